//! Regular tracking: optical depths, their gradients and sampled distances, against the reference's brute force.
//!
//! Lines that stay in one medium have no single-precision segment ends, so both sides agree to rounding. Where a line crosses
//! media, the expected value is put together from one-medium stretches between the very ends that the library gets.

mod common;
mod reference;

use common::{
    assert_below,
    host::*,
    media::{heterogeneous, homogeneous, large_grid},
};
use rand_pcg::Pcg64;
use reference::{
    differences::derivative,
    distance::distance_pdf,
    medium::Medium as ReferenceMedium,
    optical_depth::{optical_depth, optical_depth_in_medium},
    optical_depth_gradient::{Moving, optical_depth_gradient, optical_depth_gradients_in_medium},
    random::*,
    scenes::{random_grid, sheared},
    segments::Edge,
    selftest::Worst,
    vector::*,
    world::World,
};
use volgrad::medium::sample_distance_with_moments;
use volgrad::medium::{
    self, Collision, EdgeMoments, Flight, Line, Milestones, NONE, Segment, distance_number, sample_distance,
};

/// Of exact line integrals, relative to 1 + τ, and of distances, in world units.
const EXACT: f64 = 1e-9;
/// Of gradients, relative to 1 + |∇τ|.
const GRADIENT: f64 = 1e-9;
/// Of a pdf by differences. Next to a wall between cells they would see its kink, but no tested distance is there.
const DIFFERENCES: f64 = 1e-8;

const GREY: Rgb = [0.8; 3];
const CHROMATIC: Rgb = [0.4, 0.9, 1.7];

/// Small and large grids, upright and sheared, grey and chromatic, within about two units of the origin.
fn media(rng: &mut Pcg64) -> Vec<(&'static str, ReferenceMedium)> {
    let upright = Affine::onto_box([-1.0, -0.8, -0.9], [1.0, 1.1, 0.7]);
    vec![
        ("one sample", heterogeneous(GREY, random_grid(rng, [1, 1, 1], upright))),
        ("a row of samples", heterogeneous(GREY, random_grid(rng, [1, 1, 7], sheared()))),
        ("small grid", heterogeneous(CHROMATIC, random_grid(rng, [4, 5, 3], upright))),
        ("sheared grid", heterogeneous(CHROMATIC, random_grid(rng, [9, 8, 17], sheared()))),
        ("large grid", heterogeneous(GREY, large_grid(rng, upright))),
        ("large sheared grid", heterogeneous(CHROMATIC, large_grid(rng, sheared()))),
    ]
}

/// Calls `visit` with every medium, with bricks and without, and some edges through it whose ends are inside and outside.
fn for_each_edge(seed: u64, mut visit: impl FnMut(&str, &ReferenceMedium, &Edge, &Line)) {
    let mut rng = generator(seed);
    for (name, medium) in media(&mut rng) {
        for bricks in [Bricks::Built, Bricks::Left] {
            let host = HostMedium::new(&medium, bricks);
            let views = [host.view()];
            for _ in 0..30 {
                let [a, b] = [0; 2].map(|_| random_vector(&mut rng, -1.3, 1.3));
                let edge = Edge::between(a, b);
                visit(&format!("{name}, {bricks:?}"), &medium, &edge, &line(&edge, &views, &ONE_SEGMENT));
            }
        }
    }
}

#[test]
fn optical_depth_is_that_of_brute_force() {
    let mut worst = Worst::default();
    for_each_edge(1, |name, medium, edge, line| {
        let expected = optical_depth_in_medium(medium, edge.origin, edge.point(edge.length));
        let by_integral = medium::optical_depth(line).to_array();
        let by_moments = medium::moments(line).optical_depth.to_array();
        for tau in [by_integral, by_moments] {
            worst.note(distance(tau, expected) / (1.0 + length(expected)), || name.to_string());
        }
    });
    assert_below(&worst, EXACT);
}

#[test]
fn gradients_at_both_ends_are_those_of_brute_force() {
    let mut worst = Worst::default();
    for_each_edge(2, |name, medium, edge, line| {
        let [near, far] = optical_depth_gradients_in_medium(medium, edge.origin, edge.point(edge.length));
        let moments = medium::moments(line);
        let ours_near = moments.near_gradient(line.direction, line.length);
        let ours_far = moments.far_gradient(line.direction, line.length);
        for c in 0..3 {
            let scale = 1.0 + length(near[c]) + length(far[c]);
            worst.note(distance(ours_near[c].to_array(), near[c]) / scale, || format!("∇_a, {name}"));
            worst.note(distance(ours_far[c].to_array(), far[c]) / scale, || format!("∇_b, {name}"));
        }
    });
    assert_below(&worst, GRADIENT);
}

