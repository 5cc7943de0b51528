//! What a path carries to the film: contributions that stay at its pixel, and those that its first vertex can take along.
//!
//! Beside the usual throughput it keeps `rest`, the throughput without the factors that change when x_1 moves (shift/link.rs):
//! 1/(We G pdf) at x_1, and so on; so a contribution's `rest` needs no division of colours.

use super::next_event::NextEvent;
use crate::math::{Colour, DVec3};
use crate::medium::Segment;
use crate::phase::Phase;
use crate::scene::ImagePoint;
use crate::shift::{First, Link, Next, Shiftable};

/// Links from x_1: to a light by next-event estimation, and to x_2 (or the environment) by going on.
const TO_LIGHT: usize = 0;
const TO_SECOND: usize = 1;

/// How far along the path the recording is.
#[derive(Clone, Copy, Debug)]
enum Stage {
    /// All contributions stay.
    Plain,
    /// At x_1.
    First,
    /// On the way to x_2, in a direction of this density.
    Leaving { pdf: f64 },
    /// At x_2; its phase function if in a medium.
    Second { phase: Option<Phase> },
    /// Beyond: the unit vector from x_2 onwards, and whether it passes a phase function at x_2.
    Beyond { onwards: DVec3, wing: bool },
}

#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Sum of the contributions that stay at the path's pixel.
    pub plain: Colour,
    enabled: bool,
    stage: Stage,
    shiftable: Option<Shiftable>,
    rest: Colour,
    /// Sum of the contributions beyond x_2, without what changes.
    beyond: Colour,
}

/// The end of an edge, reached.
pub struct Arrival<'a> {
    /// x, or the direction of an environment.
    pub next: Next,
    /// Unit vector along which it was reached, and how far.
    pub direction: DVec3,
    pub distance: f64,
    pub optical_depth: Colour,
    pub segments: &'a [Segment],
    /// σ_s/pdf of a collision, 1/probability of passing.
    pub weight: Colour,
    pub transmittance: Colour,
}

impl Record {
    pub fn new(enabled: bool) -> Self {
        let none = Colour::ZERO;
        Self { plain: none, enabled, stage: Stage::Plain, shiftable: None, rest: none, beyond: none }
    }

    /// The first vertex, where f = A·L·… in the measure of shift/link.rs, and the path's density in that measure so far.
    pub fn first(&mut self, first: First, image: ImagePoint, density: f64, arrival: &Arrival) {
        let Next::Point { position, .. } = arrival.next else { return };
        if !self.enabled {
            return;
        }
        self.rest = Colour::splat(1.0 / density);
        self.shiftable = Some(Shiftable::new(position, image, first, arrival.optical_depth, arrival.segments));
        self.stage = Stage::First;
    }

    /// A later vertex.
    pub fn later(&mut self, arrival: &Arrival, phase: Option<Phase>) {
        match self.stage {
            Stage::Leaving { pdf } => {
                let geometry = arrival.next.geometry(arrival.direction, arrival.distance);
                if !(geometry > 0.0) {
                    self.stage = Stage::Plain;
                    return;
                }
                self.rest *= arrival.weight / (pdf * geometry);
                if let Some(shiftable) = &mut self.shiftable {
                    let link = Link::new(arrival.next, arrival.optical_depth, arrival.segments);
                    shiftable.links[TO_SECOND] = Some(Link { phase: phase.unwrap_or_default(), ..link });
                }
                self.stage = Stage::Second { phase };
            }
            Stage::Beyond { .. } => self.rest *= arrival.weight * arrival.transmittance,
            _ => {}
        }
    }

    /// At a surface whose f_r depends on the directions: what scatters at x_2 then depends on x_1 and stays.
    pub fn depends_on_direction(&mut self) {
        if let Stage::Second { .. } = self.stage {
            self.stage = Stage::Plain;
        }
    }

    /// Light met on the way: `emission` times its MIS weight.
    pub fn emitted(&mut self, throughput: Colour, emission: Colour) {
        match self.stage {
            Stage::Second { .. } => self.add_plain(self.rest * emission),
            Stage::Beyond { .. } => self.beyond += self.rest * emission,
            _ => self.plain += throughput * emission,
        }
    }

    /// A next-event estimate at the current vertex.
    pub fn next_event(&mut self, throughput: Colour, event: &NextEvent) {
        match self.stage {
            Stage::First if !event.profile => {
                if let Some(shiftable) = &mut self.shiftable {
                    let link = Link::new(event.next, event.optical_depth, event.hit.media());
                    shiftable.links[TO_LIGHT] = Some(Link { plain: self.rest * event.emitted, ..link });
                }
            }
            Stage::Second { phase: Some(_) } => {
                let rest = self.rest * event.emitted * event.transmittance * event.geometry;
                if let Some(link) = self.second_link() {
                    link.add_wing(event.direction, rest);
                }
            }
            Stage::Second { phase: None } => self.add_plain(self.rest * event.received()),
            Stage::Beyond { .. } => self.beyond += self.rest * event.received(),
            _ => self.plain += throughput * event.received(),
        }
    }

    /// The path goes on in `direction` of density `pdf`; `weight` is value over pdf and `survival`, the probability of going on.
    pub fn scattered(&mut self, direction: DVec3, weight: Colour, pdf: f64, survival: f64) {
        match self.stage {
            Stage::First => {
                self.rest /= survival;
                self.stage = Stage::Leaving { pdf };
            }
            Stage::Second { phase } => {
                // A phase function is its own density.
                self.rest *= if phase.is_some() { weight / pdf } else { weight };
                self.stage = Stage::Beyond { onwards: direction, wing: phase.is_some() };
            }
            Stage::Beyond { .. } => self.rest *= weight,
            _ => {}
        }
    }

    /// What can be shifted, if anything.
    pub fn finish(mut self) -> Option<Shiftable> {
        match self.stage {
            Stage::Beyond { onwards, wing: true } => {
                let beyond = self.beyond;
                if let Some(link) = self.second_link() {
                    link.add_wing(onwards, beyond);
                }
            }
            Stage::Beyond { wing: false, .. } => self.add_plain(self.beyond),
            _ => {}
        }
        self.shiftable.and_then(Shiftable::without_empty_links)
    }

    fn second_link(&mut self) -> Option<&mut Link> {
        self.shiftable.as_mut()?.links[TO_SECOND].as_mut()
    }

    fn add_plain(&mut self, rest: Colour) {
        if let Some(link) = self.second_link() {
            link.plain += rest;
        }
    }
}
