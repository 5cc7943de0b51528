//! The cells of a regular lattice that a ray stretch passes, in order.
//! Source: J. Amanatides, A. Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, Eurographics 1987.

use crate::math::{DVec3, floor};

/// A line in lattice coordinates, `origin + t·direction`, with 1/direction beside it.
#[derive(Clone, Copy)]
pub struct LatticeLine {
    pub origin: DVec3,
    pub direction: DVec3,
    pub inverse: DVec3,
}

impl LatticeLine {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, inverse: direction.recip() }
    }

    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// One cell on the way: its index and the stretch inside.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub cell: [i32; 3],
    pub start: f64,
    pub end: f64,
}

/// Iterates over the cubic cells of side `side` between `start` and `end`. Indices stay in [0, counts).
pub struct Dda {
    cell: [i32; 3],
    /// +1, −1, or 0 where the line is parallel to the cell walls.
    advance: [i32; 3],
    last: [i32; 3],
    /// Distance to the next wall per axis, and between walls.
    next_wall: [f64; 3],
    spacing: [f64; 3],
    t: f64,
    end: f64,
}

impl Dda {
    pub fn new(line: &LatticeLine, counts: [i32; 3], side: f64, start: f64, end: f64) -> Self {
        let (origin, direction, inverse) = (line.origin.to_array(), line.direction.to_array(), line.inverse.to_array());
        let mut dda = Self {
            cell: [0; 3],
            advance: [0; 3],
            last: counts.map(|n| n - 1),
            next_wall: [f64::INFINITY; 3],
            spacing: [f64::INFINITY; 3],
            t: start,
            end,
        };
        for axis in 0..3 {
            let position = (origin[axis] + start * direction[axis]) / side;
            // The cast saturates, so that the clamp holds for any position.
            dda.cell[axis] = (floor(position) as i32).min(dda.last[axis]).max(0);
            if direction[axis] == 0.0 {
                continue;
            }
            let forward = direction[axis] > 0.0;
            let wall = f64::from(dda.cell[axis] + i32::from(forward)) * side;
            dda.advance[axis] = if forward { 1 } else { -1 };
            dda.next_wall[axis] = (wall - origin[axis]) * inverse[axis];
            dda.spacing[axis] = side * inverse[axis].abs();
        }
        dda
    }
}

impl Iterator for Dda {
    type Item = Step;

    #[inline]
    fn next(&mut self) -> Option<Step> {
        // Written so that NaN ends the walk.
        if !(self.t < self.end) {
            return None;
        }
        let [x, y, z] = self.next_wall;
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        let end = self.next_wall[axis].clamp(self.t, self.end);
        let step = Step { cell: self.cell, start: self.t, end };
        self.t = end;
        self.next_wall[axis] += self.spacing[axis];
        self.cell[axis] += self.advance[axis];
        if self.cell[axis] < 0 || self.cell[axis] > self.last[axis] {
            // Past the lattice, which the caller clipped to: what is left is rounding. The last cell keeps it.
            self.cell[axis] = self.cell[axis].min(self.last[axis]).max(0);
            self.next_wall[axis] = f64::INFINITY;
        }
        Some(step)
    }
}
