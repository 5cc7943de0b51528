//! Where [Lu20] prints another formula than this library computes: each against finite differences of the factor it is the gradient
//! of. What is printed is off by what ARCHITECTURE.md and the comments here say; what the library computes agrees.

mod common;
mod reference;

use common::host::*;
use rand_pcg::Pcg64;
use reference::{
    contribution::contribution,
    differences::{derivative, difference_gradient, gradient},
    factors::Factors,
    gradient::log_gradient,
    grid::Grid,
    medium::{Density, Medium},
    optical_depth::optical_depth_in_medium,
    path::{Path, Vertex},
    phase::Phase,
    random::{generator, uniform},
    random_paths::MIRROR_PATTERNS,
    scenes::{random_grid, sheared},
    selftest::{for_each_path, for_each_vertex},
    vector::*,
    world::World,
};
use std::f64::consts::PI;
use volgrad::path::{LogGradient, path_log_gradient, path_run_log_derivative};

const SEED: u64 = 23;
/// As in tests/gradients: single-precision segments, relative to Σ|factor gradients|.
const AGREES: f64 = 1e-6;

/// Relative errors against differences of what is printed and of what the library computes.
#[derive(Default)]
struct Erratum {
    printed: Vec<f64>,
    corrected: Vec<f64>,
}

impl Erratum {
    fn note(&mut self, printed: Vec3, corrected: Vec3, truth: Vec3, magnitude: f64) {
        self.printed.push(distance(printed, truth) / length(truth));
        self.corrected.push(distance(corrected, truth) / magnitude);
    }

    /// What is printed is typically off by `stated`, give or take half of it, and what the library computes is not.
    fn assert_off_by(mut self, stated: f64) {
        self.printed.sort_by(f64::total_cmp);
        let median = self.printed[self.printed.len() / 2];
        let worst = self.corrected.iter().fold(0.0, |worst: f64, &e| if e > worst || e.is_nan() { e } else { worst });
        println!("printed: {median:.2}, library: {worst:.1e}, {} gradients", self.printed.len());
        assert!((median - stated).abs() <= 0.5 * stated, "printed is off by {median}, not by {stated}");
        assert!(worst <= AGREES, "the library is off by {worst:e}");
    }
}

/// Any vertex of the random paths, with everything about it.
struct Case<'a> {
    world: &'a World,
    path: &'a Path,
    i: usize,
    x: Vec3,
    /// Truth.
    differences: Factors<Vec3>,
    library: LogGradient,
}

impl Case<'_> {
    fn phase(&self, q: usize) -> Option<Phase> {
        match self.path.vertices[q] {
            Vertex::Medium { medium, .. } => Some(self.world.media[medium].phase),
            _ => None,
        }
    }

    /// From x_q to its neighbours before and after, and their lengths.
    fn edges(&self, q: usize) -> [(Vec3, f64); 2] {
        let [before, after] = [q - 1, q].map(|edge| self.path.edge(self.world, edge));
        [(scale(-1.0, before.direction), before.length), (after.direction, after.length)]
    }
}

/// Collects an erratum over all vertices for which `printed` says something: what it prints and which factor that is, of the library
/// and of the differences.
fn erratum(printed: impl Fn(&Case) -> Option<(Vec3, Vec3, Vec3)>) -> Erratum {
    let mut erratum = Erratum::default();
    for_each_vertex(SEED, |scene, _, _, path, i| {
        let (world, path) = (&rounded_world(&scene.world), &rounded_path(path));
        let library =
            with_path(world, path, Bricks::Built, |scene, path| path_log_gradient(scene, path, i).expect("f > 0").factors);
        let differences = difference_gradient(world, path, i).factors;
        let magnitude = log_gradient(world, path, i).magnitude();
        let x = path.vertices[i].position(world);
        let case = Case { world, path, i, x, differences, library };
        if let Some((printed, corrected, truth)) = printed(&case) {
            erratum.note(printed, corrected, truth, magnitude);
        }
    });
    erratum
}

/// ∇cosθ for a wing [Lu20 (24)], which is right.
fn wing((u_x, d_x): (Vec3, f64), (u_o, _): (Vec3, f64)) -> Vec3 {
    scale(1.0 / d_x, sub(u_o, scale(dot(u_x, u_o), u_x)))
}

