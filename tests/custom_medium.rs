//! Densities through callbacks: what their quadrature promises (the same from both ends, additive, inverted exactly), its errors, and that
//! copies of built-in media give the same answers and the same pictures.

mod toy;

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use toy::estimate::{Estimate, scale};
use toy::scenes::{World, edges_under_area_lights, homogeneous};
use volgrad::math::{Colour, DAffine3, DVec3, Vec3, transmittance};
use volgrad::medium::*;
use volgrad::sampler;
use volgrad::shift::{self, Kernel, Mode};

/// 1/2 + 0.4·sin(wave·x)
#[derive(Debug)]
struct Waves(DVec3);

impl DensityField for Waves {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        densities.iter_mut().zip(points).for_each(|(density, x)| *density = 0.5 + 0.4 * self.0.dot(*x).sin());
    }

    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        gradients.iter_mut().zip(points).for_each(|(gradient, x)| *gradient = 0.4 * self.0.dot(*x).cos() * self.0);
    }
}

const WAVES: Waves = Waves(DVec3::new(3.0, -2.0, 4.0));

impl Waves {
    /// ∫ ρ and ∫ |ρ''| along a line, and ∇τ at its ends, all by a fine midpoint rule of the formulas.
    fn truth(&self, from: DVec3, to: DVec3) -> (f64, f64, [DVec3; 2]) {
        const STEPS: u32 = 100_000;
        let (length, direction) = ((to - from).length(), (to - from).normalize());
        let width = length / f64::from(STEPS);
        let (mut sum, mut bend, mut gradients) = (0.0, 0.0, [-direction, direction]);
        let (mut near, mut far) = (DVec3::ZERO, DVec3::ZERO);
        for k in 0..STEPS {
            let f = (f64::from(k) + 0.5) / f64::from(STEPS);
            let (sin, cos) = self.0.dot(from.lerp(to, f)).sin_cos();
            sum += width * (0.5 + 0.4 * sin);
            bend += width * 0.4 * sin.abs() * self.0.dot(direction).powi(2);
            far += width * f * 0.4 * cos * self.0;
            near += width * (1.0 - f) * 0.4 * cos * self.0;
        }
        gradients = gradients.map(|g| g * sum / length);
        (sum, bend, [gradients[0] + near, gradients[1] + far])
    }
}

/// Another density, seen as a host's function. On the faces of its box rounding may put a point outside, where a box has density 0.
#[derive(Debug)]
struct Copy(Density<'static>, DVec3);

impl Copy {
    fn inward(&self, x: DVec3) -> DVec3 {
        self.1 + (x - self.1) * (1.0 - 1e-12)
    }
}

impl DensityField for Copy {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        densities.iter_mut().zip(points).for_each(|(density, x)| *density = self.0.at(self.inward(*x)));
    }

    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        gradients.iter_mut().zip(points).for_each(|(gradient, x)| *gradient = self.0.gradient(self.inward(*x)));
    }
}

fn uniform(rng: &mut Pcg64, low: f64, high: f64) -> f64 {
    low + (high - low) * (f64::from(rng.next_u32()) + 0.5) / 4_294_967_296.0
}

fn point(rng: &mut Pcg64, half: f64) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| uniform(rng, -half, half)))
}

/// A sheared box around the origin, and the step with which it is sampled.
fn boxed(field: &dyn DensityField, step: f64) -> Medium<'_> {
    medium(Density::Custom(Custom::new(field, to_world(), step, 1.0).expect("not too many panels")))
}

fn to_world() -> DAffine3 {
    let matrix3 =
        volgrad::math::DMat3::from_cols(DVec3::new(2.0, 0.3, 0.0), DVec3::new(0.0, 2.5, -0.2), DVec3::new(0.4, 0.0, 3.0));
    DAffine3 { matrix3, translation: matrix3 * DVec3::splat(-0.5) }
}

