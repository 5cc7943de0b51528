//! A trilinear density grid with exact line integrals ("regular tracking").
//! Source: ARCHITECTURE.md, "Line integrals".

use super::bricks::{Brick, brick_counts};
use super::cell::Expansion;
use super::dda::LatticeLine;
use super::milestones::{Milestones, Survey};
use super::walk::{Inside, MomentsUntil, Samples, Until};
use super::{Extent, Inversion, Moments, Stretch};
use crate::math::{DAffine3, DMat3, DVec2, DVec3};
use core::ops::ControlFlow;

/// Samples at cell centres of a box, trilinear between them, constant in the outermost half cells, 0 outside the box.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    samples: Samples<'a>,
    to_lattice: DAffine3,
    /// Takes gradients from lattice to world coordinates.
    gradient_to_world: DMat3,
}

/// Keeps indices within 32 bits, together with the bound on all samples.
const MAX_SIDE: i32 = 1 << 20;

/// Whether `length` values are one for each of `counts`, in 32 bits, of a grid of this size.
fn fits(size: [i32; 3], counts: [i32; 3], length: usize) -> bool {
    let product = counts.iter().try_fold(1usize, |product, n| product.checked_mul(usize::try_from(*n).ok()?));
    size.iter().all(|n| (1..=MAX_SIDE).contains(n)) && length <= i32::MAX as usize && product == Some(length)
}

impl<'a> Grid<'a> {
    /// `density` has size[0]·size[1]·size[2] values, x fastest; `bricks` as many as [`brick_counts`] says, or none.
    /// `local_to_world` maps the unit cube and is invertible. None if a count does not fit.
    pub fn new(density: &'a [f32], size: [i32; 3], local_to_world: DAffine3, bricks: &'a [Brick]) -> Option<Self> {
        let fits = fits(size, size, density.len()) && (bricks.is_empty() || fits(size, brick_counts(size), bricks.len()));
        fits.then(|| Self::on(Samples::new(density, &[], size, bricks), local_to_world))
    }

    /// The same with samples in blocks: `blocks` has the number of each brick's, and `density` [`BLOCK_SAMPLES`] values for each, those
    /// outside the box repeated from its border. `bricks` are those of [`build_block_bricks`].
    ///
    /// [`BLOCK_SAMPLES`]: super::BLOCK_SAMPLES
    /// [`build_block_bricks`]: super::build_block_bricks
    pub fn of_blocks(
        density: &'a [f32],
        blocks: &'a [u32],
        size: [i32; 3],
        local_to_world: DAffine3,
        bricks: &'a [Brick],
    ) -> Option<Self> {
        let fits = fits(size, brick_counts(size), blocks.len()) && bricks.len() == blocks.len();
        fits.then(|| Self::on(Samples::new(density, blocks, size, bricks), local_to_world))
    }

    fn on(samples: Samples<'a>, local_to_world: DAffine3) -> Self {
        let size = samples.size;
        let [nx, ny, nz] = size.map(f64::from);
        let scale = DAffine3::from_scale_rotation_translation(DVec3::new(nx, ny, nz), glam::DQuat::IDENTITY, DVec3::splat(0.5));
        let to_lattice = scale * local_to_world.inverse();
        Self { samples, to_lattice, gradient_to_world: to_lattice.matrix3.transpose() }
    }

    pub fn at(&self, x: DVec3) -> f64 {
        let p = self.to_lattice.transform_point3(x);
        if self.holds(p) { self.value_at(p) } else { 0.0 }
    }

    /// The same as `at(x) > 0`. A brick's bounds say so for most.
    pub fn is_positive(&self, x: DVec3) -> bool {
        let p = self.to_lattice.transform_point3(x);
        self.holds(p)
            && match self.samples.brick(cell_of(p)) {
                Some(brick) if brick.min > 0.0 || brick.max == 0.0 => brick.min > 0.0,
                _ => self.value_at(p) > 0.0,
            }
    }