/// (9) and (23) have −2g cosθ with the angle θ between the edges, at which straight on is cosθ = −1.
/// As printed g > 0 would scatter backward: the mean cosine of the deflection is −g, and the gradient has the wrong size and sign.
#[test]
fn equations_9_and_23_swap_forward_and_backward() {
    let printed_value = |g: f64, c: f64| (1.0 - g * g) / (4.0 * PI) * (1.0 + g * g - 2.0 * g * c).powf(-1.5);
    let mean_cosine = |value: &dyn Fn(f64) -> f64| {
        let n = 10_000;
        let c = |i: usize| (2 * i + 1) as f64 / n as f64 - 1.0;
        (0..n).map(|i| -c(i) * value(c(i)) * 2.0 * PI * 2.0 / n as f64).sum::<f64>()
    };
    for g in [-0.6, 0.3, 0.9] {
        assert!((mean_cosine(&|c| printed_value(g, c)) + g).abs() < 1e-4);
        assert!((mean_cosine(&|c| volgrad::phase::Phase::henyey_greenstein(g).eval(c)) - g).abs() < 1e-4);
    }
    let erratum = erratum(|case| {
        let Some(Phase::HenyeyGreenstein { g }) = case.phase(case.i + 1) else { return None };
        let [to_x, onwards] = case.edges(case.i + 1);
        let printed = scale(3.0 * g / (1.0 + g * g - 2.0 * g * dot(to_x.0, onwards.0)), wing(to_x, onwards));
        Some((printed, case.library.phase_next.to_array(), case.differences.profile_next[0]))
    });
    erratum.assert_off_by(2.0);
}

/// (25) is the sum of both wings' ∇cosθ.
/// But moving the apex is moving both wings the other way: it is the negative of that sum.
#[test]
fn equation_25_has_the_sign_of_the_wings() {
    let erratum = erratum(|case| {
        let phase @ Phase::HenyeyGreenstein { .. } = case.phase(case.i)? else { return None };
        let [p, n] = case.edges(case.i);
        let printed = scale(phase.log_derivative(dot(p.0, n.0)), add(wing(p, n), wing(n, p)));
        Some((printed, case.library.phase_apex.to_array(), case.differences.phase_apex))
    });
    erratum.assert_off_by(2.0);
}

/// (29) has seven terms: transmittance, phase function and geometry.
/// A vertex that moves in a medium of varying density also scatters more or less: ∇σ_s/σ_s is missing.
#[test]
fn equation_29_forgets_the_scattering_coefficient() {
    let erratum = erratum(|case| {
        let Vertex::Medium { medium, .. } = case.path.vertices[case.i] else { return None };
        let Density::Grid(_) = case.world.media[medium].density else { return None };
        let printed = sub(case.differences.total(0), case.differences.scattering);
        Some((printed, case.library.channel(0).to_array(), case.differences.total(0)))
    });
    // By chance of the media; a median of many.
    erratum.assert_off_by(0.35);
}

/// (38) is W_e/p(ω) with p(ω) of (35), so that (39) has −∇cosθ/cosθ: nothing is sampled by that density when x_1 is connected to the camera.
/// There W_e itself counts, and G: −3∇cosθ/cosθ − 2v/d².
#[test]
fn equations_38_and_39_divide_by_a_density_and_forget_the_distance() {
    let erratum = erratum(|case| {
        (case.i == 1).then(|| {
            let camera = &case.world.camera;
            let (u, d, cosine) = (direction(camera.position, case.x), distance(camera.position, case.x), camera.cosine(case.x));
            let gradient_of_cosine = scale(1.0 / d, sub(camera.forward, scale(cosine, u)));
            let printed = scale(-1.0 / cosine, gradient_of_cosine);
            let library = case.library.importance + case.library.geometry_previous;
            (printed, library.to_array(), add(case.differences.importance, case.differences.geometry_prev))
        })
    });
    erratum.assert_off_by(1.0);
}

/// (42) and (43) take G = 1/d² of (10) next to a diffuse surface, and so does "Area lights".
/// There G has the cosine at the surface or light, whose gradient is as large.
#[test]
fn equations_42_and_43_forget_the_cosine() {
    let erratum = erratum(|case| {
        let q = &case.path.vertices[case.i + 1];
        matches!(q, Vertex::Diffuse { .. } | Vertex::AreaLight { .. }).then(|| {
            let v = sub(case.x, q.position(case.world));
            let printed = scale(-2.0 / dot(v, v), v);
            (printed, case.library.geometry_next.to_array(), case.differences.geometry_next)
        })
    });
    erratum.assert_off_by(0.77);
}

