//! The shift layer under a sampler of the host's own: uniform distances along the camera ray, uniform directions, one connection to
//! a point light; one to three scatterings. Any sampler will do that knows its weights C = w·f/p.
//!
//! Same comparison, limits and significance as in unbiased.rs, 13 times: a new seed trips one with probability 0.4 %.

mod toy;

use std::ops::RangeInclusive;
use toy::estimate::{Estimate, scale};
use toy::scenes::{BLACK, World, camera, homogeneous, rectangle};
use volgrad::film::Film;
use volgrad::math::{Colour, DVec2, DVec3, direction_around, transmittance};
use volgrad::medium::{NONE, Segment};
use volgrad::path::{Path, PathError, PathErrorKind, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, Vertex};
use volgrad::phase::Phase;
use volgrad::sampler::{Stats, shift_numbers, tile_numbers};
use volgrad::scene::{HIT_SURFACE, Hit, Light, Queries, Ray};
use volgrad::shift::{self, BatchStats, Draw, Kernel, Mode, Options, Paths, Radius, Scratch, Tile, Tiling};

/// Paths per pixel and batch: 64 × 64 × 128 = 524 288 per estimate.
const PASSES: u64 = 128;

/// A dense medium in thin fog, both homogeneous, an occluder above that shades a part of both and one before them.
fn world() -> World {
    let mut camera = camera([0.0, 0.0, -2.5], 0.8, 8);
    camera.near_clip = NEAR;
    World::new(camera)
        .medium([-1.5, -1.5, -2.0], [1.5, 1.5, 1.5], homogeneous([0.2; 3], [0.9; 3], 0.0))
        .medium([-1.0, -1.0, -0.5], [0.2, 1.0, 0.7], homogeneous([1.0, 1.4, 1.8], [0.9, 0.8, 0.7], 0.7))
        .surface(rectangle([-0.2, 1.6, -0.4], [0.4, 0.0, 0.0], [0.0, 0.0, 0.5]), BLACK)
        .surface(rectangle([-0.3, -1.0, -1.2], [0.0, 0.7, 0.0], [0.8, 0.0, 0.0]), BLACK)
        .light(Light::Point { position: LIGHT.into(), intensity: Colour::splat(8.0) }, 1.0)
}

/// In the fog; nothing counts before it.
const NEAR: f64 = 0.7;

const LIGHT: [f64; 3] = [0.1, 2.3, 0.0];

/// A path in the making; all in f64, positions rounded as the library will see them.
#[derive(Clone)]
struct Sample<'a> {
    world: &'a World,
    vertices: Vec<Vertex>,
    segments: Vec<Segment>,
    edge_ends: Vec<u32>,
    /// f/p so far.
    weight: Colour,
}

fn vertex(kind: u32, index: u32, position: DVec3) -> Vertex {
    Vertex { kind, index, position: position.into(), ..Vertex::default() }
}

fn rounded(x: DVec3) -> DVec3 {
    x.as_vec3().as_dvec3()
}

impl<'a> Sample<'a> {
    fn new(world: &'a World) -> Self {
        let camera = vertex(VERTEX_CAMERA, 0, world.camera.position);
        Self { world, vertices: vec![camera], segments: vec![], edge_ends: vec![], weight: Colour::ONE }
    }

    fn last(&self) -> DVec3 {
        self.vertices.last().expect("starts at the camera").position.wide()
    }

    /// Adds an edge and its transmittance. False if it is blocked.
    fn connect(&mut self, end: Vertex) -> bool {
        let (from, to) = (self.last(), end.position.wide());
        let (length, direction) = ((to - from).length(), (to - from).normalize());
        // The camera's edge counts from the near plane on, though its segments start at the camera.
        let near = if self.vertices.len() == 1 { NEAR / direction.z } else { 0.0 };
        let begin = from + near * direction;
        let ray = Ray::free(begin, direction, length - near, self.world.geometry.medium_at(begin));
        let mut hits = [Hit::EMPTY];
        self.world.geometry.occluded(&[ray], &mut hits).expect("never stops");
        if hits[0].kind == HIT_SURFACE {
            return false;
        }
        let segments = self.world.geometry.segments(from, direction, length).expect("few media");
        let mut start = near;
        let mut tau = Colour::ZERO;
        for segment in &segments {
            let end = f64::from(segment.end).min(length).max(near);
            if segment.medium != NONE {
                tau += self.world.media[segment.medium as usize].sigma_t * (end - start);
            }
            start = end;
        }
        self.weight *= transmittance(tau);
        self.segments.extend(segments);
        self.edge_ends.push(self.segments.len() as u32);
        self.vertices.push(end);
        true
    }

