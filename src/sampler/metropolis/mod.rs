//! Multiplexed Metropolis Light Transport in media. [HKD14]

mod bootstrap;
mod chain;
mod numbers;
mod path;

pub use bootstrap::{Brightness, Plan, Start, run as bootstrap};
pub use chain::{ChainStats, Metropolis, Options, State};
pub use numbers::capacity;
