//! Primary sample numbers at fixed addresses (stream, vertex, slot), so that whoever supplies them, chance or a Markov chain,
//! makes the same decisions with the same numbers.

use crate::math::DVec2;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;

/// What each of a vertex' numbers decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The distance to this vertex; at the camera unused.
    Distance = 0,
    /// The direction from this vertex; at the camera the place within the pixel.
    DirectionU = 1,
    DirectionV = 2,
    /// Reflection or refraction.
    Lobe = 3,
    /// Russian roulette.
    Survival = 4,
    /// Next-event estimation: which light, and where on it; at the camera the last two are the place on the lens.
    Light = 5,
    LightU = 6,
    LightV = 7,
}

/// Numbers per vertex.
pub const SLOTS: usize = 8;

/// One vertex' numbers, each in (0, 1).
pub type VertexNumbers = [f64; SLOTS];

pub fn number(numbers: &VertexNumbers, slot: Slot) -> f64 {
    numbers[slot as usize]
}

pub fn pair(numbers: &VertexNumbers, u: Slot, v: Slot) -> DVec2 {
    DVec2::new(number(numbers, u), number(numbers, v))
}

/// A source of primary sample numbers. Vertices are asked for once each, in order from 0, the camera.
pub trait PrimarySample {
    fn vertex(&mut self, index: u32) -> VertexNumbers;
}

/// Uniform numbers: independent ones, but for the place within the pixel, which the passes spread evenly. What is seen directly has no
/// other noise than that.
#[derive(Clone, Debug)]
pub struct RandomNumbers {
    rng: Pcg32,
    place: Option<[u32; 2]>,
}

/// What of one sample, or of all samples of a pixel, must not share numbers.
const PATH: u64 = 0;
const SHIFT: u64 = 1;
const PLACE: u64 = 2;
const TILES: u64 = 3;
const LINE: u64 = 4;
const LIGHT: u64 = 5;
const BOOTSTRAP: u64 = 6;
const CHAIN: u64 = 7;
const CHAIN_SHIFT: u64 = 8;
const PLAN: u64 = 9;
const ROULETTE: u64 = 10;

/// 2³²/φ and 2³²/φ², where φ³ = φ + 1: multiples of these, modulo 2³², fill the unit square evenly.
/// Source: M. Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018 (R₂).
const SPREAD: [u32; 2] = [3_242_174_889, 2_447_445_414];

impl RandomNumbers {
    /// The path through `pixel` in `pass`.
    pub fn for_path(seed: u64, pass: u64, pixel: u32) -> Self {
        // One random place for all pixels, moved on by each pass: each alone is uniform. A tile's members are at each other's places.
        let mut start = stream(seed, 0, 0, PLACE);
        let place = SPREAD.map(|step| start.next_u32().wrapping_add(step.wrapping_mul(pass as u32)));
        Self { rng: stream(seed, pass, pixel, PATH), place: Some(place) }
    }

    /// The subpath from a light that belongs to the same sample.
    pub fn for_light(seed: u64, pass: u64, pixel: u32) -> Self {
        Self { rng: stream(seed, pass, pixel, LIGHT), place: None }
    }
}

impl PrimarySample for RandomNumbers {
    fn vertex(&mut self, index: u32) -> VertexNumbers {
        let mut numbers = core::array::from_fn(|_| uniform(self.rng.next_u32()));
        if let Some(place) = self.place.filter(|_| index == 0) {
            [numbers[Slot::DirectionU as usize], numbers[Slot::DirectionV as usize]] = place.map(uniform);
        }
        numbers
    }
}

/// Uniform numbers for the shifts of the path through `pixel` in `pass`, independent of the path's own.
pub fn shift_numbers(seed: u64, pass: u64, pixel: u32) -> impl FnMut() -> f64 {
    let mut rng = stream(seed, pass, pixel, SHIFT);
    move || uniform(rng.next_u32())
}

/// Uniform numbers for what the bidirectional sample through `pixel` in `pass` leaves to chance because it is worth little.
pub fn roulette_numbers(seed: u64, pass: u64, pixel: u32) -> impl FnMut() -> f64 {
    let mut rng = stream(seed, pass, pixel, ROULETTE);
    move || uniform(rng.next_u32())
}

/// Where the tiles of a pass begin, for all its paths.
pub fn tile_numbers(seed: u64, pass: u64) -> [u32; 2] {
    let mut rng = stream(seed, pass, 0, TILES);
    [rng.next_u32(), rng.next_u32()]
}

/// Uniform numbers for sample number `index` among those that chains begin with.
pub fn bootstrap_numbers(seed: u64, index: u64) -> impl FnMut() -> f64 {
    let mut rng = stream(seed, index, 0, BOOTSTRAP);
    move || uniform(rng.next_u32())
}

/// Uniform numbers for choosing among those.
pub fn plan_numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut rng = stream(seed, 0, 0, PLAN);
    move || uniform(rng.next_u32())
}

/// For the batch of the path that `mutation` of chain number `index` made: where tiles begin, and uniform numbers that no decision of the
/// chain knows.
pub fn chain_shift_numbers(seed: u64, index: u32, mutation: u64) -> ([u32; 2], impl FnMut() -> f64) {
    let mut rng = stream(seed, mutation, index, CHAIN_SHIFT);
    ([rng.next_u32(), rng.next_u32()], move || uniform(rng.next_u32()))
}

/// Uniform numbers for all that Markov chain number `index` decides.
#[derive(Clone, Debug)]
pub struct ChainNumbers(Pcg32);

impl ChainNumbers {
    pub fn new(seed: u64, index: u32) -> Self {
        Self(stream(seed, 0, index, CHAIN))
    }

    pub fn next(&mut self) -> f64 {
        uniform(self.0.next_u32())
    }
}

/// Uniform numbers for estimate number `index` along a line.
pub fn line_numbers(seed: u64, index: u64) -> impl FnMut() -> f64 {
    let mut rng = stream(seed, index, 0, LINE);
    move || uniform(rng.next_u32())
}

/// A generator whose state mixes seed, pass, pixel and purpose, on an increment of its own per pixel and purpose.
fn stream(seed: u64, pass: u64, pixel: u32, purpose: u64) -> Pcg32 {
    let address = u64::from(pixel) << 4 | purpose;
    let mut key = [0; 16];
    let (state, increment) = key.split_at_mut(8);
    state.copy_from_slice(&mix(mix(mix(seed) ^ pass) ^ address).to_le_bytes());
    increment.copy_from_slice(&(address << 1).to_le_bytes());
    Pcg32::from_seed(key)
}

/// A bijection of 64-bit numbers that changes half the bits for each one changed.
/// Source: D. Stafford's variant 13 of MurmurHash3's finaliser, as in SplitMix64 (Steele et al., OOPSLA 2014).
pub fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The middle of one of 2³² equal parts of (0, 1): never 0 or 1.
fn uniform(number: u32) -> f64 {
    (f64::from(number) + 0.5) * (1.0 / 4_294_967_296.0)
}
