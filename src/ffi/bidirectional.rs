//! The bidirectional sampler.

use super::films::{film, volgrad_film};
use super::pointer::{sized_over, write_sized};
use super::samplers::{HostQueries, NO_STATS, add_stats, pixel_range, volgrad_path_sampler_stats};
use super::scenes::{scene, volgrad_scene};
use super::shifts::{DEFAULTS as SHIFT_DEFAULTS, number, options as shift_options, volgrad_shift_options};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::volgrad_queries;
use crate::sampler::Stats;
use crate::sampler::bidirectional::{Bidirectional, Heuristic, MAX_LENGTH, MOST_LIGHT_VERTICES, Options, Technique};

/// Most edges of a path of the bidirectional sampler and of chains.
pub const VOLGRAD_MAX_LENGTH: u32 = 64;

/// Most vertices of a subpath from a light where bidirectional samples are shifted.
pub const VOLGRAD_MAX_SHIFTED_LIGHT_VERTICES: u32 = 3;

const _: () = assert!(MAX_LENGTH == VOLGRAD_MAX_LENGTH as usize);
const _: () = assert!(MOST_LIGHT_VERTICES == VOLGRAD_MAX_SHIFTED_LIGHT_VERTICES as usize);

/// Weights p/sum p of the techniques that could have made a path [VG95].
pub const VOLGRAD_HEURISTIC_BALANCE: u32 = 0;
/// p^2/sum p^2.
pub const VOLGRAD_HEURISTIC_POWER: u32 = 1;

/// Settings of the bidirectional sampler.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct volgrad_bidirectional_options {
    /// `sizeof(volgrad_bidirectional_options)` of the caller.
    pub struct_size: u32,
    /// Most edges of a path, 2 ... VOLGRAD_MAX_LENGTH.
    pub max_length: u32,
    /// Vertices of a subpath before Russian roulette begins.
    pub rr_depth: u32,
    /// `VOLGRAD_HEURISTIC_*`.
    pub heuristic: u32,
    pub seed: u64,
    /// Most vertices of a subpath from a light; 0 is no limit, or with shifts, which take no more,
    /// VOLGRAD_MAX_SHIFTED_LIGHT_VERTICES. Few are best where light has a few bright
    /// spots to come from: each costs a connection to every vertex from the camera. Light of directional, point and spot lights that passes n
    /// specular surfaces first is missing with fewer than n + 2.
    pub light_vertices: u32,
    /// Connections and batches that add less luminance than this to a pixel are made by chance only, and count as much more: unbiased, and
    /// faster where most of them are weak. A few times the image's mean luminance is good in scenes that are lit indirectly. 0: never.
    pub roulette: f32,
    /// Batches, as by `volgrad_shift_path`; only the first vertex moves, whatever `run` says. Lights' subpaths are then not connected to the camera
    /// itself, so that paths through specular surfaces to directional, point and spot lights are missing. Its struct_size is that of this
    /// library's version.
    pub shift: volgrad_shift_options,
}

pub(super) const DEFAULTS: volgrad_bidirectional_options = volgrad_bidirectional_options {
    struct_size: size_of::<volgrad_bidirectional_options>() as u32,
    max_length: VOLGRAD_MAX_LENGTH,
    rr_depth: 5,
    heuristic: VOLGRAD_HEURISTIC_BALANCE,
    seed: 0,
    light_vertices: 0,
    roulette: 0.0,
    shift: SHIFT_DEFAULTS,
};

/// Fills options with their defaults: VOLGRAD_MAX_LENGTH, roulette from vertex 5 on. `struct_size`: `sizeof *options` of the caller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_bidirectional_options_default(
    options: *mut volgrad_bidirectional_options,
    struct_size: usize,
) -> volgrad_status {
    // SAFETY: the header's contract.
    finish(unsafe { write_sized(options, struct_size, DEFAULTS) }.map_err(Into::into))
}

/// As `volgrad_path_sampler_run`, but each sample is a subpath from the camera, one from a light, and all their connections that make a path
/// of 2 ... max_length edges; directly visible lights and longer paths are the path sampler's (see `left_out_first` there). Pixels are
/// numbered row by row; with shifts and `VOLGRAD_KERNEL_TILE` tile by tile. Paths through specular surfaces to directional, point and spot
/// lights, which no path sampler finds, are found here, if `light_vertices` and `shift` leave them.
///
/// A path is weighted by the true densities of all techniques that could have made it, free flight and phase functions included.
/// Subpaths start from lights at infinity only if the scene's bounds are known.
/// Costs per pixel two subpaths, and for every pair of their vertices a ray and the optical depth of an edge.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_bidirectional_run(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_bidirectional_options,
    pass: u64,
    first_pixel: u32,
    pixel_count: u32,
    film: *mut volgrad_film,
    stats: *mut volgrad_path_sampler_stats,
) -> volgrad_status {
    // SAFETY: the header's contract.
    finish(unsafe { run(scene, queries, options, None, pass, first_pixel, pixel_count, film, stats) })
}

