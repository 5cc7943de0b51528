//! Random paths through a world, away from everything that is not smooth, so that differences can judge gradients.

use super::{
    differences::is_smooth,
    medium::Density,
    microfacets::{Microfacets, passing_cosine},
    path::{Path, Vertex},
    random::*,
    vector::*,
    world::World,
};
use rand_pcg::Pcg64;

/// Paths by their vertices: Camera, Medium, Diffuse, mirror (X), then Area light, Point light, spot light (O), Environment, map of one (K) or directional Sun.
/// Together every kind of vertex is before and after a medium vertex.
pub const PATTERNS: [&str; 18] = [
    "CMP", "CMA", "CME", "CMS", "CMDP", "CDMA", "CDMP", "CDME", "CDMS", "CMMP", "CMMA", "CMMDE", "CMMMS", "CDMDA", "CMMMMA",
    "CMDMMS", "CDMMMDP", "CMMMMME",
];

/// Paths with mirrors (X) before or after a run of medium vertices, or two of them.
pub const MIRROR_PATTERNS: [&str; 12] =
    ["CMXP", "CMXA", "CMXE", "CMXMP", "CMMXDA", "CDMMMXXS", "CXMP", "CXMMA", "CXXMDP", "CDXMMME", "CMMXMMXP", "CDMXDMP"];

/// Paths whose medium vertices are next to what looks different from different directions: rough conductors (R), rough
/// glass that reflects (G) or that light passes through (T), spot lights (O), environment maps (K).
pub const PROFILE_PATTERNS: [&str; 18] = [
    "CMO", "CMMO", "CDMO", "CMMDMO", "CMK", "CDMMK", "CMDK", "CMRP", "CRMP", "CMMRMA", "CRMO", "CMGA", "CGMMP", "CMGMO",
    "CMTP", "CTMMA", "CMTMO", "CRMTMGP",
];
/// Not so smooth that a lobe is narrow against the steps of differences.
const LEAST_ALPHA: f64 = 0.3;
/// A metal like copper, glass.
const COPPER: Microfacets = Microfacets::Conductor { eta: [0.2, 0.9, 1.1], k: [3.9, 2.5, 2.4] };
const GLASS: f64 = 1.5;
/// Half angles of a spot light's cones, radians, and how far a vertex stays away from them.
const CONES: [f64; 2] = [0.2, 1.4];
const CONE_CLEARANCE: f64 = 0.1;

/// Least distance between neighbouring vertices.
const SEPARATION: f64 = 0.3;
/// Least distance of a medium vertex from a face, in world units, and from a plane of samples, in cells.
const CLEARANCE: f64 = 0.02;
/// Least cosine at a surface, a light or the camera.
const LEAST_COSINE: f64 = 0.2;

/// A random path of the given pattern with f > 0, its medium vertices in media and away from everything that is not smooth.
pub fn random_path(rng: &mut Pcg64, world: &World, pattern: &str) -> Path {
    loop {
        let vertices = pattern.chars().map(|kind| random_vertex(rng, world, kind)).collect();
        let mut path = Path { vertices };
        if is_well_separated(world, &path) && turn_normals(rng, world, pattern, &mut path) && all_moves_are_smooth(world, &path)
        {
            return path;
        }
    }
}

fn random_vertex(rng: &mut Pcg64, world: &World, kind: char) -> Vertex {
    let light = random_vector(rng, 0.5, 2.0);
    let position = random_vector(rng, -1.4, 1.4);
    let normal = [0.0, 0.0, 1.0]; // until turn_normals
    match kind {
        'C' => Vertex::Camera,
        'M' => random_medium_vertex(rng, world),
        'D' => Vertex::Diffuse { position, normal, albedo: random_vector(rng, 0.2, 0.9) },
        'R' | 'G' | 'T' => {
            let microfacets = if kind == 'R' { COPPER } else { Microfacets::Dielectric { eta: GLASS } };
            Vertex::Rough { position, normal, alpha: uniform(rng, LEAST_ALPHA, 0.7), microfacets }
        }
        'X' => Vertex::Mirror { position, normal, reflectance: [0.7; 3] },
        'A' => Vertex::AreaLight { position, normal, radiance: light },
        'O' => Vertex::Spot { position, axis: normal, inner: CONES[0], outer: CONES[1], intensity: light },
        'P' => Vertex::PointLight { position, intensity: light },
        'E' => Vertex::Environment { direction: random_direction(rng), radiance: light },
        'K' => Vertex::Sky { direction: random_direction(rng), texels: [0; 12].map(|_| random_vector(rng, 0.1, 2.0)) },
        'S' => Vertex::Directional { direction: random_direction(rng), irradiance: light },
        _ => panic!("no vertex kind {kind}"),
    }
}

