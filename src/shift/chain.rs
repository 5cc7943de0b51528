//! Light that reaches the run through specular surfaces. A shifted path leaves the run in the same direction and goes on through the
//! same kinds of events, reflected or refracted as the surfaces that it meets want it, to whatever light it then finds.
//!
//! In the measure of that direction the chain adds nothing but its transmittances, reflectances and the light's radiance, and the map
//! from x to y has Jacobian 1. (Theory for specular neighbours moves along the edge instead: it has no chain to trace, but one dimension.)

use super::evaluate::{CHUNK, Evaluation, ray};
use super::place::Member;
use crate::math::{Colour, DVec2, DVec3, luminance, transmittance};
use crate::medium::{Line, NONE, optical_depth_or_dark};
use crate::scene::{Bsdf, HIT_OVERFLOW, HIT_SURFACE, Hit, Queries, Ray, Scene, Stop, SurfacePoint, surface_epsilon};

/// Most specular surfaces in a row.
pub const MAX_CHAIN: usize = 8;

/// A chain of specular surfaces between the run and a light.
#[derive(Clone, Copy, Debug)]
pub struct Chain {
    /// Unit direction in which it leaves the run, and from which of its vertices.
    pub direction: DVec3,
    pub from: usize,
    /// Which surfaces it passes, and does not reflect from.
    transmitted: [bool; MAX_CHAIN],
    length: usize,
    /// Transmittances, reflectances and emission at x.
    pub value: Colour,
    /// What stays.
    pub rest: Colour,
}

/// A ray that a specular surface sends on.
pub struct Bounce {
    pub direction: DVec3,
    /// Reflectance, or what the surface lets through.
    pub value: Colour,
    pub transmitted: bool,
}

impl Bounce {
    /// What the sampled path did.
    pub fn new(bsdf: &Bsdf, at: &SurfacePoint, to_camera: DVec3, direction: DVec3) -> Self {
        let transmitted = at.normal.dot(to_camera) * at.normal.dot(direction) < 0.0;
        Self { direction, value: bsdf.eval_or_weight(at, to_camera, direction), transmitted }
    }

    /// The one event of that kind at another surface; None if there is none.
    fn like(transmitted: bool, bsdf: &Bsdf, at: &SurfacePoint, to_camera: DVec3) -> Option<Self> {
        // The extreme numbers choose reflection and refraction, if they are possible.
        let lobe = if transmitted { 1.0 } else { 0.0 };
        let sample = if bsdf.is_specular() { bsdf.sample(at, to_camera, DVec2::ZERO, lobe) } else { None }?;
        Some(Self::new(bsdf, at, to_camera, sample.direction)).filter(|bounce| bounce.transmitted == transmitted)
    }
}

impl Chain {
    /// A chain that leaves the run's vertex `from`; `rest` as it is after sampling the direction.
    pub fn new(direction: DVec3, from: usize, rest: Colour) -> Self {
        Self { direction, from, transmitted: [false; MAX_CHAIN], length: 0, value: Colour::ONE, rest }
    }

    /// An edge, and the probability with which it was passed.
    pub fn pass(&mut self, optical_depth: Colour, probability: f64) {
        self.value *= transmittance(optical_depth);
        self.rest /= probability;
    }

    /// A surface, `weight` being value over probability there. False: the chain is too long.
    pub fn bounce(&mut self, bounce: &Bounce, weight: Colour) -> bool {
        let Some(slot) = self.transmitted.get_mut(self.length) else { return false };
        *slot = bounce.transmitted;
        self.length += 1;
        self.value *= bounce.value;
        self.rest *= luminance(weight) / luminance(bounce.value);
        true
    }

    fn events(&self) -> &[bool] {
        self.transmitted.get(..self.length).unwrap_or(&[])
    }
}

/// The end of a shifted chain, as far as it has been followed.
#[derive(Clone, Copy)]
struct Tip {
    ray: Ray,
    origin: DVec3,
    direction: DVec3,
    /// A f_p and the chain's factors so far.
    value: Colour,
}

/// Where a tip's ray has led.
enum Found {
    On(Tip),
    Light(Colour),
    Nothing,
}

