//! From the header's descriptions to the core's types, with every range checked.

use super::status::{Fault, volgrad_status::*};
use super::types::*;
use crate::math::{Colour, DAffine3, DMat3, DVec3, Rgb, UNIT_TOLERANCE, Vec3, is_unit};
use crate::medium::NONE;
use crate::phase::Phase;
use crate::scene::{
    Bounds, Bsdf, Camera, Conductor, EnvironmentMap, Falloff, Ggx, Light, Reflector, RoughConductor, RoughDielectric,
};
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

    pub fn colour(self, value: Rgb, ok: impl Fn(f64) -> bool) -> Result<Colour, Fault> {
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
        if is_unit(v) { Ok(v.normalize()) } else { Err(VOLGRAD_ERROR_NOT_FINITE.at(self.0, self.1)) }
    }

    /// A field that has no meaning yet.
    pub fn reserved(self, value: u32) -> Result<(), Fault> {
        if value == 0 { Ok(()) } else { self.range() }
    }

    fn kind<T>(self) -> Result<T, Fault> {
        Err(VOLGRAD_ERROR_KIND.at(self.0, self.1))
    }

    fn range<T>(self) -> Result<T, Fault> {
        Err(VOLGRAD_ERROR_RANGE.at(self.0, self.1))
    }
}

pub fn not_negative(v: f64) -> bool {
    v >= 0.0
}

fn share(v: f64) -> bool {
    (0.0..=1.0).contains(&v)
}

fn positive(v: f64) -> bool {
    v > 0.0
}

pub fn camera(c: &volgrad_camera, media_count: u32) -> Result<Camera, Fault> {
    let (lens_radius, focal_distance) = lens(c)?;
    if c.width == 0 || c.height == 0 || c.width > MAX_IMAGE_SIDE || c.height > MAX_IMAGE_SIDE {
        return Place(c"camera.width, camera.height", 0).range();
    }
    if c.crop_x0 >= c.crop_x1 || c.crop_x1 > c.width || c.crop_y0 >= c.crop_y1 || c.crop_y1 > c.height {
        return Place(c"camera.crop_x0 ... camera.crop_y1", 0).range();
    }
    if c.medium != NONE && c.medium >= media_count {
        return Err(VOLGRAD_ERROR_INDEX.at(c"camera.medium", 0));
    }
    let forward = Place(c"camera.forward", 0).unit(c.forward)?;
    let right = Place(c"camera.right", 0).unit(c.right)?;
    let up = Place(c"camera.up", 0).unit(c.up)?;
    let axes = orthonormal(forward, right, up);
    let [forward, right, up] = axes.ok_or(VOLGRAD_ERROR_RANGE.at(c"camera.forward, camera.right, camera.up", 0))?;
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
        lens_radius,
        focal_distance,
    })
}

/// Radius and focal distance.
fn lens(c: &volgrad_camera) -> Result<(f64, f64), Fault> {
    let radius = Place(c"camera.lens_radius", 0);
    match c.kind {
        VOLGRAD_CAMERA_PINHOLE => Ok((radius.number(c.lens_radius, |r| r == 0.0)?, 1.0)),
        VOLGRAD_CAMERA_THIN_LENS => {
            let focal_distance = Place(c"camera.focal_distance", 0).number(c.focal_distance, positive)?;
            Ok((radius.number(c.lens_radius, positive)?, focal_distance))
        }
        _ => Place(c"camera.kind", 0).kind(),
    }
}

/// Keeps pixel counts within 32 bits.
pub const MAX_IMAGE_SIDE: u32 = 65_535;

/// A built-in one.
pub fn phase(p: &volgrad_phase, place: Place) -> Result<Phase, Fault> {
    match p.kind {
        VOLGRAD_PHASE_ISOTROPIC => Ok(Phase::ISOTROPIC),
        VOLGRAD_PHASE_HENYEY_GREENSTEIN => Ok(Phase::henyey_greenstein(place.number(p.g, |g| g > -1.0 && g < 1.0)?)),
        _ => place.kind(),
    }
}

