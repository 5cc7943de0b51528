//! Where the samples of a pass begin: the camera's ray through each sampled pixel. With tiles, those of a whole tile are traced at once, and
//! their batches share them.

use super::path_tracer::Stats;
use super::primary::{PrimarySample, RandomNumbers, Slot, VertexNumbers, pair, shift_numbers, tile_numbers};
use crate::math::DVec2;
use crate::scene::{Queries, Scene, Stop, View};
use crate::shift::{self, Bounds, Draw, Tile, Tiling};

/// A pixel's sample.
pub struct CameraSample {
    /// Number of the pixel, row by row.
    pub pixel: u32,
    /// On the image, and on the lens.
    pub place: DVec2,
    pub lens: DVec2,
    pub view: View,
    /// The numbers of the path from vertex 1 on.
    pub numbers: RandomNumbers,
}

/// Those of a pass.
pub struct CameraSamples<'a, Q> {
    scene: &'a Scene<'a>,
    queries: &'a Q,
    seed: u64,
    pass: u64,
    /// How batches are made in this pass.
    pub shift: Option<shift::Options>,
    tiling: Option<Tiling>,
    /// The last tile that was traced, and the bounds of that which the last sample is in.
    tile: Option<Tile>,
    bounds: Option<Bounds>,
}

impl<'a, Q: Queries> CameraSamples<'a, Q> {
    pub fn new(
        scene: &'a Scene<'a>,
        queries: &'a Q,
        shift: Option<shift::Options>,
        seed: u64,
        pass: u64,
    ) -> Result<Self, Stop> {
        if let Some(options) = &shift {
            options.check(scene)?;
        }
        let [x0, y0, x1, y1] = scene.camera.crop;
        let samples = pass as f64 * f64::from(x1 - x0) * f64::from(y1 - y0);
        let shift = shift.map(|options| options.after(samples));
        let tiling = shift.filter(shift::Options::has_views).map(|options| {
            let numbers = tile_numbers(seed, pass);
            Tiling::new(&scene.camera, options.tile_side(), numbers)
        });
        Ok(Self { scene, queries, seed, pass, shift, tiling, tile: None, bounds: None })
    }

    /// That of the sampled pixel number `index`: row by row; with tiles, tile by tile.
    pub fn sample(&mut self, index: u32, stats: &mut Stats) -> Result<CameraSample, Stop> {
        let camera = &self.scene.camera;
        let [x0, y0, x1, _] = camera.crop;
        let width = (x1 - x0).max(1);
        let (x, y) = self.tiling.map_or((x0 + index % width, y0 + index / width), |tiling| tiling.pixel(index));
        let number = |x: u32, y: u32| (y - y0) * width + x - x0;
        let on_lens = |at_camera: VertexNumbers| camera.lens_point(pair(&at_camera, Slot::LightU, Slot::LightV));
        let pixel = number(x, y);
        let mut numbers = RandomNumbers::for_path(self.seed, self.pass, pixel);
        let at_camera = numbers.vertex(0);
        let place = DVec2::new(x.into(), y.into()) + pair(&at_camera, Slot::DirectionU, Slot::DirectionV);
        let lens = on_lens(at_camera);
        if let Some(bounds) = self.tiling.map(|tiling| tiling.tile(x, y))
            && self.bounds != Some(bounds)
        {
            // All paths of a tile go through one point of the lens: that of its first pixel, sampled here or not.
            let [left, top, ..] = bounds;
            let lens = on_lens(RandomNumbers::for_path(self.seed, self.pass, number(left, top)).vertex(0));
            self.bounds = None;
            let tile = shift::made(&mut self.tile);
            tile.retrace(self.scene, self.queries, bounds, place, lens)?;
            stats.rays += tile.views().len() as u64;
            self.bounds = Some(bounds);
        }
        let view = self.view(place, lens, stats)?;
        let lens = if self.bounds.is_some() { camera.on_lens(view.ray.origin) } else { lens };
        Ok(CameraSample { pixel, place, lens, view, numbers })
    }

    /// What the camera sees at an image point.
    fn view(&self, place: DVec2, lens: DVec2, stats: &mut Stats) -> Result<View, Stop> {
        if let Some(view) = self.tile().and_then(|tile| tile.view(place)) {
            return Ok(*view);
        }
        let mut view = [View::through(self.scene, place, lens)];
        View::trace(&mut view, self.scene, self.queries)?;
        stats.rays += 1;
        let [view] = view;
        Ok(view)
    }

    /// The tile that the last sample is in.
    pub fn tile(&self) -> Option<&Tile> {
        self.tile.as_ref().filter(|_| self.bounds.is_some())
    }

    /// The numbers of the batch of that pixel's sample.
    pub fn draw(&self, pixel: u32) -> Draw<impl FnMut() -> f64 + use<Q>> {
        Draw { tiles: tile_numbers(self.seed, self.pass), random: shift_numbers(self.seed, self.pass, pixel) }
    }
}
