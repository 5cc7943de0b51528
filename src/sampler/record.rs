//! What a path carries to the film: contributions that stay at its pixel, and those that its run can take along.
//!
//! Beside the usual throughput it keeps `rest`, the throughput without the factors that change when the run moves (shift/run.rs):
//! 1/(We G pdf) at x_1, 1/(pdf pdf) at each further vertex of the run; so a contribution's `rest` needs no division of colours.

use super::next_event::NextEvent;
use crate::math::{Colour, DVec3, transmittance};
use crate::medium::{EdgeMoments, Line, moments};
use crate::phase::Phase;
use crate::scene::{ImagePoint, Scene};
use crate::shift::{self, Bounce, Chain, Depth, Exit, Link, Next, Onwards, Place, RunVertex, Shiftable};

/// How far along the path the recording is.
#[derive(Clone, Copy, Debug)]
enum Stage {
    /// All contributions stay.
    Plain,
    /// At a vertex of the run.
    Run,
    /// On the way from the run's last vertex, in a direction of this density.
    Leaving { pdf: f64 },
    /// At the vertex after the run; its phase function if in a medium, and whether a link may end there for what scatters.
    Next { phase: Option<Phase>, connects: bool },
    /// Beyond: the unit vector onwards from the vertex where the link ends, and whether it passes a phase function there.
    Beyond { onwards: DVec3, wing: bool },
}

#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Sum of the contributions that stay at the path's pixel.
    pub plain: Colour,
    /// Most vertices of the run; 0: nothing is shifted.
    run: usize,
    derivatives: bool,
    /// Whether light through specular surfaces is shifted, and such a chain in the making.
    chains: bool,
    chain: Option<Chain>,
    stage: Stage,
    shiftable: Option<Shiftable>,
    /// How the run's last vertex, if not its first, looks as the end of a link: σ_s there and the link's depth.
    last: (Colour, Depth),
    rest: Colour,
    /// Sum of the contributions beyond the link onwards, without what changes.
    beyond: Colour,
}

/// The end of an edge, reached.
pub struct Arrival<'a> {
    /// The edge, up to there.
    pub line: Line<'a>,
    pub optical_depth: Colour,
    /// Of a collision per distance, or the probability of passing.
    pub density: f64,
    pub next: Next,
    /// What scatters there, if a run may begin or go on there.
    pub place: Option<Place>,
    /// Whether what scatters there does not depend on where light goes, but for a phase function: then a run may end before.
    pub connects: bool,
    /// Whether it is a light. Next-event estimation finds the same light, so that a run may end before it, whatever scatters there.
    pub emits: bool,
    /// 1 but in a medium.
    pub sigma_s: Colour,
    pub phase: Option<Phase>,
}

impl Arrival<'_> {
    fn is_far(&self) -> bool {
        matches!(self.next, Next::Direction(_))
    }

    /// The vertex that it is in a run, if it can be in one.
    fn run_vertex(&self, depth: Depth) -> Option<RunVertex> {
        let Next::Point { position, .. } = self.next else { return None };
        let Line { direction, length, .. } = self.line;
        Some(RunVertex { x: position, place: self.place?, depth, to_previous: -direction, distance: length })
    }
}

impl Record {
    /// Of no path yet.
    pub fn new(options: Option<&shift::Options>) -> Self {
        let none = Colour::ZERO;
        Self {
            plain: none,
            run: options.map_or(0, |options| options.run.max(1)),
            derivatives: options.is_some_and(|options| options.mode.has_derivatives()),
            chains: options.is_some_and(|options| options.mode.has_queries()),
            chain: None,
            stage: Stage::Plain,
            shiftable: None,
            last: (none, Depth::default()),
            rest: none,
            beyond: none,
        }
    }

    /// For the next path. (What is large stays where it is.)
    pub fn clear(&mut self) {
        (self.plain, self.beyond) = (Colour::ZERO, Colour::ZERO);
        (self.stage, self.chain) = (Stage::Plain, None);
        if let Some(path) = &mut self.shiftable {
            path.clear();
        }
    }

