//! The gradient of log f with respect to one medium vertex. [Lu20 (29)], with the term ∇σ_s/σ_s that is missing there.

use super::{Node, Path, PathError, PathErrorKind, factors};
use crate::math::{Colour, DVec3, luminance};
use crate::medium::{Line, Medium, moments};
use crate::phase::{Phase, cosine_gradient_apex, cosine_gradient_wing};
use crate::scene::{Camera, Scene};

/// A neighbour of the moving vertex, as far as the gradient depends on it.
#[derive(Clone, Copy, Debug)]
pub enum Neighbour {
    /// The camera's centre of projection.
    Camera,
    /// A point, with its normal if the geometry term has a cosine there.
    Point { position: DVec3, normal: Option<DVec3> },
    /// Infinitely far away: this unit direction is kept.
    Direction(DVec3),
}

/// A phase function at a neighbour, whose angle changes when the vertex moves.
#[derive(Clone, Copy, Debug)]
pub struct Wing {
    pub phase: Phase,
    /// Unit vector from the neighbour to its own other neighbour.
    pub to_other: DVec3,
}

/// A medium vertex x between its neighbours p (towards the camera) and n (towards the light).
#[derive(Clone, Copy, Debug)]
pub struct Move<'a> {
    pub x: DVec3,
    pub medium: &'a Medium<'a>,
    pub previous: Neighbour,
    pub next: Neighbour,
    /// From p to x, and from x to n.
    pub previous_line: Line<'a>,
    pub next_line: Line<'a>,
    pub previous_wing: Option<Wing>,
    pub next_wing: Option<Wing>,
}

/// ∇log of every factor of f that depends on x, 1/world unit.
#[derive(Clone, Copy, Debug, Default)]
pub struct LogGradient {
    /// ∇σ_s/σ_s
    pub scattering: DVec3,
    /// −∇τ(p, x) and −∇τ(x, n), per colour channel.
    pub transmittance_previous: [DVec3; 3],
    pub transmittance_next: [DVec3; 3],
    /// ∇log G(p, x) and ∇log G(x, n), cosines at p and n included.
    pub geometry_previous: DVec3,
    pub geometry_next: DVec3,
    /// ∇log W_e
    pub importance: DVec3,
    /// ∇log f_p at p, x and n.
    pub phase_previous: DVec3,
    pub phase_apex: DVec3,
    pub phase_next: DVec3,
}

impl LogGradient {
    /// ∇log of one colour channel of f.
    pub fn channel(&self, c: usize) -> DVec3 {
        let shared = self.scattering + self.geometry_previous + self.geometry_next + self.importance;
        let phases = self.phase_previous + self.phase_apex + self.phase_next;
        shared + phases + self.transmittance_previous[c] + self.transmittance_next[c]
    }

    /// ∇log of the luminance of f, whose colour is `f` up to a factor.
    pub fn of_luminance(&self, f: Colour) -> DVec3 {
        let total = luminance(f);
        (0..3).map(|c| self.channel(c) * (crate::math::LUMINANCE[c] * f[c] / total)).sum()
    }
}

/// The gradient of a path's contribution.
#[derive(Clone, Copy, Debug)]
pub struct Gradient {
    pub factors: LogGradient,
    /// ∇log luminance(f)
    pub luminance: DVec3,
}

/// ∇log f for all factors that depend on x. None where σ_s(x) = 0.
pub fn log_gradient(camera: &Camera, m: &Move) -> Option<LogGradient> {
    let density = m.medium.density.at(m.x);
    if !(density > 0.0) {
        return None;
    }
    let previous = Seen::from(camera, m.x, m.previous);
    let next = Seen::from(camera, m.x, m.next);
    let c = previous.towards.dot(next.towards);
    let apex = cosine_gradient_apex(previous.towards, next.towards, c, previous.distance, next.distance);
    let before = moments(&m.previous_line).far_gradient(m.previous_line.direction, m.previous_line.length);
    let after = moments(&m.next_line).near_gradient(m.next_line.direction, m.next_line.length);
    Some(LogGradient {
        scattering: m.medium.density.gradient(m.x) / density,
        transmittance_previous: before.map(|g| -g),
        transmittance_next: after.map(|g| -g),
        geometry_previous: previous.geometry_gradient(),
        geometry_next: next.geometry_gradient(),
        importance: match m.previous {
            // cos⁻⁴ of We; its own cosine in G is counted there. [Lu20 (38)] has −1/cosθ instead.
            Neighbour::Camera => -4.0 * previous.cosine_gradient(camera.forward),
            _ => DVec3::ZERO,
        },
        phase_previous: m.previous_wing.map_or(DVec3::ZERO, |wing| previous.wing_gradient(&wing)),
        phase_apex: m.medium.phase.log_derivative(c) * apex,
        phase_next: m.next_wing.map_or(DVec3::ZERO, |wing| next.wing_gradient(&wing)),
    })
}

