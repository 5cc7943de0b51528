//! Where a chain's mutations are made: its path and the proposed one, which trade places when the proposal is accepted. What the two have in
//! common is there once.

use super::bootstrap::Numbers;
use super::numbers::{Change, capacity};
use crate::sampler::bidirectional::{Connection, MAX_LENGTH, Subpath};
use crate::shift::{self, Shiftable, Tile};

/// A path of the chain, ready to be splatted. Its vertices are beside it.
#[derive(Default)]
pub struct Sample {
    pub target: f64,
    /// Its value is w·f/p over the density of this path among a chain's samples, what it is worth each time that it comes; its weight is 1.
    pub connection: Option<Connection>,
    /// What it is worth as a large step's sample, over that.
    pub large: f64,
    /// The mutation that made it, and whether some of it can move.
    pub born: u64,
    pub moves: bool,
}

/// What belongs to the chain's path, and what to the proposed one.
#[derive(Default)]
pub struct Double<T> {
    places: [T; 2],
    traded: bool,
}

impl<T> Double<T> {
    pub fn current(&mut self) -> &mut T {
        self.get(false)
    }

    pub fn proposed(&mut self) -> &mut T {
        self.get(true)
    }

    pub fn get(&mut self, proposed: bool) -> &mut T {
        let [a, b] = &mut self.places;
        if proposed == self.traded { a } else { b }
    }
}

/// A proposed path has the chain's subpaths, but for those that it changes.
pub struct Room<'a> {
    pub camera: Double<Subpath<'a>>,
    pub light: Double<Subpath<'a>>,
    pub sample: Double<Sample>,
    /// The proposed path's.
    pub numbers: Numbers,
    pub shiftable: Option<Shiftable>,
    pub batch: shift::Scratch,
    pub tile: Option<Tile>,
}

impl Default for Room<'_> {
    // Out of line, as is what a room is made of: it passes over the stack, and need not stay there.
    #[inline(never)]
    fn default() -> Self {
        Self {
            camera: Double::default(),
            light: Double::default(),
            sample: Double::default(),
            numbers: [0.0; capacity(MAX_LENGTH)],
            shiftable: None,
            batch: shift::Scratch::default(),
            tile: None,
        }
    }
}

impl Room<'_> {
    /// The proposed path, with these changes, is the chain's from now on.
    pub fn accept(&mut self, change: Change) {
        self.camera.traded ^= change.camera;
        self.light.traded ^= change.light;
        self.sample.traded = !self.sample.traded;
    }
}
