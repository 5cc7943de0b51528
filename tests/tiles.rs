//! Tiles cover the sampled pixels, each once, whatever the crop; and the map of a tile's pixels onto each other is symmetric: there and
//! back again is where one began, with the Jacobian of that map in the weight.

mod toy;

use proptest::prelude::*;
use std::collections::HashSet;
use toy::Geometry;
use toy::scenes::{World, camera, grid, homogeneous};
use volgrad::math::{Colour, DVec2, DVec3, Vec3, absorptance, luminance, mean, transmittance};
use volgrad::medium::{Line, Medium, optical_depth};
use volgrad::sampler::shift_numbers;
use volgrad::scene::{Camera, HIT_OVERFLOW, Hit, ImagePoint, Light, Queries, Ray, Scene, Stop, View};
use volgrad::shift::{
    Bounds, Depth, Draw, Exit, Kernel, Link, Mode, Next, Options, Place, RunVertex, Shiftable, Tile, Tiling, shift,
};

fn cropped([left, top, width, height]: [u32; 4]) -> Camera {
    Camera { width: 64, height: 64, crop: [left, top, left + width, top + height], ..camera([0.0; 3], 0.5, 64) }
}

fn contains([left, top, right, bottom]: Bounds, (x, y): (u32, u32)) -> bool {
    (left..right).contains(&x) && (top..bottom).contains(&y)
}

fn crops() -> impl Strategy<Value = [u32; 4]> {
    [0..30_u32, 0..30_u32, 1..34_u32, 1..34_u32]
}

proptest! {
    /// Pixels are counted tile by tile: every sampled one once.
    #[test]
    fn every_sampled_pixel_has_one_number(crop in crops(), side in 1..8_u32, begin in any::<[u32; 2]>()) {
        let camera = cropped(crop);
        let tiling = Tiling::new(&camera, side, begin);
        let [x0, y0, x1, y1] = camera.crop;
        let pixels: Vec<_> = (0..(x1 - x0) * (y1 - y0)).map(|index| tiling.pixel(index)).collect();
        prop_assert!(pixels.iter().all(|pixel| contains(camera.crop, *pixel)));
        prop_assert_eq!(pixels.iter().collect::<HashSet<_>>().len(), pixels.len());
        // Once left, no tile is come back to.
        let mut tiles: Vec<Bounds> = pixels.iter().map(|(x, y)| tiling.tile(*x, *y)).collect();
        tiles.dedup();
        prop_assert_eq!(tiles.iter().collect::<HashSet<_>>().len(), tiles.len());
    }

    /// A pixel lies in its tile, and all pixels of a tile say that it is theirs: tiles are a partition of the crop.
    #[test]
    fn tiles_are_a_partition(crop in crops(), side in 1..8_u32, begin in any::<[u32; 2]>()) {
        let camera = cropped(crop);
        let tiling = Tiling::new(&camera, side, begin);
        let [x0, y0, x1, y1] = camera.crop;
        for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
            let tile = tiling.tile(x, y);
            let [left, top, right, bottom] = tile;
            prop_assert!(contains(tile, (x, y)) && right - left <= side && bottom - top <= side);
            prop_assert!(x0 <= left && right <= x1 && y0 <= top && bottom <= y1);
            for (u, v) in [(left, top), (right - 1, top), (left, bottom - 1), (right - 1, bottom - 1)] {
                prop_assert_eq!(tiling.tile(u, v), tile);
            }
            // Only the border cuts tiles.
            prop_assert!(right - left == side || left == x0 || right == x1);
            prop_assert!(bottom - top == side || top == y0 || bottom == y1);
        }
    }

    /// The others and the pixel itself are the tile.
    #[test]
    fn others_are_the_rest_of_the_tile(crop in crops(), side in 1..8_u32, begin in any::<[u32; 2]>(), at in any::<[u32; 2]>()) {
        let camera = cropped(crop);
        let tiling = Tiling::new(&camera, side, begin);
        let (x, y) = (crop[0] + at[0] % crop[2], crop[1] + at[1] % crop[3]);
        let tile = tiling.tile(x, y);
        let own = DVec2::new(f64::from(x) + 0.7, f64::from(y) + 0.1);
        let others: HashSet<(u32, u32)> = tiling.others(own).map(|step| ((own + step).x as u32, (own + step).y as u32)).collect();
        let count = (tile[2] - tile[0]) * (tile[3] - tile[1]);
        prop_assert_eq!(tiling.others(own).count() as u32, count - 1);
        prop_assert!(others.len() as u32 == count - 1 && !others.contains(&(x, y)));
        prop_assert!(others.iter().all(|other| contains(tile, *other)));
    }
}

