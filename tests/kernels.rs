//! What shifts rest on, exactly and not only in the mean: symmetric kernels, and batches that keep a path's energy.

mod toy;

use toy::batch::{batch, paths, record, splats};
use toy::scenes::{
    World, camera, edges_under_area_lights, edges_under_point_light, edges_with_rough_surfaces, edges_with_specular_surfaces,
    homogeneous, rectangle,
};
use volgrad::math::{Colour, DVec2, DVec3, luminance};
use volgrad::medium::NONE;
use volgrad::sampler;
use volgrad::scene::{Bsdf, Camera, Light};
use volgrad::shift::{Depth, Exit, Kernel, Link, MAX_RUN, Mode, Next, Options, Place, Radius, RunVertex, Shiftable};

const DISK: Kernel = Kernel::Disk(Radius::Pixels(1.5));
const BALL: Kernel = Kernel::Ball(0.35);
const ALL_MODES: [Mode; 7] =
    [Mode::FirstOrder, Mode::HalfOrder, Mode::LogLinear, Mode::LinearDepth, Mode::Exact, Mode::TwoLevel, Mode::Exchangeable];

fn options(mode: Mode, kernel: Kernel, count: usize, run: usize) -> Options {
    Options { run, ..Options::new(mode, kernel, count) }
}

/// The same scene with grey media and surfaces.
fn grey(mut world: World) -> World {
    for medium in &mut world.media {
        *medium =
            volgrad::medium::Medium { density: medium.density, phase: medium.phase, ..homogeneous([1.3; 3], [0.8; 3], 0.0) };
    }
    for bsdf in &mut world.materials {
        if let Bsdf::Diffuse { albedo } = bsdf {
            *albedo = Colour::splat(albedo.x);
        }
    }
    world
}

/// An exchangeable batch's weights are in [0, 1] and sum to 1: of a grey path, energy moves and none is lost or made.
#[test]
fn an_exchangeable_batch_keeps_the_energy_of_a_grey_path() {
    let world = grey(edges_under_point_light());
    let scene = world.scene();
    for (kernel, run) in [(DISK, 1), (BALL, 3), (Kernel::Tile, 1), (Kernel::Tile, MAX_RUN)] {
        let mut moved = 0.0;
        let options = options(Mode::Exchangeable, kernel, 8, run);
        for (pass, path) in paths(&world, &options, 2000).iter().enumerate() {
            let own = luminance(path.carried(&scene));
            let splats = splats(&world, &options, path, pass as u64);
            let sum: f64 = splats.iter().map(|(_, c)| luminance(*c)).sum();
            assert!((sum - own).abs() <= 1e-12 * own, "{kernel:?}, run {run}: {sum} of {own}");
            assert!(splats.iter().all(|(_, c)| c.min_element() >= 0.0));
            let (_, others) = splats.split_last().expect("the path's own splat");
            moved += others.iter().map(|(_, c)| luminance(*c)).sum::<f64>() / own;
        }
        assert!(moved > 200.0, "{kernel:?}, run {run}: only {moved} paths' worth of energy moved");
    }
}

/// Where f is the same all around, every member of an exchangeable batch gets the same share of it.
#[test]
fn an_exchangeable_batch_is_shared_out_evenly_where_f_is_flat() {
    let (world, path) = flat(camera([0.0; 3], 0.01, 64));
    let own = path.carried(&world.scene());
    for kernel in [Kernel::Disk(Radius::Pixels(1.0)), Kernel::Tile] {
        for (_, colour) in splats(&world, &options(Mode::Exchangeable, kernel, 8, 1), &path, 0) {
            assert!((9.0 * colour - own).length() < 2e-3 * own.length(), "{kernel:?}: {colour} is not a ninth of {own}");
        }
    }
}

