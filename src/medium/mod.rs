//! Participating media: extinction is a constant colour times a scalar density, so one density integral serves all channels.

mod blocks;
mod bricks;
mod cell;
mod custom;
mod dda;
mod estimators;
mod exact;
mod grid;
mod milestones;
mod tracking;
mod walk;

pub use blocks::{BLOCK_SAMPLES, build_block_bricks};
pub use bricks::{BRICK_SIDE, Brick, brick_counts, build_bricks};
pub use custom::{Custom, DensityField, IntegratedField};
pub use estimators::{Estimate, Estimator, estimate_transmittance};
pub use grid::Grid;
pub use milestones::Milestones;
pub use tracking::{
    Collision, EdgeMoments, Flight, Line, NONE, Segment, collision_pdf, distance_number, moments, optical_depth,
    optical_depth_or_dark, sample_distance, sample_distance_with_moments,
};

use crate::math::{Colour, DVec3};
use crate::phase::Phase;

/// A medium: σ_t(x) = `sigma_t`·density(x), σ_s = albedo·σ_t.
#[derive(Clone, Copy, Debug)]
pub struct Medium<'a> {
    /// Extinction at density 1, 1/world unit.
    pub sigma_t: Colour,
    pub albedo: Colour,
    pub phase: Phase,
    pub density: Density<'a>,
}

impl Medium<'_> {
    pub fn sigma_t(&self, x: DVec3) -> Colour {
        self.sigma_t * self.density.at(x)
    }

    pub fn sigma_s(&self, x: DVec3) -> Colour {
        self.albedo * self.sigma_t(x)
    }

    /// ∇log σ_s = ∇ρ/ρ, away from faces; None where nothing scatters.
    pub fn log_sigma_s_gradient(&self, x: DVec3) -> Option<DVec3> {
        let (density, gradient) = self.density.with_gradient(x);
        (density > 0.0).then(|| gradient / density)
    }
}

/// The scalar density of a medium.
#[derive(Clone, Copy, Debug)]
pub enum Density<'a> {
    /// 1 everywhere.
    Homogeneous,
    Grid(Grid<'a>),
    Custom(Custom<'a>),
}

/// The stretch `origin + t·direction`, t ∈ [start, end], of a ray; `end` may be infinite.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    pub origin: DVec3,
    pub direction: DVec3,
    pub start: f64,
    pub end: f64,
}

/// Integrals of the density ρ along a stretch. The gradients are in the sense of distributions: where ρ jumps at a face they
/// include the jump, which is how a face moves optical depth when an endpoint moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// ∫ ρ dt
    pub integral: f64,
    /// ∫ ∇ρ dt
    pub gradient: DVec3,
    /// ∫ t ∇ρ dt
    pub first_moment: DVec3,
    /// ρ just after the start and just before the end.
    pub at_start: f64,
    pub at_end: f64,
}

/// The part of a stretch inside a density's box, and bounds of the density there.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    pub start: f64,
    pub end: f64,
    /// Normals, of any length, of the box's faces where the stretch enters and leaves it; None where the stretch itself begins or ends.
    pub entry: Option<DVec3>,
    pub exit: Option<DVec3>,
    /// ρ just after the start and just before the end.
    pub at_start: f64,
    pub at_end: f64,
    pub min: f64,
    pub max: f64,
}

/// Where an integral of the density is used up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inversion {
    /// ∫ ρ from the start to this distance is the target.
    At(f64),
    /// The whole stretch holds less: this much.
    Beyond(f64),
}

