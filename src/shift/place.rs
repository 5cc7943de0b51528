//! Where the members of a batch are.

use super::kernel::{Kernel, MAX_SHIFTS, Mode, Options};
use super::run::{Place, Progress, Shiftable, volume_to_image};
use super::tile::{Tile, Tiling, collision_probability};
use crate::math::{DVec2, DVec3, absorptance, mean};
use crate::medium::{Flight, collision_pdf, sample_distance};
use crate::scene::{Camera, HIT_SURFACE, ImagePoint, Scene, View};

/// What chance has to say about a batch.
#[derive(Clone, Copy, Debug)]
pub struct Draw<R> {
    /// Where the tiles of this pass begin: any numbers, the same for all its paths.
    pub tiles: [u32; 2],
    /// Uniform numbers, independent of those that made the path.
    pub random: R,
}

/// A shifted copy of the path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    /// None: not on the sampled image.
    pub image: Option<ImagePoint>,
    /// The first vertex; on a surface only once it is known.
    pub y: DVec3,
    /// f, once evaluated; None if 0.
    pub value: Option<Progress>,
}

impl Member {
    pub const EMPTY: Self = Self { image: None, y: DVec3::ZERO, value: None };

    pub fn pixel(&self) -> Option<DVec2> {
        self.image.map(|image| image.pixel)
    }

    /// Evaluates f with optical depths linear in the offset. A first vertex on a surface moves in its tangent plane.
    pub fn predict(&mut self, scene: &Scene, path: &Shiftable) {
        let Some(image) = &mut self.image else { return };
        let first = path.first();
        if let Some(value) = &mut self.value {
            path.predict_links(scene, value);
            return;
        }
        if let Place::Surface { normal, .. } = first.place {
            let origin = image.ray.origin;
            let distance = normal.dot(first.x - origin) / normal.dot(image.ray.direction);
            if !(distance > image.ray.start && distance.is_finite()) {
                return;
            }
            image.distance = distance;
            self.y = origin + distance * image.ray.direction;
        }
        self.value = Some(path.predicted(scene, self.y, *image));
    }
}

/// Room for the members of a batch beside the path itself.
pub(super) struct Members(pub [Member; MAX_SHIFTS]);

impl Default for Members {
    fn default() -> Self {
        Self([Member::EMPTY; MAX_SHIFTS])
    }
}

impl Members {
    fn fill(&mut self, members: impl Iterator<Item = Member>) -> &mut [Member] {
        let mut count = 0;
        for (slot, member) in self.0.iter_mut().zip(members) {
            *slot = member;
            count += 1;
        }
        self.0.get_mut(..count).unwrap_or(&mut [])
    }
}

/// A copy of the path in space: its first vertex, and the pixel where that is seen. None: not on the sampled image.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spot {
    pub y: DVec3,
    pub pixel: Option<DVec2>,
}

/// Room for those of a batch. (What is done to them is done to all, step by step: the steps for one wait for each other, those for several
/// do not.)
pub(super) struct Spots([Spot; MAX_SHIFTS]);

impl Default for Spots {
    fn default() -> Self {
        Self([Spot::default(); MAX_SHIFTS])
    }
}

/// Moves the path's first vertex in space, for each member other than the path itself.
pub(super) fn spots<'s>(
    camera: &Camera,
    options: &Options,
    path: &Shiftable,
    draw: &mut Draw<impl FnMut() -> f64>,
    spots: &'s mut Spots,
) -> &'s mut [Spot] {
    let (own, x) = (path.image.pixel, path.first().x);
    if options.kernel == Kernel::Tile {
        let scale = camera.pixel_size() * camera.depth(x);
        let mut count = 0;
        for (spot, offset) in spots.0.iter_mut().zip(Tiling::new(camera, options.tile_side(), draw.tiles).others(own)) {
            let y = x + scale * (offset.x * camera.right - offset.y * camera.up);
            *spot = Spot { y, pixel: Some(own + offset) };
            count += 1;
        }
        return spots.0.get_mut(..count).unwrap_or(&mut []);
    }
    // The kernel is the same at all members: its radius in world units depends on depth alone, which a disk keeps.
    let mut offset = || options.offset(camera, x, &mut draw.random);
    let centre = if options.mode == Mode::Exchangeable { x + offset() } else { x };
    let spots = spots.0.get_mut(..options.count).unwrap_or(&mut []);
    spots.iter_mut().for_each(|spot| spot.y = centre + offset());
    let lens = camera.on_lens(path.image.ray.origin);
    spots.iter_mut().for_each(|spot| spot.pixel = camera.pixel(spot.y, lens));
    spots
}

