//! Joins a subpath from the camera and one from a light to a path, and weighs it. [V97 10.3]

use super::mis::{Heuristic, Junction, Repertoire, weight};
use super::vertex::{Edge, Kind, Vertex};
use crate::math::{Colour, DVec2, DVec3, luminance, transmittance};
use crate::medium::{Line, optical_depth, optical_depth_or_dark};
use crate::sampler::path_tracer::Stats;
use crate::scene::{HIT_NONE, HIT_OVERFLOW, HIT_SURFACE, Hit, Queries, Ray, Scene, Stop, View};

/// A path from the camera to a light, as one technique made it.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    pub pixel: DVec2,
    /// f/p: per sample, where one sample is a path per sampled pixel.
    pub value: Colour,
    /// MIS weight.
    pub weight: f64,
    /// The edge between the two subpaths, ending at the light's last vertex. None where the camera's found the light.
    pub edge: Option<Edge>,
}

/// Chance decides about what is worth little: it counts as much more as it is rarer. [AK90]
#[derive(Clone, Copy, Debug, Default)]
pub struct Roulette {
    /// Luminance from which on nothing is left to chance; 0: never.
    pub threshold: f64,
    /// Uniform in (0, 1), one for each decision.
    pub number: f64,
}

impl Roulette {
    /// Probability with which something of this luminance at most is made; None: this time it is not.
    pub fn survival(&self, luminance: f64) -> Option<f64> {
        let probability = if luminance < self.threshold { luminance / self.threshold } else { 1.0 };
        (self.number < probability).then_some(probability)
    }
}

/// What connecting needs besides the subpaths.
pub struct Connector<'a, 'q, Q> {
    pub scene: &'a Scene<'a>,
    pub queries: &'q Q,
    pub heuristic: Heuristic,
    pub repertoire: Repertoire,
    pub roulette: Roulette,
    /// The camera's ray, and the point on the lens that paths from lights are connected to.
    pub pixel: DVec2,
    pub lens: DVec2,
}

impl<'a, 'q, Q: Queries> Connector<'a, 'q, Q> {
    /// All techniques, by the balance heuristic, and nothing is left to chance.
    pub fn of_all_techniques(scene: &'a Scene<'a>, queries: &'q Q, pixel: DVec2, lens: DVec2) -> Self {
        let (heuristic, repertoire, roulette) = (Heuristic::Balance, Repertoire::ALL, Roulette::default());
        Self { scene, queries, heuristic, repertoire, roulette, pixel, lens }
    }

    /// Joins all vertices of `camera` and of `light`, two or more in all but not the camera and a light alone. None: nothing arrives.
    pub fn connect(&self, camera: &[Vertex], light: &[Vertex], stats: &mut Stats) -> Result<Option<Connection>, Stop> {
        match (camera, light) {
            (_, []) => Ok(self.found(camera)),
            ([_], [.., before, last]) => self.seen(camera, light, before, last, stats),
            ([.., before, last], [..]) => self.joined(camera, light, before, last, stats),
            _ => Ok(None),
        }
    }

    /// s = 0: the camera's subpath has found a light. Through nothing but specular surfaces: that is the path sampler's.
    fn found(&self, camera: &[Vertex]) -> Option<Connection> {
        let [_, between @ .., last] = camera else { return None };
        let before = between.last().filter(|_| !between.iter().all(Vertex::is_specular))?;
        let direction = last.edge.back;
        let (index, light, normal) = match last.kind {
            Kind::Surface { light: index, normal, .. } => (index, self.scene.lights.get(index)?, Some(normal)),
            Kind::Far { light, index } => (index, light, None),
            _ => return None,
        };
        let kind = if normal.is_some() { Kind::Light { light, index, normal } } else { last.kind };
        let source = Vertex { kind, ..*last };
        let front = normal.is_none_or(|n| n.dot(direction) > 0.0);
        let value = if front { last.throughput * light.emission(direction) } else { Colour::ZERO };
        let pick = self.scene.lights.probability(index);
        let point = if normal.is_some() { light.area_pdf() } else { light.far_density(last.position) };
        let towards = source.density_of(self.scene, direction, before, &last.edge.reversed());
        let junction = Junction { camera: [pick * point, towards], light: [0.0; 2] };
        self.finish(self.pixel, value, None, camera, &[], &junction)
    }

