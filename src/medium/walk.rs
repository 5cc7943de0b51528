//! The way of a line through a grid: constant bricks in one step, others cell by cell.

use super::Moments;
use super::blocks::block_corners;
use super::bricks::{BRICK_SIDE, Brick, brick_counts};
use super::cell::{Chords, Corners};
use super::dda::{Dda, Lattice, LatticeLine, index};
use crate::math::{DVec2, DVec3};
use core::ops::ControlFlow;

/// The samples of a grid, and their bricks or none.
///
/// In *lattice coordinates* sample i lies at i + 1, so that the unit cells [c, c+1), c = 0…n, tile the box [½, n + ½].
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    density: &'a [f32],
    /// The block of each brick (`blocks`); none: `density` is all samples, x fastest.
    blocks: &'a [u32],
    bricks: &'a [Brick],
    pub size: [i32; 3],
    /// From one row of bricks to the next, and from one plane.
    brick_strides: [u32; 2],
    cell_lattice: Lattice,
    brick_lattice: Lattice,
}

/// The stretch of a line that is inside the box.
pub struct Inside {
    pub start: f64,
    pub end: f64,
}

/// What is added up on the way. Break(t) ends it.
pub trait Visitor {
    fn constant(&mut self, density: f64, start: f64, end: f64) -> ControlFlow<f64>;
    fn cells(&mut self, line: &LatticeLine, chords: &Chords) -> ControlFlow<f64>;
}

/// Cells that are traced, looked up and integrated together. The first two wait, for the step before and for memory, the last are long
/// sums; one after the other, each keeps the processor busy with many cells at once.
type Batch = [Chords; 8];

/// Bricks that are walked in one go. Not all that there are: the way may end in the first of them.
const BRICKS_IN_A_ROW: usize = 4;

impl<'a> Samples<'a> {
    /// As many samples and bricks as there have to be, in 32 bits. With blocks there are bricks.
    pub fn new(density: &'a [f32], blocks: &'a [u32], size: [i32; 3], bricks: &'a [Brick]) -> Self {
        let [nx, ny, _] = size.map(f64::from);
        let [bx, by, _] = brick_counts(size).map(f64::from);
        Self {
            density,
            blocks,
            bricks,
            size,
            brick_strides: [bx as u32, (bx * by) as u32],
            // Cell (1, 1, 1) starts at sample 0.
            cell_lattice: Lattice::new(1, size.map(|n| n + 1), -(1.0 + nx + nx * ny), DVec3::new(1.0, nx, nx * ny)),
            brick_lattice: Lattice::new(BRICK_SIDE, brick_counts(size), 0.0, DVec3::new(1.0, bx, bx * by)),
        }
    }

    #[inline(always)]
    pub fn walk(&self, line: &LatticeLine, inside: &Inside, visitor: &mut impl Visitor) -> ControlFlow<f64> {
        let core = self.core(line, inside);
        // Made when the first cell comes: many lines pass empty bricks only.
        let mut batch = None;
        let mut bricks = Dda::new(line, &self.brick_lattice, inside.start, inside.end);
        // Up to here everything is visited: to the next brick; or by a cell further, if rounding puts the cell's wall before the brick's.
        let mut done = inside.start;
        let mut cells = None;
        while done < inside.end && bricks.t < inside.end {
            if let Some(density) = self.constant(&bricks) {
                bricks.advance();
                if density > 0.0 && done < bricks.t {
                    visitor.constant(density, done, bricks.t)?;
                }
                (done, cells) = (bricks.t, None);
                continue;
            }
            for _ in 0..BRICKS_IN_A_ROW {
                bricks.advance();
                if !(bricks.t < inside.end) || self.constant(&bricks).is_some() {
                    break;
                }
            }
            let cells = cells.get_or_insert_with(|| Dda::new(line, &self.cell_lattice, done, inside.end));
            let batch = batch.get_or_insert(Batch::default());
            while cells.t < bricks.t {
                let traced = trace(cells, bricks.t, batch);
                let known = if self.blocks.is_empty() { self.look_up(&core, traced) } else { self.look_up_in_blocks(traced) };
                for chords in known {
                    visitor.cells(line, chords)?;
                }
            }
            done = cells.t;
        }
        ControlFlow::Continue(())
    }

    /// Of all bricks on the way; of all samples, if there are no bricks.
    pub fn bounds(&self, line: &LatticeLine, inside: &Inside) -> Brick {
        let mut bounds = Brick { min: f32::INFINITY, max: 0.0 };
        let mut add = |min: f32, max: f32| bounds = Brick { min: bounds.min.min(min), max: bounds.max.max(max) };
        if self.bricks.is_empty() {
            self.density.iter().for_each(|value| add(*value, *value));
        }
        let mut bricks = Dda::new(line, &self.brick_lattice, inside.start, inside.end);
        while bricks.t < inside.end {
            if let Some(brick) = self.bricks.get(bricks.index()) {
                add(brick.min, brick.max);
            }
            bricks.advance();
        }
        Brick { min: bounds.min.min(bounds.max), ..bounds }
    }

