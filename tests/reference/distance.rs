//! Distance sampling along an edge: where the chromatic σ_t differs per channel, the cdf is the mean of the channels' cdfs,
//! so that one number gives one distance and back.
//!
//! For a single channel the density is that of [Lu20 (31)], σ_t(x) exp(−τ).

use super::{
    optical_depth::{optical_depth_until, pieces},
    segments::Edge,
    vector::*,
    world::World,
};

fn mean(c: Rgb) -> f64 {
    (c[0] + c[1] + c[2]) / 3.0
}

/// Probability of a collision before distance t: the mean of 1 − exp(−τ_c(t)).
pub fn distance_cdf(world: &World, edge: &Edge, t: f64) -> f64 {
    mean(optical_depth_until(world, edge, t).map(|tau| -(-tau).exp_m1()))
}

/// Its derivative, the mean of σ_t,c·exp(−τ_c); zero before the near plane.
pub fn distance_pdf(world: &World, edge: &Edge, t: f64) -> f64 {
    let tau = optical_depth_until(world, edge, t);
    let pieces = pieces(world, edge);
    let piece = pieces.iter().find(|piece| t <= piece.end).expect("t is on the edge");
    let sigma = piece.sigma_t(edge.point(t));
    mean([0, 1, 2].map(|c| sigma[c] * (-tau[c]).exp()))
}

/// The distance t at which the cdf is `u`, by bisection down to neighbouring floating-point numbers; `None` if the edge
/// ends, or its media end, before that.
pub fn invert_distance_cdf(world: &World, edge: &Edge, u: f64) -> Option<f64> {
    let mut low = 0.0;
    let mut high = upper_bound(world, edge, u)?;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return Some(high);
        }
        if distance_cdf(world, edge, middle) < u {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// A distance at which the cdf is at least `u`.
fn upper_bound(world: &World, edge: &Edge, u: f64) -> Option<f64> {
    let mut high =
        pieces(world, edge).iter().flat_map(|piece| [piece.begin, piece.end]).filter(|t| t.is_finite()).fold(0.0, f64::max);
    if distance_cdf(world, edge, edge.length) < u {
        return None;
    }
    // A medium that goes on to infinity reaches any u < 1 somewhere.
    while u < 1.0 && distance_cdf(world, edge, high) < u {
        high = 2.0 * high + 1.0;
    }
    (distance_cdf(world, edge, high) >= u).then_some(high)
}