/// All tilings are equally likely: over all places where tiles begin, two neighbours share a tile in (side - 1)/side of them.
#[test]
fn tiles_begin_anywhere() {
    let camera = cropped([0, 0, 64, 64]);
    for side in 2..7_u32 {
        let shared = (0..side).filter(|begin| Tiling::new(&camera, side, [*begin, 0]).tile(31, 30)[2] > 32);
        assert_eq!(shared.count() as u32, side - 1);
    }
}

/// A medium of a density that changes from ray to ray, in front of nothing, under a light at infinity.
fn world(sigma_t: [f64; 3]) -> World {
    let (low, high) = ([-1.1, -1.0, -0.7], [1.0, 1.1, 0.9]);
    let density = grid(low, high, [5, 4, 6], |[x, y, z]| 0.3 + ((x * 5 + y * 3 + z * 7) % 11) as f32 * 0.2);
    let medium = Medium { density, ..homogeneous(sigma_t, [0.9, 0.8, 0.7], 0.4) };
    World::new(camera([0.1, -0.2, -3.0], 0.3, 8))
        .medium(low, high, medium)
        .light(Light::Directional { direction: -TO_LIGHT, irradiance: Colour::ONE }, 1.0)
}

const TO_LIGHT: DVec3 = DVec3::new(0.48, 0.8, 0.36);
/// Where in its pixel a path is.
const PLACE: DVec2 = DVec2::new(0.3, 0.6);
const TILE: Bounds = [2, 3, 5, 6];

/// A point of the medium on a camera ray, and all that f and the map are made of there.
struct Point<'a> {
    scene: &'a Scene<'a>,
    view: View,
    t: f64,
    x: DVec3,
    /// To the camera, and to the light.
    depths: [Colour; 2],
}

impl<'a> Point<'a> {
    fn new(scene: &'a Scene<'a>, world: &World, view: View, t: f64) -> Self {
        let x = view.ray.origin + t * view.ray.direction;
        let mut hits = [volgrad::scene::Hit::EMPTY];
        world
            .geometry
            .occluded(&[Ray::free(x, TO_LIGHT, f64::INFINITY, world.geometry.medium_at(x))], &mut hits)
            .expect("never stops");
        let to_light = Line::new(scene.media, x, TO_LIGHT, f64::INFINITY, hits[0].media());
        let depths = [optical_depth(&view.line(scene, t)), optical_depth(&to_light)];
        Self { scene, view, t, x, depths }
    }

    /// Probability of a collision on the whole ray.
    fn probability(&self) -> f64 {
        mean(absorptance(optical_depth(&self.view.line(self.scene, self.view.length()))))
    }

    /// Share of the ray's collisions before the point.
    fn share(&self) -> f64 {
        mean(absorptance(self.depths[0])) / self.probability()
    }

    /// The share's derivative by t.
    fn density(&self) -> f64 {
        mean(self.scene.media[0].sigma_t(self.x) * transmittance(self.depths[0])) / self.probability()
    }

    /// f in the measure of the share and the image: there We G dV = dA/A dt.
    fn f(&self) -> Colour {
        let medium = &self.scene.media[0];
        let phase = medium.phase.eval(-self.view.ray.direction.dot(TO_LIGHT));
        medium.sigma_s(self.x) * transmittance(self.depths[0] + self.depths[1]) * phase / self.density()
    }

    fn path(&self) -> Shiftable {
        let ray = self.view.ray;
        let image = ImagePoint { pixel: self.view.pixel, ray, distance: self.t };
        let link = Link { next: Next::Direction(TO_LIGHT), depth: Depth::constant(self.depths[1]) };
        let depth = Depth::constant(self.depths[0]);
        let first = RunVertex { x: self.x, place: Place::Medium(0), depth, to_previous: -ray.direction, distance: self.t };
        let mut path = Shiftable::new(image, first);
        path.leave(Exit { from: 0, link, wing: None, rest: Colour::ONE });
        path
    }
}

/// The point of another pixel's ray with the same share, by bisection.
fn mapped<'a>(scene: &'a Scene<'a>, world: &World, view: View, share: f64) -> Point<'a> {
    let (mut low, mut high) = (view.ray.start, 10.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        let below = Point::new(scene, world, view, middle).share() < share;
        *(if below { &mut low } else { &mut high }) = middle;
    }
    Point::new(scene, world, view, 0.5 * (low + high))
}