    /// A vertex at a uniform distance within `reach`; it has to lie in a medium. The phase function at the vertex before is the
    /// caller's.
    fn step(&mut self, direction: DVec3, reach: f64, u: f64) -> bool {
        let x = rounded(self.last() + u * reach * direction);
        let medium = self.world.geometry.medium_at(x);
        if medium == NONE || !self.connect(vertex(VERTEX_MEDIUM, medium, x)) {
            return false;
        }
        let medium = &self.world.media[medium as usize];
        self.weight *= medium.albedo * medium.sigma_t * reach;
        true
    }

    /// The same path with its first `run` vertices moved; None if it is blocked.
    fn moved(&self, run: usize, offset: DVec3) -> Option<Self> {
        let mut moved = Self::new(self.world);
        for (i, old) in self.vertices.iter().enumerate().skip(1) {
            let x = rounded(old.position.wide() + if i <= run { offset } else { DVec3::ZERO });
            let index = if old.kind == VERTEX_MEDIUM { self.world.geometry.medium_at(x) } else { old.index };
            if !moved.connect(vertex(old.kind, index, x)) {
                return None;
            }
        }
        Some(moved)
    }

    fn path(&self) -> Path<'_> {
        Path { vertices: &self.vertices, segments: &self.segments, edge_ends: &self.edge_ends }
    }

    /// The library's f.
    fn contribution(&self) -> Colour {
        volgrad::path::contribution(&self.world.scene(), &self.path()).expect("a valid path")
    }

    /// Connects to the light, and multiplies the phase functions of all medium vertices.
    fn finish(&mut self) -> bool {
        let light = rounded(LIGHT.into());
        let distance2 = (light - self.last()).length_squared();
        if !self.connect(vertex(VERTEX_LIGHT, 0, light)) {
            return false;
        }
        self.weight *= 8.0 / distance2;
        for i in 1..self.vertices.len() - 1 {
            let at = |i: usize| self.vertices[i].position.wide();
            let (back, on) = ((at(i - 1) - at(i)).normalize(), (at(i + 1) - at(i)).normalize());
            let Phase::HenyeyGreenstein { g } = self.world.media[self.vertices[i].index as usize].phase else {
                panic!("built in")
            };
            let d = 1.0 + g * g + 2.0 * g * back.dot(on);
            self.weight *= (1.0 - g * g) / (4.0 * std::f64::consts::PI * d * d.sqrt());
        }
        true
    }
}

/// One path of `scatterings` medium vertices through `pixel`; None if f = 0.
fn sample<'a>(world: &'a World, scatterings: usize, pixel: u32, random: &mut impl FnMut() -> f64) -> Option<Sample<'a>> {
    lengths(world, scatterings..=scatterings, pixel, random).pop()?
}

/// The same after each of these numbers of scatterings: None where light does not reach, and nothing after the path has ended.
fn lengths<'a>(
    world: &'a World,
    scatterings: RangeInclusive<usize>,
    pixel: u32,
    random: &mut impl FnMut() -> f64,
) -> Vec<Option<Sample<'a>>> {
    const REACH: f64 = 5.0;
    let corner = DVec2::new(f64::from(pixel % 8), f64::from(pixel / 8));
    let ray = world.camera.ray(corner + DVec2::new(random(), random()), DVec2::ZERO);
    let mut path = Sample::new(world);
    let mut all = vec![];
    for i in 0..*scatterings.end() {
        let mut direction = ray.direction;
        if i > 0 {
            direction = direction_around(DVec3::Z, 1.0 - 2.0 * random(), random());
            path.weight *= 4.0 * std::f64::consts::PI;
        }
        // Before the near plane, or off the image by rounding, f = 0.
        if !path.step(direction, REACH, random()) || (i == 0 && world.camera.project(path.last(), DVec2::ZERO).is_none()) {
            break;
        }
        if scatterings.contains(&(i + 1)) {
            let mut whole = path.clone();
            all.push((whole.finish() && is_valid(&whole)).then_some(whole));
        }
    }
    all
}