    /// The first vertex, and the path's density there in the measure of shift/run.rs.
    pub fn first(&mut self, image: ImagePoint, density: f64, arrival: &Arrival) {
        if self.run == 0 {
            return;
        }
        let Some(vertex) = arrival.run_vertex(self.depth(arrival, Depth::far)) else { return };
        self.rest = Colour::splat(1.0 / density);
        match &mut self.shiftable {
            Some(path) => path.renew(image, vertex),
            None => self.shiftable = Some(Shiftable::new(image, vertex)),
        }
        self.stage = Stage::Run;
    }

    /// A later vertex.
    pub fn later(&mut self, arrival: &Arrival) {
        self.chain = self.chain.filter(|_| arrival.phase.is_none() && (arrival.emits || !arrival.connects || arrival.is_far()));
        if let Some(chain) = &mut self.chain {
            chain.pass(arrival.optical_depth, arrival.density);
        }
        match self.stage {
            Stage::Leaving { pdf } => {
                if self.extend(arrival) {
                    self.rest /= pdf * arrival.density;
                    self.stage = Stage::Run;
                } else if arrival.connects || arrival.emits {
                    self.leave(pdf, arrival);
                } else {
                    self.begin_chain(pdf, arrival);
                    self.leave_before_last(pdf, arrival);
                }
            }
            Stage::Beyond { .. } => self.pass(arrival),
            _ => {}
        }
    }

    /// Takes a vertex into the run, if it is one of a medium and there is room.
    fn extend(&mut self, arrival: &Arrival) -> bool {
        let (Some(Place::Medium(_)), Some(path)) = (arrival.place, &self.shiftable) else { return false };
        if path.first().place.is_surface() || path.run().len() >= self.run {
            return false;
        }
        let Line { direction, length, .. } = arrival.line;
        let (mut whole, mut near) = (Depth::constant(arrival.optical_depth), Depth::constant(arrival.optical_depth));
        if self.derivatives {
            let moments = moments(&arrival.line);
            (whole, near) = (Depth::whole(&moments), Depth::near(&moments, direction, length));
        }
        let Some(vertex) = arrival.run_vertex(whole) else { return false };
        self.last = (arrival.sigma_s, near);
        self.shiftable.as_mut().is_some_and(|path| path.push(vertex))
    }

    /// The path goes on from the run's last vertex to one that stays.
    fn leave(&mut self, pdf: f64, arrival: &Arrival) {
        let Line { direction, length, .. } = arrival.line;
        let geometry = arrival.next.geometry(direction, length);
        let depth = self.depth(arrival, Depth::near);
        let Some(path) = self.shiftable.as_mut().filter(|_| geometry > 0.0) else {
            self.stage = Stage::Plain;
            return;
        };
        self.rest *= arrival.sigma_s / (arrival.density * pdf * geometry);
        let link = Link { next: arrival.next, depth };
        path.onwards = Some(Onwards::new(link, path.run().len() - 1, arrival.phase.unwrap_or_default()));
        self.stage = Stage::Next { phase: arrival.phase, connects: arrival.connects };
    }

    /// The path meets a surface that no link may end at: the run's last vertex cannot move, but the ones before it can, and connect to it.
    fn leave_before_last(&mut self, pdf: f64, arrival: &Arrival) {
        self.stage = Stage::Plain;
        let Some(path) = &mut self.shiftable else { return };
        let [.., _, last] = path.run() else { return };
        let Place::Medium(index) = last.place else { return };
        let phase = arrival.line.media.get(index as usize).map(|medium| medium.phase).unwrap_or_default();
        let (sigma_s, depth) = self.last;
        let next = Next::Point { position: last.x, normal: None };
        self.rest *= sigma_s * (last.distance * last.distance / pdf);
        path.onwards = Some(Onwards::new(Link { next, depth }, path.run().len() - 2, phase));
        self.stage = Stage::Beyond { onwards: arrival.line.direction, wing: true };
        self.pass(arrival);
    }

    /// The path meets what may be the first of a chain of specular surfaces.
    fn begin_chain(&mut self, pdf: f64, arrival: &Arrival) {
        let Some(path) = self.shiftable.as_ref().filter(|_| self.chains) else { return };
        let mut chain = Chain::new(arrival.line.direction, path.run().len() - 1, self.rest / pdf);
        chain.pass(arrival.optical_depth, arrival.density);
        self.chain = Some(chain);
    }

