//! A participating medium: colour, albedo and phase function times a density that may vary in space.

use super::{grid::Grid, phase::Phase, vector::*};

#[derive(Clone, Debug)]
pub enum Density {
    /// 1 everywhere: a homogeneous medium.
    Constant,
    Grid(Grid),
}

#[derive(Clone, Debug)]
pub struct Medium {
    /// σ_t at density 1, in 1/world unit, per channel.
    pub sigma_t: Rgb,
    /// σ_s/σ_t per channel.
    pub albedo: Rgb,
    pub phase: Phase,
    pub density: Density,
}

impl Medium {
    /// Zero outside of a grid's box.
    pub fn density(&self, point: Vec3) -> f64 {
        match &self.density {
            Density::Constant => 1.0,
            Density::Grid(grid) => grid.density(point),
        }
    }

    /// As [`Medium::density`], but at a grid's box the limit from inside.
    pub fn clamped_density(&self, point: Vec3) -> f64 {
        match &self.density {
            Density::Constant => 1.0,
            Density::Grid(grid) => grid.clamped_density(point),
        }
    }

    /// World-space gradient of [`Medium::clamped_density`].
    pub fn clamped_density_gradient(&self, point: Vec3) -> Vec3 {
        match &self.density {
            Density::Constant => ZERO,
            Density::Grid(grid) => grid.clamped_gradient(point),
        }
    }

    /// Extinction coefficient.
    pub fn sigma_t_at(&self, point: Vec3) -> Rgb {
        scale(self.density(point), self.sigma_t)
    }

    /// Scattering coefficient.
    pub fn sigma_s_at(&self, point: Vec3) -> Rgb {
        product(self.albedo, self.sigma_t_at(point))
    }

    /// ∇σ_s/σ_s, the same in all channels since only the density varies. Inside of a grid's box.
    pub fn log_sigma_s_gradient(&self, point: Vec3) -> Vec3 {
        scale(1.0 / self.clamped_density(point), self.clamped_density_gradient(point))
    }
}
