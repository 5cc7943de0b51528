//! Shifts: one sampled path becomes a batch of correlated ones by moving its first vertex.
//!
//! The contract with a sampler: a sample of weight C = w·f/p is repeated at y as (C*/f*(x))·f(y), for the samples of *all* techniques,
//! whose MIS weights w sum to 1 wherever f > 0, unclamped.

mod batch;
mod kernel;
mod link;
mod weight;

pub use batch::{BatchStats, shift};
pub use kernel::{Kernel, MAX_SHIFTS, Mode, Options, Radius};
pub use link::{First, Link, Next, Shiftable, from_path, moves_on, towards, volume_to_image};
