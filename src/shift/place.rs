//! Where the members of a batch are.

use super::kernel::{MAX_SHIFTS, Options};
use super::run::{Place, Progress, Shiftable, volume_to_image};
use super::spots::{spots, steps};
use super::tile::Tile;
use crate::math::{DVec2, DVec3, absorptance, mean, transmittance};
use crate::medium::{Flight, collision_pdf};
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
        // One after another, since a value that is not there need not be written; a copy of an empty member would.
        Self(core::array::from_fn(|_| Member { image: None, y: DVec3::ZERO, value: None }))
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
    // None: more media are on the path's own ray than fit. It keeps its light to itself, as its pixel gets none of the others'.
    let own_place = own.and_then(|view| {
        let probability = view.known_collisions()?.probability;
        let pdf = collision_pdf(&view.line(scene, path.image.distance), first.depth.at_x);
        let spread = probability / (pdf * volume_to_image(&scene.camera, &path.image));
        Some((mean(absorptance(first.depth.at_x)) / probability, spread))
    });
    let mut count = 0;
    let others = tile.views().iter().filter(|view| own.is_none_or(|own| own.pixel != view.pixel));
    for (slot, view) in members.0.iter_mut().zip(others) {
        slot.value = if first.place.is_surface() {
            on_surface(scene, view)
        } else {
            own_place.and_then(|(share, own_spread)| {
                let (value, spread) = in_medium(scene, view, share)?;
                Some(value.scaled(spread / own_spread))
            })
        };
        let unknown = ImagePoint { pixel: view.pixel, ray: view.ray, distance: f64::INFINITY };
        (slot.y, slot.image) = slot.value.as_ref().map_or((first.x, Some(unknown)), |value| (value.y, Some(value.image)));
        count += 1;
    }
    members.0.get_mut(..count).unwrap_or(&mut [])
}

/// The surface that a camera ray meets, if paths may begin to move there.
fn on_surface(scene: &Scene, view: &View) -> Option<Progress> {
    let bsdf = scene.materials.get(view.hit.material as usize).filter(|_| view.hit.kind == HIT_SURFACE)?;
    let place = Place::on_surface(bsdf, &view.hit, view.ray.direction)?;
    let image = ImagePoint { pixel: view.pixel, ray: view.ray, distance: view.length() };
    let y = view.ray.origin + image.distance * view.ray.direction;
    Some(Progress::at_first(scene, y, place, image, view.known_collisions()?.optical_depth))
}

/// The vertex in a medium with `share` of the collisions along a camera ray before it, and dV/du there, per area of the image.
fn in_medium(scene: &Scene, view: &View, share: f64) -> Option<(Progress, f64)> {
    let probability = view.known_collisions()?.probability;
    let Flight::Collision(collision) = view.sample_distance(scene, share * probability) else { return None };
    let image = ImagePoint { pixel: view.pixel, ray: view.ray, distance: collision.t };
    let y = image.ray.origin + collision.t * image.ray.direction;
    let spread = probability / (collision.pdf * volume_to_image(&scene.camera, &image));
    let sigma_s = scene.medium(collision.medium)?.albedo * collision.extinction;
    let value =
        Progress::new(scene, y, Place::Medium(collision.medium), image, sigma_s * transmittance(collision.optical_depth));
    Some((value, spread)).filter(|_| spread.is_finite())
}
