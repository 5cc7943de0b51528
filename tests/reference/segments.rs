//! Edges of a path, and the media they cross.
//!
//! The segments are computed from the regions each time: when a vertex moves, the crossings move with it, as finite
//! differences need it.

use super::{
    camera::Camera,
    vector::*,
    world::{Plane, World},
};

/// A straight line from `origin`, with length `f64::INFINITY` for an edge to an environment or directional light.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    pub origin: Vec3,
    /// Of unit length.
    pub direction: Vec3,
    pub length: f64,
    /// Media before this plane are skipped: the near plane, for an edge from the camera.
    pub near_plane: Option<Plane>,
}

impl Edge {
    pub fn between(a: Vec3, b: Vec3) -> Edge {
        Edge { origin: a, direction: direction(a, b), length: distance(a, b), near_plane: None }
    }

    pub fn to_infinity(origin: Vec3, direction: Vec3) -> Edge {
        Edge { origin, direction, length: f64::INFINITY, near_plane: None }
    }

    pub fn from_camera(camera: &Camera, point: Vec3) -> Edge {
        Edge { near_plane: near_plane(camera), ..Edge::between(camera.position, point) }
    }

    /// A ray from the camera, for distance sampling.
    pub fn camera_ray(camera: &Camera, direction: Vec3) -> Edge {
        Edge { near_plane: near_plane(camera), ..Edge::to_infinity(camera.position, direction) }
    }

    pub fn point(&self, t: f64) -> Vec3 {
        add(self.origin, scale(t, self.direction))
    }

    /// A point between two parameters, of which the second may be infinite.
    pub fn point_between(&self, begin: f64, end: f64) -> Vec3 {
        self.point(if end.is_finite() { 0.5 * (begin + end) } else { begin + 1.0 })
    }
}

fn near_plane(camera: &Camera) -> Option<Plane> {
    let point = add(camera.position, scale(camera.near, camera.forward));
    (camera.near > 0.0).then(|| Plane::through(point, camera.forward))
}

/// A stretch of an edge inside of one medium. It begins where the one before it ends.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Distance from the edge's origin.
    pub end: f64,
    /// Index into [`World::media`]; `None` in vacuum.
    pub medium: Option<usize>,
    /// Normal, in either sense and not necessarily of unit length, of the face on which the segment ends; `None` if it
    /// ends with the edge.
    pub face_normal: Option<Vec3>,
}

/// Two faces that coincide (boxes that touch) are found this far apart at most, relative to coordinates of order 1.
const ROUNDING: f64 = 1e-12;

impl World {
    /// The ordered segments of an edge. A camera edge begins with a vacuum segment up to the near plane (at distance
    /// near/cosθ) whose face normal is the camera's forward vector; elsewhere neighbouring segments differ in medium.
    pub fn segments(&self, edge: &Edge) -> Vec<Segment> {
        let mut segments = Vec::new();
        let mut begin = 0.0;
        if let Some(plane) = edge.near_plane {
            begin = plane.crossing(edge.origin, edge.direction).min(edge.length);
            segments.push(Segment { end: begin, medium: None, face_normal: Some(plane.normal) });
        }
        let first = segments.len();

        for (end, face_normal) in self.face_crossings(edge, begin) {
            let medium = self.medium_at(edge.point_between(begin, end));
            let is_sliver = end - begin < ROUNDING;
            match segments[first..].last_mut() {
                // The plane in between bounds nothing here: same medium on both sides.
                Some(last) if is_sliver || last.medium == medium => {
                    last.end = end;
                    last.face_normal = face_normal;
                }
                _ if is_sliver => {}
                _ => segments.push(Segment { end, medium, face_normal }),
            }
            begin = end;
        }
        segments
    }

    /// Distance and normal of every region plane met after `begin`, in order, and the end of the edge.
    fn face_crossings(&self, edge: &Edge, begin: f64) -> Vec<(f64, Option<Vec3>)> {
        let planes = self.regions.iter().flat_map(|region| &region.planes);
        let mut crossings: Vec<_> = planes
            .map(|plane| (plane.crossing(edge.origin, edge.direction), Some(plane.normal)))
            .filter(|&(t, _)| begin < t && t < edge.length)
            .collect();
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        crossings.push((edge.length, None));
        crossings
    }
}
