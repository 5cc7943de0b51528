//! What the statistical tests look at: everything of a toy scene in one owner, and the scene with all kinds of edges.

use super::{Geometry, MediumBox, Shape, Surface};
use volgrad::math::{Colour, DAffine3, DMat3, DVec3, Rgb};
use volgrad::medium::{Density, Grid, Medium, NONE};
use volgrad::phase::Phase;
use volgrad::scene::{
    Bsdf, Camera, Conductor, EnvironmentMap, Ggx, Guide, Light, Lights, Reflector, RoughConductor, Scene, running_sums,
    sums_length,
};

/// Owns what a `Scene` borrows.
#[derive(Clone, Debug)]
pub struct World {
    pub camera: Camera,
    pub media: Vec<Medium<'static>>,
    pub materials: Vec<Bsdf<'static>>,
    pub lights: Vec<Light<'static>>,
    /// Picking probabilities of the lights.
    pub picks: Vec<f64>,
    cdf: Vec<f64>,
    /// The medium in front of each light; no light here lies in another one than where its first point is.
    light_media: Vec<u32>,
    /// Of each light's subpaths, or none.
    pub guides: Vec<Guide>,
    pub geometry: Geometry,
}

pub const BLACK: Bsdf = Bsdf::Diffuse { albedo: Colour::ZERO };

impl World {
    pub fn new(camera: Camera) -> Self {
        Self {
            camera,
            media: vec![],
            materials: vec![BLACK],
            lights: vec![],
            picks: vec![],
            cdf: vec![],
            light_media: vec![],
            guides: vec![],
            geometry: Geometry::default(),
        }
    }

    /// The lights' picking probabilities are proportional to `weight`.
    pub fn light(mut self, light: Light<'static>, weight: f64) -> Self {
        self.lights.push(light);
        self.picks.push(weight);
        let total: f64 = self.picks.iter().sum();
        let mut sum = 0.0;
        self.cdf = self
            .picks
            .iter()
            .map(|pick| {
                sum += pick / total;
                sum
            })
            .collect();
        self.cdf.last_mut().into_iter().for_each(|last| *last = 1.0);
        self.find_light_media();
        self
    }

    fn find_light_media(&mut self) {
        let place = |light: &Light| match *light {
            Light::Parallelogram { corner, edge_u, edge_v, .. } => Some(corner + 0.5 * (edge_u + edge_v)),
            Light::Triangle { corner, edge_u, edge_v, .. } => Some(corner + 0.25 * (edge_u + edge_v)),
            Light::Sphere { centre, radius, .. } => Some(centre + radius * DVec3::X),
            Light::Point { position, .. } | Light::Spot { position, .. } | Light::CustomPoint { position, .. } => {
                Some(position)
            }
            _ => None,
        };
        self.light_media = self.lights.iter().map(|l| place(l).map_or(NONE, |x| self.geometry.medium_at(x))).collect();
    }

    /// A light of this shape and radiance, which is black.
    pub fn shining(self, shape: Shape, radiance: Colour) -> Self {
        let light = match shape {
            Shape::Parallelogram { corner, edge_u, edge_v } => Light::Parallelogram { corner, edge_u, edge_v, radiance },
            Shape::Triangle { corner, edge_u, edge_v } => Light::Triangle { corner, edge_u, edge_v, radiance },
            Shape::Sphere { centre, radius } => Light::Sphere { centre, radius, radiance },
            Shape::Disc { .. } => panic!("there are no discs among the lights"),
        };
        let index = self.lights.len() as u32;
        let mut world = self.light(light, 1.0);
        world.geometry.surfaces.push(Surface { shape, material: 0, light: index });
        world
    }

    /// A parallelogram light, and its black surface.
    pub fn area_light(self, corner: [f64; 3], edge_u: [f64; 3], edge_v: [f64; 3], radiance: f64, weight: f64) -> Self {
        let (corner, edge_u, edge_v) = (corner.into(), edge_u.into(), edge_v.into());
        let light = self.lights.len() as u32;
        let mut world = self.light(Light::Parallelogram { corner, edge_u, edge_v, radiance: Colour::splat(radiance) }, weight);
        world.geometry.surfaces.push(Surface { shape: Shape::Parallelogram { corner, edge_u, edge_v }, material: 0, light });
        world
    }

