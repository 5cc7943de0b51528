//! BSDFs for light that travels the other way: sampled from the side of the light, `weight · eta_squared` is f·cos/pdf of importance.

use super::rough::{METAL, glass, index, metal};
use super::{direction, direction_before, unit_square};
use proptest::prelude::*;
use volgrad::math::{Colour, DVec2, DVec3};
use volgrad::scene::{Bsdf, Reflector, SurfacePoint};

const ALBEDO: Colour = Colour::new(0.8, 0.5, 0.3);

/// Cosine and turn, from either side and not grazing: there half vectors lose digits.
fn either_side() -> impl Strategy<Value = (f64, f64)> {
    (prop_oneof![0.1..0.999_f64, -0.999..-0.1_f64], 0.0..1.0_f64)
}

/// f(from the direction sampled, to the light)·cos/pdf: radiance that comes from `light` and goes to `l`.
fn adjoint(bsdf: &Bsdf, n: DVec3, light: DVec3, l: DVec3) -> Colour {
    bsdf.eval(&SurfacePoint::with_normal(n), l, light) * n.dot(l).abs() / bsdf.pdf(&SurfacePoint::with_normal(n), light, l)
}

proptest! {
    #[test]
    fn weights_of_importance(n in direction(), light in either_side(), u in unit_square(), lobe in 0.0..1.0_f64, alpha in 0.1..1.2_f64, eta in index()) {
        let light = direction_before(n, light);
        let diffuse = Bsdf::Diffuse { albedo: ALBEDO };
        for bsdf in [diffuse, Bsdf::TwoSided(Reflector::Diffuse { albedo: ALBEDO }), metal(METAL, alpha), glass(eta, alpha)] {
            let Some(sample) = bsdf.sample(&SurfacePoint::with_normal(n), light, u, lobe) else { continue };
            if n.dot(sample.direction).abs() < 0.05 {
                continue;
            }
            let (found, expected) = (sample.weight * sample.eta_squared, adjoint(&bsdf, n, light, sample.direction));
            prop_assert!((found - expected).length() < 1e-9 * expected.length(), "{bsdf:?}: {found}, {expected}");
        }
    }

    /// Smooth glass scales no importance. In terms of f_r without its delta factor there is a second η²: the factor of a ray's solid angle,
    /// which is the direction's before and its successor's behind the surface.
    #[test]
    fn smooth_glass_scales_no_importance(n in direction(), light in either_side(), lobe in 0.0..1.0_f64, eta in index()) {
        let light = direction_before(n, light);
        let bsdf = Bsdf::Dielectric { eta };
        let sample = bsdf.sample(&SurfacePoint::with_normal(n), light, DVec2::ZERO, lobe).expect("a direction");
        prop_assert!((sample.weight * sample.eta_squared - Colour::ONE).length() < 1e-12);
        let reflectance = bsdf.eval_or_weight(&SurfacePoint::with_normal(n), light, light).x;
        let passed = n.dot(light) * n.dot(sample.direction) < 0.0;
        let probability = if passed { 1.0 - reflectance } else { reflectance };
        let value = bsdf.eval_or_weight(&SurfacePoint::with_normal(n), sample.direction, light) / probability;
        prop_assert!((value - sample.weight * sample.eta_squared * sample.eta_squared).length() < 1e-7, "{value}");
    }

    /// The limit of rough glass, of which f_r is known without reference to smooth glass.
    #[test]
    fn hardly_rough_glass_scales_no_importance(n in direction(), light in either_side(), u in (0.1..0.9_f64, 0.0..1.0_f64), lobe in 0.0..1.0_f64, eta in index()) {
        let light = direction_before(n, light);
        let bsdf = glass(eta, 1e-3);
        let Some(sample) = bsdf.sample(&SurfacePoint::with_normal(n), light, DVec2::from(u), lobe) else { return Ok(()) };
        prop_assume!(n.dot(sample.direction).abs() > 0.1);
        let found = adjoint(&bsdf, n, light, sample.direction);
        prop_assert!((found - Colour::ONE).length() < 1e-3, "{found}");
    }

    #[test]
    fn metals_are_their_own_adjoints(n in direction(), light in either_side(), lobe in 0.0..1.0_f64) {
        let light = direction_before(n, light);
        for bsdf in [Bsdf::Conductor(METAL), Bsdf::Mirror { reflectance: ALBEDO }, Bsdf::TwoSided(Reflector::Conductor(METAL))] {
            let Some(sample) = bsdf.sample(&SurfacePoint::with_normal(n), light, DVec2::ZERO, lobe) else { continue };
            let value = bsdf.eval_or_weight(&SurfacePoint::with_normal(n), sample.direction, light);
            prop_assert!((sample.weight * sample.eta_squared - value).length() < 1e-9, "{bsdf:?}: {value}");
        }
    }
}
