//! Vectors, colours and affine maps as plain arrays.

/// A point or a direction in world space.
pub type Vec3 = [f64; 3];

/// A linear RGB value. Factors without colour hold the same number three times.
pub type Rgb = [f64; 3];

/// One world-space gradient per colour channel: `[channel][axis]`.
pub type RgbGradient = [Vec3; 3];

pub const ZERO: Vec3 = [0.0; 3];
pub const ONE: Rgb = [1.0; 3];

/// Rec. 709 luminance of linear RGB.
pub const LUMINANCE: Rgb = [0.212671, 0.715160, 0.072169];

pub fn luminance(c: Rgb) -> f64 {
    dot(LUMINANCE, c)
}

pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scale(s: f64, a: Vec3) -> Vec3 {
    [s * a[0], s * a[1], s * a[2]]
}

/// Channel by channel product of two colours.
pub fn product(a: Rgb, b: Rgb) -> Rgb {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

pub fn sum(vectors: &[Vec3]) -> Vec3 {
    vectors.iter().fold(ZERO, |s, &v| add(s, v))
}

pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn length(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

pub fn distance(a: Vec3, b: Vec3) -> f64 {
    length(sub(a, b))
}

pub fn normalize(a: Vec3) -> Vec3 {
    scale(1.0 / length(a), a)
}

/// The unit vector from `a` to `b`.
pub fn direction(a: Vec3, b: Vec3) -> Vec3 {
    normalize(sub(b, a))
}

/// The map `p ↦ x·p₀ + y·p₁ + z·p₂ + origin`: `columns` are the images of the three axes.
#[derive(Clone, Copy, Debug)]
pub struct Affine {
    pub columns: [Vec3; 3],
    pub origin: Vec3,
}

impl Affine {
    /// Takes the unit cube to the axis-aligned box from `min` to `max`.
    pub fn onto_box(min: Vec3, max: Vec3) -> Affine {
        let e = sub(max, min);
        Affine { columns: [[e[0], 0.0, 0.0], [0.0, e[1], 0.0], [0.0, 0.0, e[2]]], origin: min }
    }

    pub fn apply(&self, p: Vec3) -> Vec3 {
        let [x, y, z] = self.columns;
        sum(&[scale(p[0], x), scale(p[1], y), scale(p[2], z), self.origin])
    }

    /// The rows of the inverse matrix, by Cramer's rule. Row a is also the (unnormalised) world normal of the planes on
    /// which local coordinate a is constant.
    pub fn inverse_rows(&self) -> [Vec3; 3] {
        let [x, y, z] = self.columns;
        let determinant = dot(x, cross(y, z));
        [cross(y, z), cross(z, x), cross(x, y)].map(|row| scale(1.0 / determinant, row))
    }

    pub fn apply_inverse(&self, p: Vec3) -> Vec3 {
        self.inverse_rows().map(|row| dot(row, sub(p, self.origin)))
    }
}