/// An edge to a light at infinity moves as a whole.
#[test]
fn gradients_of_infinite_edges_are_those_of_brute_force() {
    let mut worst = Worst::default();
    for_each_edge(3, |name, medium, edge, line| {
        let world = World::filled_with(medium.clone());
        let endless = Edge { length: f64::INFINITY, ..*edge };
        let expected = optical_depth_gradient(&world, &endless, Moving::Whole).total();
        let moments = medium::moments(&Line { length: f64::INFINITY, ..*line });
        let tau = optical_depth_in_medium(medium, edge.origin, edge.point(10.0));
        worst.note(distance(moments.optical_depth.to_array(), tau), || format!("τ, {name}"));
        for c in 0..3 {
            let ours = moments.near_gradient(line.direction, f64::INFINITY)[c].to_array();
            worst.note(distance(ours, expected[c]) / (1.0 + length(expected[c])), || format!("∇, {name}"));
        }
    });
    assert_below(&worst, GRADIENT);
}

/// The number of a distance, and the distance of that number, whatever the bricks.
#[test]
fn distances_and_their_numbers_are_inverse() {
    let [mut from_t, mut from_u, mut depth] = [Worst::default(), Worst::default(), Worst::default()];
    let mut rng = generator(4);
    for_each_edge(5, |name, _, edge, whole| {
        let t = edge.length * uniform(&mut rng, 0.0, 1.0);
        let at = Line { length: t, ..*whole };
        // Where nothing scatters, no number leads.
        let x = vec(edge.point(t));
        if whole.media[0].sigma_t(x).max_element() > 0.05 {
            match sample_distance(whole, distance_number(&at)) {
                Flight::Collision(Collision { t: back, optical_depth, .. }) => {
                    from_t.note((back - t).abs(), || name.to_string());
                    let tau = medium::optical_depth(&at);
                    depth.note((optical_depth - tau).length(), || name.to_string());
                }
                Flight::Passed { .. } => from_t.note(f64::NAN, || format!("passed, {name}")),
            }
        }
        let u = uniform(&mut rng, 0.0, 1.0);
        if let Flight::Collision(Collision { t, .. }) = sample_distance(whole, u) {
            from_u.note((distance_number(&Line { length: t, ..*whole }) - u).abs(), || name.to_string());
        }
    });
    assert_below(&from_t, EXACT);
    assert_below(&from_u, EXACT);
    assert_below(&depth, EXACT);
}

/// pdf = mean of σ_t·exp(−τ) is the reference's, and the derivative of the library's own cdf; what is left is the chance to pass.
#[test]
fn pdf_is_the_derivative_of_the_cdf() {
    let [mut by_reference, mut by_differences, mut passed] = [Worst::default(), Worst::default(), Worst::default()];
    let mut rng = generator(6);
    for_each_edge(7, |name, medium, edge, line| {
        let world = World::filled_with(medium.clone());
        let cdf = |t: f64| distance_number(&Line { length: t, ..*line });
        match sample_distance(line, uniform(&mut rng, 0.0, 1.0)) {
            Flight::Collision(Collision { t, pdf, extinction, .. }) => {
                by_reference.note((pdf - distance_pdf(&world, edge, t)).abs(), || name.to_string());
                let at_point = line.media[0].sigma_t(line.origin + t * line.direction);
                by_reference.note((extinction - at_point).length(), || format!("σ_t, {name}"));
                let [slope] = derivative(|h| [cdf(t + h)]);
                by_differences.note((pdf - slope).abs(), || name.to_string());
            }
            Flight::Passed { probability, .. } => {
                passed.note((probability - (1.0 - cdf(edge.length))).abs(), || name.to_string());
            }
        }
    });
    assert_below(&by_reference, EXACT);
    assert_below(&by_differences, DIFFERENCES);
    assert_below(&passed, EXACT);
}

/// Notes by how much two flights differ. Returns how far the second goes.
fn compare_flights(found: Flight, expected: Flight, line: &Line, worst: &mut Worst, name: &str) -> f64 {
    match (found, expected) {
        (Flight::Collision(found), Flight::Collision(expected)) => {
            worst.note((found.t - expected.t).abs() + (found.pdf - expected.pdf).abs(), || format!("distance, {name}"));
            let colours = [found.optical_depth - expected.optical_depth, found.extinction - expected.extinction];
            worst.note(colours[0].length() + colours[1].length(), || format!("τ, σ_t, {name}"));
            assert_eq!(found.medium, expected.medium, "{name}");
            expected.t
        }
        (Flight::Passed { probability, .. }, Flight::Passed { probability: expected, .. }) => {
            worst.note((probability - expected).abs(), || format!("probability, {name}"));
            line.length
        }
        other => panic!("{name}: {other:?}"),
    }
}

