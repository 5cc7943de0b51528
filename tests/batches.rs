//! Batches of the path sampler's paths against those of the same paths handed in by a host, and what batches cost.

mod toy;

use std::cell::Cell;
use toy::batch::{batch, record, splats};
use toy::scenes::{World, camera, edges_with_specular_surfaces, homogeneous};
use volgrad::math::{Colour, DVec2, DVec3, DVec4, exp_of_small};
use volgrad::medium::Segment;
use volgrad::path::{Path, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, Vertex};
use volgrad::phase::Phase;
use volgrad::sampler::{self, shift_numbers};
use volgrad::scene::{Hit, Light, Queries, Ray, Stop};
use volgrad::shift::{
    self, Depth, Draw, Exit, Kernel, Link, MAX_RUN, Mode, Next, Onwards, Options, Place, Radius, RunVertex, Shiftable, Tile,
    from_path,
};

/// A host's path, with its memory.
#[derive(Default)]
struct Owned {
    vertices: Vec<Vertex>,
    segments: Vec<Segment>,
    edge_ends: Vec<u32>,
}

impl Owned {
    fn view(&self) -> Path<'_> {
        Path { vertices: &self.vertices, segments: &self.segments, edge_ends: &self.edge_ends }
    }

    /// From the camera through the vertices of a run to what its last one's next-event estimate found. None if single precision has
    /// moved a vertex across a face.
    fn of_next_event(world: &World, run: &[RunVertex], link: &Link) -> Option<Self> {
        let mut path = Self::default();
        let camera = world.camera;
        path.vertices.push(Vertex { kind: VERTEX_CAMERA, position: camera.position.into(), ..Vertex::default() });
        for vertex in run {
            let index = vertex.place.medium();
            let new = Vertex { kind: VERTEX_MEDIUM, index, position: vertex.x.into(), ..Vertex::default() };
            if world.geometry.medium_at(new.position.wide()) != index {
                return None;
            }
            path.vertices.push(new);
        }
        let light = |wanted: fn(&Light) -> bool| world.lights.iter().position(wanted).map(|i| i as u32);
        let (index, position, normal) = match link.next {
            Next::Point { position, normal } => {
                let index = light(|light| matches!(light, Light::Parallelogram { .. }))?;
                (index, position, normal.unwrap_or_default())
            }
            Next::Direction(direction) => {
                let Light::Directional { direction: sun, .. } = world.lights[2] else { panic!("light 2 is the sun") };
                let is_sun = (direction + sun).length() < 1e-12;
                (if is_sun { 2 } else { light(|light| light.is_environment())? }, direction, DVec3::ZERO)
            }
        };
        let (position, normal) = (position.into(), normal.into());
        path.vertices.push(Vertex { kind: VERTEX_LIGHT, index, position, normal, ..Vertex::default() });
        for pair in path.vertices.windows(2) {
            let (from, to) = (pair[0].position.wide(), pair[1].position.wide());
            let at_infinity = pair[1].kind == VERTEX_LIGHT && matches!(link.next, Next::Direction(_));
            let v = if at_infinity { to } else { to - from };
            let length = if at_infinity { f64::INFINITY } else { v.length() };
            path.segments.extend(world.geometry.segments(from, v.normalize(), length)?);
            path.edge_ends.push(path.segments.len() as u32);
        }
        path.view().validate(&world.scene()).ok().map(|_| path)
    }
}

/// The run up to a next-event estimate, with nothing else.
fn next_event_alone(path: &Shiftable, run: &[RunVertex], event: &Exit) -> Shiftable {
    let mut alone = Shiftable::new(path.image, run[0]);
    for vertex in &run[1..] {
        assert!(alone.push(*vertex));
    }
    assert!(alone.leave(*event));
    alone
}

/// Relative to the largest splat. A host's positions are in single precision; the few splats that differ more are near a neighbour, or have
/// an offset within rounding of the stay rule's bounds or of an edge.
const SINGLE: f64 = 1e-6;
const MOST_APART: f64 = 2e-3;

