//! What of a path changes when its first vertex moves, and what stays.
//!
//! f = A(x)·L(x)·w(x)·rest: the camera side A, the link L = f_p G Tr (or f_r G Tr) from x to its next neighbour, and the phase
//! function w at that neighbour change; `rest` does not. Several contributions of one sampled path share A, some share L.
//! In a medium A = We G Tr σ_s, in volume measure. On a surface A = Tr, in image measure: We G dA(x) is the image's own area.

use crate::math::{Colour, DVec3, luminance, transmittance};
use crate::medium::{Line, Medium, NONE, Segment, optical_depth};
use crate::path::{Neighbour, Node, Path, PathError, PathErrorKind, Wing, factors};
use crate::phase::Phase;
use crate::scene::{Bsdf, Camera, Hit, ImagePoint, MAX_SEGMENTS, Scene, surface_epsilon};

/// The neighbour of x towards the light.
#[derive(Clone, Copy, Debug)]
pub enum Next {
    /// A point; with a normal, light passes only on its front and the geometry term has a cosine.
    Point { position: DVec3, normal: Option<DVec3> },
    /// A unit direction to an environment or directional light, which is kept.
    Direction(DVec3),
}

impl Next {
    /// G of the edge that arrives along the unit vector `direction` after `distance`, without the cosine at its start; 0 on the back.
    pub fn geometry(&self, direction: DVec3, distance: f64) -> f64 {
        match *self {
            Self::Direction(_) => 1.0,
            Self::Point { normal, .. } => {
                let cosine = normal.map_or(1.0, |n| -n.dot(direction));
                cosine.max(0.0) / (distance * distance)
            }
        }
    }

    /// How far a ray along that edge may go before it meets the surface at its end.
    pub fn t_max(&self, distance: f64) -> f64 {
        match *self {
            Self::Point { position, normal: Some(_) } => distance - surface_epsilon(position, distance),
            _ => distance,
        }
    }
}

/// The media along an edge, kept beyond the query that found them.
#[derive(Clone, Copy, Debug)]
pub struct Media {
    segments: [Segment; MAX_SEGMENTS],
    count: usize,
}

impl Default for Media {
    fn default() -> Self {
        Self { segments: [Segment::default(); MAX_SEGMENTS], count: 0 }
    }
}

impl Media {
    pub fn from(segments: &[Segment]) -> Self {
        let mut media = Self::default();
        for (to, from) in media.segments.iter_mut().zip(segments) {
            *to = *from;
            media.count += 1;
        }
        media
    }

    pub fn segments(&self) -> &[Segment] {
        self.segments.get(..self.count).unwrap_or(&[])
    }
}

/// Most contributions of a link with a phase function of their own at its far end.
pub const MAX_WINGS: usize = 2;

/// An edge from x onwards, and the contributions that go along it.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    pub next: Next,
    pub optical_depth: Colour,
    /// Only for gradients.
    pub media: Media,
    /// `rest` of all contributions without a phase function at `next`: those that end there or scatter on a diffuse surface.
    pub plain: Colour,
    /// The phase function at `next`, and per contribution the unit vector from there onwards, and its `rest`.
    pub phase: Phase,
    pub wings: [(DVec3, Colour); MAX_WINGS],
    pub wing_count: usize,
}

impl Link {
    pub fn new(next: Next, optical_depth: Colour, segments: &[Segment]) -> Self {
        Self {
            next,
            optical_depth,
            media: Media::from(segments),
            plain: Colour::ZERO,
            phase: Phase::ISOTROPIC,
            wings: [(DVec3::Z, Colour::ZERO); MAX_WINGS],
            wing_count: 0,
        }
    }

    /// Adds a contribution that scatters at `next` towards `to_other`.
    pub fn add_wing(&mut self, to_other: DVec3, rest: Colour) {
        if let Some(wing) = self.wings.get_mut(self.wing_count) {
            *wing = (to_other, rest);
            self.wing_count += 1;
        }
    }

    fn carries(&self) -> bool {
        self.plain.max_element() > 0.0 || self.wings().iter().any(|(_, rest)| rest.max_element() > 0.0)
    }

    pub fn wings(&self) -> &[(DVec3, Colour)] {
        self.wings.get(..self.wing_count).unwrap_or(&[])
    }

    pub fn wing(&self, index: usize) -> Option<Wing> {
        self.wings().get(index).map(|(to_other, _)| Wing { phase: self.phase, to_other: *to_other })
    }

    pub fn neighbour(&self) -> Neighbour {
        match self.next {
            Next::Point { position, normal } => Neighbour::Point { position, normal },
            Next::Direction(direction) => Neighbour::Direction(direction),
        }
    }
}

/// Most links of one path: to a light, and to the next vertex.
pub const MAX_LINKS: usize = 2;

