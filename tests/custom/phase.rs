//! Custom phase functions.

use crate::chains::{Chain, Chains, Picture, Setup};
use crate::images::{Image, assert_the_same, bidirectionally, by_chains, by_path, shifts};
use crate::toy::scenes::{World, camera, edges_under_area_lights, homogeneous};
use volgrad::math::{Colour, DVec2, DVec3, Vec3};
use volgrad::medium::{Medium, Segment};
use volgrad::path::{Path, PathErrorKind, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, Vertex, path_log_gradient};
use volgrad::phase::{Phase, PhaseFunction};
use volgrad::sampler::bidirectional::{self, Bidirectional, thesis};
use volgrad::sampler::metropolis::ChainStats;
use volgrad::sampler::{FirstVertices, Lengths, Options, PathTracer, Stats};
use volgrad::scene::{Light, Stop};
use volgrad::shift::{self, Kernel, Mode, Radius, from_path};

/// A built-in phase function as a host would compute it; its derivative may be unknown.
#[derive(Debug)]
struct Copy {
    original: Phase,
    derivative: bool,
}

impl PhaseFunction for Copy {
    fn eval(&self, mu: f64) -> f64 {
        self.original.eval(-mu)
    }

    fn sample(&self, u: f64) -> f64 {
        self.original.sample(DVec3::Z, DVec2::new(u, 0.0)).expect("built in").dot(-DVec3::Z)
    }

    fn has_log_derivative(&self) -> bool {
        self.derivative
    }

    fn log_derivative(&self, mu: f64) -> f64 {
        -self.original.log_derivative(-mu)
    }
}

fn copied(original: Phase, derivative: bool) -> Phase {
    Phase::Custom(Box::leak(Box::new(Copy { original, derivative })))
}

fn with_copies(world: &World, derivative: bool) -> World {
    let mut world = world.clone();
    world.media.iter_mut().for_each(|medium| medium.phase = copied(medium.phase, derivative));
    world
}

#[test]
fn a_copy_renders_the_same() {
    let original = edges_under_area_lights();
    assert_the_same(&original, &with_copies(&original, true));
}

/// A path from the camera over two vertices in fog to a light.
fn in_fog<T>(phase: Phase, then: impl Fn(&World, &Path) -> T) -> T {
    let world = World::new(camera([0.0, 0.0, -3.0], 0.8, 8))
        .medium([-3.0; 3], [3.0; 3], Medium { phase, ..homogeneous([0.5, 0.7, 0.9], [0.8; 3], 0.0) })
        .light(Light::Point { position: DVec3::new(1.5, 1.0, 0.2), intensity: Colour::ONE }, 1.0);
    let vertex = |kind: u32, position: [f64; 3]| Vertex { kind, position: DVec3::from(position).into(), ..Vertex::default() };
    let vertices = [
        vertex(VERTEX_CAMERA, [0.0, 0.0, -3.0]),
        vertex(VERTEX_MEDIUM, [0.2, -0.3, -0.4]),
        vertex(VERTEX_MEDIUM, [0.1, 0.2, 1.0]),
        vertex(VERTEX_LIGHT, [1.5, 1.0, 0.2]),
    ];
    let segments = [0, 0, 0].map(|medium| Segment { end: f32::INFINITY, medium, normal: Vec3::default() });
    then(&world, &Path { vertices: &vertices, segments: &segments, edge_ends: &[1, 2, 3] })
}

/// Gradients are the original's, at the vertex that moves and at its neighbours; unknown ones are refused.
#[test]
fn gradients_need_the_derivative() {
    let gradient = |phase: Phase, i: usize| in_fog(phase, |world, path| path_log_gradient(&world.scene(), path, i));
    let original = Phase::henyey_greenstein(0.6);
    for i in [1, 2] {
        let expected = gradient(original, i).expect("f > 0");
        let found = gradient(copied(original, true), i).expect("f > 0");
        assert!((found.luminance - expected.luminance).length() < 1e-9 * expected.luminance.length());
        assert!(expected.factors.phase_apex.length() > 0.1, "the phase function's part is no trifle");
        let refused = gradient(copied(original, false), i).expect_err("not known");
        assert_eq!(refused.kind, PathErrorKind::NoGradient);
    }
}

const DISK: Kernel = Kernel::Disk(Radius::Pixels(1.0));

/// Modes that have nothing but the gradient.
const BY_GRADIENT: [Mode; 3] = [Mode::FirstOrder, Mode::HalfOrder, Mode::LogLinear];
const OTHERS: [Mode; 4] = [Mode::LinearDepth, Mode::Exact, Mode::TwoLevel, Mode::Exchangeable];

