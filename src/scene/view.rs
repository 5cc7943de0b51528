//! What the camera sees through an image point: the first surface, and the media before it.

use super::{Bsdf, CameraRay, HIT_OVERFLOW, HIT_SURFACE, Hit, Queries, Ray, Scene, Stop};
use crate::math::{Colour, DVec2, absorptance, mean};
use crate::medium::{Line, optical_depth};
use core::slice::from_mut;

/// A camera ray, traced.
#[derive(Clone, Copy, Debug)]
pub struct View {
    pub pixel: DVec2,
    pub ray: CameraRay,
    /// Of kind `HIT_OVERFLOW` if there are more media than fit: nothing is known then.
    pub hit: Hit,
    /// Of all media along the ray, if it has been computed.
    pub optical_depth: Option<Colour>,
}

/// Rays per query.
const CHUNK: usize = 8;

impl View {
    /// To be traced.
    pub fn through(scene: &Scene, pixel: DVec2, lens: DVec2) -> Self {
        Self { pixel, ray: scene.camera.ray(pixel, lens), hit: Hit::EMPTY, optical_depth: None }
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

    /// τ along all of it, computed once. 0 for an overflow.
    pub fn whole_depth(&mut self, scene: &Scene) -> Colour {
        let known = self.optical_depth;
        let depth = known.unwrap_or_else(|| optical_depth(&self.line(scene, self.length())));
        self.optical_depth = Some(depth);
        depth
    }

    /// Where nothing scatters at the end of the ray, only those distance numbers are used that make a collision: their share.
    pub fn collision_share(&mut self, scene: &Scene) -> f64 {
        let bsdf = scene.materials.get(self.hit.material as usize).filter(|_| self.hit.kind == HIT_SURFACE);
        if bsdf.is_none_or(Bsdf::is_black) { mean(absorptance(self.whole_depth(scene))) } else { 1.0 }
    }
}
