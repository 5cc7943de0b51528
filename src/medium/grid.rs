//! A trilinear density grid with exact line integrals ("regular tracking").
//!
//! Along a ray the density of one cell is a cubic in t, and so is t·∇ρ: two-point Gauss–Legendre per cell is exact for every
//! integral here. Source: ARCHITECTURE.md, "Line integrals".

use super::bricks::{BRICK_SIDE, Brick, brick_counts};
use super::dda::{Dda, LatticeLine};
use super::{Extent, Inversion, Moments, Stretch};
use crate::math::{DAffine3, DMat3, DVec3, floor};
use core::ops::ControlFlow;

/// Samples at cell centres of a box, trilinear between them, constant in the outermost half cells, 0 outside the box.
///
/// In *lattice coordinates* sample i lies at i + 1, so that the unit cells [c, c+1), c = 0…n, tile the box [½, n + ½].
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    density: &'a [f32],
    bricks: &'a [Brick],
    size: [i32; 3],
    to_lattice: DAffine3,
    /// Takes gradients from lattice to world coordinates.
    gradient_to_world: DMat3,
}

/// Keeps indices within 32 bits, together with the bound on all samples.
const MAX_SIDE: i32 = 1 << 20;

/// Offset of the two Gauss–Legendre points from the middle of an interval, as a share of its half.
const GAUSS_2: f64 = 0.577_350_269_189_625_8;

impl<'a> Grid<'a> {
    /// `density` has size[0]·size[1]·size[2] values, x fastest; `bricks` as many as [`brick_counts`] says, or none.
    /// `local_to_world` maps the unit cube and is invertible. None if a count does not fit.
    pub fn new(density: &'a [f32], size: [i32; 3], local_to_world: DAffine3, bricks: &'a [Brick]) -> Option<Self> {
        if size.iter().any(|n| *n > MAX_SIDE) {
            return None;
        }
        let samples = size.iter().try_fold(1usize, |product, n| product.checked_mul(usize::try_from(*n).ok()?))?;
        let brick_count: usize = brick_counts(size).iter().map(|n| *n as usize).product();
        if samples == 0
            || samples > i32::MAX as usize
            || density.len() != samples
            || (!bricks.is_empty() && bricks.len() != brick_count)
        {
            return None;
        }
        let [nx, ny, nz] = size.map(f64::from);
        let scale = DAffine3::from_scale_rotation_translation(DVec3::new(nx, ny, nz), glam::DQuat::IDENTITY, DVec3::splat(0.5));
        let to_lattice = scale * local_to_world.inverse();
        Some(Self { density, bricks, size, to_lattice, gradient_to_world: to_lattice.matrix3.transpose() })
    }

    pub fn at(&self, x: DVec3) -> f64 {
        let p = self.to_lattice.transform_point3(x);
        if !self.holds(p) {
            return 0.0;
        }
        let cell = self.cell_of(p);
        self.corners(cell).value(p - corner(cell))
    }

    pub fn gradient(&self, x: DVec3) -> DVec3 {
        let p = self.to_lattice.transform_point3(x);
        if !self.holds(p) {
            return DVec3::ZERO;
        }
        let cell = self.cell_of(p);
        self.gradient_to_world * self.corners(cell).gradient(p - corner(cell))
    }

    pub fn integral(&self, stretch: &Stretch) -> f64 {
        let line = self.line(stretch);
        let Some(clip) = self.clip(&line, stretch) else { return 0.0 };
        let mut total = 0.0;
        let _ = self.walk(&line, &clip, |piece| {
            total += piece.integral(&line, piece.end);
            ControlFlow::<()>::Continue(())
        });
        total
    }

