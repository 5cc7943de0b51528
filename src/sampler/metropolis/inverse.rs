//! From a path back to the numbers of any technique that can make it.

use super::bootstrap::Numbers;
use super::numbers::capacity;
use crate::math::{DVec2, DVec3, absorptance, disk_number, mean, orthonormal_basis};
use crate::sampler::bidirectional::{Edge, Joined, Kind, MAX_LENGTH, Technique};
use crate::scene::{Queries, Stop, View};

/// Where any number will do.
const ANY: f64 = 0.5;

/// Where numbers of (0, 1) begin: rounding may leave some at an end.
const LEAST: f64 = 0.5 * f64::EPSILON;

/// Numbers as they come, vertex by vertex.
struct Writer {
    numbers: Numbers,
    count: usize,
}

impl Writer {
    fn push(&mut self, numbers: &[f64]) {
        for number in numbers {
            if let Some(slot) = self.numbers.get_mut(self.count) {
                *slot = number.clamp(LEAST, 1.0 - LEAST);
                self.count += 1;
            }
        }
    }
}

/// The numbers from which `technique` makes this path, each in (0, 1): as many as [`Technique::numbers`] says, of those between which a path does not
/// change any. None if it never makes it. On smooth surfaces it is taken on trust that directions are those that they reflect or refract.
pub fn invert<Q: Queries>(path: &Joined, queries: &Q, technique: Technique) -> Result<Option<Numbers>, Stop> {
    let mut writer = Writer { numbers: [0.0; capacity(MAX_LENGTH)], count: 0 };
    if technique.camera == 0 || technique.camera + technique.light != path.last() + 1 {
        return Ok(None);
    }
    let share = if technique.camera > 1 { share(path, queries)? } else { 1.0 };
    let found =
        from_camera(path, technique.camera, share, &mut writer).and_then(|()| from_light(path, technique.light, &mut writer));
    Ok(found.map(|()| writer.numbers))
}

/// Of the first edge's distance numbers, those that are used.
fn share<Q: Queries>(path: &Joined, queries: &Q) -> Result<f64, Stop> {
    let (scene, origin) = (path.scene, path.vertex(0).position);
    let mut view = [View::through(scene, path.connection.pixel, scene.camera.on_lens(origin))];
    View::trace(&mut view, scene, queries)?;
    let [mut view] = view;
    Ok(view.collision_share(scene))
}

/// The first `count` vertices.
fn from_camera(path: &Joined, count: usize, share: f64, writer: &mut Writer) -> Option<()> {
    let camera = &path.scene.camera;
    let [x0, y0, x1, y1] = camera.crop.map(f64::from);
    let place = (path.connection.pixel - DVec2::new(x0, y0)) / DVec2::new(x1 - x0, y1 - y0);
    let lens = camera.lens_number(camera.on_lens(path.vertex(0).position));
    writer.push(&[place.x, place.y, lens.x, lens.y]);
    for i in 1..count {
        let (edge, on) = (path.edge(i - 1), i + 1 < count);
        let number = distance(path, i, &edge) / if i == 1 { share } else { 1.0 };
        let to_next = if on { Some(path.directions(i)) } else { None };
        write_vertex(path, i, number, to_next, writer)?;
    }
    Some(())
}

/// The last `count` vertices.
fn from_light(path: &Joined, count: usize, writer: &mut Writer) -> Option<()> {
    if count == 0 {
        return Some(());
    }
    let last = path.last();
    let (scene, vertex) = (path.scene, path.vertex(last));
    let along = path.edge(last - 1).back;
    let (index, place, direction) = match vertex.kind {
        Kind::Far { light, index } => {
            let (centre, radius) = (scene.bounds.centre, scene.bounds.radius);
            let (s, t) = orthonormal_basis(vertex.position);
            let off = path.vertex(last - 1).position - centre;
            let on_disk = disk_number(DVec2::new(off.dot(s), off.dot(t)) / radius);
            (index, light.invert_far(vertex.position)?, Some(on_disk))
        }
        Kind::Light { light, index, normal } => {
            (index, light.invert_position(vertex.position), light.invert_direction(normal, along))
        }
        Kind::Surface { light: index, normal, .. } => {
            let light = scene.lights.get(index)?;
            (index, light.invert_position(vertex.position), light.invert_direction(Some(normal), along))
        }
        _ => return None,
    };
    let direction = if count > 1 { scene.lights.unguide(index, direction?) } else { DVec2::splat(ANY) };
    writer.push(&[scene.lights.number(index, ANY)?, place.x, place.y, direction.x, direction.y]);
    for j in 1..count {
        let (i, on) = (last - j, j + 1 < count);
        let number = distance(path, i, &path.edge(i));
        let to_next = if on { Some(path.directions(i)) } else { None };
        write_vertex(path, i, number, to_next.map(|(to_camera, to_light)| (to_light, to_camera)), writer)?;
    }
    Some(())
}

/// The number of the flight along `edge` to x_i: a collision there, or the middle of those that pass all media.
fn distance(path: &Joined, i: usize, edge: &Edge) -> f64 {
    let collisions = mean(absorptance(edge.optical_depth));
    if matches!(path.vertex(i).kind, Kind::Medium { .. }) { collisions } else { 0.5 * (collisions + 1.0) }
}

/// The numbers of x_i: that of the distance to it, and those of the direction from it if the subpath goes on.
fn write_vertex(path: &Joined, i: usize, distance: f64, directions: Option<(DVec3, DVec3)>, writer: &mut Writer) -> Option<()> {
    let (direction, lobe) = match (directions, path.vertex(i).kind) {
        (None, _) => (DVec2::splat(ANY), ANY),
        (Some((back, on)), Kind::Medium { phase, .. }) => (phase.invert(back, on)?, ANY),
        (Some((back, on)), Kind::Surface { bsdf, normal, .. }) => bsdf.invert(normal, back, on)?,
        _ => return None,
    };
    writer.push(&[distance, direction.x, direction.y, lobe]);
    Some(())
}
