//! Samplers: from primary sample numbers to paths and splats.

pub mod bidirectional;
mod interaction;
pub mod metropolis;
mod next_event;
mod path_tracer;
mod primary;
mod record;

pub use path_tracer::{Lengths, Options, PathTracer, Stats};
pub use primary::{PrimarySample, RandomNumbers, SLOTS, Slot, VertexNumbers, line_numbers, shift_numbers, tile_numbers};
pub use record::Record;
