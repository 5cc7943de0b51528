//! A Markov chain over the paths of one length: Multiplexed Metropolis Light Transport. [HKD14]
//!
//! Differs from [HKD14]: small steps keep the technique, so that a chain has the numbers of one technique only and none that nothing reads;
//! large steps, whose samples are independent, count as such too, by the balance heuristic [KSKAC02].

use super::bootstrap::{self, Numbers, Start};
use super::numbers::{capacity, step};
use super::path::{Scratch, make, target};
use super::techniques::{Shares, Techniques};
use crate::film::Film;
use crate::math::{Colour, DVec2};
use crate::sampler::bidirectional::{Connection, Joined, MAX_LENGTH, Technique, thesis};
use crate::sampler::path_tracer::Stats;
use crate::sampler::primary::{ChainNumbers, chain_shift_numbers};
use crate::scene::{Queries, Scene, Stop};
use crate::shift::{self, Draw, Shiftable, Tile};

/// How chains move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    pub seed: u64,
    /// Probability of a large step.
    pub large_step: f64,
    /// Mutations before the first that counts, in which the size of small steps adapts.
    pub burn_in: u32,
    pub shift: Option<Batches>,
    /// T: of paths that move only every T-th mutation counts, T times. 1 without shifts.
    pub shift_every: u32,
}

/// What becomes of paths that may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Batches {
    Shifts(shift::Options),
    Thesis(thesis::Options),
}

/// What of a chain does not depend on its length. The numbers are beside it.
#[derive(Clone, Debug)]
pub struct State {
    pub index: u32,
    pub start: Start,
    /// How often large steps try the techniques.
    shares: Shares,
    /// Those that counted.
    pub mutations: u64,
    technique: Technique,
    random: ChainNumbers,
    /// Size of the largest small steps.
    step: f64,
    /// Which of `shift_every` mutations counts, in parts of all: by chance, so that any number of mutations counts right in the mean.
    phase: f64,
    /// How much of the current path is still to be splatted, and the mutation that made it.
    pending: f64,
    born: u64,
    /// Its f* over the technique's probability.
    target: f64,
}

/// Counts of samples before the chains, of mutations, and of those accepted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainStats {
    pub samples: u64,
    pub large: u64,
    pub large_accepted: u64,
    pub small: u64,
    pub small_accepted: u64,
    /// Mutations to a path that carries nothing.
    pub dark: u64,
    pub burn_in: u64,
    /// Paths whose value was not finite, among samples and mutations of all kinds.
    pub dropped: u64,
}

/// The sampler; one may be used by any number of threads, each with chains of its own.
#[derive(Clone, Copy, Debug)]
pub struct Metropolis<'a, Q> {
    pub scene: &'a Scene<'a>,
    pub queries: &'a Q,
    pub options: Options,
}

/// A small step's best rate of acceptance, about, in many dimensions.
const TARGET_RATE: f64 = 0.3;
const FIRST_STEP: f64 = 0.1;
/// Logarithm of the largest step's size over the smallest one's. Numbers that bear steps of very different sizes are in one path: with one size
/// for all, squared errors were 1.5 times (`room`) and 1.9 times (`caustic`) as large.
const STEP_RANGE: f64 = 4.0;
/// How fast the size adapts: by this much at first, by half after so many mutations.
const FIRST_GAIN: f64 = 2.0;
const GAIN_DECAY: f64 = 1.0 / 8.0;
const STEPS: core::ops::RangeInclusive<f64> = 1e-4..=0.5;

/// How much a path's value may differ between two evaluations of the same numbers, relative: on processors of another type rays can end a
/// little elsewhere. Another scene or table gives other values, to some of a plan's chains at least.
const SAME_VALUE: f64 = 1e-3;

/// A path of the chain, ready to be splatted.
struct Sample {
    target: f64,
    pixel: DVec2,
    /// w·f/p over the density of this path among a chain's samples: what it is worth each time that it comes.
    value: Colour,
    /// What it is worth as a large step's sample, over that.
    large: f64,
    /// The mutation that made it, and what can move of it.
    born: u64,
    shiftable: Option<Shiftable>,
    moves: bool,
}

impl Default for Sample {
    fn default() -> Self {
        Self { target: 0.0, pixel: DVec2::ZERO, value: Colour::ZERO, large: 0.0, born: 0, shiftable: None, moves: false }
    }
}

/// Room for the work on one mutation after another.
struct Room<'a> {
    paths: Scratch<'a>,
    numbers: Numbers,
    current: Sample,
    proposal: Sample,
    batch: shift::Scratch,
}

impl Default for Room<'_> {
    fn default() -> Self {
        Self {
            paths: Scratch::default(),
            numbers: [0.0; capacity(MAX_LENGTH)],
            current: Sample::default(),
            proposal: Sample::default(),
            batch: shift::Scratch::default(),
        }
    }
}

