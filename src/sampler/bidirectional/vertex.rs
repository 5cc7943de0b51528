//! A vertex of a subpath, from the camera or from a light, and the densities with which subpaths make their vertices.
//!
//! Densities are per volume in a medium, per area on a surface, per solid angle for light from infinitely far away. At a specular vertex
//! they are meant without its delta factor, in a measure that both directions share: projected solid angle times squared index of
//! refraction. So only products in which each such vertex appears once have a meaning, and only their ratios.

use crate::math::{Colour, DVec2, DVec3, disk_number, mean, orthonormal_basis};
use crate::phase::Phase;
use crate::scene::{Bounds, Bsdf, Light, Scene, SurfacePoint};
use core::f64::consts::PI;

/// What a vertex is.
#[derive(Clone, Copy, Debug)]
pub enum Kind<'a> {
    Camera,
    Medium {
        index: u32,
        phase: Phase,
    },
    Surface {
        material: u32,
        bsdf: &'a Bsdf<'a>,
        /// As the surface is oriented, and the media on its side and on the other.
        normal: DVec3,
        media: [u32; 2],
        /// `volgrad_hit.user`
        user: u64,
        /// The light that it is, or NONE.
        light: u32,
    },
    /// A point of a light, where a subpath starts.
    Light {
        light: &'a Light<'a>,
        index: u32,
        normal: Option<DVec3>,
    },
    /// A light infinitely far away. The vertex' position is the unit vector to it.
    Far {
        light: &'a Light<'a>,
        index: u32,
    },
}

#[derive(Clone, Copy, Debug)]
pub struct Vertex<'a> {
    pub kind: Kind<'a>,
    pub position: DVec3,
    /// The edge from the subpath's vertex before; none at its first.
    pub edge: Edge,
    /// Value over density of the subpath up to here: σ_s included, what scatters not; nor, at a light, what it emits.
    pub throughput: Colour,
    /// σ_t in a medium, 1 elsewhere: times the transmittance of an edge it is the density with which the edge ends here.
    pub extinction: Colour,
    /// Density with which its subpath makes it, the vertices before given.
    pub density: f64,
    /// Density with which a subpath from the other end makes it, given the two vertices after it in this one.
    pub reverse: f64,
    /// How far from a ray's start surfaces count.
    pub epsilon: f64,
}

/// A straight edge to a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Unit vector from the vertex where it ends to that where it starts.
    pub back: DVec3,
    pub distance: f64,
    pub optical_depth: Colour,
    pub transmittance: Colour,
}

impl Edge {
    pub const NONE: Self = Self { back: DVec3::Z, distance: 0.0, optical_depth: Colour::ZERO, transmittance: Colour::ONE };

    pub fn reversed(&self) -> Self {
        Self { back: -self.back, ..*self }
    }

    /// 1/d², or 1 for an edge to infinity.
    pub fn spread(&self) -> f64 {
        if self.distance.is_finite() { 1.0 / (self.distance * self.distance) } else { 1.0 }
    }
}

/// Density with which rays to light from infinitely far away start on the disk that covers the scene.
pub fn disk_density(bounds: &Bounds) -> f64 {
    if bounds.radius > 0.0 { 1.0 / (PI * bounds.radius * bounds.radius) } else { 0.0 }
}

/// The numbers of the place on that disk, across the unit vector `to_light`, from which a ray reaches `x`.
fn disk_numbers(bounds: &Bounds, to_light: DVec3, x: DVec3) -> DVec2 {
    let (s, t) = orthonormal_basis(to_light);
    let offset = (x - bounds.centre) / bounds.radius;
    disk_number(DVec2::new(offset.dot(s), offset.dot(t)))
}