fn medium(density: Density<'_>) -> Medium<'_> {
    let Medium { albedo, phase, .. } = homogeneous([1.0; 3], [0.9; 3], 0.0);
    Medium { sigma_t: Colour::new(1.0, 0.7, 0.3), albedo, phase, density }
}

const ONE_SEGMENT: [Segment; 1] = [Segment { end: f32::INFINITY, medium: 0, normal: Vec3 { x: 0.0, y: 0.0, z: 0.0 } }];

fn line<'a>(media: &'a [Medium<'a>], from: DVec3, to: DVec3) -> Line<'a> {
    Line::new(media, from, (to - from).normalize(), (to - from).length(), &ONE_SEGMENT)
}

fn stretch(from: DVec3, to: DVec3) -> Stretch {
    Stretch { origin: from, direction: (to - from).normalize(), start: 0.0, end: (to - from).length() }
}

/// Both ∇τ of the red channel.
fn gradients(line: &Line) -> [DVec3; 2] {
    let edge = moments(line);
    [edge.near_gradient(line.direction, line.length)[0], edge.far_gradient(line.direction, line.length)[0]]
}

const LINES: usize = 300;
const INSIDE: f64 = 0.8;
const ACROSS: f64 = 4.0;

/// τ is off by no more than step²/12·∫|ρ''| on the panels that it touches, and ∇τ converges as fast.
#[test]
fn the_error_is_of_second_order() {
    let mut rng = Pcg64::seed_from_u64(1);
    let mut worst = [[0.0f64; 2]; 2];
    let steps = [0.1, 0.025];
    for _ in 0..LINES / 10 {
        let (from, to) = (point(&mut rng, INSIDE), point(&mut rng, INSIDE));
        let (tau, bend, truth) = WAVES.truth(from, to);
        for (i, step) in steps.into_iter().enumerate() {
            let media = [boxed(&WAVES, step)];
            let line = line(&media, from, to);
            let error = (optical_depth(&line).x - tau).abs();
            // The two panels at the ends count whole, where |ρ''| is at most 0.4·|wave|².
            let bound = step * step / 12.0 * (bend + 2.0 * step * 0.4 * WAVES.0.length_squared());
            assert!(error < bound, "step {step}: {error:e} > {bound:e}");
            worst[i][0] = worst[i][0].max(error);
            let errors = gradients(&line).into_iter().zip(truth).map(|(a, b)| (a - b).length());
            worst[i][1] = errors.fold(worst[i][1], f64::max);
        }
    }
    println!("worst errors of τ and ∇τ at steps {steps:?}: {worst:.6?}");
    let [coarse, fine] = worst;
    assert!(fine[0] < coarse[0] / 10.0 && fine[1] < coarse[1] / 10.0, "a quarter of the step, about a sixteenth of the error");
    assert!(fine[0] < 2e-4 && fine[1] < 1e-3);
}

/// 0.3 + xy/20
#[derive(Debug)]
struct Saddle;

impl DensityField for Saddle {
    fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
        densities.iter_mut().zip(points).for_each(|(density, p)| *density = 0.3 + p.x * p.y / 20.0);
    }

    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        gradients.iter_mut().zip(points).for_each(|(gradient, p)| *gradient = DVec3::new(p.y, p.x, 0.0) / 20.0);
    }
}

/// A gradient that is linear along the line is integrated exactly, so ∇τ is exact across it, however coarse the step.
#[test]
fn linear_gradients_are_exact() {
    let mut rng = Pcg64::seed_from_u64(8);
    let media = [boxed(&Saddle, 1.3)];
    for _ in 0..LINES {
        let (from, to) = (point(&mut rng, INSIDE), point(&mut rng, INSIDE));
        let (line, slope) = (line(&media, from, to), |p: DVec3| DVec3::new(p.y, p.x, 0.0) / 20.0);
        let (d, direction) = (line.length, line.direction);
        let across = |v: DVec3| v - v.dot(direction) * direction;
        let far = d / 2.0 * slope(from) + d * d / 3.0 * slope(direction);
        let near = d * slope(from) + d * d / 2.0 * slope(direction) - far;
        let [got_near, got_far] = gradients(&line);
        assert!(across(got_near - near).length() < 1e-12 && across(got_far - far).length() < 1e-12, "{got_far} {far}");
    }
}

