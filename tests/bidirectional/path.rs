//! A whole path, its contribution f and the density of each technique that could have made it: written down from the formulas, once for
//! the whole path, not as walks gather them.
//!
//! f = W Π [C/d² Tr σ_s] Π [f_s C] Le, and for (s, t), p = Π of t − 1 densities from the camera's side and s from the light's. At a specular
//! vertex both are without its delta factor, in the measure η² C dω, which is the same for both directions.

use crate::toy::scenes::World;
use crate::worlds::carried;
use std::f64::consts::PI;
use volgrad::math::{Colour, DVec2, DVec3, mean, orthonormal_basis};
use volgrad::medium::{Line, optical_depth};
use volgrad::sampler::bidirectional::{Kind, Sample, Vertex};
use volgrad::scene::{Bsdf, GUIDE_SIDE, HIT_SURFACE, Hit, Light, Queries, Ray, SurfacePoint};

pub struct Path<'a> {
    world: &'a World,
    /// From the camera to the light.
    pub vertices: Vec<Vertex<'a>>,
    /// Number of the light.
    pub light: usize,
}

impl<'a> Path<'a> {
    pub fn new(world: &'a World, sample: &Sample<'_, 'a>) -> Self {
        let vertices: Vec<Vertex> = sample.camera.iter().chain(sample.light.iter().rev()).copied().collect();
        let light = match vertices.last().expect("there are three").kind {
            Kind::Light { index, .. } | Kind::Far { index, .. } | Kind::Surface { light: index, .. } => index as usize,
            _ => panic!("the last vertex is no light"),
        };
        Self { world, vertices, light }
    }

    /// Edges.
    pub fn length(&self) -> usize {
        self.vertices.len() - 1
    }

    fn is_far(&self, i: usize) -> bool {
        matches!(self.vertices[i].kind, Kind::Far { .. })
    }

    /// Unit vector from vertex `i` to its neighbour `j`.
    pub fn to(&self, i: usize, j: usize) -> DVec3 {
        let (a, b) = (&self.vertices[i], &self.vertices[j]);
        match (self.is_far(i), self.is_far(j)) {
            (_, true) => b.position,
            (true, _) => -a.position,
            _ => (b.position - a.position).normalize(),
        }
    }

    /// Between vertices `i` − 1 and `i`.
    pub fn distance(&self, i: usize) -> f64 {
        if self.is_far(i) { f64::INFINITY } else { self.vertices[i].position.distance(self.vertices[i - 1].position) }
    }

    /// Per channel, of the edge between vertices `i` − 1 and `i`.
    fn transmittance(&self, i: usize) -> Colour {
        let skipped = if i == 1 { self.world.camera.near_clip / self.cosine_at_camera() } else { 0.0 };
        let direction = self.to(i - 1, i);
        let origin = self.vertices[i - 1].position + skipped * direction;
        exp(-self.depth(origin, direction, self.distance(i) - skipped))
    }

    fn depth(&self, origin: DVec3, direction: DVec3, length: f64) -> Colour {
        let segments = self.world.geometry.segments(origin, direction, length).expect("few media");
        optical_depth(&Line::new(&self.world.media, origin, direction, length, &segments))
    }

    fn cosine_at_camera(&self) -> f64 {
        self.to(0, 1).dot(self.world.camera.forward)
    }

    fn normal(&self, i: usize) -> Option<DVec3> {
        match self.vertices[i].kind {
            Kind::Surface { normal, .. } => Some(normal),
            Kind::Light { normal, .. } => normal,
            _ => None,
        }
    }

    /// |cos| at vertex `i` to the direction of vertex `j`.
    fn cosine(&self, i: usize, j: usize) -> f64 {
        self.normal(i).map_or(1.0, |n| n.dot(self.to(i, j)).abs())
    }

    /// C/d² of vertex `i` seen from its neighbour `j`.
    fn geometry(&self, i: usize, j: usize) -> f64 {
        let distance = self.distance(i.max(j));
        self.cosine(i, j) * if distance.is_finite() { distance.powi(-2) } else { 1.0 }
    }

    /// σ_t, σ_s at a vertex in a medium, 1 elsewhere.
    fn sigma(&self, i: usize) -> [Colour; 2] {
        let vertex = &self.vertices[i];
        let Kind::Medium { index, .. } = vertex.kind else { return [Colour::ONE; 2] };
        let medium = &self.world.media[index as usize];
        let sigma_t = medium.sigma_t * medium.density.at(vertex.position);
        [sigma_t, sigma_t * medium.albedo]
    }

    pub fn is_specular(&self, i: usize) -> bool {
        matches!(self.vertices[i].kind, Kind::Surface { bsdf, .. } if bsdf.is_specular()) && i < self.length()
    }

    /// Squared index of refraction at vertex `i` on the side of vertex `j`.
    fn eta2(&self, i: usize, j: usize) -> f64 {
        match self.vertices[i].kind {
            Kind::Surface { bsdf: Bsdf::Dielectric { eta }, normal, .. } if normal.dot(self.to(i, j)) < 0.0 => eta * eta,
            _ => 1.0,
        }
    }

