//! Vertices and edges of a path, looked up once for all that f and its gradient ask of them.

use super::{Node, Path, PathError, PathErrorKind};
use crate::math::DVec3;
use crate::medium::Line;
use crate::scene::{Scene, SurfacePoint};

/// A vertex, with what it is.
#[derive(Clone, Copy)]
pub struct Joint<'s> {
    pub node: Node<'s>,
    /// Of a light at infinity the direction.
    pub position: DVec3,
    /// These two mean nothing where there is no surface.
    pub normal: DVec3,
    pub user: u64,
}

/// How a vertex sees the next one: what all of an edge's factors are made of.
#[derive(Clone, Copy)]
pub struct Leg {
    pub direction: DVec3,
    /// Infinite towards a light at infinity.
    pub length: f64,
}

impl<'s> Joint<'s> {
    pub fn new(scene: &'s Scene<'s>, path: &Path, i: usize) -> Result<Self, PathError> {
        let (node, vertex) = (path.node(scene, i)?, path.vertex(i)?);
        let position = path.place(scene, i, node.is_direction())?;
        Ok(Self { node, position, normal: vertex.normal.wide(), user: vertex.user })
    }

    /// The surface's point.
    pub fn surface(&self) -> SurfacePoint {
        SurfacePoint { position: self.position, normal: self.normal, user: self.user }
    }

    /// The edge from here, vertex `i`, to the next.
    pub fn leg_to(&self, next: &Joint, i: usize) -> Result<Leg, PathError> {
        Leg::new(self.position, next.position, next.node.is_direction(), i)
    }

    /// That edge with its media.
    pub fn line(&self, scene: &'s Scene<'s>, path: &Path<'s>, i: usize, leg: &Leg) -> Result<Line<'s>, PathError> {
        path.line(scene, i, self.position, leg)
    }
}

impl Leg {
    /// The edge number `i`, to a place or in a direction.
    pub fn new(from: DVec3, to: DVec3, is_direction: bool, i: usize) -> Result<Self, PathError> {
        if is_direction {
            return Ok(Self { direction: to, length: f64::INFINITY });
        }
        let length = (to - from).length();
        // Written so that NaN is an error.
        if !(length > 0.0 && length.is_finite()) {
            return Err(PathErrorKind::ZeroLength.at(i));
        }
        Ok(Self { direction: (to - from) / length, length })
    }
}
