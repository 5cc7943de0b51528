//! An edge from the shifted run to a vertex that stays, and the contributions that go along it.

use crate::math::{Colour, DVec3};
use crate::medium::EdgeMoments;
use crate::path::Neighbour;
use crate::phase::Phase;
use crate::scene::surface_epsilon;

/// The neighbour of the run's last vertex towards the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Next {
    /// A point; with a normal, light passes only on its front and the geometry term has a cosine.
    Point { position: DVec3, normal: Option<DVec3> },
    /// A unit direction to an environment or directional light, which is kept.
    Direction(DVec3),
}

impl Next {
    /// Unit direction and distance from `x`.
    pub fn seen_from(&self, x: DVec3) -> (DVec3, f64) {
        match *self {
            Self::Point { position, .. } => {
                let distance = (position - x).length();
                ((position - x) / distance, distance)
            }
            Self::Direction(direction) => (direction, f64::INFINITY),
        }
    }

    pub fn neighbour(&self) -> Neighbour {
        match *self {
            Self::Point { position, normal } => Neighbour::Point { position, normal },
            Self::Direction(direction) => Neighbour::Direction(direction),
        }
    }

    /// G of the edge that arrives along the unit vector `direction` after `distance`, without the cosine at its start; 0 on the back.
    pub fn geometry(&self, direction: DVec3, distance: f64) -> f64 {
        match *self {
            Self::Direction(_) => 1.0,
            Self::Point { normal, .. } => {
                let cosine = normal.map_or(1.0, |n| -n.dot(direction));
                cosine.max(0.0) / (distance * distance)
            }
        }
    }

    /// How far a ray along that edge may go before it meets the surface at its end.
    pub fn t_max(&self, distance: f64) -> f64 {
        match *self {
            Self::Point { position, normal: Some(_) } => distance - surface_epsilon(position, distance),
            _ => distance,
        }
    }
}

/// τ of an edge of the path where it was sampled, and ∇τ when the run moves, per colour channel (0 where no mode needs it).
#[derive(Clone, Copy, Debug, Default)]
pub struct Depth {
    pub at_x: Colour,
    pub slope: [DVec3; 3],
}

impl Depth {
    pub fn constant(at_x: Colour) -> Self {
        Self { at_x, slope: [DVec3::ZERO; 3] }
    }

    /// Of an edge from a vertex that stays.
    pub fn far(moments: &EdgeMoments, direction: DVec3, length: f64) -> Self {
        Self { at_x: moments.optical_depth, slope: moments.far_gradient(direction, length) }
    }

    /// Of an edge to a vertex, or in a direction, that stays.
    pub fn near(moments: &EdgeMoments, direction: DVec3, length: f64) -> Self {
        Self { at_x: moments.optical_depth, slope: moments.near_gradient(direction, length) }
    }

    /// Of an edge that moves as a whole.
    pub fn whole(moments: &EdgeMoments) -> Self {
        Self { at_x: moments.optical_depth, slope: moments.gradient }
    }

    /// τ after the run moved by `offset`, to first order.
    pub fn after(&self, offset: DVec3) -> Colour {
        let change = Colour::from_array(self.slope.map(|slope| slope.dot(offset)));
        (self.at_x + change).max(Colour::ZERO)
    }
}

/// An edge from a vertex of the run to a vertex, or in a direction, that stays.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    pub next: Next,
    pub depth: Depth,
}

/// A contribution that leaves the run by a link of its own: a next-event estimate, or another vertex of a light's subpath.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// The run's vertex where it starts.
    pub from: usize,
    pub link: Link,
    /// Where it ends in a medium, the phase function there and the unit vector onwards.
    pub wing: Option<(Phase, DVec3)>,
    pub rest: Colour,
}

impl Exit {
    pub(super) const NONE: Self = Self {
        from: 0,
        link: Link { next: Next::Direction(DVec3::Z), depth: Depth { at_x: Colour::ZERO, slope: [DVec3::ZERO; 3] } },
        wing: None,
        rest: Colour::ZERO,
    };
}

/// Most contributions with a phase function of their own where the run's last link ends.
pub const MAX_WINGS: usize = 4;

/// The link by which the path goes on from the run, and the contributions that go along it.
#[derive(Clone, Copy, Debug)]
pub struct Onwards {
    pub link: Link,
    /// The run's vertex where it starts. All but the last in front of specular vertices: there the last one stays.
    pub from: usize,
    /// `rest` of all contributions without a phase function at `next`: those that end there or scatter on a diffuse surface.
    pub plain: Colour,
    /// The phase function at `next`, and per contribution the unit vector from there onwards, and its `rest`.
    pub phase: Phase,
    pub wings: [(DVec3, Colour); MAX_WINGS],
    pub wing_count: usize,
}

impl Onwards {
    pub fn new(link: Link, from: usize, phase: Phase) -> Self {
        let wings = [(DVec3::Z, Colour::ZERO); MAX_WINGS];
        Self { link, from, plain: Colour::ZERO, phase, wings, wing_count: 0 }
    }

    /// Adds a contribution that scatters at `next` towards `to_other`.
    pub fn add_wing(&mut self, to_other: DVec3, rest: Colour) {
        if let Some(wing) = self.wings.get_mut(self.wing_count) {
            *wing = (to_other, rest);
            self.wing_count += 1;
        }
    }

    /// With all contributions times `factor`.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.plain *= factor;
        self.wings = self.wings.map(|(to_other, rest)| (to_other, rest * factor));
        self
    }

    pub fn wings(&self) -> &[(DVec3, Colour)] {
        self.wings.get(..self.wing_count).unwrap_or(&[])
    }
}
