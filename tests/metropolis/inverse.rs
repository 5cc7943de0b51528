//! Numbers → path → numbers, and path → numbers of any other technique → the same path.

use crate::toy::scenes::{World, edges_under_point_light, edges_with_rough_surfaces, edges_with_specular_surfaces};
use volgrad::math::{DVec2, DVec3, luminance};
use volgrad::sampler::bidirectional::{Connection, Joined, Technique};
use volgrad::sampler::metropolis::{Scratch, invert, make};
use volgrad::sampler::{Stats, line_numbers};
use volgrad::scene::{Guide, Scene};

const LONGEST: usize = 5;

/// Of numbers, pixels, and of values relative to what they are.
const TOLERANCE: f64 = 1e-6;
/// Another technique's rays start elsewhere, in single precision; the few paths that are farther apart have neighbours next to each other.
const OF_ANOTHER: f64 = 1e-4;
const MOST_APART: f64 = 5e-3;

/// What a technique makes of numbers.
struct Made {
    pixel: DVec2,
    positions: Vec<DVec3>,
    /// f over the sum of all techniques' densities: the same whichever technique made it.
    value: f64,
}

impl Made {
    fn new(connection: &Connection, room: &Scratch) -> Self {
        let (camera, light) = (room.camera.vertices(), room.light.vertices());
        let positions = camera.iter().chain(light.iter().rev()).map(|vertex| vertex.position).collect();
        Self { pixel: connection.pixel, positions, value: luminance(connection.value) * connection.weight }
    }

    /// How far apart: pixels, world units, or in value.
    fn distance(&self, other: &Self) -> f64 {
        let vertices = self.positions.iter().zip(&other.positions).map(|(a, b)| (a - b).length()).fold(0.0, f64::max);
        let value = (self.value / other.value - 1.0).abs();
        vertices.max((self.pixel - other.pixel).length()).max(value)
    }
}

fn remade<'a>(world: &World, scene: &'a Scene<'a>, technique: Technique, numbers: &[f64]) -> Option<Made> {
    let mut room = Scratch::default();
    let numbers = &numbers[..technique.numbers()];
    let made = make(scene, &world.geometry, technique, numbers, &mut room, &mut Stats::default()).expect("never stops");
    made.map(|connection| Made::new(&connection, &room))
}

/// Paths of each technique of what `number` makes of random numbers.
fn each_path(
    world: &World,
    count: u64,
    number: fn(f64) -> f64,
    mut check: impl FnMut(&Scene, Technique, &[f64], &Joined, &Made),
) {
    let scene = world.scene();
    let mut room = Scratch::default();
    for length in 2..=LONGEST {
        for camera in 1..=length + 1 {
            let technique = Technique { camera, light: length + 1 - camera };
            for index in 0..count {
                let mut random = line_numbers((length * 100 + camera) as u64, index);
                let numbers: Vec<f64> = (0..technique.numbers()).map(|_| number(random())).collect();
                let stats = &mut Stats::default();
                let made = make(&scene, &world.geometry, technique, &numbers, &mut room, stats).expect("never stops");
                let Some(connection) = made else { continue };
                let (camera, light) = (room.camera.vertices(), room.light.vertices());
                let joined = Joined { scene: &scene, camera, light, connection: &connection };
                check(&scene, technique, &numbers, &joined, &Made::new(&connection, &room));
            }
        }
    }
}

/// Directions from each light in bands and rings, to one where ten times more goes than to the other.
fn guided(world: World) -> World {
    let guide = |light| Guide::learned(move |i, j| if (i / 8 + j / 16 + light) % 2 == 0 { 1.0 } else { 0.1 });
    let guides = (0..world.lights.len()).map(guide).collect();
    world.guided(guides)
}

