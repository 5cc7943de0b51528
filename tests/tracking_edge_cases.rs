//! Regular tracking where it is easy to get wrong: lines in the walls between cells or past the box, lines of almost no length,
//! lines that never end, empty media, and numbers that are none.

mod common;
mod reference;

use common::{
    host::*,
    media::{UNIT_CUBE, heterogeneous, homogeneous},
};
use proptest::prelude::*;
use reference::{
    grid::Grid,
    medium::Medium as ReferenceMedium,
    optical_depth::optical_depth_in_medium,
    optical_depth_gradient::optical_depth_gradients_in_medium,
    random::{generator, random_vector, uniform},
    scenes::{random_grid, sheared},
    segments::Edge,
    vector::*,
};
use volgrad::math::{Colour, DAffine3, DMat3, DVec3};
use volgrad::medium::{
    self, Collision, Density, Flight, Inversion, Line, Medium, Moments, Stretch, distance_number, sample_distance,
};

/// Both sides compute the same in another order.
const ROUNDING: f64 = 1e-12;
/// A gradient's change over the distance of 1e-9 at which a side of a wall is looked at.
const SIDE: f64 = 1e-6;

const CHROMATIC: Rgb = [0.4, 0.9, 1.7];

/// 4³ samples in the unit cube: walls between cells at odd multiples of 1/8, exactly.
fn eighths() -> ReferenceMedium {
    heterogeneous([1.0; 3], random_grid(&mut generator(1), [4; 3], UNIT_CUBE))
}

fn stretch(origin: Vec3, direction: Vec3, end: f64) -> Stretch {
    Stretch { origin: vec(origin), direction: vec(direction), start: 0.0, end }
}

/// The directions along axes and diagonals: each component −1, 0 or 1, not all 0.
fn lattice_direction() -> impl Strategy<Value = [i32; 3]> {
    const ZEROS: i32 = 13;
    let code = (0..26_i32).prop_map(|n| if n < ZEROS { n } else { n + 1 });
    code.prop_map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1])
}

proptest! {
    /// Lines from multiples of 1/8: through corners, along edges and inside walls of cells.
    #[test]
    fn lines_in_walls_and_through_corners(
        eighths_of_origin in prop::array::uniform3(-4..12_i32),
        step in lattice_direction(),
        length in 0.1..3.0_f64,
    ) {
        let origin = [0, 1, 2].map(|axis| {
            // A line inside a face of the box has no side: rather the wall or the outside next to it.
            let in_face = step[axis] == 0 && [0, 8].contains(&eighths_of_origin[axis]);
            f64::from(eighths_of_origin[axis] + i32::from(in_face)) / 8.0
        });
        let direction = normalize(step.map(f64::from));
        let medium = eighths();
        let end = add(origin, scale(length, direction));
        let [tau, ..] = optical_depth_in_medium(&medium, origin, end);
        for bricks in [Bricks::Built, Bricks::Left] {
            let host = HostMedium::new(&medium, bricks);
            let density = host.view().density;
            let stretch = stretch(origin, direction, length);
            prop_assert!((density.integral(&stretch) - tau).abs() < ROUNDING, "{} for {tau}", density.integral(&stretch));
            if let Inversion::At(t) = density.invert(&stretch, 0.5 * tau) {
                let half = density.integral(&Stretch { end: t, ..stretch });
                prop_assert!((half - 0.5 * tau).abs() < ROUNDING, "{half} for half of {tau}");
            }
        }
    }
}

/// In a wall the density has two gradients; what comes out lies between those of the two sides.
#[test]
fn gradients_inside_a_wall_lie_between_its_sides() {
    let medium = eighths();
    let host = HostMedium::new(&medium, Bricks::Built);
    let media = [host.view()];
    let along = |x: f64| [[x, 0.4, 0.1], [x, 0.4, 0.9]];
    for wall in [0.125, 0.375, 0.625, 0.875] {
        let [a, b] = along(wall);
        let line = line(&Edge::between(a, b), &media, &ONE_SEGMENT);
        let ours = gradients(&medium::moments(&line), &line);
        let sides = [-1e-9, 1e-9].map(|side| {
            let [a, b] = along(wall + side);
            optical_depth_gradients_in_medium(&medium, a, b)
        });
        for end in 0..2 {
            let [low, high] = sides.map(|side| side[end][0][0]);
            let (least, most) = (low.min(high) - SIDE, low.max(high) + SIDE);
            assert!((least..=most).contains(&ours[end][0].x), "wall {wall}: {} in {least}..{most}", ours[end][0].x);
        }
    }
}

