//! volgrad: gradients of light paths in participating media, batches of correlated paths, and the samplers that use them.
//!
//! The core is `no_std`, allocates nothing, starts nothing and panics never. ARCHITECTURE.md has the order of its modules.
//! Source: G. Lu, *Gradient-Domain Volume Rendering*, Utrecht 2020, cited as `[Lu20 (n)]`; see ARCHITECTURE.md.

#![no_std]
#![deny(unsafe_op_in_unsafe_fn)]
#![cfg_attr(not(feature = "ffi"), forbid(unsafe_code))]

#[cfg(any(feature = "exr", test))]
extern crate std;

pub mod film;
pub mod math;
pub mod medium;
pub mod path;
pub mod phase;
pub mod sampler;
pub mod scene;
pub mod shift;
pub mod text;

#[cfg(feature = "exr")]
pub mod exr;
#[cfg(feature = "ffi")]
pub mod ffi;
#[cfg(feature = "freestanding")]
mod freestanding;
