//! Values beyond all numbers, from the host's density and in its environment map: chains go on without them, and say how many.

use crate::chains::{Chains, Picture, Setup};
use crate::toy::scenes::{World, camera, edges_under_area_lights, environment_map, homogeneous, rectangle};
use crate::unbiased_shifts;
use volgrad::math::{Colour, DAffine3, DVec3};
use volgrad::medium::{Custom, Density, DensityField, Medium};
use volgrad::sampler::metropolis::{ChainStats, Techniques, bootstrap};
use volgrad::sampler::{Lengths, Stats};
use volgrad::scene::{Bsdf, Light};

const SETUP: Setup =
    Setup { lengths: Lengths { first: 2, last: 5 }, learn: 500, samples: 3000, chains: 12, large_step: 0.3, burn_in: 50 };
const MUTATIONS: u64 = 300;

/// A box of fog, or of what is in its place, over a floor.
fn room(medium: Medium<'static>) -> World {
    World::new(camera([0.0, 0.0, -3.0], 0.5, 4))
        .medium([-1.2, -1.1, -1.2], [1.2, 1.1, 1.2], medium)
        .surface(rectangle([-2.0, -1.2, -1.5], [0.0, 0.0, 3.2], [4.0, 0.0, 0.0]), Bsdf::Diffuse { albedo: Colour::splat(0.6) })
}

/// In slabs, what no density should be.
#[derive(Debug)]
struct Wild;

impl DensityField for Wild {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        let wild = [f64::NAN, f64::INFINITY, -3.0, f64::NEG_INFINITY];
        for (density, x) in densities.iter_mut().zip(points) {
            let slab = (x.x * 20.0).floor().rem_euclid(12.0) as usize;
            *density = wild.get(slab).copied().unwrap_or(1.0);
        }
    }

    fn gradients(&self, _: &[DVec3], gradients: &mut [DVec3]) {
        gradients.fill(DVec3::splat(f64::NAN));
    }
}

/// What 12 chains add: whole mutations, to sums that are not black and far from where cells end.
fn picture(world: &World, shift: Option<volgrad::shift::Options>) -> Picture {
    let chains = Chains::new(world, &SETUP, 1);
    assert!(chains.brightness > 0.0 && chains.brightness.is_finite() && chains.relative_error.is_finite());
    let picture = chains.film(shift, 1, MUTATIONS);
    let made = picture.chain_stats.large + picture.chain_stats.small;
    assert_eq!(made, MUTATIONS * chains.chains.len() as u64);
    assert!(picture.chain_stats.large_accepted > 0 && picture.chain_stats.small_accepted > 0);
    assert!(picture.cells.iter().all(|cell| cell.sums().iter().all(|sum| sum.unsigned_abs() < 1 << 120)));
    picture
}

#[test]
fn a_density_that_is_no_number_in_places() {
    let (low, high) = (DVec3::new(-1.2, -1.1, -1.2), DVec3::new(1.2, 1.1, 1.2));
    let to_world = DAffine3::from_translation(low) * DAffine3::from_scale(high - low);
    let wild = Density::Custom(Custom::new(&Wild, to_world, 0.05, 1.0).expect("few panels"));
    let medium = Medium { density: wild, ..homogeneous([1.0; 3], [0.9; 3], 0.3) };
    let world = room(medium).light(Light::Environment { radiance: Colour::ONE }, 1.0);
    for shift in [None].into_iter().chain(unbiased_shifts().map(Some)) {
        let picture = picture(&world, shift);
        assert!(picture.mean(1.0) > 0.0);
        assert_eq!(picture.dropped.get() + picture.chain_stats.dropped, 0, "{shift:?}: such values count as 0");
    }
}

/// Splats beyond what a film holds are counted, not added.
#[test]
fn an_environment_map_as_bright_as_numbers_go() {
    let [disk, _, _, tile, _] = unbiased_shifts();
    for texel in [1e6, 1e20, f32::MAX] {
        let map = environment_map(|i| if i == 13 { texel } else { 1.0 });
        let world = room(homogeneous([0.5; 3], [0.9; 3], 0.0)).light(map, 1.0);
        for shift in [None, Some(disk), Some(tile)] {
            assert_eq!(picture(&world, shift).dropped.get() > 0, texel > 1e9, "{shift:?}, {texel:e}");
        }
    }
}

/// Beside a sun whose light is no number.
fn under_an_infinite_sun() -> World {
    let mut world = edges_under_area_lights();
    for light in &mut world.lights {
        if let Light::Directional { irradiance, .. } = light {
            *irradiance = Colour::INFINITY;
        }
    }
    world
}

/// Paths from it are dropped, and counted; those of the other lights are not.
#[test]
fn paths_without_a_value_are_counted() {
    let world = under_an_infinite_sun();
    for shift in [None].into_iter().chain(unbiased_shifts().map(Some)) {
        let picture = picture(&world, shift);
        assert!(picture.chain_stats.dropped > 20 && picture.dropped.get() == 0 && picture.mean(1.0) > 0.0, "{shift:?}");
    }
}

/// The samples before the chains too, and mutations before the first that counts.
#[test]
fn samples_and_burn_in_without_a_value_are_counted() {
    let world = under_an_infinite_sun();
    let (mut stats, mut weights) = (ChainStats::default(), vec![0.0; 500]);
    let (scene, alike) = (world.scene(), Techniques::alike(SETUP.lengths));
    bootstrap(&scene, &world.geometry, 1, &alike, 0, &mut weights, &mut Stats::default(), &mut stats).expect("never stops");
    assert!(weights.iter().all(|weight| weight.is_finite() && *weight >= 0.0));
    assert!(stats.samples == 500 && stats.dropped > 5 && stats.dropped < 500 && stats.large == 0);

    let mut chains = Chains::new(&world, &SETUP, 1);
    chains.options.burn_in = 500;
    let (sampler, mut stats) = (chains.sampler(&scene, None, 1), ChainStats::default());
    for mut chain in chains.chains.clone() {
        sampler.burn_in(&mut chain.state, &mut chain.numbers, &mut Stats::default(), &mut stats).expect("never stops");
    }
    assert!(stats.burn_in == 500 * chains.chains.len() as u64 && stats.dropped > 5 && stats.large + stats.small == 0);
}
