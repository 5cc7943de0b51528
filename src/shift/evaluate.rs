//! f of shifted paths, visibility included: the members' rays are asked for together, edge by edge.

use super::batch::BatchStats;
use super::link::Link;
use super::place::Member;
use super::run::{Aim, Place, Progress, Shiftable};
use crate::math::{Colour, DVec3};
use crate::medium::{Line, optical_depth_or_dark};
use crate::scene::{HIT_NONE, HIT_OVERFLOW, HIT_SURFACE, Hit, ImagePoint, Queries, Ray, Scene, Stop, surface_epsilon};

/// Rays per query.
pub(super) const CHUNK: usize = 8;
pub(super) type Hits = [Hit; CHUNK];

/// Everything that the steps of one evaluation share.
pub(super) struct Evaluation<'a, Q> {
    pub scene: &'a Scene<'a>,
    pub(super) queries: &'a Q,
    pub path: &'a Shiftable,
    pub(super) hits: &'a mut Hits,
    pub stats: BatchStats,
}

impl<'a, Q: Queries> Evaluation<'a, Q> {
    pub fn new(scene: &'a Scene<'a>, queries: &'a Q, path: &'a Shiftable, hits: &'a mut Hits) -> Self {
        Self { scene, queries, path, hits, stats: BatchStats::default() }
    }

    /// Fills the members' values; none where f(y) = 0.
    pub fn run(&mut self, members: &mut [Member]) -> Result<(), Stop> {
        members.chunks_mut(CHUNK).try_for_each(|chunk| self.evaluate(chunk))
    }

    fn evaluate(&mut self, chunk: &mut [Member]) -> Result<(), Stop> {
        let path = self.path;
        if path.first().place.is_surface() {
            self.see_surfaces(chunk)?
        } else {
            self.see(chunk)?
        }
        for i in 0..path.run().len() {
            for (g, exit) in path.exits().iter().enumerate().filter(|(_, exit)| exit.from == i) {
                self.connect(chunk, i, &exit.link, |value, aim, depth| value.exit(g, exit, aim, depth))?;
            }
            if let Some(onwards) = path.onwards.as_ref().filter(|onwards| onwards.from == i) {
                self.connect(chunk, i, &onwards.link, |value, aim, depth| value.go_onwards(onwards, aim, depth))?;
            }
            if let Some(chain) = path.chain.as_ref().filter(|chain| chain.from == i) {
                self.follow(chunk, chain)?;
            }
            if i + 1 < path.run().len() {
                self.step(chunk, i + 1)?;
            }
        }
        Ok(())
    }

    /// The members that the camera sees in a medium, but for those that are known.
    fn see(&mut self, chunk: &mut [Member]) -> Result<(), Stop> {
        let camera = &self.scene.camera;
        self.ask(
            chunk,
            Q::occluded,
            HIT_NONE,
            |member| unseen(member).map(|image| (image.ray.free(camera, image.distance), image)),
            |scene, member, image, hit| {
                let Some(last) = hit.media().last() else { return };
                let line = image.ray.line(scene, image.distance, hit.media());
                let place = Place::Medium(last.medium);
                member.value = Some(Progress::at_first(scene, member.y, place, image, optical_depth_or_dark(&line)));
            },
        )
    }

    /// The members whose image point shows a surface where paths may begin to move, but for those that are known.
    fn see_surfaces(&mut self, chunk: &mut [Member]) -> Result<(), Stop> {
        let camera = &self.scene.camera;
        self.ask(
            chunk,
            Q::intersect,
            HIT_SURFACE,
            |member| unseen(member).map(|image| (image.ray.free(camera, f64::INFINITY), image)),
            |scene, member, mut image, hit| {
                let bsdf = scene.materials.get(hit.material as usize);
                let Some(place) = bsdf.and_then(|bsdf| Place::on_surface(bsdf, hit, image.ray.direction)) else { return };
                image.distance = image.ray.start + f64::from(hit.t);
                member.y = image.ray.origin + image.distance * image.ray.direction;
                let line = image.ray.line(scene, image.distance, hit.media());
                member.image = Some(image);
                member.value = Some(Progress::at_first(scene, member.y, place, image, optical_depth_or_dark(&line)));
            },
        )
    }

