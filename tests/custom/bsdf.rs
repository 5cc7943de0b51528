//! Custom BSDFs.

use crate::images::{assert_the_same, by_path, difference};
use crate::toy::scenes::{BLACK, World, camera, edges_with_rough_surfaces, homogeneous, rectangle};
use volgrad::math::{Colour, DVec2, DVec3, Vec3};
use volgrad::medium::{NONE, Segment};
use volgrad::path::{
    Path, PathErrorKind, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, VERTEX_SURFACE, Vertex, path_log_gradient,
};
use volgrad::scene::{
    Bsdf, BsdfFunction, Conductor, CustomBsdf, Ggx, Light, Reflector, RoughConductor, RoughDielectric, SurfaceFrame,
    SurfacePoint,
};

const METAL: Bsdf = Bsdf::RoughConductor(RoughConductor {
    conductor: Conductor { eta: Colour::splat(0.2), k: Colour::new(3.9, 2.4, 2.2), reflectance: Colour::ONE },
    ggx: Ggx { alpha: 0.4 },
});
const PAINT: Bsdf = Bsdf::Diffuse { albedo: Colour::new(0.7, 0.6, 0.5) };
const GLASS: Bsdf = Bsdf::RoughDielectric(RoughDielectric { eta: 1.5, ggx: Ggx { alpha: 0.3 } });

/// A built-in BSDF as a host would compute it; its gradient may be unknown.
#[derive(Debug)]
struct Copy {
    original: Bsdf<'static>,
    gradient: bool,
}

impl BsdfFunction for Copy {
    fn transmits(&self) -> bool {
        self.original.transmits()
    }

