//! Shifts of any sampler's paths.

use super::films::volgrad_splat;
use super::paths::path;
use super::pointer::{array, array_mut, output, reference, sized_over, write_sized};
use super::samplers::HostQueries;
use super::scenes::{scene, volgrad_scene};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::{volgrad_path, volgrad_queries};
use crate::math::{Colour, DVec2, Rgb, floor};
use crate::path::Path;
use crate::sampler::bidirectional::thesis;
use crate::sampler::{shift_numbers, tile_numbers};
use crate::scene::Scene;
use crate::shift::{self, Kernel, MAX_RUN, MAX_SHIFTS, Mode, Options, Paths, Radius, Scratch, Shiftable, Tiling};
use core::ffi::CStr;
use core::slice;

/// No batch: every path stays as it is.
///
/// Of the other modes: f is a path's contribution, x where its moving vertices were sampled, y where an offset puts them. A batch is the path
/// and its shifted copies, each a splat of the path's weight times the number given, over how many there are. "Staying at x": the splat is left at x's
/// pixel with the weight 1.
pub const VOLGRAD_SHIFT_NONE: u32 = 0;
/// exp(<gradient of log f, offset>), staying at x outside [1/4, 4]: biased, of order radius^2; no ray queries.
pub const VOLGRAD_SHIFT_LOG_LINEAR: u32 = 1;
/// f(y)/f(x), staying at x where that is 0 or outside [1/4, 4]: unbiased.
pub const VOLGRAD_SHIFT_EXACT: u32 = 2;
/// All around a common centre, weighted f(y)/sum f: unbiased, weights in [0, 1].
pub const VOLGRAD_SHIFT_EXCHANGEABLE: u32 = 3;
/// 1 + <gradient of log f, offset> [Lu20 (30)]: biased, of order radius^2 like no gradient at all; no ray queries. Weights can be negative.
pub const VOLGRAD_SHIFT_FIRST_ORDER: u32 = 4;
/// 1 + <gradient of log f, offset>/2: biased, of order radius^4 inside a medium, of order radius at edges; no ray queries.
pub const VOLGRAD_SHIFT_HALF_ORDER: u32 = 5;
/// f(y)/f(x) with optical depths linear in the offset, and light as visible as at x; staying at x outside [1/4, 4]: biased, of order
/// radius^2; no ray queries.
pub const VOLGRAD_SHIFT_LINEAR_DEPTH: u32 = 6;
/// LINEAR_DEPTH for all offsets, corrected by EXACT for `exact_count` of them: unbiased.
pub const VOLGRAD_SHIFT_TWO_LEVEL: u32 = 7;
/// The thesis' own estimator [Lu20 5.1], for Metropolis chains alone, where a path has a technique: `count` offsets of the first vertex in a
/// ball, as if the same technique had made them, each with w f/p at the MIS weight w that it has there and f/p linear in the offset. Biased,
/// of order radius^2, and at edges of media and shadows. The kernel is a BALL; `run` and `exact_count` are unused.
pub const VOLGRAD_SHIFT_THESIS: u32 = 8;
/// The same with the radii of [Lu20 alg. 2] as printed: radius * i^((alpha - 1)/3) over the offsets i = 1, 2 ... of each batch, so that the bias
/// never ends.
pub const VOLGRAD_SHIFT_THESIS_PRINTED: u32 = 9;

/// Uniform in a disk parallel to the image plane.
pub const VOLGRAD_KERNEL_DISK: u32 = 0;
/// Uniform in a ball; its radius must be in world units.
pub const VOLGRAD_KERNEL_BALL: u32 = 1;
/// All pixels of the square tile of pixels that the path is seen in. Tiles cover the image; where they begin changes from pass to pass.
/// Every pixel gets equally many splats. `count` is 3, 8, 15, 24 or 35; there is no radius.
pub const VOLGRAD_KERNEL_TILE: u32 = 2;

/// Pixels at the depth of the vertex.
pub const VOLGRAD_RADIUS_PIXELS: u32 = 0;
pub const VOLGRAD_RADIUS_WORLD: u32 = 1;

