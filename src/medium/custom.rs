//! A density that the host computes point by point. What the host's function is integrated with defines its optical depth:
//!
//! A line's chord through the medium's box is cut into equal *panels*, no longer than a given step, and the density counts as linear
//! in each. So the rule belongs to the line, not to the part of it that is asked for. τ adds up exactly where an edge is divided, is
//! the same from either end, and sampling inverts it exactly, with pdf = σ̃_t·exp(−τ), σ̃ being that piecewise linear function. The
//! true density counts wherever a vertex scatters, which makes estimates unbiased for the medium of this τ as long as σ̃ > 0 where
//! σ_s > 0: the step must resolve the density.
//!
//! Errors: τ is off by no more than step²/12·∫|ρ''|. Along the line ∇τ is the exact derivative of this τ; across it, ∇ρ is integrated
//! by the same rule, with an error of the same order, or of first order where ∇ρ jumps.

use super::{Extent, Inversion, Moments, Stretch};
use crate::math::{DAffine3, DVec3, floor, sqrt};
use core::fmt::Debug;
use core::ops::ControlFlow;

/// A density as the host computes it, a function of the point alone. Values that are NaN, infinite or negative count as 0.
pub trait DensityField: Debug + Sync {
    /// Fills `densities`, as long as `points`.
    fn densities(&self, points: &[DVec3], densities: &mut [f64]);
    /// Fills `gradients`, as long as `points`, 1/world unit.
    fn gradients(&self, points: &[DVec3], gradients: &mut [DVec3]);
}

/// One whose line integrals the host has too.
pub trait IntegratedField: DensityField {
    /// Integrals of ρ, and if asked for of ∇ρ and t·∇ρ, along a stretch inside the box, exactly; the ends are left out.
    fn moments(&self, stretch: &Stretch, gradients: bool) -> Moments;
}

/// A density field inside a box, 0 outside.
#[derive(Clone, Copy, Debug)]
pub struct Custom<'a> {
    pub(super) field: &'a dyn DensityField,
    /// To where the box is the unit cube.
    pub(super) to_box: DAffine3,
    pub(super) step: f64,
    pub(super) majorant: f64,
    /// The same field, if the host integrates it: medium/exact.rs.
    pub(super) exact: Option<&'a dyn IntegratedField>,
}

/// Panels along the longest chord of a box.
const MAX_PANELS: f64 = 1_048_576.0;

/// Points that are asked for at a time: enough to make a callback cheap, few enough for the stack.
const BATCH: usize = 32;

/// How far the number of panels may be above a whole one and still count as that: what rounding makes of it must not depend on the end
/// that a line is seen from.
const WHOLE: f64 = 1e-9;

impl<'a> Custom<'a> {
    /// `box_to_world` maps the unit cube and is invertible; `step` > 0 in world units; `majorant` ≥ every density in the box. None if
    /// the step is too small for the box.
    pub fn new(field: &'a dyn DensityField, box_to_world: DAffine3, step: f64, majorant: f64) -> Option<Self> {
        let m = box_to_world.matrix3;
        let longest = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
        (longest / step <= MAX_PANELS).then(|| Self { field, to_box: box_to_world.inverse(), step, majorant, exact: None })
    }

    /// Whether the host integrates it.
    pub fn is_exact(&self) -> bool {
        self.exact.is_some()
    }

    pub fn at(&self, x: DVec3) -> f64 {
        if self.holds(x) { self.value(x) } else { 0.0 }
    }

    pub fn gradient(&self, x: DVec3) -> DVec3 {
        if !self.holds(x) {
            return DVec3::ZERO;
        }
        let mut gradient = [DVec3::ZERO];
        self.read_gradients(&[x], &mut gradient);
        gradient[0]
    }

    pub fn integral(&self, stretch: &Stretch) -> f64 {
        if let Some(field) = self.exact {
            return self.exact_integral(field, stretch);
        }
        let mut total = 0.0;
        let _ = self.walk(stretch, false, |panel| {
            total += panel.integral();
            ControlFlow::<()>::Continue(())
        });
        total
    }

    pub fn invert(&self, stretch: &Stretch, target: f64) -> Inversion {
        if let Some(field) = self.exact {
            return self.exact_invert(field, stretch, target);
        }
        let mut total = 0.0;
        let found = self.walk(stretch, false, |panel| {
            let here = panel.integral();
            if here > 0.0 && total + here >= target {
                return ControlFlow::Break(panel.solve(target - total));
            }
            total += here;
            ControlFlow::Continue(())
        });
        match found {
            ControlFlow::Break(t) => Inversion::At(t),
            ControlFlow::Continue(()) => Inversion::Beyond(total),
        }
    }

