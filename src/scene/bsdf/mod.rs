//! Surface scattering: diffuse, mirror, smooth and rough conductors and dielectrics; and what the host computes.

mod custom;
mod fresnel;
mod ggx;
mod rough;

pub use custom::{BsdfFunction, CustomBsdf, SurfaceFrame};
pub use fresnel::Conductor;
pub use ggx::Ggx;
pub use rough::{RoughConductor, RoughDielectric};

use fresnel::Interface;

use crate::math::{Colour, DVec2, DVec3, hemisphere_number, orthonormal_basis, sqrt, uniform_disk};
use core::f64::consts::PI;

/// A point of a surface, where its BSDF is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    pub position: DVec3,
    /// As the surface is oriented.
    pub normal: DVec3,
    /// What the host's hit, or vertex, said about it: for BSDFs that the host computes.
    pub user: u64,
}

impl SurfacePoint {
    /// For BSDFs to which only the normal matters.
    pub const fn with_normal(normal: DVec3) -> Self {
        Self { position: DVec3::ZERO, normal, user: 0 }
    }
}

/// A surface's BSDF. Directions point away from the surface; `n` is its oriented geometric normal.
#[derive(Clone, Copy, Debug)]
pub enum Bsdf<'a> {
    /// Lambert's, on the side that the normal points to.
    Diffuse {
        albedo: Colour,
    },
    /// A perfect mirror on the side that the normal points to.
    Mirror {
        reflectance: Colour,
    },
    /// A smooth interface; `eta` is the index of refraction behind it over that before it.
    Dielectric {
        eta: f64,
    },
    /// A smooth metal, on the side that the normal points to.
    Conductor(Conductor),
    /// On the side that the normal points to.
    RoughConductor(RoughConductor),
    RoughDielectric(RoughDielectric),
    /// On the side that the normal points to, unless it transmits.
    Custom(CustomBsdf<'a>),
    /// Lambert's, with the host's f_r, which is asked for along the normal: the only one of its functions that is.
    Texture(CustomBsdf<'a>),
    /// The same on both sides.
    TwoSided(Reflector<'a>),
}

/// What scatters only on the side that its normal points to; see the same names in [`Bsdf`].
#[derive(Clone, Copy, Debug)]
pub enum Reflector<'a> {
    Diffuse {
        albedo: Colour,
    },
    Mirror {
        reflectance: Colour,
    },
    Conductor(Conductor),
    RoughConductor(RoughConductor),
    /// One that does not transmit.
    Custom(CustomBsdf<'a>),
    Texture(CustomBsdf<'a>),
}

impl<'a> From<Reflector<'a>> for Bsdf<'a> {
    fn from(reflector: Reflector<'a>) -> Self {
        match reflector {
            Reflector::Diffuse { albedo } => Self::Diffuse { albedo },
            Reflector::Mirror { reflectance } => Self::Mirror { reflectance },
            Reflector::Conductor(conductor) => Self::Conductor(conductor),
            Reflector::RoughConductor(rough) => Self::RoughConductor(rough),
            Reflector::Custom(custom) => Self::Custom(custom),
            Reflector::Texture(texture) => Self::Texture(texture),
        }
    }
}

/// Log-derivatives by to_camera and to_light, per colour channel.
type LogGradients = ([DVec3; 3], [DVec3; 3]);

const NO_GRADIENT: LogGradients = ([DVec3::ZERO; 3], [DVec3::ZERO; 3]);

/// What an inverse says where any number will do.
const ANY: f64 = 0.5;

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    pub direction: DVec3,
    /// f_r·cos/pdf.
    pub weight: Colour,
    /// Per steradian; None for a specular direction.
    pub pdf: Option<f64>,
    /// Squared ratio of the indices of refraction passed. `weight` times it is the weight for light travelling the other way, with
    /// `to_camera` pointing to where that comes from: refraction scales radiance, but not importance. Russian roulette uses it too.
    pub eta_squared: f64,
}

impl Bsdf<'_> {
    pub fn is_specular(&self) -> bool {
        match *self {
            Self::Mirror { .. } | Self::Dielectric { .. } | Self::Conductor(_) => true,
            Self::Diffuse { .. } | Self::RoughConductor(_) | Self::RoughDielectric(_) => false,
            Self::Custom(_) | Self::Texture(_) => false,
            Self::TwoSided(reflector) => Self::from(reflector).is_specular(),
        }
    }

    /// Whether f_r is the same for all pairs of directions on one side, and 0 otherwise.
    pub fn is_lambertian(&self) -> bool {
        match self {
            Self::Diffuse { .. } | Self::Texture(_) => true,
            Self::TwoSided(reflector) => matches!(reflector, Reflector::Diffuse { .. } | Reflector::Texture(_)),
            _ => false,
        }
    }

    /// Whether light can pass to the other side.
    pub fn transmits(&self) -> bool {
        match self {
            Self::Dielectric { .. } | Self::RoughDielectric(_) => true,
            Self::Custom(custom) => custom.transmits(),
            _ => false,
        }
    }

    /// The normal, turned to the side from which it is seen if both sides are alike.
    pub fn facing(&self, n: DVec3, to_camera: DVec3) -> DVec3 {
        if matches!(self, Self::TwoSided(_)) && n.dot(to_camera) < 0.0 { -n } else { n }
    }

    /// The same for the point.
    fn facing_at(&self, at: &SurfacePoint, to_camera: DVec3) -> SurfacePoint {
        SurfacePoint { normal: self.facing(at.normal, to_camera), ..*at }
    }

    /// Whether it scatters nothing, as the surface of a light usually does.
    pub fn is_black(&self) -> bool {
        let (Self::Diffuse { albedo } | Self::TwoSided(Reflector::Diffuse { albedo })) = self else { return false };
        *albedo == Colour::ZERO
    }

    /// f_r(to_camera, to_light), without the cosine. 0 for specular ones.
    pub fn eval(&self, at: &SurfacePoint, to_camera: DVec3, to_light: DVec3) -> Colour {
        let n = at.normal;
        match *self {
            Self::Diffuse { albedo } if n.dot(to_camera) > 0.0 && n.dot(to_light) > 0.0 => albedo * (1.0 / PI),
            Self::Texture(texture) if n.dot(to_camera) > 0.0 && n.dot(to_light) > 0.0 => texture.constant(at),
            Self::RoughConductor(rough) => rough.eval(n, to_camera, to_light),
            Self::RoughDielectric(rough) => rough.eval(n, to_camera, to_light),
            Self::Custom(custom) => custom.eval(at, to_camera, to_light),
            Self::TwoSided(reflector) => Self::from(reflector).eval(&self.facing_at(at, to_camera), to_camera, to_light),
            _ => Colour::ZERO,
        }
    }

    /// f_r, or what is left of it without its delta factor at a specular vertex.
    pub fn eval_or_weight(&self, at: &SurfacePoint, to_camera: DVec3, to_light: DVec3) -> Colour {
        let n = at.normal;
        match *self {
            Self::Mirror { reflectance } if n.dot(to_camera) > 0.0 && n.dot(to_light) > 0.0 => reflectance,
            Self::Conductor(metal) if n.dot(to_camera) > 0.0 && n.dot(to_light) > 0.0 => metal.fresnel(n.dot(to_camera)),
            Self::Dielectric { eta } => {
                let interface = Interface::new(n.dot(to_camera), eta);
                let reflected = n.dot(to_camera) * n.dot(to_light) > 0.0;
                let (f, eta) = (interface.fresnel(), interface.relative);
                Colour::splat(if reflected { f } else { (1.0 - f) / (eta * eta) })
            }
            Self::TwoSided(reflector) => {
                Self::from(reflector).eval_or_weight(&self.facing_at(at, to_camera), to_camera, to_light)
            }
            _ => self.eval(at, to_camera, to_light),
        }
    }

    /// Density of [`Bsdf::sample`], per steradian.
    pub fn pdf(&self, at: &SurfacePoint, to_camera: DVec3, to_light: DVec3) -> f64 {
        let n = at.normal;
        match *self {
            Self::Diffuse { .. } | Self::Texture(_) if n.dot(to_camera) > 0.0 => n.dot(to_light).max(0.0) * (1.0 / PI),
            Self::RoughConductor(rough) => rough.pdf(n, to_camera, to_light),
            Self::RoughDielectric(rough) => rough.pdf(n, to_camera, to_light),
            Self::Custom(custom) => custom.pdf(at, to_camera, to_light),
            Self::TwoSided(reflector) => Self::from(reflector).pdf(&self.facing_at(at, to_camera), to_camera, to_light),
            _ => 0.0,
        }
    }

    /// Density with which a specular surface sends light that comes from the direction `from` to the one that follows, `to`: without its
    /// delta factor, in a measure that is the same both ways, projected solid angle times squared index of refraction.
    pub fn specular_density(&self, n: DVec3, from: DVec3, to: DVec3) -> f64 {
        let cosine = n.dot(to);
        let Self::Dielectric { eta } = *self else { return cosine.abs() };
        let fresnel = Interface::new(n.dot(from), eta).fresnel();
        let probability = if n.dot(from) * cosine > 0.0 { fresnel } else { 1.0 - fresnel };
        probability * cosine.abs() * if cosine > 0.0 { 1.0 } else { eta * eta }
    }

    /// ∂log f_r/∂to_camera and ∂log f_r/∂to_light per colour channel, as unconstrained vectors: for a direction ω to a point at a
    /// distance d, the gradient with respect to that point is (I − ωωᵀ)/d times it. 0 where f_r does not depend on the direction, or is 0.
    /// None: the host does not tell.
    pub fn log_gradient(&self, at: &SurfacePoint, to_camera: DVec3, to_light: DVec3) -> Option<LogGradients> {
        let n = at.normal;
        match *self {
            Self::RoughConductor(rough) => Some(rough.log_gradient(n, to_camera, to_light)),
            Self::RoughDielectric(rough) => Some(rough.log_gradient(n, to_camera, to_light)),
            Self::Custom(custom) => custom.log_gradient(at, to_camera, to_light),
            Self::TwoSided(reflector) => {
                Self::from(reflector).log_gradient(&self.facing_at(at, to_camera), to_camera, to_light)
            }
            _ => Some(NO_GRADIENT),
        }
    }

    /// A direction towards the lights; `lobe` chooses between reflection and refraction. None if nothing is scattered.
    pub fn sample(&self, at: &SurfacePoint, to_camera: DVec3, u: DVec2, lobe: f64) -> Option<BsdfSample> {
        let n = at.normal;
        let cosine = n.dot(to_camera);
        match *self {
            Self::Diffuse { albedo } if cosine > 0.0 => sample_diffuse(n, u, albedo),
            Self::Texture(texture) if cosine > 0.0 => sample_diffuse(n, u, texture.constant(at) * PI),
            Self::Mirror { reflectance } if cosine > 0.0 => Some(specular(reflect(n, to_camera), reflectance, 1.0)),
            Self::Dielectric { eta } => Some(sample_dielectric(n, to_camera, eta, lobe)),
            Self::Conductor(metal) if cosine > 0.0 => Some(specular(reflect(n, to_camera), metal.fresnel(cosine), 1.0)),
            Self::RoughConductor(rough) => rough.sample(n, to_camera, u),
            Self::RoughDielectric(rough) => rough.sample(n, to_camera, u, lobe),
            Self::Custom(custom) => custom.sample(at, to_camera, u, lobe),
            Self::TwoSided(reflector) => Self::from(reflector).sample(&self.facing_at(at, to_camera), to_camera, u, lobe),
            _ => None,
        }
    }

    /// The numbers, `u` and `lobe`, from which [`Bsdf::sample`] makes `direction`; [`ANY`] where any will do, and of a lobe's numbers the
    /// middle. None if there are none, or only the host knows. A smooth surface takes it on trust that the direction is one that it makes.
    pub fn invert(&self, n: DVec3, to_camera: DVec3, direction: DVec3) -> Option<(DVec2, f64)> {
        let (cosine, beyond) = (n.dot(to_camera), n.dot(direction));
        let front = cosine > 0.0 && beyond > 0.0;
        match *self {
            Self::Diffuse { .. } | Self::Texture(_) if front => Some((hemisphere_number(n, direction), ANY)),
            Self::Mirror { .. } | Self::Conductor(_) if front => Some((DVec2::splat(ANY), ANY)),
            Self::Dielectric { eta } => {
                let lobe = Interface::new(cosine, eta).lobe(cosine * beyond > 0.0)?;
                Some((DVec2::splat(ANY), lobe))
            }
            Self::RoughConductor(rough) => rough.invert(n, to_camera, direction).map(|u| (u, ANY)),
            Self::RoughDielectric(rough) => rough.invert(n, to_camera, direction),
            Self::TwoSided(reflector) => Self::from(reflector).invert(self.facing(n, to_camera), to_camera, direction),
            _ => None,
        }
    }
}