/// What the batch of the path through a point gives other pixels, times the number of members, in luminances of the path.
fn weights(scene: &Scene, world: &World, point: &Point) -> Vec<(DVec2, Colour)> {
    let path = point.path();
    let tile = Tile::trace(scene, &world.geometry, TILE, point.view.pixel, DVec2::ZERO).expect("never stops");
    let options = Options::new(Mode::Exact, Kernel::Tile, 8);
    let own = luminance(path.carried(scene));
    let mut splats = vec![];
    let draw = Draw { tiles: [0; 2], random: shift_numbers(0, 0, 0) };
    let add = |pixel, colour: Colour| splats.push((pixel, 9.0 * colour / own));
    shift(scene, &world.geometry, &options, &path, Some(&tile), draw, add).expect("never stops");
    splats.pop();
    splats
}

#[test]
fn the_map_of_a_tile_is_its_own_inverse() {
    let world = world([0.9, 1.3, 1.8]);
    let scene = world.scene();
    let own = DVec2::new(3.0, 4.0) + PLACE;
    let tile = Tile::trace(&scene, &world.geometry, TILE, own, DVec2::ZERO).expect("never stops");
    let view = *tile.view(own).expect("in the tile");
    let mut compared = 0;
    for t in [2.35, 2.6, 2.9, 3.3, 3.7] {
        let x = Point::new(&scene, &world, view, t);
        let there = weights(&scene, &world, &x);
        assert_eq!(there.len(), 8);
        for (pixel, weight) in there.into_iter().filter(|(_, weight)| luminance(*weight) > 0.0) {
            let y = mapped(&scene, &world, *tile.view(pixel).expect("in the tile"), x.share());
            let expected = y.f() / luminance(x.f());
            assert!((weight - expected).length() < 1e-9 * expected.length(), "{weight} is not {expected}");
            let back = weights(&scene, &world, &y);
            let (_, back) = back.iter().find(|(pixel, _)| *pixel == own).expect("x is in the tile of y");
            let product = luminance(weight) * luminance(*back);
            assert!((product - 1.0).abs() < 1e-9, "{product}");
            compared += 1;
        }
    }
    println!("{compared} pairs");
    assert!(compared > 30);
}

/// A host to which the ray along `direction` passes more media than fit.
struct Overflowing<'a> {
    geometry: &'a Geometry,
    direction: Vec3,
}

impl Queries for Overflowing<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.geometry.intersect(rays, hits)?;
        for (_, hit) in rays.iter().zip(hits).filter(|(ray, _)| ray.direction == self.direction) {
            hit.kind = HIT_OVERFLOW;
        }
        Ok(())
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.geometry.occluded(rays, hits)
    }
}

/// Of a pixel whose own ray is not known the path keeps its light, and other pixels' paths give it none.
#[test]
fn what_is_seen_through_too_many_media_stays_where_it_is() {
    let world = world([1.3; 3]);
    let scene = world.scene();
    let [own, other] = [DVec2::new(3.0, 4.0), DVec2::new(2.0, 4.0)].map(|pixel| pixel + PLACE);
    let host = Overflowing { geometry: &world.geometry, direction: scene.camera.ray(own, DVec2::ZERO).direction.into() };
    let tile = Tile::trace(&scene, &host, TILE, own, DVec2::ZERO).expect("never stops");
    for pixel in [own, other] {
        let known = Tile::trace(&scene, &world.geometry, TILE, own, DVec2::ZERO).expect("never stops");
        let path = Point::new(&scene, &world, *known.view(pixel).expect("in the tile"), 2.9).path();
        let mut splats = vec![];
        let draw = Draw { tiles: [0; 2], random: shift_numbers(0, 0, 0) };
        let options = Options::new(Mode::Exchangeable, Kernel::Tile, 8);
        shift(&scene, &host, &options, &path, Some(&tile), draw, |p, c| splats.push((p, c))).expect("never stops");
        let at = |pixel: DVec2| splats.iter().filter(|(p, _)| *p == pixel).map(|(_, c)| *c).sum::<Colour>();
        let all = splats.iter().map(|(_, c)| *c).sum::<Colour>();
        let carried = path.carried(&scene);
        let kept = if pixel == own { carried } else { Colour::ZERO };
        assert!((at(own) - kept).length() <= 1e-12 * carried.length(), "{} is not {kept}", at(own));
        assert!(all.is_finite() && luminance(all) > 0.0, "{all}");
    }
}
