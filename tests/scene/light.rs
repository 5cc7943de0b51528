//! Points on lights: on their surface, with its normal, at the stated density; and lights picked as often as stated.

use super::{ROUNDING, unit_square};
use crate::reference::differences::derivative;
use proptest::prelude::*;
use std::f64::consts::PI;
use volgrad::math::{Colour, DVec2, DVec3};
use volgrad::scene::{Light, LightSample, Lights, leave_constant_sky_to_chance};

const CORNER: DVec3 = DVec3::new(1.0, 2.0, -0.5);
const EDGE_U: DVec3 = DVec3::new(0.5, 0.2, 0.1);
const EDGE_V: DVec3 = DVec3::new(-0.3, 0.9, 0.4);
const RADIUS: f64 = 0.7;
const COLOUR: Colour = Colour::new(3.0, 2.0, 1.0);

const PARALLELOGRAM: Light = Light::Parallelogram { corner: CORNER, edge_u: EDGE_U, edge_v: EDGE_V, radiance: COLOUR };
const TRIANGLE: Light = Light::Triangle { corner: CORNER, edge_u: EDGE_U, edge_v: EDGE_V, radiance: COLOUR };
const SPHERE: Light = Light::Sphere { centre: CORNER, radius: RADIUS, radiance: COLOUR };

/// A sampled point with normal and density.
fn point(light: Light, u: DVec2) -> (DVec3, DVec3, f64) {
    match light.sample(u) {
        LightSample::Point { position, normal: Some(normal), pdf } => (position, normal, pdf),
        other => panic!("{other:?} from an area light"),
    }
}

/// (a, b) with x = corner + a·edge_u + b·edge_v, and the distance of x from that plane.
fn in_edges(x: DVec3) -> (f64, f64, f64) {
    let (v, n) = (x - CORNER, EDGE_U.cross(EDGE_V));
    let n2 = n.length_squared();
    (v.cross(EDGE_V).dot(n) / n2, EDGE_U.cross(v).dot(n) / n2, v.dot(n) / n2.sqrt())
}

#[test]
fn densities_are_one_over_the_areas() {
    let (u2, v2, uv) = (EDGE_U.length_squared(), EDGE_V.length_squared(), EDGE_U.dot(EDGE_V));
    let parallelogram = (u2 * v2 - uv * uv).sqrt();
    for (light, area) in [(PARALLELOGRAM, parallelogram), (TRIANGLE, 0.5 * parallelogram), (SPHERE, 4.0 * PI * RADIUS * RADIUS)]
    {
        assert!((light.area_pdf() * area - 1.0).abs() < ROUNDING, "{light:?}");
        assert_eq!(light.emission(DVec3::Z), COLOUR);
    }
}

proptest! {
    #[test]
    fn points_are_on_the_light_with_its_normal(u in unit_square()) {
        let n = EDGE_U.cross(EDGE_V).normalize();
        for light in [PARALLELOGRAM, TRIANGLE] {
            let (x, normal, pdf) = point(light, u);
            let (a, b, off) = in_edges(x);
            let unit = -ROUNDING..=1.0 + ROUNDING;
            prop_assert!(unit.contains(&a) && unit.contains(&b) && off.abs() < ROUNDING, "{a}, {b}, {off}");
            prop_assert!(matches!(light, Light::Parallelogram { .. }) || unit.contains(&(a + b)), "{a} + {b}");
            prop_assert!((normal - n).length() < ROUNDING, "the side that edge_u × edge_v points to");
            prop_assert_eq!(pdf, light.area_pdf());
        }
        let (x, normal, pdf) = point(SPHERE, u);
        prop_assert!(((x - CORNER) - RADIUS * normal).length() < ROUNDING && (normal.length() - 1.0).abs() < ROUNDING);
        prop_assert_eq!(pdf, SPHERE.area_pdf());
    }

    /// The area that the map from the unit square gives to du₁du₂, by differences, times the density is 1 everywhere.
    #[test]
    fn points_are_spread_evenly(u in (0.01..0.99_f64, 0.01..0.99_f64)) {
        for light in [PARALLELOGRAM, TRIANGLE, SPHERE] {
            let at = |dx: f64, dy: f64| point(light, DVec2::new(u.0 + dx, u.1 + dy)).0.to_array();
            let along_x = DVec3::from_array(derivative(|h| at(h, 0.0)));
            let along_y = DVec3::from_array(derivative(|h| at(0.0, h)));
            let area = along_x.cross(along_y).length();
            prop_assert!((area * light.area_pdf() - 1.0).abs() < 1e-7, "{light:?}: {area}");
        }
    }
}

