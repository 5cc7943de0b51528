//! A unidirectional volumetric path tracer: next-event estimation, multiple importance sampling with the true pdfs (free flight
//! and roulette included), Russian roulette; and a batch of shifts for every path whose first vertex may move.

use super::camera_samples::{CameraSample, CameraSamples};
use super::first_vertices::FirstVertices;
use super::interaction::{Interaction, Scatterer};
use super::lengths::Lengths;
use super::next_event::{self, Origin, Outcome};
use super::primary::{PrimarySample, Slot, VertexNumbers, number, pair};
use super::record::{Arrival, Record};
use crate::film::Film;
use crate::math::{Colour, DVec3, transmittance};
use crate::medium::{Collision, Flight, Line, NONE, Segment, sample_distance};
use crate::scene::{Bsdf, HIT_OVERFLOW, HIT_SURFACE, Hit, ImagePoint, Light, Queries, Ray, Scene, Stop, View, surface_epsilon};
use crate::shift::{self, BatchStats, Bounce, Next, Place, Scratch, volume_to_image};
use core::ops::Range;
use core::slice::from_mut;

#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Most edges of a path: 1 is only directly visible emission.
    pub max_depth: u32,
    /// Vertices before Russian roulette begins.
    pub rr_depth: u32,
    pub seed: u64,
    pub shift: Option<shift::Options>,
    /// Paths that another sampler renders: of these lengths, but light that the camera sees directly, or through nothing but specular
    /// surfaces, only if length 1 is among them. No sampler finds that as easily as this one.
    pub left_out: Lengths,
    /// Paths that are rendered.
    pub first: FirstVertices,
}

impl Options {
    /// Whether paths of this length are left out; `direct`: those without a vertex that scatters.
    fn leaves_out(&self, length: u32, direct: bool) -> bool {
        self.left_out.contains(length) && !(direct && self.left_out.first > 1)
    }

    /// Whether any path longer than `length` is not.
    fn goes_beyond(&self, length: u32, direct: bool) -> bool {
        let open = |length| length <= self.max_depth && !self.leaves_out(length, direct);
        open(length + 1) || open(self.left_out.last.max(length).saturating_add(1))
    }
}

/// Counts of what was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    pub paths: u64,
    pub rays: u64,
    pub occlusion_rays: u64,
    /// Paths that got a batch.
    pub shifted_paths: u64,
    /// Offsets tried; one that changes several contributions differently counts once for each.
    pub shifts: u64,
    /// Those whose splat stayed.
    pub stays: u64,
    /// Rays that crossed more media than fit; their path ends there.
    pub overflows: u64,
}

/// The sampler; one may be used by any number of threads.
#[derive(Clone, Copy, Debug)]
pub struct PathTracer<'a, Q> {
    pub scene: &'a Scene<'a>,
    pub queries: &'a Q,
    pub options: Options,
}

/// The largest probability of going on under Russian roulette, and the number of vertices from which on there is roulette whatever the
/// options say: no path is endless, even without absorption.
const MAX_SURVIVAL: f64 = 0.95;
const LONGEST_SURE_PATH: u32 = 1 << 16;

/// Of the walks that begin edges that are left out, one for so many of them goes on.
const EDGES_PER_WALK: f64 = 4.0;

