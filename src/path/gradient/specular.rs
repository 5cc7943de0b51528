//! The derivative of log f when a run of medium vertices next to a specular one moves: only along the edge between the two, so that
//! the specular chain stays as it is.
//!
//! f is meant in (direction, distance) measure along the chain, in which the move has Jacobian 1 and no edge of the chain has a G.
//! Differs from the thesis (section 5.1, Specular), which takes the gradient of G of the specular edge: that edge has none, the one
//! at the other end of the run has.

use super::super::{Path, PathError, PathErrorKind};
use super::run::{Run, Side};
use super::{LogGradient, relative_colour};
use crate::math::DVec3;
use crate::scene::Scene;

/// d log f/dδ when a run moves by δ·`direction`, 1/world unit.
#[derive(Clone, Copy, Debug)]
pub struct LogDerivative {
    /// Unit vector from the run to its specular neighbour.
    pub direction: DVec3,
    /// Of these only the components along `direction` have a meaning; what stays on the specular side is 0.
    pub factors: LogGradient,
    /// d log luminance(f)/dδ
    pub luminance: f64,
}

impl LogDerivative {
    /// d log/dδ of one colour channel of f.
    pub fn channel(&self, c: usize) -> f64 {
        self.factors.channel(c).dot(self.direction)
    }
}

/// The derivative of log f when the `count` medium vertices from `first` on move towards their only specular neighbour: the one after
/// the run, or the one before it. Valid until they reach it.
pub fn path_run_log_derivative(scene: &Scene, path: &Path, first: usize, count: usize) -> Result<LogDerivative, PathError> {
    let run = Run::new(scene, path, first, count)?;
    let side = match (run.is_beside_specular(Side::Previous), run.is_beside_specular(Side::Next)) {
        (true, false) => Side::Previous,
        (false, true) => Side::Next,
        // Nowhere to move, or anywhere: that is a gradient.
        _ => return Err(PathErrorKind::NotMovable.at(first)),
    };
    // Before the ends: hosts are asked for derivatives only where there is light.
    let colour = relative_colour(scene, path, first)?;
    let mut factors = LogGradient::default();
    run.add_specular_end(side, &mut factors)?;
    run.add_end(scene, path, side.other(), &mut factors)?;
    run.add_inside(scene, path, &mut factors)?;
    let direction = run.outwards(side);
    let (_, luminance) = factors.of_colour(colour);
    Ok(LogDerivative { direction, factors, luminance: luminance.dot(direction) })
}
