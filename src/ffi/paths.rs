//! Contribution and gradient of a path.

use super::pointer::{array, array_mut, output, reference};
use super::scenes::{finish_with, scene, volgrad_scene};
use super::status::{Fault, finish, volgrad_error, volgrad_status, volgrad_status::*};
use super::types::volgrad_path;
use crate::math::{DVec3, Rgb, Vec3};
use crate::path::{self, Gradient, LogDerivative, Path, contribution, factors, path_run_log_derivative, path_run_log_gradient};
use crate::text::Text;
use core::ffi::c_char;

/// The factors of f at one vertex and along the edge from it to the next.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_path_factor {
    /// Camera: importance We. Medium: sigma_s times phase function. Surface: BSDF, without its delta factor if specular. Light: emission.
    pub vertex: Rgb,
    /// Transmittance of the edge; 1 at the last vertex.
    pub transmittance: Rgb,
    /// Geometry term of the edge: cosines over squared distance, 1/world unit^2; without distance for an edge to infinity; 1 at the
    /// last vertex, and along specular chains but for the cosine where they start.
    pub geometry: f64,
}

/// Gradient of log f with respect to the position of one medium vertex x, or of a run of consecutive ones that move by the same offset,
/// 1/world unit, in world axes. p is the vertex before (towards the camera), n the one after (towards the light). [Lu20 (29)] with the
/// term of sigma_s that is missing there, and without the factors inside a run that a common offset does not change. Per-channel arrays:
/// 0 red, 1 green, 2 blue.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_gradient {
    /// Gradient of log luminance(f).
    pub luminance: Vec3,
    /// Gradient of log f per channel: the sum of all factors below.
    pub rgb: [Vec3; 3],
    /// Scattering coefficient: grad sigma_s / sigma_s, summed over the run.
    pub scattering: Vec3,
    /// Transmittance, -grad tau: of the edge from p to the run's first vertex, of all edges inside the run (0 for a single vertex), and of
    /// the edge from its last vertex to n. Surfaces at which sigma_t jumps count.
    pub transmittance_previous: [Vec3; 3],
    pub transmittance_inside: [Vec3; 3],
    pub transmittance_next: [Vec3; 3],
    /// Geometry terms of the edges to p and n, with the cosines there (at the camera: that of G).
    pub geometry_previous: Vec3,
    pub geometry_next: Vec3,
    /// The camera's importance, if p is the camera.
    pub importance: Vec3,
    /// Phase functions at p, at the run's first and last vertex together, and at n; 0 where there is none.
    pub phase_previous: Vec3,
    pub phase_apex: Vec3,
    pub phase_next: Vec3,
    /// BSDF at p, BSDF or emission at n, if those depend on the direction to the run: rough surfaces and spot lights; else 0.
    pub profile_previous: [Vec3; 3],
    pub profile_next: [Vec3; 3],
}

impl From<Gradient> for volgrad_gradient {
    fn from(gradient: Gradient) -> Self {
        let f = &gradient.factors;
        Self {
            luminance: gradient.luminance.into(),
            rgb: gradient.rgb.map(Vec3::from),
            scattering: f.scattering.into(),
            transmittance_previous: f.transmittance_previous.map(Vec3::from),
            transmittance_inside: f.transmittance_inside.map(Vec3::from),
            transmittance_next: f.transmittance_next.map(Vec3::from),
            geometry_previous: f.geometry_previous.into(),
            geometry_next: f.geometry_next.into(),
            importance: f.importance.into(),
            phase_previous: f.phase_previous.into(),
            phase_apex: f.phase_apex.into(),
            phase_next: f.phase_next.into(),
            profile_previous: f.profile_previous.map(Vec3::from),
            profile_next: f.profile_next.map(Vec3::from),
        }
    }
}

/// Derivative of log f by the distance that a run of medium vertices beside a specular one moves along `direction`, 1/world unit. The
/// names are those of `volgrad_gradient`, whose components along `direction` these are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_derivative {
    /// Unit vector from the run to its specular neighbour: every other move would change the specular chain.
    pub direction: Vec3,
    /// Derivative of log luminance(f).
    pub luminance: f32,
    /// Derivative of log f per channel: the sum of all factors below.
    pub rgb: Rgb,
    /// Scattering coefficients along the run.
    pub scattering: f32,
    /// Transmittance before, inside and after the run: on the specular side +sigma_t, as that edge gets shorter.
    pub transmittance_previous: Rgb,
    pub transmittance_inside: Rgb,
    pub transmittance_next: Rgb,
    /// Geometry terms; 0 on the specular side, where there is none up to the next vertex that is not specular.
    pub geometry_previous: f32,
    pub geometry_next: f32,
    /// The camera's importance, if p is the camera.
    pub importance: f32,
    /// Phase functions at p, at the run's end that is not beside the specular vertex, and at n.
    pub phase_previous: f32,
    pub phase_apex: f32,
    pub phase_next: f32,
    /// BSDF at p, BSDF or emission at n.
    pub profile_previous: Rgb,
    pub profile_next: Rgb,
}