/// What scatters at the first vertex.
#[derive(Clone, Copy, Debug)]
pub enum First {
    /// The medium of this index: x moves in space.
    Medium(u32),
    /// A surface that is not specular: x moves with the image point that sees it. `medium` is on the side that its normal points to.
    Surface { material: u32, normal: DVec3, medium: u32 },
}

/// Whether a first vertex on such a surface may move.
pub fn moves_on(bsdf: &Bsdf) -> bool {
    !bsdf.is_specular() && !bsdf.transmits()
}

impl First {
    /// The surface that a ray from the camera hit along `direction`.
    pub fn surface(hit: &Hit, bsdf: &Bsdf, direction: DVec3) -> Self {
        let outwards = hit.unit_normal();
        let normal = bsdf.facing(outwards, -direction);
        Self::Surface { material: hit.material, normal, medium: hit.medium_beyond(normal.dot(outwards) > 0.0) }
    }

    /// f_p, or f_r·cos.
    fn scattering(&self, scene: &Scene, to_camera: DVec3, to_next: DVec3) -> Colour {
        match *self {
            Self::Medium(index) => {
                let phase = scene.medium(index).map(|medium| medium.phase);
                Colour::splat(phase.map_or(0.0, |phase| phase.eval(to_camera.dot(to_next))))
            }
            Self::Surface { material, normal, .. } => {
                let bsdf = scene.materials.get(material as usize);
                bsdf.map_or(Colour::ZERO, |bsdf| bsdf.eval(normal, to_camera, to_next) * normal.dot(to_next).abs())
            }
        }
    }

    /// The medium in which links start.
    pub fn medium(&self) -> u32 {
        match *self {
            Self::Medium(medium) | Self::Surface { medium, .. } => medium,
        }
    }

    /// A, from the optical depth between the near plane and x.
    pub fn camera_side(&self, scene: &Scene, x: DVec3, image: &ImagePoint, optical_depth: Colour) -> Colour {
        let transmittance = transmittance(optical_depth);
        let Self::Medium(index) = *self else { return transmittance };
        let Some(medium) = scene.medium(index) else { return Colour::ZERO };
        medium.sigma_s(x) * transmittance * volume_to_image(&scene.camera, image)
    }
}

/// We cosθ/d²: what a volume at an image point's world point takes of the image's measure, per length along the ray.
pub fn volume_to_image(camera: &Camera, image: &ImagePoint) -> f64 {
    let cosine = image.ray.cosine;
    camera.importance(cosine) * cosine / (image.distance * image.distance)
}

/// A sampled path whose first vertex may move.
#[derive(Clone, Copy, Debug)]
pub struct Shiftable {
    pub x: DVec3,
    pub image: ImagePoint,
    pub first: First,
    /// From the near plane to x.
    pub optical_depth: Colour,
    pub media: Media,
    pub links: [Option<Link>; MAX_LINKS],
}

/// L and the phase functions at its far end for one position of x. Colour 0: nothing gets through.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinkValue {
    /// A·L
    pub colour: Colour,
    pub wings: [f64; MAX_WINGS],
}

/// Direction and distance from x to `next`.
pub fn towards(x: DVec3, next: &Next) -> (DVec3, f64) {
    match *next {
        Next::Point { position, .. } => {
            let distance = (position - x).length();
            ((position - x) / distance, distance)
        }
        Next::Direction(direction) => (direction, f64::INFINITY),
    }
}

/// f_p·G (or f_r·G) of the link, before visibility and Tr; 0 if either end faces away.
pub fn link_geometry(scene: &Scene, first: &First, to_camera: DVec3, next: &Next, direction: DVec3, distance: f64) -> Colour {
    first.scattering(scene, to_camera, direction) * next.geometry(direction, distance)
}

impl Shiftable {
    /// A path without contributions yet; `segments` start at the near plane.
    pub fn new(x: DVec3, image: ImagePoint, first: First, optical_depth: Colour, segments: &[Segment]) -> Self {
        Self { x, image, first, optical_depth, media: Media::from(segments), links: [None; MAX_LINKS] }
    }

    /// Drops links that carry nothing; None if that is all of them.
    pub fn without_empty_links(mut self) -> Option<Self> {
        for link in &mut self.links {
            *link = link.take().filter(Link::carries);
        }
        self.links.iter().any(Option::is_some).then_some(self)
    }

    /// The value of link `i` where the path was sampled.
    pub fn value(&self, scene: &Scene, i: usize) -> LinkValue {
        let Some(Some(link)) = self.links.get(i) else { return LinkValue::default() };
        let a = self.first.camera_side(scene, self.x, &self.image, self.optical_depth);
        let (direction, distance) = towards(self.x, &link.next);
        let l = link_geometry(scene, &self.first, -self.image.ray.direction, &link.next, direction, distance);
        LinkValue { colour: a * transmittance(link.optical_depth) * l, wings: link.wing_values(direction) }
    }

