//! The gradients that a batch is weighted with, seen from outside: 1 + ⟨g, d⟩, 1 + ½⟨g, d⟩ and exp⟨g, d⟩ tell ⟨g, d⟩, and on a disk
//! the pixel of a splat tells d. Against the gradient of the whole path.

use super::{
    SEED,
    common::{assert_below, host::*},
    reference::{
        random_paths::PATTERNS,
        selftest::{Worst, for_each_path},
    },
};
use volgrad::math::{DVec2, luminance};
use volgrad::path::{Path, contribution, path_run_log_gradient};
use volgrad::sampler::shift_numbers;
use volgrad::scene::{Hit, Queries, Ray, Scene, Stop};
use volgrad::shift::{Draw, Kernel, Mode, Options, Radius, from_path, shift};

/// Relative to |g||d|; sums of the same numbers in another order.
const TOLERANCE: f64 = 1e-9;
/// A path's point of the lens is in single precision, and so not quite on the lens.
const LENS_TOLERANCE: f64 = 1e-6;
const LONGEST_RUN: usize = 3;

/// These modes ask nothing.
struct Silent;

impl Queries for Silent {
    fn intersect(&self, _: &[Ray], _: &mut [Hit]) -> Result<(), Stop> {
        Err(Stop::Callback(1))
    }

    fn occluded(&self, _: &[Ray], _: &mut [Hit]) -> Result<(), Stop> {
        Err(Stop::Callback(1))
    }
}

/// What a mode's weights say about ⟨g, d⟩ when the path's first `run` vertices move by d, and that in truth.
fn note_slopes(worst: &mut Worst, scene: &Scene, path: &Path, run: usize, mode: Mode, name: &str) {
    let options = Options { run, ..Options::new(mode, Kernel::Disk(Radius::Pixels(1.0)), 4) };
    let f = contribution(scene, path).expect("valid");
    let x = path.position(scene, 1).expect("valid");
    let camera = scene.camera.at(path.position(scene, 0).expect("valid"));
    // Off the image there is nothing to shift.
    let Ok(shiftable) = from_path(scene, path, f, &options) else { return };
    let shiftable = shiftable.expect("begins in a medium");
    assert_eq!(shiftable.run().len(), run);
    let g = path_run_log_gradient(scene, path, 1, run).expect("f > 0").luminance;
    let mut splats = vec![];
    let draw = Draw { tiles: [0; 2], random: shift_numbers(SEED, worst.count as u64, 0) };
    shift(scene, &Silent, &options, &shiftable, None, draw, |p, c| splats.push((p, c))).expect("asks nothing");
    let (own, _) = splats.pop().expect("the path's own");
    for (pixel, colour) in splats.into_iter().filter(|(_, colour)| luminance(*colour) != 0.0) {
        let w = (options.count + 1) as f64 * luminance(colour) / luminance(f);
        let slope = match mode {
            Mode::FirstOrder => w - 1.0,
            Mode::HalfOrder => 2.0 * (w - 1.0),
            _ => w.ln(),
        };
        let by: DVec2 = (pixel - own) * camera.pixel_size() * camera.depth(x);
        let d = by.x * camera.right - by.y * camera.up;
        worst.note((slope - g.dot(d)).abs() / (g.length() * d.length()), || format!("{mode:?} of x_1…x_{run} in {name}"));
    }
}

#[test]
fn batches_use_the_gradient_of_the_whole_run() {
    let [mut pinhole, mut lens] = [Worst::default(), Worst::default()];
    for_each_path(SEED, &PATTERNS, |scene, phase, pattern, path| {
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        let leading = path.vertices.iter().skip(1).take_while(|vertex| vertex.is_medium()).count();
        with_path(&world, &path, Bricks::Built, |view, path| {
            let worst = if view.camera.is_pinhole() { &mut pinhole } else { &mut lens };
            for run in 1..=leading.min(LONGEST_RUN) {
                for mode in [Mode::FirstOrder, Mode::HalfOrder, Mode::LogLinear] {
                    note_slopes(worst, view, path, run, mode, &format!("{pattern}, {}, {phase:?}", scene.name));
                }
            }
        });
    });
    assert_below(&pinhole, TOLERANCE);
    assert_below(&lens, LENS_TOLERANCE);
    assert!(pinhole.count > 5000 && lens.count > 500);
}
