//! Density grids: samples at cell centres, clamped in the outermost half cells, 0 outside the box; constant ones are homogeneous;
//! bricks only save time, and sparse grids only memory.

mod common;
mod reference;

use common::{
    host::*,
    media::{UNIT_CUBE, heterogeneous, homogeneous, large_grid},
};
use rand_pcg::Pcg64;
use reference::{grid::Grid, random::*, scenes::sheared, segments::Edge, vector::*, world::*};
use volgrad::math::DVec3;
use volgrad::medium::{self, Collision, Flight, Segment, Stretch, sample_distance};

/// Both sides compute the same in another order.
const ROUNDING: f64 = 1e-12;
/// Segment ends and normals are in single precision.
const SINGLE: f64 = 1e-6;

const CHROMATIC: Rgb = [0.4, 0.9, 1.7];

fn largest_difference(a: [[DVec3; 3]; 2], b: [[DVec3; 3]; 2]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
}

/// A random edge that grazes no face, where a normal's rounding would be magnified.
fn edge_through_faces(rng: &mut Pcg64, world: &World) -> (Edge, Vec<Segment>) {
    loop {
        let [a, b] = [0; 2].map(|_| random_vector(rng, -1.3, 1.3));
        let edge = Edge::between(a, b);
        let segments = segments(world, &edge);
        let faces = &segments[..segments.len() - 1];
        if faces.iter().all(|face| face.normal.wide().dot(vec(edge.direction)).abs() > 0.2) {
            return (edge, segments);
        }
    }
}

/// A grid of constant density in a box, and a homogeneous medium with the same faces.
#[test]
fn constant_grid_is_a_homogeneous_box() {
    let samples = vec![1.0; 9 * 3 * 4];
    let grid = heterogeneous(CHROMATIC, Grid { resolution: [9, 3, 4], samples, to_world: sheared() });
    let mut world = World::filled_with(homogeneous(CHROMATIC));
    world.regions = vec![Region::image_of_unit_cube(&sheared(), 0)];
    let mut rng = generator(2);
    for bricks in [Bricks::Built, Bricks::Left] {
        let hosts = [HostMedium::new(&grid, bricks), HostMedium::new(&world.media[0], bricks)];
        let [in_grid, in_box] = hosts.each_ref().map(|host| [host.view()]);
        for n in 0..100 {
            let (edge, segments) = edge_through_faces(&mut rng, &world);
            let (ours, expected) = (line(&edge, &in_grid, &ONE_SEGMENT), line(&edge, &in_box, &segments));
            let (m, e) = (medium::moments(&ours), medium::moments(&expected));
            assert!((m.optical_depth - e.optical_depth).length() < SINGLE, "τ of edge {n}");
            assert!(largest_difference(gradients(&m, &ours), gradients(&e, &expected)) < SINGLE, "∇τ of edge {n}");
            let u = uniform(&mut rng, 0.0, 1.0);
            match (sample_distance(&ours, u), sample_distance(&expected, u)) {
                (Flight::Collision(Collision { t, pdf, .. }), Flight::Collision(Collision { t: t_box, pdf: pdf_box, .. })) => {
                    assert!((t - t_box).abs() < SINGLE && (pdf - pdf_box).abs() < SINGLE, "distance on edge {n}");
                }
                (Flight::Passed { .. }, Flight::Passed { .. }) => {}
                other => panic!("edge {n}: {other:?}"),
            }
        }
    }
}

/// Two cells along x, 1 and 3: clamped in the outer halves, linear between, 0 outside.
#[test]
fn samples_are_at_cell_centres_and_clamp() {
    let two = heterogeneous([1.0; 3], Grid { resolution: [2, 1, 1], samples: vec![1.0, 3.0], to_world: UNIT_CUBE });
    let host = HostMedium::new(&two, Bricks::Built);
    let density = host.view().density;
    let at = |x: f64| density.at(DVec3::new(x, 0.3, 0.8));
    for (x, value) in [(-0.01, 0.0), (0.0, 1.0), (0.25, 1.0), (0.5, 2.0), (0.75, 3.0), (0.9, 3.0), (1.0, 3.0), (1.01, 0.0)] {
        assert!((at(x) - value).abs() < ROUNDING, "at {x}: {}", at(x));
    }
    for (x, slope) in [(-0.1, 0.0), (0.1, 0.0), (0.3, 4.0), (0.7, 4.0), (0.9, 0.0), (1.1, 0.0)] {
        let gradient = density.gradient(DVec3::new(x, 0.3, 0.8));
        assert!((gradient - slope * DVec3::X).length() < ROUNDING, "at {x}: {gradient}");
    }
    let along_x = Stretch { origin: DVec3::new(-1.0, 0.3, 0.8), direction: DVec3::X, start: 0.0, end: 5.0 };
    let through = density.moments(&along_x);
    assert!((through.integral - 2.0).abs() < ROUNDING, "1/4 + 1 + 3/4");
    // The rise from 1 to 3, and the jumps from 0 to 1 at t = 1 and from 3 to 0 at t = 2, as distributions.
    assert!(through.gradient.length() < ROUNDING, "{through:?}");
    assert!((through.first_moment - (2.0 * 1.5 + 1.0 - 3.0 * 2.0) * DVec3::X).length() < ROUNDING, "{through:?}");
}

