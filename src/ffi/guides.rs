//! Guides: where the subpaths from lights go, learned from what such subpaths carry.

use super::bidirectional::{DEFAULTS, options, volgrad_bidirectional_options};
use super::convert::MAX_IMAGE_SIDE;
use super::films::{cells, film, volgrad_film};
use super::pointer::{output, sized_over};
use super::samplers::{HostQueries, NO_STATS, add_stats, pixel_numbers, volgrad_path_sampler_stats};
use super::scenes::{ALIGNMENT, STAMP, check_memory, fill, object, scene, volgrad_scene};
use super::status::{Fault, finish, volgrad_status, volgrad_status::*};
use super::types::volgrad_queries;
use crate::film::Cell;
use crate::math::luminance;
use crate::sampler::Stats;
use crate::sampler::bidirectional::Bidirectional;
use crate::scene::{GUIDE_SIDE, Guide, Lights, Scene};
use core::ffi::c_void;

/// The size of the film that `volgrad_guide_learn` fills. VOLGRAD_ERROR_RANGE if the scene has too many lights (more than 1023) or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_guide_film_size(
    scene: *const volgrad_scene,
    width: *mut u32,
    height: *mut u32,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, to_width, to_height) = unsafe { (self::scene(scene)?, output(width)?, output(height)?) };
        let [w, h] = size(scene)?;
        to_width(w);
        to_height(h);
        Ok(())
    })())
}

fn size(scene: &Scene) -> Result<[u32; 2], Fault> {
    let height = scene.lights.lights.len() * GUIDE_SIDE;
    let ok = height > 0 && height <= MAX_IMAGE_SIDE as usize;
    if ok { Ok([GUIDE_SIDE as u32, height as u32]) } else { Err(VOLGRAD_ERROR_RANGE.at(c"lights", 0)) }
}

fn check_size(scene: &Scene, film: [u32; 2]) -> Result<(), Fault> {
    if size(scene)? == film { Ok(()) } else { Err(VOLGRAD_ERROR_SIZE_MISMATCH.into()) }
}

/// As `volgrad_bidirectional_run`, but for the image: adds what the subpaths from each light carry to `film`, of
/// `volgrad_guide_film_size`, by where they go. Some ten samples for each of its pixels are enough. Films of several threads add up, as
/// all films do. `stats` counts as there.
/// Costs per pixel at most what `volgrad_bidirectional_run` costs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_guide_learn(
    scene: *const volgrad_scene,
    queries: *const volgrad_queries,
    options: *const volgrad_bidirectional_options,
    pass: u64,
    first_pixel: u32,
    pixel_count: u32,
    film: *mut volgrad_film,
    stats: *mut volgrad_path_sampler_stats,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (scene, queries) = unsafe { (self::scene(scene)?, HostQueries::read(queries)?) };
        let options = self::options(&unsafe { sized_over(options, DEFAULTS) }?)?;
        let mut film = unsafe { self::film(film) }?;
        check_size(scene, [film.width, film.height])?;
        let pixels = pixel_numbers(scene, first_pixel, pixel_count)?;
        let sampler = Bidirectional { scene, queries: &queries, options };
        let counted = if stats.is_null() { NO_STATS } else { unsafe { sized_over(stats, NO_STATS) }? };
        let mut done = Stats::default();
        let result = sampler.learn(pass, pixels, &mut film, &mut done);
        if !stats.is_null() {
            unsafe { add_stats(stats, counted, &done) }?;
        }
        Ok(result?)
    })())
}

fn bytes_of(scene: &Scene) -> usize {
    size_of::<volgrad_scene>().next_multiple_of(ALIGNMENT) + scene.lights.lights.len() * size_of::<Guide>()
}

/// Memory that a guided scene needs: 33 KiB for each light.
/// `VOLGRAD_ERROR_RANGE` as for `volgrad_guide_film_size`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_guide_size(scene: *const volgrad_scene, bytes: *mut usize) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, write) = unsafe { (self::scene(scene)?, output(bytes)?) };
        size(scene)?;
        write(bytes_of(scene));
        Ok(())
    })())
}

/// Makes a scene in `memory` that is `scene`, but that the subpaths which the bidirectional sampler and chains start from its lights
/// go more often where the film says that they carry more. All else about it is the same, and every image still has the same
/// expectation: a fifth of the subpaths go wherever the lights shine. `bytes` as from `volgrad_guide_size`, aligned to 16. The new
/// scene refers to `scene`, whose memory has to outlive it. The samples, and all chains of their plan, use the same guided scene.
/// Costs a pass over the film. `VOLGRAD_ERROR_RANGE` as for `volgrad_guide_film_size`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_guide_init(
    memory: *mut c_void,
    bytes: usize,
    scene: *const volgrad_scene,
    film: *const volgrad_film,
    guided: *mut *const volgrad_scene,
) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract, here and below.
        let (volgrad_scene { scene, hosts, .. }, (film, cells)) = unsafe { (self::object(scene)?, self::cells(film)?) };
        let write = unsafe { output(guided) }?;
        check_size(scene, [film.width, film.height])?;
        check_memory(memory, bytes, bytes_of(scene))?;
        let object = memory.cast::<volgrad_scene>();
        // SAFETY: a scene that was here before is one no more.
        unsafe { (&raw mut (*object).stamp).write(0) };
        let place = size_of::<volgrad_scene>().next_multiple_of(ALIGNMENT);
        // SAFETY: the memory is aligned and holds the scene and the guides behind it.
        let guides = unsafe {
            fill(memory.cast::<u8>().add(place), (0..scene.lights.lights.len()).map(|light| Ok(guide(cells, light))))?
        };
        let lights = Lights { guides, ..scene.lights };
        // SAFETY: as above.
        unsafe { object.write(volgrad_scene { stamp: STAMP, scene: Scene { lights, ..*scene }, hosts: *hosts }) };
        write(object);
        Ok(())
    })())
}

fn guide(cells: &[Cell], light: usize) -> Guide {
    Guide::learned(|i, j| {
        let cell = cells.get((light * GUIDE_SIDE + j) * GUIDE_SIDE + i);
        cell.map_or(0.0, |cell| luminance(cell.value()))
    })
}
