//! A batch: the path where it was sampled and `count` shifted copies, as weighted splats. [Lu20 alg. 2]
//!
//! Differs from [Lu20 alg. 2]: the radius does not shrink within a batch, and the unbiased modes evaluate f(y), visibility included.

use super::link::{LinkValue, MAX_LINKS, MAX_WINGS, Next, Shiftable, camera_line, camera_side, link_geometry, towards};
use super::weight::{exact, exchangeable, log_linear};
use super::{MAX_SHIFTS, Mode, Options};
use crate::math::{Colour, DVec2, DVec3, transmittance};
use crate::medium::{Line, NONE, optical_depth};
use crate::scene::{HIT_NONE, HIT_OVERFLOW, HIT_SURFACE, Hit, ImagePoint, Queries, Ray, Scene, Stop, surface_epsilon};

/// What became of a batch's offsets; those that change several contributions differently count once for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BatchStats {
    pub shifts: u64,
    /// Those whose splat stayed at the path's own pixel.
    pub stays: u64,
    pub occlusion_rays: u64,
    pub overflows: u64,
}

/// One member of a batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    pub y: DVec3,
    /// None: not on the sampled image.
    pub image: Option<ImagePoint>,
    /// Set once the camera sees y and light scatters there.
    medium: u32,
    camera_side: Colour,
    pub links: [LinkValue; MAX_LINKS],
}

impl Member {
    const EMPTY: Self = Self {
        y: DVec3::ZERO,
        image: None,
        medium: NONE,
        camera_side: Colour::ZERO,
        links: [LinkValue { colour: Colour::ZERO, wings: [0.0; MAX_WINGS] }; MAX_LINKS],
    };
}

/// Rays per query.
const CHUNK: usize = 8;

/// Everything that the steps of one batch share.
struct Batch<'a, Q> {
    scene: &'a Scene<'a>,
    queries: &'a Q,
    options: &'a Options,
    path: &'a Shiftable,
    radius: f64,
    occlusion_rays: u64,
    overflows: u64,
}

/// Splats the path and its shifted copies: `splat(pixel, rgb)` is called `options.count` + 1 times at most. The colours' expected
/// sum is the path's own. `random` gives uniform numbers, independent of those that made the path.
pub fn shift<Q: Queries>(
    scene: &Scene,
    queries: &Q,
    options: &Options,
    path: &Shiftable,
    mut random: impl FnMut() -> f64,
    mut splat: impl FnMut(DVec2, Colour),
) -> Result<BatchStats, Stop> {
    let radius = options.radius_at(&scene.camera, path.x);
    let mut batch = Batch { scene, queries, options, path, radius, occlusion_rays: 0, overflows: 0 };
    let mut storage = [Member::EMPTY; MAX_SHIFTS + 1];
    let members = storage.get_mut(..=options.count.min(MAX_SHIFTS)).unwrap_or(&mut []);
    batch.place(members, &mut random);
    let stats = match options.mode {
        Mode::LogLinear => log_linear(scene, path, members, &mut splat),
        Mode::Exact => {
            batch.evaluate(members)?;
            exact(path, members, &mut splat)
        }
        Mode::Exchangeable => {
            batch.evaluate(members)?;
            exchangeable(path, members, &mut splat)
        }
    };
    Ok(BatchStats { occlusion_rays: batch.occlusion_rays, overflows: batch.overflows, ..stats })
}