fn random_medium_vertex(rng: &mut Pcg64, world: &World) -> Vertex {
    loop {
        let position = random_vector(rng, -1.0, 1.0);
        if let Some(medium) = world.medium_at(position)
            && is_clear(world, medium, position)
        {
            return Vertex::Medium { position, medium };
        }
    }
}

fn is_clear(world: &World, medium: usize, x: Vec3) -> bool {
    let mut planes = world.regions.iter().flat_map(|region| &region.planes);
    let clear_of_faces = planes.all(|plane| (dot(plane.normal, x) - plane.offset).abs() / length(plane.normal) > CLEARANCE);
    let clear_of_samples = match &world.media[medium].density {
        Density::Constant => true,
        Density::Grid(grid) => grid.contains(x) && grid.cells_to_nearest_plane(x) > CLEARANCE,
    };
    clear_of_faces && clear_of_samples
}

fn is_well_separated(world: &World, path: &Path) -> bool {
    let first = path.vertices[1].position(world);
    let camera = &world.camera;
    camera.depth(first) > camera.near + 0.1
        && camera.cosine(first) > LEAST_COSINE
        && (0..path.edge_count()).all(|i| path.edge(world, i).length > SEPARATION)
}

/// Gives surfaces and lights a normal that all their neighbours are in front of, and mirrors the one between their neighbours; false
/// if none is found.
fn turn_normals(rng: &mut Pcg64, world: &World, pattern: &str, path: &mut Path) -> bool {
    let k = path.edge_count();
    for i in 1..=k {
        let mut neighbours = vec![path.direction_to_previous(world, i)];
        if i < k {
            neighbours.push(path.direction_to_next(world, i));
        }
        let passes = pattern.as_bytes()[i] == b'T';
        if passes {
            let front = usize::from(uniform(rng, 0.0, 1.0) < 0.5);
            neighbours[1 - front] = scale(-1.0, neighbours[1 - front]);
        }
        if let Vertex::Diffuse { normal, .. } | Vertex::Rough { normal, .. } | Vertex::AreaLight { normal, .. } =
            &mut path.vertices[i]
        {
            let candidates = [0; 20].map(|_| random_direction(rng));
            let good = |n: &&Vec3| neighbours.iter().all(|&u| dot(**n, u) > LEAST_COSINE);
            let Some(found) = candidates.iter().find(good) else {
                return false;
            };
            *normal = *found;
            if passes {
                let (c, l) = (path.direction_to_previous(world, i), path.direction_to_next(world, i));
                if passing_cosine(*found, c, l, GLASS) < LEAST_COSINE {
                    return false;
                }
            }
        }
        if let Vertex::Spot { axis, .. } = &mut path.vertices[i] {
            let turned = random_direction(rng);
            let angle = dot(turned, neighbours[0]).acos();
            if !(CONES[0] + CONE_CLEARANCE..CONES[1] - CONE_CLEARANCE).contains(&angle) {
                return false;
            }
            *axis = turned;
        }
        if let Vertex::Mirror { normal, .. } = &mut path.vertices[i] {
            *normal = normalize(add(neighbours[0], neighbours[1]));
            if dot(*normal, neighbours[0]) < LEAST_COSINE {
                return false;
            }
        }
    }
    true
}

/// Can differences judge the gradient of every medium vertex, and of every run of them that starts at x_1?
fn all_moves_are_smooth(world: &World, path: &Path) -> bool {
    let medium_vertices = (1..path.edge_count()).filter(|&i| path.vertices[i].is_medium());
    let leading_run = (1..path.edge_count()).take_while(|&i| path.vertices[i].is_medium());
    medium_vertices.into_iter().all(|i| is_smooth(world, path, i, i))
        && leading_run.into_iter().all(|i| is_smooth(world, path, 1, i))
}
