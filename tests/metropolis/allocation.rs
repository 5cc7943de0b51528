//! Nothing allocates: not the bootstrap, the table of techniques and the plan, nor chains.

use crate::chains::{Chains, Picture, Setup};
use crate::toy::scenes::edges_with_specular_surfaces;
use crate::{THESIS, unbiased_shifts};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use volgrad::sampler::metropolis::{ChainStats, Plan, State, Techniques, bootstrap, capacity, learn};
use volgrad::sampler::{Lengths, Stats};

/// Counts the allocations of each thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: the system's allocator, and a number of this thread's own that needs no memory.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often `work` allocates.
fn allocations(work: impl FnOnce()) -> u64 {
    let before = ALLOCATIONS.get();
    work();
    ALLOCATIONS.get() - before
}

#[test]
fn the_count_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1_u8]))), 1);
}

#[test]
fn by_bootstrap_and_plan() {
    let world = edges_with_specular_surfaces();
    let (scene, lengths) = (world.scene(), Lengths { first: 2, last: 8 });
    let (mut weights, mut numbers) = (vec![0.0; 500], vec![0.0; capacity(8)]);
    let options = Chains::new(&world, &SETUP, 1).options;
    let (mut started, stats) = (0, (&mut Stats::default(), &mut ChainStats::default()));
    let count = allocations(|| {
        let alike = Techniques::alike(lengths);
        bootstrap(&scene, &world.geometry, 1, &alike, 0, &mut weights, stats.0, stats.1).expect("never stops");
        let techniques = learn(1, lengths, &weights);
        bootstrap(&scene, &world.geometry, 1, &techniques, 0, &mut weights, stats.0, stats.1).expect("never stops");
        Plan::new(1, &techniques, &weights, 20).starts(&weights, |start| {
            started += u32::from(State::new(&options, &techniques, started, start, &mut numbers).is_some());
        });
    });
    assert!(started >= 20);
    assert_eq!(count, 0);
}

const SETUP: Setup =
    Setup { lengths: Lengths { first: 2, last: 6 }, learn: 0, samples: 500, chains: 10, large_step: 0.3, burn_in: 0 };

#[test]
fn by_chains() {
    let world = edges_with_specular_surfaces();
    let scene = world.scene();
    let mut chains = Chains::new(&world, &SETUP, 1);
    let others = [(None, None, 1), (Some(THESIS), None, 2)];
    for (thesis, shift, every) in others.into_iter().chain(unbiased_shifts().map(|shift| (None, Some(shift), 2))) {
        chains.thesis = thesis;
        let sampler = chains.sampler(&scene, shift, every);
        let (mut all, mut picture) = (chains.chains.clone(), Picture::new(&world));
        let count = allocations(|| {
            for chain in &mut all {
                let stats = (&mut Stats::default(), &mut ChainStats::default());
                sampler.burn_in(&mut chain.state, &mut chain.numbers, stats.0, stats.1).expect("never stops");
                picture.run(&sampler, chain, 100);
                picture.flush(&sampler, chain);
            }
        });
        // The thesis' weights may well be negative.
        assert!(picture.mean(1.0).abs() > 0.0);
        assert_eq!(count, 0, "{thesis:?} {shift:?}");
    }
}
