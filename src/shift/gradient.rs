//! ∇log f* of each of a path's contributions when its run moves: a sum over the run in which all that it keeps inside cancels.

use super::link::Link;
use super::run::{GROUPS, PLAIN, Place, Progress, RunVertex, Shiftable, WINGS};
use crate::math::{Colour, DVec3, LUMINANCE, luminance};
use crate::path::{Neighbour, Seen, Wing};
use crate::phase::cosine_gradient_apex;
use crate::scene::{Camera, Scene};

/// Per group, 1/world unit; 0 for those that carry nothing.
pub type GroupGradients = [DVec3; GROUPS];

/// A gradient per colour channel.
#[derive(Clone, Copy)]
struct PerChannel([DVec3; 3]);

impl PerChannel {
    fn plus(self, shared: DVec3) -> Self {
        Self(self.0.map(|g| g + shared))
    }

    fn minus(self, slopes: &[DVec3; 3]) -> Self {
        Self(core::array::from_fn(|c| self.0[c] - slopes[c]))
    }

    /// ∇log of the luminance of what has this colour, up to a factor.
    fn of_luminance(self, f: Colour) -> DVec3 {
        let total = luminance(f);
        (0..3).map(|c| self.0[c] * (LUMINANCE[c] * f[c] / total)).sum()
    }
}

pub(super) fn group_gradients(camera: &Camera, scene: &Scene, path: &Shiftable, own: &Progress) -> GroupGradients {
    let mut gradients = [DVec3::ZERO; GROUPS];
    let rests = path.rests();
    let mut set = |g: usize, gradient: PerChannel| {
        let (Some(slot), Some(value), Some(rest)) = (gradients.get_mut(g), own.values.get(g), rests.get(g)) else { return };
        let colour = *value * *rest;
        if luminance(colour) > 0.0 {
            *slot = gradient.of_luminance(colour);
        }
    };
    let mut a = PerChannel([DVec3::ZERO; 3]);
    for (i, vertex) in path.run().iter().enumerate() {
        a = a.plus(scattering(scene, vertex)).minus(&vertex.depth.slope);
        if i == 0 {
            let seen = Seen::from(&camera.at(path.image.ray.origin), vertex.x, Neighbour::Camera);
            a = a.plus(seen.geometry_gradient() + seen.importance_gradient(camera));
        }
        for (g, exit) in path.exits().iter().enumerate().filter(|(_, exit)| exit.from == i) {
            let gradient = a.plus(link_gradient(camera, scene, path, i, &exit.link)).minus(&exit.link.depth.slope);
            let wing = exit.wing.map_or(DVec3::ZERO, |(phase, to_other)| {
                Seen::from(camera, vertex.x, exit.link.next.neighbour()).wing_gradient(&Wing { phase, to_other })
            });
            set(g, gradient.plus(wing));
        }
        if let Some(onwards) = path.onwards.as_ref().filter(|onwards| onwards.from == i) {
            let gradient = a.plus(link_gradient(camera, scene, path, i, &onwards.link)).minus(&onwards.link.depth.slope);
            set(PLAIN, gradient);
            let seen = Seen::from(camera, vertex.x, onwards.link.next.neighbour());
            for (wing, (to_other, _)) in onwards.wings().iter().enumerate() {
                let wing_at_next = Wing { phase: onwards.phase, to_other: *to_other };
                set(WINGS + wing, gradient.plus(seen.wing_gradient(&wing_at_next)));
            }
        }
        if i == 0 {
            // Inside the run directions stay: only the one to the camera turns.
            if let Some(next) = path.run().get(1) {
                a = a.plus(apex(
                    scene,
                    vertex,
                    (-path.image.ray.direction, path.image.distance),
                    (-next.to_previous, f64::INFINITY),
                ));
            }
        }
    }
    gradients
}

/// ∇σ_s/σ_s.
fn scattering(scene: &Scene, vertex: &RunVertex) -> DVec3 {
    let Some(medium) = scene.medium(vertex.place.medium()) else { return DVec3::ZERO };
    let (density, gradient) = medium.density.with_gradient(vertex.x);
    gradient / density
}

/// ∇log of f_p G of a link from the run's vertex `i`.
fn link_gradient(camera: &Camera, scene: &Scene, path: &Shiftable, i: usize, link: &Link) -> DVec3 {
    let Some(vertex) = path.run().get(i) else { return DVec3::ZERO };
    let previous = if i == 0 { (-path.image.ray.direction, path.image.distance) } else { (vertex.to_previous, f64::INFINITY) };
    let geometry = Seen::from(camera, vertex.x, link.next.neighbour()).geometry_gradient();
    geometry + apex(scene, vertex, previous, link.next.seen_from(vertex.x))
}

/// ∇log f_p at a vertex between two others, in these unit directions and at these distances (infinite: the direction stays).
fn apex(scene: &Scene, vertex: &RunVertex, (to_p, distance_p): (DVec3, f64), (to_n, distance_n): (DVec3, f64)) -> DVec3 {
    let Place::Medium(index) = vertex.place else { return DVec3::ZERO };
    let phase = scene.medium(index).map(|medium| medium.phase).unwrap_or_default();
    let c = to_p.dot(to_n);
    phase.log_derivative(c) * cosine_gradient_apex(to_p, to_n, c, distance_p, distance_n)
}
