//! The path sampler and both heuristics find the same images, in worlds that isolate a light, a camera, a material, a medium.
//!
//! In these no light reaches the camera in ways that the path sampler does not find, or hardly does.

use crate::toy::estimate::scale;
use crate::toy::scenes::{
    World, edges_under_area_lights, edges_under_point_light, edges_with_rough_surfaces, edges_with_specular_surfaces,
};
use crate::{MOST, MOST_OF_PIXELS, bidirectional, options, path_tracer, worlds, z};
use volgrad::math::Colour;
use volgrad::sampler::bidirectional::Heuristic;
use volgrad::scene::Light;

const LONGEST: u32 = 4;

fn agree(worlds: Vec<(&str, World)>) {
    let mut wrong = vec![];
    for (name, world) in worlds {
        let expected = path_tracer(&world, LONGEST, 32 * scale());
        for heuristic in [Heuristic::Balance, Heuristic::Power] {
            let found = bidirectional(&world, options(LONGEST, heuristic), 8 * scale());
            let (a, b) = (found.total(), expected.total());
            let total = (0..3).map(|c| z(found.channel(c), expected.channel(c)));
            let pixel = (0..found.pixels()).map(|i| z(found.pixel(i), expected.pixel(i)));
            let worst =
                |scores: &mut dyn Iterator<Item = f64>| scores.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
            let (total, pixel) = (worst(&mut total.into_iter()), worst(&mut pixel.into_iter()));
            println!(
                "{name}, {heuristic:?}: {:.5} ± {:.2} % against {:.5} ± {:.2} %, z {total:+.2}, of pixels {pixel:+.2}",
                a.value,
                100.0 * a.error / a.value,
                b.value,
                100.0 * b.error / b.value
            );
            if !(total.abs() < MOST && pixel.abs() < MOST_OF_PIXELS) || found.dropped > 0 {
                wrong.push((name, heuristic));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn under_each_light() {
    agree(worlds::lights());
}

#[test]
fn through_each_camera() {
    agree(worlds::cameras());
}

#[test]
fn on_each_material() {
    agree(worlds::materials());
}

#[test]
fn in_each_medium() {
    agree(worlds::media());
}

#[test]
fn through_glass() {
    agree(worlds::glass());
}

/// The worlds that shifts are tested in. The path sampler never finds the sun through a pane of glass, so that is put out.
#[test]
fn across_all_kinds_of_edges() {
    let mut specular = edges_with_specular_surfaces();
    for light in &mut specular.lights {
        if let Light::Directional { irradiance, .. } = light {
            *irradiance = Colour::ZERO;
        }
    }
    agree(vec![
        ("point light", edges_under_point_light()),
        ("area lights", edges_under_area_lights()),
        ("specular", specular),
        ("rough", edges_with_rough_surfaces()),
    ]);
}
