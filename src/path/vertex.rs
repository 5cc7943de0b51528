//! A light path as the host hands it over, and what its parts refer to.

use super::joint::Leg;
use crate::math::{DVec3, Vec3, is_unit};
use crate::medium::{Line, Medium, NONE, Segment};
use crate::scene::{Bsdf, Camera, Light, MAX_SEGMENTS, Scene};

pub const VERTEX_CAMERA: u32 = 0;
pub const VERTEX_MEDIUM: u32 = 1;
pub const VERTEX_SURFACE: u32 = 2;
pub const VERTEX_LIGHT: u32 = 3;

/// A vertex of a path.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vertex {
    /// `VOLGRAD_VERTEX_*`: the first of a path is the camera, the last a light, those between are neither.
    pub kind: u32,
    /// Index into the scene's media, materials or lights, by kind. Unused for the camera.
    pub index: u32,
    /// Of a surface: what custom BSDFs get back (`volgrad_hit.user`), or 0; `volgrad_shift_paths` takes vertices for the same only if it is the
    /// same. Unused otherwise.
    pub user: u64,
    /// World position; for an environment or directional light the unit direction towards it. For a thin lens
    /// camera the point on its lens; unused for a pinhole camera, whose position is the scene's.
    pub position: Vec3,
    /// Geometric unit normal of a surface or area light; unused otherwise.
    pub normal: Vec3,
    /// Shading normal; this version reads the geometric one only. Set both alike.
    pub shading_normal: Vec3,
    pub reserved: u32,
}

/// A path x_0 … x_k from the camera to a light. Null surfaces are no vertices.
#[derive(Clone, Copy, Debug)]
pub struct Path<'a> {
    pub vertices: &'a [Vertex],
    /// The media along all edges, edge after edge.
    pub segments: &'a [Segment],
    /// For edge i, from vertex i to i + 1, the index in `segments` past its last.
    pub edge_ends: &'a [u32],
}

/// What is wrong with a path, and at which vertex (or the edge that starts there).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathError {
    pub kind: PathErrorKind,
    pub index: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathErrorKind {
    /// A kind that does not exist, or not at this place of a path; or fewer than two vertices.
    BadKind,
    /// An index into media, materials, lights or segments is out of range.
    BadIndex,
    /// A NaN, an infinity, or a normal or direction that is not of unit length.
    NotFinite,
    /// x_0 off the lens, or the last vertex not where its point, spot or directional light is.
    Misplaced,
    /// Two neighbouring vertices at one place.
    ZeroLength,
    /// Segments are missing, not in order, or end before their edge does; or a medium vertex lies in none of them.
    BadSegments,
    /// The vertex cannot move freely: not in a medium, or next to a specular surface.
    NotMovable,
    /// f is 0 here, so log f has no gradient.
    ZeroContribution,
    /// The host computes what is here, but not its derivatives.
    NoGradient,
}

impl PathErrorKind {
    pub fn at(self, index: usize) -> PathError {
        PathError { kind: self, index: index as u32 }
    }
}

/// What a vertex is, looked up in the scene.
#[derive(Clone, Copy, Debug)]
pub enum Node<'a> {
    Camera(&'a Camera),
    Medium(&'a Medium<'a>),
    Surface(&'a Bsdf<'a>),
    Light(&'a Light<'a>),
}

impl Node<'_> {
    pub fn is_specular(&self) -> bool {
        matches!(self, Self::Surface(bsdf) if bsdf.is_specular())
    }

    /// Whether the vertex is a direction instead of a point.
    pub fn is_direction(&self) -> bool {
        matches!(self, Self::Light(light) if light.is_environment() || matches!(light, Light::Directional { .. }))
    }

    /// Whether the geometry term has a surface cosine here.
    pub fn has_cosine(&self) -> bool {
        match self {
            Self::Surface(_) => true,
            Self::Light(light) => light.area_pdf() > 0.0,
            _ => false,
        }
    }
}

