//! What a chain adds depends on nothing but its number: not on how its mutations are divided into calls, on the other chains, on threads, or on
//! whether it was looked at, or stored, on the way.

use crate::chains::{Chain, Chains, Picture, Setup};
use crate::toy::scenes::{World, camera, edges_under_area_lights, rectangle};
use crate::{THESIS, unbiased_shifts};
use volgrad::math::Colour;
use volgrad::sampler::Lengths;
use volgrad::sampler::bidirectional::thesis;
use volgrad::scene::Bsdf;
use volgrad::shift::{self, Kernel, Mode};

const MUTATIONS: u64 = 60;

fn chains(world: &World) -> Chains<'_> {
    let lengths = Lengths { first: 2, last: 5 };
    Chains::new(world, &Setup { lengths, learn: 200, samples: 1000, chains: 12, large_step: 0.3, burn_in: 30 }, 7)
}

/// Without shifts and with each kind, every mutation and every third.
fn shifts() -> Vec<(Option<thesis::Options>, Option<shift::Options>, u32)> {
    let shrinking = unbiased_shifts().map(|shift| shift::Options { alpha: 0.7, ..shift });
    let others = [(None, None, 1), (Some(THESIS), None, 1), (Some(THESIS), None, 3)];
    others.into_iter().chain(shrinking.into_iter().flat_map(|shift| [1, 3].map(|every| (None, Some(shift), every)))).collect()
}

/// What is left of a chain: all that can be read of it, and what it would do next.
fn assert_same(chains: &Chains, a: &Chain, b: &Chain) {
    assert_eq!(format!("{:?} {:?}", a.state, a.numbers), format!("{:?} {:?}", b.state, b.numbers));
    let scene = chains.world.scene();
    let sampler = chains.sampler(&scene, None, 1);
    let [a, b] = [a, b].map(|chain| {
        let (mut chain, mut picture) = (chain.clone(), Picture::new(chains.world));
        picture.run(&sampler, &mut chain, 10);
        (picture.cells, picture.chain_stats)
    });
    assert!(a == b);
}

/// Films and chains after the same mutations, once in one call for each chain, once as `divide` does it.
fn compare(divide: impl Fn(&Chains, &mut Vec<Chain>, &mut dyn FnMut(&mut Chain, u64), Option<shift::Options>, u32)) {
    let world = edges_under_area_lights();
    let mut chains = chains(&world);
    let scene = world.scene();
    for (thesis, shift, every) in shifts() {
        chains.thesis = thesis;
        let sampler = chains.sampler(&scene, shift, every);
        let (mut whole, mut parts) = (Picture::new(&world), Picture::new(&world));
        let (mut at_once, mut divided) = (chains.chains.clone(), chains.chains.clone());
        at_once.iter_mut().for_each(|chain| whole.run(&sampler, chain, MUTATIONS));
        divide(&chains, &mut divided, &mut |chain, mutations| parts.run(&sampler, chain, mutations), shift, every);
        assert!(whole.mean(1.0) > 0.0);
        assert!(parts.cells == whole.cells && parts.chain_stats == whole.chain_stats, "{thesis:?} {shift:?}, every {every}");
        at_once.iter().zip(&divided).for_each(|(a, b)| assert_same(&chains, a, b));
    }
}

#[test]
fn any_division_into_calls() {
    compare(|_, chains, run, _, _| {
        for chain in chains {
            [1, 0, 2, 7, 19, MUTATIONS - 29].into_iter().for_each(|mutations| run(chain, mutations));
        }
    });
}

#[test]
fn any_order_of_chains() {
    compare(|_, chains, run, _, _| {
        chains.iter_mut().rev().for_each(|chain| run(chain, 20));
        chains.iter_mut().for_each(|chain| run(chain, MUTATIONS - 20));
    });
}

#[test]
fn a_flush_leaves_the_chain_as_it_is() {
    compare(|all, chains, run, shift, every| {
        let scene = all.world.scene();
        for chain in chains {
            for mutations in [5, MUTATIONS - 5] {
                run(chain, mutations);
                let before = chain.clone();
                let (mut a, mut b) = (Picture::new(all.world), Picture::new(all.world));
                a.flush(&all.sampler(&scene, shift, every), chain);
                b.flush(&all.sampler(&scene, shift, every), chain);
                assert!(a == b);
                assert_same(all, &before, chain);
            }
        }
    });
}

#[test]
fn a_stored_chain_goes_on_alike() {
    compare(|_, chains, run, _, _| {
        for chain in chains {
            run(chain, 31);
            *chain = chain.clone();
            run(chain, MUTATIONS - 31);
        }
    });
}

#[test]
fn threads_and_merged_films() {
    let world = edges_under_area_lights();
    let mut chains = chains(&world);
    let scene = world.scene();
    for (thesis, shift, every) in shifts() {
        chains.thesis = thesis;
        let sampler = chains.sampler(&scene, shift, every);
        let render = |first: usize, step: usize| {
            let mut picture = Picture::new(&world);
            for chain in chains.chains.iter().skip(first).step_by(step) {
                let mut chain = chain.clone();
                picture.run(&sampler, &mut chain, MUTATIONS);
                picture.flush(&sampler, &chain);
            }
            picture
        };
        let whole = render(0, 1);
        let (even, odd) = std::thread::scope(|scope| {
            let odd = scope.spawn(|| render(1, 2));
            (render(0, 2), odd.join().expect("a chain panicked"))
        });
        even.film().merge(&odd.cells, odd.dropped.get());
        assert!(even.cells == whole.cells && even.dropped == whole.dropped);
    }
}

/// A ball has no offsets for what is seen on a surface: such paths need no batch, and count each time.
#[test]
fn surfaces_under_a_ball_are_as_without_shifts() {
    let floor = rectangle([-2.0, -1.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]);
    let world = World::new(camera([0.0, 0.0, -1.0], 0.5, 8))
        .surface(floor, Bsdf::Diffuse { albedo: Colour::splat(0.5) })
        .area_light([-0.5, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0, 1.0);
    let chains = chains(&world);
    let scene = world.scene();
    let film = |shift, every| {
        let sampler = chains.sampler(&scene, shift, every);
        let mut picture = Picture::new(&world);
        chains.chains.iter().for_each(|chain| picture.run(&sampler, &mut chain.clone(), MUTATIONS));
        picture
    };
    let ball = shift::Options::new(Mode::Exact, Kernel::Ball(0.1), 3);
    let (plain, shifted) = (film(None, 1), film(Some(ball), 4));
    assert!(plain.mean(1.0) > 0.0 && plain.cells == shifted.cells);
}
