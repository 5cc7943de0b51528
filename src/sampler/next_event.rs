//! Next-event estimation: one light, one point or direction on it, and how much of it arrives.

use super::interaction::Interaction;
use super::primary::{Slot, VertexNumbers, number, pair};
use crate::math::{Colour, DVec3, mean, transmittance};
use crate::medium::{Line, optical_depth_or_dark};
use crate::scene::{HIT_NONE, HIT_OVERFLOW, HIT_SURFACE, Hit, LightSample, Queries, Ray, Scene, Stop};
use crate::shift::Next;

/// An estimate of the light that arrives at a vertex from one light.
pub struct NextEvent {
    position: DVec3,
    pub next: Next,
    /// Unit vector to the light, and its distance.
    pub direction: DVec3,
    pub distance: f64,
    pub optical_depth: Colour,
    pub transmittance: Colour,
    /// cos/d² at the light; 1 for a direction.
    pub geometry: f64,
    /// f_p, or f_r·cos, at the vertex.
    pub scattering: Colour,
    /// Emission times MIS weight over the density of the sample.
    pub emitted: Colour,
    /// Whether the light emits differently towards other points.
    pub profile: bool,
    pub hit: Hit,
}

impl NextEvent {
    /// The estimate, to be multiplied by the throughput.
    pub fn received(&self) -> Colour {
        self.emitted * self.scattering * self.transmittance * self.geometry
    }

    /// The edge to the light.
    pub fn line<'s>(&'s self, scene: &'s Scene<'s>) -> Line<'s> {
        Line::new(scene.media, self.position, self.direction, self.distance, self.hit.media())
    }
}

/// Where a vertex' rays start: its medium on that side, and whether it is a surface.
pub struct Origin {
    pub medium: u32,
    pub t_min: f64,
}

/// What [`sample`] found.
pub enum Outcome {
    /// Nothing could arrive, and no ray was needed to see it.
    Nothing,
    Blocked,
    /// More media on the way than fit.
    Overflow,
    Light(NextEvent),
}

/// A next-event estimate at `vertex`. `survival` is the probability that the path goes on from there, part of the competing
/// technique's density. `origin` tells where a ray in a given direction starts.
pub fn sample(
    scene: &Scene,
    queries: &impl Queries,
    vertex: &Interaction,
    survival: f64,
    numbers: &VertexNumbers,
    origin: impl Fn(DVec3) -> Origin,
) -> Result<Outcome, Stop> {
    if vertex.is_specular() {
        return Ok(Outcome::Nothing);
    }
    let Some((index, light, rest)) = scene.lights.pick(number(numbers, Slot::Light)) else { return Ok(Outcome::Nothing) };
    let pick = scene.lights.probability(index);
    let u = pair(numbers, Slot::LightU, Slot::LightV);
    let aim = match light.sample(u) {
        LightSample::Sky { pdf, .. } if !(pdf > 0.0) => return Ok(Outcome::Nothing),
        LightSample::Sky { to_light, pdf } => Aim { next: Next::Direction(to_light), pdf: pick * pdf, rival: true },
        LightSample::Direction { to_light } => Aim { next: Next::Direction(to_light), pdf: pick, rival: false },
        LightSample::Point { position, normal, pdf } => {
            Aim { next: Next::Point { position, normal }, pdf: pick * pdf, rival: normal.is_some() }
        }
        LightSample::AnyDirection => {
            let Some(sample) = vertex.sample(u, rest) else { return Ok(Outcome::Nothing) };
            let Some(pdf) = sample.pdf else { return Ok(Outcome::Nothing) };
            Aim { next: Next::Direction(sample.direction), pdf: pick * pdf, rival: true }
        }
    };
    let (direction, distance) = aim.next.seen_from(vertex.position);
    let geometry = aim.next.geometry(direction, distance);
    let scattering = vertex.eval(direction);
    let emission = light.emission(-direction);
    let dark = !(emission.max_element() > 0.0);
    if dark || !(geometry > 0.0 && scattering.max_element() > 0.0) {
        return Ok(Outcome::Nothing);
    }
    let Origin { medium, t_min } = origin(direction);
    // Next to the light it is the epsilons that have to give way.
    let t_min = t_min.min(0.25 * distance);
    let ray = Ray { t_min: t_min as f32, ..Ray::free(vertex.position, direction, aim.next.t_max(distance), medium) };
    let mut hits = [Hit::EMPTY];
    queries.occluded(&[ray], &mut hits)?;
    let [hit] = hits;
    match hit.kind {
        HIT_NONE => hit.check(scene)?,
        HIT_OVERFLOW => return Ok(Outcome::Overflow),
        HIT_SURFACE => return Ok(Outcome::Blocked),
        _ => return Err(Stop::InvalidHit),
    }
    let line = Line::new(scene.media, vertex.position, direction, distance, hit.media());
    let optical_depth = optical_depth_or_dark(&line);
    let transmittance = transmittance(optical_depth);
    // The balance heuristic against finding the light by going on: both densities per unit of the light's own measure.
    let going_on = if aim.rival { survival * vertex.pdf(direction) * mean(transmittance) * geometry } else { 0.0 };
    let emitted = emission / (aim.pdf + going_on);
    Ok(Outcome::Light(NextEvent {
        position: vertex.position,
        next: aim.next,
        direction,
        distance,
        optical_depth,
        transmittance,
        geometry,
        scattering,
        emitted,
        profile: light.has_profile(),
        hit,
    }))
}

/// A sampled place of light.
struct Aim {
    next: Next,
    /// Per area or solid angle; a mere probability for lights without extent.
    pdf: f64,
    /// Whether a path that goes on can find the same light.
    rival: bool,
}
