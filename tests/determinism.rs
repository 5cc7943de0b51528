//! The same bits for any split of the work, and what becomes of a host's bad answers: the call stops with a status, or the path
//! ends and is counted; never a panic.

mod toy;

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use toy::Geometry;
use toy::batch::record;
use toy::scenes::{World, camera, edges_under_area_lights, edges_with_specular_surfaces, homogeneous};
use volgrad::film::{Cell, Count, Film};
use volgrad::math::{Colour, Vec3};
use volgrad::sampler::{FirstVertices, Options, PathTracer, Stats, shift_numbers};
use volgrad::scene::{HIT_NONE, HIT_OVERFLOW, HIT_SURFACE, Hit, Light, MAX_SEGMENTS, Queries, Ray, Stop};
use volgrad::shift::{self, Draw, Kernel, Mode, Radius};

const PASSES: u64 = 16;
const PIXELS: u32 = 64;

const BALL: Kernel = Kernel::Ball(0.3);
const DISK: Kernel = Kernel::Disk(Radius::Pixels(1.0));

/// Runs of up to three vertices; 3 × 3 pixels are a tile.
fn options(shift: Option<(Mode, Kernel)>) -> Options {
    let shift = shift.map(|(mode, kernel)| {
        let count = if kernel == Kernel::Tile { 8 } else { 3 };
        shift::Options { run: 3, alpha: 0.25, ..shift::Options::new(mode, kernel, count) }
    });
    Options { max_depth: 6, rr_depth: 3, seed: 5, shift, left_out: volgrad::sampler::Lengths::NONE, first: FirstVertices::ALL }
}

/// A film with its memory, and the counts of what went into it.
#[derive(Clone, Debug, PartialEq)]
struct Picture {
    cells: Vec<Cell>,
    dropped: Count,
    stats: Stats,
}

impl Picture {
    fn new() -> Self {
        Self { cells: vec![Cell::default(); PIXELS as usize], dropped: Count::default(), stats: Stats::default() }
    }

    fn film(&self) -> Film<'_> {
        Film { width: 8, height: 8, cells: &self.cells, dropped: &self.dropped, is_shared: false }
    }

    /// Samples those passes' pixels; stops at the first error.
    fn sample(
        &mut self,
        world: &World,
        queries: &impl Queries,
        options: Options,
        mut work: impl Iterator<Item = Work>,
    ) -> Result<(), Stop> {
        let scene = world.scene();
        let tracer = PathTracer { scene: &scene, queries, options };
        let mut stats = self.stats;
        let mut film = self.film();
        let result = work.try_for_each(|(pass, pixels)| tracer.sample_pixels(pass, pixels, &mut film, &mut stats));
        self.stats = stats;
        result
    }

    fn of(world: &World, options: Options, work: impl Iterator<Item = Work>) -> Self {
        let mut picture = Self::new();
        picture.sample(world, &world.geometry, options, work).expect("the toy host never stops");
        picture
    }

    /// Without the counts of rays: a tile's are traced once for each piece of it.
    fn without_rays(mut self) -> Self {
        self.stats.rays = 0;
        self
    }

    fn merge(mut self, other: Self) -> Self {
        self.film().merge(&other.cells, other.dropped.get());
        let (a, b) = (&mut self.stats, other.stats);
        a.paths += b.paths;
        a.rays += b.rays;
        a.occlusion_rays += b.occlusion_rays;
        a.shifted_paths += b.shifted_paths;
        a.shifts += b.shifts;
        a.stays += b.stays;
        a.overflows += b.overflows;
        self
    }
}

/// Pixels of a pass.
type Work = (u64, Range<u32>);

/// All of the work, pass by pass, in ranges of up to `length` pixels.
fn work(length: u32) -> impl DoubleEndedIterator<Item = Work> {
    let starts = (0..PIXELS).step_by(length as usize);
    (0..PASSES).flat_map(move |pass| starts.clone().map(move |start| (pass, start..(start + length).min(PIXELS))))
}

/// Through a lens, whose point all paths of a tile share.
fn lens_world() -> World {
    let mut world = edges_with_specular_surfaces();
    (world.camera.lens_radius, world.camera.focal_distance) = (0.2, 2.5);
    world
}

