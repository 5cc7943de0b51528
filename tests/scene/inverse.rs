//! What is sampled from numbers can be turned back into them: u → sample → u, and sample → u → sample.
//!
//! Numbers keep off the borders of the unit square, where turns wrap around and square roots lose half of the digits.

use super::environment_map::Map;
use super::rough::{METAL, index};
use super::{direction, direction_before};
use proptest::prelude::*;
use volgrad::math::{Colour, DVec2, DVec3, disk_number, uniform_disk};
use volgrad::scene::{
    Bsdf, Camera, Falloff, Ggx, Light, LightSample, Lights, Reflector, RoughConductor, RoughDielectric, SurfacePoint,
    accumulate,
};

const TOLERANCE: f64 = 1e-9;

fn numbers() -> impl Strategy<Value = DVec2> {
    (0.001..0.999_f64, 0.001..0.999_f64).prop_map(DVec2::from)
}

/// On either side of a surface, not grazing.
fn either_side() -> impl Strategy<Value = (f64, f64)> {
    (prop_oneof![0.05..0.999_f64, -0.999..-0.05_f64], 0.0..1.0_f64)
}

fn rough(eta: f64, alpha: f64) -> [Bsdf<'static>; 5] {
    let (ggx, conductor, albedo) = (Ggx { alpha }, METAL, Colour::splat(0.5));
    let metal = RoughConductor { conductor, ggx };
    [
        Bsdf::Diffuse { albedo },
        Bsdf::RoughConductor(metal),
        Bsdf::RoughDielectric(RoughDielectric { eta, ggx }),
        Bsdf::TwoSided(Reflector::Diffuse { albedo }),
        Bsdf::TwoSided(Reflector::RoughConductor(metal)),
    ]
}

fn smooth(eta: f64) -> [Bsdf<'static>; 4] {
    let reflectance = Colour::splat(0.5);
    [
        Bsdf::Mirror { reflectance },
        Bsdf::Conductor(METAL),
        Bsdf::Dielectric { eta },
        Bsdf::TwoSided(Reflector::Mirror { reflectance }),
    ]
}