impl<'a> Path<'a> {
    pub fn vertex(&self, i: usize) -> Result<&'a Vertex, PathError> {
        self.vertices.get(i).ok_or(PathErrorKind::BadIndex.at(i))
    }

    /// Where vertex `i` is: the scene's pinhole camera, or as the vertex says; for a light at infinity the direction.
    pub fn position(&self, scene: &Scene, i: usize) -> Result<DVec3, PathError> {
        self.place(scene, i, self.is_direction(scene, i)?)
    }

    /// The same if it is known whether it is a direction.
    pub(super) fn place(&self, scene: &Scene, i: usize, is_direction: bool) -> Result<DVec3, PathError> {
        if i == 0 && scene.camera.is_pinhole() {
            return Ok(scene.camera.position);
        }
        let position = self.vertex(i)?.position.wide();
        // Phase functions with a sharp peak do not forgive what single precision lacks in length.
        Ok(if is_direction { position.normalize_or_zero() } else { position })
    }

    /// Whether vertex `i` is a direction instead of a point.
    fn is_direction(&self, scene: &Scene, i: usize) -> Result<bool, PathError> {
        // Other vertices need not be known: reports say where they are.
        Ok(self.vertex(i)?.kind == VERTEX_LIGHT && self.node(scene, i)?.is_direction())
    }

    /// Looks vertex `i` up.
    pub fn node<'s>(&self, scene: &'s Scene<'s>, i: usize) -> Result<Node<'s>, PathError> {
        let vertex = self.vertex(i)?;
        let index = vertex.index as usize;
        let last = self.vertices.len() - 1;
        let node = match vertex.kind {
            VERTEX_CAMERA if i == 0 => Some(Node::Camera(&scene.camera)),
            VERTEX_MEDIUM if i > 0 && i < last => scene.media.get(index).map(Node::Medium),
            VERTEX_SURFACE if i > 0 && i < last => scene.materials.get(index).map(Node::Surface),
            VERTEX_LIGHT if i > 0 && i == last => scene.lights.lights.get(index).map(Node::Light),
            _ => return Err(PathErrorKind::BadKind.at(i)),
        };
        node.ok_or(PathErrorKind::BadIndex.at(i))
    }

    /// The edge from vertex i to i + 1.
    pub fn edge<'s>(&self, scene: &'s Scene<'s>, i: usize) -> Result<Line<'s>, PathError>
    where
        'a: 's,
    {
        let (from, to) = (self.position(scene, i)?, self.position(scene, i + 1)?);
        self.line(scene, i, from, &Leg::new(from, to, self.is_direction(scene, i + 1)?, i)?)
    }

    /// The media along an edge that starts at vertex `i`, which is at `from`.
    pub(super) fn line<'s>(&self, scene: &'s Scene<'s>, i: usize, from: DVec3, leg: &Leg) -> Result<Line<'s>, PathError>
    where
        'a: 's,
    {
        let line = Line::new(scene.media, from, leg.direction, leg.length, self.edge_segments(i)?);
        if i > 0 {
            return Ok(line);
        }
        // No medium before the near plane attenuates.
        let camera = &scene.camera;
        let start = (camera.near_clip / camera.forward.dot(leg.direction)).max(0.0).min(leg.length);
        Ok(Line { start, start_normal: camera.forward, ..line })
    }

    /// The media along the edge from vertex i to i + 1.
    fn edge_segments(&self, i: usize) -> Result<&'a [Segment], PathError> {
        let start = if i == 0 { 0 } else { self.edge_end(i - 1)? };
        let segments = self.segments.get(start..self.edge_end(i)?).filter(|s| !s.is_empty());
        segments.ok_or(PathErrorKind::BadSegments.at(i))
    }

    fn edge_end(&self, i: usize) -> Result<usize, PathError> {
        self.edge_ends.get(i).map(|end| *end as usize).ok_or(PathErrorKind::BadSegments.at(i))
    }

    /// Checks all that the functions on paths rely on.
    pub fn validate(&self, scene: &Scene) -> Result<(), PathError> {
        if self.vertices.len() < 2 {
            return Err(PathErrorKind::BadKind.at(0));
        }
        for (i, vertex) in self.vertices.iter().enumerate() {
            let node = self.node(scene, i)?;
            let point_ok = (i == 0 && scene.camera.is_pinhole()) || vertex.position.wide().is_finite();
            let position_ok = point_ok && (!node.is_direction() || is_unit(vertex.position.wide()));
            if !position_ok || (node.has_cosine() && !is_unit(vertex.normal.wide())) {
                return Err(PathErrorKind::NotFinite.at(i));
            }
        }
        (0..self.vertices.len() - 1).try_for_each(|i| self.validate_edge(scene, i))?;
        for i in [0, self.vertices.len() - 1] {
            if !is_in_place(&self.node(scene, i)?, self.position(scene, i)?) {
                return Err(PathErrorKind::Misplaced.at(i));
            }
        }
        Ok(())
    }

    fn validate_edge(&self, scene: &Scene, i: usize) -> Result<(), PathError> {
        let line = self.edge(scene, i)?;
        let mut reached = 0.0;
        let last = line.segments.len() - 1;
        if last >= MAX_SEGMENTS {
            return Err(PathErrorKind::BadSegments.at(i));
        }
        for (j, segment) in line.segments.iter().enumerate() {
            let known = segment.medium == NONE || (segment.medium as usize) < scene.media.len();
            if !known {
                return Err(PathErrorKind::BadIndex.at(i));
            }
            if !(segment.end >= reached) {
                return Err(PathErrorKind::BadSegments.at(i));
            }
            if j < last && !is_unit(segment.normal.wide()) {
                return Err(PathErrorKind::NotFinite.at(i));
            }
            reached = segment.end;
        }
        let inside = |vertex: &Vertex, segment: Option<&Segment>| {
            vertex.kind != VERTEX_MEDIUM || segment.is_some_and(|s| s.medium == vertex.index)
        };
        // Single precision carries the lengths: a relative slack of a few hundred roundings.
        let long_enough = f64::from(reached) >= line.length * (1.0 - 1e-4);
        let (from, to) = (self.vertex(i)?, self.vertex(i + 1)?);
        if !long_enough || !inside(from, line.segments.first()) || !inside(to, line.segments.last()) {
            return Err(PathErrorKind::BadSegments.at(i));
        }
        Ok(())
    }
}

/// Whether a vertex is on its lens, or at its light if that has one place only: to single precision.
fn is_in_place(node: &Node, x: DVec3) -> bool {
    const SLACK: f64 = 1e-4;
    // Of a point far from the origin, beside which a lens may be small: some sixteen roundings.
    const ROUNDING: f64 = 1e-6;
    match node {
        Node::Camera(camera) if !camera.is_pinhole() => {
            let from_centre = x - camera.position;
            let off_plane = camera.forward.dot(from_centre).abs();
            let slack = SLACK * camera.lens_radius + ROUNDING * x.length();
            off_plane <= slack && camera.on_lens(x).length() <= camera.lens_radius + slack
        }
        Node::Light(Light::Directional { direction, .. }) => (x + *direction).length() <= SLACK,
        Node::Light(Light::Point { position, .. } | Light::Spot { position, .. } | Light::CustomPoint { position, .. }) => {
            (x - *position).length() <= SLACK * position.length().max(x.length())
        }
        _ => true,
    }
}