/// Whatever a sampled path may take along on its run, and what stays: together they are what the sampler finds without shifts.
#[test]
fn a_record_is_the_whole_path() {
    let worlds =
        [(edges_under_area_lights(), false), (edges_with_specular_surfaces(), true), (edges_with_rough_surfaces(), true)];
    for (world, ends_early) in worlds {
        let scene = world.scene();
        let sampler = |shift| sampler::Options {
            max_depth: 10,
            rr_depth: 4,
            seed: 11,
            shift,
            left_out: volgrad::sampler::Lengths::NONE,
            first: volgrad::sampler::FirstVertices::ALL,
        };
        for (run, mode) in [(1, Mode::Exact), (2, Mode::LogLinear), (3, Mode::Exchangeable), (MAX_RUN, Mode::TwoLevel)] {
            let (mut long, mut beside) = (0, 0);
            for pass in 0..8000 {
                let whole = record(&world, sampler(None), pass).plain;
                let mut record = record(&world, sampler(Some(options(mode, DISK, 1, run))), pass);
                let plain = record.plain;
                let path = record.finish().copied();
                let carried = path.as_ref().map_or(Colour::ZERO, |path| path.carried(&scene));
                assert!(
                    (plain + carried - whole).length() <= 1e-10 * whole.length(),
                    "{run}: {plain} and {carried} of {whole}"
                );
                let Some(path) = path else { continue };
                long += usize::from(path.run().len() == run);
                beside += usize::from(path.onwards.is_some_and(|onwards| onwards.from + 1 < path.run().len()));
            }
            println!("run {run}: {long} of full length, {beside} end before their last vertex");
            assert!(long > 5 && (beside > 5) == (ends_early && run > 1));
        }
    }
}

/// No splat falls off the image where offsets have nowhere to go, and all that the path carries is kept.
#[test]
fn a_batch_without_offsets_is_the_path_itself() {
    let world = edges_with_specular_surfaces();
    for mode in ALL_MODES {
        for (kernel, run) in [(DISK, 1), (DISK, 3), (Kernel::Tile, MAX_RUN)] {
            let options = options(mode, kernel, 0, run);
            for path in paths(&world, &options, 500) {
                let own = path.carried(&world.scene());
                let splats = splats(&world, &options, &path, 0);
                let sum: Colour = splats.iter().map(|(_, c)| *c).sum();
                assert!((sum - own).length() <= 1e-12 * own.length(), "{mode:?}: {sum} of {own}");
                assert!(splats.iter().all(|(p, _)| *p == path.image.pixel));
            }
        }
    }
}

/// At the same place a member's f is the path's own, whether its rays are asked for or its optical depths
/// predicted: with offsets that lead nowhere every splat is an equal share.
#[test]
fn a_shift_by_nothing_changes_nothing() {
    let world = edges_with_specular_surfaces();
    let mut splat_count = 0;
    for mode in ALL_MODES {
        for run in [1, 3, MAX_RUN] {
            let options = options(mode, Kernel::Disk(Radius::Pixels(1e-12)), 3, run);
            for path in paths(&world, &options, 1000) {
                let own = path.carried(&world.scene());
                let splats = splats(&world, &options, &path, 0);
                // Some modes leave paths that begin on a surface alone.
                assert!(splats.len() == 4 || splats.len() == 1 && path.first().place.is_surface());
                for (_, colour) in &splats {
                    // Surfaces are met again, and faces crossed, in single precision.
                    let close = (splats.len() as f64 * *colour - own).length() <= 1e-4 * own.length();
                    assert!(close, "{mode:?}, run {run}: {colour} is not an equal share of {own}");
                }
                splat_count += splats.len();
            }
        }
    }
    println!("{splat_count} splats");
}

/// Where all weights are 0, what is left at the path itself is its own share, and one for each member that left the image or its medium.
#[test]
fn what_leaves_stays() {
    let world = edges_under_point_light();
    let (mut lefts, mut stays) = (0, 0);
    for (kernel, count, run) in [(DISK, 5, 1), (BALL, 10, 3)] {
        for mode in [Mode::FirstOrder, Mode::HalfOrder] {
            let options = Options { clamp: 0.0, ..options(mode, kernel, count, run) };
            for (pass, path) in
                paths(&world, &options, 500).iter().enumerate().filter(|(_, path)| !path.first().place.is_surface())
            {
                let (own, mut splats) = (path.carried(&world.scene()), vec![]);
                let stats = batch(&world, &options, path, pass as u64, |p, c| splats.push((p, c)));
                let (_, rest) = splats.pop().expect("the path's own");
                assert!(splats.iter().all(|(_, colour)| *colour == Colour::ZERO));
                let left = count - splats.len();
                let expected = own * ((1 + left) as f64 / (1 + count) as f64);
                assert!((rest - expected).length() <= 1e-12 * own.length(), "{kernel:?}: {rest}, {left} of {count} left");
                assert_eq!(stats.stays * count as u64, stats.shifts * left as u64);
                (lefts, stays) = (lefts + left, stays + splats.len());
            }
        }
    }
    println!("{lefts} left, {stays} did not");
    assert!(lefts > 1000 && stays > 1000);
}

