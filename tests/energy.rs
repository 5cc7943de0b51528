//! Whole light transport: the furnace, in which every radiance is 1 whatever the media, and multiple importance sampling, whose
//! result does not depend on how often a light is picked.
//!
//! Significance: |z| < 4 for each of some 20 image means: a new seed trips one with probability 0.13 % if all is right. Seeds are
//! fixed. The standard error of the furnace's 1 is asserted to be below 0.1 %, with VOLGRAD_LONG below 0.025 %.

mod toy;

use toy::estimate::{Estimate, scale};
use toy::scenes::{World, camera, edges_under_area_lights, environment_map, grid, homogeneous, rectangle};
use volgrad::math::{Colour, DVec3};
use volgrad::medium::Medium;
use volgrad::sampler;
use volgrad::scene::{Bsdf, Conductor, Falloff, Ggx, Light, Reflector, RoughConductor, RoughDielectric};
use volgrad::shift::{self, Kernel, Mode, Radius};

const WHITE: [f64; 3] = [1.0; 3];

/// Nothing absorbs, and radiance 1 comes from everywhere.
fn furnace(medium: Medium<'static>) -> World {
    World::new(camera([0.1, 0.05, -2.5], 0.4, 4))
        .medium([-1.0; 3], [1.0; 3], medium)
        .light(Light::Environment { radiance: Colour::ONE }, 1.0)
}

fn white_grid() -> Medium<'static> {
    let density = grid([-0.9, -1.0, -0.8], [0.8, 1.0, 1.0], [4, 5, 3], |[x, y, z]| ((x * 3 + y * 5 + z * 2) % 4) as f32);
    Medium { density, ..homogeneous([0.9, 0.7, 1.1], WHITE, 0.5) }
}

fn options(max_depth: u32, shift: Option<shift::Options>) -> sampler::Options {
    sampler::Options {
        max_depth,
        rr_depth: 4,
        seed: 23,
        shift,
        left_out: volgrad::sampler::Lengths::NONE,
        first: volgrad::sampler::FirstVertices::ALL,
    }
}

fn assert_furnace(name: &str, world: &World, passes: u64, shift: Option<shift::Options>) {
    // Without absorption only the roulette ends a path: 0.95^500 is nothing.
    let estimate = Estimate::of_path_tracer(world, options(500, shift), passes * scale());
    for channel in 0..3 {
        let mean = estimate.channel(channel);
        println!("{name}, channel {channel}: {:.5} ± {:.5}, z {:+.2}", mean.value, mean.error, mean.z_to(1.0));
        let enough = if scale() > 1 { 2.5e-4 } else { 1e-3 };
        assert!(mean.error < enough && mean.z_to(1.0).abs() < 4.0);
    }
}

#[test]
fn furnace_with_a_chromatic_medium() {
    assert_furnace("homogeneous", &furnace(homogeneous([0.8, 1.0, 1.3], WHITE, 0.4)), 1024, None);
}

#[test]
fn furnace_with_a_grid() {
    assert_furnace("grid", &furnace(white_grid()), 1024, None);
}

/// Walls that reflect everything, white and mirrors, back to back because only a front reflects.
#[test]
fn furnace_with_walls() {
    let (across, up) = ([1.2, 0.0, 0.0], [0.0, 1.2, 0.0]);
    let white = Bsdf::Diffuse { albedo: Colour::ONE };
    let mirror = Bsdf::Mirror { reflectance: Colour::ONE };
    let world = furnace(homogeneous([0.8, 1.0, 1.3], WHITE, -0.3))
        .surface(rectangle([-0.8, -0.8, 0.5], up, across), white)
        .surface(rectangle([-0.8, -0.8, 0.5001], across, up), white)
        .surface(rectangle([0.3, -0.6, -0.6], [0.0, 1.2, 0.2], [0.6, 0.0, 0.0]), mirror)
        .surface(rectangle([0.3, -0.6, -0.5999], [0.6, 0.0, 0.0], [0.0, 1.2, 0.2]), mirror);
    assert_furnace("walls", &world, 1536, None);
}