/// No two numbers share a point, and no part of the light is left out: the corners of the square go to its extremes.
#[test]
fn the_whole_light_is_reached() {
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(DVec2::from);
    let farthest = |light: Light, towards: DVec3| {
        corners.iter().map(|u| (point(light, *u).0 - CORNER).dot(towards)).fold(f64::NEG_INFINITY, f64::max)
    };
    let n = EDGE_U.cross(EDGE_V);
    let ([across_u, across_v], both) = ([EDGE_V.cross(n), n.cross(EDGE_U)], n.length_squared());
    for light in [PARALLELOGRAM, TRIANGLE] {
        for across in [across_u, across_v] {
            assert!((farthest(light, across) - both).abs() < ROUNDING, "{light:?}");
        }
    }
    for z in [DVec3::Z, -DVec3::Z] {
        assert!((farthest(SPHERE, z) - RADIUS).abs() < ROUNDING);
    }
}

#[test]
fn lights_without_area_have_no_density_over_it() {
    let sun = Light::Directional { direction: -DVec3::Y, irradiance: COLOUR };
    let lamp = Light::Point { position: CORNER, intensity: COLOUR };
    let sky = Light::Environment { radiance: COLOUR };
    for light in [sun, lamp, sky] {
        assert_eq!((light.area_pdf(), light.emission(DVec3::Z)), (0.0, COLOUR));
    }
    let u = DVec2::splat(0.3);
    assert!(matches!(sun.sample(u), LightSample::Direction { to_light: DVec3::Y }), "against the way that the light travels");
    assert!(matches!(lamp.sample(u), LightSample::Point { position: CORNER, normal: None, pdf: 1.0 }));
    assert!(matches!(sky.sample(u), LightSample::AnyDirection));
}

/// A million equally spaced numbers: each light as often as its probability says, one of probability 0 never.
#[test]
fn lights_are_picked_as_often_as_stated() {
    let lights = [PARALLELOGRAM, TRIANGLE, SPHERE, PARALLELOGRAM];
    let expected = [0.125, 0.0, 0.5, 0.375];
    let lights = Lights { lights: &lights, cdf: &[0.125, 0.125, 0.625, 1.0], media: &[], guides: &[], environment: None };
    let mut counts = [0; 4];
    const NUMBERS: u32 = 1 << 20;
    for n in 0..NUMBERS {
        let (index, light, rest) = lights.pick(f64::from(n) / f64::from(NUMBERS)).expect("any u < 1 picks one");
        assert!(lights.get(index).is_some_and(|same| std::ptr::eq(light, same)));
        let before = lights.cdf[index as usize] - lights.probability(index);
        assert!((before + rest * lights.probability(index) - f64::from(n) / f64::from(NUMBERS)).abs() < ROUNDING);
        counts[index as usize] += 1;
    }
    for i in 0..4 {
        assert_eq!(lights.probability(i), expected[i as usize]);
        assert_eq!(f64::from(counts[i as usize]), expected[i as usize] * f64::from(NUMBERS));
    }
    assert!(lights.pick(1.0 - f64::EPSILON / 2.0).is_some_and(|(index, ..)| index == 3), "the largest number below 1");
    assert!(lights.probability(4) == 0.0 && lights.get(4).is_none());
    assert!(Lights::default().pick(0.5).is_none(), "a scene without lights");
}

/// Beside a light with a weight a constant sky has none; alone, or beside lights without one, it keeps its own.
#[test]
fn a_constant_sky_is_picked_only_if_it_is_alone() {
    let sky = Light::Environment { radiance: COLOUR };
    for (lights, before, after) in [
        (&[sky][..], &[0.5][..], &[0.5][..]),
        (&[SPHERE, sky], &[0.2, 0.7], &[0.2, 0.0]),
        (&[sky, SPHERE], &[0.7, 0.0], &[0.7, 0.0]),
        (&[SPHERE, TRIANGLE], &[0.2, 0.7], &[0.2, 0.7]),
    ] {
        let mut weights = before.to_vec();
        leave_constant_sky_to_chance(lights, &mut weights);
        assert_eq!(weights, after);
    }
}