fn is_valid(path: &Sample) -> bool {
    match path.path().validate(&path.world.scene()) {
        // A vertex within rounding of a face, one in millions: the media on its two edges do not agree. It is left out.
        Err(PathError { kind: PathErrorKind::BadSegments, .. }) => false,
        result => {
            result.expect("a valid path");
            true
        }
    }
}

/// Batches of this sampler's paths: with shifts if there are options, else each in its own pixel.
fn estimate(world: &World, scatterings: usize, options: Option<Options>) -> Estimate {
    let scene = world.scene();
    let passes = PASSES * scale();
    Estimate::of_batches(world, passes, |batch, film: &mut Film| {
        let mut stats = Stats::default();
        for pass in batch * passes..(batch + 1) * passes {
            for pixel in 0..64 {
                let mut random = shift_numbers(17, pass, pixel);
                let Some(path) = sample(world, scatterings, pixel, &mut random) else { continue };
                stats.paths += 1;
                let parts = path.path();
                let Some(options) = &options else {
                    let x1 = path.vertices[1].position.wide();
                    let image = scene.camera.project(x1, DVec2::ZERO);
                    film.add(image.expect("sampled on the image").pixel, path.weight);
                    continue;
                };
                let random = shift_numbers(19, pass, pixel);
                let splats = &mut |p, c| film.add(p, c);
                let batch = shifted(world, options, &parts, path.weight, tile_numbers(19, pass), random, splats);
                stats.shifts += batch.shifts;
                stats.stays += batch.stays;
            }
        }
        stats
    })
}

/// One path's batch.
fn shifted(
    world: &World,
    options: &Options,
    path: &Path,
    weight: Colour,
    tiles: [u32; 2],
    random: impl FnMut() -> f64,
    splats: &mut dyn FnMut(DVec2, Colour),
) -> BatchStats {
    let scene = world.scene();
    let shiftable = shift::from_path(&scene, path, weight, options).expect("f > 0").expect("movable");
    let tile = options.has_views().then(|| {
        let pixel = shiftable.image.pixel;
        let bounds = Tiling::new(&scene.camera, options.tile_side(), tiles).tile(pixel.x as u32, pixel.y as u32);
        Tile::trace(&scene, &world.geometry, bounds, pixel, DVec2::ZERO).expect("never stops")
    });
    let draw = Draw { tiles, random };
    shift::shift(&scene, &world.geometry, options, &shiftable, tile.as_ref(), draw, splats).expect("never stops")
}

fn assert_unbiased(scatterings: usize, options: &[Options]) {
    let world = world();
    let reference = estimate(&world, scatterings, None);
    for options in options {
        let shifted = estimate(&world, scatterings, Some(*options));
        let scores = shifted.paired_scores(&reference);
        println!(
            "{:?} {:?}, run {}, {scatterings} scatterings: worst z pixel {:+.2}, total {:+.2}; total {:+.3} % ± {:.3} %",
            options.mode,
            options.kernel,
            options.run,
            scores.pixel,
            scores.total,
            100.0 * scores.bias,
            100.0 * scores.error
        );
        assert!(scores.pixel.abs() < 4.8 && scores.total.abs() < 4.0, "{options:?}: {scores:?}");
        assert_eq!(scores.dropped, 0);
    }
}

const DISK: Kernel = Kernel::Disk(Radius::Pixels(1.5));
const BALL: Kernel = Kernel::Ball(0.3);

fn options(mode: Mode, kernel: Kernel, run: usize) -> Options {
    let count = if kernel == Kernel::Tile { 8 } else { 4 };
    Options { run, ..Options::new(mode, kernel, count) }
}

#[test]
fn exact_single_scattering() {
    assert_unbiased(1, &[options(Mode::Exact, DISK, 1), options(Mode::Exact, BALL, 1)]);
}

#[test]
fn exact_double_scattering() {
    assert_unbiased(2, &[options(Mode::Exact, DISK, 1), options(Mode::Exact, BALL, 2)]);
}

#[test]
fn exchangeable_single_scattering() {
    assert_unbiased(1, &[options(Mode::Exchangeable, DISK, 1), options(Mode::Exchangeable, BALL, 1)]);
}

#[test]
fn exchangeable_double_scattering() {
    assert_unbiased(2, &[options(Mode::Exchangeable, DISK, 2), options(Mode::Exchangeable, BALL, 1)]);
}

