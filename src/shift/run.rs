//! What of a path changes when its run moves, and what stays.
//!
//! The run x_1 … x_m are the vertices that move by one offset: medium vertices from the camera on, or a single one on a surface.
//! Contributions leave it by links: exits from any of its vertices, to a light above all, and onwards from the last. Each is
//!
//! ```text
//! f = A_i(x) · L(x) · w(x) · rest        A_1 = We G Tr σ_s,   A_{i+1} = A_i f_p Tr σ_s,   L = f_p G Tr  (or f_r G Tr)
//! ```
//!
//! with w the phase function where the link ends, if it ends in a medium. `rest` stays; so do all distances and directions inside the run, whose G is
//! part of it. On a surface A_1 = Tr, in image measure: We G dA(x_1) is the image's own area.

use super::chain::Chain;
use super::kernel::MAX_RUN;
use super::link::{Depth, Exit, Link, MAX_WINGS, Onwards};
use crate::math::{Colour, DVec3, transmittance};
use crate::medium::NONE;
use crate::scene::{Bsdf, Camera, Hit, ImagePoint, Scene, SurfacePoint};

/// What scatters at a vertex of the run.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// The medium of this index.
    Medium(u32),
    /// A surface, seen from the side that `normal` points to; `medium` is on that side. `user` is `volgrad_hit.user`.
    Surface { material: u32, normal: DVec3, medium: u32, user: u64 },
}

impl Place {
    /// The surface that a camera ray along `direction` hit. None where paths do not move: if it is specular, or light passes it.
    pub fn on_surface(bsdf: &Bsdf, hit: &Hit, direction: DVec3) -> Option<Self> {
        let outside = hit.unit_normal();
        let normal = Self::normal(bsdf, outside, -direction)?;
        let medium = hit.medium_beyond(normal == outside);
        Some(Self::Surface { material: hit.material, normal, medium, user: hit.user })
    }

    /// The normal on the side that the camera sees; None as for `on_surface`.
    pub(super) fn normal(bsdf: &Bsdf, outside: DVec3, to_camera: DVec3) -> Option<DVec3> {
        (!bsdf.transmits() && !bsdf.is_specular()).then(|| bsdf.facing(outside, to_camera))
    }

    /// f_p, or f_r·cos, at `x`.
    pub(super) fn scattering(&self, scene: &Scene, x: DVec3, to_previous: DVec3, to_next: DVec3) -> Colour {
        match *self {
            Self::Medium(index) => {
                let phase = scene.medium(index).map(|medium| medium.phase);
                Colour::splat(phase.map_or(0.0, |phase| phase.eval(to_previous.dot(to_next))))
            }
            Self::Surface { material, normal, user, .. } => {
                let (bsdf, at) = (scene.materials.get(material as usize), SurfacePoint { position: x, normal, user });
                bsdf.map_or(Colour::ZERO, |bsdf| bsdf.eval(&at, to_previous, to_next) * normal.dot(to_next).abs())
            }
        }
    }

    /// σ_s at `x`; 1 on a surface.
    pub(super) fn scattering_coefficient(&self, scene: &Scene, x: DVec3) -> Colour {
        match *self {
            Self::Medium(index) => scene.medium(index).map_or(Colour::ZERO, |medium| medium.sigma_s(x)),
            Self::Surface { .. } => Colour::ONE,
        }
    }

    /// The medium in which edges from here start.
    pub fn medium(&self) -> u32 {
        match *self {
            Self::Medium(medium) | Self::Surface { medium, .. } => medium,
        }
    }

    pub fn is_surface(&self) -> bool {
        matches!(self, Self::Surface { .. })
    }
}

/// We cosθ/d²: what a volume at an image point's world point takes of the image's measure, per length along the ray.
pub fn volume_to_image(camera: &Camera, image: &ImagePoint) -> f64 {
    let cosine = image.ray.cosine;
    camera.importance(cosine) * cosine / (image.distance * image.distance)
}

/// A vertex that moves.
#[derive(Clone, Copy, Debug)]
pub struct RunVertex {
    pub x: DVec3,
    pub place: Place,
    /// Of the edge that leads here, from the near plane or from the run's vertex before.
    pub depth: Depth,
    /// Unit direction to the vertex before, and distance from it.
    pub to_previous: DVec3,
    pub distance: f64,
}

