//! Bidirectional path tracing against the path sampler, against what is known, and technique against technique.
//!
//! Significance: |z| < 4 for a mean, |z| < 4.8 for the worst of an image's pixels: with other seeds one of some 500 means fails with a
//! probability of 3 %, one of some 1800 pixels with 0.3 %, if all is right. Seeds are fixed.

#[path = "../toy/mod.rs"]
mod toy;

mod agreement;
mod bundles;
mod densities;
mod determinism;
mod furnace;
mod left_out;
mod path;
mod sun;
mod techniques;
mod thesis;
mod weights;
mod worlds;

use toy::Geometry;
use toy::estimate::{Estimate, Mean};
use toy::scenes::World;
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic, MAX_LENGTH, Options, Sample, Subpath};
use volgrad::sampler::{self, CameraSamples, FirstVertices, Lengths, PathTracer, Stats};
use volgrad::scene::Scene;

const MOST: f64 = 4.0;
const MOST_OF_PIXELS: f64 = 4.8;

fn options(max_length: u32, heuristic: Heuristic) -> Options {
    Options { max_length, rr_depth: 3, seed: 2, heuristic, light_vertices: MAX_LENGTH, roulette: 0.0, shift: None }
}

/// All that is seen: what the path sampler keeps for itself, light seen directly or through specular surfaces alone, and the rest.
fn bidirectional(world: &World, options: Options, passes: u64) -> Estimate {
    let scene = world.scene();
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    let others = Lengths { first: 2, last: options.max_length };
    let direct = tracer(world, &scene, options.max_length, others, 3);
    Estimate::of_batches(world, passes, |batch, film| {
        let mut stats = Stats::default();
        for pass in batch * passes..(batch + 1) * passes {
            sampler.sample_pixels(pass, 0..pixels(world), film, &mut stats).expect("the toy host never stops");
            direct.sample_pixels(pass, 0..pixels(world), film, &mut stats).expect("the toy host never stops");
        }
        stats
    })
}

fn path_tracer(world: &World, max_depth: u32, passes: u64) -> Estimate {
    let scene = world.scene();
    let tracer = tracer(world, &scene, max_depth, Lengths::NONE, 1);
    Estimate::of_batches(world, passes, |batch, film| {
        let mut stats = Stats::default();
        for pass in batch * passes..(batch + 1) * passes {
            tracer.sample_pixels(pass, 0..pixels(world), film, &mut stats).expect("the toy host never stops");
        }
        stats
    })
}

fn tracer<'a>(
    world: &'a World,
    scene: &'a Scene<'a>,
    max_depth: u32,
    left_out: Lengths,
    seed: u64,
) -> PathTracer<'a, Geometry> {
    let options = sampler::Options { max_depth, rr_depth: 3, seed, shift: None, left_out, first: FirstVertices::ALL };
    PathTracer { scene, queries: &world.geometry, options }
}

/// Tells all that the sample through a pixel makes. Pixels are numbered row by row.
fn each_technique<'a>(sampler: &Bidirectional<'a, Geometry>, pass: u64, pixel: u32, mut tell: impl FnMut(&Sample)) {
    let (mut camera, mut light) = (Subpath::default(), Subpath::default());
    let mut samples =
        CameraSamples::new(sampler.scene, sampler.queries, None, sampler.options.seed, pass).expect("nothing is shifted");
    let first = samples.sample(pixel, &mut Stats::default()).expect("the toy host never stops");
    let tell = |sample: &Sample| {
        tell(sample);
        Ok(())
    };
    sampler.sample(pass, first, &mut camera, &mut light, &mut Stats::default(), tell).expect("the toy host never stops");
}

/// Of the crop.
fn pixels(world: &World) -> u32 {
    let [x0, y0, x1, y1] = world.camera.crop;
    (x1 - x0) * (y1 - y0)
}

/// How far two independent means are apart, in standard errors.
fn z(a: Mean, b: Mean) -> f64 {
    let error = a.error.hypot(b.error);
    // Pixels outside the crop are black in both.
    if a.value == b.value { 0.0 } else { (a.value - b.value) / error }
}
