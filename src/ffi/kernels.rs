//! Media and phase functions as single calls.

use super::convert::{self, Place};
use super::pointer::{array, output, reference};
use super::scenes::{scene, volgrad_scene};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::volgrad_phase;
use crate::math::{DVec2, DVec3, Rgb, Vec3};
use crate::medium::{Collision, Flight, Line, Segment, distance_number, moments, optical_depth, sample_distance};
use crate::phase::{Phase, cosine_gradient_apex, cosine_gradient_wing};
use crate::scene::Scene;

/// A straight line from `origin` along the unit `direction` and the media on it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_line {
    pub origin: Vec3,
    pub direction: Vec3,
    /// World units; may be INFINITY, then the gradients keep the direction instead of the far end.
    pub length: f32,
    /// At least 1; see `volgrad_segment`.
    pub segment_count: u32,
    pub segments: *const Segment,
}

/// Optical depth of a line and its gradients, per colour channel (index 0 red, 1 green, 2 blue).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_optical_depth {
    pub tau: Rgb,
    /// d tau / d origin, 1/world unit: the far end stays, or for an infinite line the direction.
    pub origin_gradient: [Vec3; 3],
    /// d tau / d far end, 1/world unit: the origin stays. 0 for an infinite line.
    pub end_gradient: [Vec3; 3],
}

/// A sampled distance along a line.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_flight {
    /// Distance of the collision; the line's length if there is none.
    pub t: f32,
    /// Medium of the collision, or `VOLGRAD_NONE`: the far end was reached.
    pub medium: u32,
    /// Optical depth from the origin to t.
    pub tau: Rgb,
    /// Density of the collision per world unit: mean over the channels of sigma_t * exp(-tau). Without one: the probability of that.
    pub pdf: f32,
}

/// # Safety
/// As the header says of the line.
pub(super) unsafe fn line<'a>(scene: &'a Scene<'a>, pointer: *const volgrad_line) -> Result<Line<'a>, Fault> {
    // SAFETY: the caller's promise, here and below.
    let line = unsafe { reference(pointer) }?;
    let segments = unsafe { array(line.segments, line.segment_count as usize) }?;
    if !(line.length > 0.0) {
        let status = if line.length.is_nan() { VOLGRAD_ERROR_NOT_FINITE } else { VOLGRAD_ERROR_ZERO_LENGTH };
        return Err(status.at(c"line.length", 0));
    }
    check_segments(scene, segments, line.length)?;
    let origin = Place(c"line.origin", 0).point(line.origin)?;
    let direction = Place(c"line.direction", 0).unit(line.direction)?;
    Ok(Line::new(scene.media, origin, direction, line.length.into(), segments))
}

fn check_segments(scene: &Scene, segments: &[Segment], length: f32) -> Result<(), Fault> {
    let mut reached = 0.0;
    for (i, segment) in segments.iter().enumerate() {
        if segment.medium != crate::medium::NONE && segment.medium as usize >= scene.media.len() {
            return Err(VOLGRAD_ERROR_INDEX.at(c"segments.medium", i));
        }
        if !(segment.end >= reached) {
            return Err(VOLGRAD_ERROR_SEGMENTS.at(c"segments.end", i));
        }
        if i + 1 < segments.len() {
            Place(c"segments.normal", i).unit(segment.normal)?;
        }
        reached = segment.end;
    }
    // Lengths are rounded to single precision.
    let covered = !segments.is_empty() && reached >= length * (1.0 - 1e-4);
    if covered { Ok(()) } else { Err(VOLGRAD_ERROR_SEGMENTS.at(c"segments", segments.len())) }
}

/// tau along a line, and its gradients at both ends [Lu20 (20)]. Exact for trilinear grids; faces where sigma_t jumps count.
/// Costs time in proportion to the cells of grids, or the panels of custom densities, on the way; empty bricks of 8^3 cells are skipped.
/// Homogeneous media are a closed form.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_line_optical_depth(
    scene: *const volgrad_scene,
    line: *const volgrad_line,
    result: *mut volgrad_optical_depth,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, write) = unsafe { (self::scene(scene)?, output(result)?) };
        let line = unsafe { self::line(scene, line) }?;
        let edge = moments(&line);
        let far = if line.length.is_finite() { edge.far_gradient(line.direction, line.length) } else { [DVec3::ZERO; 3] };
        write(volgrad_optical_depth {
            tau: edge.optical_depth.into(),
            origin_gradient: edge.near_gradient(line.direction, line.length).map(Vec3::from),
            end_gradient: far.map(Vec3::from),
        });
        Ok(())
    })())
}

/// A distance from one uniform number 0 < u < 1. The same u gives the same distance; its density is exactly `pdf`.
/// Costs what `volgrad_line_tau` costs up to the collision, and some steps of Newton's method in one cell.
/// `VOLGRAD_ERROR_RANGE`: `u` is not between 0 and 1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_line_sample_distance(
    scene: *const volgrad_scene,
    line: *const volgrad_line,
    u: f64,
    result: *mut volgrad_flight,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, write) = unsafe { (self::scene(scene)?, output(result)?) };
        let line = unsafe { self::line(scene, line) }?;
        check_number(u)?;
        write(match sample_distance(&line, u) {
            Flight::Collision(Collision { t, medium, optical_depth, pdf, .. }) => {
                volgrad_flight { t: t as f32, medium, tau: optical_depth.into(), pdf: pdf as f32 }
            }
            Flight::Passed { optical_depth, probability } => volgrad_flight {
                t: line.length as f32,
                medium: crate::medium::NONE,
                tau: optical_depth.into(),
                pdf: probability as f32,
            },
        });
        Ok(())
    })())
}

