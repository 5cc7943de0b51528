//! Scenes: checked once, converted into memory of the caller, then shared by any number of threads.

use super::callbacks::{volgrad_custom_bsdf, volgrad_custom_density, volgrad_custom_light, volgrad_custom_phase};
use super::convert::{self, MAX_IMAGE_SIDE, Place, not_negative};
use super::custom::{Host, Hosts};
use super::grids;
use super::pointer::{array, check, output, reference, sized_since, write_sized};
use super::status::{Fault, finish, volgrad_error, volgrad_status, volgrad_status::*};
use super::types::*;
use super::{custom_bsdf, custom_density, custom_light, custom_phase};
use crate::math::{Rgb, Vec3};
use crate::medium::{Brick, Density, Grid, Medium};
use crate::phase::Phase;
use crate::scene::{
    Bsdf, EnvironmentMap, Light, Lights, Scene, accumulate, leave_constant_sky_to_chance, running_sums, sums_length,
};
use core::ffi::c_void;
use core::mem::{align_of, size_of};
use core::ptr::null;
use core::slice;

/// A scene without its geometry. Lives in memory of the caller; must not be moved.
pub struct volgrad_scene {
    /// Tells a scene from other memory.
    pub(super) stamp: u64,
    pub(super) scene: Scene<'static>,
    /// What of it the host computes.
    pub(super) hosts: Hosts,
}

pub(super) const STAMP: u64 = 0x766f_6c67_7261_6400 | VOLGRAD_ABI_VERSION as u64;

/// Alignment of all memory for objects.
pub(super) const ALIGNMENT: usize = 16;

/// The scene behind a pointer.
///
/// # Safety
/// As for `reference`.
pub(super) unsafe fn scene<'a>(pointer: *const volgrad_scene) -> Result<&'a Scene<'static>, Fault> {
    // SAFETY: the caller's promise.
    Ok(&unsafe { object(pointer) }?.scene)
}

/// The same, with what only the C ABI knows.
///
/// # Safety
/// As for `reference`.
pub(super) unsafe fn object<'a>(pointer: *const volgrad_scene) -> Result<&'a volgrad_scene, Fault> {
    check(pointer)?;
    // SAFETY: the caller's promise; only the stamp is read before it is known to be one.
    if unsafe { (&raw const (*pointer).stamp).read() } != STAMP {
        return Err(VOLGRAD_ERROR_NOT_INITIALISED.into());
    }
    // SAFETY: the stamp says that a whole scene is there.
    Ok(unsafe { reference(pointer) }?)
}

/// A description and its arrays.
struct Description<'a> {
    camera: volgrad_camera,
    media: &'a [volgrad_medium],
    materials: &'a [volgrad_material],
    lights: &'a [volgrad_light],
    bounds_centre: Vec3,
    bounds_radius: f32,
    phases: &'a [*const volgrad_custom_phase],
}

/// `sizeof(volgrad_scene_desc)` before it had phase functions.
const FIRST_DESC: usize = core::mem::offset_of!(volgrad_scene_desc, phases);

impl<'a> Description<'a> {
    /// # Safety
    /// `pointer` and the arrays in it are as the header says.
    unsafe fn read(pointer: *const volgrad_scene_desc) -> Result<Self, Fault> {
        // SAFETY: the caller's promise, here and below.
        let desc = unsafe { sized_since(pointer, FIRST_DESC) }?;
        Place(c"reserved", 0).reserved(desc.reserved)?;
        Ok(Self {
            camera: desc.camera,
            media: unsafe { array(desc.media, desc.media_count as usize) }.map_err(|s| s.at(c"media", 0))?,
            materials: unsafe { array(desc.materials, desc.material_count as usize) }.map_err(|s| s.at(c"materials", 0))?,
            lights: unsafe { array(desc.lights, desc.light_count as usize) }.map_err(|s| s.at(c"lights", 0))?,
            bounds_centre: desc.bounds_centre,
            bounds_radius: desc.bounds_radius,
            phases: unsafe { array(desc.phases, desc.phase_count as usize) }.map_err(|s| s.at(c"phases", 0))?,
        })
    }

    fn brick_count(&self) -> Result<usize, Fault> {
        total(self.media.iter().enumerate().map(|(i, m)| grids::brick_count(m, i)))
    }

    fn custom_media(&self) -> impl Iterator<Item = (usize, &volgrad_medium)> {
        self.media.iter().enumerate().filter(|(_, m)| m.kind == VOLGRAD_MEDIUM_CUSTOM)
    }

    fn custom_materials(&self) -> impl Iterator<Item = (usize, &volgrad_material)> {
        self.materials.iter().enumerate().filter(|(_, m)| m.kind == VOLGRAD_MATERIAL_CUSTOM)
    }

