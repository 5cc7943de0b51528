//! A pinhole camera, or what a thin lens is through one of its points: a pinhole camera there.
//!
//! Source: [Lu20 (34)-(36)], with the importance written as in path space: We = 1/(A cos⁴θ), cosine C(x_0) = cosθ.
//! Differs from [Lu20 (37)-(39)]: 1/(A A_lens cos⁴θ) for a lens, A_lens = πr², as of [Lu20 (36)].

use super::vector::*;
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// x_0.
    pub position: Vec3,
    /// Unit vector along the optical axis.
    pub forward: Vec3,
    /// Unit vector, perpendicular to `forward`.
    pub right: Vec3,
    /// Unit vector, perpendicular to both.
    pub up: Vec3,
    /// The area A of the image on the plane at distance 1.
    pub image_area: f64,
    /// Media at camera depth below this are skipped, and vertices there are not seen.
    pub near: f64,
    pub lens: Option<Lens>,
}

/// A disk across the optical axis, on which the camera's `position` is a point.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    pub centre: Vec3,
    pub radius: f64,
}

impl Camera {
    /// A camera at `position` that looks at `target`, which is not straight above or below it.
    pub fn looking_at(position: Vec3, target: Vec3, image_area: f64, near: f64) -> Camera {
        let forward = direction(position, target);
        let right = normalize(cross(forward, [0.0, 1.0, 0.0]));
        let up = cross(right, forward);
        Camera { position, forward, right, up, image_area, near, lens: None }
    }

    /// The same camera with a lens, through the point of it that is `right` and `up` from its centre.
    pub fn through_lens(self, radius: f64, [right, up]: [f64; 2]) -> Camera {
        let centre = self.position;
        let offset = add(scale(right, self.right), scale(up, self.up));
        Camera { position: add(centre, offset), lens: Some(Lens { centre, radius }), ..self }
    }

    /// Distance along the optical axis.
    pub fn depth(&self, point: Vec3) -> f64 {
        dot(self.forward, sub(point, self.position))
    }

    /// cosθ between the optical axis and the direction to `point`.
    pub fn cosine(&self, point: Vec3) -> f64 {
        dot(self.forward, direction(self.position, point))
    }

    /// Where `point` appears on the plane at distance 1, in (right, up) coordinates; `None` if it is before the near plane.
    pub fn project(&self, point: Vec3) -> Option<[f64; 2]> {
        let depth = self.depth(point);
        let v = sub(point, self.position);
        (depth > self.near).then(|| [dot(self.right, v) / depth, dot(self.up, v) / depth])
    }

    /// We(x_0 → point) = 1/(A cos⁴θ), and 0 before the near plane. The image has an area here but no outline: whoever
    /// limits it to a rectangle does so with [`Camera::project`].
    pub fn importance(&self, point: Vec3) -> f64 {
        match self.project(point) {
            Some(_) => {
                let lens_area = self.lens.map_or(1.0, |lens| PI * lens.radius.powi(2));
                1.0 / (self.image_area * lens_area * self.cosine(point).powi(4))
            }
            None => 0.0,
        }
    }
}