/// Past the box, touching an edge or a corner of it, or inside one of its faces.
#[test]
fn lines_that_miss_or_graze_the_box() {
    let medium = eighths();
    let host = HostMedium::new(&medium, Bricks::Built);
    let density = host.view().density;
    let missing = [
        stretch([-1.0, 1.5, 0.5], [1.0, 0.0, 0.0], 9.0),
        stretch([-1.0, 0.5, 0.5], [-1.0, 0.0, 0.0], 9.0),
        stretch([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], 0.5),
        stretch([-1.0, 0.5, 0.5], normalize([1.0, 2.0, 0.0]), f64::INFINITY),
    ];
    for stretch in missing {
        assert_eq!(density.moments(&stretch), Moments::default(), "{stretch:?}");
        assert_eq!(density.invert(&stretch, 0.1), Inversion::Beyond(0.0), "{stretch:?}");
    }
    let touching =
        [stretch([-1.0, 1.0, 0.5], normalize([1.0, -1.0, 0.0]), 9.0), stretch([-1.0, 0.5, 0.5], [1.0, 0.0, 0.0], 1.0)];
    for stretch in touching {
        assert!(density.integral(&stretch).abs() < ROUNDING, "{stretch:?}");
        assert!(density.moments(&stretch).gradient.is_finite(), "{stretch:?}");
    }
    for x in [0.0, 1.0] {
        let along_z = |x: f64| density.moments(&stretch([x, 0.4, -1.0], [0.0, 0.0, 1.0], 9.0));
        let in_face = along_z(x);
        // In the outermost half cell the density is that at the face.
        let just_inside = 0.01 + 0.98 * x;
        let [inside, ..] = optical_depth_in_medium(&medium, [just_inside, 0.4, -1.0], [just_inside, 0.4, 8.0]);
        assert!((along_z(just_inside).integral - inside).abs() < ROUNDING, "{inside} beside the face");
        assert!(in_face.integral == 0.0 || (in_face.integral - inside).abs() < ROUNDING, "{in_face:?}, {inside}");
        assert!(in_face.gradient.is_finite() && in_face.first_moment.is_finite(), "{in_face:?}");
    }
}

#[test]
fn lines_of_almost_no_length() {
    let host = HostMedium::new(&eighths(), Bricks::Built);
    let media = [host.view()];
    for direction in [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], normalize([-1.0, 2.0, 0.5])] {
        // In a cell, in a wall, in a corner of cells.
        for origin in [[0.3, 0.4, 0.2], [0.375, 0.4, 0.2], [0.375, 0.625, 0.125]] {
            let none = stretch(origin, direction, 0.0);
            assert_eq!(media[0].density.moments(&none), Moments::default());
            assert_eq!(media[0].density.integral(&none), 0.0);

            let tiny = Edge { length: 1e-30, ..Edge::to_infinity(origin, direction) };
            let line = line(&tiny, &media, &ONE_SEGMENT);
            let sigma = media[0].sigma_t(vec(origin)).x;
            let [near, far] = gradients(&medium::moments(&line), &line);
            assert!((far[0] - sigma * vec(direction)).length() < ROUNDING, "{far:?}");
            assert!((near[0] + sigma * vec(direction)).length() < ROUNDING, "{near:?}");
            assert!((distance_number(&line) / 1e-30 - sigma).abs() < ROUNDING);
            assert!(matches!(sample_distance(&line, 0.5), Flight::Passed { probability: 1.0, .. }));
        }
    }
}

