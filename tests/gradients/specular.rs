//! Runs beside a mirror, which move along the edge to it.

use super::{
    GRADIENT_TOLERANCE, SEED,
    common::{assert_below, host::*},
    reference::{
        contribution::contribution,
        differences::{derivative, is_smooth},
        medium::{Density, Medium},
        path::{Path as ReferencePath, Vertex},
        phase::Phase,
        random_paths::MIRROR_PATTERNS,
        selftest::{Worst, for_each_path},
        vector::*,
        world::World,
    },
    runs, simple_path,
};
use volgrad::path::{LogDerivative, PathError, PathErrorKind, path_run_log_derivative};
use volgrad::scene::{Bsdf, Scene};

fn ours(world: &World, path: &ReferencePath, first: usize, last: usize) -> Result<LogDerivative, PathError> {
    with_path(world, path, Bricks::Built, |scene, path| path_run_log_derivative(scene, path, first, last + 1 - first))
}

/// d log f/dδ per channel and of the luminance when the run moves by δ·direction, by differences.
fn differences(world: &World, path: &ReferencePath, first: usize, last: usize, direction: Vec3) -> [f64; 4] {
    derivative(|delta| {
        let f = contribution(world, &path.moved(first, last, scale(delta, direction))).total();
        [f[0].ln(), f[1].ln(), f[2].ln(), luminance(f).ln()]
    })
}

#[test]
fn derivatives_agree_with_differences() {
    let mut worst = Worst::default();
    let (mut before, mut after) = (0, 0);
    for_each_path(SEED, &MIRROR_PATTERNS, |scene, phase, pattern, path| {
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        for (first, last) in runs(&path) {
            let [p, n] = [first - 1, last + 1].map(|i| path.vertices[i].is_specular());
            if p == n || !is_smooth(&world, &path, first, last) {
                continue;
            }
            let ours = ours(&world, &path, first, last).expect("one specular neighbour");
            let (direction, count) = match p {
                true => (path.direction_to_previous(&world, first), &mut before),
                false => (path.direction_to_next(&world, last), &mut after),
            };
            *count += 1;
            let name = || format!("x_{first}…x_{last} in {pattern}, {}, {phase:?}", scene.name);
            worst.note(distance(ours.direction.to_array(), direction), name);
            let expected = differences(&world, &path, first, last, direction);
            let got = [ours.channel(0), ours.channel(1), ours.channel(2), ours.luminance];
            for (got, expected) in got.into_iter().zip(expected) {
                worst.note((got - expected).abs() / (1.0 + expected.abs()), name);
            }
        }
    });
    println!("{before} runs after a mirror, {after} before one");
    assert!(before > 100 && after > 100);
    assert_below(&worst, GRADIENT_TOLERANCE);
}

/// A mirror in the plane z = 2, a medium before it, a lamp at `lamp` that is seen at `image` in the mirror.
struct Unfolded {
    world: World,
    lamp: Vec3,
    image: Vec3,
}

const INTENSITY: Rgb = [3.0, 2.0, 1.0];
const REFLECTANCE: Rgb = [0.7; 3];
const MIRROR: f64 = 2.0;

impl Unfolded {
    fn new(phase: Phase) -> Self {
        let medium = Medium { sigma_t: [0.3, 0.6, 0.9], albedo: [0.9, 0.5, 0.7], phase, density: Density::Constant };
        let lamp = [-0.75, 0.5, 0.75];
        Self { world: World::filled_with(medium), lamp, image: [lamp[0], lamp[1], 2.0 * MIRROR - lamp[2]] }
    }

    /// Camera, the run of medium vertices, mirror, lamp.
    fn path(&self, run: &[Vec3]) -> ReferencePath {
        let x = run[run.len() - 1];
        let to_image = sub(self.image, x);
        let position = add(x, scale((MIRROR - x[2]) / to_image[2], to_image));
        let mirror = Vertex::Mirror { position, normal: [0.0, 0.0, -1.0], reflectance: REFLECTANCE };
        let lamp = Vertex::PointLight { position: self.lamp, intensity: INTENSITY };
        let run = run.iter().map(|&position| Vertex::Medium { position, medium: 0 });
        ReferencePath { vertices: [Vertex::Camera].into_iter().chain(run).chain([mirror, lamp]).collect() }
    }