/// The moments that come with a distance are those of the line up to there.
fn compare_moments_with_distance(line: &Line, u: f64, worst: &mut Worst, name: &str) {
    let (flight, flown) = sample_distance_with_moments(line, u);
    let length = compare_flights(flight, sample_distance(line, u), line, worst, name);
    let part = Line { length, ..*line };
    let expected = medium::moments(&part);
    worst.note((flown.optical_depth - expected.optical_depth).length(), || format!("τ, {name}"));
    for end in [EdgeMoments::near_gradient, EdgeMoments::far_gradient] {
        let (ours, expected) = (end(&flown, line.direction, length), end(&expected, line.direction, length));
        for c in 0..3 {
            worst.note((ours[c] - expected[c]).length() / (1.0 + expected[c].length()), || format!("∇τ, {name}"));
        }
    }
}

/// From milestones the same distances are found, everywhere along a line, and where none is.
fn compare_from_milestones(line: &Line, worst: &mut Worst, name: &str) {
    let (milestones, optical_depth) = Milestones::along(line);
    worst.note((optical_depth - medium::optical_depth(line)).length(), || format!("τ, {name}"));
    let end = distance_number(line);
    let inside = (0..64).map(|i| end * (f64::from(i) + 0.5) / 64.0);
    for u in inside.chain([0.0, (1.0 - 1e-9) * end, end + 0.5 * (1.0 - end)]) {
        compare_flights(milestones.sample_distance(line, u), sample_distance(line, u), line, worst, name);
    }
}

#[test]
fn distances_are_found_from_milestones() {
    let mut worst = Worst::default();
    let mut rng = generator(13);
    for_each_edge(14, |name, _, _, line| {
        compare_from_milestones(line, &mut worst, name);
        compare_from_milestones(&Line { length: f64::INFINITY, ..*line }, &mut worst, &format!("{name}, to infinity"));
    });
    for n in 0..200 {
        let mixed = Mixed::random(&mut rng);
        let host = mixed.media.each_ref().map(|medium| HostMedium::new(medium, Bricks::Built));
        let media = host.each_ref().map(HostMedium::view);
        let whole = line(&mixed.edge, &media, &mixed.segments);
        compare_from_milestones(&whole, &mut worst, &format!("edge {n}"));
    }
    assert_below(&worst, EXACT);
}

#[test]
fn moments_come_with_distances() {
    let mut worst = Worst::default();
    let mut rng = generator(11);
    for_each_edge(12, |name, _, _, line| {
        compare_moments_with_distance(line, uniform(&mut rng, 0.0, 1.0), &mut worst, name);
    });
    for n in 0..200 {
        let mixed = Mixed::random(&mut rng);
        let host = mixed.media.each_ref().map(|medium| HostMedium::new(medium, Bricks::Built));
        let media = host.each_ref().map(HostMedium::view);
        let whole = line(&mixed.edge, &media, &mixed.segments);
        compare_moments_with_distance(&whole, uniform(&mut rng, 0.0, 1.0), &mut worst, &format!("edge {n}"));
    }
    assert_below(&worst, EXACT);
}

/// ∫ over [0, a] and [a, b] is that over [0, b].
#[test]
fn integrals_of_parts_add_up() {
    let mut worst = Worst::default();
    let mut rng = generator(13);
    for_each_edge(14, |name, _, edge, whole| {
        let a = edge.length * uniform(&mut rng, 0.0, 1.0);
        let [before, all] = [a, edge.length].map(|length| medium::optical_depth(&Line { length, ..*whole }));
        let after = medium::optical_depth(&Line { start: a, ..*whole });
        worst.note((before + after - all).length() / (1.0 + all.length()), || name.to_string());
    });
    assert_below(&worst, EXACT);
}

/// The chromatic cdf is the mean of the channels' own.
#[test]
fn chromatic_cdf_is_the_mean_of_the_channels() {
    let mut worst = Worst::default();
    for_each_edge(8, |name, medium, edge, line| {
        let channels = medium.sigma_t.map(|sigma| {
            let grey = ReferenceMedium { sigma_t: [sigma; 3], ..medium.clone() };
            let tau = optical_depth_in_medium(&grey, edge.origin, edge.point(edge.length));
            1.0 - (-tau[0]).exp()
        });
        let expected = channels.iter().sum::<f64>() / 3.0;
        worst.note((distance_number(line) - expected).abs(), || name.to_string());
    });
    assert_below(&worst, EXACT);
}

/// Vacuum, grid, homogeneous, vacuum, grid again, with ends as the host rounds them.
struct Mixed {
    media: [ReferenceMedium; 2],
    edge: Edge,
    segments: Vec<Segment>,
}