/// Where no density is, every number passes.
#[test]
fn nothing_collides_in_empty_media() {
    let samples = vec![0.0; 9 * 10 * 3];
    let empty = heterogeneous(CHROMATIC, Grid { resolution: [9, 10, 3], samples, to_world: sheared() });
    for bricks in [Bricks::Built, Bricks::Left] {
        let host = HostMedium::new(&empty, bricks);
        let media = [host.view()];
        let line = line(&Edge::between([-1.0; 3], [1.0, 1.1, 1.2]), &media, &ONE_SEGMENT);
        assert_eq!(medium::moments(&line).optical_depth, Colour::ZERO);
        assert_eq!(distance_number(&line), 0.0);
        for u in [1e-300, 0.5, 1.0 - f64::EPSILON] {
            assert!(matches!(sample_distance(&line, u), Flight::Passed { probability: 1.0, .. }));
        }
    }
}

fn endless<'a>(media: &'a [Medium<'a>]) -> Line<'a> {
    line(&Edge::to_infinity(ZERO, [0.0, 0.6, 0.8]), media, &ONE_SEGMENT)
}

/// To infinity through a homogeneous medium, some of whose channels may have no extinction.
#[test]
fn homogeneous_media_without_end() {
    for (sigma_t, escape) in [(CHROMATIC, 0.0), ([1.0; 3], 0.0), ([0.0, 0.0, 1.0], 2.0 / 3.0), (ZERO, 1.0)] {
        let host = HostMedium::new(&homogeneous(sigma_t), Bricks::Left);
        let media = [host.view()];
        let line = endless(&media);
        assert!(!medium::optical_depth(&line).is_nan());
        for u in [1e-9, 0.2, 0.5, 0.9, 1.0 - 1e-9] {
            match sample_distance(&line, u) {
                Flight::Collision(Collision { t, pdf, .. }) => {
                    assert!(t.is_finite() && pdf > 0.0 && u < 1.0 - escape, "σ {sigma_t:?}, u = {u}: collision at {t}, {pdf}");
                    let back = distance_number(&Line { length: t, ..line });
                    assert!((back - u).abs() < ROUNDING, "σ {sigma_t:?}, u = {u}: {back}");
                }
                Flight::Passed { probability, .. } => {
                    assert!((probability - escape).abs() < ROUNDING && u >= 1.0 - escape, "σ {sigma_t:?}, u = {u}");
                }
            }
        }
    }
}

/// A position that is no number must not keep the walk going, nor stop the host's process.
#[test]
fn walks_end_for_numbers_that_are_none() {
    let host = HostMedium::new(&eighths(), Bricks::Built);
    let Density::Grid(grid) = host.view().density else { unreachable!() };
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
        for axis in 0..3 {
            let mut vector = [0.5; 3];
            vector[axis] = bad;
            let _ = grid.moments(&stretch(vector, [0.0, 0.6, 0.8], 1.0));
            let _ = grid.moments(&stretch([0.5; 3], vector, 1.0));
            let _ = grid.invert(&stretch(vector, [0.0, 0.6, 0.8], 1.0), 0.1);
            let _ = (grid.at(vec(vector)), grid.with_gradient(vec(vector)));
        }
        let _ = grid.moments(&stretch([0.5; 3], [0.0, 0.6, 0.8], bad));
    }
}

/// A box that is next to nothing in one direction: rounding puts the line's cells anywhere.
#[test]
fn walks_end_in_boxes_of_no_volume() {
    let samples = vec![1.0; 125];
    let mut rng = generator(3);
    for _ in 0..20000 {
        let thickness = 10.0_f64.powf(uniform(&mut rng, -18.0, -9.0));
        let [x, y, offset, origin] = [0; 4].map(|_| vec(random_vector(&mut rng, -1.0, 1.0)));
        let matrix3 = DMat3::from_cols(x, y, x + thickness * offset);
        let grid = medium::Grid::new(&samples, [5; 3], DAffine3 { matrix3, translation: DVec3::splat(0.5) }, &[]);
        let grid = grid.expect("the counts fit");
        let _ = grid.moments(&stretch(origin.to_array(), [0.0, 0.6, 0.8], 3.0));
        let _ = grid.moments(&stretch([0.5; 3], (x + y).normalize().to_array(), 3.0));
    }
}
