//! A toy host: geometry of boxes, parallelograms, triangles, discs and spheres that answers the library's queries, without any ray tracing library.
//!
//! Axis-aligned boxes bound media (null surfaces) and may be nested: the last box of the list that holds a point decides.
//! The others are surfaces, and may be lights.

#![allow(dead_code)]

pub mod batch;
pub mod estimate;
pub mod scenes;

use volgrad::math::{DVec3, Vec3};
use volgrad::medium::{NONE, Segment};
use volgrad::scene::{Bounds, HIT_OVERFLOW, HIT_SURFACE, Hit, MAX_SEGMENTS, Queries, Ray, Stop};

/// Index-matched walls around a medium.
#[derive(Clone, Copy, Debug)]
pub struct MediumBox {
    pub low: DVec3,
    pub high: DVec3,
    pub medium: u32,
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Its normal is edge_u × edge_v.
    Parallelogram {
        corner: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
    },
    /// Its normal is edge_u × edge_v.
    Triangle {
        corner: DVec3,
        edge_u: DVec3,
        edge_v: DVec3,
    },
    Disc {
        centre: DVec3,
        normal: DVec3,
        radius: f64,
    },
    /// Its normal points outwards.
    Sphere {
        centre: DVec3,
        radius: f64,
    },
}

/// A surface.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub shape: Shape,
    pub material: u32,
    /// Index of the light that it is, or NONE.
    pub light: u32,
}

#[derive(Clone, Debug, Default)]
pub struct Geometry {
    pub boxes: Vec<MediumBox>,
    pub surfaces: Vec<Surface>,
}

/// A ray in f64.
struct Line {
    origin: DVec3,
    direction: DVec3,
}

impl Line {
    fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

impl MediumBox {
    pub fn new(low: [f64; 3], high: [f64; 3], medium: u32) -> Self {
        Self { low: low.into(), high: high.into(), medium }
    }

    fn holds(&self, x: DVec3) -> bool {
        x.cmpge(self.low).all() && x.cmplt(self.high).all()
    }

