//! The unbiased shifts leave every pixel's mean alone: the path sampler with and without them, on scenes with a medium edge, a
//! shadow edge inside media, an occluder's edge before them, and mirrors and glass in them, behind runs of medium vertices.
//!
//! Both take the same paths, so that only what shifts add is noise. 64 pixels and 3 channel totals are compared each time; 22 times
//! make 1408 and 66 comparisons. Significance: if all is right, a new seed trips |z| < 4.8 at a pixel with probability 1408·1.6e-6 and
//! |z| < 4 at a total with 66·6.3e-5: 0.6 % in all. (64 batches each: Student's t doubles that.) Seeds are fixed.
//! VOLGRAD_LONG takes 20 times the paths.

mod toy;

use std::sync::OnceLock;
use toy::estimate::{BATCHES, Estimate, Scores, scale};
use toy::scenes::{World, edges, edges_under_point_light, edges_with_rough_surfaces, edges_with_specular_surfaces};
use volgrad::math::{Colour, DVec3};
use volgrad::sampler;
use volgrad::scene::{Falloff, Light};
use volgrad::shift::{Kernel, MAX_RUN, Mode, Options, Radius};

/// Paths per pixel and batch of a quick run: 64 pixels × 64 batches × 48 = 196 608 paths per estimate.
const PASSES: u64 = 48;
/// Most edges of a path: six scatterings.
const MAX_DEPTH: u32 = 7;

const PIXEL_LIMIT: f64 = 4.8;
const TOTAL_LIMIT: f64 = 4.0;

/// About one pixel and a half, which at the media's depth is 0.5 to 1 world units: as large as the media's own structure.
const DISK: Kernel = Kernel::Disk(Radius::Pixels(1.5));
const BALL: Kernel = Kernel::Ball(0.35);
/// Far beyond where a linear log f is any good.
const LARGE_DISK: Kernel = Kernel::Disk(Radius::Pixels(1.0));

/// A scene and what the unshifted sampler makes of it.
struct Subject {
    world: World,
    options: sampler::Options,
    reference: Estimate,
}

fn subject(world: World, max_depth: u32) -> Subject {
    let options = sampler::Options {
        max_depth,
        rr_depth: 3,
        seed: 1,
        shift: None,
        left_out: volgrad::sampler::Lengths::NONE,
        first: volgrad::sampler::FirstVertices::ALL,
    };
    let reference = Estimate::of_path_tracer(&world, options, PASSES * scale());
    Subject { world, options, reference }
}

/// A medium edge, a shadow edge, an occluder's edge; a point light.
fn point_light() -> &'static Subject {
    static SUBJECT: OnceLock<Subject> = OnceLock::new();
    SUBJECT.get_or_init(|| subject(edges_under_point_light(), MAX_DEPTH))
}

/// The same edges, all other lights, and specular surfaces in the media.
fn specular() -> &'static Subject {
    static SUBJECT: OnceLock<Subject> = OnceLock::new();
    SUBJECT.get_or_init(|| subject(edges_with_specular_surfaces(), MAX_DEPTH))
}

/// Four members beside the path's own, or eight on a tile of 3 × 3 pixels.
fn options(mode: Mode, kernel: Kernel, run: usize) -> Options {
    let count = if kernel == Kernel::Tile { 8 } else { 4 };
    Options { run, ..Options::new(mode, kernel, count) }
}