    fn custom_lights(&self) -> impl Iterator<Item = (usize, &volgrad_light)> {
        self.lights.iter().enumerate().filter(|(_, l)| custom_light::is_custom(l))
    }

    /// Length of the running sums that environment maps are sampled with.
    fn sum_count(&self) -> Result<usize, Fault> {
        total(self.lights.iter().enumerate().map(|(i, l)| match convert::texel_count(l, i)? {
            0 => Ok(0),
            _ => Ok(sums_of(l)),
        }))
    }

    fn layout(&self) -> Result<Layout, Fault> {
        let mut end = size_of::<volgrad_scene>();
        let mut section = |size: usize, count: usize| {
            let start = end.checked_next_multiple_of(ALIGNMENT)?;
            end = start.checked_add(size.checked_mul(count)?)?;
            Some(start)
        };
        let starts = [
            section(size_of::<Medium>(), self.media.len()),
            section(size_of::<Bsdf>(), self.materials.len()),
            section(size_of::<Light>(), self.lights.len()),
            section(size_of::<f64>(), self.lights.len()),
            section(size_of::<u32>(), self.lights.len()),
            section(size_of::<Brick>(), self.brick_count()?),
            section(size_of::<f64>(), self.sum_count()?),
            section(size_of::<Host<volgrad_custom_density>>(), self.custom_media().count()),
            section(size_of::<Host<volgrad_custom_bsdf>>(), self.custom_materials().count()),
            section(size_of::<Host<volgrad_custom_phase>>(), self.phases.len()),
            section(size_of::<Host<volgrad_custom_light>>(), self.custom_lights().count()),
        ];
        if starts.contains(&None) {
            return Err(VOLGRAD_ERROR_RANGE.into());
        }
        let [media, materials, lights, cdf, light_media, bricks, sums, densities, bsdfs, phases, light_functions] =
            starts.map(Option::unwrap_or_default);
        Ok(Layout {
            media,
            materials,
            lights,
            cdf,
            light_media,
            bricks,
            sums,
            densities,
            bsdfs,
            phases,
            light_functions,
            bytes: end,
        })
    }
}

/// The sum of counts, which 32 bits may be too few for.
fn total(mut counts: impl Iterator<Item = Result<usize, Fault>>) -> Result<usize, Fault> {
    counts.try_fold(0usize, |total, count| total.checked_add(count?).ok_or(VOLGRAD_ERROR_RANGE.into()))
}

/// For a light with an image.
fn sums_of(l: &volgrad_light) -> usize {
    sums_length(l.image_width as usize, l.image_height as usize)
}

/// Where the sections of a scene's memory start, and how long all of it is.
struct Layout {
    media: usize,
    materials: usize,
    lights: usize,
    cdf: usize,
    light_media: usize,
    bricks: usize,
    sums: usize,
    densities: usize,
    bsdfs: usize,
    phases: usize,
    light_functions: usize,
    bytes: usize,
}

/// Memory that a scene of this description needs. Reads the counts and the sizes of grids and environment maps only.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_scene_size(desc: *const volgrad_scene_desc, bytes: *mut usize) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (desc, write) = unsafe { (Description::read(desc)?, output(bytes)?) };
        write(desc.layout()?.bytes);
        Ok(())
    })())
}

/// Checks a description and makes a scene of it in `memory`: `bytes` as from `volgrad_scene_size`, aligned to 16, writable; it stays
/// the caller's and is needed, unmoved, as long as the scene. There is nothing else to free. Density grids,
/// environment maps and what callbacks' `user` points to are borrowed as long. The bounds of grids and sums of maps are computed here, so
/// this reads all of them once.
/// On an error `*scene` is untouched and `error`, which may be NULL, says which field was wrong; a scene that was in `memory` is gone.
/// Costs one pass over all grids and maps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_scene_init(
    memory: *mut c_void,
    bytes: usize,
    desc: *const volgrad_scene_desc,
    scene: *mut *const volgrad_scene,
    error: *mut volgrad_error,
) -> volgrad_status {
    // SAFETY: the header's contract.
    let result = (|| unsafe {
        let write = output(scene)?;
        let desc = Description::read(desc)?;
        let layout = desc.layout()?;
        check_memory(memory, bytes, layout.bytes)?;
        write(build(memory.cast(), &desc, &layout)?);
        Ok(())
    })();
    // SAFETY: the header's contract.
    unsafe { finish_with(error, result) }
}