impl State {
    /// Chain number `index`. `numbers` has room for [`capacity`] of its length. None: the start is not one of these samples.
    pub fn new(options: &Options, techniques: &Techniques, index: u32, start: Start, numbers: &mut [f64]) -> Option<Self> {
        let mut all: Numbers = [0.0; capacity(MAX_LENGTH)];
        let (length, technique) = bootstrap::numbers(techniques.seed(options.seed), techniques, start.sample, &mut all);
        let shares = *techniques.shares(start.length as usize);
        numbers.iter_mut().zip(all).for_each(|(to, from)| *to = from);
        let mut random = ChainNumbers::new(options.seed, index);
        let phase = random.next();
        (length == start.length as usize).then_some(Self {
            index,
            start,
            shares,
            mutations: 0,
            technique,
            random,
            step: FIRST_STEP,
            phase,
            pending: 0.0,
            born: 0,
            target: start.value,
        })
    }
}

/// A mutation that has been decided, but not made.
struct Decision {
    large: bool,
    acceptance: f64,
    accepted: bool,
    dark: bool,
    dropped: bool,
    technique: Technique,
    random: ChainNumbers,
}

impl<'a, Q: Queries> Metropolis<'a, Q> {
    /// Adapts the size of a new chain's small steps, without splats.
    pub fn burn_in(
        &self,
        state: &mut State,
        numbers: &mut [f64],
        stats: &mut Stats,
        chain_stats: &mut ChainStats,
    ) -> Result<(), Stop> {
        let mut room = self.begin(state, numbers, stats)?;
        for i in 0..self.options.burn_in {
            let decision = self.decide(state, numbers, &mut room, stats)?;
            chain_stats.burn_in += 1;
            chain_stats.dropped += u64::from(decision.dropped);
            if !decision.large {
                let gain = FIRST_GAIN / (1.0 + f64::from(i) * GAIN_DECAY);
                let size = state.step * libm::exp(gain * (decision.acceptance - TARGET_RATE));
                state.step = size.clamp(*STEPS.start(), *STEPS.end());
            }
            self.make(decision, state, numbers, &mut room);
        }
        Ok(())
    }

    /// Makes `count` mutations. What they made of the path where the chain is now is kept for [`Metropolis::flush`].
    pub fn run(
        &self,
        state: &mut State,
        numbers: &mut [f64],
        count: u64,
        film: &mut Film,
        stats: &mut Stats,
        chain_stats: &mut ChainStats,
    ) -> Result<(), Stop> {
        let mut room = self.begin(state, numbers, stats)?;
        let every = u64::from(self.options.shift_every);
        let phase = (state.phase * every as f64) as u64;
        for _ in 0..count {
            // Only what moves costs a batch: whether a path does depends on the path alone.
            let of_batches = if state.mutations % every == phase { every as f64 } else { 0.0 };
            let worth = |sample: &Sample| if sample.moves { of_batches } else { 1.0 };
            let decision = self.decide(state, numbers, &mut room, stats)?;
            // The path that is left for good, whichever of the two that is, can be splatted. A callback can stop that, but only before
            // the first splat: nothing has changed then.
            let stay = state.pending + worth(&room.current) * (1.0 - decision.acceptance);
            let come = worth(&room.proposal) * (decision.acceptance + if decision.large { room.proposal.large } else { 0.0 });
            let (left, made, due) = if decision.accepted {
                (&room.current, (state.technique, &*numbers), stay)
            } else {
                (&room.proposal, (decision.technique, &room.numbers[..]), come)
            };
            self.splat(state, left, made, due, &mut room.batch, film, stats)?;
            state.pending = if decision.accepted { come } else { stay };
            state.mutations += 1;
            chain_stats.count(&decision);
            self.make(decision, state, numbers, &mut room);
        }
        Ok(())
    }

    /// Splats what is due at the chain's current path, which stays as it is.
    pub fn flush(&self, state: &State, numbers: &[f64], film: &mut Film, stats: &mut Stats) -> Result<(), Stop> {
        if !(state.pending > 0.0) {
            return Ok(());
        }
        let mut room = self.begin(state, numbers, stats)?;
        self.splat(state, &room.current, (state.technique, numbers), state.pending, &mut room.batch, film, stats)
    }

