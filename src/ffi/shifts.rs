//! Shifts of any sampler's paths.

use super::films::volgrad_splat;
use super::paths::path;
use super::pointer::{array_mut, output, sized_over, write_sized};
use super::samplers::HostQueries;
use super::scenes::{scene, volgrad_scene};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::{volgrad_path, volgrad_queries};
use crate::math::{Colour, DVec2, Rgb, floor};
use crate::path::Path;
use crate::sampler::shift_numbers;
use crate::scene::Scene;
use crate::shift::{Kernel, MAX_SHIFTS, Mode, Options, Radius, from_path, shift};

/// No batch: every path stays as it is.
pub const VOLGRAD_SHIFT_NONE: u32 = 0;
/// exp(<gradient of log f, offset>): biased, of order radius^2; no ray queries.
pub const VOLGRAD_SHIFT_LOG_LINEAR: u32 = 1;
/// f(y)/f(x), staying at x where that is 0 or outside [1/4, 4]: unbiased.
pub const VOLGRAD_SHIFT_EXACT: u32 = 2;
/// All around a common centre, weighted f(y)/sum f: unbiased, weights in [0, 1].
pub const VOLGRAD_SHIFT_EXCHANGEABLE: u32 = 3;

/// Uniform in a disk parallel to the image plane.
pub const VOLGRAD_KERNEL_DISK: u32 = 0;
/// Uniform in a ball; its radius must be in world units.
pub const VOLGRAD_KERNEL_BALL: u32 = 1;

/// Pixels at the depth of the vertex.
pub const VOLGRAD_RADIUS_PIXELS: u32 = 0;
pub const VOLGRAD_RADIUS_WORLD: u32 = 1;

/// Most offsets in a batch.
pub const VOLGRAD_MAX_SHIFTS: u32 = 32;

const _: () = assert!(MAX_SHIFTS == VOLGRAD_MAX_SHIFTS as usize);

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
}

pub(super) const DEFAULTS: volgrad_shift_options = volgrad_shift_options {
    struct_size: size_of::<volgrad_shift_options>() as u32,
    mode: VOLGRAD_SHIFT_NONE,
    kernel: VOLGRAD_KERNEL_DISK,
    radius_unit: VOLGRAD_RADIUS_PIXELS,
    radius: 4.0,
    count: 8,
};

/// None for `VOLGRAD_SHIFT_NONE`.
pub(super) fn options(o: &volgrad_shift_options) -> Result<Option<Options>, Fault> {
    let mode = match o.mode {
        VOLGRAD_SHIFT_NONE => return Ok(None),
        VOLGRAD_SHIFT_LOG_LINEAR => Mode::LogLinear,
        VOLGRAD_SHIFT_EXACT => Mode::Exact,
        VOLGRAD_SHIFT_EXCHANGEABLE => Mode::Exchangeable,
        _ => return Err(VOLGRAD_ERROR_KIND.at(c"shift.mode", 0)),
    };
    let radius = f64::from(o.radius);
    if !radius.is_finite() {
        return Err(VOLGRAD_ERROR_NOT_FINITE.at(c"shift.radius", 0));
    }
    if radius <= 0.0 {
        return Err(VOLGRAD_ERROR_RANGE.at(c"shift.radius", 0));
    }
    let (kernel, radius) = match (o.kernel, o.radius_unit) {
        (VOLGRAD_KERNEL_DISK, VOLGRAD_RADIUS_PIXELS) => (Kernel::Disk, Radius::Pixels(radius)),
        (VOLGRAD_KERNEL_DISK, VOLGRAD_RADIUS_WORLD) => (Kernel::Disk, Radius::World(radius)),
        (VOLGRAD_KERNEL_BALL, VOLGRAD_RADIUS_WORLD) => (Kernel::Ball, Radius::World(radius)),
        (VOLGRAD_KERNEL_BALL, VOLGRAD_RADIUS_PIXELS) => return Err(VOLGRAD_ERROR_KIND.at(c"shift.radius_unit", 0)),
        _ => return Err(VOLGRAD_ERROR_KIND.at(c"shift.kernel, shift.radius_unit", 0)),
    };
    if o.count == 0 || o.count > VOLGRAD_MAX_SHIFTS {
        return Err(VOLGRAD_ERROR_RANGE.at(c"shift.count", 0));
    }
    Ok(Some(Options { mode, kernel, radius, count: o.count as usize }))
}

/// Fills options with their defaults: mode NONE, a disk of 4 pixels, 8 offsets. `struct_size`: `sizeof *options` of the caller.
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
/// A first vertex in a medium moves in space. One on a surface moves with its image point, which takes mode EXACT or EXCHANGEABLE and a
/// disk in pixels. Paths whose first vertex may not move (specular, or before a specular one) come back as one splat at their own pixel.
/// `seed` and `index` choose the offsets: another index for every path. `queries` may be NULL for `VOLGRAD_SHIFT_LOG_LINEAR`.
/// Checks kinds and indices of the path, nothing else (see `volgrad_path_validate`).
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
        let (scene, path, write) = unsafe { (self::scene(scene)?, self::path(path)?, output(count)?) };
        (0..path.vertices.len()).try_for_each(|i| path.node(scene, i).map(|_| ()))?;
        let options = self::options(&unsafe { sized_over(options, DEFAULTS) }?)?;
        if !weight.wide().is_finite() {
            return Err(VOLGRAD_ERROR_NOT_FINITE.at(c"weight", 0));
        }
        let mut batch = Splats { all: [volgrad_splat::default(); MAX_SHIFTS + 1], count: 0 };
        let shiftable = match &options {
            Some(_) if weight.wide().max_element() > 0.0 => from_path(scene, &path, weight.wide())?,
            _ => None,
        };
        match (options, shiftable) {
            (Some(options), Some(shiftable)) => {
                let queries = match options.mode {
                    Mode::LogLinear => HostQueries::UNUSED,
                    _ => unsafe { HostQueries::read(queries) }?,
                };
                let random = shift_numbers(seed, index, 0);
                shift(scene, &queries, &options, &shiftable, random, |pixel, value| batch.add(pixel, value))?;
            }
            _ => batch.add(first_pixel(scene, &path)?, weight.wide()),
        }
        if (capacity as usize) < batch.count {
            return Err(VOLGRAD_ERROR_TOO_SMALL.into());
        }
        let result = unsafe { array_mut(splats, batch.count) }?;
        result.copy_from_slice(&batch.all[..batch.count]);
        write(batch.count as u32);
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

/// Splats of one batch, before they go to the caller.
struct Splats {
    all: [volgrad_splat; MAX_SHIFTS + 1],
    count: usize,
}

impl Splats {
    fn add(&mut self, pixel: DVec2, value: Colour) {
        if let Some(splat) = self.all.get_mut(self.count) {
            *splat = volgrad_splat { x: narrow(pixel.x), y: narrow(pixel.y), value: value.into() };
            self.count += 1;
        }
    }
}
