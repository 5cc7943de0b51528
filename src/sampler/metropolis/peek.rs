//! What a chain's next mutation will do, looked at before it is made: to find mistakes by.

use super::chain::{Metropolis, State};
use super::numbers::Change;
use super::room::Room;
use crate::math::{DVec2, Vec3};
use crate::path::{VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, VERTEX_SURFACE, Vertex};
use crate::sampler::bidirectional::{Kind, Technique, Vertex as SubpathVertex};
use crate::sampler::path_tracer::Stats;
use crate::scene::{Queries, Stop};

#[derive(Clone, Copy, Debug)]
pub struct Peek {
    pub large: bool,
    pub accepted: bool,
    pub acceptance: f64,
    /// Whose numbers change.
    pub change: Change,
    /// The chain's path, and the proposed one.
    pub paths: [PathPeek; 2],
}

#[derive(Clone, Copy, Debug)]
pub struct PathPeek {
    pub technique: Technique,
    /// Its f* over the technique's probability: 0 if it carries nothing.
    pub target: f64,
    pub pixel: DVec2,
    /// Of the array that was handed over; 0 if it carries nothing.
    pub vertex_count: usize,
}

impl<Q: Queries> Metropolis<'_, Q> {
    /// Decides about the next mutation, and leaves the chain as it is. Writes the vertices of its path and of the proposed one.
    pub fn peek(&self, state: &State, numbers: &[f64], vertices: [&mut [Vertex]; 2], stats: &mut Stats) -> Result<Peek, Stop> {
        let mut room = Room::default();
        self.begin(state, numbers, &mut room, stats)?;
        let decision = self.decide(state, numbers, &mut room, stats)?;
        let [current, proposed] = vertices;
        let paths = [
            look(&mut room, Change::NONE, state.technique, current),
            look(&mut room, decision.change, decision.technique, proposed),
        ];
        let (large, accepted, acceptance) = (decision.large, decision.accepted, decision.acceptance);
        Ok(Peek { large, accepted, acceptance, change: decision.change, paths })
    }
}

/// The room's path that differs from the chain's by `change`.
fn look(room: &mut Room, change: Change, technique: Technique, to: &mut [Vertex]) -> PathPeek {
    let Room { camera, light, sample, .. } = room;
    let sample = sample.get(change != Change::NONE);
    let Some(connection) = sample.connection.as_ref().filter(|_| sample.target > 0.0) else {
        return PathPeek { technique, target: 0.0, pixel: DVec2::ZERO, vertex_count: 0 };
    };
    let (camera, light) = (camera.get(change.camera).vertices(), light.get(change.light).vertices());
    let last = (camera.len() + light.len()).saturating_sub(1);
    let mut vertex_count = 0;
    for (i, (vertex, to)) in camera.iter().chain(light.iter().rev()).zip(to).enumerate() {
        *to = of_path(vertex, i == last);
        vertex_count = i + 1;
    }
    PathPeek { technique, target: sample.target, pixel: connection.pixel, vertex_count }
}

fn of_path(vertex: &SubpathVertex, is_last: bool) -> Vertex {
    let (kind, index, normal, user) = match vertex.kind {
        Kind::Camera => (VERTEX_CAMERA, 0, None, 0),
        Kind::Medium { index, .. } => (VERTEX_MEDIUM, index, None, 0),
        Kind::Surface { light, normal, .. } if is_last => (VERTEX_LIGHT, light, Some(normal), 0),
        Kind::Surface { material, normal, user, .. } => (VERTEX_SURFACE, material, Some(normal), user),
        Kind::Light { index, normal, .. } => (VERTEX_LIGHT, index, normal, 0),
        Kind::Far { index, .. } => (VERTEX_LIGHT, index, None, 0),
    };
    let normal = normal.map_or(Vec3::default(), Vec3::from);
    Vertex { kind, index, user, position: vertex.position.into(), normal, shading_normal: normal, reserved: 0 }
}
