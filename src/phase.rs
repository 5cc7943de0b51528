//! Phase functions: isotropic and Henyey–Greenstein, which is isotropic at g = 0.
//!
//! The angle's cosine `c` is the dot product of the two unit vectors that point *away* from the scattering vertex: straight on is
//! c = −1. Source: `[Lu20 (9), (23)]` with the sign as in ARCHITECTURE.md (the thesis prints it flipped).

use crate::math::{DVec2, DVec3, around_direction, direction_around, sqrt};
use core::f64::consts::PI;

/// Henyey–Greenstein with mean cosine `g`; 0 is isotropic.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phase {
    pub g: f64,
}

impl Phase {
    pub const ISOTROPIC: Self = Self { g: 0.0 };

    /// Value, 1/sr; also the density of [`Phase::sample`].
    pub fn eval(self, c: f64) -> f64 {
        let g = self.g;
        let d = 1.0 + g * g + 2.0 * g * c;
        (1.0 - g * g) / (4.0 * PI * d * sqrt(d))
    }

    /// ∂log(value)/∂c.
    pub fn log_derivative(self, c: f64) -> f64 {
        let g = self.g;
        -3.0 * g / (1.0 + g * g + 2.0 * g * c)
    }

    /// A direction away from the vertex, given the unit vector from it to the previous one.
    pub fn sample(self, to_previous: DVec3, u: DVec2) -> DVec3 {
        // The textbook inverse (1 + g² − ((1−g²)/(1+gm))²)/(2g), m = 2u−1, with the division by g carried out.
        let (g, m) = (self.g, 2.0 * u.x - 1.0);
        let a = 1.0 + g * m;
        let cosine = (2.0 * m + g * (m * m + 3.0) + 2.0 * g * g * m + g * g * g * (m * m - 1.0)) / (2.0 * a * a);
        direction_around(-to_previous, cosine.clamp(-1.0, 1.0), u.y)
    }

    /// The numbers from which [`Phase::sample`] makes `to_next`.
    pub fn invert(self, to_previous: DVec3, to_next: DVec3) -> DVec2 {
        let (cosine, turn) = around_direction(-to_previous, to_next);
        let g = self.g;
        let root = sqrt(1.0 + g * g - 2.0 * g * cosine);
        let m = (2.0 * cosine - 3.0 * g + g * g * g) / (root * (1.0 - g * g + root));
        DVec2::new((0.5 * (m + 1.0)).clamp(0.0, 1.0), turn)
    }
}

/// Gradient of `c` at apex `q` when its wing `x` moves: `to_wing`, `to_other` are unit vectors from q to x and to the other wing.
/// The wing term of `[Lu20 (24)]`.
pub fn cosine_gradient_wing(to_wing: DVec3, to_other: DVec3, c: f64, distance: f64) -> DVec3 {
    (to_other - c * to_wing) / distance
}

/// Gradient of `c` at apex `x` when x itself moves, between p and n at the given distances (infinite: the wing's direction is kept).
/// Differs from `[Lu20 (25)]` by its sign: it is minus the sum of the two wing terms.
pub fn cosine_gradient_apex(to_p: DVec3, to_n: DVec3, c: f64, distance_p: f64, distance_n: f64) -> DVec3 {
    -((to_p - c * to_n) / distance_n + (to_n - c * to_p) / distance_p)
}
