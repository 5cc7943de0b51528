//! Single scattering in a homogeneous box or in unbounded media, against quadrature of the integral along each camera ray; with
//! every kind of light, with and without shifts. The quadrature shares no code with the library.
//!
//! Limits: |z| < 4 for the image's mean, whose standard error is asserted to be below 0.1 % (with VOLGRAD_LONG below 0.025 %, so that
//! it is right to 0.1 %), and |z| < 4.5 for each of its 16 pixels. Significance: 13 means and 208 pixels; a new seed trips one with
//! probability 0.2 % if all is right. Seeds are fixed.

mod toy;

use std::f64::consts::PI;
use toy::estimate::{Estimate, scale};
use toy::scenes::{World, camera, homogeneous};
use volgrad::math::{Colour, DVec2, DVec3};
use volgrad::sampler;
use volgrad::scene::Light;
use volgrad::shift::{self, Kernel, Mode, Radius};

const SIDE: u32 = 4;
const ALBEDO: f64 = 0.8;
/// For integrands without a peak near the camera's rays.
const ASIDE: DVec3 = DVec3::new(0.0, 4.0, 0.0);

/// The medium's box, what is in it, and the same as a world.
struct Setting {
    low: DVec3,
    high: DVec3,
    sigma_t: f64,
    g: f64,
    world: World,
}

/// The camera looks through the front face; all rays leave through the back one, so that pixels are smooth.
fn boxed(sigma_t: f64, g: f64) -> Setting {
    setting([-3.0, -1.0, -1.0], [3.0, 1.0, 1.0], sigma_t, g, [0.1, 0.05, -2.5])
}

/// The camera is inside, and the medium has no end.
fn unbounded(sigma_t: f64, g: f64) -> Setting {
    setting([-1e4; 3], [1e4; 3], sigma_t, g, [0.0; 3])
}

fn setting(low: [f64; 3], high: [f64; 3], sigma_t: f64, g: f64, position: [f64; 3]) -> Setting {
    let world = World::new(camera(position, 0.25, SIDE)).medium(low, high, homogeneous([sigma_t; 3], [ALBEDO; 3], g));
    Setting { low: low.into(), high: high.into(), sigma_t, g, world }
}

impl Setting {
    fn with(mut self, light: Light<'static>) -> Self {
        self.world = self.world.light(light, 1.0);
        self
    }

    /// Distances between which the line is in the box.
    fn inside(&self, from: DVec3, direction: DVec3) -> (f64, f64) {
        let (a, b) = ((self.low - from) / direction, (self.high - from) / direction);
        (a.min(b).max_element(), a.max(b).min_element())
    }

    /// How far light goes through the medium to x, against `direction`, over `distance`.
    fn transmittance(&self, x: DVec3, direction: DVec3, distance: f64) -> f64 {
        (-self.sigma_t * self.inside(x, direction).1.min(distance)).exp()
    }

    /// Henyey–Greenstein of light that comes from direction `to_light` and goes on along −`view`.
    fn phase(&self, view: DVec3, to_light: DVec3) -> f64 {
        let cos_turn = to_light.dot(view);
        (1.0 - self.g * self.g) / (4.0 * PI * (1.0 + self.g * self.g - 2.0 * self.g * cos_turn).powf(1.5))
    }

    /// ∫ σ_s Tr(camera, x) S(x) dt along a ray, t = near + D tan φ around the point nearest to `focus`, where S(x) has its peak.
    fn along(&self, view: DVec3, cosine: f64, focus: DVec3, panels: u32, scattered: &dyn Fn(DVec3) -> f64) -> f64 {
        let origin = self.world.camera.position;
        let (enter, leave) = self.inside(origin, view);
        let start = enter.max(self.world.camera.near_clip / cosine);
        let leave = leave.min(start + 40.0 / self.sigma_t);
        let nearest = (focus - origin).dot(view);
        let distance = (origin + nearest * view - focus).length();
        let (low, high) = (((start - nearest) / distance).atan(), ((leave - nearest) / distance).atan());
        gauss_panels(low, high, panels, &|phi| {
            let t = nearest + distance * phi.tan();
            let stretch = distance / (phi.cos() * phi.cos());
            let x = origin + t * view;
            stretch * ALBEDO * self.sigma_t * (-self.sigma_t * (t - start)).exp() * scattered(x)
        })
    }

