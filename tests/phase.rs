//! Phase functions: normalised, forward for g > 0, and sampled as they say.

mod common;
mod reference;

use common::statistics::chi_square_p_value;
use proptest::prelude::*;
use reference::{differences::derivative, optical_depth::gauss_legendre, random::*};
use std::f64::consts::PI;
use volgrad::math::{DVec2, DVec3};
use volgrad::phase::{Phase, cosine_gradient_apex, cosine_gradient_wing};

/// Isotropic, next to it, ordinary, and next to a mirror or a straight line.
const MEAN_COSINES: [f64; 11] = [-0.999, -0.9, -0.5, -1e-4, -1e-12, 0.0, 1e-9, 0.3, 0.8, 0.99, 0.9999];

/// Of a quadrature over the sphere: 1 + g² + 2gc is known to a rounding of 1, and is as small as (1 − |g|)².
fn quadrature_tolerance(g: f64) -> f64 {
    1e-9 + 4.0 * f64::EPSILON / (1.0 - g.abs()).powi(2)
}

/// Some roundings of numbers of order 1.
const ROUNDINGS: f64 = 16.0 * f64::EPSILON;

/// Chance that a test against a histogram fails for a new seed although all is right, per histogram.
const SIGNIFICANCE: f64 = 1e-4;
const SAMPLES: usize = 400_000;

fn unit(v: reference::vector::Vec3) -> DVec3 {
    DVec3::from_array(reference::vector::normalize(v))
}

fn sine(cosine: f64) -> f64 {
    (1.0 - cosine * cosine).max(0.0).sqrt()
}

/// 2π ∫ f dc between two cosines: the peaks at both ends are wide only as the square of their distance, so intervals halve
/// towards them.
fn integral_over_cosines(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let halved = (0..=300).map(|k| 0.5_f64.powf(f64::from(k) / 6.0));
    let near_backward = halved.clone().map(|distance| 1.0 - distance);
    let near_forward = halved.map(|distance| distance - 1.0);
    let mut cuts: Vec<f64> =
        near_forward.chain(near_backward).chain([low, high]).filter(|c| (low..=high).contains(c)).collect();
    cuts.sort_by(f64::total_cmp);
    let interval = |pair: &[f64]| gauss_legendre(pair[0], pair[1]).map(|(c, weight)| weight * f(c)).iter().sum::<f64>();
    2.0 * PI * cuts.windows(2).map(interval).sum::<f64>()
}

#[test]
fn values_integrate_to_one() {
    for g in MEAN_COSINES {
        let total = integral_over_cosines(-1.0, 1.0, |c| Phase::henyey_greenstein(g).eval(c));
        assert!((total - 1.0).abs() < quadrature_tolerance(g), "g = {g}: {total}");
    }
}

/// Straight on is c = −1, so the cosine of the deflection is −c: its mean is g, and g > 0 goes forward.
#[test]
fn mean_cosine_is_g() {
    for g in MEAN_COSINES {
        let mean = integral_over_cosines(-1.0, 1.0, |c| -c * Phase::henyey_greenstein(g).eval(c));
        assert!((mean - g).abs() < quadrature_tolerance(g), "g = {g}: {mean}");
    }
    assert!(Phase::henyey_greenstein(0.5).eval(-1.0) > 10.0 * Phase::henyey_greenstein(0.5).eval(1.0));
    assert_eq!(Phase::ISOTROPIC.eval(0.3), 1.0 / (4.0 * PI));
}

#[test]
fn log_derivative_is_that_of_differences() {
    for g in MEAN_COSINES {
        let phase = Phase::henyey_greenstein(g);
        // At the peak of |g| = 0.9999, log f bends within 1e-8, which the steps of the differences do not resolve.
        let cosines = if g.abs() < 0.95 { [-0.99, -0.3, 0.4, 0.99] } else { [-0.5, -0.3, 0.4, 0.5] };
        for c in cosines {
            let [slope] = derivative(|h| [phase.eval(c + h).ln()]);
            let error = (phase.log_derivative(c) - slope).abs();
            assert!(error < 1e-9 * (1.0 + slope.abs()), "g = {g}, c = {c}: {error:e}");
        }
    }
}