#[test]
fn a_path_handed_in_is_shifted_like_the_samplers_own() {
    let world = edges_with_specular_surfaces();
    let scene = world.scene();
    for mode in [Mode::Exchangeable, Mode::LinearDepth, Mode::Exact] {
        for run in 1..=3 {
            let shift = Options { run, ..Options::new(mode, Kernel::Disk(Radius::Pixels(0.7)), 6) };
            let sampler = sampler::Options {
                max_depth: 6,
                rr_depth: 9,
                seed: 41,
                shift: Some(shift),
                left_out: volgrad::sampler::Lengths::NONE,
                first: volgrad::sampler::FirstVertices::ALL,
            };
            let (mut compared, mut apart, mut full) = (0_u32, 0_u32, 0);
            for pass in 0..3000 {
                let Some(path) = record(&world, sampler, pass).finish().copied() else { continue };
                for event in path.exits().iter().filter(|_| !path.first().place.is_surface()) {
                    let length = event.from + 1;
                    let run_so_far = &path.run()[..length];
                    let Some(host) = Owned::of_next_event(&world, run_so_far, &event.link) else { continue };
                    let own = next_event_alone(&path, run_so_far, event);
                    let handed = from_path(&scene, &host.view(), own.carried(&scene), &Options { run: length, ..shift });
                    let handed = handed.expect("f > 0").expect("begins in a medium");
                    full += u32::from(length == run);
                    let (ours, theirs) = (splats(&world, &shift, &own, pass), splats(&world, &shift, &handed, pass));
                    assert_eq!(ours.len(), theirs.len());
                    let largest = ours.iter().map(|(_, colour)| colour.length()).fold(0.0, f64::max);
                    for ((p, a), (q, b)) in ours.iter().zip(&theirs) {
                        assert!((p - q).length() < 1e-4);
                        compared += 1;
                        apart += u32::from(!((a - b).length() <= SINGLE * largest));
                    }
                }
            }
            println!("{mode:?}, run {run}: {apart} of {compared} splats apart, {full} of full length");
            assert!(full > 50 && f64::from(apart) < MOST_APART * f64::from(compared));
        }
    }
}

/// How many rays the host is asked about.
struct Counting<'a, Q> {
    host: &'a Q,
    rays: Cell<u64>,
}

impl<Q: Queries> Queries for Counting<'_, Q> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.rays.set(self.rays.get() + rays.len() as u64);
        self.host.intersect(rays, hits)
    }

    fn occluded(&self, rays: &[Ray], hits: &mut [Hit]) -> Result<(), Stop> {
        self.rays.set(self.rays.get() + rays.len() as u64);
        self.host.occluded(rays, hits)
    }
}

/// A run of `length` vertices in a medium without end, every one of them lit, the last one with a next vertex.
fn open_path(length: usize) -> (World, Shiftable) {
    let mut world = World::new(camera([0.0; 3], 0.5, 64))
        .medium([-1e3; 3], [1e3; 3], homogeneous([0.5; 3], [0.8; 3], 0.2))
        .light(Light::Directional { direction: -DVec3::Y, irradiance: Colour::ONE }, 1.0);
    world.camera.near_clip = 0.5;
    let point = |i: usize| DVec3::new(0.1 + 0.4 * i as f64, 0.05, 5.0 + 0.3 * (i % 3) as f64);
    let link = Link { next: Next::Direction(DVec3::Y), depth: Depth::default() };
    let image = world.camera.project(point(0), DVec2::ZERO).expect("in view");
    let vertex = |i: usize| {
        let v = if i == 0 { -point(0) } else { point(i - 1) - point(i) };
        RunVertex {
            x: point(i),
            place: Place::Medium(0),
            depth: Depth::default(),
            to_previous: v.normalize(),
            distance: v.length(),
        }
    };
    let mut path = Shiftable::new(image, vertex(0));
    for i in 1..length {
        assert!(path.push(vertex(i)));
    }
    for from in 0..length {
        assert!(path.leave(Exit { from, link, wing: None, rest: Colour::ONE }));
    }
    let next = Next::Point { position: point(length), normal: None };
    let mut onwards = Onwards::new(Link { next, depth: Depth::default() }, length - 1, Phase::ISOTROPIC);
    onwards.plain = Colour::ONE;
    path.onwards = Some(onwards);
    (world, path)
}

