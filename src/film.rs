//! The film: exact sums of splats in fixed point, so that order, threads, machines and restarts add up to the same bits.
//!
//! A sum is made of limbs that are atomic. A film that one thread adds to reads and writes them as if they were not; one that is shared adds
//! to each limb in one step, and takes the carry on to the next: what all threads have added is in the limbs when none is adding.

use crate::math::{Colour, DVec2};
use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The least value a cell tells apart, 2⁻⁶⁴.
pub const LEAST: f64 = 1.0 / 18_446_744_073_709_551_616.0;

/// Splats of this size and beyond are dropped: 2³² of them still fit into a cell.
pub const LARGEST: f64 = 1e9;

const LIMBS: usize = (i128::BITS / usize::BITS) as usize;

/// An integer of 128 bits, the least limb first.
#[derive(Debug, Default)]
struct Sum([AtomicUsize; LIMBS]);

impl Sum {
    fn get(&self) -> i128 {
        self.0.iter().rev().fold(0, |sum, limb| (sum << usize::BITS) | limb.load(Relaxed) as i128)
    }

    fn set(&self, mut value: i128) {
        for limb in &self.0 {
            limb.store(value as usize, Relaxed);
            value >>= usize::BITS;
        }
    }

    /// While no other thread does. At an end of the range it stays there.
    fn add(&self, v: i128) {
        self.set(self.get().checked_add(v).unwrap_or_else(|| end_of_range(v)));
    }

    /// While others may. Beyond an end of the range it goes on at the other.
    fn add_shared(&self, mut v: i128) {
        let mut carry = false;
        for limb in &self.0 {
            let (part, full) = (v as usize).overflowing_add(carry.into());
            carry = full || (part != 0 && limb.fetch_add(part, Relaxed).overflowing_add(part).1);
            v >>= usize::BITS;
        }
    }
}

/// Where a sum stays that would leave the range by adding `v`. (Cold, so that it is a branch: it does not happen.)
#[cold]
fn end_of_range(v: i128) -> i128 {
    if v < 0 { i128::MIN } else { i128::MAX }
}

/// One pixel's sum, in units of [`LEAST`].
#[repr(C, align(16))]
#[derive(Debug, Default)]
pub struct Cell([Sum; 3]);

impl Cell {
    pub fn value(&self) -> Colour {
        let [r, g, b] = self.sums().map(|sum| sum as f64 * LEAST);
        Colour::new(r, g, b)
    }

    /// In units of [`LEAST`].
    pub fn sums(&self) -> [i128; 3] {
        let [r, g, b] = &self.0;
        [r, g, b].map(Sum::get)
    }
}

impl From<[i128; 3]> for Cell {
    fn from(sums: [i128; 3]) -> Self {
        let cell = Self::default();
        cell.0.iter().zip(sums).for_each(|(sum, value)| sum.set(value));
        cell
    }
}

impl Clone for Cell {
    fn clone(&self) -> Self {
        self.sums().into()
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.sums() == other.sums()
    }
}

/// A number of splats.
#[derive(Debug, Default)]
pub struct Count(AtomicUsize);

impl Count {
    pub fn get(&self) -> u64 {
        self.0.load(Relaxed) as u64
    }

    pub fn add(&self, more: u64) {
        self.0.fetch_add(more as usize, Relaxed);
    }
}

impl Clone for Count {
    fn clone(&self) -> Self {
        Self(self.0.load(Relaxed).into())
    }
}

impl PartialEq for Count {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

/// A film over memory of the caller; splats may be negative.
#[derive(Debug)]
pub struct Film<'a> {
    pub width: u32,
    pub height: u32,
    /// width·height cells, row by row from the top.
    pub cells: &'a [Cell],
    /// Splats left out: not finite, too large, or off the image.
    pub dropped: &'a Count,
    /// Whether other threads may add to these cells at the same time.
    pub is_shared: bool,
}

impl Film<'_> {
    /// Adds a splat to the pixel that contains `pixel`.
    pub fn add(&mut self, pixel: DVec2, value: Colour) {
        match self.cell(pixel).filter(|_| value.abs().max_element() < LARGEST && !value.is_nan()) {
            Some(cell) => self.add_to(cell, value.to_array().map(fixed_point)),
            None => self.dropped.add(1),
        }
    }

    fn add_to(&self, cell: &Cell, values: [i128; 3]) {
        for (sum, v) in cell.0.iter().zip(values) {
            if self.is_shared { sum.add_shared(v) } else { sum.add(v) }
        }
    }

    fn cell(&self, pixel: DVec2) -> Option<&Cell> {
        let inside = pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < f64::from(self.width) && pixel.y < f64::from(self.height);
        if !inside {
            return None;
        }
        self.cells.get(pixel.y as u32 as usize * self.width as usize + pixel.x as u32 as usize)
    }

    /// Adds the cells of another film of the same size, and how many splats it dropped.
    pub fn merge(&mut self, cells: &[Cell], dropped: u64) {
        for (to, from) in self.cells.iter().zip(cells) {
            self.add_to(to, from.sums());
        }
        self.dropped.add(dropped);
    }
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
