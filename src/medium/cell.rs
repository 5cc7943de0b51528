//! The density inside one cell: trilinear between its corners. Along a line that is a cubic, whose coefficients are the mixed
//! derivatives at any point of it, and so are its integrals. Source: ARCHITECTURE.md, "Line integrals".
//!
//! Two cells are computed side by side, in the two halves of a `DVec2`: that is what the processor's registers hold.

use super::Moments;
use super::dda::LatticeLine;
use crate::math::{DVec2, DVec3};

/// Densities at the corners of a cell: pairs along x, of which the second is above the first along y, the last two above those along z.
pub type Corners = [[f32; 2]; 4];

/// ρ and all its derivatives at a point of each of two cells: it is linear in each coordinate.
pub struct Expansion {
    pub value: DVec2,
    pub x: DVec2,
    pub y: DVec2,
    pub z: DVec2,
    xy: DVec2,
    xz: DVec2,
    yz: DVec2,
    xyz: DVec2,
}

impl Expansion {
    /// At points seen from their cells' low corners. The corners are those of the first and of the second cell, pair by pair.
    #[inline(always)]
    pub fn new(corners: &[[[f32; 2]; 2]; 4], [x, y, z]: [DVec2; 3]) -> Self {
        let [[c0, c1], [c2, c3], [c4, c5], [c6, c7]] =
            corners.map(|[a, b]| [DVec2::new(a[0].into(), b[0].into()), DVec2::new(a[1].into(), b[1].into())]);
        // Along x at each edge, then along y at both faces, then along z.
        let x_slopes = [c1 - c0, c3 - c2, c5 - c4, c7 - c6];
        let [e0, e1, e2, e3] = [c0 + x * x_slopes[0], c2 + x * x_slopes[1], c4 + x * x_slopes[2], c6 + x * x_slopes[3]];
        let (xy_low, xy_high) = (x_slopes[1] - x_slopes[0], x_slopes[3] - x_slopes[2]);
        let (y_low, y_high) = (e1 - e0, e3 - e2);
        let (low, high) = (e0 + y * y_low, e2 + y * y_high);
        let (xyz, yz, slope) = (xy_high - xy_low, y_high - y_low, high - low);
        let (x_low, x_high) = (x_slopes[0] + y * xy_low, x_slopes[2] + y * xy_high);
        let xz = x_high - x_low;
        Self { value: low + z * slope, x: x_low + z * xz, y: y_low + z * yz, z: slope, xy: xy_low + z * xyz, xz, yz, xyz }
    }

    /// The coefficient of s² along a line of direction `d`.
    #[inline(always)]
    fn bend(&self, d: DVec3) -> DVec2 {
        self.xy * (d.x * d.y) + self.xz * (d.x * d.z) + self.yz * (d.y * d.z)
    }
}

/// Two stretches of a line, each inside one cell.
#[derive(Clone, Copy, Default)]
pub struct Chords {
    pub start: DVec2,
    pub end: DVec2,
    /// The cells' low corners, axis by axis, and their numbers.
    pub cells: [DVec2; 3],
    pub numbers: DVec2,
    pub corners: [[[f32; 2]; 2]; 4],
}

impl Chords {
    /// Those of the first and of the second cell.
    #[inline(always)]
    pub fn set_corners(&mut self, a: Corners, b: Corners) {
        for (i, pairs) in self.corners.iter_mut().enumerate() {
            *pairs = [a[i], b[i]];
        }
    }

    /// At `t`, one for each.
    #[inline(always)]
    fn expand(&self, line: &LatticeLine, t: DVec2) -> Expansion {
        let (o, d, [x, y, z]) = (line.origin, line.direction, self.cells);
        let along = |o: f64, d: f64| DVec2::splat(o) + t * DVec2::splat(d);
        let point = [along(o.x, d.x) - x, along(o.y, d.y) - y, along(o.z, d.z) - z];
        Expansion::new(&self.corners, point)
    }

    /// ∫ ρ dt.
    #[inline(always)]
    pub fn integrals(&self, line: &LatticeLine) -> DVec2 {
        let length = self.end - self.start;
        let e = self.expand(line, 0.5 * (self.start + self.end));
        // Odd powers of the distance from the middle cancel.
        length * (e.value + length * length * TWELFTH * e.bend(line.direction))
    }

    /// The integrals of both from the start to `end`, added up, gradients in lattice coordinates.
    #[inline(always)]
    pub fn moments(&self, line: &LatticeLine, end: DVec2) -> Moments {
        let d = line.direction;
        let (length, middle) = (end - self.start, 0.5 * (self.start + end));
        let e = self.expand(line, middle);
        let square = length * length * TWELFTH;
        let twist = square * e.xyz;
        // Of ∇ρ: the mean, and what grows with the distance from the middle.
        let mean = [e.x + twist * (d.y * d.z), e.y + twist * (d.x * d.z), e.z + twist * (d.x * d.y)];
        let slope = [e.xy * d.y + e.xz * d.z, e.xy * d.x + e.yz * d.z, e.xz * d.x + e.yz * d.y];
        let sum = |values: [DVec2; 3]| DVec3::from_array(values.map(|value| (length * value).element_sum()));
        Moments {
            integral: (length * (e.value + square * e.bend(d))).element_sum(),
            gradient: sum(mean),
            first_moment: sum(core::array::from_fn(|axis| middle * mean[axis] + square * slope[axis])),
            ..Moments::default()
        }
    }

    /// The t at which ∫ ρ from the start of one of them is `target`, given that all of it holds `total` ≥ target: bracketed Newton.
    #[inline(never)]
    pub fn solve(&self, which: usize, line: &LatticeLine, target: f64, total: f64) -> f64 {
        let (start, d) = (self.start[which], line.direction);
        let e = self.expand(line, DVec2::splat(start));
        let [a, b, c, f] = [e.value, e.x * d.x + e.y * d.y + e.z * d.z, e.bend(d), e.xyz * (d.x * d.y * d.z)].map(|k| k[which]);
        let (mut low, mut high) = (0.0, self.end[which] - start);
        let mut s = if total > 0.0 { high * (target / total) } else { low };
        // Newton converges quadratically; halving alone would take 53 rounds to exhaust the bracket.
        for _ in 0..64 {
            let error = s * (a + s * (b / 2.0 + s * (c / 3.0 + s * (f / 4.0)))) - target;
            if error > 0.0 {
                high = s
            } else {
                low = s
            }
            let next = s - error / (a + s * (b + s * (c + s * f)));
            let inside = next >= low && next <= high;
            // As close as rounding lets it come: in the distance, or in the integral where there is next to no density.
            if (next - s).abs() <= 2.0 * f64::EPSILON * (start + s) || error.abs() <= 2.0 * f64::EPSILON * total {
                return start + if inside { next } else { s };
            }
            s = if inside { next } else { 0.5 * (low + high) };
        }
        start + s
    }
}

/// The mean square of the distance from a line's middle, over that of its length.
const TWELFTH: f64 = 1.0 / 12.0;