    pub fn invert(&self, stretch: &Stretch, target: f64) -> Inversion {
        let line = self.line(stretch);
        let Some(clip) = self.clip(&line, stretch) else { return Inversion::Beyond(0.0) };
        let mut total = 0.0;
        let found = self.walk(&line, &clip, |piece| {
            let here = piece.integral(&line, piece.end);
            if here > 0.0 && total + here >= target {
                return ControlFlow::Break(piece.solve(&line, target - total, here));
            }
            total += here;
            ControlFlow::Continue(())
        });
        match found {
            ControlFlow::Break(t) => Inversion::At(t),
            ControlFlow::Continue(()) => Inversion::Beyond(total),
        }
    }

    pub fn moments(&self, stretch: &Stretch) -> Moments {
        let line = self.line(stretch);
        let Some(clip) = self.clip(&line, stretch) else { return Moments::default() };
        let mut sum = Moments::default();
        let _ = self.walk(&line, &clip, |piece| {
            piece.add_moments(&line, &mut sum);
            ControlFlow::<()>::Continue(())
        });
        sum.gradient = self.gradient_to_world * sum.gradient;
        sum.first_moment = self.gradient_to_world * sum.first_moment;
        // The box's own faces, where ρ jumps from 0 and back, if the stretch crosses them.
        match clip.entry {
            Some(axis) => self.add_face(&mut sum, stretch, &line, clip.start, axis, 1.0),
            None => sum.at_start = self.value_on(&line, clip.start),
        }
        match clip.exit {
            Some(axis) => self.add_face(&mut sum, stretch, &line, clip.end, axis, -1.0),
            None => sum.at_end = self.value_on(&line, clip.end),
        }
        sum
    }

    /// The part of the stretch inside the box, with the bounds of all bricks on the way (of all samples, if there are no bricks).
    pub fn extent(&self, stretch: &Stretch) -> Option<Extent> {
        let line = self.line(stretch);
        let clip = self.clip(&line, stretch)?;
        let normal = |axis: usize| self.gradient_to_world.col(axis);
        let (mut min, mut max) = (f32::INFINITY, 0.0f32);
        if self.bricks.is_empty() {
            self.density.iter().for_each(|value| (min, max) = (min.min(*value), max.max(*value)));
        }
        let counts = brick_counts(self.size);
        for step in Dda::new(&line, counts, f64::from(BRICK_SIDE), clip.start, clip.end) {
            let [x, y, z] = step.cell;
            if let Some(brick) = self.bricks.get(((z * counts[1] + y) * counts[0] + x) as usize) {
                (min, max) = (min.min(brick.min), max.max(brick.max));
            }
        }
        Some(Extent {
            start: clip.start,
            end: clip.end,
            entry: clip.entry.map(normal),
            exit: clip.exit.map(normal),
            at_start: self.value_on(&line, clip.start),
            at_end: self.value_on(&line, clip.end),
            min: min.min(max).into(),
            max: max.into(),
        })
    }

    /// The jump of ρ by `sign`·ρ(t) at a face across `axis`: ∇ρ holds −(ρ_before − ρ_after) δ n/(n·direction).
    fn add_face(&self, sum: &mut Moments, stretch: &Stretch, line: &LatticeLine, t: f64, axis: usize, sign: f64) {
        let normal = self.gradient_to_world.col(axis);
        let jump = sign * self.value_on(line, t) * normal / normal.dot(stretch.direction);
        sum.gradient += jump;
        sum.first_moment += t * jump;
    }

    fn line(&self, stretch: &Stretch) -> LatticeLine {
        LatticeLine::new(self.to_lattice.transform_point3(stretch.origin), self.to_lattice.transform_vector3(stretch.direction))
    }

    /// ρ inside the box next to the line's point at `t`, which may lie on a face.
    fn value_on(&self, line: &LatticeLine, t: f64) -> f64 {
        let p = line.at(t);
        let cell = self.cell_of(p);
        self.corners(cell).value(p - corner(cell))
    }

    fn holds(&self, p: DVec3) -> bool {
        let [nx, ny, nz] = self.size.map(|n| f64::from(n) + 0.5);
        p.cmpge(DVec3::splat(0.5)).all() && p.cmple(DVec3::new(nx, ny, nz)).all()
    }

