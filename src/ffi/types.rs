//! Plain data that crosses the C boundary: scene descriptions, paths, ray queries.
//!
//! Layouts are frozen per ABI version. Kinds are `u32` and checked where they are read, so that a bad value is a status.
//! Vectors, rays, hits, segments and vertices are the core's own; cbindgen.toml gives them their C names.

use super::callbacks::{volgrad_custom_bsdf, volgrad_custom_light, volgrad_custom_phase};
use crate::math::{Rgb, Vec3};
use crate::medium::Segment;
use crate::path::Vertex;
use crate::scene::{Hit, Ray};
use core::ffi::c_void;

/// Version of the structs and functions below; `volgrad_abi_version()` returns the library's.
pub const VOLGRAD_ABI_VERSION: u32 = 2;

/// "None" wherever an index is expected: no medium (vacuum), no light.
pub const VOLGRAD_NONE: u32 = 0xFFFF_FFFF;

/// `volgrad_vertex.kind`.
pub const VOLGRAD_VERTEX_CAMERA: u32 = 0;
pub const VOLGRAD_VERTEX_MEDIUM: u32 = 1;
pub const VOLGRAD_VERTEX_SURFACE: u32 = 2;
pub const VOLGRAD_VERTEX_LIGHT: u32 = 3;

/// `volgrad_hit.kind`.
pub const VOLGRAD_HIT_NONE: u32 = 0;
pub const VOLGRAD_HIT_SURFACE: u32 = 1;
/// More than `VOLGRAD_MAX_SEGMENTS` media on the way: what the path would have carried beyond is lost, and counted.
pub const VOLGRAD_HIT_OVERFLOW: u32 = 2;

/// `volgrad_hit.medium_outside`, `medium_inside`: the surface does not change the medium.
pub const VOLGRAD_KEEP_MEDIUM: u32 = 0xFFFF_FFFE;

// The header's constants are the core's.
const _: () = {
    use crate::{medium, path, scene};
    assert!(VOLGRAD_NONE == medium::NONE && VOLGRAD_KEEP_MEDIUM == scene::KEEP_MEDIUM);
    assert!(VOLGRAD_VERTEX_CAMERA == path::VERTEX_CAMERA && VOLGRAD_VERTEX_MEDIUM == path::VERTEX_MEDIUM);
    assert!(VOLGRAD_VERTEX_SURFACE == path::VERTEX_SURFACE && VOLGRAD_VERTEX_LIGHT == path::VERTEX_LIGHT);
    assert!(VOLGRAD_HIT_NONE == scene::HIT_NONE && VOLGRAD_HIT_SURFACE == scene::HIT_SURFACE);
    assert!(VOLGRAD_HIT_OVERFLOW == scene::HIT_OVERFLOW);
};

pub const VOLGRAD_CAMERA_PINHOLE: u32 = 0;
pub const VOLGRAD_CAMERA_THIN_LENS: u32 = 1;

/// A camera. The image's x axis is `right`, its first row is at the top (`+up`). The three axes are orthonormal.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct volgrad_camera {
    /// `VOLGRAD_CAMERA_*`.
    pub kind: u32,
    /// Image size, pixels.
    pub width: u32,
    pub height: u32,
    /// The part of the image that is sampled: pixels `crop_x0 <= x < crop_x1`, likewise y. Paths outside it carry nothing.
    pub crop_x0: u32,
    pub crop_y0: u32,
    pub crop_x1: u32,
    pub crop_y1: u32,
    /// Medium around the near plane, an index into `volgrad_scene_desc.media`, or `VOLGRAD_NONE`.
    pub medium: u32,
    /// Centre of projection, or of the lens.
    pub position: Vec3,
    /// Unit viewing direction.
    pub forward: Vec3,
    /// Unit vector towards larger pixel x.
    pub right: Vec3,
    /// Unit vector towards smaller pixel y.
    pub up: Vec3,
    /// Tangent of half the horizontal field of view. Pixels are square.
    pub tan_half_fov_x: f32,
    /// Distance of the near plane along `forward`, world units: nothing before it is seen and no medium before it attenuates. 0: none.
    pub near_clip: f32,
    /// Lens radius, world units: > 0 for a thin lens, 0 for a pinhole. The lens is a disk across `forward`.
    pub lens_radius: f32,
    /// Distance of the plane in focus along `forward`, world units, > 0. Unused by a pinhole.
    pub focal_distance: f32,
}

