//! Subpaths: random walks from the camera and from the lights. [V97 10]
//!
//! Walks from a light carry importance the other way, so light that passes a dielectric is not compressed: weights are those of radiance
//! times the squared ratio of the indices of refraction.

use super::vertex::{Edge, Kind, Vertex, disk_density};
use crate::math::{Colour, DVec2, DVec3, mean, orthonormal_basis, transmittance, uniform_disk};
use crate::medium::{Collision, Flight, Line, sample_distance};
use crate::sampler::path_tracer::Stats;
use crate::sampler::primary::{PrimarySample, Slot, VertexNumbers, number, pair};
use crate::scene::{BsdfSample, HIT_OVERFLOW, HIT_SURFACE, Hit, LightSample, Queries, Ray, Scene, Stop, View, surface_epsilon};

/// Most edges of a bidirectional path.
pub const MAX_LENGTH: usize = 64;

/// Most vertices of a subpath.
const MAX_VERTICES: usize = MAX_LENGTH + 1;

const EMPTY: Vertex = Vertex {
    kind: Kind::Camera,
    position: DVec3::ZERO,
    edge: Edge::NONE,
    throughput: Colour::ONE,
    extinction: Colour::ONE,
    density: 1.0,
    reverse: 0.0,
    epsilon: 0.0,
};

/// Room for a subpath.
pub struct Subpath<'a> {
    vertices: [Vertex<'a>; MAX_VERTICES],
    count: usize,
}

impl Default for Subpath<'_> {
    fn default() -> Self {
        Self { vertices: [EMPTY; MAX_VERTICES], count: 0 }
    }
}

impl<'a> Subpath<'a> {
    /// A copy.
    pub fn of(vertices: &[Vertex<'a>]) -> Self {
        let mut path = Self::default();
        vertices.iter().for_each(|vertex| path.push(*vertex));
        path
    }

    pub fn vertices(&self) -> &[Vertex<'a>] {
        self.vertices.get(..self.count).unwrap_or(&[])
    }

    pub(super) fn vertices_mut(&mut self) -> &mut [Vertex<'a>] {
        self.vertices.get_mut(..self.count).unwrap_or(&mut [])
    }

    pub fn clear(&mut self) {
        self.count = 0;
    }

    fn push(&mut self, vertex: Vertex<'a>) {
        if let Some(slot) = self.vertices.get_mut(self.count) {
            *slot = vertex;
            self.count += 1;
        }
    }

    fn set_reverse(&mut self, index: usize, density: f64) {
        if let Some(vertex) = self.vertices.get_mut(index) {
            vertex.reverse = density;
        }
    }
}

/// How long subpaths may get.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Most vertices.
    pub vertices: usize,
    /// Vertices before Russian roulette begins.
    pub rr_depth: usize,
}

/// The largest probability of going on under Russian roulette.
const MAX_SURVIVAL: f64 = 0.95;

/// The subpath that begins with `view`.
pub fn from_camera<'a, Q: Queries>(
    scene: &'a Scene<'a>,
    queries: &Q,
    view: &mut View,
    limits: Limits,
    numbers: &mut impl PrimarySample,
    path: &mut Subpath<'a>,
    stats: &mut Stats,
) -> Result<(), Stop> {
    path.clear();
    path.push(Vertex { position: view.ray.origin, ..EMPTY });
    if view.hit.kind == HIT_OVERFLOW {
        stats.overflows += 1;
        return Ok(());
    }
    if limits.vertices < 2 {
        return Ok(());
    }
    let share = view.collision_share(scene);
    let mut walk = Walk {
        scene,
        queries,
        path,
        stats,
        adjoint: false,
        direction: view.ray.direction,
        pdf: scene.camera.direction_density(view.ray.cosine),
        throughput: Colour::ONE,
        eta_squared: 1.0,
        from_far: false,
    };
    walk.go(limits, numbers, |walk, _, numbers| {
        let flight = view.sample_distance(scene, share * number(numbers, Slot::Distance));
        Ok(walk.arrive(view.ray.origin, &view.hit, view.length(), flight, share))
    })
}

