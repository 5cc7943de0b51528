//! Light that the host computes: a sky, and the profile of a point light. What is no value (NaN, infinite, negative) counts as 0.

use crate::math::{Colour, DVec2, DVec3, colour_or_black, is_unit, positive_or_zero};
use core::fmt::Debug;

/// Light from infinitely far away, by the unit vector to where it comes from.
pub trait SkyFunction: Debug + Sync {
    fn radiance(&self, to_sky: DVec3) -> Colour;

    /// Density of [`SkyFunction::sample`], per steradian: positive wherever the radiance is.
    fn pdf(&self, to_sky: DVec3) -> f64;

    /// A direction from two uniform numbers in (0, 1). None: no light comes from anywhere.
    fn sample(&self, u: DVec2) -> Option<DVec3>;
}

/// What a point light sends along a unit vector away from it. Subpaths leave it in all directions alike.
pub trait ProfileFunction: Debug + Sync {
    fn intensity(&self, direction: DVec3) -> Colour;

    /// ∂log intensity/∂direction, as [`super::Light::log_gradient`] has it, where there is any. None: not known.
    fn log_gradient(&self, direction: DVec3) -> Option<[DVec3; 3]>;
}

#[derive(Clone, Copy, Debug)]
pub struct CustomSky<'a> {
    pub function: &'a dyn SkyFunction,
    /// A factor.
    pub scale: Colour,
}

#[derive(Clone, Copy, Debug)]
pub struct CustomProfile<'a> {
    pub function: &'a dyn ProfileFunction,
    /// A factor.
    pub scale: Colour,
}

impl CustomSky<'_> {
    pub fn radiance(&self, to_sky: DVec3) -> Colour {
        self.scale * colour_or_black(self.function.radiance(to_sky))
    }

    pub fn pdf(&self, to_sky: DVec3) -> f64 {
        positive_or_zero(self.function.pdf(to_sky))
    }

    /// A direction to the sky and its density per steradian; None if there is none.
    pub fn sample(&self, u: DVec2) -> Option<(DVec3, f64)> {
        let to_sky = self.function.sample(u).filter(|v| is_unit(*v))?.normalize();
        let pdf = self.pdf(to_sky);
        (pdf > 0.0).then_some((to_sky, pdf))
    }
}

impl CustomProfile<'_> {
    pub fn intensity(&self, direction: DVec3) -> Colour {
        self.scale * colour_or_black(self.function.intensity(direction))
    }

    /// None: the host does not know it. 0 where it is not finite.
    pub fn log_gradient(&self, direction: DVec3) -> Option<[DVec3; 3]> {
        let gradient = self.function.log_gradient(direction)?;
        Some(gradient.map(|g| if g.is_finite() { g } else { DVec3::ZERO }))
    }
}
