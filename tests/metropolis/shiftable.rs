//! Paths joined of two subpaths, prepared for shifting: they carry the weight handed in, make the batches that `from_path` makes of them, and
//! what of them moves depends on the path alone, not on the technique that made it.

use crate::toy::batch::splats;
use crate::toy::scenes::{World, edges_with_rough_surfaces, edges_with_specular_surfaces};
use crate::unbiased_shifts;
use volgrad::math::{Colour, DVec2, DVec3};
use volgrad::medium::{NONE, Segment};
use volgrad::path::{self, Path, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, VERTEX_SURFACE};
use volgrad::sampler::bidirectional::{
    Bidirectional, Connection, Edge, Heuristic, Joined, Kind, Options, Sample, Subpath, Vertex,
};
use volgrad::sampler::{CameraSamples, Stats};
use volgrad::scene::Scene;
use volgrad::shift::{self, Kernel, Mode, Radius, Shiftable, from_path};

/// x_0 … x_k, and the edges from each vertex to the next as they arrive there.
struct Whole<'a> {
    world: &'a World,
    scene: &'a Scene<'a>,
    vertices: Vec<Vertex<'a>>,
    edges: Vec<Edge>,
    connection: Connection,
    /// Vertices from the camera.
    t: usize,
}

impl<'a> Whole<'a> {
    fn new(world: &'a World, scene: &'a Scene<'a>, sample: &Sample<'_, 'a>) -> Self {
        let Sample { camera, light, connection } = *sample;
        let vertices = camera.iter().chain(light.iter().rev()).copied().collect();
        let from_camera = camera[1..].iter().map(|vertex| vertex.edge);
        let from_light = light[1.min(light.len())..].iter().rev().map(|vertex| vertex.edge.reversed());
        let edges = from_camera.chain(connection.edge).chain(from_light).collect();
        Self { world, scene, vertices, edges, connection, t: camera.len() }
    }

    fn last(&self) -> usize {
        self.vertices.len() - 1
    }

    /// What the technique with `t` vertices from the camera prepares. Some(None): nothing moves; None: it cannot make such paths.
    fn prepared(&self, t: usize, options: &shift::Options) -> Option<Option<Shiftable>> {
        let last = self.last();
        let edge_to = |i: usize| if i > 0 { self.edges[i - 1] } else { Edge::NONE };
        let mut camera: Vec<Vertex> = (0..t).map(|i| Vertex { edge: edge_to(i), ..self.vertices[i] }).collect();
        let edge_from = |i: usize| if i < last { self.edges[i].reversed() } else { Edge::NONE };
        let mut light: Vec<Vertex> = (t..=last).rev().map(|i| Vertex { edge: edge_from(i), ..self.vertices[i] }).collect();
        match light.first_mut() {
            Some(first) => first.kind = self.as_light(first.kind),
            None => camera[last].kind = self.as_found(camera[last].kind)?,
        }
        let edge = (t <= last).then(|| self.edges[t - 1]);
        let connection = Connection { edge, ..self.connection };
        let joined = Joined { scene: self.scene, camera: &camera, light: &light, connection: &connection };
        let mut path = None;
        let moves = joined.prepare(&self.world.geometry, options, &mut path).expect("never stops");
        Some(path.filter(|_| moves))
    }