fn scores(subject: &Subject, shift: Options) -> Scores {
    let sampler = sampler::Options { shift: Some(shift), ..subject.options };
    let estimate = Estimate::of_path_tracer(&subject.world, sampler, PASSES * scale());
    let scores = estimate.paired_scores(&subject.reference);
    let stats = estimate.stats;
    println!(
        "{:?} {:?} × {}, run {}: worst z pixel {:+.2}, total {:+.2}; total {:+.3} % ± {:.3} %; {BATCHES} batches, {} paths, \
         {:.0} % shifted, {:.0} % of shifts stay, {} splats dropped",
        shift.mode,
        shift.kernel,
        shift.count,
        shift.run,
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

fn assert_unbiased(subject: &Subject, shift: Options) {
    let scores = scores(subject, shift);
    assert_eq!(scores.dropped, 0);
    assert!(scores.pixel.abs() < PIXEL_LIMIT && scores.total.abs() < TOTAL_LIMIT, "{shift:?}: {scores:?}");
}

#[test]
fn exact_disk_under_a_point_light() {
    assert_unbiased(point_light(), options(Mode::Exact, DISK, 1));
}

#[test]
fn exact_ball_under_a_point_light() {
    assert_unbiased(point_light(), options(Mode::Exact, BALL, 3));
}

#[test]
fn exact_tile_under_a_point_light() {
    assert_unbiased(point_light(), options(Mode::Exact, Kernel::Tile, MAX_RUN));
}

#[test]
fn exact_disk_beside_specular_surfaces() {
    assert_unbiased(specular(), options(Mode::Exact, DISK, MAX_RUN));
}

#[test]
fn exact_ball_beside_specular_surfaces() {
    assert_unbiased(specular(), options(Mode::Exact, BALL, 1));
}

#[test]
fn exact_tile_beside_specular_surfaces() {
    assert_unbiased(specular(), Options { count: 3, ..options(Mode::Exact, Kernel::Tile, 1) });
}

#[test]
fn two_level_disk_under_a_point_light() {
    assert_unbiased(point_light(), options(Mode::TwoLevel, DISK, 3));
}

#[test]
fn two_level_tile_under_a_point_light() {
    assert_unbiased(point_light(), Options { exact_count: 2, ..options(Mode::TwoLevel, Kernel::Tile, 1) });
}

#[test]
fn two_level_ball_beside_specular_surfaces() {
    assert_unbiased(specular(), Options { exact_count: 2, ..options(Mode::TwoLevel, BALL, MAX_RUN) });
}

#[test]
fn two_level_tile_beside_specular_surfaces() {
    assert_unbiased(specular(), Options { count: 3, ..options(Mode::TwoLevel, Kernel::Tile, 3) });
}

#[test]
fn exchangeable_disk_under_a_point_light() {
    assert_unbiased(point_light(), options(Mode::Exchangeable, DISK, MAX_RUN));
}

#[test]
fn exchangeable_ball_under_a_point_light() {
    assert_unbiased(point_light(), options(Mode::Exchangeable, BALL, 1));
}

#[test]
fn exchangeable_tile_under_a_point_light() {
    assert_unbiased(point_light(), Options { count: 3, ..options(Mode::Exchangeable, Kernel::Tile, 3) });
}

#[test]
fn exchangeable_disk_beside_specular_surfaces() {
    assert_unbiased(specular(), options(Mode::Exchangeable, DISK, 1));
}

#[test]
fn exchangeable_ball_beside_specular_surfaces() {
    assert_unbiased(specular(), options(Mode::Exchangeable, BALL, 3));
}

#[test]
fn exchangeable_tile_beside_specular_surfaces() {
    assert_unbiased(specular(), options(Mode::Exchangeable, Kernel::Tile, MAX_RUN));
}

/// What x_1 gets from a spot light depends on where it is.
#[test]
fn exact_disk_under_a_spot_light() {
    let (position, axis) = (DVec3::new(0.3, 2.7, -0.8), DVec3::new(0.0, -0.7, 0.7).normalize());
    let spot = Light::Spot { position, axis, intensity: Colour::splat(20.0), falloff: Falloff::new(0.97, 0.6) };
    assert_unbiased(&subject(edges().light(spot, 1.0), 4), options(Mode::Exact, DISK, 3));
}

/// A shifted path goes through the same point of the lens.
#[test]
fn through_a_thin_lens() {
    let mut world = edges_with_specular_surfaces();
    (world.camera.lens_radius, world.camera.focal_distance) = (0.3, 2.0);
    let subject = subject(world, 5);
    assert_unbiased(&subject, options(Mode::Exact, DISK, 1));
    assert_unbiased(&subject, options(Mode::Exchangeable, Kernel::Tile, 3));
}

/// Paths that begin on a rough mirror, seen from its front, and on a two-sided wall, seen from behind.
#[test]
fn from_rough_and_two_sided_surfaces() {
    let subject = subject(edges_with_rough_surfaces(), 5);
    assert_unbiased(&subject, options(Mode::Exact, DISK, 1));
    assert_unbiased(&subject, options(Mode::TwoLevel, Kernel::Tile, 3));
    assert_unbiased(&subject, options(Mode::Exchangeable, DISK, 1));
    assert_unbiased(&subject, options(Mode::Exchangeable, Kernel::Tile, 1));
}

/// The same comparison sees the bias that modes are known to have. Single scattering: for longer paths the bias knows no bounds,
/// as exp(2 offset/distance) has no mean where the next vertex may be near.
#[test]
fn biased_modes_are_biased_at_a_large_radius() {
    let single = subject(edges_under_point_light(), 2);
    for mode in [Mode::FirstOrder, Mode::HalfOrder, Mode::LogLinear, Mode::LinearDepth] {
        let scores = scores(&single, options(mode, LARGE_DISK, 1));
        assert!(scores.pixel.abs() > 8.0, "{mode:?}, {scores:?}: this comparison cannot fail");
    }
}

/// What two_level corrects on tiles.
#[test]
fn linear_depth_on_a_tile_is_biased() {
    let scores = scores(point_light(), options(Mode::LinearDepth, Kernel::Tile, 3));
    assert!(scores.pixel.abs() > 8.0, "{scores:?}: this comparison cannot fail");
}