    /// The contribution in volume measure: the path without the mirror to the lamp's image, G over the whole of its length.
    fn contribution(&self, run: &[Vec3]) -> Rgb {
        let image = Vertex::PointLight { position: self.image, intensity: INTENSITY };
        let run = run.iter().map(|&position| Vertex::Medium { position, medium: 0 });
        let path = ReferencePath { vertices: [Vertex::Camera].into_iter().chain(run).chain([image]).collect() };
        product(REFLECTANCE, contribution(&self.world, &path).total())
    }
}

/// The lamp's image unfolds the mirror: what is computed is the change of F/G, F in volume measure and G over the unfolded length,
/// since dω = G dA at the lamp.
#[test]
fn a_plane_mirror_unfolds() {
    let mut worst = Worst::default();
    for phase in [Phase::Isotropic, Phase::HenyeyGreenstein { g: 0.7 }] {
        let scene = Unfolded::new(phase);
        for run in [&[[0.25, -0.25, 1.0]][..], &[[0.5, 0.25, 0.75], [-0.25, 0.25, 1.25]]] {
            let x = run[run.len() - 1];
            let direction = direction(x, scene.image);
            let derivatives = derivative(|delta| {
                let moved: Vec<Vec3> = run.iter().map(|&x| add(x, scale(delta, direction))).collect();
                scene.contribution(&moved).map(f64::ln)
            });
            let ours = ours(&scene.world, &scene.path(run), 1, run.len()).expect("one specular neighbour");
            // G = 1/(d − δ)².
            let geometry = 2.0 / distance(x, scene.image);
            for (c, with_geometry) in derivatives.into_iter().enumerate() {
                worst.note((ours.channel(c) - (with_geometry - geometry)).abs(), || {
                    format!("{phase:?}, {} vertices", run.len())
                });
                assert!((ours.channel(c) - with_geometry).abs() > 0.1, "G of the chain would be seen");
            }
        }
    }
    assert_below(&worst, GRADIENT_TOLERANCE);
}

/// And f itself differs from the physical contribution by G of the unfolded chain.
#[test]
fn f_is_the_contribution_over_the_geometry_term_of_the_chain() {
    let scene = Unfolded::new(Phase::HenyeyGreenstein { g: 0.7 });
    let run = [[0.25, -0.25, 1.0]];
    let f = with_path(&scene.world, &scene.path(&run), Bricks::Built, |scene, path| {
        volgrad::path::contribution(scene, path).expect("a valid path").to_array()
    });
    let d2 = distance(run[0], scene.image).powi(2);
    for (f, physical) in f.into_iter().zip(scene.contribution(&run)) {
        assert!((f / (physical * d2) - 1.0).abs() < GRADIENT_TOLERANCE);
    }
}

#[test]
fn only_runs_with_one_specular_neighbour_have_a_derivative() {
    let (world, path) = simple_path("CMMXMXMP");
    let error = |first, last| ours(&world, &path, first, last).err().map(|error| error.kind);
    for (first, last) in [(1, 2), (2, 2), (6, 6)] {
        assert_eq!(error(first, last), None, "x_{first}…x_{last}");
    }
    // Free at both ends, held at both ends, not in a medium.
    for (first, last) in [(1, 1), (4, 4), (2, 3), (3, 3), (0, 0)] {
        assert_eq!(error(first, last), Some(PathErrorKind::NotMovable), "x_{first}…x_{last}");
    }
}

/// The derivative does not depend on what the specular vertex is, nor on what comes after it but for its colour.
#[test]
fn glass_is_like_a_mirror() {
    let (world, path) = simple_path("CMMXP");
    with_path(&world, &path, Bricks::Built, |scene, path| {
        let mirror = path_run_log_derivative(scene, path, 1, 2).expect("f > 0");
        let glass = Scene { materials: &[Bsdf::Dielectric { eta: 1.5 }], ..*scene };
        let glass = path_run_log_derivative(&glass, path, 1, 2).expect("f > 0");
        assert_eq!(glass.factors, mirror.factors);
        assert_eq!(glass.direction, mirror.direction);
    });
}
