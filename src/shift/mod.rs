//! Shifts: one sampled path becomes a batch of correlated ones by moving its first vertices.
//!
//! The contract with a sampler: a sample of weight C = w·f/p is repeated at y as (C*/f*(x))·f(y), for the samples of *all* techniques,
//! whose MIS weights w sum to 1 wherever f > 0, unclamped.

mod batch;
mod chain;
mod evaluate;
mod from_path;
mod gradient;
mod kernel;
mod link;
mod paths;
mod place;
mod run;
mod spots;
mod tile;
mod weight;

pub(crate) use batch::made;
pub use batch::{BatchStats, Scratch, shift};
pub use chain::{Bounce, Chain, MAX_CHAIN};
pub use from_path::{from_path, prepare};
pub(crate) use kernel::fill_with_unit_ball;
pub use kernel::{Kernel, MAX_RUN, MAX_SHIFTS, Mode, Options, Radius};
pub use link::{Depth, Exit, Link, MAX_WINGS, Next, Onwards};
pub use paths::Paths;
pub use place::Draw;
pub use run::{Place, RunVertex, Shiftable, volume_to_image};
pub use tile::{Bounds, Tile, Tiling};