/// Most offsets in a batch.
pub const VOLGRAD_MAX_SHIFTS: u32 = 35;
/// Most vertices that move together.
pub const VOLGRAD_MAX_RUN: u32 = 8;

const _: () = assert!(MAX_SHIFTS == VOLGRAD_MAX_SHIFTS as usize && MAX_RUN == VOLGRAD_MAX_RUN as usize);

/// How a batch of shifted paths is made.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct volgrad_shift_options {
    /// `sizeof(volgrad_shift_options)` of the caller.
    pub struct_size: u32,
    /// `VOLGRAD_SHIFT_*`.
    pub mode: u32,
    /// `VOLGRAD_KERNEL_*`.
    pub kernel: u32,
    /// `VOLGRAD_RADIUS_*`.
    pub radius_unit: u32,
    /// > 0. Exchangeable makes two steps of this radius: to the common centre, and from there.
    pub radius: f32,
    /// Offsets per path, 1 ... VOLGRAD_MAX_SHIFTS.
    pub count: u32,
    /// Most medium vertices that move together, from the first on: 1 ... VOLGRAD_MAX_RUN.
    pub run: u32,
    /// TWO_LEVEL: offsets that are evaluated exactly, 1 ... count.
    pub exact_count: u32,
    /// 0 ... 1: samplers use radius * i^((alpha - 1)/3), where i is the samples of the passes before (pass * pixels of the crop), for chains the
    /// number of the mutation times that of chains, and 1 at least. 1 keeps the radius; tiles have none; for `volgrad_shift_path` i is 1.
    pub alpha: f32,
    /// FIRST_ORDER, HALF_ORDER, THESIS: greatest absolute weight, which adds a bias of its own; 0 for no clamp.
    pub clamp: f32,
}

pub(super) const DEFAULTS: volgrad_shift_options = volgrad_shift_options {
    struct_size: size_of::<volgrad_shift_options>() as u32,
    mode: VOLGRAD_SHIFT_NONE,
    kernel: VOLGRAD_KERNEL_TILE,
    radius_unit: VOLGRAD_RADIUS_PIXELS,
    radius: 4.0,
    count: 8,
    run: 2,
    exact_count: 1,
    alpha: 1.0,
    clamp: 0.0,
};

/// None for `VOLGRAD_SHIFT_NONE`.
pub(super) fn options(o: &volgrad_shift_options) -> Result<Option<Options>, Fault> {
    let mode = match o.mode {
        VOLGRAD_SHIFT_NONE => return Ok(None),
        VOLGRAD_SHIFT_LOG_LINEAR => Mode::LogLinear,
        VOLGRAD_SHIFT_EXACT => Mode::Exact,
        VOLGRAD_SHIFT_EXCHANGEABLE => Mode::Exchangeable,
        VOLGRAD_SHIFT_FIRST_ORDER => Mode::FirstOrder,
        VOLGRAD_SHIFT_HALF_ORDER => Mode::HalfOrder,
        VOLGRAD_SHIFT_LINEAR_DEPTH => Mode::LinearDepth,
        VOLGRAD_SHIFT_TWO_LEVEL => Mode::TwoLevel,
        // Those of the thesis too: for chains alone.
        _ => return Err(VOLGRAD_ERROR_KIND.at(c"shift.mode", 0)),
    };
    let count = whole(o.count, VOLGRAD_MAX_SHIFTS, c"shift.count")?;
    let options = Options {
        mode,
        kernel: kernel(o)?,
        count,
        run: whole(o.run, VOLGRAD_MAX_RUN, c"shift.run")?,
        exact_count: whole(o.exact_count, o.count, c"shift.exact_count")?,
        alpha: alpha(o)?,
        clamp: clamp(o)?,
    };
    let side = options.tile_side() as usize;
    if options.kernel == Kernel::Tile && side * side != count + 1 {
        return Err(VOLGRAD_ERROR_RANGE.at(c"shift.count", 0));
    }
    Ok(Some(options))
}

