//! Image points, rays and world points: the same on all ways; and an importance that integrates to 1.

use super::{ROUNDING, direction, unit_square};
use proptest::prelude::*;
use volgrad::math::{DVec2, DVec3, orthonormal_basis};
use volgrad::medium::NONE;
use volgrad::scene::Camera;

const POSITION: DVec3 = DVec3::new(0.3, -1.2, 2.5);

/// Of a thin lens camera's lens.
const LENS_RADIUS: f64 = 0.4;
const FOCAL_DISTANCE: f64 = 3.0;

fn thin_lens_towards(forward: DVec3) -> Camera {
    Camera { lens_radius: LENS_RADIUS, focal_distance: FOCAL_DISTANCE, ..camera_towards(forward) }
}

fn camera_towards(forward: DVec3) -> Camera {
    let (right, _) = orthonormal_basis(forward);
    Camera {
        position: POSITION,
        forward,
        right,
        up: right.cross(forward),
        tan_half_fov_x: 0.7,
        width: 96,
        height: 54,
        crop: [10, 0, 96, 50],
        near_clip: 0.25,
        medium: NONE,
        lens_radius: 0.0,
        focal_distance: 1.0,
    }
}

/// Pixel coordinates in the cropped part.
fn in_crop(camera: &Camera, u: DVec2) -> DVec2 {
    let [x0, y0, x1, y1] = camera.crop.map(f64::from);
    DVec2::new(x0 + u.x * (x1 - x0), y0 + u.y * (y1 - y0))
}

proptest! {
    #[test]
    fn image_points_survive_their_rays(forward in direction(), u in unit_square(), depth in 0.3..100.0_f64) {
        let camera = camera_towards(forward);
        // Keeps off the border, at which a rounding decides.
        let pixel = in_crop(&camera, 0.001 + 0.998 * u);
        let ray = camera.ray(pixel, DVec2::ZERO);
        let distance = depth / ray.cosine;
        let x = camera.position + distance * ray.direction;
        prop_assert!((camera.depth(x) - depth).abs() < ROUNDING * depth);
        prop_assert!((ray.direction.length() - 1.0).abs() < ROUNDING);
        prop_assert!((ray.cosine - forward.dot(ray.direction)).abs() < ROUNDING);
        prop_assert!((ray.start * ray.cosine - camera.near_clip).abs() < ROUNDING, "a start on the near plane");

        let seen = camera.project(x, DVec2::ZERO).expect("in the image");
        prop_assert!((seen.pixel - pixel).length() < 1e3 * ROUNDING, "{} for {pixel}", seen.pixel);
        prop_assert!((seen.distance - distance).abs() < ROUNDING * distance);
        prop_assert!((seen.ray.direction - ray.direction).length() < ROUNDING);
        prop_assert!((seen.ray.cosine - ray.cosine).abs() < ROUNDING);
        prop_assert!((seen.ray.start - ray.start).abs() < ROUNDING);
    }

    /// What is in focus is seen at one image point from all of the lens, and where a pinhole would see it.
    #[test]
    fn thin_lenses_focus(forward in direction(), u in unit_square(), v in unit_square(), depth in 0.3..100.0_f64) {
        let (camera, pinhole) = (thin_lens_towards(forward), camera_towards(forward));
        let pixel = in_crop(&camera, 0.001 + 0.998 * u);
        let lens = camera.lens_point(v);
        prop_assert!(lens.length() <= LENS_RADIUS);
        let ray = camera.ray(pixel, lens);
        let offset = ray.origin - POSITION;
        prop_assert!((offset.length() - lens.length()).abs() < ROUNDING && offset.dot(forward).abs() < ROUNDING);
        prop_assert!((camera.on_lens(ray.origin) - lens).length() < ROUNDING);
        prop_assert!((ray.cosine - forward.dot(ray.direction)).abs() < ROUNDING);
        prop_assert!((ray.start * ray.cosine - camera.near_clip).abs() < ROUNDING, "a start on the near plane");
        let through_pinhole = pinhole.ray(pixel, DVec2::ZERO);
        let in_focus = POSITION + FOCAL_DISTANCE / through_pinhole.cosine * through_pinhole.direction;
        prop_assert!((ray.origin + FOCAL_DISTANCE / ray.cosine * ray.direction - in_focus).length() < 1e2 * ROUNDING);

        let x = ray.origin + depth / ray.cosine * ray.direction;
        let seen = camera.project(x, lens).expect("in the image");
        prop_assert!((seen.pixel - pixel).length() < 1e4 * ROUNDING, "{} for {pixel}", seen.pixel);
        prop_assert!((seen.distance - depth / ray.cosine).abs() < ROUNDING * seen.distance);
        prop_assert!((seen.ray.direction - ray.direction).length() < ROUNDING && (seen.ray.origin - ray.origin).length() < ROUNDING);
        prop_assert!((seen.ray.start - ray.start).abs() < ROUNDING && (seen.ray.cosine - ray.cosine).abs() < ROUNDING);
    }

    #[test]
    fn points_outside_the_sampled_pixels_are_not_seen(forward in direction(), u in unit_square(), off in 0.01..100.0_f64) {
        let camera = camera_towards(forward);
        let [x0, y0, x1, y1] = camera.crop.map(f64::from);
        let pixel = in_crop(&camera, u);
        let outside = [
            DVec2::new(x0 - off, pixel.y),
            DVec2::new(x1 + off, pixel.y),
            DVec2::new(pixel.x, y0 - off),
            DVec2::new(pixel.x, y1 + off),
        ];
        for pixel in outside {
            prop_assert!(camera.project(camera.position + 3.0 * camera.ray(pixel, DVec2::ZERO).direction, DVec2::ZERO).is_none(), "{pixel}");
        }
    }

    /// Before the near plane, at the camera, and behind it, where the projection would be upside down.
    #[test]
    fn points_before_the_near_plane_are_not_seen(forward in direction(), u in unit_square(), depth in -100.0..0.2499_f64) {
        let camera = camera_towards(forward);
        let ray = camera.ray(in_crop(&camera, u), DVec2::ZERO);
        prop_assert!(camera.project(camera.position + depth / ray.cosine * ray.direction, DVec2::ZERO).is_none());
        let no_near_plane = Camera { near_clip: 0.0, ..camera };
        prop_assert!(no_near_plane.project(camera.position, DVec2::ZERO).is_none());
        prop_assert_eq!(no_near_plane.project(camera.position + depth / ray.cosine * ray.direction, DVec2::ZERO).is_some(), depth > 0.0);
    }
}