/// "Environment light": the gradient is 0, as its radiance does not change.
/// The transmittance towards it does: the whole edge moves through the medium.
#[test]
fn an_environment_has_a_gradient() {
    let erratum = erratum(|case| {
        let truth = case.differences.transmittance_next[0];
        let at_infinity = case.path.vertices[case.i + 1].is_at_infinity();
        (at_infinity && length(truth) > 1e-3).then(|| (ZERO, case.library.transmittance_next[0].to_array(), truth))
    });
    erratum.assert_off_by(1.0);
}

/// "Specular": x moves along the ray to the mirror, and only the gradient of that edge's G is needed.
/// That edge has no G (the chain is in direction and distance), and the edge at the other side has one.
#[test]
fn a_specular_edge_has_no_geometry_term() {
    let mut erratum = Erratum::default();
    for_each_path(SEED, &MIRROR_PATTERNS, |scene, _, pattern, path| {
        if !pattern.starts_with("CMX") {
            return;
        }
        let (world, path) = (rounded_world(&scene.world), rounded_path(path));
        let edge = path.edge(&world, 1);
        let [truth] = derivative(|delta| {
            let f = contribution(&world, &path.moved(1, 1, scale(delta, edge.direction)));
            [f.geometry.iter().product::<f64>().ln()]
        });
        let library = with_path(&world, &path, Bricks::Built, |scene, path| {
            let derivative = path_run_log_derivative(scene, path, 1, 1).expect("f > 0");
            (derivative.factors.geometry_previous + derivative.factors.geometry_next).dot(derivative.direction)
        });
        // 1/d² of an edge that gets shorter.
        let printed = 2.0 / edge.length;
        erratum.note([printed, 0.0, 0.0], [library, 0.0, 0.0], [truth, 0.0, 0.0], 1.0 + truth.abs());
    });
    erratum.assert_off_by(3.5);
}

/// A grid that an edge does not leave, and its majorant σ̄.
struct Tracked {
    medium: Medium,
    majorant: f64,
    a: Vec3,
    b: Vec3,
}

/// The collisions of ratio tracking with σ̄ along the edge from a to b, as shares c_j/c_n of it.
fn collisions(rng: &mut Pcg64, majorant: f64, length: f64) -> Vec<f64> {
    let mut shares = Vec::new();
    let mut t = 0.0;
    loop {
        t -= (1.0 - uniform(rng, 0.0, 1.0)).ln() / majorant;
        if t >= length {
            return shares;
        }
        shares.push(t / length);
    }
}

impl Tracked {
    fn new() -> Self {
        let grid = random_grid(&mut generator(SEED), [4, 3, 5], sheared());
        let majorant = grid.samples.iter().copied().fold(0.0, f64::max);
        let medium = Medium { sigma_t: ONE, albedo: ONE, phase: Phase::Isotropic, density: Density::Grid(grid) };
        Self { medium, majorant, a: [-0.2, 0.3, -0.4], b: [0.4, 0.1, 0.5] }
    }

    fn at(&self, share: f64) -> Vec3 {
        add(self.a, scale(share, sub(self.b, self.a)))
    }

    fn sigma(&self, share: f64) -> f64 {
        self.medium.density(self.at(share))
    }

    fn sigma_gradient(&self, share: f64) -> Vec3 {
        self.medium.clamped_density_gradient(self.at(share))
    }

    /// T̂, and Σ c_j/c_n ∇σ(x_j)/(σ̄ − σ(x_j)).
    fn printed_sum(&self, shares: &[f64]) -> (f64, Vec3) {
        let transmittance = shares.iter().map(|&s| 1.0 - self.sigma(s) / self.majorant).product();
        let term = |s: f64| scale(s / (self.majorant - self.sigma(s)), self.sigma_gradient(s));
        (transmittance, shares.iter().fold(ZERO, |sum, &s| add(sum, term(s))))
    }

    /// [Lu20 (20)]
    fn equation_20(&self, shares: &[f64]) -> Vec3 {
        let (transmittance, sum) = self.printed_sum(shares);
        scale(-transmittance, sum)
    }

    /// [Lu20 (21)]
    fn equation_21(&self, shares: &[f64]) -> Vec3 {
        let (transmittance, sum) = self.printed_sum(shares);
        let average = shares.iter().map(|&s| self.sigma(s)).sum::<f64>() / shares.len() as f64;
        scale(-transmittance, add(sum, scale(average, direction(self.a, self.b))))
    }

