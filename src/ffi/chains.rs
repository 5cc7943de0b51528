//! Chains of Metropolis light transport.

use super::bidirectional::VOLGRAD_MAX_LENGTH;
use super::bootstraps::{techniques, volgrad_chain_start, volgrad_chain_techniques};
use super::films::{film, volgrad_film};
use super::pointer::{array_mut, check, exclusive, output, reference, sized, sized_over, write_sized};
use super::samplers::{HostQueries, check_size};
use super::scenes::{ALIGNMENT, check_memory, scene, volgrad_scene};
use super::shifts::{DEFAULTS as SHIFT_DEFAULTS, options as shift_options, thesis_options, volgrad_shift_options};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::{VOLGRAD_ABI_VERSION, volgrad_queries};
use crate::path::Vertex;
use crate::sampler::metropolis::{Batches, ChainStats, Metropolis, Options, Start, State, capacity};
use crate::sampler::{Lengths, Stats};
use core::ffi::c_void;
use core::slice;

/// Settings of Metropolis light transport. All calls for one image take the same.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct volgrad_chain_options {
    /// `sizeof(volgrad_chain_options)` of the caller.
    pub struct_size: u32,
    /// The edges of the paths that chains render: 2 <= min_length <= max_length <= VOLGRAD_MAX_LENGTH. Others are the path sampler's: give it
    /// the same two as `left_out_first` and `left_out_last`.
    pub min_length: u32,
    pub max_length: u32,
    /// Mutations of each chain before the first that counts, in which the size of its small steps adapts.
    pub burn_in: u32,
    /// Probability of a mutation that makes a new, independent path; > 0 and <= 1.
    pub large_step: f32,
    /// Every how many mutations a batch of shifted paths is made, which then counts as many times; >= 1. Unused without shifts.
    pub shift_every: u32,
    pub seed: u64,
    /// Batches, as by `volgrad_shift_path`, or of the modes for chains alone. Its struct_size is that of this library's version.
    pub shift: volgrad_shift_options,
}

pub(super) const DEFAULTS: volgrad_chain_options = volgrad_chain_options {
    struct_size: size_of::<volgrad_chain_options>() as u32,
    min_length: 2,
    max_length: 32,
    burn_in: 512,
    large_step: 0.3,
    shift_every: 4,
    seed: 0,
    shift: SHIFT_DEFAULTS,
};

/// Counts of what chains did, and the samples before them; each call adds to them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct volgrad_chain_stats {
    /// `sizeof(volgrad_chain_stats)` of the caller.
    pub struct_size: u32,
    pub reserved: u32,
    /// Bootstrap samples.
    pub samples: u64,
    /// Mutations by kind, those accepted, those to a path that carries nothing, and those before the first that counts.
    pub large_steps: u64,
    pub large_accepted: u64,
    pub small_steps: u64,
    pub small_accepted: u64,
    pub dark: u64,
    pub burn_in: u64,
    /// Paths whose value was not finite, which were left out, among samples and all mutations.
    pub dropped: u64,
    /// Rays of `intersect` and of `occluded`; rays that crossed more media than `VOLGRAD_MAX_SEGMENTS`.
    pub rays: u64,
    pub occlusion_rays: u64,
    pub overflows: u64,
    /// Batches, offsets tried, and those that stayed, as in `volgrad_path_sampler_stats`.
    pub shifted_paths: u64,
    pub shifts: u64,
    pub stays: u64,
}

/// A path of a chain, at the time of `volgrad_chain_peek`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_chain_path {
    /// The technique that made it: vertices of the subpath from the camera, and of that from a light.
    pub camera_vertices: u32,
    pub light_vertices: u32,
    /// Image point, pixels.
    pub x: f32,
    pub y: f32,
    /// What the chain's density is proportional to: luminance of w f/p, over the probability of the technique. 0: it carries nothing.
    pub target: f64,
    /// Vertices written; 0 if it carries nothing.
    pub vertex_count: u32,
    pub reserved: u32,
}

/// What a chain's next mutation will do.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_chain_mutation {
    /// `sizeof(volgrad_chain_mutation)` of the caller.
    pub struct_size: u32,
    /// 1: a new, independent path. 0: a small step.
    pub large: u32,
    /// Whether the numbers of the camera's subpath change, and of that from the light: 0 or 1.
    pub changes_camera: u32,
    pub changes_light: u32,
    /// Probability with which it is accepted, and whether it will be.
    pub acceptance: f64,
    pub accepted: u32,
    pub reserved: u32,
    /// How many mutations that count were made before.
    pub number: u64,
    pub current: volgrad_chain_path,
    pub proposed: volgrad_chain_path,
}

