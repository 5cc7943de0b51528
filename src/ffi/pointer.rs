//! From C pointers to references: NULL and alignment checks, option structs of other sizes.

use super::status::volgrad_status::{self, *};
use core::mem::size_of;
use core::slice;

fn check<T>(pointer: *const T) -> Result<(), volgrad_status> {
    if pointer.is_null() {
        Err(VOLGRAD_ERROR_NULL)
    } else if !pointer.is_aligned() {
        Err(VOLGRAD_ERROR_MISALIGNED)
    } else {
        Ok(())
    }
}

/// # Safety
/// `pointer`, if not NULL and aligned, points to a `T` that nothing else changes during 'a.
pub unsafe fn reference<'a, T>(pointer: *const T) -> Result<&'a T, volgrad_status> {
    check(pointer)?;
    // SAFETY: checked, and the caller's promise.
    Ok(unsafe { &*pointer })
}

/// # Safety
/// `pointer`, if not NULL and aligned, points to an initialised `T` that nothing else uses during 'a.
pub unsafe fn exclusive<'a, T>(pointer: *mut T) -> Result<&'a mut T, volgrad_status> {
    check(pointer)?;
    // SAFETY: checked, and the caller's promise.
    Ok(unsafe { &mut *pointer })
}

/// An output: written once, never read.
///
/// # Safety
/// `pointer`, if not NULL and aligned, may be written.
pub unsafe fn output<'a, T: 'a>(pointer: *mut T) -> Result<impl FnOnce(T) + 'a, volgrad_status> {
    check(pointer)?;
    // SAFETY: checked, and the caller's promise.
    Ok(move |value| unsafe { pointer.write(value) })
}

/// NULL is an empty array if `count` is 0.
///
/// # Safety
/// `pointer`, if not NULL and aligned, points to `count` values that nothing changes during 'a.
pub unsafe fn array<'a, T>(pointer: *const T, count: usize) -> Result<&'a [T], volgrad_status> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer)?;
    fits::<T>(count)?;
    // SAFETY: checked, and the caller's promise.
    Ok(unsafe { slice::from_raw_parts(pointer, count) })
}

/// # Safety
/// `pointer`, if not NULL and aligned, points to `count` initialised values that nothing else uses during 'a.
pub unsafe fn array_mut<'a, T>(pointer: *mut T, count: usize) -> Result<&'a mut [T], volgrad_status> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(pointer)?;
    fits::<T>(count)?;
    // SAFETY: checked, and the caller's promise.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, count) })
}

/// No array spans more than half the address space.
fn fits<T>(count: usize) -> Result<(), volgrad_status> {
    match count.checked_mul(size_of::<T>()) {
        Some(bytes) if isize::try_from(bytes).is_ok() => Ok(()),
        _ => Err(VOLGRAD_ERROR_RANGE),
    }
}

/// A struct that starts with its size: the known part of the caller's over `defaults`. An older caller's struct is shorter; a newer
/// one's extra bytes must be 0.
///
/// # Safety
/// `pointer`, if not NULL and aligned, points to as many bytes as the u32 there says; any bytes are a valid `T`.
pub unsafe fn sized<T: Copy>(pointer: *const T, defaults: T) -> Result<T, volgrad_status> {
    check(pointer)?;
    // SAFETY: T is aligned and starts with a u32.
    let size = unsafe { pointer.cast::<u32>().read() } as usize;
    if size < size_of::<u32>() || size > LARGEST_STRUCT {
        return Err(VOLGRAD_ERROR_STRUCT_SIZE);
    }
    // SAFETY: the caller's promise covers `size` bytes.
    let bytes = unsafe { slice::from_raw_parts(pointer.cast::<u8>(), size) };
    if bytes.iter().skip(size_of::<T>()).any(|byte| *byte != 0) {
        return Err(VOLGRAD_ERROR_STRUCT_SIZE);
    }
    let mut value = defaults;
    // SAFETY: both ranges hold this many bytes and do not overlap: `value` is ours.
    unsafe { (&raw mut value).cast::<u8>().copy_from_nonoverlapping(bytes.as_ptr(), size.min(size_of::<T>())) };
    Ok(value)
}

/// Writes `value` into a caller's struct of `size` bytes, and no further; the caller's `struct_size` becomes `size`.
///
/// # Safety
/// `pointer`, if not NULL and aligned, points to `size` writable bytes. T starts with a u32, its size.
pub unsafe fn write_sized<T: Copy>(pointer: *mut T, size: usize, value: T) -> Result<(), volgrad_status> {
    check(pointer)?;
    if size < size_of::<u32>() || size > LARGEST_STRUCT {
        return Err(VOLGRAD_ERROR_STRUCT_SIZE);
    }
    let bytes = pointer.cast::<u8>();
    let known = size.min(size_of::<T>());
    // SAFETY: the caller's promise covers `size` bytes, of which `known` come from `value` and the rest is cleared.
    unsafe {
        bytes.copy_from_nonoverlapping((&raw const value).cast::<u8>(), known);
        bytes.add(known).write_bytes(0, size - known);
        pointer.cast::<u32>().write(size as u32);
    }
    Ok(())
}

/// A struct_size beyond this is a mistake, not a future version.
const LARGEST_STRUCT: usize = 4096;
