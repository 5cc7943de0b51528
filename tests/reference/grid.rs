//! A density that is trilinear between samples at the centres of nx × ny × nz cells.
//!
//! The cells fill the unit cube, which an affine map places in the world. In the outermost half cells the density is
//! clamped, outside of the box it is zero: the box is a face at which the density may jump.

use super::vector::*;

#[derive(Clone, Debug)]
pub struct Grid {
    /// nx, ny, nz; each at least 1.
    pub resolution: [usize; 3],
    /// Sample (i, j, k) is at index i + nx·(j + ny·k).
    pub samples: Vec<f64>,
    /// From the unit cube to the world; invertible, otherwise arbitrary.
    pub to_world: Affine,
}

/// Where a coordinate lies between two sample planes: the sample before, the sample after, the weight of the latter, and
/// the derivative of that weight by the local coordinate (0 where clamped).
#[derive(Clone, Copy)]
struct Bracket {
    before: usize,
    after: usize,
    weight: f64,
    slope: f64,
}

fn bracket(local: f64, n: usize) -> Bracket {
    let x = local * n as f64 - 0.5;
    let last = n - 1;
    if x <= 0.0 {
        return Bracket { before: 0, after: 0, weight: 0.0, slope: 0.0 };
    }
    if x >= last as f64 {
        return Bracket { before: last, after: last, weight: 0.0, slope: 0.0 };
    }
    let before = x.floor() as usize;
    Bracket { before, after: before + 1, weight: x - before as f64, slope: n as f64 }
}

impl Grid {
    fn sample(&self, i: usize, j: usize, k: usize) -> f64 {
        let [nx, ny, _] = self.resolution;
        self.samples[i + nx * (j + ny * k)]
    }

    fn brackets(&self, point: Vec3) -> [Bracket; 3] {
        let local = self.to_world.apply_inverse(point);
        [0, 1, 2].map(|a| bracket(local[a], self.resolution[a]))
    }

    /// Σ over the eight surrounding samples, each with the product of its three weights. `weights[axis]` holds the weight
    /// of the sample before and after.
    fn weighted_sum(&self, b: [Bracket; 3], weights: [[f64; 2]; 3]) -> f64 {
        let mut total = 0.0;
        for (k, wz) in [b[2].before, b[2].after].into_iter().zip(weights[2]) {
            for (j, wy) in [b[1].before, b[1].after].into_iter().zip(weights[1]) {
                for (i, wx) in [b[0].before, b[0].after].into_iter().zip(weights[0]) {
                    total += wx * wy * wz * self.sample(i, j, k);
                }
            }
        }
        total
    }

    /// Is the point in the closed box?
    pub fn contains(&self, point: Vec3) -> bool {
        let local = self.to_world.apply_inverse(point);
        local.iter().all(|u| (0.0..=1.0).contains(u))
    }

    /// The density, zero outside of the box.
    pub fn density(&self, point: Vec3) -> f64 {
        if self.contains(point) { self.clamped_density(point) } else { 0.0 }
    }

    /// The density, continued beyond the box by clamping. At the box it is the limit from inside.
    pub fn clamped_density(&self, point: Vec3) -> f64 {
        let b = self.brackets(point);
        self.weighted_sum(b, b.map(|b| [1.0 - b.weight, b.weight]))
    }

    /// The world-space gradient of [`Grid::clamped_density`].
    pub fn clamped_gradient(&self, point: Vec3) -> Vec3 {
        let b = self.brackets(point);
        let local = [0, 1, 2].map(|axis| {
            let mut weights = b.map(|b| [1.0 - b.weight, b.weight]);
            weights[axis] = [-b[axis].slope, b[axis].slope];
            self.weighted_sum(b, weights)
        });
        // Gradients transform by the inverse transpose.
        let rows = self.to_world.inverse_rows();
        sum(&[0, 1, 2].map(|axis| scale(local[axis], rows[axis])))
    }

    /// Parameter t and world normal wherever the line `origin + t·direction` meets a plane of samples or of the box: between
    /// two neighbouring ones the density is cubic in t.
    pub fn crossings(&self, origin: Vec3, direction: Vec3) -> Vec<(f64, Vec3)> {
        let local_origin = self.to_world.apply_inverse(origin);
        let rows = self.to_world.inverse_rows();
        let mut crossings = Vec::new();
        for axis in 0..3 {
            let n = self.resolution[axis];
            let speed = dot(rows[axis], direction);
            let sample_planes = (0..n).map(|i| (i as f64 + 0.5) / n as f64);
            for plane in sample_planes.chain([0.0, 1.0]) {
                crossings.push(((plane - local_origin[axis]) / speed, rows[axis]));
            }
        }
        // A line parallel to a plane never meets it.
        crossings.retain(|(t, _)| t.is_finite());
        crossings
    }

    /// Distance to the nearest plane of samples or of the box, in cells. Derivatives of the density jump there.
    pub fn cells_to_nearest_plane(&self, point: Vec3) -> f64 {
        let local = self.to_world.apply_inverse(point);
        let along = |axis: usize| {
            let n = self.resolution[axis] as f64;
            let x = local[axis] * n;
            let to_samples = (x - 0.5 - (x - 0.5).round()).abs();
            to_samples.min(x.abs()).min((n - x).abs())
        };
        along(0).min(along(1)).min(along(2))
    }
}
