//! What shifts rest on, exactly and not only in the mean: symmetric kernels, and batches that keep a path's energy.

mod toy;

use toy::scenes::{World, edges_under_area_lights, edges_under_point_light, homogeneous};
use volgrad::math::{Colour, DVec2, DVec3, luminance};
use volgrad::sampler::{self, PathTracer, RandomNumbers, Stats, shift_numbers};
use volgrad::shift::{self, Kernel, Mode, Radius, Shiftable};

fn options(mode: Mode, kernel: Kernel, radius: Radius, count: usize) -> shift::Options {
    shift::Options { mode, kernel, radius, count }
}

/// Shiftable paths of the path sampler.
fn paths(world: &World, count: u64) -> Vec<Shiftable> {
    let scene = world.scene();
    let shift = Some(options(Mode::Exact, Kernel::Ball, Radius::World(0.1), 1));
    let options = sampler::Options { max_depth: 6, rr_depth: 4, seed: 11, shift };
    let tracer = PathTracer { scene: &scene, queries: &world.geometry, options };
    let path = |pass: u64| {
        let pixel = (pass % 64) as u32;
        let corner = DVec2::new(f64::from(pixel % 8), f64::from(pixel / 8));
        let (_, record) = tracer.trace(corner, &mut RandomNumbers::for_path(11, pass, pixel), &mut Stats::default()).ok()?;
        record.finish()
    };
    (0..count).filter_map(path).collect()
}

/// All that a path contributes where it was sampled.
fn own_contribution(world: &World, path: &Shiftable) -> Colour {
    let scene = world.scene();
    let links = path.links.iter().enumerate().filter_map(|(i, link)| Some((i, link.as_ref()?)));
    links
        .map(|(i, link)| {
            let value = path.value(&scene, i);
            let wings = link.wings().iter().zip(value.wings);
            value.colour * (link.plain + wings.map(|((_, rest), phase)| *rest * phase).sum::<Colour>())
        })
        .sum()
}

fn splats(world: &World, options: &shift::Options, path: &Shiftable, pass: u64) -> Vec<(DVec2, Colour)> {
    let mut splats = vec![];
    let random = shift_numbers(3, pass, 0);
    shift::shift(&world.scene(), &world.geometry, options, path, random, |p, c| splats.push((p, c))).expect("never stops");
    splats
}

/// The same scene with grey media and surfaces.
fn grey(mut world: World) -> World {
    for (medium, density) in world.media.clone().iter().map(|m| m.density).enumerate() {
        let g = world.media[medium].phase.g;
        world.media[medium] = volgrad::medium::Medium { density, ..homogeneous([1.3; 3], [0.8; 3], g) };
    }
    for bsdf in &mut world.materials {
        if let volgrad::scene::Bsdf::Diffuse { albedo } = bsdf {
            *albedo = Colour::splat(albedo.x);
        }
    }
    world
}

/// An exchangeable batch's weights are in [0, 1] and sum to 1: of a grey path, energy moves and none is lost or made.
#[test]
fn an_exchangeable_batch_keeps_the_energy_of_a_grey_path() {
    let world = grey(edges_under_point_light());
    let mut moved = 0.0;
    for kernel in [(Kernel::Disk, Radius::Pixels(1.5)), (Kernel::Ball, Radius::World(0.35))] {
        let options = options(Mode::Exchangeable, kernel.0, kernel.1, 8);
        for (pass, path) in paths(&world, 4000).iter().enumerate() {
            let own = luminance(own_contribution(&world, path));
            let splats = splats(&world, &options, path, pass as u64);
            let sum: f64 = splats.iter().map(|(_, c)| luminance(*c)).sum();
            assert!((sum - own).abs() <= 1e-12 * own, "{sum} of {own}");
            assert!(splats.iter().all(|(_, c)| c.min_element() >= 0.0));
            moved += splats.iter().skip(1).map(|(_, c)| luminance(*c)).sum::<f64>() / own;
        }
    }
    assert!(moved > 1000.0, "only {moved} paths' worth of energy moved");
}

