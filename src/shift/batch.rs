//! A batch: the path where it was sampled and `count` shifted copies, as weighted splats. [Lu20 alg. 2]
//!
//! Differs from [Lu20 alg. 2]: the radius does not shrink within a batch, and the unbiased modes evaluate f(y), visibility included.

use super::link::{First, LinkValue, MAX_LINKS, MAX_WINGS, Shiftable, camera_line, link_geometry, moves_on, towards};
use super::weight::{exact, exchangeable, log_linear};
use super::{MAX_SHIFTS, Mode, Options};
use crate::math::{Colour, DVec2, DVec3, transmittance, uniform_disk};
use crate::medium::{Line, optical_depth};
use crate::scene::{HIT_NONE, HIT_OVERFLOW, HIT_SURFACE, Hit, ImagePoint, Queries, Ray, Scene, Stop, surface_epsilon};

/// What became of a batch's offsets; those that change several contributions differently count once for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BatchStats {
    pub shifts: u64,
    /// Those whose splat stayed at the path's own pixel.
    pub stays: u64,
    pub rays: u64,
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
    first: Option<First>,
    camera_side: Colour,
    pub links: [LinkValue; MAX_LINKS],
}

impl Member {
    const EMPTY: Self = Self {
        y: DVec3::ZERO,
        image: None,
        first: None,
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
    stats: BatchStats,
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
    let on_surface = matches!(path.first, First::Surface { .. });
    if on_surface && options.surface_radius().is_none() {
        splat(path.image.pixel, path.carried(scene));
        return Ok(BatchStats::default());
    }
    let radius = options.radius_at(&scene.camera, path.x);
    let mut batch = Batch { scene, queries, options, path, radius, stats: BatchStats::default() };
    let mut storage = [Member::EMPTY; MAX_SHIFTS + 1];
    let members = storage.get_mut(..=options.count.min(MAX_SHIFTS)).unwrap_or(&mut []);
    match options.surface_radius().filter(|_| on_surface) {
        Some(pixels) => batch.place_on_image(members, pixels, &mut random),
        None => batch.place(members, &mut random),
    }
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
    let BatchStats { rays, occlusion_rays, overflows, .. } = batch.stats;
    Ok(BatchStats { rays, occlusion_rays, overflows, ..stats })
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
        let lens = camera.on_lens(self.path.image.ray.origin);
        own.y = self.path.x;
        own.image = Some(self.path.image);
        own.links = core::array::from_fn(|i| self.path.value(self.scene, i));
        for member in others {
            member.y = centre + offset();
            member.image = camera.project(member.y, lens);
        }
    }

    /// The same for a path whose first vertex is on a surface: image points first, what they see later.
    fn place_on_image(&self, members: &mut [Member], pixels: f64, random: &mut impl FnMut() -> f64) {
        let camera = &self.scene.camera;
        let mut offset = || uniform_disk(DVec2::new(random(), random())) * pixels;
        let own_pixel = self.path.image.pixel;
        let lens = camera.on_lens(self.path.image.ray.origin);
        let centre = match self.options.mode {
            Mode::Exchangeable => own_pixel + offset(),
            _ => own_pixel,
        };
        let Some((own, others)) = members.split_first_mut() else { return };
        own.image = Some(self.path.image);
        own.links = core::array::from_fn(|i| self.path.value(self.scene, i));
        for member in others {
            let pixel = centre + offset();
            let image = ImagePoint { pixel, ray: camera.ray(pixel, lens), distance: f64::INFINITY };
            member.image = Some(image).filter(|_| camera.samples(pixel));
        }
    }

