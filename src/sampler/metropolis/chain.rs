//! A Markov chain over the paths of one length: Multiplexed Metropolis Light Transport. [HKD14]
//!
//! Differs from [HKD14]: small steps keep the technique, so that a chain has the numbers of one technique only and none that nothing reads;
//! large steps, whose samples are independent, count as such too, by the balance heuristic [KSKAC02].

use super::bootstrap::{self, Numbers, Start};
use super::numbers::{Change, LARGEST_STEP, capacity, step};
use super::path::{remake, target};
use super::room::{Room, Sample};
use super::techniques::{Shares, Techniques};
use crate::film::Film;
use crate::math::exp;
use crate::sampler::bidirectional::{Connection, Joined, MAX_LENGTH, Technique, thesis};
use crate::sampler::path_tracer::Stats;
use crate::sampler::primary::{ChainNumbers, chain_shift_numbers};
use crate::scene::{Queries, Scene, Stop};
use crate::shift::{self, Draw};

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
    pub(super) technique: Technique,
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
const STEPS: core::ops::RangeInclusive<f64> = 1e-4..=LARGEST_STEP;

/// How much a path's value may differ between two evaluations of the same numbers, relative: on processors of another type rays can end a
/// little elsewhere. Another scene or table gives other values, to some of a plan's chains at least.
const SAME_VALUE: f64 = 1e-3;

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
pub(super) struct Decision {
    pub large: bool,
    pub acceptance: f64,
    pub accepted: bool,
    dark: bool,
    dropped: bool,
    pub technique: Technique,
    pub change: Change,
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
        let mut room = Room::default();
        self.begin(state, numbers, &mut room, stats)?;
        for i in 0..self.options.burn_in {
            let decision = self.decide(state, numbers, &mut room, stats)?;
            chain_stats.burn_in += 1;
            chain_stats.dropped += u64::from(decision.dropped);
            if !decision.large {
                let gain = FIRST_GAIN / (1.0 + f64::from(i) * GAIN_DECAY);
                let size = state.step * exp(gain * (decision.acceptance - TARGET_RATE));
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
        let mut room = Room::default();
        self.begin(state, numbers, &mut room, stats)?;
        let every = u64::from(self.options.shift_every).max(1);
        let phase = (state.phase * every as f64) as u64;
        for _ in 0..count {
            // Only what moves costs a batch: whether a path does depends on the path alone.
            let of_batches = if state.mutations % every == phase { every as f64 } else { 0.0 };
            let worth = |sample: &Sample| if sample.moves { of_batches } else { 1.0 };
            let decision = self.decide(state, numbers, &mut room, stats)?;
            // The path that is left for good, whichever of the two that is, can be splatted. A callback can stop that, but only before
            // the first splat: nothing has changed then.
            let stay = state.pending + worth(room.sample.current()) * (1.0 - decision.acceptance);
            let proposal = room.sample.proposed();
            let come = worth(proposal) * (decision.acceptance + if decision.large { proposal.large } else { 0.0 });
            let (left, due) = if decision.accepted { (Change::NONE, stay) } else { (decision.change, come) };
            self.splat(state, left, due, &mut room, film, stats)?;
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
        let mut room = Room::default();
        self.begin(state, numbers, &mut room, stats)?;
        self.splat(state, Change::NONE, state.pending, &mut room, film, stats)
    }

    /// Puts the path of the chain's numbers into an empty room. It stops if that is another one than it was, or batches cannot be made.
    pub(super) fn begin(&self, state: &State, numbers: &[f64], room: &mut Room<'a>, stats: &mut Stats) -> Result<(), Stop> {
        match &self.options.shift {
            Some(Batches::Shifts(options)) => options.check(self.scene)?,
            Some(Batches::Thesis(_)) => self.scene.check_phase_derivatives()?,
            None => {}
        }
        room.numbers.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
        self.sample(state, state.technique, Change::BOTH, room, stats)?;
        room.sample.proposed().born = state.born;
        room.accept(Change::BOTH);
        let same = (room.sample.current().target - state.target).abs() <= SAME_VALUE * state.target;
        if same { Ok(()) } else { Err(Stop::OtherPath) }
    }

    /// Makes the path of the room's numbers, which differ from the chain's by `change`.
    fn sample(
        &self,
        state: &State,
        technique: Technique,
        change: Change,
        room: &mut Room<'a>,
        stats: &mut Stats,
    ) -> Result<(), Stop> {
        let Room { camera, light, sample, numbers, .. } = room;
        let (camera, light, sample) = (camera.get(change.camera), light.get(change.light), sample.proposed());
        let numbers = numbers.get(..technique.numbers()).unwrap_or(&[]);
        (sample.target, sample.moves) = (0.0, false);
        let Some(path) = remake(self.scene, self.queries, technique, numbers, change, camera, light, stats)? else {
            return Ok(());
        };
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
        sample.target = target;
        sample.large = density(others.into()) / density(brightness);
        let connection = sample.connection.insert(Connection { value, weight: 1.0, ..path });
        let joined = Joined { scene: self.scene, camera: camera.vertices(), light: light.vertices(), connection };
        sample.moves = match &self.options.shift {
            Some(Batches::Shifts(options)) => joined.moves(options),
            Some(Batches::Thesis(_)) => joined.is_available(),
            None => false,
        };
        Ok(())
    }

    /// Proposes a path and decides about it, without a change of the chain.
    pub(super) fn decide(
        &self,
        state: &State,
        numbers: &[f64],
        room: &mut Room<'a>,
        stats: &mut Stats,
    ) -> Result<Decision, Stop> {
        let mut random = state.random.clone();
        let large = random.next() < self.options.large_step;
        let technique =
            if large { state.shares.technique(state.start.length as usize, random.next()) } else { state.technique };
        let change = if large { Change::BOTH } else { Change::small(technique, random.next()) };
        let size = state.step * exp(-STEP_RANGE * random.next());
        room.numbers.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
        for number in room.numbers.get_mut(change.numbers(technique)).unwrap_or(&mut []) {
            *number = if large { random.next() } else { step(*number, size, &mut || random.next()) };
        }
        self.sample(state, technique, change, room, stats)?;
        let current = room.sample.current().target;
        let proposal = room.sample.proposed();
        proposal.born = state.mutations + 1;
        let target = proposal.target;
        let acceptance = if target > 0.0 && current > 0.0 { (target / current).min(1.0) } else { f64::from(target > 0.0) };
        let accepted = random.next() < acceptance;
        let (dark, dropped) = (target == 0.0, target.is_nan());
        Ok(Decision { large, acceptance, accepted, dark, dropped, technique, change, random })
    }

    fn make(&self, decision: Decision, state: &mut State, numbers: &mut [f64], room: &mut Room<'a>) {
        state.random = decision.random;
        if decision.accepted {
            state.technique = decision.technique;
            state.born = room.sample.proposed().born;
            state.target = room.sample.proposed().target;
            numbers.iter_mut().zip(&room.numbers).take(decision.technique.numbers()).for_each(|(to, from)| *to = *from);
            room.accept(decision.change);
        }
    }

    /// Splats the path that differs from the chain's by `change`.
    fn splat(
        &self,
        state: &State,
        change: Change,
        due: f64,
        room: &mut Room<'a>,
        film: &mut Film,
        stats: &mut Stats,
    ) -> Result<(), Stop> {
        let Room { camera, light, sample, shiftable, batch, tile, .. } = room;
        let sample = sample.get(change != Change::NONE);
        let Some(connection) = sample.connection.as_ref().filter(|_| due > 0.0 && sample.target > 0.0) else { return Ok(()) };
        let (camera, light) = (camera.get(change.camera).vertices(), light.get(change.light).vertices());
        let joined = Joined { scene: self.scene, camera, light, connection };
        let moving = match &self.options.shift {
            Some(Batches::Shifts(options)) if sample.moves && joined.prepare(self.queries, options, shiftable)? => {
                Some(options).zip(shiftable.as_ref())
            }
            Some(Batches::Thesis(options)) if sample.moves => {
                return self.splat_thesis(options, state, sample.born, &joined, connection.value * due, film, stats);
            }
            _ => None,
        };
        let Some((options, path)) = moving else {
            film.add(connection.pixel, connection.value * due);
            return Ok(());
        };
        let options = options.after(sample.born as f64 * f64::from(state.start.chains));
        let (tiles, random) = chain_shift_numbers(self.options.seed, state.index, sample.born);
        if options.has_views() {
            let tile = shift::made(tile);
            tile.retrace_around(self.scene, self.queries, &options, tiles, &path.image)?;
            stats.rays += tile.views().len() as u64;
        }
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