#[test]
fn modes_that_need_the_derivative_are_refused() {
    let world = with_copies(&edges_under_area_lights(), false);
    let scene = world.scene();
    let stop = |mode: Mode| {
        let shift = Some(shift::Options::new(mode, DISK, 3));
        let options = Options { max_depth: 3, rr_depth: 3, seed: 1, shift, left_out: Lengths::NONE, first: FirstVertices::ALL };
        let cells = vec![Default::default(); 64];
        let mut film = volgrad::film::Film {
            width: 8,
            height: 8,
            cells: &cells,
            dropped: &volgrad::film::Count::default(),
            is_shared: false,
        };
        let tracer = PathTracer { scene: &scene, queries: &world.geometry, options };
        let by_path = tracer.sample_pixels(0, 0..64, &mut film, &mut Stats::default());
        let options = bidirectional::Options {
            max_length: 3,
            rr_depth: 3,
            seed: 1,
            heuristic: bidirectional::Heuristic::Balance,
            light_vertices: 3,
            roulette: 0.0,
            shift,
        };
        let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
        let bidirectionally = sampler.sample_pixels(0, 0..64, &mut film, &mut Stats::default());
        let shifted = in_fog(copied(Phase::ISOTROPIC, false), |world, path| {
            from_path(&world.scene(), path, Colour::ONE, &shift::Options::new(mode, DISK, 3)).map(|path| path.is_some())
        });
        assert_eq!(by_path, bidirectionally);
        assert_eq!(by_path.is_ok(), shifted == Ok(true));
        by_path
    };
    for mode in BY_GRADIENT {
        assert_eq!(stop(mode), Err(Stop::NoGradient), "{mode:?}");
    }
    for mode in OTHERS {
        assert_eq!(stop(mode), Ok(()), "{mode:?}");
    }
    assert_eq!(scene.check_phase_derivatives(), Err(Stop::NoGradient));
}

#[test]
fn chains_that_need_the_derivative_are_refused() {
    let world = with_copies(&edges_under_area_lights(), false);
    let scene = world.scene();
    let setup =
        Setup { lengths: Lengths { first: 2, last: 4 }, learn: 0, samples: 500, chains: 1, large_step: 0.5, burn_in: 5 };
    let mut chains = Chains::new(&world, &setup, 7);
    let run = |chains: &Chains, shift: Option<shift::Options>| {
        let Chain { mut state, mut numbers } = chains.chains[0].clone();
        let picture = Picture::new(&world);
        let counts = (&mut Stats::default(), &mut ChainStats::default());
        chains.sampler(&scene, shift, 1).run(&mut state, &mut numbers, 1, &mut picture.film(), counts.0, counts.1)
    };
    for mode in BY_GRADIENT {
        assert_eq!(run(&chains, Some(shift::Options::new(mode, DISK, 3))), Err(Stop::NoGradient));
    }
    for mode in OTHERS {
        assert_eq!(run(&chains, Some(shift::Options::new(mode, DISK, 3))), Ok(()));
    }
    chains.thesis = Some(thesis::Options { radius: 0.3, count: 3, alpha: 1.0, clamp: f64::INFINITY, as_printed: false });
    assert_eq!(run(&chains, None), Err(Stop::NoGradient));
}

/// Unbiased modes do without: the same images as with the derivative.
#[test]
fn other_modes_do_without() {
    let original = edges_under_area_lights();
    let [with, without] = [true, false].map(|derivative| with_copies(&original, derivative));
    for shift in shifts().into_iter().filter(|shift| shift.is_none_or(|shift| shift.mode.evaluates())) {
        let images =
            |world: &World| -> [Image; 3] { [by_path(world, shift), bidirectionally(world, shift), by_chains(world, shift)] };
        assert!(images(&with) == images(&without), "{shift:?}");
    }
}

/// Answers that are no values, one kind after the other.
#[derive(Debug)]
struct Bad(u32);

impl PhaseFunction for Bad {
    fn eval(&self, mu: f64) -> f64 {
        match self.0 {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => -1.0,
            3 => 0.0,
            _ => Phase::henyey_greenstein(0.3).eval(-mu),
        }
    }

    fn sample(&self, u: f64) -> f64 {
        match self.0 {
            4 => f64::NAN,
            5 => 1.5,
            _ => 2.0 * u - 1.0,
        }
    }

    fn has_log_derivative(&self) -> bool {
        true
    }

    fn log_derivative(&self, _: f64) -> f64 {
        if self.0 == 6 { f64::NAN } else { f64::INFINITY }
    }
}

/// They count as 0, and never enter the film, which drops nothing.
#[test]
fn bad_values_count_as_nothing() {
    for kind in 0..7 {
        let mut world = edges_under_area_lights();
        let bad = Phase::Custom(Box::leak(Box::new(Bad(kind))));
        world.media.iter_mut().for_each(|medium| medium.phase = bad);
        for (name, image) in crate::images::images(&world) {
            assert!(image.iter().all(|c| c.is_finite()), "{kind}: {name}");
        }
        assert!(bad.log_derivative(0.5) == 0.0 && bad.has_derivative() && bad.invert(DVec3::X, DVec3::Y).is_none());
    }
}
