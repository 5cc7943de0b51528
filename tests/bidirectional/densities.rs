//! What subpaths say about their own densities: with p the density of their vertices, the mean of 1/p over those subpaths that have each
//! vertex in a region of its own is the product of the regions' sizes, whatever p is.
//!
//! A p that is wrong in the same way in values and weights would go unnoticed path by path; here it does not.

use crate::MOST;
use crate::toy::Shape;
use crate::toy::estimate::{BATCHES, Mean, scale};
use crate::toy::scenes::{World, environment_map, homogeneous, rectangle};
use crate::worlds::{self, fog, lamp, pinhole, room};
use std::f64::consts::PI;
use volgrad::math::{Colour, DVec2, DVec3};
use volgrad::sampler::bidirectional::{Limits, Subpath, from_camera, from_light};
use volgrad::sampler::{PrimarySample, RandomNumbers, SLOTS, Slot, Stats};
use volgrad::scene::{Camera, Falloff, Light, Scene, View};

/// A part of where a vertex may be, and its size: volume, area or solid angle, or 1 for a point or a direction that is given.
struct Region {
    size: f64,
    holds: fn(DVec3) -> bool,
}

fn within(x: DVec3, low: [f64; 3], high: [f64; 3]) -> bool {
    x.cmpge(low.into()).all() && x.cmple(high.into()).all()
}

// All of these see each other, the camera sees MIDDLE, BEHIND and the wall, cropped or in the fog only NEAR.
const MIDDLE: Region = Region { size: 3.328, holds: |x| within(x, [-0.8, -0.8, -0.9], [0.8, 0.8, 0.4]) };
const TOP: Region = Region { size: 5.324, holds: |x| within(x, [-1.1, 0.0, -1.1], [1.1, 1.1, 1.1]) };
const BEHIND: Region = Region { size: 6.0, holds: |x| within(x, [-1.0, -1.0, -0.4], [1.0, 1.0, 1.1]) };
const NEAR: Region = Region { size: 0.64, holds: |x| within(x, [-0.5, -0.2, 0.3], [0.5, 0.6, 1.1]) };
const FLOOR: Region = Region { size: 7.5, holds: |x| within(x, [-1.5, -1.201, -1.0], [1.5, -1.199, 1.5]) };
const WALL: Region = Region { size: 6.0, holds: |x| within(x, [-1.5, -1.0, 1.599], [1.5, 1.0, 1.601]) };

const LAMP: Region = Region { size: 1.96, holds: |x| (x.y - 1.8).abs() < 1e-6 };
const GIVEN: Region = Region { size: 1.0, holds: |_| true };
/// Near the zenith.
const ZENITH: Region = Region { size: 2.0 * PI * 0.1, holds: |to_light| to_light.y > 0.9 };
/// The lower end of a sphere of radius ½ at height 2.1.
const CAP: Region = Region { size: 2.0 * PI * 0.25 * 0.1, holds: |x| x.y < 2.1 - 0.45 };

fn pair(numbers: [f64; SLOTS], u: Slot, v: Slot) -> DVec2 {
    DVec2::new(numbers[u as usize], numbers[v as usize])
}

/// A subpath of `count` vertices at most, the camera itself not counted.
fn subpath<'a>(world: &'a World, scene: &'a Scene<'a>, of_light: bool, count: usize, sample: u64, path: &mut Subpath<'a>) {
    let (seed, stats, queries) = (5, &mut Stats::default(), &world.geometry);
    let [x0, y0, x1, y1] = scene.camera.crop;
    if of_light {
        let limits = Limits { vertices: count, rr_depth: 99 };
        from_light(scene, queries, limits, &mut RandomNumbers::for_light(seed, sample, 0), path, stats).expect("never stops");
        return;
    }
    let mut numbers = RandomNumbers::for_path(seed, sample, 0);
    let first = numbers.vertex(0);
    let size = DVec2::new((x1 - x0).into(), (y1 - y0).into());
    let place = DVec2::new(x0.into(), y0.into()) + size * pair(first, Slot::DirectionU, Slot::DirectionV);
    let lens = scene.camera.lens_point(pair(first, Slot::LightU, Slot::LightV));
    let mut view = [View::through(scene, place, lens)];
    View::trace(&mut view, scene, queries).expect("never stops");
    let limits = Limits { vertices: count + 1, rr_depth: 99 };
    from_camera(scene, queries, &mut view[0], limits, &mut numbers, path, stats).expect("never stops");
}

/// The mean of 1/p over those subpaths whose vertices are in these regions.
fn mean_size(world: &World, of_light: bool, regions: &[&Region]) -> Mean {
    let scene = world.scene();
    let samples = 2000 * scale();
    let batch = |batch: u64| {
        let mut path = Subpath::default();
        let mut sum = 0.0;
        for sample in batch * samples..(batch + 1) * samples {
            subpath(world, &scene, of_light, regions.len(), sample, &mut path);
            let vertices = &path.vertices()[usize::from(!of_light)..];
            if vertices.len() == regions.len() && regions.iter().zip(vertices).all(|(r, v)| (r.holds)(v.position)) {
                sum += vertices.iter().map(|v| 1.0 / v.density).product::<f64>();
            }
        }
        sum / samples as f64
    };
    let batches: Vec<f64> = (0..BATCHES).map(batch).collect();
    Mean::of(batches.into_iter())
}