/// τ belongs to the line: the same from either end, whole or in parts. Along it ∇τ is the exact derivative of this τ, to rounding.
#[test]
fn tau_belongs_to_the_line() {
    let mut rng = Pcg64::seed_from_u64(2);
    // Ten of the first step along y: a whole number of panels, which rounding must not change.
    for step in [0.1 * to_world().matrix3.y_axis.length(), 0.07, 10.0] {
        let density = boxed(&WAVES, step).density;
        for i in 0..LINES {
            let (mut from, mut to) = (point(&mut rng, ACROSS), point(&mut rng, ACROSS));
            if i % 3 == 0 {
                let (middle, along) = (point(&mut rng, INSIDE), to_world().matrix3.y_axis);
                (from, to) = (middle - 1.7 * along, middle + 1.6 * along);
            }
            let (there, back) = (stretch(from, to), stretch(to, from));
            let whole = density.integral(&there);
            assert!((density.integral(&back) - whole).abs() < 1e-12, "{from} {to}");
            assert!((density.moments(&there).integral - whole).abs() < 1e-12);
            let cut = uniform(&mut rng, 0.0, there.end);
            let parts = [(0.0, cut), (cut, there.end)].map(|(start, end)| density.integral(&Stretch { start, end, ..there }));
            assert!((parts[0] + parts[1] - whole).abs() < 1e-12);

            let middle = Stretch { end: cut, ..there };
            let media = [medium(density)];
            let gradient = gradients(&line(&media, from, from + cut * there.direction))[1].dot(there.direction);
            let at_cut = density.along(&there, cut);
            assert!((gradient - at_cut).abs() < 1e-10, "{gradient} {at_cut}");
            const STEP: f64 = 1e-6;
            let difference = density.integral(&Stretch { end: cut + STEP, ..middle })
                - density.integral(&Stretch { end: cut - STEP, ..middle });
            let at_face =
                density.extent(&there).is_none_or(|e| (e.start - cut).abs() < 2.0 * STEP || (e.end - cut).abs() < 2.0 * STEP);
            assert!(at_face || (difference / (2.0 * STEP) - at_cut).abs() < 1e-5);
        }
    }
}

/// u → t → u, and a pdf that is the derivative of the cdf.
#[test]
fn distances_are_sampled_exactly() {
    let mut rng = Pcg64::seed_from_u64(3);
    let (mut worst, mut collisions) = (0.0f64, 0);
    let media = [boxed(&WAVES, 0.3)];
    for _ in 0..LINES {
        let (from, to) = (point(&mut rng, ACROSS), point(&mut rng, INSIDE));
        let line = line(&media, from, to);
        let u = uniform(&mut rng, 0.0, 1.0);
        let Flight::Collision(Collision { t, optical_depth: tau, pdf, .. }) = sample_distance(&line, u) else { continue };
        collisions += 1;
        let until = |t: f64| Line { length: t, ..line };
        worst = worst.max((distance_number(&until(t)) - u).abs());
        assert!((optical_depth(&until(t)) - tau).abs().max_element() < 1e-12);
        const STEP: f64 = 1e-6;
        let slope = (distance_number(&until(t + STEP)) - distance_number(&until(t - STEP))) / (2.0 * STEP);
        assert!((slope - pdf).abs() < 1e-5, "{slope} {pdf}");
    }
    println!("u → t → u: {worst:.1e} over {collisions} collisions");
    assert!(worst < 1e-12 && collisions > LINES / 4);
}

/// A constant density is integrated exactly, faces of the box included: as a grid of the same box.
#[test]
fn a_constant_copy_is_exact() {
    let grid = Grid::new(&[1.0; 8], [2; 3], to_world(), &[]).expect("it fits");
    compare_with(Density::Grid(grid), 10.0, [1e-9; 3]);
}

/// A copy of a grid has its τ, gradients and distances up to the error of the quadrature; which is of first order for the gradients, as
/// the grid's own ∇ρ jumps at cell walls.
#[test]
fn a_copy_of_a_grid_converges() {
    compare_with(random_grid(), 0.02, [3e-4, 4e-2, 6e-4]);
    compare_with(random_grid(), 0.005, [2e-5, 1e-2, 4e-5]);
}

