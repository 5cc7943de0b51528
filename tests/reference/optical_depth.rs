//! Optical depth τ = ∫ σ_t along an edge, by brute force: cut the edge at every plane at which σ_t is not smooth, and use
//! Gauss-Legendre quadrature of more than sufficient order on every piece.
//!
//! Transmittance is exp(−τ) [Lu20 (6)].

use super::{
    medium::{Density, Medium},
    segments::{Edge, Segment},
    vector::*,
    world::World,
};

/// A stretch of an edge on which σ_t is a polynomial of degree ≤ 3.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'a> {
    pub begin: f64,
    pub end: f64,
    /// `None` where σ_t is zero: in vacuum or outside of the box of a grid.
    pub medium: Option<&'a Medium>,
    /// Normal of the plane on which the piece ends; `None` at the end of the edge.
    pub face_normal: Option<Vec3>,
}

impl Piece<'_> {
    /// σ_t of this piece, continued smoothly: at both ends it is the limit from within the piece.
    pub fn sigma_t(&self, point: Vec3) -> Rgb {
        self.medium.map_or(ZERO, |m| scale(m.clamped_density(point), m.sigma_t))
    }

    /// ∇σ_t of this piece, per channel.
    pub fn sigma_t_gradient(&self, point: Vec3) -> RgbGradient {
        self.medium.map_or([ZERO; 3], |m| {
            let gradient = m.clamped_density_gradient(point);
            m.sigma_t.map(|sigma| scale(sigma, gradient))
        })
    }
}

/// The pieces of an edge, in order.
pub fn pieces<'a>(world: &'a World, edge: &Edge) -> Vec<Piece<'a>> {
    let mut pieces = Vec::new();
    let mut begin = 0.0;
    for segment in world.segments(edge) {
        match segment.medium {
            None => pieces.push(Piece { begin, end: segment.end, medium: None, face_normal: segment.face_normal }),
            Some(m) => pieces.extend(pieces_in_medium(&world.media[m], edge, begin, &segment)),
        }
        begin = segment.end;
    }
    pieces
}

fn pieces_in_medium<'a>(medium: &'a Medium, edge: &Edge, mut begin: f64, segment: &Segment) -> Vec<Piece<'a>> {
    let mut cuts = match &medium.density {
        Density::Constant => Vec::new(),
        Density::Grid(grid) => grid.crossings(edge.origin, edge.direction),
    };
    cuts.retain(|&(t, _)| begin < t && t < segment.end);
    cuts.sort_by(|a, b| a.0.total_cmp(&b.0));

    let mut pieces = Vec::new();
    let cuts = cuts.into_iter().map(|(t, normal)| (t, Some(normal)));
    for (end, face_normal) in cuts.chain([(segment.end, segment.face_normal)]) {
        let has_density = match &medium.density {
            Density::Constant => true,
            Density::Grid(grid) => grid.contains(edge.point_between(begin, end)),
        };
        pieces.push(Piece { begin, end, medium: has_density.then_some(medium), face_normal });
        begin = end;
    }
    pieces
}

/// Nodes and weights of 5-point Gauss-Legendre quadrature on [begin, end]: exact up to degree 9.
pub fn gauss_legendre(begin: f64, end: f64) -> [(f64, f64); 5] {
    let inner = (5.0 - 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0;
    let outer = (5.0 + 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0;
    let inner_weight = (322.0 + 13.0 * 70.0_f64.sqrt()) / 900.0;
    let outer_weight = (322.0 - 13.0 * 70.0_f64.sqrt()) / 900.0;
    let half = 0.5 * (end - begin);
    let middle = begin + half;
    [(-outer, outer_weight), (-inner, inner_weight), (0.0, 128.0 / 225.0), (inner, inner_weight), (outer, outer_weight)]
        .map(|(node, weight)| (middle + half * node, half * weight))
}

/// τ of a whole edge, per channel; infinite if a medium goes on to infinity.
pub fn optical_depth(world: &World, edge: &Edge) -> Rgb {
    optical_depth_until(world, edge, edge.length)
}

/// τ of an edge from its origin to distance `t`.
pub fn optical_depth_until(world: &World, edge: &Edge, t: f64) -> Rgb {
    let mut tau = ZERO;
    for piece in pieces(world, edge) {
        let (begin, end) = (piece.begin, piece.end.min(t));
        if piece.medium.is_none() || end <= begin {
            continue;
        }
        if end.is_infinite() {
            return [f64::INFINITY; 3];
        }
        for (node, weight) in gauss_legendre(begin, end) {
            tau = add(tau, scale(weight, piece.sigma_t(edge.point(node))));
        }
    }
    tau
}

/// τ(a, b) in one medium that fills the space (a grid is zero outside of its box).
pub fn optical_depth_in_medium(medium: &Medium, a: Vec3, b: Vec3) -> Rgb {
    optical_depth(&World::filled_with(medium.clone()), &Edge::between(a, b))
}
