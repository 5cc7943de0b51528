//! Weights of the techniques that could have made a path: (s, t) has s vertices from a light and t from the camera. [VG95] [V97 10.2]

use super::Technique;
use super::vertex::Vertex;

/// How the densities of techniques make weights that sum to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// p_i/Σp.
    #[default]
    Balance,
    /// p_i²/Σp².
    Power,
}

impl Heuristic {
    fn of(self, ratio: f64) -> f64 {
        match self {
            Self::Balance => ratio,
            Self::Power => ratio * ratio,
        }
    }
}

/// The techniques that make paths, of all that could.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repertoire {
    /// Fewest vertices from the camera: 1, or 2 without connections to the camera itself.
    pub camera: usize,
    /// Most vertices from a light.
    pub light: usize,
}

impl Repertoire {
    pub const ALL: Self = Self { camera: 1, light: usize::MAX };

    pub fn has(&self, technique: Technique) -> bool {
        technique.camera >= self.camera && technique.light <= self.light
    }
}

/// Densities, in the other subpath's direction, of the two vertices on either side of the connection and of those before them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Junction {
    /// Of the camera's last vertex, and of the one before it, made from the light's side.
    pub camera: [f64; 2],
    /// Of the light's last vertex, and of the one before it, made from the camera's side.
    pub light: [f64; 2],
}

/// The weight of the technique that joined these subpaths. Without light vertices the camera's last one is on a light.
pub fn weight(camera: &[Vertex], light: &[Vertex], junction: &Junction, heuristic: Heuristic, repertoire: &Repertoire) -> f64 {
    let vertices = camera.len() + light.len();
    let has = |camera: usize| repertoire.has(Technique { camera, light: vertices - camera });
    let reverse = |vertex: &Vertex, near: &[f64; 2], after: usize| match after {
        0 => near[0],
        1 => near[1],
        _ => vertex.reverse,
    };
    // A path's last vertex is a light as well as what it is otherwise.
    let connects = |path: &[Vertex], i: usize| {
        (light.is_empty() && i + 1 == path.len()) || path.get(i).is_some_and(|vertex| !vertex.is_specular())
    };
    let mut sum = 1.0;
    let mut ratio = 1.0;
    for (i, vertex) in camera.iter().enumerate().skip(1).rev() {
        ratio *= reverse(vertex, &junction.camera, camera.len() - 1 - i) / vertex.density;
        if connects(camera, i) && connects(camera, i - 1) && has(i) {
            sum += heuristic.of(ratio);
        }
    }
    ratio = 1.0;
    for (i, vertex) in light.iter().enumerate().rev() {
        ratio *= reverse(vertex, &junction.light, light.len() - 1 - i) / vertex.density;
        let possible = match i.checked_sub(1).and_then(|before| light.get(before)) {
            None => vertex.can_be_found(),
            Some(before) => !vertex.is_specular() && !before.is_specular(),
        };
        if possible && has(vertices - i) {
            sum += heuristic.of(ratio);
        }
    }
    1.0 / sum
}
