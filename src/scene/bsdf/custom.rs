//! BSDFs that the host computes, in the surface's own frame: z is the normal; x and y are any two axes across it, so that the BSDF has to
//! be isotropic.
//!
//! The host says f_r, a density and which direction numbers make; values over densities are made of these here, so that no three answers
//! have to agree. What is no value (NaN, infinite, negative) counts as 0.

use super::{BsdfSample, LogGradients, NO_GRADIENT};
use crate::math::{Colour, DMat3, DVec2, DVec3, colour_or_black, is_unit, orthonormal_basis, positive_or_zero};
use core::fmt::Debug;

/// A BSDF as the host computes it, a function of unit vectors away from the surface. It is not specular.
pub trait BsdfFunction: Debug + Sync {
    /// Whether light passes to the other side. If not, both directions always have z > 0.
    fn transmits(&self) -> bool {
        false
    }

    /// f_r(to_camera, to_light), without the cosine. Symmetric, but for light that is refracted: its radiance is divided by the square of the
    /// relative index of refraction on the way in.
    fn eval(&self, to_camera: DVec3, to_light: DVec3) -> Colour;

    /// Density of [`BsdfFunction::sample`], per steradian: positive wherever f_r is.
    fn pdf(&self, to_camera: DVec3, to_light: DVec3) -> f64;

    /// A direction from three uniform numbers in (0, 1), and the squared ratio of the indices of refraction passed, 1 if none. None if
    /// nothing is scattered.
    fn sample(&self, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<(DVec3, f64)>;

    /// ∂log f_r/∂to_camera and ∂log f_r/∂to_light, as [`super::Bsdf::log_gradient`] has them, where f_r > 0. None: not known.
    fn log_gradient(&self, to_camera: DVec3, to_light: DVec3) -> Option<LogGradients>;
}

#[derive(Clone, Copy, Debug)]
pub struct CustomBsdf<'a>(pub &'a dyn BsdfFunction);

impl CustomBsdf<'_> {
    pub fn transmits(&self) -> bool {
        self.0.transmits()
    }

    pub fn eval(&self, n: DVec3, to_camera: DVec3, to_light: DVec3) -> Colour {
        self.local(n, to_camera, to_light).map_or(Colour::ZERO, |(c, l)| self.value(c, l))
    }

    pub fn pdf(&self, n: DVec3, to_camera: DVec3, to_light: DVec3) -> f64 {
        self.local(n, to_camera, to_light).map_or(0.0, |(c, l)| self.density(c, l))
    }

    pub fn sample(&self, n: DVec3, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<BsdfSample> {
        let frame = frame(n);
        let c = frame.transpose() * to_camera;
        if !(c.z > 0.0 || self.transmits()) {
            return None;
        }
        let (l, eta_squared) = self.0.sample(c, u, lobe)?;
        let is_direction = is_unit(l);
        let l = l.normalize_or_zero();
        if !(is_direction && self.scatters(c, l) && eta_squared > 0.0 && eta_squared.is_finite()) {
            return None;
        }
        let pdf = self.density(c, l);
        let weight = self.value(c, l) * (l.z.abs() / pdf);
        (pdf > 0.0).then_some(BsdfSample { direction: frame * l, weight, pdf: Some(pdf), eta_squared })
    }

    /// None: the host does not know it. 0 where it is not finite.
    pub fn log_gradient(&self, n: DVec3, to_camera: DVec3, to_light: DVec3) -> Option<LogGradients> {
        let Some((c, l)) = self.local(n, to_camera, to_light) else { return Some(NO_GRADIENT) };
        let frame = frame(n);
        let to_world = |g: DVec3| if g.is_finite() { frame * g } else { DVec3::ZERO };
        self.0.log_gradient(c, l).map(|(by_c, by_l)| (by_c.map(to_world), by_l.map(to_world)))
    }

    /// Both directions in the surface's frame; None if nothing is scattered from one to the other.
    fn local(&self, n: DVec3, to_camera: DVec3, to_light: DVec3) -> Option<(DVec3, DVec3)> {
        let to_local = frame(n).transpose();
        let (c, l) = (to_local * to_camera, to_local * to_light);
        self.scatters(c, l).then_some((c, l))
    }

    fn scatters(&self, c: DVec3, l: DVec3) -> bool {
        (c.z > 0.0 && l.z > 0.0) || (self.transmits() && c.z != 0.0 && l.z != 0.0)
    }

    fn value(&self, c: DVec3, l: DVec3) -> Colour {
        colour_or_black(self.0.eval(c, l))
    }

    fn density(&self, c: DVec3, l: DVec3) -> f64 {
        positive_or_zero(self.0.pdf(c, l))
    }
}

/// From the frame of a surface with this normal to the world.
fn frame(n: DVec3) -> DMat3 {
    let (s, t) = orthonormal_basis(n);
    DMat3::from_cols(s, t, n)
}
