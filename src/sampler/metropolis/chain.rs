//! A Markov chain over the paths of one length: Multiplexed Metropolis Light Transport. [HKD14]
//!
//! Differs from [HKD14]: small steps keep the technique, so that a chain has the numbers of one technique only and none that nothing reads;
//! large steps, whose samples are independent, count as such too, by the balance heuristic [K02].

use super::bootstrap::{self, Numbers, Start};
use super::numbers::{Technique, capacity, step};
use super::path::{Scratch, make, target};
use crate::film::Film;
use crate::math::{Colour, DVec2};
use crate::sampler::bidirectional::{Connection, MAX_LENGTH};
use crate::sampler::path_tracer::Stats;
use crate::sampler::primary::ChainNumbers;
use crate::scene::{Queries, Scene, Stop};

/// How chains move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    pub seed: u64,
    /// Probability of a large step.
    pub large_step: f64,
    /// Mutations before the first that counts, in which the size of small steps adapts.
    pub burn_in: u32,
}

/// What of a chain does not depend on its length. The numbers are beside it.
#[derive(Clone, Debug)]
pub struct State {
    pub index: u32,
    pub start: Start,
    pub mutations: u64,
    technique: Technique,
    random: ChainNumbers,
    /// Size of small steps.
    step: f64,
    /// How much of the current path is still to be splatted.
    pending: f64,
}

/// Counts of mutations, and of those accepted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainStats {
    pub large: u64,
    pub large_accepted: u64,
    pub small: u64,
    pub small_accepted: u64,
    /// Mutations to a path that carries nothing.
    pub dark: u64,
    pub burn_in: u64,
    /// Targets that were not finite.
    pub dropped: u64,
}

/// A chain at work.
pub struct Chain<'c, 'a, Q> {
    pub scene: &'a Scene<'a>,
    pub queries: &'a Q,
    pub options: Options,
    pub state: &'c mut State,
    pub numbers: &'c mut [f64],
}

/// A small step's best rate of acceptance, about, in many dimensions.
const TARGET_RATE: f64 = 0.3;
const FIRST_STEP: f64 = 0.02;
const STEPS: core::ops::RangeInclusive<f64> = 1e-4..=0.25;

/// A path of the chain, ready to be splatted.
#[derive(Clone, Copy)]
struct Current {
    target: f64,
    pixel: DVec2,
    /// w·f/p over the density of this path among a chain's samples: what it is worth each time that it comes.
    value: Colour,
}

impl Current {
    const DARK: Self = Self { target: 0.0, pixel: DVec2::ZERO, value: Colour::ZERO };
}

impl State {
    /// Chain number `index`. `numbers` has room for [`capacity`] of its length.
    pub fn new(options: &Options, index: u32, start: Start, numbers: &mut [f64]) -> Self {
        let mut all: Numbers = [0.0; capacity(MAX_LENGTH)];
        let technique = bootstrap::sample(options.seed, start.length as usize, start.sample, &mut all);
        numbers.iter_mut().zip(all).for_each(|(to, from)| *to = from);
        let random = ChainNumbers::new(options.seed, index);
        Self { index, start, mutations: 0, technique, random, step: FIRST_STEP, pending: 0.0 }
    }
}

