//! Films: exact sums of splats, in memory of the caller.

use super::pointer::{array, array_mut, output, reference};
use super::scenes::{check_memory, image_size};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::VOLGRAD_ABI_VERSION;
use crate::film::{Cell, Count, Film};
use crate::math::{DVec2, Rgb};
use core::ffi::c_void;
use core::mem::size_of;
use core::slice;

/// A film. It holds no pointer, so its memory may be copied, moved and stored: all of it, `volgrad_film_size` bytes. Read back what was stored
/// unchanged, with the same build of the library.
#[repr(C, align(16))]
pub struct volgrad_film {
    stamp: u64,
    pub(super) width: u32,
    pub(super) height: u32,
    dropped: Count,
    /// Not a bool: stored films come back as they please.
    shared: u32,
}

const STAMP: u64 = 0x766f_6c66_696c_6d00 | VOLGRAD_ABI_VERSION as u64;

/// Light for one pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_splat {
    /// Image point, pixels: pixel (i, j) covers i <= x < i + 1, j <= y < j + 1.
    pub x: f32,
    pub y: f32,
    /// May be negative.
    pub value: Rgb,
}

/// # Safety
/// As for `reference`; the film was initialised, so that its cells follow it.
pub(super) unsafe fn film<'a>(pointer: *mut volgrad_film) -> Result<Film<'a>, Fault> {
    // SAFETY: the caller's promise; all that changes in a film is atomic.
    let (object, cells) = unsafe { self::cells(pointer) }?;
    let volgrad_film { width, height, ref dropped, shared, .. } = *object;
    Ok(Film { width, height, cells, dropped, is_shared: shared != 0 })
}

/// The cells of a film that is only read.
///
/// # Safety
/// As for `reference`; the film was initialised.
pub(super) unsafe fn cells<'a>(pointer: *const volgrad_film) -> Result<(&'a volgrad_film, &'a [Cell]), Fault> {
    // SAFETY: the caller's promise; the stamp says that there was room for this many cells behind the head, and that they were cleared.
    let object = unsafe { reference(pointer) }?;
    if object.stamp != STAMP {
        return Err(VOLGRAD_ERROR_NOT_INITIALISED.into());
    }
    let count = image_size(object.width, object.height)?;
    Ok((object, unsafe { slice::from_raw_parts(pointer.add(1).cast::<Cell>(), count) }))
}

fn bytes_of(width: u32, height: u32) -> Result<usize, Fault> {
    let cells = image_size(width, height)?.checked_mul(size_of::<Cell>());
    cells.and_then(|bytes| bytes.checked_add(size_of::<volgrad_film>())).ok_or(VOLGRAD_ERROR_RANGE.into())
}

/// Memory that a film of width * height pixels needs: 48 bytes per pixel and a head.
/// `VOLGRAD_ERROR_RANGE`: a side is 0 or above 65535.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_film_size(width: u32, height: u32, bytes: *mut usize) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let write = unsafe { output(bytes) }?;
        write(bytes_of(width, height)?);
        Ok(())
    })())
}

/// Makes an empty film in `memory`: `bytes` as from `volgrad_film_size`, aligned to 16. There is nothing else to free.
/// Costs writing all of it. `VOLGRAD_ERROR_RANGE` as for `volgrad_film_size`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_film_init(
    memory: *mut c_void,
    bytes: usize,
    width: u32,
    height: u32,
    film: *mut *mut volgrad_film,
) -> volgrad_status {
    // SAFETY: the header's contract.
    finish(unsafe { init(memory, bytes, width, height, film, false) })
}

/// The same, of a film that any number of threads may add to at a time, by `volgrad_film_add`, `volgrad_film_merge`, samplers and chains: a call that
/// wants a film of its own takes this one from all of them. Sums are as exact, so that the image does not depend on the threads either.
/// Look at it (`_develop`, `_dropped`, `_merge` from it, a copy of its memory) while no thread is adding.
/// Costs as `volgrad_film_init`; a splat costs some nanoseconds more than in a film that belongs to a thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_film_init_shared(
    memory: *mut c_void,
    bytes: usize,
    width: u32,
    height: u32,
    film: *mut *mut volgrad_film,
) -> volgrad_status {
    // SAFETY: the header's contract.
    finish(unsafe { init(memory, bytes, width, height, film, true) })
}

