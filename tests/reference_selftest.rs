//! The reference implementation checked against finite differences, marching and formulas written out by hand. What the
//! library is compared with elsewhere is thereby known to be right, and to how many digits.

mod reference;

use reference::{
    contribution::contribution,
    grid::Grid,
    medium::{Density, Medium},
    microfacets::{Microfacets, distribution, reflectance},
    optical_depth::optical_depth_in_medium,
    path::{Path, Vertex},
    phase::Phase,
    random::generator,
    random_paths::random_path,
    scenes::*,
    segments::Edge,
    selftest::*,
    selftest_values::*,
    vector::*,
    world::{Region, World},
};
use std::f64::consts::PI;

/// Relative to Σ|factor gradients|.
const GRADIENT_TOLERANCE: f64 = 1e-8;
/// A missing term must be seen by far more than that.
const NOTICED: f64 = 1e-3;

fn assert_below(worst: &Worst, tolerance: f64) {
    println!("worst of {}: {:.1e} at {}", worst.count, worst.error, worst.of);
    assert!(worst.error <= tolerance, "{worst:?} > {tolerance:e}");
}

fn assert_noticed(worst: &Worst) {
    println!("worst of {}: {:.1e} at {}", worst.count, worst.error, worst.of);
    assert!(worst.error > NOTICED, "{worst:?}: this test could not fail");
}

fn sheared_grid_medium(sigma_t: Rgb) -> Medium {
    let grid = random_grid(&mut generator(5), [4, 3, 5], sheared());
    Medium { sigma_t, albedo: [0.9; 3], phase: Phase::Isotropic, density: Density::Grid(grid) }
}

#[test]
fn gradients_agree_with_differences() {
    assert_below(&worst_gradient(1), GRADIENT_TOLERANCE);
}

#[test]
fn gradients_of_rigid_runs_agree_with_differences() {
    assert_below(&worst_run_gradient(2), GRADIENT_TOLERANCE);
}

#[test]
fn every_pair_of_neighbour_kinds_is_tested() {
    let kinds = neighbour_kinds(1);
    for p in ["C", "M", "D"] {
        for n in ["M", "D", "A", "P", "E", "S"] {
            assert!(kinds.contains(&format!("{p}{n}")), "{p} before, {n} after a medium vertex");
        }
    }
}

/// The comparison with differences can fail: it sees a face term that is left out.
#[test]
fn missing_face_terms_are_noticed() {
    assert_noticed(&error_after(3, |scene| scene.has_faces, drop_face_terms));
    assert_below(&error_after(3, |scene| !scene.has_faces, drop_face_terms), GRADIENT_TOLERANCE);
}

/// It sees the near plane: from a camera inside of the medium, that is the only face on the first edge.
#[test]
fn missing_near_plane_term_is_noticed() {
    let inside = |scene: &Scene| scene.name.starts_with("near plane");
    assert_noticed(&error_after(3, inside, |world, path, i, formula| {
        if i == 1 {
            let next = formula.transmittance_next;
            drop_face_terms(world, path, i, formula);
            formula.transmittance_next = next;
        }
    }));
}

/// It sees that the transmittance towards a light at infinity changes, too.
#[test]
fn missing_environment_term_is_noticed() {
    assert_noticed(&error_after(
        3,
        |_| true,
        |_, path, i, formula| {
            if path.vertices[i + 1].is_at_infinity() {
                formula.transmittance_next = [ZERO; 3];
            }
        },
    ));
}

/// It sees that ∇σ_s/σ_s is left out, as it is in [Lu20 (29)], and only where the density varies.
#[test]
fn missing_scattering_gradient_is_noticed() {
    assert_noticed(&error_after(3, |scene| scene.has_grid, |_, _, _, formula| formula.scattering = ZERO));
    assert_below(&error_after(3, |scene| !scene.has_grid, |_, _, _, formula| formula.scattering = ZERO), GRADIENT_TOLERANCE);
}

