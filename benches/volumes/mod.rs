//! Grids in the unit cube to be measured, rays through them, and a camera and a light outside.
#![allow(dead_code)] // Not every benchmark uses all of it.

use criterion::Criterion;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::time::Duration;
use volgrad::math::{Colour, DAffine3, DVec3, Vec3};
use volgrad::medium::{Brick, Density, Grid, Medium, Segment, brick_counts, build_bricks};
use volgrad::phase::Phase;
use volgrad::scene::Camera;

const SEED: u64 = 1;
const RAYS: usize = 4096;

#[derive(Clone, Copy, PartialEq)]
pub enum Shape {
    /// Noise everywhere.
    Full,
    /// Noise in a ball of a tenth of the cube, nothing around it.
    Sparse,
}

pub const SHAPES: [(&str, Shape); 2] = [("full", Shape::Full), ("sparse", Shape::Sparse)];

/// Optical depths across the cube, where it is not empty.
pub const DEPTHS: [(&str, f32); 2] = [("thin", 1.0), ("dense", 30.0)];

/// (3/4π·0.1)^⅓
const BALL_RADIUS: f32 = 0.288;

/// Before the unit cube, looking along z. All is in medium 0.
pub const CAMERA: Camera = Camera {
    position: DVec3::new(0.5, 0.5, -1.0),
    forward: DVec3::Z,
    right: DVec3::X,
    up: DVec3::Y,
    tan_half_fov_x: 0.5,
    width: 64,
    height: 64,
    crop: [0, 0, 64, 64],
    near_clip: 0.0,
    medium: 0,
    lens_radius: 0.0,
    focal_distance: 1.0,
};

/// Above the cube.
pub const LIGHT: DVec3 = DVec3::new(0.5, 1.5, 0.5);

/// Medium 0 as far as a ray or an edge goes.
pub const ONE_SEGMENT: Segment = Segment { end: f32::INFINITY, medium: 0, normal: Vec3 { x: 0.0, y: 0.0, z: 0.0 } };

pub struct Volume {
    size: [i32; 3],
    pub samples: Vec<f32>,
    bricks: Vec<Brick>,
}

impl Volume {
    /// `side`³ samples, uniform in depth·[½, 3/2).
    pub fn new(side: i32, shape: Shape, depth: f32, with_bricks: bool) -> Self {
        let mut rng = Pcg64::seed_from_u64(SEED);
        let size = [side; 3];
        let mut samples = Vec::new();
        let from_centre = |i: i32| (i as f32 + 0.5) / side as f32 - 0.5;
        for (x, y, z) in (0..side).flat_map(|z| (0..side).flat_map(move |y| (0..side).map(move |x| (x, y, z)))) {
            let [x, y, z] = [x, y, z].map(from_centre);
            let inside = shape == Shape::Full || x * x + y * y + z * z < BALL_RADIUS * BALL_RADIUS;
            samples.push(if inside { depth * (0.5 + uniform(&mut rng) as f32) } else { 0.0 });
        }
        let mut bricks = Vec::new();
        if with_bricks {
            bricks.resize(brick_counts(size).iter().product::<i32>() as usize, Brick::default());
            build_bricks(&samples, size, &mut bricks);
        }
        Self { size, samples, bricks }
    }

    pub fn medium(&self) -> Medium<'_> {
        let grid = Grid::new(&self.samples, self.size, DAffine3::IDENTITY, &self.bricks).expect("the counts fit");
        Medium { sigma_t: Colour::ONE, albedo: Colour::ONE, phase: Phase::ISOTROPIC, density: Density::Grid(grid) }
    }
}

pub struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
    pub length: f64,
    /// A uniform number for a distance.
    pub u: f64,
}

/// Rays that pass the whole cube, each through two random points of it.
pub fn rays() -> Vec<Ray> {
    let mut rng = Pcg64::seed_from_u64(SEED);
    let mut ray = || {
        let [a, b] = [0; 2].map(|_| DVec3::from_array([0; 3].map(|_| uniform(&mut rng))));
        let direction = (b - a).normalize();
        // The cube's diagonal is less than 2.
        Ray { origin: a - 2.0 * direction, direction, length: 4.0, u: uniform(&mut rng) }
    };
    (0..RAYS).map(|_| ray()).collect()
}

/// Uniform in [0, 1).
pub fn uniform(rng: &mut Pcg64) -> f64 {
    (rng.next_u64() >> 11) as f64 * f64::exp2(-53.0)
}

/// A second and a half for each: there are many, and all are short.
pub fn criterion() -> Criterion {
    Criterion::default().warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_millis(1200)).sample_size(20)
}
