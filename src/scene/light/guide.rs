//! Where light should be sent: how often each part of a light's directions (for one infinitely far away, of the places that it shines on) starts
//! a subpath, learned from what such subpaths carried to the camera.

use super::distribution::{accumulate, number, pick, probability};
use crate::math::DVec2;

/// Parts along each axis of the square of numbers that choose a direction.
pub const GUIDE_SIDE: usize = 64;

/// Cells of this many directions in all go on being tried alike: what carried nothing so far may yet.
const ALL_ALIKE: f64 = 0.2;

/// For one light.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Guide {
    /// Running sums of the probabilities of rows, and of each row's columns.
    rows: [f64; GUIDE_SIDE],
    columns: [[f64; GUIDE_SIDE]; GUIDE_SIDE],
}

fn cell(x: f64) -> usize {
    ((x * GUIDE_SIDE as f64) as usize).min(GUIDE_SIDE - 1)
}

impl Guide {
    /// In proportion to what the cell in column i of row j carried; all alike if none carried anything.
    pub fn learned(carried: impl Fn(usize, usize) -> f64) -> Self {
        let mut columns = [[0.0; GUIDE_SIDE]; GUIDE_SIDE];
        let mut total = 0.0;
        for (j, columns) in columns.iter_mut().enumerate() {
            for (i, column) in columns.iter_mut().enumerate() {
                *column = carried(i, j).max(0.0);
                total += *column;
            }
        }
        let count = (GUIDE_SIDE * GUIDE_SIDE) as f64;
        let mut rows = [0.0; GUIDE_SIDE];
        for (row, columns) in rows.iter_mut().zip(&mut columns) {
            for column in columns.iter_mut() {
                let own = if total > 0.0 { *column / total } else { 1.0 / count };
                *column = ALL_ALIKE / count + (1.0 - ALL_ALIKE) * own;
            }
            *row = columns.iter().sum();
            accumulate(columns);
        }
        accumulate(&mut rows);
        Self { rows, columns }
    }

    /// The numbers to use in the place of uniform ones, and their density.
    pub fn warp(&self, u: DVec2) -> Option<(DVec2, f64)> {
        let (j, down) = pick(&self.rows, u.y)?;
        let (i, along) = pick(self.columns.get(j)?, u.x)?;
        let warped = DVec2::new(i as f64 + along, j as f64 + down) / GUIDE_SIDE as f64;
        Some((warped.clamp(DVec2::ZERO, DVec2::ONE), self.density_in(i, j)))
    }

    /// The uniform numbers that [`Guide::warp`] makes these of.
    pub fn unwarp(&self, warped: DVec2) -> Option<DVec2> {
        let (i, j) = (cell(warped.x), cell(warped.y));
        let rest = warped * GUIDE_SIDE as f64 - DVec2::new(i as f64, j as f64);
        Some(DVec2::new(number(self.columns.get(j)?, i, rest.x)?, number(&self.rows, j, rest.y)?))
    }

    /// Density of those numbers.
    pub fn density(&self, u: DVec2) -> f64 {
        self.density_in(cell(u.x), cell(u.y))
    }

    fn density_in(&self, i: usize, j: usize) -> f64 {
        let columns = self.columns.get(j).map_or(&[] as &[f64], |columns| columns);
        probability(&self.rows, j) * probability(columns, i) * (GUIDE_SIDE * GUIDE_SIDE) as f64
    }
}
