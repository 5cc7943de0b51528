//! Estimates of a line's transmittance and of its gradients at both ends, by [`ratio_tracking`] or [`ray_marching`].
//!
//! For hosts that integrate media in these ways, and as independent truth for tests: the sampler's own τ is deterministic.
//! Sources: [NSJ14] for the trackers, [JDZJ08] for marching and its gradient; [Lu20 (20), (21)] corrected, see each file.

mod ratio_tracking;
mod ray_marching;

use super::{Extent, Line, Medium};
use crate::math::{Colour, DVec3};
use core::mem::replace;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// Unbiased. Collisions with the greatest density on the way as majorant.
    RatioTracking,
    /// Unbiased. The least density on the way counts in closed form, and collisions only for what is above it.
    ResidualRatioTracking,
    /// Biased. `steps` points in each medium on the way, in the middles of equal steps, or all at the same random place in theirs.
    RayMarching { steps: u32, jitter: bool },
}

/// A line's transmittance and its gradients, per colour channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Estimate {
    pub transmittance: Colour,
    /// With respect to the line's origin; its far end stays, or the direction if it is infinite.
    pub near_gradient: [DVec3; 3],
    /// With respect to the far end; 0 for an infinite line.
    pub far_gradient: [DVec3; 3],
    /// Points at which a density was computed.
    pub evaluations: u32,
}

/// More evaluations than this are expected of no estimate.
const MAX_EVALUATIONS: f64 = 1e6;

/// One estimate from uniform numbers in (0, 1). None if it takes more than [`MAX_EVALUATIONS`].
pub fn estimate_transmittance(line: &Line, estimator: Estimator, random: impl FnMut() -> f64) -> Option<Estimate> {
    match estimator {
        Estimator::RatioTracking => ratio_tracking::estimate(line, false, random),
        Estimator::ResidualRatioTracking => ratio_tracking::estimate(line, true, random),
        Estimator::RayMarching { steps, jitter } => ray_marching::estimate(line, steps, jitter, random),
    }
}

/// A medium that a line passes: where, and what is at either end of that.
struct Crossing<'a> {
    medium: &'a Medium<'a>,
    extent: Extent,
    borders: [Border; 2],
}

/// What ends a medium along a line.
#[derive(Clone, Copy)]
enum Border {
    /// The line's own origin or far end.
    Origin,
    End,
    /// A null surface, the near plane, or a box, of this normal.
    Face(DVec3),
}

fn crossings<'a>(line: &Line<'a>) -> impl Iterator<Item = Crossing<'a>> {
    let line = *line;
    let mut next = if line.start > 0.0 { Border::Face(line.start_normal) } else { Border::Origin };
    line.stretches().filter_map(move |(stretch, segment)| {
        let exit = if stretch.end == line.length { Border::End } else { Border::Face(segment.normal.wide()) };
        let entry = replace(&mut next, exit);
        let medium = line.medium(segment.medium)?;
        let extent = medium.density.extent(&stretch)?;
        let borders = [extent.entry.map_or(entry, Border::Face), extent.exit.map_or(exit, Border::Face)];
        Some(Crossing { medium, extent, borders })
    })
}

/// The part of a vector across a unit direction.
fn across(direction: DVec3, v: DVec3) -> DVec3 {
    v - v.dot(direction) * direction
}
