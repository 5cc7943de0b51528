//! The reference's worlds, edges and paths as a host hands them to the library.
//!
//! Positions, directions, normals and densities cross that boundary in single precision. [`rounded_world`] and [`rounded_path`]
//! round the reference's own numbers first, so that both sides compute from the same ones. What cannot be made equal are the
//! ends and normals of segments, which the reference computes anew in double precision.

use crate::reference::{
    camera::Camera as ReferenceCamera,
    grid::Grid as ReferenceGrid,
    medium::{Density as ReferenceDensity, Medium as ReferenceMedium},
    microfacets::Microfacets,
    path::{Path as ReferencePath, Vertex as ReferenceVertex},
    phase::Phase as ReferencePhase,
    segments::Edge,
    vector as reference_vector,
    world::World,
};
use volgrad::math::{Colour, DAffine3, DMat3, DVec3, Rgb, Vec3, orthonormal_basis};
use volgrad::medium::{
    BRICK_SIDE, Brick, Density, EdgeMoments, Grid, Line, Medium, NONE, Segment, brick_counts, build_block_bricks, build_bricks,
};
use volgrad::path::{Path, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, VERTEX_SURFACE, Vertex};
use volgrad::phase::Phase;
use volgrad::scene::{
    Bounds, Bsdf, Camera, Conductor, EnvironmentMap, Falloff, Ggx, Light, Lights, RoughConductor, RoughDielectric, Scene,
    running_sums, sums_length,
};

pub fn vec(v: reference_vector::Vec3) -> DVec3 {
    DVec3::from_array(v)
}

fn single(v: reference_vector::Vec3) -> Vec3 {
    vec(v).into()
}

fn rounded(v: reference_vector::Vec3) -> reference_vector::Vec3 {
    v.map(|x| f64::from(x as f32))
}

/// The world with the camera's position and all densities in single precision.
pub fn rounded_world(world: &World) -> World {
    let mut world = world.clone();
    world.camera.position = rounded(world.camera.position);
    for medium in &mut world.media {
        if let ReferenceDensity::Grid(grid) = &mut medium.density {
            grid.samples = grid.samples.iter().map(|&sample| f64::from(sample as f32)).collect();
        }
    }
    world
}

/// The path with all positions, normals and directions in single precision.
pub fn rounded_path(path: &ReferencePath) -> ReferencePath {
    let mut path = path.clone();
    for vertex in &mut path.vertices {
        match vertex {
            ReferenceVertex::Camera => {}
            ReferenceVertex::Spot { position, axis, .. } => (*position, *axis) = (rounded(*position), rounded(*axis)),
            ReferenceVertex::Medium { position, .. } | ReferenceVertex::PointLight { position, .. } => {
                *position = rounded(*position);
            }
            ReferenceVertex::Diffuse { position, normal, .. }
            | ReferenceVertex::Rough { position, normal, .. }
            | ReferenceVertex::Mirror { position, normal, .. }
            | ReferenceVertex::AreaLight { position, normal, .. } => {
                (*position, *normal) = (rounded(*position), rounded(*normal));
            }
            ReferenceVertex::Sky { direction, texels } => {
                (*direction, *texels) = (rounded(*direction), texels.map(rounded));
            }
            ReferenceVertex::Environment { direction, .. } | ReferenceVertex::Directional { direction, .. } => {
                *direction = rounded(*direction);
            }
        }
    }
    path
}

pub fn phase(phase: ReferencePhase) -> Phase {
    match phase {
        ReferencePhase::Isotropic => Phase::ISOTROPIC,
        ReferencePhase::HenyeyGreenstein { g } => Phase::henyey_greenstein(g),
    }
}

/// A square image of the reference camera's area.
pub fn camera(camera: &ReferenceCamera) -> Camera {
    Camera {
        position: vec(camera.lens.map_or(camera.position, |lens| lens.centre)),
        forward: vec(camera.forward),
        right: vec(camera.right),
        up: vec(camera.up),
        tan_half_fov_x: 0.5 * camera.image_area.sqrt(),
        width: 64,
        height: 64,
        crop: [0, 0, 64, 64],
        near_clip: camera.near,
        medium: NONE,
        lens_radius: camera.lens.map_or(0.0, |lens| lens.radius),
        // Says where on the image a point is seen, of which f knows nothing.
        focal_distance: 1.0,
    }
}

/// Does a grid come with its bricks? Or is it sparse?
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bricks {
    Built,
    Left,
    Sparse,
}

/// A medium and the memory that the library borrows from its host.
pub struct HostMedium {
    source: ReferenceMedium,
    samples: Vec<f32>,
    /// Of a sparse grid; its samples are in blocks.
    blocks: Vec<u32>,
    bricks: Vec<Brick>,
}

