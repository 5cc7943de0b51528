//! Lights: sampling points or directions on them, and the density of doing so.

use crate::math::{Colour, DVec2, DVec3, direction_around, sqrt};
use core::f64::consts::PI;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Radiance from the side that edge_u × edge_v points to.
    Parallelogram {
        corner: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
        radiance: Colour,
    },
    Triangle {
        corner: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
        radiance: Colour,
    },
    /// Radiance outwards.
    Sphere {
        centre: DVec3,
        radius: f64,
        radiance: Colour,
    },
    /// The same radiance from all directions.
    Environment {
        radiance: Colour,
    },
    /// Light that travels along `direction`; `irradiance` on a plane across it.
    Directional {
        direction: DVec3,
        irradiance: Colour,
    },
    Point {
        position: DVec3,
        intensity: Colour,
    },
}

/// Where a light is seen from a point.
#[derive(Clone, Copy, Debug)]
pub enum LightSample {
    /// A point; `normal` (None for a point light) and the density per area (1 for a point light).
    Point { position: DVec3, normal: Option<DVec3>, pdf: f64 },
    /// A direction that nothing else can sample.
    Direction { to_light: DVec3 },
    /// Any direction: a constant environment, which the caller samples as the scattering suggests.
    AnyDirection,
}

impl Light {
    /// Radiance, intensity or irradiance along the unit vector `direction` in which the light travels, away from it. An area light's
    /// dark side is up to the caller.
    pub fn emission(&self, _direction: DVec3) -> Colour {
        match *self {
            Self::Parallelogram { radiance, .. }
            | Self::Triangle { radiance, .. }
            | Self::Sphere { radiance, .. }
            | Self::Environment { radiance } => radiance,
            Self::Directional { irradiance, .. } => irradiance,
            Self::Point { intensity, .. } => intensity,
        }
    }

    /// ∂log emission/∂direction per colour channel, as unconstrained vectors: for a direction ω that ends at a distance d, the gradient
    /// with respect to that end is (I − ωωᵀ)/d times it. 0 where the emission does not depend on the direction, or is 0.
    pub fn log_gradient(&self, _direction: DVec3) -> [DVec3; 3] {
        [DVec3::ZERO; 3]
    }

    /// Density of [`Light::sample`] over the surface of an area light, 1/world unit²; 0 for others.
    pub fn area_pdf(&self) -> f64 {
        match *self {
            Self::Parallelogram { edge_u, edge_v, .. } => 1.0 / edge_u.cross(edge_v).length(),
            Self::Triangle { edge_u, edge_v, .. } => 2.0 / edge_u.cross(edge_v).length(),
            Self::Sphere { radius, .. } => 1.0 / (4.0 * PI * radius * radius),
            _ => 0.0,
        }
    }

    pub fn sample(&self, u: DVec2) -> LightSample {
        match *self {
            Self::Parallelogram { corner, edge_u, edge_v, .. } => {
                self.area_point(corner + u.x * edge_u + u.y * edge_v, edge_u.cross(edge_v).normalize())
            }
            Self::Triangle { corner, edge_u, edge_v, .. } => {
                let root = sqrt(u.x);
                let position = corner + (1.0 - root) * edge_u + root * u.y * edge_v;
                self.area_point(position, edge_u.cross(edge_v).normalize())
            }
            Self::Sphere { centre, radius, .. } => {
                let normal = direction_around(DVec3::Z, 1.0 - 2.0 * u.x, u.y);
                self.area_point(centre + radius * normal, normal)
            }
            Self::Environment { .. } => LightSample::AnyDirection,
            Self::Directional { direction, .. } => LightSample::Direction { to_light: -direction },
            Self::Point { position, .. } => LightSample::Point { position, normal: None, pdf: 1.0 },
        }
    }

    fn area_point(&self, position: DVec3, normal: DVec3) -> LightSample {
        LightSample::Point { position, normal: Some(normal), pdf: self.area_pdf() }
    }
}

/// A scene's lights and the probability of picking each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lights<'a> {
    pub lights: &'a [Light],
    /// Running sums of the picking probabilities; the last is 1. As long as `lights`.
    pub cdf: &'a [f64],
    /// Index of the environment light among them.
    pub environment: Option<u32>,
}

impl<'a> Lights<'a> {
    pub fn get(&self, index: u32) -> Option<&'a Light> {
        self.lights.get(index as usize)
    }

    /// Probability that [`Lights::pick`] gives this one.
    pub fn probability(&self, index: u32) -> f64 {
        let i = index as usize;
        let before = i.checked_sub(1).and_then(|b| self.cdf.get(b)).copied().unwrap_or(0.0);
        self.cdf.get(i).map_or(0.0, |sum| sum - before)
    }

    pub fn pick(&self, u: f64) -> Option<(u32, &'a Light)> {
        let i = self.cdf.partition_point(|sum| *sum <= u);
        self.lights.get(i).map(|light| (i as u32, light))
    }
}