proptest! {
    /// u → direction → u. Roundings of the cosine are magnified on both ways, most next to a mirror or a straight line; the turn
    /// is known relative to the sine.
    #[test]
    fn numbers_survive_their_direction(
        g in -0.9999..0.9999_f64,
        u in (1e-6..1.0_f64, 0.0..1.0_f64),
        seed in any::<u64>(),
    ) {
        let phase = Phase::henyey_greenstein(g);
        let to_previous = DVec3::from_array(random_direction(&mut generator(seed)));
        let to_next = phase.sample(to_previous, DVec2::from(u)).expect("built in");
        prop_assert!((to_next.length() - 1.0).abs() < ROUNDINGS);

        let back = phase.invert(to_previous, to_next).expect("built in");
        let c = to_previous.dot(to_next);
        let magnified = 1.0 + 1.0 / ((1.0 - g * g) * (1.0 + g * g + 2.0 * g * c).sqrt());
        prop_assert!((back.x - u.0).abs() <= ROUNDINGS * magnified, "{back} for {u:?}, c = {c}");
        let turned = (back.y - u.1).abs();
        prop_assert!(turned.min(1.0 - turned) * sine(c) <= ROUNDINGS, "{back} for {u:?}, c = {c}");
    }

    /// Direction → u → direction.
    #[test]
    fn directions_survive_their_numbers(g in -0.9999..0.9999_f64, seed in any::<u64>()) {
        let mut rng = generator(seed);
        let [to_previous, to_next] = [0; 2].map(|_| DVec3::from_array(random_direction(&mut rng)));
        let phase = Phase::henyey_greenstein(g);
        let u = phase.invert(to_previous, to_next).expect("built in");
        prop_assert!((0.0..=1.0).contains(&u.x) && (0.0..1.0).contains(&u.y), "{u}");
        let error = (phase.sample(to_previous, u).expect("built in") - to_next).length();
        let magnified = 1.0 / (1.0 - g * g).powi(2);
        prop_assert!(error * sine(to_previous.dot(to_next)) <= ROUNDINGS * magnified, "{error:e} for {u}");
    }

    /// The ends of the range of numbers are straight back and straight on. An angle is the root of its cosine's rounding.
    #[test]
    fn extreme_numbers_are_extreme_directions(g in -0.9999..0.9999_f64, turn in 0.0..1.0_f64, seed in any::<u64>()) {
        let to_previous = DVec3::from_array(random_direction(&mut generator(seed)));
        for (number, expected) in [(0.0, to_previous), (1.0, -to_previous)] {
            let direction = Phase::henyey_greenstein(g).sample(to_previous, DVec2::new(number, turn)).expect("built in");
            let tolerance = (2.0 * ROUNDINGS).sqrt() / (1.0 - g.abs());
            prop_assert!((direction - expected).length() <= tolerance, "{direction} for {number}");
        }
    }
}

/// [`SAMPLES`] directions per g, in bins of equal angle to the axis and of equal turn about it, at [`SIGNIFICANCE`].
#[test]
fn samples_follow_the_pdf() {
    const ANGLES: usize = 60;
    const TURNS: usize = 4;
    let mut rng = generator(21);
    for g in MEAN_COSINES {
        let phase = Phase::henyey_greenstein(g);
        let to_previous = DVec3::from_array(random_direction(&mut rng));
        // Any frame about the axis, not necessarily the library's.
        let side = unit(to_previous.cross(DVec3::new(0.3, -0.5, 0.8)).to_array());
        let other = to_previous.cross(side);

        let mut counts = vec![0; ANGLES * TURNS];
        for _ in 0..SAMPLES {
            let u = DVec2::new(uniform(&mut rng, 0.0, 1.0), uniform(&mut rng, 0.0, 1.0));
            let direction = phase.sample(to_previous, u).expect("built in");
            let sine = direction.dot(side).hypot(direction.dot(other));
            let angle = sine.atan2(direction.dot(to_previous));
            let turn = 0.5 + direction.dot(other).atan2(direction.dot(side)) / (2.0 * PI);
            let angle_bin = ((angle / PI * ANGLES as f64) as usize).min(ANGLES - 1);
            let turn_bin = ((turn * TURNS as f64) as usize).min(TURNS - 1);
            counts[angle_bin * TURNS + turn_bin] += 1;
        }

        let edge = |bin: usize| (PI * bin as f64 / ANGLES as f64).cos();
        let share = |bin: usize| integral_over_cosines(edge(bin + 1), edge(bin), |c| phase.eval(c)) / TURNS as f64;
        let probabilities: Vec<f64> = (0..ANGLES * TURNS).map(|bin| share(bin / TURNS)).collect();
        let p = chi_square_p_value(&counts, &probabilities);
        println!("g = {g}: p = {p:.3}");
        assert!(p > SIGNIFICANCE, "g = {g}: p = {p:e}");
    }
}

/// ∇c for a moving wing and a moving apex, by differences.
#[test]
fn cosine_gradients_are_those_of_differences() {
    let mut rng = generator(22);
    for _ in 0..100 {
        let [p, x, n] = [0; 3].map(|_| DVec3::from_array(random_vector(&mut rng, -1.0, 1.0)));
        if (p - x).length() < 0.3 || (n - x).length() < 0.3 {
            continue;
        }
        let cosine = |p: DVec3, x: DVec3, n: DVec3| (p - x).normalize().dot((n - x).normalize());
        let gradient = |f: &dyn Fn(DVec3) -> f64| {
            DVec3::from_array([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| derivative(|h| [f(h * axis)])[0]))
        };
        let (to_p, to_n, c) = ((p - x).normalize(), (n - x).normalize(), cosine(p, x, n));
        let (d_p, d_n) = ((p - x).length(), (n - x).length());
        let wing = cosine_gradient_wing(to_p, to_n, c, d_p);
        let apex = cosine_gradient_apex(to_p, to_n, c, d_p, d_n);
        assert!((wing - gradient(&|offset| cosine(p + offset, x, n))).length() < 1e-9);
        assert!((apex - gradient(&|offset| cosine(p, x + offset, n))).length() < 1e-9);
    }
}
