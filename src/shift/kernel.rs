//! Where a vertex is shifted to. Kernels are symmetric in volume measure: the density of x → y is that of y → x.

use crate::math::{DVec2, DVec3, cbrt, direction_around, uniform_disk};
use crate::scene::Camera;

/// Most offsets in a batch.
pub const MAX_SHIFTS: usize = 32;

/// How a shifted path is weighted. See ARCHITECTURE.md, "Estimators".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// exp⟨∇log f, offset⟩: biased by O(r²), no ray queries.
    LogLinear,
    /// f(y)/f(x), staying at x where f(y) = 0: unbiased.
    Exact,
    /// All members around a common centre, weighted f(y)/Σf: unbiased, weights in [0, 1].
    Exchangeable,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Uniform in a disk parallel to the image plane. (One perpendicular to the camera ray is not symmetric.)
    Disk,
    /// Uniform in a ball.
    Ball,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radius {
    /// In pixels at the vertex' depth. That is constant on the disk, and so symmetric; not in a ball.
    Pixels(f64),
    World(f64),
}

/// How a batch is made: `count` offsets beside the path itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    pub mode: Mode,
    pub kernel: Kernel,
    /// Of one step. `Exchangeable` makes two: to the centre, and from there.
    pub radius: Radius,
    pub count: usize,
}

impl Options {
    /// The radius at `x`, world units.
    pub fn radius_at(&self, camera: &Camera, x: DVec3) -> f64 {
        match self.radius {
            Radius::Pixels(pixels) => pixels * camera.pixel_size() * camera.depth(x),
            Radius::World(radius) => radius,
        }
    }

    /// The radius in pixels if surfaces may be shifted: they move with their image point, which takes a disk in pixels, and weights from
    /// ray queries.
    pub fn surface_radius(&self) -> Option<f64> {
        match (self.mode, self.kernel, self.radius) {
            (Mode::Exact | Mode::Exchangeable, Kernel::Disk, Radius::Pixels(pixels)) => Some(pixels),
            _ => None,
        }
    }

    /// An offset from three uniform numbers.
    pub fn offset(&self, camera: &Camera, radius: f64, u: [f64; 3]) -> DVec3 {
        match self.kernel {
            Kernel::Disk => {
                let d = uniform_disk(DVec2::new(u[0], u[1])) * radius;
                d.x * camera.right + d.y * camera.up
            }
            Kernel::Ball => direction_around(DVec3::Z, 1.0 - 2.0 * u[0], u[1]) * (radius * cbrt(u[2])),
        }
    }
}
