//! The GGX (Trowbridge–Reitz) distribution of microfacet normals, isotropic, with Smith's masking of each direction by itself.
//!
//! Source: [W07], [H18]. Masking and shadowing are taken as independent, as in Mitsuba 3.

use crate::math::{DVec2, DVec3, disk_number, orthonormal_basis, sqrt, uniform_disk};
use core::f64::consts::PI;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Roughness.
    pub alpha: f64,
}

impl Ggx {
    /// D(h/|h|)/|h|⁴ for a vector `h` along a microfacet's normal. Half vectors come unnormalised, and their length often cancels.
    pub fn density(&self, n: DVec3, h: DVec3) -> f64 {
        let q = self.spread(n, h);
        self.alpha * self.alpha / (PI * q * q)
    }

    /// ∂log [`Ggx::density`]/∂h
    pub fn density_log_gradient(&self, n: DVec3, h: DVec3) -> DVec3 {
        let along = n.dot(h) * n;
        -4.0 * (self.alpha * self.alpha * along + (h - along)) / self.spread(n, h)
    }

    /// (α² cos² + sin²)|h|², the sine from its own components: for smooth surfaces 1 − cos² is all rounding.
    fn spread(&self, n: DVec3, h: DVec3) -> f64 {
        let height = n.dot(h);
        self.alpha * self.alpha * height * height + (h - height * n).length_squared()
    }

    /// Smith's G₁ at a cosine > 0 to the normal.
    pub fn masking(&self, cosine: f64) -> f64 {
        2.0 / (1.0 + self.root(cosine))
    }

    /// ∂log G₁/∂cosine
    pub fn masking_log_derivative(&self, cosine: f64) -> f64 {
        let root = self.root(cosine);
        self.alpha * self.alpha / (cosine * cosine * cosine * root * (1.0 + root))
    }

    /// √(1 + α² tan²)
    fn root(&self, cosine: f64) -> f64 {
        sqrt(1.0 + self.alpha * self.alpha * (1.0 / (cosine * cosine) - 1.0).max(0.0))
    }

    /// The frame of [`Ggx::sample_visible`]: the direction stretched, so that the microfacets are a hemisphere, and two axes across it.
    fn stretched(&self, (s, t): (DVec3, DVec3), n: DVec3, v: DVec3) -> [DVec3; 3] {
        let v = DVec3::new(self.alpha * v.dot(s), self.alpha * v.dot(t), v.dot(n)).normalize();
        let x = DVec3::new(-v.y, v.x, 0.0).try_normalize().unwrap_or(DVec3::X);
        [x, v.cross(x), v]
    }

    /// A microfacet's normal m as the unit vector `v` on the side of `n` sees them: with density G₁(v) (v·m) D(m)/(n·v). [H18]
    pub fn sample_visible(&self, n: DVec3, v: DVec3, u: DVec2) -> DVec3 {
        let (s, t) = orthonormal_basis(n);
        let [x, y, v] = self.stretched((s, t), n, v);
        // The hemisphere's projection: a half disk, and half of another one that is seen at an angle.
        let mut d = uniform_disk(u);
        let share = 0.5 * (1.0 + v.z);
        d.y = (1.0 - share) * sqrt((1.0 - d.x * d.x).max(0.0)) + share * d.y;
        let m = d.x * x + d.y * y + sqrt((1.0 - d.length_squared()).max(0.0)) * v;
        (self.alpha * (m.x * s + m.y * t) + m.z.max(0.0) * n).normalize()
    }

    /// The numbers from which [`Ggx::sample_visible`] makes the microfacet normal `m`, which sees `v`.
    pub fn invert_visible(&self, n: DVec3, v: DVec3, m: DVec3) -> DVec2 {
        let (s, t) = orthonormal_basis(n);
        let [x, y, v] = self.stretched((s, t), n, v);
        let m = DVec3::new(m.dot(s) / self.alpha, m.dot(t) / self.alpha, m.dot(n)).normalize();
        let mut d = DVec2::new(m.dot(x), m.dot(y));
        let share = 0.5 * (1.0 + v.z);
        d.y = (d.y - (1.0 - share) * sqrt((1.0 - d.x * d.x).max(0.0))) / share;
        disk_number(d)
    }
}
