//! Gradients by finite differences: central differences at shrinking steps, extrapolated to step zero (Ridders' method),
//! keeping the extrapolation that agrees best with the ones it comes from.
//!
//! Differences see a kink if a moving edge meets its planes in another order within a step: [`is_smooth`] says whether.

use super::{
    contribution::{Contribution, contribution},
    factors::{FACTORS, Factors},
    medium::Medium,
    optical_depth::pieces,
    path::Path,
    vector::*,
    world::World,
};

/// The first step, small against the distances between vertices (0.3 and more) and the width of a forward peak.
const FIRST_STEP: f64 = 5e-4;
/// Step k is FIRST_STEP/2^k; the last, 3e-5, still leaves ten digits in a logarithm of order 1.
const STEPS: usize = 5;

/// Derivative by t at t = 0 of each component of `f`.
pub fn derivative<const N: usize>(f: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    let central = |k: usize| {
        let h = FIRST_STEP / (1 << k) as f64;
        let (plus, minus) = (f(h), f(-h));
        core::array::from_fn::<f64, N, _>(|i| (plus[i] - minus[i]) / (2.0 * h))
    };
    let by_step: [[f64; N]; STEPS] = core::array::from_fn(central);
    core::array::from_fn(|i| extrapolate(core::array::from_fn(|k| by_step[k][i])))
}

/// Richardson: an estimate with error ~ h^(2m) at two steps gives one with error ~ h^(2m+2).
fn extrapolate(central: [f64; STEPS]) -> f64 {
    let mut best = central[STEPS - 1];
    let mut best_error = f64::INFINITY;
    let mut coarser_row = vec![central[0]];
    for &finer in &central[1..] {
        let mut row = vec![finer];
        for m in 0..coarser_row.len() {
            let power = 4_f64.powi(m as i32 + 1);
            let estimate = (power * row[m] - coarser_row[m]) / (power - 1.0);
            let error = (estimate - row[m]).abs().max((estimate - coarser_row[m]).abs());
            if error < best_error {
                (best, best_error) = (estimate, error);
            }
            row.push(estimate);
        }
        coarser_row = row;
    }
    best
}

/// The gradient of each component of a function of a point.
pub fn gradient<const N: usize>(f: impl Fn(Vec3) -> [f64; N], x: Vec3) -> [Vec3; N] {
    let by_axis = [0, 1, 2].map(|axis| {
        derivative(|t| {
            let mut moved = x;
            moved[axis] += t;
            f(moved)
        })
    });
    core::array::from_fn(|i| [by_axis[0][i], by_axis[1][i], by_axis[2][i]])
}

/// Logarithms of the factors that change when x_i moves.
pub fn log_factors(world: &World, path: &Path, i: usize) -> Factors<f64> {
    factors_at(&contribution(world, path), i)
}

fn factors_at(f: &Contribution, i: usize) -> Factors<f64> {
    // The channels of σ_s and f_r have constant ratios: any that is not black has the same gradient.
    let brightest = |c: Rgb| c.into_iter().fold(0.0, f64::max).ln();
    let is_last = i + 2 == f.profile.len();
    let next = if is_last { f.emission } else { f.profile[i + 1] };
    Factors {
        scattering: brightest(f.scattering[i]),
        transmittance_prev: f.transmittance[i - 1].map(f64::ln),
        transmittance_next: f.transmittance[i].map(f64::ln),
        geometry_prev: f.geometry[i - 1].ln(),
        geometry_next: f.geometry[i].ln(),
        importance: f.importance.ln(),
        profile_prev: f.profile[i - 1].map(f64::ln),
        phase_apex: brightest(f.profile[i]),
        profile_next: next.map(f64::ln),
    }
}

/// What [`super::gradient::log_gradient`] must be equal to.
#[derive(Clone, Copy, Debug)]
pub struct Differences {
    pub factors: Factors<Vec3>,
    /// ∇ log f per channel, from f itself and not from the factors.
    pub totals: RgbGradient,
    /// ∇ log luminance(f).
    pub luminance: Vec3,
}

/// ∇ log f with respect to x_i, by differences.
pub fn difference_gradient(world: &World, path: &Path, i: usize) -> Differences {
    let logarithms = |offset: Vec3| -> [f64; FACTORS + 4] {
        let f = contribution(world, &path.moved(i, i, offset));
        let factors = factors_at(&f, i).to_array();
        let total = f.total();
        let totals = [total[0].ln(), total[1].ln(), total[2].ln(), luminance(total).ln()];
        core::array::from_fn(|n| if n < FACTORS { factors[n] } else { totals[n - FACTORS] })
    };
    let g = gradient(logarithms, ZERO);
    Differences {
        factors: Factors::from_array(core::array::from_fn(|n| g[n])),
        totals: [g[FACTORS], g[FACTORS + 1], g[FACTORS + 2]],
        luminance: g[FACTORS + 3],
    }
}

/// ∇ log f per channel when the run `first..=last` moves rigidly, by differences.
pub fn run_difference_gradient(world: &World, path: &Path, first: usize, last: usize) -> RgbGradient {
    gradient(|offset| contribution(world, &path.moved(first, last, offset)).total().map(f64::ln), ZERO)
}

/// Do the edges of the path cross the same planes in the same order wherever differences move the run `first..=last`?
/// If not, a kink of τ (an edge of a box, or one between cells) is so near that differences are no judge of a gradient.
pub fn is_smooth(world: &World, path: &Path, first: usize, last: usize) -> bool {
    let here = crossed(world, path, first, last);
    (0..6).all(|n| {
        let mut offset = ZERO;
        offset[n % 3] = if n < 3 { FIRST_STEP } else { -FIRST_STEP };
        crossed(world, &path.moved(first, last, offset), first, last) == here
    })
}

/// Medium and final face of each piece of the edges that touch the run `first..=last`.
fn crossed(world: &World, path: &Path, first: usize, last: usize) -> Vec<(Option<*const Medium>, Option<Vec3>)> {
    // Where two faces coincide, rounding decides whether there is a piece between them.
    const NOTHING: f64 = 1e-12;
    let edges = (first - 1..=last).map(|i| path.edge(world, i));
    let pieces = edges.flat_map(|edge| pieces(world, &edge)).filter(|piece| piece.end - piece.begin > NOTHING);
    pieces.map(|piece| (piece.medium.map(|m| m as *const Medium), piece.face_normal)).collect()
}
