//! Contributions and their gradients against the reference: random worlds, random paths, factor by factor and in total. One file per
//! thing that moves.
//!
//! The reference has no occluders, and its medium vertices keep away from faces and from the walls between cells, where gradients
//! jump. What is left between the two are single-precision ends and normals of segments: 4e-7 of f, 7e-8 of Σ|factor gradients|.

#[path = "../common/mod.rs"]
mod common;
#[path = "../reference/mod.rs"]
mod reference;

mod batches;
mod profile;
mod runs;
mod specular;
mod vertex;

use common::host::{rounded_path, rounded_world};
use reference::{
    path::Path as ReferencePath, phase::Phase, random::generator, random_paths::random_path, scenes::scenes, world::World,
};

/// Relative, of f and each factor.
const CONTRIBUTION_TOLERANCE: f64 = 2e-6;
/// Relative to Σ|factor gradients|.
const GRADIENT_TOLERANCE: f64 = 1e-6;
const SEED: u64 = 11;

fn scene_named(name: &str, phase: Phase, rng: &mut rand_pcg::Pcg64) -> World {
    scenes(rng, phase).into_iter().find(|scene| scene.name == name).expect("a scene of that name").world
}

/// A path through a homogeneous cube.
fn simple_path(pattern: &str) -> (World, ReferencePath) {
    let mut rng = generator(SEED);
    let world = rounded_world(&scene_named("homogeneous cube", Phase::Isotropic, &mut rng));
    let path = rounded_path(&random_path(&mut rng, &world, pattern));
    (world, path)
}

/// Every run of consecutive medium vertices, first and last.
fn runs(path: &ReferencePath) -> impl Iterator<Item = (usize, usize)> + '_ {
    let is_medium = |i: &usize| path.vertices[*i].is_medium();
    let starts = (0..path.vertices.len()).filter(is_medium);
    starts.flat_map(move |first| (first..path.vertices.len()).take_while(is_medium).map(move |last| (first, last)))
}