fn random_grid() -> Density<'static> {
    let mut rng = Pcg64::seed_from_u64(4);
    let samples = Vec::leak((0..6 * 5 * 4).map(|_| uniform(&mut rng, 0.1, 1.0) as f32).collect());
    Density::Grid(Grid::new(samples, [6, 5, 4], to_world(), &[]).expect("it fits"))
}

fn compare_with(density: Density<'static>, step: f64, tolerance: [f64; 3]) {
    let copy = Copy(density, DVec3::ZERO);
    let (original, copied) = ([medium(density)], [boxed(&copy, step)]);
    let mut rng = Pcg64::seed_from_u64(5);
    let mut worst = [0.0f64; 3];
    for i in 0..LINES {
        let (from, to) = (point(&mut rng, if i % 2 == 0 { INSIDE } else { ACROSS }), point(&mut rng, ACROSS));
        let lines = [line(&original, from, to), line(&copied, from, to)];
        let [a, b] = lines.map(|line| optical_depth(&line));
        worst[0] = worst[0].max((a - b).abs().max_element());
        let [a, b] = lines.map(|line| gradients(&line));
        // Lines that graze a face have large gradients.
        let error = |a: DVec3, b: DVec3| (a - b).length() / a.length().max(1.0);
        worst[1] = worst[1].max(error(a[0], b[0])).max(error(a[1], b[1]));
        let u = uniform(&mut rng, 0.0, 1.0);
        if let [Flight::Collision(Collision { t: a, .. }), Flight::Collision(Collision { t: b, .. })] =
            lines.map(|line| sample_distance(&line, u))
        {
            worst[2] = worst[2].max((a - b).abs());
        }
    }
    println!("step {step}: worst differences of τ, ∇τ, t: {worst:.6?}");
    assert!(worst.iter().zip(tolerance).all(|(w, t)| *w < t), "{worst:?}");
}

/// Estimators use the true density, so they know nothing of panels: the means at a coarse step are those of the formula.
#[test]
fn ratio_tracking_of_a_custom_density_is_unbiased() {
    const SAMPLES: u32 = 40_000;
    let mut rng = Pcg64::seed_from_u64(6);
    let (from, to) = (DVec3::new(-0.7, 0.5, -0.9), DVec3::new(0.6, -0.4, 0.8));
    let (tau, _, gradients) = WAVES.truth(from, to);
    let media = [boxed(&WAVES, 1.0)];
    let line = line(&media, from, to);
    let (mut sums, mut squares) = ([0.0; 7], [0.0; 7]);
    for _ in 0..SAMPLES {
        let random = || uniform(&mut rng, 0.0, 1.0);
        let e = estimate_transmittance(&line, Estimator::RatioTracking, random).expect("few collisions");
        let (near, far) = (e.near_gradient[0].to_array(), e.far_gradient[0].to_array());
        for (i, value) in [e.transmittance.x].into_iter().chain(near).chain(far).enumerate() {
            (sums[i], squares[i]) = (sums[i] + value, squares[i] + value * value);
        }
    }
    let t = (-tau).exp();
    let exact = [t].into_iter().chain(gradients.into_iter().flat_map(|g| (-t * g).to_array()));
    for (i, exact) in exact.enumerate() {
        let mean = sums[i] / f64::from(SAMPLES);
        let z = (mean - exact) / ((squares[i] / f64::from(SAMPLES) - mean * mean) / f64::from(SAMPLES)).sqrt();
        println!("{mean:.4} instead of {exact:.4}, z {z:.2}");
        assert!(z.abs() < 4.0);
    }
    assert!((transmittance(optical_depth(&line)).x - t).abs() > 1e-3, "the step is coarse");
}

