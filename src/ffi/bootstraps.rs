//! What Metropolis chains begin with: bootstrap samples, how often to try what, the plan of chains.

use super::bidirectional::VOLGRAD_MAX_LENGTH;
use super::chains::{DEFAULTS, Work, add_stats, counted, options, volgrad_chain_options, volgrad_chain_stats};
use super::pointer::{array, array_mut, check, output, sized_over, write_sized};
use super::samplers::HostQueries;
use super::scenes::{scene, volgrad_scene};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::volgrad_queries;
use crate::sampler::Lengths;
use crate::sampler::metropolis::{Plan, Start, Techniques, bootstrap, learn};

/// How often each path length and each technique is tried, as `volgrad_chain_learn` finds it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct volgrad_chain_techniques {
    /// Running sums of probabilities: over the lengths 0 ... VOLGRAD_MAX_LENGTH in the first row; in row k + 1 over the techniques for k edges, by
    /// the number of their camera's vertices less 1.
    pub shares: [[f32; 65]; 66],
}

const _: () = assert!(size_of::<volgrad_chain_techniques>() == size_of::<Techniques>() && VOLGRAD_MAX_LENGTH == 64);

/// All alike if `pointer` is NULL.
///
/// # Safety
/// As for `reference`.
pub(super) unsafe fn techniques(pointer: *const volgrad_chain_techniques, lengths: Lengths) -> Result<Techniques, Fault> {
    if pointer.is_null() {
        return Ok(Techniques::alike(lengths));
    }
    check(pointer)?;
    // SAFETY: the caller's promise; both are as many floats, and any floats are valid.
    Ok(unsafe { pointer.cast::<Techniques>().read() })
}

/// Where a chain begins, as `volgrad_chain_plan` finds it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_chain_start {
    /// Number of the bootstrap sample, and the edges of its path.
    pub sample: u64,
    pub length: u32,
    /// Number of the chain.
    pub index: u32,
    /// Chains in all over those of this length, in the mean: what a splat counts for.
    pub share: f64,
    /// Chains in all.
    pub chains: u32,
    /// Brightness of this length as the other samples alone tell it, and as all do.
    pub others: f32,
    pub brightness: f64,
    /// What the chain should find where it begins, so that it knows whether it belongs to these samples.
    pub value: f64,
}

/// What the bootstrap says about the image.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct volgrad_chain_plan_result {
    /// `sizeof(volgrad_chain_plan_result)` of the caller.
    pub struct_size: u32,
    /// Chains planned; 0 if all samples are dark.
    pub chain_count: u32,
    /// Mean luminance over the sampled pixels of what chains render, and its standard error over it.
    pub brightness: f64,
    pub relative_error: f64,
}

const NO_RESULT: volgrad_chain_plan_result =
    volgrad_chain_plan_result { struct_size: 0, chain_count: 0, brightness: 0.0, relative_error: 0.0 };

/// Makes `count` independent samples, from number `first` on, and writes their values (w f/p, luminance) to `weights`. They tell how bright
/// the image is, and where chains may begin. One that is not finite becomes 0 and is counted in stats->dropped. The array for all samples starts
/// with number 0 and has no gaps; threads fill parts of it. With `techniques` NULL all lengths and techniques are tried alike: from some samples
/// of that kind `volgrad_chain_learn` makes a better choice, for a new array. `stats` may be NULL. On `VOLGRAD_ERROR_CALLBACK` or
/// `VOLGRAD_ERROR_INVALID_HIT` as many weights are written as stats->samples has grown by.
/// Costs two subpaths and one connection per sample.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_bootstrap(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_chain_options,
    techniques: *const volgrad_chain_techniques,
    first: u64,
    count: u32,
    weights: *mut f32,
    stats: *mut volgrad_chain_stats,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (scene, queries) = unsafe { (self::scene(scene)?, HostQueries::read(queries)?) };
        let (options, lengths) = self::options(&unsafe { sized_over(options, DEFAULTS) }?)?;
        let weights = unsafe { array_mut(weights, count as usize) }?;
        let techniques = unsafe { self::techniques(techniques, lengths) }?;
        let (counted, mut done) = (unsafe { counted(stats) }?, Work::default());
        let result = bootstrap(scene, &queries, options.seed, &techniques, first, weights, &mut done.rays, &mut done.chain);
        unsafe { add_stats(stats, counted, &done) }?;
        Ok(result?)
    })())
}