    /// The density whose integral τ is, at the distance `t`.
    pub fn along(&self, stretch: &Stretch, t: f64) -> f64 {
        if self.exact.is_some() {
            return self.value(stretch.origin + t * stretch.direction);
        }
        let mut value = 0.0;
        let _ = self.walk(&Stretch { start: t.next_down(), end: t.next_up(), ..*stretch }, false, |panel| {
            value = panel.value(t);
            ControlFlow::Break(())
        });
        value
    }

    pub fn moments(&self, stretch: &Stretch) -> Moments {
        if let Some(field) = self.exact {
            return self.exact_moments(field, stretch);
        }
        let mut sum = Moments::default();
        let Some(chord) = self.chord(stretch) else { return sum };
        let (mut first, mut last) = (None, 0.0);
        let _ = self.walk(stretch, true, |panel| {
            panel.add_moments(stretch.direction, &mut sum);
            first.get_or_insert(panel.value(panel.start));
            last = panel.value(panel.end);
            ControlFlow::<()>::Continue(())
        });
        chord.add_faces(stretch, [first.unwrap_or(0.0), last], &mut sum);
        sum
    }

    pub fn extent(&self, stretch: &Stretch) -> Option<Extent> {
        let chord = self.chord(stretch)?;
        let (start, end) = chord.clip(stretch);
        let at = |t: f64| self.value(stretch.origin + t * stretch.direction);
        (start < end).then(|| Extent {
            start,
            end,
            entry: chord.entry_within(stretch),
            exit: chord.exit_within(stretch),
            at_start: at(start),
            at_end: at(end),
            min: 0.0,
            max: self.majorant,
        })
    }

    fn holds(&self, x: DVec3) -> bool {
        let p = self.to_box.transform_point3(x);
        p.cmpge(DVec3::ZERO).all() && p.cmple(DVec3::ONE).all()
    }

    pub(super) fn value(&self, x: DVec3) -> f64 {
        let mut density = [0.0];
        self.read_densities(&[x], &mut density);
        density[0]
    }

    fn read_densities(&self, points: &[DVec3], densities: &mut [f64]) {
        self.field.densities(points, densities);
        densities.iter_mut().filter(|d| !(**d > 0.0 && d.is_finite())).for_each(|d| *d = 0.0);
    }

    fn read_gradients(&self, points: &[DVec3], gradients: &mut [DVec3]) {
        self.field.gradients(points, gradients);
        gradients.iter_mut().filter(|g| !g.is_finite()).for_each(|g| *g = DVec3::ZERO);
    }

    /// What the box cuts out of the whole line, however long the stretch is.
    pub(super) fn chord(&self, stretch: &Stretch) -> Option<Chord> {
        let origin = self.to_box.transform_point3(stretch.origin);
        let direction = self.to_box.transform_vector3(stretch.direction);
        let (mut start, mut end, mut entry, mut exit) = (f64::NEG_INFINITY, f64::INFINITY, 0, 0);
        for axis in 0..3 {
            let (origin, direction) = (origin[axis], direction[axis]);
            if direction == 0.0 {
                if !(0.0..=1.0).contains(&origin) {
                    return None;
                }
                continue;
            }
            let (a, b) = (-origin / direction, (1.0 - origin) / direction);
            if a.min(b) > start {
                (start, entry) = (a.min(b), axis);
            }
            if a.max(b) < end {
                (end, exit) = (a.max(b), axis);
            }
        }
        // Nor if a line has no direction, or a number that is none: hosts are asked for finite points only.
        if !(start < end && (end - start).is_finite()) {
            return None;
        }
        let panels = -floor(WHOLE - (end - start) / self.step);
        let normal = |axis| self.to_box.matrix3.row(axis);
        Some(Chord { start, end, panels: panels.max(1.0), entry: normal(entry), exit: normal(exit) })
    }

    /// Visits the panels that a stretch passes, in order.
    fn walk<B>(&self, stretch: &Stretch, gradients: bool, mut visit: impl FnMut(&Panel) -> ControlFlow<B>) -> ControlFlow<B> {
        let Some(chord) = self.chord(stretch) else { return ControlFlow::Continue(()) };
        let (start, end) = chord.clip(stretch);
        if !(start < end) {
            return ControlFlow::Continue(());
        }
        let panel_of =
            |t: f64| floor((t - chord.start) / (chord.end - chord.start) * chord.panels).max(0.0).min(chord.panels - 1.0);
        let (mut next, last) = (panel_of(start) as usize, panel_of(end) as usize);
        while next <= last {
            let count = (last + 1 - next).min(BATCH - 1);
            let (mut ends, mut points) = ([0.0; BATCH], [DVec3::ZERO; BATCH]);
            for i in 0..=count {
                ends[i] = chord.node(next + i);
                points[i] = stretch.origin + ends[i] * stretch.direction;
            }
            let (mut densities, mut slopes) = ([0.0; BATCH], [DVec3::ZERO; BATCH]);
            self.read_densities(&points[..=count], &mut densities[..=count]);
            if gradients {
                self.read_gradients(&points[..=count], &mut slopes[..=count]);
            }
            for i in 0..count {
                let panel = Panel {
                    nodes: [ends[i], ends[i + 1]],
                    density: [densities[i], densities[i + 1]],
                    gradient: [slopes[i], slopes[i + 1]],
                    start: ends[i].max(start),
                    end: ends[i + 1].min(end),
                };
                if panel.start < panel.end {
                    visit(&panel)?;
                }
            }
            next += count;
        }
        ControlFlow::Continue(())
    }
}

