//! A custom density whose line integrals the host has too: exact τ instead of panels. Its box is still a face: what jumps there is added
//! here, the host integrates between.

use super::custom::{Custom, IntegratedField};
use super::{Inversion, Moments, Stretch};
use crate::math::{DAffine3, DVec3, positive_or_zero};
use core::ops::Range;

/// Halvings that take any bracket to neighbouring numbers; Newton's steps need some five.
const MOST_STEPS: u32 = 100;

impl<'a> Custom<'a> {
    /// As [`Custom::new`], without its step.
    pub fn exact(field: &'a dyn IntegratedField, box_to_world: DAffine3, majorant: f64) -> Self {
        Self { field, to_box: box_to_world.inverse(), step: f64::INFINITY, majorant, exact: Some(field) }
    }

    pub(super) fn exact_integral(&self, field: &dyn IntegratedField, stretch: &Stretch) -> f64 {
        self.inside(stretch).map_or(0.0, |range| between(field, stretch, range))
    }

    /// The root of ∫ρ − target, bracketed: Newton's step where it stays inside, else the middle.
    pub(super) fn exact_invert(&self, field: &dyn IntegratedField, stretch: &Stretch, target: f64) -> Inversion {
        let Some(Range { start, end }) = self.inside(stretch) else { return Inversion::Beyond(0.0) };
        let total = between(field, stretch, start..end);
        if !(total >= target && total > 0.0) {
            return Inversion::Beyond(total);
        }
        let (mut low, mut high) = (start, end);
        let mut t = start + (end - start) * (target / total);
        for _ in 0..MOST_STEPS {
            let error = between(field, stretch, start..t) - target;
            if error > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - error / self.value(stretch.origin + t * stretch.direction);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if error == 0.0 || (next - t).abs() <= f64::EPSILON * t.abs() {
                break;
            }
            t = next;
        }
        Inversion::At(t)
    }

    pub(super) fn exact_moments(&self, field: &dyn IntegratedField, stretch: &Stretch) -> Moments {
        let mut sum = Moments::default();
        let Some(chord) = self.chord(stretch) else { return sum };
        let Some(Range { start, end }) = self.inside(stretch) else { return sum };
        let inside = field.moments(&Stretch { start, end, ..*stretch }, true);
        let finite = |v: DVec3| if v.is_finite() { v } else { DVec3::ZERO };
        sum.integral = positive_or_zero(inside.integral);
        (sum.gradient, sum.first_moment) = (finite(inside.gradient), finite(inside.first_moment));
        let at = |t: f64| self.value(stretch.origin + t * stretch.direction);
        chord.add_faces(stretch, [at(start), at(end)], &mut sum);
        sum
    }

    /// The part of the stretch inside the box.
    fn inside(&self, stretch: &Stretch) -> Option<Range<f64>> {
        let (start, end) = self.chord(stretch)?.clip(stretch);
        (start < end).then_some(start..end)
    }
}

fn between(field: &dyn IntegratedField, stretch: &Stretch, Range { start, end }: Range<f64>) -> f64 {
    positive_or_zero(field.moments(&Stretch { start, end, ..*stretch }, false).integral)
}