    /// −[ T̂ σ(b) û + Σ_j c_j/c_n P⊥∇σ(x_j)/σ̄ Π_{k≠j} (1 − σ_k/σ̄) ]: nothing is divided by what may be 0.
    fn corrected(&self, shares: &[f64]) -> Vec3 {
        let u = direction(self.a, self.b);
        let without = |j: usize| {
            let others = shares.iter().enumerate().filter(|(k, _)| *k != j);
            others.map(|(_, &s)| 1.0 - self.sigma(s) / self.majorant).product::<f64>()
        };
        let mut sum = scale(without(usize::MAX) * self.sigma(1.0), u);
        for (j, &s) in shares.iter().enumerate() {
            let gradient = self.sigma_gradient(s);
            let across = sub(gradient, scale(dot(gradient, u), u));
            sum = add(sum, scale(s / self.majorant * without(j), across));
        }
        scale(-1.0, sum)
    }

    /// The mean of an estimator of ∇_b Tr; what is no number counts as 0.
    fn mean(&self, estimator: impl Fn(&Self, &[f64]) -> Vec3) -> Vec3 {
        const SAMPLES: usize = 100_000;
        let mut rng = generator(SEED);
        let mut sum = ZERO;
        for _ in 0..SAMPLES {
            let shares = collisions(&mut rng, self.majorant, distance(self.a, self.b));
            let value = estimator(self, &shares);
            if value.iter().all(|v| v.is_finite()) {
                sum = add(sum, value);
            }
        }
        scale(1.0 / SAMPLES as f64, sum)
    }

    /// ∇_b Tr by differences.
    fn truth(&self) -> Vec3 {
        gradient(|b| [(-optical_depth_in_medium(&self.medium, self.a, b)[0]).exp()], self.b)[0]
    }

    /// The library's, exactly: Tr times the gradient of its logarithm.
    fn library(&self) -> Vec3 {
        let edge = reference::segments::Edge::between(self.a, self.b);
        let host = HostMedium::new(&self.medium, Bricks::Built);
        let media = [host.view()];
        let line = line(&edge, &media, &ONE_SEGMENT);
        let moments = volgrad::medium::moments(&line);
        let [_, far] = gradients(&moments, &line);
        scale(-(-moments.optical_depth.x).exp(), far[0].to_array())
    }

    fn error(&self, gradient: Vec3) -> f64 {
        let truth = self.truth();
        let error = distance(gradient, truth) / length(truth);
        println!("off by {error:.1e}");
        error
    }
}

/// Standard errors of the means are a fifth of this.
const MONTE_CARLO: f64 = 0.02;

/// (20) lets the points of the edge follow its end, and so changes their σ.
/// The edge's length changes, too: what is printed is only a part of the gradient, and in a homogeneous medium nothing.
#[test]
fn equation_20_is_only_a_part_of_the_gradient() {
    let tracked = Tracked::new();
    let printed = tracked.error(tracked.mean(Tracked::equation_20));
    assert!(printed > 0.5 && printed < 1.5, "{printed}");
    assert!(tracked.error(tracked.mean(Tracked::corrected)) < MONTE_CARLO);
    assert!(tracked.error(tracked.library()) < AGREES);
}

/// (21) adds σ_avg û, σ_avg from the very samples of T̂, with which it is correlated; it is 0/0 where there is no collision.
/// And 1/(σ̄ − σ) has no value where the majorant is reached, as it is everywhere in a homogeneous medium.
#[test]
fn equation_21_is_biased_and_singular() {
    let tracked = Tracked::new();
    let printed = tracked.error(tracked.mean(Tracked::equation_21));
    assert!(printed > 0.15 && printed < 0.6, "{printed}");
    assert!(tracked.equation_21(&[])[0].is_nan() && tracked.corrected(&[])[0].is_finite());

    let grid = Grid { resolution: [1; 3], samples: vec![1.0], to_world: sheared() };
    let medium = Medium { density: Density::Grid(grid), ..tracked.medium };
    let homogeneous = Tracked { medium, majorant: 1.0, ..tracked };
    assert!(homogeneous.equation_21(&[0.5])[0].is_nan() && homogeneous.corrected(&[0.5])[0].is_finite());
    assert!(homogeneous.error(homogeneous.mean(Tracked::corrected)) < MONTE_CARLO);
}
