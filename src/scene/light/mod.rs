//! Lights: what they emit, and sampling points or directions on them; and what of that the host computes.
//!
//! A light's own `direction` is the one in which its light travels, from the light to what it shines on.

mod custom;
mod distribution;
mod emission;
mod environment_map;
mod guide;
mod invert;
mod spot;

pub use custom::{CustomProfile, CustomSky, ProfileFunction, SkyFunction};
pub use distribution::{accumulate, leave_constant_sky_to_chance};
pub use environment_map::{EnvironmentMap, running_sums, sums_length};
pub use guide::{GUIDE_SIDE, Guide};
pub use spot::Falloff;

use crate::math::{Colour, DVec2, DVec3, direction_around, sqrt};
use core::f64::consts::PI;
use distribution::{number, pick, probability};

#[derive(Clone, Copy, Debug)]
pub enum Light<'a> {
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
    EnvironmentMap(EnvironmentMap<'a>),
    /// Light that travels along `direction`; `irradiance` on a plane across it.
    Directional {
        direction: DVec3,
        irradiance: Colour,
    },
    Point {
        position: DVec3,
        intensity: Colour,
    },
    /// A point light with a profile around the unit vector `axis`.
    Spot {
        position: DVec3,
        axis: DVec3,
        intensity: Colour,
        falloff: Falloff,
    },
    /// From all directions, infinitely far away.
    CustomSky(CustomSky<'a>),
    /// A point light with a profile.
    CustomPoint {
        position: DVec3,
        profile: CustomProfile<'a>,
    },
}

/// Where a light is seen from a point.
#[derive(Clone, Copy, Debug)]
pub enum LightSample {
    /// A point; `normal` (None for lights without area) and the density per area (1 for those).
    Point { position: DVec3, normal: Option<DVec3>, pdf: f64 },
    /// A direction that nothing else can sample.
    Direction { to_light: DVec3 },
    /// A direction to an environment that is sampled by itself, and its density per steradian: 0 if that is black.
    Sky { to_light: DVec3, pdf: f64 },
    /// Any direction: a constant environment, which the caller samples as the scattering suggests.
    AnyDirection,
}

impl Light<'_> {
    /// Whether it shines from all directions, infinitely far away.
    pub fn is_environment(&self) -> bool {
        matches!(self, Self::Environment { .. } | Self::EnvironmentMap(_) | Self::CustomSky(_))
    }

    /// Whether what a fixed point of it emits depends on the direction.
    pub fn has_profile(&self) -> bool {
        matches!(self, Self::Spot { .. } | Self::CustomPoint { .. })
    }

    /// Radiance, intensity or irradiance along the unit vector `direction` in which the light travels, away from it. An area light's
    /// dark side is up to the caller.
    pub fn emission(&self, direction: DVec3) -> Colour {
        match *self {
            Self::Parallelogram { radiance, .. }
            | Self::Triangle { radiance, .. }
            | Self::Sphere { radiance, .. }
            | Self::Environment { radiance } => radiance,
            Self::Directional { irradiance, .. } => irradiance,
            Self::Point { intensity, .. } => intensity,
            Self::Spot { axis, intensity, falloff, .. } => intensity * falloff.at(axis.dot(direction)),
            Self::EnvironmentMap(map) => map.radiance(-direction),
            Self::CustomSky(sky) => sky.radiance(-direction),
            Self::CustomPoint { profile, .. } => profile.intensity(direction),
        }
    }

    /// ∂log emission/∂direction per colour channel, as unconstrained vectors: for a direction ω that ends at a distance d, the gradient
    /// with respect to that end is (I − ωωᵀ)/d times it. 0 where the emission does not depend on the direction, or is 0.
    /// None: the host does not tell.
    pub fn log_gradient(&self, direction: DVec3) -> Option<[DVec3; 3]> {
        match *self {
            Self::Spot { axis, falloff, .. } => Some([falloff.log_gradient(axis, direction); 3]),
            Self::EnvironmentMap(map) => Some(map.log_gradient(-direction).map(|g| -g)),
            Self::CustomSky(_) => None,
            Self::CustomPoint { profile, .. } => profile.log_gradient(direction),
            _ => Some([DVec3::ZERO; 3]),
        }
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

    /// Density of [`Light::sample`] per steradian for light that travels along `direction`; 0 for lights that are not sampled so.
    pub fn direction_pdf(&self, direction: DVec3) -> f64 {
        match self {
            Self::EnvironmentMap(map) => map.pdf(-direction),
            Self::CustomSky(sky) => sky.pdf(-direction),
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
            Self::Point { position, .. } | Self::Spot { position, .. } | Self::CustomPoint { position, .. } => {
                LightSample::Point { position, normal: None, pdf: 1.0 }
            }
            Self::EnvironmentMap(map) => {
                let (to_light, pdf) = map.sample(u).unwrap_or((DVec3::Z, 0.0));
                LightSample::Sky { to_light, pdf }
            }
            Self::CustomSky(sky) => {
                let (to_light, pdf) = sky.sample(u).unwrap_or((DVec3::Z, 0.0));
                LightSample::Sky { to_light, pdf }
            }
        }
    }

    fn area_point(&self, position: DVec3, normal: DVec3) -> LightSample {
        LightSample::Point { position, normal: Some(normal), pdf: self.area_pdf() }
    }
}

/// A scene's lights and the probability of picking each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lights<'a> {
    pub lights: &'a [Light<'a>],
    /// Running sums of the picking probabilities; the last is 1. As long as `lights`.
    pub cdf: &'a [f64],
    /// The medium in front of each area light and around each point and spot light; NONE where there is no entry. As long as `lights`, or empty.
    pub media: &'a [u32],
    /// Where each light's subpaths go. As long as `lights`; or empty: wherever it shines.
    pub guides: &'a [Guide],
    /// Index of the environment light among them.
    pub environment: Option<u32>,
}