    /// At the path of the chain's numbers. It stops if that is another one than it was.
    fn begin(&self, state: &State, numbers: &[f64], stats: &mut Stats) -> Result<Room<'a>, Stop> {
        let mut room = Room::default();
        let numbers = numbers.get(..state.technique.numbers()).unwrap_or(&[]);
        self.sample(state, state.technique, numbers, &mut room.paths, &mut room.current, stats)?;
        room.current.born = state.born;
        let same = (room.current.target - state.target).abs() <= SAME_VALUE * state.target;
        if same { Ok(room) } else { Err(Stop::OtherPath) }
    }

    /// Evaluates a technique at some numbers.
    fn sample(
        &self,
        state: &State,
        technique: Technique,
        numbers: &[f64],
        paths: &mut Scratch<'a>,
        sample: &mut Sample,
        stats: &mut Stats,
    ) -> Result<(), Stop> {
        (sample.target, sample.moves) = (0.0, false);
        let Some(path) = make(self.scene, self.queries, technique, numbers, paths, stats)? else { return Ok(()) };
        let Start { share, brightness, others, .. } = state.start;
        let probability = state.shares.of_technique(technique);
        let target = target(&path) / probability;
        if !target.is_finite() {
            sample.target = f64::NAN;
            return Ok(());
        }
        // Samples of the chain have the density target/b, those of large steps, among all mutations, the probability of one. Their weights
        // sum to 1 in the mean over bootstraps.
        let density = |b: f64| target / brightness + self.options.large_step * b / brightness;
        let value = path.value * (path.weight * share / (probability * density(others.into())));
        (sample.target, sample.pixel, sample.value) = (target, path.pixel, value);
        sample.large = density(others.into()) / density(brightness);
        let connection = Connection { value, weight: 1.0, ..path };
        let (camera, light) = (paths.camera.vertices(), paths.light.vertices());
        let joined = Joined { scene: self.scene, camera, light, connection: &connection };
        sample.moves = match &self.options.shift {
            Some(Batches::Shifts(options)) => joined.prepare(self.queries, options, &mut sample.shiftable)?,
            Some(Batches::Thesis(_)) => joined.is_available(),
            None => false,
        };
        Ok(())
    }

    /// Proposes a path and decides about it, without a change of the chain.
    fn decide(&self, state: &State, numbers: &[f64], room: &mut Room<'a>, stats: &mut Stats) -> Result<Decision, Stop> {
        let mut random = state.random.clone();
        let large = random.next() < self.options.large_step;
        let technique =
            if large { state.shares.technique(state.start.length as usize, random.next()) } else { state.technique };
        let count = technique.numbers();
        let size = state.step * libm::exp(-STEP_RANGE * random.next());
        for (to, from) in room.numbers.iter_mut().zip(numbers).take(count) {
            *to = if large { random.next() } else { step(*from, size, &mut || random.next()) };
        }
        let made = room.numbers.get(..count).unwrap_or(&[]);
        self.sample(state, technique, made, &mut room.paths, &mut room.proposal, stats)?;
        room.proposal.born = state.mutations + 1;
        let (target, current) = (room.proposal.target, room.current.target);
        let acceptance = if target > 0.0 && current > 0.0 { (target / current).min(1.0) } else { f64::from(target > 0.0) };
        let accepted = random.next() < acceptance;
        let (dark, dropped) = (target == 0.0, target.is_nan());
        Ok(Decision { large, acceptance, accepted, dark, dropped, technique, random })
    }

    fn make(&self, decision: Decision, state: &mut State, numbers: &mut [f64], room: &mut Room<'a>) {
        state.random = decision.random;
        if decision.accepted {
            state.technique = decision.technique;
            state.born = room.proposal.born;
            state.target = room.proposal.target;
            numbers.iter_mut().zip(&room.numbers).take(decision.technique.numbers()).for_each(|(to, from)| *to = *from);
            core::mem::swap(&mut room.current, &mut room.proposal);
        }
    }

    /// Splats a path, made by a technique of some numbers.
    fn splat(
        &self,
        state: &State,
        sample: &Sample,
        made: (Technique, &[f64]),
        due: f64,
        batch: &mut shift::Scratch,
        film: &mut Film,
        stats: &mut Stats,
    ) -> Result<(), Stop> {
        if !(due > 0.0 && sample.target > 0.0) {
            return Ok(());
        }
        let (options, path) = match (&self.options.shift, &sample.shiftable) {
            (Some(Batches::Shifts(options)), Some(path)) if sample.moves => (options, path),
            (Some(Batches::Thesis(options)), _) if sample.moves => {
                // All its vertices are needed, which are made again.
                let (mut paths, (technique, numbers)) = (Scratch::default(), made);
                let numbers = numbers.get(..technique.numbers()).unwrap_or(&[]);
                let connection = make(self.scene, self.queries, technique, numbers, &mut paths, stats)?;
                let Some(connection) = &connection else { return Ok(()) };
                let (camera, light) = (paths.camera.vertices(), paths.light.vertices());
                let path = Joined { scene: self.scene, camera, light, connection };
                return self.splat_thesis(options, state, sample.born, &path, sample.value * due, film, stats);
            }
            _ => {
                film.add(sample.pixel, sample.value * due);
                return Ok(());
            }
        };
        let options = options.after(sample.born as f64 * f64::from(state.start.chains));
        let (tiles, random) = chain_shift_numbers(self.options.seed, state.index, sample.born);
        let tile = Tile::around(self.scene, self.queries, &options, tiles, &path.image)?;
        stats.rays += tile.as_ref().map_or(0, |tile| tile.views().len() as u64);
        let draw = Draw { tiles, random };
        let done = batch.shift(self.scene, self.queries, &options, path, tile.as_ref(), draw, |p, c| film.add(p, c * due))?;
        stats.add_batch(&done);
        Ok(())
    }
}

impl ChainStats {
    fn count(&mut self, decision: &Decision) {
        let (all, accepted) = if decision.large {
            (&mut self.large, &mut self.large_accepted)
        } else {
            (&mut self.small, &mut self.small_accepted)
        };
        *all += 1;
        *accepted += u64::from(decision.accepted);
        self.dark += u64::from(decision.dark);
        self.dropped += u64::from(decision.dropped);
    }
}
