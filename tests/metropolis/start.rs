//! The expected image is right from the first mutation on, however few samples chains begin with; and as exact as the bootstrap says.
//!
//! b is the mean of independent samples, and so without bias. How an image's mean differs from its own b is what chains can do wrong: that
//! is known to less than 0.1 % where the image itself is to 1 %.

use crate::chains::{Chains, Setup};
use crate::toy::estimate::{Mean, scale};
use crate::toy::scenes::{World, edges_under_area_lights};
use crate::unbiased_shifts;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::ops::Range;
use volgrad::sampler::Lengths;

const LENGTHS: Lengths = Lengths { first: 2, last: 5 };

/// As few samples as make any sense.
const TINY: Setup = Setup { lengths: LENGTHS, learn: 0, samples: 50, chains: 4, large_step: 0.3, burn_in: 0 };

/// Of one comparison; there are six, so all fail with a probability of 4e-4 for a new seed.
const MOST: f64 = 4.0;

/// What `of` says of each seed's chains, on two threads.
fn of_seeds<T: Send>(world: &World, setup: &Setup, seeds: Range<u64>, of: impl Fn(&Chains) -> T + Sync) -> Vec<T> {
    let half =
        |first| seeds.clone().skip(first).step_by(2).map(|seed| of(&Chains::new(world, setup, seed))).collect::<Vec<_>>();
    std::thread::scope(|scope| {
        let odd = scope.spawn(|| half(1));
        let mut all = half(0);
        all.extend(odd.join().expect("a seed panicked"));
        all
    })
}

/// The mean image less b, in units of the mean b.
fn beside_b(setup: &Setup, seeds: u64, mutations: u64, shift: Option<volgrad::shift::Options>, every: u32) {
    let world = edges_under_area_lights();
    let found = of_seeds(&world, setup, 0..seeds * scale(), |chains| {
        let image = chains.film(shift, every, mutations).mean(chains.scale(mutations));
        (image - chains.brightness, chains.brightness)
    });
    let (difference, b) = (Mean::of(found.iter().map(|f| f.0)), Mean::of(found.iter().map(|f| f.1)));
    let z = difference.z_to(0.0);
    println!("{:+.3} % ± {:.3} % of b, z {z:+.2}", 100.0 * difference.value / b.value, 100.0 * difference.error / b.value);
    assert!(z.abs() < MOST);
}

#[test]
fn three_mutations_without_burn_in() {
    beside_b(&TINY, 2500, 3, None, 1);
}

#[test]
fn a_chain_that_hardly_leaves_its_start() {
    beside_b(&Setup { large_step: 0.02, ..TINY }, 2500, 3, None, 1);
}

#[test]
fn after_burn_in() {
    beside_b(&Setup { burn_in: 50, ..TINY }, 800, 4, None, 1);
}

/// Batches that count 3 times, in 4 mutations: one or two.
#[test]
fn any_number_of_mutations_counts_right() {
    beside_b(&TINY, 1200, 4, Some(unbiased_shifts()[3]), 3);
}

/// How often techniques are tried was learned from other samples: the mean b is that without a table.
#[test]
fn learning_does_not_bias() {
    let world = edges_under_area_lights();
    let b = |learn, samples, seeds: Range<u64>| {
        let setup = Setup { learn, samples, chains: 1, ..TINY };
        Mean::of(of_seeds(&world, &setup, seeds, |chains| chains.brightness).into_iter())
    };
    let first = 1 << 32;
    let (alike, learned) = (b(0, 100, first..first + 1000 * scale()), b(50, 50, 0..1000 * scale()));
    let z = (learned.value - alike.value) / learned.error.hypot(alike.error);
    println!("{:.5} ± {:.5} against {:.5} ± {:.5}, z {z:+.2}", learned.value, learned.error, alike.value, alike.error);
    assert!(z.abs() < MOST);
}

/// Images of 40 seeds scatter as the bootstrap's relative error says: chi-square, 1e-4 on either side, and a tenth more for what chains add.
#[test]
fn seeds_differ_as_much_as_the_bootstrap_says() {
    const SEEDS: u64 = 40;
    let world = edges_under_area_lights();
    let setup = Setup { learn: 500, samples: 2000, chains: 8, burn_in: 20, ..TINY };
    let found =
        of_seeds(&world, &setup, 0..SEEDS, |chains| (chains.film(None, 1, 100).mean(chains.scale(100)), chains.relative_error));
    let mean = Mean::of(found.iter().map(|f| f.0));
    let predicted = found.iter().map(|f| f.1 * f.1).sum::<f64>() / SEEDS as f64;
    let ratio = mean.error * mean.error * SEEDS as f64 / (mean.value * mean.value) / predicted;
    let chi = ChiSquared::new((SEEDS - 1) as f64).expect("there are some");
    let (least, most) = (chi.inverse_cdf(1e-4) / (SEEDS - 1) as f64, 1.1 * chi.inverse_cdf(1.0 - 1e-4) / (SEEDS - 1) as f64);
    println!(
        "variance over what was predicted {ratio:.2}, between {least:.2} and {most:.2}; error {:.2} %",
        100.0 * predicted.sqrt()
    );
    assert!(least < ratio && ratio < most);
}
