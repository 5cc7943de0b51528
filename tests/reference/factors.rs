//! The factors of f that change when one inner medium vertex x moves, p its neighbour before and n the one after. One name
//! for each, whether it holds the logarithm or the gradient of that logarithm.

use super::vector::*;

/// `T` is `f64` for log-factors, [`Vec3`] for their gradients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors<T> {
    /// σ_s(x).
    pub scattering: T,
    /// Tr(p, x), per channel.
    pub transmittance_prev: [T; 3],
    /// Tr(x, n), per channel.
    pub transmittance_next: [T; 3],
    /// G(p, x): 1/d² and the cosine at p, if p is a surface or the camera.
    pub geometry_prev: T,
    /// G(x, n): 1/d² and the cosine at n, if n is a surface or an area light.
    pub geometry_next: T,
    /// cos⁻⁴θ of the camera alone, if p is the camera.
    pub importance: T,
    /// What p scatters, seen from x: phase function or BSDF, per channel.
    pub profile_prev: [T; 3],
    /// Phase function at x itself, the apex.
    pub phase_apex: T,
    /// What n scatters or emits, seen from x: phase function, BSDF or emission, per channel.
    pub profile_next: [T; 3],
}

pub const FACTORS: usize = 17;

/// What [`Factors::to_array`] lists.
pub const FACTOR_NAMES: [&str; FACTORS] = [
    "scattering",
    "transmittance_prev red",
    "transmittance_prev green",
    "transmittance_prev blue",
    "transmittance_next red",
    "transmittance_next green",
    "transmittance_next blue",
    "geometry_prev",
    "geometry_next",
    "importance",
    "profile_prev red",
    "profile_prev green",
    "profile_prev blue",
    "phase_apex",
    "profile_next red",
    "profile_next green",
    "profile_next blue",
];

impl<T: Copy> Factors<T> {
    pub fn to_array(self) -> [T; FACTORS] {
        let [a, b, c] = self.transmittance_prev;
        let [d, e, f] = self.transmittance_next;
        let [g, h, i] = [self.geometry_prev, self.geometry_next, self.importance];
        let [j, k, l] = self.profile_prev;
        let [m, n, o] = self.profile_next;
        [self.scattering, a, b, c, d, e, f, g, h, i, j, k, l, self.phase_apex, m, n, o]
    }

    pub fn from_array(a: [T; FACTORS]) -> Factors<T> {
        Factors {
            scattering: a[0],
            transmittance_prev: [a[1], a[2], a[3]],
            transmittance_next: [a[4], a[5], a[6]],
            geometry_prev: a[7],
            geometry_next: a[8],
            importance: a[9],
            profile_prev: [a[10], a[11], a[12]],
            phase_apex: a[13],
            profile_next: [a[14], a[15], a[16]],
        }
    }

    /// The nine factors as one channel sees them; their sum is ∇ log f_channel.
    pub fn of_channel(&self, channel: usize) -> [T; 9] {
        [
            self.scattering,
            self.transmittance_prev[channel],
            self.transmittance_next[channel],
            self.geometry_prev,
            self.geometry_next,
            self.importance,
            self.profile_prev[channel],
            self.phase_apex,
            self.profile_next[channel],
        ]
    }
}

impl Factors<Vec3> {
    /// ∇ log f of one channel. Source: [Lu20 (29)], which lacks ∇σ_s/σ_s, importance and cosines.
    pub fn total(&self, channel: usize) -> Vec3 {
        sum(&self.of_channel(channel))
    }

    /// ∇ log f per channel.
    pub fn totals(&self) -> RgbGradient {
        [0, 1, 2].map(|channel| self.total(channel))
    }

    /// ∇ log luminance(f): the mean of the channels' gradients, weighted by what each adds to the luminance of f.
    pub fn luminance(&self, f: Rgb) -> Vec3 {
        let shares = product(LUMINANCE, f);
        let weighted = [0, 1, 2].map(|channel| scale(shares[channel], self.total(channel)));
        scale(1.0 / luminance(f), sum(&weighted))
    }

    /// Σ |factor gradients|, the largest of the channels: the scale against which an error is relative. Factors can cancel
    /// in the total, which is no fault of theirs.
    pub fn magnitude(&self) -> f64 {
        let of = |channel| self.of_channel(channel).iter().map(|&v| length(v)).sum::<f64>();
        [0, 1, 2].map(of).into_iter().fold(0.0, f64::max)
    }
}
