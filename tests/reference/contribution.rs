//! The contribution of a path, factor by factor:
//!
//! ```text
//! f(x̄) = We(x_0→x_1) · Π_edges [ G(x_i,x_{i+1}) · Tr(x_i,x_{i+1}) ] · Π_inner [ σ_s(x_i) f_p   or   f_r ] · Le(x_k→x_{k−1})
//! ```
//!
//! Source: [Lu20 (5)], seen from the camera as in [Lu20 (27)].
//! Differs from [Lu20 (10)]: G has the cosines of surfaces, area lights and the camera.
//!
//! A chain of specular vertices is in (direction, distance) measure: dω at the vertex where it starts, towards the camera, and the
//! distance along it replace the volume or area at its end. dω = G dA of the unfolded chain takes its G away, but for the cosine
//! where it starts (the measure of directions at a surface is the projected one).

use super::{
    optical_depth::optical_depth,
    path::{Path, Vertex},
    vector::*,
    world::World,
};
use std::f64::consts::PI;

#[derive(Clone, Debug)]
pub struct Contribution {
    /// We(x_0→x_1) = 1/(A cos⁴θ).
    pub importance: f64,
    /// G of edge i, from x_i to x_{i+1}.
    pub geometry: Vec<f64>,
    /// Tr of edge i.
    pub transmittance: Vec<Rgb>,
    /// σ_s(x_i) at a medium vertex, 1 at all others.
    pub scattering: Vec<Rgb>,
    /// f_p or f_r at x_i, 1 at both ends.
    pub profile: Vec<Rgb>,
    /// Le(x_k→x_{k−1}), or the intensity or irradiance of a light that has those.
    pub emission: Rgb,
}

impl Contribution {
    /// f(x̄).
    pub fn total(&self) -> Rgb {
        let geometry: f64 = self.geometry.iter().product();
        let colours = [&self.transmittance, &self.scattering, &self.profile].into_iter().flatten();
        colours.fold(scale(self.importance * geometry, self.emission), |f, &c| product(f, c))
    }
}

pub fn contribution(world: &World, path: &Path) -> Contribution {
    let edges = 0..path.edge_count();
    let vertices = 0..path.vertices.len();
    Contribution {
        importance: world.camera.importance(path.vertices[1].position(world)),
        geometry: edges.clone().map(|i| geometry(world, path, i)).collect(),
        transmittance: edges.map(|i| transmittance(world, path, i)).collect(),
        scattering: vertices.clone().map(|i| scattering(world, path, i)).collect(),
        profile: vertices.map(|i| profile(world, path, i)).collect(),
        emission: emission(world, path),
    }
}

/// G = C(x_i)·C(x_{i+1})/d², and C(x_i) alone for an edge to infinity.
///
/// The cosine of a *surface* lit from infinity stays: f is then in solid angle measure at that surface, and the light
/// arrives at its plane under that cosine.
fn geometry(world: &World, path: &Path, i: usize) -> f64 {
    let edge = path.edge(world, i);
    let cosine = |vertex: &Vertex| vertex.cosine_normal(world).map_or(1.0, |n| dot(n, edge.direction).abs());
    let (near, far) = (&path.vertices[i], &path.vertices[i + 1]);
    if near.is_specular() {
        return 1.0;
    }
    if far.is_specular() {
        return cosine(near);
    }
    let cosines = cosine(near) * cosine(far);
    if edge.length.is_finite() { cosines / edge.length.powi(2) } else { cosines }
}

/// Tr = exp(−τ) [Lu20 (6)].
fn transmittance(world: &World, path: &Path, i: usize) -> Rgb {
    optical_depth(world, &path.edge(world, i)).map(|tau| (-tau).exp())
}

fn scattering(world: &World, path: &Path, i: usize) -> Rgb {
    match path.vertices[i] {
        Vertex::Medium { position, medium } => world.media[medium].sigma_s_at(position),
        _ => ONE,
    }
}

fn profile(world: &World, path: &Path, i: usize) -> Rgb {
    match path.vertices[i] {
        // [Lu20 (8), (9)]
        Vertex::Medium { medium, .. } => {
            let c = path.cosine_at(world, i);
            [world.media[medium].phase.value(c); 3]
        }
        // f_r = albedo/π on the front, as in [Lu20 (42)].
        Vertex::Diffuse { normal, albedo, .. } => {
            let in_front =
                dot(normal, path.direction_to_previous(world, i)) > 0.0 && dot(normal, path.direction_to_next(world, i)) > 0.0;
            if in_front { scale(1.0 / PI, albedo) } else { ZERO }
        }
        Vertex::Rough { normal, alpha, microfacets, .. } => {
            microfacets.value(alpha, normal, path.direction_to_previous(world, i), path.direction_to_next(world, i))
        }
        Vertex::Mirror { reflectance, .. } => reflectance,
        _ => ONE,
    }
}

/// Every texel by how far it is from the direction, in columns and rows.
fn sky_radiance([x, y, z]: Vec3, texels: &[Rgb; 12]) -> Rgb {
    let (column, row) = (4.0 * x.atan2(-z) / (2.0 * PI) - 0.5, 2.0 * y.acos() / PI);
    let mut radiance = ZERO;
    for (n, &texel) in texels.iter().enumerate() {
        let columns = column - (n % 4) as f64;
        let columns = (columns - 4.0 * (columns / 4.0).round()).abs();
        let rows = (row - (n / 4) as f64).abs();
        radiance = add(radiance, scale((1.0 - columns).max(0.0) * (1.0 - rows).max(0.0), texel));
    }
    radiance
}

fn emission(world: &World, path: &Path) -> Rgb {
    let k = path.edge_count();
    match path.vertices[k] {
        Vertex::AreaLight { normal, radiance, .. } => {
            let in_front = dot(normal, path.direction_to_previous(world, k)) > 0.0;
            if in_front { radiance } else { ZERO }
        }
        Vertex::PointLight { intensity, .. } => intensity,
        Vertex::Spot { axis, inner, outer, intensity, .. } => {
            let angle = dot(axis, path.direction_to_previous(world, k)).acos();
            scale(((outer - angle) / (outer - inner)).clamp(0.0, 1.0), intensity)
        }
        Vertex::Environment { radiance, .. } => radiance,
        Vertex::Sky { direction, texels } => sky_radiance(direction, &texels),
        Vertex::Directional { irradiance, .. } => irradiance,
        _ => panic!("a path ends on a light"),
    }
}
