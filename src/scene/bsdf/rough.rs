//! Rough surfaces made of GGX microfacets: conductors reflect, dielectrics refract as well.
//!
//! Directions c to the camera and l to the light, n on the camera's side. With the relative index of refraction η (1 to reflect), a
//! microfacet that sends one to the other is normal to h = c + ηl, and with k = c·l every product of h with the two is one of k.
//! Source: [W07 (20), (21), (38), (41)].

use super::fresnel::{Conductor, Interface};
use super::ggx::Ggx;
use super::{BsdfSample, LogGradients, NO_GRADIENT, reflect};
use crate::math::{Colour, DVec2, DVec3};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    pub conductor: Conductor,
    pub ggx: Ggx,
}

impl RoughConductor {
    pub fn eval(&self, n: DVec3, c: DVec3, l: DVec3) -> Colour {
        if !front(n, c, l) {
            return Colour::ZERO;
        }
        self.conductor.fresnel(half_cosine(c, l)) * reflection(&self.ggx, n, c, l)
    }

    pub fn pdf(&self, n: DVec3, c: DVec3, l: DVec3) -> f64 {
        if front(n, c, l) { reflection_pdf(&self.ggx, n, c, l) } else { 0.0 }
    }

    pub fn sample(&self, n: DVec3, c: DVec3, u: DVec2) -> Option<BsdfSample> {
        if !(n.dot(c) > 0.0) {
            return None;
        }
        let m = self.ggx.sample_visible(n, c, u);
        let direction = reflect(m, c).normalize();
        let weight = self.conductor.fresnel(c.dot(m)) * self.ggx.masking(n.dot(direction));
        let pdf = self.pdf(n, c, direction);
        (pdf > 0.0).then_some(BsdfSample { direction, weight, pdf: Some(pdf), eta_squared: 1.0 })
    }

    /// The number from which [`RoughConductor::sample`] makes `l`.
    pub fn invert(&self, n: DVec3, c: DVec3, l: DVec3) -> Option<DVec2> {
        front(n, c, l).then(|| self.ggx.invert_visible(n, c, (c + l).normalize()))
    }

    pub fn log_gradient(&self, n: DVec3, c: DVec3, l: DVec3) -> LogGradients {
        if !front(n, c, l) {
            return NO_GRADIENT;
        }
        let (by_c, by_l) = reflection_log_gradient(&self.ggx, n, c, l);
        let cosine = half_cosine(c, l);
        let fresnel = self.conductor.log_derivative(cosine).map(|slope| slope / (4.0 * cosine));
        (fresnel.map(|f| by_c + f * l), fresnel.map(|f| by_l + f * c))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    /// Index of refraction inside over outside, not 1: then nothing is refracted, however rough the surface.
    pub eta: f64,
    pub ggx: Ggx,
}

impl RoughDielectric {
    /// The normal on the side of `c`, and the index of refraction beyond over that on this side.
    fn side(&self, n: DVec3, c: DVec3) -> (DVec3, f64) {
        if n.dot(c) > 0.0 { (n, self.eta) } else { (-n, 1.0 / self.eta) }
    }

    pub fn eval(&self, n: DVec3, c: DVec3, l: DVec3) -> Colour {
        let (n, eta) = self.side(n, c);
        if front(n, c, l) {
            let fresnel = Interface::facing(half_cosine(c, l), eta).fresnel();
            return Colour::splat(fresnel * reflection(&self.ggx, n, c, l));
        }
        let Some(pass) = Pass::new(n, c, l, eta) else { return Colour::ZERO };
        let masking = self.ggx.masking(n.dot(c)) * self.ggx.masking(-n.dot(l));
        let density = self.ggx.density(n, pass.h) * masking * pass.products() / (n.dot(c) * -n.dot(l));
        Colour::splat((1.0 - pass.interface.fresnel()) * density)
    }

    pub fn pdf(&self, n: DVec3, c: DVec3, l: DVec3) -> f64 {
        let (n, eta) = self.side(n, c);
        if front(n, c, l) {
            return Interface::facing(half_cosine(c, l), eta).fresnel() * reflection_pdf(&self.ggx, n, c, l);
        }
        let Some(pass) = Pass::new(n, c, l, eta) else { return 0.0 };
        let visible = self.ggx.density(n, pass.h) * self.ggx.masking(n.dot(c)) / n.dot(c);
        (1.0 - pass.interface.fresnel()) * visible * eta * eta * pass.products()
    }

    /// Reflects with a microfacet's Fresnel probability, else refracts.
    pub fn sample(&self, n: DVec3, c: DVec3, u: DVec2, lobe: f64) -> Option<BsdfSample> {
        let (n, eta) = self.side(n, c);
        if !(n.dot(c) > 0.0) {
            return None;
        }
        let m = self.ggx.sample_visible(n, c, u);
        let interface = Interface::facing(c.dot(m), eta);
        let (direction, eta_squared) =
            if lobe < interface.fresnel() { (reflect(m, c), 1.0) } else { (interface.refract(m, c), eta * eta) };
        let direction = direction.normalize();
        let reflected = eta_squared == 1.0;
        // Through further microfacets, to the other side of the surface: that light is lost.
        if (n.dot(direction) > 0.0) != reflected {
            return None;
        }
        let pdf = RoughDielectric { eta, ..*self }.pdf(n, c, direction);
        let weight = Colour::splat(self.ggx.masking(n.dot(direction).abs()) / eta_squared);
        (pdf > 0.0).then_some(BsdfSample { direction, weight, pdf: Some(pdf), eta_squared })
    }

