//! What a pass adds to a film depends on nothing but its number: not on how its pixels are divided, nor on where a host stops it.

use crate::toy::Geometry;
use crate::toy::scenes::{World, edges_with_specular_surfaces};
use crate::{options, pixels, worlds};
use std::cell::Cell as Counter;
use std::ops::Range;
use volgrad::film::{Cell, Count, Film};
use volgrad::math::{Colour, DVec3};
use volgrad::sampler::Stats;
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic, Options};
use volgrad::scene::{Falloff, Hit, Light, Queries, Ray, Stop};
use volgrad::shift::{self, Kernel, Mode, Radius};

const PASSES: u64 = 8;

/// Places in a pass.
const STOPS: u64 = 97;

struct Picture {
    cells: Vec<Cell>,
    stats: Stats,
}

impl Picture {
    fn new(world: &World) -> Self {
        let cells = (world.camera.width * world.camera.height) as usize;
        Self { cells: vec![Cell::default(); cells], stats: Stats::default() }
    }

    fn sample(
        &mut self,
        world: &World,
        queries: &impl Queries,
        options: Options,
        pass: u64,
        pixels: Range<u32>,
    ) -> Result<(), Stop> {
        let scene = world.scene();
        let (width, height, dropped) = (world.camera.width, world.camera.height, Count::default());
        let mut film = Film { width, height, cells: &self.cells, dropped: &dropped, is_shared: false };
        let sampler = Bidirectional { scene: &scene, queries, options };
        let result = sampler.sample_pixels(pass, pixels, &mut film, &mut self.stats);
        assert_eq!(dropped.get(), 0);
        result
    }

    fn of(world: &World, options: Options, ranges: &[Range<u32>]) -> Self {
        let mut picture = Self::new(world);
        for pass in 0..PASSES {
            for range in ranges {
                let done = picture.sample(world, &world.geometry, options, pass, range.clone());
                done.expect("the toy host never stops");
            }
        }
        picture
    }
}

fn any_division_gives_the_same(world: &World, options: Options) {
    let n = pixels(world);
    let mut whole = Picture::of(world, options, &[0..n]);
    assert!(4 * whole.cells.iter().filter(|cell| cell.value().min_element() > 0.0).count() as u32 >= 3 * n);
    let mut parts = Picture::of(world, options, &[7..n, 0..3, 3..7]);
    assert_eq!(parts.cells, whole.cells);
    if options.shift.is_some() {
        assert!(whole.stats.shifted_paths > u64::from(n));
        // A tile's are traced once for each piece of it.
        (whole.stats.rays, parts.stats.rays) = (0, 0);
    }
    assert_eq!(parts.stats, whole.stats);
}

fn shifted(mode: Mode, kernel: Kernel, roulette: f64) -> Options {
    let shift = shift::Options::new(mode, kernel, if kernel == Kernel::Tile { 8 } else { 3 });
    Options { roulette, shift: Some(shift), ..options(5, Heuristic::Balance) }
}

fn all_shifts() -> [Options; 3] {
    let disk = Kernel::Disk(Radius::Pixels(1.0));
    [
        shifted(Mode::Exact, disk, 0.0),
        shifted(Mode::TwoLevel, Kernel::Tile, 0.1),
        shifted(Mode::Exchangeable, Kernel::Tile, 0.0),
    ]
}

#[test]
fn any_division_of_a_pass_gives_the_same_bits() {
    let (_, world) = worlds::lights().pop().expect("there are some");
    any_division_gives_the_same(&world, options(5, Heuristic::Balance));
    any_division_gives_the_same(&world, Options { roulette: 0.1, light_vertices: 2, ..options(5, Heuristic::Power) });
}

#[test]
fn any_division_of_a_shifted_pass_gives_the_same_bits() {
    let mut world = edges_with_specular_surfaces();
    (world.camera.lens_radius, world.camera.focal_distance) = (0.2, 2.5);
    all_shifts().into_iter().for_each(|options| any_division_gives_the_same(&world, options));
}

/// A host that stops at one of its queries.
struct Stopping<'a> {
    geometry: &'a Geometry,
    left: Counter<u64>,
}

impl Stopping<'_> {
    fn count(&self) -> Result<(), Stop> {
        let left = self.left.get().checked_sub(1).ok_or(Stop::Callback(-42))?;
        self.left.set(left);
        Ok(())
    }
}

impl Queries for Stopping<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.count()?;
        self.geometry.intersect(rays, hits)
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.count()?;
        self.geometry.occluded(rays, hits)
    }
}

/// Wherever that is, going on behind the last whole sample loses nothing and doubles nothing.
#[test]
fn a_stop_leaves_whole_samples() {
    // From the spot light some of a sample stays while the rest moves.
    let (position, axis) = (DVec3::new(0.3, 2.7, -0.8), DVec3::new(0.0, -0.7, 0.7).normalize());
    let spot = Light::Spot { position, axis, intensity: Colour::splat(20.0), falloff: Falloff::new(0.97, 0.6) };
    let world = edges_with_specular_surfaces().light(spot, 1.0);
    let unshifted = Options { roulette: 0.1, ..options(5, Heuristic::Balance) };
    for options in all_shifts().into_iter().chain([unshifted]) {
        let n = pixels(&world);
        let host = |queries| Stopping { geometry: &world.geometry, left: Counter::new(queries) };
        let (mut whole, patient) = (Picture::new(&world), host(u64::MAX));
        whole.sample(&world, &patient, options, 0, 0..n).expect("it waits long");
        let all = u64::MAX - patient.left.get();
        let mut between = 0;
        for i in 0..STOPS {
            let queries = all * i / STOPS;
            let host = host(queries);
            let mut picture = Picture::new(&world);
            assert_eq!(picture.sample(&world, &host, options, 0, 0..n), Err(Stop::Callback(-42)));
            let done = picture.stats.paths as u32;
            between += u64::from(0 < done && done < n);
            picture.sample(&world, &world.geometry, options, 0, done..n).expect("the toy host never stops");
            assert!(picture.cells == whole.cells, "{:?}, {queries} queries", options.shift);
            assert_eq!(picture.stats.paths, u64::from(n));
        }
        assert!(between > STOPS / 2);
    }
}