pub const VOLGRAD_PHASE_ISOTROPIC: u32 = 0;
pub const VOLGRAD_PHASE_HENYEY_GREENSTEIN: u32 = 1;
/// Of media only: what the host computes.
pub const VOLGRAD_PHASE_CUSTOM: u32 = 2;

/// A phase function, normalised to 1 over the sphere.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct volgrad_phase {
    /// `VOLGRAD_PHASE_*`.
    pub kind: u32,
    /// Mean cosine, -1 < g < 1; forward scattering is positive. Unused by isotropic and custom.
    pub g: f32,
}

pub const VOLGRAD_MEDIUM_HOMOGENEOUS: u32 = 0;
pub const VOLGRAD_MEDIUM_GRID: u32 = 1;
pub const VOLGRAD_MEDIUM_CUSTOM: u32 = 2;
pub const VOLGRAD_MEDIUM_SPARSE_GRID: u32 = 3;

/// Cells along a side of a sparse grid's brick, and samples of a block: (`VOLGRAD_BRICK_SIDE` + 1)^3.
pub const VOLGRAD_BRICK_SIDE: u32 = 8;
pub const VOLGRAD_BLOCK_SAMPLES: u32 = 729;

const _: () = {
    use crate::medium::{BLOCK_SAMPLES, BRICK_SIDE};
    assert!(VOLGRAD_BRICK_SIDE == BRICK_SIDE as u32 && VOLGRAD_BLOCK_SAMPLES == BLOCK_SAMPLES as u32);
};

/// The samples of a sparse grid. They mean what those of a grid of nx*ny*nz samples mean, and give the same results bit for bit; but only
/// one block is stored of all bricks that are alike, those without any density above all.
///
/// Brick (i, j, k), i < (nx + 8)/8, j < (ny + 8)/8, k < (nz + 8)/8 (rounded down), is the cells between samples 8 i - 1 and 8 i + 7 along x,
/// likewise y and z. Its block holds these 9*9*9 samples, x fastest; a sample that would be outside the grid is the nearest one inside.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_sparse_grid {
    /// `sizeof(volgrad_sparse_grid)` of the caller.
    pub struct_size: u32,
    pub block_count: u32,
    /// For each brick, x fastest, the number of its block, below block_count. Borrowed: must outlive the scene.
    pub blocks: *const u32,
    /// block_count blocks of `VOLGRAD_BLOCK_SAMPLES` densities, finite, not negative. Blocks of neighbours share a layer of samples,
    /// which have to be equal. Borrowed: must outlive the scene.
    pub density: *const f32,
}

/// A participating medium: extinction `sigma_t * density(x)`, scattering `albedo *` that.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_medium {
    /// `VOLGRAD_MEDIUM_*`.
    pub kind: u32,
    pub phase: volgrad_phase,
    /// Extinction at density 1, 1/world unit, not negative. The density of a homogeneous medium is 1.
    pub sigma_t: Rgb,
    /// Single-scattering albedo, in [0, 1].
    pub albedo: Rgb,
    /// Index into `volgrad_scene_desc.phases`; read if `phase.kind` is `VOLGRAD_PHASE_CUSTOM`.
    pub custom_phase: u32,
    /// Grid: nx*ny*nz densities, not negative, x fastest; sample (i, j, k) lies at ((i+.5)/nx, (j+.5)/ny, (k+.5)/nz) of the
    /// unit cube; trilinear between samples, constant in the outermost half cells, 0 outside the cube.
    /// Borrowed: must outlive the scene. NULL for other kinds.
    pub density: *const f32,
    /// Grid and sparse grid: samples along each axis, 1 ... 2^20; less than 2^31 samples, or bricks of a sparse grid.
    pub nx: u32,
    pub ny: u32,
    pub nz: u32,
    /// Grid, sparse grid and custom: affine map of the unit cube to the world, 3 rows of 4 (row-major, translation last); invertible.
    pub local_to_world: [f32; 12],
    /// Custom: a `volgrad_custom_density`, read by `volgrad_scene_init`. Sparse grid: a `volgrad_sparse_grid`, likewise; what that points to is
    /// borrowed: must outlive the scene. NULL for other kinds.
    pub custom: *const c_void,
}