const SHIFTS: [(Mode, Kernel); 6] = [
    (Mode::Exact, BALL),
    (Mode::Exchangeable, DISK),
    (Mode::LogLinear, BALL),
    (Mode::TwoLevel, Kernel::Tile),
    (Mode::Exchangeable, Kernel::Tile),
    (Mode::FirstOrder, Kernel::Tile),
];

/// Largest difference of two pictures' cells.
fn difference(a: &Picture, b: &Picture) -> u128 {
    let cells = a.cells.iter().zip(&b.cells);
    cells.flat_map(|(a, b)| (0..3).map(|i| a.sums()[i].abs_diff(b.sums()[i]))).max().expect("a picture has cells")
}

/// Paths by their first vertex: each is in one layer, with all that it is worth in the image, up to roundings of sums.
#[test]
fn layers_add_up_to_the_image() {
    const ROUNDING: u128 = 1 << 20; // 2⁻⁴⁴
    const NOTHING: FirstVertices = FirstVertices { medium: false, surface: false, specular: false, none: false };
    let layers = [
        FirstVertices { medium: true, ..NOTHING },
        FirstVertices { surface: true, ..NOTHING },
        FirstVertices { specular: true, ..NOTHING },
        FirstVertices { none: true, ..NOTHING },
    ];
    let dark = Picture::new();
    let fog = || World::new(camera([0.0, 0.0, -3.0], 0.8, 8)).medium([-1.0; 3], [1.0; 3], homogeneous([0.9; 3], [0.8; 3], 0.3));
    let environment = Light::Environment { radiance: Colour::new(0.3, 0.4, 0.5) };
    let worlds = [edges_with_specular_surfaces(), edges_under_area_lights(), fog().light(environment, 1.0)];
    for shift in [None, Some((Mode::Exchangeable, Kernel::Tile)), Some((Mode::Exact, BALL))] {
        for (world, kinds) in worlds.iter().zip([[true; 4], [true, true, false, true], [true, false, false, true]]) {
            let picture = |options| Picture::of(world, options, work(PIXELS));
            let image = picture(options(shift));
            let layers = layers.map(|first| picture(Options { first, ..options(shift) }));
            for (layer, kind) in layers.iter().zip(kinds) {
                assert_eq!(difference(layer, &dark) > 0, kind, "{shift:?}");
            }
            assert_eq!(layers[3].cells, picture(Options { max_depth: 1, ..options(shift) }).cells, "{shift:?}");
            let sum = layers.into_iter().reduce(Picture::merge).expect("there are layers");
            assert!(difference(&sum, &image) < ROUNDING, "{shift:?}");
        }
    }
}

#[test]
fn any_split_and_order_gives_the_same_bits() {
    let world = lens_world();
    for shift in SHIFTS {
        let picture = |work: &mut dyn Iterator<Item = Work>| Picture::of(&world, options(Some(shift)), work).without_rays();
        let whole = picture(&mut work(PIXELS));
        assert!(whole.stats.shifted_paths > 100 && whole.cells.iter().filter(|cell| cell.sums()[1] > 0).count() > 50);
        for length in [1, 7, 24] {
            assert_eq!(whole, picture(&mut work(length)), "{shift:?}, {length} pixels at a time");
            assert_eq!(whole, picture(&mut work(length).rev()), "{shift:?}, {length} pixels at a time, backwards");
        }
        let part =
            |share: &dyn Fn(u64, u32) -> bool| picture(&mut work(5).filter(|(pass, pixels)| share(*pass, pixels.start / 5)));
        let by_pixels: [Picture; 3] = std::array::from_fn(|i| part(&|_, range| range % 3 == i as u32));
        let by_passes: [Picture; 3] = std::array::from_fn(|i| part(&|pass, _| pass % 3 == i as u64));
        for parts in [by_pixels, by_passes] {
            let [a, b, c] = parts;
            assert_eq!(whole, a.clone().merge(b.clone()).merge(c.clone()), "in order");
            assert_eq!(whole, c.merge(a).merge(b), "out of order");
        }
    }
}

