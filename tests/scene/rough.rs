//! Metals and rough surfaces: values against an evaluation by angles and complex numbers, densities against quadrature and samples,
//! reciprocity, energy, and log-derivatives against differences.
//!
//! Significance: the chi-square tests fail below p = 1e-4; seeds are fixed, so that they pass for ever or never.

use super::{ROUNDING, direction, direction_before, unit_square};
use crate::reference::differences::gradient;
use crate::reference::random::{generator, uniform};
use crate::statistics::chi_square_p_value;
use proptest::prelude::*;
use std::f64::consts::PI;
use volgrad::math::{Colour, DVec2, DVec3, around_direction};
use volgrad::scene::{Bsdf, Conductor, Ggx, Reflector, RoughConductor, RoughDielectric, SurfacePoint};

/// Copper, about.
const ETA: Colour = Colour::new(0.22, 0.95, 1.2);
const K: Colour = Colour::new(3.6, 2.6, 2.4);
const TINT: Colour = Colour::new(0.9, 0.8, 0.7);
pub const METAL: Conductor = Conductor { eta: ETA, k: K, reflectance: TINT };
/// Reflects all.
const PERFECT: Conductor = Conductor { eta: Colour::ZERO, k: Colour::ONE, reflectance: Colour::ONE };

pub fn metal(conductor: Conductor, alpha: f64) -> Bsdf<'static> {
    Bsdf::RoughConductor(RoughConductor { conductor, ggx: Ggx { alpha } })
}

pub fn glass(eta: f64, alpha: f64) -> Bsdf<'static> {
    Bsdf::RoughDielectric(RoughDielectric { eta, ggx: Ggx { alpha } })
}

/// Complex numbers as pairs.
mod complex {
    pub type Complex = (f64, f64);

    pub fn add(a: Complex, b: Complex) -> Complex {
        (a.0 + b.0, a.1 + b.1)
    }

    pub fn scale(s: f64, a: Complex) -> Complex {
        (s * a.0, s * a.1)
    }

