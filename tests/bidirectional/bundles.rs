//! What a bundle takes of a sample and what it leaves, against the sum of all that the sample's techniques make.

use crate::toy::batch::splats;
use crate::toy::scenes::{
    World, edges_under_area_lights, edges_under_point_light, edges_with_rough_surfaces, edges_with_specular_surfaces,
};
use crate::{each_technique, options, pixels, worlds};
use volgrad::math::Colour;
use volgrad::sampler::bidirectional::{Bidirectional, Bundle, Heuristic, Joined, MOST_LIGHT_VERTICES, Options};
use volgrad::shift::{self, Kernel, Mode, Radius};

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

/// One contribution alone in a bundle moves as the whole path does that a chain shifts, by a run of one vertex: all members get the same
/// splats in every mode, whether it leaves by an exit, onwards or through specular surfaces.
#[test]
fn a_contribution_alone_moves_like_its_path() {
    let modes = [Mode::FirstOrder, Mode::LinearDepth, Mode::TwoLevel, Mode::Exact, Mode::Exchangeable];
    let kernels = [Kernel::Disk(Radius::Pixels(0.7)), Kernel::Tile];
    let (mut exits, mut onwards, mut chains) = (0, 0, 0);
    let specular = ("edges with specular surfaces", edges_with_specular_surfaces());
    for (name, world) in worlds::media().into_iter().chain(worlds::materials()).chain([specular]) {
        let scene = world.scene();
        for (mode, kernel) in modes.into_iter().flat_map(|mode| kernels.map(|kernel| (mode, kernel))) {
            let shift = shift::Options { exact_count: 2, ..shift::Options::new(mode, kernel, 8) };
            let options = Options { shift: Some(shift), ..options(4, Heuristic::Balance) };
            let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
            let (mut bundle, mut whole) = (Bundle::default(), None);
            let mut worst = 0.0_f64;
            for (pass, pixel) in (0..6).flat_map(|pass| (0..pixels(&world)).map(move |pixel| (pass, pixel))) {
                each_technique(&sampler, pass, pixel, |sample| {
                    let joined =
                        Joined { scene: &scene, camera: sample.camera, light: sample.light, connection: &sample.connection };
                    bundle.clear();
                    bundle.add(&joined, &world.geometry, &shift).expect("the toy host never stops");
                    let moves = joined.moves(&shift)
                        && joined.prepare(&world.geometry, &shift, &mut whole).expect("the toy host never stops");
                    let alone = bundle.finish();
                    assert_eq!(alone.is_some(), moves, "{name}");
                    let (Some(alone), Some(whole)) = (alone, whole.as_ref().filter(|_| moves)) else { return };
                    exits += alone.exits().len();
                    onwards += usize::from(alone.onwards.is_some());
                    chains += usize::from(alone.chain.is_some());
                    let found = splats(&world, &shift, alone, u64::from(pixel));
                    let expected = splats(&world, &shift, whole, u64::from(pixel));
                    assert_eq!(found.len(), expected.len());
                    let largest = expected.iter().map(|(_, colour)| colour.abs().max_element()).fold(0.0, f64::max);
                    for ((p, a), (q, b)) in found.iter().zip(&expected) {
                        assert_eq!(p, q);
                        let error = (*a - *b).abs().max_element() / largest;
                        worst = if error > worst || error.is_nan() { error } else { worst };
                    }
                });
            }
            assert!(worst < ROUNDING, "{name}, {mode:?}, {kernel:?}: {worst:e}");
        }
    }
    assert!(exits > 1000 && onwards > 1000 && chains > 20, "{exits} exits, {onwards} onwards, {chains} chains");
}
