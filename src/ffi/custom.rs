//! Densities that the host computes.

use super::convert::{self, Place};
use super::pointer::{output, reference, sized};
use super::scenes::{object, volgrad_scene};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::{volgrad_custom_density, volgrad_medium};
use crate::math::{DVec3, Vec3};
use crate::medium::{Custom, DensityField};
use core::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Points that fit on the stack while they are converted.
const BATCH: usize = 32;

// SAFETY: the header's contract: the functions may be called by several threads at a time, with the same `user`.
unsafe impl Sync for volgrad_custom_density {}

impl volgrad_custom_density {
    /// Hands the points over in single precision, some at a time, and takes a value back for each.
    fn ask<T: Copy, V>(
        &self,
        function: unsafe extern "C" fn(*mut core::ffi::c_void, *const Vec3, *mut T, u32),
        zero: T,
        points: &[DVec3],
        values: &mut [V],
        convert: impl Fn(T) -> V,
    ) {
        for (points, values) in points.chunks(BATCH).zip(values.chunks_mut(BATCH)) {
            let (mut single, mut answers) = ([Vec3::default(); BATCH], [zero; BATCH]);
            single.iter_mut().zip(points).for_each(|(single, point)| *single = (*point).into());
            // SAFETY: both arrays hold as many values; the rest is the header's contract.
            unsafe { function(self.user, single.as_ptr(), answers.as_mut_ptr(), points.len() as u32) };
            values.iter_mut().zip(answers).for_each(|(value, answer)| *value = convert(answer));
        }
    }
}

/// A host's density, and how many of its values were left out.
#[derive(Debug)]
pub(super) struct Field {
    host: &'static volgrad_custom_density,
    dropped: AtomicU64,
}

impl Field {
    /// Counts a value that is none; the core takes 0 for it.
    fn checked<T>(&self, value: T, ok: bool) -> T {
        if !ok {
            self.dropped.fetch_add(1, Relaxed);
        }
        value
    }
}

impl DensityField for Field {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        if let Some(function) = self.host.density {
            let convert = |d: f32| self.checked(d.into(), d >= 0.0 && d.is_finite());
            self.host.ask(function, 0.0, points, densities, convert);
        }
    }

    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        if let Some(function) = self.host.gradient {
            let convert = |g: Vec3| self.checked(g.wide(), g.wide().is_finite());
            self.host.ask(function, Vec3::default(), points, gradients, convert);
        }
    }
}

/// The callbacks of medium `i`, which borrow the host's description of it.
///
/// # Safety
/// As the header says of `custom`.
pub(super) unsafe fn field(m: &volgrad_medium, i: usize) -> Result<Field, Fault> {
    // SAFETY: the caller's promise, here and below.
    let checked = unsafe { sized(m.custom) }.map_err(|s| s.at(c"media.custom", i))?;
    if checked.density.is_none() || checked.gradient.is_none() {
        return Err(VOLGRAD_ERROR_NULL.at(c"media.custom.density, media.custom.gradient", i));
    }
    Ok(Field { host: unsafe { reference(m.custom) }?, dropped: AtomicU64::new(0) })
}

/// The density of medium `i`.
pub(super) fn density(field: &'static Field, m: &volgrad_medium, i: usize) -> Result<Custom<'static>, Fault> {
    let majorant = Place(c"media.custom.majorant", i).number(field.host.majorant, |v| v >= 0.0)?;
    let place = Place(c"media.custom.step", i);
    let step = place.number(field.host.step, |v| v > 0.0)?;
    Custom::new(field, convert::grid_transform(m, i)?, step, majorant).ok_or(VOLGRAD_ERROR_RANGE.at(place.0, i))
}

/// How many values of the scene's custom densities were NaN, infinite or negative, and how many of their gradients were not finite, since
/// `volgrad_scene_init`: all of them count as 0. A scene's guided scenes count with it. While other threads use the scene this is what they
/// have counted by now.
/// Costs a look at each custom density's counter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_scene_dropped_densities(scene: *const volgrad_scene, dropped: *mut u64) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, write) = unsafe { (object(scene)?, output(dropped)?) };
        write(scene.fields.iter().map(|field| field.dropped.load(Relaxed)).sum());
        Ok(())
    })())
}