    /// Fills the shifted members' values, zero where f(y) = 0.
    fn evaluate(&mut self, members: &mut [Member]) -> Result<(), Stop> {
        for chunk in members.get_mut(1..).unwrap_or(&mut []).chunks_mut(CHUNK) {
            match self.path.first {
                First::Medium(_) => self.see(chunk)?,
                First::Surface { .. } => self.see_surfaces(chunk)?,
            }
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
                let start = image.ray.origin + image.ray.start * image.ray.direction;
                let length = image.distance - image.ray.start;
                Some(Ray::free(start, image.ray.direction, length, camera.medium))
            },
            |scene, member, hit| {
                let (Some(image), Some(last)) = (member.image, hit.media().last()) else { return };
                let line = camera_line(camera, scene.media, &image, hit.media());
                let first = First::Medium(last.medium);
                member.first = Some(first);
                member.camera_side = first.camera_side(scene, member.y, &image, optical_depth(&line));
            },
        )
    }

    /// The camera side of the members whose image point shows a surface that is not specular.
    fn see_surfaces(&mut self, chunk: &mut [Member]) -> Result<(), Stop> {
        let camera = &self.scene.camera;
        self.ask(
            chunk,
            Q::intersect,
            HIT_SURFACE,
            |member| {
                let image = member.image?;
                let start = image.ray.origin + image.ray.start * image.ray.direction;
                Some(Ray::free(start, image.ray.direction, f64::INFINITY, camera.medium))
            },
            |scene, member, hit| {
                let bsdf = scene.materials.get(hit.material as usize);
                let (Some(image), Some(bsdf)) = (&mut member.image, bsdf.filter(|bsdf| moves_on(bsdf))) else { return };
                image.distance = image.ray.start + f64::from(hit.t);
                member.y = image.ray.origin + image.distance * image.ray.direction;
                let line = camera_line(camera, scene.media, image, hit.media());
                let first = First::surface(hit, bsdf, image.ray.direction);
                member.first = Some(first);
                member.camera_side = first.camera_side(scene, member.y, image, optical_depth(&line));
            },
        )
    }

    /// The value of link `i` for the members that `see` found.
    fn connect(&mut self, chunk: &mut [Member], i: usize) -> Result<(), Stop> {
        let Some(Some(link)) = self.path.links.get(i) else { return Ok(()) };
        let geometry = |scene: &Scene, member: &Member| {
            let (Some(first), Some(image)) = (&member.first, &member.image) else { return None };
            let (direction, distance) = towards(member.y, &link.next);
            let g = link_geometry(scene, first, -image.ray.direction, &link.next, direction, distance) * member.camera_side;
            (g.max_element() > 0.0).then_some((direction, distance, g))
        };
        let scene = self.scene;
        self.unoccluded(
            chunk,
            |member| {
                let (direction, distance, _) = geometry(scene, member)?;
                let first = member.first?;
                let t_min = match first {
                    First::Medium(_) => 0.0,
                    First::Surface { .. } => surface_epsilon(member.y, member.image?.distance).min(0.25 * distance),
                };
                Some(Ray { t_min: t_min as f32, ..Ray::free(member.y, direction, link.next.t_max(distance), first.medium()) })
            },
            |scene, member, hit| {
                let Some((direction, distance, g)) = geometry(scene, member) else { return };
                let line = Line::new(scene.media, member.y, direction, distance, hit.media());
                let colour = transmittance(optical_depth(&line)) * g;
                member.links[i] = LinkValue { colour, wings: link.wing_values(direction) };
            },
        )
    }

    /// Asks which members' rays (none: skipped) are free, and passes these on.
    fn unoccluded(
        &mut self,
        chunk: &mut [Member],
        ray_of: impl Fn(&Member) -> Option<Ray>,
        free: impl Fn(&Scene, &mut Member, &Hit),
    ) -> Result<(), Stop> {
        self.ask(chunk, Q::occluded, HIT_NONE, ray_of, free)
    }

    /// Asks about one ray per member (none: skipped) in one query, and passes on those whose hit is of the kind `wanted`.
    fn ask(
        &mut self,
        chunk: &mut [Member],
        query: impl Fn(&Q, &[Ray], &mut [Hit]) -> Result<(), Stop>,
        wanted: u32,
        ray_of: impl Fn(&Member) -> Option<Ray>,
        found: impl Fn(&Scene, &mut Member, &Hit),
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
        let counter = if wanted == HIT_NONE { &mut self.stats.occlusion_rays } else { &mut self.stats.rays };
        *counter += count as u64;
        query(self.queries, &rays[..count], &mut hits[..count])?;
        for (hit, index) in hits[..count].iter().zip(asked) {
            if hit.kind == wanted {
                hit.check(self.scene)?;
                found(self.scene, &mut chunk[index], hit);
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