impl Vertex<'_> {
    pub fn is_specular(&self) -> bool {
        matches!(self.kind, Kind::Surface { bsdf, .. } if bsdf.is_specular())
    }

    /// Its point on a surface of which this is known.
    pub fn surface(&self, normal: DVec3, user: u64) -> SurfacePoint {
        SurfacePoint { position: self.position, normal, user }
    }

    /// For a light's vertex: whether a path that goes on can find it.
    pub fn can_be_found(&self) -> bool {
        match self.kind {
            Kind::Light { normal, .. } => normal.is_some(),
            Kind::Far { light, .. } => light.is_environment(),
            _ => true,
        }
    }

    /// |cos| to a direction at a surface or an area light, 1 elsewhere.
    pub fn cosine(&self, direction: DVec3) -> f64 {
        match self.kind {
            Kind::Surface { normal, .. } | Kind::Light { normal: Some(normal), .. } => normal.dot(direction).abs(),
            _ => 1.0,
        }
    }

    /// f_p or f_r·cos for light that goes from the direction `to_light` to `to_camera`, the cosine being that of `leaving`, one of the two.
    pub fn scattering(&self, to_camera: DVec3, to_light: DVec3, leaving: DVec3) -> Colour {
        match self.kind {
            Kind::Medium { phase, .. } => Colour::splat(phase.eval(to_camera.dot(to_light))),
            Kind::Surface { bsdf, normal, user, .. } => {
                bsdf.eval(&self.surface(normal, user), to_camera, to_light) * normal.dot(leaving).abs()
            }
            _ => Colour::ZERO,
        }
    }

    /// What a light's vertex sends along `direction`: emission, times the cosine if it has one.
    pub fn emission(&self, direction: DVec3) -> Colour {
        match self.kind {
            Kind::Light { light, normal, .. } => light.emission(direction) * normal.map_or(1.0, |n| n.dot(direction).max(0.0)),
            Kind::Far { light, .. } => light.emission(direction),
            _ => Colour::ZERO,
        }
    }

    /// Density, per steradian, with which a subpath that came from the direction `from` goes on to `to`.
    pub(super) fn scattering_density(&self, from: DVec3, to: DVec3) -> f64 {
        match self.kind {
            Kind::Medium { phase, .. } => phase.eval(from.dot(to)),
            Kind::Surface { bsdf, normal, .. } if bsdf.is_specular() => bsdf.specular_density(normal, from, to),
            Kind::Surface { bsdf, normal, user, .. } => bsdf.pdf(&self.surface(normal, user), from, to),
            _ => 0.0,
        }
    }

    /// What takes a direction's density, per steradian, to that of this vertex at the end of `edge`.
    pub(super) fn arrival(&self, edge: &Edge) -> f64 {
        match self.kind {
            Kind::Camera | Kind::Light { normal: None, .. } => 0.0,
            _ => self.cosine(edge.back) * edge.spread() * mean(self.extinction * edge.transmittance),
        }
    }

    /// Density with which a subpath at this vertex, that came from the direction `from`, makes the vertex `next` at the end of `edge`.
    pub fn density_of(&self, scene: &Scene, from: DVec3, next: &Vertex, edge: &Edge) -> f64 {
        let direction = -edge.back;
        match self.kind {
            Kind::Far { .. } => {
                let aim = self.guided(scene, next, direction);
                disk_density(&scene.bounds) * aim * next.cosine(direction) * mean(next.extinction * edge.transmittance)
            }
            Kind::Light { light, normal, .. } => {
                let aim = self.guided(scene, next, direction);
                light.direction_density(normal, direction) * aim * next.arrival(edge)
            }
            Kind::Camera => scene.camera.direction_density(scene.camera.forward.dot(direction)) * next.arrival(edge),
            _ => self.scattering_density(from, direction) * next.arrival(edge),
        }
    }

    /// What a light's guide makes of the density with which its subpath goes to `next`, in `direction`; 1 at other vertices.
    pub(super) fn guided(&self, scene: &Scene, next: &Vertex, direction: DVec3) -> f64 {
        let lights = &scene.lights;
        match self.kind {
            Kind::Far { index, .. } => {
                lights.guide_density(index, || Some(disk_numbers(&scene.bounds, self.position, next.position)))
            }
            Kind::Light { light, index, normal } => lights.guide_density(index, || light.invert_direction(normal, direction)),
            _ => 1.0,
        }
    }

    /// The medium in which a ray from here in `direction` starts.
    pub fn medium(&self, scene: &Scene, direction: DVec3) -> u32 {
        match self.kind {
            Kind::Camera => scene.camera.medium,
            Kind::Medium { index, .. } => index,
            Kind::Surface { normal, media, .. } => media[usize::from(direction.dot(normal) <= 0.0)],
            Kind::Light { index, .. } => scene.lights.medium(index),
            Kind::Far { .. } => crate::medium::NONE,
        }
    }
}