fn check_number(u: f64) -> Result<(), Fault> {
    if u.is_nan() {
        return Err(VOLGRAD_ERROR_NOT_FINITE.at(c"u", 0));
    }
    if u > 0.0 && u < 1.0 { Ok(()) } else { Err(VOLGRAD_ERROR_RANGE.at(c"u", 0)) }
}

/// The number u from which `volgrad_line_sample_distance` makes a collision at the far end of this (shorter) line: 0 in vacuum, and
/// rounded to 1 where practically nothing arrives, neither of which can be sampled.
/// Costs what `volgrad_line_tau` costs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_line_invert_distance(
    scene: *const volgrad_scene,
    line: *const volgrad_line,
    u: *mut f64,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, write) = unsafe { (self::scene(scene)?, output(u)?) };
        let line = unsafe { self::line(scene, line) }?;
        write(distance_number(&line));
        Ok(())
    })())
}

/// tau of a line alone.
/// Costs what `volgrad_line_optical_depth` costs, less the gradients.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_line_tau(
    scene: *const volgrad_scene,
    line: *const volgrad_line,
    tau: *mut Rgb,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, write) = unsafe { (self::scene(scene)?, output(tau)?) };
        let line = unsafe { self::line(scene, line) }?;
        write(optical_depth(&line).into());
        Ok(())
    })())
}

/// A phase function's value and gradient of its logarithm at one vertex.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_phase_value {
    /// 1/sr; also the density of `volgrad_phase_sample`.
    pub value: f32,
    /// d log(value) per world unit when the vertex itself moves, and when the point that `to_previous` or `to_next` leads to moves.
    pub apex_gradient: Vec3,
    pub previous_gradient: Vec3,
    pub next_gradient: Vec3,
}

/// # Safety
/// As the header says of the phase function.
unsafe fn phase(pointer: *const volgrad_phase) -> Result<Phase, Fault> {
    // SAFETY: the caller's promise.
    convert::phase(unsafe { reference(pointer) }?, Place(c"phase", 0))
}

/// Value and log-gradients of a phase function at a vertex, from the vectors (not unit vectors, world units) from the vertex to the
/// previous and to the next point. [Lu20 (24), (25)], the latter with its sign corrected.
/// Costs a constant time. `VOLGRAD_ERROR_ZERO_LENGTH`: one of the vectors is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_phase_eval(
    phase: *const volgrad_phase,
    to_previous: Vec3,
    to_next: Vec3,
    result: *mut volgrad_phase_value,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (phase, write) = unsafe { (self::phase(phase)?, output(result)?) };
        let (p, n) = (Place(c"to_previous", 0).point(to_previous)?, Place(c"to_next", 0).point(to_next)?);
        let (dp, dn) = (p.length(), n.length());
        if !(dp > 0.0 && dn > 0.0) {
            return Err(VOLGRAD_ERROR_ZERO_LENGTH.into());
        }
        let (up, un) = (p / dp, n / dn);
        let c = up.dot(un);
        let slope = phase.log_derivative(c);
        write(volgrad_phase_value {
            value: phase.eval(c) as f32,
            apex_gradient: (slope * cosine_gradient_apex(up, un, c, dp, dn)).into(),
            previous_gradient: (slope * cosine_gradient_wing(up, un, c, dp)).into(),
            next_gradient: (slope * cosine_gradient_wing(un, up, c, dn)).into(),
        });
        Ok(())
    })())
}

/// A direction to the next vertex from two uniform numbers in [0, 1), given the unit vector to the previous one.
/// Costs a constant time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_phase_sample(
    phase: *const volgrad_phase,
    to_previous: Vec3,
    u0: f64,
    u1: f64,
    to_next: *mut Vec3,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (phase, write) = unsafe { (self::phase(phase)?, output(to_next)?) };
        let previous = Place(c"to_previous", 0).unit(to_previous)?;
        if u0.is_nan() || u1.is_nan() {
            return Err(VOLGRAD_ERROR_NOT_FINITE.into());
        }
        if !((0.0..1.0).contains(&u0) && (0.0..1.0).contains(&u1)) {
            return Err(VOLGRAD_ERROR_RANGE.into());
        }
        let direction = phase.sample(previous, DVec2::new(u0, u1));
        write(direction.ok_or(VOLGRAD_ERROR_INTERNAL)?.into());
        Ok(())
    })())
}

/// The two numbers from which `volgrad_phase_sample` makes `to_next`; both vectors have unit length.
/// Costs a constant time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_phase_invert(
    phase: *const volgrad_phase,
    to_previous: Vec3,
    to_next: Vec3,
    u0: *mut f64,
    u1: *mut f64,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (phase, write_0, write_1) = unsafe { (self::phase(phase)?, output(u0)?, output(u1)?) };
        let previous = Place(c"to_previous", 0).unit(to_previous)?;
        let u = phase.invert(previous, Place(c"to_next", 0).unit(to_next)?).ok_or(VOLGRAD_ERROR_INTERNAL)?;
        write_0(u.x);
        write_1(u.y);
        Ok(())
    })())
}
