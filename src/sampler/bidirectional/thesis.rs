//! The thesis' own estimator: a path of one technique whose first vertex moves, worth w f/p there. [Lu20 5.1, alg. 2]
//!
//! A path x of weight w·f/p is repeated at y, which is x with x_1 elsewhere and all other vertices as they are, with
//!
//! ```text
//! W = w(y)/w(x) · (1 + ⟨∇log(f/p), y_1 − x_1⟩)
//! ```
//!
//! as if the same technique had made it. The MIS weight w is that of y; of f/p only those factors change that the connection of the two
//! subpaths has [Lu20 fig. 13], everything sampled being worth the same wherever it leads [Lu20 (32), (33)]. Seen from x_1, whose neighbour on
//! the camera's side is the camera, the cases of figure 13 are told apart by t, the vertices from the camera:
//!
//! | t | case | what changes |
//! |---|---|---|
//! | 1 | 3 | W_e, G and Tr to the camera, f_p at x_1 |
//! | 2 | 4 | G and Tr to x_2, f_p at x_1 and, in a medium, at x_2 |
//! | 3 | 5 | f_p at x_2, in a medium |
//! | more, or no vertex from a light | 6 | nothing |
//!
//! The factors are those of ARCHITECTURE.md, not as printed. What p has here and not in the thesis is known at y, with w: the share of
//! distance numbers that make a collision, and a guide's density. This is biased, by O(r²) and at all edges: kept to show just that.

use super::connect::{Connector, aim, edge};
use super::shiftable::{Asker, Joined};
use super::subpath::Subpath;
use super::vertex::{Edge, Kind, Vertex};
use crate::math::{Colour, DVec2, DVec3, LUMINANCE, pow};
use crate::medium::{NONE, optical_depth};
use crate::path::{Neighbour, Seen, Wing};
use crate::phase::cosine_gradient_apex;
use crate::sampler::path_tracer::Stats;
use crate::scene::{HIT_OVERFLOW, ImagePoint, Queries, Stop, View};
use crate::shift::{Depth, MAX_SHIFTS, fill_with_unit_ball};

/// How a batch is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Of the ball in which x_1 moves, world units. ([Lu20 alg. 2] has it move on the sphere around that.)
    pub radius: f64,
    /// Paths beside x; x itself is no part of the batch.
    pub count: usize,
    /// The radius shrinks as i^((alpha − 1)/3): 1 keeps it.
    pub alpha: f64,
    /// Greatest |W|; infinite for no clamp.
    pub clamp: f64,
    /// [Lu20 alg. 2] as printed: i counts the members of one batch, from 1 on in each, instead of the samples of the image. Never consistent.
    pub as_printed: bool,
}

impl Options {
    /// Of member `index` of a batch that comes after `samples` samples of the image.
    fn radius(&self, index: usize, samples: f64) -> f64 {
        let count = if self.as_printed { (index + 1) as f64 } else { samples.max(1.0) };
        self.radius * pow(count, (self.alpha - 1.0) / 3.0)
    }
}

/// Where the members of a batch are seen, and their W.
pub type Batch = [(DVec2, f64); MAX_SHIFTS];
pub const EMPTY: Batch = [(DVec2::ZERO, 0.0); MAX_SHIFTS];

/// A path of a technique that is weighted by the balance heuristic, while its first vertex is moved about.
pub struct Moving<'p, 'a, Q> {
    connector: Connector<'a, 'p, Q>,
    /// With x_1, and what its neighbours know of it, where it was last moved to.
    camera: Subpath<'a>,
    light: Subpath<'a>,
    first: Vertex<'a>,
    next: Vertex<'a>,
    /// ∇log of the luminance of f/p.
    gradient: DVec3,
}

/// A path moved, and seen.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    pub pixel: DVec2,
    /// MIS weight.
    pub weight: f64,
    /// The part of 1/p that the thesis does not have.
    pub chance: f64,
}

