//! What chains begin with: independent samples, whose mean is the brightness b of each path length, and among which starts are chosen.
//!
//! A start is chosen in proportion to its value, and b is the mean of the same values: so the expected image is right from the first
//! mutation on. [V97 11.3.1]

use super::numbers::{Technique, capacity};
use super::path::{Scratch, make, target};
use crate::sampler::bidirectional::MAX_LENGTH;
use crate::sampler::path_tracer::{Lengths, Stats};
use crate::sampler::primary::{bootstrap_numbers, plan_numbers};
use crate::scene::{Queries, Scene, Stop};

/// Numbers of any path.
pub type Numbers = [f64; capacity(MAX_LENGTH)];

/// The path length of sample number `index`: all take turns.
pub fn length(lengths: Lengths, index: u64) -> usize {
    (u64::from(lengths.first) + index % u64::from(lengths.last - lengths.first + 1)) as usize
}

/// The technique and the numbers of sample `index`, to make a path of `length` edges.
pub fn sample(seed: u64, length: usize, index: u64, numbers: &mut Numbers) -> Technique {
    let mut random = bootstrap_numbers(seed, index);
    let technique = Technique::pick(length, random());
    numbers.iter_mut().take(technique.numbers()).for_each(|number| *number = random());
    technique
}

/// The values of `weights.len()` samples from number `first` on.
pub fn run<Q: Queries>(
    scene: &Scene,
    queries: &Q,
    seed: u64,
    lengths: Lengths,
    first: u64,
    weights: &mut [f32],
    stats: &mut Stats,
) -> Result<(), Stop> {
    let (mut room, mut numbers) = (Scratch::default(), [0.0; capacity(MAX_LENGTH)]);
    for (index, weight) in (first..).zip(weights) {
        let length = length(lengths, index);
        let technique = sample(seed, length, index, &mut numbers);
        let path = make(scene, queries, technique, &numbers[..technique.numbers()], &mut room, stats)?;
        let value = path.map_or(0.0, |path| target(&path) * Technique::count(length) as f64) as f32;
        *weight = if value.is_finite() { value } else { 0.0 };
    }
    Ok(())
}

/// Brightness of one path length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Brightness {
    pub count: u64,
    pub sum: f64,
    pub sum_of_squares: f64,
}

impl Brightness {
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value;
        self.sum_of_squares += value * value;
    }

    pub fn mean(&self) -> f64 {
        if self.count > 0 { self.sum / self.count as f64 } else { 0.0 }
    }

    /// Squared standard error of the mean.
    pub fn variance(&self) -> f64 {
        let (n, mean) = (self.count as f64, self.mean());
        if self.count > 1 { (self.sum_of_squares / n - mean * mean).max(0.0) / (n - 1.0) } else { 0.0 }
    }
}

/// What all chains begin with.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    pub lengths: Lengths,
    pub by_length: [Brightness; MAX_LENGTH + 1],
    /// How many chains each length gets.
    pub chains: [u32; MAX_LENGTH + 1],
    pub chain_count: u32,
}

/// Where a chain begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// Number of the sample.
    pub sample: u64,
    pub length: u32,
    /// Chains of all lengths over those of this one: what a splat of it counts for.
    pub share: f64,
    /// Chains of all lengths.
    pub chains: u32,
    /// b of this length.
    pub brightness: f64,
}

impl Plan {
    /// `weights` are those of the samples from number 0 on.
    pub fn new(lengths: Lengths, weights: &[f32], chain_count: u32) -> Self {
        let mut plan =
            Self { lengths, by_length: [Brightness::default(); MAX_LENGTH + 1], chains: [0; MAX_LENGTH + 1], chain_count: 0 };
        for (index, weight) in (0..).zip(weights) {
            plan.by_length[length(lengths, index)].add(f64::from(*weight));
        }
        plan.share_out(chain_count);
        plan
    }

    /// b of all lengths together.
    pub fn brightness(&self) -> f64 {
        self.by_length.iter().map(Brightness::mean).sum()
    }

    /// Its standard error, relative.
    pub fn relative_error(&self) -> f64 {
        let b = self.brightness();
        if b > 0.0 { libm::sqrt(self.by_length.iter().map(Brightness::variance).sum()) / b } else { 0.0 }
    }

    /// Chains in proportion to brightness, one at least for each length that is not dark: so there can be more of them than wanted.
    fn share_out(&mut self, wanted: u32) {
        let b = self.brightness();
        for (chains, length) in self.chains.iter_mut().zip(&self.by_length) {
            if length.mean() > 0.0 {
                *chains = (libm::round(f64::from(wanted) * length.mean() / b) as u32).max(1);
                self.chain_count += *chains;
            }
        }
    }

    /// The start of each chain, chains of one length in a row: evenly spread over the samples' sum of values, from one random place on.
    pub fn starts(&self, seed: u64, weights: &[f32], mut tell: impl FnMut(Start)) {
        let mut random = plan_numbers(seed);
        for length in self.lengths.first..=self.lengths.last {
            let u = random();
            let (chains, brightness) = (self.chains[length as usize], &self.by_length[length as usize]);
            let share = f64::from(self.chain_count) / f64::from(chains);
            let period = self.lengths.last - self.lengths.first + 1;
            let samples = (0u64..).zip(weights).skip((length - self.lengths.first) as usize).step_by(period as usize);
            let (mut sum, mut next) = (0.0, 0);
            let mut last = Start { length, share, chains: self.chain_count, brightness: brightness.mean(), ..Start::default() };
            for (sample, weight) in samples {
                if !(*weight > 0.0) {
                    continue;
                }
                (sum, last.sample) = (sum + f64::from(*weight), sample);
                while next < chains && sum * f64::from(chains) > (f64::from(next) + u) * brightness.sum {
                    tell(last);
                    next += 1;
                }
            }
            (next..chains).for_each(|_| tell(last));
        }
    }
}
