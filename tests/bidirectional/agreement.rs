//! The path sampler and both heuristics find the same images, in worlds that isolate a light, a camera, a material, a medium.
//!
//! In these no light reaches the camera in ways that the path sampler does not find, or hardly does.

use crate::toy::estimate::scale;
use crate::toy::scenes::{
    World, edges_under_area_lights, edges_under_point_light, edges_with_rough_surfaces, edges_with_specular_surfaces,
};
use crate::{MOST, MOST_OF_PIXELS, bidirectional, options, path_tracer, pixels, worlds, z};
use volgrad::film::{Cell, Count, Film};
use volgrad::math::{Colour, luminance};
use volgrad::sampler::Stats;
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic, MAX_LENGTH, Options};
use volgrad::scene::{GUIDE_SIDE, Guide, Light};
use volgrad::shift::{self, Kernel, Mode, Radius};

const LONGEST: u32 = 4;

fn agree(worlds: Vec<(&str, World)>) {
    agree_with(worlds, &[Heuristic::Balance, Heuristic::Power].map(|heuristic| options(LONGEST, heuristic)));
}

fn agree_with(worlds: Vec<(&str, World)>, all: &[Options]) {
    let mut wrong = vec![];
    for (name, world) in worlds {
        let expected = path_tracer(&world, LONGEST, 32 * scale());
        for options in all {
            let found = bidirectional(&world, *options, 8 * scale());
            let (a, b) = (found.total(), expected.total());
            let total = (0..3).map(|c| z(found.channel(c), expected.channel(c)));
            let pixel = (0..found.pixels()).map(|i| z(found.pixel(i), expected.pixel(i)));
            let worst =
                |scores: &mut dyn Iterator<Item = f64>| scores.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
            let (total, pixel) = (worst(&mut total.into_iter()), worst(&mut pixel.into_iter()));
            println!(
                "{name}, {}: {:.5} ± {:.2} % against {:.5} ± {:.2} %, z {total:+.2}, of pixels {pixel:+.2}",
                description(options),
                a.value,
                100.0 * a.error / a.value,
                b.value,
                100.0 * b.error / b.value
            );
            if !(total.abs() < MOST && pixel.abs() < MOST_OF_PIXELS) || found.dropped > 0 {
                wrong.push((name, description(options)));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

fn description(options: &Options) -> String {
    let Options { heuristic, light_vertices, roulette, shift, .. } = options;
    let shift = shift.map(|shift| (shift.mode, shift.kernel));
    format!("{heuristic:?}, {light_vertices} light vertices, roulette {roulette}, {shift:?}")
}

#[test]
fn under_each_light() {
    agree(worlds::lights());
}

#[test]
fn through_each_camera() {
    agree(worlds::cameras());
}

#[test]
fn on_each_material() {
    agree(worlds::materials());
}

#[test]
fn in_each_medium() {
    agree(worlds::media());
}

#[test]
fn through_glass() {
    agree(worlds::glass());
}

/// The worlds that shifts are tested in. The path sampler never finds the sun through a pane of glass, so that is put out.
#[test]
fn across_all_kinds_of_edges() {
    agree(edges());
}

fn edges() -> Vec<(&'static str, World)> {
    let mut specular = edges_with_specular_surfaces();
    for light in &mut specular.lights {
        if let Light::Directional { irradiance, .. } = light {
            *irradiance = Colour::ZERO;
        }
    }
    vec![
        ("point light", edges_under_point_light()),
        ("area lights", edges_under_area_lights()),
        ("specular", specular),
        ("rough", edges_with_rough_surfaces()),
    ]
}

/// Some that are known well after few samples: of each kind of light and medium, of surfaces alone, behind glass.
fn a_few() -> Vec<(&'static str, World)> {
    let wanted = ["sphere", "environment", "environment map", "spot", "lens", "diffuse", "mirror", "chromatic", "grid", "ball"];
    let all = worlds::lights().into_iter().chain(worlds::cameras()).chain(worlds::materials());
    let all = all.chain(worlds::media()).chain(worlds::glass());
    let few: Vec<_> = all.filter(|(name, _)| wanted.contains(name)).collect();
    assert_eq!(few.len(), wanted.len());
    few
}

/// With one vertex from a light it is a path tracer.
#[test]
fn with_few_light_vertices() {
    let balance = options(LONGEST, Heuristic::Balance);
    let few = [1, 2].map(|light_vertices| Options { light_vertices, ..balance });
    agree_with(a_few(), &few);
    agree_with(edges(), &[Options { light_vertices: 2, ..options(LONGEST, Heuristic::Power) }]);
}

/// About as bright as the worlds, and some times that. With more, pixels have too few splats for normal scores.
const ROULETTES: [f64; 2] = [0.1, 0.5];

#[test]
fn with_roulette() {
    let all = ROULETTES.map(|roulette| Options { roulette, ..options(LONGEST, Heuristic::Balance) });
    agree_with(a_few(), &all);
    agree_with(edges(), &all[..1]);
}

/// Batches of four members beside the path's own, or eight on a tile of 3 x 3 pixels.
fn shifted(mode: Mode, kernel: Kernel, roulette: f64, light_vertices: usize) -> Options {
    let shift = shift::Options::new(mode, kernel, if kernel == Kernel::Tile { 8 } else { 4 });
    Options { roulette, light_vertices, shift: Some(shift), ..options(LONGEST, Heuristic::Balance) }
}

const DISK: Kernel = Kernel::Disk(Radius::Pixels(1.0));

/// Edges of media, of shadows and of what is in the way, chains of specular surfaces, rough ones.
#[test]
fn shifted_across_all_kinds_of_edges() {
    let all = [
        shifted(Mode::Exact, DISK, 0.0, MAX_LENGTH),
        shifted(Mode::Exact, Kernel::Tile, ROULETTES[0], 2),
        shifted(Mode::Exchangeable, DISK, ROULETTES[0], MAX_LENGTH),
        shifted(Mode::Exchangeable, Kernel::Tile, 0.0, MAX_LENGTH),
    ];
    agree_with(edges(), &all);
}

#[test]
fn shifted_in_toys() {
    let all = [
        shifted(Mode::Exact, DISK, ROULETTES[1], MAX_LENGTH),
        shifted(Mode::Exchangeable, Kernel::Tile, ROULETTES[0], MAX_LENGTH),
        Options { heuristic: Heuristic::Power, ..shifted(Mode::Exact, Kernel::Tile, 0.0, 1) },
    ];
    agree_with(a_few(), &all);
}

/// Guides that know nothing of the world, and one that has learned where the window is.
#[test]
fn with_guides() {
    agree(worlds::guided());
    agree(vec![("behind a window", learned(&worlds::behind_a_window()))]);
}

fn learned(world: &World) -> World {
    let film = learn(world, 64);
    let guide = Guide::learned(|i, j| luminance(film[j * GUIDE_SIDE + i].value()));
    world.clone().guided(vec![guide])
}

/// What the one light's subpaths carry, cell by cell.
fn learn(world: &World, passes: u64) -> Vec<Cell> {
    let scene = world.scene();
    let options = Options { seed: 9, ..options(LONGEST, Heuristic::Balance) };
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    let (cells, dropped) = (vec![Cell::default(); GUIDE_SIDE * GUIDE_SIDE], Count::default());
    let (width, height) = (GUIDE_SIDE as u32, GUIDE_SIDE as u32);
    let mut film = Film { width, height, cells: &cells, dropped: &dropped, is_shared: false };
    for pass in 0..passes {
        sampler.learn(pass, 0..pixels(world), &mut film, &mut Stats::default()).expect("the toy host never stops");
    }
    assert_eq!(dropped.get(), 0);
    cells
}

/// By where light leaves the lamp: also in a scene whose own guide chose that.
#[test]
fn only_what_leads_through_the_window_is_learned() {
    let world = worlds::behind_a_window();
    // Of directions steeper than 45°, where the window is: half of all that the lamp sends out.
    let steep = |world: &World| {
        let film = learn(world, 500).into_iter().map(|cell| luminance(cell.value())).enumerate();
        let sum = |last: usize| film.clone().filter(|(cell, _)| cell % GUIDE_SIDE < last).map(|(_, value)| value).sum::<f64>();
        sum(GUIDE_SIDE / 2) / sum(GUIDE_SIDE)
    };
    for (name, world) in [("alike", &world), ("guided", &learned(&world))] {
        let share = steep(world);
        println!("{name}: {share:.4}");
        assert!(share > 0.98, "{name}");
    }
}
