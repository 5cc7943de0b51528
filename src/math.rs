//! Vectors, colours, frames, and the one door to libm.
//!
//! Inside, everything is f64: optical depths cancel, path contributions grow, and a distance must survive u → t → u.
//! Single precision appears where values cross to the host (`Vec3`, `Rgb`).

pub use glam::{BVec4, DAffine3, DMat3, DVec2, DVec3, DVec4};
pub use libm::{acos, atan2, cos, exp, expm1, floor, log1p, pow, round, sin, sqrt};

use core::f64::consts::PI;

/// A linear RGB colour, inside the library.
pub type Colour = DVec3;

/// A vector as the host sees it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3 {
    pub x: f32,
    pub y: f32,
    pub z: f32,
}

impl Vec3 {
    pub fn wide(self) -> DVec3 {
        DVec3::new(self.x.into(), self.y.into(), self.z.into())
    }
}

impl From<DVec3> for Vec3 {
    fn from(v: DVec3) -> Self {
        Self { x: v.x as f32, y: v.y as f32, z: v.z as f32 }
    }
}

/// A linear RGB colour (Rec. 709 primaries, no gamma) as the host sees it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rgb {
    pub r: f32,
    pub g: f32,
    pub b: f32,
}

impl Rgb {
    pub fn wide(self) -> Colour {
        Colour::new(self.r.into(), self.g.into(), self.b.into())
    }
}

impl From<Colour> for Rgb {
    fn from(c: Colour) -> Self {
        Self { r: c.x as f32, g: c.y as f32, b: c.z as f32 }
    }
}

/// Vectors of the host count as unit vectors, and as orthogonal, within this.
pub(crate) const UNIT_TOLERANCE: f64 = 1e-3;

/// Whether a host's vector counts as one of unit length.
pub fn is_unit(v: DVec3) -> bool {
    (v.length() - 1.0).abs() < UNIT_TOLERANCE
}

/// Whether a host's colour is one: finite, and nowhere negative.
pub fn is_colour(c: Colour) -> bool {
    c.is_finite() && c.min_element() >= 0.0
}

/// A host's colour; black if it is none.
pub fn colour_or_black(c: Colour) -> Colour {
    if is_colour(c) { c } else { Colour::ZERO }
}

/// A host's density; 0 if it is none.
pub fn positive_or_zero(value: f64) -> f64 {
    if value > 0.0 && value.is_finite() { value } else { 0.0 }
}

/// Luminance weights of linear Rec. 709 RGB (Y of CIE XYZ, D65).
pub const LUMINANCE: Colour = Colour::new(0.212671, 0.715160, 0.072169);

pub fn luminance(c: Colour) -> f64 {
    c.dot(LUMINANCE)
}

pub fn mean(c: Colour) -> f64 {
    c.element_sum() * (1.0 / 3.0)
}

/// exp of four numbers of at most ln 4 either way, within 1e-15 of each: Taylor's polynomial of a quarter, to the fourth power.
pub fn exp_of_small(x: DVec4) -> DVec4 {
    let quarter = 0.25 * x;
    let power = TAYLOR.iter().rev().fold(DVec4::ZERO, |sum, coefficient| sum * quarter + *coefficient);
    let square = power * power;
    square * square
}

/// 1/k!. What comes next is less than (ln √2)¹⁴/14! = 4e-18.
const TAYLOR: [f64; 14] = {
    let mut coefficients = [1.0; 14];
    let mut k = 1;
    while k < coefficients.len() {
        coefficients[k] = coefficients[k - 1] / k as f64;
        k += 1;
    }
    coefficients
};

/// exp(−optical depth), per channel.
pub fn transmittance(optical_depth: Colour) -> Colour {
    if optical_depth.x == optical_depth.y && optical_depth.x == optical_depth.z {
        return Colour::splat(exp(-optical_depth.x));
    }
    Colour::new(exp(-optical_depth.x), exp(-optical_depth.y), exp(-optical_depth.z))
}

/// 1 − exp(−optical depth), per channel, without cancellation.
pub fn absorptance(optical_depth: Colour) -> Colour {
    Colour::new(-expm1(-optical_depth.x), -expm1(-optical_depth.y), -expm1(-optical_depth.z))
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`.
/// Source: T. Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 2017.
pub fn orthonormal_basis(n: DVec3) -> (DVec3, DVec3) {
    n.any_orthonormal_pair()
}

/// A point in the unit disk, uniform by area, from two uniform numbers.
pub fn uniform_disk(u: DVec2) -> DVec2 {
    let (radius, angle) = (sqrt(u.x), 2.0 * PI * u.y);
    DVec2::new(radius * cos(angle), radius * sin(angle))
}

/// The inverse of [`uniform_disk`].
pub fn disk_number(d: DVec2) -> DVec2 {
    DVec2::new(d.length_squared().min(1.0), turn(d.x, d.y))
}

/// The numbers from which [`uniform_disk`], projected onto the hemisphere around `n`, makes the unit vector `direction`: its density is
/// cos/π.
pub fn hemisphere_number(n: DVec3, direction: DVec3) -> DVec2 {
    let (s, t) = orthonormal_basis(n);
    disk_number(DVec2::new(direction.dot(s), direction.dot(t)))
}

/// The angle of a vector in the plane, as a share of a full turn in [0, 1).
fn turn(x: f64, y: f64) -> f64 {
    let turn = atan2(y, x) / (2.0 * PI);
    // A tiny negative turn plus 1 rounds to 1.
    let turn = if turn < 0.0 { turn + 1.0 } else { turn };
    if turn < 1.0 { turn } else { 0.0 }
}

/// A unit vector at cosine `cos_theta` to the unit vector `axis`, turned around it by `turn` ∈ [0, 1) of a full turn.
pub fn direction_around(axis: DVec3, cos_theta: f64, turn: f64) -> DVec3 {
    let (s, t) = orthonormal_basis(axis);
    let sin_theta = sqrt((1.0 - cos_theta * cos_theta).max(0.0));
    let angle = 2.0 * PI * turn;
    axis * cos_theta + (s * cos(angle) + t * sin(angle)) * sin_theta
}

/// The inverse of [`direction_around`]: `(cos_theta, turn)` of a unit vector.
pub fn around_direction(axis: DVec3, direction: DVec3) -> (f64, f64) {
    let (s, t) = orthonormal_basis(axis);
    (axis.dot(direction), turn(direction.dot(s), direction.dot(t)))
}
