//! Milestones along a line through a grid: where its integral is known, so that each of many distances is found from near.

use super::cell::Chords;
use super::dda::LatticeLine;
use super::tracking::{Flight, find_collision, scaled};
use super::walk::Visitor;
use super::{Density, Inversion, Line, Medium, Stretch};
use crate::math::Colour;
use core::ops::ControlFlow;

/// Most of a line.
const MOST: usize = 16;

/// The density integral at some distances along one stretch of a line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Milestones {
    /// The stretch is the line's that begins here, and ends, or leaves the grid, there.
    start: f64,
    end: f64,
    /// The integral over all of it.
    total: f64,
    /// Distances from the line's origin, and the integrals from the stretch's start.
    distances: [f64; MOST],
    integrals: [f64; MOST],
    count: usize,
}

impl Milestones {
    /// Those of the first stretch that is in a grid; and τ of the whole line, as [`optical_depth`](super::optical_depth) has it.
    pub fn along(line: &Line) -> (Self, Colour) {
        let (mut milestones, mut optical_depth) = (Self::default(), Colour::ZERO);
        for (stretch, segment) in line.stretches() {
            let Some(medium) = line.medium(segment.medium) else { continue };
            let integral = match &medium.density {
                Density::Grid(grid) if milestones.count == 0 => {
                    milestones.start = stretch.start;
                    milestones.total = grid.integral_with_milestones(&stretch, &mut milestones);
                    milestones.total
                }
                density => density.integral(&stretch),
            };
            optical_depth += scaled(medium.sigma_t, integral);
        }
        (milestones, optical_depth)
    }

    /// What [`sample_distance`](super::sample_distance) finds along the line that they are along.
    pub fn sample_distance(&self, line: &Line, u: f64) -> Flight {
        find_collision(line, u, |medium, stretch, target| self.invert(medium, stretch, target))
    }

    fn invert(&self, medium: &Medium, stretch: &Stretch, target: f64) -> Inversion {
        let known = self.count.min(MOST);
        // Of 0 the first density decides that there is, whatever the integrals.
        if known == 0 || stretch.start != self.start || target == 0.0 {
            return medium.density.invert(stretch, target);
        }
        if !(target <= self.total) {
            return Inversion::Beyond(self.total);
        }
        let next = self.integrals[..known].partition_point(|integral| *integral < target);
        let place = |i: usize| Some((*self.distances.get(i)?, *self.integrals.get(i)?)).filter(|_| i < known);
        let (start, before) = next.checked_sub(1).and_then(place).unwrap_or((stretch.start, 0.0));
        let end = place(next).map_or(self.end, |(distance, _)| distance);
        match medium.density.invert(&Stretch { start, end, ..*stretch }, target - before) {
            // But for rounding it would be before that.
            Inversion::Beyond(_) => Inversion::At(end),
            found => found,
        }
    }

    fn push(&mut self, distance: f64, integral: f64) {
        if let (Some(t), Some(sum)) = (self.distances.get_mut(self.count), self.integrals.get_mut(self.count)) {
            (*t, *sum) = (distance, integral);
            self.count += 1;
        }
    }
}

/// ∫ ρ dt, which sets milestones on its way.
pub(super) struct Survey<'m> {
    pub total: f64,
    to: &'m mut Milestones,
    /// Where the next one is due, and how far they are apart.
    due: f64,
    apart: f64,
}

impl<'m> Survey<'m> {
    /// Of what is between `start` and `end`.
    pub fn new(to: &'m mut Milestones, start: f64, end: f64) -> Self {
        let apart = (end - start) / MOST as f64;
        to.end = end;
        Self { total: 0.0, to, due: start + apart, apart }
    }

    #[inline(always)]
    fn pass(&mut self, t: f64) {
        if t >= self.due {
            self.to.push(t, self.total);
            self.due = t + self.apart;
        }
    }
}

impl Visitor for Survey<'_> {
    fn constant(&mut self, density: f64, start: f64, end: f64) -> ControlFlow<f64> {
        self.total += density * (end - start);
        self.pass(end);
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn cells(&mut self, line: &LatticeLine, chords: &Chords) -> ControlFlow<f64> {
        self.total += chords.integrals(line).element_sum();
        self.pass(chords.end.y);
        ControlFlow::Continue(())
    }
}