    /// Where the line enters and leaves: distance and the axis across the face.
    fn crossings(&self, line: &Line) -> Option<[(f64, usize); 2]> {
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
        for axis in 0..3 {
            let (origin, slope) = (line.origin[axis], line.direction[axis]);
            if slope == 0.0 {
                if origin < self.low[axis] || origin >= self.high[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((self.low[axis] - origin) / slope, (self.high[axis] - origin) / slope);
            if a.min(b) > enter.0 {
                enter = (a.min(b), axis);
            }
            if a.max(b) < leave.0 {
                leave = (a.max(b), axis);
            }
        }
        (enter.0 < leave.0).then_some([enter, leave])
    }
}

impl Shape {
    pub fn normal(&self, x: DVec3) -> DVec3 {
        match *self {
            Self::Parallelogram { edge_u, edge_v, .. } | Self::Triangle { edge_u, edge_v, .. } => {
                edge_u.cross(edge_v).normalize()
            }
            Self::Disc { normal, .. } => normal,
            Self::Sphere { centre, .. } => (x - centre).normalize(),
        }
    }

    /// A point of it; of a disc or a sphere the centre.
    pub fn corner(&self) -> DVec3 {
        match *self {
            Self::Parallelogram { corner, .. } | Self::Triangle { corner, .. } => corner,
            Self::Disc { centre, .. } | Self::Sphere { centre, .. } => centre,
        }
    }

    /// Distance along the line to the shape, from `t_min` on.
    fn distance(&self, line: &Line, t_min: f64) -> Option<f64> {
        let (normal, through) = match *self {
            Self::Parallelogram { corner, edge_u, edge_v } | Self::Triangle { corner, edge_u, edge_v } => {
                (edge_u.cross(edge_v), corner)
            }
            Self::Disc { centre, normal, .. } => (normal, centre),
            Self::Sphere { centre, radius } => return sphere_distance(centre, radius, line, t_min),
        };
        let t = (through - line.origin).dot(normal) / line.direction.dot(normal);
        let from = line.at(t) - through;
        let inside = match *self {
            Self::Parallelogram { edge_u, edge_v, .. } | Self::Triangle { edge_u, edge_v, .. } => {
                let (u, v) = (from.cross(edge_v).dot(normal), edge_u.cross(from).dot(normal));
                let area2 = normal.length_squared();
                let half = matches!(self, Self::Triangle { .. });
                u >= 0.0 && u < area2 && v >= 0.0 && v < area2 && (!half || u + v < area2)
            }
            Self::Disc { radius, .. } => from.length_squared() < radius * radius,
            Self::Sphere { .. } => false,
        };
        (t.is_finite() && t >= t_min && inside).then_some(t)
    }
}

fn sphere_distance(centre: DVec3, radius: f64, line: &Line, t_min: f64) -> Option<f64> {
    let from = line.origin - centre;
    let (a, b) = (line.direction.length_squared(), from.dot(line.direction));
    let root = (b * b - a * (from.length_squared() - radius * radius)).sqrt();
    [(-b - root) / a, (-b + root) / a].into_iter().find(|t| *t >= t_min)
}

impl Geometry {
    /// A sphere around everything.
    pub fn bounds(&self) -> Bounds {
        let boxes = self.boxes.iter().flat_map(|b| [b.low, b.high]);
        let surfaces = self.surfaces.iter().flat_map(|surface| match surface.shape {
            Shape::Parallelogram { corner, edge_u, edge_v } => {
                [corner, corner + edge_u, corner + edge_v, corner + edge_u + edge_v]
            }
            Shape::Triangle { corner, edge_u, edge_v } => [corner, corner + edge_u, corner + edge_v, corner],
            Shape::Sphere { centre, radius } => {
                [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(|[a, b]| centre + radius * DVec3::new(a, b, a * b))
            }
            Shape::Disc { centre, radius, .. } => [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]]
                .map(|[a, b]| centre + radius * DVec3::new(a, b, a * b) * 1.5),
        });
        let points: Vec<DVec3> = boxes.chain(surfaces).collect();
        let (low, high) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
        if points.is_empty() { Bounds::default() } else { Bounds { centre, radius } }
    }

    /// The medium at a point, or NONE.
    pub fn medium_at(&self, x: DVec3) -> u32 {
        self.boxes.iter().rev().find(|b| b.holds(x)).map_or(NONE, |b| b.medium)
    }

    /// The distance to a surface, its number, counted from 1, and itself.
    fn nearest(&self, line: &Line, t_min: f64, t_max: f64) -> Option<(f64, u64, &Surface)> {
        let mut nearest: Option<(f64, u64, &Surface)> = None;
        for (number, surface) in (1..).zip(&self.surfaces) {
            let Some(t) = surface.shape.distance(line, t_min.max(1e-9)) else { continue };
            if t < nearest.map_or(t_max, |(t, ..)| t) {
                nearest = Some((t, number, surface));
            }
        }
        nearest
    }

    /// Media along the line up to `length`. None if they are too many.
    pub fn segments(&self, origin: DVec3, direction: DVec3, length: f64) -> Option<Vec<Segment>> {
        let line = Line { origin, direction };
        let mut hit = Hit::EMPTY;
        self.fill_segments(&line, length, &mut hit).then(|| hit.media().to_vec())
    }

    /// False if there are too many.
    fn fill_segments(&self, line: &Line, length: f64, hit: &mut Hit) -> bool {
        const MOST: usize = 32;
        let mut faces = [(f64::INFINITY, 0); MOST + 1];
        let mut count = 0;
        for (t, axis) in self.boxes.iter().filter_map(|b| b.crossings(line)).flatten() {
            if t > 0.0 && t < length && count < MOST {
                faces[count] = (t, axis);
                count += 1;
            }
        }
        faces[..count].sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        faces[count] = (length, 0);
        let mut start = 0.0;
        let mut used = 0;
        for (i, (end, axis)) in faces[..=count].iter().copied().enumerate() {
            // A face inside another medium of higher rank changes nothing, but may still end a segment.
            let middle = if end.is_finite() { 0.5 * (start + end) } else { start + 1.0 };
            let medium = self.medium_at(line.at(middle));
            if used == MAX_SEGMENTS {
                return false;
            }
            let normal = Vec3::from(if i == count { DVec3::ZERO } else { DVec3::AXES[axis] });
            hit.segments[used] = Segment { end: end as f32, medium, normal };
            (used, start) = (used + 1, end);
        }
        hit.segment_count = used as u32;
        true
    }

    fn answer(&self, ray: &Ray, hit: &mut Hit, to_surface: bool) {
        let line = Line { origin: ray.origin.wide(), direction: ray.direction.wide() };
        *hit = Hit::EMPTY;
        let mut length = f64::from(ray.t_max);
        if let Some((t, number, surface)) = self.nearest(&line, ray.t_min.into(), length) {
            (hit.kind, hit.t, hit.user) = (HIT_SURFACE, t as f32, number);
            (hit.material, hit.light) = (surface.material, surface.light);
            hit.normal = surface.shape.normal(line.at(t)).into();
            hit.shading_normal = hit.normal;
            // An occlusion query goes on through the surface: its media count as if nothing were there.
            length = if to_surface { t } else { length };
        }
        if !self.fill_segments(&line, length, hit) {
            hit.kind = HIT_OVERFLOW;
        }
        assert!(self.near(line.origin, ray.medium), "{ray:?} starts in medium {}", hit.segments[0].medium);
    }

    /// Whether a point lies in a medium, but for the rounding of single-precision coordinates.
    fn near(&self, x: DVec3, medium: u32) -> bool {
        const ROUNDING: f64 = 1e-5;
        let corners = (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) - 0.5);
        self.medium_at(x) == medium || corners.map(|c| x + c * ROUNDING).any(|x| self.medium_at(x) == medium)
    }
}

impl Queries for Geometry {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        rays.iter().zip(hits).for_each(|(ray, hit)| self.answer(ray, hit, true));
        Ok(())
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        rays.iter().zip(hits).for_each(|(ray, hit)| self.answer(ray, hit, false));
        Ok(())
    }
}
