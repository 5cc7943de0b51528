//! Lights that the host computes.

use super::callbacks::volgrad_custom_light;
use super::convert::{Place, not_negative};
use super::custom::Host;
use super::pointer::sized;
use super::status::{Fault, volgrad_status::*};
use super::types::{VOLGRAD_LIGHT_CUSTOM_POINT, VOLGRAD_LIGHT_CUSTOM_SKY, volgrad_light};
use crate::math::{Colour, DVec2, DVec3, Rgb, Vec3, is_colour, is_unit};
use crate::scene::{CustomProfile, CustomSky, Light, ProfileFunction, SkyFunction};

impl Host<volgrad_custom_light> {
    fn emission(&self, direction: DVec3) -> Colour {
        let mut value = Rgb::default();
        if let Some(emission) = self.table.emission {
            // SAFETY: the header's contract, here and below.
            unsafe { emission(self.table.user, direction.into(), &mut value) };
        }
        let value = value.wide();
        self.checked(value, is_colour(value))
    }
}

impl SkyFunction for Host<volgrad_custom_light> {
    fn radiance(&self, to_sky: DVec3) -> Colour {
        self.emission(to_sky)
    }

    fn pdf(&self, to_sky: DVec3) -> f64 {
        let Some(pdf) = self.table.pdf else { return 0.0 };
        // SAFETY: as above.
        let pdf = unsafe { pdf(self.table.user, to_sky.into()) };
        self.checked(pdf.into(), pdf.is_finite() && pdf >= 0.0)
    }

    fn sample(&self, u: DVec2) -> Option<DVec3> {
        let mut to_sky = Vec3::default();
        // SAFETY: as above.
        let shines = unsafe { self.table.sample?(self.table.user, [u.x, u.y].as_ptr(), &mut to_sky) };
        let to_sky = to_sky.wide();
        (shines != 0).then(|| self.checked(to_sky, is_unit(to_sky)))
    }
}

impl ProfileFunction for Host<volgrad_custom_light> {
    fn intensity(&self, direction: DVec3) -> Colour {
        self.emission(direction)
    }

    fn log_gradient(&self, direction: DVec3) -> Option<[DVec3; 3]> {
        let mut gradient = [Vec3::default(); 3];
        // SAFETY: as above; the array holds three vectors.
        unsafe { self.table.log_gradient?(self.table.user, direction.into(), gradient.as_mut_ptr()) };
        let gradient = gradient.map(Vec3::wide);
        Some(self.checked(gradient, gradient.iter().all(|g| g.is_finite())))
    }
}

pub(super) fn is_custom(l: &volgrad_light) -> bool {
    matches!(l.kind, VOLGRAD_LIGHT_CUSTOM_SKY | VOLGRAD_LIGHT_CUSTOM_POINT)
}

/// The callbacks of light `i`.
///
/// # Safety
/// As the header says of `custom`.
pub(super) unsafe fn host(l: &volgrad_light, i: usize) -> Result<Host<volgrad_custom_light>, Fault> {
    // SAFETY: the caller's promise.
    let table = unsafe { sized(l.custom) }.map_err(|s| s.at(c"lights.custom", i))?;
    Place(c"lights.custom.reserved", i).reserved(table.reserved)?;
    if table.emission.is_none() {
        return Err(VOLGRAD_ERROR_NULL.at(c"lights.custom.emission", i));
    }
    if l.kind == VOLGRAD_LIGHT_CUSTOM_SKY && (table.pdf.is_none() || table.sample.is_none()) {
        return Err(VOLGRAD_ERROR_NULL.at(c"lights.custom.pdf, lights.custom.sample", i));
    }
    Ok(Host::new(table))
}

/// Light `i`, if it is one of these.
pub(super) fn light(host: &'static Host<volgrad_custom_light>, l: &volgrad_light, i: usize) -> Result<Light<'static>, Fault> {
    let scale = Place(c"lights.emission", i).colour(l.emission, not_negative)?;
    if l.kind == VOLGRAD_LIGHT_CUSTOM_SKY {
        return Ok(Light::CustomSky(CustomSky { function: host, scale }));
    }
    let position = Place(c"lights.position", i).point(l.position)?;
    Ok(Light::CustomPoint { position, profile: CustomProfile { function: host, scale } })
}