impl<'a> Lights<'a> {
    pub fn get(&self, index: u32) -> Option<&'a Light<'a>> {
        self.lights.get(index as usize)
    }

    /// The medium in which subpaths from a light start.
    pub fn medium(&self, index: u32) -> u32 {
        self.media.get(index as usize).copied().unwrap_or(crate::medium::NONE)
    }

    /// Warps the numbers that choose a subpath's direction from a light; and the warped numbers' density.
    pub fn guide(&self, index: u32, u: DVec2) -> (DVec2, f64) {
        self.guides.get(index as usize).and_then(|guide| guide.warp(u)).unwrap_or((u, 1.0))
    }

    /// The numbers that [`Lights::guide`] warps to these.
    pub fn unguide(&self, index: u32, warped: DVec2) -> DVec2 {
        self.guides.get(index as usize).and_then(|guide| guide.unwarp(warped)).unwrap_or(warped)
    }

    /// The density of such numbers, told only if anyone asks.
    pub fn guide_density(&self, index: u32, numbers: impl FnOnce() -> Option<DVec2>) -> f64 {
        match self.guides.get(index as usize) {
            Some(guide) => numbers().map_or(0.0, |u| guide.density(u)),
            None => 1.0,
        }
    }

    /// Probability that [`Lights::pick`] gives this one.
    pub fn probability(&self, index: u32) -> f64 {
        probability(self.cdf, index as usize)
    }

    /// A light, and what the choice leaves of `u`: a number as uniform as u, in [0, 1].
    pub fn pick(&self, u: f64) -> Option<(u32, &'a Light<'a>, f64)> {
        let (i, rest) = pick(self.cdf, u)?;
        self.lights.get(i).map(|light| (i as u32, light, rest))
    }

    /// The number from which [`Lights::pick`] picks a light and leaves `rest`; None if it never picks it.
    pub fn number(&self, index: u32, rest: f64) -> Option<f64> {
        number(self.cdf, index as usize, rest)
    }
}
