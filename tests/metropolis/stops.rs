//! A callback that stops: after each of its calls the chain and the film are what whole mutations left, and going on leads to the same film.

use crate::chains::{Chain, Chains, Picture, Setup};
use crate::toy::Geometry;
use crate::toy::scenes::edges_with_specular_surfaces;
use crate::{THESIS, unbiased_shifts};
use std::cell::Cell;
use volgrad::sampler::metropolis::Metropolis;
use volgrad::sampler::{Lengths, Stats};
use volgrad::scene::{Hit, Queries, Ray, Scene, Stop};
use volgrad::shift;

const MUTATIONS: u64 = 12;
const CODE: i32 = 17;

/// Answers so many calls, and no more.
struct Stopping<'g> {
    geometry: &'g Geometry,
    left: Cell<u64>,
}

impl Stopping<'_> {
    fn call(&self) -> Result<(), Stop> {
        let left = self.left.get().checked_sub(1).ok_or(Stop::Callback(CODE))?;
        self.left.set(left);
        Ok(())
    }
}

impl Queries for Stopping<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.call().and_then(|()| self.geometry.intersect(rays, hits))
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.call().and_then(|()| self.geometry.occluded(rays, hits))
    }
}

/// Runs and flushes a chain whose callbacks stop after `calls`; returns it, what it added, and whether running and flushing were done.
fn interrupted(chains: &Chains, scene: &Scene, shift: Option<shift::Options>, calls: u64) -> (Chain, Picture, [bool; 2]) {
    let queries = Stopping { geometry: &chains.world.geometry, left: Cell::new(calls) };
    let options = chains.sampler(scene, shift, every(chains, shift)).options;
    let sampler = Metropolis { scene, queries: &queries, options };
    let (mut chain, mut picture) = (chains.chains[0].clone(), Picture::new(chains.world));
    let mut chain_stats = picture.chain_stats;
    let film = &mut picture.film();
    let run = sampler.run(&mut chain.state, &mut chain.numbers, MUTATIONS, film, &mut Stats::default(), &mut chain_stats);
    let flush = run.and_then(|()| sampler.flush(&chain.state, &chain.numbers, film, &mut Stats::default()));
    picture.chain_stats = chain_stats;
    for result in [run, flush] {
        assert!(matches!(result, Ok(()) | Err(Stop::Callback(CODE))));
    }
    (chain, picture, [run.is_ok(), flush.is_ok()])
}

fn every(chains: &Chains, shift: Option<shift::Options>) -> u32 {
    if chains.thesis.is_some() || shift.is_some() { 2 } else { 1 }
}

#[test]
fn at_any_call() {
    let world = edges_with_specular_surfaces();
    let scene = world.scene();
    let lengths = Lengths { first: 4, last: 4 };
    let setup = Setup { lengths, learn: 0, samples: 200, chains: 1, large_step: 0.3, burn_in: 5 };
    let kinds = [(None, None), (Some(THESIS), None)].into_iter().chain(unbiased_shifts().map(|shift| (None, Some(shift))));
    for ((thesis, shift), seed) in kinds.flat_map(|kind| [(kind, 3), (kind, 4)]) {
        let mut chains = Chains::new(&world, &setup, seed);
        chains.thesis = thesis;
        let sampler = chains.sampler(&scene, shift, every(&chains, shift));
        // The film after each whole mutation.
        let (mut chain, mut picture) = (chains.chains[0].clone(), Picture::new(&world));
        let mut after = vec![picture.cells.clone()];
        for _ in 0..MUTATIONS {
            picture.run(&sampler, &mut chain, 1);
            after.push(picture.cells.clone());
        }
        picture.flush(&sampler, &chain);
        let mut calls = 0;
        loop {
            let (mut chain, mut film, [ran, flushed]) = interrupted(&chains, &scene, shift, calls);
            let made = film.chain_stats.large + film.chain_stats.small;
            assert_eq!(made, chain.state.mutations);
            assert_eq!(ran, made == MUTATIONS);
            if flushed {
                break;
            }
            assert!(film.cells == after[made as usize], "{shift:?}, call {calls}: part of mutation {made} is in the film");
            film.run(&sampler, &mut chain, MUTATIONS - made);
            film.flush(&sampler, &chain);
            assert!(film.cells == picture.cells && film.dropped.get() == 0, "{shift:?}, call {calls}");
            calls += 1;
        }
        println!("{shift:?}: {calls} calls");
        assert!(calls > MUTATIONS);
    }
}
