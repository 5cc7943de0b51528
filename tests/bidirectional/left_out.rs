//! What the path sampler renders of paths longer than those that another sampler renders.

use crate::toy::estimate::{Estimate, scale};
use crate::toy::scenes::{World, homogeneous};
use crate::{MOST, MOST_OF_PIXELS, pixels, worlds, z};
use volgrad::math::{Colour, DVec3};
use volgrad::sampler::{FirstVertices, Lengths, Options, PathTracer, Stats};
use volgrad::scene::{Camera, Light};
use volgrad::shift::{self, Kernel, Mode, Radius};

/// Beyond this there is hardly any light left, with or without roulette.
const LONGEST: u32 = 160;

/// Almost nothing is absorbed, and from the camera it takes some thirty scatterings to get out: much light comes by long paths.
fn cloud() -> World {
    let medium = homogeneous([3.5, 4.0, 4.5], [0.999, 0.998, 0.997], 0.0);
    let inside = Camera { position: DVec3::new(0.1, 0.0, -0.1), ..worlds::pinhole() };
    World::new(inside)
        .medium([-1.3; 3], [1.2; 3], medium)
        .light(Light::Environment { radiance: Colour::new(0.3, 0.4, 0.5) }, 1.0)
}

fn render(world: &World, options: Options, passes: u64) -> Estimate {
    let scene = world.scene();
    let tracer = PathTracer { scene: &scene, queries: &world.geometry, options };
    Estimate::of_batches(world, passes, |batch, film| {
        let mut stats = Stats::default();
        for pass in batch * passes..(batch + 1) * passes {
            tracer.sample_pixels(pass, 0..pixels(world), film, &mut stats).expect("the toy host never stops");
        }
        stats
    })
}

/// Against paths of all lengths, less those of the lengths left out. The same seed gives both the same paths, so that the difference is
/// that of what remains alone.
#[test]
fn paths_longer_than_those_left_out() {
    let world = cloud();
    let whole = |max_depth| {
        let options =
            Options { max_depth, rr_depth: 40, seed: 1, shift: None, left_out: Lengths::NONE, first: FirstVertices::ALL };
        render(&world, options, 8 * scale())
    };
    let all = whole(LONGEST);
    let shift = shift::Options::new(Mode::Exact, Kernel::Disk(Radius::Pixels(0.5)), 4);
    for (first, last, shift) in [(2, 24, None), (5, 24, None), (2, 24, Some(shift)), (2, 4, None)] {
        let left_out = Lengths { first, last };
        let options = Options { max_depth: LONGEST, rr_depth: 40, seed: 3, shift, left_out, first: FirstVertices::ALL };
        let found = render(&world, options, 64 * scale());
        let tail = all.minus(&whole(last));
        let expected = tail.plus(&whole(first - 1));
        let share = tail.total().value / all.total().value;
        let channels = (0..3).map(|c| z(found.channel(c), expected.channel(c)));
        let pixels = (0..found.pixels()).map(|i| z(found.pixel(i), expected.pixel(i)));
        let [channels, pixels] =
            [channels.collect::<Vec<_>>(), pixels.collect()].map(|z| z.iter().fold(0.0, |a: f64, b| a.max(b.abs())));
        let error = found.total().error / expected.total().value;
        println!("{first} … {last}: tail {:.0} %, error {:.2} %, z {channels:.2}, {pixels:.2}", 100.0 * share, 100.0 * error);
        assert!(share > 0.2 && error < 0.03);
        assert!(channels < MOST && pixels < MOST_OF_PIXELS, "{first} … {last}");
    }
}