fn worlds() -> [World; 4] {
    let mut rough = edges_with_rough_surfaces();
    (rough.camera.lens_radius, rough.camera.focal_distance) = (0.3, 2.0);
    let specular = edges_with_specular_surfaces();
    [edges_under_point_light(), guided(specular.clone()), specular, rough]
}

/// Each number comes back, or does not matter: the path is the same with it in the place of the first one.
#[test]
fn numbers_come_back() {
    for world in worlds() {
        let (mut back, mut free) = (0, 0);
        each_path(
            &world,
            1000,
            |u| u,
            |scene, technique, numbers, joined, own| {
                let found = invert(joined, &world.geometry, technique).expect("never stops").expect("made it");
                for i in 0..numbers.len() {
                    if (found[i] - numbers[i]).abs() < TOLERANCE {
                        back += 1;
                        continue;
                    }
                    let mut changed = numbers.to_vec();
                    changed[i] = found[i];
                    let other = remade(&world, scene, technique, &changed);
                    let distance = other.map(|other| own.distance(&other));
                    assert!(distance.is_some_and(|d| d < TOLERANCE), "number {i} of {technique:?}: {distance:?}");
                    free += 1;
                }
            },
        );
        println!("{back} numbers come back, {free} do not matter");
        assert!(back > 5000);
    }
}

/// Whether a technique can make it: no connection at specular vertices, nor to lights that cannot be found.
fn possible(joined: &Joined, technique: Technique) -> bool {
    let last = joined.last();
    if technique.light == 0 {
        return joined.vertex(last).can_be_found() && !(1..last).all(|i| joined.vertex(i).is_specular());
    }
    let joins = |i: usize| i == last || !joined.vertex(i).is_specular();
    joins(technique.camera - 1) && joins(technique.camera)
}

#[test]
fn other_techniques_make_the_same_path() {
    for world in worlds() {
        let (mut same, mut lost, mut through_glass) = (0, 0_u32, 0);
        each_path(
            &world,
            500,
            |u| u,
            |scene, own_technique, _, joined, own| {
                for camera in 1..=joined.last() + 1 {
                    let technique = Technique { camera, light: joined.last() + 1 - camera };
                    if technique == own_technique || !possible(joined, technique) {
                        continue;
                    }
                    let numbers = invert(joined, &world.geometry, technique).expect("never stops").expect("can make it");
                    match remade(&world, scene, technique, &numbers).map(|other| own.distance(&other)) {
                        Some(distance) if distance < OF_ANOTHER => same += 1_u32,
                        _ => lost += 1,
                    }
                    through_glass += u32::from((1..joined.last()).any(|i| joined.vertex(i).is_specular()));
                }
            },
        );
        println!("{same} the same, {lost} not; {through_glass} with specular surfaces");
        assert!(same > 1000 && f64::from(lost) < MOST_APART * f64::from(same));
    }
}

/// A fifth of the numbers next to 0 and 1, where rounding can lead to these: every technique's numbers are in the open interval.
#[test]
fn numbers_stay_between_0_and_1() {
    const LEAST: f64 = 0.5 * f64::EPSILON;
    for world in worlds() {
        let (mut all, mut least) = (0, 0);
        let ends = |u: f64| if u < 0.1 { LEAST } else { u.min(0.9) / 0.9 }.min(1.0 - LEAST);
        each_path(&world, 500, ends, |_, own_technique, _, joined, _| {
            for camera in 1..=joined.last() + 1 {
                let technique = Technique { camera, light: joined.last() + 1 - camera };
                if technique == own_technique || possible(joined, technique) {
                    let found = invert(joined, &world.geometry, technique).expect("never stops");
                    for number in found.iter().flat_map(|found| &found[..technique.numbers()]) {
                        assert!(*number > 0.0 && *number < 1.0, "{technique:?}: {number:e}");
                        all += 1;
                        least += u32::from(*number == LEAST);
                    }
                }
            }
        });
        println!("{least} of {all} numbers are the least");
        assert!(least > 100);
    }
}
