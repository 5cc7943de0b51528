//! BSDFs that the host computes, in the surface's own frame: z is the normal; x and y are two axes across it.
//!
//! The host says f_r, a density and which direction numbers make; values over densities are made of these here, so that no three answers
//! have to agree. What is no value (NaN, infinite, negative) counts as 0.

use super::{BsdfSample, LogGradients, NO_GRADIENT, SurfacePoint};
use crate::math::{Colour, DMat3, DVec2, DVec3, colour_or_black, is_unit, orthonormal_basis, positive_or_zero};
use core::fmt::Debug;

/// A point of a surface with its frame.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFrame {
    pub position: DVec3,
    /// From the frame to the world: the axes are its columns.
    pub axes: DMat3,
    /// What the host's hit, or vertex, said about the point.
    pub user: u64,
}

/// A BSDF as the host computes it, a function of a point and of unit vectors away from the surface, in the point's frame. It is not specular.
pub trait BsdfFunction: Debug + Sync {
    /// Whether light passes to the other side. If not, both directions always have z > 0.
    fn transmits(&self) -> bool {
        false
    }

    /// f_r(to_camera, to_light), without the cosine. Symmetric, but for light that is refracted: its radiance is divided by the square of the
    /// relative index of refraction on the way in.
    fn eval(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> Colour;

    /// Density of [`BsdfFunction::sample`], per steradian: positive wherever f_r is.
    fn pdf(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> f64;

    /// A direction from three uniform numbers in (0, 1), and the squared ratio of the indices of refraction passed, 1 if none. None if
    /// nothing is scattered.
    fn sample(&self, at: &SurfaceFrame, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<(DVec3, f64)>;

    /// ∂log f_r/∂to_camera and ∂log f_r/∂to_light, as [`super::Bsdf::log_gradient`] has them, where f_r > 0. None: not known.
    fn log_gradient(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> Option<LogGradients>;
}

#[derive(Clone, Copy, Debug)]
pub struct CustomBsdf<'a>(pub &'a dyn BsdfFunction);

impl CustomBsdf<'_> {
    pub fn transmits(&self) -> bool {
        self.0.transmits()
    }

    /// f_r of a Lambertian one.
    pub fn constant(&self, at: &SurfacePoint) -> Colour {
        self.value(&SurfaceFrame::new(at), DVec3::Z, DVec3::Z)
    }

    pub fn eval(&self, at: &SurfacePoint, to_camera: DVec3, to_light: DVec3) -> Colour {
        self.local(at, to_camera, to_light).map_or(Colour::ZERO, |(at, c, l)| self.value(&at, c, l))
    }

    pub fn pdf(&self, at: &SurfacePoint, to_camera: DVec3, to_light: DVec3) -> f64 {
        self.local(at, to_camera, to_light).map_or(0.0, |(at, c, l)| self.density(&at, c, l))
    }

    pub fn sample(&self, at: &SurfacePoint, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<BsdfSample> {
        let at = SurfaceFrame::new(at);
        let c = at.axes.transpose() * to_camera;
        if !(c.z > 0.0 || self.transmits()) {
            return None;
        }
        let (l, eta_squared) = self.0.sample(&at, c, u, lobe)?;
        let is_direction = is_unit(l);
        let l = l.normalize_or_zero();
        if !(is_direction && self.scatters(c, l) && eta_squared > 0.0 && eta_squared.is_finite()) {
            return None;
        }
        let pdf = self.density(&at, c, l);
        let weight = self.value(&at, c, l) * (l.z.abs() / pdf);
        (pdf > 0.0).then_some(BsdfSample { direction: at.axes * l, weight, pdf: Some(pdf), eta_squared })
    }

    /// None: the host does not know it. 0 where it is not finite.
    pub fn log_gradient(&self, at: &SurfacePoint, to_camera: DVec3, to_light: DVec3) -> Option<LogGradients> {
        let Some((at, c, l)) = self.local(at, to_camera, to_light) else { return Some(NO_GRADIENT) };
        let to_world = |g: DVec3| if g.is_finite() { at.axes * g } else { DVec3::ZERO };
        self.0.log_gradient(&at, c, l).map(|(by_c, by_l)| (by_c.map(to_world), by_l.map(to_world)))
    }

    /// The frame, and both directions in it; None if nothing is scattered from one to the other.
    fn local(&self, at: &SurfacePoint, to_camera: DVec3, to_light: DVec3) -> Option<(SurfaceFrame, DVec3, DVec3)> {
        let at = SurfaceFrame::new(at);
        let to_local = at.axes.transpose();
        let (c, l) = (to_local * to_camera, to_local * to_light);
        self.scatters(c, l).then_some((at, c, l))
    }

    fn scatters(&self, c: DVec3, l: DVec3) -> bool {
        (c.z > 0.0 && l.z > 0.0) || (self.transmits() && c.z != 0.0 && l.z != 0.0)
    }

    fn value(&self, at: &SurfaceFrame, c: DVec3, l: DVec3) -> Colour {
        colour_or_black(self.0.eval(at, c, l))
    }

    fn density(&self, at: &SurfaceFrame, c: DVec3, l: DVec3) -> f64 {
        positive_or_zero(self.0.pdf(at, c, l))
    }
}

impl SurfaceFrame {
    fn new(at: &SurfacePoint) -> Self {
        let (s, t) = orthonormal_basis(at.normal);
        Self { position: at.position, axes: DMat3::from_cols(s, t, at.normal), user: at.user }
    }
}