#[test]
fn furnace_with_shifts() {
    for (mode, kernel) in [(Mode::Exact, Kernel::Disk(Radius::Pixels(1.0))), (Mode::Exchangeable, Kernel::Ball(0.3))] {
        let shift = Some(shift::Options::new(mode, kernel, 3));
        assert_furnace(&format!("{mode:?}"), &furnace(white_grid()), 1024, shift);
    }
}

/// An estimate with lights picked with some weight against one without.
fn assert_same_total(weight: f64, other: &Estimate, never: &Estimate) {
    let (a, b) = (other.total(), never.total());
    let z = (a.value - b.value) / a.error.hypot(b.error);
    println!("weight {weight}: {:.5} ± {:.5} against {:.5} ± {:.5}, z {z:+.2}", a.value, a.error, b.value, b.error);
    assert!(z.abs() < 4.0);
}

/// A light that is rarely or never picked is found by chance instead, with the weight that next-event estimation leaves.
#[test]
fn how_often_a_light_is_picked_changes_nothing() {
    // A large panel, found by chance often enough; beside it a light without emission takes the picks.
    let world = |weight: f64| {
        let fog = homogeneous([0.6, 0.9, 1.4], [0.9, 0.8, 0.7], 0.3);
        World::new(camera([0.0, 0.0, -2.0], 0.5, 4))
            .medium([-1.5; 3], [1.5; 3], fog)
            .surface(
                rectangle([-2.0, -1.2, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]),
                Bsdf::Diffuse { albedo: Colour::splat(0.5) },
            )
            .area_light([-1.5, 1.3, -1.5], [3.0, 0.0, 0.0], [0.0, 0.0, 3.0], 1.0, weight)
            .light(Light::Environment { radiance: Colour::splat(0.3) }, weight)
            .light(Light::Point { position: DVec3::new(0.0, 9.0, 0.0), intensity: Colour::ZERO }, 1.0)
    };
    let estimate = |weight| Estimate::of_path_tracer(&world(weight), options(5, None), 1024 * scale());
    let never = estimate(0.0);
    for weight in [0.05, 1.0, 50.0] {
        assert_same_total(weight, &estimate(weight), &never);
    }
}

/// Rough and two-sided surfaces under area lights and a sky: next-event estimation and going on agree, whether shifted or not.
#[test]
fn how_often_a_light_is_picked_changes_nothing_on_rough_surfaces() {
    let ggx = Ggx { alpha: 0.3 };
    let conductor = Conductor { eta: Colour::splat(0.2), k: Colour::new(3.9, 2.4, 2.2), reflectance: Colour::ONE };
    let world = |weight: f64| {
        let fog = homogeneous([0.3, 0.4, 0.5], [0.9, 0.8, 0.7], 0.3);
        World::new(camera([0.0, 0.0, -2.0], 0.5, 4))
            .medium([-1.5; 3], [1.5; 3], fog)
            .surface(
                rectangle([-2.0, -1.2, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]),
                Bsdf::RoughConductor(RoughConductor { conductor, ggx }),
            )
            .surface(
                rectangle([-1.2, -1.0, 0.4], [1.0, 0.0, 0.3], [0.0, 2.0, 0.0]),
                Bsdf::RoughDielectric(RoughDielectric { eta: 1.5, ggx }),
            )
            .surface(
                rectangle([0.3, -1.0, 0.2], [1.0, 0.0, 0.3], [0.0, 2.0, 0.0]),
                Bsdf::TwoSided(Reflector::Diffuse { albedo: Colour::splat(0.7) }),
            )
            .area_light([-1.5, 1.3, -1.5], [3.0, 0.0, 0.0], [0.0, 0.0, 3.0], 1.0, weight)
            .light(Light::Environment { radiance: Colour::splat(0.3) }, weight)
            .light(Light::Point { position: DVec3::new(0.0, 9.0, 0.0), intensity: Colour::ZERO }, 1.0)
    };
    let shift = shift::Options::new(Mode::Exact, Kernel::Disk(Radius::Pixels(1.0)), 3);
    let estimate = |weight, shift| Estimate::of_path_tracer(&world(weight), options(5, shift), 512 * scale());
    let never = estimate(0.0, None);
    let often = estimate(50.0, None);
    for (weight, other) in [(1.0, &estimate(1.0, None)), (50.0, &often)] {
        let (a, b) = (other.total(), never.total());
        let z = (a.value - b.value) / a.error.hypot(b.error);
        println!("weight {weight}: {:.5} ± {:.5} against {:.5} ± {:.5}, z {z:+.2}", a.value, a.error, b.value, b.error);
        assert!(z.abs() < 4.0);
    }
    let scores = estimate(50.0, Some(shift)).paired_scores(&often);
    println!("shifted: {scores:?}");
    assert!(scores.pixel.abs() < 4.8 && scores.total.abs() < 4.0, "{scores:?}");
}