impl RunVertex {
    const NONE: Self = Self {
        x: DVec3::ZERO,
        place: Place::Medium(NONE),
        depth: Depth { at_x: Colour::ZERO, slope: [DVec3::ZERO; 3] },
        to_previous: DVec3::Z,
        distance: 0.0,
    };
}

/// Most exits of a run: a next-event estimate from each vertex, or several from one.
const MAX_EXITS: usize = MAX_RUN;

/// Contributions that change differently: the exits', those onwards: without a wing, and with each wing; and that through specular
/// surfaces.
pub(super) const GROUPS: usize = MAX_EXITS + 2 + MAX_WINGS;
pub(super) const PLAIN: usize = MAX_EXITS;
pub(super) const WINGS: usize = MAX_EXITS + 1;
const CHAIN: usize = WINGS + MAX_WINGS;

/// One colour for each group.
pub(super) type Groups = [Colour; GROUPS];

/// A sampled path whose run may move.
#[derive(Clone, Copy, Debug)]
pub struct Shiftable {
    pub image: ImagePoint,
    run: [RunVertex; MAX_RUN],
    length: usize,
    exits: [Exit; MAX_EXITS],
    exit_count: usize,
    pub onwards: Option<Onwards>,
    pub chain: Option<Chain>,
}

impl Shiftable {
    /// No path.
    pub fn none() -> Self {
        let (image, first) = (ImagePoint::default(), RunVertex::NONE);
        let exits = [Exit::NONE; MAX_EXITS];
        Self { image, run: [first; MAX_RUN], length: 0, exits, exit_count: 0, onwards: None, chain: None }
    }

    /// A path without contributions yet.
    pub fn new(image: ImagePoint, first: RunVertex) -> Self {
        let mut path = Self::none();
        path.renew(image, first);
        path
    }

    /// The same in the place of another path that was cleared.
    pub fn renew(&mut self, image: ImagePoint, first: RunVertex) {
        (self.image, self.run[0], self.length) = (image, first, 1);
    }

    /// Becomes another path, without writing what that does not use.
    pub fn assign(&mut self, path: &Self) {
        (self.image, self.length, self.exit_count) = (path.image, path.length, path.exit_count);
        self.run.iter_mut().zip(path.run()).for_each(|(to, from)| *to = *from);
        self.exits.iter_mut().zip(path.exits()).for_each(|(to, from)| *to = *from);
        (self.onwards, self.chain) = (path.onwards, path.chain);
    }

    /// No path.
    pub fn clear(&mut self) {
        (self.length, self.exit_count, self.onwards, self.chain) = (0, 0, None, None);
    }

    pub fn run(&self) -> &[RunVertex] {
        self.run.get(..self.length).unwrap_or(&[])
    }

    pub fn first(&self) -> &RunVertex {
        &self.run[0]
    }

    /// The run's vertex `i` after the first.
    fn later(&self, i: usize) -> Option<&RunVertex> {
        self.run.get(i).filter(|_| i > 0)
    }

    /// The exits, by group.
    pub fn exits(&self) -> &[Exit] {
        self.exits.get(..self.exit_count).unwrap_or(&[])
    }

    /// Adds a contribution that leaves the run, if there is any. False: there is no room.
    pub fn leave(&mut self, exit: Exit) -> bool {
        if !(exit.rest.max_element() > 0.0) {
            return true;
        }
        let slot = self.exits.get_mut(self.exit_count);
        let room = slot.is_some();
        if let Some(slot) = slot {
            *slot = exit;
            self.exit_count += 1;
        }
        room
    }

    /// Appends a vertex to the run. False: it is full.
    pub fn push(&mut self, vertex: RunVertex) -> bool {
        let slot = self.run.get_mut(self.length);
        let room = slot.is_some();
        if let Some(slot) = slot {
            *slot = vertex;
            self.length += 1;
        }
        room
    }

    /// Drops links that carry nothing, and vertices after the last that does. False: none is left.
    pub fn drop_what_carries_nothing(&mut self) -> bool {
        let carries = |rest: &Colour| rest.max_element() > 0.0;
        if !self.rests()[PLAIN..CHAIN].iter().any(carries) {
            self.onwards = None;
        }
        // Exits carry something, whatever they are.
        let from_exits = self.exits().iter().map(|exit| exit.from + 1).max();
        let onwards = self.onwards.map(|onwards| onwards.from + 1);
        let by_chain = self.chain.map(|chain| chain.from + 1);
        self.length = from_exits.max(onwards).max(by_chain).unwrap_or(0);
        self.length > 0
    }

