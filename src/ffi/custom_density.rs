//! Densities that the host computes.

use super::callbacks::{volgrad_custom_density, volgrad_density_integrals, volgrad_stretch};
use super::convert::{self, Place};
use super::custom::Host;
use super::pointer::sized_since;
use super::status::{Fault, volgrad_status::*};
use super::types::volgrad_medium;
use crate::math::{DVec3, Vec3};
use crate::medium::{Custom, DensityField, IntegratedField, Moments, Stretch};
use core::mem::offset_of;

/// Points that fit on the stack while they are converted.
const BATCH: usize = 32;

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

impl DensityField for Host<volgrad_custom_density> {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        if let Some(function) = self.table.density {
            let convert = |d: f32| self.checked(d.into(), d >= 0.0 && d.is_finite());
            self.table.ask(function, 0.0, points, densities, convert);
        }
    }

    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        if let Some(function) = self.table.gradient {
            let convert = |g: Vec3| self.checked(g.wide(), g.wide().is_finite());
            self.table.ask(function, Vec3::default(), points, gradients, convert);
        }
    }
}

impl IntegratedField for Host<volgrad_custom_density> {
    fn moments(&self, stretch: &Stretch, gradients: bool) -> Moments {
        let Some(function) = self.table.integrals else { return Moments::default() };
        let Stretch { origin, direction, start, end } = *stretch;
        let stretch = volgrad_stretch { origin: origin.to_array(), direction: direction.to_array(), start, end };
        let mut found = volgrad_density_integrals::default();
        // SAFETY: the header's contract.
        unsafe { function(self.table.user, &stretch, gradients.into(), &mut found) };
        let (gradient, first_moment) = (DVec3::from_array(found.gradient), DVec3::from_array(found.moment));
        let finite = !gradients || (gradient.is_finite() && first_moment.is_finite());
        let ok = found.density >= 0.0 && found.density.is_finite() && finite;
        self.checked(Moments { integral: found.density, gradient, first_moment, ..Moments::default() }, ok)
    }
}

/// `sizeof(volgrad_custom_density)` before it had integrals.
const FIRST: usize = offset_of!(volgrad_custom_density, integrals);

/// The callbacks of medium `i`.
///
/// # Safety
/// As the header says of `custom`.
pub(super) unsafe fn host(m: &volgrad_medium, i: usize) -> Result<Host<volgrad_custom_density>, Fault> {
    // SAFETY: the caller's promise.
    let table =
        unsafe { sized_since(m.custom.cast::<volgrad_custom_density>(), FIRST) }.map_err(|s| s.at(c"media.custom", i))?;
    Place(c"media.custom.reserved", i).reserved(table.reserved)?;
    if table.density.is_none() || table.gradient.is_none() {
        return Err(VOLGRAD_ERROR_NULL.at(c"media.custom.density, media.custom.gradient", i));
    }
    Ok(Host::new(table))
}

/// The density of medium `i`.
pub(super) fn density(
    host: &'static Host<volgrad_custom_density>,
    m: &volgrad_medium,
    i: usize,
) -> Result<Custom<'static>, Fault> {
    let majorant = Place(c"media.custom.majorant", i).number(host.table.majorant, |v| v >= 0.0)?;
    if host.table.integrals.is_some() {
        return Ok(Custom::exact(host, convert::grid_transform(m, i)?, majorant));
    }
    let place = Place(c"media.custom.step", i);
    let step = place.number(host.table.step, |v| v > 0.0)?;
    Custom::new(host, convert::grid_transform(m, i)?, step, majorant).ok_or(VOLGRAD_ERROR_RANGE.at(place.0, i))
}