    /// Whether the bricks say that it is more than 0 at all points at most `reach` from `x` along each axis.
    pub fn is_surely_positive_around(&self, x: DVec3, reach: DVec3) -> bool {
        let p = self.to_lattice.transform_point3(x);
        let matrix = self.to_lattice.matrix3;
        let reach = matrix.x_axis.abs() * reach.x + matrix.y_axis.abs() * reach.y + matrix.z_axis.abs() * reach.z;
        let (low, high) = (p - reach, p + reach);
        self.holds(low) && self.holds(high) && self.samples.is_positive_between(cell_of(low), cell_of(high))
    }

    /// ρ and ∇ρ.
    pub fn with_gradient(&self, x: DVec3) -> (f64, DVec3) {
        let p = self.to_lattice.transform_point3(x);
        if !self.holds(p) {
            return (0.0, DVec3::ZERO);
        }
        let e = self.expand(p);
        (e.value.x, self.gradient_to_world * DVec3::new(e.x.x, e.y.x, e.z.x))
    }

    pub fn integral(&self, stretch: &Stretch) -> f64 {
        match self.invert(stretch, f64::INFINITY) {
            Inversion::Beyond(total) => total,
            // Not for finite samples.
            Inversion::At(_) => f64::INFINITY,
        }
    }

    /// The same; milestones are set along what is inside the box.
    pub fn integral_with_milestones(&self, stretch: &Stretch, milestones: &mut Milestones) -> f64 {
        let line = self.line(stretch);
        let Some(clip) = self.clip(&line, stretch) else { return 0.0 };
        let mut survey = Survey::new(milestones, clip.inside.start, clip.inside.end);
        let _ = self.samples.walk(&line, &clip.inside, &mut survey);
        survey.total.max(0.0)
    }

    pub fn invert(&self, stretch: &Stretch, target: f64) -> Inversion {
        let line = self.line(stretch);
        let Some(clip) = self.clip(&line, stretch) else { return Inversion::Beyond(0.0) };
        let mut sum = Until { total: 0.0, target };
        match self.samples.walk(&line, &clip.inside, &mut sum) {
            ControlFlow::Break(t) => Inversion::At(t),
            // Rounding takes some 1e-16 of the largest sample off where the density is 0.
            ControlFlow::Continue(()) => Inversion::Beyond(sum.total.max(0.0)),
        }
    }

    /// The same as `invert`, and the moments up to where it ends.
    pub fn invert_with_moments(&self, stretch: &Stretch, target: f64) -> (Inversion, Moments) {
        let line = self.line(stretch);
        let Some(clip) = self.clip(&line, stretch) else { return (Inversion::Beyond(0.0), Moments::default()) };
        let mut until = MomentsUntil { sum: Moments::default(), target };
        let found = self.samples.walk(&line, &clip.inside, &mut until);
        let mut sum = until.sum;
        sum.integral = sum.integral.max(0.0);
        sum.gradient = self.gradient_to_world * sum.gradient;
        sum.first_moment = self.gradient_to_world * sum.first_moment;
        // The box's own faces, where ρ jumps from 0 and back, if the stretch crosses them.
        match clip.entry {
            Some(axis) => self.add_face(&mut sum, stretch, &line, clip.inside.start, axis, 1.0),
            None => sum.at_start = self.value_at(line.at(clip.inside.start)),
        }
        match (found, clip.exit) {
            (ControlFlow::Break(t), _) => sum.at_end = self.value_at(line.at(t)),
            (_, Some(axis)) => self.add_face(&mut sum, stretch, &line, clip.inside.end, axis, -1.0),
            (_, None) => sum.at_end = self.value_at(line.at(clip.inside.end)),
        }
        match found {
            ControlFlow::Break(t) => (Inversion::At(t), sum),
            ControlFlow::Continue(()) => (Inversion::Beyond(sum.integral), sum),
        }
    }

    pub fn moments(&self, stretch: &Stretch) -> Moments {
        self.invert_with_moments(stretch, f64::INFINITY).1
    }