/// The radius after i samples is that of the first one times i^((alpha - 1)/3); a tile keeps its size.
#[test]
fn the_radius_follows_its_schedule() {
    for (alpha, samples, factor) in [
        (1.0, 1e6, 1.0),
        (0.25, 0.0, 1.0),
        (0.25, 1.0, 1.0),
        (0.25, 1e4, 0.1),
        (0.25, 16.0, 0.5),
        (0.0, 8.0, 0.5),
        (0.7, 1e10, 0.1),
    ] {
        let after = |kernel| Options { alpha, ..Options::new(Mode::LogLinear, kernel, 3) }.after(samples).kernel;
        let close = |radius: f64, first: f64| assert!((radius / (factor * first) - 1.0).abs() < 1e-12, "{alpha}, {samples}");
        match (after(Kernel::Disk(Radius::Pixels(4.0))), after(Kernel::Disk(Radius::World(0.3))), after(Kernel::Ball(0.2))) {
            (Kernel::Disk(Radius::Pixels(p)), Kernel::Disk(Radius::World(w)), Kernel::Ball(b)) => {
                close(p, 4.0);
                close(w, 0.3);
                close(b, 0.2);
            }
            kernels => panic!("{kernels:?}"),
        }
        assert_eq!(after(Kernel::Tile), Kernel::Tile);
    }
}

/// A vertex in a medium so thin that it changes nothing, far before the camera and lit from one direction: f is flat.
fn flat(mut camera: Camera) -> (World, Shiftable) {
    camera.medium = NONE;
    let distance = 100.0;
    let world = World::new(camera)
        .medium([-1e3; 3], [1e3; 3], homogeneous([1e-9; 3], [0.8; 3], 0.0))
        .light(Light::Directional { direction: -DVec3::Y, irradiance: Colour::ONE }, 1.0);
    let x = world.camera.position + distance * world.camera.forward + 0.1 * world.camera.right;
    let image = world.camera.project(x, DVec2::ZERO).expect("in view");
    let link = Link { next: Next::Direction(DVec3::Y), depth: Depth::default() };
    let (depth, to_previous) = (Depth::default(), -image.ray.direction);
    let first = RunVertex { x, place: Place::Medium(0), depth, to_previous, distance: image.distance };
    let mut path = Shiftable::new(image, first);
    path.leave(Exit { from: 0, link, wing: None, rest: Colour::ONE });
    (world, path)
}

/// The same on a wall.
fn flat_wall() -> (World, Shiftable) {
    let (world, path) = flat(camera([0.0; 3], 0.01, 64));
    let distance = path.first().x.z;
    let world = world.surface(
        rectangle([-100.0, -100.0, distance], [0.0, 200.0, 0.0], [200.0, 0.0, 0.0]),
        Bsdf::Diffuse { albedo: Colour::splat(0.5) },
    );
    let place = Place::Surface { material: world.materials.len() as u32 - 1, normal: -DVec3::Z, medium: 0, user: 0 };
    let link = Link { next: Next::Direction(DVec3::new(0.0, 0.6, -0.8)), depth: Depth::default() };
    let mut path = Shiftable::new(path.image, RunVertex { place, ..*path.first() });
    path.leave(Exit { from: 0, link, wing: None, rest: Colour::ONE });
    (world, path)
}

