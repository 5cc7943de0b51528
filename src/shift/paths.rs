//! Paths of any sampler, one after another: what neighbours have in common is computed once. Those that begin with the same vertices become
//! one batch, and a tile's camera rays serve all paths that are seen at the same place of its pixels.

use super::batch::{Scratch, made};
use super::kernel::Options;
use super::link::{Exit, Onwards};
use super::place::Draw;
use super::run::{Place, RunVertex, Shiftable};
use super::tile::Tile;
use crate::math::{Colour, DVec2};
use crate::scene::{ImagePoint, Queries, Scene, Stop};

/// Paths whose place within the pixel differs by less share rays, in pixels: what single precision leaves of a first vertex' place.
const SAME_PLACE: f64 = 1e-3;

/// The same for places on the lens, in its radius.
const SAME_LENS_PLACE: f64 = 1e-5;

pub struct Paths<'a, Q, R> {
    scene: &'a Scene<'a>,
    queries: &'a Q,
    options: Options,
    tiles: [u32; 2],
    tile: Option<Tile>,
    scratch: &'a mut Scratch,
    /// Not shifted yet, since the next path may join it; none without random numbers.
    waiting: Shiftable,
    random: Option<R>,
}

impl<'a, Q: Queries, R: FnMut() -> f64> Paths<'a, Q, R> {
    /// `tiles`: where tiles begin.
    pub fn new(scene: &'a Scene<'a>, queries: &'a Q, options: Options, tiles: [u32; 2], scratch: &'a mut Scratch) -> Self {
        Self { scene, queries, options, tiles, tile: None, scratch, waiting: Shiftable::none(), random: None }
    }

    /// A path to shift, with random numbers of its own; splats the ones before that have nothing in common with it.
    pub fn add(&mut self, path: &Shiftable, random: R, splat: impl FnMut(DVec2, Colour)) -> Result<(), Stop> {
        if self.random.is_some() && self.waiting.join(path) {
            return Ok(());
        }
        self.finish(splat)?;
        self.waiting.assign(path);
        self.random = Some(random);
        Ok(())
    }

    /// Splats what waits.
    pub fn finish(&mut self, splat: impl FnMut(DVec2, Colour)) -> Result<(), Stop> {
        let Some(random) = self.random.take() else { return Ok(()) };
        let Self { scene, queries, options, tiles, tile, scratch, waiting: path, .. } = self;
        if options.has_views() {
            let tile = made(tile);
            if !has_view(scene, tile, &path.image) {
                tile.retrace_around(scene, *queries, options, *tiles, &path.image)?;
            }
        }
        let draw = Draw { tiles: *tiles, random };
        scratch.shift(scene, *queries, options, path, tile.as_ref(), draw, splat).map(|_| ())
    }
}

/// Whether a tile serves an image point.
fn has_view(scene: &Scene, tile: &Tile, image: &ImagePoint) -> bool {
    tile.view(image.pixel).is_some_and(|view| {
        let on_lens = (view.ray.origin - image.ray.origin).length() <= SAME_LENS_PLACE * scene.camera.lens_radius;
        on_lens && (view.pixel - image.pixel).abs().max_element() < SAME_PLACE
    })
}

impl Shiftable {
    /// Takes the contribution of `other` along, a path from `from_path`. False, and nothing done: it begins with other vertices, or there is
    /// no room.
    fn join(&mut self, other: &Self) -> bool {
        let begins_alike = self.image.ray.origin == other.image.ray.origin
            && self.run().iter().zip(other.run()).all(|(vertex, of_other)| is_same(vertex, of_other));
        let Some(new) = other.onwards.filter(|_| begins_alike && self.chain.is_none()) else { return false };
        self.take_along(&new) && {
            // Those that the run of this one lacks.
            other.run().iter().skip(self.run().len()).all(|vertex| self.push(*vertex))
        }
    }

    /// Adds what goes on by another path's link. Its vertices are the run's as far as that goes.
    fn take_along(&mut self, new: &Onwards) -> bool {
        match &mut self.onwards {
            Some(known) if known.from == new.from && known.link.next == new.link.next => known.take_along(new),
            // The last one is the likeliest to be shared by the next: it is where the sampler went on.
            Some(known) => {
                let leaving = known.as_exit();
                leaving.is_some_and(|exit| self.leave(exit)) && {
                    self.onwards = Some(*new);
                    true
                }
            }
            None => false,
        }
    }
}

impl Onwards {
    /// Adds the contributions of the same link.
    fn take_along(&mut self, new: &Self) -> bool {
        let Some((to_other, rest)) = new.wings().first() else {
            self.plain += new.plain;
            return true;
        };
        let count = self.wing_count;
        if let Some((_, sum)) = self.wings.iter_mut().take(count).find(|(known, _)| known == to_other) {
            *sum += *rest;
            return true;
        }
        self.add_wing(*to_other, *rest);
        self.wing_count > count
    }

    /// The same as a link of its own, if it carries only one contribution.
    fn as_exit(&self) -> Option<Exit> {
        let (wing, rest) = match self.wings() {
            [] => (None, self.plain),
            [(to_other, rest)] if self.plain == Colour::ZERO => (Some((self.phase, *to_other)), *rest),
            _ => return None,
        };
        Some(Exit { from: self.from, link: self.link, wing, rest })
    }
}

fn is_same(a: &RunVertex, b: &RunVertex) -> bool {
    let same_place = match (a.place, b.place) {
        (Place::Medium(a), Place::Medium(b)) => a == b,
        (Place::Surface { material: a, user: c, .. }, Place::Surface { material: b, user: d, .. }) => (a, c) == (b, d),
        _ => false,
    };
    same_place && a.x == b.x
}