/// A chain. It holds no pointer, so its memory may be copied, moved and stored: all of it, `volgrad_chain_size` bytes. Read back what was stored
/// unchanged, with the same build of the library.
#[repr(C, align(16))]
pub struct volgrad_chain {
    stamp: u64,
    bytes: u64,
    options: Options,
    state: State,
}

const STAMP: u64 = 0x766f_6c63_6861_6900 | VOLGRAD_ABI_VERSION as u64;
const HEAD: usize = size_of::<volgrad_chain>();

pub(super) fn options(o: &volgrad_chain_options) -> Result<(Options, Lengths), Fault> {
    if !(2 <= o.min_length && o.min_length <= o.max_length && o.max_length <= VOLGRAD_MAX_LENGTH) {
        return Err(VOLGRAD_ERROR_RANGE.at(c"min_length, max_length", 0));
    }
    if !(o.large_step > 0.0 && o.large_step <= 1.0) {
        return Err(VOLGRAD_ERROR_RANGE.at(c"large_step", 0));
    }
    if o.shift_every == 0 {
        return Err(VOLGRAD_ERROR_RANGE.at(c"shift_every", 0));
    }
    if o.shift.struct_size as usize != size_of::<volgrad_shift_options>() {
        return Err(VOLGRAD_ERROR_STRUCT_SIZE.at(c"shift.struct_size", 0));
    }
    let shift = match thesis_options(&o.shift)? {
        Some(thesis) => Some(Batches::Thesis(thesis)),
        None => shift_options(&o.shift)?.map(Batches::Shifts),
    };
    let options = Options {
        seed: o.seed,
        large_step: o.large_step.into(),
        burn_in: o.burn_in,
        shift,
        shift_every: if shift.is_some() { o.shift_every } else { 1 },
    };
    Ok((options, Lengths { first: o.min_length, last: o.max_length }))
}

/// Fills options with their defaults: paths of 2 to 32 edges, no shifts. `struct_size`: `sizeof *options` of the caller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_options_default(
    options: *mut volgrad_chain_options,
    struct_size: usize,
) -> volgrad_status {
    // SAFETY: the header's contract.
    finish(unsafe { write_sized(options, struct_size, DEFAULTS) }.map_err(Into::into))
}

fn bytes_of(length: u32) -> usize {
    (HEAD + capacity(length as usize) * size_of::<f64>()).next_multiple_of(ALIGNMENT)
}

/// Memory that a chain with these options needs: less than 3 KiB, little more than 1 KiB for paths of up to 16 edges.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_size(options: *const volgrad_chain_options, bytes: *mut usize) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (options, write) = unsafe { (sized_over(options, DEFAULTS)?, output(bytes)?) };
        write(bytes_of(self::options(&options)?.1.last));
        Ok(())
    })())
}

/// Makes a chain in `memory`: `bytes` as from `volgrad_chain_size`, aligned to 16; and makes the mutations that do not count. `options` and
/// `techniques` are those of the plan. There is nothing else to free. `stats` may be NULL. If `start` is not from samples with
/// this scene, these techniques and this seed: `VOLGRAD_ERROR_RANGE` if that sample is of another length, else `VOLGRAD_ERROR_OTHER_PATH` if
/// its value differs.
/// Costs options.burn_in mutations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_init(
    memory: *mut c_void,
    bytes: usize,
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_chain_options,
    techniques: *const volgrad_chain_techniques,
    start: *const volgrad_chain_start,
    stats: *mut volgrad_chain_stats,
    chain: *mut *mut volgrad_chain,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (scene, queries, start) = unsafe { (self::scene(scene)?, HostQueries::read(queries)?, reference(start)?) };
        let (options, lengths) = self::options(&unsafe { sized_over(options, DEFAULTS) }?)?;
        let write = unsafe { output(chain) }?;
        let counted = unsafe { counted(stats) }?;
        let ok = start.brightness > 0.0 && start.share > 0.0 && start.others >= 0.0 && start.value > 0.0;
        if !(ok && lengths.contains(start.length)) {
            return Err(VOLGRAD_ERROR_RANGE.at(c"start", 0));
        }
        check_memory(memory, bytes, bytes_of(lengths.last))?;
        let object = memory.cast::<volgrad_chain>();
        let numbers = unsafe {
            memory.cast::<u8>().write_bytes(0, bytes_of(lengths.last));
            slice::from_raw_parts_mut(object.add(1).cast::<f64>(), capacity(lengths.last as usize))
        };
        let volgrad_chain_start { sample, length, share, chains, brightness, others, value, .. } = *start;
        let from = Start { sample, length, share, chains, brightness, others, value };
        let techniques = unsafe { self::techniques(techniques, lengths) }?;
        let state = State::new(&options, &techniques, start.index, from, numbers);
        let state = state.ok_or(VOLGRAD_ERROR_RANGE.at(c"start", 0))?;
        unsafe { object.write(volgrad_chain { stamp: STAMP, bytes: bytes_of(lengths.last) as u64, options, state }) };
        let mut work = Work::default();
        let state = &mut unsafe { exclusive(object) }?.state;
        let metropolis = Metropolis { scene, queries: &queries, options };
        let result = metropolis.burn_in(state, numbers, &mut work.rays, &mut work.chain);
        unsafe { add_stats(stats, counted, &work) }?;
        if let Err(stop) = result {
            unsafe { (&raw mut (*object).stamp).write(0) };
            return Err(stop.into());
        }
        write(object);
        Ok(())
    })())
}