    fn eval(&self, _: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> Colour {
        self.original.eval(&SurfacePoint::with_normal(DVec3::Z), to_camera, to_light)
    }

    fn pdf(&self, _: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> f64 {
        self.original.pdf(&SurfacePoint::with_normal(DVec3::Z), to_camera, to_light)
    }

    fn sample(&self, _: &SurfaceFrame, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<(DVec3, f64)> {
        self.original
            .sample(&SurfacePoint::with_normal(DVec3::Z), to_camera, u, lobe)
            .map(|sample| (sample.direction, sample.eta_squared))
    }

    fn log_gradient(&self, _: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> Option<([DVec3; 3], [DVec3; 3])> {
        self.original.log_gradient(&SurfacePoint::with_normal(DVec3::Z), to_camera, to_light).filter(|_| self.gradient)
    }
}

fn copy(original: Bsdf<'static>, gradient: bool) -> CustomBsdf<'static> {
    CustomBsdf(Box::leak(Box::new(Copy { original, gradient })))
}

fn with_copies(world: &World, replace: impl Fn(Bsdf<'static>) -> Bsdf<'static>) -> World {
    let mut world = world.clone();
    world.materials.iter_mut().for_each(|bsdf| *bsdf = replace(*bsdf));
    world
}

/// Rough metal and rough glass in view, both lit by all kinds of lights.
fn rough_world() -> World {
    edges_with_rough_surfaces().surface(rectangle([-0.9, -0.2, -0.9], [0.9, 0.0, 0.2], [0.0, 0.9, 0.2]), GLASS)
}

/// Copies of the rough surfaces.
#[test]
fn a_copy_renders_the_same() {
    let original = rough_world();
    let copied = with_copies(&original, |bsdf| match bsdf {
        Bsdf::RoughConductor(_) | Bsdf::RoughDielectric(_) => Bsdf::Custom(copy(bsdf, true)),
        bsdf => bsdf,
    });
    assert_the_same(&original, &copied);
    let black = with_copies(&original, |bsdf| match bsdf {
        Bsdf::RoughConductor(_) | Bsdf::RoughDielectric(_) => BLACK,
        bsdf => bsdf,
    });
    let gone = difference(&by_path(&original, None), &by_path(&black, None));
    assert!(gone > 0.1, "what is copied is seen: {gone}");
}

/// A gradient is nothing that a sampler asks for.
#[test]
fn a_copy_without_gradient_renders_the_same() {
    let original = rough_world();
    let [with, without] = [true, false].map(|gradient| {
        with_copies(&original, |bsdf| match bsdf {
            Bsdf::RoughConductor(_) | Bsdf::RoughDielectric(_) => Bsdf::Custom(copy(bsdf, gradient)),
            bsdf => bsdf,
        })
    });
    for ((name, a), (_, b)) in crate::images::images(&with).iter().zip(crate::images::images(&without)) {
        assert!(*a == b, "{name}");
    }
}

/// A diffuse copy, on one side and on both. The core does not know that links may end on it, so that only plain paths are the same.
#[test]
fn a_diffuse_copy_renders_the_same() {
    let original = edges_with_rough_surfaces();
    let copied = with_copies(&original, |bsdf| match bsdf {
        Bsdf::Diffuse { albedo } if albedo != Colour::ZERO => Bsdf::Custom(copy(bsdf, true)),
        Bsdf::TwoSided(diffuse @ Reflector::Diffuse { .. }) => Bsdf::TwoSided(Reflector::Custom(copy(diffuse.into(), true))),
        bsdf => bsdf,
    });
    let difference = difference(&by_path(&original, None), &by_path(&copied, None));
    assert!(difference < 1e-6, "{difference}");
}

/// A path from the camera over a vertex in fog to a tilted surface, and on to a light; the gradient at the vertex.
fn gradient_before(bsdf: Bsdf<'static>) -> Result<volgrad::path::Gradient, (PathErrorKind, u32)> {
    let light = Light::Point { position: DVec3::new(1.5, 1.0, 0.2), intensity: Colour::ONE };
    let world = World::new(camera([0.0, 0.0, -3.0], 0.8, 8))
        .medium([-3.0; 3], [3.0; 3], homogeneous([0.5, 0.7, 0.9], [0.8; 3], 0.3))
        .surface(rectangle([-1.0, -1.0, 1.0], [0.0, 2.0, 0.5], [2.0, 0.0, 0.3]), bsdf)
        .light(light, 1.0);
    let normal = Vec3::from(DVec3::new(0.0, 2.0, 0.5).cross(DVec3::new(2.0, 0.0, 0.3)).normalize());
    let vertex = |kind: u32, index: u32, position: [f64; 3]| {
        let position = DVec3::from(position).into();
        Vertex { kind, index, position, normal, shading_normal: normal, ..Vertex::default() }
    };
    let vertices = [
        vertex(VERTEX_CAMERA, 0, [0.0, 0.0, -3.0]),
        vertex(VERTEX_MEDIUM, 0, [0.2, -0.3, -0.4]),
        vertex(VERTEX_SURFACE, 1, [0.1, 0.2, 1.0]),
        vertex(VERTEX_LIGHT, 0, [1.5, 1.0, 0.2]),
    ];
    let segments = [0, 0, 0].map(|medium| Segment { end: f32::INFINITY, medium, normal: Vec3::default() });
    let path = Path { vertices: &vertices, segments: &segments, edge_ends: &[1, 2, 3] };
    assert!(segments.iter().all(|segment| segment.medium != NONE));
    path_log_gradient(&world.scene(), &path, 1).map_err(|error| (error.kind, error.index))
}

/// Gradients are the original's, which differences check (tests/gradients); unknown ones are refused, at the vertex that lacks them.
#[test]
fn gradients_need_the_bsdfs_own() {
    let original = gradient_before(METAL).expect("f > 0");
    let found = gradient_before(Bsdf::Custom(copy(METAL, true))).expect("f > 0");
    assert!(original.factors.profile_next.iter().all(|g| g.length() > 1e-3), "the BSDF's part is no trifle");
    for channel in 0..3 {
        // The path's normal is of single precision, and so is its length.
        let (found, original) = (found.factors.channel(channel), original.factors.channel(channel));
        assert!((found - original).length() < 1e-6 * original.length());
    }
    let refused = gradient_before(Bsdf::Custom(copy(METAL, false)));
    assert_eq!(refused.expect_err("not known"), (PathErrorKind::NoGradient, 2));
    assert!(gradient_before(PAINT).is_ok());
}

/// Answers that are no values, one kind after the other.
#[derive(Debug)]
struct Bad(u32);

impl BsdfFunction for Bad {
    fn transmits(&self) -> bool {
        self.0 == 7
    }

    fn eval(&self, _: &SurfaceFrame, c: DVec3, l: DVec3) -> Colour {
        match self.0 {
            0 => Colour::new(0.1, f64::NAN, 0.1),
            1 => Colour::splat(f64::INFINITY),
            2 => Colour::new(0.1, -0.1, 0.1),
            _ => PAINT.eval(&SurfacePoint::with_normal(DVec3::Z), c, l),
        }
    }

    fn pdf(&self, _: &SurfaceFrame, c: DVec3, l: DVec3) -> f64 {
        match self.0 {
            3 => f64::NAN,
            4 => f64::INFINITY,
            5 => -1.0,
            _ => PAINT.pdf(&SurfacePoint::with_normal(DVec3::Z), c, l),
        }
    }

    fn sample(&self, _: &SurfaceFrame, c: DVec3, u: DVec2, lobe: f64) -> Option<(DVec3, f64)> {
        let (l, eta_squared) = PAINT
            .sample(&SurfacePoint::with_normal(DVec3::Z), c, u, lobe)
            .map(|sample| (sample.direction, sample.eta_squared))?;
        match self.0 {
            6 => Some((DVec3::splat(f64::NAN), 1.0)),
            7 => Some((DVec3::new(1.0, 0.0, 0.0), f64::NAN)),
            8 => Some((2.0 * l, 1.0)),
            9 => Some((-l, eta_squared)),
            _ => Some((l, eta_squared)),
        }
    }

    fn log_gradient(&self, _: &SurfaceFrame, _: DVec3, _: DVec3) -> Option<([DVec3; 3], [DVec3; 3])> {
        Some(([DVec3::splat(f64::NAN); 3], [DVec3::ZERO; 3]))
    }
}

/// They count as 0: the image is darker than with paint, but made of numbers; `image` sees to it that the film drops nothing.
#[test]
fn bad_values_count_as_nothing() {
    let world = edges_with_rough_surfaces();
    for kind in 0..10 {
        let bad = Bsdf::Custom(CustomBsdf(Box::leak(Box::new(Bad(kind)))));
        let with_bad = with_copies(&world, |bsdf| match bsdf {
            Bsdf::Diffuse { albedo } if albedo == Colour::ZERO => BLACK,
            _ => bad,
        });
        for (name, image) in crate::images::images(&with_bad) {
            assert!(image.iter().all(|c| c.is_finite()), "{kind}: {name}");
        }
    }
    let gradient = gradient_before(Bsdf::Custom(CustomBsdf(&Bad(10)))).expect("f > 0");
    assert!(gradient.luminance.is_finite() && gradient.factors.profile_next == [DVec3::ZERO; 3]);
}