/// Layers along x: random, empty, random, constant, random; so that walks go into and out of bricks that are crossed whole.
fn layered_grid(rng: &mut Pcg64, to_world: Affine) -> Grid {
    let resolution = [96, 12, 17];
    let sample = |rng: &mut Pcg64, x: usize| match 5 * x / resolution[0] {
        1 => 0.0,
        3 => 0.7,
        _ => uniform(rng, 0.2, 2.0),
    };
    let count = resolution.iter().product();
    let samples = (0..count).map(|i| sample(rng, i % resolution[0])).collect();
    Grid { resolution, samples, to_world }
}

/// Bricks answer for most points, interpolation for the rest: both say the same as the density.
#[test]
fn where_a_density_is_positive() {
    let mut rng = generator(4);
    for grid in [large_grid(&mut rng, UNIT_CUBE), layered_grid(&mut rng, sheared())] {
        let medium = heterogeneous(CHROMATIC, grid);
        for bricks in [Bricks::Built, Bricks::Left] {
            let host = HostMedium::new(&medium, bricks);
            let density = host.view().density;
            let mut counts = [0; 2];
            for _ in 0..20_000 {
                let x = vec(random_vector(&mut rng, -0.3, 1.3));
                let positive = density.at(x) > 0.0;
                assert_eq!(density.is_positive(x), positive, "{x}");
                counts[usize::from(positive)] += 1;
            }
            assert!(counts.iter().all(|count| *count > 500), "{counts:?}");
        }
    }
}

/// Where it is said to be positive all around a point, it is at points around it. Without bricks nothing is said.
#[test]
fn where_a_density_is_surely_positive() {
    let mut rng = generator(5);
    for grid in [large_grid(&mut rng, UNIT_CUBE), layered_grid(&mut rng, sheared())] {
        let medium = heterogeneous(CHROMATIC, grid);
        let (host, bare) = (HostMedium::new(&medium, Bricks::Built), HostMedium::new(&medium, Bricks::Left));
        let mut count = 0;
        for _ in 0..20_000 {
            let (x, reach) = (vec(random_vector(&mut rng, -0.3, 1.3)), vec(random_vector(&mut rng, 0.0, 0.1)));
            assert!(!bare.view().density.is_surely_positive_around(x, reach));
            if host.view().density.is_surely_positive_around(x, reach) {
                let y = x + reach * vec(random_vector(&mut rng, -1.0, 1.0));
                assert!(host.view().density.at(y) > 0.0, "{y}, {reach} from {x} at most");
                count += 1;
            }
        }
        assert!(count > 500, "{count}");
    }
}

/// Half of the bricks are empty or constant, and crossed whole.
#[test]
fn bricks_change_nothing() {
    let mut rng = generator(3);
    let mut grids = Vec::new();
    for to_world in [UNIT_CUBE, sheared()] {
        grids.extend([large_grid(&mut rng, to_world), layered_grid(&mut rng, to_world)]);
    }
    for grid in grids {
        let medium = heterogeneous(CHROMATIC, grid);
        let hosts = [Bricks::Built, Bricks::Left].map(|bricks| HostMedium::new(&medium, bricks));
        let [with, without] = hosts.each_ref().map(|host| [host.view()]);
        for n in 0..500 {
            let [a, b] = [0; 2].map(|_| random_vector(&mut rng, -1.0, 1.5));
            let edge = Edge::between(a, b);
            let (fast, slow) = (line(&edge, &with, &ONE_SEGMENT), line(&edge, &without, &ONE_SEGMENT));
            let (f, s) = (medium::moments(&fast), medium::moments(&slow));
            assert!((f.optical_depth - s.optical_depth).length() < ROUNDING, "τ of edge {n}");
            // Relative to the slope of the density, 40 samples per unit.
            assert!(largest_difference(gradients(&f, &fast), gradients(&s, &slow)) < 100.0 * ROUNDING, "∇τ of edge {n}");
            let u = uniform(&mut rng, 0.0, 1.0);
            match (sample_distance(&fast, u), sample_distance(&slow, u)) {
                (Flight::Collision(Collision { t, .. }), Flight::Collision(Collision { t: slow_t, .. })) => {
                    assert!((t - slow_t).abs() < 100.0 * ROUNDING, "distance on edge {n}");
                }
                (Flight::Passed { .. }, Flight::Passed { .. }) => {}
                other => panic!("edge {n}: {other:?}"),
            }
        }
    }
}

