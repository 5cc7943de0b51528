//! A path as text, to find mistakes by: every vertex, every factor of f, and where light's log-gradient comes from.

use super::{Factors, LogGradient, Node, Path, PathError, PathErrorKind, contribution, factors, path_run_log_gradient};
use crate::math::{Colour, DVec3};
use crate::scene::Scene;
use crate::text::Text;

/// Writes it. What is wrong with the path stands where it was found, by name.
pub fn report(scene: &Scene, path: &Path, text: &mut Text) {
    text.put("path of ").whole(path.vertices.len() as u64).put(" vertices");
    match contribution(scene, path) {
        Ok(f) => colour(text.put(", f ="), f),
        Err(error) => wrong(text.put(", f: "), error),
    }
    text.put("\n");
    if let Err(error) = path.validate(scene) {
        wrong(text.put("not valid: "), error);
        text.put("\n");
    }
    for i in 0..path.vertices.len() {
        vertex(scene, path, i, text);
    }
}

fn vertex(scene: &Scene, path: &Path, i: usize, text: &mut Text) {
    text.put("vertex ").whole(i as u64).put(": ");
    let node = path.node(scene, i);
    let name = match &node {
        Ok(Node::Camera(_)) => "camera",
        Ok(Node::Medium(_)) => "medium",
        Ok(Node::Surface(bsdf)) if bsdf.is_specular() => "specular surface, material",
        Ok(Node::Surface(_)) => "surface, material",
        Ok(Node::Light(_)) => "light",
        Err(_) => "unknown",
    };
    text.put(name);
    if let (false, Ok(vertex)) = (matches!(node, Ok(Node::Camera(_))), path.vertex(i)) {
        text.put(" ").whole(vertex.index.into());
    }
    let is_direction = node.as_ref().is_ok_and(Node::is_direction);
    if let Ok(position) = path.position(scene, i) {
        vector(text.put(if is_direction { " towards" } else { " at" }), position);
    }
    if let (true, Ok(vertex)) = (node.as_ref().is_ok_and(Node::has_cosine), path.vertex(i)) {
        vector(text.put(", normal"), vertex.normal.wide());
    }
    text.put("\n");
    match factors(scene, path, i) {
        Ok(factors) => of_f(&factors, &node, text),
        Err(error) => {
            wrong(text.put("    f: "), error);
            text.put("\n");
        }
    }
    if let Ok(edge) = path.edge(scene, i) {
        text.put("    edge of ").number(edge.length).put(":");
        for segment in edge.segments {
            text.put(if segment.medium == crate::medium::NONE { " vacuum" } else { " medium " });
            if segment.medium != crate::medium::NONE {
                text.whole(segment.medium.into());
            }
            text.put(" to ").number(f64::from(segment.end));
        }
        text.put("\n");
    }
    if matches!(node, Ok(Node::Medium(_))) {
        match path_run_log_gradient(scene, path, i, 1) {
            Ok(gradient) => {
                vector(text.put("    grad log luminance ="), gradient.luminance);
                text.put("\n");
                of_gradient(&gradient.factors, text);
            }
            Err(error) => {
                wrong(text.put("    grad log luminance: "), error);
                text.put("\n");
            }
        }
    }
}

fn of_f(factors: &Factors, node: &Result<Node, PathError>, text: &mut Text) {
    let name = match node {
        Ok(Node::Camera(_)) => "    importance =",
        Ok(Node::Medium(_)) => "    sigma_s * phase =",
        Ok(Node::Surface(_)) => "    bsdf =",
        _ => "    emission =",
    };
    colour(text.put(name), factors.vertex);
    if !matches!(node, Ok(Node::Light(_))) {
        text.put(", geometry = ").number(factors.geometry);
        colour(text.put(", transmittance ="), factors.transmittance);
    }
    text.put("\n");
}

/// The factors' gradients under the names of `volgrad_gradient`, but for those that are 0.
fn of_gradient(g: &LogGradient, text: &mut Text) {
    let one = [
        ("scattering", g.scattering),
        ("geometry_previous", g.geometry_previous),
        ("geometry_next", g.geometry_next),
        ("importance", g.importance),
        ("phase_previous", g.phase_previous),
        ("phase_apex", g.phase_apex),
        ("phase_next", g.phase_next),
    ];
    for (name, v) in one.iter().filter(|(_, v)| *v != DVec3::ZERO) {
        vector(text.put("        ").put(name).put(" ="), *v);
        text.put("\n");
    }
    let each = [
        ("transmittance_previous", g.transmittance_previous),
        ("transmittance_next", g.transmittance_next),
        ("profile_previous", g.profile_previous),
        ("profile_next", g.profile_next),
    ];
    for (name, channels) in each.iter().filter(|(_, channels)| *channels != [DVec3::ZERO; 3]) {
        for (v, channel) in channels.iter().zip([" red =", " green =", " blue ="]) {
            vector(text.put("        ").put(name).put(channel), *v);
            text.put("\n");
        }
    }
}

fn vector(text: &mut Text, v: DVec3) {
    text.put(" ").number(v.x).put(" ").number(v.y).put(" ").number(v.z);
}

fn colour(text: &mut Text, c: Colour) {
    vector(text, c);
}

fn wrong(text: &mut Text, error: PathError) {
    let what = match error.kind {
        PathErrorKind::BadKind => "no such kind, or not in this place",
        PathErrorKind::BadIndex => "an index past its array",
        PathErrorKind::NotFinite => "not finite, or not of unit length",
        PathErrorKind::Misplaced => "off the lens, or not where the light is",
        PathErrorKind::ZeroLength => "at the place of the next vertex",
        PathErrorKind::BadSegments => {
            "segments missing, too many, out of order, too short, or of another medium than the vertex"
        }
        PathErrorKind::NotMovable => "cannot move freely: not in a medium, or beside a specular surface",
        PathErrorKind::ZeroContribution => "f is 0",
    };
    text.put(what).put(" (vertex or edge ").whole(error.index.into()).put(")");
}