    /// The part of the stretch inside the box, with the bounds of all bricks on the way (of all samples, if there are no bricks).
    pub fn extent(&self, stretch: &Stretch) -> Option<Extent> {
        let line = self.line(stretch);
        let clip = self.clip(&line, stretch)?;
        let normal = |axis| self.normal(axis);
        let bounds = self.samples.bounds(&line, &clip.inside);
        Some(Extent {
            start: clip.inside.start,
            end: clip.inside.end,
            entry: clip.entry.map(normal),
            exit: clip.exit.map(normal),
            at_start: self.value_at(line.at(clip.inside.start)),
            at_end: self.value_at(line.at(clip.inside.end)),
            min: bounds.min.into(),
            max: bounds.max.into(),
        })
    }

    /// The jump of ρ by `sign`·ρ(t) at a face across `axis`: ∇ρ holds −(ρ_before − ρ_after) δ n/(n·direction).
    fn add_face(&self, sum: &mut Moments, stretch: &Stretch, line: &LatticeLine, t: f64, axis: usize, sign: f64) {
        let normal = self.normal(axis);
        let jump = sign * self.value_at(line.at(t)) * normal / normal.dot(stretch.direction);
        sum.gradient += jump;
        sum.first_moment += t * jump;
    }

    /// A normal of the faces across `axis`, of any length.
    fn normal(&self, axis: usize) -> DVec3 {
        let DMat3 { x_axis, y_axis, z_axis } = self.gradient_to_world;
        [x_axis, y_axis].get(axis).copied().unwrap_or(z_axis)
    }

    fn line(&self, stretch: &Stretch) -> LatticeLine {
        LatticeLine::new(self.to_lattice.transform_point3(stretch.origin), self.to_lattice.transform_vector3(stretch.direction))
    }

    /// ρ at a point inside the box, or on a face of it.
    fn value_at(&self, p: DVec3) -> f64 {
        self.expand(p).value.x
    }

    /// ρ around a point inside the box, in lattice coordinates.
    #[inline(always)]
    fn expand(&self, p: DVec3) -> Expansion {
        let cell: [i32; 3] = core::array::from_fn(|axis| (cell_of(p)[axis] as i32).min(self.samples.size[axis]));
        let point = p - DVec3::from_array(cell.map(f64::from));
        Expansion::new(&self.samples.corners(cell).map(|pair| [pair; 2]), point.to_array().map(DVec2::splat))
    }

    /// The faces of the box in lattice coordinates.
    fn faces(&self) -> (DVec3, DVec3) {
        (DVec3::splat(0.5), DVec3::from_array(self.samples.size.map(f64::from)) + 0.5)
    }

    fn holds(&self, p: DVec3) -> bool {
        let (low, high) = self.faces();
        p.cmpge(low).all() && p.cmple(high).all()
    }

    /// The part of the stretch inside the box.
    fn clip(&self, line: &LatticeLine, stretch: &Stretch) -> Option<Clip> {
        let (low, high) = self.faces();
        let (a, b) = (line.crossings(low), line.crossings(high));
        let mut inside = Inside { start: stretch.start, end: stretch.end };
        let (mut entry, mut exit) = (None, None);
        for axis in 0..3 {
            if line.is_parallel(axis) {
                if !(low[axis]..=high[axis]).contains(&line.origin[axis]) {
                    return None;
                }
                continue;
            }
            let (near, far) = if a[axis] < b[axis] { (a[axis], b[axis]) } else { (b[axis], a[axis]) };
            if near > inside.start {
                (inside.start, entry) = (near, Some(axis));
            }
            if far < inside.end {
                (inside.end, exit) = (far, Some(axis));
            }
        }
        let walkable = inside.start < inside.end && line.resolves(inside.start) && line.resolves(inside.end);
        walkable.then_some(Clip { inside, entry, exit })
    }
}

/// The cell around a point inside the box. No coordinate is negative there: cutting off rounds down.
fn cell_of(p: DVec3) -> [u32; 3] {
    p.to_array().map(|coordinate| coordinate as u32)
}

/// A stretch clipped to the box, and the axes of the faces that clipped it.
struct Clip {
    inside: Inside,
    entry: Option<usize>,
    exit: Option<usize>,
}