impl Density<'_> {
    pub fn at(&self, x: DVec3) -> f64 {
        match self {
            Self::Homogeneous => 1.0,
            Self::Grid(grid) => grid.at(x),
            Self::Custom(custom) => custom.at(x),
        }
    }

    /// Whether it is more than 0.
    pub fn is_positive(&self, x: DVec3) -> bool {
        match self {
            Self::Grid(grid) => grid.is_positive(x),
            _ => self.at(x) > 0.0,
        }
    }

    /// Whether it is certainly more than 0 at all points at most `reach` from `x` along each axis. False says nothing.
    pub fn is_surely_positive_around(&self, x: DVec3, reach: DVec3) -> bool {
        match self {
            Self::Homogeneous => true,
            Self::Grid(grid) => grid.is_surely_positive_around(x, reach),
            Self::Custom(_) => false,
        }
    }

    /// ∇ρ, away from faces.
    pub fn gradient(&self, x: DVec3) -> DVec3 {
        match self {
            Self::Custom(custom) => custom.gradient(x),
            _ => self.with_gradient(x).1,
        }
    }

    /// ρ and ∇ρ, away from faces.
    pub fn with_gradient(&self, x: DVec3) -> (f64, DVec3) {
        match self {
            Self::Homogeneous => (1.0, DVec3::ZERO),
            Self::Grid(grid) => grid.with_gradient(x),
            Self::Custom(custom) => (custom.at(x), custom.gradient(x)),
        }
    }

    /// The derivative of [`Density::integral`] at the distance `t`, which the density of a sampled distance is made of.
    pub fn along(&self, stretch: &Stretch, t: f64) -> f64 {
        match self {
            Self::Custom(custom) => custom.along(stretch, t),
            _ => self.at(stretch.origin + t * stretch.direction),
        }
    }

    /// ρ at the distance `t`, and [`Density::along`]: the same where integrals are exact.
    pub fn at_and_along(&self, stretch: &Stretch, t: f64) -> (f64, f64) {
        let density = self.at(stretch.origin + t * stretch.direction);
        match self {
            Self::Custom(custom) if !custom.is_exact() => (density, custom.along(stretch, t)),
            _ => (density, density),
        }
    }

    /// Where along the stretch the density can be other than 0. None: nowhere.
    pub fn extent(&self, stretch: &Stretch) -> Option<Extent> {
        match self {
            Self::Homogeneous => {
                let Stretch { start, end, .. } = *stretch;
                Some(Extent { start, end, entry: None, exit: None, at_start: 1.0, at_end: 1.0, min: 1.0, max: 1.0 })
            }
            Self::Grid(grid) => grid.extent(stretch),
            Self::Custom(custom) => custom.extent(stretch),
        }
    }

    pub fn integral(&self, stretch: &Stretch) -> f64 {
        match self {
            Self::Homogeneous => stretch.end - stretch.start,
            Self::Grid(grid) => grid.integral(stretch),
            Self::Custom(custom) => custom.integral(stretch),
        }
    }

    pub fn moments(&self, stretch: &Stretch) -> Moments {
        match self {
            Self::Homogeneous => {
                Moments { integral: stretch.end - stretch.start, at_start: 1.0, at_end: 1.0, ..Moments::default() }
            }
            Self::Grid(grid) => grid.moments(stretch),
            Self::Custom(custom) => custom.moments(stretch),
        }
    }

    /// The same as `invert`, and the moments up to where it ends.
    pub fn invert_with_moments(&self, stretch: &Stretch, target: f64) -> (Inversion, Moments) {
        match self {
            Self::Grid(grid) => grid.invert_with_moments(stretch, target),
            _ => {
                let found = self.invert(stretch, target);
                let end = if let Inversion::At(t) = found { t } else { stretch.end };
                (found, self.moments(&Stretch { end, ..*stretch }))
            }
        }
    }

    /// The distance at which ∫ ρ from the start reaches `target` ≥ 0.
    pub fn invert(&self, stretch: &Stretch, target: f64) -> Inversion {
        match self {
            Self::Homogeneous if target.is_finite() && stretch.start + target <= stretch.end => {
                Inversion::At(stretch.start + target)
            }
            Self::Homogeneous => Inversion::Beyond(stretch.end - stretch.start),
            Self::Grid(grid) => grid.invert(stretch, target),
            Self::Custom(custom) => custom.invert(stretch, target),
        }
    }
}
