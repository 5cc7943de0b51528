//! Custom densities whose line integrals the host has. Those without: tests/custom_medium.rs.

use crate::images::assert_the_same;
use crate::toy::scenes::{World, edges_under_area_lights};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use volgrad::math::{Colour, DAffine3, DVec3};
use volgrad::medium::{
    Collision, Custom, Density, DensityField, Flight, IntegratedField, Inversion, Line, Medium, Moments, Segment, Stretch,
    distance_number, moments, optical_depth, sample_distance,
};
use volgrad::phase::Phase;

/// Another density as a host would compute it. On the faces of its box rounding may put a point outside, where a box has density 0.
#[derive(Debug)]
struct Copy {
    original: Density<'static>,
    centre: DVec3,
}

const INWARD: f64 = 1e-12;

impl DensityField for Copy {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        let inward = |x: DVec3| self.centre + (x - self.centre) * (1.0 - INWARD);
        densities.iter_mut().zip(points).for_each(|(density, x)| *density = self.original.at(inward(*x)));
    }

    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        gradients.iter_mut().zip(points).for_each(|(gradient, x)| *gradient = self.original.gradient(*x));
    }
}

impl IntegratedField for Copy {
    fn moments(&self, stretch: &Stretch, gradients: bool) -> Moments {
        let Stretch { start, end, .. } = *stretch;
        let part = Stretch { start: start + INWARD, end: end - INWARD, ..*stretch };
        match (part.start < part.end, gradients) {
            (false, _) => Moments::default(),
            (true, true) => self.original.moments(&part),
            (true, false) => Moments { integral: self.original.integral(&part), ..Moments::default() },
        }
    }
}

const LOW: DVec3 = DVec3::new(0.4, -1.0, -0.5);
const SIZE: DVec3 = DVec3::new(1.2, 2.0, 1.2);

fn copy(original: Density<'static>) -> Density<'static> {
    let to_world = DAffine3::from_translation(LOW) * DAffine3::from_scale(SIZE);
    let copy = Box::leak(Box::new(Copy { original, centre: LOW + 0.5 * SIZE }));
    Density::Custom(Custom::exact(copy, to_world, 2.5))
}

fn world() -> (World, World) {
    let original = edges_under_area_lights();
    let mut copied = original.clone();
    copied.media[2].density = copy(original.media[2].density);
    (original, copied)
}

/// The grid of the scene, in the box that it has there.
#[test]
fn a_copy_renders_the_same() {
    let (original, copied) = world();
    assert_the_same(&original, &copied);
}

/// τ and both gradients along lines through, into and inside the box; and u → t → u, with the pdf that its cdf has.
#[test]
fn a_copy_has_the_same_lines() {
    const LINES: u32 = 2000;
    let (original, copied) = world();
    let media = [&original, &copied].map(|world| {
        [Medium { sigma_t: Colour::ONE, albedo: Colour::ONE, phase: Phase::ISOTROPIC, density: world.media[2].density }]
    });
    let segments = [Segment { end: f32::INFINITY, medium: 0, normal: Default::default() }];
    let mut rng = Pcg64::seed_from_u64(1);
    let mut point = |reach: f64| {
        let mut number = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        LOW + 0.5 * SIZE + reach * DVec3::new(number(), number(), number()) * SIZE
    };
    let (mut worst, mut collisions) = ([0.0f64; 4], 0);
    for i in 0..LINES {
        let (from, to) = (point(if i % 2 == 0 { 1.0 } else { 2.5 }), point(2.5));
        let (length, direction) = ((to - from).length(), (to - from).normalize());
        let lines = [0, 1].map(|i| Line::new(&media[i], from, direction, length, &segments));
        let [a, b] = lines.map(|line| optical_depth(&line).x);
        worst[0] = worst[0].max((a - b).abs());
        let ends = |line: &Line| {
            let moments = moments(line);
            [moments.near_gradient(direction, length)[0], moments.far_gradient(direction, length)[0]]
        };
        let [a, b] = [ends(&lines[0]), ends(&lines[1])];
        for (a, b) in a.into_iter().zip(b) {
            // Lines that graze a face have large gradients.
            worst[1] = worst[1].max((a - b).length() / (1.0 + a.length()));
        }
        let u = f64::from(i) / f64::from(LINES);
        let Flight::Collision(Collision { t, pdf, .. }) = sample_distance(&lines[1], u) else { continue };
        let Flight::Collision(Collision { t: expected, pdf: density, .. }) = sample_distance(&lines[0], u) else { continue };
        collisions += 1;
        let until = Line { length: t, ..lines[1] };
        worst[2] = worst[2].max((distance_number(&until) - u).abs());
        // Where the density is next to 0 a distance hardly matters.
        worst[3] = worst[3].max((t - expected).abs() * density).max((pdf - density).abs() * 1e-3);
    }
    println!("differences of τ, ∇τ, u → t → u, t: {worst:?} over {collisions} collisions");
    assert!(worst.iter().zip([1e-11, 1e-9, 1e-11, 1e-9]).all(|(worst, most)| *worst < most), "{worst:?}");
    assert!(collisions > LINES / 8);
}

/// Density 1, and only of what is finite.
#[derive(Debug)]
struct Finite;

impl DensityField for Finite {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        assert!(points.iter().all(|x| x.is_finite()));
        densities.fill(1.0);
    }

    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        assert!(points.iter().all(|x| x.is_finite()));
        gradients.fill(DVec3::ZERO);
    }
}

