//! What a path can meet besides media: the camera, surfaces' BSDFs, lights; and how the host is asked about geometry.

mod bsdf;
mod camera;
mod light;
mod query;
mod view;

pub use bsdf::{
    Bsdf, BsdfFunction, BsdfSample, Conductor, CustomBsdf, Ggx, Reflector, RoughConductor, RoughDielectric, SurfaceFrame,
    SurfacePoint,
};
pub use camera::{Camera, CameraRay, ImagePoint};
pub use light::{
    CustomProfile, CustomSky, EnvironmentMap, Falloff, GUIDE_SIDE, Guide, Light, LightSample, Lights, ProfileFunction,
    SkyFunction, accumulate, leave_constant_sky_to_chance, running_sums, sums_length,
};
pub use query::{
    HIT_NONE, HIT_OVERFLOW, HIT_SURFACE, Hit, KEEP_MEDIUM, MAX_SEGMENTS, Mistake, Queries, Ray, Stop, surface_epsilon,
};
pub use view::View;

use crate::math::DVec3;
use crate::medium::Medium;

/// Everything of a scene but its geometry.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    pub camera: Camera,
    pub media: &'a [Medium<'a>],
    pub materials: &'a [Bsdf<'a>],
    pub lights: Lights<'a>,
    pub bounds: Bounds,
}

/// A sphere around all surfaces, null ones included: what light from infinitely far away has to be aimed at. Radius 0: unknown, no
/// subpath starts from such light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    pub centre: DVec3,
    pub radius: f64,
}

impl Scene<'_> {
    pub fn medium(&self, index: u32) -> Option<&Medium<'_>> {
        self.media.get(index as usize)
    }

    /// An error if the derivative of a phase function is not known.
    pub fn check_phase_derivatives(&self) -> Result<(), Stop> {
        let known = self.media.iter().all(|medium| medium.phase.has_derivative());
        if known { Ok(()) } else { Err(Stop::NoGradient) }
    }
}