impl<Q: Queries> Batch<'_, Q> {
    /// Draws the members' positions; the first is the path's own.
    fn place(&self, members: &mut [Member], random: &mut impl FnMut() -> f64) {
        let camera = &self.scene.camera;
        let mut offset = || self.options.offset(camera, self.radius, [random(), random(), random()]);
        let centre = match self.options.mode {
            Mode::Exchangeable => self.path.x + offset(),
            _ => self.path.x,
        };
        let Some((own, others)) = members.split_first_mut() else { return };
        own.y = self.path.x;
        own.image = Some(self.path.image);
        own.links = core::array::from_fn(|i| self.path.value(self.scene, i));
        for member in others {
            member.y = centre + offset();
            member.image = camera.project(member.y);
        }
    }

    /// Fills the shifted members' values, zero where f(y) = 0.
    fn evaluate(&mut self, members: &mut [Member]) -> Result<(), Stop> {
        for chunk in members.get_mut(1..).unwrap_or(&mut []).chunks_mut(CHUNK) {
            self.see(chunk)?;
            for i in 0..MAX_LINKS {
                if self.path.links[i].is_some() {
                    self.connect(chunk, i)?;
                }
            }
        }
        Ok(())
    }

    /// The camera side of the members that the camera sees in a scattering medium.
    fn see(&mut self, chunk: &mut [Member]) -> Result<(), Stop> {
        let camera = &self.scene.camera;
        self.unoccluded(
            chunk,
            |member| {
                let image = member.image?;
                let start = camera.position + image.ray.start * image.ray.direction;
                let length = image.distance - image.ray.start;
                Some(Ray::free(start, image.ray.direction, length, camera.medium))
            },
            |scene, member, hit| {
                let (Some(image), Some(last)) = (member.image, hit.media().last()) else { return };
                let line = camera_line(camera, scene.media, &image, hit.media());
                member.medium = last.medium;
                member.camera_side = camera_side(scene, member.y, &image, last.medium, optical_depth(&line));
            },
        )
    }

    /// The value of link `i` for the members that `see` found.
    fn connect(&mut self, chunk: &mut [Member], i: usize) -> Result<(), Stop> {
        let Some(Some(link)) = self.path.links.get(i) else { return Ok(()) };
        let geometry = |scene: &Scene, member: &Member| {
            let (Some(medium), Some(image)) = (scene.medium(member.medium), member.image) else { return None };
            let (direction, distance) = towards(member.y, &link.next);
            let g = link_geometry(medium.phase, -image.ray.direction, &link.next, direction, distance);
            (g > 0.0 && member.camera_side.max_element() > 0.0).then_some((direction, distance, g))
        };
        let scene = self.scene;
        self.unoccluded(
            chunk,
            |member| {
                let (direction, distance, _) = geometry(scene, member)?;
                let t_max = match link.next {
                    Next::Point { position, normal: Some(_) } => distance - surface_epsilon(position, distance),
                    _ => distance,
                };
                Some(Ray::free(member.y, direction, t_max, member.medium))
            },
            |scene, member, hit| {
                let Some((direction, distance, g)) = geometry(scene, member) else { return };
                let line = Line::new(scene.media, member.y, direction, distance, hit.media());
                let colour = member.camera_side * transmittance(optical_depth(&line)) * g;
                member.links[i] = LinkValue { colour, wings: link.wing_values(direction) };
            },
        )
    }

    /// Asks about one ray per member (none: skipped) in one query, and passes on the free ones.
    fn unoccluded(
        &mut self,
        chunk: &mut [Member],
        ray_of: impl Fn(&Member) -> Option<Ray>,
        free: impl Fn(&Scene, &mut Member, &Hit),
    ) -> Result<(), Stop> {
        let mut rays = [Ray::default(); CHUNK];
        let mut hits = [const { Hit::EMPTY }; CHUNK];
        let mut asked = [0; CHUNK];
        let mut count = 0;
        for (index, member) in chunk.iter().enumerate() {
            if let Some(ray) = ray_of(member) {
                (rays[count], asked[count]) = (ray, index);
                count += 1;
            }
        }
        if count == 0 {
            return Ok(());
        }
        self.occlusion_rays += count as u64;
        self.queries.occluded(&rays[..count], &mut hits[..count])?;
        for (hit, index) in hits[..count].iter().zip(asked) {
            if hit.kind == HIT_NONE {
                hit.check(self.scene)?;
                free(self.scene, &mut chunk[index], hit);
            } else if hit.kind == HIT_OVERFLOW {
                // More media than fit: f counts as 0 there.
                self.overflows += 1;
            } else if hit.kind != HIT_SURFACE {
                return Err(Stop::InvalidHit);
            }
        }
        Ok(())
    }
}