/// The colours of medium `i`.
pub fn medium(m: &volgrad_medium, i: usize) -> Result<(Colour, Colour), Fault> {
    if !matches!(m.kind, VOLGRAD_MEDIUM_CUSTOM | VOLGRAD_MEDIUM_SPARSE_GRID) && !m.custom.is_null() {
        return Place(c"media.custom", i).range();
    }
    Ok((Place(c"media.sigma_t", i).colour(m.sigma_t, not_negative)?, Place(c"media.albedo", i).colour(m.albedo, share)?))
}

/// Samples of a grid along each axis, as the core counts.
pub fn grid_size(m: &volgrad_medium, i: usize) -> Result<[i32; 3], Fault> {
    let size = [m.nx, m.ny, m.nz];
    if size.iter().any(|n| *n == 0 || *n > MAX_GRID_SIDE) {
        return Place(c"media.nx, media.ny, media.nz", i).range();
    }
    Ok(size.map(|n| n as i32))
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

pub fn material(m: &volgrad_material, i: usize) -> Result<Bsdf<'static>, Fault> {
    if !m.custom.is_null() {
        return Place(c"materials.custom", i).range();
    }
    if m.flags & !VOLGRAD_MATERIAL_TWO_SIDED != 0 {
        return Place(c"materials.flags", i).kind();
    }
    if m.kind == VOLGRAD_MATERIAL_DIELECTRIC {
        return dielectric(m, i);
    }
    let reflector = reflector(m, i)?;
    Ok(if m.flags == VOLGRAD_MATERIAL_TWO_SIDED { Bsdf::TwoSided(reflector) } else { reflector.into() })
}

fn reflector(m: &volgrad_material, i: usize) -> Result<Reflector<'static>, Fault> {
    let reflectance = || Place(c"materials.reflectance", i).colour(m.reflectance, share);
    match m.kind {
        VOLGRAD_MATERIAL_DIFFUSE => Ok(Reflector::Diffuse { albedo: reflectance()? }),
        VOLGRAD_MATERIAL_MIRROR => Ok(Reflector::Mirror { reflectance: reflectance()? }),
        VOLGRAD_MATERIAL_CONDUCTOR => {
            let eta = Place(c"materials.conductor_eta", i).colour(m.conductor_eta, not_negative)?;
            let k = Place(c"materials.conductor_k", i).colour(m.conductor_k, not_negative)?;
            let conductor = Conductor { eta, k, reflectance: reflectance()? };
            Ok(match roughness(m, i)? {
                Some(ggx) => Reflector::RoughConductor(RoughConductor { conductor, ggx }),
                None => Reflector::Conductor(conductor),
            })
        }
        _ => Place(c"materials.kind", i).kind(),
    }
}

fn dielectric(m: &volgrad_material, i: usize) -> Result<Bsdf<'static>, Fault> {
    let place = Place(c"materials.eta", i);
    match roughness(m, i)? {
        Some(ggx) => {
            let eta = place.number(m.eta, |eta| eta > 0.0 && eta != 1.0)?;
            Ok(Bsdf::RoughDielectric(RoughDielectric { eta, ggx }))
        }
        None => Ok(Bsdf::Dielectric { eta: place.number(m.eta, positive)? }),
    }
}

/// None: a smooth surface.
fn roughness(m: &volgrad_material, i: usize) -> Result<Option<Ggx>, Fault> {
    let allowed = |alpha: f64| alpha == 0.0 || alpha >= LEAST_ROUGHNESS;
    let alpha = Place(c"materials.roughness", i).number(m.roughness, allowed)?;
    Ok((alpha > 0.0).then_some(Ggx { alpha }))
}

/// Below it, f_r is too high and narrow for the single precision of hits; Mitsuba 3 has the same bound.
const LEAST_ROUGHNESS: f64 = 1e-4_f32 as f64;

/// A light; `map` makes the map of an environment map from its orientation and scale.
pub fn light<'a>(
    l: &volgrad_light,
    i: usize,
    map: impl FnOnce(DMat3, Colour) -> Result<EnvironmentMap<'a>, Fault>,
) -> Result<Light<'a>, Fault> {
    if !l.custom.is_null() {
        return Place(c"lights.custom", i).range();
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
        VOLGRAD_LIGHT_SPOT => {
            let axis = Place(c"lights.direction", i).unit(l.direction)?;
            Ok(Light::Spot { position: position()?, axis, intensity: emission, falloff: falloff(l, i)? })
        }
        VOLGRAD_LIGHT_ENVIRONMENT_MAP => Ok(Light::EnvironmentMap(map(orientation(l, i)?, emission)?)),
        _ => Place(c"lights.kind", i).kind(),
    }
}

