//! Density grids, dense and sparse.

use super::convert::{self, Place};
use super::pointer::{array, sized};
use super::status::{Fault, volgrad_status::*};
use super::types::*;
use crate::medium::{BLOCK_SAMPLES, Brick, Grid, brick_counts, build_block_bricks, build_bricks};

/// Bricks that medium `i` needs; 0 if it is no grid.
pub(super) fn brick_count(m: &volgrad_medium, i: usize) -> Result<usize, Fault> {
    if !matches!(m.kind, VOLGRAD_MEDIUM_GRID | VOLGRAD_MEDIUM_SPARSE_GRID) {
        return Ok(0);
    }
    let size = convert::grid_size(m, i)?;
    if m.kind == VOLGRAD_MEDIUM_GRID {
        count(size, i)?;
    }
    count(brick_counts(size), i)
}

/// Samples or bricks, from how many there are along each axis.
fn count(counts: [i32; 3], i: usize) -> Result<usize, Fault> {
    let product = counts.iter().try_fold(1usize, |product, n| product.checked_mul(*n as usize));
    // The core's indices are products of i32s.
    product.filter(|product| *product <= i32::MAX as usize).ok_or(VOLGRAD_ERROR_RANGE.at(c"media.nx, media.ny, media.nz", i))
}

/// The grid of medium `i`, and the bounds of its `bricks`, as many as `brick_count` says.
///
/// # Safety
/// As the header says of `density` and `custom`, which outlive the scene.
pub(super) unsafe fn grid(m: &volgrad_medium, i: usize, bricks: &'static mut [Brick]) -> Result<Grid<'static>, Fault> {
    // SAFETY: the caller's promise.
    let grid = unsafe { if m.kind == VOLGRAD_MEDIUM_SPARSE_GRID { sparse(m, i, bricks) } else { dense(m, i, bricks) } }?;
    grid.ok_or(VOLGRAD_ERROR_RANGE.at(c"media.nx, media.ny, media.nz", i))
}

/// # Safety
/// As for `grid`.
unsafe fn dense(m: &volgrad_medium, i: usize, bricks: &'static mut [Brick]) -> Result<Option<Grid<'static>>, Fault> {
    let size = convert::grid_size(m, i)?;
    let place = Place(c"media.density", i);
    // SAFETY: the caller's promise.
    let density = unsafe { array(m.density, count(size, i)?) }.map_err(|s| s.at(place.0, i))?;
    densities(density, place)?;
    build_bricks(density, size, bricks);
    Ok(Grid::new(density, size, convert::grid_transform(m, i)?, bricks))
}

/// # Safety
/// As for `grid`.
unsafe fn sparse(m: &volgrad_medium, i: usize, bricks: &'static mut [Brick]) -> Result<Option<Grid<'static>>, Fault> {
    let size = convert::grid_size(m, i)?;
    let place = Place(c"media.custom.density", i);
    // SAFETY: the caller's promise, here and below.
    let s = unsafe { sized(m.custom.cast::<volgrad_sparse_grid>()) }.map_err(|s| s.at(c"media.custom", i))?;
    let samples = (s.block_count as usize).checked_mul(BLOCK_SAMPLES).ok_or(VOLGRAD_ERROR_RANGE.at(place.0, i))?;
    let density = unsafe { array(s.density, samples) }.map_err(|s| s.at(place.0, i))?;
    let blocks = unsafe { array(s.blocks, bricks.len()) }.map_err(|s| s.at(c"media.custom.blocks", i))?;
    densities(density, place)?;
    build_block_bricks(density, blocks, bricks).ok_or(VOLGRAD_ERROR_INDEX.at(c"media.custom.blocks", i))?;
    Ok(Grid::of_blocks(density, blocks, size, convert::grid_transform(m, i)?, bricks))
}

/// Whether all values are densities.
fn densities(density: &[f32], place: Place) -> Result<(), Fault> {
    if density.iter().any(|value| !value.is_finite()) {
        return Err(VOLGRAD_ERROR_NOT_FINITE.at(place.0, place.1));
    }
    if density.iter().any(|value| *value < 0.0) {
        return Err(VOLGRAD_ERROR_RANGE.at(place.0, place.1));
    }
    Ok(())
}
