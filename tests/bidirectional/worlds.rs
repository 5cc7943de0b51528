//! Small worlds: fog before a wall and over a floor, one thing different in each.
//!
//! Lights stay away from media that scatter, so that the path sampler's 1/d² is bounded.

use crate::toy::Shape;
use crate::toy::scenes::{World, camera, environment_map, grid, homogeneous, rectangle};
use volgrad::math::{Colour, DAffine3, DVec3};
use volgrad::medium::{Custom, Density, DensityField, Medium};
use volgrad::scene::{Bsdf, Camera, Conductor, Falloff, Ggx, Guide, Light, Reflector, RoughConductor, RoughDielectric};

const METAL: Conductor = Conductor { eta: Colour::splat(0.2), k: Colour::new(3.9, 2.4, 2.2), reflectance: Colour::splat(0.9) };

pub fn fog() -> Medium<'static> {
    homogeneous([0.5; 3], [0.9; 3], 0.0)
}

pub fn diffuse(albedo: f64) -> Bsdf<'static> {
    Bsdf::Diffuse { albedo: Colour::splat(albedo) }
}

pub fn pinhole() -> Camera {
    camera([0.0, 0.0, -3.0], 0.5, 4)
}

/// A box of a medium before a wall and over a floor; no light yet.
pub fn room(camera: Camera, medium: Medium<'static>) -> World {
    World::new(camera)
        .medium([-1.2, -1.1, -1.2], [1.2, 1.1, 1.2], medium)
        .surface(rectangle([-2.0, -1.2, -1.5], [0.0, 0.0, 3.2], [4.0, 0.0, 0.0]), diffuse(0.6))
        .surface(rectangle([-2.0, -1.4, 1.6], [0.0, 3.2, 0.0], [4.0, 0.0, 0.0]), diffuse(0.7))
}

pub fn lamp(world: World) -> World {
    world.area_light([-0.7, 1.8, -0.7], [1.4, 0.0, 0.0], [0.0, 0.0, 1.4], 4.0, 1.0)
}

/// A lamp from below the fog's height, seen through whatever stands in the middle.
fn lamp_behind(world: World) -> World {
    world.area_light([-1.4, -0.9, 1.5], [0.0, 1.8, 0.0], [2.8, 0.0, 0.0], 2.0, 1.0)
}

fn lit(light: Light<'static>) -> World {
    room(pinhole(), fog()).light(light, 1.0)
}

pub fn lights() -> Vec<(&'static str, World)> {
    let (position, intensity) = (DVec3::new(0.3, 2.2, -0.2), Colour::new(3.0, 4.0, 5.0));
    let axis = DVec3::new(-0.2, -1.0, 0.1).normalize();
    let triangle = Shape::Triangle {
        corner: DVec3::new(-0.8, 1.8, -0.7),
        edge_u: DVec3::new(1.7, 0.2, 0.0),
        edge_v: DVec3::new(0.0, 0.0, 1.6),
    };
    let sphere = Shape::Sphere { centre: DVec3::new(0.2, 2.1, 0.0), radius: 0.5 };
    let direction = DVec3::new(0.4, -1.0, 0.5).normalize();
    vec![
        ("parallelogram", lamp(room(pinhole(), fog()))),
        ("triangle", room(pinhole(), fog()).shining(triangle, Colour::splat(4.0))),
        ("sphere", room(pinhole(), fog()).shining(sphere, Colour::splat(4.0))),
        ("environment", lit(Light::Environment { radiance: Colour::new(0.3, 0.4, 0.5) })),
        ("environment map", lit(environment_map(|i| if i == 13 { 9.0 } else { (i % 3) as f32 }))),
        ("directional", lit(Light::Directional { direction, irradiance: Colour::ONE })),
        ("point", lit(Light::Point { position, intensity })),
        ("spot", lit(Light::Spot { position, axis, intensity, falloff: Falloff::new(0.9, 0.7) })),
        (
            "all",
            lamp(room(pinhole(), fog()))
                .light(Light::Environment { radiance: Colour::new(0.3, 0.4, 0.5) }, 0.3)
                .light(Light::Directional { direction, irradiance: Colour::ONE }, 0.2)
                .light(Light::Point { position, intensity }, 2.0),
        ),
    ]
}

