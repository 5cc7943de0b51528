//! A run of consecutive medium vertices that moves rigidly, between a neighbour before it and one after it that stay.

use super::super::contribution::towards;
use super::super::{Node, Path, PathError, PathErrorKind};
use super::LogGradient;
use super::end::{End, EndGradient};
use super::neighbour::{Beyond, known};
use crate::math::DVec3;
use crate::medium::{Medium, moments};
use crate::scene::Scene;

/// Vertices `first` to `last` of a path, all in media.
pub struct Run {
    pub first: usize,
    pub last: usize,
}

/// Which end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// Towards the camera.
    Previous,
    /// Towards the light.
    Next,
}

fn medium<'s>(scene: &'s Scene<'s>, path: &Path, i: usize) -> Result<&'s Medium<'s>, PathError> {
    match path.node(scene, i)? {
        Node::Medium(medium) => Ok(medium),
        _ => Err(PathErrorKind::NotMovable.at(i)),
    }
}

impl Run {
    pub fn new(scene: &Scene, path: &Path, first: usize, count: usize) -> Result<Self, PathError> {
        let after = first.checked_add(count).filter(|_| count > 0).ok_or(PathErrorKind::BadIndex.at(first))?;
        (first..after).try_for_each(|i| medium(scene, path, i).map(drop))?;
        Ok(Self { first, last: after - 1 })
    }

    /// Its outermost vertex on that side, and the neighbour beyond it. Medium vertices have both neighbours.
    pub fn outermost(&self, side: Side) -> (usize, usize) {
        match side {
            Side::Previous => (self.first, self.first - 1),
            Side::Next => (self.last, self.last + 1),
        }
    }

    /// Whether the neighbour on that side is specular.
    pub fn is_beside_specular(&self, scene: &Scene, path: &Path, side: Side) -> Result<bool, PathError> {
        path.node(scene, self.outermost(side).1).map(|node| node.is_specular())
    }

    /// What changes at an end whose neighbour is not specular.
    pub fn end(&self, scene: &Scene, path: &Path, side: Side) -> Result<EndGradient, PathError> {
        let (i, q) = self.outermost(side);
        let end = End {
            side,
            x: path.position(scene, i)?,
            phase: known(medium(scene, path, i)?.phase, i)?,
            onwards: towards(path, scene, i, if q < i { i + 1 } else { i - 1 })?,
            beyond: Beyond::new(scene, path, i, q)?,
            line: path.edge(scene, i.min(q))?,
        };
        Ok(end.log_gradient(&scene.camera.at(path.position(scene, 0)?)))
    }

    /// ∇log of all that changes: at the ends, σ_s at every vertex of the run, and Tr of every edge inside it.
    pub fn log_gradient(&self, scene: &Scene, path: &Path, ends: [EndGradient; 2]) -> Result<LogGradient, PathError> {
        let mut sum = LogGradient::of_ends(ends);
        for i in self.first..=self.last {
            let gradient = medium(scene, path, i)?.log_sigma_s_gradient(path.position(scene, i)?);
            sum.scattering += gradient.ok_or(PathErrorKind::ZeroContribution.at(i))?;
        }
        for i in self.first..self.last {
            // The whole edge moves: ∇τ = ∫ ∇σ_t dt.
            let gradient = moments(&path.edge(scene, i)?).gradient;
            sum.transmittance_inside = core::array::from_fn(|c| sum.transmittance_inside[c] - gradient[c]);
        }
        Ok(sum)
    }

    /// Unit vector from the run to its neighbour on that side.
    pub fn outwards(&self, scene: &Scene, path: &Path, side: Side) -> Result<DVec3, PathError> {
        let (i, q) = self.outermost(side);
        towards(path, scene, i, q)
    }

    /// What changes at an end with a specular neighbour q when the run moves along the edge between them: nothing but the edge's
    /// length. The chain beyond q stays, and has no G.
    pub fn specular_end(&self, scene: &Scene, path: &Path, side: Side) -> Result<EndGradient, PathError> {
        let (i, _) = self.outermost(side);
        let sigma_t = medium(scene, path, i)?.sigma_t(path.position(scene, i)?);
        let outwards = self.outwards(scene, path, side)?;
        Ok(EndGradient { transmittance: core::array::from_fn(|c| sigma_t[c] * outwards), ..EndGradient::default() })
    }
}