/// NaN, infinite and negative densities count as 0, gradients that are not finite too.
#[test]
fn bad_values_count_as_nothing() {
    #[derive(Debug)]
    struct Bad;
    impl DensityField for Bad {
        fn densities(&self, points: &[DVec3], densities: &mut [f64]) {
            let bad = [f64::NAN, f64::INFINITY, -1.0, f64::NEG_INFINITY, 1.0];
            densities.iter_mut().zip(points).for_each(|(d, x)| *d = bad[(x.x * 1e4).abs() as usize % bad.len()]);
        }
        fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
            gradients.iter_mut().zip(points).for_each(|(g, x)| *g = DVec3::new(f64::INFINITY, f64::NAN, x.x));
        }
    }
    let media = [boxed(&Bad, 0.05)];
    let mut rng = Pcg64::seed_from_u64(7);
    for _ in 0..LINES {
        let (from, to) = (point(&mut rng, ACROSS), point(&mut rng, INSIDE));
        let line = line(&media, from, to);
        let tau = optical_depth(&line);
        assert!(tau.is_finite() && tau.min_element() >= 0.0);
        assert!(gradients(&line).into_iter().all(|g| g.is_finite()));
        if let Flight::Collision(Collision { t, pdf, .. }) = sample_distance(&line, uniform(&mut rng, 0.0, 1.0)) {
            assert!(t.is_finite() && pdf.is_finite());
        }
        assert!(matches!(media[0].density.at(to), 0.0 | 1.0));
    }
}

/// A step that would make a line endless is refused.
#[test]
fn a_step_has_a_least_length() {
    assert!(Custom::new(&WAVES, to_world(), 1e-6, 1.0).is_none() && Custom::new(&WAVES, to_world(), f64::NAN, 1.0).is_none());
}

/// Paths per pixel and batch: 64 pixels × 64 batches × 64 = 262 144 paths per estimate.
const PASSES: u64 = 64;

/// The world with its grid, medium 2, as a custom density.
fn with_a_copy(mut world: World) -> World {
    let low = DVec3::new(0.4, -1.0, -0.5);
    let size = DVec3::new(1.2, 2.0, 1.2);
    let copy = Box::leak(Box::new(Copy(world.media[2].density, low + 0.5 * size)));
    let to_world = DAffine3::from_translation(low) * DAffine3::from_scale(size);
    world.media[2].density = Density::Custom(Custom::new(copy, to_world, 0.05, 2.5).expect("few panels"));
    world
}

/// Rendered with a copy of its grid a scene looks the same: means of 64 batches; |z| < 3 in 3 channel totals, |z| < 4.5 in 64 pixels,
/// which a new seed trips with probability 0.9 %. Shifted exchangeably, the copy's mean stays as well.
#[test]
fn a_copy_renders_the_same() {
    let options = sampler::Options {
        max_depth: 5,
        rr_depth: 3,
        seed: 1,
        shift: None,
        left_out: volgrad::sampler::Lengths::NONE,
        first: volgrad::sampler::FirstVertices::ALL,
    };
    let grid = Estimate::of_path_tracer(&edges_under_area_lights(), options, PASSES * scale());
    let copy = with_a_copy(edges_under_area_lights());
    let plain = Estimate::of_path_tracer(&copy, sampler::Options { seed: 2, ..options }, PASSES * scale());
    let z = |a: toy::estimate::Mean, b: toy::estimate::Mean| (a.value - b.value) / a.error.hypot(b.error);
    let totals = [0, 1, 2].map(|c| z(plain.channel(c), grid.channel(c)));
    let pixel = (0..grid.pixels()).map(|i| z(plain.pixel(i), grid.pixel(i)).abs()).fold(0.0, f64::max);
    println!("z of totals {totals:.2?}, worst of pixels {pixel:.2}");
    assert!(totals.into_iter().all(|z| z.abs() < 3.0) && pixel < 4.5);

    let ball = shift::Options::new(Mode::Exchangeable, Kernel::Ball(0.35), 4);
    let tile = shift::Options { run: 3, ..shift::Options::new(Mode::Exchangeable, Kernel::Tile, 8) };
    for shift in [ball, tile] {
        let shifted = sampler::Options { seed: 2, shift: Some(shift), ..options };
        let scores = Estimate::of_path_tracer(&copy, shifted, PASSES * scale()).paired_scores(&plain);
        println!("shifted: {scores:.2?}");
        assert!(scores.pixel.abs() < 4.8 && scores.total.abs() < 4.0 && scores.dropped == 0);
    }
}
