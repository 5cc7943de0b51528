//! The contribution f(x̄) of a path, factor by factor:
//!
//! ```text
//! f = We Π_edges [ G Tr ] Π_inner [ σ_s f_p  or  f_r ] Le        [Lu20 (5)]
//! ```
//!
//! With specular vertices f is meant without their delta factors, in (direction, distance) measure along the chain.

use super::{Node, Path, PathError, PathErrorKind};
use crate::math::{Colour, DVec3, transmittance};
use crate::medium::optical_depth;
use crate::scene::Scene;

/// The factors of f that belong to vertex i and to the edge from it to vertex i + 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// We at the camera, σ_s·f_p in a medium, f_r on a surface, Le at the light.
    pub vertex: Colour,
    /// G of the edge; 1 at the last vertex.
    pub geometry: f64,
    /// Tr of the edge; 1 at the last vertex.
    pub transmittance: Colour,
}

impl Factors {
    pub fn product(&self) -> Colour {
        self.vertex * self.geometry * self.transmittance
    }
}

/// f in linear RGB. Long paths can exceed the range of a double: infinite then.
pub fn contribution(scene: &Scene, path: &Path) -> Result<Colour, PathError> {
    (0..path.vertices.len()).try_fold(Colour::ONE, |f, i| Ok(f * factors(scene, path, i)?.product()))
}

/// The factors at vertex `i`.
pub fn factors(scene: &Scene, path: &Path, i: usize) -> Result<Factors, PathError> {
    let factors = in_vacuum(scene, path, i)?;
    if i + 1 == path.vertices.len() {
        return Ok(factors);
    }
    Ok(Factors { transmittance: transmittance(optical_depth(&path.edge(scene, i)?)), ..factors })
}

/// The factors at vertex `i` but for transmittance, which costs the most.
pub(super) fn in_vacuum(scene: &Scene, path: &Path, i: usize) -> Result<Factors, PathError> {
    let vertex = vertex_factor(scene, path, i)?;
    let geometry = if i + 1 == path.vertices.len() { 1.0 } else { geometry(scene, path, i)? };
    Ok(Factors { vertex, geometry, transmittance: Colour::ONE })
}

/// Unit vector from vertex i to a neighbour of it.
pub(super) fn towards(path: &Path, scene: &Scene, i: usize, neighbour: usize) -> Result<DVec3, PathError> {
    let to = path.position(scene, neighbour)?;
    if path.is_direction(scene, neighbour)? {
        return Ok(to);
    }
    let v = to - path.position(scene, i)?;
    v.try_normalize().ok_or(PathErrorKind::ZeroLength.at(i))
}

/// Unit vector along which light travels from the light at vertex `i` to the vertex before it.
fn emission_direction(scene: &Scene, path: &Path, i: usize) -> Result<DVec3, PathError> {
    if path.node(scene, i)?.is_direction() { Ok(-path.position(scene, i)?) } else { towards(path, scene, i, i - 1) }
}

fn vertex_factor(scene: &Scene, path: &Path, i: usize) -> Result<Colour, PathError> {
    let vertex = path.vertex(i)?;
    let normal = vertex.normal.wide();
    match path.node(scene, i)? {
        Node::Camera(camera) => {
            let cosine = camera.forward.dot(towards(path, scene, i, i + 1)?);
            let seen = cosine > 0.0;
            Ok(Colour::splat(if seen { camera.importance(cosine) } else { 0.0 }))
        }
        Node::Medium(medium) => {
            let c = towards(path, scene, i, i - 1)?.dot(towards(path, scene, i, i + 1)?);
            Ok(medium.sigma_s(vertex.position.wide()) * medium.phase.eval(c))
        }
        Node::Surface(bsdf) => {
            let (to_camera, to_light) = (towards(path, scene, i, i - 1)?, towards(path, scene, i, i + 1)?);
            Ok(bsdf.eval_or_weight(normal, to_camera, to_light))
        }
        Node::Light(light) => {
            let direction = emission_direction(scene, path, i)?;
            let dark = light.area_pdf() > 0.0 && !(normal.dot(direction) > 0.0);
            Ok(if dark { Colour::ZERO } else { light.emission(direction) })
        }
    }
}

/// G of the edge from vertex i to i + 1: |cos| at its surface ends, cosθ at the camera, over d². Edges to infinity have only the
/// near cosine; so have edges at specular vertices, and only where their chain starts.
fn geometry(scene: &Scene, path: &Path, i: usize) -> Result<f64, PathError> {
    let (near, far) = (path.node(scene, i)?, path.node(scene, i + 1)?);
    let (from, to) = (path.vertex(i)?, path.vertex(i + 1)?);
    let direction = towards(path, scene, i, i + 1)?;
    let cosine = |node: &Node, normal: DVec3| match node {
        Node::Camera(camera) => camera.forward.dot(direction).abs(),
        node if node.has_cosine() => normal.dot(direction).abs(),
        _ => 1.0,
    };
    let near_cosine = if near.is_specular() { 1.0 } else { cosine(&near, from.normal.wide()) };
    if far.is_direction() || near.is_specular() || far.is_specular() {
        return Ok(near_cosine);
    }
    let distance_squared = (path.position(scene, i + 1)? - path.position(scene, i)?).length_squared();
    Ok(near_cosine * cosine(&far, to.normal.wide()) / distance_squared)
}
