//! Ray marching: the midpoint rule, or the same with all points moved by one random share of a step; and the exact gradient of that sum.
//! Source: [JDZJ08].
//!
//! Every medium on the way is marched from border to border, so no point ever crosses a face when an end of the line moves. The midpoint
//! rule's τ is off by O(step²) for smooth densities; jittered, τ has no bias, but T̂ = exp(−τ̂) has: about +½·T·Var(τ̂).

use super::{Border, Crossing, Estimate, MAX_EVALUATIONS, across, crossings};
use crate::math::{Colour, DVec3, transmittance};
use crate::medium::Line;
use crate::medium::tracking::scaled;

pub fn estimate(line: &Line, steps: u32, jitter: bool, mut random: impl FnMut() -> f64) -> Option<Estimate> {
    let place = if jitter { random() } else { 0.5 };
    let (mut tau, mut gradient) = (Colour::ZERO, [Ends::default(); 3]);
    let mut evaluations = 0;
    for crossing in crossings(line) {
        // A constant density is known after one step.
        let constant = crossing.extent.min == crossing.extent.max;
        let count = if constant { 1 } else { steps };
        evaluations = count.saturating_add(evaluations);
        if f64::from(evaluations) > MAX_EVALUATIONS {
            return None;
        }
        let sum = march(line, &crossing, count, place);
        let sigma_t = crossing.medium.sigma_t;
        tau += scaled(sigma_t, sum.integral);
        for c in 0..3 {
            gradient[c] = gradient[c].plus(&sum.gradient, sigma_t[c]);
        }
    }
    let t = transmittance(tau);
    Some(Estimate {
        transmittance: t,
        near_gradient: core::array::from_fn(|c| -t[c] * gradient[c].near),
        far_gradient: core::array::from_fn(|c| -t[c] * gradient[c].far),
        evaluations,
    })
}

/// A gradient with respect to either end of a line.
#[derive(Clone, Copy, Default)]
struct Ends {
    near: DVec3,
    far: DVec3,
}

impl Ends {
    fn plus(&self, other: &Self, factor: f64) -> Self {
        Self { near: self.near + factor * other.near, far: self.far + factor * other.far }
    }
}

struct Sum {
    integral: f64,
    gradient: Ends,
}

/// The sum over one medium: width·Σ ρ(x_k), x_k = origin + t_k·direction, t_k = (1 − f_k)·start + f_k·end, and how all of it changes.
fn march(line: &Line, Crossing { medium, extent, borders }: &Crossing, count: u32, place: f64) -> Sum {
    let share = 1.0 / f64::from(count);
    let width = (extent.end - extent.start) * share;
    if width.is_infinite() {
        // Nothing arrives, wherever the ends are; or there is no extinction.
        return Sum { integral: width, gradient: Ends::default() };
    }
    let (start, end) = (slide(line, borders[0], extent.start), slide(line, borders[1], extent.end));
    let (mut value, mut change) = (0.0, Ends::default());
    for k in 0..count {
        let f = (f64::from(k) + place) * share;
        let t = extent.start * (1.0 - f) + extent.end * f;
        let x = line.origin + t * line.direction;
        let slope = medium.density.gradient(x);
        let along = slope.dot(line.direction);
        // The point moves with the line, most next to the end that moves, and along it with the borders.
        let turned = if line.length.is_finite() { t / line.length * across(line.direction, slope) } else { DVec3::ZERO };
        change = change.plus(&start, along * (1.0 - f)).plus(&end, along * f);
        change = change.plus(&Ends { near: slope - turned, far: turned }, 1.0);
        value += medium.density.at(x);
    }
    let stretched = Ends::default().plus(&end, value * share).plus(&start, -value * share);
    Sum { integral: width * value, gradient: stretched.plus(&change, width) }
}

/// How the distance `t` of a border changes when an end of the line moves. A face stays where it is: n·(origin + t·direction) is constant.
fn slide(line: &Line, border: Border, t: f64) -> Ends {
    match border {
        Border::Origin => Ends::default(),
        Border::End => Ends { near: -line.direction, far: line.direction },
        Border::Face(normal) => {
            let normal = normal / normal.dot(line.direction);
            let turned = if line.length.is_finite() { t / line.length * across(line.direction, normal) } else { DVec3::ZERO };
            Ends { near: turned - normal, far: -turned }
        }
    }
}
