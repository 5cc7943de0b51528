//! Bidirectional path tracing in media: every way to split a path between a walk from the camera and one from a light, weighted with the
//! true densities, free flight and phase functions included.

mod connect;
mod mis;
mod shiftable;
mod subpath;
pub mod thesis;
mod vertex;

pub use connect::{Connection, Connector};
pub use mis::Heuristic;
pub use shiftable::Joined;
pub use subpath::{Limits, MAX_LENGTH, Subpath, from_camera, from_light};
pub use vertex::{Edge, Kind, Vertex};

use super::path_tracer::Stats;
use super::primary::{PrimarySample, RandomNumbers, Slot, number, pair};
use crate::film::Film;
use crate::math::{Colour, DVec2};
use crate::scene::{GUIDE_SIDE, Queries, Scene, Stop, View};
use core::ops::Range;

#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Most edges of a path, at most [`MAX_LENGTH`].
    pub max_length: u32,
    /// Vertices of a subpath before Russian roulette begins.
    pub rr_depth: u32,
    pub seed: u64,
    pub heuristic: Heuristic,
}

/// A way to make a path: with `camera` vertices of a subpath from there, and `light` ones from a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Technique {
    pub camera: usize,
    pub light: usize,
}

/// What one technique (s, t) made: s vertices from a light, t from the camera.
pub struct Sample<'c, 'a> {
    pub camera: &'c [Vertex<'a>],
    pub light: &'c [Vertex<'a>],
    pub connection: Connection,
}

/// The sampler; one may be used by any number of threads.
#[derive(Clone, Copy, Debug)]
pub struct Bidirectional<'a, Q> {
    pub scene: &'a Scene<'a>,
    pub queries: &'a Q,
    pub options: Options,
}

impl<'a, Q: Queries> Bidirectional<'a, Q> {
    /// One subpath through each of `pixels` of the camera's crop, numbered row by row, one from a light for each, and all their
    /// connections.
    pub fn sample_pixels(&self, pass: u64, pixels: Range<u32>, film: &mut Film, stats: &mut Stats) -> Result<(), Stop> {
        self.splat_pixels(pass, pixels, film, stats, |sample| sample.connection.value * sample.connection.weight)
    }

    /// The same samples, of which only what one technique makes is kept: `weighted`, all techniques sum to the image; else each that can make
    /// all paths of a length shows all of them.
    pub fn sample_technique(
        &self,
        technique: Technique,
        weighted: bool,
        pass: u64,
        pixels: Range<u32>,
        film: &mut Film,
        stats: &mut Stats,
    ) -> Result<(), Stop> {
        self.splat_pixels(pass, pixels, film, stats, |sample| {
            let Connection { value, weight, .. } = sample.connection;
            match (Technique { camera: sample.camera.len(), light: sample.light.len() }) == technique {
                true if weighted => value * weight,
                true => value,
                false => Colour::ZERO,
            }
        })
    }

    /// Adds `share` of everything that the pixels' samples make.
    fn splat_pixels(
        &self,
        pass: u64,
        pixels: Range<u32>,
        film: &mut Film,
        stats: &mut Stats,
        share: impl Fn(&Sample) -> Colour,
    ) -> Result<(), Stop> {
        let (mut camera, mut light) = (Subpath::default(), Subpath::default());
        // All of a sample or nothing: a callback can stop it, but only before its first splat.
        let mut seen_elsewhere = [(DVec2::ZERO, Colour::ZERO); MAX_LENGTH];
        for pixel in pixels {
            let (mut sum, mut count) = (Colour::ZERO, 0);
            let place = self.sample(pass, pixel, &mut camera, &mut light, stats, |sample| {
                if sample.camera.len() > 1 {
                    sum += share(sample);
                } else if let Some(splat) = seen_elsewhere.get_mut(count) {
                    *splat = (sample.connection.pixel, share(sample));
                    count += 1;
                }
            })?;
            seen_elsewhere.iter().take(count).for_each(|(place, value)| film.add(*place, *value));
            film.add(place, sum);
            stats.paths += 1;
        }
        Ok(())
    }

    /// What the subpaths from each light carry, by the numbers that choose their direction: a film of [`GUIDE_SIDE`] pixels' width, with as
    /// many rows for each light. From it [`Guide::learned`] knows where to send them.
    pub fn learn(&self, pass: u64, pixels: Range<u32>, film: &mut Film, stats: &mut Stats) -> Result<(), Stop> {
        let (mut camera, mut light) = (Subpath::default(), Subpath::default());
        for pixel in pixels {
            let mut sum = Colour::ZERO;
            self.sample(pass, pixel, &mut camera, &mut light, stats, |sample| {
                if sample.light.len() > 1 {
                    sum += sample.connection.value * sample.connection.weight;
                }
            })?;
            let first = RandomNumbers::for_light(self.options.seed, pass, pixel).vertex(0);
            if let Some((index, _, _)) = self.scene.lights.pick(number(&first, Slot::Light)) {
                let (u, _) = self.scene.lights.guide(index, pair(&first, Slot::DirectionU, Slot::DirectionV));
                film.add((u + DVec2::new(0.0, index.into())) * GUIDE_SIDE as f64, sum);
            }
            stats.paths += 1;
        }
        Ok(())
    }

    /// Everything that the two subpaths of one sample make, told to `tell` one by one. Returns the image point of the camera's.
    pub fn sample(
        &self,
        pass: u64,
        pixel: u32,
        camera: &mut Subpath<'a>,
        light: &mut Subpath<'a>,
        stats: &mut Stats,
        mut tell: impl FnMut(&Sample),
    ) -> Result<DVec2, Stop> {
        let Options { max_length, rr_depth, seed, heuristic } = self.options;
        let scene = self.scene;
        let longest = (max_length as usize).min(MAX_LENGTH);
        let mut numbers = RandomNumbers::for_path(seed, pass, pixel);
        let first = numbers.vertex(0);
        let [x0, y0, x1, _] = scene.camera.crop;
        let width = (x1 - x0).max(1);
        let corner = DVec2::new((x0 + pixel % width).into(), (y0 + pixel / width).into());
        let place = corner + pair(&first, Slot::DirectionU, Slot::DirectionV);
        let lens = scene.camera.lens_point(pair(&first, Slot::LightU, Slot::LightV));
        let mut view = [View::through(scene, place, lens)];
        View::trace(&mut view, scene, self.queries)?;
        stats.rays += 1;
        let limits = Limits { vertices: longest + 1, rr_depth: rr_depth as usize };
        from_camera(scene, self.queries, &mut view[0], limits, &mut numbers, camera, stats)?;
        let limits = Limits { vertices: longest, ..limits };
        let mut numbers = RandomNumbers::for_light(seed, pass, pixel);
        from_light(scene, self.queries, limits, &mut numbers, light, stats)?;
        let connector = Connector { scene, queries: self.queries, heuristic, pixel: place, lens };
        let (camera, light) = (camera.vertices(), light.vertices());
        for t in 1..=camera.len() {
            for s in 0..=light.len().min((longest + 1).saturating_sub(t)) {
                let (camera, light) = (&camera[..t], &light[..s]);
                if s + t > 2
                    && let Some(connection) = connector.connect(camera, light, stats)?
                {
                    tell(&Sample { camera, light, connection });
                }
            }
        }
        Ok(place)
    }
}
