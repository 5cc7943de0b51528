//! How the core asks the host about geometry: rays in batches, answered with the surface and the media on the way.

use super::{Scene, SurfacePoint};
use crate::math::{DVec3, Vec3};
use crate::medium::{NONE, Segment};

/// Most media that one ray or edge may cross, and so the capacity of `volgrad_hit.segments`.
pub const MAX_SEGMENTS: usize = 16;

pub const HIT_NONE: u32 = 0;
pub const HIT_SURFACE: u32 = 1;
pub const HIT_OVERFLOW: u32 = 2;

/// The surface does not change the medium.
pub const KEEP_MEDIUM: u32 = 0xFFFF_FFFE;

/// A ray whose surfaces and media the host is asked for.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ray {
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Surfaces nearer than this are the one the ray starts from, and no hit (media still change from the origin on). World units.
    pub t_min: f32,
    /// Surfaces at or beyond this are no hit; may be INFINITY. World units.
    pub t_max: f32,
    /// Medium at the origin, or `VOLGRAD_NONE`.
    pub medium: u32,
}

/// The host's answer to a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// `VOLGRAD_HIT_*`.
    pub kind: u32,
    /// Index of the surface's material. An area light's surface has one too (a black diffuse one, usually).
    pub material: u32,
    /// Index of the area light that this surface is, or `VOLGRAD_NONE`.
    pub light: u32,
    /// Media crossed: at least 1, the first starting at the ray's origin, the last ending at or past the hit or `t_max`.
    /// Neighbouring segments in the same medium may be merged. Unused when an occlusion query found a surface.
    pub segment_count: u32,
    /// Anything that says where on which surface this is, or 0: custom BSDFs get it back (`volgrad_surface_point`), and paths that are handed
    /// out have it in their vertices.
    pub user: u64,
    /// Distance to the surface, world units, > 0.
    pub t: f32,
    /// Geometric unit normal, as the surface is oriented (not flipped towards the ray).
    pub normal: Vec3,
    /// Shading normal; this version reads the geometric one only. Set both alike.
    pub shading_normal: Vec3,
    /// Medium on the side of the surface that the normal points to, and on the other; both `VOLGRAD_KEEP_MEDIUM` when the surface
    /// bounds none: a ray that goes on through it stays in the medium that it is in.
    pub medium_outside: u32,
    pub medium_inside: u32,
    pub segments: [Segment; MAX_SEGMENTS],
}

impl Ray {
    /// A ray that starts at no surface.
    pub fn free(origin: DVec3, direction: DVec3, t_max: f64, medium: u32) -> Self {
        Self { origin: origin.into(), direction: direction.into(), t_min: 0.0, t_max: t_max as f32, medium }
    }
}

const ZERO: Vec3 = Vec3 { x: 0.0, y: 0.0, z: 0.0 };

impl Hit {
    /// To be filled by a query.
    pub const EMPTY: Self = Self {
        kind: HIT_NONE,
        material: NONE,
        light: NONE,
        segment_count: 0,
        user: 0,
        t: 0.0,
        normal: ZERO,
        shading_normal: ZERO,
        medium_outside: KEEP_MEDIUM,
        medium_inside: KEEP_MEDIUM,
        segments: [Segment { end: 0.0, medium: NONE, normal: ZERO }; MAX_SEGMENTS],
    };

    /// Checks what the core relies on. The media of a hit that only says "occluded" are not looked at.
    pub fn check(&self, scene: &Scene) -> Result<(), Stop> {
        self.mistake(scene).map_or(Ok(()), |_| Err(Stop::InvalidHit))
    }

    /// The first thing that is wrong.
    pub fn mistake(&self, scene: &Scene) -> Option<Mistake> {
        let medium = |index: u32| index == NONE || (index as usize) < scene.media.len();
        let side = |index: u32| index == KEEP_MEDIUM || medium(index);
        if !matches!(self.kind, HIT_NONE | HIT_SURFACE) {
            return Some(Mistake::Kind);
        }
        // Written so that NaN fails.
        if self.kind == HIT_SURFACE {
            if self.material as usize >= scene.materials.len() {
                return Some(Mistake::Material);
            }
            if self.light != NONE && !scene.lights.get(self.light).is_some_and(|light| light.area_pdf() > 0.0) {
                return Some(Mistake::Light);
            }
            if !(side(self.medium_inside) && side(self.medium_outside)) {
                return Some(Mistake::Medium);
            }
            if !(self.t > 0.0 && self.t.is_finite()) {
                return Some(Mistake::Distance);
            }
            if !((self.normal.wide().length_squared() - 1.0).abs() < 1e-2) {
                return Some(Mistake::Normal);
            }
        }
        if self.media().is_empty() {
            return Some(Mistake::SegmentCount);
        }
        let mut reached = 0.0;
        let wrong = |segment: &Segment| {
            let ok = segment.end >= reached && medium(segment.medium);
            reached = segment.end;
            !ok
        };
        self.media().iter().position(wrong).map(Mistake::Segment)
    }

    /// The medium in which a ray that leaves the surface starts, on the side that the normal points to or on the other.
    pub fn medium_beyond(&self, outside: bool) -> u32 {
        match if outside { self.medium_outside } else { self.medium_inside } {
            KEEP_MEDIUM => self.media().last().map_or(NONE, |segment| segment.medium),
            medium => medium,
        }
    }

    /// The surface's point, at this position.
    pub fn at(&self, position: DVec3) -> SurfacePoint {
        SurfacePoint { position, normal: self.unit_normal(), user: self.user }
    }

    /// The normal with what single precision lacks in length mended.
    pub fn unit_normal(&self) -> DVec3 {
        self.normal.wide().normalize_or_zero()
    }

    pub fn media(&self) -> &[Segment] {
        self.segments.get(..self.segment_count as usize).unwrap_or(&[])
    }
}

/// What can be wrong with a hit.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    Kind,
    Material,
    /// There is no such area light.
    Light,
    Medium,
    Distance,
    Normal,
    /// None, or more than fit.
    SegmentCount,
    /// Its end lies before the one before, or there is no such medium.
    Segment(usize),
}

/// Why a running call ends early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// A callback returned this code.
    Callback(i32),
    /// The host's answer breaks the contract of [`Hit`].
    InvalidHit,
    /// A chain's numbers do not make the path that they made before: this is another scene, or a plan of other samples.
    OtherPath,
    /// Batches need the derivative of a phase function that the host does not tell.
    NoGradient,
}

/// Geometry, as the host has it. Index-matched (null) surfaces are never hits: they end segments. `hits` is as long as `rays`.
pub trait Queries {
    /// The nearest surface in [t_min, t_max), and the media up to it, or up to t_max.
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop>;
    /// Whether any surface is in [t_min, t_max), and if none, the media up to t_max.
    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop>;
}

/// How far a ray from or to a surface stays away from it, given the point there and its distance from the ray's other end:
/// some hundred times the rounding of single-precision coordinates and distances, but a quarter of the way at most.
pub fn surface_epsilon(point: DVec3, distance: f64) -> f64 {
    const ROUNDING: f64 = 5e-5;
    (ROUNDING * point.abs().max_element().max(distance)).min(0.25 * distance)
}
