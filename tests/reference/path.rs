//! Light paths x_0 … x_k: x_0 is the camera, x_k a light, and what is between are medium or surface points.

use super::{microfacets::Microfacets, segments::Edge, vector::*, world::World};

#[derive(Clone, Copy, Debug)]
pub enum Vertex {
    /// At [`World::camera`].
    Camera,
    /// A scattering event in the medium with this index in [`World::media`].
    Medium { position: Vec3, medium: usize },
    /// A Lambert surface that reflects on the side its unit normal points to, and is black on the other.
    Diffuse { position: Vec3, normal: Vec3, albedo: Rgb },
    /// A rough surface; `alpha` is the roughness.
    Rough { position: Vec3, normal: Vec3, alpha: f64, microfacets: Microfacets },
    /// A perfect mirror on the side its unit normal points to. It is where its neighbours see each other in it.
    Mirror { position: Vec3, normal: Vec3, reflectance: Rgb },
    /// Emits constant radiance on the side its unit normal points to.
    AreaLight { position: Vec3, normal: Vec3, radiance: Rgb },
    /// Radiant intensity (power per solid angle), the same in all directions.
    PointLight { position: Vec3, intensity: Rgb },
    /// A point light that shines along its unit `axis`: with all of its intensity up to the angle `inner` (in radians), with none from
    /// `outer` on, linearly in between.
    Spot { position: Vec3, axis: Vec3, inner: f64, outer: f64, intensity: Rgb },
    /// Radiance from infinity. `direction` is the unit vector towards it.
    Environment { direction: Vec3, radiance: Rgb },
    /// Radiance from infinity as on a map: 4 columns by longitude, from −z by +x, of texels in their middle; 3 rows from +y to −y, of
    /// which the first and last are the poles; linear in both angles in between.
    Sky { direction: Vec3, texels: [Rgb; 12] },
    /// A light that shines from one direction. `direction` is the unit vector towards it, `irradiance` that on a plane
    /// perpendicular to it.
    Directional { direction: Vec3, irradiance: Rgb },
}

impl Vertex {
    pub fn is_medium(&self) -> bool {
        matches!(self, Vertex::Medium { .. })
    }

    pub fn is_specular(&self) -> bool {
        matches!(self, Vertex::Mirror { .. })
    }

    /// Does what it scatters or emits depend on the direction, other than by a phase function?
    pub fn has_profile(&self) -> bool {
        matches!(self, Vertex::Rough { .. } | Vertex::Spot { .. })
    }

    pub fn is_at_infinity(&self) -> bool {
        matches!(self, Vertex::Environment { .. } | Vertex::Sky { .. } | Vertex::Directional { .. })
    }

    /// Where the vertex is; panics for one at infinity.
    pub fn position(&self, world: &World) -> Vec3 {
        match *self {
            Vertex::Camera => world.camera.position,
            Vertex::Medium { position, .. }
            | Vertex::Diffuse { position, .. }
            | Vertex::Rough { position, .. }
            | Vertex::Mirror { position, .. }
            | Vertex::AreaLight { position, .. }
            | Vertex::Spot { position, .. }
            | Vertex::PointLight { position, .. } => position,
            Vertex::Environment { .. } | Vertex::Sky { .. } | Vertex::Directional { .. } => {
                panic!("a vertex at infinity has no position")
            }
        }
    }

    /// The normal whose cosine C is part of the geometry term; `None` where C = 1.
    pub fn cosine_normal(&self, world: &World) -> Option<Vec3> {
        match *self {
            Vertex::Camera => Some(world.camera.forward),
            Vertex::Diffuse { normal, .. } | Vertex::Rough { normal, .. } | Vertex::AreaLight { normal, .. } => Some(normal),
            _ => None,
        }
    }
}

#[derive(Clone, Debug)]
pub struct Path {
    pub vertices: Vec<Vertex>,
}

impl Path {
    /// k, the number of edges; the last vertex is x_k.
    pub fn edge_count(&self) -> usize {
        self.vertices.len() - 1
    }

    /// The edge from x_i to x_{i+1}.
    pub fn edge(&self, world: &World, i: usize) -> Edge {
        let origin = self.vertices[i].position(world);
        match self.vertices[i + 1] {
            Vertex::Environment { direction, .. } | Vertex::Sky { direction, .. } | Vertex::Directional { direction, .. } => {
                // A rounded unit vector is none, and sharp phase functions notice.
                Edge::to_infinity(origin, normalize(direction))
            }
            end if i == 0 => Edge::from_camera(&world.camera, end.position(world)),
            end => Edge::between(origin, end.position(world)),
        }
    }

    /// The unit vector from x_i to its neighbour before.
    pub fn direction_to_previous(&self, world: &World, i: usize) -> Vec3 {
        scale(-1.0, self.edge(world, i - 1).direction)
    }

    /// The unit vector from x_i to its neighbour after.
    pub fn direction_to_next(&self, world: &World, i: usize) -> Vec3 {
        self.edge(world, i).direction
    }

    /// c at an inner vertex: the dot product of the two directions away from it.
    pub fn cosine_at(&self, world: &World, i: usize) -> f64 {
        dot(self.direction_to_previous(world, i), self.direction_to_next(world, i))
    }

    /// The path with medium vertices `first..=last` moved by one offset. They keep their medium.
    pub fn moved(&self, first: usize, last: usize, offset: Vec3) -> Path {
        let mut path = self.clone();
        for vertex in &mut path.vertices[first..=last] {
            match vertex {
                Vertex::Medium { position, .. } => *position = add(*position, offset),
                _ => panic!("only medium vertices move"),
            }
        }
        path
    }

    /// The path with every medium vertex in the medium that is really there, as a shift across a face needs it; `None` if
    /// one of them is in vacuum (f = 0).
    pub fn with_media_of(&self, world: &World) -> Option<Path> {
        let mut path = self.clone();
        for vertex in &mut path.vertices {
            if let Vertex::Medium { position, medium } = vertex {
                *medium = world.medium_at(*position)?;
            }
        }
        Some(path)
    }
}
