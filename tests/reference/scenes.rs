//! Small random worlds in which the reference is tested, all within about two units of the origin.

use super::{
    camera::Camera,
    grid::Grid,
    medium::{Density, Medium},
    phase::Phase,
    random::*,
    vector::*,
    world::{Plane, Region, World},
};
use rand_pcg::Pcg64;

pub const PHASES: [Phase; 4] = [
    Phase::Isotropic,
    Phase::HenyeyGreenstein { g: -0.6 },
    Phase::HenyeyGreenstein { g: 0.3 },
    Phase::HenyeyGreenstein { g: 0.9 },
];

pub fn random_grid(rng: &mut Pcg64, resolution: [usize; 3], to_world: Affine) -> Grid {
    let count = resolution.iter().product();
    let samples = std::iter::repeat_with(|| uniform(rng, 0.2, 2.0)).take(count).collect();
    Grid { resolution, samples, to_world }
}

/// A cube about the origin, turned and sheared.
pub fn sheared() -> Affine {
    Affine { columns: [[1.6, 0.5, -0.3], [-0.7, 1.7, 0.4], [0.2, -0.6, 1.8]], origin: [-0.6, -0.8, -0.9] }
}

fn cube(medium: usize) -> Region {
    Region::axis_aligned([-1.0; 3], [1.0; 3], medium)
}

/// The part of the cube on one side of a slanted plane.
fn slanted_part(medium: usize) -> Region {
    let mut region = cube(medium);
    region.planes.push(Plane::through([0.1, 0.0, -0.1], [1.0, 0.4, -0.3]));
    region
}

fn homogeneous(sigma_t: Rgb, phase: Phase) -> Medium {
    Medium { sigma_t, albedo: [0.9, 0.8, 0.6], phase, density: Density::Constant }
}

fn heterogeneous(sigma_t: Rgb, phase: Phase, grid: Grid) -> Medium {
    Medium { density: Density::Grid(grid), ..homogeneous(sigma_t, phase) }
}

const GREY: Rgb = [0.8; 3];
const BLUISH: Rgb = [0.4, 0.9, 1.7];
const REDDISH: Rgb = [2.1, 1.2, 0.3];

#[derive(Clone, Debug)]
pub struct Scene {
    pub name: &'static str,
    pub world: World,
    /// Does σ_t jump somewhere along most paths?
    pub has_faces: bool,
    pub has_grid: bool,
}

/// One world for each thing that can go wrong with transmittance.
pub fn scenes(rng: &mut Pcg64, phase: Phase) -> Vec<Scene> {
    let outside = Camera::looking_at([0.4, 0.7, -3.0], ZERO, 0.7, 0.1);
    let inside = Camera::looking_at([0.1, -0.2, -0.8], [0.0, 0.0, 1.0], 0.7, 0.25);
    let scene = |name, camera, media, regions, has_grid| Scene {
        name,
        world: World { camera, media, regions },
        has_faces: true,
        has_grid,
    };
    let upright = Affine::onto_box([-1.0; 3], [1.0; 3]);
    let small = Affine::onto_box([-0.8, -0.7, -0.9], [0.9, 0.8, 0.7]);
    let mut grid = |resolution, map| random_grid(rng, resolution, map);

    let filled = Scene {
        has_faces: false,
        ..scene("homogeneous everywhere", outside, vec![homogeneous(GREY, phase)], vec![Region::everywhere(0)], false)
    };
    vec![
        Scene { world: World { camera: Camera { near: 0.0, ..outside }, ..filled.world }, ..filled },
        scene("homogeneous cube", outside, vec![homogeneous(GREY, phase)], vec![cube(0)], false),
        scene("chromatic cube", outside, vec![homogeneous(BLUISH, phase)], vec![cube(0)], false),
        scene("grid", outside, vec![heterogeneous(GREY, phase, grid([4, 5, 3], upright))], vec![cube(0)], true),
        scene(
            "sheared grid",
            outside,
            vec![heterogeneous(BLUISH, phase, grid([3, 4, 5], sheared()))],
            vec![Region::image_of_unit_cube(&sheared(), 0)],
            true,
        ),
        scene(
            "faces between media",
            outside,
            vec![homogeneous(BLUISH, phase), homogeneous(REDDISH, phase), homogeneous(GREY, phase)],
            vec![cube(0), slanted_part(1), Region::axis_aligned([-0.4; 3], [0.5, 0.4, 0.3], 2)],
            false,
        ),
        scene(
            "grid within its region, beside a homogeneous medium, with a hole",
            outside,
            vec![heterogeneous(BLUISH, phase, grid([4, 3, 4], small)), homogeneous(REDDISH, phase)],
            vec![
                cube(0),
                slanted_part(1),
                Region { medium: None, ..Region::axis_aligned([-0.2, -0.3, -0.2], [0.3, 0.2, 0.2], 0) },
            ],
            true,
        ),
        scene(
            "sheared grid through a lens",
            outside.through_lens(0.5, [0.3, -0.2]),
            vec![heterogeneous(GREY, phase, grid([4, 4, 3], sheared()))],
            vec![Region::image_of_unit_cube(&sheared(), 0)],
            true,
        ),
        scene(
            "near plane in a cube through a lens",
            inside.through_lens(0.1, [-0.05, 0.04]),
            vec![homogeneous(BLUISH, phase)],
            vec![cube(0)],
            false,
        ),
        scene("near plane in a cube", inside, vec![homogeneous(BLUISH, phase)], vec![cube(0)], false),
        scene(
            "near plane in a grid",
            inside,
            vec![heterogeneous(BLUISH, phase, grid([5, 4, 4], upright))],
            vec![cube(0)],
            true,
        ),
    ]
}
