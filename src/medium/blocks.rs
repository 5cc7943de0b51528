//! Densities stored brick by brick, so that memory grows with what is not empty: to each brick belongs a block of all samples that its
//! cells interpolate. Bricks that are alike share one. Samples on a face are in the blocks of both bricks: a cell never reads two.

use super::bricks::{BRICK_SIDE, Brick};
use super::cell::Corners;

/// Samples along the side of a block: cell c of its brick lies between samples c and c + 1.
const BLOCK_SIDE: usize = BRICK_SIDE as usize + 1;

/// Samples of a block, x fastest.
pub const BLOCK_SAMPLES: usize = BLOCK_SIDE * BLOCK_SIDE * BLOCK_SIDE;

/// Fills `bricks` with the bounds of their blocks. None if there is no such block.
pub fn build_block_bricks(density: &[f32], blocks: &[u32], bricks: &mut [Brick]) -> Option<()> {
    // Alike bricks often stand in a row.
    let mut last = None;
    for (brick, &block) in bricks.iter_mut().zip(blocks) {
        let (_, bounds) = match last {
            Some(known @ (number, _)) if number == block => known,
            _ => (block, bounds(density.chunks_exact(BLOCK_SAMPLES).nth(block as usize)?)),
        };
        (*brick, last) = (bounds, Some((block, bounds)));
    }
    Some(())
}

fn bounds(samples: &[f32]) -> Brick {
    let add = |brick: Brick, &value: &f32| Brick { min: brick.min.min(value), max: brick.max.max(value) };
    samples.iter().fold(Brick { min: f32::INFINITY, max: 0.0 }, add)
}

/// The corners of a cell, counted from the low corner of the brick with this block.
#[inline(always)]
pub fn block_corners(density: &[f32], block: u32, [x, y, z]: [usize; 3]) -> Corners {
    const PLANE: usize = BLOCK_SIDE * BLOCK_SIDE;
    let first = block as usize * BLOCK_SAMPLES + z * PLANE + y * BLOCK_SIDE + x;
    let near = density.get(first..).and_then(|rest| rest.first_chunk::<{ PLANE + BLOCK_SIDE + 2 }>());
    near.map_or(Corners::default(), |near| {
        let pair = |at: usize| [near[at], near[at + 1]];
        [pair(0), pair(BLOCK_SIDE), pair(PLANE), pair(PLANE + BLOCK_SIDE)]
    })
}