/// The furnace again, with a sky that is sampled by itself.
#[test]
fn furnace_under_an_environment_map() {
    let medium = homogeneous([0.8, 1.0, 1.3], WHITE, 0.4);
    let world = World::new(camera([0.1, 0.05, -2.5], 0.4, 4)).medium([-1.0; 3], [1.0; 3], medium);
    assert_furnace("map", &world.light(environment_map(|_| 1.0), 1.0), 1024, None);
}

/// Next-event estimation by the map's density, and going on: any mixture of the two gives the same image, shifted or not.
#[test]
fn how_often_an_environment_map_is_picked_changes_nothing() {
    let world = |weight: f64| {
        let fog = homogeneous([0.6, 0.9, 1.4], [0.9, 0.8, 0.7], 0.3);
        World::new(camera([0.0, 0.0, -2.0], 0.5, 4))
            .medium([-1.5; 3], [1.5; 3], fog)
            .surface(
                rectangle([-2.0, -1.2, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]),
                Bsdf::Diffuse { albedo: Colour::splat(0.5) },
            )
            .light(environment_map(|i| if i == 13 { 20.0 } else { (i % 3) as f32 }), weight)
            .light(Light::Point { position: DVec3::new(0.0, 9.0, 0.0), intensity: Colour::ZERO }, 1.0)
    };
    let shift = shift::Options::new(Mode::Exact, Kernel::Disk(Radius::Pixels(1.0)), 3);
    let estimate = |weight, shift| Estimate::of_path_tracer(&world(weight), options(5, shift), 512 * scale());
    let never = estimate(0.0, None);
    for (weight, shift) in [(0.05, None), (1.0, Some(shift))] {
        assert_same_total(weight, &estimate(weight, shift), &never);
    }
}

/// Where it shines at full intensity a spot light is a point light.
#[test]
fn a_wide_spot_light_is_a_point_light() {
    let (position, intensity) = (DVec3::new(0.3, 1.7, -0.2), Colour::new(3.0, 2.0, 1.0));
    let image = |light: Light<'static>| {
        let world = World::new(camera([0.0, 0.0, -2.0], 0.5, 4)).medium([-1.0; 3], [1.0; 3], white_grid()).light(light, 1.0);
        Estimate::of_path_tracer(&world, options(4, None), 64)
    };
    let point = image(Light::Point { position, intensity });
    let spot = |inner: f64, outer: f64| {
        let falloff = Falloff::new(inner.cos(), outer.cos());
        image(Light::Spot { position, axis: -DVec3::Y, intensity, falloff })
    };
    assert_eq!(spot(1.56, 1.57).total().value, point.total().value);
    let narrow = spot(0.2, 0.4).total().value;
    assert!(narrow > 0.0 && narrow < 0.5 * point.total().value, "{narrow}");
}

/// Nor does where the roulette begins.
#[test]
fn roulette_changes_nothing() {
    let world = edges_under_area_lights();
    let total = |rr_depth, seed| {
        let options = sampler::Options { rr_depth, seed, ..options(6, None) };
        Estimate::of_path_tracer(&world, options, 128 * scale()).total()
    };
    let (early, late) = (total(1, 1), total(99, 2));
    let z = (early.value - late.value) / early.error.hypot(late.error);
    println!("{:.5} ± {:.5} against {:.5} ± {:.5}, z {z:+.2}", early.value, early.error, late.value, late.error);
    assert!(z.abs() < 4.0);
}