/// Places the members other than the path itself.
pub(super) fn place<'m>(
    camera: &Camera,
    options: &Options,
    path: &Shiftable,
    draw: &mut Draw<impl FnMut() -> f64>,
    spots: &mut Spots,
    members: &'m mut Members,
) -> &'m mut [Member] {
    let lens = camera.on_lens(path.image.ray.origin);
    if path.first().place.is_surface() && options.kernel != Kernel::Tile {
        let mut offset = || options.image_offset(&mut draw.random);
        let own = path.image.pixel;
        let centre = if options.mode == Mode::Exchangeable { own + offset() } else { own };
        return members.fill((0..options.count).map(|_| {
            let pixel = centre + offset();
            let image = ImagePoint { pixel, ray: camera.ray(pixel, lens), distance: f64::INFINITY };
            Member { image: Some(image).filter(|_| camera.samples(pixel)), y: path.first().x, value: None }
        }));
    }
    let spots = self::spots(camera, options, path, draw, spots);
    for (slot, Spot { y, pixel }) in members.0.iter_mut().zip(spots.iter()) {
        // Not the whole slot: its value is large.
        (slot.y, slot.image) = (*y, pixel.map(|pixel| camera.image_point(pixel, *y, lens)));
        slot.value = None;
    }
    members.0.get_mut(..spots.len()).unwrap_or(&mut [])
}

/// Places the members on the other rays of the tile, and evaluates f there up to the first vertex.
///
/// One on a surface is what the ray meets. One in a medium is where its ray has the same share u of its collisions before it as the
/// path's own ray: in the measure of u and the image, f dt/du takes the place of f, and a density that changes from ray to ray moves
/// the vertex instead of changing f.
pub(super) fn place_on_rays<'m>(scene: &Scene, path: &Shiftable, tile: &Tile, members: &'m mut Members) -> &'m mut [Member] {
    let first = path.first();
    let own = tile.view(path.image.pixel);
    let share = own.map_or(0.0, |view| mean(absorptance(first.depth.at_x)) / collision_probability(view));
    let pdf = own.map_or(0.0, |view| collision_pdf(&view.line(scene, path.image.distance), first.depth.at_x));
    let density = pdf * volume_to_image(&scene.camera, &path.image);
    let own_spread = own.map_or(0.0, |view| collision_probability(view) / density);
    let reached = |view: &View| {
        if first.place.is_surface() {
            return on_surface(scene, view);
        }
        let (value, spread) = in_medium(scene, view, share)?;
        Some(value.scaled(spread / own_spread))
    };
    let others = tile.views().iter().filter(|view| own.is_none_or(|own| own.pixel != view.pixel));
    members.fill(others.map(|view| {
        let value = reached(view);
        let image = ImagePoint { pixel: view.pixel, ray: view.ray, distance: f64::INFINITY };
        Member { image: Some(value.map_or(image, |value| value.image)), y: value.map_or(first.x, |value| value.y), value }
    }))
}

/// The surface that a camera ray meets, if paths may begin to move there.
fn on_surface(scene: &Scene, view: &View) -> Option<Progress> {
    let bsdf = scene.materials.get(view.hit.material as usize).filter(|_| view.hit.kind == HIT_SURFACE)?;
    let place = Place::on_surface(bsdf, &view.hit, view.ray.direction)?;
    let image = ImagePoint { pixel: view.pixel, ray: view.ray, distance: view.length() };
    let y = view.ray.origin + image.distance * view.ray.direction;
    Some(Progress::at_first(scene, y, place, image, view.optical_depth?))
}

/// The vertex in a medium with `share` of the collisions along a camera ray before it, and dV/du there, per area of the image.
fn in_medium(scene: &Scene, view: &View, share: f64) -> Option<(Progress, f64)> {
    let probability = collision_probability(view);
    let line = view.line(scene, view.length());
    let number = share * probability;
    let Flight::Collision { t, medium, optical_depth, pdf } = sample_distance(&line, number) else { return None };
    let image = ImagePoint { pixel: view.pixel, ray: view.ray, distance: t };
    let y = line.origin + t * line.direction;
    let spread = probability / (pdf * volume_to_image(&scene.camera, &image));
    Some((Progress::at_first(scene, y, Place::Medium(medium), image, optical_depth), spread)).filter(|_| spread.is_finite())
}