/// And every other factor.
#[test]
fn any_missing_factor_is_noticed() {
    let all = |_: &Scene| true;
    assert_noticed(&error_after(4, all, |_, _, _, f| f.transmittance_prev = [ZERO; 3]));
    assert_noticed(&error_after(4, all, |_, _, _, f| f.transmittance_next = [ZERO; 3]));
    assert_noticed(&error_after(4, all, |_, _, _, f| f.geometry_prev = ZERO));
    assert_noticed(&error_after(4, all, |_, _, _, f| f.geometry_next = ZERO));
    assert_noticed(&error_after(4, all, |_, _, _, f| f.importance = ZERO));
    assert_noticed(&error_after(4, all, |_, _, _, f| f.profile_prev = [ZERO; 3]));
    assert_noticed(&error_after(4, all, |_, _, _, f| f.phase_apex = ZERO));
    assert_noticed(&error_after(4, all, |_, _, _, f| f.profile_next = [ZERO; 3]));
}

#[test]
fn optical_depth_agrees_with_marching() {
    // A face may be off by half a step of edges up to 5 long, at σ_t up to 3.5.
    assert_below(&worst_optical_depth(6, 200_000), 1e-4);
}

#[test]
fn optical_depth_is_additive() {
    let mut rng = generator(7);
    for scene in scenes(&mut rng, Phase::Isotropic) {
        let [a, b] = [[-1.3, -0.4, 0.6], [1.2, 0.9, -0.8]];
        assert!(additivity_error(&scene.world, a, b, 1.1) < 1e-14, "{}", scene.name);
    }
}

#[test]
fn optical_depth_gradients_at_both_ends_agree_with_differences() {
    assert_below(&worst_optical_depth_gradient(&sheared_grid_medium([0.5, 1.0, 2.0]), 8), GRADIENT_TOLERANCE);
}

#[test]
fn constant_grid_is_homogeneous() {
    let to_world = Affine::onto_box([-2.0; 3], [2.0; 3]);
    let samples = vec![1.0; 2 * 3 * 4];
    let constant = Density::Grid(Grid { resolution: [2, 3, 4], samples, to_world });
    let medium = Medium { density: constant, ..sheared_grid_medium([0.5, 1.0, 2.0]) };
    let [a, b] = [[-1.9, 0.3, 1.2], [1.4, -1.7, -0.6]];
    let tau = optical_depth_in_medium(&medium, a, b);
    assert!(distance(tau, scale(distance(a, b), medium.sigma_t)) < 1e-14);
    assert!(length(medium.log_sigma_s_gradient(a)) < 1e-14);
}

#[test]
fn phase_functions_are_normalised_and_forward_is_minus_one() {
    for phase in PHASES {
        assert!((phase_integral(phase) - 1.0).abs() < 1e-6, "{phase:?}");
    }
    let forward = Phase::HenyeyGreenstein { g: 0.9 };
    assert!(forward.value(-1.0) > 1000.0 * forward.value(1.0));
    assert!(forward.log_derivative(0.0) < 0.0);
}

/// ∫ D cosθ dω = 1, f_r is reciprocal, f_t is up to the squared index, and Fresnel's equations have their known values.
#[test]
fn microfacets_are_normalised_and_reciprocal() {
    let steps = 100_000;
    for alpha in [0.1, 0.3, 0.7] {
        let cosine = |i: usize| (i as f64 + 0.5) / steps as f64;
        let integral: f64 = (0..steps).map(|i| 2.0 * PI * cosine(i) * distribution(alpha, cosine(i)) / steps as f64).sum();
        assert!((integral - 1.0).abs() < 1e-4, "{integral}");
    }
    let [n, a, b] = [[0.0, 0.0, 1.0], normalize([0.3, -0.2, 0.9]), normalize([-0.5, 0.1, 0.6])];
    let below = normalize([-0.25, 0.1, -0.7]);
    let copper = Microfacets::Conductor { eta: [0.2, 0.9, 1.1], k: [3.9, 2.5, 2.4] };
    let glass = Microfacets::Dielectric { eta: 1.5 };
    for microfacets in [copper, glass] {
        let [f, g] = [microfacets.value(0.3, n, a, b), microfacets.value(0.3, n, b, a)];
        assert!(distance(f, g) < 1e-12 && f[0] > 0.01, "{f:?}, {g:?}");
    }
    let [f, g] = [glass.value(0.3, n, a, below), glass.value(0.3, n, below, a)];
    assert!(distance(scale(1.5 * 1.5, f), g) < 1e-12 && f[0] > 0.01, "{f:?}, {g:?}");
    assert!((reflectance((1.5, 0.0), 1.0) - 0.04).abs() < 1e-12);
    assert!(reflectance((1.5, 0.0), (1.5_f64).atan().cos()) < 0.5 * 0.15, "Brewster's angle");
    assert!((reflectance((1.0 / 1.5, 0.0), 0.5) - 1.0).abs() < 1e-12, "total reflection");
    // ((η − 1)² + k²)/((η + 1)² + k²)
    assert!((reflectance((0.2, 3.9), 1.0) - (0.64 + 15.21) / (1.44 + 15.21)).abs() < 1e-12);
}