impl<Q: Queries> PathTracer<'_, Q> {
    /// One path through each of `pixels` of the camera's crop, with all its splats. Pixels are numbered row by row; with tiles, tile by
    /// tile.
    pub fn sample_pixels(&self, pass: u64, pixels: Range<u32>, film: &mut Film, stats: &mut Stats) -> Result<(), Stop> {
        let Options { seed, shift, .. } = self.options;
        let mut samples = CameraSamples::new(self.scene, self.queries, shift, seed, pass)?;
        let mut scratch = Scratch::default();
        let mut record = Record::new(shift.as_ref());
        for index in pixels {
            let CameraSample { pixel, place, view, mut numbers, .. } = samples.sample(index, stats)?;
            record.clear();
            self.trace(view, &mut numbers, &mut record, stats)?;
            let plain = record.plain;
            if let (Some(options), Some(path)) = (&samples.shift, record.finish()) {
                let (tile, draw) = (samples.tile(), samples.draw(pixel));
                let batch = scratch.shift(self.scene, self.queries, options, path, tile, draw, |p, c| film.add(p, c))?;
                stats.add_batch(&batch);
            }
            // All of a path or nothing: a callback can stop the shifts, but only before their first splat.
            film.add(place, plain);
            stats.paths += 1;
        }
        Ok(())
    }

    /// The whole path that begins with `view`, from primary sample numbers, into an empty record.
    pub fn trace(
        &self,
        view: View,
        numbers: &mut impl PrimarySample,
        record: &mut Record,
        stats: &mut Stats,
    ) -> Result<(), Stop> {
        if view.hit.kind == HIT_OVERFLOW {
            stats.overflows += 1;
            return Ok(());
        }
        let mut walk = Walk::from_camera(self, view, record, stats);
        for depth in 1..=self.options.max_depth {
            let numbers = numbers.vertex(depth);
            let Some(vertex) = walk.advance(depth, &numbers)? else { break };
            if depth == 1 && !walk.may_begin_with(&vertex) {
                break;
            }
            walk.direct = walk.direct && vertex.interaction.is_specular();
            if !self.options.goes_beyond(depth, walk.direct) || !walk.scatter(depth, &vertex, &numbers)? {
                break;
            }
        }
        Ok(())
    }
}

impl Stats {
    pub(super) fn add_batch(&mut self, batch: &BatchStats) {
        self.shifted_paths += 1;
        self.shifts += batch.shifts;
        self.stays += batch.stays;
        self.rays += batch.rays;
        self.occlusion_rays += batch.occlusion_rays;
        self.overflows += batch.overflows;
    }
}

/// How the current ray was sampled, for weighting the light it finds.
#[derive(Clone, Copy)]
struct Sampled {
    /// Per steradian, times the probability of going on.
    pdf: f64,
    /// Density of the direction alone.
    direction_pdf: f64,
}

/// A path in the making.
struct Walk<'a, Q> {
    scene: &'a Scene<'a>,
    queries: &'a Q,
    options: &'a Options,
    stats: &'a mut Stats,
    record: &'a mut Record,
    /// Its first ray.
    view: View,
    /// What the current ray meets. Hits are large: this one stays where the host writes it.
    hit: Hit,
    origin: DVec3,
    direction: DVec3,
    /// Where the ray begins: at the near plane for the first one.
    start: f64,
    t_min: f64,
    medium: u32,
    throughput: Colour,
    /// Product of the squared indices of refraction entered; undoes the compression of radiance in the roulette.
    eta_squared: f64,
    /// None after the camera and specular vertices: nothing else finds the same light.
    sampled: Option<Sampled>,
    /// Whether no vertex so far scatters.
    direct: bool,
    /// Whether another sampler renders all that it can still become but for very long paths.
    in_tail: bool,
}

/// A vertex to scatter at, and what its rays need.
struct Vertex<'a> {
    interaction: Interaction<'a>,
    /// How far from rays' start surfaces count; 0 in a medium.
    epsilon: f64,
}

impl<'a, Q: Queries> Walk<'a, Q> {
    fn from_camera(tracer: &'a PathTracer<'a, Q>, view: View, record: &'a mut Record, stats: &'a mut Stats) -> Self {
        Self {
            scene: tracer.scene,
            queries: tracer.queries,
            options: &tracer.options,
            stats,
            record,
            view,
            hit: view.hit,
            origin: view.ray.origin,
            direction: view.ray.direction,
            start: view.ray.start,
            t_min: 0.0,
            medium: tracer.scene.camera.medium,
            throughput: Colour::ONE,
            eta_squared: 1.0,
            sampled: None,
            direct: true,
            in_tail: false,
        }
    }