pub(super) fn check_memory(memory: *mut c_void, bytes: usize, needed: usize) -> Result<(), Fault> {
    if memory.is_null() {
        return Err(VOLGRAD_ERROR_NULL.at(c"memory", 0));
    }
    if memory.align_offset(ALIGNMENT) != 0 {
        return Err(VOLGRAD_ERROR_MISALIGNED.at(c"memory", 0));
    }
    if bytes < needed { Err(VOLGRAD_ERROR_TOO_SMALL.at(c"bytes", 0)) } else { Ok(()) }
}

/// The status of a result, whose field and index go to `error`.
///
/// # Safety
/// `error` is NULL or points to a volgrad_error with its size.
pub(super) unsafe fn finish_with(error: *mut volgrad_error, result: Result<(), Fault>) -> volgrad_status {
    if let Err(fault) = &result {
        let value = volgrad_error { struct_size: 0, index: fault.index, field: fault.field.map_or(null(), |f| f.as_ptr()) };
        // SAFETY: the caller's promise. A bad struct_size leaves the struct alone; there is nothing better to do.
        unsafe {
            if let Ok(size) = reference(error.cast::<u32>()).map(|size| *size as usize) {
                let _ = write_sized(error, size, value);
            }
        }
    }
    finish(result)
}

/// A section of the caller's memory, filled value by value.
///
/// # Safety
/// `section` is aligned to ALIGNMENT, holds all `values`, and is free to write for as long as the scene is used.
pub(super) unsafe fn fill<T>(
    section: *mut u8,
    values: impl Iterator<Item = Result<T, Fault>>,
) -> Result<&'static mut [T], Fault> {
    const { assert!(align_of::<T>() <= ALIGNMENT) };
    let section = section.cast::<T>();
    let mut count = 0;
    for value in values {
        // SAFETY: the caller's promise.
        unsafe { section.add(count).write(value?) };
        count += 1;
    }
    // SAFETY: all `count` values were written just now.
    Ok(unsafe { slice::from_raw_parts_mut(section, count) })
}

/// # Safety
/// `memory` is aligned to ALIGNMENT and holds `layout`, which is that of `desc`; the grids in `desc` are as the header says.
unsafe fn build(memory: *mut u8, desc: &Description, layout: &Layout) -> Result<*const volgrad_scene, Fault> {
    let object = memory.cast::<volgrad_scene>();
    // SAFETY: the caller's promise, here and below. A scene that was here before is one no more.
    unsafe { (&raw mut (*object).stamp).write(0) };
    let camera = convert::camera(&desc.camera, desc.media.len() as u32)?;
    let at = |start: usize| unsafe { memory.add(start) };
    let mut bricks = unsafe { fill(at(layout.bricks), (0..desc.brick_count()?).map(|_| Ok(Brick::default())))? };
    let numbered_media = || desc.media.iter().enumerate();
    let numbered_materials = || desc.materials.iter().enumerate();
    let numbered_lights = || desc.lights.iter().enumerate();
    let numbered_phases = desc.phases.iter().enumerate();
    let hosts = unsafe {
        Hosts {
            densities: fill(at(layout.densities), desc.custom_media().map(|(i, m)| custom_density::host(m, i)))?,
            bsdfs: fill(at(layout.bsdfs), desc.custom_materials().map(|(i, m)| custom_bsdf::host(m, i)))?,
            phases: fill(at(layout.phases), numbered_phases.map(|(i, p)| custom_phase::host(*p, i)))?,
            lights: fill(at(layout.light_functions), desc.custom_lights().map(|(i, l)| custom_light::host(l, i)))?,
        }
    };
    let (mut densities, mut bsdfs, mut light_functions) = (hosts.densities.iter(), hosts.bsdfs.iter(), hosts.lights.iter());
    let medium = |(i, m)| medium(m, i, &mut bricks, &mut densities, hosts.phases);
    let media = unsafe { fill(at(layout.media), numbered_media().map(medium))? };
    let material = |(i, m)| material(m, i, &mut bsdfs);
    let materials = unsafe { fill(at(layout.materials), numbered_materials().map(material))? };
    let mut sums = unsafe { fill(at(layout.sums), (0..desc.sum_count()?).map(|_| Ok(0.0)))? };
    let light = |(i, l)| light(l, i, &mut sums, &mut light_functions);
    let lights = unsafe { fill(at(layout.lights), numbered_lights().map(light))? };
    let cdf = unsafe { fill(at(layout.cdf), numbered_lights().map(|(i, l)| convert::light_weight(l, i)))? };
    leave_constant_sky_to_chance(lights, cdf);
    accumulate(cdf);
    let light_medium = |(i, l)| convert::light_medium(l, i, desc.media.len() as u32);
    let light_media = unsafe { fill(at(layout.light_media), numbered_lights().map(light_medium))? };
    let mut environments = (0u32..).zip(lights.iter()).filter(|(_, l)| l.is_environment());
    let environment = environments.next().map(|(i, _)| i);
    if let Some((i, _)) = environments.next() {
        return Err(VOLGRAD_ERROR_RANGE.at(c"lights.kind", i as usize));
    }
    let lights = Lights { lights, cdf, media: light_media, guides: &[], environment };
    let bounds = convert::bounds(desc.bounds_centre, desc.bounds_radius)?;
    let scene = Scene { camera, media, materials, lights, bounds };
    // SAFETY: as above.
    unsafe { object.write(volgrad_scene { stamp: STAMP, scene, hosts }) };
    Ok(object)
}

