//! Media of the reference: homogeneous ones, grids, and grids large enough to have many bricks, some empty and some constant.

use super::host::rounded_world;
use crate::reference::{
    grid::Grid,
    medium::{Density, Medium},
    phase::Phase,
    random::uniform,
    vector::*,
    world::World,
};
use rand_pcg::Pcg64;

pub const UNIT_CUBE: Affine = Affine { columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: ZERO };

pub fn homogeneous(sigma_t: Rgb) -> Medium {
    Medium { sigma_t, albedo: [0.9; 3], phase: Phase::Isotropic, density: Density::Constant }
}

/// With its samples rounded to single precision.
pub fn heterogeneous(sigma_t: Rgb, grid: Grid) -> Medium {
    let medium = Medium { density: Density::Grid(grid), ..homogeneous(sigma_t) };
    rounded_world(&World::filled_with(medium)).media.remove(0)
}

/// Several bricks along each axis, and no multiple of a brick's side.
pub const LARGE: [usize; 3] = [40, 24, 33];

/// Empty in the first part along x, constant in the last, random between.
pub fn large_grid(rng: &mut Pcg64, to_world: Affine) -> Grid {
    sparse_grid(rng, LARGE, to_world, 0.0)
}

/// The first two fifths of the samples along x are `low`, the last two 0.7, those between random in [0.2, 2).
pub fn sparse_grid(rng: &mut Pcg64, resolution: [usize; 3], to_world: Affine, low: f64) -> Grid {
    let [nx, ny, nz] = resolution;
    let mut samples = Vec::with_capacity(nx * ny * nz);
    for _ in 0..ny * nz {
        for i in 0..nx {
            samples.push(match 5 * i / nx {
                0 | 1 => low,
                2 => uniform(rng, 0.2, 2.0),
                _ => 0.7,
            });
        }
    }
    Grid { resolution, samples, to_world }
}