    /// The part of the stretch inside the box.
    fn clip(&self, line: &LatticeLine, stretch: &Stretch) -> Option<Clip> {
        let mut clip = Clip { start: stretch.start, end: stretch.end, entry: None, exit: None };
        for axis in 0..3 {
            let (low, high) = (0.5, f64::from(self.size[axis]) + 0.5);
            let (origin, direction) = (line.origin[axis], line.direction[axis]);
            if direction == 0.0 {
                if !(low..=high).contains(&origin) {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - origin) * line.inverse[axis], (high - origin) * line.inverse[axis]);
            let (near, far) = if a < b { (a, b) } else { (b, a) };
            if near > clip.start {
                (clip.start, clip.entry) = (near, Some(axis));
            }
            if far < clip.end {
                (clip.end, clip.exit) = (far, Some(axis));
            }
        }
        if clip.start < clip.end { Some(clip) } else { None }
    }

    /// Visits the pieces of the clipped line: constant bricks whole, others cell by cell.
    #[inline]
    fn walk<B>(&self, line: &LatticeLine, clip: &Clip, mut visit: impl FnMut(&Piece) -> ControlFlow<B>) -> ControlFlow<B> {
        let cells = self.size.map(|n| n + 1);
        if self.bricks.is_empty() {
            for step in Dda::new(line, cells, 1.0, clip.start, clip.end) {
                visit(&Piece { corners: self.corners(step.cell), cell: corner(step.cell), start: step.start, end: step.end })?;
            }
            return ControlFlow::Continue(());
        }
        let counts = brick_counts(self.size);
        for brick_step in Dda::new(line, counts, f64::from(BRICK_SIDE), clip.start, clip.end) {
            let [x, y, z] = brick_step.cell;
            let index = ((z * counts[1] + y) * counts[0] + x) as usize;
            match self.bricks.get(index) {
                Some(brick) if brick.max == 0.0 => {}
                Some(brick) if brick.min == brick.max => visit(&Piece {
                    corners: Corners::constant(brick.min),
                    cell: DVec3::ZERO,
                    start: brick_step.start,
                    end: brick_step.end,
                })?,
                _ => {
                    for step in Dda::new(line, cells, 1.0, brick_step.start, brick_step.end) {
                        visit(&Piece {
                            corners: self.corners(step.cell),
                            cell: corner(step.cell),
                            start: step.start,
                            end: step.end,
                        })?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    fn cell_of(&self, p: DVec3) -> [i32; 3] {
        core::array::from_fn(|axis| (floor(p[axis]) as i32).min(self.size[axis]).max(0))
    }

    /// The eight samples around a cell, those outside the box repeated from its border.
    #[inline]
    fn corners(&self, cell: [i32; 3]) -> Corners {
        let [nx, ny, nz] = self.size;
        let below = |c: i32| (c - 1).max(0) as usize;
        let above = |c: i32, n: i32| c.min(n - 1) as usize;
        let (x0, x1) = (below(cell[0]), above(cell[0], nx));
        let (y0, y1) = (below(cell[1]), above(cell[1], ny));
        let (z0, z1) = (below(cell[2]), above(cell[2], nz));
        let (row, plane) = (nx as usize, (nx * ny) as usize);
        let pair = |y: usize, z: usize| {
            let start = z * plane + y * row;
            [self.sample(start + x0), self.sample(start + x1)]
        };
        Corners([[pair(y0, z0), pair(y1, z0)], [pair(y0, z1), pair(y1, z1)]])
    }

    #[inline]
    fn sample(&self, index: usize) -> f64 {
        self.density.get(index).map_or(0.0, |value| f64::from(*value))
    }
}

/// A stretch clipped to the box, and the axes of the faces that clipped it.
struct Clip {
    start: f64,
    end: f64,
    entry: Option<usize>,
    exit: Option<usize>,
}

fn corner(cell: [i32; 3]) -> DVec3 {
    DVec3::new(f64::from(cell[0]), f64::from(cell[1]), f64::from(cell[2]))
}

/// Corner densities of a cell, indexed [z][y][x].
struct Corners([[[f64; 2]; 2]; 2]);

impl Corners {
    fn constant(value: f32) -> Self {
        Self([[[f64::from(value); 2]; 2]; 2])
    }

    #[inline]
    fn value(&self, f: DVec3) -> f64 {
        let c = &self.0;
        let edge = |z: usize, y: usize| c[z][y][0] + f.x * (c[z][y][1] - c[z][y][0]);
        let face = |z: usize| edge(z, 0) + f.y * (edge(z, 1) - edge(z, 0));
        face(0) + f.z * (face(1) - face(0))
    }

    #[inline]
    fn gradient(&self, f: DVec3) -> DVec3 {
        let c = &self.0;
        let edge = |z: usize, y: usize| c[z][y][0] + f.x * (c[z][y][1] - c[z][y][0]);
        let slope_x = |z: usize, y: usize| c[z][y][1] - c[z][y][0];
        let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
        let face = |z: usize| mix(edge(z, 0), edge(z, 1), f.y);
        DVec3::new(
            mix(mix(slope_x(0, 0), slope_x(0, 1), f.y), mix(slope_x(1, 0), slope_x(1, 1), f.y), f.z),
            mix(edge(0, 1) - edge(0, 0), edge(1, 1) - edge(1, 0), f.z),
            face(1) - face(0),
        )
    }
}

/// A stretch of the line inside one cell (or one constant brick).
struct Piece {
    corners: Corners,
    /// Lattice coordinates of the cell's low corner.
    cell: DVec3,
    start: f64,
    end: f64,
}

impl Piece {
    /// The two Gauss–Legendre points of [start, end].
    #[inline]
    fn gauss(&self, end: f64) -> (f64, f64, f64) {
        let (middle, half) = (0.5 * (self.start + end), 0.5 * (end - self.start));
        (middle - GAUSS_2 * half, middle + GAUSS_2 * half, half)
    }

    #[inline]
    fn value(&self, line: &LatticeLine, t: f64) -> f64 {
        self.corners.value(line.at(t) - self.cell)
    }

    /// ∫ ρ dt from the piece's start to `end`.
    #[inline]
    fn integral(&self, line: &LatticeLine, end: f64) -> f64 {
        let (a, b, half) = self.gauss(end);
        half * (self.value(line, a) + self.value(line, b))
    }

    /// Adds the integrals, gradients in lattice coordinates.
    #[inline]
    fn add_moments(&self, line: &LatticeLine, sum: &mut Moments) {
        let (a, b, half) = self.gauss(self.end);
        let (at_a, at_b) = (line.at(a) - self.cell, line.at(b) - self.cell);
        let (gradient_a, gradient_b) = (self.corners.gradient(at_a), self.corners.gradient(at_b));
        sum.integral += half * (self.corners.value(at_a) + self.corners.value(at_b));
        sum.gradient += half * (gradient_a + gradient_b);
        sum.first_moment += half * (a * gradient_a + b * gradient_b);
    }

    /// The t at which ∫ ρ from the start is `target`, given that the whole piece holds `total` ≥ target: bracketed Newton.
    fn solve(&self, line: &LatticeLine, target: f64, total: f64) -> f64 {
        let (mut low, mut high) = (self.start, self.end);
        let mut t = if total > 0.0 { low + (high - low) * (target / total) } else { low };
        // Newton converges quadratically; halving alone would take 53 rounds to exhaust the bracket.
        for _ in 0..64 {
            let error = self.integral(line, t) - target;
            if error > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - error / self.value(line, t);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if next == t || (next - t).abs() <= 4.0 * f64::EPSILON * t.abs() {
                return next;
            }
            t = next;
        }
        t
    }
}
