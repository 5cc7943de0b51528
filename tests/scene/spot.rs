//! Spot lights: all within a cone, nothing outside a wider one, straight between them in the angle.

use super::{ROUNDING, direction, direction_before};
use crate::reference::differences::gradient;
use proptest::prelude::*;
use std::f64::consts::PI;
use volgrad::math::{Colour, DVec2, DVec3};
use volgrad::scene::{Falloff, Light, LightSample};

const INTENSITY: Colour = Colour::new(3.0, 2.0, 1.0);
const POSITION: DVec3 = DVec3::new(1.0, 2.0, -0.5);

fn spot(axis: DVec3, inner: f64, outer: f64) -> Light<'static> {
    Light::Spot { position: POSITION, axis, intensity: INTENSITY, falloff: Falloff::new(inner.cos(), outer.cos()) }
}

proptest! {
    #[test]
    fn falls_off_linearly_in_the_angle(axis in direction(), outer in 0.05..3.1_f64, share in 0.05..0.95_f64, at in 0.01..0.99_f64, turn in 0.0..1.0_f64) {
        let inner = share * outer;
        let light = spot(axis, inner, outer);
        let emitted = |angle: f64| light.emission(direction_before(axis, (angle.cos(), turn)));
        prop_assert_eq!(emitted(at * inner), INTENSITY);
        prop_assert_eq!(emitted(outer + at * (PI - outer)), Colour::ZERO);
        let between = emitted(inner + at * (outer - inner));
        prop_assert!((between - INTENSITY * (1.0 - at)).length() < 1e-9 / (outer - inner), "{between}");
    }

    /// Against differences; and 0 where nothing changes.
    #[test]
    fn log_gradient_is_that_of_the_emission(axis in direction(), outer in 0.3..2.8_f64, share in 0.1..0.8_f64, at in 0.1..0.8_f64, turn in 0.0..1.0_f64) {
        let inner = share * outer;
        let light = spot(axis, inner, outer);
        let towards = |angle: f64| direction_before(axis, (angle.cos(), turn));
        let omega = towards(inner + at * (outer - inner));
        let expected = gradient(|w| light.emission(DVec3::from_array(w).normalize()).to_array().map(f64::ln), omega.to_array());
        let found = light.log_gradient(omega).expect("built in");
        for (found, expected) in found.into_iter().zip(expected) {
            let tangent = found - found.dot(omega) * omega;
            prop_assert!((tangent - DVec3::from_array(expected)).length() < 1e-6 * (1.0 + tangent.length()), "{tangent}, {expected:?}");
        }
        prop_assert_eq!(light.log_gradient(towards(0.5 * inner)), Some([DVec3::ZERO; 3]));
        prop_assert_eq!(light.log_gradient(towards(outer + 0.1)), Some([DVec3::ZERO; 3]));
    }
}

#[test]
fn equal_cones_have_a_sharp_edge() {
    let light = spot(DVec3::Z, 0.5, 0.5);
    let towards = |angle: f64| direction_before(DVec3::Z, (angle.cos(), 0.3));
    assert_eq!((light.emission(towards(0.4999)), light.emission(towards(0.5001))), (INTENSITY, Colour::ZERO));
    assert_eq!(light.log_gradient(towards(0.5)), Some([DVec3::ZERO; 3]));
}

#[test]
fn is_sampled_as_a_point() {
    let light = spot(DVec3::Z, 0.2, 0.5);
    assert!(matches!(light.sample(DVec2::splat(0.3)), LightSample::Point { position: POSITION, normal: None, pdf: 1.0 }));
    assert!(light.area_pdf() == 0.0 && light.direction_pdf(DVec3::Z) == 0.0 && !light.is_environment());
    assert!((light.emission(DVec3::Z) - INTENSITY).length() < ROUNDING);
}
