//! Densities that the host computes.

use super::convert::{self, Place};
use super::pointer::{reference, sized};
use super::status::{Fault, volgrad_status::*};
use super::types::{volgrad_custom_density, volgrad_medium};
use crate::math::{DVec3, Vec3};
use crate::medium::{Custom, DensityField};

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

impl DensityField for volgrad_custom_density {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        if let Some(function) = self.density {
            self.ask(function, 0.0f32, points, densities, f64::from);
        }
    }

    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        if let Some(function) = self.gradient {
            self.ask(function, Vec3::default(), points, gradients, Vec3::wide);
        }
    }
}

/// The density of medium `i`, which borrows the host's description of it.
///
/// # Safety
/// As the header says of `custom`.
pub(super) unsafe fn density(m: &volgrad_medium, i: usize) -> Result<Custom<'static>, Fault> {
    // SAFETY: the caller's promise, here and below.
    let checked = unsafe { sized(m.custom) }.map_err(|s| s.at(c"media.custom", i))?;
    let field: &volgrad_custom_density = unsafe { reference(m.custom) }?;
    if checked.density.is_none() || checked.gradient.is_none() {
        return Err(VOLGRAD_ERROR_NULL.at(c"media.custom.density, media.custom.gradient", i));
    }
    let majorant = Place(c"media.custom.majorant", i).number(checked.majorant, |v| v >= 0.0)?;
    let place = Place(c"media.custom.step", i);
    let step = place.number(checked.step, |v| v > 0.0)?;
    Custom::new(field, convert::grid_transform(m, i)?, step, majorant).ok_or(VOLGRAD_ERROR_RANGE.at(place.0, i))
}
