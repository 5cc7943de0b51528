//! One medium vertex: f, each of its factors, and the gradient of each.

use super::{
    CONTRIBUTION_TOLERANCE, GRADIENT_TOLERANCE, SEED,
    common::{assert_below, host::*, media::sparse_grid},
    reference::{
        contribution::contribution,
        factors::{FACTOR_NAMES, Factors},
        gradient::log_gradient,
        medium::Density,
        path::{Path as ReferencePath, Vertex},
        phase::Phase,
        random::generator,
        random_paths::{MIRROR_PATTERNS, PATTERNS, random_path},
        scenes::sheared,
        selftest::{Worst, for_each_path, for_each_vertex, neighbour_kinds},
        vector::*,
        world::{Region, World},
    },
    scene_named, simple_path,
};
use rand_pcg::Pcg64;
use volgrad::math::{Colour, DVec3};
use volgrad::path::{self, LogGradient, Path, PathErrorKind, path_log_gradient};
use volgrad::scene::{Bsdf, Light, Lights, Scene};

/// The largest relative error of a channel.
fn relative_error(ours: Rgb, expected: Rgb) -> f64 {
    let error = |c: usize| (ours[c] - expected[c]).abs() / expected[c].abs();
    [0, 1, 2].map(error).into_iter().fold(0.0, |worst, e| if e > worst || e.is_nan() { e } else { worst })
}

/// f and each of its factors at every vertex.
pub fn note_contribution(worst: &mut Worst, world: &World, path: &ReferencePath, bricks: Bricks, name: &str) {
    let expected = contribution(world, path);
    with_path(world, path, bricks, |scene, ours| {
        ours.validate(scene).expect("a valid path");
        let total = path::contribution(scene, ours).expect("a valid path").to_array();
        worst.note(relative_error(total, expected.total()), || format!("f, {name}"));

        let k = path.edge_count();
        for i in 0..=k {
            let factors = path::factors(scene, ours, i).expect("a valid path");
            let vertex = match i {
                0 => [expected.importance; 3],
                _ if i == k => expected.emission,
                _ => product(expected.scattering[i], expected.profile[i]),
            };
            let (geometry, transmittance) = if i < k { (expected.geometry[i], expected.transmittance[i]) } else { (1.0, ONE) };
            worst.note(relative_error(factors.vertex.to_array(), vertex), || format!("x_{i}, {name}"));
            worst.note(relative_error([factors.geometry; 3], [geometry; 3]), || format!("G of edge {i}, {name}"));
            worst.note(relative_error(factors.transmittance.to_array(), transmittance), || format!("Tr of edge {i}, {name}"));
        }
    });
}

/// The library's factors under the reference's names.
pub fn named(g: &LogGradient) -> Factors<Vec3> {
    let rgb = |gradient: [DVec3; 3]| gradient.map(|g| g.to_array());
    Factors {
        scattering: g.scattering.to_array(),
        transmittance_prev: rgb(g.transmittance_previous),
        transmittance_next: rgb(g.transmittance_next),
        geometry_prev: g.geometry_previous.to_array(),
        geometry_next: g.geometry_next.to_array(),
        importance: g.importance.to_array(),
        profile_prev: rgb(g.profile_previous.map(|profile| g.phase_previous + profile)),
        phase_apex: g.phase_apex.to_array(),
        profile_next: rgb(g.profile_next.map(|profile| g.phase_next + profile)),
    }
}

/// Every factor's gradient, the total of each channel and that of the luminance, at vertex i.
fn note_gradient(worst: &mut Worst, world: &World, path: &ReferencePath, i: usize, bricks: Bricks, name: &str) {
    let expected = log_gradient(world, path, i);
    let f = contribution(world, path).total();
    let ours = with_path(world, path, bricks, |scene, path| path_log_gradient(scene, path, i).expect("f > 0"));

    let mut note = |what: &str, a: Vec3, b: Vec3| {
        worst.note(distance(a, b) / expected.magnitude(), || format!("{what} of x_{i} in {name}"));
    };
    for ((what, a), b) in FACTOR_NAMES.iter().zip(named(&ours.factors).to_array()).zip(expected.to_array()) {
        note(what, a, b);
    }
    for (c, what) in ["red", "green", "blue"].into_iter().enumerate() {
        note(what, ours.factors.channel(c).to_array(), expected.total(c));
    }
    note("luminance", ours.luminance.to_array(), expected.luminance(f));
}

#[test]
fn every_pair_of_neighbour_kinds_is_tested() {
    let kinds = neighbour_kinds(SEED);
    for p in ["C", "M", "D"] {
        for n in ["M", "D", "A", "P", "E", "S"] {
            assert!(kinds.contains(&format!("{p}{n}")), "{p} before, {n} after a medium vertex");
        }
    }
}

#[test]
fn contributions_agree_factor_by_factor() {
    let mut worst = Worst::default();
    let patterns = [PATTERNS.as_slice(), &MIRROR_PATTERNS].concat();
    for_each_path(SEED, &patterns, |scene, phase, pattern, path| {
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        let name = format!("{pattern}, {}, {phase:?}", scene.name);
        note_contribution(&mut worst, &world, &path, Bricks::Built, &name);
    });
    assert_below(&worst, CONTRIBUTION_TOLERANCE);
}

