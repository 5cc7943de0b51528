//! Prepares a path of any sampler for shifting.

use super::kernel::{Mode, Options};
use super::link::{Depth, Link, Next, Onwards};
use super::run::{Place, RunVertex, Shiftable};
use crate::math::{Colour, DVec3, luminance};
use crate::medium::{Line, NONE, moments, optical_depth};
use crate::path::{Node, Path, PathError, PathErrorKind, factors};
use crate::phase::Phase;
use crate::scene::{MAX_SEGMENTS, Scene};

/// Prepares a path of any sampler, with weight C = w·f/p in RGB. None: it stays as it is, because its first vertex may not move, or because f
/// is 0 as seen from here: what the host rounded otherwise carries light that must not be lost.
pub fn from_path(scene: &Scene, path: &Path, weight: Colour, options: &Options) -> Result<Option<Shiftable>, PathError> {
    let mut shiftable = Shiftable::none();
    Ok(prepare(scene, path, weight, options, &mut shiftable)?.then_some(shiftable))
}

/// The same in the place of another path. False: it stays as it is.
pub fn prepare(
    scene: &Scene,
    path: &Path,
    weight: Colour,
    options: &Options,
    shiftable: &mut Shiftable,
) -> Result<bool, PathError> {
    options.check(scene).map_err(|_| PathErrorKind::NoGradient.at(1))?;
    let Some(length) = run_length(scene, path, options)? else { return Ok(false) };
    let lens = scene.camera.on_lens(path.position(scene, 0)?);
    let image = scene.camera.project(path.position(scene, 1)?, lens).ok_or(PathErrorKind::ZeroContribution.at(1))?;
    shiftable.clear();
    shiftable.renew(image, run_vertex(scene, path, 1, options.mode)?);
    for i in 2..=length {
        shiftable.push(run_vertex(scene, path, i, options.mode)?);
    }
    let mut onwards = link_onwards(scene, path, length, options.mode)?;
    let rest = rest(scene, path, length + 1)?;
    match to_other(scene, path, length + 1)? {
        Some(direction) => onwards.add_wing(direction, rest),
        None => onwards.plain = rest,
    }
    shiftable.onwards = Some(onwards);
    let scale = luminance(weight) / luminance(shiftable.carried(scene));
    shiftable.onwards = Some(onwards.scaled(scale));
    Ok(scale.is_finite())
}

/// How many vertices move, the medium vertices from the camera on, or one on a surface. The vertex after them must be one to connect to.
fn run_length(scene: &Scene, path: &Path, options: &Options) -> Result<Option<usize>, PathError> {
    let connects = |i: usize| {
        Ok(match path.node(scene, i)? {
            Node::Surface(bsdf) => bsdf.is_lambertian(),
            Node::Light(light) => !light.has_profile(),
            _ => true,
        })
    };
    let mut length = 1;
    match path.node(scene, 1)? {
        Node::Medium(_) => {
            while length < options.run && matches!(path.node(scene, length + 1)?, Node::Medium(_)) {
                length += 1;
            }
        }
        Node::Surface(bsdf) if !bsdf.is_specular() && !bsdf.transmits() => {}
        _ => return Ok(None),
    }
    if !connects(length + 1)? {
        length -= 1;
    }
    Ok((length > 0).then_some(length))
}

fn run_vertex(scene: &Scene, path: &Path, i: usize, mode: Mode) -> Result<RunVertex, PathError> {
    let edge = edge(scene, path, i - 1)?;
    let vertex = path.vertex(i)?;
    let place = match path.node(scene, i)? {
        Node::Surface(bsdf) => {
            let medium = path.edge(scene, i)?.segments.first().map_or(NONE, |segment| segment.medium);
            let normal = bsdf.facing(vertex.normal.wide().normalize_or_zero(), -edge.direction);
            Place::Surface { material: vertex.index, normal, medium, user: vertex.user }
        }
        _ => Place::Medium(vertex.index),
    };
    let depth = if !mode.has_derivatives() {
        Depth::constant(optical_depth(&edge))
    } else if i == 1 {
        Depth::far(&moments(&edge), edge.direction, edge.length)
    } else {
        Depth::whole(&moments(&edge))
    };
    let x = path.position(scene, i)?;
    Ok(RunVertex { x, place, depth, to_previous: -edge.direction, distance: edge.length })
}

/// The link from the run's last vertex to the next one.
fn link_onwards(scene: &Scene, path: &Path, last: usize, mode: Mode) -> Result<Onwards, PathError> {
    let node = path.node(scene, last + 1)?;
    let position = path.position(scene, last + 1)?;
    let edge = edge(scene, path, last)?;
    let outside = path.vertex(last + 1)?.normal.wide();
    let normal = match node {
        Node::Surface(bsdf) => bsdf.facing(outside, -edge.direction),
        _ => outside,
    };
    let next = if node.is_direction() {
        Next::Direction(position)
    } else {
        Next::Point { position, normal: node.has_cosine().then_some(normal) }
    };
    let depth = if mode.has_derivatives() {
        Depth::near(&moments(&edge), edge.direction, edge.length)
    } else {
        Depth::constant(optical_depth(&edge))
    };
    let phase = match node {
        Node::Medium(medium) => medium.phase,
        _ => Phase::ISOTROPIC,
    };
    Ok(Onwards::new(Link { next, depth }, last - 1, phase))
}

fn edge<'s>(scene: &'s Scene, path: &Path<'s>, i: usize) -> Result<Line<'s>, PathError> {
    let edge = path.edge(scene, i)?;
    if edge.segments.len() > MAX_SEGMENTS { Err(PathErrorKind::BadSegments.at(i)) } else { Ok(edge) }
}

/// The factors from vertex `first` on. Only their ratios between the channels matter.
fn rest(scene: &Scene, path: &Path, first: usize) -> Result<Colour, PathError> {
    (first..path.vertices.len()).try_fold(Colour::ONE, |rest, i| {
        let f = rest * factors(scene, path, i)?.product();
        let largest = f.max_element();
        Ok(if largest > 0.0 { f / largest } else { f })
    })
}

/// The direction onwards from vertex `i`, if it is in a medium.
fn to_other(scene: &Scene, path: &Path, i: usize) -> Result<Option<DVec3>, PathError> {
    if !matches!(path.node(scene, i)?, Node::Medium(_)) {
        return Ok(None);
    }
    let other = path.position(scene, i + 1)?;
    let v = if path.node(scene, i + 1)?.is_direction() { other } else { other - path.position(scene, i)? };
    Ok(Some(v.try_normalize().ok_or(PathErrorKind::ZeroLength.at(i))?))
}
