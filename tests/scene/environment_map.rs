//! Environment maps: bilinear in longitude and latitude, sampled at the density that is stated, with the gradient that differences give.
//!
//! Significance: the chi-square tests fail below p = 1e-4; seeds are fixed, so that they pass for ever or never.

use super::{ROUNDING, direction, unit_square};
use crate::reference::differences::gradient;
use crate::reference::random::{generator, random_direction, uniform};
use crate::statistics::chi_square_p_value;
use proptest::prelude::*;
use std::f64::consts::PI;
use volgrad::math::{Colour, DMat3, DVec2, DVec3, Rgb, luminance, orthonormal_basis};
use volgrad::scene::{EnvironmentMap, Light, LightSample, running_sums, sums_length};

const SCALE: Colour = Colour::new(2.0, 1.0, 0.5);

/// An image, what it is sampled with, and how it is turned.
pub struct Map {
    texels: Vec<Rgb>,
    size: [usize; 2],
    sums: Vec<f64>,
    to_world: DMat3,
}

impl Map {
    pub fn new(size: [usize; 2], texel: impl FnMut(usize) -> Rgb) -> Self {
        let [width, height] = size;
        let texels: Vec<Rgb> = (0..width * height).map(texel).collect();
        let mut sums = vec![0.0; sums_length(width, height)];
        running_sums(&texels, width, height, SCALE, &mut sums);
        let y = DVec3::new(0.48, -0.6, 0.64);
        let (z, x) = orthonormal_basis(y);
        Self { texels, size, sums, to_world: DMat3::from_cols(x, y, z) }
    }

    /// Values over four orders of magnitude, every third texel black.
    pub fn random(size: [usize; 2], seed: u64) -> Self {
        let mut rng = generator(seed);
        let mut value = || uniform(&mut rng, -4.0, 4.0).exp() as f32;
        Self::new(size, |i| if i % 3 == 1 { Rgb::default() } else { Rgb { r: value(), g: value(), b: value() } })
    }

    /// Nowhere black.
    pub fn bright(size: [usize; 2], seed: u64) -> Self {
        let mut rng = generator(seed);
        let mut value = || uniform(&mut rng, 0.2, 2.0) as f32;
        Self::new(size, |_| Rgb { r: value(), g: value(), b: value() })
    }

    pub fn light(&self) -> Light<'_> {
        let [width, height] = self.size;
        let map = EnvironmentMap::new(&self.texels, width, height, self.to_world, SCALE, &self.sums);
        Light::EnvironmentMap(map.expect("the lengths fit"))
    }

    /// Bilinear by weighting all texels by how far they are from the place, in columns and rows.
    fn radiance(&self, to_sky: DVec3) -> Colour {
        let [width, height] = self.size;
        let v = self.to_world.inverse() * to_sky;
        let (turn, down) = (v.x.atan2(-v.z) / (2.0 * PI), v.y.clamp(-1.0, 1.0).acos() / PI);
        let mut sum = Colour::ZERO;
        for j in 0..height {
            for i in 0..width {
                let turns = turn - (i as f64 + 0.5) / width as f64;
                let columns = (turns - turns.round()).abs() * width as f64;
                let rows = (down * (height - 1) as f64 - j as f64).abs();
                sum += self.texels[j * width + i].wide() * (1.0 - columns).max(0.0) * (1.0 - rows).max(0.0);
            }
        }
        sum * SCALE
    }
}

fn sky(light: Light, u: DVec2) -> (DVec3, f64) {
    match light.sample(u) {
        LightSample::Sky { to_light, pdf } => (to_light, pdf),
        other => panic!("{other:?} from an environment map"),
    }
}

proptest! {
    #[test]
    fn radiance_is_bilinear_in_longitude_and_latitude(to_sky in direction(), seed in 0..1000_u64) {
        let map = Map::random([5, 4], seed);
        let (found, expected) = (map.light().emission(-to_sky), map.radiance(to_sky));
        prop_assert!((found - expected).length() < 1e3 * ROUNDING * (1.0 + 4e2), "{found}, {expected}");
    }

    #[test]
    fn samples_are_as_dense_as_stated(u in unit_square(), seed in 0..1000_u64) {
        let map = Map::random([5, 4], seed);
        let (to_sky, pdf) = sky(map.light(), u);
        prop_assert!((to_sky.length() - 1.0).abs() < ROUNDING && pdf > 0.0);
        // At a border, rounding decides for one of two cells.
        let nearby = [-1e-9, 0.0, 1e-9].map(|h| sky(map.light(), (u + h).clamp(DVec2::ZERO, DVec2::splat(1.0 - 1e-9))));
        prop_assert!(nearby.iter().any(|(to_sky, _)| (map.light().direction_pdf(-*to_sky) / pdf - 1.0).abs() < 1e-9));
    }

    #[test]
    fn what_shines_is_sampled(to_sky in direction(), seed in 0..1000_u64) {
        let light = Map::random([5, 4], seed);
        let light = light.light();
        prop_assert!(luminance(light.emission(-to_sky)) == 0.0 || light.direction_pdf(-to_sky) > 0.0);
    }

    /// Off the borders of cells, at which it jumps.
    #[test]
    fn log_gradient_is_that_of_the_emission(u in unit_square(), seed in 0..1000_u64) {
        let map = Map::bright([5, 4], seed);
        let light = map.light();
        let (to_sky, _) = sky(light, u);
        let omega = -to_sky;
        let v = map.to_world.transpose() * to_sky;
        let column = v.x.atan2(-v.z) / (2.0 * PI) * 5.0 - 0.5;
        let row = v.y.acos() / PI * 3.0;
        let off_border = |x: f64| (x - x.round()).abs() > 0.02;
        prop_assume!(off_border(column) && off_border(row));
        let expected = gradient(|w| light.emission(DVec3::from_array(w).normalize()).to_array().map(f64::ln), omega.to_array());
        for (found, expected) in light.log_gradient(omega).expect("built in").into_iter().zip(expected) {
            let tangent = found - found.dot(omega) * omega;
            prop_assert!((tangent - DVec3::from_array(expected)).length() < 1e-5 * (1.0 + tangent.length()), "{tangent}, {expected:?}");
        }
    }
}