impl HostMedium {
    pub fn new(source: &ReferenceMedium, bricks: Bricks) -> Self {
        let mut host = Self { source: source.clone(), samples: Vec::new(), blocks: Vec::new(), bricks: Vec::new() };
        if let ReferenceDensity::Grid(grid) = &source.density {
            let size = grid.resolution.map(|n| n as i32);
            host.samples = grid.samples.iter().map(|&sample| sample as f32).collect();
            if bricks != Bricks::Left {
                host.bricks = vec![Brick::default(); brick_counts(size).iter().product::<i32>() as usize];
                build_bricks(&host.samples, size, &mut host.bricks);
            }
            if bricks == Bricks::Sparse {
                host.cut_into_blocks(size);
            }
        }
        host
    }

    /// A block for each brick that is unlike those before it.
    fn cut_into_blocks(&mut self, size: [i32; 3]) {
        let [nx, ny, nz] = brick_counts(size);
        let mut stored: Vec<Vec<f32>> = Vec::new();
        for brick in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
            let block = self.block(size, brick);
            let number = stored.iter().position(|other| *other == block).unwrap_or_else(|| {
                stored.push(block);
                stored.len() - 1
            });
            self.blocks.push(number as u32);
        }
        self.samples = stored.concat();
        self.bricks.fill(Brick::default());
        build_block_bricks(&self.samples, &self.blocks, &mut self.bricks).expect("every block is there");
    }

    fn block(&self, size: [i32; 3], brick: [i32; 3]) -> Vec<f32> {
        let near = |axis: usize, i: i32| (brick[axis] * BRICK_SIDE - 1 + i).clamp(0, size[axis] - 1) as usize;
        let [nx, ny, _] = size.map(|n| n as usize);
        let side = 0..=BRICK_SIDE;
        let points = side.clone().flat_map(|z| side.clone().flat_map(move |y| (0..=BRICK_SIDE).map(move |x| [x, y, z])));
        points.map(|[x, y, z]| self.samples[(near(2, z) * ny + near(1, y)) * nx + near(0, x)]).collect()
    }

    pub fn view(&self) -> Medium<'_> {
        Medium {
            sigma_t: vec(self.source.sigma_t),
            albedo: vec(self.source.albedo),
            phase: phase(self.source.phase),
            density: match &self.source.density {
                ReferenceDensity::Constant => Density::Homogeneous,
                ReferenceDensity::Grid(grid) => Density::Grid(self.grid(grid)),
            },
        }
    }

    fn grid(&self, grid: &ReferenceGrid) -> Grid<'_> {
        let [x, y, z] = grid.to_world.columns.map(vec);
        let local_to_world = DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: vec(grid.to_world.origin) };
        let size = grid.resolution.map(|n| n as i32);
        let view = if self.blocks.is_empty() {
            Grid::new(&self.samples, size, local_to_world, &self.bricks)
        } else {
            Grid::of_blocks(&self.samples, &self.blocks, size, local_to_world, &self.bricks)
        };
        view.expect("the counts fit")
    }
}

/// All media of a world.
pub fn host_media(world: &World, bricks: Bricks) -> Vec<HostMedium> {
    world.media.iter().map(|medium| HostMedium::new(medium, bricks)).collect()
}

/// The segments of an edge, measured from its origin. A camera's edge starts with the vacuum before its near plane.
pub fn segments(world: &World, edge: &Edge) -> Vec<Segment> {
    let convert = |segment: &crate::reference::segments::Segment| Segment {
        end: segment.end as f32,
        medium: segment.medium.map_or(NONE, |medium| medium as u32),
        normal: segment.face_normal.map_or(Vec3::default(), |n| vec(n).normalize().into()),
    };
    world.segments(edge).iter().map(convert).collect()
}

/// What covers a line in medium 0 from end to end.
pub const ONE_SEGMENT: [Segment; 1] = [Segment { end: f32::INFINITY, medium: 0, normal: Vec3 { x: 0.0, y: 0.0, z: 0.0 } }];

pub fn line<'a>(edge: &Edge, media: &'a [Medium<'a>], segments: &'a [Segment]) -> Line<'a> {
    Line::new(media, vec(edge.origin), vec(edge.direction), edge.length, segments)
}

/// ∇τ with respect to the near and the far end of a line.
pub fn gradients(moments: &EdgeMoments, line: &Line) -> [[DVec3; 3]; 2] {
    [moments.near_gradient(line.direction, line.length), moments.far_gradient(line.direction, line.length)]
}

fn at(kind: u32, position: reference_vector::Vec3) -> Vertex {
    Vertex { kind, position: single(position), ..Vertex::default() }
}

fn facing(vertex: Vertex, normal: reference_vector::Vec3) -> Vertex {
    Vertex { normal: single(normal), shading_normal: single(normal), ..vertex }
}

fn rough(alpha: f64, microfacets: Microfacets) -> Bsdf<'static> {
    let ggx = Ggx { alpha };
    match microfacets {
        Microfacets::Conductor { eta, k } => {
            let conductor = Conductor { eta: vec(eta), k: vec(k), reflectance: Colour::ONE };
            Bsdf::RoughConductor(RoughConductor { conductor, ggx })
        }
        Microfacets::Dielectric { eta } => Bsdf::RoughDielectric(RoughDielectric { eta, ggx }),
    }
}

