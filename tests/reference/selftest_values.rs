//! How right the reference's values are: optical depths, distances and contributions, each measured against something that
//! shares as little as possible with it.
//! `tests/reference_selftest.rs` states the tolerances.

use super::{
    differences::{derivative, gradient},
    distance::{distance_cdf, distance_pdf, invert_distance_cdf},
    medium::Medium,
    optical_depth::{optical_depth, optical_depth_in_medium, optical_depth_until},
    optical_depth_gradient::optical_depth_gradients_in_medium,
    path::{Path, Vertex},
    phase::Phase,
    random::*,
    scenes::scenes,
    segments::Edge,
    selftest::Worst,
    vector::*,
    world::World,
};
use std::f64::consts::PI;

/// τ by the midpoint rule with σ_t looked up point by point, which knows nothing of segments and pieces.
pub fn marched_optical_depth(world: &World, a: Vec3, b: Vec3, steps: usize) -> Rgb {
    let edge = Edge::between(a, b);
    let step = edge.length / steps as f64;
    let at = |i| world.sigma_t_at(edge.point((i as f64 + 0.5) * step));
    scale(step, (0..steps).map(at).fold(ZERO, add))
}

/// The difference between τ and marching, over the τ of a whole edge. Marching is off by up to a step per face.
pub fn worst_optical_depth(seed: u64, steps: usize) -> Worst {
    let mut rng = generator(seed);
    let mut worst = Worst::default();
    for scene in scenes(&mut rng, Phase::Isotropic) {
        for _ in 0..5 {
            let [a, b] = [0; 2].map(|_| random_vector(&mut rng, -1.5, 1.5));
            let tau = optical_depth(&scene.world, &Edge::between(a, b));
            let marched = marched_optical_depth(&scene.world, a, b, steps);
            worst.note(distance(tau, marched) / (1.0 + length(tau)), || scene.name.to_string());
        }
    }
    worst
}

/// ∇_a τ and ∇_b τ in one grid, with both ends inside of its box or not, against differences; relative to |∇τ|.
pub fn worst_optical_depth_gradient(medium: &Medium, seed: u64) -> Worst {
    let mut rng = generator(seed);
    let mut worst = Worst::default();
    for _ in 0..50 {
        let [a, b] = [0; 2].map(|_| random_vector(&mut rng, -1.2, 1.2));
        let [by_a, by_b] = optical_depth_gradients_in_medium(medium, a, b);
        let difference_a = gradient(|a| optical_depth_in_medium(medium, a, b), a);
        let difference_b = gradient(|b| optical_depth_in_medium(medium, a, b), b);
        for c in 0..3 {
            let magnitude = length(by_a[c]) + length(by_b[c]);
            if magnitude > 0.0 {
                worst.note(distance(by_a[c], difference_a[c]) / magnitude, || format!("∇_a from {a:?} to {b:?}"));
                worst.note(distance(by_b[c], difference_b[c]) / magnitude, || format!("∇_b from {a:?} to {b:?}"));
            }
        }
    }
    worst
}

/// cdf(inverse(u)) − u, and the pdf minus the derivative of the cdf, along camera rays.
pub fn worst_distance(seed: u64) -> [Worst; 2] {
    let mut rng = generator(seed);
    let [mut round_trip, mut density] = [Worst::default(), Worst::default()];
    for scene in scenes(&mut rng, Phase::Isotropic) {
        for _ in 0..5 {
            let target = random_vector(&mut rng, -0.5, 0.5);
            let camera = &scene.world.camera;
            let ray = Edge::camera_ray(camera, direction(camera.position, target));
            let u = uniform(&mut rng, 0.0, 1.0);
            let Some(t) = invert_distance_cdf(&scene.world, &ray, u) else {
                let end = distance_cdf(&scene.world, &ray, ray.length);
                round_trip.note(if end < u { 0.0 } else { f64::NAN }, || format!("no distance, {}", scene.name));
                continue;
            };
            round_trip.note((distance_cdf(&scene.world, &ray, t) - u).abs(), || scene.name.to_string());
            let [derivative] = derivative(|h| [distance_cdf(&scene.world, &ray, t + h)]);
            let pdf = distance_pdf(&scene.world, &ray, t);
            density.note((pdf - derivative).abs() / pdf, || scene.name.to_string());
        }
    }
    [round_trip, density]
}

/// ∫ f_p over the sphere by the midpoint rule.
pub fn phase_integral(phase: Phase) -> f64 {
    let steps = 100_000;
    let width = 2.0 / steps as f64;
    (0..steps).map(|i| 2.0 * PI * width * phase.value(-1.0 + (i as f64 + 0.5) * width)).sum()
}

/// f of camera, one scattering in a homogeneous medium without end, point light, written out by hand.
pub fn single_scattering_by_hand(world: &World, x: Vec3, light: Vec3, intensity: Rgb) -> Rgb {
    let (camera, medium) = (&world.camera, &world.media[0]);
    let (d1, d2) = (distance(camera.position, x), distance(x, light));
    let cosine = camera.depth(x) / d1;
    let lens = 1.0 / (camera.image_area * cosine.powi(3) * d1 * d1 * d2 * d2);
    let Phase::HenyeyGreenstein { g } = medium.phase else { panic!("written for Henyey-Greenstein") };
    // The law of cosines: the angle at x in the triangle of camera, x and light.
    let d3 = distance(camera.position, light);
    let c = (d1 * d1 + d2 * d2 - d3 * d3) / (2.0 * d1 * d2);
    let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g + 2.0 * g * c).powf(1.5));
    [0, 1, 2].map(|i| {
        let sigma_t = medium.sigma_t[i];
        lens * (-sigma_t * (d1 + d2)).exp() * medium.albedo[i] * sigma_t * phase * intensity[i]
    })
}

/// τ over the first part of an edge and the rest of it, minus the whole.
pub fn additivity_error(world: &World, a: Vec3, b: Vec3, t: f64) -> f64 {
    let edge = Edge::between(a, b);
    let first = optical_depth_until(world, &edge, t);
    let second = optical_depth(world, &Edge::between(edge.point(t), b));
    distance(add(first, second), optical_depth(world, &edge))
}

/// A path of one scattering between the camera and a point light.
pub fn single_scattering_path(position: Vec3, light: Vec3, intensity: Rgb) -> Path {
    let scatter = Vertex::Medium { position, medium: 0 };
    Path { vertices: vec![Vertex::Camera, scatter, Vertex::PointLight { position: light, intensity }] }
}