/// ∇log of the phase function at the neighbour `q` of x, x being one of its wings. [Lu20 (24)]
pub fn wing_log_gradient(camera: &Camera, x: DVec3, q: Neighbour, wing: &Wing) -> DVec3 {
    Seen::from(camera, x, q).wing_gradient(wing)
}

/// A neighbour q seen from x.
struct Seen {
    /// Unit vector from x to q.
    towards: DVec3,
    /// Infinite for a direction.
    distance: f64,
    normal: Option<DVec3>,
}

impl Seen {
    fn from(camera: &Camera, x: DVec3, neighbour: Neighbour) -> Self {
        let (position, normal) = match neighbour {
            Neighbour::Camera => (camera.position, Some(camera.forward)),
            Neighbour::Point { position, normal } => (position, normal),
            Neighbour::Direction(towards) => return Self { towards, distance: f64::INFINITY, normal: None },
        };
        let distance = (position - x).length();
        Self { towards: (position - x) / distance, distance, normal }
    }

    /// ∇log of |cos|/d²: n/(n·v) − v/d² and −2v/d², v = x − q.
    fn geometry_gradient(&self) -> DVec3 {
        if self.distance.is_infinite() {
            return DVec3::ZERO;
        }
        let inverse_square = 2.0 * self.towards / self.distance;
        inverse_square + self.normal.map_or(DVec3::ZERO, |n| self.cosine_gradient(n))
    }

    /// ∇log of the cosine to the normal n at q.
    fn cosine_gradient(&self, n: DVec3) -> DVec3 {
        let v = -self.towards;
        (n / n.dot(v) - v) / self.distance
    }

    /// ∇log f_p at apex q, x being its wing. [Lu20 (24)]
    fn wing_gradient(&self, wing: &Wing) -> DVec3 {
        let to_x = -self.towards;
        let c = to_x.dot(wing.to_other);
        wing.phase.log_derivative(c) * cosine_gradient_wing(to_x, wing.to_other, c, self.distance)
    }
}

/// The gradient of log f when the medium vertex `i` of `path` moves.
pub fn path_log_gradient(scene: &Scene, path: &Path, i: usize) -> Result<Gradient, PathError> {
    let Node::Medium(medium) = path.node(scene, i)? else { return Err(PathErrorKind::NotMovable.at(i)) };
    let x = path.vertex(i)?.position.wide();
    let (previous, previous_wing) = neighbour(scene, path, i, i - 1, i.checked_sub(2))?;
    let (next, next_wing) = neighbour(scene, path, i, i + 1, Some(i + 2).filter(|o| *o < path.vertices.len()))?;
    let m = Move {
        x,
        medium,
        previous,
        next,
        previous_line: path.edge(scene, i - 1)?,
        next_line: path.edge(scene, i)?,
        previous_wing,
        next_wing,
    };
    let factors = log_gradient(&scene.camera.at(path.position(scene, 0)?), &m).ok_or(PathErrorKind::ZeroContribution.at(i))?;
    let colour = relative_colour(scene, path)?;
    if !(luminance(colour) > 0.0) {
        return Err(PathErrorKind::ZeroContribution.at(i));
    }
    Ok(Gradient { factors, luminance: factors.of_luminance(colour) })
}

/// The neighbour `q` of vertex `i`, and the phase function at it if its other neighbour `o` makes it an apex.
fn neighbour(scene: &Scene, path: &Path, i: usize, q: usize, o: Option<usize>) -> Result<(Neighbour, Option<Wing>), PathError> {
    let vertex = path.vertex(q)?;
    let position = path.position(scene, q)?;
    let node = path.node(scene, q)?;
    match node {
        Node::Camera(_) => return Ok((Neighbour::Camera, None)),
        node if node.is_specular() => return Err(PathErrorKind::NotMovable.at(i)),
        node if node.is_direction() => return Ok((Neighbour::Direction(position), None)),
        _ => {}
    }
    let normal = node.has_cosine().then(|| vertex.normal.wide());
    let wing = match (node, o) {
        (Node::Medium(medium), Some(o)) => {
            let other = path.position(scene, o)?;
            let to_other = if path.node(scene, o)?.is_direction() { other } else { other - position };
            let to_other = to_other.try_normalize().ok_or(PathErrorKind::ZeroLength.at(q))?;
            Some(Wing { phase: medium.phase, to_other })
        }
        _ => None,
    };
    Ok((Neighbour::Point { position, normal }, wing))
}

/// f up to a positive factor, kept in range however long the path.
fn relative_colour(scene: &Scene, path: &Path) -> Result<Colour, PathError> {
    (0..path.vertices.len()).try_fold(Colour::ONE, |colour, i| {
        let f = colour * factors(scene, path, i)?.product();
        let largest = f.max_element();
        Ok(if largest > 0.0 { f / largest } else { f })
    })
}
