//! A thin lens: what is out of focus is as blurred as geometry says, paths start on the lens, and ∇log f is that of f.
//!
//! Significance: the blurred image's pixels are compared at |z| < 4.8: 64 of them trip a new seed with probability 1e-4. Seeds are fixed.

mod toy;

use toy::estimate::Estimate;
use toy::scenes::{World, camera, homogeneous};
use volgrad::math::{Colour, DVec2, DVec3, Vec3};
use volgrad::medium::Segment;
use volgrad::path::{Path, PathErrorKind, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, Vertex, contribution, path_log_gradient};
use volgrad::sampler::Options;
use volgrad::scene::{Camera, Light};

const RADIUS: f64 = 0.3;
const FOCAL_DISTANCE: f64 = 2.0;
const SIDE: u32 = 8;

fn lens_camera() -> Camera {
    Camera { lens_radius: RADIUS, focal_distance: FOCAL_DISTANCE, ..camera([0.1, -0.2, 0.0], 0.5, SIDE) }
}

/// A lamp of radiance 1 behind what is in focus.
const LAMP: ([f64; 3], [f64; 3], [f64; 3]) = ([-0.6, -0.9, 4.0], [0.0, 1.3, 0.0], [1.1, 0.0, 0.0]);

/// The share of the lens and of a pixel's area from which the lamp is seen, by the midpoint rule. Lines from a point on the lens
/// through one on the plane in focus go on to the lamp's plane.
fn share(x: u32, y: u32) -> f64 {
    const STEPS: u32 = 24;
    let camera = lens_camera();
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
    let half_side = FOCAL_DISTANCE * camera.tan_half_fov_x;
    let ([left, low, depth], [_, height, _], [width, ..]) = LAMP;
    let seen = |coordinate: f64, on_lens: f64, centre: f64, low: f64, high: f64| {
        let at_lamp = centre + on_lens + (coordinate - on_lens) * depth / FOCAL_DISTANCE;
        (low..high).contains(&at_lamp)
    };
    let mut count = 0;
    for i in 0..STEPS * STEPS * STEPS * STEPS {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| middle(i / STEPS.pow(k) % STEPS));
        let focus_x = ((f64::from(x) + a) / f64::from(SIDE) * 2.0 - 1.0) * half_side;
        let focus_y = (1.0 - (f64::from(y) + b) / f64::from(SIDE) * 2.0) * half_side;
        let (radius, angle) = (RADIUS * c.sqrt(), 2.0 * std::f64::consts::PI * d);
        let hit = seen(focus_x, radius * angle.cos(), camera.position.x, left, left + width)
            && seen(focus_y, radius * angle.sin(), camera.position.y, low, low + height);
        count += u32::from(hit);
    }
    f64::from(count) / f64::from(STEPS.pow(4))
}

#[test]
fn out_of_focus_is_as_blurred_as_geometry_says() {
    let world = World::new(lens_camera()).area_light(LAMP.0, LAMP.1, LAMP.2, 1.0, 1.0);
    let estimate = Estimate::of_path_tracer(
        &world,
        Options {
            max_depth: 1,
            rr_depth: 9,
            seed: 3,
            shift: None,
            left_out: volgrad::sampler::Lengths::NONE,
            first: volgrad::sampler::FirstVertices::ALL,
        },
        64,
    );
    let mut blurred = 0;
    for y in 0..SIDE {
        for x in 0..SIDE {
            let (mean, expected) = (estimate.pixel((y * SIDE + x) as usize), share(x, y));
            // The midpoint rule misses a thousandth of what an edge covers.
            let error = mean.error.hypot(2e-3);
            assert!((mean.value - expected).abs() < 4.8 * error, "({x}, {y}): {mean:?}, {expected}");
            blurred += u32::from(expected > 0.02 && expected < 0.98);
        }
    }
    assert!(blurred > 8, "{blurred} pixels see the lamp's edge");
}

/// x_0 on the lens, x_1 in fog, a point light.
fn vertices(x0: DVec3, x1: DVec3, light: DVec3) -> [Vertex; 3] {
    let vertex = |kind, position: DVec3| Vertex { kind, position: position.into(), ..Vertex::default() };
    [vertex(VERTEX_CAMERA, x0), vertex(VERTEX_MEDIUM, x1), vertex(VERTEX_LIGHT, light)]
}

const FOG: [Segment; 2] = [Segment { end: f32::INFINITY, medium: 0, normal: Vec3 { x: 0.0, y: 0.0, z: 0.0 } }; 2];

fn fog() -> World {
    World::new(Camera { near_clip: 0.0, ..lens_camera() })
        .medium([-9.0; 3], [9.0; 3], homogeneous([0.5, 0.7, 0.9], [0.9; 3], 0.6))
        .light(Light::Point { position: DVec3::new(1.0, 2.0, 2.5), intensity: Colour::ONE }, 1.0)
}

