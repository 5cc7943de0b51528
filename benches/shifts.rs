//! What a batch of shifted paths costs, by mode, number of offsets and length of the run, in a grid, with ray queries that answer at
//! once; and what of it are the optical depths and queries that an exact batch cannot do without.

mod volumes;

use criterion::{Criterion, criterion_group, criterion_main};
use std::cell::{LazyCell, RefCell};
use std::hint::black_box;
use volgrad::film::{Cell, Count, Film};
use volgrad::math::{Colour, DVec2};
use volgrad::medium::{Line, Medium, optical_depth_or_dark};
use volgrad::phase::Phase;
use volgrad::sampler::{self, PathTracer, RandomNumbers, Record, Stats, shift_numbers};
use volgrad::scene::{Bounds, HIT_NONE, Hit, Light, Lights, Queries, Ray, Scene, Stop, View};
use volgrad::shift::{Draw, Kernel, MAX_RUN, Mode, Options, Radius, Scratch, Shiftable, Tile, Tiling};
use volumes::{CAMERA, LIGHT, ONE_SEGMENT, Shape, Volume};

const SIDE: i32 = 64;
/// Optical depth across the cube: runs of eight vertices are not rare.
const DEPTH: f32 = 4.0;
const PHASE: Phase = Phase::henyey_greenstein(0.7);
const SEED: u64 = 1;
const PATHS: usize = 200;
/// From one path's pixel to the next one's: without a common factor with the number of pixels, and so all over the image.
const SPREAD: u32 = 2531;
/// Edges. A run of eight vertices and something beyond it.
const MAX_DEPTH: u32 = 12;

const MODES: [(&str, Mode); 7] = [
    ("first_order", Mode::FirstOrder),
    ("half_order", Mode::HalfOrder),
    ("log_linear", Mode::LogLinear),
    ("linear_depth", Mode::LinearDepth),
    ("exact", Mode::Exact),
    ("two_level", Mode::TwoLevel),
    ("exchangeable", Mode::Exchangeable),
];
const RUNS: [usize; 4] = [1, 2, 4, 8];
const DISK: Kernel = Kernel::Disk(Radius::Pixels(1.0));
/// Offsets: what all batches have (a tile of 3 × 3 pixels too), and as many more that the cost of one more can be told.
const COUNT: usize = 8;
const MANY: usize = 32;

/// A host without surfaces.
struct Open;

impl Queries for Open {
    fn intersect(&self, _: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        for hit in hits {
            (hit.kind, hit.segment_count, hit.segments[0]) = (HIT_NONE, 1, ONE_SEGMENT);
        }
        Ok(())
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.intersect(rays, hits)
    }
}

/// The same host, that remembers what it was asked.
#[derive(Default)]
struct Log(RefCell<Vec<Vec<Ray>>>);

impl Queries for Log {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.0.borrow_mut().push(rays.to_vec());
        Open.intersect(rays, hits)
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.intersect(rays, hits)
    }
}

/// A path to be shifted, and its tile's camera rays if the kernel is one.
struct Sample {
    path: Shiftable,
    tile: Option<Tile>,
}

/// Paths with runs of full length, as the path sampler finds them.
fn samples(scene: &Scene, options: &Options) -> Vec<Sample> {
    let options = sampler::Options {
        max_depth: MAX_DEPTH,
        rr_depth: MAX_DEPTH,
        seed: SEED,
        shift: Some(*options),
        left_out: volgrad::sampler::Lengths::NONE,
        first: volgrad::sampler::FirstVertices::ALL,
    };
    let tracer = PathTracer { scene, queries: &Open, options };
    (0..).filter_map(|pass| sample(&tracer, pass)).take(PATHS).collect()
}

fn sample(tracer: &PathTracer<Open>, pass: u64) -> Option<Sample> {
    let (scene, options) = (tracer.scene, tracer.options.shift?);
    let pixel = (pass as u32 * SPREAD) % (CAMERA.width * CAMERA.height);
    let place = DVec2::new((pixel % CAMERA.width).into(), (pixel / CAMERA.width).into()) + 0.5;
    let mut view = [View::through(scene, place, DVec2::ZERO)];
    View::trace(&mut view, scene, &Open).ok()?;
    let mut numbers = RandomNumbers::for_path(SEED, pass, pixel);
    let mut record = Record::new(Some(&options));
    tracer.trace(view[0], &mut numbers, &mut record, &mut Stats::default()).ok()?;
    let path = *record.finish()?;
    let tile = options.has_views().then(|| {
        let bounds = Tiling::new(&CAMERA, options.tile_side(), [0; 2]).tile(place.x as u32, place.y as u32);
        Tile::trace(scene, &Open, bounds, place, DVec2::ZERO).expect("never stops")
    });
    (path.run().len() == options.run).then_some(Sample { path, tile })
}

