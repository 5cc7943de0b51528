//! Fresnel reflectances of unpolarised light, at dielectrics and conductors.

use crate::math::{Colour, DVec3, sqrt};

/// An interface between dielectrics, met at cosine `cos_i`.
pub struct Interface {
    /// Index of refraction beyond the surface over that on the side of arrival.
    pub relative: f64,
    cos_i: f64,
    sin2_t: f64,
    cos_t: f64,
}

impl Interface {
    /// `cosine` to a normal that points outwards, `eta` the index of refraction inside over outside.
    pub fn new(cosine: f64, eta: f64) -> Self {
        Self::facing(cosine.abs(), if cosine > 0.0 { eta } else { 1.0 / eta })
    }

    /// With a normal on the side of arrival.
    pub fn facing(cos_i: f64, relative: f64) -> Self {
        let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (relative * relative);
        Self { relative, cos_i, sin2_t, cos_t: sqrt((1.0 - sin2_t).max(0.0)) }
    }

    /// The direction beyond the surface in which light goes on that comes from `from` on the side of `n`, both pointing away.
    pub fn refract(&self, n: DVec3, from: DVec3) -> DVec3 {
        (n * self.cos_i - from) / self.relative - n * self.cos_t
    }

    /// Reflectance; 1 at total internal reflection.
    pub fn fresnel(&self) -> f64 {
        if self.sin2_t >= 1.0 {
            return 1.0;
        }
        let (s, p) = self.amplitudes();
        0.5 * (s * s + p * p)
    }

    /// The middle of the numbers that choose to reflect, those below the reflectance, or else to refract. None if none do.
    pub fn lobe(&self, reflected: bool) -> Option<f64> {
        let fresnel = self.fresnel();
        if reflected { (fresnel > 0.0).then_some(0.5 * fresnel) } else { (fresnel < 1.0).then_some(0.5 * (1.0 + fresnel)) }
    }

    /// ∂ reflectance/∂cos_i; 0 at total internal reflection.
    pub fn fresnel_derivative(&self) -> f64 {
        if self.sin2_t >= 1.0 {
            return 0.0;
        }
        let &Self { relative, cos_i, cos_t, .. } = self;
        let (s, p) = self.amplitudes();
        // Both amplitudes are (a − b)/(a + b), with derivatives 2(a'b − ab')/(a + b)².
        let change = 2.0 * relative * (cos_t - cos_i * cos_i / (relative * relative * cos_t));
        let (a_s, a_p) = (cos_i + relative * cos_t, relative * cos_i + cos_t);
        change * (s / (a_s * a_s) + p / (a_p * a_p))
    }

    fn amplitudes(&self) -> (f64, f64) {
        let &Self { relative, cos_i, cos_t, .. } = self;
        let s = (cos_i - relative * cos_t) / (cos_i + relative * cos_t);
        let p = (relative * cos_i - cos_t) / (relative * cos_i + cos_t);
        (s, p)
    }
}

/// A metal: complex index of refraction eta + i·k over that outside, and a factor on its reflectance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    pub eta: Colour,
    pub k: Colour,
    pub reflectance: Colour,
}

impl Conductor {
    /// Reflectance at the cosine of incidence.
    pub fn fresnel(&self, cosine: f64) -> Colour {
        let channel = |c: usize| self.reflectance[c] * conductor(self.eta[c], self.k[c], cosine).0;
        Colour::new(channel(0), channel(1), channel(2))
    }

    /// ∂log reflectance/∂cosine.
    pub fn log_derivative(&self, cosine: f64) -> [f64; 3] {
        [0, 1, 2].map(|c| {
            let (reflectance, derivative) = conductor(self.eta[c], self.k[c], cosine);
            if reflectance > 0.0 { derivative / reflectance } else { 0.0 }
        })
    }
}

/// Reflectance of a conductor and its derivative by the cosine.
/// Source: M. Born, E. Wolf, *Principles of Optics*, 13.4, in the form of Mitsuba 3's `fresnel_conductor`.
fn conductor(eta: f64, k: f64, cosine: f64) -> (f64, f64) {
    let (c, c2) = (cosine, cosine * cosine);
    let s2 = (1.0 - c2).max(0.0);
    let t = eta * eta - k * k - s2;
    let a2_b2 = sqrt(t * t + 4.0 * eta * eta * k * k);
    let a = sqrt((0.5 * (a2_b2 + t)).max(0.0));
    let (s_sum, s_product) = (a2_b2 + c2, 2.0 * c * a);
    let (p_sum, p_product) = (a2_b2 * c2 + s2 * s2, s_product * s2);
    let s = (s_sum - s_product) / (s_sum + s_product);
    let p = (p_sum - p_product) / (p_sum + p_product);
    // Without a, all is reflected.
    if !(a > 0.0 && c > 0.0) {
        return (1.0, 0.0);
    }
    let d_a2_b2 = 2.0 * c * t / a2_b2;
    let d_a = (d_a2_b2 + 2.0 * c) / (4.0 * a);
    let (d_s_sum, d_s_product) = (d_a2_b2 + 2.0 * c, 2.0 * a + 2.0 * c * d_a);
    let d_p_sum = d_a2_b2 * c2 + 2.0 * c * a2_b2 - 4.0 * c * s2;
    let d_p_product = d_s_product * s2 - 2.0 * c * s_product;
    let ratio = |sum: f64, product: f64, d_sum: f64, d_product: f64| {
        2.0 * (d_sum * product - sum * d_product) / ((sum + product) * (sum + product))
    };
    let d_s = ratio(s_sum, s_product, d_s_sum, d_s_product);
    let d_p = ratio(p_sum, p_product, d_p_sum, d_p_product);
    (0.5 * s * (1.0 + p), 0.5 * (d_s * (1.0 + p) + s * d_p))
}