/// The members of an exchangeable batch, the path itself among them, are alike: any two are as far apart as any other two, which is
/// two steps of the kernel, of mean square r² in all (the variance of that over r⁴ is below 1: |z| < 4.5).
#[test]
fn the_members_of_an_exchangeable_batch_are_alike() {
    const BATCHES: u64 = 20_000;
    const RADIUS: f64 = 3.0;
    let options = options(Mode::Exchangeable, Kernel::Disk(Radius::Pixels(RADIUS)), 2, 1);
    for (world, path) in [flat(camera([0.0; 3], 0.01, 64)), flat_wall()] {
        let mut squares = [0.0; 3];
        for pass in 0..BATCHES {
            let splats = splats(&world, &options, &path, pass);
            let [a, b, own] = splats[..] else { panic!("{} splats", splats.len()) };
            for (sum, (p, q)) in squares.iter_mut().zip([(own, a), (own, b), (a, b)]) {
                *sum += (p.0 - q.0).length_squared() / (RADIUS * RADIUS * BATCHES as f64);
            }
        }
        println!("mean squares {squares:.3?} of 1");
        assert!(squares.iter().all(|square| (square - 1.0).abs() < 4.5 / (BATCHES as f64).sqrt()), "{squares:?}");
    }
}

/// Where the splats beside the path's own fall, in pixels from it.
fn offsets(world: &World, path: &Shiftable, kernel: Kernel) -> Vec<DVec2> {
    let options = options(Mode::LinearDepth, kernel, 32, 1);
    let all = (0..DRAWS as u64 / 32).flat_map(|pass| {
        let mut splats = splats(world, &options, path, pass);
        splats.pop();
        splats
    });
    all.map(|(pixel, _)| pixel - path.image.pixel).collect()
}

/// The disk is uniform by area.
#[test]
fn the_disk_is_symmetric() {
    let (world, path) = flat(camera([0.0; 3], 0.01, 64));
    let samples: Vec<_> = offsets(&world, &path, Kernel::Disk(Radius::Pixels(8.0))).iter().map(|d| *d / 8.0).collect();
    assert!(samples.iter().all(|d| d.length() < 1.0 + 1e-9));
    assert_uniform(&samples, |r| r * r);
}

/// The ball is uniform by volume: seen from far away, along any axis, as much of it as its shadow says.
#[test]
fn the_ball_is_symmetric() {
    let along_z = camera([0.0; 3], 0.01, 64);
    let along_x = Camera { forward: DVec3::X, right: DVec3::Y, up: DVec3::Z, ..along_z };
    for camera in [along_z, along_x] {
        let (world, path) = flat(camera);
        let radius = 0.25;
        let pixels = radius / (camera.pixel_size() * camera.depth(path.first().x));
        let samples: Vec<_> = offsets(&world, &path, Kernel::Ball(radius)).iter().map(|d| *d / pixels).collect();
        assert!(samples.iter().all(|d| d.length() < 1.003), "the camera is not infinitely far away");
        assert_uniform(&samples, |r| 1.0 - (1.0 - (r * r).min(1.0)).powf(1.5));
    }
}

const DRAWS: usize = 1 << 16;

/// `measure` of the distance is uniform (Kolmogorov–Smirnov, significance 1e-4: D < 2.23/√n), and offsets d and −d are alike: their
/// mean is 0 (each component has variance below 1/4: |z| < 4.5).
fn assert_uniform(samples: &[DVec2], measure: impl Fn(f64) -> f64) {
    assert_eq!(samples.len(), DRAWS, "some fell off the image");
    let n = DRAWS as f64;
    let mut measures: Vec<f64> = samples.iter().map(|d| measure(d.length())).collect();
    measures.sort_by(f64::total_cmp);
    let distance = measures.iter().enumerate().map(|(i, m)| (m - i as f64 / n).abs()).fold(0.0, f64::max);
    let mean = samples.iter().copied().sum::<DVec2>() / n;
    println!("KS {:.2} of 2.23, mean {:.2} of 4.5", distance * n.sqrt(), mean.abs().max_element() * 2.0 * n.sqrt());
    assert!(distance < 2.23 / n.sqrt() && mean.abs().max_element() < 4.5 * 0.5 / n.sqrt());
}