/// # Safety
/// The header's contract.
unsafe fn init(
    memory: *mut c_void,
    bytes: usize,
    width: u32,
    height: u32,
    film: *mut *mut volgrad_film,
    is_shared: bool,
) -> Result<(), Fault> {
    // SAFETY: the caller's promise.
    let write = unsafe { output(film) }?;
    let needed = bytes_of(width, height)?;
    check_memory(memory, bytes, needed)?;
    let object = memory.cast::<volgrad_film>();
    // SAFETY: the memory is aligned to 16 and holds `needed` bytes; zeros are empty cells.
    unsafe {
        memory.cast::<u8>().write_bytes(0, needed);
        object.write(volgrad_film { stamp: STAMP, width, height, dropped: Count::default(), shared: is_shared.into() });
    }
    write(object);
    Ok(())
}

/// Adds `count` splats to the pixels that contain them. Those that are not finite, beyond 1e9 or off the film are dropped and counted.
/// Sums are exact, in steps of 2^-64: their order does not matter.
/// Costs a constant time per splat.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_film_add(
    film: *mut volgrad_film,
    splats: *const volgrad_splat,
    count: usize,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (mut film, splats) = unsafe { (self::film(film)?, array(splats, count)?) };
        for splat in splats {
            film.add(DVec2::new(splat.x.into(), splat.y.into()), splat.value.wide());
        }
        Ok(())
    })())
}

/// Adds all of `from` to `into`, exactly. Both have the same size and are two films.
/// Costs a pass over both. `VOLGRAD_ERROR_RANGE`: they are one film.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_film_merge(into: *mut volgrad_film, from: *const volgrad_film) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (source, cells) = unsafe { self::cells(from) }?;
        if core::ptr::eq(into, from) {
            return Err(VOLGRAD_ERROR_RANGE.into());
        }
        // SAFETY: the header's contract; the films are not the same.
        let mut target = unsafe { self::film(into) }?;
        if (source.width, source.height) != (target.width, target.height) {
            return Err(VOLGRAD_ERROR_SIZE_MISMATCH.into());
        }
        target.merge(cells, source.dropped.get());
        Ok(())
    })())
}

/// Writes the sums times `scale` as linear RGB, 3 floats per pixel, row by row from the top; `count` >= 3 * width * height floats.
/// For a path sampler `scale` is 1/passes.
/// Costs a pass over the film. `VOLGRAD_ERROR_NOT_FINITE`: `scale` is not; `VOLGRAD_ERROR_TOO_SMALL`: `count` is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_film_develop(
    film: *const volgrad_film,
    scale: f64,
    rgb: *mut f32,
    count: usize,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (_, cells) = unsafe { self::cells(film) }?;
        if !scale.is_finite() {
            return Err(VOLGRAD_ERROR_NOT_FINITE.into());
        }
        if count < 3 * cells.len() {
            return Err(VOLGRAD_ERROR_TOO_SMALL.into());
        }
        // SAFETY: the header's contract.
        let rgb = unsafe { array_mut(rgb, 3 * cells.len()) }?;
        for (pixel, cell) in rgb.chunks_exact_mut(3).zip(cells) {
            let Rgb { r, g, b } = (cell.value() * scale).into();
            pixel.copy_from_slice(&[r, g, b]);
        }
        Ok(())
    })())
}

/// Number of splats that were dropped (see `volgrad_film_add`).
/// Costs a constant time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_film_dropped(film: *const volgrad_film, dropped: *mut u64) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let ((film, _), write) = unsafe { (self::cells(film)?, output(dropped)?) };
        write(film.dropped.get());
        Ok(())
    })())
}
