//! A mutation of one subpath keeps the other: the path is the same, bit by bit, as if both had been made from its numbers.

use crate::toy::scenes::{World, edges_under_area_lights, edges_under_point_light};
use crate::toy::scenes::{edges_with_rough_surfaces, edges_with_specular_surfaces};
use volgrad::sampler::bidirectional::{Connection, Subpath, Technique};
use volgrad::sampler::metropolis::{Change, Scratch, make, remake};
use volgrad::sampler::{Stats, line_numbers};

const LONGEST: usize = 6;

/// Mutations of each technique's path.
const MUTATIONS: usize = 300;

/// Of a path's numbers.
const STEP: f64 = 0.05;

fn worlds() -> [World; 4] {
    let mut lens = edges_with_rough_surfaces();
    (lens.camera.lens_radius, lens.camera.focal_distance) = (0.3, 2.0);
    [edges_under_point_light(), edges_under_area_lights(), edges_with_specular_surfaces(), lens]
}

/// A path and its numbers, one of which is changed at a time, and the same path made anew.
struct Walk<'a> {
    numbers: Vec<f64>,
    kept: Scratch<'a>,
    anew: Scratch<'a>,
}

/// All that is known of a path, but for densities that are set when a subpath goes on.
fn shown(connection: &Option<Connection>, camera: &Subpath, light: &Subpath) -> String {
    format!("{connection:?} {:?} {:?}", camera.vertices(), light.vertices())
}

fn walk(world: &World, technique: Technique, seed: u64) -> [u32; 2] {
    let scene = world.scene();
    let queries = &world.geometry;
    let stats = &mut Stats::default();
    let mut random = line_numbers(seed, technique.camera as u64 + 100 * technique.light as u64);
    let mut walk = Walk { numbers: Vec::new(), kept: Scratch::default(), anew: Scratch::default() };
    let mut changes = [0; 2];
    for _ in 0..MUTATIONS {
        let numbers = walk.numbers.clone();
        // A path first, then small changes of it.
        let change = if numbers.is_empty() { Change::BOTH } else { Change::small(technique, random()) };
        walk.numbers.resize(technique.numbers(), 0.0);
        for i in change.numbers(technique) {
            walk.numbers[i] = if numbers.is_empty() { random() } else { (walk.numbers[i] + STEP * random()).fract() };
        }
        let made = make(&scene, queries, technique, &walk.numbers, &mut walk.anew, stats).expect("never stops");
        let Scratch { camera, light } = &mut walk.kept;
        let again = remake(&scene, queries, technique, &walk.numbers, change, camera, light, stats).expect("never stops");
        let both = [(&made, &walk.anew), (&again, &walk.kept)].map(|(made, room)| shown(made, &room.camera, &room.light));
        if made.is_none() {
            assert!(again.is_none());
            walk.numbers = Vec::new();
            continue;
        }
        assert_eq!(both[0], both[1], "{technique:?}, {change:?}");
        changes[0] += u32::from(change == Change { camera: true, light: false });
        changes[1] += u32::from(change == Change { camera: false, light: true });
    }
    changes
}

#[test]
fn paths_are_those_of_their_numbers() {
    for (seed, world) in (0..).zip(worlds()) {
        let mut all = [0; 2];
        for length in 2..=LONGEST {
            for camera in 1..=length + 1 {
                let changes = walk(&world, Technique { camera, light: length + 1 - camera }, seed);
                all = [all[0] + changes[0], all[1] + changes[1]];
            }
        }
        println!("{} changes of the camera's subpath, {} of the light's", all[0], all[1]);
        assert!(all[0] > 500 && all[1] > 50);
    }
}

/// What changes one subpath changes all of its numbers and none of the other's; what single vertices are made of always changes too.
#[test]
fn each_change_has_its_numbers() {
    for length in 2..=LONGEST {
        for camera in 1..=length + 1 {
            let technique = Technique { camera, light: length + 1 - camera };
            let [one, other] = [0.0, 1.0].map(|u| Change::small(technique, u));
            assert_eq!(Change::BOTH.numbers(technique), 0..technique.numbers());
            if camera == 1 || technique.light == 0 {
                assert!(one == Change::BOTH && other == Change::BOTH);
            } else {
                assert_eq!((one.camera, one.light, other.camera, other.light), (true, false, false, true));
                let (of_camera, of_light) = (one.numbers(technique), other.numbers(technique));
                assert_eq!((of_camera.start, of_camera.end, of_light.end), (0, of_light.start, technique.numbers()));
                assert_eq!(of_camera.len(), Technique { camera, light: 0 }.numbers());
            }
        }
    }
}