/// One ray per member and edge that changes: from the camera (but a tile has traced those), inside the run, to the light from each
/// vertex, and onwards: 2 · run + 1.
#[test]
fn rays_are_linear_in_the_run_and_the_members() {
    for length in 1..=MAX_RUN {
        let (world, path) = open_path(length);
        let scene = world.scene();
        for count in [3, 8, 24] {
            for kernel in [Kernel::Disk(Radius::Pixels(2.0)), Kernel::Ball(0.1), Kernel::Tile] {
                for mode in [Mode::LogLinear, Mode::LinearDepth, Mode::TwoLevel, Mode::Exact, Mode::Exchangeable] {
                    let options = Options { run: length, exact_count: 2, ..Options::new(mode, kernel, count) };
                    let seen = u64::from(kernel != Kernel::Tile);
                    let evaluated = match mode {
                        Mode::Exact | Mode::Exchangeable => count as u64,
                        Mode::TwoLevel => 2,
                        _ => 0,
                    };
                    let expected = evaluated * (2 * length as u64 + seen);
                    let host = Counting { host: &world.geometry, rays: Cell::new(0) };
                    let tile = options.has_views().then(|| {
                        let tiling = shift::Tiling::new(&scene.camera, options.tile_side(), [0; 2]);
                        let bounds = tiling.tile(path.image.pixel.x as u32, path.image.pixel.y as u32);
                        Tile::trace(&scene, &world.geometry, bounds, path.image.pixel, DVec2::ZERO).expect("never stops")
                    });
                    let draw = Draw { tiles: [0; 2], random: shift_numbers(1, 0, 0) };
                    let stats = shift::shift(&scene, &host, &options, &path, tile.as_ref(), draw, |_, _| {}).expect("no stop");
                    assert_eq!(host.rays.get(), expected, "{mode:?}, {kernel:?} × {count}, run {length}");
                    assert_eq!((stats.rays, stats.occlusion_rays), (0, expected));
                }
            }
        }
    }
}

/// Nothing is asked about a member that is off the image, nor beyond what is in its way.
#[test]
fn rays_end_where_members_do() {
    let (mut world, path) = open_path(3);
    let options = Options { run: 3, ..Options::new(Mode::Exact, Kernel::Disk(Radius::Pixels(2.0)), 24) };
    let pixel = path.image.pixel;
    world.camera.crop = [pixel.x as u32, 0, pixel.x as u32 + 1, 64];
    let mut outside = 0;
    for pass in 0..20 {
        let mut on_image = 0;
        let stats = batch(&world, &options, &path, pass, |_, _| on_image += 1);
        outside += 25 - on_image;
        assert_eq!(stats.occlusion_rays, 7 * (on_image - 1));
    }
    assert!(outside > 100);
}

/// Against libm, whose error is below an ulp.
#[test]
fn exp_of_small_is_exp() {
    let largest = 4_f64.ln();
    let steps = 10_000;
    for i in -steps..=steps {
        let x = largest * f64::from(i) / f64::from(steps);
        let [a, b, c, d] = exp_of_small(DVec4::new(x, 0.0, -x, 0.5 * x)).to_array();
        assert_eq!(b, 1.0);
        for (value, exact) in [(a, x.exp()), (c, (-x).exp()), (d, (0.5 * x).exp())] {
            assert!((value - exact).abs() <= 1e-15 * exact, "exp {x}: {value:e}, {exact:e}");
        }
    }
}