#[test]
fn tiles() {
    assert_unbiased(1, &[options(Mode::Exchangeable, Kernel::Tile, 1)]);
    assert_unbiased(2, &[options(Mode::Exact, Kernel::Tile, 2), options(Mode::TwoLevel, Kernel::Tile, 1)]);
}

#[test]
fn triple_scattering_with_runs() {
    assert_unbiased(3, &[options(Mode::TwoLevel, DISK, 2), options(Mode::Exchangeable, BALL, 3)]);
}

/// Not in the mean but one by one: what arrives at a shifted path's pixel is that path's f, in the scale of C/f(x).
#[test]
fn a_shifted_splat_is_the_moved_paths_contribution() {
    let world = world();
    let scene = world.scene();
    let mut compared = 0;
    for (pass, scatterings, run) in (0..8000).flat_map(|pass| [(pass, 1, 1), (pass, 2, 1), (pass, 2, 2), (pass, 3, 2)]) {
        let disk = Options { run, ..Options::new(Mode::Exact, Kernel::Disk(Radius::Pixels(0.5)), 1) };
        let Some(path) = sample(&world, scatterings, pass as u32 % 64, &mut shift_numbers(29, pass, 0)) else { continue };
        let weight = path.contribution();
        let mut splats = vec![];
        let random = shift_numbers(31, pass, 0);
        shifted(&world, &disk, &path.path(), weight, [0; 2], random, &mut |p, c| splats.push((p, c)));
        let Some((pixel, colour)) = splats.first().filter(|(_, c)| splats.len() == 2 && c.max_element() > 0.0) else {
            continue;
        };
        // On the disk, the depth tells where in the world an image point is.
        let ray = scene.camera.ray(*pixel, DVec2::ZERO);
        let x = path.vertices[1].position.wide();
        let y = scene.camera.position + ray.direction * (scene.camera.depth(x) / ray.cosine);
        let moved = path.moved(run, y - x).expect("an accepted shift is not blocked").contribution();
        assert!((2.0 * *colour - moved).abs().max_element() < 1e-4 * moved.max_element(), "{colour} is not half of {moved}");
        compared += 1;
    }
    println!("{compared} shifted splats");
    assert!(compared > 500);
}

/// Contributions of two samples through neighbouring pixels, handed over together, are the batches that each would be, added up.
#[test]
fn paths_that_begin_alike_share_a_batch() {
    let world = world();
    let scene = world.scene();
    let mut compared = 0;
    for (seed, run) in (0..4000).flat_map(|seed| (1..=3).map(move |run| (seed, run))) {
        let pixel = 2 * (seed as u32 % 32);
        let both = [0, 1].map(|i| lengths(&world, 1..=4, pixel + i, &mut shift_numbers(37, seed, i)));
        let all: Vec<_> = both.iter().flatten().flatten().collect();
        let options = options(Mode::Exchangeable, Kernel::Tile, run);
        let tiles = tile_numbers(41, seed);
        let (mut apart, mut together) = (vec![], vec![]);
        let mut scratch = Scratch::default();
        let mut paths = Paths::new(&scene, &world.geometry, options, tiles, &mut scratch);
        for path in &all {
            let random = || unreachable!("exchangeable tiles leave nothing to chance");
            shifted(&world, &options, &path.path(), path.weight, tiles, random, &mut |p, c| apart.push((p, c)));
            let shiftable = shift::from_path(&scene, &path.path(), path.weight, &options).expect("f > 0").expect("movable");
            paths.add(&shiftable, random, |p, c| together.push((p, c))).expect("never stops");
        }
        paths.finish(|p, c| together.push((p, c))).expect("never stops");
        assert!(together.len() <= 18, "{} splats of {} paths", together.len(), all.len());
        let at = |splats: &[(DVec2, Colour)], x: f64, y: f64| -> Colour {
            splats.iter().filter(|(p, _)| p.x.floor() == x && p.y.floor() == y).map(|(_, c)| *c).sum()
        };
        for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (f64::from(x), f64::from(y)))) {
            let (a, b) = (at(&apart, x, y), at(&together, x, y));
            assert!((a - b).abs().max_element() <= 1e-6 * a.max_element(), "{a} apart is {b} together");
            compared += usize::from(a.max_element() > 0.0 && all.len() > 2);
        }
    }
    println!("{compared} pixels of samples with three contributions or more");
    assert!(compared > 300);
}
