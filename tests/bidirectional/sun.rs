//! Light that no path from the camera finds: a diffuse floor under a sheet of glass in the sun, for which there is a formula.
//!
//! Irradiance E across the sun's direction becomes E cosθ (1 − F) on the floor: flux is what passes, so that no index of refraction counts,
//! while radiance changes by its square. The camera is under the sheet.

use crate::toy::estimate::scale;
use crate::toy::scenes::{World, camera, rectangle};
use crate::{MOST, bidirectional, options, path_tracer, worlds};
use std::f64::consts::PI;
use volgrad::math::{Colour, DVec3};
use volgrad::sampler::bidirectional::Heuristic;
use volgrad::scene::{Bsdf, Camera, Light};

const ALBEDO: f64 = 0.6;

/// The sun shines at this cosine to the sheet's normal through a sheet, whose far side has this index of refraction relative to the sun's.
fn sunny(cosine: f64, eta: f64) -> World {
    let sine = (1.0 - cosine * cosine).sqrt();
    let direction = DVec3::new(sine, -cosine, 0.0);
    // The floor fills the image; the sheet lies between the sun and all of it.
    let camera = Camera { forward: -DVec3::Y, up: DVec3::Z, ..camera([0.0, 1.9, 0.0], 0.9, 2) };
    let slope = |sine: f64| sine / (1.0 - sine * sine).sqrt();
    let (floor, sheet) = (1.75, 1.75 + 2.0 * slope(sine).max(slope(sine / eta)));
    World::new(camera)
        .surface(rectangle([-floor, 0.0, -floor], [0.0, 0.0, 2.0 * floor], [2.0 * floor, 0.0, 0.0]), worlds::diffuse(ALBEDO))
        .surface(rectangle([-sheet, 2.0, -sheet], [0.0, 0.0, 2.0 * sheet], [2.0 * sheet, 0.0, 0.0]), Bsdf::Dielectric { eta })
        .light(Light::Directional { direction, irradiance: Colour::ONE }, 1.0)
}

/// Schoolbook Fresnel: the two polarisations by the angles.
fn passes(cosine: f64, eta: f64) -> f64 {
    let (cos, sin) = (cosine, (1.0 - cosine * cosine).sqrt() / eta);
    let beyond = (1.0 - sin * sin).sqrt();
    let s = (cos - eta * beyond) / (cos + eta * beyond);
    let p = (eta * cos - beyond) / (eta * cos + beyond);
    1.0 - 0.5 * (s * s + p * p)
}

#[test]
fn the_sun_through_glass() {
    for (cosine, eta) in [(1.0, 1.5), (0.6, 1.5), (0.9, 1.0 / 1.5)] {
        let world = sunny(cosine, eta);
        let exact = ALBEDO / PI * cosine * passes(cosine, eta);
        for heuristic in [Heuristic::Balance, Heuristic::Power] {
            // Three edges: no light that comes back from the sheet.
            let found = bidirectional(&world, options(3, heuristic), 150 * scale()).total();
            println!(
                "cosine {cosine}, η {eta:.3}: {:.5} ± {:.5}, exact {exact:.5}, z {:+.2}",
                found.value,
                found.error,
                found.z_to(exact)
            );
            assert!(found.z_to(exact).abs() < MOST && found.error < 0.025 * exact);
        }
        assert_eq!(path_tracer(&world, 3, 20).total().value, 0.0);
    }
}