    /// Whether bricks say that all densities in a box of cells are more than 0. They are not asked if more than two in a row would have
    /// to be: cell by cell is faster then.
    pub fn is_positive_between(&self, low: [u32; 3], high: [u32; 3]) -> bool {
        let [low, high] = [low, high].map(|cell| cell.map(|c| c / BRICK_SIDE as u32));
        let mut bricks =
            (low[2]..=high[2]).flat_map(|z| (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| [x, y, z])));
        (0..3).all(|axis| high[axis] - low[axis] <= 1)
            && bricks.all(|brick| self.brick_at(brick).is_some_and(|brick| brick.min > 0.0))
    }

    /// The brick that a cell is in, if there are bricks.
    pub fn brick(&self, cell: [u32; 3]) -> Option<&Brick> {
        self.brick_at(cell.map(|c| c / BRICK_SIDE as u32))
    }

    fn brick_at(&self, brick: [u32; 3]) -> Option<&Brick> {
        let [x, y, z] = brick.map(|b| b as usize);
        let [nx, ny, _] = brick_counts(self.size).map(|n| n as usize);
        self.bricks.get((z * ny + y) * nx + x)
    }

    /// The density of the brick that a walk comes to, if it is the same all over it.
    #[inline(always)]
    fn constant(&self, bricks: &Dda) -> Option<f64> {
        let brick = self.bricks.get(bricks.index())?;
        (brick.min == brick.max).then(|| brick.min.into())
    }

    /// Fills in the corners. The second loop waits for nothing but memory, which is so asked for many of them at a time.
    #[inline(never)]
    fn look_up<'c>(&self, core: &Inside, batch: &'c mut [Chords]) -> &'c [Chords] {
        for chords in batch.iter_mut() {
            chords.numbers = self.cell_lattice.numbers(chords.cells);
        }
        for chords in batch.iter_mut() {
            let [a, b] = if chords.start.x >= core.start && chords.end.y <= core.end {
                chords.numbers.to_array().map(|number| self.inner_corners(index(number)))
            } else {
                let [x, y, z] = chords.cells;
                [0, 1].map(|i| self.corners([x[i] as i32, y[i] as i32, z[i] as i32]))
            };
            chords.set_corners(a, b);
        }
        batch
    }

    /// The same, of blocks.
    #[inline(never)]
    fn look_up_in_blocks<'c>(&self, batch: &'c mut [Chords]) -> &'c [Chords] {
        for chords in batch.iter_mut() {
            let [x, y, z] = chords.cells;
            let [a, b] = [0, 1].map(|i| self.corners_in_block([x[i] as u32, y[i] as u32, z[i] as u32]));
            chords.set_corners(a, b);
        }
        batch
    }

    /// The part of a line where all samples are x fastest and no cell reaches beyond the outermost ones.
    fn core(&self, line: &LatticeLine, inside: &Inside) -> Inside {
        let none = Inside { start: f64::INFINITY, end: f64::NEG_INFINITY };
        if !self.blocks.is_empty() {
            return none;
        }
        let mut core = Inside { ..*inside };
        let low = DVec3::ONE;
        let high = DVec3::from_array(self.size.map(f64::from));
        let (a, b) = (line.crossings(low), line.crossings(high));
        for axis in 0..3 {
            if !line.is_parallel(axis) {
                core.start = core.start.max(a[axis].min(b[axis]));
                core.end = core.end.min(a[axis].max(b[axis]));
            } else if !(line.origin[axis] >= low[axis] && line.origin[axis] < high[axis]) {
                return none;
            }
        }
        core
    }

    /// The eight samples around a cell, those outside the box repeated from its border. In a box of next to no volume rounding puts cells
    /// anywhere.
    #[inline(never)]
    pub fn corners(&self, cell: [i32; 3]) -> Corners {
        if !self.blocks.is_empty() {
            return self.corners_in_block(cell.map(|c| c.max(0) as u32));
        }
        let inside = |axis: usize, sample: i32| sample.min(self.size[axis] - 1).max(0) as usize;
        let below = |axis: usize| inside(axis, cell[axis].saturating_sub(1));
        let above = |axis: usize| inside(axis, cell[axis]);
        let [nx, ny, _] = self.size.map(|n| n as usize);
        let sample = |x: usize, y: usize, z: usize| self.density.get((z * ny + y) * nx + x).copied().unwrap_or(0.0);
        let pair = |y: usize, z: usize| [sample(below(0), y, z), sample(above(0), y, z)];
        [pair(below(1), below(2)), pair(above(1), below(2)), pair(below(1), above(2)), pair(above(1), above(2))]
    }

    /// The same from the blocks, where samples outside the box are those of its border.
    #[inline(always)]
    fn corners_in_block(&self, cell: [u32; 3]) -> Corners {
        let side = BRICK_SIDE as u32;
        let [x, y, z]: [u32; 3] = core::array::from_fn(|axis| cell[axis].min(self.size[axis] as u32));
        let [row, plane] = self.brick_strides;
        match self.blocks.get((z / side * plane + y / side * row + x / side) as usize) {
            Some(block) => block_corners(self.density, *block, [x, y, z].map(|c| (c % side) as usize)),
            None => Corners::default(),
        }
    }

    /// The same for a cell whose samples are all there, the first of them at `index`.
    #[inline(always)]
    fn inner_corners(&self, index: usize) -> Corners {
        // As u32: with 64 bits the compiler then knows that no sum overflows, and from the one comparison that all pairs are there. With
        // 32 it looks at each pair; sums of an inner cell's indices do not overflow.
        let (row, plane) = (self.size[0] as u32 as usize, (self.size[0] * self.size[1]) as u32 as usize);
        if index + row + plane + 2 > self.density.len() {
            return Corners::default();
        }
        let pair = |first: usize| match self.density.get(first..first + 2) {
            Some([a, b]) => [*a, *b],
            _ => [0.0; 2],
        };
        [pair(index), pair(index + row), pair(index + plane), pair(index + row + plane)]
    }
}

