//! OpenEXR files. Only in libvolgrad, not in the freestanding core.

use super::pointer::{array, array_mut, output, reference};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use crate::exr::{self, Attribute, Layout};
use core::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::vec::Vec;

/// A named text or number stored beside an image.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_exr_attribute {
    pub name: *const c_char,
    /// UTF-8 text, or NULL for a number. (All texts and paths here are UTF-8.)
    pub text: *const c_char,
    pub number: f64,
}

/// Which part of an image a file stores, pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct volgrad_exr_layout {
    /// The whole image ("display window").
    pub width: u32,
    pub height: u32,
    /// The stored part ("data window").
    pub x: u32,
    pub y: u32,
    pub window_width: u32,
    pub window_height: u32,
}

/// # Safety
/// `pointer` is NULL or a C string that outlives 'a.
unsafe fn text<'a>(pointer: *const c_char) -> Result<&'a str, Fault> {
    if pointer.is_null() {
        return Err(VOLGRAD_ERROR_NULL.into());
    }
    // SAFETY: the caller's promise.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| VOLGRAD_ERROR_FILE.into())
}

/// Runs code of other crates; a panic there becomes a status here.
fn guarded<T>(work: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(Err(VOLGRAD_ERROR_INTERNAL.into()))
}

/// Writes an OpenEXR file (32-bit float R, G, B; lossless): 3 floats per pixel of the window, row by row from the top; `count` is exactly
/// 3 * window_width * window_height. Allocates. An existing file is replaced; on an error what is left of it is unusable.
/// Costs a file. `VOLGRAD_ERROR_RANGE`: an empty window or image, or another `count`; `VOLGRAD_ERROR_FILE`: the file cannot be written
/// so.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_exr_write(
    path: *const c_char,
    layout: *const volgrad_exr_layout,
    rgb: *const f32,
    count: usize,
    attributes: *const volgrad_exr_attribute,
    attribute_count: u32,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (path, layout, rgb) = unsafe { (text(path)?, reference(layout)?, array(rgb, count)?) };
        let attributes = unsafe { array(attributes, attribute_count as usize) }?;
        let area = layout.window_width as usize * layout.window_height as usize;
        let image = layout.width as usize * layout.height as usize;
        if area == 0 || image == 0 || area.checked_mul(3) != Some(count) {
            return Err(VOLGRAD_ERROR_RANGE.into());
        }
        let attribute = |a: &volgrad_exr_attribute| {
            let name = unsafe { text(a.name) }?;
            Ok(if a.text.is_null() {
                Attribute::Number(name, a.number)
            } else {
                Attribute::Text(name, unsafe { text(a.text) }?)
            })
        };
        guarded(|| {
            let attributes = attributes.iter().map(attribute).collect::<Result<Vec<_>, Fault>>()?;
            exr::write(Path::new(path), &layout_of(layout), rgb, &attributes).map_err(|_| VOLGRAD_ERROR_FILE.into())
        })
    })())
}

fn layout_of(layout: &volgrad_exr_layout) -> Layout {
    Layout {
        width: layout.width as usize,
        height: layout.height as usize,
        x: layout.x as usize,
        y: layout.y as usize,
        window_width: layout.window_width as usize,
        window_height: layout.window_height as usize,
    }
}

/// The windows of an OpenEXR file, to size the buffer for `volgrad_exr_read`.
/// Costs reading the file's head. `VOLGRAD_ERROR_FILE`: it cannot be read, or is no OpenEXR file with R, G, B.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_exr_read_layout(path: *const c_char, layout: *mut volgrad_exr_layout) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (path, write) = unsafe { (text(path)?, output(layout)?) };
        let found = guarded(|| exr::read_layout(Path::new(path)).map_err(|_| VOLGRAD_ERROR_FILE.into()))?;
        let number = |n: usize| u32::try_from(n).map_err(|_| Fault::from(VOLGRAD_ERROR_FILE));
        write(volgrad_exr_layout {
            width: number(found.width)?,
            height: number(found.height)?,
            x: number(found.x)?,
            y: number(found.y)?,
            window_width: number(found.window_width)?,
            window_height: number(found.window_height)?,
        });
        Ok(())
    })())
}

/// Reads the R, G, B of an OpenEXR file's window into `rgb`, which holds at least 3 * window_width * window_height floats. Allocates.
/// Costs a file. `VOLGRAD_ERROR_FILE`: it cannot be read, or is no OpenEXR file with R, G, B; `VOLGRAD_ERROR_TOO_SMALL`: `count` is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_exr_read(path: *const c_char, rgb: *mut f32, count: usize) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let path = unsafe { text(path) }?;
        let pixels = guarded(|| {
            // The size first: a broken file may claim more than there is memory.
            let layout = exr::read_layout(Path::new(path)).map_err(|_| VOLGRAD_ERROR_FILE)?;
            let floats = layout.window_width.checked_mul(layout.window_height).and_then(|n| n.checked_mul(3));
            if floats.is_none_or(|floats| floats > count) {
                return Err(VOLGRAD_ERROR_TOO_SMALL.into());
            }
            exr::read(Path::new(path)).map_err(|_| VOLGRAD_ERROR_FILE.into())
        })?;
        // SAFETY: the header's contract.
        unsafe { array_mut(rgb, pixels.len()) }?.copy_from_slice(&pixels);
        Ok(())
    })())
}
