//! Chains refuse a scene that is not that of the samples, and starts that are not of their seed and table.
//!
//! A chain knows by the value of its path, so one whose value happens to be the same goes on: some chains of a plan may, not all.

use crate::chains::{Chains, Picture, Setup};
use crate::toy::scenes::{World, edges_under_area_lights};
use volgrad::sampler::metropolis::{ChainStats, Metropolis, Options, Plan, State, Techniques, bootstrap, capacity, learn};
use volgrad::sampler::{Lengths, Stats};
use volgrad::scene::{Guide, Stop};

const SETUP: Setup =
    Setup { lengths: Lengths { first: 2, last: 5 }, learn: 500, samples: 3000, chains: 40, large_step: 0.3, burn_in: 10 };
const SEED: u64 = 3;

fn guided(world: &World) -> World {
    let guide = |light| Guide::learned(move |i, j| if (i / 8 + j / 16 + light) % 2 == 0 { 1.0 } else { 0.1 });
    world.clone().guided((0..world.lights.len()).map(guide).collect())
}

fn darker(world: &World) -> World {
    let mut world = world.clone();
    world.media.iter_mut().for_each(|medium| medium.albedo *= 0.8);
    world
}

/// Of the chains that a plan starts with `seed` in `world`, those that find the path of their sample.
fn begun(samples: &World, world: &World, seed: u64, own_table: bool) -> (usize, usize) {
    let scene = samples.scene();
    let (alike, queries) = (Techniques::alike(SETUP.lengths), &samples.geometry);
    let sample = |techniques: &Techniques| {
        let mut weights = vec![0.0; SETUP.samples];
        let stats = (&mut Stats::default(), &mut ChainStats::default());
        bootstrap(&scene, queries, SEED, techniques, 0, &mut weights, stats.0, stats.1).expect("never stops");
        weights
    };
    let techniques = learn(SEED, SETUP.lengths, &sample(&alike));
    let weights = sample(&techniques);
    let options = Options { seed, ..Chains::new(samples, &SETUP, SEED).options };
    let scene = world.scene();
    let sampler = Metropolis { scene: &scene, queries: &world.geometry, options };
    let (mut all, mut good) = (0, 0);
    Plan::new(SEED, &techniques, &weights, SETUP.chains).starts(&weights, |start| {
        let mut numbers = vec![0.0; capacity(start.length as usize)];
        let table = if own_table { &techniques } else { &alike };
        all += 1;
        let Some(mut state) = State::new(&options, table, all as u32, start, &mut numbers) else { return };
        let stats = (&mut Stats::default(), &mut ChainStats::default());
        match sampler.burn_in(&mut state, &mut numbers, stats.0, stats.1) {
            Ok(()) => good += 1,
            stopped => assert_eq!(stopped, Err(Stop::OtherPath)),
        }
    });
    (good, all)
}

#[test]
fn of_other_samples() {
    let world = edges_under_area_lights();
    let (good, all) = begun(&world, &world, SEED, true);
    assert!(good == all && all >= SETUP.chains as usize);
    let (guided, darker) = (guided(&world), darker(&world));
    let strangers = [
        ("guides", begun(&world, &guided, SEED, true)),
        ("no guides", begun(&guided, &world, SEED, true)),
        ("media", begun(&world, &darker, SEED, true)),
        ("seed", begun(&world, &world, SEED + 1, true)),
        ("table", begun(&world, &world, SEED, false)),
    ];
    for (name, (good, all)) in strangers {
        println!("another one's {name}: {good} of {all} begin");
        assert!(good < all / 2, "{name}");
    }
}

#[test]
fn with_another_scene_on_the_way() {
    let world = edges_under_area_lights();
    let (chains, guided) = (Chains::new(&world, &SETUP, SEED), guided(&world));
    let scenes = [world.scene(), guided.scene()];
    let [own, other] = scenes.each_ref().map(|scene| {
        let (sampler, picture) = (chains.sampler(scene, None, 1), Picture::new(&world));
        let gone_on = chains.chains.iter().filter(|chain| {
            let (mut chain, mut stats) = ((*chain).clone(), ChainStats::default());
            let film = &mut picture.film();
            let run = sampler.run(&mut chain.state, &mut chain.numbers, 9, film, &mut Stats::default(), &mut stats);
            let flush = sampler.flush(&chain.state, &chain.numbers, film, &mut Stats::default());
            assert!([run, flush].iter().all(|done| matches!(done, Ok(()) | Err(Stop::OtherPath))));
            assert!(run.is_ok() || stats == ChainStats::default());
            run.is_ok()
        });
        gone_on.count()
    });
    println!("another one's guides: {other} of {own} go on");
    assert!(own == chains.chains.len() && other < own / 2);
}
