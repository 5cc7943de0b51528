//! The film: exact sums of splats in fixed point, so that order, threads, machines and restarts add up to the same bits.

use crate::math::{Colour, DVec2};

/// One pixel's sum, in units of [`LEAST`].
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cell(pub [i128; 3]);

/// The least value a cell tells apart, 2⁻⁶⁴.
pub const LEAST: f64 = 1.0 / 18_446_744_073_709_551_616.0;

/// Splats of this size and beyond are dropped: 2³² of them still fit into a cell.
pub const LARGEST: f64 = 1e9;

/// A film over memory of the caller; splats may be negative.
#[derive(Debug)]
pub struct Film<'a> {
    pub width: u32,
    pub height: u32,
    /// width·height cells, row by row from the top.
    pub cells: &'a mut [Cell],
    /// Splats left out: not finite, too large, or off the image.
    pub dropped: &'a mut u64,
}

impl Film<'_> {
    /// Adds a splat to the pixel that contains `pixel`.
    pub fn add(&mut self, pixel: DVec2, value: Colour) {
        let Some(cell) = self.cell(pixel).filter(|_| value.abs().max_element() < LARGEST && !value.is_nan()) else {
            *self.dropped = self.dropped.saturating_add(1);
            return;
        };
        for (sum, v) in cell.0.iter_mut().zip(value.to_array()) {
            *sum = sum.saturating_add(fixed_point(v));
        }
    }

    fn cell(&mut self, pixel: DVec2) -> Option<&mut Cell> {
        let inside = pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < f64::from(self.width) && pixel.y < f64::from(self.height);
        if !inside {
            return None;
        }
        self.cells.get_mut(pixel.y as u32 as usize * self.width as usize + pixel.x as u32 as usize)
    }

    /// Adds the cells of another film of the same size, and how many splats it dropped.
    pub fn merge(&mut self, cells: &[Cell], dropped: u64) {
        for (to, from) in self.cells.iter_mut().zip(cells) {
            for (sum, v) in to.0.iter_mut().zip(from.0) {
                *sum = sum.saturating_add(v);
            }
        }
        *self.dropped = self.dropped.saturating_add(dropped);
    }
}

/// In units of [`LEAST`], towards 0. In two halves of 32 bits behind the point: both conversions are then instructions of the processor.
fn fixed_point(v: f64) -> i128 {
    const HALF: f64 = 4_294_967_296.0;
    // Less than 2⁶², as values are less than `LARGEST`.
    let high = (v * HALF) as i64;
    let low = (v * HALF - high as f64) * HALF;
    (i128::from(high) << 32) + i128::from(low as i64)
}

impl Cell {
    pub fn value(&self) -> Colour {
        let [r, g, b] = self.0.map(|sum| sum as f64 * LEAST);
        Colour::new(r, g, b)
    }
}