/// Two threads take work as they come, each into its own film.
#[test]
fn threads_give_the_same_bits() {
    let world = lens_world();
    for shift in [(Mode::Exact, BALL), (Mode::Exchangeable, Kernel::Tile)] {
        let all: Vec<Work> = work(11).collect();
        let next = AtomicU64::new(0);
        let one_thread = || {
            let claim = || all.get(next.fetch_add(1, Ordering::Relaxed) as usize).cloned();
            Picture::of(&world, options(Some(shift)), std::iter::from_fn(claim))
        };
        let (a, b) = std::thread::scope(|scope| {
            let other = scope.spawn(one_thread);
            (one_thread(), other.join().expect("no panic"))
        });
        let whole = Picture::of(&world, options(Some(shift)), work(PIXELS));
        assert_eq!(whole.without_rays(), a.merge(b).without_rays());
    }
}

/// A host whose answers to one kind of query are changed, from the `from`th on.
struct Faulty<'a, F> {
    geometry: &'a Geometry,
    occlusion: bool,
    from: u64,
    asked: AtomicU64,
    fault: F,
}

impl<F: Fn(&mut Hit) -> Result<(), Stop>> Faulty<'_, F> {
    fn pass_on(&self, occlusion: bool, hits: &mut [Hit]) -> Result<(), Stop> {
        if occlusion != self.occlusion || self.asked.fetch_add(1, Ordering::Relaxed) < self.from {
            return Ok(());
        }
        hits.iter_mut().try_for_each(&self.fault)
    }
}

impl<F: Fn(&mut Hit) -> Result<(), Stop>> Queries for Faulty<'_, F> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.geometry.intersect(rays, hits)?;
        self.pass_on(false, hits)
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.geometry.occluded(rays, hits)?;
        self.pass_on(true, hits)
    }
}

/// What sampling everything, with or without shifts, comes to when the host's answers are changed by `fault`.
fn with_fault(
    shift: Option<(Mode, Kernel)>,
    occlusion: bool,
    from: u64,
    fault: impl Fn(&mut Hit) -> Result<(), Stop>,
) -> (Result<(), Stop>, Picture) {
    let world = edges_under_area_lights();
    let host = Faulty { geometry: &world.geometry, occlusion, from, asked: AtomicU64::new(0), fault };
    let mut picture = Picture::new();
    let result = picture.sample(&world, &host, options(shift), work(PIXELS));
    (result, picture)
}

fn set(change: impl Fn(&mut Hit)) -> impl Fn(&mut Hit) -> Result<(), Stop> {
    move |hit| {
        change(hit);
        Ok(())
    }
}

