//! The density inside one cell: trilinear between its corners, and so a cubic along a line, as is t·∇ρ. Two-point Gauss–Legendre
//! is exact for cubics. Source: ARCHITECTURE.md, "Line integrals".
//!
//! Both points are computed side by side, in the two halves of a `DVec2`: that is what the processor's registers hold.

use super::Moments;
use super::dda::LatticeLine;
use crate::math::{DVec2, DVec3};

/// Densities at the corners of a cell: pairs along x, indexed [z][y].
#[derive(Clone, Copy, Default)]
pub struct Corners(pub [[[f32; 2]; 2]; 2]);

/// Two points of a cell, seen from its low corner.
#[derive(Clone, Copy)]
pub struct Points {
    x: DVec2,
    y: DVec2,
    z: DVec2,
}

impl Points {
    /// The same point twice.
    pub fn both(point: DVec3) -> Self {
        Self { x: DVec2::splat(point.x), y: DVec2::splat(point.y), z: DVec2::splat(point.z) }
    }
}

impl Corners {
    #[inline(always)]
    fn wide(&self) -> [[[DVec2; 2]; 2]; 2] {
        self.0.map(|face| face.map(|pair| pair.map(|corner| DVec2::splat(f64::from(corner)))))
    }

    /// ρ at both points.
    #[inline(always)]
    pub fn value(&self, p: Points) -> DVec2 {
        let [low, high] = self.wide().map(|[a, b]| mix(mix(a[0], a[1], p.x), mix(b[0], b[1], p.x), p.y));
        mix(low, high, p.z)
    }

    /// ρ and its derivatives by x, y and z at both points.
    #[inline(always)]
    pub fn value_and_gradient(&self, p: Points) -> (DVec2, [DVec2; 3]) {
        let [[a, b], [c, d]] = self.wide();
        let edge = |pair: [DVec2; 2]| mix(pair[0], pair[1], p.x);
        let slope = |pair: [DVec2; 2]| pair[1] - pair[0];
        let (low, high) = (mix(edge(a), edge(b), p.y), mix(edge(c), edge(d), p.y));
        let x = mix(mix(slope(a), slope(b), p.y), mix(slope(c), slope(d), p.y), p.z);
        let y = mix(edge(b) - edge(a), edge(d) - edge(c), p.z);
        (mix(low, high, p.z), [x, y, high - low])
    }
}

#[inline(always)]
fn mix(a: DVec2, b: DVec2, t: DVec2) -> DVec2 {
    a + t * (b - a)
}

/// A line for two points at once.
pub struct TwinLine {
    origin: [DVec2; 3],
    direction: [DVec2; 3],
}

impl TwinLine {
    pub fn new(line: &LatticeLine) -> Self {
        Self { origin: line.origin.to_array().map(DVec2::splat), direction: line.direction.to_array().map(DVec2::splat) }
    }

    /// The points at `t`, in the cell of `chord`.
    #[inline(always)]
    fn at(&self, t: DVec2, chord: &Chord) -> Points {
        let [x, y, z] = [0, 1, 2].map(|axis| self.origin[axis] + t * self.direction[axis]);
        Points { x: x - DVec2::splat(chord.x), y: y - DVec2::splat(chord.y), z: z - DVec2::splat(chord.z) }
    }
}

/// A stretch of a line inside one cell. (In this order the fields y and z, which are not written together, are not read together
/// either: the processor would wait until both have reached the cache.)
#[derive(Clone, Copy, Default)]
#[repr(C)]
pub struct Chord {
    /// The cell's low corner.
    pub x: f64,
    pub y: f64,
    pub start: f64,
    pub z: f64,
    pub end: f64,
    pub corners: Corners,
}

/// The two Gauss–Legendre points of [a, b] are a·`NEAR` + b·`FAR`: (1 ± 1/√3)/2. Their weights are half the length.
const NEAR: DVec2 = DVec2::new(0.788_675_134_594_812_9, 0.211_324_865_405_187_1);
const FAR: DVec2 = DVec2::new(0.211_324_865_405_187_1, 0.788_675_134_594_812_9);

impl Chord {
    #[inline(always)]
    fn gauss(&self, end: f64) -> (DVec2, f64) {
        (DVec2::splat(self.start) * NEAR + DVec2::splat(end) * FAR, 0.5 * (end - self.start))
    }

    /// ∫ ρ dt from the start to `end`.
    #[inline(always)]
    pub fn integral(&self, line: &TwinLine, end: f64) -> f64 {
        let (t, half) = self.gauss(end);
        half * self.corners.value(line.at(t, self)).element_sum()
    }

    /// The integrals from the start to `end`, gradients in lattice coordinates.
    #[inline(always)]
    pub fn moments(&self, line: &TwinLine, end: f64) -> Moments {
        let (t, half) = self.gauss(end);
        let (value, [x, y, z]) = self.corners.value_and_gradient(line.at(t, self));
        let sum = |x: DVec2, y: DVec2, z: DVec2| half * DVec3::new(x.element_sum(), y.element_sum(), z.element_sum());
        Moments {
            integral: half * value.element_sum(),
            gradient: sum(x, y, z),
            first_moment: sum(t * x, t * y, t * z),
            ..Moments::default()
        }
    }

    /// The t at which ∫ ρ from the start is `target`, given that the whole chord holds `total` ≥ target: bracketed Newton.
    pub fn solve(&self, line: &TwinLine, target: f64, total: f64) -> f64 {
        let (mut low, mut high) = (self.start, self.end);
        let mut t = if total > 0.0 { low + (high - low) * (target / total) } else { low };
        // Newton converges quadratically; halving alone would take 53 rounds to exhaust the bracket.
        for _ in 0..64 {
            let error = self.integral(line, t) - target;
            if error > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - error / self.corners.value(line.at(DVec2::splat(t), self)).x;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if next == t || (next - t).abs() <= 4.0 * f64::EPSILON * t.abs() {
                return next;
            }
            t = next;
        }
        t
    }
}
