//! The unbiased shifts leave every pixel's mean alone: the path sampler with and without them, on scenes with a medium edge, a
//! shadow edge inside media and an occluder's edge before them.
//!
//! Both take the same paths, so that only what shifts add is noise. Per test 64 pixels and 3 channel totals are compared; 10 tests
//! make 640 and 30 comparisons. Significance: if all is right, a new seed trips |z| < 4.8 at a pixel with probability 640·1.6e-6 and
//! |z| < 4 at a total with 30·6.3e-5: 0.29 % in all. (64 batches each: Student's t doubles that.) Seeds are fixed. VOLGRAD_LONG
//! takes 20 times the paths: 10.5 million per estimate.

mod toy;

use std::sync::OnceLock;
use toy::estimate::{BATCHES, Estimate, Scores, scale};
use toy::scenes::{World, edges, edges_under_area_lights, edges_under_point_light};
use volgrad::math::{Colour, DVec3};
use volgrad::sampler;
use volgrad::scene::{Falloff, Light};
use volgrad::shift::{self, Kernel, Mode, Radius};

/// Paths per pixel and batch of a quick run: 64 pixels × 64 batches × 128 = 524 288 paths per estimate.
const PASSES: u64 = 128;

const PIXEL_LIMIT: f64 = 4.8;
const TOTAL_LIMIT: f64 = 4.0;

/// About one pixel and a half, which at the media's depth is 0.5 to 1 world units: as large as the media's own structure.
const DISK: (Kernel, Radius) = (Kernel::Disk, Radius::Pixels(1.5));
const BALL: (Kernel, Radius) = (Kernel::Ball, Radius::World(0.35));
/// Far beyond where a linear log f is any good.
const LARGE_DISK: (Kernel, Radius) = (Kernel::Disk, Radius::Pixels(1.0));

/// A scene and what the unshifted sampler makes of it.
struct Subject {
    world: World,
    options: sampler::Options,
    reference: Estimate,
}

fn subject(world: World, max_depth: u32) -> Subject {
    let options = sampler::Options { max_depth, rr_depth: 3, seed: 1, shift: None };
    let reference = Estimate::of_path_tracer(&world, options, PASSES * scale());
    Subject { world, options, reference }
}

fn point_light() -> &'static Subject {
    static SUBJECT: OnceLock<Subject> = OnceLock::new();
    SUBJECT.get_or_init(|| subject(edges_under_point_light(), 5))
}

fn area_lights() -> &'static Subject {
    static SUBJECT: OnceLock<Subject> = OnceLock::new();
    SUBJECT.get_or_init(|| subject(edges_under_area_lights(), 5))
}

fn scores(subject: &Subject, mode: Mode, (kernel, radius): (Kernel, Radius)) -> Scores {
    let shift = Some(shift::Options { mode, kernel, radius, count: 4 });
    let options = sampler::Options { shift, ..subject.options };
    let estimate = Estimate::of_path_tracer(&subject.world, options, PASSES * scale());
    let scores = estimate.paired_scores(&subject.reference);
    let stats = estimate.stats;
    println!(
        "{mode:?} {kernel:?}: worst z pixel {:+.2}, total {:+.2}; total {:+.3} % ± {:.3} %; {BATCHES} batches, {} paths, \
         {:.0} % shifted, {:.0} % of shifts stay, {} splats dropped",
        scores.pixel,
        scores.total,
        100.0 * scores.bias,
        100.0 * scores.error,
        stats.paths,
        100.0 * stats.shifted_paths as f64 / stats.paths as f64,
        100.0 * stats.stays as f64 / stats.shifts as f64,
        scores.dropped,
    );
    scores
}

fn assert_unbiased(subject: &Subject, mode: Mode, kernel: (Kernel, Radius)) {
    let scores = scores(subject, mode, kernel);
    assert_eq!(scores.dropped, 0);
    assert!(scores.pixel.abs() < PIXEL_LIMIT && scores.total.abs() < TOTAL_LIMIT, "{scores:?}");
}

#[test]
fn exact_disk_under_a_point_light() {
    assert_unbiased(point_light(), Mode::Exact, DISK);
}

#[test]
fn exact_ball_under_a_point_light() {
    assert_unbiased(point_light(), Mode::Exact, BALL);
}

#[test]
fn exchangeable_disk_under_a_point_light() {
    assert_unbiased(point_light(), Mode::Exchangeable, DISK);
}

#[test]
fn exchangeable_ball_under_a_point_light() {
    assert_unbiased(point_light(), Mode::Exchangeable, BALL);
}

#[test]
fn exact_disk_under_area_lights() {
    assert_unbiased(area_lights(), Mode::Exact, DISK);
}

#[test]
fn exact_ball_under_area_lights() {
    assert_unbiased(area_lights(), Mode::Exact, BALL);
}

#[test]
fn exchangeable_disk_under_area_lights() {
    assert_unbiased(area_lights(), Mode::Exchangeable, DISK);
}

#[test]
fn exchangeable_ball_under_area_lights() {
    assert_unbiased(area_lights(), Mode::Exchangeable, BALL);
}

/// What x_1 gets from a spot light depends on where it is.
#[test]
fn exact_disk_under_a_spot_light() {
    let (position, axis) = (DVec3::new(0.3, 2.7, -0.8), DVec3::new(0.0, -0.7, 0.7).normalize());
    let spot = Light::Spot { position, axis, intensity: Colour::splat(20.0), falloff: Falloff::new(0.97, 0.6) };
    assert_unbiased(&subject(edges().light(spot, 1.0), 4), Mode::Exact, DISK);
}

/// A shifted path goes through the same point of the lens.
#[test]
fn exact_disk_through_a_thin_lens() {
    let mut world = edges_under_area_lights();
    (world.camera.lens_radius, world.camera.focal_distance) = (0.3, 2.0);
    assert_unbiased(&subject(world, 5), Mode::Exact, DISK);
}

/// The same comparison sees the bias that a mode is known to have. Single scattering: for longer paths the bias knows no bounds,
/// as exp(2 offset/distance) has no mean where the next vertex may be near.
#[test]
fn log_linear_at_a_large_radius_is_biased() {
    let scores = scores(&subject(edges_under_point_light(), 2), Mode::LogLinear, LARGE_DISK);
    assert!(scores.pixel.abs() > 8.0, "{scores:?}: this comparison cannot fail");
}
