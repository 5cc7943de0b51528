//! Directions in which light leaves a light, for subpaths that start there.
//!
//! Positions come from [`Light::sample`], with the same density as for next-event estimation.

use super::Light;
use crate::math::{DVec2, DVec3, direction_around, orthonormal_basis, sqrt, uniform_disk};
use core::f64::consts::PI;

impl Light<'_> {
    /// A direction in which light leaves a point of it, which has a `normal` if it is on an area light, and its density per steradian.
    /// None for light from infinitely far away, whose direction comes first.
    pub fn sample_direction(&self, normal: Option<DVec3>, u: DVec2) -> Option<(DVec3, f64)> {
        let direction = match (self, normal) {
            (_, Some(n)) => {
                let d = uniform_disk(u);
                let (s, t) = orthonormal_basis(n);
                s * d.x + t * d.y + n * sqrt((1.0 - d.length_squared()).max(0.0))
            }
            (Self::Point { .. } | Self::CustomPoint { .. }, None) => direction_around(DVec3::Z, 1.0 - 2.0 * u.x, u.y),
            (Self::Spot { axis, falloff, .. }, None) => direction_around(*axis, 1.0 - (1.0 - falloff.cos_outer()) * u.x, u.y),
            _ => return None,
        };
        let pdf = self.direction_density(normal, direction);
        (pdf > 0.0).then_some((direction, pdf))
    }

    /// Density of [`Light::sample_direction`].
    pub fn direction_density(&self, normal: Option<DVec3>, direction: DVec3) -> f64 {
        match (self, normal) {
            (_, Some(n)) => n.dot(direction).max(0.0) * (1.0 / PI),
            (Self::Point { .. } | Self::CustomPoint { .. }, None) => 1.0 / (4.0 * PI),
            (Self::Spot { axis, falloff, .. }, None)
                if falloff.cos_outer() < 1.0 && axis.dot(direction) >= falloff.cos_outer() =>
            {
                1.0 / (2.0 * PI * (1.0 - falloff.cos_outer()))
            }
            _ => 0.0,
        }
    }

    /// A direction to a light at infinity, and its density per steradian, 1 for a directional light, which has only one. None for others.
    pub fn sample_far(&self, u: DVec2) -> Option<(DVec3, f64)> {
        match self {
            Self::Environment { .. } => Some((direction_around(DVec3::Z, 1.0 - 2.0 * u.x, u.y), 1.0 / (4.0 * PI))),
            Self::EnvironmentMap(map) => map.sample(u),
            Self::CustomSky(sky) => sky.sample(u),
            Self::Directional { direction, .. } => Some((-*direction, 1.0)),
            _ => None,
        }
    }

    /// Density of [`Light::sample_far`]: what a path that goes on shares with it; 0 for a directional light, which it never finds.
    pub fn far_density(&self, to_light: DVec3) -> f64 {
        match self {
            Self::Environment { .. } => 1.0 / (4.0 * PI),
            Self::EnvironmentMap(map) => map.pdf(to_light),
            Self::CustomSky(sky) => sky.pdf(to_light),
            _ => 0.0,
        }
    }

    /// Whether it is infinitely far away.
    pub fn is_far(&self) -> bool {
        self.is_environment() || matches!(self, Self::Directional { .. })
    }
}