/// A way to break an answer, and its name.
type Fault = (&'static str, fn(&mut Hit));

/// Ways to break its media.
const BAD_MEDIA: [Fault; 7] = [
    ("no segments", |hit| hit.segment_count = 0),
    ("too many segments", |hit| hit.segment_count = MAX_SEGMENTS as u32 + 1),
    ("NaN end", |hit| hit.segments[0].end = f32::NAN),
    ("negative end", |hit| hit.segments[0].end = -1.0),
    ("falling ends", |hit| {
        hit.segments[1] = hit.segments[0];
        hit.segments[1].end = 0.0;
        hit.segments[0].end = 1.0;
        hit.segment_count = 2;
    }),
    ("unknown medium", |hit| hit.segments[0].medium = 3),
    ("the constant that is no medium of a segment", |hit| hit.segments[0].medium = volgrad::scene::KEEP_MEDIUM),
];

/// Ways to break its surface.
const BAD_SURFACES: [Fault; 10] = [
    ("NaN distance", |hit| hit.t = f32::NAN),
    ("infinite distance", |hit| hit.t = f32::INFINITY),
    ("distance 0", |hit| hit.t = 0.0),
    ("NaN normal", |hit| hit.normal.y = f32::NAN),
    ("no normal", |hit| hit.normal = Vec3::default()),
    ("unknown material", |hit| hit.material = 99),
    ("unknown light", |hit| hit.light = 3),
    ("unknown medium inside", |hit| hit.medium_inside = 3),
    ("unknown medium outside", |hit| hit.medium_outside = 3),
    ("unknown kind", |hit| hit.kind = 77),
];

#[test]
fn answers_that_break_the_contract_stop_the_call() {
    for (what, change) in BAD_MEDIA {
        let free_only = |hit: &mut Hit| {
            if hit.kind == HIT_NONE {
                change(hit)
            }
        };
        assert_eq!(with_fault(None, false, 100, set(change)).0, Err(Stop::InvalidHit), "{what}");
        assert_eq!(with_fault(None, true, 100, set(free_only)).0, Err(Stop::InvalidHit), "{what}, occlusion");
    }
    for (what, change) in BAD_SURFACES {
        let surface_only = |hit: &mut Hit| {
            if hit.kind == HIT_SURFACE {
                change(hit)
            }
        };
        assert_eq!(with_fault(None, false, 100, set(surface_only)).0, Err(Stop::InvalidHit), "{what}");
    }
}

/// A shift asks about occlusion by itself.
#[test]
fn a_shift_checks_its_answers() {
    let world = edges_under_area_lights();
    let scene = world.scene();
    let options = options(Some((Mode::Exact, BALL)));
    let path = (0..64).find_map(|pass| {
        let path = record(&world, options, pass).finish().copied()?;
        Some(path).filter(|path| !path.first().place.is_surface())
    });
    let path = path.expect("one of 64 paths scatters in a medium");
    for (what, change) in BAD_MEDIA {
        let free_only = |hit: &mut Hit| {
            if hit.kind == HIT_NONE {
                change(hit)
            }
        };
        let host =
            Faulty { geometry: &world.geometry, occlusion: true, from: 0, asked: AtomicU64::new(0), fault: set(free_only) };
        let shift = options.shift.expect("shifts");
        let draw = Draw { tiles: [0; 2], random: shift_numbers(5, 0, 27) };
        let result = shift::shift(&scene, &host, &shift, &path, None, draw, |_, _| {});
        assert_eq!(result, Err(Stop::InvalidHit), "{what}");
    }
}

/// What was finished before is kept, path by path: the film holds all splats of those and none of the one that was stopped.
#[test]
fn a_callback_that_stops_leaves_whole_paths() {
    let world = edges_under_area_lights();
    for shift in SHIFTS {
        for (occlusion, from) in [(false, 200), (true, 200), (true, 777), (false, 1234)] {
            let (result, picture) = with_fault(Some(shift), occlusion, from, |_| Err(Stop::Callback(-42)));
            assert_eq!(result, Err(Stop::Callback(-42)));
            let paths = picture.stats.paths as u32;
            assert!(paths > 10, "{paths}");
            let (passes, rest) = (u64::from(paths / PIXELS), paths % PIXELS);
            let finished = work(PIXELS).take(passes as usize).chain([(passes, 0..rest)]);
            assert_eq!(picture.cells, Picture::of(&world, options(Some(shift)), finished).cells, "{shift:?}");
        }
    }
}

/// A path that met too many media ends there and is counted; nothing else fails.
#[test]
fn overflow_is_counted() {
    let overflow = || set(|hit| hit.kind = HIT_OVERFLOW);
    let (result, blind) = with_fault(None, false, 0, overflow());
    assert_eq!((result, blind.stats.overflows), (Ok(()), PASSES * u64::from(PIXELS)));
    assert!(blind.cells.iter().all(|cell| *cell == Cell::default()));
    let (result, unlit) = with_fault(None, true, 0, overflow());
    assert_eq!(result, Ok(()));
    assert!(unlit.stats.overflows > 0 && unlit.stats.overflows <= unlit.stats.occlusion_rays);
}

/// The same with media that are really there: nine boxes inside one another have seventeen stretches.
#[test]
fn more_media_than_fit_are_counted() {
    let nested = |count: i32| {
        let environment = Light::Environment { radiance: Colour::ONE };
        (1..=count).rev().fold(World::new(camera([0.0, 0.0, -3.0], 0.01, 8)).light(environment, 1.0), |world, i| {
            let half = [0.1 * f64::from(i); 3];
            world.medium(half.map(|h| -h), half, homogeneous([0.5; 3], [1.0; 3], 0.0))
        })
    };
    let (few, many) = (nested(7), nested(9));
    for kernel in [BALL, Kernel::Tile] {
        let overflows = |world| Picture::of(world, options(Some((Mode::Exact, kernel))), work(PIXELS)).stats.overflows;
        assert_eq!((overflows(&few), overflows(&many)), (0, PASSES * u64::from(PIXELS)));
    }
}
