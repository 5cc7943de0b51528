//! Materials whose BSDF the host computes.

use super::callbacks::{VOLGRAD_BSDF_LAMBERTIAN, VOLGRAD_BSDF_TRANSMITS, volgrad_custom_bsdf, volgrad_surface_point};
use super::custom::Host;
use super::pointer::sized;
use super::status::{Fault, volgrad_status::*};
use super::types::{VOLGRAD_MATERIAL_TWO_SIDED, volgrad_material};
use crate::math::{Colour, DMat3, DVec2, DVec3, Rgb, Vec3, is_colour, is_unit};
use crate::scene::{Bsdf, BsdfFunction, CustomBsdf, Reflector, SurfaceFrame};

impl From<&SurfaceFrame> for volgrad_surface_point {
    fn from(at: &SurfaceFrame) -> Self {
        let DMat3 { x_axis, y_axis, z_axis } = at.axes;
        Self { user: at.user, position: at.position.into(), x: x_axis.into(), y: y_axis.into(), z: z_axis.into() }
    }
}

impl BsdfFunction for Host<volgrad_custom_bsdf> {
    fn transmits(&self) -> bool {
        self.table.flags == VOLGRAD_BSDF_TRANSMITS
    }

    fn eval(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> Colour {
        let mut value = Rgb::default();
        if let Some(eval) = self.table.eval {
            // SAFETY: the header's contract.
            unsafe { eval(self.table.user, &at.into(), to_camera.into(), to_light.into(), &mut value) };
        }
        let value = value.wide();
        self.checked(value, is_colour(value))
    }

    fn pdf(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> f64 {
        let Some(pdf) = self.table.pdf else { return 0.0 };
        // SAFETY: the header's contract.
        let pdf = unsafe { pdf(self.table.user, &at.into(), to_camera.into(), to_light.into()) };
        self.checked(pdf.into(), pdf.is_finite() && pdf >= 0.0)
    }

    fn sample(&self, at: &SurfaceFrame, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<(DVec3, f64)> {
        let (mut to_light, mut eta_squared) = (Vec3::default(), 1.0);
        let (sample, u) = (self.table.sample?, [u.x, u.y, lobe]);
        // SAFETY: the header's contract.
        let scatters =
            unsafe { sample(self.table.user, &at.into(), to_camera.into(), u.as_ptr(), &mut to_light, &mut eta_squared) };
        if scatters == 0 {
            return None;
        }
        let l = to_light.wide();
        let ok = is_unit(l) && eta_squared > 0.0 && eta_squared.is_finite();
        Some(self.checked((l, eta_squared.into()), ok))
    }

    fn log_gradient(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> Option<([DVec3; 3], [DVec3; 3])> {
        let gradient = self.table.log_gradient?;
        let (mut by_camera, mut by_light) = ([Vec3::default(); 3], [Vec3::default(); 3]);
        // SAFETY: the header's contract; both arrays hold three vectors.
        unsafe {
            gradient(
                self.table.user,
                &at.into(),
                to_camera.into(),
                to_light.into(),
                by_camera.as_mut_ptr(),
                by_light.as_mut_ptr(),
            );
        }
        let all = (by_camera.map(Vec3::wide), by_light.map(Vec3::wide));
        let finite = all.0.iter().chain(&all.1).all(|g| g.is_finite());
        Some(self.checked(all, finite))
    }
}

/// The callbacks of material `i`.
///
/// # Safety
/// As the header says of `custom`.
pub(super) unsafe fn host(m: &volgrad_material, i: usize) -> Result<Host<volgrad_custom_bsdf>, Fault> {
    // SAFETY: the caller's promise.
    let table = unsafe { sized(m.custom) }.map_err(|s| s.at(c"materials.custom", i))?;
    if !matches!(table.flags, 0 | VOLGRAD_BSDF_TRANSMITS | VOLGRAD_BSDF_LAMBERTIAN) {
        return Err(VOLGRAD_ERROR_KIND.at(c"materials.custom.flags", i));
    }
    if table.eval.is_none() {
        return Err(VOLGRAD_ERROR_NULL.at(c"materials.custom.eval", i));
    }
    if table.flags != VOLGRAD_BSDF_LAMBERTIAN && (table.pdf.is_none() || table.sample.is_none()) {
        return Err(VOLGRAD_ERROR_NULL.at(c"materials.custom.pdf, materials.custom.sample", i));
    }
    Ok(Host::new(table))
}

/// The BSDF of material `i`.
pub(super) fn bsdf(host: &'static Host<volgrad_custom_bsdf>, m: &volgrad_material, i: usize) -> Result<Bsdf<'static>, Fault> {
    let custom = CustomBsdf(host);
    let reflector =
        if host.table.flags == VOLGRAD_BSDF_LAMBERTIAN { Reflector::Texture(custom) } else { Reflector::Custom(custom) };
    match m.flags {
        0 => Ok(reflector.into()),
        VOLGRAD_MATERIAL_TWO_SIDED if !host.transmits() => Ok(Bsdf::TwoSided(reflector)),
        _ => Err(VOLGRAD_ERROR_KIND.at(c"materials.flags", i)),
    }
}
