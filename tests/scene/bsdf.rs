//! Surfaces: what is sampled is what is evaluated; glass obeys Snell and Fresnel, and keeps energy and reciprocity.

use super::{ROUNDING, direction, direction_before, unit_square};
use crate::reference::differences::derivative;
use proptest::prelude::*;
use std::f64::consts::PI;
use volgrad::math::{Colour, DVec2, DVec3};
use volgrad::scene::{Bsdf, SurfacePoint};

const ALBEDO: Colour = Colour::new(0.8, 0.5, 0.1);
const DIFFUSE: Bsdf = Bsdf::Diffuse { albedo: ALBEDO };
const MIRROR: Bsdf = Bsdf::Mirror { reflectance: ALBEDO };

/// Cosine to an axis, off 0 and 1, and share of a turn about it.
fn above() -> impl Strategy<Value = (f64, f64)> {
    (0.001..0.999_f64, 0.0..1.0_f64)
}

/// The cosine of the critical angle inside glass; 0 if `eta` < 1.
fn critical_cosine(eta: f64) -> f64 {
    (1.0 - 1.0 / (eta * eta)).max(0.0).sqrt()
}

/// Unpolarised Fresnel reflectance by angles, which volgrad's does not use. Not for normal incidence.
fn fresnel_by_angles(cosine: f64, eta: f64) -> f64 {
    let incident = cosine.acos();
    let refracted = (incident.sin() / eta).asin();
    let s = (incident - refracted).sin() / (incident + refracted).sin();
    let p = (incident - refracted).tan() / (incident + refracted).tan();
    0.5 * (s * s + p * p)
}

/// The two directions that glass scatters to: mirrored, and through; the latter None at total internal reflection.
fn glass_lobes(n: DVec3, to_camera: DVec3, eta: f64) -> (DVec3, Option<DVec3>) {
    let lobe = |lobe: f64| {
        Bsdf::Dielectric { eta }
            .sample(&SurfacePoint::with_normal(n), to_camera, DVec2::ZERO, lobe)
            .expect("glass scatters all")
    };
    let last = lobe(1.0 - f64::EPSILON / 2.0);
    let passes = n.dot(last.direction) * n.dot(to_camera) < 0.0;
    (lobe(0.0).direction, passes.then_some(last.direction))
}