fn batch(
    scene: &Scene,
    queries: &impl Queries,
    options: &Options,
    sample: &Sample,
    pass: u64,
    scratch: &mut Scratch,
    film: &mut Film,
) {
    let draw = Draw { tiles: [0; 2], random: shift_numbers(SEED, pass, 0) };
    let splat = |pixel, colour| film.add(pixel, colour);
    let stats = scratch.shift(scene, queries, options, &sample.path, sample.tile.as_ref(), draw, splat);
    black_box(stats.expect("never stops"));
}

/// One batch per iteration, each of the next path.
fn bench(c: &mut Criterion, scene: &Scene, name: &str, options: &Options) {
    let samples = LazyCell::new(|| samples(scene, options));
    let mut passes = 0..;
    let cells = vec![Cell::default(); (CAMERA.width * CAMERA.height) as usize];
    let dropped = Count::default();
    let mut film = Film { width: CAMERA.width, height: CAMERA.height, cells: &cells, dropped: &dropped, is_shared: false };
    let mut scratch = Scratch::default();
    c.bench_function(name, |bencher| {
        bencher.iter(|| {
            let Some(pass) = passes.next() else { return };
            batch(scene, &Open, options, &samples[pass as usize % PATHS], pass, &mut scratch, &mut film);
        });
    });
}

/// The rays that an exact batch asks about in each query.
fn questions(scene: &Scene, options: &Options, sample: &Sample, pass: u64) -> Vec<Vec<Ray>> {
    let dropped = Count::default();
    let mut film = Film { width: 0, height: 0, cells: &[], dropped: &dropped, is_shared: false };
    let log = Log::default();
    batch(scene, &log, options, sample, pass, &mut Scratch::default(), &mut film);
    log.0.into_inner()
}

/// Those queries, and the optical depths of the answers: nothing else.
fn bench_edges(c: &mut Criterion, scene: &Scene, name: &str, options: &Options) {
    let batches: LazyCell<Vec<_>, _> = LazyCell::new(|| {
        let samples = samples(scene, options);
        (0..).zip(&samples).map(|(pass, sample)| questions(scene, options, sample, pass)).collect()
    });
    let mut indices = (0..PATHS).cycle();
    let mut hits = [Hit::EMPTY; COUNT];
    c.bench_function(name, |bencher| {
        bencher.iter(|| {
            let Some(index) = indices.next() else { return };
            for rays in &batches[index] {
                Open.occluded(black_box(rays), &mut hits).expect("never stops");
                for (ray, hit) in rays.iter().zip(&hits) {
                    let (origin, direction) = (ray.origin.wide(), ray.direction.wide());
                    black_box(optical_depth_or_dark(&Line::new(scene.media, origin, direction, ray.t_max.into(), hit.media())));
                }
            }
        });
    });
}

fn with_scene(body: impl FnOnce(&Scene)) {
    let volume = Volume::new(SIDE, Shape::Full, DEPTH, true);
    let media = [Medium { phase: PHASE, ..volume.medium() }];
    let lights = [Light::Point { position: LIGHT, intensity: Colour::ONE }];
    let lights = Lights { lights: &lights, cdf: &[1.0], media: &[], guides: &[], environment: None };
    body(&Scene { camera: CAMERA, media: &media, materials: &[], lights, bounds: Bounds::default() });
}

fn modes(c: &mut Criterion) {
    with_scene(|scene| {
        for (name, mode) in MODES {
            for run in RUNS {
                for count in [COUNT, MANY] {
                    let options = Options { run, ..Options::new(mode, DISK, count) };
                    bench(c, scene, &format!("disk/{name} {run} {count}"), &options);
                }
                if mode.evaluates() {
                    let options = Options { run, ..Options::new(mode, Kernel::Tile, COUNT) };
                    bench(c, scene, &format!("tile/{name} {run} {COUNT}"), &options);
                }
            }
        }
    });
}

/// What `modes` leaves out of the plots against the number of offsets and the length of the run.
fn exact(c: &mut Criterion) {
    with_scene(|scene| {
        let exact = |run, count| Options { run, ..Options::new(Mode::Exact, DISK, count) };
        for count in [4, 16] {
            bench(c, scene, &format!("disk/exact 1 {count}"), &exact(1, count));
        }
        for run in (1..=MAX_RUN).filter(|run| !RUNS.contains(run)) {
            bench(c, scene, &format!("disk/exact {run} {COUNT}"), &exact(run, COUNT));
        }
        for run in 1..=MAX_RUN {
            bench_edges(c, scene, &format!("edges/exact {run} {COUNT}"), &exact(run, COUNT));
        }
    });
}

criterion_group! {
    name = benches;
    config = volumes::criterion();
    targets = modes, exact
}
criterion_main!(benches);
