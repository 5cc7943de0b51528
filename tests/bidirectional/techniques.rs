//! Each technique alone, without its weight: all that can make a path find the same light, summed over the image.
//!
//! A connection's 1/d² has infinite variance where both ends may be next to each other. Only paths without short edges count; that is a
//! property of the path, whoever made it. Paths are sorted by their light and by where they are specular: techniques that would have to
//! connect there, or to find a point, make none.

use crate::path::Path;
use crate::toy::estimate::{BATCHES, Mean, scale};
use crate::toy::scenes::World;
use crate::{MOST, each_technique, options, pixels, worlds};
use std::collections::{BTreeMap, BTreeSet};
use volgrad::math::luminance;
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic};

const LONGEST: u32 = 4;

/// Edges shorter than this are short, in world units: the media are some two wide.
const SHORT: f64 = 0.4;

/// Estimates with a larger relative standard error than this are too few samples for a normal distribution.
const ENOUGH: f64 = 0.03;

/// The light, and whether each vertex between it and the camera is specular.
type Class = (usize, Vec<bool>);

/// What one batch found, by class: per technique without weights, and all together with them.
#[derive(Clone, Default)]
struct Found {
    alone: Vec<f64>,
    weighted: f64,
}

fn batch(world: &World, batch: u64, passes: u64) -> BTreeMap<Class, Found> {
    let scene = world.scene();
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options: options(LONGEST, Heuristic::Balance) };
    let mut found: BTreeMap<Class, Found> = BTreeMap::new();
    for pass in batch * passes..(batch + 1) * passes {
        for pixel in 0..pixels(world) {
            let tell = |sample: &volgrad::sampler::bidirectional::Sample| {
                let path = Path::new(world, sample);
                if (1..=path.length()).any(|i| path.distance(i) < SHORT) {
                    return;
                }
                let specular = (1..path.length()).map(|i| path.is_specular(i)).collect();
                let sum = found.entry((path.light, specular)).or_default();
                sum.alone.resize(path.length() + 1, 0.0);
                let value = luminance(sample.connection.value);
                sum.alone[sample.light.len()] += value;
                sum.weighted += value * sample.connection.weight;
                assert!(path.can_make(sample.light.len()));
            };
            each_technique(&sampler, pass, pixel, tell);
        }
    }
    found
}

/// Compares techniques with the weighted sum, relative to that, where both are known well enough. Returns which, as (specular vertices, s, t).
fn compare(name: &str, world: &World, passes: u64) -> BTreeSet<(usize, usize, usize)> {
    let half = |first: u64| (first..BATCHES).step_by(2).map(|i| batch(world, i, passes)).collect::<Vec<_>>();
    let batches: Vec<_> = std::thread::scope(|scope| {
        let odd = scope.spawn(|| half(1));
        half(0).into_iter().chain(odd.join().expect("a batch panicked")).collect()
    });
    let classes: BTreeSet<&Class> = batches.iter().flat_map(BTreeMap::keys).collect();
    let mut compared = BTreeSet::new();
    for class in classes {
        let of = |value: &dyn Fn(&Found) -> f64| Mean::of(batches.iter().map(|found| found.get(class).map_or(0.0, value)));
        let weighted = of(&|found| found.weighted);
        let (_, specular) = class;
        for s in 0..=specular.len() + 1 {
            let t = specular.len() + 2 - s;
            let alone = |found: &Found| found.alone.get(s).copied().unwrap_or(0.0);
            let difference = of(&|found| alone(found) - found.weighted);
            let error = difference.error / weighted.value;
            let few = error > ENOUGH || weighted.error > ENOUGH * weighted.value;
            // The only one has weight 1, but for rounding.
            if few || error < 1e-9 || of(&alone).value == 0.0 {
                continue;
            }
            let z = difference.value / difference.error;
            println!("{name}, {class:?}, ({s}, {t}): {:+.2} %, z {z:+.2}", 100.0 * difference.value / weighted.value);
            assert!(z.abs() < MOST);
            compared.insert((specular.iter().filter(|here| **here).count(), s, t));
        }
    }
    compared
}

fn compare_all(worlds: Vec<(&str, World)>) -> BTreeSet<(usize, usize, usize)> {
    worlds.iter().flat_map(|(name, world)| compare(name, world, 24 * scale())).collect()
}

#[test]
fn techniques_under_each_light() {
    let compared = compare_all(worlds::lights());
    // All of two and three edges, with one vertex that finds the light, and some of four.
    for (s, t) in [(0, 3), (1, 2), (2, 1), (0, 4), (1, 3), (2, 2), (3, 1), (0, 5), (1, 4)] {
        assert!(compared.contains(&(0, s, t)), "({s}, {t})");
    }
}

#[test]
fn techniques_through_each_camera() {
    compare_all(worlds::cameras());
}

#[test]
fn techniques_on_each_material() {
    compare_all(worlds::materials());
}

#[test]
fn techniques_in_each_medium() {
    compare_all(worlds::media());
}

/// Into glass and out of it, from both ends.
#[test]
fn techniques_through_glass() {
    let compared = compare_all(worlds::glass());
    for technique in [(1, 3, 1), (1, 4, 1), (2, 1, 4)] {
        assert!(compared.contains(&technique), "{technique:?}");
    }
}