    pub fn medium(mut self, low: [f64; 3], high: [f64; 3], medium: Medium<'static>) -> Self {
        let index = self.media.len() as u32;
        self.media.push(medium);
        self.geometry.boxes.push(MediumBox::new(low, high, index));
        self.camera.medium = self.geometry.medium_at(self.camera.position + self.camera.near_clip * self.camera.forward);
        self.find_light_media();
        self
    }

    pub fn surface(mut self, shape: Shape, bsdf: Bsdf<'static>) -> Self {
        let material = self.materials.len() as u32;
        self.materials.push(bsdf);
        self.geometry.surfaces.push(Surface { shape, material, light: NONE });
        self
    }

    pub fn guided(self, guides: Vec<Guide>) -> Self {
        Self { guides, ..self }
    }

    pub fn scene(&self) -> Scene<'_> {
        let environment = self.lights.iter().position(Light::is_environment);
        let environment = environment.map(|i| i as u32);
        let lights =
            Lights { lights: &self.lights, cdf: &self.cdf, media: &self.light_media, guides: &self.guides, environment };
        let bounds = self.geometry.bounds();
        Scene { camera: self.camera, media: &self.media, materials: &self.materials, lights, bounds }
    }
}

/// A square image of `side` pixels, seen along +z from `position`.
pub fn camera(position: [f64; 3], tan_half_fov: f64, side: u32) -> Camera {
    Camera {
        position: position.into(),
        forward: DVec3::Z,
        right: DVec3::X,
        up: DVec3::Y,
        tan_half_fov_x: tan_half_fov,
        width: side,
        height: side,
        crop: [0, 0, side, side],
        near_clip: 0.1,
        medium: NONE,
        lens_radius: 0.0,
        focal_distance: 1.0,
    }
}

pub fn homogeneous(sigma_t: [f64; 3], albedo: [f64; 3], g: f64) -> Medium<'static> {
    Medium { sigma_t: sigma_t.into(), albedo: albedo.into(), phase: Phase::henyey_greenstein(g), density: Density::Homogeneous }
}

/// A grid of `size` samples in the box from `low` to `high`, whose density at sample (x, y, z) is `density`.
pub fn grid(low: [f64; 3], high: [f64; 3], size: [i32; 3], density: impl Fn([i32; 3]) -> f32) -> Density<'static> {
    let mut samples = vec![];
    for z in 0..size[2] {
        for y in 0..size[1] {
            samples.extend((0..size[0]).map(|x| density([x, y, z])));
        }
    }
    let (low, high) = (DVec3::from(low), DVec3::from(high));
    let local_to_world = DAffine3::from_translation(low) * DAffine3::from_scale(high - low);
    Density::Grid(Grid::new(samples.leak(), size, local_to_world, &[]).expect("counts fit"))
}

pub fn rectangle(corner: [f64; 3], edge_u: [f64; 3], edge_v: [f64; 3]) -> Shape {
    Shape::Parallelogram { corner: corner.into(), edge_u: edge_u.into(), edge_v: edge_v.into() }
}

