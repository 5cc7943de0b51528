//! What chains begin with: independent samples, whose mean is the brightness b of each path length, and among which starts are chosen.
//!
//! A start is chosen in proportion to its value, and b is the mean of the same values: so the expected image is right from the first
//! mutation on [V97 11.3.1]. The balance heuristic needs b too, and there a start's own value must not be part of it: it would count for less
//! the brighter it is, and images with n samples per length would be darker by up to the probability of a large step over n.

use super::chain::ChainStats;
use super::numbers::capacity;
use super::path::{Scratch, make, target};
use super::techniques::Techniques;
use crate::math::{round, sqrt};
use crate::sampler::bidirectional::{MAX_LENGTH, Technique};
use crate::sampler::lengths::Lengths;
use crate::sampler::path_tracer::Stats;
use crate::sampler::primary::{bootstrap_numbers, plan_numbers};
use crate::scene::{Queries, Scene, Stop};

/// Numbers of any path.
pub type Numbers = [f64; capacity(MAX_LENGTH)];

/// The path length and the technique of sample `index`, and where its numbers come from. `seed` is that of the techniques.
fn sample(seed: u64, techniques: &Techniques, index: u64) -> (usize, Technique, impl FnMut() -> f64 + use<>) {
    let mut random = bootstrap_numbers(seed, index);
    let (length, technique) = techniques.pick(random(), random());
    (length, technique, random)
}

/// The path length, the technique and the numbers of sample `index`. `seed` is that of the techniques.
pub fn numbers(seed: u64, techniques: &Techniques, index: u64, numbers: &mut Numbers) -> (usize, Technique) {
    let (length, technique, mut random) = sample(seed, techniques, index);
    numbers.iter_mut().take(technique.numbers()).for_each(|number| *number = random());
    (length, technique)
}

/// The values of `weights.len()` samples from number `first` on.
pub fn run<Q: Queries>(
    scene: &Scene,
    queries: &Q,
    seed: u64,
    techniques: &Techniques,
    first: u64,
    weights: &mut [f32],
    stats: &mut Stats,
    chain_stats: &mut ChainStats,
) -> Result<(), Stop> {
    let (mut room, mut numbers) = (Scratch::default(), [0.0; capacity(MAX_LENGTH)]);
    let seed = techniques.seed(seed);
    for (index, weight) in (first..).zip(weights) {
        let (length, technique) = self::numbers(seed, techniques, index, &mut numbers);
        let path = make(scene, queries, technique, numbers.get(..technique.numbers()).unwrap_or(&[]), &mut room, stats)?;
        let value = path.map_or(0.0, |path| target(&path) / techniques.probability(length, technique)) as f32;
        // A subnormal number has too few digits for a chain to know its path by.
        *weight = if value.is_normal() { value } else { 0.0 };
        chain_stats.samples += 1;
        chain_stats.dropped += u64::from(!value.is_finite());
    }
    Ok(())
}

/// How often to try each technique, as samples that tried all alike tell.
pub fn learn(seed: u64, lengths: Lengths, weights: &[f32]) -> Techniques {
    let alike = Techniques::alike(lengths);
    let seed = alike.seed(seed);
    let mut squares = [[0.0; MAX_LENGTH + 1]; MAX_LENGTH + 1];
    for (index, weight) in (0..).zip(weights) {
        let (length, technique, _) = sample(seed, &alike, index);
        let probability = alike.probability(length, technique);
        let value = f64::from(*weight) * probability;
        if let Some(square) = squares.get_mut(length).and_then(|of| of.get_mut(technique.camera - 1)) {
            *square += value * value / probability;
        }
    }
    Techniques::learned(lengths, |length, i| squares[length][i])
}

/// Brightness of one path length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Brightness {
    pub sum: f64,
    pub sum_of_squares: f64,
}

impl Brightness {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.sum_of_squares += value * value;
    }
}

/// What all chains begin with.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    seed: u64,
    /// That of the techniques.
    sample_seed: u64,
    techniques: Techniques,
    samples: u64,
    /// By length; of all that share chains.
    brightness: [Brightness; MAX_LENGTH + 1],
    shared: f64,
    /// How many chains each length gets, or at [`SHARED`] those that have less than one each get together.
    chains: [u32; MAX_LENGTH + 1],
    pub chain_count: u32,
}

/// No path has this length.
const SHARED: usize = 0;

/// Of sums over sums.
const ROUNDING: f64 = 1e-9;

