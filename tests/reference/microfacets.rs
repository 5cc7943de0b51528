//! Rough conductors and dielectrics made of GGX microfacets, written out with angles.
//!
//! Source: B. Walter, S. Marschner, H. Li, K. Torrance, *Microfacet Models for Refraction through Rough Surfaces*, EGSR 2007:
//! (20) and (21) with the distribution (33) and the masking (34), each direction by itself; Fresnel's equations in complex numbers.

use super::vector::*;
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug)]
pub enum Microfacets {
    /// Complex index of refraction η + ik per channel; reflects on the side that the normal points to.
    Conductor { eta: Rgb, k: Rgb },
    /// Index of refraction on the side that the normal points away from, over that on the other.
    Dielectric { eta: f64 },
}

impl Microfacets {
    /// f_r or f_t from the unit vector `l` to the light into the unit vector `c` to the camera, both away from the surface, for radiance.
    pub fn value(&self, alpha: f64, n: Vec3, c: Vec3, l: Vec3) -> Rgb {
        let (n_c, n_l) = (dot(n, c), dot(n, l));
        match *self {
            Microfacets::Conductor { eta, k } if n_c > 0.0 && n_l > 0.0 => {
                let half = normalize(add(c, l));
                let fresnel = [0, 1, 2].map(|channel| reflectance((eta[channel], k[channel]), dot(c, half)));
                scale(reflected(alpha, n, c, l), fresnel)
            }
            Microfacets::Conductor { .. } => ZERO,
            // Seen from the other side, the surface is one with the reciprocal index.
            Microfacets::Dielectric { eta } if n_c < 0.0 => {
                Microfacets::Dielectric { eta: 1.0 / eta }.value(alpha, scale(-1.0, n), c, l)
            }
            Microfacets::Dielectric { eta } if n_l > 0.0 => {
                let half = normalize(add(c, l));
                scale(reflectance((eta, 0.0), dot(c, half)) * reflected(alpha, n, c, l), ONE)
            }
            Microfacets::Dielectric { eta } => scale(refracted(alpha, n, c, l, eta), ONE),
        }
    }
}

/// D G/(4 |c·n| |l·n|), half way between c and l. [Walter 2007 (20)]
fn reflected(alpha: f64, n: Vec3, c: Vec3, l: Vec3) -> f64 {
    let half = normalize(add(c, l));
    let masking = masking(alpha, n, c) * masking(alpha, n, l);
    distribution(alpha, dot(n, half)) * masking / (4.0 * dot(n, c) * dot(n, l))
}

/// [Walter 2007 (21)] from l, beyond the surface with index `eta`, to c, on the side of n with index 1.
fn refracted(alpha: f64, n: Vec3, c: Vec3, l: Vec3, eta: f64) -> f64 {
    let m = refracting(n, c, l, eta);
    let (m_c, m_l) = (dot(m, c), dot(m, l));
    if m_c <= 0.0 || m_l >= 0.0 {
        return 0.0;
    }
    let masking = masking(alpha, n, c) * masking(alpha, n, l);
    let passed = 1.0 - reflectance((eta, 0.0), m_c);
    let jacobian = (m_c * m_l).abs() / (m_c + eta * m_l).powi(2);
    passed * distribution(alpha, dot(n, m)) * masking * jacobian / (dot(n, c) * dot(n, l)).abs()
}

/// The normal, on the side of n, of the microfacet that refracts l to c; only if m·c > 0 > m·l is there one.
fn refracting(n: Vec3, c: Vec3, l: Vec3, eta: f64) -> Vec3 {
    let half = normalize(add(c, scale(eta, l)));
    scale(dot(half, n).signum(), half)
}

/// The cosine at which light passes a microfacet, on the side where it is smaller. Not positive: it does not.
pub fn passing_cosine(n: Vec3, c: Vec3, l: Vec3, eta: f64) -> f64 {
    let (n, eta) = if dot(n, c) > 0.0 { (n, eta) } else { (scale(-1.0, n), 1.0 / eta) };
    let m = refracting(n, c, l, eta);
    dot(m, c).min(-dot(m, l))
}

/// D(m) by the cosine of m to the surface's normal. [Walter 2007 (33)]
pub fn distribution(alpha: f64, cosine: f64) -> f64 {
    let tan2 = 1.0 / (cosine * cosine) - 1.0;
    if cosine > 0.0 { alpha * alpha / (PI * cosine.powi(4) * (alpha * alpha + tan2).powi(2)) } else { 0.0 }
}

/// G_1 [Walter 2007 (34)]
fn masking(alpha: f64, n: Vec3, v: Vec3) -> f64 {
    let tan = dot(n, v).abs().acos().tan();
    2.0 / (1.0 + (1.0 + alpha * alpha * tan * tan).sqrt())
}

type Complex = (f64, f64);

fn times(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn over(a: Complex, b: Complex) -> Complex {
    let norm = b.0 * b.0 + b.1 * b.1;
    times(a, (b.0 / norm, -b.1 / norm))
}

fn root(a: Complex) -> Complex {
    let (radius, angle) = (a.0.hypot(a.1).sqrt(), 0.5 * a.1.atan2(a.0));
    (radius * angle.cos(), radius * angle.sin())
}

/// |(a − b)/(a + b)|²
fn amplitude2(a: Complex, b: Complex) -> f64 {
    let (re, im) = over((a.0 - b.0, a.1 - b.1), (a.0 + b.0, a.1 + b.1));
    re * re + im * im
}

/// Fresnel reflectance of unpolarised light that meets a medium with that relative complex index under that cosine.
pub fn reflectance(index: Complex, cosine: f64) -> f64 {
    let (re, im) = over((1.0 - cosine * cosine, 0.0), times(index, index));
    let refracted = root((1.0 - re, -im));
    let perpendicular = amplitude2((cosine, 0.0), times(index, refracted));
    let parallel = amplitude2(times(index, (cosine, 0.0)), refracted);
    0.5 * (perpendicular + parallel)
}
