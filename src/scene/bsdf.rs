//! Surface scattering: diffuse, mirror, smooth dielectric.

use crate::math::{Colour, DVec2, DVec3, orthonormal_basis, sqrt, uniform_disk};
use core::f64::consts::PI;

/// A surface's BSDF. Directions point away from the surface; `n` is its oriented geometric normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambert's, on the side that the normal points to.
    Diffuse { albedo: Colour },
    /// A perfect mirror on the side that the normal points to.
    Mirror { reflectance: Colour },
    /// A smooth interface; `eta` is the index of refraction behind it over that before it.
    Dielectric { eta: f64 },
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    pub direction: DVec3,
    /// f_r·cos/pdf.
    pub weight: Colour,
    /// Per steradian; None for a specular direction.
    pub pdf: Option<f64>,
    /// Squared ratio of the indices of refraction passed, for Russian roulette on importance instead of radiance.
    pub eta_squared: f64,
}

impl Bsdf {
    pub fn is_specular(&self) -> bool {
        !matches!(self, Self::Diffuse { .. })
    }

    /// Whether it scatters nothing, as the surface of a light usually does.
    pub fn is_black(&self) -> bool {
        matches!(self, Self::Diffuse { albedo } if *albedo == Colour::ZERO)
    }

    /// f_r(to_camera, to_light), without the cosine. 0 for specular ones.
    pub fn eval(&self, n: DVec3, to_camera: DVec3, to_light: DVec3) -> Colour {
        match self {
            Self::Diffuse { albedo } if n.dot(to_camera) > 0.0 && n.dot(to_light) > 0.0 => *albedo * (1.0 / PI),
            _ => Colour::ZERO,
        }
    }

    /// f_r, or what is left of it without its delta factor at a specular vertex.
    pub fn eval_or_weight(&self, n: DVec3, to_camera: DVec3, to_light: DVec3) -> Colour {
        match *self {
            Self::Diffuse { .. } => self.eval(n, to_camera, to_light),
            Self::Mirror { reflectance } if n.dot(to_camera) > 0.0 && n.dot(to_light) > 0.0 => reflectance,
            Self::Mirror { .. } => Colour::ZERO,
            Self::Dielectric { eta } => {
                let interface = Interface::new(n.dot(to_camera), eta);
                let reflected = n.dot(to_camera) * n.dot(to_light) > 0.0;
                let (f, eta) = (interface.fresnel(), interface.relative);
                Colour::splat(if reflected { f } else { (1.0 - f) / (eta * eta) })
            }
        }
    }

    /// Density of [`Bsdf::sample`], per steradian.
    pub fn pdf(&self, n: DVec3, to_camera: DVec3, to_light: DVec3) -> f64 {
        match self {
            Self::Diffuse { .. } if n.dot(to_camera) > 0.0 => n.dot(to_light).max(0.0) * (1.0 / PI),
            _ => 0.0,
        }
    }

    /// ∂log f_r/∂to_camera and ∂log f_r/∂to_light per colour channel, as unconstrained vectors: for a direction ω to a point at a
    /// distance d, the gradient with respect to that point is (I − ωωᵀ)/d times it. 0 where f_r does not depend on the direction, or is 0.
    pub fn log_gradient(&self, _n: DVec3, _to_camera: DVec3, _to_light: DVec3) -> ([DVec3; 3], [DVec3; 3]) {
        ([DVec3::ZERO; 3], [DVec3::ZERO; 3])
    }

    /// A direction towards the lights; `lobe` chooses between reflection and refraction. None if nothing is scattered.
    pub fn sample(&self, n: DVec3, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<BsdfSample> {
        let cosine = n.dot(to_camera);
        match *self {
            Self::Diffuse { albedo } if cosine > 0.0 => {
                let d = uniform_disk(u);
                let height = sqrt((1.0 - d.length_squared()).max(0.0));
                let (s, t) = orthonormal_basis(n);
                let pdf = height * (1.0 / PI);
                let direction = s * d.x + t * d.y + n * height;
                (pdf > 0.0).then_some(BsdfSample { direction, weight: albedo, pdf: Some(pdf), eta_squared: 1.0 })
            }
            Self::Mirror { reflectance } if cosine > 0.0 => Some(specular(reflect(n, to_camera), reflectance, 1.0)),
            Self::Dielectric { eta } => Some(sample_dielectric(n, to_camera, eta, lobe)),
            _ => None,
        }
    }
}

fn specular(direction: DVec3, weight: Colour, eta_squared: f64) -> BsdfSample {
    BsdfSample { direction, weight, pdf: None, eta_squared }
}

fn reflect(n: DVec3, away: DVec3) -> DVec3 {
    2.0 * n.dot(away) * n - away
}

/// A smooth interface met at cosine `cos_i`.
struct Interface {
    /// Index of refraction beyond the surface over that on the side of arrival.
    relative: f64,
    cos_i: f64,
    sin2_t: f64,
    cos_t: f64,
}

impl Interface {
    fn new(cosine: f64, eta: f64) -> Self {
        let relative = if cosine > 0.0 { eta } else { 1.0 / eta };
        let cos_i = cosine.abs();
        let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (relative * relative);
        Self { relative, cos_i, sin2_t, cos_t: sqrt((1.0 - sin2_t).max(0.0)) }
    }

    /// Unpolarised Fresnel reflectance; 1 at total internal reflection.
    fn fresnel(&self) -> f64 {
        let &Self { relative, cos_i, sin2_t, cos_t } = self;
        if sin2_t >= 1.0 {
            return 1.0;
        }
        let s = (cos_i - relative * cos_t) / (cos_i + relative * cos_t);
        let p = (relative * cos_i - cos_t) / (relative * cos_i + cos_t);
        0.5 * (s * s + p * p)
    }
}

/// Reflects with the Fresnel probability, else refracts. Radiance is divided by η² on the way into the denser side.
fn sample_dielectric(n: DVec3, to_camera: DVec3, eta: f64, lobe: f64) -> BsdfSample {
    let cosine = n.dot(to_camera);
    let facing = if cosine > 0.0 { n } else { -n };
    let interface = Interface::new(cosine, eta);
    if lobe < interface.fresnel() {
        return specular(reflect(facing, to_camera), Colour::ONE, 1.0);
    }
    let Interface { relative, cos_i, cos_t, .. } = interface;
    let direction = (facing * cos_i - to_camera) / relative - facing * cos_t;
    let eta_squared = relative * relative;
    specular(direction.normalize(), Colour::splat(1.0 / eta_squared), eta_squared)
}