proptest! {
    #[test]
    fn numbers_survive_rough_surfaces(n in direction(), camera in either_side(), u in numbers(), lobe in 0.0..1.0_f64, alpha in 0.05..1.2_f64, eta in index()) {
        let c = direction_before(n, camera);
        for bsdf in rough(eta, alpha) {
            let Some(sample) = bsdf.sample(&SurfacePoint::with_normal(n), c, u, lobe) else { continue };
            // Half vectors of grazing directions lose digits.
            if n.dot(sample.direction).abs() < 0.01 {
                continue;
            }
            let (found, same_lobe) = bsdf.invert(n, c, sample.direction).expect("what was sampled");
            prop_assert!((uniform_disk(found) - uniform_disk(u)).length() < TOLERANCE / alpha, "{bsdf:?}: {u}, {found}");
            let again = bsdf.sample(&SurfacePoint::with_normal(n), c, u, same_lobe).expect("the same lobe");
            prop_assert!(again.direction == sample.direction, "{bsdf:?}");
        }
    }

    /// And what has no density has no numbers.
    #[test]
    fn directions_survive_rough_surfaces(n in direction(), camera in either_side(), light in either_side(), alpha in 0.05..1.2_f64, eta in index()) {
        let (c, l) = (direction_before(n, camera), direction_before(n, light));
        for bsdf in rough(eta, alpha) {
            match bsdf.invert(n, c, l) {
                Some((u, lobe)) => {
                    prop_assert!(bsdf.pdf(&SurfacePoint::with_normal(n), c, l) > 0.0, "{bsdf:?}");
                    let sample = bsdf.sample(&SurfacePoint::with_normal(n), c, u, lobe).expect("a direction");
                    prop_assert!((sample.direction - l).length() < TOLERANCE / alpha, "{bsdf:?}: {} for {l}", sample.direction);
                }
                None => prop_assert_eq!(bsdf.pdf(&SurfacePoint::with_normal(n), c, l), 0.0),
            }
        }
    }

    /// Both lobes, and total reflection, which leaves one.
    #[test]
    fn smooth_surfaces_find_their_lobe(n in direction(), camera in either_side(), lobe in 0.0..1.0_f64, eta in index()) {
        let c = direction_before(n, camera);
        for bsdf in smooth(eta) {
            let sample = bsdf.sample(&SurfacePoint::with_normal(n), c, DVec2::ZERO, lobe);
            let Some(sample) = sample else {
                prop_assert!(bsdf.invert(n, c, c).is_none() && bsdf.invert(n, c, -c).is_none(), "{bsdf:?} from behind");
                continue;
            };
            let (u, found) = bsdf.invert(n, c, sample.direction).expect("what was sampled");
            prop_assert!(u == DVec2::splat(0.5) && (0.0..1.0).contains(&found));
            let again = bsdf.sample(&SurfacePoint::with_normal(n), c, u, found).expect("the same lobe");
            prop_assert!(again.direction == sample.direction && again.eta_squared == sample.eta_squared, "{bsdf:?}");
            let passed = n.dot(c) * n.dot(sample.direction) < 0.0;
            prop_assert!(bsdf.transmits() || (!passed && bsdf.invert(n, c, -sample.direction).is_none()));
            let value = bsdf.eval_or_weight(&SurfacePoint::with_normal(n), c, c).x;
            if bsdf.transmits() {
                let middle = if passed { 0.5 * (value + 1.0) } else { 0.5 * value };
                prop_assert!((found - middle).abs() < TOLERANCE, "the middle of the lobe");
            }
        }
    }

    #[test]
    fn numbers_survive_disks(u in numbers()) {
        prop_assert!((disk_number(uniform_disk(u)) - u).length() < TOLERANCE);
        let lens = Camera { lens_radius: 0.4, ..pinhole() };
        prop_assert!((lens.lens_number(lens.lens_point(u)) - u).length() < TOLERANCE);
        prop_assert_eq!(pinhole().lens_number(pinhole().lens_point(u)), DVec2::splat(0.5));
    }

    #[test]
    fn numbers_survive_positions_on_lights(u in numbers(), v in numbers()) {
        let at = |light: &Light, u: DVec2| match light.sample(u) {
            LightSample::Point { position, normal, .. } => (position, normal),
            other => panic!("{other:?}"),
        };
        for light in &near_lights(DVec3::Z) {
            let (position, normal) = at(light, u);
            let found = light.invert_position(position);
            if normal.is_some() {
                prop_assert!((found - u).length() < TOLERANCE, "{light:?}: {u}, {found}");
            } else {
                prop_assert_eq!(found, DVec2::splat(0.5));
            }
            let (direction, _) = light.sample_direction(normal, v).expect("a direction");
            let found = light.invert_direction(normal, direction).expect("what was sampled");
            prop_assert!((found - v).length() < TOLERANCE, "{light:?}: {v}, {found}");
        }
    }

    /// And none where there is no density.
    #[test]
    fn directions_from_lights_survive(axis in direction(), w in direction()) {
        for light in &near_lights(axis) {
            let normal = (light.area_pdf() > 0.0).then_some(axis);
            match light.invert_direction(normal, w) {
                Some(u) => {
                    let (again, _) = light.sample_direction(normal, u).expect("a direction");
                    prop_assert!((again - w).length() < 1e-7, "{light:?}: {again} for {w}");
                }
                None => prop_assert_eq!(light.direction_density(normal, w), 0.0),
            }
        }
    }

    #[test]
    fn numbers_survive_light_from_far_away(u in numbers(), w in direction()) {
        let map = Map::random([7, 5], 3);
        for light in [Light::Environment { radiance: Colour::ONE }, map.light()] {
            let (to_light, _) = light.sample_far(u).expect("a direction");
            let found = light.invert_far(to_light).expect("what was sampled");
            prop_assert!((found - u).length() < 1e-8, "{light:?}: {u}, {found}");
            match light.invert_far(w) {
                Some(u) => {
                    let (again, _) = light.sample_far(u).expect("a direction");
                    prop_assert!((again - w).length() < 1e-7, "{light:?}: {again} for {w}");
                }
                None => prop_assert_eq!(light.far_density(w), 0.0),
            }
        }
        for light in near_lights(DVec3::Z) {
            prop_assert!(light.invert_far(w).is_none());
        }
    }

    #[test]
    fn numbers_survive_the_pick_of_a_light(u in 0.0..1.0_f64, rest in 0.0..=1.0_f64) {
        let lights = near_lights(DVec3::Z);
        let lights = Lights { lights: &lights[..4], cdf: &[0.0, 0.1, 0.1, 1.0], media: &[], guides: &[], environment: None };
        let (index, _, left) = lights.pick(u).expect("a light");
        prop_assert!((lights.number(index, left).expect("it is picked") - u).abs() < TOLERANCE);
        for index in 0..5 {
            let Some(number) = lights.number(index, rest) else {
                prop_assert_eq!(lights.probability(index), 0.0);
                continue;
            };
            let (again, _, left) = lights.pick(number).expect("a light");
            prop_assert!(again == index && (left - rest).abs() < TOLERANCE);
        }
    }

    /// Where the shares of elements meet, the inverse keeps to its own.
    #[test]
    fn the_ends_of_a_share_belong_to_it(mut weights in prop::array::uniform4(0.0..1.0_f64)) {
        accumulate(&mut weights);
        let lights = near_lights(DVec3::Z);
        let lights = Lights { lights: &lights[..4], cdf: &weights, media: &[], guides: &[], environment: None };
        for index in 0..4 {
            for rest in [0.0, 1.0] {
                let number = lights.number(index, rest).expect("it is picked");
                prop_assert_eq!(lights.pick(number).map(|(index, ..)| index), Some(index));
            }
        }
    }
}