/// As `volgrad_bidirectional_run`, with the same samples, but adds only what one technique makes: paths of which `light_vertices` are
/// vertices of the subpath from a light and `camera_vertices`, 1 or more, of that from the camera; together 3 ... max_length + 1. To look
/// at, and to find mistakes. Pixels are always numbered row by row; nothing is shifted, but with `options->shift` weights are those of the
/// techniques that shifts leave.
///
/// `weighted` 1: what the technique adds to the image; all techniques sum to it. 0: without its weight, so that techniques of as many
/// edges show the same paths, where they can make them at all, with the noise of their own. That may be without bounds: a connection in a
/// medium has infinite variance.
/// Costs at most what `volgrad_bidirectional_run` costs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_bidirectional_run_technique(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_bidirectional_options,
    light_vertices: u32,
    camera_vertices: u32,
    weighted: u32,
    pass: u64,
    first_pixel: u32,
    pixel_count: u32,
    film: *mut volgrad_film,
    stats: *mut volgrad_path_sampler_stats,
) -> volgrad_status {
    let technique = [light_vertices, camera_vertices, weighted];
    // SAFETY: the header's contract.
    finish(unsafe { run(scene, queries, options, Some(technique), pass, first_pixel, pixel_count, film, stats) })
}

/// # Safety
/// The pointers are as the header wants them. `only`: light vertices, camera vertices, weighted; None: all techniques.
unsafe fn run(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_bidirectional_options,
    only: Option<[u32; 3]>,
    pass: u64,
    first_pixel: u32,
    pixel_count: u32,
    film: *mut volgrad_film,
    stats: *mut volgrad_path_sampler_stats,
) -> Result<(), Fault> {
    // SAFETY: the caller's promise, here and below.
    let (scene, queries) = unsafe { (self::scene(scene)?, HostQueries::read(queries)?) };
    let options = self::options(&unsafe { sized_over(options, DEFAULTS) }?)?;
    let technique = only.map(|only| technique(only, options.max_length)).transpose()?;
    let counted = if stats.is_null() { NO_STATS } else { unsafe { sized_over(stats, NO_STATS) }? };
    let mut film = unsafe { self::film(film) }?;
    let pixels = pixel_range(scene, &film, first_pixel, pixel_count)?;
    let sampler = Bidirectional { scene, queries: &queries, options };
    let mut done = Stats::default();
    let result = match technique {
        None => sampler.sample_pixels(pass, pixels, &mut film, &mut done),
        Some((technique, weighted)) => sampler.sample_technique(technique, weighted, pass, pixels, &mut film, &mut done),
    };
    if !stats.is_null() {
        unsafe { add_stats(stats, counted, &done) }?;
    }
    Ok(result?)
}

fn technique([light, camera, weighted]: [u32; 3], max_length: u32) -> Result<(Technique, bool), Fault> {
    let vertices = light.checked_add(camera).filter(|sum| (3..=max_length + 1).contains(sum));
    if vertices.is_none() || camera == 0 {
        return Err(VOLGRAD_ERROR_RANGE.at(c"light_vertices, camera_vertices", 0));
    }
    if weighted > 1 {
        return Err(VOLGRAD_ERROR_RANGE.at(c"weighted", 0));
    }
    Ok((Technique { camera: camera as usize, light: light as usize }, weighted == 1))
}

pub(super) fn options(o: &volgrad_bidirectional_options) -> Result<Options, Fault> {
    if !(2..=VOLGRAD_MAX_LENGTH).contains(&o.max_length) {
        return Err(VOLGRAD_ERROR_RANGE.at(c"max_length", 0));
    }
    let heuristic = match o.heuristic {
        VOLGRAD_HEURISTIC_BALANCE => Heuristic::Balance,
        VOLGRAD_HEURISTIC_POWER => Heuristic::Power,
        _ => return Err(VOLGRAD_ERROR_KIND.at(c"heuristic", 0)),
    };
    if o.shift.struct_size as usize != size_of::<volgrad_shift_options>() {
        return Err(VOLGRAD_ERROR_STRUCT_SIZE.at(c"shift.struct_size", 0));
    }
    let shift = shift_options(&o.shift)?;
    let most = if shift.is_some() { MOST_LIGHT_VERTICES } else { MAX_LENGTH };
    let light_vertices = if o.light_vertices == 0 { most } else { o.light_vertices as usize };
    if shift.is_some() && light_vertices > most {
        return Err(VOLGRAD_ERROR_RANGE.at(c"light_vertices", 0));
    }
    let roulette = number(o.roulette, |roulette| roulette >= 0.0, c"roulette")?;
    Ok(Options { max_length: o.max_length, rr_depth: o.rr_depth, seed: o.seed, heuristic, light_vertices, roulette, shift })
}