impl From<LogDerivative> for volgrad_derivative {
    fn from(derivative: LogDerivative) -> Self {
        let f = &derivative.factors;
        let along = |gradient: DVec3| gradient.dot(derivative.direction) as f32;
        let rgb = |g: [DVec3; 3]| Rgb { r: along(g[0]), g: along(g[1]), b: along(g[2]) };
        Self {
            direction: derivative.direction.into(),
            luminance: derivative.luminance as f32,
            rgb: rgb(core::array::from_fn(|c| f.channel(c))),
            scattering: along(f.scattering),
            transmittance_previous: rgb(f.transmittance_previous),
            transmittance_inside: rgb(f.transmittance_inside),
            transmittance_next: rgb(f.transmittance_next),
            geometry_previous: along(f.geometry_previous),
            geometry_next: along(f.geometry_next),
            importance: along(f.importance),
            phase_previous: along(f.phase_previous),
            phase_apex: along(f.phase_apex),
            phase_next: along(f.phase_next),
            profile_previous: rgb(f.profile_previous),
            profile_next: rgb(f.profile_next),
        }
    }
}

/// # Safety
/// As the header says of the path.
pub(super) unsafe fn path<'a>(pointer: *const volgrad_path) -> Result<Path<'a>, Fault> {
    // SAFETY: the caller's promise, here and below.
    let path = unsafe { reference(pointer) }?;
    let count = path.vertex_count as usize;
    if count < 2 {
        return Err(VOLGRAD_ERROR_RANGE.at(c"path.vertex_count", 0));
    }
    Ok(Path {
        vertices: unsafe { array(path.vertices, count) }.map_err(|s| s.at(c"path.vertices", 0))?,
        segments: unsafe { array(path.segments, path.segment_count as usize) }.map_err(|s| s.at(c"path.segments", 0))?,
        edge_ends: unsafe { array(path.edge_ends, count - 1) }.map_err(|s| s.at(c"path.edge_ends", 0))?,
    })
}

/// Checks all that the functions on paths rely on but do not check: finite positions, unit normals and directions, segments in order and
/// as long as their edges, vertices inside their media, x_0 on the lens, and the last vertex where its point, spot or directional light is.
/// Where area lights and surfaces are only the host knows. `error` may be NULL; its index is the vertex, or the one that an edge starts at.
/// Paths that fail this are safe to hand over, but what comes back has no meaning.
/// Costs a pass over vertices and segments. `VOLGRAD_ERROR_NOT_FINITE`: a position is not finite, or a normal or direction no unit vector;
/// `VOLGRAD_ERROR_RANGE`: x_0 is off the lens, or the last vertex not where its light is; `VOLGRAD_ERROR_SEGMENTS`: as for all functions on
/// paths, and if an edge has more than `VOLGRAD_MAX_SEGMENTS`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_validate(
    scene: *const volgrad_scene,
    path: *const volgrad_path,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the header's contract.
    unsafe { finish_with(error, (|| Ok(self::path(path)?.validate(self::scene(scene)?)?))()) }
}

/// Describes a path in English, to find mistakes by: each vertex, each factor of f and of the log-gradient under its name in
/// `volgrad_gradient`, each edge's media; and what is wrong, where it is. As `snprintf` does it writes at most `capacity` bytes, of which the
/// last is 0, and returns in `*length` how many there are without that one: `capacity` 0 asks for the length alone. Not for use by programs:
/// the words may change.
/// Costs what the path's factors and its vertices' gradients cost.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_report(
    scene: *const volgrad_scene,
    path: *const volgrad_path,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, path, write) = unsafe { (self::scene(scene)?, self::path(path)?, output(length)?) };
        let buffer = unsafe { array_mut(text.cast::<u8>(), capacity) }?;
        let mut text = Text::new(buffer.get_mut(..capacity.saturating_sub(1)).unwrap_or(&mut []));
        path::report(scene, &path, &mut text);
        let all = text.length;
        if let Some(end) = buffer.get_mut(all.min(capacity.saturating_sub(1))) {
            *end = 0;
        }
        write(all);
        Ok(())
    })())
}

/// The contribution f of a path in linear RGB, `rgb[3]`: the integrand in volume and area measure [Lu20 (5)]. With specular vertices only
/// ratios over the same chain have a meaning. Whether the camera's crop holds the path is not looked at. Very long paths exceed a
/// double: INFINITY. Checks kinds and indices, nothing else.
/// Costs the optical depth of every edge.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_contribution(
    scene: *const volgrad_scene,
    path: *const volgrad_path,
    rgb: *mut f64,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, path, write) = unsafe { (self::scene(scene)?, self::path(path)?, output(rgb.cast::<[f64; 3]>())?) };
        write(contribution(scene, &path)?.to_array());
        Ok(())
    })())
}