#[test]
fn gradients_agree_factor_by_factor() {
    for bricks in [Bricks::Built, Bricks::Left] {
        let mut worst = Worst::default();
        for_each_vertex(SEED, |scene, phase, pattern, path, i| {
            let (world, path) = (rounded_world(&scene.world), rounded_path(path));
            let name = format!("{pattern}, {}, {phase:?}, {bricks:?}", scene.name);
            note_gradient(&mut worst, &world, &path, i, bricks, &name);
        });
        assert_below(&worst, GRADIENT_TOLERANCE);
    }
}

/// Several bricks along each axis, some of them constant: [`for_each_vertex`] has grids of a single one.
#[test]
fn gradients_agree_in_a_sheared_grid_of_many_bricks() {
    let mut rng = generator(SEED);
    let world = rounded_world(&many_bricks(&mut rng));
    let mut worst = Worst::default();
    for pattern in PATTERNS.into_iter().filter(|pattern| pattern.len() <= 4) {
        let path = rounded_path(&random_path(&mut rng, &world, pattern));
        for bricks in [Bricks::Built, Bricks::Left] {
            note_contribution(&mut worst, &world, &path, bricks, pattern);
            for i in (0..path.vertices.len()).filter(|&i| path.vertices[i].is_medium()) {
                note_gradient(&mut worst, &world, &path, i, bricks, &format!("{pattern}, {bricks:?}"));
            }
        }
    }
    assert_below(&worst, GRADIENT_TOLERANCE);
}

fn many_bricks(rng: &mut Pcg64) -> World {
    let phase = Phase::HenyeyGreenstein { g: 0.4 };
    let mut world = scene_named("sheared grid", phase, rng);
    world.media[0].density = Density::Grid(sparse_grid(rng, [24, 17, 11], sheared(), 0.3));
    world
}

fn gradient_error(scene: &Scene, path: &Path, i: usize) -> Option<PathErrorKind> {
    path_log_gradient(scene, path, i).err().map(|error| error.kind)
}

#[test]
fn only_free_medium_vertices_have_gradients() {
    let (world, path) = simple_path("CDMP");
    with_path(&world, &path, Bricks::Built, |scene, path| {
        for i in [0, 1, 3] {
            assert_eq!(gradient_error(scene, path, i), Some(PathErrorKind::NotMovable), "x_{i}");
        }
        assert_eq!(gradient_error(scene, path, 2), None);
        for material in [Bsdf::Mirror { reflectance: Colour::ONE }, Bsdf::Dielectric { eta: 1.5 }] {
            let specular = Scene { materials: &[material], ..*scene };
            assert_eq!(gradient_error(&specular, path, 2), Some(PathErrorKind::NotMovable), "{material:?}");
        }
    });
}

/// log f is finite where f is smaller than any number.
#[test]
fn dark_paths_have_gradients() {
    for sigma_t in [[4e3; 3], [4e3, 5e3, 6e3]] {
        let (mut world, path) = simple_path("CMA");
        world.media[0].sigma_t = sigma_t;
        let [f, gradient] = with_path(&world, &path, Bricks::Built, |scene, path| {
            let f = path::contribution(scene, path).expect("a valid path");
            [f, path_log_gradient(scene, path, 1).expect("log f is finite").luminance]
        });
        let expected = log_gradient(&world, &path, 1).total(0);
        assert_eq!(f, Colour::ZERO);
        // Of three channels the red one is by far the brightest.
        assert!(distance(gradient.to_array(), expected) < GRADIENT_TOLERANCE * length(expected), "{gradient}, {expected:?}");
    }
}

/// No light comes from a sky behind a medium without end.
#[test]
fn endless_media_hide_the_sky() {
    let (mut world, path) = simple_path("CMDE");
    world.regions = vec![Region::everywhere(0)];
    let error = with_path(&world, &path, Bricks::Built, |scene, path| gradient_error(scene, path, 1));
    assert_eq!(error, Some(PathErrorKind::ZeroContribution));
}

/// log 0 has no gradient: nothing scatters at x, the light faces away, or it is black.
#[test]
fn paths_that_carry_nothing_have_no_gradient() {
    let (mut world, mut path) = simple_path("CMA");
    with_path(&world, &path, Bricks::Built, |scene, path| {
        assert_eq!(gradient_error(scene, path, 1), None);
        let (corner, edge_u, edge_v) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        let black = [Light::Parallelogram { corner, edge_u, edge_v, radiance: Colour::ZERO }];
        let dark = Scene { lights: Lights { lights: &black, ..scene.lights }, ..*scene };
        assert_eq!(gradient_error(&dark, path, 1), Some(PathErrorKind::ZeroContribution));
    });

    world.media[0].albedo = ZERO;
    let error = with_path(&world, &path, Bricks::Built, |scene, path| gradient_error(scene, path, 1));
    assert_eq!(error, Some(PathErrorKind::ZeroContribution), "no scattering");
    world.media[0].albedo = ONE;

    let Some(Vertex::AreaLight { normal, .. }) = path.vertices.last_mut() else { unreachable!() };
    *normal = scale(-1.0, *normal);
    let error = with_path(&world, &path, Bricks::Built, |scene, path| gradient_error(scene, path, 1));
    assert_eq!(error, Some(PathErrorKind::ZeroContribution), "a light that faces away");
}