/// None for the other modes.
pub(super) fn thesis_options(o: &volgrad_shift_options) -> Result<Option<thesis::Options>, Fault> {
    let as_printed = match o.mode {
        VOLGRAD_SHIFT_THESIS => false,
        VOLGRAD_SHIFT_THESIS_PRINTED => true,
        _ => return Ok(None),
    };
    let count = whole(o.count, VOLGRAD_MAX_SHIFTS, c"shift.count")?;
    let Kernel::Ball(radius) = kernel(o)? else {
        return Err(VOLGRAD_ERROR_KIND.at(c"shift.kernel", 0));
    };
    Ok(Some(thesis::Options { radius, count, alpha: alpha(o)?, clamp: clamp(o)?, as_printed }))
}

fn alpha(o: &volgrad_shift_options) -> Result<f64, Fault> {
    number(o.alpha, |alpha| (0.0..=1.0).contains(&alpha), c"shift.alpha")
}

/// Infinite for none.
fn clamp(o: &volgrad_shift_options) -> Result<f64, Fault> {
    let clamp = number(o.clamp, |clamp| clamp >= 0.0, c"shift.clamp")?;
    Ok(if clamp > 0.0 { clamp } else { f64::INFINITY })
}

fn kernel(o: &volgrad_shift_options) -> Result<Kernel, Fault> {
    if o.kernel == VOLGRAD_KERNEL_TILE {
        return Ok(Kernel::Tile);
    }
    let radius = number(o.radius, |radius| radius > 0.0, c"shift.radius")?;
    match (o.kernel, o.radius_unit) {
        (VOLGRAD_KERNEL_DISK, VOLGRAD_RADIUS_PIXELS) => Ok(Kernel::Disk(Radius::Pixels(radius))),
        (VOLGRAD_KERNEL_DISK, VOLGRAD_RADIUS_WORLD) => Ok(Kernel::Disk(Radius::World(radius))),
        (VOLGRAD_KERNEL_BALL, VOLGRAD_RADIUS_WORLD) => Ok(Kernel::Ball(radius)),
        (VOLGRAD_KERNEL_BALL, VOLGRAD_RADIUS_PIXELS) => Err(VOLGRAD_ERROR_KIND.at(c"shift.radius_unit", 0)),
        _ => Err(VOLGRAD_ERROR_KIND.at(c"shift.kernel, shift.radius_unit", 0)),
    }
}

pub(super) fn number(value: f32, ok: impl Fn(f64) -> bool, field: &'static CStr) -> Result<f64, Fault> {
    let value = f64::from(value);
    if !value.is_finite() {
        return Err(VOLGRAD_ERROR_NOT_FINITE.at(field, 0));
    }
    if ok(value) { Ok(value) } else { Err(VOLGRAD_ERROR_RANGE.at(field, 0)) }
}

fn whole(value: u32, most: u32, field: &'static CStr) -> Result<usize, Fault> {
    if (1..=most).contains(&value) { Ok(value as usize) } else { Err(VOLGRAD_ERROR_RANGE.at(field, 0)) }
}

/// Fills options with their defaults: mode NONE, tiles of 3 x 3 pixels, runs of at most 2 vertices; for the other kernels a
/// radius of 4 pixels. `struct_size`: `sizeof *options` of the caller.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_shift_options_default(
    options: *mut volgrad_shift_options,
    struct_size: usize,
) -> volgrad_status {
    // SAFETY: the header's contract.
    finish(unsafe { write_sized(options, struct_size, DEFAULTS) }.map_err(Into::into))
}