proptest! {
    #[test]
    fn diffuse_samples_are_as_evaluated(n in direction(), camera in above(), u in unit_square()) {
        let to_camera = direction_before(n, camera);
        let sample = DIFFUSE.sample(&SurfacePoint::with_normal(n), to_camera, u, 0.5).expect("light from the front");
        let cosine = n.dot(sample.direction);
        prop_assert!(cosine > 0.0 && (sample.direction.length() - 1.0).abs() < ROUNDING);
        let pdf = DIFFUSE.pdf(&SurfacePoint::with_normal(n), to_camera, sample.direction);
        prop_assert!((sample.pdf.expect("a density") - pdf).abs() < ROUNDING);
        let weight = DIFFUSE.eval(&SurfacePoint::with_normal(n), to_camera, sample.direction) * cosine;
        prop_assert!((sample.weight * pdf - weight).length() < ROUNDING);
        prop_assert_eq!(sample.eta_squared, 1.0);
        prop_assert!(DIFFUSE.sample(&SurfacePoint::with_normal(n), -to_camera, u, 0.5).is_none());
        prop_assert_eq!(DIFFUSE.eval(&SurfacePoint::with_normal(n), -to_camera, sample.direction), Colour::ZERO);
        prop_assert_eq!(DIFFUSE.eval(&SurfacePoint::with_normal(n), to_camera, -sample.direction), Colour::ZERO);
        prop_assert_eq!(DIFFUSE.pdf(&SurfacePoint::with_normal(n), to_camera, -sample.direction), 0.0);
    }

    /// The solid angle that the map from the unit square gives to du₁du₂, by differences, times the density is 1.
    #[test]
    fn diffuse_samples_are_as_dense_as_stated(n in direction(), camera in above(), u in (0.01..0.99_f64, 0.01..0.99_f64)) {
        let to_camera = direction_before(n, camera);
        let at = |dx: f64, dy: f64| DIFFUSE.sample(&SurfacePoint::with_normal(n), to_camera, DVec2::new(u.0 + dx, u.1 + dy), 0.5).expect("a direction");
        let along_x = DVec3::from_array(derivative(|h| at(h, 0.0).direction.to_array()));
        let along_y = DVec3::from_array(derivative(|h| at(0.0, h).direction.to_array()));
        let solid_angle = along_x.cross(along_y).length();
        prop_assert!((solid_angle * at(0.0, 0.0).pdf.expect("a density") - 1.0).abs() < 1e-7);
    }

    #[test]
    fn mirrors_mirror(n in direction(), camera in above()) {
        let to_camera = direction_before(n, camera);
        let sample = MIRROR.sample(&SurfacePoint::with_normal(n), to_camera, DVec2::ZERO, 0.5).expect("light from the front");
        prop_assert!((sample.direction + to_camera - 2.0 * camera.0 * n).length() < ROUNDING);
        prop_assert_eq!((sample.weight, sample.pdf), (ALBEDO, None));
        prop_assert_eq!(MIRROR.eval_or_weight(&SurfacePoint::with_normal(n), to_camera, sample.direction), ALBEDO);
        prop_assert_eq!(MIRROR.eval(&SurfacePoint::with_normal(n), to_camera, sample.direction), Colour::ZERO);
        prop_assert!(MIRROR.sample(&SurfacePoint::with_normal(n), -to_camera, DVec2::ZERO, 0.5).is_none());
        prop_assert_eq!(MIRROR.eval_or_weight(&SurfacePoint::with_normal(n), -to_camera, -sample.direction), Colour::ZERO);
    }

    /// sin θ = η sin θ', in one plane; and back on the same way.
    #[test]
    fn glass_refracts_by_snell(n in direction(), camera in above(), eta in 1.0001..3.0_f64, inside in any::<bool>()) {
        let to_camera = direction_before(if inside { -n } else { n }, camera);
        let (reflected, refracted) = glass_lobes(n, to_camera, eta);
        let facing = n * n.dot(to_camera).signum();
        prop_assert!((reflected + to_camera - 2.0 * camera.0 * facing).length() < ROUNDING);
        let Some(refracted) = refracted else {
            prop_assert!(inside && camera.0 <= critical_cosine(eta) + ROUNDING, "total reflection only in the denser side");
            return Ok(());
        };
        prop_assert!(!inside || camera.0 >= critical_cosine(eta) - ROUNDING);
        prop_assert!((refracted.length() - 1.0).abs() < ROUNDING);
        let relative = if inside { 1.0 / eta } else { eta };
        prop_assert!((n.cross(to_camera) + relative * n.cross(refracted)).length() < 1e-9);
        let (_, back) = glass_lobes(n, refracted, eta);
        // Next to the critical angle a rounding of the sine is a large one of the cosine.
        prop_assert!(back.is_none_or(|back| (back - to_camera).length() < 1e-6));
    }

    /// What is reflected and what passes add up, each with the weight that sampling gives it. Radiance that passes is divided by
    /// η², since its solid angle is multiplied by it.
    #[test]
    fn glass_keeps_energy(n in direction(), camera in above(), eta in 1.0001..3.0_f64, inside in any::<bool>(), lobe in 0.0..1.0_f64) {
        let glass = Bsdf::Dielectric { eta };
        let to_camera = direction_before(if inside { -n } else { n }, camera);
        let (reflected, refracted) = glass_lobes(n, to_camera, eta);
        let relative = if inside { 1.0 / eta } else { eta };
        let fresnel = glass.eval_or_weight(&SurfacePoint::with_normal(n), to_camera, reflected).x;
        let passing = refracted.map_or(0.0, |refracted| glass.eval_or_weight(&SurfacePoint::with_normal(n), to_camera, refracted).x);
        prop_assert!((fresnel + relative * relative * passing - 1.0).abs() < ROUNDING);
        let expected = if refracted.is_some() { fresnel_by_angles(camera.0, relative) } else { 1.0 };
        // Next to the critical angle the reflectance rises as the root of the distance to it.
        prop_assert!((fresnel - expected).abs() < 1e-7, "{fresnel}, {expected}");

        let sample = glass.sample(&SurfacePoint::with_normal(n), to_camera, DVec2::ZERO, lobe).expect("glass scatters all");
        let (weight, probability) = if lobe < fresnel { (fresnel, fresnel) } else { (passing, 1.0 - fresnel) };
        prop_assert!((sample.weight.x * probability - weight).abs() < ROUNDING);
        prop_assert!((sample.weight.x * sample.eta_squared - 1.0).abs() < ROUNDING);
        prop_assert_eq!(sample.pdf, None);
    }

    /// Light that goes the other way: radiance over the square of the index of refraction is what stays the same.
    #[test]
    fn glass_is_reciprocal(n in direction(), camera in above(), eta in 1.0001..3.0_f64) {
        let glass = Bsdf::Dielectric { eta };
        let to_camera = direction_before(n, camera);
        let (reflected, refracted) = glass_lobes(n, to_camera, eta);
        let weight = |a: DVec3, b: DVec3| glass.eval_or_weight(&SurfacePoint::with_normal(n), a, b).x;
        prop_assert!((weight(to_camera, reflected) - weight(reflected, to_camera)).abs() < ROUNDING);
        let refracted = refracted.expect("the thinner side always lets through");
        let (into, out_of) = (weight(to_camera, refracted) * eta * eta, weight(refracted, to_camera) / (eta * eta));
        // Near the critical angle a cosine is the root of a rounding.
        prop_assert!((into - out_of).abs() < 1e-7, "{into}, {out_of}");
    }

    /// A thinner inside behaves as the back of a denser one.
    #[test]
    fn glass_turned_around_is_its_inverse(n in direction(), camera in above(), eta in 1.0001..3.0_f64, lobe in 0.0..1.0_f64) {
        let to_camera = direction_before(n, camera);
        let sample = |n, eta| Bsdf::Dielectric { eta }.sample(&SurfacePoint::with_normal(n), to_camera, DVec2::ZERO, lobe).expect("glass scatters all");
        let (a, b) = (sample(n, 1.0 / eta), sample(-n, eta));
        prop_assert!((a.direction - b.direction).length() < ROUNDING && (a.weight - b.weight).length() < ROUNDING);
    }
}