    /// t = 1: the light's last vertex is seen by the camera.
    fn seen(
        &self,
        camera: &[Vertex],
        light: &[Vertex],
        before: &Vertex,
        last: &Vertex,
        stats: &mut Stats,
    ) -> Result<Option<Connection>, Stop> {
        let (scene, back) = (self.scene, last.edge.back);
        let Some(image) = scene.camera.project(last.position, self.lens).filter(|_| !last.is_specular()) else {
            return Ok(None);
        };
        let to_camera = -image.ray.direction;
        let scattering = last.scattering(to_camera, back, to_camera);
        if !(scattering.max_element() > 0.0) {
            return Ok(None);
        }
        let unoccluded = last.throughput
            * scattering
            * (scene.camera.direction_density(image.ray.cosine) / (image.distance * image.distance));
        let Some(survival) = self.roulette.survival(luminance(unoccluded)) else { return Ok(None) };
        let mut view = [View::to(&image)];
        View::trace(&mut view, scene, self.queries)?;
        stats.rays += 1;
        let [mut view] = view;
        if view.hit.kind == HIT_OVERFLOW {
            stats.overflows += 1;
            return Ok(None);
        }
        if view.length() <= image.distance - last.epsilon {
            return Ok(None);
        }
        let depth = optical_depth(&view.line(scene, image.distance.min(view.length())));
        let edge = edge(to_camera, image.distance, depth);
        let mut forward = camera[0].density_of(scene, DVec3::ZERO, last, &edge);
        let value = unoccluded * edge.transmittance / survival;
        if matches!(last.kind, Kind::Medium { .. }) {
            forward /= view.collision_share(scene);
        }
        let backward = last.density_of(scene, to_camera, before, &last.edge.reversed());
        let junction = Junction { camera: [0.0; 2], light: [forward, backward] };
        Ok(self.finish(image.pixel, value, Some(edge), camera, light, &junction))
    }

    /// A visible pair of vertices.
    fn joined(
        &self,
        camera: &[Vertex],
        light: &[Vertex],
        camera_before: &Vertex,
        z: &Vertex,
        stats: &mut Stats,
    ) -> Result<Option<Connection>, Stop> {
        let Some(y) = light.last().filter(|y| !y.is_specular() && !z.is_specular()) else { return Ok(None) };
        if matches!(z.kind, Kind::Far { .. }) {
            return Ok(None);
        }
        let (direction, distance) = aim(z, y);
        let (z_back, y_back) = (z.edge.back, y.edge.back);
        let from_light = if light.len() == 1 { y.emission(-direction) } else { y.scattering(-direction, y_back, direction) };
        let vacuum = z.throughput * y.throughput * z.scattering(z_back, direction, direction) * from_light;
        if !(vacuum.max_element() > 0.0 && distance > 0.0) {
            return Ok(None);
        }
        let unoccluded = vacuum * Edge { distance, ..Edge::NONE }.spread();
        let Some(survival) = self.roulette.survival(luminance(unoccluded)) else { return Ok(None) };
        let Some(depth) = self.depth_between(z, y, direction, distance, stats)? else { return Ok(None) };
        let edge = edge(-direction, distance, depth);
        let value = unoccluded * edge.transmittance / survival;
        let scene = self.scene;
        let mut junction = Junction::default();
        junction.camera[0] = y.density_of(scene, y_back, z, &edge.reversed());
        junction.camera[1] = z.density_of(scene, direction, camera_before, &z.edge.reversed());
        junction.light[0] = z.density_of(scene, z_back, y, &edge);
        if let [.., before, _] = light {
            junction.light[1] = y.density_of(scene, -direction, before, &y.edge.reversed());
        }
        Ok(self.finish(self.pixel, value, Some(edge), camera, light, &junction))
    }

    /// τ between two vertices that see each other.
    pub(super) fn depth_between(
        &self,
        z: &Vertex,
        y: &Vertex,
        direction: DVec3,
        distance: f64,
        stats: &mut Stats,
    ) -> Result<Option<Colour>, Stop> {
        // Next to each other it is the epsilons that have to give way.
        let most = 0.25 * distance;
        let t_max = distance - y.epsilon.min(most);
        let ray = Ray {
            t_min: z.epsilon.min(most) as f32,
            ..Ray::free(z.position, direction, t_max, z.medium(self.scene, direction))
        };
        let mut hits = [Hit::EMPTY];
        stats.occlusion_rays += 1;
        self.queries.occluded(&[ray], &mut hits)?;
        let [hit] = hits;
        match hit.kind {
            HIT_NONE => hit.check(self.scene)?,
            HIT_OVERFLOW => {
                stats.overflows += 1;
                return Ok(None);
            }
            HIT_SURFACE => return Ok(None),
            _ => return Err(Stop::InvalidHit),
        }
        let line = Line::new(self.scene.media, z.position, direction, distance, hit.media());
        Ok(Some(optical_depth_or_dark(&line)))
    }

    fn finish(
        &self,
        pixel: DVec2,
        value: Colour,
        edge: Option<Edge>,
        camera: &[Vertex],
        light: &[Vertex],
        junction: &Junction,
    ) -> Option<Connection> {
        if !(value.max_element() > 0.0) {
            return None;
        }
        let weight = weight(camera, light, junction, self.heuristic, &self.repertoire);
        (weight > 0.0).then_some(Connection { pixel, value, weight, edge })
    }
}

pub(super) fn edge(back: DVec3, distance: f64, optical_depth: Colour) -> Edge {
    Edge { back, distance, optical_depth, transmittance: transmittance(optical_depth) }
}

/// Unit direction and distance from `z` to `y`.
pub(super) fn aim(z: &Vertex, y: &Vertex) -> (DVec3, f64) {
    if matches!(y.kind, Kind::Far { .. }) {
        return (y.position, f64::INFINITY);
    }
    let v = y.position - z.position;
    let distance = v.length();
    (v / distance, distance)
}