/// The jump of ρ by `jump` at a face: ∇ρ holds −(ρ_before − ρ_after) δ n/(n·direction).
fn add_face(sum: &mut Moments, direction: DVec3, t: f64, normal: DVec3, jump: f64) {
    let jump = jump * normal / normal.dot(direction);
    sum.gradient += jump;
    sum.first_moment += t * jump;
}

/// A whole line's part inside the box, and the normals of the faces where it enters and leaves.
pub(super) struct Chord {
    start: f64,
    end: f64,
    /// A whole number.
    panels: f64,
    entry: DVec3,
    exit: DVec3,
}

impl Chord {
    fn node(&self, index: usize) -> f64 {
        let share = index as f64 / self.panels;
        self.start * (1.0 - share) + self.end * share
    }

    pub(super) fn clip(&self, stretch: &Stretch) -> (f64, f64) {
        (self.start.max(stretch.start), self.end.min(stretch.end))
    }

    fn entry_within(&self, stretch: &Stretch) -> Option<DVec3> {
        (self.start > stretch.start).then_some(self.entry)
    }

    fn exit_within(&self, stretch: &Stretch) -> Option<DVec3> {
        (self.end < stretch.end).then_some(self.exit)
    }

    /// The box's own faces, where ρ jumps from 0 to the first density inside and back from the last, if the stretch crosses them.
    pub(super) fn add_faces(&self, stretch: &Stretch, [first, last]: [f64; 2], sum: &mut Moments) {
        let (start, end) = self.clip(stretch);
        match self.entry_within(stretch) {
            Some(normal) => add_face(sum, stretch.direction, start, normal, first),
            None => sum.at_start = first,
        }
        match self.exit_within(stretch) {
            Some(normal) => add_face(sum, stretch.direction, end, normal, -last),
            None => sum.at_end = last,
        }
    }
}

/// A stretch of the chord between two nodes, between which density and gradient are linear, and the part of it that counts.
struct Panel {
    nodes: [f64; 2],
    density: [f64; 2],
    gradient: [DVec3; 2],
    start: f64,
    end: f64,
}

impl Panel {
    fn slope(&self) -> f64 {
        (self.density[1] - self.density[0]) / (self.nodes[1] - self.nodes[0])
    }

    fn value(&self, t: f64) -> f64 {
        // A mean of two densities: never negative.
        let share = ((t - self.nodes[0]) / (self.nodes[1] - self.nodes[0])).clamp(0.0, 1.0);
        self.density[0] * (1.0 - share) + self.density[1] * share
    }

    fn integral(&self) -> f64 {
        (self.end - self.start) * self.value(0.5 * (self.start + self.end))
    }

    fn add_moments(&self, direction: DVec3, sum: &mut Moments) {
        let across = |v: DVec3| v - v.dot(direction) * direction;
        let (length, middle) = (self.end - self.start, 0.5 * (self.start + self.end));
        let share = (middle - self.nodes[0]) / (self.nodes[1] - self.nodes[0]);
        let change = across(self.gradient[1] - self.gradient[0]);
        let gradient = across(self.gradient[0]) + share * change + self.slope() * direction;
        sum.integral += self.integral();
        sum.gradient += length * gradient;
        // ∫ t² about the middle is length³/12.
        let spread = length * length / (12.0 * (self.nodes[1] - self.nodes[0]));
        sum.first_moment += length * (middle * gradient + spread * change);
    }

    /// The t at which ∫ ρ from the start is `target`: the root of a quadratic, written without cancellation.
    fn solve(&self, target: f64) -> f64 {
        if !(target > 0.0) {
            return self.start;
        }
        let (value, slope) = (self.value(self.start), self.slope());
        let root = sqrt((value * value + 2.0 * slope * target).max(0.0));
        (self.start + 2.0 * target / (value + root)).min(self.end)
    }
}
