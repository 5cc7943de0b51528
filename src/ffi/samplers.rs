//! The path sampler, and the host's ray queries as the core sees them.

use super::films::{film, volgrad_film};
use super::pointer::{sized, sized_over, write_sized};
use super::scenes::{scene, volgrad_scene};
use super::shifts::{DEFAULTS as SHIFT_DEFAULTS, options as shift_options, volgrad_shift_options};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::{volgrad_queries, volgrad_query_fn};
use crate::film::Film;
use crate::sampler::{FirstVertices, Lengths, Options, PathTracer, Stats};
use crate::scene::{Hit, Queries, Ray, Scene, Stop};
use core::ops::Range;
use core::ptr::null_mut;

/// The host's callbacks.
pub(super) struct HostQueries(volgrad_queries);

impl HostQueries {
    /// For modes that ask nothing.
    pub const UNUSED: Self =
        Self(volgrad_queries { struct_size: 0, reserved: 0, user: null_mut(), intersect: None, occluded: None });

    /// # Safety
    /// As the header says of the callbacks.
    pub unsafe fn read(pointer: *const volgrad_queries) -> Result<Self, Fault> {
        // SAFETY: the caller's promise.
        let queries = unsafe { sized(pointer) }?;
        if queries.intersect.is_none() || queries.occluded.is_none() {
            return Err(VOLGRAD_ERROR_NULL.at(c"queries.intersect, queries.occluded", 0));
        }
        Ok(Self(queries))
    }

    fn ask(&self, query: volgrad_query_fn, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        let Some(query) = query else { return Err(Stop::InvalidHit) };
        let count = rays.len().min(hits.len());
        // SAFETY: both arrays hold `count` values; the rest is the header's contract.
        match unsafe { query(self.0.user, rays.as_ptr(), hits.as_mut_ptr(), count as u32) } {
            0 => Ok(()),
            code => Err(Stop::Callback(code)),
        }
    }
}

impl Queries for HostQueries {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.ask(self.0.intersect, rays, hits)
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.ask(self.0.occluded, rays, hits)
    }
}

/// Paths whose first vertex after the camera is in a medium.
pub const VOLGRAD_FIRST_VERTEX_MEDIUM: u32 = 1;
/// On a surface that scatters.
pub const VOLGRAD_FIRST_VERTEX_SURFACE: u32 = 2;
/// On a specular one.
pub const VOLGRAD_FIRST_VERTEX_SPECULAR: u32 = 4;
/// Light that the camera sees directly.
pub const VOLGRAD_FIRST_VERTEX_NONE: u32 = 8;
const VOLGRAD_FIRST_VERTEX_ALL: u32 = 15;

/// Settings of the path sampler.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct volgrad_path_sampler_options {
    /// `sizeof(volgrad_path_sampler_options)` of the caller.
    pub struct_size: u32,
    /// Most edges of a path: 1 is only directly visible emission, 2 adds single scattering; 0 is no limit.
    pub max_depth: u32,
    /// Vertices before Russian roulette begins.
    pub rr_depth: u32,
    /// The paths to render, a sum of `VOLGRAD_FIRST_VERTEX_*`; 0: all. The layers that make an image have, with the same seed, the same
    /// paths, and add up to it.
    pub first_vertex: u32,
    pub seed: u64,
    /// Batches, as by `volgrad_shift_path`. Its struct_size is that of this library's version.
    pub shift: volgrad_shift_options,
    /// Paths of left_out_first ... left_out_last edges are left out, because another sampler renders them; none if the first is 0.
    /// Light that the camera sees directly, or through nothing but specular surfaces, is left out only if left_out_first is 1: other
    /// samplers leave it to this one, which renders all of it in few passes.
    pub left_out_first: u32,
    pub left_out_last: u32,
}

pub(super) const DEFAULTS: volgrad_path_sampler_options = volgrad_path_sampler_options {
    struct_size: size_of::<volgrad_path_sampler_options>() as u32,
    max_depth: 0,
    rr_depth: 5,
    first_vertex: 0,
    seed: 0,
    shift: SHIFT_DEFAULTS,
    left_out_first: 0,
    left_out_last: 0,
};

/// Counts of what was done; each call adds to them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct volgrad_path_sampler_stats {
    /// `sizeof(volgrad_path_sampler_stats)` of the caller.
    pub struct_size: u32,
    pub reserved: u32,
    pub paths: u64,
    /// Rays of `intersect` and of `occluded`. A tile that is cut by the end of a range of pixels has its camera rays traced for each part.
    pub rays: u64,
    pub occlusion_rays: u64,
    /// Paths that got a batch.
    pub shifted_paths: u64,
    /// Offsets tried; one that changes several contributions of a path differently counts once for each.
    pub shifts: u64,
    /// Those that light does not reach, or that stayed for another reason.
    pub stays: u64,
    /// Rays that crossed more media than `VOLGRAD_MAX_SEGMENTS`; all that they would have carried is missing.
    pub overflows: u64,
}

pub(super) const NO_STATS: volgrad_path_sampler_stats = volgrad_path_sampler_stats {
    struct_size: 0,
    reserved: 0,
    paths: 0,
    rays: 0,
    occlusion_rays: 0,
    shifted_paths: 0,
    shifts: 0,
    stays: 0,
    overflows: 0,
};

/// Fills options with their defaults: no depth limit, roulette from vertex 5 on, no shifts. `struct_size`: `sizeof *options` of the caller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_sampler_options_default(
    options: *mut volgrad_path_sampler_options,
    struct_size: usize,
) -> volgrad_status {
    // SAFETY: the header's contract.
    finish(unsafe { write_sized(options, struct_size, DEFAULTS) }.map_err(Into::into))
}

