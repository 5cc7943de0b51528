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
    /// Next-event estimation: which light, and where on it.
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

/// Independent uniform numbers.
#[derive(Clone, Debug)]
pub struct RandomNumbers(Pcg32);

/// Streams of one sample that must not share numbers.
const PATH: u64 = 0;
const SHIFT: u64 = 1;

impl RandomNumbers {
    /// The path through `pixel` in `pass`.
    pub fn for_path(seed: u64, pass: u64, pixel: u32) -> Self {
        Self(stream(seed, pass, pixel, PATH))
    }
}

impl PrimarySample for RandomNumbers {
    fn vertex(&mut self, _index: u32) -> VertexNumbers {
        core::array::from_fn(|_| uniform(&mut self.0))
    }
}

/// Uniform numbers for the shifts of the path through `pixel` in `pass`, independent of the path's own.
pub fn shift_numbers(seed: u64, pass: u64, pixel: u32) -> impl FnMut() -> f64 {
    let mut rng = stream(seed, pass, pixel, SHIFT);
    move || uniform(&mut rng)
}

/// A generator whose state mixes seed and pass, on the increment that belongs to (pixel, purpose).
fn stream(seed: u64, pass: u64, pixel: u32, purpose: u64) -> Pcg32 {
    let mut key = [0; 16];
    let (state, increment) = key.split_at_mut(8);
    state.copy_from_slice(&mix(mix(seed) ^ mix(pass.wrapping_add(1)) ^ mix(u64::from(pixel) << 1 | purpose)).to_le_bytes());
    increment.copy_from_slice(&(u64::from(pixel) << 2 | purpose << 1).to_le_bytes());
    Pcg32::from_seed(key)
}

/// A bijection of 64-bit numbers that changes half the bits for each one changed.
/// Source: D. Stafford's variant 13 of MurmurHash3's finaliser, as in SplitMix64 (Steele et al., OOPSLA 2014).
fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The middle of one of 2³² equal parts of (0, 1): never 0 or 1.
fn uniform(rng: &mut Pcg32) -> f64 {
    (f64::from(rng.next_u32()) + 0.5) * (1.0 / 4_294_967_296.0)
}
