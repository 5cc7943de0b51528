//! The vertices next to those that move: they stay, but G, W_e and f_p depend on how they are seen.

use super::super::joint::Joint;
use super::super::{Node, PathError, PathErrorKind};
use crate::math::DVec3;
use crate::phase::{Phase, cosine_gradient_wing};
use crate::scene::Camera;

/// A neighbour of the moving vertex, as far as the gradient depends on it.
#[derive(Clone, Copy, Debug)]
pub enum Neighbour {
    /// The camera, at x_0.
    Camera,
    /// A point, with its normal if the geometry term has a cosine there.
    Point { position: DVec3, normal: Option<DVec3> },
    /// Infinitely far away: this unit direction is kept.
    Direction(DVec3),
}

/// A phase function at a neighbour, whose angle changes when the vertex moves.
#[derive(Clone, Copy, Debug)]
pub struct Wing {
    pub phase: Phase,
    /// Unit vector from the neighbour to its own other neighbour.
    pub to_other: DVec3,
}

/// A neighbour q seen from x.
pub struct Seen {
    /// Unit vector from x to q.
    pub towards: DVec3,
    /// Infinite for a direction.
    pub distance: f64,
    normal: Option<DVec3>,
}

impl Seen {
    pub fn from(camera: &Camera, x: DVec3, neighbour: Neighbour) -> Self {
        let (position, normal) = match neighbour {
            Neighbour::Camera => (camera.position, Some(camera.forward)),
            Neighbour::Point { position, normal } => (position, normal),
            Neighbour::Direction(towards) => return Self { towards, distance: f64::INFINITY, normal: None },
        };
        let distance = (position - x).length();
        Self { towards: (position - x) / distance, distance, normal }
    }

    /// A neighbour in a path, in the unit direction `towards` from x.
    pub fn joint(q: &Joint, towards: DVec3, distance: f64) -> Self {
        let normal = match q.node {
            Node::Camera(camera) => Some(camera.forward),
            node => node.has_cosine().then_some(q.normal),
        };
        Self { towards, distance, normal }
    }

    /// ∇log of |cos|/d²: n/(n·v) − v/d² and −2v/d², v = x − q.
    pub fn geometry_gradient(&self) -> DVec3 {
        if self.distance.is_infinite() {
            return DVec3::ZERO;
        }
        let inverse_square = 2.0 * self.towards / self.distance;
        inverse_square + self.normal.map_or(DVec3::ZERO, |n| self.cosine_gradient(n))
    }

    /// ∇log of the cosine to the normal n at q.
    pub fn cosine_gradient(&self, n: DVec3) -> DVec3 {
        let v = -self.towards;
        (n / n.dot(v) - v) / self.distance
    }

    /// ∇log We seen from the camera: cos⁻⁴, as its own cosine in G is counted there. [Lu20 (38)] has −1/cosθ instead.
    pub fn importance_gradient(&self, camera: &Camera) -> DVec3 {
        -4.0 * self.cosine_gradient(camera.forward)
    }

    /// The gradient by x of something whose gradient by the unit vector ω from q to x is `by_direction`: (I − ωωᵀ)/d · ∂/∂ω.
    pub fn direction_gradient(&self, by_direction: DVec3) -> DVec3 {
        (by_direction - by_direction.dot(self.towards) * self.towards) / self.distance
    }

    /// ∇log f_p at apex q, x being its wing. [Lu20 (24)]
    pub fn wing_gradient(&self, wing: &Wing) -> DVec3 {
        let to_x = -self.towards;
        let c = to_x.dot(wing.to_other);
        wing.phase.log_derivative(c) * cosine_gradient_wing(to_x, wing.to_other, c, self.distance)
    }
}

/// The phase function at vertex `i`, if its derivative is known.
pub fn known(phase: Phase, i: usize) -> Result<Phase, PathError> {
    if phase.has_derivative() { Ok(phase) } else { Err(PathErrorKind::NoGradient.at(i)) }
}
