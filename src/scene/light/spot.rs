//! A spot light's profile: 1 within a cone, 0 outside a wider one, between them falling off linearly in the angle.
//! Source: Mitsuba 3, `spot`.

use crate::math::{DVec3, acos, sqrt};

/// The part of its full intensity that a spot light has at an angle to its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Falloff {
    cos_inner: f64,
    cos_outer: f64,
    /// Half angle of the outer cone, and how much wider it is than the inner one; radians.
    outer: f64,
    width: f64,
}

impl Falloff {
    /// From the cosines of the cones' half angles, −1 ≤ `cos_outer` ≤ `cos_inner` ≤ 1.
    pub fn new(cos_inner: f64, cos_outer: f64) -> Self {
        let outer = acos(cos_outer);
        Self { cos_inner, cos_outer, outer, width: outer - acos(cos_inner) }
    }

    /// Of the outer cone's half angle.
    pub fn cos_outer(&self) -> f64 {
        self.cos_outer
    }

    pub fn at(&self, cosine: f64) -> f64 {
        if cosine >= self.cos_inner {
            1.0
        } else if cosine > self.cos_outer {
            (self.outer - acos(cosine)) / self.width
        } else {
            0.0
        }
    }

    /// ∂log [`Falloff::at`]/∂direction, the cosine being that between `axis` and `direction`. At the inner cone itself, where the profile
    /// has a kink, that of the inside, 0; at the outer cone and beyond 0 too.
    pub fn log_gradient(&self, axis: DVec3, direction: DVec3) -> DVec3 {
        let cosine = axis.dot(direction);
        if cosine >= self.cos_inner || cosine <= self.cos_outer {
            return DVec3::ZERO;
        }
        // ∂angle/∂direction = −axis/sin
        axis / (sqrt(1.0 - cosine * cosine) * (self.outer - acos(cosine)))
    }
}