    /// Radiance of a ray: the scattered light of a light's points or directions.
    fn radiance(&self, view: DVec3, cosine: f64) -> f64 {
        match self.world.lights[0] {
            Light::Point { position, intensity } => self.along(view, cosine, position, 12, &|x| {
                let (to_light, d) = ((position - x).normalize(), (position - x).length());
                self.phase(view, to_light) * self.transmittance(x, to_light, d) * intensity.x / (d * d)
            }),
            Light::Directional { direction, irradiance } => self.along(view, cosine, ASIDE, 4, &|x| {
                self.phase(view, -direction) * self.transmittance(x, -direction, f64::INFINITY) * irradiance.x
            }),
            Light::Parallelogram { corner, edge_u, edge_v, radiance } => {
                let normal = edge_u.cross(edge_v);
                self.along(view, cosine, corner + 0.5 * (edge_u + edge_v), 12, &|x| {
                    gauss_panels(0.0, 1.0, 2, &|u| {
                        gauss_panels(0.0, 1.0, 2, &|v| {
                            let to_point = corner + u * edge_u + v * edge_v - x;
                            let (to_light, d) = (to_point.normalize(), to_point.length());
                            let projected = (-normal.dot(to_light)).max(0.0) / (d * d);
                            self.phase(view, to_light) * self.transmittance(x, to_light, d) * projected * radiance.x
                        })
                    })
                })
            }
            Light::Environment { radiance } => {
                self.along(view, cosine, ASIDE, 4, &|x| {
                    // Midpoints: how far the box reaches has kinks over the directions.
                    let (n, m) = (100, 200);
                    let cell = |i: i32| {
                        let (z, turn) = ((f64::from(i / m) + 0.5) / f64::from(n), (f64::from(i % m) + 0.5) / f64::from(m));
                        let (c, s) = (1.0 - 2.0 * z, 2.0 * (z * (1.0 - z)).sqrt());
                        let to_light = DVec3::new(s * (2.0 * PI * turn).cos(), s * (2.0 * PI * turn).sin(), c);
                        self.phase(view, to_light) * self.transmittance(x, to_light, f64::INFINITY)
                    };
                    4.0 * PI / f64::from(n * m) * (0..n * m).map(cell).sum::<f64>() * radiance.x
                }) + radiance.x * self.unscattered(view, cosine)
            }
            _ => unreachable!("no quadrature for this light"),
        }
    }

    /// Transmittance of a whole camera ray.
    fn unscattered(&self, view: DVec3, cosine: f64) -> f64 {
        let (enter, leave) = self.inside(self.world.camera.position, view);
        (-self.sigma_t * (leave - enter.max(self.world.camera.near_clip / cosine)).max(0.0)).exp()
    }

    /// Mean radiance of pixel number `pixel`.
    fn pixel(&self, pixel: usize) -> f64 {
        let corner = DVec2::new((pixel as u32 % SIDE).into(), (pixel as u32 / SIDE).into());
        // Gauss–Legendre with 3 × 3 points; 2 × 2 would be off by 0.02 %.
        const POINTS: [(f64, f64); 3] =
            [(-0.774_596_669_241_483, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.774_596_669_241_483, 5.0 / 18.0)];
        let mut mean = 0.0;
        for (x, weight_x) in POINTS {
            for (y, weight_y) in POINTS {
                let ray = self.world.camera.ray(corner + 0.5 * DVec2::new(1.0 + x, 1.0 + y), DVec2::ZERO);
                mean += weight_x * weight_y * self.radiance(ray.direction, ray.cosine);
            }
        }
        mean
    }

    /// The path sampler's image against the quadrature.
    fn assert_agrees(&self, name: &str, passes: u64, shift: Option<shift::Options>) {
        let options = sampler::Options {
            max_depth: 2,
            rr_depth: 9,
            seed: 7,
            shift,
            left_out: volgrad::sampler::Lengths::NONE,
            first: volgrad::sampler::FirstVertices::ALL,
        };
        let estimate = Estimate::of_path_tracer(&self.world, options, passes * scale());
        let exact: Vec<f64> = (0..estimate.pixels()).map(|i| self.pixel(i)).collect();
        let mean = exact.iter().sum::<f64>() / exact.len() as f64;
        let total = estimate.total();
        let z = exact.iter().enumerate().map(|(i, exact)| estimate.pixel(i).z_to(*exact)).fold(0.0, |a: f64, z| a.max(z.abs()));
        let (error, deviation) = (total.error / mean, total.value / mean - 1.0);
        println!(
            "{name}: {mean:.5}, off {:+.4} % ± {:.4} %, z {:+.2}, worst pixel {z:.2}; {} paths",
            100.0 * deviation,
            100.0 * error,
            total.z_to(mean),
            estimate.stats.paths,
        );
        let enough = if scale() > 1 { 2.5e-4 } else { 1e-3 };
        assert!(error < enough, "{name}: standard error {error}");
        assert!(total.z_to(mean).abs() < 4.0 && z < 4.5, "{name}");
    }
}