/// Where a chain begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// Number of the sample.
    pub sample: u64,
    pub length: u32,
    /// Chains of all lengths over those of this one, in the mean: what a splat of it counts for.
    pub share: f64,
    /// Chains of all lengths.
    pub chains: u32,
    /// b of this length, and as the other samples alone tell it.
    pub brightness: f64,
    pub others: f32,
    /// What the chain should find there, so that it knows whether it has the scene, the seed and the techniques of the samples.
    pub value: f64,
}

impl Plan {
    /// `weights` are those of the samples from number 0 on.
    pub fn new(seed: u64, techniques: &Techniques, weights: &[f32], chain_count: u32) -> Self {
        let mut plan = Self {
            seed,
            sample_seed: techniques.seed(seed),
            techniques: *techniques,
            samples: weights.len() as u64,
            brightness: [Brightness::default(); MAX_LENGTH + 1],
            shared: 0.0,
            chains: [0; MAX_LENGTH + 1],
            chain_count: 0,
        };
        for (index, weight) in (0..).zip(weights) {
            let (length, ..) = sample(plan.sample_seed, techniques, index);
            plan.brightness[length.min(MAX_LENGTH)].add(f64::from(*weight));
        }
        plan.share_out(chain_count);
        plan
    }

    /// b of all lengths together.
    pub fn brightness(&self) -> f64 {
        self.brightness.iter().map(|length| length.sum).sum::<f64>() / self.samples.max(1) as f64
    }

    /// Its standard error, relative.
    pub fn relative_error(&self) -> f64 {
        let (b, n) = (self.brightness(), self.samples as f64);
        let square = self.brightness.iter().map(|length| length.sum_of_squares).sum::<f64>() / n;
        if b > 0.0 { sqrt((square / (b * b) - 1.0).max(0.0) / (n - 1.0).max(1.0)) } else { 0.0 }
    }

    /// Chains in proportion to brightness. Lengths too dark for one share what is left of those wanted, but at least one.
    fn share_out(&mut self, wanted: u32) {
        let all: f64 = self.brightness.iter().map(|length| length.sum).sum();
        let chains = |sum: f64| f64::from(wanted) * sum / all;
        for (count, length) in self.chains.iter_mut().zip(&self.brightness).filter(|(_, length)| length.sum > 0.0) {
            if chains(length.sum) > 1.0 - ROUNDING {
                *count = round(chains(length.sum)) as u32;
            } else {
                self.shared += length.sum;
            }
        }
        if self.shared > 0.0 {
            self.chains[SHARED] = wanted.saturating_sub(self.chains.iter().sum()).max(1);
        }
        self.chain_count = self.chains.iter().sum();
    }

    /// The start of each chain, evenly spread over the sum of its length's values, or of all that share chains, from a random place on. As the
    /// samples go, lengths mixed.
    pub fn starts(&self, weights: &[f32], mut tell: impl FnMut(Start)) {
        let mut random = plan_numbers(self.seed);
        // How much of each sum has passed, in chains; a chain starts wherever this passes a whole number.
        let mut passed = [0.0; MAX_LENGTH + 1];
        passed.iter_mut().for_each(|passed| *passed = random());
        let mut begun = [0; MAX_LENGTH + 1];
        let mut last = [Start::default(); MAX_LENGTH + 1];
        for (index, weight) in (0..).zip(weights) {
            let (length, ..) = sample(self.sample_seed, &self.techniques, index);
            let length = length.min(MAX_LENGTH);
            let sum = self.brightness[length].sum;
            if !(*weight > 0.0) {
                continue;
            }
            let (place, of) = if self.chains[length] > 0 { (length, sum) } else { (SHARED, self.shared) };
            let chains = f64::from(self.chains[place]);
            let value = f64::from(*weight) * self.techniques.of_length(length);
            let start = Start {
                sample: index,
                length: length as u32,
                share: f64::from(self.chain_count) / (chains * sum / of),
                chains: self.chain_count,
                brightness: sum / self.samples as f64,
                others: ((sum - f64::from(*weight)).max(0.0) / (self.samples as f64 - 1.0).max(1.0)) as f32,
                value,
            };
            last[place] = start;
            passed[place] += chains * f64::from(*weight) / of;
            while begun[place] < self.chains[place] && passed[place] >= f64::from(begun[place] + 1) {
                tell(start);
                begun[place] += 1;
            }
        }
        // Rounding can leave the last one out.
        for (place, start) in last.iter().enumerate() {
            (begun[place]..self.chains[place]).for_each(|_| tell(*start));
        }
    }
}