pub const VOLGRAD_MATERIAL_DIFFUSE: u32 = 0;
pub const VOLGRAD_MATERIAL_MIRROR: u32 = 1;
pub const VOLGRAD_MATERIAL_DIELECTRIC: u32 = 2;
pub const VOLGRAD_MATERIAL_CONDUCTOR: u32 = 3;
pub const VOLGRAD_MATERIAL_CUSTOM: u32 = 4;

/// `volgrad_material.flags`: a surface that is not dielectric scatters alike on both sides.
pub const VOLGRAD_MATERIAL_TWO_SIDED: u32 = 1;

/// A surface's BSDF. All but dielectrics, and custom ones that transmit, are one-sided, unless `flags` says otherwise: black from behind
/// (against the geometric normal).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_material {
    /// `VOLGRAD_MATERIAL_*`.
    pub kind: u32,
    /// `VOLGRAD_MATERIAL_TWO_SIDED` or 0.
    pub flags: u32,
    /// Diffuse: albedo. Mirror: reflectance at all angles. Conductor: factor on its Fresnel reflectance, usually 1. In [0, 1].
    pub reflectance: Rgb,
    /// Dielectric: index of refraction inside over outside; the normal points outside. > 0.
    pub eta: f32,
    /// Dielectric, conductor: alpha of the isotropic GGX distribution of microfacet normals, >= 1e-4; or 0, a smooth surface. A rough
    /// dielectric's eta is not 1.
    pub roughness: f32,
    /// Conductor: complex index of refraction eta + i k over that outside, per channel; >= 0.
    pub conductor_eta: Rgb,
    pub conductor_k: Rgb,
    /// Custom: the BSDF; read by `volgrad_scene_init`. NULL for other kinds.
    pub custom: *const volgrad_custom_bsdf,
}

pub const VOLGRAD_LIGHT_PARALLELOGRAM: u32 = 0;
pub const VOLGRAD_LIGHT_TRIANGLE: u32 = 1;
pub const VOLGRAD_LIGHT_SPHERE: u32 = 2;
pub const VOLGRAD_LIGHT_ENVIRONMENT: u32 = 3;
pub const VOLGRAD_LIGHT_DIRECTIONAL: u32 = 4;
pub const VOLGRAD_LIGHT_POINT: u32 = 5;
pub const VOLGRAD_LIGHT_SPOT: u32 = 6;
pub const VOLGRAD_LIGHT_ENVIRONMENT_MAP: u32 = 7;
/// Radiance from infinitely far away, as the host computes it.
pub const VOLGRAD_LIGHT_CUSTOM_SKY: u32 = 8;
/// A point light whose profile the host computes.
pub const VOLGRAD_LIGHT_CUSTOM_POINT: u32 = 9;

/// A light. Area lights emit from the side that their normal points to, and are opaque surfaces that the host's ray queries return.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_light {
    /// `VOLGRAD_LIGHT_*`.
    pub kind: u32,
    /// Medium in front of an area light, around a point or spot light: an index into `volgrad_scene_desc.media`, or `VOLGRAD_NONE`.
    /// Subpaths from the light start in it; an area light must not cross a medium's boundary. Unused by lights at infinity.
    pub medium: u32,
    /// Area and environment: radiance. Directional: irradiance on a plane across its direction. Point and spot: intensity, a spot's within
    /// its inner cone. Environment map: factor on its image. Custom: factor on what the host computes. Not negative.
    pub emission: Rgb,
    /// Relative probability of being picked for next-event estimation; 1 is usual. >= 0, and > 0 for directional, point and spot
    /// lights, custom ones too, which nothing else can find. All weights are divided by their sum. That of a constant environment counts only if no other
    /// light has one: paths that go on find the sky as well.
    pub sampling_weight: f32,
    /// Parallelogram, triangle: a corner. Sphere: centre. Point, custom or not, and spot: position.
    pub position: Vec3,
    /// Parallelogram, triangle: edges from that corner. The normal is edge_u x edge_v, normalised.
    /// Environment map: its x and y axes in the world; y is up.
    pub edge_u: Vec3,
    pub edge_v: Vec3,
    /// Sphere: radius; its normal points outwards.
    pub radius: f32,
    /// Directional: unit direction in which the light travels. Spot: unit direction of its axis. Environment map: its z axis in the world;
    /// the three are orthonormal, (1,0,0), (0,1,0), (0,0,1) if nothing is turned.
    pub direction: Vec3,
    /// Spot: cosines of two cones' half angles, -1 <= cos_outer <= cos_inner <= 1: all of the intensity within the inner one, nothing
    /// outside the outer one, between them falling off linearly in the angle.
    pub cos_inner: f32,
    pub cos_outer: f32,
    /// Environment map: image_width * image_height linear RGB radiances, not negative, from the first row on; longitude by latitude,
    /// interpolated bilinearly. Texel i of a row lies at longitude (i + .5)/image_width of a turn from -z by +x, z and -x; the
    /// first row is the up pole, the last the down pole, so image_height >= 2. Borrowed: must outlive the scene. NULL for other kinds.
    pub image: *const f32,
    pub image_width: u32,
    pub image_height: u32,
    /// Custom: the light; read by `volgrad_scene_init`. NULL for other kinds.
    pub custom: *const volgrad_custom_light,
}

