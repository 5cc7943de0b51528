//! Custom lights.

use crate::images::{assert_the_same, bidirectionally, by_chains, by_path, difference, images, shifts};
use crate::toy::estimate::Estimate;
use crate::toy::scenes::{World, camera, edges, environment_map, homogeneous};
use volgrad::math::{Colour, DVec2, DVec3, Vec3};
use volgrad::medium::Segment;
use volgrad::path::path_log_gradient;
use volgrad::path::{Gradient, Path, PathError, PathErrorKind, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, Vertex};
use volgrad::sampler::Stats;
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic, MAX_LENGTH, Options};
use volgrad::scene::{CustomProfile, CustomSky, Falloff, Guide, Light, LightSample, ProfileFunction, SkyFunction};

/// A built-in light as a host would compute it; its gradient may be unknown.
#[derive(Debug)]
struct Copy {
    original: Light<'static>,
    gradient: bool,
}

impl SkyFunction for Copy {
    fn radiance(&self, to_sky: DVec3) -> Colour {
        self.original.emission(-to_sky)
    }

    fn pdf(&self, to_sky: DVec3) -> f64 {
        self.original.direction_pdf(-to_sky)
    }

    fn sample(&self, u: DVec2) -> Option<DVec3> {
        let LightSample::Sky { to_light, pdf } = self.original.sample(u) else { return None };
        (pdf > 0.0).then_some(to_light)
    }
}

impl ProfileFunction for Copy {
    fn intensity(&self, direction: DVec3) -> Colour {
        0.5 * self.original.emission(direction)
    }

    fn log_gradient(&self, direction: DVec3) -> Option<[DVec3; 3]> {
        self.original.log_gradient(direction).filter(|_| self.gradient)
    }
}

fn copy(original: Light<'static>, gradient: bool) -> Light<'static> {
    let copy: &Copy = Box::leak(Box::new(Copy { original, gradient }));
    match original {
        Light::Point { position, .. } | Light::Spot { position, .. } => {
            Light::CustomPoint { position, profile: CustomProfile { function: copy, scale: Colour::splat(2.0) } }
        }
        _ => Light::CustomSky(CustomSky { function: copy, scale: Colour::ONE }),
    }
}

const POSITION: DVec3 = DVec3::new(0.3, 2.7, 0.1);
const POINT: Light = Light::Point { position: POSITION, intensity: Colour::new(10.0, 8.0, 6.0) };

fn spot() -> Light<'static> {
    let axis = DVec3::new(0.1, -1.0, 0.2).normalize();
    Light::Spot { position: POSITION, axis, intensity: Colour::new(30.0, 20.0, 10.0), falloff: Falloff::new(0.95, 0.6) }
}

fn map() -> Light<'static> {
    environment_map(|i| [0.0, 1.0, 3.0, 0.2, 0.5][i % 5])
}

fn lit_by(light: Light<'static>) -> World {
    edges().light(light, 0.7).area_light([0.0, 2.6, -0.3], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8], 2.0, 0.3)
}

#[test]
fn a_copy_of_a_map_renders_the_same() {
    assert_the_same(&lit_by(map()), &lit_by(copy(map(), true)));
}

/// With shifts too, as no link ends at either.
#[test]
fn a_copy_of_a_spot_renders_the_same() {
    for shift in shifts() {
        let [original, copied] = [spot(), copy(spot(), false)].map(|light| by_path(&lit_by(light), shift));
        let difference = difference(&original, &copied);
        assert!(difference < 1e-6, "{shift:?}: {difference}");
    }
}

/// The subpaths of both leave it in all directions alike; links end only at the original.
#[test]
fn a_copy_of_a_point_renders_the_same() {
    let worlds = [lit_by(POINT), lit_by(copy(POINT, false))];
    for render in [by_path, bidirectionally, by_chains] {
        let [original, copied] = [0, 1].map(|i| render(&worlds[i], None));
        let difference = difference(&original, &copied);
        assert!(difference < 1e-6, "{difference}");
    }
}

/// Subpaths of the copy of a spot carry what its profile says, wherever a guide sends them: the sums of images of light subpaths
/// agree, |z| < 4 in 3 channels, which a new seed trips with probability 2e-4.
#[test]
fn guided_subpaths_carry_the_profile() {
    let guide = || Guide::learned(|i, j| f64::from(u8::from((i + 2 * j) % 5 == 0)));
    let estimate = |light: Light<'static>, seed: u64| {
        let world = edges().light(light, 1.0).guided(vec![guide()]);
        let scene = world.scene();
        let (heuristic, light_vertices) = (Heuristic::Balance, MAX_LENGTH);
        let options = Options { max_length: 4, rr_depth: 3, seed, heuristic, light_vertices, roulette: 0.0, shift: None };
        let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
        Estimate::of_batches(&world, 6, |batch, film| {
            let mut stats = Stats::default();
            for pass in batch * 6..(batch + 1) * 6 {
                sampler.sample_pixels(pass, 0..64, film, &mut stats).expect("the toy host never stops");
            }
            stats
        })
    };
    let (original, copied) = (estimate(spot(), 1), estimate(copy(spot(), false), 2));
    for channel in 0..3 {
        let (a, b) = (original.channel(channel), copied.channel(channel));
        let z = (a.value - b.value) / a.error.hypot(b.error);
        println!("{} {} z {z:.2}", a.value, b.value);
        assert!(z.abs() < 4.0 && a.error < 0.1 * a.value);
    }
}

