//! Bidirectional path tracing in media: every way to split a path between a walk from the camera and one from a light, weighted with the
//! true densities, free flight and phase functions included.

mod bundle;
mod connect;
mod mis;
mod shiftable;
mod subpath;
pub mod thesis;
mod vertex;

pub use bundle::{Bundle, MOST_LIGHT_VERTICES};
pub use connect::{Connection, Connector, Roulette};
pub use mis::{Heuristic, Repertoire};
pub use shiftable::Joined;
pub use subpath::{Limits, MAX_LENGTH, Subpath, from_camera, from_light};
pub use vertex::{Edge, Kind, Vertex};

use super::camera_samples::{CameraSample, CameraSamples};
use super::path_tracer::Stats;
use super::primary::{PrimarySample, RandomNumbers, Slot, number, pair, roulette_numbers};
use crate::film::Film;
use crate::math::{Colour, DVec2, luminance};
use crate::scene::{GUIDE_SIDE, Queries, Scene, Stop};
use crate::shift::{self, Scratch};
use core::ops::Range;

#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Most edges of a path, at most [`MAX_LENGTH`].
    pub max_length: u32,
    /// Vertices of a subpath before Russian roulette begins.
    pub rr_depth: u32,
    pub seed: u64,
    pub heuristic: Heuristic,
    /// Most vertices of a light's subpath.
    pub light_vertices: usize,
    /// What adds less luminance to a pixel is left to chance; 0: nothing is.
    pub roulette: f64,
    /// Batches of the camera subpaths' first vertices, in which techniques are those of [`Options::repertoire`].
    pub shift: Option<shift::Options>,
}

impl Options {
    /// Samples that are shifted begin with the camera's subpath: what a light's subpath shows the camera has a first vertex of its own.
    fn repertoire(&self) -> Repertoire {
        match self.shift {
            Some(_) => Repertoire { camera: 2, light: self.light_vertices.min(MOST_LIGHT_VERTICES) },
            None => Repertoire { light: self.light_vertices, ..Repertoire::ALL },
        }
    }
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
        if self.options.shift.is_some() {
            return self.shift_pixels(pass, pixels, film, stats);
        }
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
        let mut samples = CameraSamples::new(self.scene, self.queries, None, self.options.seed, pass)?;
        for index in pixels {
            let (mut sum, mut count) = (Colour::ZERO, 0);
            let first = samples.sample(index, stats)?;
            let place = first.place;
            self.sample(pass, first, &mut camera, &mut light, stats, |sample| {
                if sample.camera.len() > 1 {
                    sum += share(sample);
                } else if let Some(splat) = seen_elsewhere.get_mut(count) {
                    *splat = (sample.connection.pixel, share(sample));
                    count += 1;
                }
                Ok(())
            })?;
            seen_elsewhere.iter().take(count).for_each(|(place, value)| film.add(*place, *value));
            film.add(place, sum);
            stats.paths += 1;
        }
        Ok(())
    }

    /// The same as `sample_pixels`, with a batch of every sample whose first vertex may move. With tiles, pixels are numbered tile by tile.
    fn shift_pixels(&self, pass: u64, pixels: Range<u32>, film: &mut Film, stats: &mut Stats) -> Result<(), Stop> {
        let (mut camera, mut light) = (Subpath::default(), Subpath::default());
        let mut samples = CameraSamples::new(self.scene, self.queries, self.options.shift, self.options.seed, pass)?;
        let Some(options) = samples.shift else { return Ok(()) };
        let mut bundle = Bundle::default();
        let mut scratch = Scratch::default();
        for index in pixels {
            let first = samples.sample(index, stats)?;
            let (pixel, place) = (first.pixel, first.place);
            bundle.clear();
            self.sample(pass, first, &mut camera, &mut light, stats, |sample| {
                let Sample { camera, light, connection } = sample;
                bundle.add(&Joined { scene: self.scene, camera, light, connection }, self.queries, &options)
            })?;
            let plain = bundle.plain;
            if let Some(path) = bundle.finish() {
                let (tile, mut draw) = (samples.tile(), samples.draw(pixel));
                let roulette = Roulette { threshold: self.options.roulette, number: (draw.random)() };
                if let Some(survival) = roulette.survival(luminance(path.carried(self.scene))) {
                    let splat = |place, colour| film.add(place, colour / survival);
                    let batch = scratch.shift(self.scene, self.queries, &options, path, tile, draw, splat)?;
                    stats.add_batch(&batch);
                }
            }
            // All of a sample or nothing: a callback can stop the shifts, but only before their first splat.
            film.add(place, plain);
            stats.paths += 1;
        }
        Ok(())
    }

    /// What the subpaths from each light carry, by the numbers that choose their direction: a film of [`GUIDE_SIDE`] pixels' width, with as
    /// many rows for each light. From it [`Guide::learned`] knows where to send them.
    pub fn learn(&self, pass: u64, pixels: Range<u32>, film: &mut Film, stats: &mut Stats) -> Result<(), Stop> {
        let (mut camera, mut light) = (Subpath::default(), Subpath::default());
        let mut samples = CameraSamples::new(self.scene, self.queries, None, self.options.seed, pass)?;
        for index in pixels {
            let mut sum = Colour::ZERO;
            let first = samples.sample(index, stats)?;
            let pixel = first.pixel;
            self.sample(pass, first, &mut camera, &mut light, stats, |sample| {
                if sample.light.len() > 1 {
                    sum += sample.connection.value * sample.connection.weight;
                }
                Ok(())
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

    /// Everything that the two subpaths of one sample make, told to `tell` one by one.
    pub fn sample(
        &self,
        pass: u64,
        first: CameraSample,
        camera: &mut Subpath<'a>,
        light: &mut Subpath<'a>,
        stats: &mut Stats,
        mut tell: impl FnMut(&Sample) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let Options { max_length, rr_depth, seed, heuristic, .. } = self.options;
        let repertoire = self.options.repertoire();
        let scene = self.scene;
        let longest = (max_length as usize).min(MAX_LENGTH);
        let CameraSample { pixel, place, lens, mut view, mut numbers } = first;
        let limits = Limits { vertices: longest + 1, rr_depth: rr_depth as usize };
        from_camera(scene, self.queries, &mut view, limits, &mut numbers, camera, stats)?;
        let limits = Limits { vertices: longest.min(repertoire.light), ..limits };
        let mut numbers = RandomNumbers::for_light(seed, pass, pixel);
        from_light(scene, self.queries, limits, &mut numbers, light, stats)?;
        let mut chance = roulette_numbers(seed, pass, pixel);
        let queries = self.queries;
        let (camera, light) = (camera.vertices(), light.vertices());
        for t in repertoire.camera..=camera.len() {
            for s in 0..=light.len().min((longest + 1).saturating_sub(t)) {
                let (camera, light) = (&camera[..t], &light[..s]);
                let roulette = Roulette { threshold: self.options.roulette, number: chance() };
                let connector = Connector { scene, queries, heuristic, repertoire, roulette, pixel: place, lens };
                if s + t > 2
                    && let Some(connection) = connector.connect(camera, light, stats)?
                {
                    tell(&Sample { camera, light, connection })?;
                }
            }
        }
        Ok(())
    }
}
