//! Furnaces: nothing absorbs and radiance 1 comes from everywhere, or each wall emits what it absorbs. Then radiance is 1 everywhere.

use crate::toy::estimate::scale;
use crate::toy::scenes::{World, camera, homogeneous, rectangle};
use crate::{MOST, bidirectional, options, worlds};
use volgrad::math::Colour;
use volgrad::medium::Medium;
use volgrad::sampler::bidirectional::Heuristic;
use volgrad::scene::{Bsdf, Light, Reflector};

fn fog() -> Medium<'static> {
    homogeneous([0.8, 1.0, 1.3], [1.0; 3], 0.4)
}

fn check(name: &str, world: &World) {
    for heuristic in [Heuristic::Balance, Heuristic::Power] {
        let estimate = bidirectional(world, options(32, heuristic), 20 * scale());
        for channel in 0..3 {
            let mean = estimate.channel(channel);
            println!(
                "{name}, {heuristic:?}, channel {channel}: {:.5} ± {:.5}, z {:+.2}",
                mean.value,
                mean.error,
                mean.z_to(1.0)
            );
            assert!(mean.z_to(1.0).abs() < MOST && mean.error < 0.02);
        }
    }
}

fn open_furnace() -> World {
    World::new(camera([0.1, 0.05, -2.5], 0.4, 4)).medium([-1.0; 3], [1.0; 3], fog())
}

#[test]
fn a_furnace_under_a_white_sky() {
    let world = open_furnace().light(Light::Environment { radiance: Colour::ONE }, 1.0);
    check("fog", &world);
}

/// A white wall and a mirror in the fog.
#[test]
fn a_furnace_with_walls() {
    let world = open_furnace()
        .surface(
            rectangle([-0.8, -0.8, 0.5], [0.0, 1.2, 0.0], [1.2, 0.0, 0.0]),
            Bsdf::TwoSided(Reflector::Diffuse { albedo: Colour::ONE }),
        )
        .surface(
            rectangle([0.3, -0.6, -0.6], [0.0, 1.2, 0.2], [0.6, 0.0, 0.0]),
            Bsdf::TwoSided(Reflector::Mirror { reflectance: Colour::ONE }),
        )
        .light(Light::Environment { radiance: Colour::ONE }, 1.0);
    check("walls", &world);
}

/// Of walls that reflect half and emit the other half: paths pass through lights, and end on ones that scatter.
#[test]
fn a_furnace_of_glowing_walls() {
    const ALBEDO: f64 = 0.5;
    let mut world = World::new(camera([0.1, 0.05, -0.9], 0.7, 4)).medium([-1.01; 3], [1.01; 3], fog());
    let ([x, y, z], corner) = ([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], [-1.0; 3]);
    let walls = [
        (corner, x, y),
        (corner, y, z),
        (corner, z, x),
        ([-1.0, -1.0, 1.0], y, x),
        ([1.0, -1.0, -1.0], z, y),
        ([-1.0, 1.0, -1.0], x, z),
    ];
    for (corner, u, v) in walls {
        world = world.shining(rectangle(corner, u, v), Colour::splat(1.0 - ALBEDO));
    }
    world.materials[0] = worlds::diffuse(ALBEDO);
    check("glowing walls", &world);
}