/// A map that is never freed: tests have few.
fn sky(texels: &[reference_vector::Rgb; 12]) -> EnvironmentMap<'static> {
    let texels: Vec<Rgb> = texels.iter().map(|&texel| vec(texel).into()).collect();
    let mut sums = vec![0.0; sums_length(4, 3)];
    running_sums(&texels, 4, 3, Colour::ONE, &mut sums);
    EnvironmentMap::new(texels.leak(), 4, 3, DMat3::IDENTITY, Colour::ONE, sums.leak()).expect("the lengths fit")
}

/// A path and what its vertices refer to.
#[derive(Default)]
struct HostPath {
    vertices: Vec<Vertex>,
    segments: Vec<Segment>,
    edge_ends: Vec<u32>,
    materials: Vec<Bsdf<'static>>,
    lights: Vec<Light<'static>>,
}

impl HostPath {
    fn new(world: &World, path: &ReferencePath) -> Self {
        let mut host = Self::default();
        for vertex in &path.vertices {
            let vertex = host.vertex(world, vertex);
            host.vertices.push(vertex);
        }
        for i in 0..path.edge_count() {
            host.segments.extend(segments(world, &path.edge(world, i)));
            host.edge_ends.push(host.segments.len() as u32);
        }
        host
    }

    fn surface(&mut self, position: reference_vector::Vec3, normal: reference_vector::Vec3, bsdf: Bsdf<'static>) -> Vertex {
        self.materials.push(bsdf);
        Vertex { index: self.materials.len() as u32 - 1, ..facing(at(VERTEX_SURFACE, position), normal) }
    }

    /// The vertex, after its material or light has been added to the lists.
    fn vertex(&mut self, world: &World, vertex: &ReferenceVertex) -> Vertex {
        match *vertex {
            ReferenceVertex::Camera => at(VERTEX_CAMERA, world.camera.position),
            ReferenceVertex::Medium { position, medium } => Vertex { index: medium as u32, ..at(VERTEX_MEDIUM, position) },
            ReferenceVertex::Diffuse { position, normal, albedo } => {
                self.surface(position, normal, Bsdf::Diffuse { albedo: vec(albedo) })
            }
            ReferenceVertex::Rough { position, normal, alpha, microfacets } => {
                self.surface(position, normal, rough(alpha, microfacets))
            }
            ReferenceVertex::Mirror { position, normal, reflectance } => {
                self.surface(position, normal, Bsdf::Mirror { reflectance: vec(reflectance) })
            }
            ReferenceVertex::AreaLight { position, normal, radiance } => {
                let (edge_u, edge_v) = orthonormal_basis(vec(normal));
                self.lights.push(Light::Parallelogram { corner: vec(position), edge_u, edge_v, radiance: vec(radiance) });
                facing(at(VERTEX_LIGHT, position), normal)
            }
            ReferenceVertex::PointLight { position, intensity } => {
                self.lights.push(Light::Point { position: vec(position), intensity: vec(intensity) });
                at(VERTEX_LIGHT, position)
            }
            ReferenceVertex::Spot { position, axis, inner, outer, intensity } => {
                let (axis, falloff) = (vec(axis).normalize(), Falloff::new(inner.cos(), outer.cos()));
                self.lights.push(Light::Spot { position: vec(position), axis, intensity: vec(intensity), falloff });
                at(VERTEX_LIGHT, position)
            }
            ReferenceVertex::Environment { direction, radiance } => {
                self.lights.push(Light::Environment { radiance: vec(radiance) });
                at(VERTEX_LIGHT, direction)
            }
            ReferenceVertex::Sky { direction, texels } => {
                self.lights.push(Light::EnvironmentMap(sky(&texels)));
                at(VERTEX_LIGHT, direction)
            }
            ReferenceVertex::Directional { direction, irradiance } => {
                self.lights.push(Light::Directional { direction: -vec(direction), irradiance: vec(irradiance) });
                at(VERTEX_LIGHT, direction)
            }
        }
    }
}

/// Calls `visit` with the library's view of a path. World and path are rounded already.
pub fn with_path<R>(world: &World, path: &ReferencePath, bricks: Bricks, visit: impl FnOnce(&Scene, &Path) -> R) -> R {
    let host_media = host_media(world, bricks);
    let media: Vec<Medium> = host_media.iter().map(HostMedium::view).collect();
    let HostPath { vertices, segments, edge_ends, materials, lights } = HostPath::new(world, path);
    let lights = Lights { lights: &lights, cdf: &[1.0], media: &[], guides: &[], environment: None };
    let scene =
        Scene { camera: camera(&world.camera), media: &media, materials: &materials, lights, bounds: Bounds::default() };
    visit(&scene, &Path { vertices: &vertices, segments: &segments, edge_ends: &edge_ends })
}