impl<'a, Q: Queries> Chain<'_, 'a, Q> {
    /// Adapts the size of small steps, without splats.
    pub fn burn_in(&mut self, stats: &mut Stats, chain_stats: &mut ChainStats) -> Result<(), Stop> {
        let mut room = Scratch::default();
        let mut current = self.current(&mut room, stats)?;
        let mut ignored = ChainStats::default();
        for i in 0..self.options.burn_in {
            let step = self.mutate(&mut current, &mut room, stats, &mut ignored, &mut |_, _| {})?;
            chain_stats.burn_in += 1;
            if let Step::Small { acceptance } = step {
                let gain = 2.0 / (1.0 + f64::from(i) / 8.0);
                let size = self.state.step * libm::exp(gain * (acceptance - TARGET_RATE));
                self.state.step = size.clamp(*STEPS.start(), *STEPS.end());
            }
        }
        self.state.pending = 0.0;
        Ok(())
    }

    /// Makes `count` mutations. What they made of the path where the chain is now is kept for [`Chain::flush`].
    pub fn run(&mut self, count: u64, film: &mut Film, stats: &mut Stats, chain_stats: &mut ChainStats) -> Result<(), Stop> {
        let mut room = Scratch::default();
        let mut current = self.current(&mut room, stats)?;
        for _ in 0..count {
            self.mutate(&mut current, &mut room, stats, chain_stats, &mut |pixel, value| film.add(pixel, value))?;
            self.state.mutations += 1;
        }
        Ok(())
    }

    /// Splats what is due at the chain's current path, which stays as it is.
    pub fn flush(&mut self, film: &mut Film, stats: &mut Stats) -> Result<(), Stop> {
        let current = self.current(&mut Scratch::default(), stats)?;
        if self.state.pending > 0.0 {
            film.add(current.pixel, current.value * self.state.pending);
        }
        Ok(())
    }

    /// The path of the chain's numbers.
    fn current(&self, room: &mut Scratch<'a>, stats: &mut Stats) -> Result<Current, Stop> {
        let State { technique, .. } = *self.state;
        let numbers = self.numbers.get(..technique.numbers()).unwrap_or(&[]);
        let path = make(self.scene, self.queries, technique, numbers, room, stats)?;
        Ok(path.and_then(|path| self.weighed(&path)).unwrap_or(Current::DARK))
    }

    /// None: its target is not a positive number.
    fn weighed(&self, path: &Connection) -> Option<Current> {
        let Start { length, share, brightness, .. } = self.state.start;
        let techniques = Technique::count(length as usize) as f64;
        let target = target(path) * techniques;
        // Samples of the chain have the density target/b, those of large steps, among all mutations, the probability of one.
        let density = target / brightness + self.options.large_step;
        let value = path.value * (path.weight * techniques * share / density);
        (target > 0.0 && target.is_finite()).then_some(Current { target, pixel: path.pixel, value })
    }

    /// One mutation; splats what is certain: the path that is left for good, whichever of the two that is.
    fn mutate(
        &mut self,
        current: &mut Current,
        room: &mut Scratch<'a>,
        stats: &mut Stats,
        chain_stats: &mut ChainStats,
        splat: &mut impl FnMut(DVec2, Colour),
    ) -> Result<Step, Stop> {
        let Options { large_step, .. } = self.options;
        let mut random = self.state.random.clone();
        let mut numbers: Numbers = [0.0; capacity(MAX_LENGTH)];
        let large = random.next() < large_step;
        let technique =
            if large { Technique::pick(self.state.start.length as usize, random.next()) } else { self.state.technique };
        let size = self.state.step;
        for (to, from) in numbers.iter_mut().zip(self.numbers.iter()).take(technique.numbers()) {
            *to = if large { random.next() } else { step(*from, size, &mut || random.next()) };
        }
        let made = &numbers[..technique.numbers()];
        let path = make(self.scene, self.queries, technique, made, room, stats)?;
        let proposal = path.as_ref().and_then(|path| self.weighed(path));
        chain_stats.dropped += u64::from(path.is_some() && proposal.is_none());
        let target = proposal.map_or(0.0, |proposal| proposal.target);
        let acceptance = if current.target > 0.0 { (target / current.target).min(1.0) } else { 1.0 };
        let accepted = random.next() < acceptance;
        // No callback has stopped the mutation: it counts from here on.
        self.state.random = random;
        self.state.pending += 1.0 - acceptance;
        chain_stats.count(large, accepted, proposal.is_none());
        if let Some(proposal) = proposal {
            let weight = acceptance + if large { 1.0 } else { 0.0 };
            let (leaving, due) = if accepted {
                (core::mem::replace(current, proposal), core::mem::replace(&mut self.state.pending, weight))
            } else {
                (proposal, weight)
            };
            splat(leaving.pixel, leaving.value * due);
        }
        if accepted {
            self.state.technique = technique;
            self.numbers.iter_mut().zip(made).for_each(|(to, from)| *to = *from);
        }
        Ok(if large { Step::Large } else { Step::Small { acceptance } })
    }
}

enum Step {
    Large,
    Small { acceptance: f64 },
}

impl ChainStats {
    fn count(&mut self, large: bool, accepted: bool, dark: bool) {
        let (all, good) =
            if large { (&mut self.large, &mut self.large_accepted) } else { (&mut self.small, &mut self.small_accepted) };
        *all += 1;
        *good += u64::from(accepted);
        self.dark += u64::from(dark);
    }
}
