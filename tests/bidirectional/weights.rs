//! Path by path, for every connection of every technique: its value is f/p, its weight p/Σp or p²/Σp², with f and the p of all
//! techniques from `path`. So the weights of all techniques that could have made a path sum to 1.

use crate::path::Path;
use crate::toy::scenes::World;
use crate::{each_technique, options, pixels, worlds};
use std::collections::BTreeSet;
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic, MAX_LENGTH, MOST_LIGHT_VERTICES, Options, Sample};
use volgrad::shift::{self, Kernel, Mode};

const LONGEST: u32 = 5;

/// Rays and segments are in single precision; a path of five edges has some ten such factors, and 1/cos of some, which weights have on both
/// sides.
const ROUNDING: f64 = 1e-4;
const ROUNDING_OF_WEIGHTS: f64 = 1e-5;

/// Tells all connections of some samples, without roulette: that is in values, but in no density.
fn each(world: &World, options: Options, passes: u64, mut tell: impl FnMut(&Sample)) {
    let scene = world.scene();
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    for pass in 0..passes {
        for pixel in 0..pixels(world) {
            each_technique(&sampler, pass, pixel, &mut tell);
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

/// Of the techniques with as many vertices from the camera, and from a light: they alone make paths.
fn check(world: &World, options: Options, camera: usize, light: usize) -> Seen {
    let mut seen = Seen::default();
    let heuristic = options.heuristic;
    each(world, options, 40, |sample| {
        let path = Path::new(world, sample);
        let s = sample.light.len();
        assert!(s <= light && sample.camera.len() >= camera);
        let most = light.min(path.length() + 1 - camera);
        let densities = &path.densities()[..=most];
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
            let options = Options { rr_depth: 99, ..options(LONGEST, heuristic) };
            let seen = check(&world, options, 1, MAX_LENGTH);
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

/// Few vertices from lights, and none that the camera sees itself: what such techniques would have made is shared among the others.
#[test]
fn weights_of_few_techniques() {
    let shift = shift::Options::new(Mode::Exact, Kernel::Tile, 8);
    let shifts = (2, MOST_LIGHT_VERTICES, Some(shift));
    for (camera, light, shift) in [(1, 1, None), (1, 2, None), (1, 3, None), (2, 1, Some(shift)), shifts] {
        let mut techniques = BTreeSet::new();
        let worlds = worlds::lights().into_iter().chain(worlds::materials()).chain(worlds::glass());
        for (name, world) in worlds {
            for heuristic in [Heuristic::Balance, Heuristic::Power] {
                let options = Options { rr_depth: 99, light_vertices: light, shift, ..options(LONGEST, heuristic) };
                let seen = check(&world, options, camera, light);
                let Seen { value, weight, count, .. } = seen;
                println!("{name}, {heuristic:?}, ({light}, {camera}): {count}, values {value:.1e}, weights {weight:.1e}");
                assert!(value < ROUNDING && weight < ROUNDING_OF_WEIGHTS && count > 10, "{name}, {heuristic:?}");
                techniques.extend(seen.techniques);
            }
        }
        let possible = (0..=light).flat_map(|s| (camera..=6).map(move |t| (s, t))).filter(|(s, t)| (3..=6).contains(&(s + t)));
        assert_eq!(techniques, possible.collect());
    }
}
