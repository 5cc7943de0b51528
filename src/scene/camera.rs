//! Pinhole and thin lens cameras: from image points and points on the lens to rays, back, and the importance of both.
//!
//! Through a fixed point of the lens the camera is a pinhole camera whose image is shifted so that the plane in focus stays where it is.
//! Image areas on the plane at distance 1, and their ratio to solid angles, are the same for all points of the lens.
//! Source of the thin lens: Mitsuba 3, `thinlens`.

use super::{Ray, Scene};
use crate::math::{DVec2, DVec3, disk_number, uniform_disk};
use crate::medium::{Line, Segment};
use core::f64::consts::PI;

/// A camera. `right`, `up`, `forward` are orthonormal; pixel x grows along `right`, pixel y against `up`.
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
    /// 0 for a pinhole.
    pub lens_radius: f64,
    /// Distance along `forward` of what is in focus; > 0, without a meaning for a pinhole.
    pub focal_distance: f64,
}

/// A ray through an image point, from a point of the lens. It starts at the near plane, `start` away from there.
#[derive(Clone, Copy, Debug, Default)]
pub struct CameraRay {
    /// The path's x_0.
    pub origin: DVec3,
    pub direction: DVec3,
    pub start: f64,
    /// Cosine to the viewing direction.
    pub cosine: f64,
}

/// Where a world point is seen.
#[derive(Clone, Copy, Debug, Default)]
pub struct ImagePoint {
    /// Pixel coordinates; pixel (i, j) covers [i, i+1) × [j, j+1).
    pub pixel: DVec2,
    pub ray: CameraRay,
    pub distance: f64,
}

impl CameraRay {
    /// The same ray for the host, from the near plane on, ending `length` from x_0.
    pub fn free(&self, camera: &Camera, length: f64) -> Ray {
        let start = self.origin + self.start * self.direction;
        Ray::free(start, self.direction, length - self.start, camera.medium)
    }

    /// The edge along it, ending `length` from x_0; `segments` start at the near plane.
    pub fn line<'s>(&self, scene: &'s Scene<'s>, length: f64, segments: &'s [Segment]) -> Line<'s> {
        let line = Line::new(scene.media, self.origin, self.direction, length, segments);
        Line { start: self.start, start_normal: scene.camera.forward, segments_start: self.start, ..line }
    }
}

impl Camera {
    pub fn is_pinhole(&self) -> bool {
        self.lens_radius == 0.0
    }

    /// Side of a pixel on the plane at distance 1.
    pub fn pixel_size(&self) -> f64 {
        2.0 * self.tan_half_fov_x / f64::from(self.width)
    }

    /// Area of the whole image on the plane at distance 1.
    pub fn image_area(&self) -> f64 {
        let size = self.pixel_size();
        size * size * f64::from(self.width) * f64::from(self.height)
    }

    /// A point of the lens from two uniform numbers, in world units along `right` and `up`; 0 for a pinhole.
    pub fn lens_point(&self, u: DVec2) -> DVec2 {
        if self.is_pinhole() { DVec2::ZERO } else { uniform_disk(u) * self.lens_radius }
    }

    /// The inverse of [`Camera::lens_point`]; any number for a pinhole.
    pub fn lens_number(&self, lens: DVec2) -> DVec2 {
        if self.is_pinhole() { DVec2::splat(0.5) } else { disk_number(lens / self.lens_radius) }
    }

    /// Where on the lens a world point is.
    pub fn on_lens(&self, origin: DVec3) -> DVec2 {
        let v = origin - self.position;
        DVec2::new(v.dot(self.right), v.dot(self.up))
    }

    /// The pinhole camera that a point of the lens is for what changes with its distance and direction.
    pub fn at(&self, origin: DVec3) -> Self {
        Self { position: origin, ..*self }
    }

    fn origin(&self, lens: DVec2) -> DVec3 {
        self.position + (lens.x * self.right + lens.y * self.up)
    }

    /// The ray through an image point that starts at a point of the lens.
    pub fn ray(&self, pixel: DVec2, lens: DVec2) -> CameraRay {
        let size = self.pixel_size();
        let x = (pixel.x - 0.5 * f64::from(self.width)) * size - lens.x / self.focal_distance;
        let y = (0.5 * f64::from(self.height) - pixel.y) * size - lens.y / self.focal_distance;
        let to_plane = self.forward + x * self.right + y * self.up;
        let distance = to_plane.length();
        CameraRay {
            origin: self.origin(lens),
            direction: to_plane / distance,
            start: self.near_clip * distance,
            cosine: 1.0 / distance,
        }
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

    /// Where `x` is seen through a point of the lens; None if not beyond the near plane or outside the sampled pixels.
    pub fn project(&self, x: DVec3, lens: DVec2) -> Option<ImagePoint> {
        self.pixel(x, lens).map(|pixel| self.image_point(pixel, x, lens))
    }

    /// The same, pixel coordinates alone. (Inlined, so that one loop over points divides by what is the camera's once.)
    #[inline(always)]
    pub fn pixel(&self, x: DVec3, lens: DVec2) -> Option<DVec2> {
        let v = x - self.origin(lens);
        let depth = v.dot(self.forward);
        if !(depth > self.near_clip && depth > 0.0) {
            return None;
        }
        let on_plane = DVec2::new(v.dot(self.right), v.dot(self.up)) * (1.0 / depth) + lens / self.focal_distance;
        let from_centre = on_plane * (1.0 / self.pixel_size());
        let half = 0.5 * DVec2::new(self.width.into(), self.height.into());
        let pixel = DVec2::new(half.x + from_centre.x, half.y - from_centre.y);
        self.samples(pixel).then_some(pixel)
    }

    /// What is seen at `pixel`, given that it is `x`.
    pub fn image_point(&self, pixel: DVec2, x: DVec3, lens: DVec2) -> ImagePoint {
        let origin = self.origin(lens);
        let v = x - origin;
        let distance = v.length();
        let cosine = v.dot(self.forward) / distance;
        let ray = CameraRay { origin, direction: v / distance, start: self.near_clip / cosine, cosine };
        ImagePoint { pixel, ray, distance }
    }

    /// Density per steradian of the rays through uniform points of the sampled pixels, at cosine `cosine` to the viewing direction.
    pub fn direction_density(&self, cosine: f64) -> f64 {
        let [x0, y0, x1, y1] = self.crop.map(f64::from);
        let size = self.pixel_size();
        1.0 / (size * size * (x1 - x0) * (y1 - y0) * cosine * cosine * cosine)
    }

    /// Importance W_e emitted at cosine `cosine` to the viewing direction: 1/(A cos⁴θ), per image area, or 1/(A A_lens cos⁴θ) per
    /// area of the lens as well.
    pub fn importance(&self, cosine: f64) -> f64 {
        let c2 = cosine * cosine;
        let lens_area = if self.is_pinhole() { 1.0 } else { PI * self.lens_radius * self.lens_radius };
        1.0 / (self.image_area() * c2 * c2 * lens_area)
    }
}
