//! What calling through the C ABI costs: the gradient of one path, by the Rust function and by the C function, in fog, where it is
//! cheapest, and in a grid. Both are called through pointers, as from another language, in turns; the last lines are the median ratios.

mod volumes;

use core::ptr::null_mut;
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::mem::{MaybeUninit, zeroed};
use std::time::Instant;
use volgrad::ffi::*;
use volgrad::math::{Colour, Rgb, Vec3};
use volgrad::medium::{Density, Medium};
use volgrad::path::{Gradient, Path, PathError, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, Vertex, path_log_gradient};
use volgrad::phase::Phase;
use volgrad::scene::{Bounds, Light, Lights, Scene};
use volumes::{CAMERA, LIGHT, ONE_SEGMENT, Shape, Volume, rays};

const SIDE: i32 = 64;
const G: f32 = 0.7;
const SEGMENTS: [volgrad::medium::Segment; 2] = [ONE_SEGMENT; 2];
const EDGE_ENDS: [u32; 2] = [1, 2];
/// Turns, and paths in each.
const ROUNDS: usize = 301;
const PATHS: usize = 200;

type InRust = fn(&Scene, &Path, usize) -> Result<Gradient, PathError>;
type InC = unsafe extern "C" fn(*const volgrad_scene, *const volgrad_path, u32, *mut volgrad_gradient) -> volgrad_status;

fn paths() -> Vec<[Vertex; 3]> {
    let vertex = |kind, position: Vec3| Vertex { kind, position, ..Vertex::default() };
    let path = |ray: volumes::Ray| {
        let middle = ray.origin + 2.0 * ray.direction;
        [
            vertex(VERTEX_CAMERA, CAMERA.position.into()),
            vertex(VERTEX_MEDIUM, middle.into()),
            vertex(VERTEX_LIGHT, LIGHT.into()),
        ]
    };
    rays().into_iter().map(path).collect()
}

/// The scene of [`with_rust`] as C describes it; `memory` has room for it.
fn scene_in_c(grid: Option<&[f32]>, memory: &mut [u128]) -> *const volgrad_scene {
    let white = Rgb { r: 1.0, g: 1.0, b: 1.0 };
    // SAFETY: zeros are the defaults of these structs of numbers and pointers, and everything outlives the scene.
    unsafe {
        let mut medium = volgrad_medium { sigma_t: white, albedo: white, ..zeroed() };
        medium.phase = volgrad_phase { kind: VOLGRAD_PHASE_HENYEY_GREENSTEIN, g: G };
        if let Some(samples) = grid {
            (medium.kind, medium.density) = (VOLGRAD_MEDIUM_GRID, samples.as_ptr());
            (medium.nx, medium.ny, medium.nz) = (SIDE as u32, SIDE as u32, SIDE as u32);
            medium.local_to_world = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        }
        let light = volgrad_light {
            kind: VOLGRAD_LIGHT_POINT,
            emission: white,
            sampling_weight: 1.0,
            position: LIGHT.into(),
            ..zeroed()
        };
        let camera = volgrad_camera {
            width: CAMERA.width,
            height: CAMERA.height,
            crop_x1: CAMERA.width,
            crop_y1: CAMERA.height,
            position: CAMERA.position.into(),
            forward: CAMERA.forward.into(),
            right: CAMERA.right.into(),
            up: CAMERA.up.into(),
            tan_half_fov_x: CAMERA.tan_half_fov_x as f32,
            ..zeroed()
        };
        let desc = volgrad_scene_desc {
            struct_size: size_of::<volgrad_scene_desc>() as u32,
            media_count: 1,
            light_count: 1,
            camera,
            media: &medium,
            lights: &light,
            ..zeroed()
        };
        let mut scene = core::ptr::null();
        let bytes = size_of_val(memory);
        assert_eq!(
            volgrad_scene_init(memory.as_mut_ptr().cast(), bytes, &desc, &mut scene, null_mut()),
            volgrad_status::VOLGRAD_OK
        );
        scene
    }
}

/// Both functions on one path, to compare in turns.
struct Pair<'a> {
    rust: (InRust, &'a Scene<'a>),
    c: (InC, *const volgrad_scene),
}

impl Pair<'_> {
    fn by_rust(&self, vertices: &[Vertex; 3]) {
        let path = Path { vertices, segments: &SEGMENTS, edge_ends: &EDGE_ENDS };
        let _ = black_box(self.rust.0(self.rust.1, &path, 1));
    }

    fn by_c(&self, vertices: &[Vertex; 3]) {
        let path = volgrad_path {
            vertices: vertices.as_ptr(),
            segments: SEGMENTS.as_ptr(),
            edge_ends: EDGE_ENDS.as_ptr(),
            vertex_count: 3,
            segment_count: 2,
        };
        let mut gradient = MaybeUninit::uninit();
        // SAFETY: as the header asks.
        let status = unsafe { self.c.0(self.c.1, &path, 1, gradient.as_mut_ptr()) };
        assert_eq!(status, volgrad_status::VOLGRAD_OK);
        black_box(&gradient);
    }

    /// Median over the turns of the time in C over that in Rust.
    fn ratio(&self, paths: &[[Vertex; 3]]) -> f64 {
        let time = |by: &dyn Fn(&[Vertex; 3])| {
            let start = Instant::now();
            paths.iter().cycle().take(PATHS).for_each(by);
            start.elapsed().as_secs_f64()
        };
        let mut ratios: Vec<f64> = (0..ROUNDS)
            .map(|round| match round % 2 {
                0 => time(&|p| self.by_c(p)) / time(&|p| self.by_rust(p)),
                _ => 1.0 / (time(&|p| self.by_rust(p)) / time(&|p| self.by_c(p))),
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ROUNDS / 2]
    }
}

fn bench(c: &mut Criterion, name: &str, medium: Medium, grid: Option<&[f32]>) {
    let media = [medium];
    let lights = [Light::Point { position: LIGHT, intensity: Colour::ONE }];
    let lights = Lights { lights: &lights, cdf: &[1.0], media: &[], guides: &[], environment: None };
    let scene = Scene { camera: CAMERA, media: &media, materials: &[], lights, bounds: Bounds::default() };
    let mut memory = vec![0u128; 1 << 16];
    let in_c = scene_in_c(grid, &mut memory);
    let pair =
        Pair { rust: (black_box(path_log_gradient as InRust), &scene), c: (black_box(volgrad_path_log_gradient as InC), in_c) };
    let paths = paths();
    let mut next = paths.iter().cycle();
    c.bench_function(&format!("rust/{name}"), |b| b.iter(|| next.next().map(|p| pair.by_rust(p))));
    c.bench_function(&format!("c/{name}"), |b| b.iter(|| next.next().map(|p| pair.by_c(p))));
    println!("{name}: C over Rust {:.3}", pair.ratio(&paths));
}

fn all(c: &mut Criterion) {
    let phase = Phase::henyey_greenstein(G.into());
    let fog = Medium { sigma_t: Colour::ONE, albedo: Colour::ONE, phase, density: Density::Homogeneous };
    bench(c, "homogeneous", fog, None);
    let volume = Volume::new(SIDE, Shape::Full, 1.0, true);
    bench(c, "grid", Medium { phase, ..volume.medium() }, Some(&volume.samples));
}

criterion_group! {
    name = benches;
    config = volumes::criterion();
    targets = all
}
criterion_main!(benches);
