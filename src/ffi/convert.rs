//! From the header's descriptions to the core's types, with every range checked.

use super::status::{Fault, volgrad_status::*};
use super::types::*;
use crate::math::{Colour, DAffine3, DMat3, DVec3, Rgb, Vec3};
use crate::medium::NONE;
use crate::phase::Phase;
use crate::scene::{Bsdf, Camera, Light};
use core::ffi::CStr;

/// Names what is checked: the field, and which element of its array.
#[derive(Clone, Copy)]
pub struct Place(pub &'static CStr, pub usize);

impl Place {
    pub fn number(self, value: f32, ok: impl Fn(f64) -> bool) -> Result<f64, Fault> {
        if !value.is_finite() {
            return Err(VOLGRAD_ERROR_NOT_FINITE.at(self.0, self.1));
        }
        if ok(value.into()) { Ok(value.into()) } else { Err(VOLGRAD_ERROR_RANGE.at(self.0, self.1)) }
    }

    fn colour(self, value: Rgb, ok: impl Fn(f64) -> bool) -> Result<Colour, Fault> {
        for channel in [value.r, value.g, value.b] {
            self.number(channel, &ok)?;
        }
        Ok(value.wide())
    }

    pub fn point(self, value: Vec3) -> Result<DVec3, Fault> {
        if value.wide().is_finite() { Ok(value.wide()) } else { Err(VOLGRAD_ERROR_NOT_FINITE.at(self.0, self.1)) }
    }

    /// A unit vector; what single precision lacks in length is mended.
    pub fn unit(self, value: Vec3) -> Result<DVec3, Fault> {
        let v = self.point(value)?;
        let unit = (v.length() - 1.0).abs() < UNIT_TOLERANCE;
        if unit { Ok(v.normalize()) } else { Err(VOLGRAD_ERROR_NOT_FINITE.at(self.0, self.1)) }
    }

    fn kind<T>(self) -> Result<T, Fault> {
        Err(VOLGRAD_ERROR_KIND.at(self.0, self.1))
    }

    fn range<T>(self) -> Result<T, Fault> {
        Err(VOLGRAD_ERROR_RANGE.at(self.0, self.1))
    }
}

/// Vectors of the host count as unit vectors, and as orthogonal, within this.
const UNIT_TOLERANCE: f64 = 1e-3;

fn not_negative(v: f64) -> bool {
    v >= 0.0
}

fn share(v: f64) -> bool {
    (0.0..=1.0).contains(&v)
}

fn positive(v: f64) -> bool {
    v > 0.0
}

pub fn camera(c: &volgrad_camera, media_count: u32) -> Result<Camera, Fault> {
    if c.kind != VOLGRAD_CAMERA_PINHOLE {
        return Place(c"camera.kind", 0).kind();
    }
    if c.width == 0 || c.height == 0 || c.width > MAX_IMAGE_SIDE || c.height > MAX_IMAGE_SIDE {
        return Place(c"camera.width, camera.height", 0).range();
    }
    if c.crop_x0 >= c.crop_x1 || c.crop_x1 > c.width || c.crop_y0 >= c.crop_y1 || c.crop_y1 > c.height {
        return Place(c"camera.crop_x0 ... camera.crop_y1", 0).range();
    }
    if c.lens_radius != 0.0 {
        return Place(c"camera.lens_radius", 0).range();
    }
    if c.medium != NONE && c.medium >= media_count {
        return Err(VOLGRAD_ERROR_INDEX.at(c"camera.medium", 0));
    }
    let forward = Place(c"camera.forward", 0).unit(c.forward)?;
    let right = Place(c"camera.right", 0).unit(c.right)?;
    let up = Place(c"camera.up", 0).unit(c.up)?;
    let skew = forward.dot(right).abs().max(forward.dot(up).abs()).max(right.dot(up).abs());
    if skew > UNIT_TOLERANCE {
        return Place(c"camera.forward, camera.right, camera.up", 0).range();
    }
    // What single precision lacks in orthogonality is mended.
    let right = (right - forward.dot(right) * forward).normalize();
    let up = (up - forward.dot(up) * forward - right.dot(up) * right).normalize();
    Ok(Camera {
        position: Place(c"camera.position", 0).point(c.position)?,
        forward,
        right,
        up,
        tan_half_fov_x: Place(c"camera.tan_half_fov_x", 0).number(c.tan_half_fov_x, positive)?,
        width: c.width,
        height: c.height,
        crop: [c.crop_x0, c.crop_y0, c.crop_x1, c.crop_y1],
        near_clip: Place(c"camera.near_clip", 0).number(c.near_clip, not_negative)?,
        medium: c.medium,
    })
}

/// Keeps pixel counts within 32 bits.
pub const MAX_IMAGE_SIDE: u32 = 65_535;

pub fn phase(p: &volgrad_phase, place: Place) -> Result<Phase, Fault> {
    match p.kind {
        VOLGRAD_PHASE_ISOTROPIC => Ok(Phase::ISOTROPIC),
        VOLGRAD_PHASE_HENYEY_GREENSTEIN => Ok(Phase { g: place.number(p.g, |g| g > -1.0 && g < 1.0)? }),
        _ => place.kind(),
    }
}

/// The colours and phase function of medium `i`.
pub fn medium(m: &volgrad_medium, i: usize) -> Result<(Colour, Colour, Phase), Fault> {
    if m.kind != VOLGRAD_MEDIUM_CUSTOM && !m.custom.is_null() {
        return Place(c"media: a reserved field", i).range();
    }
    Ok((
        Place(c"media.sigma_t", i).colour(m.sigma_t, not_negative)?,
        Place(c"media.albedo", i).colour(m.albedo, share)?,
        phase(&m.phase, Place(c"media.phase", i))?,
    ))
}

/// Number of samples of a grid, and its size as the core counts.
pub fn grid_size(m: &volgrad_medium, i: usize) -> Result<(usize, [i32; 3]), Fault> {
    let place = Place(c"media.nx, media.ny, media.nz", i);
    let size = [m.nx, m.ny, m.nz];
    if size.iter().any(|n| *n == 0 || *n > MAX_GRID_SIDE) {
        return place.range();
    }
    let samples = size.iter().try_fold(1usize, |product, n| product.checked_mul(*n as usize));
    match samples {
        // Indices inside a grid are products of i32s.
        Some(samples) if samples <= i32::MAX as usize => Ok((samples, size.map(|n| n as i32))),
        _ => place.range(),
    }
}

const MAX_GRID_SIDE: u32 = 1 << 20;

pub fn grid_transform(m: &volgrad_medium, i: usize) -> Result<DAffine3, Fault> {
    let place = Place(c"media.local_to_world", i);
    for value in m.local_to_world {
        place.number(value, |_| true)?;
    }
    let [a, b, c, x, d, e, f, y, g, h, k, z] = m.local_to_world.map(f64::from);
    let matrix3 = DMat3::from_cols(DVec3::new(a, d, g), DVec3::new(b, e, h), DVec3::new(c, f, k));
    let affine = DAffine3 { matrix3, translation: DVec3::new(x, y, z) };
    let inverse = affine.inverse();
    if matrix3.determinant() != 0.0 && inverse.is_finite() { Ok(affine) } else { place.range() }
}

pub fn material(m: &volgrad_material, i: usize) -> Result<Bsdf, Fault> {
    let conductor = [m.conductor_eta.wide(), m.conductor_k.wide()] != [Colour::ZERO; 2];
    if m.flags != 0 || m.roughness != 0.0 || conductor || !m.custom.is_null() {
        return Place(c"materials: a reserved field", i).range();
    }
    let reflectance = || Place(c"materials.reflectance", i).colour(m.reflectance, share);
    match m.kind {
        VOLGRAD_MATERIAL_DIFFUSE => Ok(Bsdf::Diffuse { albedo: reflectance()? }),
        VOLGRAD_MATERIAL_MIRROR => Ok(Bsdf::Mirror { reflectance: reflectance()? }),
        VOLGRAD_MATERIAL_DIELECTRIC => Ok(Bsdf::Dielectric { eta: Place(c"materials.eta", i).number(m.eta, positive)? }),
        _ => Place(c"materials.kind", i).kind(),
    }
}

pub fn light(l: &volgrad_light, i: usize) -> Result<Light, Fault> {
    let image = !l.image.is_null() || l.image_width != 0 || l.image_height != 0;
    if l.flags != 0 || l.cos_inner != 0.0 || l.cos_outer != 0.0 || image || !l.custom.is_null() {
        return Place(c"lights: a reserved field", i).range();
    }
    let emission = Place(c"lights.emission", i).colour(l.emission, not_negative)?;
    let position = || Place(c"lights.position", i).point(l.position);
    let edges = || -> Result<(DVec3, DVec3), Fault> {
        let u = Place(c"lights.edge_u", i).point(l.edge_u)?;
        let v = Place(c"lights.edge_v", i).point(l.edge_v)?;
        if u.cross(v).length_squared() > 0.0 { Ok((u, v)) } else { Place(c"lights.edge_u, lights.edge_v", i).range() }
    };
    match l.kind {
        VOLGRAD_LIGHT_PARALLELOGRAM => {
            let (edge_u, edge_v) = edges()?;
            Ok(Light::Parallelogram { corner: position()?, edge_u, edge_v, radiance: emission })
        }
        VOLGRAD_LIGHT_TRIANGLE => {
            let (edge_u, edge_v) = edges()?;
            Ok(Light::Triangle { corner: position()?, edge_u, edge_v, radiance: emission })
        }
        VOLGRAD_LIGHT_SPHERE => {
            let radius = Place(c"lights.radius", i).number(l.radius, positive)?;
            Ok(Light::Sphere { centre: position()?, radius, radiance: emission })
        }
        VOLGRAD_LIGHT_ENVIRONMENT => Ok(Light::Environment { radiance: emission }),
        VOLGRAD_LIGHT_DIRECTIONAL => {
            Ok(Light::Directional { direction: Place(c"lights.direction", i).unit(l.direction)?, irradiance: emission })
        }
        VOLGRAD_LIGHT_POINT => Ok(Light::Point { position: position()?, intensity: emission }),
        _ => Place(c"lights.kind", i).kind(),
    }
}

/// The weight with which light `i` is picked.
pub fn light_weight(l: &volgrad_light, i: usize) -> Result<f64, Fault> {
    let only_by_choice = matches!(l.kind, VOLGRAD_LIGHT_DIRECTIONAL | VOLGRAD_LIGHT_POINT);
    Place(c"lights.sampling_weight", i).number(l.sampling_weight, |w| if only_by_choice { w > 0.0 } else { w >= 0.0 })
}
