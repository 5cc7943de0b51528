//! Batches one by one: paths of the path sampler that may be shifted, and the splats of one of them.

use super::scenes::World;
use volgrad::math::{Colour, DVec2};
use volgrad::sampler::{self, PathTracer, RandomNumbers, Record, Stats, shift_numbers, tile_numbers};
use volgrad::scene::View;
use volgrad::shift::{self, BatchStats, Draw, Shiftable, Tile};

/// The toy images' pixels along a side.
const SIDE: u32 = 8;

/// What the path sampler records of path number `pass`, through pixel number `pass` of the image.
pub fn record(world: &World, options: sampler::Options, pass: u64) -> Record {
    let (scene, pixel) = (world.scene(), (pass % u64::from(SIDE * SIDE)) as u32);
    let tracer = PathTracer { scene: &scene, queries: &world.geometry, options };
    // No place in a pixel whose rays meet an edge of a box.
    let place = DVec2::new(f64::from(pixel % SIDE) + 0.37, f64::from(pixel / SIDE) + 0.43);
    let lens = scene.camera.lens_point(DVec2::new(0.2, 0.6));
    let mut view = [View::through(&scene, place, lens)];
    View::trace(&mut view, &scene, &world.geometry).expect("never stops");
    let mut numbers = RandomNumbers::for_path(options.seed, pass, pixel);
    let mut record = Record::new(options.shift.as_ref());
    tracer.trace(view[0], &mut numbers, &mut record, &mut Stats::default()).expect("never stops");
    record
}

/// Shiftable paths of up to six edges.
pub fn paths(world: &World, options: &shift::Options, count: u64) -> Vec<Shiftable> {
    let options = sampler::Options {
        max_depth: 6,
        rr_depth: 4,
        seed: 11,
        shift: Some(*options),
        left_out: volgrad::sampler::Lengths::NONE,
        first: volgrad::sampler::FirstVertices::ALL,
    };
    (0..count).filter_map(|pass| record(world, options, pass).finish().copied()).collect()
}

/// The batch that pass number `pass` makes of a path: its splats and what they cost.
pub fn batch(
    world: &World,
    options: &shift::Options,
    path: &Shiftable,
    pass: u64,
    mut splat: impl FnMut(DVec2, Colour),
) -> BatchStats {
    let scene = world.scene();
    let draw = Draw { tiles: tile_numbers(3, pass), random: shift_numbers(3, pass, 0) };
    let mut tile = Tile::default();
    if options.has_views() {
        tile.retrace_around(&scene, &world.geometry, options, draw.tiles, &path.image).expect("never stops");
    }
    let tile = options.has_views().then_some(&tile);
    shift::shift(&scene, &world.geometry, options, path, tile, draw, &mut splat).expect("never stops")
}

/// Its splats alone; the last one is the path's own.
pub fn splats(world: &World, options: &shift::Options, path: &Shiftable, pass: u64) -> Vec<(DVec2, Colour)> {
    let mut splats = vec![];
    batch(world, options, path, pass, |pixel, colour| splats.push((pixel, colour)));
    splats
}
