//! The C ABI: include/volgrad.h is generated from here. One file per section of the header; no logic, only conversion and checks.
//!
//! The only unsafe code of the library. Every pointer that comes in is checked for NULL and alignment; that it points to as much
//! memory as the header says is the caller's promise, and the reason why each `unsafe` here is sound.

#![allow(non_camel_case_types, clippy::missing_safety_doc)]

mod bidirectional;
mod bootstraps;
mod callbacks;
mod chains;
mod checks;
mod convert;
mod custom;
mod custom_bsdf;
mod custom_density;
mod custom_light;
mod custom_phase;
mod films;
mod grids;
mod guides;
#[cfg(feature = "exr")]
mod images;
mod kernels;
mod paths;
mod pointer;
mod samplers;
mod scenes;
mod shifts;
mod status;
mod transmittance;
mod types;

pub use bidirectional::*;
pub use bootstraps::*;
pub use callbacks::*;
pub use chains::*;
pub use checks::*;
pub use films::*;
pub use guides::*;
#[cfg(feature = "exr")]
pub use images::*;
pub use kernels::*;
pub use paths::*;
pub use samplers::*;
pub use scenes::*;
pub use shifts::*;
pub use status::*;
pub use transmittance::*;
pub use types::*;
