//! Phase functions that the host computes.

use super::callbacks::volgrad_custom_phase;
use super::convert::Place;
use super::custom::Host;
use super::pointer::sized;
use super::status::{Fault, volgrad_status::*};
use crate::phase::PhaseFunction;

impl PhaseFunction for Host<volgrad_custom_phase> {
    fn eval(&self, mu: f64) -> f64 {
        let Some(eval) = self.table.eval else { return 0.0 };
        // SAFETY: the header's contract, here and below.
        let value = unsafe { eval(self.table.user, mu) };
        self.checked(value, value >= 0.0 && value.is_finite())
    }

    fn sample(&self, u: f64) -> f64 {
        let Some(sample) = self.table.sample else { return f64::NAN };
        let mu = unsafe { sample(self.table.user, u) };
        self.checked(mu, mu.abs() <= 1.0)
    }

    fn has_log_derivative(&self) -> bool {
        self.table.log_derivative.is_some()
    }

    fn log_derivative(&self, mu: f64) -> f64 {
        let Some(log_derivative) = self.table.log_derivative else { return 0.0 };
        let slope = unsafe { log_derivative(self.table.user, mu) };
        self.checked(slope, slope.is_finite())
    }
}

/// The callbacks of phase function `i`.
///
/// # Safety
/// As the header says of `phases`.
pub(super) unsafe fn host(pointer: *const volgrad_custom_phase, i: usize) -> Result<Host<volgrad_custom_phase>, Fault> {
    // SAFETY: the caller's promise.
    let table = unsafe { sized(pointer) }.map_err(|s| s.at(c"phases", i))?;
    Place(c"phases.reserved", i).reserved(table.reserved)?;
    if table.eval.is_none() || table.sample.is_none() {
        return Err(VOLGRAD_ERROR_NULL.at(c"phases.eval, phases.sample", i));
    }
    Ok(Host::new(table))
}
