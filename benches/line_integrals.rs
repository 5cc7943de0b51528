//! What one line integral costs: τ, τ with the gradients at both ends, a sampled distance, and that with the gradients up to there,
//! along random rays through a grid in the unit cube. `make bench` writes the table in README.md from these.

mod volumes;

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use volgrad::medium::{Line, moments, optical_depth, sample_distance, sample_distance_with_moments};
use volumes::{DEPTHS, ONE_SEGMENT, Ray, SHAPES, Shape, Volume, rays};

const SIDES: [i32; 3] = [64, 128, 256];
/// Of the plot that shows what bricks are for.
const PLOT_SIDES: [i32; 4] = [32, 64, 128, 256];

/// One call per iteration, each with the next ray.
fn bench(c: &mut Criterion, name: &str, parameter: &str, volume: &Volume, mut call: impl FnMut(&Line, f64)) {
    let media = [volume.medium()];
    let rays = rays();
    let mut next = rays.iter().cycle();
    c.bench_function(&format!("{name}/{parameter}"), |bencher| {
        bencher.iter(|| {
            let Some(Ray { origin, direction, length, u }) = next.next() else { return };
            call(&Line::new(&media, *origin, *direction, *length, &[ONE_SEGMENT]), *u);
        });
    });
}

fn line_integrals(c: &mut Criterion) {
    for side in SIDES {
        for (shape_name, shape) in SHAPES {
            for (depth_name, depth) in DEPTHS {
                let volume = Volume::new(side, shape, depth, true);
                let parameter = format!("{shape_name} {depth_name} {side}");
                bench(c, "tau", &parameter, &volume, |line, _| {
                    black_box(optical_depth(line));
                });
                bench(c, "gradients", &parameter, &volume, |line, _| {
                    let moments = moments(line);
                    black_box((
                        moments.near_gradient(line.direction, line.length),
                        moments.far_gradient(line.direction, line.length),
                    ));
                });
                bench(c, "distance", &parameter, &volume, |line, u| {
                    black_box(sample_distance(line, u));
                });
                bench(c, "distance and gradients", &parameter, &volume, |line, u| {
                    black_box(sample_distance_with_moments(line, u));
                });
            }
        }
    }
}

fn bricks(c: &mut Criterion) {
    for side in PLOT_SIDES {
        for (name, with_bricks) in [("bricks", true), ("no bricks", false)] {
            let volume = Volume::new(side, Shape::Sparse, 1.0, with_bricks);
            bench(c, name, &format!("sparse {side}"), &volume, |line, _| {
                black_box(optical_depth(line));
            });
        }
    }
}

criterion_group! {
    name = benches;
    config = volumes::criterion();
    targets = line_integrals, bricks
}
criterion_main!(benches);