impl<'a> Joined<'_, 'a> {
    /// Whether the estimator applies to this path: to x_1 in a medium, and to x_2 in one, on a diffuse or specular surface, or on a light.
    /// `available` of [Lu20 alg. 3].
    pub fn is_available(&self) -> bool {
        let in_medium = matches!(self.vertex(1).kind, Kind::Medium { .. });
        in_medium && (self.connects(2) || (self.last() > 2 && self.vertex(2).is_specular()))
    }

    /// ∇log of the luminance of f/p when x_1 moves, but for what [`Moved::chance`] has.
    fn case_gradient(&self, queries: &impl Queries) -> Result<DVec3, Stop> {
        let (x, next) = (self.vertex(1), self.vertex(2));
        let camera = &self.scene.camera.at(self.vertex(0).position);
        let before = Seen::from(camera, x.position, Neighbour::Camera);
        let after = Seen::from(camera, x.position, next.as_neighbour());
        let asker = Asker { path: self, queries, derivatives: true };
        let depths = [asker.depth(0, Depth::far)?, asker.depth(1, Depth::near)?];
        // Where the edges' ends were sampled, or None for the connection.
        let t = self.camera.len();
        let made = [(t > 1).then_some(x), if t == 2 { None } else { Some(if t == 1 { x } else { next }) }];
        let flights = (0..2).map(|i| self.flight_gradient(i, &depths[i], made[i])).sum::<DVec3>();
        Ok(flights
            + match t {
                1 => before.geometry_gradient() + before.importance_gradient(camera) + apex_gradient(x, &before, &after),
                2 => after.geometry_gradient() + apex_gradient(x, &before, &after) + self.wing_gradient(&after),
                3 => self.wing_gradient(&after),
                _ => DVec3::ZERO,
            })
    }

    /// ∇log of Tr of the edge from x_i; over its density mean(σ_t Tr) if it was sampled, which leaves nothing in a grey medium.
    fn flight_gradient(&self, i: usize, depth: &Depth, made: Option<&Vertex>) -> DVec3 {
        let mean = |of: Colour| (0..3).map(|c| depth.slope[c] * of[c]).sum::<DVec3>() / of.element_sum();
        let sampled = made.map_or(DVec3::ZERO, |end| mean(end.extinction * self.edge(i).transmittance));
        sampled - mean(self.connection.value * LUMINANCE)
    }

    /// ∇log f_p at x_2, if that is in a medium.
    fn wing_gradient(&self, after: &Seen) -> DVec3 {
        let Kind::Medium { phase, .. } = self.vertex(2).kind else { return DVec3::ZERO };
        after.wing_gradient(&Wing { phase, to_other: self.directions(2).1 })
    }
}

/// ∇log f_p at x_1.
fn apex_gradient(x: &Vertex, before: &Seen, after: &Seen) -> DVec3 {
    let Kind::Medium { phase, .. } = x.kind else { return DVec3::ZERO };
    let c = before.towards.dot(after.towards);
    phase.log_derivative(c) * cosine_gradient_apex(before.towards, after.towards, c, before.distance, after.distance)
}

impl Vertex<'_> {
    fn as_neighbour(&self) -> Neighbour {
        match self.kind {
            Kind::Far { .. } => Neighbour::Direction(self.position),
            Kind::Surface { normal, .. } => Neighbour::Point { position: self.position, normal: Some(normal) },
            Kind::Light { normal, .. } => Neighbour::Point { position: self.position, normal },
            _ => Neighbour::Point { position: self.position, normal: None },
        }
    }
}

impl<'p, 'a, Q: Queries> Moving<'p, 'a, Q> {
    /// A path for which [`Joined::is_available`].
    pub fn new(path: &Joined<'_, 'a>, queries: &'p Q) -> Result<Self, Stop> {
        let (scene, pixel) = (path.scene, path.connection.pixel);
        let lens = scene.camera.on_lens(path.vertex(0).position);
        Ok(Self {
            connector: Connector::of_all_techniques(scene, queries, pixel, lens),
            camera: Subpath::of(path.camera),
            light: Subpath::of(path.light),
            first: *path.vertex(1),
            next: *path.vertex(2),
            gradient: path.case_gradient(queries)?,
        })
    }

    /// ∇log of the luminance of f/p, 1/world unit, but for what [`Moved::chance`] has.
    pub fn gradient(&self) -> DVec3 {
        self.gradient
    }

    /// Makes a batch after `samples` samples of the image; how many members it has. Those that carry nothing are left out. None: x itself is
    /// within rounding of a face and seen no more, there is nothing to compare with.
    pub fn batch(
        &mut self,
        options: &Options,
        samples: f64,
        random: &mut impl FnMut() -> f64,
        members: &mut Batch,
        stats: &mut Stats,
    ) -> Result<Option<usize>, Stop> {
        let Some(own) = self.moved(DVec3::ZERO, stats)? else { return Ok(None) };
        let mut count = 0;
        for index in 0..options.count.min(MAX_SHIFTS) {
            let offset = options.radius(index, samples) * self.direction(random);
            let Some(moved) = self.moved(offset, stats)? else { continue };
            let ratio = moved.weight * moved.chance / (own.weight * own.chance);
            let w = ratio * (1.0 + self.gradient.dot(offset));
            if let Some(member) = members.get_mut(count) {
                *member = (moved.pixel, if w.abs() > options.clamp { options.clamp.copysign(w) } else { w });
                count += 1;
            }
        }
        Ok(Some(count))
    }

    /// Uniform in the unit ball; along the edge beside a specular vertex, which keeps its direction.
    fn direction(&self, random: &mut impl FnMut() -> f64) -> DVec3 {
        if self.next.is_specular() {
            return (2.0 * random() - 1.0) * aim(&self.first, &self.next).0;
        }
        let mut point = [[0.0; 3]];
        fill_with_unit_ball(&mut point, random);
        DVec3::from_array(point[0])
    }

