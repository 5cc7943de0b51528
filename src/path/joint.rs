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
        let node = path.node(scene, i)?;
        let vertex = path.vertex(i)?;
        let position = match node {
            Node::Camera(camera) if camera.is_pinhole() => camera.position,
            // Phase functions with a sharp peak do not forgive what single precision lacks in length.
            node if node.is_direction() => vertex.position.wide().normalize_or_zero(),
            _ => vertex.position.wide(),
        };
        Ok(Self { node, position, normal: vertex.normal.wide(), user: vertex.user })
    }

    /// The surface's point.
    pub fn surface(&self) -> SurfacePoint {
        SurfacePoint { position: self.position, normal: self.normal, user: self.user }
    }

    /// The edge from here, vertex `i`, to the next.
    pub fn leg_to(&self, next: &Joint, i: usize) -> Result<Leg, PathError> {
        let v = next.position - self.position;
        let leg = if next.node.is_direction() {
            Leg { direction: next.position, length: f64::INFINITY }
        } else {
            let length = v.length();
            Leg { direction: v / length, length }
        };
        // Written so that NaN is an error.
        if leg.length > 0.0 { Ok(leg) } else { Err(PathErrorKind::ZeroLength.at(i)) }
    }

    /// That edge with its media.
    pub fn line(&self, scene: &'s Scene<'s>, path: &Path<'s>, i: usize, leg: &Leg) -> Result<Line<'s>, PathError> {
        let line = Line::new(scene.media, self.position, leg.direction, leg.length, path.edge_segments(i)?);
        if i > 0 {
            return Ok(line);
        }
        // No medium before the near plane attenuates.
        let camera = &scene.camera;
        let start = (camera.near_clip / camera.forward.dot(leg.direction)).max(0.0).min(leg.length);
        Ok(Line { start, start_normal: camera.forward, ..line })
    }
}
