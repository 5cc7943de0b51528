//! Small images by each sampler, from the same numbers in every world.

use crate::chains::{Chains, Setup};
use crate::toy::scenes::World;
use volgrad::film::{Cell, Count, Film};
use volgrad::math::{Colour, luminance};
use volgrad::sampler::bidirectional::{self, Bidirectional, Heuristic, MAX_LENGTH, thesis};
use volgrad::sampler::{FirstVertices, Lengths, Options, PathTracer, Stats};
use volgrad::shift::{self, Kernel, Mode, Radius};

const PASSES: u64 = 8;
const MUTATIONS: u64 = 120;
const LONGEST: u32 = 5;

/// Of a batch's kinds one that evaluates surfaces, one that is linear in depths, and one that only has a gradient.
pub fn shifts() -> [Option<shift::Options>; 4] {
    let disk = Kernel::Disk(Radius::Pixels(1.0));
    [
        None,
        Some(shift::Options { run: 2, ..shift::Options::new(Mode::Exchangeable, Kernel::Tile, 8) }),
        Some(shift::Options { run: 3, ..shift::Options::new(Mode::TwoLevel, disk, 3) }),
        Some(shift::Options { run: 2, ..shift::Options::new(Mode::LogLinear, Kernel::Ball(0.3), 3) }),
    ]
}

pub type Image = Vec<Colour>;

fn image(world: &World, fill: impl FnOnce(&mut Film)) -> Image {
    let (width, height) = (world.camera.width, world.camera.height);
    let (cells, dropped) = (vec![Cell::default(); (width * height) as usize], Count::default());
    fill(&mut Film { width, height, cells: &cells, dropped: &dropped, is_shared: false });
    assert_eq!(dropped.get(), 0, "no splat is beyond all numbers");
    cells.iter().map(Cell::value).collect()
}

pub fn by_path(world: &World, shift: Option<shift::Options>) -> Image {
    let scene = world.scene();
    let options =
        Options { max_depth: LONGEST, rr_depth: 3, seed: 5, shift, left_out: Lengths::NONE, first: FirstVertices::ALL };
    let tracer = PathTracer { scene: &scene, queries: &world.geometry, options };
    image(world, |film| {
        for pass in 0..PASSES {
            let pixels = 0..film.width * film.height;
            tracer.sample_pixels(pass, pixels, film, &mut Stats::default()).expect("the toy host never stops");
        }
    })
}

pub fn bidirectionally(world: &World, shift: Option<shift::Options>) -> Image {
    let scene = world.scene();
    let (heuristic, light_vertices) = (Heuristic::Balance, MAX_LENGTH);
    let options =
        bidirectional::Options { max_length: LONGEST, rr_depth: 3, seed: 6, heuristic, light_vertices, roulette: 0.0, shift };
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    image(world, |film| {
        for pass in 0..PASSES {
            let pixels = 0..film.width * film.height;
            sampler.sample_pixels(pass, pixels, film, &mut Stats::default()).expect("the toy host never stops");
        }
    })
}

pub fn by_chains(world: &World, shift: Option<shift::Options>) -> Image {
    let lengths = Lengths { first: 2, last: LONGEST };
    let setup = Setup { lengths, learn: 0, samples: 800, chains: 4, large_step: 0.3, burn_in: 10 };
    let chains = Chains::new(world, &setup, 7);
    chains.film(shift, 2, MUTATIONS).cells.iter().map(Cell::value).collect()
}

pub fn by_the_thesis(world: &World) -> Image {
    let lengths = Lengths { first: 2, last: LONGEST };
    let setup = Setup { lengths, learn: 0, samples: 800, chains: 4, large_step: 0.3, burn_in: 10 };
    let mut chains = Chains::new(world, &setup, 8);
    chains.thesis = Some(thesis::Options { radius: 0.3, count: 3, alpha: 1.0, clamp: f64::INFINITY, as_printed: false });
    chains.film(None, 2, MUTATIONS).cells.iter().map(Cell::value).collect()
}

/// All of them.
pub fn images(world: &World) -> Vec<(String, Image)> {
    let mut images = vec![("thesis".into(), by_the_thesis(world))];
    for shift in shifts() {
        let name = |sampler: &str| format!("{sampler}, {:?}", shift.map(|shift| shift.mode));
        images.push((name("path"), by_path(world, shift)));
        images.push((name("bidirectional"), bidirectionally(world, shift)));
        images.push((name("chains"), by_chains(world, shift)));
    }
    images
}

/// The largest difference of two images' pixels, relative to the mean.
pub fn difference(a: &Image, b: &Image) -> f64 {
    let mean = a.iter().copied().map(luminance).sum::<f64>() / a.len() as f64;
    assert!(mean > 0.0, "something is seen");
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f64::max) / mean
}

/// Rounding of rays and what it does to sums over some paths.
const ROUNDING: f64 = 1e-4;

pub fn assert_the_same(original: &World, copy: &World) {
    for ((name, a), (_, b)) in images(original).iter().zip(images(copy)) {
        let difference = difference(a, &b);
        println!("{name}: {difference:.1e}");
        assert!(difference < ROUNDING, "{name}: {difference}");
    }
}
