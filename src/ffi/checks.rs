//! Which of a host's options, or what about a hit, is wrong: for hosts in the making.

use super::bidirectional::{self, volgrad_bidirectional_options};
use super::chains::{self, volgrad_chain_options};
use super::pointer::{reference, sized_over};
use super::samplers::{self, volgrad_path_sampler_options};
use super::scenes::{finish_with, scene, volgrad_scene};
use super::shifts::{self, volgrad_shift_options};
use super::status::{Fault, volgrad_error, volgrad_status, volgrad_status::*};
use crate::scene::{HIT_OVERFLOW, HIT_SURFACE, Hit, Mistake, Ray, Scene};

/// # Safety
/// The pointers are as the header says.
unsafe fn check<T: Copy, O>(
    options: *const T,
    defaults: T,
    read: impl FnOnce(&T) -> Result<O, Fault>,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the caller's promise.
    unsafe { finish_with(error, sized_over(options, defaults).map_err(Fault::from).and_then(|o| read(&o).map(drop))) }
}

/// Names the field that makes functions refuse these options. `error` may be NULL.
/// Costs nothing to speak of.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_shift_options_validate(
    options: *const volgrad_shift_options,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the header's contract.
    unsafe { check(options, shifts::DEFAULTS, shifts::options, error) }
}

/// Names the field that makes functions refuse these options. `error` may be NULL.
/// Costs nothing to speak of.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_sampler_options_validate(
    options: *const volgrad_path_sampler_options,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the header's contract.
    unsafe { check(options, samplers::DEFAULTS, samplers::options, error) }
}

/// Names the field that makes functions refuse these options. `error` may be NULL.
/// Costs nothing to speak of.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_bidirectional_options_validate(
    options: *const volgrad_bidirectional_options,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the header's contract.
    unsafe { check(options, bidirectional::DEFAULTS, bidirectional::options, error) }
}

/// Names the field that makes functions refuse these options. `error` may be NULL.
/// Costs nothing to speak of.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_options_validate(
    options: *const volgrad_chain_options,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the header's contract.
    unsafe { check(options, chains::DEFAULTS, chains::options, error) }
}

/// Checks a host's answer to a ray: all that `VOLGRAD_ERROR_INVALID_HIT` stands for, that `t` is where the ray goes, and that the segments reach
/// as far as it does. For answers of `intersect`, and for those of `occluded` that found no surface. `error` may be NULL; its index is the segment.
/// Costs nothing to speak of. `VOLGRAD_ERROR_KIND`, `VOLGRAD_ERROR_INDEX` (material, light, media), `VOLGRAD_ERROR_RANGE` (t, segment_count),
/// `VOLGRAD_ERROR_NOT_FINITE` (the normal is no unit vector), `VOLGRAD_ERROR_SEGMENTS` (out of order, or too short).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_hit_validate(
    scene: *const volgrad_scene,
    ray: *const Ray,
    hit: *const Hit,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the header's contract.
    unsafe { finish_with(error, (|| validate(self::scene(scene)?, reference(ray)?, reference(hit)?))()) }
}

fn validate(scene: &Scene, ray: &Ray, hit: &Hit) -> Result<(), Fault> {
    if hit.kind == HIT_OVERFLOW {
        return Ok(());
    }
    match hit.mistake(scene) {
        Some(Mistake::Kind) => return Err(VOLGRAD_ERROR_KIND.at(c"hit.kind", 0)),
        Some(Mistake::Material) => return Err(VOLGRAD_ERROR_INDEX.at(c"hit.material", 0)),
        Some(Mistake::Light) => return Err(VOLGRAD_ERROR_INDEX.at(c"hit.light", 0)),
        Some(Mistake::Medium) => return Err(VOLGRAD_ERROR_INDEX.at(c"hit.medium_outside, medium_inside", 0)),
        Some(Mistake::Distance) => return Err(VOLGRAD_ERROR_RANGE.at(c"hit.t", 0)),
        Some(Mistake::Normal) => return Err(VOLGRAD_ERROR_NOT_FINITE.at(c"hit.normal", 0)),
        Some(Mistake::SegmentCount) => return Err(VOLGRAD_ERROR_RANGE.at(c"hit.segment_count", 0)),
        Some(Mistake::Segment(i)) => return Err(VOLGRAD_ERROR_SEGMENTS.at(c"hit.segments", i)),
        None => {}
    }
    let on_surface = hit.kind == HIT_SURFACE;
    if on_surface && !(ray.t_min <= hit.t && hit.t < ray.t_max) {
        return Err(VOLGRAD_ERROR_RANGE.at(c"hit.t", 0));
    }
    let (length, last) = (if on_surface { hit.t } else { ray.t_max }, hit.media().len().saturating_sub(1));
    let reaches = hit.media().last().is_some_and(|segment| segment.end >= length * (1.0 - SLACK));
    if reaches { Ok(()) } else { Err(VOLGRAD_ERROR_SEGMENTS.at(c"hit.segments", last)) }
}

/// What the last segment may lack, relative.
const SLACK: f32 = 1e-4;