/// The factors of f, one per vertex; their product is f. `capacity` of `result`: at least the path's vertex_count.
/// Checks kinds and indices, nothing else.
/// Costs twice what `volgrad_path_contribution` costs: all of it is checked before any of it is written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_factors(
    scene: *const volgrad_scene,
    path: *const volgrad_path,
    result: *mut volgrad_path_factor,
    capacity: usize,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, path) = unsafe { (self::scene(scene)?, self::path(path)?) };
        if capacity < path.vertices.len() {
            return Err(VOLGRAD_ERROR_TOO_SMALL.into());
        }
        // Nothing is written before all of it is known to be good.
        for i in 0..path.vertices.len() {
            factors(scene, &path, i)?;
        }
        // SAFETY: the header's contract.
        let result = unsafe { array_mut(result, path.vertices.len()) }?;
        for (i, out) in result.iter_mut().enumerate() {
            let f = factors(scene, &path, i)?;
            *out = volgrad_path_factor { vertex: f.vertex.into(), transmittance: f.transmittance.into(), geometry: f.geometry };
        }
        Ok(())
    })())
}

/// The gradient of log f when vertex number `vertex`, which lies in a medium, moves and the others stay (an environment's or directional
/// light's direction stays too): `volgrad_path_run_log_gradient` for one vertex.
/// Costs and errors are those of a run of one: `VOLGRAD_ERROR_INDEX`, `VOLGRAD_ERROR_NOT_MOVABLE`, `VOLGRAD_ERROR_ZERO_CONTRIBUTION`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_log_gradient(
    scene: *const volgrad_scene,
    path: *const volgrad_path,
    vertex: u32,
    result: *mut volgrad_gradient,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, path, write) = unsafe { (self::scene(scene)?, self::path(path)?, output(result)?) };
        check_run(&path, vertex, 1)?;
        write(path_run_log_gradient(scene, &path, vertex as usize, 1)?.into());
        Ok(())
    })())
}

/// The gradient of log f when `count` consecutive medium vertices, from number `first` on, move by the same offset and the others stay:
/// the sum of the gradients of each, without what cancels: distances and angles inside the run stay, and with them its geometry terms and
/// phase functions. [Lu20 (29)], for each vertex of the run.
/// Costs the optical depths with gradients of `count` + 1 edges, and f once, but for the transmittance of edges in grey media. Checks kinds
/// and indices, nothing else.
/// `VOLGRAD_ERROR_INDEX`: the run is empty or goes beyond the path; `VOLGRAD_ERROR_NOT_MOVABLE`: one of its vertices is not in a medium, or
/// a neighbour of the run is specular (`volgrad_path_run_log_derivative` is for that); `VOLGRAD_ERROR_ZERO_CONTRIBUTION`: f is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_run_log_gradient(
    scene: *const volgrad_scene,
    path: *const volgrad_path,
    first: u32,
    count: u32,
    result: *mut volgrad_gradient,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, path, write) = unsafe { (self::scene(scene)?, self::path(path)?, output(result)?) };
        check_run(&path, first, count)?;
        write(path_run_log_gradient(scene, &path, first as usize, count as usize)?.into());
        Ok(())
    })())
}

/// The derivative of log f when `count` consecutive medium vertices, from number `first` on, move by delta times `direction`, the unit
/// vector towards the specular vertex next to the run (one after it or before it, not both), short of reaching it. The specular chain
/// stays as it is. f is in (direction, distance) measure along that chain, as `volgrad_path_contribution` gives it: shifts of delta keep
/// that measure, so that f(moved)/f(here) is the weight of a shift. Replaces the gradient of the specular edge's geometry term of [Lu20,
/// section 5.1]: that edge has none. Costs the optical depths with gradients of `count` edges, and f once, as above. Checks kinds and
/// indices, nothing else.
/// `VOLGRAD_ERROR_INDEX`: the run is empty or goes beyond the path; `VOLGRAD_ERROR_NOT_MOVABLE`: one of its vertices is not in a medium,
/// both neighbours of the run are specular, or neither (it moves freely then: `volgrad_path_run_log_gradient`);
/// `VOLGRAD_ERROR_ZERO_CONTRIBUTION`: f is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_run_log_derivative(
    scene: *const volgrad_scene,
    path: *const volgrad_path,
    first: u32,
    count: u32,
    result: *mut volgrad_derivative,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, path, write) = unsafe { (self::scene(scene)?, self::path(path)?, output(result)?) };
        check_run(&path, first, count)?;
        write(path_run_log_derivative(scene, &path, first as usize, count as usize)?.into());
        Ok(())
    })())
}

/// A run has a vertex, and all of them are on the path.
fn check_run(path: &Path, first: u32, count: u32) -> Result<(), Fault> {
    let after = u64::from(first) + u64::from(count);
    if count > 0 && after <= path.vertices.len() as u64 { Ok(()) } else { Err(VOLGRAD_ERROR_INDEX.into()) }
}
