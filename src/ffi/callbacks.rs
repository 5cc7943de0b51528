//! Tables of functions by which a host computes its own densities, materials, phase functions and lights.
//!
//! Their layouts may grow at the end: struct_size tells.

use crate::math::{Rgb, Vec3};
use core::ffi::c_void;

/// Computes the densities at `count` points (world units). Must not throw or longjmp; is called by all threads that use the scene,
/// several at a time; the same point always has the same density. Values that are NaN, infinite or negative count
/// as 0, and are counted: `volgrad_scene_dropped_densities`.
pub type volgrad_density_fn =
    Option<unsafe extern "C" fn(user: *mut c_void, points: *const Vec3, densities: *mut f32, count: u32)>;

/// Computes the gradients of the density, 1/world unit, at `count` points. As `volgrad_density_fn` otherwise.
pub type volgrad_density_gradient_fn =
    Option<unsafe extern "C" fn(user: *mut c_void, points: *const Vec3, gradients: *mut Vec3, count: u32)>;

/// A part of a line: the points origin + t * direction from `start` to `end`, world units. `direction` has unit length.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_stretch {
    pub origin: [f64; 3],
    pub direction: [f64; 3],
    pub start: f64,
    pub end: f64,
}

/// Integrals over t along a stretch.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct volgrad_density_integrals {
    /// Of the density, >= 0.
    pub density: f64,
    /// Of its gradient, and of t times its gradient.
    pub gradient: [f64; 3],
    pub moment: [f64; 3],
}

/// Computes exact integrals of the density along a stretch inside the box, in double precision; `*integrals` comes as 0. What the density
/// jumps by at the box's faces is no part of them. `gradients` 0: only that of the density is needed. As `volgrad_density_fn` otherwise.
pub type volgrad_density_integrals_fn = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        stretch: *const volgrad_stretch,
        gradients: i32,
        integrals: *mut volgrad_density_integrals,
    ),
>;

/// A density that the host computes, inside the box that is the unit cube under the medium's `local_to_world`; 0 outside.
///
/// Without `integrals` the optical depth is that of a piecewise linear density: a line's way through the box is cut into equal panels no longer than `step`,
/// and the density counts as linear in each. tau is off by at most step^2/12 times the integral of |second derivative|, its
/// gradient by the same order; a jump inside the box costs about step times the jump. tau is the same from both ends of a
/// line, adds up where the line is divided, and distances are sampled from it exactly. Choose a step that no feature is thinner than.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_custom_density {
    /// `sizeof(volgrad_custom_density)` of the caller.
    pub struct_size: u32,
    pub reserved: u32,
    /// Passed back as the callbacks' first argument. Must outlive the scene.
    pub user: *mut c_void,
    pub density: volgrad_density_fn,
    pub gradient: volgrad_density_gradient_fn,
    /// World units, > 0; not below about a millionth of the box. Unused with `integrals`.
    pub step: f32,
    /// At least as large as every density in the box. Only ratio tracking uses it.
    pub majorant: f32,
    /// May be NULL, and is if the struct ends before. With it the optical depth is exact, and distances are found by Newton's method: some
    /// five calls for each.
    pub integrals: volgrad_density_integrals_fn,
}

/// `volgrad_custom_bsdf.flags`: light passes to the other side.
pub const VOLGRAD_BSDF_TRANSMITS: u32 = 1;

/// `volgrad_custom_bsdf.flags`: f_r is the same for all pairs of directions on the side of the normal, and 0 otherwise, like that of a diffuse
/// surface with a texture, and at most 1/pi. Only `eval` is called then, with (0, 0, 1) for both directions; the other functions may be NULL,
/// and are not called if they are not. Shifted paths connect to such surfaces, and to no other custom ones. The material may be
/// `VOLGRAD_MATERIAL_TWO_SIDED`.
pub const VOLGRAD_BSDF_LAMBERTIAN: u32 = 2;

