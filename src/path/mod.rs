//! Light paths: their contribution f and its logarithmic gradient, as a whole and factor by factor.

mod contribution;
mod gradient;
mod joint;
mod report;
mod vertex;

pub use contribution::{Factors, contribution, factors};
pub(crate) use gradient::Seen;
pub use gradient::{
    Gradient, LogDerivative, LogGradient, Neighbour, Wing, path_log_gradient, path_run_log_derivative, path_run_log_gradient,
};
pub use report::report;
pub use vertex::{Node, Path, PathError, PathErrorKind, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, VERTEX_SURFACE, Vertex};