/// Rounding makes nothing less than none of a density on lines in the layer where it ends.
#[test]
fn integrals_are_not_negative() {
    let mut rng = generator(8);
    let samples = (0..4 * 4 * 4).map(|i| if i / 16 < 2 { 0.0 } else { uniform(&mut rng, 100.0, 1000.0) }).collect();
    let to_world = sheared();
    let medium = heterogeneous(CHROMATIC, Grid { resolution: [4; 3], samples, to_world });
    for bricks in [Bricks::Built, Bricks::Left, Bricks::Sparse] {
        let host = HostMedium::new(&medium, bricks);
        let mut sum = 0.0;
        for n in 0..5000 {
            let [a, b] = [0; 2].map(|_| {
                let [x, y, _] = random_vector(&mut rng, 0.0, 1.0);
                vec(to_world.apply([x, y, 1.5 / 4.0]))
            });
            let stretch = Stretch { origin: a, direction: (b - a).normalize(), start: 0.0, end: (b - a).length() };
            let density = host.view().density;
            let integrals = [density.integral(&stretch), density.moments(&stretch).integral];
            assert!(integrals.iter().all(|integral| *integral >= 0.0), "line {n}: {integrals:?}");
            sum += integrals[0];
        }
        assert!(sum < 1e-9, "{sum}");
    }
}

/// A grid that is empty beyond its low quarter, in a box that cuts bricks.
fn small_cloud_in_a_large_box(rng: &mut Pcg64) -> Grid {
    let resolution = [61, 45, 50];
    let full = |i: usize| i % 61 < 16 && i / 61 % 45 < 13 && i / 61 / 45 < 11;
    let samples = (0..61 * 45 * 50).map(|i| if full(i) { uniform(rng, 0.0, 90.0) } else { 0.0 }).collect();
    Grid { resolution, samples, to_world: UNIT_CUBE }
}

/// Sparse or dense, it is the same walk over the same cells: all answers have the same bits.
#[test]
fn sparse_grids_are_the_same() {
    let mut rng = generator(6);
    let mut grids = vec![small_cloud_in_a_large_box(&mut rng)];
    for to_world in [UNIT_CUBE, sheared()] {
        grids.extend([large_grid(&mut rng, to_world), layered_grid(&mut rng, to_world)]);
    }
    for (i, grid) in grids.into_iter().enumerate() {
        let medium = heterogeneous(CHROMATIC, grid);
        let (dense, sparse) = (HostMedium::new(&medium, Bricks::Built), HostMedium::new(&medium, Bricks::Sparse));
        let (dense, sparse) = (dense.view().density, sparse.view().density);
        let mut hits = 0;
        for n in 0..1000 {
            let [a, b] = [0; 2].map(|_| vec(random_vector(&mut rng, -0.6, 1.4)));
            // Every third through samples, walls and corners of cells.
            let a = if n % 3 == 0 { (a * 16.0).round() / 16.0 } else { a };
            let direction = if n % 5 == 0 { DVec3::AXES[n % 3] } else { (b - a).normalize() };
            let stretch = Stretch { origin: a, direction, start: 0.0, end: (b - a).length() };
            assert_eq!(dense.at(a).to_bits(), sparse.at(a).to_bits(), "grid {i}, {a}");
            assert_eq!(dense.is_positive(a), sparse.is_positive(a), "grid {i}, {a}");
            assert_eq!(dense.gradient(a), sparse.gradient(a), "grid {i}, {a}");
            let moments = dense.moments(&stretch);
            assert_eq!(moments, sparse.moments(&stretch), "grid {i}, {stretch:?}");
            let target = uniform(&mut rng, 0.0, 1.0) * moments.integral;
            assert_eq!(dense.invert(&stretch, target), sparse.invert(&stretch, target), "grid {i}, {stretch:?}");
            let extents =
                [dense, sparse].map(|d| d.extent(&stretch).map(|e| [e.start, e.end, e.at_start, e.at_end, e.min, e.max]));
            assert_eq!(extents[0], extents[1], "grid {i}, {stretch:?}");
            hits += usize::from(moments.integral > 0.0);
        }
        assert!(hits > 20, "grid {i}: {hits}");
    }
}
