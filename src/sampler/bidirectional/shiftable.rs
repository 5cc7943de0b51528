//! Prepares a path of the bidirectional techniques for shifting: the same as shift/from_path.rs, from what the subpaths know already.

use super::connect::Connection;
use super::vertex::{Edge, Kind, Vertex};
use crate::math::{Colour, DVec3, luminance};
use crate::medium::{EdgeMoments, moments};
use crate::phase::Phase;
use crate::scene::{HIT_NONE, HIT_OVERFLOW, Hit, Light, Queries, Ray, Scene, Stop, View};
use crate::shift::{self, Bounce, Chain, Depth, Link, Next, Onwards, Place, RunVertex, Shiftable};

/// A path x_0 … x_k made of two subpaths.
pub struct Joined<'p, 'a> {
    pub scene: &'a Scene<'a>,
    pub camera: &'p [Vertex<'a>],
    pub light: &'p [Vertex<'a>],
    pub connection: &'p Connection,
}

/// Beyond a path's ends: nothing comes from there.
const NOWHERE: Vertex = Vertex {
    kind: Kind::Camera,
    position: DVec3::ZERO,
    edge: Edge::NONE,
    throughput: Colour::ZERO,
    extinction: Colour::ONE,
    density: 0.0,
    reverse: 0.0,
    epsilon: 0.0,
};

