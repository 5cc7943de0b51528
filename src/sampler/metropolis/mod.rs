//! Multiplexed Metropolis Light Transport in media. [HKD14]

mod bootstrap;
mod chain;
mod numbers;
mod path;
mod techniques;

pub use bootstrap::{Plan, Start, learn, run as bootstrap};
pub use chain::{ChainStats, Metropolis, Options, State};
pub use numbers::capacity;
pub use techniques::Techniques;
