//! Neighbours that scatter or emit differently into different directions: rough surfaces and spot lights.

use super::{
    CONTRIBUTION_TOLERANCE, GRADIENT_TOLERANCE, SEED,
    common::{assert_below, host::*},
    reference::{
        differences::{difference_gradient, is_smooth, run_difference_gradient},
        factors::FACTOR_NAMES,
        random_paths::PROFILE_PATTERNS,
        selftest::{Worst, for_each_path},
        vector::*,
    },
    runs,
    vertex::{named, note_contribution},
};
use volgrad::path::{path_log_gradient, path_run_log_gradient};

#[test]
fn contributions_agree_factor_by_factor() {
    let mut worst = Worst::default();
    for_each_path(SEED, &PROFILE_PATTERNS, |scene, phase, pattern, path| {
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        note_contribution(&mut worst, &world, &path, Bricks::Built, &format!("{pattern}, {}, {phase:?}", scene.name));
    });
    assert_below(&worst, CONTRIBUTION_TOLERANCE);
}

#[test]
fn gradients_agree_with_differences() {
    let mut worst = Worst::default();
    for_each_path(SEED, &PROFILE_PATTERNS, |scene, phase, pattern, path| {
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        for i in (0..path.vertices.len()).filter(|&i| path.vertices[i].is_medium()) {
            let expected = difference_gradient(&world, &path, i);
            let ours = with_path(&world, &path, Bricks::Built, |scene, path| path_log_gradient(scene, path, i).expect("f > 0"));
            let magnitude = expected.factors.magnitude();
            let mut note = |what: &str, a: Vec3, b: Vec3| {
                worst.note(distance(a, b) / magnitude, || format!("{what} of x_{i} in {pattern}, {}, {phase:?}", scene.name));
            };
            let pairs = named(&ours.factors).to_array().into_iter().zip(expected.factors.to_array());
            for (what, (a, b)) in FACTOR_NAMES.iter().zip(pairs) {
                note(what, a, b);
            }
            for c in 0..3 {
                note("total", ours.factors.channel(c).to_array(), expected.totals[c]);
            }
            note("luminance", ours.luminance.to_array(), expected.luminance);
        }
    });
    assert_below(&worst, GRADIENT_TOLERANCE);
}

#[test]
fn runs_agree_with_differences() {
    let mut worst = Worst::default();
    for_each_path(SEED, &PROFILE_PATTERNS, |scene, phase, pattern, path| {
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        for (first, last) in runs(&path).filter(|(first, last)| is_smooth(&world, &path, *first, *last)) {
            let ours = with_path(&world, &path, Bricks::Built, |scene, path| {
                path_run_log_gradient(scene, path, first, last + 1 - first).expect("f > 0").factors
            });
            let expected = run_difference_gradient(&world, &path, first, last);
            for (c, expected) in expected.into_iter().enumerate() {
                let error = distance(ours.channel(c).to_array(), expected) / (1.0 + length(expected));
                worst.note(error, || format!("x_{first}…x_{last} in {pattern}, {}, {phase:?}", scene.name));
            }
        }
    });
    assert_below(&worst, GRADIENT_TOLERANCE);
}