    /// `rest` of each group; 0 for those that carry nothing.
    pub(super) fn rests(&self) -> Groups {
        let mut rests = [Colour::ZERO; GROUPS];
        rests.iter_mut().zip(self.exits()).for_each(|(rest, exit)| *rest = exit.rest);
        if let Some(onwards) = &self.onwards {
            rests[PLAIN] = onwards.plain;
            for (rest, (_, wing)) in rests[WINGS..CHAIN].iter_mut().zip(onwards.wings()) {
                *rest = *wing;
            }
        }
        if let Some(chain) = &self.chain {
            rests[CHAIN] = chain.rest;
        }
        rests
    }

    /// The path where it was sampled.
    pub(super) fn own(&self, scene: &Scene) -> Progress {
        self.predicted(scene, self.first().x, self.image)
    }

    /// Whether all vertices of the run still scatter, each in its own medium, after a move by `offset`.
    pub(super) fn stays_in_media(&self, scene: &Scene, offset: DVec3) -> bool {
        let scatters = |vertex: &RunVertex| {
            scene.medium(vertex.place.medium()).is_some_and(|medium| medium.density.is_positive(vertex.x + offset))
        };
        self.run().iter().all(scatters)
    }

    /// Multiplies what goes onwards by `factor`.
    pub fn scale(&mut self, factor: f64) {
        self.onwards = self.onwards.map(|onwards| onwards.scaled(factor));
        if let Some(chain) = &mut self.chain {
            chain.rest *= factor;
        }
    }

    /// Whether they certainly do, by whatever offset of at most `reach` along each axis.
    pub(super) fn surely_stays_in_media(&self, scene: &Scene, reach: DVec3) -> bool {
        let scatters = |vertex: &RunVertex| {
            let medium = scene.medium(vertex.place.medium());
            medium.is_some_and(|medium| medium.density.is_surely_positive_around(vertex.x, reach))
        };
        self.run().iter().all(scatters)
    }

    /// What the path carries where it was sampled.
    pub fn carried(&self, scene: &Scene) -> Colour {
        self.own(scene).values.iter().zip(self.rests()).map(|(value, rest)| *value * rest).sum()
    }

    /// What an exit from the first vertex carries at x, for each unit of its `rest`.
    pub fn value_of(&self, scene: &Scene, exit: &Exit) -> Colour {
        let mut progress = self.first_alone(scene);
        let Some(aim) = progress.aim(scene, self, 0, &exit.link) else { return Colour::ZERO };
        progress.exit(0, exit, &aim, exit.link.depth.at_x);
        progress.values[0]
    }

    /// What a chain from the first vertex does.
    pub fn value_of_chain(&self, scene: &Scene, chain: &Chain) -> Colour {
        self.first_alone(scene).towards(scene, self, 0, chain.direction) * chain.value
    }

    fn first_alone(&self, scene: &Scene) -> Progress {
        let first = self.first();
        Progress::at_first(scene, first.x, first.place, self.image, first.depth.at_x)
    }

    /// f of the path whose first vertex is `y`, seen at `image`, with optical depths linear in the offset.
    pub(super) fn predicted(&self, scene: &Scene, y: DVec3, image: ImagePoint) -> Progress {
        let depth = self.first().depth.after(y - self.first().x);
        let mut progress = Progress::at_first(scene, y, self.first().place, image, depth);
        self.predict_links(scene, &mut progress);
        progress
    }

    /// The rest of it, from y_1 on.
    pub(super) fn predict_links(&self, scene: &Scene, progress: &mut Progress) {
        let offset = progress.y - self.first().x;
        for i in 0..self.length {
            for (g, exit) in self.exits().iter().enumerate().filter(|(_, exit)| exit.from == i) {
                if let Some(aim) = progress.aim(scene, self, i, &exit.link) {
                    progress.exit(g, exit, &aim, exit.link.depth.after(offset));
                }
            }
            if let Some(onwards) = self.onwards.as_ref().filter(|onwards| onwards.from == i)
                && let Some(aim) = progress.aim(scene, self, i, &onwards.link)
            {
                progress.go_onwards(onwards, &aim, onwards.link.depth.after(offset));
            }
            if let Some(chain) = self.chain.as_ref().filter(|chain| chain.from == i) {
                progress.reach_light_by_chain(progress.towards(scene, self, i, chain.direction) * chain.value);
            }
            if let Some(next) = self.run().get(i + 1) {
                progress.step(scene, self, i + 1, next.place, next.depth.after(offset));
            }
        }
    }
}

