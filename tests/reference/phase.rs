//! Phase functions, of c = dot product of the two unit vectors that point **away** from the vertex.
//!
//! Straight on is c = −1, and g > 0 scatters forward.
//! Source: [Lu20 (8)], [Lu20 (9)], [Lu20 (22)], [Lu20 (23)].
//! Differs from [Lu20 (9), (23)]: as printed there, `−2g cosθ` swaps forward and backward.

use std::f64::consts::PI;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    Isotropic,
    HenyeyGreenstein { g: f64 },
}

impl Phase {
    /// f_p in 1/sr; it integrates to 1 over the sphere.
    pub fn value(&self, c: f64) -> f64 {
        match *self {
            Phase::Isotropic => 1.0 / (4.0 * PI),
            // [Lu20 (9)] with the sign corrected.
            Phase::HenyeyGreenstein { g } => (1.0 - g * g) / (4.0 * PI) * (1.0 + g * g + 2.0 * g * c).powf(-1.5),
        }
    }

    /// ∂ log f_p / ∂c.
    pub fn log_derivative(&self, c: f64) -> f64 {
        match *self {
            Phase::Isotropic => 0.0,
            // [Lu20 (23)] divided by f_p, with the sign corrected.
            Phase::HenyeyGreenstein { g } => -3.0 * g / (1.0 + g * g + 2.0 * g * c),
        }
    }
}