/// The medium that subpaths from light `i` start in.
pub fn light_medium(l: &volgrad_light, i: usize, media_count: u32) -> Result<u32, Fault> {
    let is_environment = matches!(l.kind, VOLGRAD_LIGHT_ENVIRONMENT | VOLGRAD_LIGHT_ENVIRONMENT_MAP | VOLGRAD_LIGHT_CUSTOM_SKY);
    let is_far = is_environment || l.kind == VOLGRAD_LIGHT_DIRECTIONAL;
    match l.medium {
        _ if is_far => Ok(NONE),
        medium if medium == NONE || medium < media_count => Ok(medium),
        _ => Err(VOLGRAD_ERROR_INDEX.at(c"lights.medium", i)),
    }
}

pub fn bounds(centre: Vec3, radius: f32) -> Result<Bounds, Fault> {
    Ok(Bounds {
        centre: Place(c"bounds_centre", 0).point(centre)?,
        radius: Place(c"bounds_radius", 0).number(radius, not_negative)?,
    })
}

fn falloff(l: &volgrad_light, i: usize) -> Result<Falloff, Fault> {
    let cos_inner = Place(c"lights.cos_inner", i).number(l.cos_inner, |c| c.abs() <= 1.0)?;
    let cos_outer = Place(c"lights.cos_outer", i).number(l.cos_outer, |c| (-1.0..=cos_inner).contains(&c))?;
    Ok(Falloff::new(cos_inner, cos_outer))
}

/// From an environment map's axes to the world's.
fn orientation(l: &volgrad_light, i: usize) -> Result<DMat3, Fault> {
    let z = Place(c"lights.direction", i).unit(l.direction)?;
    let x = Place(c"lights.edge_u", i).unit(l.edge_u)?;
    let y = Place(c"lights.edge_v", i).unit(l.edge_v)?;
    let [z, x, y] = orthonormal(z, x, y).ok_or(VOLGRAD_ERROR_RANGE.at(c"lights.edge_u, lights.edge_v, lights.direction", i))?;
    Ok(DMat3::from_cols(x, y, z))
}

/// Number of texels of an environment map; 0 for other lights.
pub fn texel_count(l: &volgrad_light, i: usize) -> Result<usize, Fault> {
    let side = |n: u32, least: u32| (least..=MAX_IMAGE_SIDE).contains(&n);
    match l.kind {
        VOLGRAD_LIGHT_ENVIRONMENT_MAP if side(l.image_width, 1) && side(l.image_height, 2) => {
            Ok(l.image_width as usize * l.image_height as usize)
        }
        VOLGRAD_LIGHT_ENVIRONMENT_MAP => Place(c"lights.image_width, lights.image_height", i).range(),
        _ => Ok(0),
    }
}

/// Three unit vectors with what single precision lacks in orthogonality mended; None if it is more than that.
fn orthonormal(a: DVec3, b: DVec3, c: DVec3) -> Option<[DVec3; 3]> {
    let skew = a.dot(b).abs().max(a.dot(c).abs()).max(b.dot(c).abs());
    let b = (b - a.dot(b) * a).normalize();
    let c = (c - a.dot(c) * a - b.dot(c) * b).normalize();
    (skew <= UNIT_TOLERANCE).then_some([a, b, c])
}

/// The weight with which light `i` is picked.
pub fn light_weight(l: &volgrad_light, i: usize) -> Result<f64, Fault> {
    let only_by_choice =
        matches!(l.kind, VOLGRAD_LIGHT_DIRECTIONAL | VOLGRAD_LIGHT_POINT | VOLGRAD_LIGHT_SPOT | VOLGRAD_LIGHT_CUSTOM_POINT);
    Place(c"lights.sampling_weight", i).number(l.sampling_weight, |w| if only_by_choice { w > 0.0 } else { w >= 0.0 })
}
