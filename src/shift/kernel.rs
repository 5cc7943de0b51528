//! Where a path is shifted to. Kernels are symmetric: the density of x → y is that of y → x.

use crate::math::pow;
use crate::scene::{Scene, Stop};

/// Most offsets in a batch: a tile of 6 × 6 pixels.
pub const MAX_SHIFTS: usize = 35;

/// Most vertices that move together.
pub const MAX_RUN: usize = 8;

/// How a shifted path is weighted. See ARCHITECTURE.md, "Estimators".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// 1 + ⟨∇log f, offset⟩ [Lu20 (30)]: biased by O(r²).
    FirstOrder,
    /// 1 + ½⟨∇log f, offset⟩: biased by O(r⁴) inside a medium, by O(r) at edges.
    HalfOrder,
    /// exp⟨∇log f, offset⟩: biased by O(r²), no ray queries.
    LogLinear,
    /// f(y)/f(x) with optical depths linear in the offset and light as visible as at x: biased by O(r²), no ray queries.
    LinearDepth,
    /// f(y)/f(x), staying at x where f(y) = 0: unbiased.
    Exact,
    /// `LinearDepth` for all offsets, corrected by `Exact` for some of them: unbiased.
    TwoLevel,
    /// All members around a common centre, weighted f(y)/Σf: unbiased, weights in [0, 1].
    Exchangeable,
}

impl Mode {
    /// Whether batches ask the host about rays.
    pub fn has_queries(self) -> bool {
        matches!(self, Self::Exact | Self::TwoLevel | Self::Exchangeable)
    }

    /// Whether weights are evaluated at y, beginning with what the camera sees there.
    pub fn evaluates(self) -> bool {
        !matches!(self, Self::FirstOrder | Self::HalfOrder | Self::LogLinear)
    }

    /// Whether weights need the derivatives of optical depths.
    pub fn has_derivatives(self) -> bool {
        !matches!(self, Self::Exact | Self::Exchangeable)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radius {
    /// In pixels at the vertex' depth. That is constant on the disk, and so symmetric; not in a ball.
    Pixels(f64),
    World(f64),
}

impl Radius {
    /// In pixels, whose side in world units is `pixel` where the vertex is.
    pub(super) fn in_pixels(self, pixel: f64) -> f64 {
        match self {
            Self::Pixels(pixels) => pixels,
            Self::World(radius) => radius / pixel,
        }
    }

    fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Pixels(pixels) => Self::Pixels(pixels * factor),
            Self::World(radius) => Self::World(radius * factor),
        }
    }
}

/// The radii are those of one step. `Exchangeable` makes two: to the centre, and from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kernel {
    /// The pixels of the square tile that the path's own one is in; tiles cover the image, from a random corner on. Every pixel gets
    /// equally many splats. Source: P. Bekaert et al., *Accelerating Path Tracing by Re-Using Paths*, EGWR 2002.
    Tile,
    /// Uniform in a disk parallel to the image plane. (One perpendicular to the camera ray is not symmetric.)
    Disk(Radius),
    /// Uniform in a ball of this radius, world units.
    Ball(f64),
}

/// How a batch is made: `count` offsets beside the path itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    pub mode: Mode,
    pub kernel: Kernel,
    /// For a tile of n × n pixels n² − 1.
    pub count: usize,
    /// Most medium vertices that move together, from the first on.
    pub run: usize,
    /// `TwoLevel`: how many of the offsets are evaluated exactly.
    pub exact_count: usize,
    /// The radius shrinks as i^((alpha − 1)/3) over the samples i of the image: 1 keeps it.
    pub alpha: f64,
    /// `FirstOrder` and `HalfOrder`: the greatest |W|; infinite for no clamp.
    pub clamp: f64,
}

impl Options {
    /// One vertex moves, at a constant radius.
    pub const fn new(mode: Mode, kernel: Kernel, count: usize) -> Self {
        Self { mode, kernel, count, run: 1, exact_count: 1, alpha: 1.0, clamp: f64::INFINITY }
    }

    /// With the radius after `samples` samples of the image. [Lu20 (46)], but over the whole image's samples instead of one batch's.
    pub fn after(&self, samples: f64) -> Self {
        let factor = pow(samples.max(1.0), (self.alpha - 1.0) / 3.0);
        let kernel = match self.kernel {
            Kernel::Tile => Kernel::Tile,
            Kernel::Disk(radius) => Kernel::Disk(radius.scaled(factor)),
            Kernel::Ball(radius) => Kernel::Ball(radius * factor),
        };
        Self { kernel, ..*self }
    }

    /// Whether paths that begin on a surface are shifted: they move with their image point, and have no gradient.
    pub fn moves_surfaces(&self) -> bool {
        let on_image = matches!(self.kernel, Kernel::Tile | Kernel::Disk(Radius::Pixels(_)));
        on_image && self.mode.evaluates()
    }

    /// Stops modes that have nothing but the gradient where the host does not tell a phase function's. (Links end at no surface or light whose
    /// gradient they would need.)
    pub fn check(&self, scene: &Scene) -> Result<(), Stop> {
        if self.mode.evaluates() { Ok(()) } else { scene.check_phase_derivatives() }
    }

    /// Whether batches need their tile's camera rays.
    pub fn has_views(&self) -> bool {
        self.kernel == Kernel::Tile && self.mode.evaluates()
    }

    /// Pixels along a tile's side.
    pub fn tile_side(&self) -> u32 {
        (1..).take_while(|side| side * side <= self.count as u32 + 1).last().unwrap_or(1)
    }
}

/// Uniform in the unit disk or ball: points of the square or cube around it are tried until all are inside, two for each at most in the
/// mean. Sines and roots take several times as long. One that is outside gives its slot to the next: no branch depends on chance.
pub(crate) fn fill_with_unit_ball<const N: usize>(points: &mut [[f64; N]], random: &mut impl FnMut() -> f64) {
    let mut count = 0;
    while let Some(point) = points.get_mut(count) {
        *point = [0; N].map(|_| 2.0 * random() - 1.0);
        count += usize::from(point.iter().map(|coordinate| coordinate * coordinate).sum::<f64>() < 1.0);
    }
}
