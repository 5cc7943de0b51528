//! The furnace: nothing absorbs and radiance 1 comes from everywhere, so that every pixel is 1. Chains render the shorter paths, the path
//! sampler all others: each length has to be rendered, and by one of them only.
//!
//! Significance: |z| < 4 for each of 3 channels, 3 times: a new seed trips one with probability 0.06 % if all is right (Student's t with 64
//! batches doubles that). Seeds are fixed. The standard error of the furnace's 1 is asserted to be below 0.4 %, with VOLGRAD_LONG below 0.1 %:
//! nearly all of it is the bootstrap's.

use crate::chains::{Chains, Setup};
use crate::toy::estimate::{BATCHES, Estimate, scale};
use crate::toy::scenes::{World, camera, homogeneous};
use crate::unbiased_shifts;
use volgrad::math::{Colour, DVec2};
use volgrad::sampler::{FirstVertices, Lengths, Options};
use volgrad::scene::Light;
use volgrad::shift;

const OF_CHAINS: Lengths = Lengths { first: 2, last: 6 };
const SETUP: Setup = Setup { lengths: OF_CHAINS, learn: 4000, samples: 8000, chains: 10, large_step: 0.3, burn_in: 30 };
const MUTATIONS: u64 = 200;
const PASSES: u64 = 64;

const LIMIT: f64 = 4.0;
const ENOUGH: f64 = 4e-3;
const ENOUGH_IF_LONG: f64 = 1e-3;

fn furnace() -> World {
    World::new(camera([0.1, 0.05, -2.5], 0.4, 4))
        .medium([-1.0; 3], [1.0; 3], homogeneous([0.9, 1.0, 1.1], [1.0; 3], 0.4))
        .light(Light::Environment { radiance: Colour::ONE }, 1.0)
}

/// One bootstrap for each batch.
fn chains(world: &World) -> Vec<Chains<'_>> {
    let setup = Setup { samples: SETUP.samples * scale() as usize, ..SETUP };
    let part = |batches: std::ops::Range<u64>| batches.map(|batch| Chains::new(world, &setup, 100 + batch)).collect::<Vec<_>>();
    std::thread::scope(|scope| {
        let second = scope.spawn(|| part(BATCHES / 2..BATCHES));
        let mut all = part(0..BATCHES / 2);
        all.extend(second.join().expect("a batch panicked"));
        all
    })
}

/// The paths that chains leave to the path sampler. Without absorption only the roulette ends one: 0.95^500 is nothing.
fn others(world: &World) -> Estimate {
    let options =
        Options { max_depth: 500, rr_depth: 4, seed: 23, shift: None, left_out: OF_CHAINS, first: FirstVertices::ALL };
    Estimate::of_path_tracer(world, options, PASSES * scale())
}

fn of_chains(world: &World, chains: &[Chains], shift: Option<shift::Options>) -> Estimate {
    let (every, mutations) = (if shift.is_some() { 4 } else { 1 }, MUTATIONS * scale());
    Estimate::of_batches(world, 1, |batch, film| {
        let chains = &chains[batch as usize];
        let picture = chains.film(shift, every, mutations);
        for (i, cell) in picture.cells.iter().enumerate() {
            let (x, y) = (i as u32 % film.width, i as u32 / film.width);
            film.add(DVec2::new(x.into(), y.into()) + 0.5, cell.value() * chains.scale(mutations));
        }
        film.dropped.add(picture.dropped.get() + picture.chain_stats.dropped);
        picture.stats
    })
}

#[test]
fn a_furnace() {
    let world = furnace();
    let (chains, others) = (chains(&world), others(&world));
    let [disk, .., tile, _] = unbiased_shifts();
    for shift in [None, Some(disk), Some(tile)] {
        let all = of_chains(&world, &chains, shift).plus(&others);
        let name = shift.map(|shift| shift.mode);
        for channel in 0..3 {
            let mean = all.channel(channel);
            println!("{name:?}, channel {channel}: {:.5} ± {:.5}, z {:+.2}", mean.value, mean.error, mean.z_to(1.0));
            let enough = if scale() > 1 { ENOUGH_IF_LONG } else { ENOUGH };
            assert!(mean.error < enough && mean.z_to(1.0).abs() < LIMIT);
        }
        assert_eq!(all.dropped, 0);
    }
}
