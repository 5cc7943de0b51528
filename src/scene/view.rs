//! What the camera sees through an image point: the first surface, and the media before it.

use super::{Bsdf, CameraRay, HIT_OVERFLOW, HIT_SURFACE, Hit, ImagePoint, Queries, Ray, Scene, Stop};
use crate::math::{Colour, DVec2, absorptance, mean};
use crate::medium::{Flight, Line, Milestones, sample_distance};
use core::slice::from_mut;

/// A camera ray, traced.
#[derive(Clone, Copy, Debug)]
pub struct View {
    pub pixel: DVec2,
    pub ray: CameraRay,
    /// Of kind `HIT_OVERFLOW` if there are more media than fit: nothing is known then.
    pub hit: Hit,
    /// Once they have been looked for.
    collisions: Option<Collisions>,
}

/// What collisions with all media along a camera ray are like.
#[derive(Clone, Copy, Debug)]
pub struct Collisions {
    pub optical_depth: Colour,
    /// That of one anywhere on the way, if distances are sampled to the end.
    pub probability: f64,
    milestones: Milestones,
}

impl Collisions {
    fn along(line: &Line) -> Self {
        let (milestones, optical_depth) = Milestones::along(line);
        Self { optical_depth, probability: mean(absorptance(optical_depth)), milestones }
    }
}

/// Rays per query.
const CHUNK: usize = 8;

impl View {
    /// None.
    pub fn none() -> Self {
        Self::along(DVec2::ZERO, CameraRay::default())
    }

    /// To be traced.
    pub fn through(scene: &Scene, pixel: DVec2, lens: DVec2) -> Self {
        Self::along(pixel, scene.camera.ray(pixel, lens))
    }

    /// That of an image point, to be traced.
    pub fn to(image: &ImagePoint) -> Self {
        Self::along(image.pixel, image.ray)
    }

    fn along(pixel: DVec2, ray: CameraRay) -> Self {
        Self { pixel, ray, hit: Hit::EMPTY, collisions: None }
    }

    /// Traces all rays.
    pub fn trace(views: &mut [Self], scene: &Scene, queries: &impl Queries) -> Result<(), Stop> {
        let to_infinity = |view: &Self| view.ray.free(&scene.camera, f64::INFINITY);
        for chunk in views.chunks_mut(CHUNK) {
            if let [view] = chunk {
                // The usual case, without copies.
                queries.intersect(&[to_infinity(view)], from_mut(&mut view.hit))?;
                view.check(scene)?;
                continue;
            }
            let mut rays = [Ray::default(); CHUNK];
            let mut hits = [const { Hit::EMPTY }; CHUNK];
            for (ray, view) in rays.iter_mut().zip(chunk.iter()) {
                *ray = to_infinity(view);
            }
            queries.intersect(&rays[..chunk.len()], &mut hits[..chunk.len()])?;
            for (view, hit) in chunk.iter_mut().zip(hits) {
                view.hit = hit;
                view.check(scene)?;
            }
        }
        Ok(())
    }

    fn check(&self, scene: &Scene) -> Result<(), Stop> {
        if self.hit.kind == HIT_OVERFLOW { Ok(()) } else { self.hit.check(scene) }
    }

    /// How far it goes from x_0.
    pub fn length(&self) -> f64 {
        if self.hit.kind == HIT_SURFACE { self.ray.start + f64::from(self.hit.t) } else { f64::INFINITY }
    }

    /// The edge along it, `length` long.
    pub fn line<'s>(&'s self, scene: &'s Scene<'s>, length: f64) -> Line<'s> {
        self.ray.line(scene, length, self.hit.media())
    }

    /// Collisions along all of it, looked for once.
    pub fn collisions(&mut self, scene: &Scene) -> &Collisions {
        let length = self.length();
        let Self { ray, hit, collisions, .. } = self;
        collisions.get_or_insert_with(|| Collisions::along(&ray.line(scene, length, hit.media())))
    }

    /// The same, if they have been looked for.
    pub fn known_collisions(&self) -> Option<&Collisions> {
        self.collisions.as_ref()
    }

    /// A collision, or the end: [`sample_distance`] along all of it.
    pub fn sample_distance(&self, scene: &Scene, u: f64) -> Flight {
        let line = self.line(scene, self.length());
        self.collisions.as_ref().map_or_else(|| sample_distance(&line, u), |known| known.milestones.sample_distance(&line, u))
    }

    /// Where nothing scatters at the end of the ray, only those distance numbers are used that make a collision: their share.
    pub fn collision_share(&mut self, scene: &Scene) -> f64 {
        let bsdf = scene.materials.get(self.hit.material as usize).filter(|_| self.hit.kind == HIT_SURFACE);
        if bsdf.is_none_or(Bsdf::is_black) { self.collisions(scene).probability } else { 1.0 }
    }
}