/// Gauss–Legendre with 5 points in each of `panels` equal parts.
fn gauss_panels(low: f64, high: f64, panels: u32, f: &dyn Fn(f64) -> f64) -> f64 {
    const POINTS: [(f64, f64); 3] = [
        (0.0, 0.568_888_888_888_889),
        (0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.906_179_845_938_664, 0.236_926_885_056_189),
    ];
    let half = 0.5 * (high - low) / f64::from(panels);
    let panel = |i: u32| {
        let middle = low + half * f64::from(2 * i + 1);
        let pair =
            |(x, w): (f64, f64)| if x == 0.0 { w * f(middle) } else { w * (f(middle - half * x) + f(middle + half * x)) };
        half * POINTS.into_iter().map(pair).sum::<f64>()
    };
    (0..panels).map(panel).sum()
}

fn point(position: [f64; 3]) -> Light<'static> {
    Light::Point { position: position.into(), intensity: Colour::splat(3.0) }
}

fn parallelogram() -> Light<'static> {
    let (corner, edge_u, edge_v) = (DVec3::new(-0.7, 1.4, -0.5), DVec3::new(1.2, 0.0, 0.0), DVec3::new(0.0, 0.3, 1.0));
    Light::Parallelogram { corner, edge_u, edge_v, radiance: Colour::splat(2.0) }
}

fn shifts(mode: Mode, kernel: Kernel) -> Option<shift::Options> {
    Some(shift::Options::new(mode, kernel, 3))
}

/// Passes of 16 × 64 paths for the standard error asked for.
const PASSES: u64 = 640;

#[test]
fn point_light_in_an_unbounded_medium() {
    for g in [0.0, 0.6, -0.3] {
        unbounded(0.6, g).with(point([0.3, 1.2, 1.5])).assert_agrees(&format!("unbounded, g = {g}"), 2 * PASSES, None);
    }
}

#[test]
fn point_light_inside_and_outside_a_box() {
    boxed(1.5, 0.5).with(point([1.5, 0.4, 0.3])).assert_agrees("inside", PASSES, None);
    boxed(1.5, -0.3).with(point([0.3, 1.9, -0.2])).assert_agrees("outside", PASSES, None);
}

#[test]
fn directional_light() {
    let direction = DVec3::new(0.6, -1.0, 0.0).normalize();
    boxed(1.5, 0.5).with(Light::Directional { direction, irradiance: Colour::ONE }).assert_agrees("directional", PASSES, None);
}

fn under_a_panel() -> Setting {
    let mut setting = boxed(1.2, 0.5).with(parallelogram());
    let Light::Parallelogram { corner, edge_u, edge_v, .. } = parallelogram() else { return setting };
    let shape = toy::Shape::Parallelogram { corner, edge_u, edge_v };
    setting.world.geometry.surfaces.push(toy::Surface { shape, material: 0, light: 0 });
    setting
}

#[test]
fn area_light() {
    under_a_panel().assert_agrees("area", PASSES, None);
}

#[test]
fn environment() {
    boxed(1.2, 0.5).with(Light::Environment { radiance: Colour::ONE }).assert_agrees("environment", PASSES, None);
}

#[test]
fn shifted_paths_under_a_point_light() {
    let (disk, ball) = (Kernel::Disk(Radius::Pixels(0.8)), Kernel::Ball(0.2));
    for (mode, kernel) in [(Mode::Exact, disk), (Mode::Exact, ball), (Mode::Exchangeable, disk), (Mode::Exchangeable, ball)] {
        let setting = boxed(1.5, 0.5).with(point([0.3, 1.9, -0.2]));
        setting.assert_agrees(&format!("{mode:?} {kernel:?}"), PASSES, shifts(mode, kernel));
    }
}

#[test]
fn shifted_paths_under_an_area_light() {
    let shift = shifts(Mode::Exact, Kernel::Ball(0.3));
    under_a_panel().assert_agrees("area, exact", PASSES, shift);
}