/// At a vertex in fog between the camera and a light.
fn gradient(light: Light<'static>) -> Result<Gradient, PathError> {
    let world = World::new(camera([0.0, 0.0, -3.0], 0.8, 8))
        .medium([-4.0; 3], [4.0; 3], homogeneous([0.5, 0.7, 0.9], [0.8; 3], 0.3))
        .light(light, 1.0);
    let vertex = |kind: u32, position: DVec3| Vertex { kind, position: position.into(), ..Vertex::default() };
    let to_light = if matches!(light, Light::CustomSky(_)) { DVec3::new(0.6, 0.8, 0.0) } else { POSITION };
    let vertices = [
        vertex(VERTEX_CAMERA, DVec3::new(0.0, 0.0, -3.0)),
        vertex(VERTEX_MEDIUM, DVec3::new(1.6, 0.9, 0.3)),
        vertex(VERTEX_LIGHT, to_light),
    ];
    let segments = [0, 0].map(|medium| Segment { end: f32::INFINITY, medium, normal: Vec3::default() });
    let path = Path { vertices: &vertices, segments: &segments, edge_ends: &[1, 2] };
    path_log_gradient(&world.scene(), &path, 1)
}

/// A profile's is needed, a sky's direction stays.
#[test]
fn gradients_need_the_profiles_own() {
    let (original, found) = (gradient(spot()).expect("f > 0"), gradient(copy(spot(), true)).expect("f > 0"));
    assert!(original.factors.profile_next[0].length() > 0.1, "the profile's part is no trifle");
    assert!((found.luminance - original.luminance).length() < 1e-9 * original.luminance.length());
    let refused = gradient(copy(spot(), false)).expect_err("not known");
    assert_eq!(refused, PathErrorKind::NoGradient.at(2));
    // Nothing arrives through endless fog, and nothing else is wrong.
    assert_eq!(gradient(copy(map(), false)).expect_err("dark").kind, PathErrorKind::ZeroContribution);
}

/// Answers that are no values, one kind after the other.
#[derive(Debug)]
struct Bad(u32);

impl Bad {
    fn value(&self) -> Colour {
        match self.0 {
            0 => Colour::new(0.1, f64::NAN, 0.1),
            1 => Colour::splat(f64::INFINITY),
            2 => Colour::new(0.1, -0.1, 0.1),
            _ => Colour::ONE,
        }
    }
}

impl SkyFunction for Bad {
    fn radiance(&self, _: DVec3) -> Colour {
        self.value()
    }

    fn pdf(&self, _: DVec3) -> f64 {
        [0.1, f64::NAN, f64::INFINITY, -1.0, 0.0][self.0.saturating_sub(2) as usize % 5]
    }

    fn sample(&self, _: DVec2) -> Option<DVec3> {
        match self.0 {
            7 => Some(DVec3::splat(f64::NAN)),
            8 => Some(DVec3::new(1.0, 1.0, 0.0)),
            9 => None,
            _ => Some(DVec3::Y),
        }
    }
}

impl ProfileFunction for Bad {
    fn intensity(&self, _: DVec3) -> Colour {
        self.value()
    }

    fn log_gradient(&self, _: DVec3) -> Option<[DVec3; 3]> {
        Some([DVec3::splat(f64::NAN); 3])
    }
}

/// They count as 0, and never enter the film, which drops nothing. The other light is still there.
#[test]
fn bad_values_count_as_nothing() {
    for kind in 0..10 {
        let bad: &Bad = Box::leak(Box::new(Bad(kind)));
        let point = Light::CustomPoint { position: POSITION, profile: CustomProfile { function: bad, scale: Colour::ONE } };
        let sky = Light::CustomSky(CustomSky { function: bad, scale: Colour::ONE });
        for light in [point, sky] {
            for (name, image) in images(&lit_by(light)) {
                assert!(image.iter().all(|c| c.is_finite()), "{kind}: {name}");
            }
        }
        let found = gradient(point);
        assert_eq!(found.is_ok(), kind > 2, "nothing arrives at all");
        assert!(found.is_err() || found.is_ok_and(|found| found.luminance.is_finite()));
    }
}