/// Everything of a scene but its geometry, which stays with the host. Arrays are read by `volgrad_scene_init` and may be freed
/// after it, and so may tables of callbacks; density grids and environment maps are borrowed, and what `user` points to.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_scene_desc {
    /// `sizeof(volgrad_scene_desc)` of the caller.
    pub struct_size: u32,
    pub media_count: u32,
    pub material_count: u32,
    pub light_count: u32,
    pub camera: volgrad_camera,
    pub media: *const volgrad_medium,
    pub materials: *const volgrad_material,
    /// At most one of kind `VOLGRAD_LIGHT_ENVIRONMENT`, `VOLGRAD_LIGHT_ENVIRONMENT_MAP` or `VOLGRAD_LIGHT_CUSTOM_SKY`.
    pub lights: *const volgrad_light,
    /// A sphere around all surfaces, null ones included; its radius in world units, >= 0. Radius 0: unknown; then light subpaths
    /// start from no light at infinity.
    pub bounds_centre: Vec3,
    pub bounds_radius: f32,
    /// `phase_count` phase functions of media, each read by `volgrad_scene_init`; none if the struct ends before.
    pub phases: *const *const volgrad_custom_phase,
    pub phase_count: u32,
    pub reserved: u32,
}

/// A light path `x_0 ... x_k`, from the camera to a light. Null (index-matched) surfaces are no vertices.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_path {
    /// `vertex_count` vertices, at least 2.
    pub vertices: *const Vertex,
    /// The media along all edges, edge after edge in the order of the path; each edge has at least one.
    pub segments: *const Segment,
    /// For each of the `vertex_count - 1` edges (edge i goes from vertex i to vertex i + 1): the index in `segments` past its last.
    pub edge_ends: *const u32,
    pub vertex_count: u32,
    pub segment_count: u32,
}

/// Answers `count` rays; `hits` come uninitialised. Returns 0, or another value to stop the running call, which then returns
/// `VOLGRAD_ERROR_CALLBACK`. Must not throw or longjmp. Called on the thread that called volgrad.
pub type volgrad_query_fn =
    Option<unsafe extern "C" fn(user: *mut c_void, rays: *const Ray, hits: *mut Hit, count: u32) -> i32>;

/// How volgrad asks the host about its geometry. Index-matched (null) surfaces are never hits: they end segments.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct volgrad_queries {
    /// `sizeof(volgrad_queries)` of the caller.
    pub struct_size: u32,
    pub reserved: u32,
    /// Passed back as the callbacks' first argument.
    pub user: *mut c_void,
    /// The nearest surface in [t_min, t_max), and the media up to it (or up to t_max).
    pub intersect: volgrad_query_fn,
    /// Whether any surface is in [t_min, t_max), and if none, the media up to t_max.
    pub occluded: volgrad_query_fn,
}

// Frozen per ABI version; tests/c/layout_test.c asserts the same in C.
#[cfg(target_pointer_width = "64")]
const _: () = {
    assert!(size_of::<Vec3>() == 12 && size_of::<Rgb>() == 12 && size_of::<Segment>() == 20);
    assert!(size_of::<Vertex>() == 56 && size_of::<Ray>() == 36 && size_of::<Hit>() == 384);
    assert!(size_of::<volgrad_camera>() == 96 && size_of::<volgrad_phase>() == 8 && size_of::<volgrad_medium>() == 120);
    assert!(size_of::<volgrad_sparse_grid>() == 24);
    assert!(size_of::<volgrad_scene_desc>() == 168);
    assert!(size_of::<volgrad_material>() == 64 && size_of::<volgrad_light>() == 112 && size_of::<volgrad_path>() == 32);
};