impl<'a> Joined<'_, 'a> {
    /// Number of the vertex on the light.
    pub fn last(&self) -> usize {
        self.camera.len() + self.light.len() - 1
    }

    /// x_i.
    pub fn vertex(&self, i: usize) -> &Vertex<'a> {
        self.camera.get(i).or_else(|| self.light.get(self.last() - i)).unwrap_or(&NOWHERE)
    }

    /// The edge from x_i to x_{i+1}, as it arrives there.
    pub fn edge(&self, i: usize) -> Edge {
        if i + 1 == self.camera.len() {
            self.connection.edge.unwrap_or(Edge::NONE)
        } else if i < self.camera.len() {
            self.vertex(i + 1).edge
        } else {
            self.vertex(i).edge.reversed()
        }
    }

    /// Unit vectors from x_i to the vertices before and after it.
    pub fn directions(&self, i: usize) -> (DVec3, DVec3) {
        (self.edge(i - 1).back, -self.edge(i).back)
    }

    /// The light at the path's end, and the normal there if it is an area light.
    fn source(&self) -> Option<(&'a Light<'a>, Option<DVec3>)> {
        match self.vertex(self.last()).kind {
            Kind::Light { light, normal, .. } => Some((light, normal)),
            Kind::Far { light, .. } => Some((light, None)),
            Kind::Surface { light, normal, .. } => self.scene.lights.get(light).map(|light| (light, Some(normal))),
            _ => None,
        }
    }

    /// What of f at x_i is not the same in all channels, or changes with x_i's neighbours: σ_s or f_r or the emission.
    fn colour(&self, i: usize) -> Colour {
        if i == self.last() {
            return self.source().map_or(Colour::ZERO, |(light, _)| light.emission(self.edge(i - 1).back));
        }
        let vertex = self.vertex(i);
        match vertex.kind {
            Kind::Medium { index, .. } => {
                self.scene.medium(index).map_or(Colour::ZERO, |medium| medium.albedo * vertex.extinction)
            }
            Kind::Surface { bsdf, normal, user, .. } => {
                let (to_camera, to_light) = self.directions(i);
                bsdf.eval_or_weight(&vertex.surface(normal, user), to_camera, to_light)
            }
            _ => Colour::ONE,
        }
    }

    /// Whether batches move its first vertex. That depends on the path alone, not on the technique.
    pub fn moves(&self, options: &shift::Options) -> bool {
        self.suits(options) && self.run(options).is_some()
    }

    /// Whether the kernel has offsets for a first vertex like this one.
    pub(super) fn suits(&self, options: &shift::Options) -> bool {
        options.moves_surfaces() || !matches!(self.vertex(1).kind, Kind::Surface { .. })
    }

    /// Prepares it, with the weight that the connection says, in the place of another one. False: its first vertex may not move.
    pub fn prepare<Q: Queries>(
        &self,
        queries: &Q,
        options: &shift::Options,
        path: &mut Option<Shiftable>,
    ) -> Result<bool, Stop> {
        let Some(run) = self.run(options) else { return Ok(false) };
        let asker = Asker { path: self, queries, derivatives: options.mode.has_derivatives() };
        if !self.first(&asker, path)? {
            return Ok(false);
        }
        let Some(path) = path else { return Ok(false) };
        for i in 2..=run.length {
            let Some(vertex) = self.run_vertex(i, &asker)? else { return Ok(false) };
            path.push(vertex);
        }
        if run.chain {
            path.chain = self.chain(run.length);
        } else {
            path.onwards = Some(self.onwards(run.length, &asker)?);
        }
        let scale = self.scale(path.carried(self.scene));
        path.scale(scale.unwrap_or(0.0));
        Ok(scale.is_some())
    }

    /// Makes x_1 alone of it, in the place of another path. False: it may not move.
    pub(super) fn first<Q: Queries>(&self, asker: &Asker<Q>, path: &mut Option<Shiftable>) -> Result<bool, Stop> {
        let moves = match self.vertex(1).kind {
            Kind::Medium { .. } => true,
            Kind::Surface { bsdf, .. } => !bsdf.is_specular() && !bsdf.transmits(),
            _ => false,
        };
        let Some(first) = (if moves { self.run_vertex(1, asker)? } else { None }) else { return Ok(false) };
        let camera = &self.scene.camera;
        let lens = camera.on_lens(self.vertex(0).position);
        let image = camera.image_point(self.connection.pixel, self.vertex(1).position, lens);
        match path {
            Some(path) => {
                path.clear();
                path.renew(image, first);
            }
            none => *none = Some(Shiftable::new(image, first)),
        }
        Ok(true)
    }

    /// How many vertices move: medium vertices from the camera on, or one on a surface.
    fn run(&self, options: &shift::Options) -> Option<Run> {
        let last = self.last();
        let mut length = 1;
        let in_medium = |i: usize| matches!(self.vertex(i).kind, Kind::Medium { .. });
        while in_medium(1) && length < options.run && length + 1 < last && in_medium(length + 1) {
            length += 1;
        }
        if self.connects(length + 1) {
            return Some(Run { length, chain: false });
        }
        if options.mode.has_queries() && self.is_chain(length + 1) {
            return Some(Run { length, chain: true });
        }
        (length > 1).then_some(Run { length: length - 1, chain: false })
    }

    /// Whether a link may end at x_i: what it does there does not depend on the direction, but for a phase function.
    pub(super) fn connects(&self, i: usize) -> bool {
        if i == self.last() {
            return self.source().is_some_and(|(light, _)| !light.has_profile());
        }
        match self.vertex(i).kind {
            Kind::Surface { bsdf, .. } => bsdf.is_lambertian(),
            _ => true,
        }
    }

    /// Whether from x_i on there are only specular surfaces, and then a light that can be found.
    pub(super) fn is_chain(&self, i: usize) -> bool {
        let last = self.last();
        let found = self.source().is_some_and(|(light, normal)| normal.is_some() || light.is_environment());
        i < last && last - i <= shift::MAX_CHAIN && found && (i..last).all(|j| self.vertex(j).is_specular())
    }

    fn run_vertex<Q: Queries>(&self, i: usize, asker: &Asker<Q>) -> Result<Option<RunVertex>, Stop> {
        let (vertex, edge) = (self.vertex(i), self.edge(i - 1));
        let place = match vertex.kind {
            Kind::Medium { index, .. } => Place::Medium(index),
            Kind::Surface { bsdf, material, normal, media, user, .. } => {
                let facing = bsdf.facing(normal, edge.back);
                Place::Surface { material, normal: facing, medium: media[usize::from(facing != normal)], user }
            }
            _ => return Ok(None),
        };
        let depth = asker.depth(i - 1, if i == 1 { Depth::far } else { |moments, _, _| Depth::whole(moments) })?;
        let (to_previous, distance) = (edge.back, edge.distance);
        Ok(Some(RunVertex { x: vertex.position, place, depth, to_previous, distance }))
    }

    /// The link from the run's last vertex to the next one, and all that goes along it.
    fn onwards<Q: Queries>(&self, run: usize, asker: &Asker<Q>) -> Result<Onwards, Stop> {
        let (link, phase) = self.link(run, asker)?;
        let mut onwards = Onwards::new(link, run - 1, phase);
        let rest = self.rest(run + 1);
        if run + 1 < self.last() && matches!(self.vertex(run + 1).kind, Kind::Medium { .. }) {
            onwards.add_wing(-self.edge(run + 1).back, rest);
        } else {
            onwards.plain = rest;
        }
        Ok(onwards)
    }

    /// The link from x_i to the next vertex, and the phase function there.
    pub(super) fn link<Q: Queries>(&self, i: usize, asker: &Asker<Q>) -> Result<(Link, Phase), Stop> {
        let next = self.vertex(i + 1);
        let back = self.edge(i).back;
        let (place, phase) = if i + 1 == self.last() {
            let normal = self.source().and_then(|(_, normal)| normal);
            let far = matches!(next.kind, Kind::Far { .. });
            (if far { Next::Direction(next.position) } else { Next::Point { position: next.position, normal } }, None)
        } else {
            match next.kind {
                Kind::Surface { bsdf, normal, .. } => {
                    (Next::Point { position: next.position, normal: Some(bsdf.facing(normal, back)) }, None)
                }
                Kind::Medium { phase, .. } => (Next::Point { position: next.position, normal: None }, Some(phase)),
                _ => (Next::Point { position: next.position, normal: None }, None),
            }
        };
        Ok((Link { next: place, depth: asker.depth(i, Depth::near)? }, phase.unwrap_or_default()))
    }

    /// What makes of this colour as much as the connection says. None: nothing does.
    pub(super) fn scale(&self, colour: Colour) -> Option<f64> {
        let scale = luminance(self.connection.value) * self.connection.weight / luminance(colour);
        scale.is_finite().then_some(scale)
    }

    /// The factors from x_i on, so that together with `value`, those before, they are what the connection says. None: they cannot be.
    pub(super) fn rest_of(&self, i: usize, value: Colour) -> Option<Colour> {
        let rest = self.rest(i);
        self.scale(value * rest).map(|scale| rest * scale)
    }

    /// The factors from x_i on, of which only the ratios between the channels matter.
    fn rest(&self, first: usize) -> Colour {
        (first..=self.last()).fold(Colour::ONE, |rest, i| {
            let edge = if i == self.last() { Colour::ONE } else { self.edge(i).transmittance };
            let product = rest * self.colour(i) * edge;
            let largest = product.max_element();
            if largest > 0.0 { product / largest } else { product }
        })
    }

    /// The specular surfaces after the run, and the light at their end.
    pub(super) fn chain(&self, run: usize) -> Option<Chain> {
        let mut chain = Chain::new(-self.edge(run).back, run - 1, Colour::ONE);
        for i in run..self.last() {
            chain.pass(self.edge(i).optical_depth, 1.0);
            let vertex = self.vertex(i + 1);
            let Kind::Surface { bsdf, normal, user, .. } = vertex.kind else { continue };
            if i + 1 < self.last() {
                let (to_camera, to_light) = self.directions(i + 1);
                let bounce = Bounce::new(bsdf, &vertex.surface(normal, user), to_camera, to_light);
                let weight = bounce.value;
                chain.bounce(&bounce, weight).then_some(())?;
            }
        }
        chain.value *= self.colour(self.last());
        Some(chain)
    }
}