/// The cells that a walk passes until `until`, as many as fit in the batch. An odd one is followed by a chord of no length.
#[inline(never)]
fn trace<'c>(cells: &mut Dda, until: f64, batch: &'c mut Batch) -> &'c mut [Chords] {
    let mut dda = *cells;
    let mut count = 0;
    for chords in batch.iter_mut() {
        if !(dda.t < until) {
            break;
        }
        for i in 0..2 {
            chords.start[i] = dda.t;
            if dda.t < until {
                (chords.cells[0][i], chords.cells[1][i], chords.cells[2][i]) = (dda.cell.x, dda.cell.y, dda.cell.z);
                dda.advance();
            }
            chords.end[i] = dda.t;
        }
        count += 1;
    }
    *cells = dda;
    batch.get_mut(..count).unwrap_or(&mut [])
}

/// ∫ ρ dt until it is `target`.
pub struct Until {
    pub total: f64,
    pub target: f64,
}

impl Visitor for Until {
    fn constant(&mut self, density: f64, start: f64, end: f64) -> ControlFlow<f64> {
        let here = density * (end - start);
        if self.total + here >= self.target {
            return ControlFlow::Break((start + (self.target - self.total) / density).clamp(start, end));
        }
        self.total += here;
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn cells(&mut self, line: &LatticeLine, chords: &Chords) -> ControlFlow<f64> {
        let parts = chords.integrals(line);
        if !(self.total + parts.element_sum() >= self.target) {
            self.total += parts.element_sum();
            return ControlFlow::Continue(());
        }
        for (i, here) in parts.to_array().into_iter().enumerate() {
            if here > 0.0 && self.total + here >= self.target {
                return ControlFlow::Break(chords.solve(i, line, self.target - self.total, here));
            }
            self.total += here;
        }
        ControlFlow::Continue(())
    }
}

/// All integrals until that of ρ is `target`.
pub struct MomentsUntil {
    pub sum: Moments,
    pub target: f64,
}

impl MomentsUntil {
    #[inline(always)]
    fn add(&mut self, m: &Moments) {
        self.sum.integral += m.integral;
        self.sum.gradient += m.gradient;
        self.sum.first_moment += m.first_moment;
    }
}

impl Visitor for MomentsUntil {
    fn constant(&mut self, density: f64, start: f64, end: f64) -> ControlFlow<f64> {
        let mut until = Until { total: self.sum.integral, target: self.target };
        let flow = until.constant(density, start, end);
        self.sum.integral = if flow.is_break() { self.target } else { until.total };
        flow
    }

    #[inline(always)]
    fn cells(&mut self, line: &LatticeLine, chords: &Chords) -> ControlFlow<f64> {
        let whole = chords.moments(line, chords.end);
        if self.sum.integral + whole.integral >= self.target {
            let mut until = Until { total: self.sum.integral, target: self.target };
            if let ControlFlow::Break(t) = until.cells(line, chords) {
                // What lies beyond t has no length.
                self.add(&chords.moments(line, DVec2::splat(t).clamp(chords.start, chords.end)));
                return ControlFlow::Break(t);
            }
        }
        self.add(&whole);
        ControlFlow::Continue(())
    }
}