    /// An area light that was found, as if its point had been sampled.
    fn as_light(&self, kind: Kind<'a>) -> Kind<'a> {
        match kind {
            Kind::Surface { light: index, normal, .. } => {
                let light = self.scene.lights.get(index).expect("is a light");
                Kind::Light { light, index, normal: Some(normal) }
            }
            _ => kind,
        }
    }

    /// The other way round, if it can be found.
    fn as_found(&self, kind: Kind<'a>) -> Option<Kind<'a>> {
        match kind {
            Kind::Light { index, normal: Some(normal), .. } => {
                let bsdf = &self.scene.materials[0];
                Some(Kind::Surface { material: 0, bsdf, normal, media: [NONE; 2], user: 0, light: index })
            }
            Kind::Far { light, .. } => light.is_environment().then_some(kind),
            Kind::Surface { .. } => Some(kind),
            _ => None,
        }
    }

    /// Whether a light is seen through specular surfaces.
    fn has_chain(&self) -> bool {
        self.vertices[self.last() - 1].is_specular()
    }

    /// As a host would hand it over, in single precision. Some(None): nothing moves; None: that has moved a vertex across a face.
    fn handed_in(&self, options: &shift::Options) -> Option<Option<Shiftable>> {
        let mut owned = (vec![], vec![], vec![]);
        for (i, vertex) in self.vertices.iter().enumerate() {
            let position = vertex.position.into();
            let new = |kind, index, normal: DVec3| path::Vertex {
                kind,
                index,
                user: 0,
                position,
                normal: normal.into(),
                shading_normal: normal.into(),
                reserved: 0,
            };
            owned.0.push(match self.vertices[i].kind {
                Kind::Camera => new(VERTEX_CAMERA, 0, DVec3::ZERO),
                Kind::Medium { index, .. } => {
                    (self.world.geometry.medium_at(new(0, 0, DVec3::ZERO).position.wide()) == index).then_some(())?;
                    new(VERTEX_MEDIUM, index, DVec3::ZERO)
                }
                Kind::Surface { normal, light, .. } if i == self.last() => new(VERTEX_LIGHT, light, normal),
                Kind::Surface { normal, material, .. } => new(VERTEX_SURFACE, material, normal),
                Kind::Light { index, normal, .. } => new(VERTEX_LIGHT, index, normal.unwrap_or_default()),
                Kind::Far { index, .. } => new(VERTEX_LIGHT, index, DVec3::ZERO),
            });
        }
        for pair in owned.0.windows(2) {
            let (from, to): (DVec3, DVec3) = (pair[0].position.wide(), pair[1].position.wide());
            let far = pair[1].kind == VERTEX_LIGHT && pair[1].normal.wide() == DVec3::ZERO;
            let v = if far { to } else { to - from };
            let length = if far { f64::INFINITY } else { v.length() };
            let segments: Vec<Segment> = self.world.geometry.segments(from, v.normalize(), length)?;
            owned.1.extend(segments);
            owned.2.push(owned.1.len() as u32);
        }
        let path = Path { vertices: &owned.0, segments: &owned.1, edge_ends: &owned.2 };
        path.validate(self.scene).ok()?;
        from_path(self.scene, &path, self.connection.value * self.connection.weight, options).ok()
    }
}

/// Paths of all techniques, of up to five edges.
fn each_path(world: &World, samples: u64, mut check: impl FnMut(&Whole)) {
    let scene = world.scene();
    let (max_length, heuristic, light_vertices) = (5, Heuristic::Balance, usize::MAX);
    let options = Options { max_length, rr_depth: 9, seed: 8, heuristic, light_vertices, roulette: 0.0, shift: None };
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    let (mut camera, mut light) = (Subpath::default(), Subpath::default());
    let pixels = u64::from(world.camera.width * world.camera.height);
    for pass in 0..samples {
        let pixel = (pass * 37 % pixels) as u32;
        let mut stats = Stats::default();
        let first = CameraSamples::new(&scene, &world.geometry, None, options.seed, pass);
        let first = first.expect("nothing is shifted").sample(pixel, &mut stats);
        let tell = |sample: &Sample| {
            check(&Whole::new(world, &scene, sample));
            Ok(())
        };
        sampler.sample(pass, first.expect("never stops"), &mut camera, &mut light, &mut stats, tell).expect("never stops");
    }
}

fn worlds() -> [World; 2] {
    let mut rough = edges_with_rough_surfaces();
    (rough.camera.lens_radius, rough.camera.focal_distance) = (0.3, 2.0);
    [edges_with_specular_surfaces(), rough]
}

/// With derivatives and without, on tiles and around the path, runs of one vertex and more.
fn shifts() -> Vec<shift::Options> {
    let linear = shift::Options::new(Mode::LinearDepth, Kernel::Disk(Radius::Pixels(0.7)), 4);
    unbiased_shifts().into_iter().chain([shift::Options { run: 2, ..linear }]).collect()
}

fn close(a: Colour, b: Colour, tolerance: f64) -> bool {
    (a - b).abs().max_element() <= tolerance * b.max_element()
}

/// Where derivatives are wanted the host is asked again for the media along edges, whose ends are in single precision.
#[test]
fn it_carries_the_weight_handed_in() {
    for world in worlds() {
        let scene = world.scene();
        let specular = scene.materials.iter().any(|bsdf| bsdf.is_specular());
        for shift in shifts() {
            let tolerance = if shift.mode.has_derivatives() { 1e-6 } else { 1e-9 };
            let (mut moving, mut chains) = (0, 0);
            each_path(&world, 400, |whole| {
                let Some(path) = whole.prepared(whole.t, &shift).expect("made it") else { return };
                let weight = whole.connection.value * whole.connection.weight;
                let carried = path.carried(&scene);
                assert!(close(carried, weight, tolerance), "{carried} is not {weight}, {shift:?}");
                (moving, chains) = (moving + 1, chains + u32::from(path.chain.is_some()));
            });
            println!("{:?}: {moving} move, {chains} with a specular chain", shift.mode);
            assert!(moving > 500 && (chains > 0) == (specular && shift.mode.has_queries()));
        }
    }
}

/// Splats of two preparations of one path, with the same offsets.
fn batches(world: &World, shift: &shift::Options, paths: [&Shiftable; 2], pass: u64) -> Vec<[(DVec2, Colour); 2]> {
    let [a, b] = paths.map(|path| splats(world, shift, path, pass));
    assert_eq!(a.len(), b.len());
    a.into_iter().zip(b).map(|(a, b)| [a, b]).collect()
}

#[test]
fn what_moves_depends_on_the_path_alone() {
    for world in worlds() {
        for shift in shifts() {
            let (mut compared, mut pass) = (0, 0);
            each_path(&world, 60, |whole| {
                let own = whole.prepared(whole.t, &shift).expect("made it");
                for t in (1..=whole.vertices.len()).filter(|t| *t != whole.t) {
                    let Some(other) = whole.prepared(t, &shift) else { continue };
                    let shape = |path: &Shiftable| (path.run().len(), path.onwards.is_some(), path.chain.is_some());
                    assert_eq!(
                        own.as_ref().map(shape),
                        other.as_ref().map(shape),
                        "{t} and {} of {:?}",
                        whole.t,
                        whole.vertices
                    );
                    let (Some(own), Some(other)) = (&own, &other) else { continue };
                    pass += 1;
                    for [(p, a), (q, b)] in batches(&world, &shift, [own, other], pass) {
                        let scale = whole.connection.value.max_element() * whole.connection.weight;
                        assert!(
                            (p - q).length() < 1e-9 && (a - b).abs().max_element() <= 1e-6 * a.max_element().max(scale),
                            "{a} {b}"
                        );
                        compared += 1;
                    }
                }
            });
            println!("{:?}: {compared} splats", shift.mode);
            assert!(compared > 500);
        }
    }
}

/// Of the largest splat. As in tests/batches.rs: a host's positions are in single precision; the few splats that differ more are near a
/// neighbour, or have an offset within rounding of the stay rule's bounds or of an edge.
const SINGLE: f64 = 1e-5;
const MOST_APART: f64 = 1e-2;

#[test]
fn batches_are_those_of_the_path_handed_in() {
    for world in worlds() {
        for shift in shifts() {
            let (mut compared, mut apart, mut pass) = (0_u32, 0_u32, 0);
            each_path(&world, 100, |whole| {
                let own = whole.prepared(whole.t, &shift).expect("made it").filter(|path| path.chain.is_none());
                let Some(handed) = whole.handed_in(&shift) else { return };
                let (own, handed) = match (own, handed) {
                    (Some(own), Some(handed)) => (own, handed),
                    // Only the sampler follows chains of specular surfaces.
                    (None, None) => return,
                    (own, _) => return assert!(own.is_none() && whole.has_chain(), "{:?}", whole.vertices),
                };
                assert_eq!(own.run().len(), handed.run().len());
                pass += 1;
                let splats = batches(&world, &shift, [&own, &handed], pass);
                let largest = splats.iter().map(|[(_, a), _]| a.max_element()).fold(0.0, f64::max);
                for [(p, a), (q, b)] in splats {
                    compared += 1;
                    apart += u32::from(!((a - b).abs().max_element() <= SINGLE * largest && (p - q).length() < 1e-4));
                }
            });
            println!("{:?}: {apart} of {compared} splats apart", shift.mode);
            assert!(compared > 500 && f64::from(apart) <= MOST_APART * f64::from(compared));
        }
    }
}
