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
            let v = fixed_point(v);
            *sum = sum.checked_add(v).unwrap_or_else(|| end_of_range(v));
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

/// Where a sum stays that would leave the range by adding `v`. (Cold, so that it is a branch: it does not happen.)
#[cold]
fn end_of_range(v: i128) -> i128 {
    if v < 0 { i128::MIN } else { i128::MAX }
}

/// In units of [`LEAST`], rounded to the nearest, for values below [`LARGEST`].
fn fixed_point(v: f64) -> i128 {
    /// Added to a number below 2⁵¹, this leaves the nearest integer in the low bits of the sum.
    const INTEGER_IN_LOW_BITS: f64 = 6_755_399_441_055_744.0;
    const BITS_OF_HIGH: u32 = 20;
    const BITS_OF_LOW: u32 = 64 - BITS_OF_HIGH;
    let integer = |sum: f64| i128::from(sum.to_bits() as i64 - INTEGER_IN_LOW_BITS.to_bits() as i64);
    let scaled = v * (1u64 << BITS_OF_HIGH) as f64;
    let high = scaled + INTEGER_IN_LOW_BITS;
    // At most a half: the subtractions are exact.
    let rest = scaled - (high - INTEGER_IN_LOW_BITS);
    let low = rest * (1u64 << BITS_OF_LOW) as f64 + INTEGER_IN_LOW_BITS;
    (integer(high) << BITS_OF_LOW) + integer(low)
}

impl Cell {
    pub fn value(&self) -> Colour {
        let [r, g, b] = self.0.map(|sum| sum as f64 * LEAST);
        Colour::new(r, g, b)
    }
}