    /// The path with x_1 moved by `offset`. None: it carries nothing.
    pub fn moved(&mut self, offset: DVec3, stats: &mut Stats) -> Result<Option<Moved>, Stop> {
        let scene = self.connector.scene;
        let mut y = Vertex { position: self.first.position + offset, ..self.first };
        let Some(image) = scene.camera.project(y.position, self.connector.lens) else { return Ok(None) };
        let Some((from_camera, share)) = self.see(&mut y, &image, stats)? else { return Ok(None) };
        let t = self.camera.vertices().len();
        // A connection from x_1 to x_2 asks for itself.
        let onwards = if t == 2 { Some(Edge::NONE) } else { self.onwards(&y, stats)? };
        let Some(onwards) = onwards else { return Ok(None) };
        let chance =
            if t == 1 { self.put_light(&mut y, &onwards) } else { self.put_camera(&mut y, &from_camera, share, &onwards) };
        let connection = self.connector.connect(self.camera.vertices(), self.light.vertices(), stats)?;
        Ok(connection.map(|c| Moved { pixel: image.pixel, weight: c.weight, chance }))
    }

    /// The edge from the camera to y_1, and the share of its distance numbers that are used. None: another medium, or something before it.
    fn see(&self, y: &mut Vertex, image: &ImagePoint, stats: &mut Stats) -> Result<Option<(Edge, f64)>, Stop> {
        let scene = self.connector.scene;
        let mut view = [View::to(image)];
        View::trace(&mut view, scene, self.connector.queries)?;
        stats.rays += 1;
        let [mut view] = view;
        if view.hit.kind == HIT_OVERFLOW {
            stats.overflows += 1;
            return Ok(None);
        }
        let Kind::Medium { index, .. } = y.kind else { return Ok(None) };
        if view.length() <= image.distance || medium_at(&view, image.distance) != index {
            return Ok(None);
        }
        y.extinction = scene.medium(index).map_or(Colour::ZERO, |medium| medium.sigma_t(y.position));
        let share = view.collision_share(scene);
        let depth = optical_depth(&view.line(scene, image.distance));
        Ok((y.extinction.max_element() > 0.0).then(|| (edge(-image.ray.direction, image.distance, depth), share)))
    }

    /// The edge from y_1 to x_2. None: there is something between them.
    fn onwards(&self, y: &Vertex, stats: &mut Stats) -> Result<Option<Edge>, Stop> {
        let (direction, distance) = aim(y, &self.next);
        // Past a specular vertex nothing would be as it was.
        if !(distance > 0.0) || (self.next.is_specular() && direction.dot(aim(&self.first, &self.next).0) < 0.0) {
            return Ok(None);
        }
        let depth = self.connector.depth_between(y, &self.next, direction, distance, stats)?;
        Ok(depth.map(|depth| edge(-direction, distance, depth)))
    }

    /// Makes y_1 the last vertex of the light's subpath, with the densities that change with it; `onwards` ends at x_2. Returns `chance`.
    fn put_light(&mut self, y: &mut Vertex<'a>, onwards: &Edge) -> f64 {
        let (scene, next) = (self.connector.scene, &self.next);
        y.edge = onwards.reversed();
        y.density = next.density_of(scene, next.edge.back, y, &y.edge);
        let light = self.light.vertices_mut();
        if let [.., third, _, _] = light {
            third.reverse = next.density_of(scene, onwards.back, third, &next.edge.reversed());
        }
        if let Some(last) = light.last_mut() {
            *last = *y;
        }
        1.0 / next.guided(scene, y, onwards.back)
    }

    /// Makes y_1 the second vertex of the camera's subpath, with the densities that change with it. Returns `chance`.
    fn put_camera(&mut self, y: &mut Vertex<'a>, from_camera: &Edge, share: f64, onwards: &Edge) -> f64 {
        let scene = self.connector.scene;
        if let [origin, first, others @ ..] = self.camera.vertices_mut() {
            y.edge = *from_camera;
            y.density = origin.density_of(scene, DVec3::ZERO, y, from_camera) / share;
            if let [second, others @ ..] = others {
                second.edge = *onwards;
                second.density = y.density_of(scene, from_camera.back, second, onwards);
                if let [third, ..] = others {
                    third.density = second.density_of(scene, onwards.back, third, &third.edge);
                    y.reverse = second.density_of(scene, -third.edge.back, y, &onwards.reversed());
                }
            }
            *first = *y;
        }
        share
    }
}

/// The medium on a camera ray at this distance from x_0.
fn medium_at(view: &View, distance: f64) -> u32 {
    let mut media = view.hit.media().iter();
    media.find(|segment| view.ray.start + f64::from(segment.end) >= distance).map_or(NONE, |segment| segment.medium)
}
