//! Metropolis light transport against the path sampler.

#[path = "toy/mod.rs"]
mod toy;

use toy::estimate::{Estimate, scale};
use toy::scenes::{World, edges_under_area_lights, edges_under_point_light, edges_with_rough_surfaces};
use volgrad::sampler::metropolis::{ChainStats, Metropolis, Options, Plan, State, Techniques, bootstrap, capacity, learn};
use volgrad::sampler::{self, Lengths, Stats};
use volgrad::shift;

const LENGTHS: Lengths = Lengths { first: 2, last: 5 };

fn path_tracer(world: &World, passes: u64) -> Estimate {
    let left_out = Lengths { first: 1, last: 1 };
    let options = sampler::Options { max_depth: LENGTHS.last, rr_depth: 3, seed: 1, shift: None, left_out };
    Estimate::of_path_tracer(world, options, passes)
}

/// Each batch has chains and a bootstrap of its own.
fn metropolis(world: &World, shift: Option<volgrad::shift::Options>, samples: u64, chains: u32, mutations: u64) -> Estimate {
    let scene = world.scene();
    let pixels = f64::from(scene.camera.width * scene.camera.height);
    Estimate::of_batches(world, 1, |batch, film| {
        let options = Options {
            seed: 100 + batch,
            large_step: 0.3,
            burn_in: 256,
            shift,
            shift_every: if shift.is_some() { 3 } else { 1 },
        };
        let mut stats = Stats::default();
        let mut chain_stats = ChainStats::default();
        let mut weights = vec![0.0; samples as usize];
        let alike = Techniques::alike(LENGTHS);
        bootstrap(&scene, &world.geometry, !options.seed, &alike, 0, &mut weights, &mut stats).expect("never stops");
        let techniques = learn(!options.seed, LENGTHS, &weights[..weights.len() / 4]);
        bootstrap(&scene, &world.geometry, options.seed, &techniques, 0, &mut weights, &mut stats).expect("never stops");
        let plan = Plan::new(options.seed, &techniques, &weights, chains);
        let mut index = 0;
        let (mut cells, mut dropped) = (vec![Default::default(); pixels as usize], 0);
        let mut sums = volgrad::film::Film { width: film.width, height: film.height, cells: &mut cells, dropped: &mut dropped };
        plan.starts(&weights, |start| {
            let mut numbers = vec![0.0; capacity(start.length as usize)];
            let mut state = State::new(&options, &techniques, index, start, &mut numbers).expect("of this plan");
            let chains = Metropolis { scene: &scene, queries: &world.geometry, options };
            chains.burn_in(&mut state, &mut numbers, &mut stats, &mut chain_stats).expect("never stops");
            chains.run(&mut state, &mut numbers, mutations, &mut sums, &mut stats, &mut chain_stats).expect("never stops");
            chains.flush(&state, &numbers, &mut sums, &mut stats).expect("never stops");
            index += 1;
        });
        assert_eq!(index, plan.chain_count);
        if batch == 0 {
            println!("b {} ± {:.4}, {chain_stats:?}", plan.brightness(), plan.relative_error());
        }
        let scale = pixels / (f64::from(plan.chain_count) * mutations as f64);
        for (i, cell) in cells.iter().enumerate() {
            let (x, y) = (i as u32 % film.width, i as u32 / film.width);
            film.add(volgrad::math::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), cell.value() * scale);
        }
        stats
    })
}

fn agrees(name: &str, world: &World) {
    use volgrad::shift::{Kernel, Mode, Radius};
    let expected = path_tracer(world, 60 * scale());
    let disk = Kernel::Disk(Radius::Pixels(1.0));
    let modes = [
        None,
        Some(shift::Options { run: 2, ..shift::Options::new(Mode::Exchangeable, Kernel::Tile, 3) }),
        Some(shift::Options { run: 2, ..shift::Options::new(Mode::Exact, disk, 3) }),
        Some(shift::Options { run: 3, ..shift::Options::new(Mode::TwoLevel, disk, 3) }),
    ];
    for shift in modes {
        let found = metropolis(world, shift, 4000 * scale(), 16, 400 * scale());
        let (a, b) = (expected.total(), found.total());
        let z = (b.value - a.value) / (a.error * a.error + b.error * b.error).sqrt();
        let mode = shift.map(|shift| shift.mode);
        println!("{name} {mode:?}: {:.5} ± {:.5} against {:.5} ± {:.5}, z {z:.2}", b.value, b.error, a.value, a.error);
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
fn rough() {
    agrees("rough", &edges_with_rough_surfaces());
}
