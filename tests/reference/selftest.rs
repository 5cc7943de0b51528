//! How right the reference's gradients are: measured against finite differences of f.
//! `tests/reference_selftest.rs` states the tolerances.

use super::{
    contribution::contribution,
    differences::{Differences, difference_gradient, run_difference_gradient},
    factors::{FACTOR_NAMES, Factors},
    gradient::{log_gradient, run_log_gradient},
    optical_depth_gradient::{Moving, optical_depth_gradient},
    path::Path,
    phase::Phase,
    random::generator,
    random_paths::{PATTERNS, random_path},
    scenes::{PHASES, Scene, scenes},
    vector::*,
    world::World,
};
use std::collections::BTreeSet;

/// The largest of several errors, and what it belongs to.
#[derive(Clone, Debug, Default)]
pub struct Worst {
    pub error: f64,
    pub of: String,
    pub count: usize,
}

impl Worst {
    pub fn note(&mut self, error: f64, of: impl FnOnce() -> String) {
        self.count += 1;
        // A NaN is the worst error there is, and stays.
        let is_worse = error > self.error || error.is_nan();
        if is_worse && !self.error.is_nan() {
            *self = Worst { error, of: of(), count: self.count };
        }
    }
}

/// Calls `visit` with every scene, phase function and pattern of path.
pub fn for_each_path(seed: u64, patterns: &[&str], mut visit: impl FnMut(&Scene, Phase, &str, &Path)) {
    let mut rng = generator(seed);
    for phase in PHASES {
        for scene in scenes(&mut rng, phase) {
            for pattern in patterns {
                // Nothing reaches a light at infinity through a medium without end.
                if scene.world.regions[0].planes.is_empty() && pattern.ends_with(['E', 'K', 'S']) {
                    continue;
                }
                visit(&scene, phase, pattern, &random_path(&mut rng, &scene.world, pattern));
            }
        }
    }
}

/// Calls `visit` with every scene, phase function, pattern of path and medium vertex on it.
pub fn for_each_vertex(seed: u64, mut visit: impl FnMut(&Scene, Phase, &str, &Path, usize)) {
    for_each_path(seed, &PATTERNS, |scene, phase, pattern, path| {
        for i in (0..path.vertices.len()).filter(|&i| path.vertices[i].is_medium()) {
            visit(scene, phase, pattern, path, i);
        }
    });
}

/// |formula − differences| / Σ|factor gradients|, for each factor, the three totals and the luminance.
pub fn gradient_errors(formula: &Factors<Vec3>, differences: &Differences, f: Rgb) -> Vec<(&'static str, f64)> {
    let relative = |a: Vec3, b: Vec3| distance(a, b) / formula.magnitude();
    let mut errors = Vec::new();
    for ((name, a), b) in FACTOR_NAMES.iter().zip(formula.to_array()).zip(differences.factors.to_array()) {
        errors.push((*name, relative(a, b)));
    }
    for ((name, a), b) in ["red", "green", "blue"].iter().zip(formula.totals()).zip(differences.totals) {
        errors.push((*name, relative(a, b)));
    }
    errors.push(("luminance", relative(formula.luminance(f), differences.luminance)));
    errors
}

/// Every gradient against differences.
pub fn worst_gradient(seed: u64) -> Worst {
    let mut worst = Worst::default();
    for_each_vertex(seed, |scene, phase, pattern, path, i| {
        let formula = log_gradient(&scene.world, path, i);
        let differences = difference_gradient(&scene.world, path, i);
        let f = contribution(&scene.world, path).total();
        for (name, error) in gradient_errors(&formula, &differences, f) {
            worst.note(error, || format!("{name} of x_{i} in {pattern}, {}, {phase:?}", scene.name));
        }
    });
    worst
}

/// Rigid runs of all medium vertices from x_1 on, against differences.
pub fn worst_run_gradient(seed: u64) -> Worst {
    let mut worst = Worst::default();
    for_each_vertex(seed, |scene, phase, pattern, path, i| {
        if (1..=i).any(|j| !path.vertices[j].is_medium()) {
            return;
        }
        let magnitude: f64 = (1..=i).map(|j| log_gradient(&scene.world, path, j).magnitude()).sum();
        let formula = run_log_gradient(&scene.world, path, 1, i);
        let differences = run_difference_gradient(&scene.world, path, 1, i);
        for channel in 0..3 {
            let error = distance(formula[channel], differences[channel]) / magnitude;
            worst.note(error, || format!("run x_1…x_{i} in {pattern}, {}, {phase:?}", scene.name));
        }
    });
    worst
}

/// The largest relative error of the total gradient, by differences, when `change` has taken something out of the formula.
/// Only in the scenes that `which` selects.
pub fn error_after(
    seed: u64,
    which: impl Fn(&Scene) -> bool,
    change: impl Fn(&World, &Path, usize, &mut Factors<Vec3>),
) -> Worst {
    let mut worst = Worst::default();
    for_each_vertex(seed, |scene, _, pattern, path, i| {
        if which(scene) {
            let mut formula = log_gradient(&scene.world, path, i);
            let magnitude = formula.magnitude();
            change(&scene.world, path, i, &mut formula);
            let differences = difference_gradient(&scene.world, path, i);
            let error = distance(formula.total(0), differences.totals[0]) / magnitude;
            worst.note(error, || format!("x_{i} in {pattern}, {}", scene.name));
        }
    });
    worst
}

/// Takes the face terms out of both transmittance gradients.
pub fn drop_face_terms(world: &World, path: &Path, i: usize, formula: &mut Factors<Vec3>) {
    let next = if path.vertices[i + 1].is_at_infinity() { Moving::Whole } else { Moving::Start };
    let within = |edge, moving| {
        let gradient = optical_depth_gradient(world, &path.edge(world, edge), moving);
        gradient.within.map(|g| scale(-1.0, g))
    };
    formula.transmittance_prev = within(i - 1, Moving::End);
    formula.transmittance_next = within(i, next);
}

/// The (p, n) kinds of the neighbours of every tested vertex.
pub fn neighbour_kinds(seed: u64) -> BTreeSet<String> {
    let mut kinds = BTreeSet::new();
    for_each_vertex(seed, |_, _, pattern, _, i| {
        kinds.insert(format!("{}{}", &pattern[i - 1..i], &pattern[i + 1..i + 2]));
    });
    kinds
}