impl Mixed {
    fn random(rng: &mut Pcg64) -> Self {
        let [a, b] = [0; 2].map(|_| random_vector(rng, -1.2, 1.2));
        let edge = Edge::between(a, b);
        let mut fractions = [0; 4].map(|_| uniform(rng, 0.0, 1.0));
        fractions.sort_by(f64::total_cmp);
        let ends = fractions.into_iter().chain([1.0]).map(|fraction| (fraction * edge.length) as f32);
        let segments = ends.zip([NONE, 0, 1, NONE, 0]).map(|(end, medium)| {
            let normal = vec(random_direction(rng)).into();
            Segment { end, medium, normal }
        });
        let segments = segments.collect();
        let grid = heterogeneous(CHROMATIC, random_grid(rng, [5, 6, 4], sheared()));
        Self { media: [grid, homogeneous([1.1, 0.2, 0.6])], edge, segments }
    }

    /// τ up to t, put together from the stretches.
    fn optical_depth(&self, t: f64) -> Rgb {
        let mut begin = 0.0;
        let mut total = ZERO;
        for (i, segment) in self.segments.iter().enumerate() {
            let is_last = i + 1 == self.segments.len();
            let end = if is_last { t } else { f64::from(segment.end).min(t) };
            if segment.medium != NONE && end > begin {
                let medium = &self.media[segment.medium as usize];
                total = add(total, optical_depth_in_medium(medium, self.edge.point(begin), self.edge.point(end)));
            }
            begin = begin.max(end);
        }
        total
    }
}

#[test]
fn edges_through_several_media_add_their_stretches_up() {
    let mut rng = generator(9);
    let [mut tau, mut round_trip] = [Worst::default(), Worst::default()];
    for n in 0..200 {
        let mixed = Mixed::random(&mut rng);
        let host = mixed.media.each_ref().map(|medium| HostMedium::new(medium, Bricks::Built));
        let media = host.each_ref().map(HostMedium::view);
        let whole = line(&mixed.edge, &media, &mixed.segments);
        let t = mixed.edge.length * uniform(&mut rng, 0.0, 1.0);
        let part = Line { length: t, ..whole };
        tau.note(distance(medium::optical_depth(&part).to_array(), mixed.optical_depth(t)), || format!("edge {n}"));

        let u = uniform(&mut rng, 0.0, 1.0);
        let end = distance_number(&whole);
        match sample_distance(&whole, u) {
            Flight::Collision(Collision { t, medium, optical_depth, .. }) => {
                let number = distance_number(&Line { length: t, ..whole });
                round_trip.note((number - u).abs(), || format!("edge {n}"));
                tau.note(distance(optical_depth.to_array(), mixed.optical_depth(t)), || format!("collision {n}"));
                let begin = mixed.segments.iter().position(|segment| t <= f64::from(segment.end)).expect("on the edge");
                assert_eq!(medium, mixed.segments[begin].medium, "edge {n}: a collision in the medium that is there");
            }
            Flight::Passed { probability, .. } => {
                assert!(end <= u, "edge {n}: passed, though {u} < {end}");
                round_trip.note((probability - (1.0 - end)).abs(), || format!("edge {n}"));
            }
        }
    }
    assert_below(&tau, EXACT);
    assert_below(&round_trip, EXACT);
}

/// A line that starts at a near plane measures its segments from there, and the plane is a face.
#[test]
fn lines_from_a_near_plane_have_its_face() {
    let mut rng = generator(10);
    let mut worst = Worst::default();
    for (name, medium) in media(&mut rng).into_iter().chain([("homogeneous", homogeneous(CHROMATIC))]) {
        let mut world = World::filled_with(medium);
        world.camera.near = 0.3;
        let host = HostMedium::new(&world.media[0], Bricks::Built);
        let views = [host.view()];
        for _ in 0..30 {
            let target = [uniform(&mut rng, -0.5, 0.5), uniform(&mut rng, -0.5, 0.5), uniform(&mut rng, 0.4, 0.8)];
            let edge = Edge::from_camera(&world.camera, target);
            let start = 0.3 / dot(world.camera.forward, edge.direction);
            let start_normal = vec(world.camera.forward);
            let moments = medium::moments(&Line { start, start_normal, ..line(&edge, &views, &ONE_SEGMENT) });
            let tau = optical_depth(&world, &edge);
            worst.note(distance(moments.optical_depth.to_array(), tau), || format!("τ, {name}"));
            let expected = optical_depth_gradient(&world, &edge, Moving::End).total();
            let ours = moments.far_gradient(vec(edge.direction), edge.length);
            for c in 0..3 {
                worst.note(distance(ours[c].to_array(), expected[c]), || format!("∇, {name}"));
            }
        }
    }
    assert_below(&worst, GRADIENT);
}