/// What of a path moves.
struct Run {
    length: usize,
    /// Whether a chain of specular surfaces follows.
    chain: bool,
}

/// Asks the host again for the media along edges whose derivatives are needed.
pub(super) struct Asker<'p, 's, 'a, Q> {
    pub path: &'p Joined<'s, 'a>,
    pub queries: &'p Q,
    pub derivatives: bool,
}

impl<Q: Queries> Asker<'_, '_, '_, Q> {
    pub fn depth(&self, i: usize, kind: fn(&EdgeMoments, DVec3, f64) -> Depth) -> Result<Depth, Stop> {
        let (path, edge) = (self.path, self.path.edge(i));
        let constant = Depth::constant(edge.optical_depth);
        if !self.derivatives {
            return Ok(constant);
        }
        let (scene, from, direction) = (path.scene, path.vertex(i), -edge.back);
        if i == 0 {
            let lens = scene.camera.on_lens(from.position);
            let mut view = [View::through(scene, path.connection.pixel, lens)];
            View::trace(&mut view, scene, self.queries)?;
            let [view] = view;
            let known = view.hit.kind != HIT_OVERFLOW && view.length() >= edge.distance * (1.0 - 1e-6);
            return Ok(if known {
                kind(&moments(&view.line(scene, edge.distance)), direction, edge.distance)
            } else {
                constant
            });
        }
        let t_min = from.epsilon.min(0.25 * edge.distance);
        let t_max = edge.distance - path.vertex(i + 1).epsilon.min(0.25 * edge.distance);
        let ray = Ray { t_min: t_min as f32, ..Ray::free(from.position, direction, t_max, from.medium(scene, direction)) };
        let mut hits = [Hit::EMPTY];
        self.queries.occluded(&[ray], &mut hits)?;
        let [hit] = hits;
        if hit.kind != HIT_NONE {
            return Ok(constant);
        }
        hit.check(scene)?;
        let line = crate::medium::Line::new(scene.media, from.position, direction, edge.distance, hit.media());
        Ok(kind(&moments(&line), direction, edge.distance))
    }
}
