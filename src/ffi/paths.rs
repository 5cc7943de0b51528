//! Contribution and gradient of a path.

use super::pointer::{array, array_mut, output, reference};
use super::scenes::{report, scene, volgrad_scene};
use super::status::{Fault, finish, volgrad_error, volgrad_status, volgrad_status::*};
use super::types::volgrad_path;
use crate::math::{Rgb, Vec3};
use crate::path::{Path, contribution, factors, path_log_gradient};

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

/// Gradient of log f with respect to the position of one medium vertex x between p (towards the camera) and n (towards the light),
/// 1/world unit, in world axes. [Lu20 (29)] with the term of sigma_s that is missing there. Per-channel arrays: 0 red, 1 green, 2 blue.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_gradient {
    /// Gradient of log luminance(f).
    pub luminance: Vec3,
    /// Gradient of log f per channel: the sum of all factors below.
    pub rgb: [Vec3; 3],
    /// Scattering coefficient: grad sigma_s / sigma_s.
    pub scattering: Vec3,
    /// Transmittance of the edges p-x and x-n: -grad tau.
    pub transmittance_previous: [Vec3; 3],
    pub transmittance_next: [Vec3; 3],
    /// Geometry terms of the edges, with the cosines at p and n (at the camera: that of G).
    pub geometry_previous: Vec3,
    pub geometry_next: Vec3,
    /// The camera's importance, if p is the camera.
    pub importance: Vec3,
    /// Phase functions at p, x and n; 0 where there is none.
    pub phase_previous: Vec3,
    pub phase_apex: Vec3,
    pub phase_next: Vec3,
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
/// as long as their edges, vertices inside their media. `error` may be NULL; its index is the vertex, or the one that an edge starts at.
/// Paths that fail this are safe to hand over, but what comes back has no meaning.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_validate(
    scene: *const volgrad_scene,
    path: *const volgrad_path,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the header's contract.
    let result = (|| unsafe { Ok(self::path(path)?.validate(self::scene(scene)?)?) })();
    if let Err(fault) = &result {
        // SAFETY: the header's contract.
        unsafe { report(error, fault) };
    }
    finish(result)
}

/// The contribution f of a path in linear RGB, `rgb[3]`: the integrand in volume and area measure [Lu20 (5)]. With specular vertices only
/// ratios over the same chain have a meaning. Whether the camera's crop holds the path is not looked at. Very long paths exceed a double: INFINITY. Checks kinds and indices, nothing else.
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
/// light's direction stays too). Costs two optical depths with gradients, and f once. Checks kinds and indices, nothing else.
/// `VOLGRAD_ERROR_NOT_MOVABLE`: not in a medium or next to a specular surface; `VOLGRAD_ERROR_ZERO_CONTRIBUTION`: f is 0.
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
        if vertex as usize >= path.vertices.len() {
            return Err(VOLGRAD_ERROR_INDEX.at(c"vertex", 0));
        }
        let gradient = path_log_gradient(scene, &path, vertex as usize)?;
        let f = &gradient.factors;
        write(volgrad_gradient {
            luminance: gradient.luminance.into(),
            rgb: core::array::from_fn(|c| f.channel(c).into()),
            scattering: f.scattering.into(),
            transmittance_previous: f.transmittance_previous.map(Vec3::from),
            transmittance_next: f.transmittance_next.map(Vec3::from),
            geometry_previous: f.geometry_previous.into(),
            geometry_next: f.geometry_next.into(),
            importance: f.importance.into(),
            phase_previous: f.phase_previous.into(),
            phase_apex: f.phase_apex.into(),
            phase_next: f.phase_next.into(),
        });
        Ok(())
    })())
}