#[test]
fn single_scattering_is_as_written_by_hand() {
    let phase = Phase::HenyeyGreenstein { g: 0.5 };
    let medium = Medium { sigma_t: [0.3, 0.6, 0.9], albedo: [0.9, 0.5, 0.7], phase, density: Density::Constant };
    let world = World::filled_with(medium);
    let ([x, light], intensity) = ([[0.3, -0.2, 1.5], [-0.8, 0.4, 2.5]], [3.0, 2.0, 1.0]);
    let f = contribution(&world, &single_scattering_path(x, light, intensity)).total();
    let by_hand = single_scattering_by_hand(&world, x, light, intensity);
    assert!(distance(f, by_hand) < 1e-14 * length(f));
}

#[test]
fn distances_invert_the_cdf_and_follow_the_pdf() {
    let [round_trip, density] = worst_distance(9);
    assert_below(&round_trip, 1e-14);
    assert_below(&density, GRADIENT_TOLERANCE);
}

/// A box from z = 1 to 3 with a second one from z = 2 on, seen at 60 degrees from a near plane at depth 1.5.
#[test]
fn segments_are_those_of_the_regions() {
    let medium = sheared_grid_medium([1.0; 3]);
    let mut world = World::filled_with(medium.clone());
    world.camera.near = 1.5;
    world.media.push(medium);
    world.regions = vec![
        Region::axis_aligned([-9.0, -9.0, 1.0], [9.0, 9.0, 2.0], 0),
        Region::axis_aligned([-9.0, -9.0, 2.0], [9.0, 9.0, 3.0], 1),
    ];
    let target = [4.0 * 3.0_f64.sqrt(), 0.0, 4.0];
    let segments = world.segments(&Edge::from_camera(&world.camera, target));
    let ends: Vec<f64> = segments.iter().map(|segment| segment.end).collect();
    let media: Vec<_> = segments.iter().map(|segment| segment.medium).collect();
    assert_eq!(media, [None, Some(0), Some(1), None]);
    // cos 60° = 1/2 doubles every depth.
    for (end, expected) in ends.iter().zip([3.0, 4.0, 6.0, 8.0]) {
        assert!((end - expected).abs() < 1e-12, "{ends:?}");
    }
    assert_eq!(segments[0].face_normal, Some(world.camera.forward));
    assert!(segments[3].face_normal.is_none());

    let up = world.segments(&Edge::to_infinity([0.0, 0.0, 2.5], [0.0, 0.0, 1.0]));
    assert_eq!(up.len(), 2);
    assert_eq!((up[0].end, up[0].medium), (0.5, Some(1)));
    assert_eq!((up[1].end, up[1].medium), (f64::INFINITY, None));
}

#[test]
fn contribution_is_zero_behind_surfaces_lights_and_before_the_near_plane() {
    let mut rng = generator(10);
    let world = scenes(&mut rng, Phase::Isotropic).swap_remove(1).world;
    let path = random_path(&mut rng, &world, "CMDMA");
    let f = |world: &World, path: &Path| contribution(world, path).total();
    assert!(f(&world, &path).iter().all(|&c| c > 0.0));

    for turned in [2, 4] {
        let mut path = path.clone();
        match &mut path.vertices[turned] {
            Vertex::Diffuse { normal, .. } | Vertex::AreaLight { normal, .. } => *normal = scale(-1.0, *normal),
            _ => unreachable!(),
        }
        assert_eq!(f(&world, &path), ZERO);
    }
    let mut behind = world.clone();
    behind.camera.near = 10.0;
    assert_eq!(f(&behind, &path), ZERO);
}