/// What the guides in [`guided`] have learned, in patches of 16 x 16 cells; the scene knows nothing of it.
pub fn carried(light: usize, i: usize, j: usize) -> f64 {
    [0.0, 1.0, 3.0, 0.5][(i / 16 + 3 * (j / 16) + light) % 4]
}

/// The same with a guide for each light.
pub fn guided() -> Vec<(&'static str, World)> {
    let guide = |light| Guide::learned(move |i, j| carried(light, i, j));
    lights()
        .into_iter()
        .map(|(name, world)| {
            let guides = (0..world.lights.len()).map(guide).collect();
            (name, world.guided(guides))
        })
        .collect()
}

/// A lamp above a ceiling with a window in it.
pub fn behind_a_window() -> World {
    let black = diffuse(0.0);
    room(pinhole(), fog())
        .area_light([-0.3, 2.6, -0.3], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6], 30.0, 1.0)
        .surface(rectangle([-4.0, 1.6, -4.0], [4.2, 0.0, 0.0], [0.0, 0.0, 8.0]), black)
        .surface(rectangle([0.9, 1.6, -4.0], [3.0, 0.0, 0.0], [0.0, 0.0, 8.0]), black)
        .surface(rectangle([0.2, 1.6, -4.0], [0.7, 0.0, 0.0], [0.0, 0.0, 3.6]), black)
        .surface(rectangle([0.2, 1.6, 0.3], [0.7, 0.0, 0.0], [0.0, 0.0, 4.0]), black)
}

pub fn cameras() -> Vec<(&'static str, World)> {
    let inside = Camera { position: DVec3::new(0.1, 0.2, -0.9), tan_half_fov_x: 0.9, ..pinhole() };
    let lens = Camera { lens_radius: 0.2, focal_distance: 2.8, ..pinhole() };
    let wide = Camera { width: 4, height: 2, crop: [0, 0, 4, 2], tan_half_fov_x: 0.7, ..pinhole() };
    vec![
        ("lens", lamp(room(lens, fog()))),
        ("crop", lamp(room(Camera { crop: [1, 0, 3, 3], ..pinhole() }, fog()))),
        ("inside the fog", lamp(room(inside, fog()))),
        ("lens inside the fog", lamp(room(Camera { lens_radius: 0.1, focal_distance: 1.0, ..inside }, fog()))),
        ("wide", lamp(room(wide, fog()))),
        ("no wall behind", lamp(World::new(lens).medium([-1.2, -1.1, -1.2], [1.2, 1.1, 1.2], fog()))),
    ]
}

/// Something of each material in the fog, tilted, lit from above and from behind.
pub fn materials() -> Vec<(&'static str, World)> {
    let ggx = Ggx { alpha: 0.35 };
    let mirror = Reflector::Mirror { reflectance: Colour::new(0.9, 0.8, 0.7) };
    let rough = Reflector::RoughConductor(RoughConductor { conductor: METAL, ggx });
    let bsdfs = [
        ("diffuse", Bsdf::Diffuse { albedo: Colour::new(0.8, 0.6, 0.4) }),
        ("mirror", Bsdf::from(mirror)),
        ("conductor", Bsdf::Conductor(METAL)),
        ("rough conductor", Bsdf::from(rough)),
        ("glass", Bsdf::Dielectric { eta: 1.5 }),
        ("rough glass", Bsdf::RoughDielectric(RoughDielectric { eta: 1.5, ggx })),
        ("two-sided diffuse", Bsdf::TwoSided(Reflector::Diffuse { albedo: Colour::new(0.8, 0.6, 0.4) })),
        ("two-sided mirror", Bsdf::TwoSided(mirror)),
        ("two-sided rough conductor", Bsdf::TwoSided(rough)),
    ];
    // Seen from the front on the left and from behind on the right.
    let tilted = |bsdf| {
        room(pinhole(), fog())
            .surface(rectangle([-1.3, -0.9, 0.1], [0.0, 1.7, 0.5], [1.2, 0.0, 0.1]), bsdf)
            .surface(rectangle([0.1, -0.9, 0.1], [1.2, 0.0, 0.1], [0.0, 1.7, 0.5]), bsdf)
    };
    bsdfs.into_iter().map(|(name, bsdf)| (name, lamp_behind(lamp(tilted(bsdf))))).collect()
}

