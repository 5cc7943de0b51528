//! Where on which surface a custom BSDF is asked for, and textures.

use crate::images::{assert_the_same, by_path, difference, images};
use crate::toy::Surface;
use crate::toy::scenes::{World, edges_under_area_lights, edges_with_rough_surfaces, rectangle};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use volgrad::math::{Colour, DMat3, DVec2, DVec3};
use volgrad::scene::{Bsdf, BsdfFunction, CustomBsdf, Reflector, SurfaceFrame, SurfacePoint};
use volgrad::shift::{self, Kernel, Mode, Radius};

/// The built-in BSDF of one surface, which is only asked for on it.
#[derive(Debug)]
struct OnSurface {
    original: Bsdf<'static>,
    surface: Surface,
    user: u64,
    asked: &'static AtomicU64,
}

impl OnSurface {
    /// The toy numbers its surfaces. In a surface's plane, not only on the surface: that is where depths are linear.
    fn check(&self, at: &SurfaceFrame) {
        self.asked.fetch_add(1, Relaxed);
        assert_eq!(at.user, self.user);
        let normal = self.surface.shape.normal(at.position);
        let distance = (at.position - self.surface.shape.corner()).dot(normal);
        assert!(distance.abs() < 1e-5, "{distance} from surface {}", self.user);
        let two_sided = matches!(self.original, Bsdf::TwoSided(_));
        let (z, towards) = (at.axes.z_axis, at.axes.z_axis.dot(normal));
        assert!((z.length() - 1.0).abs() < 1e-9 && (towards - 1.0).abs() < 1e-6 || (two_sided && (towards + 1.0).abs() < 1e-6));
        assert!((at.axes.transpose() * at.axes).abs_diff_eq(DMat3::IDENTITY, 1e-9) && at.axes.determinant() > 0.0);
    }

    fn one_sided(&self) -> Bsdf<'static> {
        if let Bsdf::TwoSided(reflector) = self.original { reflector.into() } else { self.original }
    }
}

const UP: SurfacePoint = SurfacePoint::with_normal(DVec3::Z);