/// Traces one path through each of `pixel_count` pixels from `first_pixel` on, for pass number `pass`, and adds its splats, shifted ones included,
/// to `film`, which has the camera's size. Pixels are numbered row by row within the camera's crop; with `VOLGRAD_KERNEL_TILE` tile by tile, so
/// that ranges of many pixels share more.
///
/// What a pass adds depends on (scene, options, pass, pixels) only. The image is `volgrad_film_develop` with scale 1/passes, once every
/// pixel has had the same number of passes: splats cross pixels. Threads work on films of their own and merge them, in any order.
/// `stats` may be NULL. On `VOLGRAD_ERROR_CALLBACK` or `VOLGRAD_ERROR_INVALID_HIT` the film holds
/// the paths that were done before, as many as `stats.paths` has grown by: the next call can go on from there.
/// Costs per path a ray and a flight through the media for every vertex, and a ray to a light with its optical depth; per offset of a
/// batch at most 2 * shift.run + 1 edges, however long the path.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_path_sampler_run(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_path_sampler_options,
    pass: u64,
    first_pixel: u32,
    pixel_count: u32,
    film: *mut volgrad_film,
    stats: *mut volgrad_path_sampler_stats,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (scene, queries) = unsafe { (self::scene(scene)?, HostQueries::read(queries)?) };
        let options = self::options(&unsafe { sized_over(options, DEFAULTS) }?)?;
        let counted = if stats.is_null() { NO_STATS } else { unsafe { sized_over(stats, NO_STATS) }? };
        let mut film = unsafe { self::film(film) }?;
        let pixels = pixel_range(scene, &film, first_pixel, pixel_count)?;
        let tracer = PathTracer { scene, queries: &queries, options };
        let mut done = Stats::default();
        let result = tracer.sample_pixels(pass, pixels, &mut film, &mut done);
        if !stats.is_null() {
            unsafe { add_stats(stats, counted, &done) }?;
        }
        Ok(result?)
    })())
}

pub(super) fn check_size(scene: &Scene, film: &Film) -> Result<(), Fault> {
    let camera = &scene.camera;
    let same = (film.width, film.height) == (camera.width, camera.height);
    if same { Ok(()) } else { Err(VOLGRAD_ERROR_SIZE_MISMATCH.into()) }
}

/// The numbers of pixels within the camera's crop.
pub(super) fn pixel_range(scene: &Scene, film: &Film, first_pixel: u32, pixel_count: u32) -> Result<Range<u32>, Fault> {
    check_size(scene, film)?;
    pixel_numbers(scene, first_pixel, pixel_count)
}

pub(super) fn pixel_numbers(scene: &Scene, first_pixel: u32, pixel_count: u32) -> Result<Range<u32>, Fault> {
    let [x0, y0, x1, y1] = scene.camera.crop;
    let end = first_pixel.checked_add(pixel_count).filter(|end| *end <= (x1 - x0) * (y1 - y0));
    Ok(first_pixel..end.ok_or(VOLGRAD_ERROR_RANGE.at(c"first_pixel, pixel_count", 0))?)
}

/// # Safety
/// `pointer` is the caller's struct, whose known part is `before`.
pub(super) unsafe fn add_stats(
    pointer: *mut volgrad_path_sampler_stats,
    before: volgrad_path_sampler_stats,
    done: &Stats,
) -> Result<(), Fault> {
    let sum = volgrad_path_sampler_stats {
        paths: before.paths.saturating_add(done.paths),
        rays: before.rays.saturating_add(done.rays),
        occlusion_rays: before.occlusion_rays.saturating_add(done.occlusion_rays),
        shifted_paths: before.shifted_paths.saturating_add(done.shifted_paths),
        shifts: before.shifts.saturating_add(done.shifts),
        stays: before.stays.saturating_add(done.stays),
        overflows: before.overflows.saturating_add(done.overflows),
        ..before
    };
    // SAFETY: the caller's promise.
    unsafe { write_sized(pointer, before.struct_size as usize, sum) }?;
    Ok(())
}

pub(super) fn options(o: &volgrad_path_sampler_options) -> Result<Options, Fault> {
    if o.shift.struct_size as usize != size_of::<volgrad_shift_options>() {
        return Err(VOLGRAD_ERROR_STRUCT_SIZE.at(c"shift.struct_size", 0));
    }
    let max_depth = if o.max_depth == 0 { u32::MAX } else { o.max_depth };
    let left_out = match o.left_out_first {
        0 => Lengths::NONE,
        first => Lengths { first, last: o.left_out_last },
    };
    let has = |bit| o.first_vertex == 0 || o.first_vertex & bit != 0;
    if o.first_vertex > VOLGRAD_FIRST_VERTEX_ALL {
        return Err(VOLGRAD_ERROR_KIND.at(c"first_vertex", 0));
    }
    let first = FirstVertices {
        medium: has(VOLGRAD_FIRST_VERTEX_MEDIUM),
        surface: has(VOLGRAD_FIRST_VERTEX_SURFACE),
        specular: has(VOLGRAD_FIRST_VERTEX_SPECULAR),
        none: has(VOLGRAD_FIRST_VERTEX_NONE),
    };
    Ok(Options { max_depth, rr_depth: o.rr_depth, seed: o.seed, shift: shift_options(&o.shift)?, left_out, first })
}