/// All kinds of edges, no light yet: fog in a room; in it a dense chromatic medium that ends in the middle of the image, and a
/// grid whose density jumps at its own box's faces and between empty and full samples; an occluder above that throws a shadow into
/// the media; an occluder before them, seen by the camera; and a wall behind.
pub fn edges() -> World {
    let fog = homogeneous([0.15; 3], [0.8; 3], 0.0);
    let dense = homogeneous([1.2, 1.5, 2.0], [0.95, 0.9, 0.8], 0.4);
    let (low, high) = ([0.4, -1.0, -0.5], [1.6, 1.0, 0.7]);
    let checkers = grid(low, high, [4, 3, 3], |[x, y, z]| [2.5, 0.0, 0.8][((x + 2 * y + z) % 3) as usize]);
    let cloud = Medium { density: checkers, ..homogeneous([1.0; 3], [0.9; 3], -0.3) };
    World::new(camera([0.0, 0.0, -3.0], 0.8, 8))
        .medium([-2.5, -2.0, -1.4], [2.5, 2.0, 2.5], fog)
        .medium([-1.2, -1.3, -0.6], [0.1, 1.3, 0.8], dense)
        .medium([0.3, -1.2, -0.6], [1.7, 1.2, 0.9], cloud)
        .surface(rectangle([-0.6, 1.6, -0.4], [1.1, 0.0, 0.0], [0.0, 0.0, 0.8]), BLACK)
        .surface(Shape::Disc { centre: DVec3::new(-0.5, -0.5, -1.6), normal: -DVec3::Z, radius: 0.35 }, BLACK)
        .surface(
            rectangle([-2.2, -1.8, 2.2], [0.0, 2.4, 0.0], [4.4, 0.0, 0.0]),
            Bsdf::Diffuse { albedo: Colour::new(0.7, 0.6, 0.5) },
        )
}

/// Lit by a point light outside the fog, so that 1/d² stays bounded.
pub fn edges_under_point_light() -> World {
    edges().light(Light::Point { position: DVec3::new(0.3, 2.7, 0.1), intensity: Colour::splat(10.0) }, 1.0)
}

/// Lit by a parallelogram, a constant environment and a directional light.
pub fn edges_under_area_lights() -> World {
    edges()
        .area_light([0.0, 2.6, -0.3], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8], 8.0, 0.5)
        .light(Light::Environment { radiance: Colour::new(0.3, 0.4, 0.5) }, 0.3)
        .light(Light::Directional { direction: DVec3::new(0.4, -1.0, 0.5).normalize(), irradiance: Colour::ONE }, 0.2)
}

/// The same, with a mirror in the dense medium, another one behind the cloud and a pane of smooth glass in the fog: runs end before
/// them, and paths begin on them.
pub fn edges_with_specular_surfaces() -> World {
    let mirror = Bsdf::Mirror { reflectance: Colour::new(0.9, 0.8, 0.7) };
    edges_under_area_lights()
        .surface(rectangle([-1.0, -0.9, 0.6], [0.9, 0.0, 0.0], [0.0, 0.5, -0.7]), mirror)
        .surface(rectangle([0.4, -1.0, 1.3], [0.0, 1.6, 0.4], [1.2, 0.0, 0.0]), mirror)
        .surface(rectangle([-1.1, 1.4, -0.7], [0.8, 0.0, 0.0], [0.0, 0.0, 1.4]), Bsdf::Dielectric { eta: 1.5 })
}

/// The same, with a rough mirror and a two-sided wall in view, whose back the camera sees.
pub fn edges_with_rough_surfaces() -> World {
    let conductor = Conductor { eta: Colour::splat(0.2), k: Colour::new(3.9, 2.4, 2.2), reflectance: Colour::ONE };
    let rough = Bsdf::RoughConductor(RoughConductor { conductor, ggx: Ggx { alpha: 0.4 } });
    let two_sided = Bsdf::TwoSided(Reflector::Diffuse { albedo: Colour::new(0.7, 0.8, 0.6) });
    edges_under_area_lights()
        .surface(rectangle([-1.7, -1.4, 0.2], [0.0, 0.5, 1.2], [3.4, 0.0, 0.0]), rough)
        .surface(rectangle([-1.6, 0.1, 0.4], [1.6, 0.0, 0.2], [0.0, 1.1, 0.3]), two_sided)
}

/// An image of 8 by 5 texels as a light; it is never freed.
pub fn environment_map(texel: impl Fn(usize) -> f32) -> Light<'static> {
    let texels: Vec<Rgb> = (0..40).map(|i| Rgb { r: texel(i), g: texel(i), b: texel(i) }).collect();
    let mut sums = vec![0.0; sums_length(8, 5)];
    running_sums(&texels, 8, 5, Colour::ONE, &mut sums);
    let to_world = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    let map = EnvironmentMap::new(texels.leak(), 8, 5, to_world, Colour::ONE, sums.leak());
    Light::EnvironmentMap(map.expect("the lengths fit"))
}
