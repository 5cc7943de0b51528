//! Chains as a host makes them: bootstrap, plan, burn-in; then films.

use crate::toy::Geometry;
use crate::toy::scenes::World;
use volgrad::film::{Cell, Count, Film};
use volgrad::sampler::bidirectional::thesis;
use volgrad::sampler::metropolis::{
    Batches, ChainStats, Metropolis, Options, Plan, State, Techniques, bootstrap, capacity, learn,
};
use volgrad::sampler::{Lengths, Stats};
use volgrad::scene::Scene;
use volgrad::shift;

/// How an image's chains are made.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    pub lengths: Lengths,
    /// Samples to learn from how often techniques are tried; with 0 all are tried alike.
    pub learn: usize,
    pub samples: usize,
    /// How many chains are wanted.
    pub chains: u32,
    pub large_step: f64,
    pub burn_in: u32,
}

pub struct Chain {
    pub state: State,
    pub numbers: Vec<f64>,
}

impl Clone for Chain {
    fn clone(&self) -> Self {
        Self { state: self.state.clone(), numbers: self.numbers.clone() }
    }
}

/// All chains of an image, before the first mutation that counts.
pub struct Chains<'w> {
    pub world: &'w World,
    pub options: Options,
    /// In the place of shifts, whatever is asked for.
    pub thesis: Option<thesis::Options>,
    pub brightness: f64,
    pub relative_error: f64,
    pub chains: Vec<Chain>,
}

impl<'w> Chains<'w> {
    pub fn new(world: &'w World, setup: &Setup, seed: u64) -> Self {
        let scene = world.scene();
        let Setup { lengths, large_step, burn_in, .. } = *setup;
        let options = Options { seed, large_step, burn_in, shift: None, shift_every: 1 };
        let mut stats = Stats::default();
        let mut sample = |techniques: &Techniques, count: usize| {
            let mut weights = vec![0.0; count];
            bootstrap(&scene, &world.geometry, seed, techniques, 0, &mut weights, &mut stats, &mut ChainStats::default())
                .expect("never stops");
            weights
        };
        let alike = Techniques::alike(lengths);
        let techniques = if setup.learn > 0 { learn(seed, lengths, &sample(&alike, setup.learn)) } else { alike };
        let weights = sample(&techniques, setup.samples);
        let plan = Plan::new(seed, &techniques, &weights, setup.chains);
        let mut chains = Vec::new();
        let metropolis = Metropolis { scene: &scene, queries: &world.geometry, options };
        plan.starts(&weights, |start| {
            let mut numbers = vec![0.0; capacity(start.length as usize)];
            let state = State::new(&options, &techniques, chains.len() as u32, start, &mut numbers);
            let mut chain = Chain { state: state.expect("of this plan"), numbers };
            let stats = (&mut Stats::default(), &mut ChainStats::default());
            metropolis.burn_in(&mut chain.state, &mut chain.numbers, stats.0, stats.1).expect("never stops");
            chains.push(chain);
        });
        assert_eq!(chains.len() as u32, plan.chain_count);
        let (brightness, relative_error) = (plan.brightness(), plan.relative_error());
        Self { world, options, thesis: None, brightness, relative_error, chains }
    }

    /// The sampler, with batches every `every` mutations.
    pub fn sampler<'s>(&'s self, scene: &'s Scene<'s>, shift: Option<shift::Options>, every: u32) -> Metropolis<'s, Geometry> {
        let shift = self.thesis.map(Batches::Thesis).or(shift.map(Batches::Shifts));
        let options = Options { shift, shift_every: every, ..self.options };
        Metropolis { scene, queries: &self.world.geometry, options }
    }

    /// What copies of all chains add to a film in so many mutations each; the chains here stay where they are.
    pub fn film(&self, shift: Option<shift::Options>, every: u32, mutations: u64) -> Picture {
        let scene = self.world.scene();
        let metropolis = self.sampler(&scene, shift, every);
        let mut picture = Picture::new(self.world);
        for chain in &self.chains {
            let mut chain = chain.clone();
            picture.run(&metropolis, &mut chain, mutations);
            picture.flush(&metropolis, &chain);
        }
        picture
    }

    /// What takes sums of so many mutations per chain to the image's.
    pub fn scale(&self, mutations: u64) -> f64 {
        let [x0, y0, x1, y1] = self.world.camera.crop.map(f64::from);
        (x1 - x0) * (y1 - y0) / (self.chains.len().max(1) as f64 * mutations as f64)
    }
}

/// A film and its memory, and counts of the work on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub cells: Vec<Cell>,
    pub dropped: Count,
    pub stats: Stats,
    pub chain_stats: ChainStats,
}

impl Picture {
    pub fn new(world: &World) -> Self {
        let (width, height) = (world.camera.width, world.camera.height);
        Self {
            width,
            cells: vec![Cell::default(); (width * height) as usize],
            dropped: Count::default(),
            stats: Stats::default(),
            chain_stats: ChainStats::default(),
        }
    }

    pub fn film(&self) -> Film<'_> {
        let height = self.cells.len() as u32 / self.width;
        Film { width: self.width, height, cells: &self.cells, dropped: &self.dropped, is_shared: false }
    }

    pub fn run(&mut self, metropolis: &Metropolis<Geometry>, chain: &mut Chain, mutations: u64) {
        let (mut stats, mut chain_stats) = (self.stats, self.chain_stats);
        let Chain { state, numbers } = chain;
        metropolis.run(state, numbers, mutations, &mut self.film(), &mut stats, &mut chain_stats).expect("never stops");
        (self.stats, self.chain_stats) = (stats, chain_stats);
    }

    pub fn flush(&mut self, metropolis: &Metropolis<Geometry>, chain: &Chain) {
        metropolis.flush(&chain.state, &chain.numbers, &mut self.film(), &mut Stats::default()).expect("never stops");
    }

    /// The image's mean luminance, times `scale`.
    pub fn mean(&self, scale: f64) -> f64 {
        let sum: f64 = self.cells.iter().map(|cell| volgrad::math::luminance(cell.value())).sum();
        sum * scale / self.cells.len() as f64
    }
}
