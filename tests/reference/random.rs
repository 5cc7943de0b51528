//! Deterministic random numbers, points and directions for tests.

use super::vector::*;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::f64::consts::PI;

pub fn generator(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// Uniform in [low, high).
pub fn uniform(rng: &mut Pcg64, low: f64, high: f64) -> f64 {
    // The upper 53 bits are as many as an f64 holds.
    let unit = (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    low + (high - low) * unit
}

pub fn random_vector(rng: &mut Pcg64, low: f64, high: f64) -> Vec3 {
    [0; 3].map(|_| uniform(rng, low, high))
}

pub fn random_direction(rng: &mut Pcg64) -> Vec3 {
    let z = uniform(rng, -1.0, 1.0);
    let angle = uniform(rng, 0.0, 2.0 * PI);
    let radius = (1.0 - z * z).sqrt();
    [radius * angle.cos(), radius * angle.sin(), z]
}
