//! From C pointers to references: NULL and alignment checks, option structs of other sizes.

use super::status::volgrad_status::{self, *};
use core::mem::{MaybeUninit, size_of};
use core::slice;

pub fn check<T>(pointer: *const T) -> Result<(), volgrad_status> {
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

/// The struct_size of a caller's T, whose bytes beyond what this library knows are 0.
///
/// # Safety
/// `pointer`, if not NULL and aligned, points to as many bytes as the u32 there says.
unsafe fn declared_size<T>(pointer: *const T) -> Result<usize, volgrad_status> {
    check(pointer)?;
    // SAFETY: T is aligned and starts with a u32.
    let size = unsafe { pointer.cast::<u32>().read() } as usize;
    plausible(size)?;
    // SAFETY: the caller's promise covers `size` bytes.
    let bytes = unsafe { slice::from_raw_parts(pointer.cast::<u8>(), size) };
    let unknown = bytes.get(size_of::<T>()..).unwrap_or(&[]);
    if unknown.iter().all(|byte| *byte == 0) { Ok(size) } else { Err(VOLGRAD_ERROR_STRUCT_SIZE) }
}

/// A struct with pointers that starts with its size. Half of a pointer is none, so all of it must be there.
///
/// # Safety
/// As for `declared_size`; any bytes are a valid `T`.
pub unsafe fn sized<T: Copy>(pointer: *const T) -> Result<T, volgrad_status> {
    // SAFETY: the caller's promise.
    if unsafe { declared_size(pointer) }? < size_of::<T>() {
        return Err(VOLGRAD_ERROR_STRUCT_SIZE);
    }
    // SAFETY: the size says that all of T is there.
    Ok(unsafe { pointer.read() })
}

/// The same of a struct that has grown since it ended after `first` bytes: what an older caller does not have is 0.
///
/// # Safety
/// As for `sized`; 0 is a valid value of everything in T.
pub unsafe fn sized_since<T: Copy>(pointer: *const T, first: usize) -> Result<T, volgrad_status> {
    // SAFETY: the caller's promise, here and below.
    if unsafe { declared_size(pointer) }? != first {
        return unsafe { sized(pointer) };
    }
    let mut value = MaybeUninit::<T>::zeroed();
    unsafe {
        value.as_mut_ptr().cast::<u8>().copy_from_nonoverlapping(pointer.cast(), first.min(size_of::<T>()));
        Ok(value.assume_init())
    }
}

/// A struct of numbers that starts with its size: the part that the caller has, over `defaults`.
///
/// # Safety
/// As for `declared_size`; any bytes are a valid `T`.
pub unsafe fn sized_over<T: Copy>(pointer: *const T, defaults: T) -> Result<T, volgrad_status> {
    // SAFETY: the caller's promise.
    let known = unsafe { declared_size(pointer) }?.min(size_of::<T>());
    let mut value = defaults;
    // SAFETY: both hold this many bytes and do not overlap: `value` is ours.
    unsafe { (&raw mut value).cast::<u8>().copy_from_nonoverlapping(pointer.cast(), known) };
    Ok(value)
}

/// Writes `value` into a caller's struct of `size` bytes, and no further, and sets its struct_size.
///
/// # Safety
/// `pointer`, if not NULL and aligned, points to `size` writable bytes. T starts with a u32, its size.
pub unsafe fn write_sized<T: Copy>(pointer: *mut T, size: usize, value: T) -> Result<(), volgrad_status> {
    check(pointer)?;
    plausible(size)?;
    let (bytes, known) = (pointer.cast::<u8>(), size.min(size_of::<T>()));
    // SAFETY: the caller's promise covers `size` bytes, of which `known` come from `value` and the rest is cleared.
    unsafe {
        bytes.copy_from_nonoverlapping((&raw const value).cast(), known);
        bytes.add(known).write_bytes(0, size - known);
        pointer.cast::<u32>().write(size as u32);
    }
    Ok(())
}

/// A struct has its size at least; beyond some kilobytes it is a mistake, not a future version.
fn plausible(size: usize) -> Result<(), volgrad_status> {
    if (size_of::<u32>()..=4096).contains(&size) { Ok(()) } else { Err(VOLGRAD_ERROR_STRUCT_SIZE) }
}
