//! Ratio tracking, T̂ = Π_j w_j with w_j = 1 − σ(t_j)/σ̄ over the points t_j of a Poisson process of rate σ̄, and residual ratio tracking,
//! in which a constant part of the density counts in closed form. Source: [NSJ14].
//!
//! Unbiased gradients: over such a process the mean of Σ_j b(t_j) Π_{k≠j} w_k is T·∫ σ̄ b dt. With b = ∇σ/σ̄ and t·∇σ/σ̄ this estimates
//! T·∫∇σ and T·∫t∇σ, all that ∇τ needs (see [`EdgeMoments`]). The product rule makes the leave-one-out products collision by
//! collision: no division, so nothing is singular at σ = σ̄, and no list of collisions. Faces are where they are, so their jumps count
//! exactly, times T̂. Along the line ∇τ is known without integral: σ at the far end, −σ at the near one.
//! Differs from [Lu20 (21)]: there σ_avg comes from the same collisions as T̂, and Π_{k≠j} w_k is T̂/w_j.
//!
//! A chromatic medium's channels share the collisions, whose rate is the majorant of its largest channel.

use super::{Border, Crossing, Estimate, MAX_EVALUATIONS, across, crossings};
use crate::math::{Colour, DVec3, log1p, transmittance};
use crate::medium::tracking::{add_face, scaled};
use crate::medium::{EdgeMoments, Line};

pub fn estimate(line: &Line, residual: bool, mut random: impl FnMut() -> f64) -> Option<Estimate> {
    let mut walk = Walk::default();
    let mut expected = 0.0;
    for crossing in crossings(line) {
        let majorant = Majorant::new(&crossing, residual);
        expected += majorant.collisions(&crossing);
        if !(expected <= MAX_EVALUATIONS) {
            return None;
        }
        walk.count_borders(line, &crossing);
        walk.track(line, &crossing, &majorant, &mut random);
    }
    Some(walk.finish(line))
}

/// How one medium is tracked.
struct Majorant {
    /// The density that counts in closed form.
    control: f64,
    /// Collisions per world unit: the largest channel's bound of the rest.
    rate: f64,
}

impl Majorant {
    fn new(Crossing { medium, extent, .. }: &Crossing, residual: bool) -> Self {
        // A constant density has nothing to track.
        let control = if residual || extent.min == extent.max { extent.min } else { 0.0 };
        Self { control, rate: medium.sigma_t.max_element() * (extent.max - control) }
    }

    fn collisions(&self, Crossing { extent, .. }: &Crossing) -> f64 {
        if self.rate > 0.0 { self.rate * (extent.end - extent.start) } else { 0.0 }
    }
}

/// What has been found so far.
struct Walk {
    transmittance: Colour,
    /// Estimates of T·∫∇σ and T·∫t∇σ, without faces.
    gradient: [DVec3; 3],
    first_moment: [DVec3; 3],
    faces: EdgeMoments,
    /// σ_t at the line's ends.
    at_origin: Colour,
    at_end: Colour,
    evaluations: u32,
}

impl Default for Walk {
    fn default() -> Self {
        Self {
            transmittance: Colour::ONE,
            gradient: [DVec3::ZERO; 3],
            first_moment: [DVec3::ZERO; 3],
            faces: EdgeMoments::default(),
            at_origin: Colour::ZERO,
            at_end: Colour::ZERO,
            evaluations: 0,
        }
    }
}

impl Walk {
    /// σ_t at the ends of a crossing: it jumps there, or the line ends.
    fn count_borders(&mut self, line: &Line, Crossing { medium, extent, borders }: &Crossing) {
        let inside = [medium.sigma_t * extent.at_start, medium.sigma_t * extent.at_end];
        let jumps = [(Colour::ZERO, inside[0]), (inside[1], Colour::ZERO)];
        for (i, t) in [extent.start, extent.end].into_iter().enumerate() {
            match borders[i] {
                Border::Origin => self.at_origin = inside[i],
                Border::End => self.at_end = inside[i],
                Border::Face(normal) => add_face(&mut self.faces, line.direction, t, normal, jumps[i].0, jumps[i].1),
            }
        }
        self.evaluations += 2;
    }

    fn track(&mut self, line: &Line, crossing: &Crossing, majorant: &Majorant, random: &mut impl FnMut() -> f64) {
        let Crossing { medium, extent, .. } = crossing;
        let control = transmittance(scaled(medium.sigma_t, majorant.control * (extent.end - extent.start)));
        self.multiply(control);
        if !(majorant.rate > 0.0) {
            return;
        }
        let share = medium.sigma_t / majorant.rate;
        let mut t = extent.start;
        loop {
            t -= log1p(-random()) / majorant.rate;
            if !(t < extent.end) {
                return;
            }
            let x = line.origin + t * line.direction;
            let slope = across(line.direction, medium.density.gradient(x));
            self.collide(t, Colour::ONE - share * (medium.density.at(x) - majorant.control), share, slope);
        }
    }

    /// Everything so far, times a factor that does not depend on where the line's ends are.
    fn multiply(&mut self, factor: Colour) {
        self.transmittance *= factor;
        for c in 0..3 {
            self.gradient[c] *= factor[c];
            self.first_moment[c] *= factor[c];
        }
    }

    /// A collision of this weight, whose derivative is −share·slope: (T·w)' = T'·w + T·w'.
    fn collide(&mut self, t: f64, weight: Colour, share: Colour, slope: DVec3) {
        let before = self.transmittance;
        self.multiply(weight);
        for c in 0..3 {
            let change = before[c] * share[c] * slope;
            self.gradient[c] += change;
            self.first_moment[c] += t * change;
        }
        self.evaluations += 1;
    }

    fn finish(&self, line: &Line) -> Estimate {
        let Line { direction, length, .. } = *line;
        let finite = length.is_finite();
        let mut edge = EdgeMoments::default();
        for c in 0..3 {
            let t = self.transmittance[c];
            let along = |sigma: f64| t * sigma * direction;
            edge.gradient[c] = self.gradient[c] + t * across(direction, self.faces.gradient[c]);
            edge.gradient[c] += along(self.at_end[c] - self.at_origin[c]);
            // ûτ + ∫tσ'û = û·length·σ(end): so there is no optical depth to add to it.
            edge.first_moment[c] = self.first_moment[c] + t * across(direction, self.faces.first_moment[c]);
            edge.first_moment[c] += if finite { length * along(self.at_end[c]) } else { DVec3::ZERO };
        }
        let far = if finite { edge.far_gradient(direction, length) } else { [DVec3::ZERO; 3] };
        Estimate {
            transmittance: self.transmittance,
            near_gradient: edge.near_gradient(direction, length).map(|g| -g),
            far_gradient: far.map(|g| -g),
            evaluations: self.evaluations,
        }
    }
}