impl IntegratedField for Finite {
    fn moments(&self, stretch: &Stretch, _: bool) -> Moments {
        assert!(stretch.origin.is_finite() && stretch.direction.is_finite() && (stretch.end - stretch.start).is_finite());
        Moments { integral: stretch.end - stretch.start, ..Moments::default() }
    }
}

/// Whatever a path that is none asks for: no direction, no number, no end.
#[test]
fn hosts_are_asked_for_finite_points() {
    let infinite = f64::INFINITY;
    for custom in [
        Custom::exact(&Finite, DAffine3::IDENTITY, 1.0),
        Custom::new(&Finite, DAffine3::IDENTITY, 0.5, 1.0).expect("few panels"),
    ] {
        let density = Density::Custom(custom);
        let inside = DVec3::splat(0.5);
        for (origin, direction) in [
            (inside, DVec3::ZERO),
            (inside, DVec3::new(0.0, f64::NAN, 0.0)),
            (DVec3::new(0.5, 0.5, f64::NAN), DVec3::Z),
            (DVec3::new(0.5, 0.5, -infinite), DVec3::Z),
        ] {
            let stretch = Stretch { origin, direction, start: 0.0, end: infinite };
            assert_eq!(density.integral(&stretch), 0.0);
            assert_eq!(density.moments(&stretch), Moments::default());
            assert_eq!(density.invert(&stretch, 0.1), Inversion::Beyond(0.0));
            assert!(density.extent(&stretch).is_none());
        }
        let through = Stretch { origin: inside, direction: DVec3::Z, start: 0.0, end: infinite };
        assert!((density.integral(&through) - 0.5).abs() < 1e-12);
    }
}

/// Answers that are no values, one kind after the other; inside a box of density 1.
#[derive(Debug)]
struct Bad(u32);

impl DensityField for Bad {
    fn densities(&self, _: &[DVec3], densities: &mut [f64]) {
        densities.fill(1.0);
    }

    fn gradients(&self, _: &[DVec3], gradients: &mut [DVec3]) {
        gradients.fill(DVec3::ZERO);
    }
}

impl IntegratedField for Bad {
    fn moments(&self, stretch: &Stretch, _: bool) -> Moments {
        let length = stretch.end - stretch.start;
        let integral = [f64::NAN, f64::INFINITY, -1.0, length, 1.0 / length][self.0 as usize];
        let gradient = DVec3::splat(if self.0 == 3 { f64::NAN } else { 0.0 });
        Moments { integral, gradient, first_moment: gradient, ..Moments::default() }
    }
}

/// They count as 0, and so does a gradient that is none. An integral that falls where it should rise ends somewhere inside.
#[test]
fn bad_values_count_as_nothing() {
    let segments = [Segment { end: f32::INFINITY, medium: 0, normal: Default::default() }];
    for kind in 0..5 {
        let bad = Bad(kind);
        let density = Density::Custom(Custom::exact(&bad, DAffine3::IDENTITY, 1.0));
        let media = [Medium { sigma_t: Colour::ONE, albedo: Colour::ONE, phase: Phase::ISOTROPIC, density }];
        let line = Line::new(&media, DVec3::new(0.5, 0.5, -1.0), DVec3::Z, 3.0, &segments);
        let depth = optical_depth(&line).x;
        assert!((depth - if kind < 3 { 0.0 } else { 1.0 }).abs() < 1e-12, "{kind}: {depth}");
        assert!(moments(&line).near_gradient(DVec3::Z, 3.0)[0].is_finite());
        if let Flight::Collision(Collision { t, pdf, .. }) = sample_distance(&line, 0.3) {
            assert!((1.0..=2.0).contains(&t) && pdf.is_finite(), "{kind}: {t}");
        }
    }
}
