//! The cells of a regular lattice that a line passes, in order.
//! Source: J. Amanatides, A. Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, Eurographics 1987. Without its branches: which
//! wall comes next is as good as random, so that a processor would guess wrong at every second cell.

use crate::math::{DVec2, DVec3, DVec4};

/// A line in lattice coordinates, `origin + t·direction`, and what a walk along it needs.
#[derive(Clone, Copy)]
pub struct LatticeLine {
    pub origin: DVec3,
    pub direction: DVec3,
    /// 1/direction, +∞ along the axes that the line is parallel to.
    inverse: DVec3,
    /// Which way the line goes along each axis, 1 or −1, and how far the wall ahead is from a cell's low corner: 1 or 0.
    way: DVec3,
    ahead: DVec3,
}

impl LatticeLine {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        // A component whose reciprocal overflows counts as 0, and so does −0.
        let inverse = direction.recip();
        let parallel = inverse.abs().cmpeq(DVec3::INFINITY);
        let forward = parallel | direction.cmpgt(DVec3::ZERO);
        Self {
            origin,
            direction,
            inverse: DVec3::select(parallel, DVec3::INFINITY, inverse),
            way: DVec3::select(forward, DVec3::ONE, DVec3::NEG_ONE),
            ahead: DVec3::select(forward, DVec3::ONE, DVec3::ZERO),
        }
    }

    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    pub fn is_parallel(&self, axis: usize) -> bool {
        self.inverse[axis] == f64::INFINITY
    }

    /// Where the line crosses the planes at `walls`, one across each axis; means nothing for axes that it is parallel to.
    pub fn crossings(&self, walls: DVec3) -> DVec3 {
        (walls - self.origin) * self.inverse
    }

    /// Can walls around `t` be told apart? Not from too far away, nor if a number is none: a walk would not get on.
    pub fn resolves(&self, t: f64) -> bool {
        (self.inverse.abs() + t).cmpgt(DVec3::splat(t)).all()
    }
}

/// The cells of a lattice: `side` units wide, `counts` of them along each axis.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    side: f64,
    counts: [i32; 3],
    /// Cell (x, y, z) has the number (x, y, z, 1)·`strides` − 2⁵².
    strides: DVec4,
}

/// Added to an integer below 2³² this leaves the integer in the low half of the sum's bits.
const INTEGER_IN_LOW_BITS: f64 = (1u64 << 52) as f64;

impl Lattice {
    /// Cell (x, y, z) has the number `first` + (x, y, z)·`strides`.
    pub fn new(side: i32, counts: [i32; 3], first: f64, strides: DVec3) -> Self {
        Self { side: side.into(), counts, strides: strides.extend(INTEGER_IN_LOW_BITS + first) }
    }

    /// The numbers of two cells, for [`index`].
    #[inline(always)]
    pub fn numbers(&self, [x, y, z]: [DVec2; 3]) -> DVec2 {
        let s = self.strides;
        x * s.x + y * s.y + (z * s.z + s.w)
    }
}

/// A cell's number as an index. One that is negative becomes larger than all others.
#[inline(always)]
pub fn index(number: f64) -> usize {
    number.to_bits() as u32 as usize
}

/// A walk from cell to cell, from a point where the line is in the lattice to one half a cell before the lattice ends.
#[derive(Clone, Copy)]
pub struct Dda {
    /// Where the walk is.
    pub t: f64,
    /// Low corner of the cell that it enters there, in cells; the last component is 1.
    pub cell: DVec4,
    /// From one cell to the next along each axis.
    way: DVec4,
    /// Where the next wall across each axis is crossed, and, last, where the walk ends.
    crossings: DVec4,
    /// From one crossing to the next. (Of no meaning for the end, as is its way.)
    spacing: DVec4,
    strides: DVec4,
}

impl Dda {
    /// From `start` to `end`. The line resolves both.
    #[inline]
    pub fn new(line: &LatticeLine, lattice: &Lattice, start: f64, end: f64) -> Self {
        let position = line.at(start) * (1.0 / lattice.side);
        // The cast saturates and truncates, so that the clamp holds for any position.
        let cell = |axis: usize| f64::from((position[axis] as i32).min(lattice.counts[axis] - 1).max(0));
        let cell = DVec3::new(cell(0), cell(1), cell(2));
        let parallel = line.inverse.cmpeq(DVec3::INFINITY);
        // Rounding can put the start beyond the first walls.
        let crossings = line.crossings(lattice.side * (cell + line.ahead)).max(DVec3::splat(start));
        Self {
            t: start,
            cell: cell.extend(1.0),
            way: line.way.extend(end),
            crossings: DVec3::select(parallel, DVec3::INFINITY, crossings).extend(end),
            spacing: (lattice.side * line.inverse.abs()).extend(end),
            strides: lattice.strides,
        }
    }

    #[inline(always)]
    pub fn index(&self) -> usize {
        let product = self.cell * self.strides;
        index((product.x + product.z) + (product.y + product.w))
    }

    /// Through the cell, or to the end.
    #[inline(always)]
    pub fn advance(&mut self) {
        let least = |a: f64, b: f64| if a < b { a } else { b };
        let next = self.crossings;
        self.t = least(least(next.x, next.z), least(next.y, next.w));
        // Through an edge or a corner of the cell all its walls are crossed at once.
        let crossed = next.cmple(DVec4::splat(self.t));
        self.crossings += DVec4::select(crossed, self.spacing, DVec4::ZERO);
        self.cell += DVec4::select(crossed, self.way, DVec4::ZERO);
    }
}
