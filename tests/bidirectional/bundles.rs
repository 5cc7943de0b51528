//! What a bundle takes of a sample and what it leaves, against the sum of all that the sample's techniques make.

use crate::toy::scenes::{
    World, edges_under_area_lights, edges_under_point_light, edges_with_rough_surfaces, edges_with_specular_surfaces,
};
use crate::{each_technique, options, pixels, worlds};
use volgrad::math::Colour;
use volgrad::sampler::bidirectional::{Bidirectional, Bundle, Heuristic, Joined, MOST_LIGHT_VERTICES, Options};
use volgrad::shift::{self, Kernel, Mode};

/// Sums of products in another order, relative to the sum's brightest channel.
const ROUNDING: f64 = 1e-9;

/// How many contributions there were, by where they are kept, in samples whose first vertex may move.
#[derive(Default)]
struct Seen {
    samples: u32,
    exits: usize,
    wings: usize,
    chains: u32,
    /// The largest error.
    worst: f64,
    /// Of all samples: what moves, and everything.
    moving: Colour,
    all: Colour,
}

fn check(world: &World, mode: Mode, roulette: f64, passes: u64) -> Seen {
    let scene = world.scene();
    let shift = shift::Options::new(mode, Kernel::Tile, 8);
    let options = Options { shift: Some(shift), roulette, ..options(6, Heuristic::Balance) };
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    let mut seen = Seen::default();
    let mut bundle = Bundle::default();
    for pass in 0..passes {
        for pixel in 0..pixels(world) {
            bundle.clear();
            let mut sum = Colour::ZERO;
            each_technique(&sampler, pass, pixel, |sample| {
                let joined =
                    Joined { scene: &scene, camera: sample.camera, light: sample.light, connection: &sample.connection };
                sum += sample.connection.value * sample.connection.weight;
                bundle.add(&joined, &world.geometry, &shift).expect("the toy host never stops");
            });
            let plain = bundle.plain;
            let mut carried = Colour::ZERO;
            if let Some(path) = bundle.finish() {
                assert!(path.run().len() == 1 && path.exits().len() <= MOST_LIGHT_VERTICES);
                carried = path.carried(&scene);
                seen.samples += 1;
                seen.exits += path.exits().len();
                seen.wings += path.onwards.map_or(0, |onwards| onwards.wing_count);
                seen.chains += u32::from(path.chain.is_some());
            }
            let error = (carried + plain - sum).abs().max_element() / sum.max_element().max(f64::MIN_POSITIVE);
            seen.worst = if error > seen.worst || error.is_nan() { error } else { seen.worst };
            seen.moving += carried;
            seen.all += sum;
        }
    }
    seen
}

fn all_worlds() -> Vec<(&'static str, World)> {
    let toys = worlds::lights().into_iter().chain(worlds::cameras()).chain(worlds::materials()).chain(worlds::glass());
    let edges = [
        ("edges", edges_under_point_light()),
        ("edges under area lights", edges_under_area_lights()),
        ("edges with specular surfaces", edges_with_specular_surfaces()),
        ("edges with rough surfaces", edges_with_rough_surfaces()),
    ];
    toys.chain(worlds::media()).chain(edges).collect()
}

/// In each channel: nothing is lost, and nothing is counted twice.
#[test]
fn a_bundle_and_what_stays_are_the_sample() {
    let (mut exits, mut wings, mut chains) = (0, 0, 0);
    for (name, world) in all_worlds() {
        let modes = [(Mode::Exact, 0.0), (Mode::LinearDepth, 0.0), (Mode::Exchangeable, 0.1)];
        for (mode, roulette) in modes {
            let seen = check(&world, mode, roulette, 64);
            let moving = (seen.moving / seen.all).min_element();
            println!("{name}, {mode:?}: {} samples, {:.1e}, {:.0} % of them moves", seen.samples, seen.worst, 100.0 * moving);
            assert!(seen.worst < ROUNDING && seen.samples > 100, "{name}, {mode:?}: {:e}", seen.worst);
            (exits, wings, chains) = (exits + seen.exits, wings + seen.wings, chains + seen.chains);
        }
    }
    assert!(exits > 10_000 && wings > 10_000 && chains > 100, "{exits} exits, {wings} wings, {chains} chains");
}

/// With media, diffuse walls and an area light, every contribution moves.
#[test]
fn everything_moves_where_it_can() {
    for (name, world) in worlds::media() {
        let seen = check(&world, Mode::Exact, 0.0, 64);
        assert!((seen.moving / seen.all - 1.0).abs().max_element() < ROUNDING, "{name}");
    }
}