/// 2^18 samples in 12 by 8 parts of equal solid angle about an axis of the world, not the map's, against 1000 places each.
#[test]
fn samples_follow_their_density() {
    const SAMPLES: usize = 1 << 18;
    const PARTS: [usize; 2] = [12, 8];
    for seed in [1, 2, 3] {
        let map = Map::random([6, 5], seed);
        let light = map.light();
        let mut rng = generator(17 + seed);
        let part = |v: DVec3| {
            let turn = (v.y.atan2(v.x) / (2.0 * PI)).rem_euclid(1.0);
            let column = ((turn * PARTS[0] as f64) as usize).min(PARTS[0] - 1);
            column + PARTS[0] * (((0.5 * v.z + 0.5) * PARTS[1] as f64) as usize).min(PARTS[1] - 1)
        };
        let mut counts = vec![0; PARTS[0] * PARTS[1]];
        for _ in 0..SAMPLES {
            let u = DVec2::new(uniform(&mut rng, 0.0, 1.0), uniform(&mut rng, 0.0, 1.0));
            counts[part(sky(light, u).0)] += 1;
        }
        // By the midpoint rule, in steps small against a part.
        let steps = [1200, 800];
        let mut probabilities = vec![0.0; counts.len()];
        for row in 0..steps[1] {
            let z = -1.0 + 2.0 * (row as f64 + 0.5) / steps[1] as f64;
            for column in 0..steps[0] {
                let turn = 2.0 * PI * (column as f64 + 0.5) / steps[0] as f64;
                let v = DVec3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
                probabilities[part(v)] += light.direction_pdf(-v) * 4.0 * PI / (steps[0] * steps[1]) as f64;
            }
        }
        let total: f64 = probabilities.iter().sum();
        assert!((total - 1.0).abs() < 2e-3, "∫ pdf = {total}");
        probabilities.iter_mut().for_each(|p| *p /= total);
        let p = chi_square_p_value(&counts, &probabilities);
        println!("seed {seed}: ∫ pdf = {total:.6}, p = {p:.3}");
        assert!(p > 1e-4, "{p}");
    }
}

/// Bilinear in between, but the density follows the luminance of the corners: most light is sampled where most light is.
#[test]
fn samples_go_where_the_light_is() {
    let map =
        Map::new([16, 9], |i| if i == 4 * 16 + 3 { Rgb { r: 1e4, g: 1e4, b: 1e4 } } else { Rgb { r: 1.0, g: 1.0, b: 1.0 } });
    let light = map.light();
    let mut rng = generator(5);
    let values: Vec<f64> = (0..4096)
        .map(|_| {
            let (to_sky, pdf) = sky(light, DVec2::new(uniform(&mut rng, 0.0, 1.0), uniform(&mut rng, 0.0, 1.0)));
            luminance(light.emission(-to_sky)) / pdf
        })
        .collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt();
    // Uniform directions would have a deviation of some 12 means.
    assert!(deviation < 1.2 * mean, "{deviation} of {mean}");
}

#[test]
fn black_maps_are_never_sampled() {
    let map = Map::new([4, 3], |_| Rgb::default());
    let light = map.light();
    assert!(matches!(light.sample(DVec2::splat(0.5)), LightSample::Sky { pdf: 0.0, .. }));
    let mut rng = generator(1);
    for _ in 0..100 {
        let v = DVec3::from_array(random_direction(&mut rng));
        assert_eq!((light.emission(v), light.direction_pdf(v)), (Colour::ZERO, 0.0));
        assert_eq!(light.log_gradient(v), Some([DVec3::ZERO; 3]));
    }
}

#[test]
fn lengths_must_fit() {
    let map = Map::bright([4, 3], 1);
    let new = |texels, width, height, sums| EnvironmentMap::new(texels, width, height, DMat3::IDENTITY, Colour::ONE, sums);
    assert!(new(&map.texels, 4, 3, &map.sums).is_some());
    assert!(new(&map.texels[1..], 4, 3, &map.sums).is_none() && new(&map.texels, 4, 3, &map.sums[1..]).is_none());
    assert!(new(&[], 0, 2, &[0.0]).is_none() && new(&map.texels[..4], 4, 1, &[]).is_none());
}