    /// The edge from the camera to x.
    pub fn camera_line<'s>(&'s self, scene: &'s Scene) -> Line<'s> {
        camera_line(&scene.camera, scene.media, &self.image, self.media.segments())
    }
}

/// The edge from the camera to an image point's world point; `segments` start at the near plane.
pub fn camera_line<'s>(camera: &Camera, media: &'s [Medium<'s>], image: &ImagePoint, segments: &'s [Segment]) -> Line<'s> {
    let start = image.ray.start;
    let line = Line::new(media, image.ray.origin, image.ray.direction, image.distance, segments);
    Line { start, start_normal: camera.forward, segments_start: start, ..line }
}

impl Link {
    /// Phase function values at `next`, seen from x along `direction`.
    pub fn wing_values(&self, direction: DVec3) -> [f64; MAX_WINGS] {
        core::array::from_fn(|i| self.wings().get(i).map_or(0.0, |(to_other, _)| self.phase.eval(-direction.dot(*to_other))))
    }
}

/// Prepares a path of any sampler, with weight C = w·f/p in RGB. None: its first vertex may not move, it stays as it is.
pub fn from_path(scene: &Scene, path: &Path, weight: Colour) -> Result<Option<Shiftable>, PathError> {
    let vertex = path.vertex(1)?;
    let x = vertex.position.wide();
    let first = match path.node(scene, 1)? {
        Node::Medium(_) => First::Medium(vertex.index),
        Node::Surface(bsdf) if moves_on(bsdf) => {
            let normal = vertex.normal.wide().normalize_or_zero();
            let medium = path.edge(scene, 1)?.segments.first().map_or(NONE, |segment| segment.medium);
            First::Surface { material: vertex.index, normal, medium }
        }
        _ => return Ok(None),
    };
    let next_node = path.node(scene, 2)?;
    let fixed = match next_node {
        Node::Surface(bsdf) => !bsdf.is_lambertian(),
        Node::Light(light) => light.has_profile(),
        _ => false,
    };
    if fixed {
        return Ok(None);
    }
    let lens = scene.camera.on_lens(path.position(scene, 0)?);
    let image = scene.camera.project(x, lens).ok_or(PathErrorKind::ZeroContribution.at(1))?;
    let (camera_edge, next_edge) = (path.edge(scene, 0)?, path.edge(scene, 1)?);
    if camera_edge.segments.len().max(next_edge.segments.len()) > MAX_SEGMENTS {
        return Err(PathErrorKind::BadSegments.at(0));
    }
    let vertex = path.vertex(2)?;
    let position = path.position(scene, 2)?;
    let next = if next_node.is_direction() {
        Next::Direction(position)
    } else {
        let normal = next_node.has_cosine().then(|| match next_node {
            Node::Surface(bsdf) => bsdf.facing(vertex.normal.wide(), x - position),
            _ => vertex.normal.wide(),
        });
        Next::Point { position, normal }
    };
    let mut link = Link::new(next, optical_depth(&next_edge), next_edge.segments);
    let mut rest = Colour::ONE;
    for i in 2..path.vertices.len() {
        let f = factors(scene, path, i)?;
        // The phase function at vertex 2 belongs to the wing; only colours matter of the rest.
        rest = normalised(rest * f.product());
    }
    match next_node {
        Node::Medium(m) => {
            link.phase = m.phase;
            let other = path.position(scene, 3)?;
            let to_other = if path.node(scene, 3)?.is_direction() { other } else { other - position };
            link.add_wing(to_other.try_normalize().ok_or(PathErrorKind::ZeroLength.at(2))?, rest);
        }
        _ => link.plain = rest,
    }
    // The path's own segments start at the camera; those from queries at the near plane.
    let media = from_near_plane(camera_edge.segments, image.ray.start);
    let optical_depth = optical_depth(&camera_edge);
    let mut shiftable = Shiftable { x, image, first, optical_depth, media, links: [Some(link), None] };
    let value = shiftable.value(scene, 0);
    let f = value.colour * rest * if link.wing_count > 0 { value.wings[0] } else { 1.0 };
    let scale = luminance(weight) / luminance(f);
    if !scale.is_finite() {
        return Err(PathErrorKind::ZeroContribution.at(1));
    }
    if let Some(link) = &mut shiftable.links[0] {
        link.plain *= scale;
        link.wings[0].1 *= scale;
    }
    Ok(Some(shiftable))
}

fn normalised(colour: Colour) -> Colour {
    let largest = colour.max_element();
    if largest > 0.0 { colour / largest } else { colour }
}

/// Segments measured from the near plane instead of the camera.
fn from_near_plane(segments: &[Segment], start: f64) -> Media {
    let mut media = Media::from(segments);
    for segment in media.segments.iter_mut() {
        segment.end = (f64::from(segment.end) - start).max(0.0) as f32;
    }
    media
}