/// The subpath from a light.
pub fn from_light<'a, Q: Queries>(
    scene: &'a Scene<'a>,
    queries: &Q,
    limits: Limits,
    numbers: &mut impl PrimarySample,
    path: &mut Subpath<'a>,
    stats: &mut Stats,
) -> Result<(), Stop> {
    path.clear();
    let first = numbers.vertex(0);
    let Some(vertex) = light_vertex(scene, &first) else { return Ok(()) };
    path.push(vertex);
    if limits.vertices < 2 {
        return Ok(());
    }
    let Some(start) = Start::new(scene, &vertex, pair(&first, Slot::DirectionU, Slot::DirectionV)) else { return Ok(()) };
    let mut walk = Walk {
        scene,
        queries,
        path,
        stats,
        adjoint: true,
        direction: start.direction,
        pdf: start.pdf,
        throughput: vertex.throughput * start.weight,
        eta_squared: 1.0,
        from_far: matches!(vertex.kind, Kind::Far { .. }),
    };
    walk.go(limits, numbers, |walk, hit, numbers| {
        let medium = vertex.medium(scene, start.direction);
        let ray = Ray { t_min: vertex.epsilon as f32, ..Ray::free(start.origin, start.direction, f64::INFINITY, medium) };
        let found = walk.fly(&ray, start.origin, hit, number(numbers, Slot::Distance))?;
        walk.from_far = false;
        Ok(found)
    })
}

/// A light, and a point on it or a direction to it.
fn light_vertex<'a>(scene: &'a Scene<'a>, numbers: &VertexNumbers) -> Option<Vertex<'a>> {
    let (index, light, _) = scene.lights.pick(number(numbers, Slot::Light))?;
    let pick = scene.lights.probability(index);
    let u = pair(numbers, Slot::LightU, Slot::LightV);
    let (position, kind, pdf) = match light.sample_far(u) {
        Some((to_light, pdf)) => (to_light, Kind::Far { light, index }, pdf),
        None => match light.sample(u) {
            LightSample::Point { position, normal, pdf } => (position, Kind::Light { light, index, normal }, pdf),
            _ => return None,
        },
    };
    let density = pick * pdf;
    let on_area = matches!(kind, Kind::Light { normal: Some(_), .. });
    let size = position.abs().max_element().max(scene.bounds.radius);
    let epsilon = if on_area { surface_epsilon(position, size) } else { 0.0 };
    (density > 0.0).then(|| Vertex { kind, position, throughput: Colour::splat(1.0 / density), density, epsilon, ..EMPTY })
}

/// The first ray from a light.
struct Start {
    origin: DVec3,
    direction: DVec3,
    /// Per steradian; from infinitely far away per area across the direction.
    pdf: f64,
    /// Emission over that density.
    weight: Colour,
}

impl Start {
    fn new(scene: &Scene, vertex: &Vertex, u: DVec2) -> Option<Self> {
        let (origin, direction, pdf) = match vertex.kind {
            Kind::Light { light, index, normal } => {
                let (u, aim) = scene.lights.guide(index, u);
                let (direction, pdf) = light.sample_direction(normal, u)?;
                (vertex.position, direction, aim * pdf)
            }
            Kind::Far { index, .. } => {
                let (u, aim) = scene.lights.guide(index, u);
                let (centre, radius) = (scene.bounds.centre, scene.bounds.radius);
                let (s, t) = orthonormal_basis(vertex.position);
                let d = uniform_disk(u) * radius;
                let origin = centre + d.x * s + d.y * t + radius * vertex.position;
                (origin, -vertex.position, aim * disk_density(&scene.bounds))
            }
            _ => return None,
        };
        let weight = vertex.emission(direction) / pdf;
        (pdf > 0.0 && weight.max_element() > 0.0).then_some(Self { origin, direction, pdf, weight })
    }
}

