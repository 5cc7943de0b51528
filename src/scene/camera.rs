//! The pinhole camera: from image points to directions, back, and its importance.

use super::{Ray, Scene};
use crate::math::{DVec2, DVec3};
use crate::medium::{Line, Segment};

/// A pinhole camera. `right`, `up`, `forward` are orthonormal; pixel x grows along `right`, pixel y against `up`.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    pub position: DVec3,
    pub forward: DVec3,
    pub right: DVec3,
    pub up: DVec3,
    pub tan_half_fov_x: f64,
    pub width: u32,
    pub height: u32,
    /// Sampled pixels: [x0, y0] inclusive to [x1, y1] exclusive.
    pub crop: [u32; 4],
    /// Distance of the near plane along `forward`.
    pub near_clip: f64,
    /// Medium around the near plane.
    pub medium: u32,
}

/// A ray through an image point. It starts at the near plane, `start` away from the camera's position.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    pub direction: DVec3,
    pub start: f64,
    /// Cosine to the viewing direction.
    pub cosine: f64,
}

/// Where a world point is seen.
#[derive(Clone, Copy, Debug)]
pub struct ImagePoint {
    /// Pixel coordinates; pixel (i, j) covers [i, i+1) × [j, j+1).
    pub pixel: DVec2,
    pub ray: CameraRay,
    pub distance: f64,
}

impl CameraRay {
    /// The same ray for the host, from the near plane on and `length` from the camera's position.
    pub fn free(&self, camera: &Camera, length: f64) -> Ray {
        let start = camera.position + self.start * self.direction;
        Ray::free(start, self.direction, length - self.start, camera.medium)
    }

    /// The edge along it, `length` from the camera's position; `segments` start at the near plane.
    pub fn line<'s>(&self, scene: &'s Scene<'s>, length: f64, segments: &'s [Segment]) -> Line<'s> {
        let camera = &scene.camera;
        let line = Line::new(scene.media, camera.position, self.direction, length, segments);
        Line { start: self.start, start_normal: camera.forward, segments_start: self.start, ..line }
    }
}

impl Camera {
    /// Side of a pixel on the plane at distance 1.
    pub fn pixel_size(&self) -> f64 {
        2.0 * self.tan_half_fov_x / f64::from(self.width)
    }

    /// Area of the whole image on the plane at distance 1.
    pub fn image_area(&self) -> f64 {
        let size = self.pixel_size();
        size * size * f64::from(self.width) * f64::from(self.height)
    }

    pub fn ray(&self, pixel: DVec2) -> CameraRay {
        let size = self.pixel_size();
        let x = (pixel.x - 0.5 * f64::from(self.width)) * size;
        let y = (0.5 * f64::from(self.height) - pixel.y) * size;
        let to_plane = self.forward + x * self.right + y * self.up;
        let distance = to_plane.length();
        CameraRay { direction: to_plane / distance, start: self.near_clip * distance, cosine: 1.0 / distance }
    }

    /// Whether an image point is on the sampled pixels.
    pub fn samples(&self, pixel: DVec2) -> bool {
        let [x0, y0, x1, y1] = self.crop.map(f64::from);
        pixel.x >= x0 && pixel.x < x1 && pixel.y >= y0 && pixel.y < y1
    }

    /// Depth of a world point along the viewing direction.
    pub fn depth(&self, x: DVec3) -> f64 {
        (x - self.position).dot(self.forward)
    }

    /// Where `x` is seen; None if not beyond the near plane or outside the sampled pixels.
    pub fn project(&self, x: DVec3) -> Option<ImagePoint> {
        let v = x - self.position;
        let depth = v.dot(self.forward);
        if !(depth > self.near_clip && depth > 0.0) {
            return None;
        }
        let scale = 1.0 / (depth * self.pixel_size());
        let pixel = DVec2::new(
            0.5 * f64::from(self.width) + v.dot(self.right) * scale,
            0.5 * f64::from(self.height) - v.dot(self.up) * scale,
        );
        if !self.samples(pixel) {
            return None;
        }
        let distance = v.length();
        let cosine = depth / distance;
        let ray = CameraRay { direction: v / distance, start: self.near_clip / cosine, cosine };
        Some(ImagePoint { pixel, ray, distance })
    }

    /// Importance W_e emitted at cosine `cosine` to the viewing direction, per image area: 1/(A cos⁴θ).
    pub fn importance(&self, cosine: f64) -> f64 {
        let c2 = cosine * cosine;
        1.0 / (self.image_area() * c2 * c2)
    }
}