/// A point of a surface, as the functions of a `volgrad_custom_bsdf` see it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_surface_point {
    /// `volgrad_hit.user` of the hit, or `volgrad_vertex.user` of the path's vertex, that led here.
    pub user: u64,
    /// World position, off the surface by rounding. The modes LINEAR_DEPTH and TWO_LEVEL also ask anywhere in the tangent plane of the point that
    /// `user` is of: clamp or wrap what you look up.
    pub position: Vec3,
    /// The frame in which directions are given, as unit vectors in the world. `z` is the surface's normal, turned to the side of `to_camera` if
    /// the material is `VOLGRAD_MATERIAL_TWO_SIDED`. `x` and `y` are any two axes across it, z = x cross y, and not continuous along a surface: for
    /// a grain, bring a tangent of yours into the frame by its dot products with the three.
    pub x: Vec3,
    pub y: Vec3,
    pub z: Vec3,
}

/// Computes f_r, 1/sr, per channel, without the cosine: of light that comes from the direction `to_light` and goes to `to_camera`, at a point.
/// `*value` comes as 0. f_r is the same with the two exchanged, except that refraction scales it: see `volgrad_custom_bsdf`.
pub type volgrad_bsdf_eval_fn = Option<
    unsafe extern "C" fn(user: *mut c_void, at: *const volgrad_surface_point, to_camera: Vec3, to_light: Vec3, value: *mut Rgb),
>;

/// Returns the density, 1/sr, with which the sample function makes `to_light`: positive wherever f_r is, and exact, or images are biased.
pub type volgrad_bsdf_pdf_fn =
    Option<unsafe extern "C" fn(user: *mut c_void, at: *const volgrad_surface_point, to_camera: Vec3, to_light: Vec3) -> f32>;

/// Makes a direction `*to_light` of unit length from three uniform numbers `u[3]` in (0, 1), and nothing else: the same numbers make the
/// same direction. `*eta_squared` comes as 1; if the direction is a refracted one, it becomes the square of (index of refraction on its
/// side over that on the side of `to_camera`). Returns 1, or 0 if nothing is scattered.
pub type volgrad_bsdf_sample_fn = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        at: *const volgrad_surface_point,
        to_camera: Vec3,
        u: *const f64,
        to_light: *mut Vec3,
        eta_squared: *mut f32,
    ) -> i32,
>;

/// Computes the derivatives of log f_r by the components of `to_camera` and of `to_light`, per channel: `by_camera[3]`, `by_light[3]`, which
/// come as 0. Parts along the directions themselves do not matter. Called where f_r > 0.
pub type volgrad_bsdf_gradient_fn = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        at: *const volgrad_surface_point,
        to_camera: Vec3,
        to_light: Vec3,
        by_camera: *mut Vec3,
        by_light: *mut Vec3,
    ),
>;

/// A BSDF that the host computes (`VOLGRAD_MATERIAL_CUSTOM`). Directions are unit vectors away from the surface, in the point's frame
/// (`volgrad_surface_point`). Both have z > 0, unless it transmits.
///
/// It is a function of the point and the directions alone, and not specular. Where light is refracted, f_r is that of radiance: smaller by
/// eta_squared on the way in, f_r(a, b)/f_r(b, a) = (index of refraction on b's side over that on a's)^-2.
///
/// The functions must not throw or longjmp; they are called by all threads that use the scene, several at a time; the same arguments
/// always have the same result. Values that are NaN, infinite or negative count as 0, and are counted: `volgrad_scene_dropped_values`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_custom_bsdf {
    /// `sizeof(volgrad_custom_bsdf)` of the caller.
    pub struct_size: u32,
    /// `VOLGRAD_BSDF_TRANSMITS`, `VOLGRAD_BSDF_LAMBERTIAN` or 0. A material that transmits is not `VOLGRAD_MATERIAL_TWO_SIDED`.
    pub flags: u32,
    /// Passed back as the functions' first argument. Must outlive the scene.
    pub user: *mut c_void,
    pub eval: volgrad_bsdf_eval_fn,
    pub pdf: volgrad_bsdf_pdf_fn,
    pub sample: volgrad_bsdf_sample_fn,
    /// May be NULL. Only the gradients of a path need it, where a vertex beside one on this material moves, unless that is Lambertian: they say
    /// `VOLGRAD_ERROR_NO_GRADIENT` then. No mode of shifts does.
    pub log_gradient: volgrad_bsdf_gradient_fn,
}

