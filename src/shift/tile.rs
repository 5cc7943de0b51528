//! Square tiles of pixels, whose paths are shared out among them, and their camera rays, traced once for all.
//! Source: P. Bekaert et al., *Accelerating Path Tracing by Re-Using Paths*, EGWR 2002.

use super::kernel::{MAX_SHIFTS, Options};
use crate::math::{DVec2, floor};
use crate::scene::{Camera, HIT_OVERFLOW, ImagePoint, Queries, Scene, Stop, View};
use core::num::NonZeroU32;

/// How tiles cover the sampled pixels. Those at the border are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiling {
    side: NonZeroU32,
    begin: [u32; 2],
    /// [x0, y0] inclusive to [x1, y1] exclusive.
    crop: [u32; 4],
}

/// The pixels of a tile: [x0, y0] inclusive to [x1, y1] exclusive.
pub type Bounds = [u32; 4];

impl Tiling {
    /// Tiles of `side` × `side` pixels, moved by any two numbers.
    pub fn new(camera: &Camera, side: u32, numbers: [u32; 2]) -> Self {
        let side = NonZeroU32::new(side).unwrap_or(NonZeroU32::MIN);
        Self { side, begin: numbers.map(|n| n % side), crop: camera.crop }
    }

    /// The tile of a sampled pixel.
    pub fn tile(&self, x: u32, y: u32) -> Bounds {
        let [x0, y0, x1, y1] = self.crop;
        let [(left, right), (top, bottom)] = [self.around(x, self.begin[0], x0, x1), self.around(y, self.begin[1], y0, y1)];
        [left, top, right, bottom]
    }

    /// The tile's extent along an axis, between `first` and `end`.
    fn around(&self, p: u32, begin: u32, first: u32, end: u32) -> (u32, u32) {
        let inside = (p % self.side + begin) % self.side;
        (p - inside.min(p - first), (p + self.side.get() - inside).min(end))
    }

    /// The steps from the pixel that contains `pixel` to the others of its tile.
    pub fn others(&self, pixel: DVec2) -> impl Iterator<Item = DVec2> + use<> {
        let (x, y) = (floor(pixel.x) as u32, floor(pixel.y) as u32);
        let [left, top, right, bottom] = self.tile(x, y);
        let all = (top..bottom).flat_map(move |v| (left..right).map(move |u| (u, v)));
        let step = move |u: u32, v: u32| DVec2::new(f64::from(u) - f64::from(x), f64::from(v) - f64::from(y));
        all.filter(move |other| *other != (x, y)).map(move |(u, v)| step(u, v))
    }

    /// The sampled pixel number `index`, counted tile by tile.
    pub fn pixel(&self, index: u32) -> (u32, u32) {
        let [x0, y0, x1, _] = self.crop;
        let width = (x1 - x0).max(1);
        let [_, top, _, bottom] = self.tile(x0, y0 + index / width);
        let (height, in_row) = ((bottom - top).max(1), index - (top - y0) * width);
        let [left, _, right, _] = self.tile(x0 + in_row / height, top);
        let in_tile = in_row - (left - x0) * height;
        let tile_width = (right - left).max(1);
        (left + in_tile % tile_width, top + in_tile / tile_width)
    }
}

/// A tile's camera rays, once they are traced.
pub struct Tile {
    views: [View; MAX_SHIFTS + 1],
    count: usize,
}

impl Default for Tile {
    fn default() -> Self {
        Self { views: core::array::from_fn(|_| View::none()), count: 0 }
    }
}

impl Tile {
    /// Traces the rays from a point of the lens through the same place in all pixels of a tile as `pixel` is in its own.
    pub fn trace(scene: &Scene, queries: &impl Queries, bounds: Bounds, pixel: DVec2, lens: DVec2) -> Result<Self, Stop> {
        let mut tile = Self::default();
        tile.retrace(scene, queries, bounds, pixel, lens)?;
        Ok(tile)
    }

    /// Becomes the tile of an image point; `numbers` say where tiles begin.
    pub fn retrace_around(
        &mut self,
        scene: &Scene,
        queries: &impl Queries,
        options: &Options,
        numbers: [u32; 2],
        image: &ImagePoint,
    ) -> Result<(), Stop> {
        let tiling = Tiling::new(&scene.camera, options.tile_side(), numbers);
        let bounds = tiling.tile(image.pixel.x as u32, image.pixel.y as u32);
        let lens = scene.camera.on_lens(image.ray.origin);
        self.retrace(scene, queries, bounds, image.pixel, lens)
    }

    /// Becomes another tile, as `trace` makes it.
    pub fn retrace(
        &mut self,
        scene: &Scene,
        queries: &impl Queries,
        [x0, y0, x1, y1]: Bounds,
        pixel: DVec2,
        lens: DVec2,
    ) -> Result<(), Stop> {
        let place = DVec2::new(pixel.x - floor(pixel.x), pixel.y - floor(pixel.y));
        self.count = 0;
        let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| DVec2::new(x.into(), y.into())));
        let mut count = 0;
        for (view, pixel) in self.views.iter_mut().zip(pixels) {
            *view = View::through(scene, pixel + place, lens);
            count += 1;
        }
        let views = self.views.get_mut(..count).unwrap_or(&mut []);
        View::trace(views, scene, queries)?;
        for view in views.iter_mut().filter(|view| view.hit.kind != HIT_OVERFLOW) {
            view.collisions(scene);
        }
        self.count = count;
        Ok(())
    }

    pub fn views(&self) -> &[View] {
        self.views.get(..self.count).unwrap_or(&[])
    }

    /// The view of the pixel that contains `pixel`.
    pub fn view(&self, pixel: DVec2) -> Option<&View> {
        let cell = |p: DVec2| (floor(p.x), floor(p.y));
        self.views().iter().find(|view| cell(view.pixel) == cell(pixel))
    }
}
