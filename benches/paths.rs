//! What f of a path costs, and its gradient: camera, one vertex in a medium, and a point light, in fog and in a grid.

mod volumes;

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use volgrad::math::{Colour, DVec3};
use volgrad::medium::{Density, Medium, Segment};
use volgrad::path::{Path, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, Vertex, contribution, path_log_gradient};
use volgrad::phase::Phase;
use volgrad::scene::{Bounds, Light, Lights, Scene};
use volumes::{CAMERA, LIGHT, ONE_SEGMENT, Shape, Volume, rays};

/// Medium 0 on both edges.
const SEGMENTS: [Segment; 2] = [ONE_SEGMENT; 2];

/// Paths whose vertices in the medium are anywhere in the cube.
fn paths() -> Vec<[Vertex; 3]> {
    let vertex = |kind, position: DVec3| Vertex { kind, position: position.into(), ..Vertex::default() };
    let middle = |ray: volumes::Ray| ray.origin + 2.0 * ray.direction;
    let path = |x| [vertex(VERTEX_CAMERA, CAMERA.position), vertex(VERTEX_MEDIUM, x), vertex(VERTEX_LIGHT, LIGHT)];
    rays().into_iter().map(|ray| path(middle(ray))).collect()
}

fn bench(c: &mut Criterion, name: &str, medium: Medium) {
    let media = [medium];
    let lights = [Light::Point { position: LIGHT, intensity: Colour::ONE }];
    let lights = Lights { lights: &lights, cdf: &[1.0], media: &[], guides: &[], environment: None };
    let scene = Scene { camera: CAMERA, media: &media, materials: &[], lights, bounds: Bounds::default() };
    let paths = paths();
    let mut next = paths.iter().cycle();
    let mut path = || Path { vertices: next.next().map_or(&[], |path| path), segments: &SEGMENTS, edge_ends: &[1, 2] };
    c.bench_function(&format!("f/{name}"), |bencher| bencher.iter(|| black_box(contribution(&scene, &path()))));
    c.bench_function(&format!("gradient/{name}"), |bencher| bencher.iter(|| black_box(path_log_gradient(&scene, &path(), 1))));
}

fn all(c: &mut Criterion) {
    let phase = Phase::henyey_greenstein(0.7);
    bench(c, "homogeneous", Medium { sigma_t: Colour::ONE, albedo: Colour::ONE, phase, density: Density::Homogeneous });
    let volume = Volume::new(64, Shape::Full, 1.0, true);
    bench(c, "grid", Medium { phase, ..volume.medium() });
}

criterion_group! {
    name = benches;
    config = volumes::criterion();
    targets = all
}
criterion_main!(benches);