    /// f_p or f_s C at vertex `i`, C towards the light.
    fn scattering(&self, i: usize) -> Colour {
        let (to_camera, to_light) = (self.to(i, i - 1), self.to(i, i + 1));
        let cosine = self.cosine(i, i + 1);
        match self.vertices[i].kind {
            Kind::Medium { phase, .. } => Colour::splat(phase.eval(to_camera.dot(to_light))),
            Kind::Surface { bsdf, normal, .. } if bsdf.is_specular() => {
                bsdf.eval_or_weight(&SurfacePoint::with_normal(normal), to_camera, to_light) * cosine * self.eta2(i, i + 1)
            }
            Kind::Surface { bsdf, normal, .. } => bsdf.eval(&SurfacePoint::with_normal(normal), to_camera, to_light) * cosine,
            _ => panic!("vertex {i} does not scatter"),
        }
    }

    /// In the pixels' measure: a path per sampled pixel.
    pub fn contribution(&self) -> Colour {
        let last = self.length();
        let edges = (1..=last).map(|i| self.geometry(i, i - 1) * self.transmittance(i) * self.sigma(i)[1]);
        let emitted = self.world.lights[self.light].emission(self.to(last, last - 1));
        let inner: Colour = (1..last).map(|i| self.scattering(i)).product();
        self.importance() * edges.product::<Colour>() * inner * emitted
    }

    /// Per steradian: one path per sampled pixel.
    fn importance(&self) -> f64 {
        let camera = &self.world.camera;
        let [x0, y0, x1, y1] = camera.crop.map(f64::from);
        let area = camera.pixel_size().powi(2) * (x1 - x0) * (y1 - y0);
        self.cosine_at_camera().powi(-3) / area
    }

    /// Per steradian, that a walk from vertex `from` goes on at `i` to `to`.
    fn going_on(&self, from: usize, i: usize, to: usize) -> f64 {
        let (back, on) = (self.to(i, from), self.to(i, to));
        match self.vertices[i].kind {
            Kind::Medium { phase, .. } => phase.eval(back.dot(on)),
            Kind::Surface { bsdf, normal, .. } if bsdf.is_specular() => {
                let passes = normal.dot(back) * normal.dot(on) < 0.0;
                let probability = match *bsdf {
                    Bsdf::Dielectric { eta } => {
                        let relative = if normal.dot(back) > 0.0 { eta } else { 1.0 / eta };
                        let reflected = fresnel(normal.dot(back).abs(), relative);
                        if passes { 1.0 - reflected } else { reflected }
                    }
                    _ => 1.0,
                };
                probability * self.cosine(i, to) * self.eta2(i, to)
            }
            Kind::Surface { bsdf, normal, .. } => bsdf.pdf(&SurfacePoint::with_normal(normal), back, on),
            _ => panic!("vertex {i} does not scatter"),
        }
    }

    /// That a flight along the edge to its end `i` from `j` does end there.
    fn flight(&self, i: usize, j: usize) -> f64 {
        mean(self.sigma(i)[0] * self.transmittance(i.max(j)))
    }

    /// Of vertex `i`, made from the camera's side.
    fn made_from_camera(&self, i: usize) -> f64 {
        let direction = if i == 1 { self.importance() / self.collisions() } else { self.going_on(i - 2, i - 1, i) };
        direction * self.geometry(i, i - 1) * self.flight(i, i - 1)
    }

    /// The part of the first edge's distance numbers that are used: those that make a collision, where its end is dark.
    pub fn collisions(&self) -> f64 {
        let direction = self.to(0, 1);
        let origin = self.vertices[0].position + self.world.camera.near_clip / self.cosine_at_camera() * direction;
        let mut hits = [Hit::EMPTY];
        self.world
            .geometry
            .intersect(&[Ray::free(origin, direction, f64::INFINITY, self.world.camera.medium)], &mut hits)
            .expect("never stops");
        let surface = hits[0].kind == HIT_SURFACE;
        if surface && !self.world.materials[hits[0].material as usize].is_black() {
            return 1.0;
        }
        let length = if surface { hits[0].t.into() } else { f64::INFINITY };
        mean(Colour::ONE - exp(-self.depth(origin, direction, length)))
    }