#[test]
fn first_row_is_on_top_and_x_grows_to_the_right() {
    let camera = camera_towards(DVec3::Z);
    let centre = camera.ray(DVec2::new(48.0, 27.0), DVec2::ZERO);
    assert!((centre.direction - camera.forward).length() < ROUNDING && (centre.cosine - 1.0).abs() < ROUNDING);
    let [left, right] = [0.0, 96.0].map(|x| camera.ray(DVec2::new(x, 27.0), DVec2::ZERO).direction);
    let [top, bottom] = [0.0, 54.0].map(|y| camera.ray(DVec2::new(48.0, y), DVec2::ZERO).direction);
    assert!((right.dot(camera.right) / right.dot(camera.forward) - camera.tan_half_fov_x).abs() < ROUNDING);
    assert!((left.dot(camera.right) / left.dot(camera.forward) + camera.tan_half_fov_x).abs() < ROUNDING);
    let tan_half_fov_y = camera.tan_half_fov_x * 54.0 / 96.0;
    assert!((top.dot(camera.up) / top.dot(camera.forward) - tan_half_fov_y).abs() < ROUNDING);
    assert!((bottom.dot(camera.up) / bottom.dot(camera.forward) + tan_half_fov_y).abs() < ROUNDING);
}

#[test]
fn pixels_are_squares_of_pixel_size_on_the_plane_at_distance_one() {
    let camera = camera_towards(DVec3::new(0.48, -0.6, 0.64));
    let on_plane = |x: f64, y: f64| {
        let ray = camera.ray(DVec2::new(x, y), DVec2::ZERO);
        ray.direction / ray.direction.dot(camera.forward)
    };
    let (corner, beside, below) = (on_plane(17.0, 33.0), on_plane(18.0, 33.0), on_plane(17.0, 34.0));
    assert!(((beside - corner).length() - camera.pixel_size()).abs() < ROUNDING);
    assert!(((below - corner).length() - camera.pixel_size()).abs() < ROUNDING);
    assert!((beside - corner).dot(below - corner).abs() < ROUNDING);
    let area = (on_plane(96.0, 0.0) - on_plane(0.0, 0.0)).cross(on_plane(0.0, 54.0) - on_plane(0.0, 0.0)).length();
    assert!((camera.image_area() - area).abs() < ROUNDING);
}

/// Solid angle of a triangle of unit vectors.
/// Source: A. van Oosterom, J. Strackee, *The Solid Angle of a Plane Triangle*, IEEE Trans. Biomed. Eng. 1983.
fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// ∫ W_e cosθ dω over the image, by the midpoint rule over solid angles that know nothing of cosines: W_e is the density of an
/// image point drawn uniformly; through a point of a lens, times the density of that.
#[test]
fn importance_integrates_to_one() {
    let forward = DVec3::new(0.48, -0.6, 0.64);
    let lens_area = std::f64::consts::PI * LENS_RADIUS * LENS_RADIUS;
    let off_axis = DVec2::new(0.3, -0.2);
    for (camera, lens, area) in [(camera_towards(forward), DVec2::ZERO, 1.0), (thin_lens_towards(forward), off_axis, lens_area)]
    {
        let total = area * importance(&camera, lens);
        // The square of a part's width, 0.7/192.
        assert!((total - 1.0).abs() < 1e-5, "{total}");
    }
}

fn importance(camera: &Camera, lens: DVec2) -> f64 {
    const PARTS: u32 = 4;
    let part = 1.0 / f64::from(PARTS);
    let mut total = 0.0;
    for y in 0..PARTS * camera.height {
        for x in 0..PARTS * camera.width {
            let at = |dx: f64, dy: f64| camera.ray(part * DVec2::new(f64::from(x) + dx, f64::from(y) + dy), lens);
            let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)].map(|ray| ray.direction);
            let cosine = at(0.5, 0.5).cosine;
            total += camera.importance(cosine) * cosine * (solid_angle(a, b, c) + solid_angle(a, c, d));
        }
    }
    total
}