/// Beyond the critical angle nothing is refracted, and an interface between equals reflects nothing.
#[test]
fn lobes_that_do_not_exist_have_no_numbers() {
    let c = direction_before(DVec3::Z, (-0.3, 0.2));
    let (reflected, refracted) = (DVec3::new(-c.x, -c.y, c.z), direction_before(DVec3::Z, (0.4, 0.7)));
    let glass = Bsdf::Dielectric { eta: 1.5 };
    assert!(glass.invert(DVec3::Z, c, reflected).is_some() && glass.invert(DVec3::Z, c, refracted).is_none());
    let nothing = Bsdf::Dielectric { eta: 1.0 };
    assert!(nothing.invert(DVec3::Z, DVec3::Z, DVec3::Z).is_none() && nothing.invert(DVec3::Z, DVec3::Z, -DVec3::Z).is_some());
}

/// Straight at the corners of a light, and at the poles.
#[test]
fn extreme_points_have_numbers() {
    for light in &near_lights(DVec3::Z)[..3] {
        for u in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(DVec2::from) {
            let at = |u: DVec2| match light.sample(u) {
                LightSample::Point { position, .. } => position,
                other => panic!("{other:?}"),
            };
            let found = light.invert_position(at(u));
            assert!(found.min_element() >= 0.0 && found.max_element() <= 1.0, "{light:?}: {found}");
            // The square root of the rounding of a cosine.
            assert!((at(found) - at(u)).length() < 1e-7, "{light:?}: {u}, {found}");
        }
    }
}

/// Area lights first.
fn near_lights(axis: DVec3) -> [Light<'static>; 5] {
    let (corner, edge_u, edge_v) = (DVec3::new(1.0, 2.0, -0.5), DVec3::new(0.5, 0.2, 0.1), DVec3::new(-0.3, 0.9, 0.4));
    let (position, intensity) = (corner, Colour::ONE);
    [
        Light::Parallelogram { corner, edge_u, edge_v, radiance: Colour::ONE },
        Light::Triangle { corner, edge_u, edge_v, radiance: Colour::ONE },
        Light::Sphere { centre: corner, radius: 0.7, radiance: Colour::ONE },
        Light::Point { position, intensity },
        Light::Spot { position, axis, intensity, falloff: Falloff::new(0.9, 0.3) },
    ]
}

fn pinhole() -> Camera {
    Camera {
        position: DVec3::ZERO,
        forward: DVec3::Z,
        right: DVec3::X,
        up: DVec3::Y,
        tan_half_fov_x: 1.0,
        width: 8,
        height: 8,
        crop: [0, 0, 8, 8],
        near_clip: 0.0,
        medium: volgrad::medium::NONE,
        lens_radius: 0.0,
        focal_distance: 1.0,
    }
}