/// Makes a batch from one path of any sampler: `*count` splats, at most options.count + 1, whose expected sum is that of the path alone.
///
/// `weight` is C = w f / p in RGB: what the sampler would have splatted for this path. For the result to be unbiased, hand over the
/// samples of all techniques, with MIS weights w that sum to 1 wherever f > 0, none clamped, all with the same options.
/// Vertices in a medium move in space. A first one on a surface moves with its image point, which takes a kernel on the image (a tile, or
/// a disk in pixels) and a mode that evaluates f (EXACT, EXCHANGEABLE, TWO_LEVEL, LINEAR_DEPTH). Other paths come back as one splat at their own
/// pixel: those whose first vertex is specular or transmits, or is followed by a surface that is not diffuse or by a light that depends on
/// the direction (spot, custom point), and those whose f is 0 here.
/// `seed` and `index` choose the offsets: another index for every path. `seed` alone says where tiles begin: another one for every pass.
/// `queries` may be NULL for FIRST_ORDER, HALF_ORDER and LOG_LINEAR, and for LINEAR_DEPTH unless the kernel is a TILE, whose camera rays are traced.
/// Checks kinds and indices of the path, nothing else (see `volgrad_path_validate`).
/// Costs per offset, in modes that evaluate f, the optical depths of at most options.run + 1 edges and the rays that say whether they are
/// open; in the other modes one gradient for all offsets. `VOLGRAD_ERROR_ZERO_CONTRIBUTION`: the camera does not see the first vertex.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_shift_path(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_shift_options,
    path: *const volgrad_path,
    weight: Rgb,
    seed: u64,
    index: u64,
    splats: *mut volgrad_splat,
    capacity: u32,
    count: *mut u32,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (path, write) = unsafe { (reference(path)?, output(count)?) };
        let mut batch = [volgrad_splat::default(); MAX_SHIFTS + 1];
        let (path, weight) = (slice::from_ref(path), slice::from_ref(&weight));
        let made = unsafe { shift_all(scene, queries, options, path, weight, seed, index, &mut batch) }?;
        if (capacity as usize) < made {
            return Err(VOLGRAD_ERROR_TOO_SMALL.into());
        }
        for (to, from) in unsafe { array_mut(splats, made) }?.iter_mut().zip(batch) {
            *to = from;
        }
        write(made as u32);
        Ok(())
    })())
}

/// As `volgrad_shift_path` for each of `path_count` paths, path i with `weights[i]` and the index `first_index` + i, but what neighbours in
/// the array have in common is computed once: paths that begin with the same vertices, as all contributions of one sample do, become one
/// batch; and a tile's camera rays are traced once for paths that are seen in it one after another, at the same place of their pixels to
/// 1/1000 pixel. So hand over sample after sample, and with VOLGRAD_KERNEL_TILE tile after tile (`volgrad_shift_tile`).
///
/// `*count` splats, at most path_count * (options.count + 1), which `capacity` has to be. On an error what is in `splats` has no meaning.
/// Costs at most what `volgrad_shift_path` costs for each path. `VOLGRAD_ERROR_ZERO_CONTRIBUTION` as there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_shift_paths(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_shift_options,
    paths: *const volgrad_path,
    weights: *const Rgb,
    path_count: u32,
    seed: u64,
    first_index: u64,
    splats: *mut volgrad_splat,
    capacity: u32,
    count: *mut u32,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (paths, weights) = unsafe { (array(paths, path_count as usize)?, array(weights, path_count as usize)?) };
        let (splats, write) = unsafe { (array_mut(splats, capacity as usize)?, output(count)?) };
        write(unsafe { shift_all(scene, queries, options, paths, weights, seed, first_index, splats) }? as u32);
        Ok(())
    })())
}