impl Tip {
    /// From where its ray hit, by `event`; None: to a light.
    fn follow(&self, scene: &Scene, hit: &Hit, event: Option<bool>) -> Found {
        let distance = if hit.kind == HIT_SURFACE { f64::from(hit.t) } else { f64::INFINITY };
        let line = Line::new(scene.media, self.origin, self.direction, distance, hit.media());
        let value = self.value * transmittance(optical_depth_or_dark(&line));
        let Some(transmitted) = event else { return Found::Light(value * self.emission(scene, hit)) };
        let bsdf = scene.materials.get(hit.material as usize).filter(|_| hit.kind == HIT_SURFACE);
        let at = hit.at(self.origin + distance * self.direction);
        let Some(bounce) = bsdf.and_then(|bsdf| Bounce::like(transmitted, bsdf, &at, -self.direction)) else {
            return Found::Nothing;
        };
        let origin = at.position;
        let medium = hit.medium_beyond(bounce.direction.dot(at.normal) > 0.0);
        let t_min = surface_epsilon(origin, distance) as f32;
        let ray = Ray { t_min, ..Ray::free(origin, bounce.direction, f64::INFINITY, medium) };
        Found::On(Self { ray, origin, direction: bounce.direction, value: value * bounce.value })
    }

    fn emission(&self, scene: &Scene, hit: &Hit) -> Colour {
        let front = hit.unit_normal().dot(self.direction) < 0.0;
        let index = match hit.kind {
            HIT_SURFACE if front => hit.light,
            HIT_SURFACE => NONE,
            _ => scene.lights.environment.unwrap_or(NONE),
        };
        scene.lights.get(index).map_or(Colour::ZERO, |light| light.emission(-self.direction))
    }
}

impl<Q: Queries> Evaluation<'_, Q> {
    /// The values of the chain's group, for the members that have reached the vertex where it begins.
    pub(super) fn follow(&mut self, chunk: &mut [Member], chain: &Chain) -> Result<(), Stop> {
        let mut tips = [None; CHUNK];
        for (tip, member) in tips.iter_mut().zip(chunk.iter()) {
            *tip = member.value.as_ref().filter(|value| value.carries(chain.from)).map(|value| Tip {
                ray: ray(value, self.path, chain.from, chain.direction, f64::INFINITY, f64::INFINITY),
                origin: value.vertex(self.path, chain.from),
                direction: chain.direction,
                value: value.towards(self.scene, self.path, chain.from, chain.direction),
            });
        }
        let events = chain.events().iter().map(|event| Some(*event)).chain([None]);
        for event in events {
            self.follow_all(chunk, &mut tips, event)?;
        }
        Ok(())
    }

    fn follow_all(&mut self, chunk: &mut [Member], tips: &mut [Option<Tip>; CHUNK], event: Option<bool>) -> Result<(), Stop> {
        let mut rays = [Ray::default(); CHUNK];
        let mut count = 0;
        for tip in tips.iter_mut() {
            *tip = tip.filter(|tip| tip.value.max_element() > 0.0);
            if let (Some(tip), Some(ray)) = (tip, rays.get_mut(count)) {
                *ray = tip.ray;
                count += 1;
            }
        }
        let (Some(rays), Some(hits)) = (rays.get(..count), self.hits.get_mut(..count)) else { return Ok(()) };
        if rays.is_empty() {
            return Ok(());
        }
        self.stats.rays += count as u64;
        self.queries.intersect(rays, hits)?;
        let mut hits = self.hits.iter();
        for (tip, member) in tips.iter_mut().zip(chunk) {
            let Some(last) = tip.take() else { continue };
            let Some(hit) = hits.next() else { continue };
            if hit.kind == HIT_OVERFLOW {
                self.stats.overflows += 1;
                continue;
            }
            hit.check(self.scene)?;
            match (last.follow(self.scene, hit, event), &mut member.value) {
                (Found::On(next), _) => *tip = Some(next),
                (Found::Light(colour), Some(value)) => value.reach_light_by_chain(colour),
                _ => {}
            }
        }
        Ok(())
    }
}
