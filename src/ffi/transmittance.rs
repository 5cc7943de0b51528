//! Estimators of a line's transmittance.

use super::kernels::{line, volgrad_line};
use super::pointer::{output, sized_over, write_sized};
use super::scenes::{scene, volgrad_scene};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use crate::math::{Rgb, Vec3};
use crate::medium::{Estimator, estimate_transmittance};
use crate::sampler::line_numbers;

/// Ratio tracking [NSJ14]: unbiased, gradients too.
pub const VOLGRAD_TRANSMITTANCE_RATIO_TRACKING: u32 = 0;
/// Residual ratio tracking [NSJ14]: unbiased; the least density on the way counts in closed form.
pub const VOLGRAD_TRANSMITTANCE_RESIDUAL_RATIO_TRACKING: u32 = 1;
/// Ray marching [JDZJ08]: biased, tau by O(step^2), or if jittered not tau, but exp(-tau) by half its variance.
pub const VOLGRAD_TRANSMITTANCE_RAY_MARCHING: u32 = 2;

/// How a transmittance is estimated.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct volgrad_transmittance_options {
    /// `sizeof(volgrad_transmittance_options)` of the caller.
    pub struct_size: u32,
    /// `VOLGRAD_TRANSMITTANCE_*`.
    pub kind: u32,
    /// Ray marching: points in each medium that the line passes, at least 1. Unused by the others.
    pub steps: u32,
    /// Ray marching: 0 for the middles of the steps, 1 for one random place in all of them. Unused by the others.
    pub jitter: u32,
}

const DEFAULTS: volgrad_transmittance_options = volgrad_transmittance_options {
    struct_size: size_of::<volgrad_transmittance_options>() as u32,
    kind: VOLGRAD_TRANSMITTANCE_RATIO_TRACKING,
    steps: 64,
    jitter: 1,
};

/// An estimate of a line's transmittance T and its gradients, per colour channel (index 0 red, 1 green, 2 blue).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_transmittance_estimate {
    /// Below 0 only if a custom density exceeds its majorant.
    pub transmittance: Rgb,
    /// d T / d origin, 1/world unit: the far end stays, or for an infinite line the direction.
    pub origin_gradient: [Vec3; 3],
    /// d T / d far end, 1/world unit: the origin stays. 0 for an infinite line.
    pub end_gradient: [Vec3; 3],
    /// Points at which a density was computed.
    pub evaluations: u32,
}

/// Fills options with their defaults: ratio tracking; 64 jittered steps if the kind is changed to ray marching.
/// `struct_size`: `sizeof *options` of the caller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_transmittance_options_default(
    options: *mut volgrad_transmittance_options,
    struct_size: usize,
) -> volgrad_status {
    // SAFETY: the header's contract.
    finish(unsafe { write_sized(options, struct_size, DEFAULTS) }.map_err(Into::into))
}

/// One estimate of a line's transmittance and its gradients at both ends; `seed` and `index` say which. Estimates of different indices are
/// independent, and their mean over many indices is exact for the unbiased kinds, for custom densities too, whose `step` plays no part
/// here. All channels share the same collisions. Homogeneous media always count in closed form.
/// `volgrad_line_optical_depth` is exact, and what the path sampler uses; this is for hosts that integrate in these ways.
/// `VOLGRAD_ERROR_RANGE` if the majorant (the greatest density on the way) makes more than a million evaluations likely.
/// Costs the evaluations of the density that result->evaluations counts: for ratio tracking about the majorant's optical depth.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_line_transmittance_estimate(
    scene: *const volgrad_scene,
    line: *const volgrad_line,
    options: *const volgrad_transmittance_options,
    seed: u64,
    index: u64,
    result: *mut volgrad_transmittance_estimate,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (scene, write) = unsafe { (self::scene(scene)?, output(result)?) };
        let line = unsafe { self::line(scene, line) }?;
        let estimator = estimator(&unsafe { sized_over(options, DEFAULTS) }?)?;
        let estimate = estimate_transmittance(&line, estimator, line_numbers(seed, index));
        let estimate = estimate.ok_or(VOLGRAD_ERROR_RANGE.at(c"line", 0))?;
        write(volgrad_transmittance_estimate {
            transmittance: estimate.transmittance.into(),
            origin_gradient: estimate.near_gradient.map(Vec3::from),
            end_gradient: estimate.far_gradient.map(Vec3::from),
            evaluations: estimate.evaluations,
        });
        Ok(())
    })())
}

fn estimator(o: &volgrad_transmittance_options) -> Result<Estimator, Fault> {
    match o.kind {
        VOLGRAD_TRANSMITTANCE_RATIO_TRACKING => Ok(Estimator::RatioTracking),
        VOLGRAD_TRANSMITTANCE_RESIDUAL_RATIO_TRACKING => Ok(Estimator::ResidualRatioTracking),
        VOLGRAD_TRANSMITTANCE_RAY_MARCHING if o.steps == 0 || o.jitter > 1 => {
            Err(VOLGRAD_ERROR_RANGE.at(c"options.steps, options.jitter", 0))
        }
        VOLGRAD_TRANSMITTANCE_RAY_MARCHING => Ok(Estimator::RayMarching { steps: o.steps, jitter: o.jitter == 1 }),
        _ => Err(VOLGRAD_ERROR_KIND.at(c"options.kind", 0)),
    }
}