    /// Of vertex `i`, made from the light's side.
    fn made_from_light(&self, i: usize) -> f64 {
        let last = self.length();
        let light = &self.world.lights[self.light];
        let start = self.to(last, last - 1);
        if i == last {
            let place = match light {
                Light::Environment { .. } => 1.0 / (4.0 * PI),
                Light::EnvironmentMap(map) => map.pdf(self.vertices[last].position),
                Light::Parallelogram { edge_u, edge_v, .. } => 1.0 / edge_u.cross(*edge_v).length(),
                Light::Triangle { edge_u, edge_v, .. } => 2.0 / edge_u.cross(*edge_v).length(),
                Light::Sphere { radius, .. } => 1.0 / (4.0 * PI * radius * radius),
                Light::Directional { .. } | Light::Point { .. } | Light::Spot { .. } => 1.0,
                Light::CustomSky(_) | Light::CustomPoint { .. } => panic!("built in, here"),
            };
            return place * self.world.picks[self.light] / self.world.picks.iter().sum::<f64>();
        }
        if i + 2 <= last {
            return self.going_on(i + 2, i + 1, i) * self.geometry(i, i + 1) * self.flight(i, i + 1);
        }
        let direction = match light {
            _ if self.is_far(last) => {
                let disk = PI * self.world.geometry.bounds().radius.powi(2);
                return self.cosine(i, last) / disk * self.aim() * self.flight(i, last);
            }
            Light::Point { .. } => 1.0 / (4.0 * PI),
            Light::Spot { falloff, .. } => 1.0 / (2.0 * PI * (1.0 - falloff.cos_outer())),
            _ => self.normal(last).expect("an area light").dot(start).max(0.0) / PI,
        };
        direction * self.aim() * self.geometry(i, last) * self.flight(i, last)
    }

    /// The numbers that choose the direction of the light's subpath: squared distance from the middle, or cosine, and turn.
    fn light_numbers(&self) -> DVec2 {
        let last = self.length();
        let direction = self.to(last, last - 1);
        let turned = |axis: DVec3, d: DVec3| {
            let (s, t) = orthonormal_basis(axis);
            d.dot(t).atan2(d.dot(s)).rem_euclid(2.0 * PI) / (2.0 * PI)
        };
        if self.is_far(last) {
            let (axis, bounds) = (self.vertices[last].position, self.world.geometry.bounds());
            let d = (self.vertices[last - 1].position - bounds.centre) / bounds.radius;
            return DVec2::new(d.cross(axis).length_squared(), turned(axis, d));
        }
        match self.world.lights[self.light] {
            Light::Point { .. } => DVec2::new(0.5 - 0.5 * direction.z, turned(DVec3::Z, direction)),
            Light::Spot { axis, falloff, .. } => {
                DVec2::new((1.0 - direction.dot(axis)) / (1.0 - falloff.cos_outer()), turned(axis, direction))
            }
            _ => {
                let axis = self.normal(last).expect("an area light");
                DVec2::new(1.0 - direction.dot(axis).powi(2), turned(axis, direction))
            }
        }
    }

    /// What the light's guide makes of the density of those numbers.
    pub fn aim(&self) -> f64 {
        if self.world.guides.is_empty() {
            return 1.0;
        }
        let [i, j] = (self.light_numbers() * GUIDE_SIDE as f64).to_array().map(|x| (x as usize).min(GUIDE_SIDE - 1));
        let cells = || (0..GUIDE_SIDE).flat_map(|i| (0..GUIDE_SIDE).map(move |j| (i, j)));
        let mean = cells().map(|(i, j)| carried(self.light, i, j)).sum::<f64>() / (GUIDE_SIDE * GUIDE_SIDE) as f64;
        0.2 + 0.8 * carried(self.light, i, j) / mean
    }

    /// Whether rounding may move the light's subpath to another cell of its guide.
    pub fn is_between_cells(&self) -> bool {
        let cells = self.light_numbers() * GUIDE_SIDE as f64;
        !self.world.guides.is_empty() && (cells - cells.round()).abs().min_element() < 1e-4
    }

    /// The densities of all techniques, by the number of vertices from the light; 0 where one cannot make this path.
    pub fn densities(&self) -> Vec<f64> {
        let last = self.length();
        (0..=last).map(|s| if self.can_make(s) { self.density(s) } else { 0.0 }).collect()
    }

    pub fn can_make(&self, s: usize) -> bool {
        let last = self.length();
        let light = &self.world.lights[self.light];
        match s {
            0 => !matches!(light, Light::Directional { .. } | Light::Point { .. } | Light::Spot { .. }),
            _ => !self.is_specular(last + 1 - s) && !self.is_specular(last - s),
        }
    }

    fn density(&self, s: usize) -> f64 {
        let t = self.vertices.len() - s;
        (1..t).map(|i| self.made_from_camera(i)).product::<f64>()
            * (t..=self.length()).map(|i| self.made_from_light(i)).product::<f64>()
    }
}

fn exp(x: Colour) -> Colour {
    Colour::new(x.x.exp(), x.y.exp(), x.z.exp())
}

/// Reflectance of a dielectric, by the angles of incidence and refraction.
fn fresnel(cosine: f64, relative: f64) -> f64 {
    let sine = (1.0 - cosine * cosine).sqrt() / relative;
    if sine >= 1.0 {
        return 1.0;
    }
    let (i, t) = (cosine.acos(), sine.asin());
    if i == 0.0 {
        return ((relative - 1.0) / (relative + 1.0)).powi(2);
    }
    0.5 * (((i - t).sin() / (i + t).sin()).powi(2) + ((i - t).tan() / (i + t).tan()).powi(2))
}