/// Makes `mutations` mutations, and adds what they splat to `film`, which has the camera's size. What is due at the path where the chain is
/// now is kept: `volgrad_chain_flush`.
///
/// The image of all chains is `volgrad_film_develop` with scale pixels/(chains * mutations of each), pixels being those of the
/// camera's crop; all chains of a plan have made as many mutations then. What a chain adds depends on (scene, options, start) only, so threads
/// share chains among them in any way, each with a film of its own. `stats` may be NULL. On `VOLGRAD_ERROR_CALLBACK` or
/// `VOLGRAD_ERROR_INVALID_HIT` the chain is where it was after the last whole mutation, and stats->large_steps + small_steps says how many there
/// were: the next call goes on from there. On `VOLGRAD_ERROR_OTHER_PATH`, for another scene than that of `volgrad_chain_init`, chain and film are
/// as they were.
/// Costs at most two subpaths and one connection per mutation, and every shift_every mutations a batch.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_run(
    chain: *mut volgrad_chain,
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    mutations: u64,
    film: *mut volgrad_film,
    stats: *mut volgrad_chain_stats,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (scene, queries) = unsafe { (self::scene(scene)?, HostQueries::read(queries)?) };
        let (mut film, counted) = unsafe { (self::film(film)?, counted(stats)?) };
        let count = numbers_of(unsafe { head(chain) }?);
        check_size(scene, &film)?;
        let object = unsafe { exclusive(chain) }?;
        // SAFETY: the stamp says that volgrad_chain_init wrote this many numbers behind the head.
        let numbers = unsafe { slice::from_raw_parts_mut(chain.add(1).cast::<f64>(), count) };
        let mut done = Work::default();
        let metropolis = Metropolis { scene, queries: &queries, options: object.options };
        let result = metropolis.run(&mut object.state, numbers, mutations, &mut film, &mut done.rays, &mut done.chain);
        unsafe { add_stats(stats, counted, &done) }?;
        Ok(result?)
    })())
}

/// Adds to `film` what is due at the path where the chain is now, and leaves the chain as it is: a last call for each chain before the final
/// image, or into a copy of the film for one on the way. `stats` may be NULL. `VOLGRAD_ERROR_OTHER_PATH` as for `volgrad_chain_run`.
/// Costs the chain's path again, and its batch.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_flush(
    chain: *const volgrad_chain,
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    film: *mut volgrad_film,
    stats: *mut volgrad_chain_stats,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (scene, queries) = unsafe { (self::scene(scene)?, HostQueries::read(queries)?) };
        let (mut film, object, counted) = unsafe { (self::film(film)?, head(chain)?, counted(stats)?) };
        check_size(scene, &film)?;
        // SAFETY: the stamp says that volgrad_chain_init wrote this many numbers behind the head.
        let numbers = unsafe { slice::from_raw_parts(chain.add(1).cast::<f64>(), numbers_of(object)) };
        let metropolis = Metropolis { scene, queries: &queries, options: object.options };
        let mut done = Work::default();
        let result = metropolis.flush(&object.state, numbers, &mut film, &mut done.rays);
        unsafe { add_stats(stats, counted, &done) }?;
        Ok(result?)
    })())
}

