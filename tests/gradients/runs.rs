//! Runs of medium vertices that move rigidly.

use super::{
    GRADIENT_TOLERANCE, SEED,
    common::{assert_below, host::*},
    reference::{
        differences::{is_smooth, run_difference_gradient},
        gradient::{log_gradient, run_log_gradient},
        random_paths::PATTERNS,
        selftest::{Worst, for_each_path},
        vector::distance,
    },
    runs, simple_path,
};
use volgrad::math::DVec3;
use volgrad::path::{LogGradient, PathErrorKind, path_log_gradient, path_run_log_gradient};
use volgrad::scene::{Bsdf, Scene};

/// Sums of the same numbers, in another order and with more of them that cancel.
const SUM_TOLERANCE: f64 = 1e-10;

#[test]
fn runs_agree_with_the_reference_and_with_differences() {
    let [mut formula, mut differences] = [Worst::default(), Worst::default()];
    for_each_path(SEED, &PATTERNS, |scene, phase, pattern, path| {
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        for (first, last) in runs(&path) {
            let ours = with_path(&world, &path, Bricks::Built, |scene, path| {
                path_run_log_gradient(scene, path, first, last + 1 - first).expect("f > 0").factors
            });
            let magnitude: f64 = (first..=last).map(|i| log_gradient(&world, &path, i).magnitude()).sum();
            let name = || format!("x_{first}…x_{last} in {pattern}, {}, {phase:?}", scene.name);
            let expected = run_log_gradient(&world, &path, first, last);
            for (c, expected) in expected.into_iter().enumerate() {
                formula.note(distance(ours.channel(c).to_array(), expected) / magnitude, name);
            }
            if is_smooth(&world, &path, first, last) {
                let expected = run_difference_gradient(&world, &path, first, last);
                for (c, expected) in expected.into_iter().enumerate() {
                    differences.note(distance(ours.channel(c).to_array(), expected) / magnitude, name);
                }
            }
        }
    });
    assert_below(&formula, GRADIENT_TOLERANCE);
    assert_below(&differences, GRADIENT_TOLERANCE);
}

/// What a factor's name promises, of vertices that move together and of each alone.
fn note_sums(worst: &mut Worst, run: &LogGradient, alone: &[LogGradient], name: &str) {
    let magnitude: f64 =
        alone.iter().flat_map(|g| [g.geometry_previous, g.geometry_next, g.scattering]).map(DVec3::length).sum();
    let mut note = |what: &str, a: DVec3, b: DVec3| worst.note((a - b).length() / magnitude, || format!("{what} of {name}"));
    let (first, last) = (alone[0], alone[alone.len() - 1]);
    note("scattering", run.scattering, alone.iter().map(|g| g.scattering).sum());
    note("geometry before", run.geometry_previous, first.geometry_previous);
    note("geometry after", run.geometry_next, last.geometry_next);
    note("importance", run.importance, first.importance);
    note("phase before", run.phase_previous, first.phase_previous);
    note("phase after", run.phase_next, last.phase_next);
    // Each edge inside the run has a gradient at both ends, and so has each phase function.
    note("phases", run.phase_previous + run.phase_apex + run.phase_next, alone.iter().map(phases).sum());
    for c in 0..3 {
        note("transmittance before", run.transmittance_previous[c], first.transmittance_previous[c]);
        note("transmittance after", run.transmittance_next[c], last.transmittance_next[c]);
        let inside = alone.iter().map(|g| g.transmittance_previous[c] + g.transmittance_next[c]).sum::<DVec3>();
        let outside = first.transmittance_previous[c] + last.transmittance_next[c];
        note("transmittance inside", run.transmittance_inside[c], inside - outside);
        note("channel", run.channel(c), alone.iter().map(|g| g.channel(c)).sum());
    }
}

fn phases(g: &LogGradient) -> DVec3 {
    g.phase_previous + g.phase_apex + g.phase_next
}

#[test]
fn a_run_is_the_sum_of_its_vertices() {
    let mut worst = Worst::default();
    let mut longest = 0;
    for_each_path(SEED, &PATTERNS, |scene, phase, pattern, path| {
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        with_path(&world, &path, Bricks::Built, |view, ours| {
            for (first, last) in runs(&path) {
                let alone: Vec<_> = (first..=last).map(|i| path_log_gradient(view, ours, i).expect("f > 0").factors).collect();
                let run = path_run_log_gradient(view, ours, first, alone.len()).expect("f > 0");
                note_sums(
                    &mut worst,
                    &run.factors,
                    &alone,
                    &format!("x_{first}…x_{last} in {pattern}, {}, {phase:?}", scene.name),
                );
                longest = longest.max(alone.len());
            }
        });
    });
    assert_below(&worst, SUM_TOLERANCE);
    assert_eq!(longest, 5);
}

#[test]
fn runs_lie_in_media_and_end_before_surfaces_that_are_not_specular() {
    let (world, path) = simple_path("CMMDMMP");
    let error = |scene: &Scene, path: &volgrad::path::Path, first, count| {
        path_run_log_gradient(scene, path, first, count).err().map(|error| (error.kind, error.index))
    };
    with_path(&world, &path, Bricks::Built, |scene, path| {
        for (first, count) in [(1, 2), (4, 2), (2, 1)] {
            assert_eq!(error(scene, path, first, count), None, "{first}, {count}");
        }
        for (first, count, at) in [(0, 1, 0), (0, 3, 0), (1, 3, 3), (2, 4, 3), (4, 3, 6), (5, usize::MAX - 5, 6)] {
            assert_eq!(error(scene, path, first, count), Some((PathErrorKind::NotMovable, at)), "{first}, {count}");
        }
        for (first, count) in [(1, 0), (7, 1), (2, usize::MAX)] {
            assert_eq!(error(scene, path, first, count).map(|e| e.0), Some(PathErrorKind::BadIndex), "{first}, {count}");
        }
        let glass = Scene { materials: &[Bsdf::Dielectric { eta: 1.5 }], ..*scene };
        assert_eq!(error(&glass, path, 1, 2), Some((PathErrorKind::NotMovable, 2)));
        assert_eq!(error(&glass, path, 1, 1), None);
        assert_eq!(error(&glass, path, 4, 2), Some((PathErrorKind::NotMovable, 4)));
    });
}