/// Light that gets out of glass, and into it: the squared index of refraction counts once each way.
pub fn glass() -> Vec<(&'static str, World)> {
    let smooth = Bsdf::Dielectric { eta: 1.5 };
    let rough = Bsdf::RoughDielectric(RoughDielectric { eta: 1.5, ggx: Ggx { alpha: 0.3 } });
    let sphere = |radius| Shape::Sphere { centre: DVec3::new(0.1, 0.0, 0.0), radius };
    let ball = |bsdf| room(pinhole(), fog()).surface(sphere(0.7), bsdf);
    vec![
        ("ball", lamp(ball(smooth))),
        ("lamp in a ball", ball(smooth).shining(sphere(0.3), Colour::splat(4.0))),
        ("under a sheet", under_a_sheet(smooth)),
        ("rough ball", lamp(ball(rough))),
        ("lamp in a rough ball", ball(rough).shining(sphere(0.3), Colour::splat(4.0))),
        ("under a rough sheet", under_a_sheet(rough)),
    ]
}

/// Between the lamp and everything else: the camera is where the index of refraction is another one, so to say under water.
fn under_a_sheet(bsdf: Bsdf<'static>) -> World {
    lamp(room(pinhole(), fog()).surface(rectangle([-2.2, 1.3, -1.8], [0.0, 0.0, 3.6], [4.4, 0.0, 0.0]), bsdf))
}

/// A density that waves, as a host's function.
#[derive(Debug)]
struct Waves;

impl DensityField for Waves {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        let at = |x: &DVec3| 0.6 + 0.5 * (2.0 * x.x + 3.0 * x.y).sin() * (2.5 * x.z).cos();
        densities.iter_mut().zip(points).for_each(|(density, x)| *density = at(x));
    }

    fn gradients(&self, _: &[DVec3], gradients: &mut [DVec3]) {
        gradients.fill(DVec3::ZERO);
    }
}

pub fn media() -> Vec<(&'static str, World)> {
    let (low, high) = ([-1.2, -1.1, -1.2], [1.2, 1.1, 1.2]);
    let checkers = grid(low, high, [4, 3, 3], |[x, y, z]| [1.5, 0.0, 0.6][((x + 2 * y + z) % 3) as usize]);
    let to_world = DAffine3::from_translation(low.into()) * DAffine3::from_scale(DVec3::from(high) - DVec3::from(low));
    let waves = Density::Custom(Custom::new(&Waves, to_world, 0.05, 1.1).expect("few panels"));
    let chromatic = homogeneous([0.3, 0.8, 1.6], [0.95, 0.9, 0.6], 0.0);
    let only = |medium| lamp(room(pinhole(), medium));
    vec![
        ("thin", only(homogeneous([0.02; 3], [0.9; 3], 0.0))),
        ("dense", only(homogeneous([3.0; 3], [0.95; 3], 0.0))),
        ("chromatic", only(chromatic)),
        ("forward", only(homogeneous([1.0; 3], [0.9; 3], 0.7))),
        ("backward", only(homogeneous([1.0; 3], [0.9; 3], -0.6))),
        ("grid", only(Medium { density: checkers, ..homogeneous([1.0, 1.2, 1.5], [0.9; 3], 0.3) })),
        ("custom", only(Medium { density: waves, ..homogeneous([1.0, 1.2, 1.5], [0.9; 3], 0.3) })),
        ("nested", only(fog()).medium([-0.6, -0.5, -0.4], [0.5, 0.6, 0.5], chromatic)),
    ]
}