/// Looks at the next mutation of a chain without making it: what it will propose and decide, and both paths' vertices, `capacity` of each,
/// at least the chain's edges + 1, max_length + 1 always do. The media along their edges are the host's to know. `mutation->struct_size` is set by the caller.
/// Costs two mutations. `VOLGRAD_ERROR_OTHER_PATH` as for `volgrad_chain_run`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_chain_peek(
    chain: *const volgrad_chain,
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    mutation: *mut volgrad_chain_mutation,
    current: *mut Vertex,
    proposed: *mut Vertex,
    capacity: u32,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (scene, queries) = unsafe { (self::scene(scene)?, HostQueries::read(queries)?) };
        let (object, before) = unsafe { (head(chain)?, sized(mutation.cast_const())?) };
        // SAFETY: the stamp says that volgrad_chain_init wrote this many numbers behind the head.
        let numbers = unsafe { slice::from_raw_parts(chain.add(1).cast::<f64>(), numbers_of(object)) };
        if (capacity as usize) < object.state.start.length as usize + 1 {
            return Err(VOLGRAD_ERROR_TOO_SMALL.into());
        }
        let vertices = unsafe { [array_mut(current, capacity as usize)?, array_mut(proposed, capacity as usize)?] };
        let metropolis = Metropolis { scene, queries: &queries, options: object.options };
        let peek = metropolis.peek(&object.state, numbers, vertices, &mut Stats::default())?;
        let [current, proposed] = peek.paths.map(|path| volgrad_chain_path {
            camera_vertices: path.technique.camera as u32,
            light_vertices: path.technique.light as u32,
            x: path.pixel.x as f32,
            y: path.pixel.y as f32,
            target: path.target,
            vertex_count: path.vertex_count as u32,
            reserved: 0,
        });
        let volgrad_chain_mutation { struct_size, .. } = before;
        let result = volgrad_chain_mutation {
            struct_size,
            large: peek.large.into(),
            changes_camera: peek.change.camera.into(),
            changes_light: peek.change.light.into(),
            acceptance: peek.acceptance,
            accepted: peek.accepted.into(),
            reserved: 0,
            number: object.state.mutations,
            current,
            proposed,
        };
        unsafe { write_sized(mutation, struct_size as usize, result) }?;
        Ok(())
    })())
}

#[derive(Default)]
pub(super) struct Work {
    pub rays: Stats,
    pub chain: ChainStats,
}

/// # Safety
/// As for `reference`.
unsafe fn head<'a>(pointer: *const volgrad_chain) -> Result<&'a volgrad_chain, Fault> {
    check(pointer)?;
    // SAFETY: the caller's promise; only the stamp is read before it is known to be a chain.
    if unsafe { (&raw const (*pointer).stamp).read() } != STAMP {
        return Err(VOLGRAD_ERROR_NOT_INITIALISED.into());
    }
    // SAFETY: the stamp says that a whole chain is there.
    Ok(unsafe { reference(pointer) }?)
}

/// How many numbers follow the head.
fn numbers_of(chain: &volgrad_chain) -> usize {
    (chain.bytes as usize - HEAD) / size_of::<f64>()
}

/// # Safety
/// As for `sized_over`, or NULL.
pub(super) unsafe fn counted(stats: *mut volgrad_chain_stats) -> Result<volgrad_chain_stats, Fault> {
    // SAFETY: the caller's promise.
    let none = volgrad_chain_stats::default();
    if stats.is_null() { Ok(none) } else { Ok(unsafe { sized_over(stats.cast_const(), none) }?) }
}

/// # Safety
/// `pointer`, if not NULL, is the caller's struct, which is `before`.
pub(super) unsafe fn add_stats(
    pointer: *mut volgrad_chain_stats,
    before: volgrad_chain_stats,
    done: &Work,
) -> Result<(), Fault> {
    if pointer.is_null() {
        return Ok(());
    }
    let (chain, rays) = (&done.chain, &done.rays);
    let sum = volgrad_chain_stats {
        samples: before.samples.saturating_add(chain.samples),
        large_steps: before.large_steps.saturating_add(chain.large),
        large_accepted: before.large_accepted.saturating_add(chain.large_accepted),
        small_steps: before.small_steps.saturating_add(chain.small),
        small_accepted: before.small_accepted.saturating_add(chain.small_accepted),
        dark: before.dark.saturating_add(chain.dark),
        burn_in: before.burn_in.saturating_add(chain.burn_in),
        dropped: before.dropped.saturating_add(chain.dropped),
        rays: before.rays.saturating_add(rays.rays),
        occlusion_rays: before.occlusion_rays.saturating_add(rays.occlusion_rays),
        overflows: before.overflows.saturating_add(rays.overflows),
        shifted_paths: before.shifted_paths.saturating_add(rays.shifted_paths),
        shifts: before.shifts.saturating_add(rays.shifts),
        stays: before.stays.saturating_add(rays.stays),
        ..before
    };
    // SAFETY: the caller's promise.
    unsafe { write_sized(pointer, before.struct_size as usize, sum) }?;
    Ok(())
}