    /// A link from the run's vertex `i`.
    fn connect(
        &mut self,
        chunk: &mut [Member],
        i: usize,
        link: &Link,
        arrive: impl Fn(&mut Progress, &Aim, Colour),
    ) -> Result<(), Stop> {
        let (scene, path) = (self.scene, self.path);
        self.ask(
            chunk,
            Q::occluded,
            HIT_NONE,
            |member| {
                let value = member.value.as_ref()?;
                let aim = value.aim(scene, path, i, link)?;
                Some((ray(value, path, i, aim.direction, aim.distance, link.next.t_max(aim.distance)), aim))
            },
            |scene, member, aim, hit| {
                let Some(value) = &mut member.value else { return };
                let line = Line::new(scene.media, value.vertex(path, i), aim.direction, aim.distance, hit.media());
                arrive(value, &aim, optical_depth_or_dark(&line));
            },
        )
    }

    /// From the run's vertex before `i` to that one. Members with something in the way stay behind; their links so far keep their values.
    fn step(&mut self, chunk: &mut [Member], i: usize) -> Result<(), Stop> {
        let path = self.path;
        let Some(vertex) = path.run().get(i) else { return Ok(()) };
        let (direction, distance) = (-vertex.to_previous, vertex.distance);
        self.ask(
            chunk,
            Q::occluded,
            HIT_NONE,
            |member| {
                let value = member.value.as_ref().filter(|value| value.carries(i - 1))?;
                Some((ray(value, path, i - 1, direction, distance, distance), ()))
            },
            |scene, member, (), hit| {
                let (Some(value), Some(last)) = (&mut member.value, hit.media().last()) else { return };
                let line = Line::new(scene.media, value.vertex(path, i - 1), direction, distance, hit.media());
                value.step(scene, path, i, Place::Medium(last.medium), optical_depth_or_dark(&line));
            },
        )
    }

    /// Asks about one ray per member (none: skipped) in one query, and passes on those whose hit is of the kind `wanted`, with what
    /// was known of the ray.
    fn ask<T>(
        &mut self,
        chunk: &mut [Member],
        query: impl Fn(&Q, &[Ray], &mut [Hit]) -> Result<(), Stop>,
        wanted: u32,
        ray_of: impl Fn(&Member) -> Option<(Ray, T)>,
        found: impl Fn(&Scene, &mut Member, T, &Hit),
    ) -> Result<(), Stop> {
        let mut rays = [Ray::default(); CHUNK];
        let mut asked = [const { None }; CHUNK];
        let mut count = 0;
        for (index, member) in chunk.iter().enumerate() {
            if let Some((ray, known)) = ray_of(member)
                && let (Some(free), Some(known_of)) = (rays.get_mut(count), asked.get_mut(count))
            {
                (*free, *known_of) = (ray, Some((index, known)));
                count += 1;
            }
        }
        let (Some(rays), Some(hits)) = (rays.get(..count), self.hits.get_mut(..count)) else { return Ok(()) };
        if rays.is_empty() {
            return Ok(());
        }
        let counter = if wanted == HIT_NONE { &mut self.stats.occlusion_rays } else { &mut self.stats.rays };
        *counter += count as u64;
        query(self.queries, rays, hits)?;
        for (hit, (index, known)) in hits.iter().zip(asked.into_iter().flatten()) {
            if hit.kind == wanted {
                hit.check(self.scene)?;
                if let Some(member) = chunk.get_mut(index) {
                    found(self.scene, member, known, hit);
                }
            } else if hit.kind == HIT_OVERFLOW {
                // More media than fit: f counts as 0 there.
                self.stats.overflows += 1;
            } else if hit.kind != HIT_NONE && hit.kind != HIT_SURFACE {
                return Err(Stop::InvalidHit);
            }
        }
        Ok(())
    }
}

/// A member's place on the image, unless what is there is known.
fn unseen(member: &Member) -> Option<ImagePoint> {
    member.image.filter(|_| member.value.is_none())
}

/// From the run's vertex `i`.
pub(super) fn ray(value: &Progress, path: &Shiftable, i: usize, direction: DVec3, distance: f64, t_max: f64) -> Ray {
    let x = value.vertex(path, i);
    let t_min = match value.place {
        Place::Medium(_) => 0.0,
        Place::Surface { .. } => surface_epsilon(x, value.image.distance).min(0.25 * distance),
    };
    Ray { t_min: t_min as f32, ..Ray::free(x, direction, t_max, value.place.medium()) }
}