/// ∫ f_r cos dω = albedo and ∫ pdf dω = 1, by the midpoint rule.
#[test]
fn diffuse_energy_is_the_albedo() {
    const STEPS: usize = 1000;
    let n = DVec3::new(0.48, -0.6, 0.64);
    let to_camera = direction_before(n, (0.3, 0.7));
    let ring = 2.0 * PI * 2.0 / STEPS as f64;
    let (mut energy, mut probability) = (Colour::ZERO, 0.0);
    for i in 0..STEPS {
        let height = -1.0 + (i as f64 + 0.5) * 2.0 / STEPS as f64;
        let to_light = direction_before(n, (height, 0.2));
        energy += DIFFUSE.eval(&SurfacePoint::with_normal(n), to_camera, to_light) * height.abs() * ring;
        probability += DIFFUSE.pdf(&SurfacePoint::with_normal(n), to_camera, to_light) * ring;
    }
    assert!((energy - ALBEDO).length() < ROUNDING && (probability - 1.0).abs() < ROUNDING, "{energy}, {probability}");
}

/// ((η − 1)/(η + 1))² straight through, nothing polarised in the plane at Brewster's angle, all at grazing.
#[test]
fn glass_has_the_textbook_reflectances() {
    let reflectance = |cosine: f64, eta: f64| {
        let to_camera = direction_before(DVec3::Z, (cosine, 0.1));
        Bsdf::Dielectric { eta }.eval_or_weight(&SurfacePoint::with_normal(DVec3::Z), to_camera, to_camera).x
    };
    assert!((reflectance(1.0, 1.5) - 0.04).abs() < ROUNDING);
    assert!((reflectance(1e-14, 1.5) - 1.0).abs() < ROUNDING);
    let brewster = 1.5_f64.atan();
    let s = (2.0 * brewster - 0.5 * PI).sin();
    assert!((reflectance(brewster.cos(), 1.5) - 0.5 * s * s).abs() < ROUNDING);
    assert!(reflectance(0.4, 1.0).abs() < ROUNDING, "no interface");
}