    /// Goes along the current ray to the next vertex, and records what light it meets. None: the path ends.
    fn advance(&mut self, depth: u32, numbers: &VertexNumbers) -> Result<Option<Vertex<'a>>, Stop> {
        if depth > 1 && !self.intersect()? {
            return Ok(None);
        }
        let on_surface = self.hit.kind == HIT_SURFACE;
        let length = if on_surface { self.start + f64::from(self.hit.t) } else { f64::INFINITY };
        let u = number(numbers, Slot::Distance);
        let (share, flight) = if depth == 1 {
            let share = self.look();
            if !self.leads_on() {
                return Ok(None);
            }
            (share, self.view.sample_distance(self.scene, share * u))
        } else {
            (1.0, sample_distance(&self.line(length, self.hit.media()), u))
        };
        match flight {
            Flight::Collision(collision) => Ok(self.collide(depth, &collision, share)),
            // Light that arrives with probability 0 has underflowed.
            Flight::Passed { probability, .. } if !(probability > 0.0) => Ok(None),
            Flight::Passed { optical_depth, probability } => Ok(self.arrive(depth, length, optical_depth, probability)),
        }
    }

    /// What the camera sees directly along its first edge counts at its expected value, Tr·Le. Returns the share of the distance
    /// numbers that lead on: where nothing scatters at the edge's end, only those that make a collision.
    fn look(&mut self) -> f64 {
        let hit = &self.hit;
        let light = match hit.kind {
            HIT_SURFACE if hit.unit_normal().dot(self.direction) < 0.0 => hit.light,
            HIT_SURFACE => NONE,
            _ => self.scene.lights.environment.unwrap_or(NONE),
        };
        if let Some(light) =
            self.scene.lights.get(light).filter(|_| self.options.first.none && !self.options.leaves_out(1, true))
        {
            let optical_depth = self.view.collisions(self.scene).optical_depth;
            self.record.emitted(transmittance(optical_depth), light.emission(-self.direction));
        }
        self.view.collision_share(self.scene)
    }

    /// Whether there are longer paths to render that begin with this ray: by a collision, or from the surface.
    fn leads_on(&self) -> bool {
        let hit = &self.hit;
        let bsdf = self.scene.materials.get(hit.material as usize).filter(|_| hit.kind == HIT_SURFACE);
        self.options.goes_beyond(1, false) || bsdf.is_some_and(Bsdf::is_specular) && self.options.goes_beyond(1, true)
    }

    fn may_begin_with(&self, vertex: &Vertex) -> bool {
        let first = &self.options.first;
        match vertex.interaction.scatterer {
            Scatterer::Medium(_) => first.medium,
            Scatterer::Surface { bsdf, .. } if bsdf.is_specular() => first.specular,
            Scatterer::Surface { .. } => first.surface,
        }
    }

    /// Finds the nearest surface and the media up to it. False: they are too many.
    fn intersect(&mut self) -> Result<bool, Stop> {
        let origin = self.origin + self.start * self.direction;
        let ray = Ray { t_min: self.t_min as f32, ..Ray::free(origin, self.direction, f64::INFINITY, self.medium) };
        self.stats.rays += 1;
        self.queries.intersect(&[ray], from_mut(&mut self.hit))?;
        if self.hit.kind == HIT_OVERFLOW {
            self.stats.overflows += 1;
            return Ok(false);
        }
        self.hit.check(self.scene)?;
        Ok(true)
    }

    fn line<'s>(&self, length: f64, segments: &'s [Segment]) -> Line<'s>
    where
        'a: 's,
    {
        Line {
            start: self.start,
            start_normal: self.scene.camera.forward,
            segments_start: self.start,
            ..Line::new(self.scene.media, self.origin, self.direction, length, segments)
        }
    }

    /// A collision in a medium, at a distance of whose numbers a `share` was used.
    fn collide(&mut self, depth: u32, collision: &Collision, share: f64) -> Option<Vertex<'a>> {
        let Collision { t, medium: index, optical_depth, extinction, .. } = *collision;
        let pdf = collision.pdf / share;
        let medium = self.scene.media.get(index as usize).filter(|_| pdf > 0.0)?;
        let position = self.origin + t * self.direction;
        let sigma_s = medium.albedo * extinction;
        self.throughput *= sigma_s * transmittance(optical_depth) / pdf;
        if !(self.throughput.max_element() > 0.0) {
            return None;
        }
        let arrival = Arrival {
            line: self.line(t, self.hit.media()),
            optical_depth,
            density: pdf,
            next: Next::Point { position, normal: None },
            place: Some(Place::Medium(index)),
            connects: true,
            emits: false,
            sigma_s,
            phase: Some(medium.phase),
        };
        if depth == 1 {
            let image = ImagePoint { pixel: self.view.pixel, ray: self.view.ray, distance: t };
            let density = volume_to_image(&self.scene.camera, &image) * pdf;
            self.record.first(image, density, &arrival);
        } else {
            self.record.later(&arrival);
        }
        self.medium = index;
        let scatterer = Scatterer::Medium(medium.phase);
        Some(Vertex { interaction: Interaction { position, to_camera: -self.direction, scatterer }, epsilon: 0.0 })
    }

    /// The end of the ray: a surface, or the environment.
    fn arrive(&mut self, depth: u32, length: f64, optical_depth: Colour, probability: f64) -> Option<Vertex<'a>> {
        self.throughput *= transmittance(optical_depth) / probability;
        let hit = &self.hit;
        let bsdf = if hit.kind == HIT_SURFACE { Some(self.scene.materials.get(hit.material as usize)?) } else { None };
        let normal = hit.unit_normal();
        let position = self.origin + length * self.direction;
        let arrival = Arrival {
            line: self.line(length, hit.media()),
            optical_depth,
            density: probability,
            next: bsdf.map_or(Next::Direction(self.direction), |bsdf| Next::Point {
                position,
                normal: Some(bsdf.facing(normal, -self.direction)),
            }),
            place: bsdf.and_then(|bsdf| Place::on_surface(bsdf, hit, self.direction)),
            connects: bsdf.is_none_or(Bsdf::is_lambertian),
            emits: hit.kind == HIT_SURFACE && hit.light != NONE,
            sigma_s: Colour::ONE,
            phase: None,
        };
        if depth > 1 {
            self.record.later(&arrival);
        } else {
            let image = ImagePoint { pixel: self.view.pixel, ray: self.view.ray, distance: length };
            self.record.first(image, probability, &arrival);
        }
        let Some(bsdf) = bsdf else {
            if depth > 1 {
                self.meet(depth, self.scene.lights.environment?, 1.0, probability);
            }
            return None;
        };
        let cosine = -normal.dot(self.direction);
        if depth > 1 && hit.light != NONE && cosine > 0.0 {
            self.meet(depth, hit.light, cosine / (length * length), probability);
        }
        let scatterer = Scatterer::Surface { bsdf, normal, user: self.hit.user };
        let interaction = Interaction { position, to_camera: -self.direction, scatterer };
        Some(Vertex { interaction, epsilon: surface_epsilon(position, length) })
    }

    /// Records the emission of a light that the ray has reached; `geometry` takes solid angle to the light's own measure.
    fn meet(&mut self, depth: u32, index: u32, geometry: f64, probability: f64) {
        let Some(light) = self.scene.lights.get(index).filter(|_| !self.options.leaves_out(depth, self.direct)) else { return };
        let mis = self.sampled.map_or(1.0, |sampled| {
            let pick = self.scene.lights.probability(index);
            let going_on = sampled.pdf * probability * geometry;
            let next_event = pick
                * match light {
                    Light::Environment { .. } => sampled.direction_pdf,
                    Light::EnvironmentMap(_) | Light::CustomSky(_) => light.direction_pdf(-self.direction),
                    light => light.area_pdf(),
                };
            if next_event > 0.0 { going_on / (going_on + next_event) } else { 1.0 }
        });
        self.record.emitted(self.throughput, light.emission(-self.direction) * mis);
    }

    /// Next-event estimation at a vertex, then a new direction. False: the path ends.
    fn scatter(&mut self, depth: u32, vertex: &Vertex, numbers: &VertexNumbers) -> Result<bool, Stop> {
        let survival = self.survival(depth) * self.enter_tail(depth);
        let origin = |direction| self.origin_of(vertex, direction);
        let outcome = if self.options.leaves_out(depth + 1, false) {
            Outcome::Nothing
        } else {
            next_event::sample(self.scene, self.queries, &vertex.interaction, survival, numbers, origin)?
        };
        match outcome {
            Outcome::Nothing => {}
            Outcome::Blocked => self.stats.occlusion_rays += 1,
            Outcome::Overflow => {
                self.stats.occlusion_rays += 1;
                self.stats.overflows += 1;
            }
            Outcome::Light(event) => {
                self.stats.occlusion_rays += 1;
                self.record.next_event(self.scene, self.throughput, &event);
            }
        }
        if number(numbers, Slot::Survival) >= survival {
            return Ok(false);
        }
        let u = pair(numbers, Slot::DirectionU, Slot::DirectionV);
        let Some(sample) = vertex.interaction.sample(u, number(numbers, Slot::Lobe)) else { return Ok(false) };
        let weight = sample.weight / survival;
        self.throughput *= weight;
        match (&vertex.interaction.scatterer, sample.pdf) {
            (Scatterer::Surface { bsdf, normal, user }, None) => {
                let at = vertex.interaction.surface(*normal, *user);
                let bounce = Bounce::new(bsdf, &at, vertex.interaction.to_camera, sample.direction);
                self.record.bounced(&bounce, weight);
            }
            _ => self.record.end_chain(),
        }
        self.record.scattered(sample.direction, weight, sample.pdf.unwrap_or(1.0), survival);
        let Origin { medium, t_min } = self.origin_of(vertex, sample.direction);
        (self.origin, self.direction, self.start) = (vertex.interaction.position, sample.direction, 0.0);
        (self.medium, self.t_min) = (medium, t_min);
        self.eta_squared *= sample.eta_squared;
        self.sampled = sample.pdf.map(|pdf| Sampled { pdf: pdf * survival, direction_pdf: pdf });
        Ok(self.throughput.max_element() > 0.0)
    }

    /// Probability of going on from the vertex reached at `depth`.
    fn survival(&self, depth: u32) -> f64 {
        if depth < self.options.rr_depth.min(LONGEST_SURE_PATH) {
            return 1.0;
        }
        (self.throughput.max_element() * self.eta_squared).min(MAX_SURVIVAL)
    }

    /// Probability of going on where the next edges' lengths are left out: what lies beyond is so little that few walks need to get there.
    fn enter_tail(&mut self, depth: u32) -> f64 {
        if self.in_tail || !self.options.leaves_out(depth + 1, self.direct) {
            return 1.0;
        }
        self.in_tail = true;
        let left_out = f64::from(self.options.left_out.last - depth);
        (EDGES_PER_WALK / left_out).min(1.0)
    }

    /// Where rays from a vertex in `direction` start.
    fn origin_of(&self, vertex: &Vertex, direction: DVec3) -> Origin {
        let medium = match vertex.interaction.scatterer {
            Scatterer::Medium(_) => self.medium,
            Scatterer::Surface { normal, .. } => self.hit.medium_beyond(direction.dot(normal) > 0.0),
        };
        Origin { medium, t_min: vertex.epsilon }
    }
}
