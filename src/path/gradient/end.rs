//! What changes at the two ends of a run that moves: the edge to a neighbour that stays, and the phase functions on both sides of it.

use super::super::joint::Joint;
use super::super::{Node, PathError, PathErrorKind};
use super::LogGradient;
use super::neighbour::{Seen, Wing, known};
use super::run::Side;
use crate::math::DVec3;
use crate::medium::{Line, moments};
use crate::phase::{Phase, cosine_gradient_wing};

/// One end of a run: its outermost vertex x, and the neighbour q beyond it.
pub struct End<'a> {
    pub side: Side,
    pub phase: Phase,
    /// Unit vector from x to its other neighbour, be it in the run or beyond it.
    pub onwards: DVec3,
    pub q: &'a Joint<'a>,
    /// Its number in the path.
    pub q_number: usize,
    /// Unit vector from x to q.
    pub outwards: DVec3,
    /// Unit vector from q to its other neighbour; of no meaning at the ends of a path.
    pub q_onwards: DVec3,
}

impl End<'_> {
    /// Adds ∇log of the factors that this end changes. `line` is between x and q, away from the camera.
    pub fn add_to(&self, sum: &mut LogGradient, line: &Line) -> Result<(), PathError> {
        let seen = Seen::joint(self.q, self.outwards, line.length);
        let c = seen.towards.dot(self.onwards);
        // Moving the apex x is moving its wing q the other way. Differs from [Lu20 (25)], whose sign is that of the wings.
        sum.phase_apex -= self.phase.log_derivative(c) * cosine_gradient_wing(seen.towards, self.onwards, c, seen.distance);
        let (moments, direction, length) = (moments(line), line.direction, line.length);
        match self.side {
            Side::Previous => {
                sum.transmittance_previous = moments.far_gradient(direction, length).map(|g| -g);
                sum.geometry_previous = seen.geometry_gradient();
            }
            Side::Next => {
                sum.transmittance_next = moments.near_gradient(direction, length).map(|g| -g);
                sum.geometry_next = seen.geometry_gradient();
            }
        }
        self.add_neighbour(&seen, sum)
    }

    /// What q makes of the direction in which it sees x.
    fn add_neighbour(&self, seen: &Seen, sum: &mut LogGradient) -> Result<(), PathError> {
        let (wing, profile) = match self.side {
            Side::Previous => (&mut sum.phase_previous, &mut sum.profile_previous),
            Side::Next => (&mut sum.phase_next, &mut sum.profile_next),
        };
        let (at, to_x) = (self.q.surface(), -seen.towards);
        let by_direction = match self.q.node {
            Node::Camera(camera) => {
                sum.importance = seen.importance_gradient(camera);
                return Ok(());
            }
            Node::Medium(medium) => {
                *wing = seen.wing_gradient(&Wing { phase: known(medium.phase, self.q_number)?, to_other: self.q_onwards });
                return Ok(());
            }
            node if node.is_direction() => return Ok(()),
            Node::Surface(bsdf) => match self.side {
                Side::Previous => bsdf.log_gradient(&at, self.q_onwards, to_x).map(|(_, by_light)| by_light),
                Side::Next => bsdf.log_gradient(&at, to_x, self.q_onwards).map(|(by_camera, _)| by_camera),
            },
            Node::Light(light) => light.log_gradient(to_x),
        };
        let by_direction = by_direction.ok_or(PathErrorKind::NoGradient.at(self.q_number))?;
        *profile = by_direction.map(|by_direction| seen.direction_gradient(by_direction));
        Ok(())
    }
}
