//! What a pass adds to a film depends on nothing but its number: not on how its pixels are divided.

use crate::toy::scenes::World;
use crate::{options, pixels, worlds};
use std::ops::Range;
use volgrad::film::{Cell, Film};
use volgrad::sampler::Stats;
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic};

fn film(world: &World, ranges: impl IntoIterator<Item = Range<u32>> + Clone) -> (Vec<Cell>, Stats) {
    let scene = world.scene();
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options: options(5, Heuristic::Balance) };
    let (mut cells, mut dropped, mut stats) = (vec![Cell::default(); 16], 0, Stats::default());
    let mut film = Film { width: 4, height: 4, cells: &mut cells, dropped: &mut dropped };
    for pass in 0..8 {
        for range in ranges.clone() {
            sampler.sample_pixels(pass, range, &mut film, &mut stats).expect("the toy host never stops");
        }
    }
    assert_eq!(dropped, 0);
    (cells, stats)
}

#[test]
fn any_division_of_a_pass_gives_the_same_bits() {
    let (_, world) = worlds::lights().pop().expect("there are some");
    let whole = film(&world, std::iter::once(0..pixels(&world)));
    assert!(whole.0.iter().all(|cell| cell.value().min_element() > 0.0));
    assert_eq!(film(&world, [7..16, 0..3, 3..7]), whole);
}