impl BsdfFunction for OnSurface {
    fn eval(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> Colour {
        self.check(at);
        self.one_sided().eval(&UP, to_camera, to_light)
    }

    fn pdf(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> f64 {
        self.check(at);
        assert!(!self.original.is_lambertian());
        self.one_sided().pdf(&UP, to_camera, to_light)
    }

    fn sample(&self, at: &SurfaceFrame, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<(DVec3, f64)> {
        self.check(at);
        assert!(!self.original.is_lambertian());
        self.one_sided().sample(&UP, to_camera, u, lobe).map(|sample| (sample.direction, sample.eta_squared))
    }

    fn log_gradient(&self, _: &SurfaceFrame, _: DVec3, _: DVec3) -> Option<([DVec3; 3], [DVec3; 3])> {
        panic!("nothing that a sampler asks for")
    }
}

/// A world whose surfaces' BSDFs are all custom but for black ones, and how often each was asked for.
fn checked(world: &World) -> (World, Vec<&'static AtomicU64>) {
    let (mut copy, mut counts) = (world.clone(), vec![]);
    for (number, surface) in world.geometry.surfaces.iter().enumerate() {
        let original = world.materials[surface.material as usize];
        if original.is_black() {
            continue;
        }
        let asked: &AtomicU64 = Box::leak(Box::new(AtomicU64::new(0)));
        let function =
            CustomBsdf(Box::leak(Box::new(OnSurface { original, surface: *surface, user: number as u64 + 1, asked })));
        let reflector = if original.is_lambertian() { Reflector::Texture(function) } else { Reflector::Custom(function) };
        let bsdf = if matches!(original, Bsdf::TwoSided(_)) { Bsdf::TwoSided(reflector) } else { reflector.into() };
        copy.materials[surface.material as usize] = bsdf;
        counts.push(asked);
    }
    (copy, counts)
}

/// The modes that `images` leaves out.
fn other_shifts() -> [Option<shift::Options>; 2] {
    let disk = Kernel::Disk(Radius::Pixels(1.0));
    [Mode::Exact, Mode::LinearDepth].map(|mode| Some(shift::Options { run: 2, ..shift::Options::new(mode, disk, 5) }))
}

/// With every sampler and every kind of shift a BSDF is asked for where the host's hits have said that its surface is, and nowhere else;
/// and Lambertian ones are for shifts what built-in ones are.
#[test]
fn points_are_on_their_surfaces() {
    let original = edges_with_rough_surfaces();
    let (copy, counts) = checked(&original);
    assert_eq!(counts.len(), 3, "a wall, a rough mirror, a wall with two sides");
    assert_the_same(&original, &copy);
    for shift in other_shifts() {
        let difference = difference(&by_path(&original, shift), &by_path(&copy, shift));
        assert!(difference < 1e-4, "{shift:?}: {difference}");
    }
    let counts: Vec<_> = counts.iter().map(|count| count.load(Relaxed)).collect();
    assert!(counts.iter().all(|count| *count > 300), "{counts:?}");
}

const LEFT: Colour = Colour::new(0.9, 0.2, 0.1);
const RIGHT: Colour = Colour::new(0.1, 0.4, 0.8);

/// Of two colours, on either side of x = 0.
#[derive(Debug)]
struct TwoColours;

impl BsdfFunction for TwoColours {
    fn eval(&self, at: &SurfaceFrame, to_camera: DVec3, to_light: DVec3) -> Colour {
        assert!(to_camera == DVec3::Z && to_light == DVec3::Z);
        (if at.position.x < 0.0 { LEFT } else { RIGHT }) / std::f64::consts::PI
    }

    fn pdf(&self, _: &SurfaceFrame, _: DVec3, _: DVec3) -> f64 {
        panic!("known of all that are Lambertian")
    }

    fn sample(&self, _: &SurfaceFrame, _: DVec3, _: DVec2, _: f64) -> Option<(DVec3, f64)> {
        panic!("known of all that are Lambertian")
    }

    fn log_gradient(&self, _: &SurfaceFrame, _: DVec3, _: DVec3) -> Option<([DVec3; 3], [DVec3; 3])> {
        panic!("known of all that are Lambertian")
    }
}

/// A wall behind the media, in two pieces or in one with a texture.
fn wall(textured: bool) -> World {
    let half = |x: f64, width: f64| rectangle([x, -1.9, 2.1], [0.0, 2.4, 0.0], [width, 0.0, 0.0]);
    let world = edges_under_area_lights();
    if textured {
        return world.surface(half(-2.2, 4.4), Bsdf::Texture(CustomBsdf(&TwoColours)));
    }
    world.surface(half(-2.2, 2.2), Bsdf::Diffuse { albedo: LEFT }).surface(half(0.0, 2.2), Bsdf::Diffuse { albedo: RIGHT })
}

/// Members of a batch see other points than the path, so that a texture's values at each count. Biased modes keep the path's value, or take
/// it from a plane that goes on beyond an edge: they are left out.
#[test]
fn a_texture_renders_as_pieces_do() {
    let [pieces, textured] = [false, true].map(wall);
    let exact = |name: &str| name.ends_with("None") || name.contains("Exchangeable");
    for ((name, a), (_, b)) in images(&pieces).iter().zip(images(&textured)).filter(|((name, _), _)| exact(name)) {
        let difference = difference(a, &b);
        println!("{name}: {difference:.1e}");
        assert!(difference < 1e-4, "{name}: {difference}");
    }
    let grey = edges_under_area_lights();
    let seen = difference(&by_path(&grey, None), &by_path(&textured, None));
    assert!(seen > 0.1, "the wall is seen: {seen}");
}