/// How often to try each length and technique, in proportion to the root of their mean squared values: from the `count` samples, from number
/// 0 on, that `volgrad_chain_bootstrap` made without such a table. Those samples serve nothing else: those that are made with the
/// table have other random numbers.
/// Costs a pass over the samples, without rays. `VOLGRAD_ERROR_NOT_FINITE`: a weight is negative or not finite.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_learn(
    options: *const volgrad_chain_options,
    weights: *const f32,
    count: usize,
    techniques: *mut volgrad_chain_techniques,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (options, lengths) = self::options(&unsafe { sized_over(options, DEFAULTS) }?)?;
        let (weights, write) = unsafe { (array(weights, count)?, output(techniques.cast::<Techniques>())?) };
        check_weights(weights)?;
        write(learn(options.seed, lengths, weights));
        Ok(())
    })())
}

fn check_weights(weights: &[f32]) -> Result<(), Fault> {
    let ok = weights.iter().all(|weight| *weight >= 0.0 && weight.is_finite());
    if ok { Ok(()) } else { Err(VOLGRAD_ERROR_NOT_FINITE.at(c"weights", 0)) }
}

/// Shares about `wanted` chains out among the path lengths, in proportion to their brightness, and picks a bootstrap sample for each to begin
/// with: `weights` are those of all samples, from number 0 on. Writes result->chain_count starts, VOLGRAD_MAX_LENGTH more than wanted at most;
/// with `starts` NULL only the result.
///
/// The expected image is right whatever the number of samples; brightness is known to result->relative_error, so it differs that much between
/// seeds. More samples make it less.
/// Costs some passes over the samples, without rays. `VOLGRAD_ERROR_NOT_FINITE`: a weight is negative or not finite;
/// `VOLGRAD_ERROR_RANGE`: `wanted` is 0 or above 2^24; `VOLGRAD_ERROR_TOO_SMALL`: `capacity` is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_plan(
    options: *const volgrad_chain_options,
    techniques: *const volgrad_chain_techniques,
    weights: *const f32,
    count: usize,
    wanted: u32,
    starts: *mut volgrad_chain_start,
    capacity: u32,
    result: *mut volgrad_chain_plan_result,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (options, lengths) = self::options(&unsafe { sized_over(options, DEFAULTS) }?)?;
        let (weights, before) = unsafe { (array(weights, count)?, sized_over(result, NO_RESULT)?) };
        if wanted == 0 || wanted > MOST_CHAINS {
            return Err(VOLGRAD_ERROR_RANGE.at(c"wanted", 0));
        }
        check_weights(weights)?;
        let plan = Plan::new(options.seed, &unsafe { self::techniques(techniques, lengths) }?, weights, wanted);
        if !starts.is_null() {
            if capacity < plan.chain_count {
                return Err(VOLGRAD_ERROR_TOO_SMALL.at(c"capacity", 0));
            }
            let starts = unsafe { array_mut(starts, plan.chain_count as usize) }?;
            let mut next = 0;
            plan.starts(weights, |Start { sample, length, share, chains, brightness, others, value }| {
                if let Some(start) = starts.get_mut(next as usize) {
                    *start = volgrad_chain_start { sample, length, index: next, share, chains, others, brightness, value };
                    next += 1;
                }
            });
        }
        let found = volgrad_chain_plan_result {
            chain_count: plan.chain_count,
            brightness: plan.brightness(),
            relative_error: plan.relative_error(),
            ..before
        };
        unsafe { write_sized(result, before.struct_size as usize, found) }?;
        Ok(())
    })())
}

const MOST_CHAINS: u32 = 1 << 24;
