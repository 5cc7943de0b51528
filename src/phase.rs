//! Phase functions: isotropic and Henyey–Greenstein, which is isotropic at g = 0; and what the host computes.
//!
//! The angle's cosine `c` is the dot product of the two unit vectors that point *away* from the scattering vertex: straight on is
//! c = −1. Source: `[Lu20 (9), (23)]` with the sign as in ARCHITECTURE.md (the thesis prints it flipped).

use crate::math::{DVec2, DVec3, around_direction, direction_around, positive_or_zero, sqrt};
use core::f64::consts::PI;
use core::fmt::Debug;

/// A phase function as the host computes it, of the cosine `mu` of the angle by which light is deflected: straight on is 1.
pub trait PhaseFunction: Debug + Sync {
    /// Value, 1/sr; 1 over the sphere.
    fn eval(&self, mu: f64) -> f64;

    /// A cosine from a uniform number in (0, 1), of density 2π times the value.
    fn sample(&self, u: f64) -> f64;

    /// Whether it knows its derivative.
    fn has_log_derivative(&self) -> bool;

    /// ∂log(value)/∂mu, where the value is > 0; any number if it is not known.
    fn log_derivative(&self, mu: f64) -> f64;
}

/// Light turns by angles of a density that is the same in all directions around the one that it comes from.
#[derive(Clone, Copy, Debug)]
pub enum Phase {
    /// With mean cosine `g`; 0 is isotropic.
    HenyeyGreenstein { g: f64 },
    /// It lives as long as the program, so that paths can keep it without borrowing the scene. Values that are none count as 0.
    Custom(&'static dyn PhaseFunction),
}

impl Default for Phase {
    fn default() -> Self {
        Self::ISOTROPIC
    }
}

impl Phase {
    pub const ISOTROPIC: Self = Self::henyey_greenstein(0.0);

    pub const fn henyey_greenstein(g: f64) -> Self {
        Self::HenyeyGreenstein { g }
    }

    /// Value, 1/sr; also the density of [`Phase::sample`].
    pub fn eval(self, c: f64) -> f64 {
        match self {
            Self::HenyeyGreenstein { g } => {
                let d = 1.0 + g * g + 2.0 * g * c;
                (1.0 - g * g) / (4.0 * PI * d * sqrt(d))
            }
            Self::Custom(custom) => positive_or_zero(custom.eval((-c).clamp(-1.0, 1.0))),
        }
    }

    /// ∂log(value)/∂c; 0 if it is not known, see [`Phase::has_derivative`].
    pub fn log_derivative(self, c: f64) -> f64 {
        match self {
            Self::HenyeyGreenstein { g } => -3.0 * g / (1.0 + g * g + 2.0 * g * c),
            Self::Custom(custom) => {
                let slope = custom.log_derivative((-c).clamp(-1.0, 1.0));
                if slope.is_finite() { -slope } else { 0.0 }
            }
        }
    }

    pub fn has_derivative(self) -> bool {
        match self {
            Self::HenyeyGreenstein { .. } => true,
            Self::Custom(custom) => custom.has_log_derivative(),
        }
    }

    /// A direction away from the vertex, given the unit vector from it to the previous one. None if the host makes none.
    pub fn sample(self, to_previous: DVec3, u: DVec2) -> Option<DVec3> {
        let mu = match self {
            Self::HenyeyGreenstein { g } => cosine(g, u.x),
            Self::Custom(custom) => Some(custom.sample(u.x)).filter(|mu| mu.abs() <= 1.0)?,
        };
        Some(direction_around(-to_previous, mu, u.y))
    }

    /// The numbers from which [`Phase::sample`] makes `to_next`. None: only the host knows.
    pub fn invert(self, to_previous: DVec3, to_next: DVec3) -> Option<DVec2> {
        let Self::HenyeyGreenstein { g } = self else { return None };
        let (cosine, turn) = around_direction(-to_previous, to_next);
        let root = sqrt(1.0 + g * g - 2.0 * g * cosine);
        let m = (2.0 * cosine - 3.0 * g + g * g * g) / (root * (1.0 - g * g + root));
        Some(DVec2::new((0.5 * (m + 1.0)).clamp(0.0, 1.0), turn))
    }
}

/// Of the angle by which Henyey–Greenstein deflects, from a uniform number.
fn cosine(g: f64, u: f64) -> f64 {
    // The textbook inverse (1 + g² − ((1−g²)/(1+gm))²)/(2g), m = 2u−1, with the division by g carried out.
    let m = 2.0 * u - 1.0;
    let a = 1.0 + g * m;
    let cosine = (2.0 * m + g * (m * m + 3.0) + 2.0 * g * g * m + g * g * g * (m * m - 1.0)) / (2.0 * a * a);
    cosine.clamp(-1.0, 1.0)
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