    pub fn multiply(a: Complex, b: Complex) -> Complex {
        (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
    }

    pub fn square_root(a: Complex) -> Complex {
        let (radius, angle) = (a.0.hypot(a.1).sqrt(), 0.5 * a.1.atan2(a.0));
        (radius * angle.cos(), radius * angle.sin())
    }

    /// |a/b|²
    pub fn squared_ratio(a: Complex, b: Complex) -> f64 {
        (a.0 * a.0 + a.1 * a.1) / (b.0 * b.0 + b.1 * b.1)
    }
}

/// Fresnel's equations with the complex index n: cos − √(n² − sin²) over the sum, and n² cos − √… over the sum.
fn fresnel(n: complex::Complex, cosine: f64) -> f64 {
    use complex::*;
    let n2 = multiply(n, n);
    let root = square_root(add(n2, (cosine * cosine - 1.0, 0.0)));
    let (s, p) = ((cosine, 0.0), scale(cosine, n2));
    let minus = scale(-1.0, root);
    0.5 * (squared_ratio(add(s, minus), add(s, root)) + squared_ratio(add(p, minus), add(p, root)))
}

/// D and G₁ by tangents [W07 (33), (34)].
fn ggx(alpha: f64, cosine: f64) -> f64 {
    let tan2 = 1.0 / (cosine * cosine) - 1.0;
    alpha * alpha / (PI * cosine.powi(4) * (alpha * alpha + tan2).powi(2))
}

fn masking(alpha: f64, cosine: f64) -> f64 {
    2.0 / (1.0 + (1.0 + alpha * alpha * (1.0 / (cosine * cosine) - 1.0)).sqrt())
}

/// [W07 (20)]
fn reflected(alpha: f64, n: DVec3, c: DVec3, l: DVec3, fresnel: impl Fn(f64) -> f64) -> f64 {
    let m = (c + l).normalize();
    let (nc, nl) = (n.dot(c), n.dot(l));
    fresnel(c.dot(m)) * ggx(alpha, n.dot(m)) * masking(alpha, nc) * masking(alpha, nl) / (4.0 * nc * nl)
}

/// [W07 (21)] divided by η², which makes it radiance's. n on the side of c.
fn refracted(alpha: f64, n: DVec3, c: DVec3, l: DVec3, eta: f64) -> f64 {
    let m = (c + eta * l).normalize();
    let m = if n.dot(m) > 0.0 { m } else { -m };
    let (nc, nl, mc, ml) = (n.dot(c), -n.dot(l), m.dot(c), -m.dot(l));
    if mc <= 0.0 || ml <= 0.0 {
        return 0.0;
    }
    let passing = (1.0 - fresnel((eta, 0.0), mc)) * ggx(alpha, n.dot(m)) * masking(alpha, nc) * masking(alpha, nl);
    passing * mc * ml / (nc * nl * (mc - eta * ml).powi(2))
}

fn above() -> impl Strategy<Value = (f64, f64)> {
    (0.02..0.999_f64, 0.0..1.0_f64)
}

fn roughness() -> impl Strategy<Value = f64> {
    0.02..1.2_f64
}

/// On both sides of 1.
pub fn index() -> impl Strategy<Value = f64> {
    prop_oneof![1.1..2.5_f64, 0.4..0.9_f64]
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * (1.0 + a.abs().max(b.abs()))
}

proptest! {
    #[test]
    fn metals_reflect_as_fresnel_says(n in direction(), camera in above(), other in above()) {
        let (c, l) = (direction_before(n, camera), direction_before(n, other));
        let smooth = Bsdf::Conductor(METAL);
        let sample = smooth.sample(&SurfacePoint::with_normal(n), c, DVec2::ZERO, 0.5).expect("light from the front");
        prop_assert!((sample.direction + c - 2.0 * camera.0 * n).length() < ROUNDING && sample.pdf.is_none());
        for channel in 0..3 {
            let expected = TINT[channel] * fresnel((ETA[channel], K[channel]), camera.0);
            prop_assert!((sample.weight[channel] - expected).abs() < 1e-10);
        }
        prop_assert_eq!(smooth.eval_or_weight(&SurfacePoint::with_normal(n), c, l), sample.weight);
        prop_assert!(smooth.is_specular() && smooth.eval(&SurfacePoint::with_normal(n), c, l) == Colour::ZERO && smooth.sample(&SurfacePoint::with_normal(n), -c, DVec2::ZERO, 0.5).is_none());
    }

    #[test]
    fn rough_metals_are_as_in_the_paper(n in direction(), camera in above(), light in above(), alpha in roughness()) {
        let (c, l) = (direction_before(n, camera), direction_before(n, light));
        let bsdf = metal(METAL, alpha);
        let found = bsdf.eval(&SurfacePoint::with_normal(n), c, l);
        for channel in 0..3 {
            let expected = reflected(alpha, n, c, l, |cosine| TINT[channel] * fresnel((ETA[channel], K[channel]), cosine));
            prop_assert!(near(found[channel], expected, 1e-8), "{}, {expected}", found[channel]);
        }
        prop_assert!((found - bsdf.eval(&SurfacePoint::with_normal(n), l, c)).length() < 1e-9 * (1.0 + found.length()), "reciprocity");
        for (c, l) in [(-c, l), (c, -l), (-c, -l)] {
            prop_assert!(bsdf.eval(&SurfacePoint::with_normal(n), c, l) == Colour::ZERO && bsdf.pdf(&SurfacePoint::with_normal(n), c, l) == 0.0);
        }
    }

    #[test]
    fn rough_glass_is_as_in_the_paper(n in direction(), camera in above(), light in above(), alpha in roughness(), eta in index()) {
        let (c, l) = (direction_before(n, camera), direction_before(n, light));
        let bsdf = glass(eta, alpha);
        // From outside, then from inside.
        for (own, eta) in [(n, eta), (-n, 1.0 / eta)] {
            let expected = reflected(alpha, n, c, l, |cosine| fresnel((eta, 0.0), cosine));
            prop_assert!(near(bsdf.eval(&SurfacePoint::with_normal(own), c, l).x, expected, 1e-8));
            let (found, expected) = (bsdf.eval(&SurfacePoint::with_normal(own), c, -l).x, refracted(alpha, n, c, -l, eta));
            prop_assert!(near(found, expected, 1e-8), "{found}, {expected}");
            let back = bsdf.eval(&SurfacePoint::with_normal(own), -l, c).x;
            prop_assert!(near(back, found * eta * eta, 1e-8), "reciprocity of f_r/η²: {found}, {back}");
        }
    }

    /// weight = f_r·cos/pdf, and the density stated is that of the direction.
    #[test]
    fn samples_are_as_evaluated(n in direction(), camera in above(), u in unit_square(), lobe in 0.0..1.0_f64, alpha in roughness(), eta in index()) {
        let c = direction_before(n, camera);
        for (bsdf, c) in [(metal(METAL, alpha), c), (glass(eta, alpha), c), (glass(eta, alpha), -c)] {
            let Some(sample) = bsdf.sample(&SurfacePoint::with_normal(n), c, u, lobe) else { continue };
            let l = sample.direction;
            let pdf = sample.pdf.expect("a density");
            prop_assert!((l.length() - 1.0).abs() < ROUNDING && near(pdf, bsdf.pdf(&SurfacePoint::with_normal(n), c, l), 1e-9));
            let value = bsdf.eval(&SurfacePoint::with_normal(n), c, l) * n.dot(l).abs() / pdf;
            // Grazing directions lose digits in the half vector.
            prop_assert!((sample.weight - value).length() < 1e-5 * (1.0 + value.length()), "{} {value} {pdf}", sample.weight);
            let relative = if n.dot(c) > 0.0 { eta } else { 1.0 / eta };
            let passes = n.dot(c) * n.dot(l) < 0.0;
            prop_assert_eq!(sample.eta_squared, if passes { relative * relative } else { 1.0 });
        }
    }

    /// By both directions, reflected and refracted, from both sides.
    #[test]
    fn log_gradients_are_those_of_the_value(n in direction(), camera in (0.15..0.98_f64, 0.0..1.0_f64), light in (0.15..0.98_f64, 0.0..1.0_f64), alpha in 0.1..1.0_f64, eta in index()) {
        let (c, l) = (direction_before(n, camera), direction_before(n, light));
        let glass = glass(eta, alpha);
        for (bsdf, c, l) in [(metal(METAL, alpha), c, l), (glass, c, l), (glass, -c, -l), (glass, c, -l), (glass, -c, l)] {
            if !(bsdf.eval(&SurfacePoint::with_normal(n), c, l).x > 1e-12) || next_to_total_reflection(eta, n, c, l) {
                continue;
            }
            let log = |c: DVec3, l: DVec3| bsdf.eval(&SurfacePoint::with_normal(n), c.normalize(), l.normalize()).to_array().map(f64::ln);
            let (by_c, by_l) = bsdf.log_gradient(&SurfacePoint::with_normal(n), c, l).expect("built in");
            let expected_c = gradient(|w| log(DVec3::from_array(w), l), c.to_array());
            let expected_l = gradient(|w| log(c, DVec3::from_array(w)), l.to_array());
            for channel in 0..3 {
                for (found, omega, expected) in [(by_c, c, expected_c), (by_l, l, expected_l)] {
                    let (found, expected) = (found[channel], DVec3::from_array(expected[channel]));
                    let tangent = found - found.dot(omega) * omega;
                    let scale = 1.0 + tangent.length() + 1.0 / alpha;
                    prop_assert!((tangent - expected).length() < 1e-4 * scale, "{bsdf:?}: {tangent}, {expected}");
                }
            }
        }
    }

    #[test]
    fn two_sided_surfaces_are_alike_on_both_sides(n in direction(), camera in above(), light in above(), u in unit_square()) {
        let (c, l) = (direction_before(n, camera), direction_before(n, light));
        let rough = RoughConductor { conductor: METAL, ggx: Ggx { alpha: 0.3 } };
        for reflector in [
            Reflector::Diffuse { albedo: TINT },
            Reflector::Mirror { reflectance: TINT },
            Reflector::Conductor(METAL),
            Reflector::RoughConductor(rough),
        ] {
            let (one, two) = (Bsdf::from(reflector), Bsdf::TwoSided(reflector));
            prop_assert_eq!(one.is_specular(), two.is_specular());
            prop_assert_eq!(one.is_lambertian(), two.is_lambertian());
            prop_assert!(!one.transmits() && !two.transmits());
            prop_assert_eq!(one.facing(n, -c), n);
            for n in [n, -n] {
                let front = two.facing(n, c);
                prop_assert!(front.dot(c) > 0.0);
                prop_assert_eq!(one.eval(&SurfacePoint::with_normal(front), c, l), two.eval(&SurfacePoint::with_normal(n), c, l));
                prop_assert_eq!(one.eval_or_weight(&SurfacePoint::with_normal(front), c, l), two.eval_or_weight(&SurfacePoint::with_normal(n), c, l));
                prop_assert_eq!(one.pdf(&SurfacePoint::with_normal(front), c, l), two.pdf(&SurfacePoint::with_normal(n), c, l));
                prop_assert_eq!(one.log_gradient(&SurfacePoint::with_normal(front), c, l), two.log_gradient(&SurfacePoint::with_normal(n), c, l));
                let [a, b] = [(one, front), (two, n)].map(|(bsdf, n)| bsdf.sample(&SurfacePoint::with_normal(n), c, u, 0.5).map(|s| (s.direction, s.weight, s.pdf)));
                prop_assert_eq!(a, b);
                prop_assert_eq!(two.eval(&SurfacePoint::with_normal(n), c, -l), Colour::ZERO);
            }
        }
    }
}

/// Where the microfacet's reflectance has its kink, within what differences reach.
fn next_to_total_reflection(eta: f64, n: DVec3, c: DVec3, l: DVec3) -> bool {
    let relative = if n.dot(c) > 0.0 { eta } else { 1.0 / eta };
    let m = if n.dot(c) * n.dot(l) > 0.0 { (c + l).normalize() } else { (c + relative * l).normalize() };
    let cosine = c.dot(m);
    let inside = 1.0 - (1.0 - cosine * cosine) / (relative * relative);
    // Refracted light is next to it where its own cosine is small.
    inside.abs() < 0.05
}

const STEPS: [usize; 2] = [600, 1200];
/// Parts of the sphere about the normal: turns, heights.
pub const PARTS: [usize; 2] = [8, 12];

pub fn part(n: DVec3, v: DVec3) -> usize {
    let (height, turn) = around_direction(n, v);
    let column = ((turn * PARTS[0] as f64) as usize).min(PARTS[0] - 1);
    column + PARTS[0] * (((0.5 * height + 0.5) * PARTS[1] as f64) as usize).min(PARTS[1] - 1)
}

/// ∫ of `value(l)` over the sphere, part by part, by the midpoint rule.
pub fn integrals(n: DVec3, value: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let mut sums = vec![0.0; PARTS[0] * PARTS[1]];
    for row in 0..STEPS[1] {
        let height = -1.0 + 2.0 * (row as f64 + 0.5) / STEPS[1] as f64;
        for column in 0..STEPS[0] {
            let l = direction_before(n, (height, (column as f64 + 0.5) / STEPS[0] as f64));
            sums[part(n, l)] += value(l) * 4.0 * PI / (STEPS[0] * STEPS[1]) as f64;
        }
    }
    sums
}

/// What is lost, because microfacets send it to the wrong side, is a part of its own.
#[test]
fn samples_follow_their_density() {
    const SAMPLES: usize = 1 << 17;
    let n = DVec3::new(0.48, -0.6, 0.64);
    let cases = [
        (metal(METAL, 0.5), 0.7),
        (metal(METAL, 0.5), 0.1),
        (glass(1.5, 0.4), 0.8),
        (glass(1.5, 0.6), -0.5),
        (glass(0.7, 0.3), 0.6),
    ];
    for (index, (bsdf, height)) in cases.into_iter().enumerate() {
        let c = direction_before(n, (height, 0.3));
        let mut rng = generator(40 + index as u64);
        let mut counts = vec![0; PARTS[0] * PARTS[1] + 1];
        for _ in 0..SAMPLES {
            let mut number = || uniform(&mut rng, 0.0, 1.0);
            let sample = bsdf.sample(&SurfacePoint::with_normal(n), c, DVec2::new(number(), number()), number());
            counts[sample.map_or(PARTS[0] * PARTS[1], |sample| part(n, sample.direction))] += 1;
        }
        let mut probabilities = integrals(n, |l| bsdf.pdf(&SurfacePoint::with_normal(n), c, l));
        let total: f64 = probabilities.iter().sum();
        assert!(total < 1.0 + 1e-4 && total > 0.5, "{total}");
        probabilities.push((1.0 - total).max(0.0));
        let p = chi_square_p_value(&counts, &probabilities);
        println!("{bsdf:?} at {height}: ∫ pdf = {total:.6}, p = {p:.3}");
        assert!(p > 1e-4, "{p}");
    }
}

/// On a surface that is hardly rough nothing is lost: ∫ pdf = 1, and all of the energy, with 1/η² undone, goes somewhere.
#[test]
fn hardly_rough_surfaces_lose_nothing() {
    let n = DVec3::new(0.48, -0.6, 0.64);
    for (bsdf, height) in
        [(metal(PERFECT, 0.02), 0.8), (glass(1.5, 0.02), 0.8), (glass(1.5, 0.02), -0.9), (glass(1.5, 0.02), -0.6)]
    {
        let c = direction_before(n, (height, 0.3));
        let probability: f64 = integrals(n, |l| bsdf.pdf(&SurfacePoint::with_normal(n), c, l)).iter().sum();
        let energy: f64 = integrals(n, |l| energy(&bsdf, n, c, l)).iter().sum();
        println!("{bsdf:?} at {height}: {probability:.6}, {energy:.6}");
        assert!((probability - 1.0).abs() < 1e-3 && energy < 1.0 + 1e-3 && energy > 0.998);
    }
}

/// f_r·cos, times η² for what passes.
fn energy(bsdf: &Bsdf, n: DVec3, c: DVec3, l: DVec3) -> f64 {
    let eta = match bsdf {
        Bsdf::RoughDielectric(rough) if n.dot(c) > 0.0 => rough.eta,
        Bsdf::RoughDielectric(rough) => 1.0 / rough.eta,
        _ => 1.0,
    };
    let passed = if n.dot(c) * n.dot(l) < 0.0 { eta * eta } else { 1.0 };
    bsdf.eval(&SurfacePoint::with_normal(n), c, l).x * n.dot(l).abs() * passed
}

/// What lets one direction see another loses light between microfacets, but never makes any.
#[test]
fn rough_surfaces_make_no_energy() {
    let n = DVec3::Z;
    for alpha in [0.2, 0.6, 1.0] {
        for height in [0.2, 0.6, 0.95] {
            let c = direction_before(n, (height, 0.3));
            for (bsdf, c) in [(metal(PERFECT, alpha), c), (glass(1.5, alpha), c), (glass(1.5, alpha), -c)] {
                let energy: f64 = integrals(n, |l| energy(&bsdf, n, c, l)).iter().sum();
                assert!(energy < 1.0 + 1e-4 && energy > 0.3, "{bsdf:?} at {height}: {energy}");
            }
        }
    }
}

/// A rough surface becomes the smooth one: the mean of what it samples, and where to.
#[test]
fn the_limit_of_roughness_is_smooth() {
    let n = DVec3::Z;
    let c = direction_before(n, (0.7, 0.3));
    let u = DVec2::new(0.37, 0.61);
    for lobe in [0.01, 0.99] {
        let pairs = [
            (metal(METAL, 1e-4), Bsdf::Conductor(METAL), c),
            (glass(1.5, 1e-4), Bsdf::Dielectric { eta: 1.5 }, c),
            (glass(1.5, 1e-4), Bsdf::Dielectric { eta: 1.5 }, -c),
        ];
        for (rough, smooth, c) in pairs {
            let [a, b] =
                [rough, smooth].map(|bsdf| bsdf.sample(&SurfacePoint::with_normal(n), c, u, lobe).expect("a direction"));
            assert!((a.direction - b.direction).length() < 1e-3 && (a.weight - b.weight).length() < 1e-3, "{rough:?}");
            assert_eq!(a.eta_squared, b.eta_squared);
        }
    }
}