fn sample_diffuse(n: DVec3, u: DVec2, albedo: Colour) -> Option<BsdfSample> {
    let d = uniform_disk(u);
    let height = sqrt((1.0 - d.length_squared()).max(0.0));
    let (s, t) = orthonormal_basis(n);
    let pdf = height * (1.0 / PI);
    let direction = s * d.x + t * d.y + n * height;
    (pdf > 0.0).then_some(BsdfSample { direction, weight: albedo, pdf: Some(pdf), eta_squared: 1.0 })
}

fn specular(direction: DVec3, weight: Colour, eta_squared: f64) -> BsdfSample {
    BsdfSample { direction, weight, pdf: None, eta_squared }
}

fn reflect(n: DVec3, away: DVec3) -> DVec3 {
    2.0 * n.dot(away) * n - away
}

/// Reflects with the Fresnel probability, else refracts. Radiance is divided by η² on the way into the denser side.
fn sample_dielectric(n: DVec3, to_camera: DVec3, eta: f64, lobe: f64) -> BsdfSample {
    let cosine = n.dot(to_camera);
    let facing = if cosine > 0.0 { n } else { -n };
    let interface = Interface::new(cosine, eta);
    if lobe < interface.fresnel() {
        return specular(reflect(facing, to_camera), Colour::ONE, 1.0);
    }
    let eta_squared = interface.relative * interface.relative;
    specular(interface.refract(facing, to_camera).normalize(), Colour::splat(1.0 / eta_squared), eta_squared)
}
