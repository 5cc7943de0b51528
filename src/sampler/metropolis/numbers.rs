//! The primary sample numbers of one technique, and how a chain changes them.

use crate::sampler::bidirectional::Technique;
use crate::sampler::primary::{PrimarySample, SLOTS, Slot, VertexNumbers};
use core::ops::Range;

/// Numbers per vertex of a subpath, and of a light's first vertex.
const PER_VERTEX: usize = 4;
const PER_LIGHT: usize = 5;

const CAMERA_SLOTS: [Slot; PER_VERTEX] = [Slot::DirectionU, Slot::DirectionV, Slot::LightU, Slot::LightV];
const LIGHT_SLOTS: [Slot; PER_LIGHT] = [Slot::Light, Slot::LightU, Slot::LightV, Slot::DirectionU, Slot::DirectionV];
const VERTEX_SLOTS: [Slot; PER_VERTEX] = [Slot::Distance, Slot::DirectionU, Slot::DirectionV, Slot::Lobe];

/// How many numbers a path of `length` edges takes at most.
pub const fn capacity(length: usize) -> usize {
    PER_VERTEX * (length + 1) + PER_LIGHT - PER_VERTEX
}

impl Technique {
    fn camera_numbers(self) -> usize {
        PER_VERTEX * self.camera
    }

    /// How many numbers it takes.
    pub fn numbers(self) -> usize {
        self.camera_numbers() + if self.light > 0 { PER_LIGHT + PER_VERTEX * (self.light - 1) } else { 0 }
    }

    /// Those of the two subpaths.
    pub fn split(self, numbers: &[f64]) -> (SubpathNumbers<'_>, SubpathNumbers<'_>) {
        let (camera, light) = numbers.split_at(self.camera_numbers().min(numbers.len()));
        (SubpathNumbers { first: &CAMERA_SLOTS, numbers: camera }, SubpathNumbers { first: &LIGHT_SLOTS, numbers: light })
    }
}

/// The subpaths whose numbers a mutation changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    pub camera: bool,
    pub light: bool,
}

/// How often a small step changes the camera's subpath, where it changes one of two: that moves the path over the image, which is what most of
/// the noise comes from.
const CAMERA_SHARE: f64 = 0.9;

impl Change {
    pub const NONE: Self = Self { camera: false, light: false };
    pub const BOTH: Self = Self { camera: true, light: true };

    /// What a small step changes: one of two subpaths, and the other need not be made again. A camera's single vertex takes no time.
    pub fn small(technique: Technique, u: f64) -> Self {
        if technique.camera == 1 || technique.light == 0 {
            return Self::BOTH;
        }
        Self { camera: u < CAMERA_SHARE, light: u >= CAMERA_SHARE }
    }

    /// The numbers that change.
    pub fn numbers(self, technique: Technique) -> Range<usize> {
        let middle = technique.camera_numbers();
        (if self.camera { 0 } else { middle })..(if self.light { technique.numbers() } else { middle })
    }
}

/// A subpath's numbers; 0 where nothing reads them.
pub struct SubpathNumbers<'n> {
    first: &'static [Slot],
    numbers: &'n [f64],
}

impl PrimarySample for SubpathNumbers<'_> {
    fn vertex(&mut self, index: u32) -> VertexNumbers {
        let mut all = [0.0; SLOTS];
        let slots = if index == 0 { self.first } else { &VERTEX_SLOTS };
        let start = if index == 0 { 0 } else { self.first.len() + PER_VERTEX * (index as usize - 1) };
        for (slot, number) in slots.iter().zip(self.numbers.get(start..).unwrap_or(&[])) {
            all[*slot as usize] = *number;
        }
        all
    }
}

/// Largest standard deviation of a small step.
pub const LARGEST_STEP: f64 = 0.2;

/// A small step of a number on the circle (0, 1): the sum of two uniform ones, of standard deviation `size`, at most [`LARGEST_STEP`].
pub fn step(number: f64, size: f64, random: &mut impl FnMut() -> f64) -> f64 {
    const UNIT: f64 = 2.449_489_742_783_178; // √6
    const { assert!(LARGEST_STEP * UNIT < 1.0) };
    let moved = number + size * UNIT * (random() + random() - 1.0);
    let wrapped = moved + f64::from(moved < 0.0) - f64::from(moved > 1.0);
    if wrapped > 0.0 && wrapped < 1.0 { wrapped } else { number }
}