/// Returns the phase function's value, 1/sr, at `mu`, the cosine of the angle by which light is deflected: 1 is straight on. Its integral
/// over the sphere, 2 pi times that over mu, is 1.
pub type volgrad_phase_eval_fn = Option<unsafe extern "C" fn(user: *mut c_void, mu: f64) -> f64>;

/// Returns a cosine mu in [-1, 1] from a uniform number `u` in (0, 1), and nothing else. Its density is 2 pi times the value, exactly, or
/// images are biased.
pub type volgrad_phase_sample_fn = Option<unsafe extern "C" fn(user: *mut c_void, u: f64) -> f64>;

/// Returns the derivative of the value's logarithm by mu.
pub type volgrad_phase_log_derivative_fn = Option<unsafe extern "C" fn(user: *mut c_void, mu: f64) -> f64>;

/// A phase function that the host computes (`VOLGRAD_PHASE_CUSTOM`): of the angle of deflection alone. Threads, and values that are none,
/// as for `volgrad_custom_bsdf`; where no cosine comes back the path ends.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_custom_phase {
    /// `sizeof(volgrad_custom_phase)` of the caller.
    pub struct_size: u32,
    pub reserved: u32,
    /// Passed back as the functions' first argument. Must outlive the scene.
    pub user: *mut c_void,
    pub eval: volgrad_phase_eval_fn,
    pub sample: volgrad_phase_sample_fn,
    /// May be NULL. Gradients of paths, and batches of the modes FIRST_ORDER, HALF_ORDER, LOG_LINEAR and THESIS need it: they say
    /// `VOLGRAD_ERROR_NO_GRADIENT` then. All other modes do without.
    pub log_derivative: volgrad_phase_log_derivative_fn,
}

/// Computes what a light emits, which is not negative: a sky's radiance from the unit vector `direction` towards it; a point light's intensity
/// along the unit vector `direction` away from it. World axes. `*value` comes as 0.
pub type volgrad_light_emission_fn = Option<unsafe extern "C" fn(user: *mut c_void, direction: Vec3, value: *mut Rgb)>;

/// Returns the density, 1/sr, with which the sample function makes the direction `to_sky`: positive wherever the radiance is, and exact, or
/// images are biased.
pub type volgrad_light_pdf_fn = Option<unsafe extern "C" fn(user: *mut c_void, to_sky: Vec3) -> f32>;

/// Makes a direction `*to_sky` of unit length from two uniform numbers `u[2]` in (0, 1), and nothing else. Returns 1, or 0 if the sky is black.
pub type volgrad_light_sample_fn = Option<unsafe extern "C" fn(user: *mut c_void, u: *const f64, to_sky: *mut Vec3) -> i32>;

/// Computes the derivatives of the logarithm of a point light's intensity by the components of `direction`, per channel, `gradient[3]`, which
/// comes as 0. The part along the direction itself does not matter. Called where the intensity is > 0.
pub type volgrad_light_gradient_fn = Option<unsafe extern "C" fn(user: *mut c_void, direction: Vec3, gradient: *mut Vec3)>;

/// A light that the host computes: `VOLGRAD_LIGHT_CUSTOM_SKY`, `VOLGRAD_LIGHT_CUSTOM_POINT`. Threads, and values that are none, as for
/// `volgrad_custom_bsdf`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_custom_light {
    /// `sizeof(volgrad_custom_light)` of the caller.
    pub struct_size: u32,
    pub reserved: u32,
    /// Passed back as the functions' first argument. Must outlive the scene.
    pub user: *mut c_void,
    pub emission: volgrad_light_emission_fn,
    /// Sky: both. Point: unused, its subpaths leave it in all directions alike (and guided ones where they carry most).
    pub pdf: volgrad_light_pdf_fn,
    pub sample: volgrad_light_sample_fn,
    /// Point; may be NULL. Only the gradients of a path need it, of a vertex beside the light: they say `VOLGRAD_ERROR_NO_GRADIENT` then. No
    /// mode of shifts does.
    pub log_gradient: volgrad_light_gradient_fn,
}

#[cfg(target_pointer_width = "64")]
const _: () = {
    assert!(size_of::<volgrad_custom_bsdf>() == 48 && size_of::<volgrad_custom_phase>() == 40);
    assert!(size_of::<volgrad_custom_light>() == 48 && size_of::<volgrad_custom_density>() == 48);
};
