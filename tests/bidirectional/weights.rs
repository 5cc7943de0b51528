//! Path by path, for every connection of every technique: its value is f/p, its weight p/Σp or p²/Σp², with f and the p of all
//! techniques from `path`. So the weights of all techniques that could have made a path sum to 1.

use crate::path::Path;
use crate::toy::scenes::World;
use crate::{options, pixels, worlds};
use std::collections::BTreeSet;
use volgrad::sampler::Stats;
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic, Options, Sample, Subpath};

const LONGEST: u32 = 5;

/// Rays and segments are in single precision; a path of five edges has some ten such factors, and 1/cos of some, which weights have on both
/// sides.
const ROUNDING: f64 = 1e-4;
const ROUNDING_OF_WEIGHTS: f64 = 1e-5;

/// Tells all connections of some samples, without roulette: that is in values, but in no density.
fn each(world: &World, heuristic: Heuristic, passes: u64, mut tell: impl FnMut(&Sample)) {
    let scene = world.scene();
    let options = Options { rr_depth: 99, ..options(LONGEST, heuristic) };
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    let (mut camera, mut light) = (Subpath::default(), Subpath::default());
    for pass in 0..passes {
        for pixel in 0..pixels(world) {
            let stats = &mut Stats::default();
            sampler.sample(pass, pixel, &mut camera, &mut light, stats, &mut tell).expect("the toy host never stops");
        }
    }
}

/// The largest relative errors of values and weights, over all connections, and which techniques and specular vertices were among them.
#[derive(Default)]
struct Seen {
    value: f64,
    weight: f64,
    count: u32,
    techniques: BTreeSet<(usize, usize)>,
    /// Specular vertices of a path.
    chains: BTreeSet<usize>,
}

fn check(world: &World, heuristic: Heuristic) -> Seen {
    let mut seen = Seen::default();
    each(world, heuristic, 40, |sample| {
        let path = Path::new(world, sample);
        let s = sample.light.len();
        let densities = path.densities();
        let power = |p: &f64| if heuristic == Heuristic::Power { p * p } else { *p };
        let weight = power(&densities[s]) / densities.iter().map(power).sum::<f64>();
        let expected = path.contribution() / densities[s];
        let found = sample.connection;
        let error = ((found.value - expected).abs() / expected.max_element().max(f64::MIN_POSITIVE)).max_element();
        let weight_error = (found.weight / weight - 1.0).abs();
        // Where a vertex is next to another, single precision knows little of what is between them.
        if (1..=path.length()).any(|i| path.distance(i) < 0.02) || path.is_between_cells() {
            return;
        }
        seen.value = worse(seen.value, error);
        seen.weight = worse(seen.weight, weight_error);
        seen.count += 1;
        seen.techniques.insert((s, sample.camera.len()));
        seen.chains.insert((1..path.length()).filter(|i| path.is_specular(*i)).count());
    });
    seen
}

/// NaN is worst.
fn worse(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

fn check_all(worlds: Vec<(&str, World)>) -> Seen {
    let mut all = Seen::default();
    for (name, world) in worlds {
        for heuristic in [Heuristic::Balance, Heuristic::Power] {
            let seen = check(&world, heuristic);
            println!(
                "{name}, {heuristic:?}: {} connections, values {:.1e}, weights {:.1e}",
                seen.count, seen.value, seen.weight
            );
            assert!(seen.value < ROUNDING && seen.weight < ROUNDING_OF_WEIGHTS && seen.count > 500, "{name}, {heuristic:?}");
            all.techniques.extend(seen.techniques);
            all.chains.extend(seen.chains);
        }
    }
    all
}

#[test]
fn weights_under_each_light() {
    let seen = check_all(worlds::lights());
    // All but directly visible light, and the camera itself, which no path finds.
    let possible = (0..=5).flat_map(|s| (1..=6).map(move |t| (s, t))).filter(|(s, t)| (3..=6).contains(&(s + t)));
    assert_eq!(seen.techniques, possible.collect());
}

#[test]
fn weights_through_each_camera() {
    check_all(worlds::cameras());
}

#[test]
fn weights_on_each_material() {
    assert_eq!(check_all(worlds::materials()).chains, (0..=2).collect());
}

/// But where the density is the host's: what distances are sampled from is not quite that.
#[test]
fn weights_in_each_medium() {
    check_all(worlds::media().into_iter().filter(|(name, _)| *name != "custom").collect());
}

#[test]
fn weights_through_glass() {
    assert_eq!(check_all(worlds::glass()).chains, (0..=3).collect());
}

/// Whatever subpaths from lights are sent where, and with two lights of a guide each.
#[test]
fn weights_of_guided_subpaths() {
    check_all(worlds::guided());
}