fn check(name: &str, world: &World, of_light: bool, regions: &[&Region]) {
    let size: f64 = regions.iter().map(|region| region.size).product();
    let found = mean_size(world, of_light, regions);
    println!(
        "{name}, {} vertices: {:.4} ± {:.4}, size {size:.4}, z {:+.2}",
        regions.len(),
        found.value,
        found.error,
        found.z_to(size)
    );
    assert!(found.z_to(size).abs() < MOST && found.error < 0.2 * size);
}

#[test]
fn densities_from_the_camera() {
    let lens = Camera { lens_radius: 0.2, focal_distance: 2.8, ..pinhole() };
    let inside = Camera { position: DVec3::new(0.1, 0.2, -0.9), tan_half_fov_x: 0.9, ..pinhole() };
    let crop = Camera { crop: [0, 0, 4, 3], ..pinhole() };
    for (name, camera, region) in
        [("pinhole", pinhole(), &BEHIND), ("lens", lens, &BEHIND), ("crop", crop, &NEAR), ("inside", inside, &NEAR)]
    {
        check(name, &lamp(room(camera, fog())), false, &[region]);
    }
    // Where there is some density everywhere, and not much less than anywhere else.
    for (name, world) in worlds::media().iter().filter(|(name, _)| !matches!(*name, "grid" | "thin")) {
        check(name, world, false, &[&MIDDLE]);
        check(name, world, false, &[&MIDDLE, &TOP]);
    }
    let world = lamp(room(pinhole(), fog()));
    check("to a surface", &world, false, &[&MIDDLE, &FLOOR]);
    check("from a surface", &world, false, &[&WALL, &MIDDLE]);
    // Where nothing is behind, the camera's first edge always ends in a collision.
    let open =
        lamp(World::new(pinhole()).medium([-1.2, -1.1, -1.2], [1.2, 1.1, 1.2], homogeneous([0.3, 0.5, 0.9], [0.9; 3], 0.4)));
    check("open", &open, false, &[&MIDDLE]);
    check("open", &open, false, &[&MIDDLE, &TOP]);
}

#[test]
fn densities_from_each_light() {
    // No wall, which would keep light out.
    let open = World::new(pinhole())
        .medium([-1.2, -1.1, -1.2], [1.2, 1.1, 1.2], homogeneous([0.3, 0.5, 0.9], [0.9; 3], 0.4))
        .surface(rectangle([-2.0, -1.2, -1.5], [0.0, 0.0, 3.2], [4.0, 0.0, 0.0]), worlds::diffuse(0.6));
    let lit = |light| open.clone().light(light, 1.0);
    let (position, intensity) = (DVec3::new(0.0, 2.2, -0.2), Colour::ONE);
    let triangle = Shape::Triangle {
        corner: DVec3::new(-0.8, 1.8, -0.7),
        edge_u: DVec3::new(1.6, 0.0, 0.0),
        edge_v: DVec3::new(0.0, 0.0, 1.5),
    };
    let sphere = Shape::Sphere { centre: DVec3::new(0.2, 2.1, 0.0), radius: 0.5 };
    let direction = DVec3::new(0.1, -1.0, 0.1).normalize();
    let half = Region { size: 1.2, ..LAMP };
    let falloff = Falloff::new(0.9, 0.7);
    let cases = [
        ("parallelogram", lamp(room(pinhole(), fog())), &LAMP),
        ("triangle", room(pinhole(), fog()).shining(triangle, Colour::ONE), &half),
        ("sphere", room(pinhole(), fog()).shining(sphere, Colour::ONE), &CAP),
        ("environment", lit(Light::Environment { radiance: Colour::ONE }), &ZENITH),
        ("environment map", lit(environment_map(|i| 1.0 + (i % 3) as f32)), &ZENITH),
        ("directional", lit(Light::Directional { direction, irradiance: Colour::ONE }), &GIVEN),
        ("point", lit(Light::Point { position, intensity }), &GIVEN),
        ("spot", lit(Light::Spot { position, axis: -DVec3::Y, intensity, falloff }), &GIVEN),
        ("one of two", lamp(lit(Light::Point { position, intensity })), &LAMP),
    ];
    for (name, world, on_light) in cases {
        check(name, &world, true, &[on_light, &MIDDLE]);
        check(name, &world, true, &[on_light, &FLOOR]);
    }
    check("two in the fog", &lamp(room(pinhole(), fog())), true, &[&LAMP, &MIDDLE, &BEHIND]);
}
