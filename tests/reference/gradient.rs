//! Gradient of log f with respect to one medium vertex, factor by factor, by formula.
//!
//! ```text
//! g(x) = ∇log σ_s(x) − ∇τ(p,x) − ∇τ(x,n) + ∇log G(p,x) + ∇log G(x,n) + phase (wing at p, apex at x, wing at n) + ∇log We
//! ```
//!
//! Source: [Lu20 (29)].
//! Differs from [Lu20 (29)]: ∇σ_s/σ_s, the importance and the cosines of surfaces, lights and the camera are missing there,
//! and so is the transmittance towards an environment.

use super::{
    factors::Factors,
    optical_depth_gradient::{Moving, optical_depth_gradient},
    path::{Path, Vertex},
    vector::*,
    world::World,
};

/// ∇ log f with respect to x_i, which is a medium vertex, split into factors. It has a meaning where f > 0.
pub fn log_gradient(world: &World, path: &Path, i: usize) -> Factors<Vec3> {
    let Vertex::Medium { position: x, medium } = path.vertices[i] else { panic!("x_{i} is not in a medium") };
    Factors {
        scattering: world.media[medium].log_sigma_s_gradient(x),
        transmittance_prev: transmittance(world, path, i - 1, Moving::End),
        transmittance_next: match path.vertices[i + 1].is_at_infinity() {
            false => transmittance(world, path, i, Moving::Start),
            true => transmittance(world, path, i, Moving::Whole),
        },
        geometry_prev: geometry(world, x, &path.vertices[i - 1]),
        geometry_next: geometry(world, x, &path.vertices[i + 1]),
        importance: importance(world, x, &path.vertices[i - 1]),
        profile_prev: [phase_wing(world, path, i, i - 1); 3],
        phase_apex: phase_apex(world, path, i),
        profile_next: [phase_wing(world, path, i, i + 1); 3],
    }
}

/// ∇ log Tr = −∇τ.
fn transmittance(world: &World, path: &Path, edge: usize, moving: Moving) -> RgbGradient {
    let gradient = optical_depth_gradient(world, &path.edge(world, edge), moving);
    gradient.total().map(|g| scale(-1.0, g))
}

/// ∇ log G(x, q): −2v/d² for 1/d² [Lu20 (26)] (which is printed unnormalised), and n/(n·v) − v/d² for the cosine at q.
/// No G, no gradient for an edge to infinity.
fn geometry(world: &World, x: Vec3, q: &Vertex) -> Vec3 {
    if q.is_at_infinity() {
        return ZERO;
    }
    let v = sub(x, q.position(world));
    let d2 = dot(v, v);
    let distance = scale(-2.0 / d2, v);
    match q.cosine_normal(world) {
        None => distance,
        Some(n) => {
            let cosine = sub(scale(1.0 / dot(n, v), n), scale(1.0 / d2, v));
            add(distance, cosine)
        }
    }
}

/// ∇ log cos⁻⁴θ = −4 ∇cosθ/cosθ, ∇cosθ = (n − cosθ·u)/d, if q is the camera.
/// Differs from [Lu20 (39)], whose importance for a camera vertex is 1/(πr² cosθ).
fn importance(world: &World, x: Vec3, q: &Vertex) -> Vec3 {
    if !matches!(q, Vertex::Camera) {
        return ZERO;
    }
    let camera = &world.camera;
    let u = direction(camera.position, x);
    let cosine = dot(camera.forward, u);
    let gradient = scale(1.0 / distance(camera.position, x), sub(camera.forward, scale(cosine, u)));
    scale(-4.0 / cosine, gradient)
}

/// The gradient of log f_p at vertex `q`, next to x_i, when x_i moves: ∇c = (u_o − c·u_x)/|x − q| [Lu20 (24)], u from q,
/// o the other neighbour of q. Zero if f_r and Le are constant there; where they are not, differences alone have the gradient.
fn phase_wing(world: &World, path: &Path, i: usize, q: usize) -> Vec3 {
    let vertex = path.vertices[q];
    assert!(!vertex.has_profile(), "no formula for {vertex:?}");
    let Vertex::Medium { position, medium } = vertex else {
        return ZERO;
    };
    let (before, after) = (path.direction_to_previous(world, q), path.direction_to_next(world, q));
    let (u_x, u_o) = if i < q { (before, after) } else { (after, before) };
    let c = dot(u_x, u_o);
    let x = path.vertices[i].position(world);
    let gradient_of_c = scale(1.0 / distance(x, position), sub(u_o, scale(c, u_x)));
    scale(world.media[medium].phase.log_derivative(c), gradient_of_c)
}

/// The gradient of log f_p at x_i itself: ∇c = −[(u_p − c·u_n)/|n − x| + (u_n − c·u_p)/|p − x|]; the first term is 0 for
/// n at infinity. Differs from [Lu20 (25)], which is the negative of this.
fn phase_apex(world: &World, path: &Path, i: usize) -> Vec3 {
    let Vertex::Medium { medium, .. } = path.vertices[i] else { panic!("x_{i} is not in a medium") };
    let (u_p, u_n) = (path.direction_to_previous(world, i), path.direction_to_next(world, i));
    let c = dot(u_p, u_n);
    let by_n = scale(1.0 / path.edge(world, i).length, sub(u_p, scale(c, u_n)));
    let by_p = scale(1.0 / path.edge(world, i - 1).length, sub(u_n, scale(c, u_p)));
    scale(-world.media[medium].phase.log_derivative(c), add(by_n, by_p))
}

/// ∇ log f per channel when the run of medium vertices `first..=last` moves rigidly: the sum of the gradients by each of
/// them. What depends on distances and directions inside the run cancels.
pub fn run_log_gradient(world: &World, path: &Path, first: usize, last: usize) -> RgbGradient {
    let by_vertex = |i| log_gradient(world, path, i).totals();
    (first..=last).map(by_vertex).fold([ZERO; 3], |sum, g| [0, 1, 2].map(|c| add(sum[c], g[c])))
}