/// How many splats there are of some paths, all of them in `splats`.
///
/// # Safety
/// As the header says of the pointers.
unsafe fn shift_all(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_shift_options,
    paths: &[volgrad_path],
    weights: &[Rgb],
    seed: u64,
    first_index: u64,
    splats: &mut [volgrad_splat],
) -> Result<usize, Fault> {
    // SAFETY: the caller's promise, here and below.
    let (scene, options) = unsafe { (self::scene(scene)?, sized_over(options, DEFAULTS)?) };
    let options = self::options(&options)?;
    let each = options.map_or(1, |options| options.count + 1);
    if splats.len() < paths.len().saturating_mul(each) {
        return Err(VOLGRAD_ERROR_TOO_SMALL.into());
    }
    let asks = options.as_ref().is_some_and(|options| options.mode.has_queries() || options.has_views());
    let queries = if asks { unsafe { HostQueries::read(queries) }? } else { HostQueries::UNUSED };
    let mut scratch = Scratch::default();
    let mut shifts = options.map(|options| Paths::new(scene, &queries, options, tile_numbers(seed, 0), &mut scratch));
    let mut shiftable = Shiftable::none();
    let mut result = Splats { all: splats, count: 0 };
    let indices = (0..).map(|i| first_index.wrapping_add(i));
    for (index, (path, weight)) in indices.zip(paths.iter().zip(weights)) {
        let path = unsafe { self::path(path) }?;
        (0..path.vertices.len()).try_for_each(|i| path.node(scene, i).map(|_| ()))?;
        let weight = weight.wide();
        if !weight.is_finite() {
            return Err(VOLGRAD_ERROR_NOT_FINITE.at(c"weight", 0));
        }
        let movable = match &options {
            Some(options) if weight.max_element() > 0.0 => shift::prepare(scene, &path, weight, options, &mut shiftable)?,
            _ => false,
        };
        match shifts.as_mut().filter(|_| movable) {
            Some(shifts) => shifts.add(&shiftable, shift_numbers(seed, index, 0), |p, c| result.add(p, c))?,
            None => result.add(first_pixel(scene, &path)?, weight),
        }
    }
    if let Some(shifts) = &mut shifts {
        shifts.finish(|p, c| result.add(p, c))?;
    }
    Ok(result.count)
}

/// The tile that a pixel of the camera's crop is in, for calls of this seed, in `bounds[4]`: pixels bounds[0] <= x < bounds[2], bounds[1] <= y < bounds[3].
/// For options of `VOLGRAD_KERNEL_TILE`: `VOLGRAD_ERROR_KIND` with others. `VOLGRAD_ERROR_RANGE`: the pixel is outside the crop.
/// Costs a constant time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_shift_tile(
    scene: *const volgrad_scene,
    options: *const volgrad_shift_options,
    seed: u64,
    x: u32,
    y: u32,
    bounds: *mut u32,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, options) = unsafe { (self::scene(scene)?, sized_over(options, DEFAULTS)?) };
        let write = unsafe { output(bounds.cast::<[u32; 4]>()) }?;
        let options = self::options(&options)?.filter(|options| options.kernel == Kernel::Tile);
        let side = options.ok_or(VOLGRAD_ERROR_KIND.at(c"shift.mode, shift.kernel", 0))?.tile_side();
        let [x0, y0, x1, y1] = scene.camera.crop;
        if !((x0..x1).contains(&x) && (y0..y1).contains(&y)) {
            return Err(VOLGRAD_ERROR_RANGE.at(c"x, y", 0));
        }
        write(Tiling::new(&scene.camera, side, tile_numbers(seed, 0)).tile(x, y));
        Ok(())
    })())
}

/// Where the camera sees the path.
fn first_pixel(scene: &Scene, path: &Path) -> Result<DVec2, Fault> {
    let camera = &scene.camera;
    let (origin, first) = (path.position(scene, 0)?, path.position(scene, 1)?);
    // A point in the direction of a light at infinity, beyond the near plane.
    let far = origin + first * (1.0 + 2.0 * camera.near_clip / camera.forward.dot(first).abs().max(f64::EPSILON));
    let x = if path.node(scene, 1)?.is_direction() { far } else { first };
    Ok(camera.project(x, camera.on_lens(origin)).ok_or(VOLGRAD_ERROR_ZERO_CONTRIBUTION)?.pixel)
}

/// Single precision, rounded so that the value stays in its pixel.
fn narrow(v: f64) -> f32 {
    let rounded = v as f32;
    if f64::from(rounded) >= floor(v) + 1.0 { rounded.next_down() } else { rounded }
}

/// Room for all splats, and how many there are.
struct Splats<'a> {
    all: &'a mut [volgrad_splat],
    count: usize,
}

impl Splats<'_> {
    fn add(&mut self, pixel: DVec2, value: Colour) {
        if let Some(splat) = self.all.get_mut(self.count) {
            *splat = volgrad_splat { x: narrow(pixel.x), y: narrow(pixel.y), value: value.into() };
            self.count += 1;
        }
    }
}