fn light(
    l: &volgrad_light,
    i: usize,
    sums: &mut &'static mut [f64],
    hosts: &mut slice::Iter<'static, Host<volgrad_custom_light>>,
) -> Result<Light<'static>, Fault> {
    if custom_light::is_custom(l) {
        return custom_light::light(hosts.next().ok_or(VOLGRAD_ERROR_INTERNAL)?, l, i);
    }
    convert::light(l, i, |to_world, scale| {
        // SAFETY: the header's contract: the image outlives the scene. An Rgb is three floats.
        let texels =
            unsafe { array(l.image.cast::<Rgb>(), convert::texel_count(l, i)?) }.map_err(|s| s.at(c"lights.image", i))?;
        let place = Place(c"lights.image", i);
        for texel in texels {
            place.colour(*texel, not_negative)?;
        }
        let Some((own, others)) = core::mem::take(sums).split_at_mut_checked(sums_of(l)) else {
            return Err(VOLGRAD_ERROR_INTERNAL.into());
        };
        *sums = others;
        let (width, height) = (l.image_width as usize, l.image_height as usize);
        running_sums(texels, width, height, scale, own);
        EnvironmentMap::new(texels, width, height, to_world, scale, own).ok_or(VOLGRAD_ERROR_INTERNAL.into())
    })
}

fn material(
    m: &volgrad_material,
    i: usize,
    hosts: &mut slice::Iter<'static, Host<volgrad_custom_bsdf>>,
) -> Result<Bsdf<'static>, Fault> {
    match m.kind {
        VOLGRAD_MATERIAL_CUSTOM => custom_bsdf::bsdf(hosts.next().ok_or(VOLGRAD_ERROR_INTERNAL)?, m, i),
        _ => convert::material(m, i),
    }
}

fn medium(
    m: &volgrad_medium,
    i: usize,
    bricks: &mut &'static mut [Brick],
    hosts: &mut slice::Iter<'static, Host<volgrad_custom_density>>,
    phases: &'static [Host<volgrad_custom_phase>],
) -> Result<Medium<'static>, Fault> {
    let (sigma_t, albedo) = convert::medium(m, i)?;
    let phase = match m.phase.kind {
        VOLGRAD_PHASE_CUSTOM => {
            let phase = phases.get(m.custom_phase as usize);
            Phase::Custom(phase.ok_or(VOLGRAD_ERROR_INDEX.at(c"media.custom_phase", i))?)
        }
        _ => convert::phase(&m.phase, Place(c"media.phase", i))?,
    };
    let density = match m.kind {
        VOLGRAD_MEDIUM_HOMOGENEOUS => Density::Homogeneous,
        VOLGRAD_MEDIUM_GRID | VOLGRAD_MEDIUM_SPARSE_GRID => Density::Grid(grid(m, i, bricks)?),
        VOLGRAD_MEDIUM_CUSTOM => Density::Custom(custom_density::density(hosts.next().ok_or(VOLGRAD_ERROR_INTERNAL)?, m, i)?),
        _ => return Err(VOLGRAD_ERROR_KIND.at(c"media.kind", i)),
    };
    Ok(Medium { sigma_t, albedo, phase, density })
}

fn grid(m: &volgrad_medium, i: usize, bricks: &mut &'static mut [Brick]) -> Result<Grid<'static>, Fault> {
    let Some((own, others)) = core::mem::take(bricks).split_at_mut_checked(grids::brick_count(m, i)?) else {
        return Err(VOLGRAD_ERROR_INTERNAL.into());
    };
    *bricks = others;
    // SAFETY: the header's contract.
    unsafe { grids::grid(m, i, own) }
}

pub(super) fn image_size(width: u32, height: u32) -> Result<usize, Fault> {
    let ok = |n: u32| (1..=MAX_IMAGE_SIDE).contains(&n);
    if ok(width) && ok(height) { Ok(width as usize * height as usize) } else { Err(VOLGRAD_ERROR_RANGE.into()) }
}
