//! Where the members of a batch are.

use super::kernel::{Kernel, MAX_SHIFTS, Mode, Options};
use super::run::{Place, Progress, Shiftable};
use crate::math::{DVec2, DVec3, floor};
use crate::scene::{Camera, ImagePoint, Scene};

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

    /// Evaluates f with optical depths linear in the offset. A first vertex on a surface moves in its tangent plane.
    pub fn predict(&mut self, scene: &Scene, path: &Shiftable) {
        let Some(image) = &mut self.image else { return };
        let first = path.first();
        if let Place::Surface { normal, .. } = first.place {
            let origin = scene.camera.position;
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
pub(super) struct Members([Member; MAX_SHIFTS]);

impl Default for Members {
    fn default() -> Self {
        Self([Member::EMPTY; MAX_SHIFTS])
    }
}

/// Places the members other than the path itself.
pub(super) fn place<'m>(
    camera: &Camera,
    options: &Options,
    path: &Shiftable,
    draw: &mut Draw<impl FnMut() -> f64>,
    members: &'m mut Members,
) -> &'m mut [Member] {
    let (own, x) = (path.image.pixel, path.first().x);
    let on_surface = path.first().place.is_surface();
    let random = &mut draw.random;
    let mut count = 0;
    let mut add = |y: DVec3, image: Option<ImagePoint>| {
        if let Some(member) = members.0.get_mut(count) {
            *member = Member { image, y, value: None };
            count += 1;
        }
    };
    if options.kernel == Kernel::Tile {
        let scale = camera.pixel_size() * camera.depth(x);
        for offset in tile(camera, options.tile_side(), draw.tiles, own) {
            let pixel = own + offset;
            let y = x + scale * (offset.x * camera.right - offset.y * camera.up);
            let distance = (y - camera.position).length();
            add(y, Some(ImagePoint { pixel, ray: camera.ray(pixel), distance }));
        }
    } else if on_surface {
        let mut offset = || options.image_offset([random(), random()]);
        let centre = if options.mode == Mode::Exchangeable { own + offset() } else { own };
        for _ in 0..options.count {
            let pixel = centre + offset();
            let image = ImagePoint { pixel, ray: camera.ray(pixel), distance: f64::INFINITY };
            add(x, Some(image).filter(|_| camera.samples(pixel)));
        }
    } else {
        // The kernel is the same at all members: its radius in world units depends on depth alone, which a disk keeps.
        let mut offset = || options.offset(camera, x, [random(), random(), random()]);
        let centre = if options.mode == Mode::Exchangeable { x + offset() } else { x };
        for _ in 0..options.count {
            let y = centre + offset();
            add(y, camera.project(y));
        }
    }
    members.0.get_mut(..count).unwrap_or(&mut [])
}

/// The steps from `pixel` to the other sampled pixels of its tile.
fn tile(camera: &Camera, side: u32, begin: [u32; 2], pixel: DVec2) -> impl Iterator<Item = DVec2> {
    let [x0, y0, x1, y1] = camera.crop.map(i64::from);
    let (px, py) = (floor(pixel.x) as i64, floor(pixel.y) as i64);
    let side = i64::from(side);
    let corner = |p: i64, begin: u32| p - (p + i64::from(begin) % side) % side;
    let (left, top) = (corner(px, begin[0]), corner(py, begin[1]));
    let sampled = move |x: i64, y: i64| x >= x0 && x < x1 && y >= y0 && y < y1 && (x, y) != (px, py);
    (top..top + side)
        .flat_map(move |y| (left..left + side).map(move |x| (x, y)))
        .filter(move |(x, y)| sampled(*x, *y))
        .map(move |(x, y)| DVec2::new((x - px) as f64, (y - py) as f64))
}
