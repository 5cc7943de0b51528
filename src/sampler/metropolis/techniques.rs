//! How often each technique is tried. Where one sample stands for many techniques the least noise comes from trying each in proportion to the
//! root of its mean squared value: that is learned from samples that tried all alike.

use crate::math::sqrt;
use crate::sampler::bidirectional::{MAX_LENGTH, Technique};
use crate::sampler::lengths::Lengths;
use crate::sampler::primary::mix;

/// Running sums of probabilities, the last 1. Entry i is for length i, or for the technique with i + 1 camera vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Shares(pub [f32; MAX_LENGTH + 1]);

/// The shares of path lengths, and of each length's techniques.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Techniques {
    lengths: Shares,
    of_length: [Shares; MAX_LENGTH + 1],
}

/// The part of all tries that goes to all alike: what was dark so far need not be, and then counts by one over its small probability. With 0.1
/// the error of b is up to three times as large (in a dense cloud), with 0.6 up to twice (in a room lit through a window).
const ALL_ALIKE: f64 = 0.3;

impl Shares {
    fn new(weight: impl Fn(usize) -> f64) -> Self {
        let total: f64 = (0..=MAX_LENGTH).map(&weight).sum();
        let mut sums = [1.0; MAX_LENGTH + 1];
        let mut sum = 0.0;
        for (i, slot) in sums.iter_mut().enumerate() {
            sum += weight(i);
            *slot = if sum < total { (sum / total) as f32 } else { 1.0 };
        }
        Self(sums)
    }

    pub fn pick(&self, u: f64) -> usize {
        self.0.partition_point(|sum| f64::from(*sum) <= u).min(MAX_LENGTH)
    }

    pub fn probability(&self, i: usize) -> f64 {
        let sum = |i: usize| self.0.get(i).map_or(1.0, |sum| f64::from(*sum));
        sum(i) - i.checked_sub(1).map_or(0.0, sum)
    }

    /// A technique that makes paths of `length` edges.
    pub fn technique(&self, length: usize, u: f64) -> Technique {
        let camera = 1 + self.pick(u).min(length);
        Technique { camera, light: length + 1 - camera }
    }

    pub fn of_technique(&self, technique: Technique) -> f64 {
        self.probability(technique.camera - 1)
    }
}

impl Techniques {
    /// All lengths alike, and all techniques of each.
    pub fn alike(lengths: Lengths) -> Self {
        let one_if = |yes: bool| if yes { 1.0 } else { 0.0 };
        Self {
            lengths: Shares::new(|length| one_if(lengths.contains(length as u32))),
            of_length: core::array::from_fn(|length| Shares::new(|i| one_if(i <= length))),
        }
    }

    /// From the mean squares of the values that techniques made, `squares(length, camera vertices − 1)`.
    pub fn learned(lengths: Lengths, squares: impl Fn(usize, usize) -> f64) -> Self {
        let root = |length: usize, i: usize| if i <= length { sqrt(squares(length, i).max(0.0)) } else { 0.0 };
        let of = |length: usize| (0..=length).map(|i| root(length, i)).sum::<f64>();
        let known = |length: &usize| lengths.contains(*length as u32);
        let total: f64 = (0..=MAX_LENGTH).filter(known).map(of).sum();
        if !(total > 0.0) {
            return Self::alike(lengths);
        }
        let mixed = |own: f64, all: f64, count: usize| {
            let own = if all > 0.0 { own / all } else { 1.0 / count as f64 };
            ALL_ALIKE / count as f64 + (1.0 - ALL_ALIKE) * own
        };
        let count = (lengths.last - lengths.first + 1) as usize;
        let of_length = core::array::from_fn(|length| {
            let all = of(length);
            Shares::new(|i| if i <= length { mixed(root(length, i), all, length + 1) } else { 0.0 })
        });
        let lengths = Shares::new(|length| if known(&length) { mixed(of(length), total, count) } else { 0.0 });
        Self { lengths, of_length }
    }

    /// The seed of the samples that are made with these shares. Those that a table was learned from are of another one, and independent:
    /// if they came again, the brightest would be tried most and counted least.
    pub fn seed(&self, seed: u64) -> u64 {
        let rows = core::iter::once(&self.lengths).chain(&self.of_length);
        rows.flat_map(|shares| shares.0).fold(seed, |seed, share| mix(seed ^ u64::from(share.to_bits())))
    }

    /// The shares of a length's techniques.
    pub fn shares(&self, length: usize) -> &Shares {
        &self.of_length[length.min(MAX_LENGTH)]
    }

    /// A path length and a technique for it, from two uniform numbers.
    pub fn pick(&self, u: f64, v: f64) -> (usize, Technique) {
        let length = self.lengths.pick(u);
        (length, self.shares(length).technique(length, v))
    }

    pub fn of_length(&self, length: usize) -> f64 {
        self.lengths.probability(length)
    }

    pub fn probability(&self, length: usize, technique: Technique) -> f64 {
        self.of_length(length) * self.shares(length).of_technique(technique)
    }
}
