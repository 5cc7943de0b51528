//! The world: a camera, media, and convex regions that say where the media are.

use super::{camera::Camera, medium::Medium, vector::*};

/// The half space n·x ≤ offset.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Points out of the half space; need not be of unit length.
    pub normal: Vec3,
    pub offset: f64,
}

impl Plane {
    pub fn through(point: Vec3, normal: Vec3) -> Plane {
        Plane { normal, offset: dot(normal, point) }
    }

    /// Parameter of the point of `origin + t·direction` on the plane: infinite or NaN if they are parallel.
    pub fn crossing(&self, origin: Vec3, direction: Vec3) -> f64 {
        (self.offset - dot(self.normal, origin)) / dot(self.normal, direction)
    }
}

/// A convex region: the points inside of all planes. Without planes it is the whole space.
#[derive(Clone, Debug)]
pub struct Region {
    pub planes: Vec<Plane>,
    /// Index into [`World::media`]; `None` is vacuum, which can carve a hole into earlier regions.
    pub medium: Option<usize>,
}

impl Region {
    pub fn everywhere(medium: usize) -> Region {
        Region { planes: Vec::new(), medium: Some(medium) }
    }

    pub fn axis_aligned(min: Vec3, max: Vec3, medium: usize) -> Region {
        Region::image_of_unit_cube(&Affine::onto_box(min, max), medium)
    }

    /// The box of a grid, for example.
    pub fn image_of_unit_cube(map: &Affine, medium: usize) -> Region {
        let far_corner = map.apply([1.0; 3]);
        let mut planes = Vec::new();
        for normal in map.inverse_rows() {
            planes.push(Plane::through(map.origin, scale(-1.0, normal)));
            planes.push(Plane::through(far_corner, normal));
        }
        Region { planes, medium: Some(medium) }
    }

    pub fn contains(&self, point: Vec3) -> bool {
        self.planes.iter().all(|plane| dot(plane.normal, point) <= plane.offset)
    }
}

#[derive(Clone, Debug)]
pub struct World {
    pub camera: Camera,
    pub media: Vec<Medium>,
    /// Where regions overlap, the later one counts.
    pub regions: Vec<Region>,
}

impl World {
    /// One medium in the whole space (a grid still ends at its box). The camera sees it from the origin.
    pub fn filled_with(medium: Medium) -> World {
        World {
            camera: Camera::looking_at(ZERO, [0.0, 0.0, 1.0], 1.0, 0.0),
            media: vec![medium],
            regions: vec![Region::everywhere(0)],
        }
    }

    /// Index of the medium at a point; `None` in vacuum. On a face either side may be meant.
    pub fn medium_at(&self, point: Vec3) -> Option<usize> {
        let region = self.regions.iter().rev().find(|region| region.contains(point));
        region.and_then(|region| region.medium)
    }

    /// σ_t at a point, zero in vacuum.
    pub fn sigma_t_at(&self, point: Vec3) -> Rgb {
        self.medium_at(point).map_or(ZERO, |m| self.media[m].sigma_t_at(point))
    }
}