/// A walk, at the path's last vertex and about to leave it.
struct Walk<'a, 'w, Q> {
    scene: &'a Scene<'a>,
    queries: &'w Q,
    path: &'w mut Subpath<'a>,
    stats: &'w mut Stats,
    /// From a light.
    adjoint: bool,
    direction: DVec3,
    /// Density of the direction.
    pdf: f64,
    throughput: Colour,
    /// Product of the squared indices of refraction entered; undoes the compression of radiance in the roulette.
    eta_squared: f64,
    /// Whether the ray comes from infinitely far away: `pdf` is then per area across it.
    from_far: bool,
}

impl<'a, Q: Queries> Walk<'a, '_, Q> {
    /// `first` makes the second vertex, the walk the others.
    fn go(
        &mut self,
        limits: Limits,
        numbers: &mut impl PrimarySample,
        mut first: impl FnMut(&mut Self, &mut Hit, &VertexNumbers) -> Result<bool, Stop>,
    ) -> Result<(), Stop> {
        let mut hit = Hit::EMPTY;
        let most = limits.vertices.min(MAX_VERTICES);
        for index in 1..most {
            let numbers = numbers.vertex(index as u32);
            let found = if index == 1 { first(self, &mut hit, &numbers)? } else { self.advance(&mut hit, &numbers)? };
            if !found || index + 1 == most || !self.scatter(index, limits, &numbers) {
                break;
            }
        }
        Ok(())
    }

    /// Along the current direction to the next vertex. False: there is none.
    fn advance(&mut self, hit: &mut Hit, numbers: &VertexNumbers) -> Result<bool, Stop> {
        let Some(from) = self.path.vertices().last() else { return Ok(false) };
        let (origin, medium) = (from.position, from.medium(self.scene, self.direction));
        let ray = Ray { t_min: from.epsilon as f32, ..Ray::free(origin, self.direction, f64::INFINITY, medium) };
        self.fly(&ray, origin, hit, number(numbers, Slot::Distance))
    }

    /// Follows a ray. False: it leads to no vertex.
    fn fly(&mut self, ray: &Ray, origin: DVec3, hit: &mut Hit, u: f64) -> Result<bool, Stop> {
        self.stats.rays += 1;
        self.queries.intersect(core::slice::from_ref(ray), core::slice::from_mut(hit))?;
        if hit.kind == HIT_OVERFLOW {
            self.stats.overflows += 1;
            return Ok(false);
        }
        hit.check(self.scene)?;
        let length = if hit.kind == HIT_SURFACE { f64::from(hit.t) } else { f64::INFINITY };
        let line = Line::new(self.scene.media, origin, self.direction, length, hit.media());
        let flight = sample_distance(&line, u);
        Ok(self.arrive(origin, hit, length, flight, 1.0))
    }

    /// Makes the vertex at the end of a flight, of whose numbers a `share` was used. False: there is none.
    fn arrive(&mut self, origin: DVec3, hit: &Hit, length: f64, flight: Flight, share: f64) -> bool {
        let vertex = match flight {
            Flight::Collision(collision) => self.collision(origin, &collision, share),
            // Light that arrives with probability 0 has underflowed.
            Flight::Passed { probability, .. } if !(probability > 0.0) => None,
            Flight::Passed { optical_depth, probability } => self.end(origin, hit, length, optical_depth, probability),
        };
        let Some(mut vertex) = vertex.filter(|_| self.throughput.max_element() > 0.0) else { return false };
        vertex.throughput = self.throughput;
        vertex.density = if self.from_far {
            vertex.edge.distance = f64::INFINITY;
            self.pdf * vertex.cosine(self.direction) * mean(vertex.extinction * vertex.edge.transmittance)
        } else {
            self.pdf * vertex.arrival(&vertex.edge) / share
        };
        let found = vertex.density > 0.0;
        if found {
            self.path.push(vertex);
        }
        found
    }

    fn edge(&self, distance: f64, optical_depth: Colour) -> Edge {
        Edge { back: -self.direction, distance, optical_depth, transmittance: transmittance(optical_depth) }
    }

    fn collision(&mut self, origin: DVec3, collision: &Collision, share: f64) -> Option<Vertex<'a>> {
        let Collision { t, medium: index, optical_depth, extinction, .. } = *collision;
        let pdf = collision.pdf / share;
        let medium = self.scene.media.get(index as usize).filter(|_| pdf > 0.0)?;
        let position = origin + t * self.direction;
        let edge = self.edge(t, optical_depth);
        self.throughput *= medium.albedo * extinction * edge.transmittance / pdf;
        Some(Vertex { kind: Kind::Medium { index, phase: medium.phase }, position, edge, extinction, ..EMPTY })
    }

    /// A surface, or the sky.
    fn end(&mut self, origin: DVec3, hit: &Hit, length: f64, optical_depth: Colour, probability: f64) -> Option<Vertex<'a>> {
        let edge = self.edge(length, optical_depth);
        self.throughput *= edge.transmittance / probability;
        if hit.kind != HIT_SURFACE {
            let index = self.scene.lights.environment.filter(|_| !self.adjoint)?;
            let light = self.scene.lights.get(index)?;
            return Some(Vertex { kind: Kind::Far { light, index }, position: self.direction, edge, ..EMPTY });
        }
        let bsdf = self.scene.materials.get(hit.material as usize)?;
        let media = [hit.medium_beyond(true), hit.medium_beyond(false)];
        let (normal, user) = (hit.unit_normal(), hit.user);
        let kind = Kind::Surface { material: hit.material, bsdf, normal, media, user, light: hit.light };
        let position = origin + length * self.direction;
        Some(Vertex { kind, position, edge, epsilon: surface_epsilon(position, length), ..EMPTY })
    }

    /// Chooses the direction in which the walk leaves its last vertex, number `index`. False: it ends there.
    fn scatter(&mut self, index: usize, limits: Limits, numbers: &VertexNumbers) -> bool {
        let Some(vertex) = self.path.vertices().last() else { return false };
        let back = vertex.edge.back;
        let Some(sample) = self.sample(vertex, numbers) else { return false };
        let survival = self.survival(index, limits);
        if number(numbers, Slot::Survival) >= survival {
            return false;
        }
        let pdf = vertex.scattering_density(back, sample.direction);
        let before = self.path.vertices().get(index.wrapping_sub(1));
        let reverse =
            before.map(|before| vertex.scattering_density(sample.direction, back) * before.arrival(&vertex.edge.reversed()));
        if let Some(reverse) = reverse {
            self.path.set_reverse(index - 1, reverse);
        }
        self.eta_squared *= sample.eta_squared;
        let weight = if self.adjoint { sample.weight * sample.eta_squared } else { sample.weight };
        self.throughput *= weight / survival;
        (self.direction, self.pdf) = (sample.direction, pdf);
        pdf > 0.0 && self.throughput.max_element() > 0.0
    }

    fn sample(&self, vertex: &Vertex, numbers: &VertexNumbers) -> Option<BsdfSample> {
        let u = pair(numbers, Slot::DirectionU, Slot::DirectionV);
        let back = vertex.edge.back;
        match vertex.kind {
            Kind::Medium { phase, .. } => {
                let direction = phase.sample(back, u)?;
                let pdf = Some(phase.eval(back.dot(direction)));
                Some(BsdfSample { direction, weight: Colour::ONE, pdf, eta_squared: 1.0 })
            }
            Kind::Surface { bsdf, normal, user, .. } => {
                bsdf.sample(&vertex.surface(normal, user), back, u, number(numbers, Slot::Lobe))
            }
            _ => None,
        }
    }

    /// Probability of going on from vertex `index`. It is part of the throughput but of no density: the weights of the techniques need not
    /// know it to sum to 1.
    fn survival(&self, index: usize, limits: Limits) -> f64 {
        if index < limits.rr_depth {
            return 1.0;
        }
        let first = self.path.vertices().get(usize::from(self.adjoint)).map_or(Colour::ONE, |vertex| vertex.throughput);
        let scale = if self.adjoint { first.max_element() } else { 1.0 / self.eta_squared };
        (self.throughput.max_element() / scale).min(MAX_SURVIVAL)
    }
}
