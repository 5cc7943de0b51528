//! From points on lights and directions of their light back to the numbers that they are sampled from.

use super::Light;
use crate::math::{DVec2, DVec3, around_direction, hemisphere_number};

/// Where any numbers will do.
const ANY: DVec2 = DVec2::splat(0.5);

impl Light<'_> {
    /// The numbers from which [`Light::sample`] makes a point of an area light; any for others, on which there is no choice.
    pub fn invert_position(&self, point: DVec3) -> DVec2 {
        match *self {
            Self::Parallelogram { corner, edge_u, edge_v, .. } => {
                along_edges(point - corner, edge_u, edge_v).clamp(DVec2::ZERO, DVec2::ONE)
            }
            Self::Triangle { corner, edge_u, edge_v, .. } => {
                let along = along_edges(point - corner, edge_u, edge_v);
                let root = (1.0 - along.x).clamp(0.0, 1.0);
                let y = if root > 0.0 { along.y / root } else { 0.0 };
                DVec2::new(root * root, y.clamp(0.0, 1.0))
            }
            Self::Sphere { centre, .. } => sphere_number((point - centre).normalize_or(DVec3::Z)),
            _ => ANY,
        }
    }

    /// The numbers from which [`Light::sample_direction`] makes a direction. None if it never does.
    pub fn invert_direction(&self, normal: Option<DVec3>, direction: DVec3) -> Option<DVec2> {
        if !(self.direction_density(normal, direction) > 0.0) {
            return None;
        }
        match (self, normal) {
            (_, Some(n)) => Some(hemisphere_number(n, direction)),
            (Self::Spot { axis, falloff, .. }, None) => {
                let (cosine, turn) = around_direction(*axis, direction);
                Some(DVec2::new(((1.0 - cosine) / (1.0 - falloff.cos_outer())).clamp(0.0, 1.0), turn))
            }
            _ => Some(sphere_number(direction)),
        }
    }

    /// The numbers from which [`Light::sample_far`] makes the direction to a light at infinity; any for a directional light. None if it
    /// never does, or only the host knows.
    pub fn invert_far(&self, to_light: DVec3) -> Option<DVec2> {
        match self {
            Self::Environment { .. } => Some(sphere_number(to_light)),
            Self::EnvironmentMap(map) => map.invert(to_light),
            Self::Directional { .. } => Some(ANY),
            _ => None,
        }
    }
}

/// Of a direction that is uniform on the sphere, made by its height and turn.
fn sphere_number(direction: DVec3) -> DVec2 {
    let (cosine, turn) = around_direction(DVec3::Z, direction);
    DVec2::new((0.5 - 0.5 * cosine).clamp(0.0, 1.0), turn)
}

/// (a, b) with v = a·edge_u + b·edge_v, apart from what is across both.
fn along_edges(v: DVec3, edge_u: DVec3, edge_v: DVec3) -> DVec2 {
    let n = edge_u.cross(edge_v);
    DVec2::new(v.cross(edge_v).dot(n), edge_u.cross(v).dot(n)) / n.length_squared()
}
