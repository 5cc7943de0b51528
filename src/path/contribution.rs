//! The contribution f(x̄) of a path, factor by factor:
//!
//! ```text
//! f = We Π_edges [ G Tr ] Π_inner [ σ_s f_p  or  f_r ] Le        [Lu20 (5)]
//! ```
//!
//! With specular vertices f is meant without their delta factors, in (direction, distance) measure along the chain.

use super::joint::{Joint, Leg};
use super::{Node, Path, PathError, PathErrorKind};
use crate::math::{Colour, DVec3, transmittance};
use crate::medium::{Line, optical_depth};
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
    let mut f = Colour::ONE;
    for_each_vertex(scene, path, |factors, edge| {
        f *= factors.product() * edge.map_or(Colour::ONE, |edge| transmittance(optical_depth(edge)));
    })?;
    Ok(f)
}

/// The factors at vertex `i`.
pub fn factors(scene: &Scene, path: &Path, i: usize) -> Result<Factors, PathError> {
    let last = last(path)?;
    let here = Joint::new(scene, path, i)?;
    let back = if i > 0 { -Joint::new(scene, path, i - 1)?.leg_to(&here, i - 1)?.direction } else { DVec3::ZERO };
    if i == last {
        return Ok(Factors { vertex: vertex_factor(&here, back, DVec3::ZERO), geometry: 1.0, transmittance: Colour::ONE });
    }
    let next = Joint::new(scene, path, i + 1)?;
    let leg = here.leg_to(&next, i)?;
    Ok(Factors {
        vertex: vertex_factor(&here, back, leg.direction),
        geometry: geometry(&here, &next, &leg),
        transmittance: transmittance(optical_depth(&here.line(scene, path, i, &leg)?)),
    })
}

/// The number of the last vertex; there are two at least.
fn last(path: &Path) -> Result<usize, PathError> {
    path.vertices.len().checked_sub(1).filter(|last| *last > 0).ok_or(PathErrorKind::BadKind.at(0))
}

/// Calls `each` with every vertex's factors but for transmittance, which costs the most, and the edge onwards from it.
pub(super) fn for_each_vertex(
    scene: &Scene,
    path: &Path,
    mut each: impl FnMut(Factors, Option<&Line>),
) -> Result<(), PathError> {
    let last = last(path)?;
    let (mut here, mut back) = (Joint::new(scene, path, 0)?, DVec3::ZERO);
    for i in 0..last {
        let next = Joint::new(scene, path, i + 1)?;
        let leg = here.leg_to(&next, i)?;
        let vertex = vertex_factor(&here, back, leg.direction);
        let factors = Factors { vertex, geometry: geometry(&here, &next, &leg), transmittance: Colour::ONE };
        each(factors, Some(&here.line(scene, path, i, &leg)?));
        (here, back) = (next, -leg.direction);
    }
    each(Factors { vertex: vertex_factor(&here, back, DVec3::ZERO), geometry: 1.0, transmittance: Colour::ONE }, None);
    Ok(())
}

/// Given unit vectors to both neighbours. The one that is missing at an end of the path is not looked at.
fn vertex_factor(here: &Joint, to_camera: DVec3, to_light: DVec3) -> Colour {
    match here.node {
        Node::Camera(camera) => {
            let cosine = camera.forward.dot(to_light);
            let seen = cosine > 0.0;
            Colour::splat(if seen { camera.importance(cosine) } else { 0.0 })
        }
        Node::Medium(medium) => medium.sigma_s(here.position) * medium.phase.eval(to_camera.dot(to_light)),
        Node::Surface(bsdf) => bsdf.eval_or_weight(&here.surface(), to_camera, to_light),
        Node::Light(light) => {
            let dark = light.area_pdf() > 0.0 && !(here.normal.dot(to_camera) > 0.0);
            if dark { Colour::ZERO } else { light.emission(to_camera) }
        }
    }
}

/// G of an edge: |cos| at its surface ends, cosθ at the camera, over d². Edges to infinity have only the near cosine; so have edges at
/// specular vertices, and only where their chain starts.
fn geometry(near: &Joint, far: &Joint, leg: &Leg) -> f64 {
    let cosine = |at: &Joint| match at.node {
        Node::Camera(camera) => camera.forward.dot(leg.direction).abs(),
        node if node.has_cosine() => at.normal.dot(leg.direction).abs(),
        _ => 1.0,
    };
    let near_cosine = if near.node.is_specular() { 1.0 } else { cosine(near) };
    if far.node.is_direction() || near.node.is_specular() || far.node.is_specular() {
        return near_cosine;
    }
    near_cosine * cosine(far) / (leg.length * leg.length)
}
