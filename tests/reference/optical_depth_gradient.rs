//! Gradient of the optical depth τ of an edge when one of its ends moves.
//!
//! The edge from a to b is x(s) = a + s·v, v = b − a, d = |v|, û = v/d:
//!
//! ```text
//! ∇_b τ =  û ∫σ ds + d ∫ s ∇σ ds     + Σ_faces d (σ₁ − σ₂) ∇_b s_face      ∇_b s_face = −s n/(n·v)
//! ∇_a τ = −û ∫σ ds + d ∫ (1−s) ∇σ ds + Σ_faces d (σ₁ − σ₂) ∇_a s_face      ∇_a s_face = −(1−s) n/(n·v)
//! ```
//!
//! with σ₁ on a's side of the face and σ₂ on b's. The regions and the near plane stay where they are.
//! Source: replaces [Lu20 (21)], whose σ_avg is an estimate and which has no face terms; for constant σ it is
//! [Lu20 (18)] divided by −Tr.

use super::{
    medium::Medium,
    optical_depth::{Piece, gauss_legendre, pieces},
    segments::Edge,
    vector::*,
    world::World,
};

/// Its two parts are separate so that a test can show that each is needed.
#[derive(Clone, Copy, Debug)]
pub struct OpticalDepthGradient {
    /// From σ_t between the faces.
    pub within: RgbGradient,
    /// From faces that move along the edge, at which σ_t jumps.
    pub faces: RgbGradient,
}

impl OpticalDepthGradient {
    pub fn total(&self) -> RgbGradient {
        [0, 1, 2].map(|c| add(self.within[c], self.faces[c]))
    }
}

/// Which part of an edge moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moving {
    /// The origin a; the other end stays.
    Start,
    /// The end b; the origin stays.
    End,
    /// The whole edge, its direction kept: for environment and directional lights.
    Whole,
}

/// ∇τ per channel, for an edge whose pieces with σ_t > 0 are finite.
pub fn optical_depth_gradient(world: &World, edge: &Edge, moving: Moving) -> OpticalDepthGradient {
    let pieces = pieces(world, edge);
    let mut gradient = OpticalDepthGradient { within: [ZERO; 3], faces: [ZERO; 3] };

    // Only pieces with σ_t count; the last one of an infinite edge is vacuum.
    for piece in pieces.iter().filter(|piece| piece.medium.is_some()) {
        for (t, weight) in gauss_legendre(piece.begin, piece.end) {
            let sigma = piece.sigma_t(edge.point(t));
            let sigma_gradient = piece.sigma_t_gradient(edge.point(t));
            for c in 0..3 {
                // dt = d·ds: the integral of σ ds is that of σ dt divided by d.
                let stretch = scale(stretching(edge, moving) * sigma[c], edge.direction);
                let shift = scale(follows(edge, moving, t), sigma_gradient[c]);
                gradient.within[c] = add(gradient.within[c], scale(weight, add(stretch, shift)));
            }
        }
    }

    for pair in pieces.windows(2) {
        for c in 0..3 {
            gradient.faces[c] = add(gradient.faces[c], face_term(edge, moving, &pair[0], &pair[1])[c]);
        }
    }
    gradient
}

/// (σ₁ − σ₂)·∇t of the face between two pieces, t its distance along the edge.
fn face_term(edge: &Edge, moving: Moving, before: &Piece, after: &Piece) -> RgbGradient {
    let n = before.face_normal.expect("only the last piece ends without a face");
    let point = edge.point(before.end);
    let jump = sub(before.sigma_t(point), after.sigma_t(point));
    // d ∇s = −s d n/(n·v) = −s n/(n·û), and −n/(n·ω) where the whole edge moves.
    let motion = scale(-follows(edge, moving, before.end) / dot(n, edge.direction), n);
    jump.map(|jump| scale(jump, motion))
}

/// By how much the point at distance t follows the moving vertex: s, 1 − s or 1.
fn follows(edge: &Edge, moving: Moving, t: f64) -> f64 {
    match moving {
        Moving::Start => 1.0 - t / edge.length,
        Moving::End => t / edge.length,
        Moving::Whole => 1.0,
    }
}

/// By how much a unit step of the moving vertex along the edge stretches each unit of its length.
fn stretching(edge: &Edge, moving: Moving) -> f64 {
    match moving {
        Moving::Start => -1.0 / edge.length,
        Moving::End => 1.0 / edge.length,
        Moving::Whole => 0.0,
    }
}

/// ∇_a τ(a, b) and ∇_b τ(a, b) in one medium that fills the space.
pub fn optical_depth_gradients_in_medium(medium: &Medium, a: Vec3, b: Vec3) -> [RgbGradient; 2] {
    let world = World::filled_with(medium.clone());
    let edge = Edge::between(a, b);
    [Moving::Start, Moving::End].map(|moving| optical_depth_gradient(&world, &edge, moving).total())
}
