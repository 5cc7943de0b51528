//! Where the members of a batch are.

use super::kernel::{Kernel, MAX_SHIFTS, Mode, Options, in_unit_ball};
use super::run::{Place, Progress, Shiftable, volume_to_image};
use super::tile::{Tile, Tiling, collision_probability};
use crate::math::{DVec2, DVec3, DVec4, absorptance, mean};
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

/// Copies of the path in space, each at an offset from its first vertex. Axis by axis, so that a processor weighs several at once.
pub(super) struct Spots {
    /// All members other than the path itself, also those that are not here: off the sampled image, or left out since.
    pub members: usize,
    count: usize,
    offsets: [[f64; ROOM]; 3],
    pixels: [DVec2; ROOM],
}

/// Spots that are weighed together.
pub(super) const LANES: usize = 4;
const ROOM: usize = MAX_SHIFTS.next_multiple_of(LANES);

impl Default for Spots {
    fn default() -> Self {
        Self { members: 0, count: 0, offsets: [[0.0; ROOM]; 3], pixels: [DVec2::ZERO; ROOM] }
    }
}

impl Spots {
    /// Makes those of a batch.
    pub fn fill(&mut self, camera: &Camera, options: &Options, path: &Shiftable, draw: &mut Draw<impl FnMut() -> f64>) {
        (self.members, self.count) = (0, 0);
        spots(camera, options, path, draw, |offset, pixel| {
            self.members += 1;
            if let Some(pixel) = pixel {
                self.push(offset, pixel);
            }
        });
    }

    fn push(&mut self, offset: DVec3, pixel: DVec2) {
        let i = self.count;
        self.pixels[i] = pixel;
        for (axis, coordinate) in self.offsets.iter_mut().zip(offset.to_array()) {
            axis[i] = coordinate;
        }
        self.count = i + 1;
    }

    /// Leaves out those whose offset is not to be kept.
    pub fn retain(&mut self, keep: impl Fn(DVec3) -> bool) {
        let all = core::mem::take(&mut self.count);
        for i in 0..all {
            let offset = DVec3::from_array(self.offsets.each_ref().map(|axis| axis[i]));
            if keep(offset) {
                self.push(offset, self.pixels[i]);
            }
        }
    }

    pub fn len(&self) -> usize {
        self.count
    }

    /// How far they are away along each axis at most.
    pub fn reach(&self) -> DVec3 {
        let mut reach = [DVec4::ZERO; 3];
        for (offsets, _) in self.blocks() {
            reach = core::array::from_fn(|axis| reach[axis].max(offsets[axis].abs()));
        }
        DVec3::from_array(reach.map(DVec4::max_element))
    }

    /// Pixels of up to [`LANES`] of them, and their offsets, axis by axis. (What is in lanes without a pixel has no meaning.)
    pub fn blocks(&self) -> impl Iterator<Item = ([DVec4; 3], &[DVec2])> {
        let [x, y, z] = self.offsets.each_ref().map(|axis| axis.as_chunks::<LANES>().0);
        let offsets = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z].map(DVec4::from_array));
        offsets.zip(self.pixels.get(..self.count).unwrap_or(&[]).chunks(LANES))
    }
}

/// Calls `member` with the steps on the image, in pixels, to the members other than the path itself. `side` is that of a pixel, in world
/// units, where the first vertex is.
fn steps(
    camera: &Camera,
    options: &Options,
    own: DVec2,
    side: f64,
    draw: &mut Draw<impl FnMut() -> f64>,
    mut member: impl FnMut(DVec2),
) {
    let Kernel::Disk(radius) = options.kernel else {
        return Tiling::new(camera, options.tile_side(), draw.tiles).others(own).for_each(member);
    };
    let radius = radius.in_pixels(side);
    let mut step = || radius * DVec2::from_array(in_unit_ball(&mut draw.random));
    let centre = if options.mode == Mode::Exchangeable { step() } else { DVec2::ZERO };
    (0..options.count).for_each(|_| member(centre + step()));
}

/// Moves the path's first vertex in space: calls `member` with the offset, and the pixel where the member is seen (None: not on the
/// sampled image), for each other than the path itself.
#[inline(always)]
fn spots(
    camera: &Camera,
    options: &Options,
    path: &Shiftable,
    draw: &mut Draw<impl FnMut() -> f64>,
    mut member: impl FnMut(DVec3, Option<DVec2>),
) {
    let (own, x) = (path.image.pixel, path.first().x);
    if let Kernel::Ball(radius) = options.kernel {
        let lens = camera.on_lens(path.image.ray.origin);
        let mut offset = || radius * DVec3::from_array(in_unit_ball(&mut draw.random));
        let centre = if options.mode == Mode::Exchangeable { offset() } else { DVec3::ZERO };
        return (0..options.count).map(|_| centre + offset()).for_each(|offset| member(offset, camera.pixel(x + offset, lens)));
    }
    // Parallel to the image plane: a step on the image is as long at all depths, in pixels there.
    let side = camera.pixel_size() * camera.depth(x);
    let (right, down) = (side * camera.right, -side * camera.up);
    steps(camera, options, own, side, draw, |step| {
        let pixel = own + step;
        member(step.x * right + step.y * down, Some(pixel).filter(|pixel| camera.samples(*pixel)));
    });
}

/// Places the members other than the path itself.
pub(super) fn place<'m>(
    camera: &Camera,
    options: &Options,
    path: &Shiftable,
    draw: &mut Draw<impl FnMut() -> f64>,
    members: &'m mut Members,
) -> &'m mut [Member] {
    let lens = camera.on_lens(path.image.ray.origin);
    let x = path.first().x;
    let mut count = 0;
    let mut put = |y: DVec3, image: Option<ImagePoint>| {
        if let Some(slot) = members.0.get_mut(count) {
            // Not the whole slot: its value is large.
            (slot.y, slot.image) = (y, image);
            slot.value = None;
            count += 1;
        }
    };
    if path.first().place.is_surface() {
        let (own, side) = (path.image.pixel, camera.pixel_size() * camera.depth(x));
        steps(camera, options, own, side, draw, |step| {
            let pixel = own + step;
            let image = ImagePoint { pixel, ray: camera.ray(pixel, lens), distance: f64::INFINITY };
            put(x, Some(image).filter(|_| camera.samples(pixel)));
        });
    } else {
        spots(camera, options, path, draw, |offset, pixel| {
            put(x + offset, pixel.map(|pixel| camera.image_point(pixel, x + offset, lens)));
        });
    }
    members.0.get_mut(..count).unwrap_or(&mut [])
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