/// Where a path has several links or colours, the weights are the changing factors' and not the whole path's; still no splat
/// falls off the image, and a batch of one offset and none agree where the offset has nowhere to go.
#[test]
fn a_batch_without_offsets_is_the_path_itself() {
    let world = edges_under_area_lights();
    for mode in [Mode::Exact, Mode::Exchangeable, Mode::LogLinear] {
        let options = options(mode, Kernel::Disk, Radius::Pixels(1.0), 0);
        for path in paths(&world, 2000) {
            let own = own_contribution(&world, &path);
            let splats = splats(&world, &options, &path, 0);
            let sum: Colour = splats.iter().map(|(_, c)| *c).sum();
            assert!((sum - own).length() <= 1e-12 * own.length(), "{mode:?}: {sum} of {own}");
            assert!(splats.iter().all(|(p, _)| *p == path.image.pixel));
        }
    }
}

/// The disk lies parallel to the image plane, so that x and y have the same radius in pixels; it is uniform by area.
#[test]
fn the_disk_is_symmetric() {
    let camera = toy::scenes::camera([0.3, -0.2, -3.0], 0.8, 8);
    let options = options(Mode::Exact, Kernel::Disk, Radius::Pixels(1.5), 1);
    let x = DVec3::new(1.3, -0.9, 0.4);
    let radius = options.radius_at(&camera, x);
    let samples = draws(|u| {
        let d = options.offset(&camera, radius, u);
        assert_eq!(d.dot(camera.forward), 0.0);
        let back = options.radius_at(&camera, x + d);
        assert!((back - radius).abs() < 1e-15 * radius && d.length() <= radius * (1.0 + 1e-15));
        let pixels = camera
            .project(x + d, DVec2::ZERO)
            .map(|image| image.pixel - camera.project(x, DVec2::ZERO).expect("in view").pixel);
        assert!(pixels.is_none_or(|p| p.length() <= 1.5 + 1e-12));
        (d / radius, (d / radius).length_squared())
    });
    assert_uniform(&samples);
}

/// The ball is uniform by volume.
#[test]
fn the_ball_is_symmetric() {
    let camera = toy::scenes::camera([0.0; 3], 0.8, 8);
    let options = options(Mode::Exact, Kernel::Ball, Radius::World(0.25), 1);
    let samples = draws(|u| {
        let d = options.offset(&camera, 0.25, u) / 0.25;
        assert!(d.length() <= 1.0 + 1e-15);
        (d, d.length().powi(3))
    });
    assert_uniform(&samples);
}

const DRAWS: usize = 1 << 16;

/// Offsets in units of the radius, and the measure of what is nearer than they are, in [0, 1].
fn draws(mut offset: impl FnMut([f64; 3]) -> (DVec3, f64)) -> Vec<(DVec3, f64)> {
    let mut random = shift_numbers(5, 0, 0);
    (0..DRAWS).map(|_| offset(std::array::from_fn(|_| random()))).collect()
}

/// The measure is uniform (Kolmogorov–Smirnov, significance 1e-4: D < 2.23/√n), and offsets d and −d are alike: their mean is 0
/// (each component has variance below 1/4: |z| < 4.5).
fn assert_uniform(samples: &[(DVec3, f64)]) {
    let n = DRAWS as f64;
    let mut measures: Vec<f64> = samples.iter().map(|(_, m)| *m).collect();
    measures.sort_by(f64::total_cmp);
    let distance = measures.iter().enumerate().map(|(i, m)| (m - i as f64 / n).abs()).fold(0.0, f64::max);
    let mean = samples.iter().map(|(d, _)| *d).sum::<DVec3>() / n;
    println!("KS {:.2} of 2.23, mean {:.2} of 4.5", distance * n.sqrt(), mean.abs().max_element() * 2.0 * n.sqrt());
    assert!(distance < 2.23 / n.sqrt() && mean.abs().max_element() < 4.5 * 0.5 / n.sqrt());
}
