//! The least and greatest density of every 8³ block of cells, so that empty and constant blocks are crossed in closed form.

/// Cells along a brick's side.
pub const BRICK_SIDE: i32 = 8;

/// Bounds of the density inside a brick, over all samples that its cells interpolate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Brick {
    pub min: f32,
    pub max: f32,
}

/// Bricks along each axis of a grid with `size` samples, which has size + 1 cells (the outermost ones are half outside).
pub fn brick_counts(size: [i32; 3]) -> [i32; 3] {
    size.map(|n| (n + BRICK_SIDE) / BRICK_SIDE)
}

/// Fills `bricks` (x fastest, as many as [`brick_counts`] says) from the samples (x fastest).
pub fn build_bricks(density: &[f32], size: [i32; 3], bricks: &mut [Brick]) {
    let counts = brick_counts(size);
    let mut out = bricks.iter_mut();
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            for x in 0..counts[0] {
                if let Some(brick) = out.next() {
                    *brick = bounds(density, size, [x, y, z]);
                }
            }
        }
    }
}

fn bounds(density: &[f32], size: [i32; 3], brick: [i32; 3]) -> Brick {
    // Cell c lies between samples c − 1 and c.
    let range = |axis: usize| {
        let first = brick[axis] * BRICK_SIDE;
        (first - 1).max(0) as usize..(first + BRICK_SIDE).min(size[axis]) as usize
    };
    let [nx, ny, _] = size.map(|n| n as usize);
    let mut result = Brick { min: f32::INFINITY, max: 0.0 };
    for z in range(2) {
        for y in range(1) {
            let row = (z * ny + y) * nx;
            for value in density.get(row + range(0).start..row + range(0).end).unwrap_or(&[]) {
                result.min = result.min.min(*value);
                result.max = result.max.max(*value);
            }
        }
    }
    result
}