    /// A specular surface sends the path on; `weight` is value over probability.
    pub fn bounced(&mut self, bounce: &Bounce, weight: Colour) {
        self.chain = self.chain.take().and_then(|mut chain| chain.bounce(bounce, weight).then_some(chain));
    }

    /// What scatters here is not specular.
    pub fn end_chain(&mut self) {
        self.chain = None;
    }

    fn pass(&mut self, arrival: &Arrival) {
        self.rest *= arrival.sigma_s * transmittance(arrival.optical_depth) / arrival.density;
    }

    fn depth(&self, arrival: &Arrival, kind: fn(&EdgeMoments, DVec3, f64) -> Depth) -> Depth {
        let line = &arrival.line;
        if self.derivatives {
            kind(&moments(line), line.direction, line.length)
        } else {
            Depth::constant(arrival.optical_depth)
        }
    }

    /// Light met on the way: `emission` times its MIS weight.
    pub fn emitted(&mut self, throughput: Colour, emission: Colour) {
        if let (Some(mut chain), Some(path)) = (self.chain.take(), &mut self.shiftable) {
            chain.value *= emission;
            path.chain = Some(chain);
            return;
        }
        match self.stage {
            Stage::Next { .. } => self.add_plain(self.rest * emission),
            Stage::Beyond { .. } => self.beyond += self.rest * emission,
            _ => self.plain += throughput * emission,
        }
    }

    /// A next-event estimate at the current vertex.
    pub fn next_event(&mut self, scene: &Scene, throughput: Colour, event: &NextEvent) {
        match self.stage {
            Stage::Run if !event.profile => {
                let depth = if self.derivatives {
                    Depth::near(&moments(&event.line(scene)), event.direction, event.distance)
                } else {
                    Depth::constant(event.optical_depth)
                };
                let rest = self.rest * event.emitted;
                if let Some(path) = &mut self.shiftable {
                    let from = path.run().len().saturating_sub(1);
                    path.leave(Exit { from, link: Link { next: event.next, depth }, wing: None, rest });
                }
            }
            Stage::Next { phase: Some(_), .. } => {
                let rest = self.rest * event.emitted * event.transmittance * event.geometry;
                if let Some(onwards) = self.onwards() {
                    onwards.add_wing(event.direction, rest);
                }
            }
            Stage::Next { connects: true, .. } => self.add_plain(self.rest * event.received()),
            Stage::Beyond { .. } => self.beyond += self.rest * event.received(),
            _ => self.plain += throughput * event.received(),
        }
    }

    /// The path goes on in `direction` of density `pdf`; `weight` is value over pdf and `survival`, the probability of going on.
    pub fn scattered(&mut self, direction: DVec3, weight: Colour, pdf: f64, survival: f64) {
        match self.stage {
            Stage::Run => {
                self.rest /= survival;
                self.stage = Stage::Leaving { pdf };
            }
            Stage::Next { connects: false, .. } => self.stage = Stage::Plain,
            Stage::Next { phase, .. } => {
                // A phase function is its own density.
                self.rest *= if phase.is_some() { weight / pdf } else { weight };
                self.stage = Stage::Beyond { onwards: direction, wing: phase.is_some() };
            }
            Stage::Beyond { .. } => self.rest *= weight,
            _ => {}
        }
    }

    /// What can be shifted, if it carries anything.
    pub fn finish(&mut self) -> Option<&Shiftable> {
        match self.stage {
            Stage::Beyond { onwards: direction, wing: true } => {
                let beyond = self.beyond;
                if let Some(onwards) = self.onwards() {
                    onwards.add_wing(direction, beyond);
                }
            }
            Stage::Beyond { wing: false, .. } => self.add_plain(self.beyond),
            _ => {}
        }
        let path = self.shiftable.as_mut()?;
        path.drop_what_carries_nothing().then_some(&*path)
    }

    fn onwards(&mut self) -> Option<&mut Onwards> {
        self.shiftable.as_mut()?.onwards.as_mut()
    }

    fn add_plain(&mut self, rest: Colour) {
        if let Some(onwards) = self.onwards() {
            onwards.plain += rest;
        }
    }
}