/// f by hand; all numbers are exact in single precision.
#[test]
fn paths_start_on_the_lens() {
    let world = fog();
    let scene = world.scene();
    let (x0, x1, light) = (DVec3::new(0.25, -0.125, 0.0), DVec3::new(0.5, 0.25, 1.5), DVec3::new(1.0, 2.0, 2.5));
    let vertices = vertices(x0, x1, light);
    let path = Path { vertices: &vertices, segments: &FOG, edge_ends: &[1, 2] };
    assert_eq!(path.validate(&scene), Ok(()));
    let (v, w) = (x1 - x0, light - x1);
    let cosine = v.z / v.length();
    // The image is 1 by 1 at distance 1, and G has one more cosine.
    let importance = 1.0 / (std::f64::consts::PI * RADIUS * RADIUS * cosine.powi(3) * v.length_squared());
    let phase = scene.media[0].phase.eval(-v.normalize().dot(w.normalize()));
    let f = contribution(&scene, &path).expect("a good path");
    for c in 0..3 {
        let (sigma_t, albedo) = (scene.media[0].sigma_t[c], scene.media[0].albedo[c]);
        let transmittance = (-sigma_t * (v.length() + w.length())).exp();
        let expected = importance * sigma_t * albedo * phase * transmittance / w.length_squared();
        assert!((f[c] / expected - 1.0).abs() < 1e-10, "{} {expected}", f[c]);
    }
    let unknown = Vertex { position: Vec3 { x: f32::NAN, y: 0.0, z: 0.0 }, ..vertices[0] };
    let path = Path { vertices: &[unknown, vertices[1], vertices[2]], ..path };
    assert_eq!(path.validate(&scene), Err(PathErrorKind::NotFinite.at(0)));
    let seen = scene.camera.project(x1, scene.camera.on_lens(x0)).expect("in view");
    assert!(
        (seen.ray.direction - v.normalize()).length() < 1e-12
            && seen.pixel != scene.camera.project(x1, DVec2::ZERO).expect("in view").pixel
    );
}

/// Far from the origin single precision keeps less of a point than a small lens is wide.
#[test]
fn small_lenses_far_away_have_valid_points() {
    let position = DVec3::new(1e4, -1e4, 1e4);
    let camera = Camera { lens_radius: 0.01, position, near_clip: 0.0, ..lens_camera() };
    let world = World::new(camera)
        .medium([-3e4; 3], [3e4; 3], homogeneous([0.5; 3], [0.9; 3], 0.6))
        .light(Light::Point { position: position + DVec3::Z, intensity: Colour::ONE }, 1.0);
    let validate = |radius: f64, angle: f64| {
        let on_lens = radius * DVec3::new(angle.cos(), angle.sin(), 0.0);
        let vertices = vertices(position + on_lens, position + DVec3::new(0.0, 1.0, 1.0), position + DVec3::Z);
        Path { vertices: &vertices, segments: &FOG, edge_ends: &[1, 2] }.validate(&world.scene())
    };
    for i in 0..64 {
        assert_eq!(validate(0.01, f64::from(i)), Ok(()));
        assert_eq!(validate(0.1, f64::from(i)), Err(PathErrorKind::Misplaced.at(0)));
    }
}

/// Steps of 1/256 are exact in single precision; central differences err by their square.
#[test]
fn gradient_is_that_of_the_contribution() {
    let world = fog();
    let scene = world.scene();
    let (x0, x1, light) = (DVec3::new(0.25, -0.125, 0.0), DVec3::new(0.5, 0.25, 1.5), DVec3::new(1.0, 2.0, 2.5));
    let log_f = |x1: DVec3| {
        let vertices = vertices(x0, x1, light);
        let path = Path { vertices: &vertices, segments: &FOG, edge_ends: &[1, 2] };
        contribution(&scene, &path).expect("a good path").to_array().map(f64::ln)
    };
    let vertices = vertices(x0, x1, light);
    let path = Path { vertices: &vertices, segments: &FOG, edge_ends: &[1, 2] };
    let gradient = path_log_gradient(&scene, &path, 1).expect("x_1 is in a medium").factors;
    let h = 1.0 / 256.0;
    for (axis, name) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(["x", "y", "z"]) {
        let (plus, minus) = (log_f(x1 + h * axis), log_f(x1 - h * axis));
        for c in 0..3 {
            let (found, expected) = (gradient.channel(c).dot(axis), (plus[c] - minus[c]) / (2.0 * h));
            assert!((found - expected).abs() < 1e-4, "{name}, channel {c}: {found}, {expected}");
        }
    }
}
