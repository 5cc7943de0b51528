//! Bidirectional path tracing against the path sampler, technique against technique, and the sums of their weights.

#[path = "toy/mod.rs"]
mod toy;

use toy::estimate::{Estimate, scale};
use toy::scenes::{
    World, edges_under_area_lights, edges_under_point_light, edges_with_rough_surfaces, edges_with_specular_surfaces,
};
use volgrad::sampler::bidirectional::{self, Bidirectional, Heuristic};
use volgrad::sampler::{Lengths, Options, Stats};

const LONGEST: u32 = 5;

fn path_tracer(world: &World, passes: u64) -> Estimate {
    let left_out = Lengths { first: 1, last: 1 };
    let options = Options { max_depth: LONGEST, rr_depth: 3, seed: 1, shift: None, left_out };
    Estimate::of_path_tracer(world, options, passes)
}

fn bidirectional(world: &World, heuristic: Heuristic, passes: u64) -> Estimate {
    let scene = world.scene();
    let options = bidirectional::Options { max_length: LONGEST, rr_depth: 3, seed: 2, heuristic };
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    let pixels = scene.camera.width * scene.camera.height;
    Estimate::of_batches(world, passes, |batch, film| {
        let mut stats = Stats::default();
        for pass in batch * passes..(batch + 1) * passes {
            sampler.sample_pixels(pass, 0..pixels, film, &mut stats).expect("the toy host never stops");
        }
        stats
    })
}

fn agrees(name: &str, world: &World) {
    let expected = path_tracer(world, 60 * scale());
    for heuristic in [Heuristic::Balance, Heuristic::Power] {
        let found = bidirectional(world, heuristic, 15 * scale());
        let (a, b) = (expected.total(), found.total());
        let z = (b.value - a.value) / (a.error * a.error + b.error * b.error).sqrt();
        println!("{name} {heuristic:?}: {:.5} ± {:.5} against {:.5} ± {:.5}, z {z:.2}", b.value, b.error, a.value, a.error);
        let worst = (0..found.pixels())
            .map(|i| {
                let (a, b) = (expected.pixel(i), found.pixel(i));
                (b.value - a.value) / (a.error * a.error + b.error * b.error).sqrt()
            })
            .fold(0.0, |m: f64, z| if z.abs() > m.abs() { z } else { m });
        println!("worst pixel {worst:.2}");
        assert!(z.abs() < 4.0 && worst.abs() < 5.0);
    }
}

#[test]
fn point_light() {
    agrees("point", &edges_under_point_light());
}

#[test]
fn area_lights() {
    agrees("area", &edges_under_area_lights());
}

#[test]
fn specular() {
    agrees("specular", &edges_with_specular_surfaces());
}

#[test]
fn rough() {
    agrees("rough", &edges_with_rough_surfaces());
}
