//! Samplers: from primary sample numbers to paths and splats.

pub mod bidirectional;
mod camera_samples;
mod first_vertices;
mod interaction;
mod lengths;
pub mod metropolis;
mod next_event;
mod path_tracer;
mod primary;
mod record;

pub use camera_samples::CameraSamples;
pub use first_vertices::FirstVertices;
pub use lengths::Lengths;
pub use path_tracer::{Options, PathTracer, Stats};
pub use primary::{PrimarySample, RandomNumbers, SLOTS, Slot, VertexNumbers, line_numbers, shift_numbers, tile_numbers};
pub use record::Record;
