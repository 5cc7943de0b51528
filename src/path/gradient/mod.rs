//! The gradient of log f when one or more consecutive medium vertices move by the same offset. [Lu20 (29)], with the term ∇σ_s/σ_s
//! that is missing there. Only what changes is looked at: inside a run that moves rigidly, distances, directions and phase angles
//! stay, and with them G and f_p.

mod end;
mod neighbour;
mod run;
mod specular;

pub(crate) use neighbour::Seen;
pub use neighbour::{Neighbour, Wing};
pub use specular::{LogDerivative, path_run_log_derivative};

use super::contribution::for_each_vertex;
use super::{Path, PathError, PathErrorKind};
use crate::math::{Colour, DVec3, LUMINANCE, luminance, transmittance};
use crate::medium::{Line, optical_depth};
use crate::scene::Scene;
use run::{Run, Side};

/// ∇log of every factor of f that changes when a run of medium vertices moves, 1/world unit. p is the neighbour before the run, n the
/// one after it; for a single vertex x, first and last are both x.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LogGradient {
    /// Σ ∇σ_s/σ_s over the run.
    pub scattering: DVec3,
    /// −∇τ(p, first), −Σ ∇τ of the edges inside the run, and −∇τ(last, n), per colour channel.
    pub transmittance_previous: [DVec3; 3],
    pub transmittance_inside: [DVec3; 3],
    pub transmittance_next: [DVec3; 3],
    /// ∇log G(p, first) and ∇log G(last, n), cosines at p and n included.
    pub geometry_previous: DVec3,
    pub geometry_next: DVec3,
    /// ∇log W_e
    pub importance: DVec3,
    /// ∇log f_p at p, at the run's first and last vertex together, and at n.
    pub phase_previous: DVec3,
    pub phase_apex: DVec3,
    pub phase_next: DVec3,
    /// ∇log of f_r at p, and of f_r or the emission at n, per colour channel, where those depend on the direction.
    pub profile_previous: [DVec3; 3],
    pub profile_next: [DVec3; 3],
}

impl LogGradient {
    /// ∇log of one colour channel of f.
    pub fn channel(&self, c: usize) -> DVec3 {
        let shared = self.scattering + self.geometry_previous + self.geometry_next + self.importance;
        let phases = self.phase_previous + self.phase_apex + self.phase_next;
        let transmittance = self.transmittance_previous[c] + self.transmittance_inside[c] + self.transmittance_next[c];
        shared + phases + transmittance + self.profile_previous[c] + self.profile_next[c]
    }

    /// ∇log of all channels of f, and of its luminance; its colour is `f` up to a factor.
    pub fn of_colour(&self, f: Colour) -> ([DVec3; 3], DVec3) {
        let rgb = core::array::from_fn(|c| self.channel(c));
        let shares = LUMINANCE * f / luminance(f);
        (rgb, rgb[0] * shares.x + rgb[1] * shares.y + rgb[2] * shares.z)
    }
}

/// The gradient of a path's contribution.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gradient {
    pub factors: LogGradient,
    /// ∇log of each channel of f: the sums of the factors.
    pub rgb: [DVec3; 3],
    /// ∇log luminance(f)
    pub luminance: DVec3,
}

/// The gradient of log f when the medium vertex `i` of `path` moves.
pub fn path_log_gradient(scene: &Scene, path: &Path, i: usize) -> Result<Gradient, PathError> {
    path_run_log_gradient(scene, path, i, 1)
}

/// The gradient of log f when the `count` medium vertices from `first` on move by the same offset: the sum of their gradients.
pub fn path_run_log_gradient(scene: &Scene, path: &Path, first: usize, count: usize) -> Result<Gradient, PathError> {
    let run = Run::new(scene, path, first, count)?;
    for side in [Side::Previous, Side::Next] {
        if run.is_beside_specular(side) {
            return Err(PathErrorKind::NotMovable.at(run.outermost(side).0));
        }
    }
    // Before the ends: hosts are asked for derivatives only where there is light.
    let colour = relative_colour(scene, path, first)?;
    let mut gradient = Gradient::default();
    run.add_end(scene, path, Side::Previous, &mut gradient.factors)?;
    run.add_end(scene, path, Side::Next, &mut gradient.factors)?;
    run.add_inside(scene, path, &mut gradient.factors)?;
    (gradient.rgb, gradient.luminance) = gradient.factors.of_colour(colour);
    Ok(gradient)
}

/// f up to a positive factor, kept in range however long or dark the path. An error at vertex `i` if it is 0.
fn relative_colour(scene: &Scene, path: &Path, i: usize) -> Result<Colour, PathError> {
    let (mut colour, mut depth) = (Colour::ONE, Colour::ZERO);
    for_each_vertex(scene, path, |factors, edge| {
        colour *= factors.product();
        let largest = colour.max_element();
        colour = if largest > 0.0 { colour / largest } else { colour };
        depth += edge.map_or(Colour::ZERO, relative_depth);
    })?;
    colour *= transmittance(depth - depth.min_element());
    // Written so that NaN is an error.
    if !(luminance(colour) > 0.0) {
        return Err(PathErrorKind::ZeroContribution.at(i));
    }
    Ok(colour)
}

/// τ of an edge up to a number that is the same for all channels. Only a light infinitely far away can be hidden by a grey medium.
fn relative_depth(edge: &Line) -> Colour {
    let media = edge.segments.iter().filter_map(|segment| edge.media.get(segment.medium as usize));
    let grey = media.map(|medium| medium.sigma_t).all(|sigma_t| sigma_t.x == sigma_t.y && sigma_t.x == sigma_t.z);
    if grey && edge.length.is_finite() { Colour::ZERO } else { optical_depth(edge) }
}
