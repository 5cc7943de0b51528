//! A run of consecutive medium vertices that moves rigidly, between a neighbour before it and one after it that stay.

use super::super::joint::{Joint, Leg};
use super::super::{Node, Path, PathError, PathErrorKind};
use super::LogGradient;
use super::end::End;
use super::neighbour::known;
use crate::math::DVec3;
use crate::medium::{Medium, moments};
use crate::scene::Scene;

/// Vertices `first` to `last` of a path, all in media.
pub struct Run<'s> {
    pub first: usize,
    pub last: usize,
    /// Towards the camera and towards the light.
    borders: [Border<'s>; 2],
}

/// Where a run ends.
struct Border<'s> {
    /// Its outermost vertex there, and the neighbour beyond. Medium vertices have both neighbours.
    x: Joint<'s>,
    q: Joint<'s>,
    /// Between them, away from the camera.
    leg: Leg,
}

/// Which end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// Towards the camera.
    Previous,
    /// Towards the light.
    Next,
}

impl Side {
    pub fn other(self) -> Self {
        match self {
            Self::Previous => Self::Next,
            Self::Next => Self::Previous,
        }
    }
}

fn medium<'s>(node: &Node<'s>, i: usize) -> Result<&'s Medium<'s>, PathError> {
    match *node {
        Node::Medium(medium) => Ok(medium),
        _ => Err(PathErrorKind::NotMovable.at(i)),
    }
}

impl<'s> Run<'s> {
    pub fn new(scene: &'s Scene<'s>, path: &Path<'s>, first: usize, count: usize) -> Result<Self, PathError> {
        let after = first.checked_add(count).filter(|_| count > 0).ok_or(PathErrorKind::BadIndex.at(first))?;
        (first..after).try_for_each(|i| medium(&path.node(scene, i)?, i).map(drop))?;
        let joint = |i| Joint::new(scene, path, i);
        let last = after - 1;
        let [before, from, to, beyond] = [joint(first - 1)?, joint(first)?, joint(last)?, joint(after)?];
        let borders = [
            Border { leg: before.leg_to(&from, first - 1)?, x: from, q: before },
            Border { leg: to.leg_to(&beyond, last)?, x: to, q: beyond },
        ];
        Ok(Self { first, last, borders })
    }

    fn border(&self, side: Side) -> &Border<'s> {
        let [previous, next] = &self.borders;
        match side {
            Side::Previous => previous,
            Side::Next => next,
        }
    }

    /// The number of its outermost vertex on that side, and of the neighbour beyond it.
    pub fn outermost(&self, side: Side) -> (usize, usize) {
        match side {
            Side::Previous => (self.first, self.first - 1),
            Side::Next => (self.last, self.last + 1),
        }
    }

    /// Whether the neighbour on that side is specular.
    pub fn is_beside_specular(&self, side: Side) -> bool {
        self.border(side).q.node.is_specular()
    }

    /// Unit vector from the run to its neighbour on that side.
    pub fn outwards(&self, side: Side) -> DVec3 {
        let direction = self.border(side).leg.direction;
        match side {
            Side::Previous => -direction,
            Side::Next => direction,
        }
    }

    /// Vertex `i` of it, counted in the path.
    fn vertex(&self, scene: &'s Scene<'s>, path: &Path, i: usize) -> Result<Joint<'s>, PathError> {
        let [previous, next] = &self.borders;
        if i == self.first {
            Ok(previous.x)
        } else if i == self.last {
            Ok(next.x)
        } else {
            Joint::new(scene, path, i)
        }
    }

    /// Adds ∇log of what changes at an end whose neighbour is not specular.
    pub fn add_end(&self, scene: &'s Scene<'s>, path: &Path<'s>, side: Side, sum: &mut LogGradient) -> Result<(), PathError> {
        let (i, q_number) = self.outermost(side);
        let Border { x, q, leg } = self.border(side);
        let from = if q_number < i { q } else { x };
        let inwards = side.other();
        let end = End {
            side,
            phase: known(medium(&x.node, i)?.phase, i)?,
            onwards: if self.first == self.last { self.outwards(inwards) } else { towards(scene, path, i, inwards)? },
            q,
            q_number,
            outwards: self.outwards(side),
            q_onwards: towards(scene, path, q_number, side)?,
        };
        end.add_to(sum, &from.line(scene, path, i.min(q_number), leg)?)
    }

    /// Adds what changes at an end with a specular neighbour q when the run moves along the edge between them: nothing but the edge's
    /// length. The chain beyond q stays, and has no G.
    pub fn add_specular_end(&self, side: Side, sum: &mut LogGradient) -> Result<(), PathError> {
        let x = &self.border(side).x;
        let sigma_t = medium(&x.node, self.outermost(side).0)?.sigma_t(x.position);
        let outwards = self.outwards(side);
        let transmittance = core::array::from_fn(|c| sigma_t[c] * outwards);
        match side {
            Side::Previous => sum.transmittance_previous = transmittance,
            Side::Next => sum.transmittance_next = transmittance,
        }
        Ok(())
    }

    /// Adds ∇log of what changes between the ends: σ_s at every vertex, and Tr of every edge inside.
    pub fn add_inside(&self, scene: &Scene, path: &Path, sum: &mut LogGradient) -> Result<(), PathError> {
        for i in self.first..=self.last {
            let x = self.vertex(scene, path, i)?;
            let gradient = medium(&x.node, i)?.log_sigma_s_gradient(x.position);
            sum.scattering += gradient.ok_or(PathErrorKind::ZeroContribution.at(i))?;
        }
        for i in self.first..self.last {
            // The whole edge moves: ∇τ = ∫ ∇σ_t dt.
            let gradient = moments(&path.edge(scene, i)?).gradient;
            sum.transmittance_inside = core::array::from_fn(|c| sum.transmittance_inside[c] - gradient[c]);
        }
        Ok(())
    }
}

/// Unit vector from vertex `i` to its neighbour on that side, if there is one.
fn towards(scene: &Scene, path: &Path, i: usize, side: Side) -> Result<DVec3, PathError> {
    let leg = |i: usize| Joint::new(scene, path, i)?.leg_to(&Joint::new(scene, path, i + 1)?, i);
    Ok(match side {
        Side::Previous if i == 0 => DVec3::ZERO,
        Side::Previous => -leg(i - 1)?.direction,
        Side::Next if i + 1 == path.vertices.len() => DVec3::ZERO,
        Side::Next => leg(i)?.direction,
    })
}