    /// The numbers, direction and lobe, from which [`RoughDielectric::sample`] makes `l`.
    pub fn invert(&self, n: DVec3, c: DVec3, l: DVec3) -> Option<(DVec2, f64)> {
        let (n, eta) = self.side(n, c);
        let (h, reflected) = if front(n, c, l) { (c + l, true) } else { (Pass::new(n, c, l, eta)?.h, false) };
        let m = if n.dot(h) > 0.0 { h.normalize() } else { -h.normalize() };
        let lobe = Interface::facing(c.dot(m), eta).lobe(reflected)?;
        Some((self.ggx.invert_visible(n, c, m), lobe))
    }

    pub fn log_gradient(&self, n: DVec3, c: DVec3, l: DVec3) -> LogGradients {
        let (n, eta) = self.side(n, c);
        if front(n, c, l) {
            let (by_c, by_l) = reflection_log_gradient(&self.ggx, n, c, l);
            let cosine = half_cosine(c, l);
            let interface = Interface::facing(cosine, eta);
            let fresnel = interface.fresnel_derivative() / (interface.fresnel() * 4.0 * cosine);
            return ([by_c + fresnel * l; 3], [by_l + fresnel * c; 3]);
        }
        let Some(pass) = Pass::new(n, c, l, eta) else { return NO_GRADIENT };
        let by_h = self.ggx.density_log_gradient(n, pass.h);
        let by_k = pass.log_derivative();
        let side = |cosine: f64| self.ggx.masking_log_derivative(cosine) - 1.0 / cosine;
        let by_c = by_h + by_k * l + side(n.dot(c)) * n;
        let by_l = eta * by_h + by_k * c - side(-n.dot(l)) * n;
        ([by_c; 3], [by_l; 3])
    }
}

fn front(n: DVec3, c: DVec3, l: DVec3) -> bool {
    n.dot(c) > 0.0 && n.dot(l) > 0.0
}

/// Cosine of both directions to the one half way between.
fn half_cosine(c: DVec3, l: DVec3) -> f64 {
    0.5 * (c + l).length()
}

/// D G/(4 (n·c)(n·l)) [W07 (20)], without Fresnel's factor.
fn reflection(ggx: &Ggx, n: DVec3, c: DVec3, l: DVec3) -> f64 {
    reflection_pdf(ggx, n, c, l) * ggx.masking(n.dot(l)) / n.dot(l)
}

/// Density of reflected visible normals: G₁(c) D/(4 n·c).
fn reflection_pdf(ggx: &Ggx, n: DVec3, c: DVec3, l: DVec3) -> f64 {
    let h = c + l;
    let squared = h.length_squared();
    ggx.density(n, h) * squared * squared * ggx.masking(n.dot(c)) / (4.0 * n.dot(c))
}

/// Of [`reflection`], by c and l.
fn reflection_log_gradient(ggx: &Ggx, n: DVec3, c: DVec3, l: DVec3) -> (DVec3, DVec3) {
    let h = c + l;
    let by_h = ggx.density_log_gradient(n, h) + 4.0 * h / h.length_squared();
    let side = |cosine: f64| ggx.masking_log_derivative(cosine) - 1.0 / cosine;
    (by_h + side(n.dot(c)) * n, by_h + side(n.dot(l)) * n)
}

/// A microfacet that refracts l to c.
struct Pass {
    h: DVec3,
    interface: Interface,
    /// c·h and l·h
    c_h: f64,
    l_h: f64,
}

impl Pass {
    /// None if there is none that both directions see from their sides of the surface.
    fn new(n: DVec3, c: DVec3, l: DVec3, eta: f64) -> Option<Self> {
        let h = c + eta * l;
        let k = c.dot(l);
        let (c_h, l_h) = (1.0 + eta * k, eta + k);
        let up = if n.dot(h) > 0.0 { 1.0 } else { -1.0 };
        let seen = n.dot(c) > 0.0 && n.dot(l) < 0.0 && up * c_h > 0.0 && up * l_h < 0.0;
        seen.then(|| Self { h, interface: Interface::facing(c_h.abs() / h.length(), eta), c_h, l_h })
    }

    /// |c·h||l·h|: with D/|h|⁴ what [W07 (21)] has as |c·m||l·m|/(c·m + η l·m)², m = h/|h|.
    fn products(&self) -> f64 {
        (self.c_h * self.l_h).abs()
    }

    /// ∂log [(1 − F)|c·h||l·h|]/∂k
    fn log_derivative(&self) -> f64 {
        let eta = self.interface.relative;
        let length = self.h.length();
        // cosine = |c·h|/|h|, |h|² = 1 + η² + 2ηk
        let cosine = self.c_h.signum() * eta * eta * self.l_h / (length * length * length);
        let fresnel = -self.interface.fresnel_derivative() / (1.0 - self.interface.fresnel());
        eta / self.c_h + 1.0 / self.l_h + fresnel * cosine
    }
}