/// A shifted path while its factors are multiplied, vertex by vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    pub y: DVec3,
    pub image: ImagePoint,
    /// The vertex of the run that is reached, and what scatters there.
    reached: usize,
    pub place: Place,
    /// A_i there.
    pub a: Colour,
    /// A·L·w of the groups.
    pub values: Groups,
}

/// The direction of a link from a shifted vertex, and A f_p G of it, without Tr.
pub(super) struct Aim {
    pub direction: DVec3,
    pub distance: f64,
    geometry: Colour,
}

impl Progress {
    /// At y_1.
    pub fn at_first(scene: &Scene, y: DVec3, place: Place, image: ImagePoint, optical_depth: Colour) -> Self {
        Self::new(scene, y, place, image, place.scattering_coefficient(scene, y) * transmittance(optical_depth))
    }

    /// At y_1, where σ_s Tr is `scattered`; on a surface Tr.
    pub fn new(scene: &Scene, y: DVec3, place: Place, image: ImagePoint, scattered: Colour) -> Self {
        let measure = if place.is_surface() { 1.0 } else { volume_to_image(&scene.camera, &image) };
        let a = scattered * measure;
        Self { y, image, reached: 0, place, a, values: [Colour::ZERO; GROUPS] }
    }

    /// With A times `factor`, before any link.
    pub fn scaled(self, factor: f64) -> Self {
        Self { a: self.a * factor, ..self }
    }

    /// The position of the run's vertex `i`.
    pub fn vertex(&self, path: &Shiftable, i: usize) -> DVec3 {
        path.later(i).map_or(self.y, |vertex| vertex.x + (self.y - path.first().x))
    }

    fn towards_previous(&self, path: &Shiftable, i: usize) -> DVec3 {
        path.later(i).map_or(-self.image.ray.direction, |vertex| vertex.to_previous)
    }

    /// Whether light gets from vertex `i` to the camera.
    pub fn carries(&self, i: usize) -> bool {
        self.reached == i && self.a.max_element() > 0.0
    }

    /// A f_p, or A f_r cos, from vertex `i` in a direction.
    pub fn towards(&self, scene: &Scene, path: &Shiftable, i: usize, direction: DVec3) -> Colour {
        self.a * self.place.scattering(scene, self.vertex(path, i), self.towards_previous(path, i), direction)
    }

    /// A chain of specular surfaces ends at a light.
    pub fn reach_light_by_chain(&mut self, value: Colour) {
        self.values[CHAIN] = value;
    }

    /// Looks along a link from vertex `i`; None if nothing can go along it.
    pub fn aim(&self, scene: &Scene, path: &Shiftable, i: usize, link: &Link) -> Option<Aim> {
        if !self.carries(i) {
            return None;
        }
        let (direction, distance) = link.next.seen_from(self.vertex(path, i));
        let geometry = self.towards(scene, path, i, direction) * link.next.geometry(direction, distance);
        (geometry.max_element() > 0.0).then_some(Aim { direction, distance, geometry })
    }

    /// What leaves by the exit of group `g` arrives.
    pub fn exit(&mut self, g: usize, exit: &Exit, aim: &Aim, optical_depth: Colour) {
        let value = aim.geometry * transmittance(optical_depth);
        if let Some(group) = self.values.get_mut(g) {
            *group = exit.wing.map_or(value, |(phase, to_other)| value * phase.eval(-aim.direction.dot(to_other)));
        }
    }

    /// The link onwards arrives.
    pub fn go_onwards(&mut self, onwards: &Onwards, aim: &Aim, optical_depth: Colour) {
        let value = aim.geometry * transmittance(optical_depth);
        self.values[PLAIN] = value;
        for (group, (to_other, _)) in self.values[WINGS..CHAIN].iter_mut().zip(onwards.wings()) {
            *group = value * onwards.phase.eval(-aim.direction.dot(*to_other));
        }
    }

    /// From the run's vertex before `i` to that one.
    pub fn step(&mut self, scene: &Scene, path: &Shiftable, i: usize, place: Place, optical_depth: Colour) {
        let (x, to_previous) = (self.vertex(path, i - 1), self.towards_previous(path, i - 1));
        let scattering = self.place.scattering(scene, x, to_previous, -self.towards_previous(path, i));
        let sigma_s = place.scattering_coefficient(scene, self.vertex(path, i));
        self.a *= scattering * sigma_s * transmittance(optical_depth);
        (self.reached, self.place) = (i, place);
    }
}
