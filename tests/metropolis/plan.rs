//! How chains are shared out among path lengths.
//!
//! Significance: |z| < 4 at each of 9 lengths, twice: 18·6.3e-5 = 0.1 %. Seeds are fixed.

use volgrad::sampler::metropolis::{Plan, Start, Techniques};
use volgrad::sampler::{Lengths, line_numbers};

const LENGTHS: Lengths = Lengths { first: 2, last: 10 };
const SEEDS: u64 = 4000;
const SAMPLES: usize = 100;
/// 9 lengths of at least one chain, each by half a chain at most, and one chain for those that share.
const ROUNDINGS: usize = 5;

fn starts(seed: u64, weights: &[f32], wanted: u32) -> Vec<Start> {
    let mut starts = Vec::new();
    Plan::new(seed, &Techniques::alike(LENGTHS), weights, wanted).starts(weights, |start| starts.push(start));
    starts
}

/// Values over four orders of magnitude, so that some lengths are much brighter than others.
fn weights(seed: u64) -> Vec<f32> {
    let mut random = line_numbers(9, seed);
    (0..SAMPLES).map(|_| (9.0 * random()).exp() as f32).collect()
}

/// A length has its own chains, or one now and then that counts for more: in the mean, what its splats count for sums up to 1.
#[test]
fn each_length_counts_right_in_the_mean() {
    for wanted in [3, 12] {
        let lengths = LENGTHS.first..=LENGTHS.last;
        let mut sums = vec![[0.0; 2]; LENGTHS.last as usize + 1];
        let (mut alone, mut shared) = (0, 0);
        for seed in 0..SEEDS {
            let starts = starts(seed, &weights(seed), wanted);
            assert!(starts.len().abs_diff(wanted as usize) <= ROUNDINGS);
            for length in lengths.clone() {
                let of_length = || starts.iter().filter(|start| start.length == length);
                let counts: f64 = of_length().map(|start| start.share / f64::from(start.chains)).sum();
                if (counts - 1.0).abs() < 1e-9 {
                    alone += 1
                } else {
                    shared += 1
                }
                sums[length as usize][0] += counts;
                sums[length as usize][1] += counts * counts;
            }
        }
        assert!(alone > 100 && shared > 100, "{wanted}: {alone} {shared}");
        for length in lengths {
            let [mean, square] = sums[length as usize].map(|sum| sum / SEEDS as f64);
            let error = ((square - mean * mean) / SEEDS as f64).sqrt();
            println!("{wanted} chains, length {length}: {mean:.3} ± {error:.3}");
            assert!((mean - 1.0).abs() < 4.0 * error, "{wanted} chains, length {length}: {mean} ± {error}");
        }
    }
}
