//! Scattering at a path vertex, in a medium or on a surface, seen alike by the sampler.

use crate::math::{Colour, DVec2, DVec3};
use crate::phase::Phase;
use crate::scene::{Bsdf, BsdfSample, SurfacePoint};

#[derive(Clone, Copy, Debug)]
pub enum Scatterer<'a> {
    Medium(Phase),
    Surface { bsdf: &'a Bsdf<'a>, normal: DVec3, user: u64 },
}

/// A vertex where light scatters.
#[derive(Clone, Copy, Debug)]
pub struct Interaction<'a> {
    pub position: DVec3,
    /// Unit vector back along the path.
    pub to_camera: DVec3,
    pub scatterer: Scatterer<'a>,
}

impl Interaction<'_> {
    pub fn is_specular(&self) -> bool {
        matches!(self.scatterer, Scatterer::Surface { bsdf, .. } if bsdf.is_specular())
    }

    /// Its point on a surface of which this is known.
    pub fn surface(&self, normal: DVec3, user: u64) -> SurfacePoint {
        SurfacePoint { position: self.position, normal, user }
    }

    /// f_p, or f_r·cos.
    pub fn eval(&self, to_light: DVec3) -> Colour {
        match self.scatterer {
            Scatterer::Medium(phase) => Colour::splat(phase.eval(self.to_camera.dot(to_light))),
            Scatterer::Surface { bsdf, normal, user } => {
                bsdf.eval(&self.surface(normal, user), self.to_camera, to_light) * normal.dot(to_light).abs()
            }
        }
    }

    pub fn pdf(&self, to_light: DVec3) -> f64 {
        match self.scatterer {
            Scatterer::Medium(phase) => phase.eval(self.to_camera.dot(to_light)),
            Scatterer::Surface { bsdf, normal, user } => bsdf.pdf(&self.surface(normal, user), self.to_camera, to_light),
        }
    }

    pub fn sample(&self, u: DVec2, lobe: f64) -> Option<BsdfSample> {
        match self.scatterer {
            Scatterer::Medium(phase) => {
                let direction = phase.sample(self.to_camera, u)?;
                let pdf = phase.eval(self.to_camera.dot(direction));
                let sample = BsdfSample { direction, weight: Colour::ONE, pdf: Some(pdf), eta_squared: 1.0 };
                (pdf > 0.0).then_some(sample)
            }
            Scatterer::Surface { bsdf, normal, user } => bsdf.sample(&self.surface(normal, user), self.to_camera, u, lobe),
        }
    }
}
