//! What changes at the two ends of a run that moves: the edge to a neighbour that stays, and the phase functions on both sides of it.

use super::LogGradient;
use super::neighbour::{Beyond, Neighbour, Seen};
use super::run::Side;
use crate::math::DVec3;
use crate::medium::{Line, moments};
use crate::phase::{Phase, cosine_gradient_wing};
use crate::scene::Camera;

/// One end of a run: its outermost vertex x, and the neighbour q beyond it.
pub struct End<'a> {
    pub side: Side,
    pub x: DVec3,
    pub phase: Phase,
    /// Unit vector from x to its other neighbour, be it in the run or beyond it.
    pub onwards: DVec3,
    pub beyond: Beyond,
    /// Between x and q, away from the camera.
    pub line: Line<'a>,
}

/// ∇log of the factors that an end changes.
#[derive(Clone, Copy, Default)]
pub struct EndGradient {
    pub transmittance: [DVec3; 3],
    pub geometry: DVec3,
    pub importance: DVec3,
    /// f_p, or f_r or the emission, at q.
    pub wing: DVec3,
    pub profile: [DVec3; 3],
    /// f_p at x, as far as it changes with the direction to q.
    pub apex: DVec3,
}

impl End<'_> {
    pub fn log_gradient(&self, camera: &Camera) -> EndGradient {
        let Beyond { neighbour, wing, profile } = &self.beyond;
        let seen = Seen::from(camera, self.x, *neighbour);
        let c = seen.towards.dot(self.onwards);
        let moments = moments(&self.line);
        let optical_depth = match self.side {
            Side::Previous => moments.far_gradient(self.line.direction, self.line.length),
            Side::Next => moments.near_gradient(self.line.direction, self.line.length),
        };
        EndGradient {
            transmittance: optical_depth.map(|g| -g),
            geometry: seen.geometry_gradient(),
            importance: match neighbour {
                Neighbour::Camera => seen.importance_gradient(camera),
                _ => DVec3::ZERO,
            },
            wing: wing.map_or(DVec3::ZERO, |wing| seen.wing_gradient(&wing)),
            profile: profile.map(|by_direction| seen.direction_gradient(by_direction)),
            // Moving the apex x is moving its wing q the other way. Differs from [Lu20 (25)], whose sign is that of the wings.
            apex: -self.phase.log_derivative(c) * cosine_gradient_wing(seen.towards, self.onwards, c, seen.distance),
        }
    }
}

impl LogGradient {
    /// What changes at both ends, and nothing else yet.
    pub(super) fn of_ends([previous, next]: [EndGradient; 2]) -> Self {
        Self {
            transmittance_previous: previous.transmittance,
            transmittance_next: next.transmittance,
            geometry_previous: previous.geometry,
            geometry_next: next.geometry,
            importance: previous.importance,
            phase_previous: previous.wing,
            phase_apex: previous.apex + next.apex,
            phase_next: next.wing,
            profile_previous: previous.profile,
            profile_next: next.profile,
            ..Self::default()
        }
    }
}
