//! Multiplexed Metropolis Light Transport in media. [HKD14]

mod bootstrap;
mod chain;
mod inverse;
mod numbers;
mod path;
mod peek;
mod room;
mod techniques;
mod thesis;

pub use bootstrap::{Numbers, Plan, Start, learn, run as bootstrap};
pub use chain::{Batches, ChainStats, Metropolis, Options, State};
pub use inverse::invert;
pub use numbers::{Change, capacity};
pub use path::{Scratch, make, remake};
pub use peek::{PathPeek, Peek};
pub use techniques::Techniques;
