//! Optical depth, its gradients, and distance sampling along an edge that crosses several media.

use super::{Inversion, Medium, Moments, Stretch};
use crate::math::{Colour, DVec3, Vec3, absorptance, log1p, mean, transmittance};

/// "None" wherever an index is expected: no medium (vacuum), no light.
pub const NONE: u32 = 0xFFFF_FFFF;

/// One stretch of a ray or edge inside one medium.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// Where it ends: distance from the ray's origin or the edge's first vertex, world units; not decreasing along the list.
    /// The last segment of an edge to infinity ends at INFINITY; that of a finite edge may end anywhere at or past the edge's end.
    pub end: f32,
    /// The medium, or `VOLGRAD_NONE`.
    pub medium: u32,
    /// Unit normal of the surface that ends it, either orientation. Unused for the last segment.
    pub normal: Vec3,
}

/// A straight edge and the media along it.
#[derive(Clone, Copy, Debug)]
pub struct Line<'a> {
    pub media: &'a [Medium<'a>],
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Media count from here on; > 0 only for a camera's edge: its near plane.
    pub start: f64,
    /// Normal of the plane at `start`.
    pub start_normal: DVec3,
    /// Where the segments' ends are measured from.
    pub segments_start: f64,
    /// Distance from the origin to the far end; may be infinite.
    pub length: f64,
    pub segments: &'a [Segment],
}

/// Where light is stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// Distance from the line's origin.
    pub t: f64,
    pub medium: u32,
    /// Of the way there.
    pub optical_depth: Colour,
    /// σ_t there.
    pub extinction: Colour,
    /// Of the distance, per unit.
    pub pdf: f64,
}

/// What [`sample_distance`] finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flight {
    Collision(Collision),
    /// The far end is reached, which has this `probability`.
    Passed {
        optical_depth: Colour,
        probability: f64,
    },
}

/// Optical depth of a whole edge q → x and its derivatives, per colour channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct EdgeMoments {
    pub optical_depth: Colour,
    /// ∫ ∇σ_t dt, jumps at faces included.
    pub gradient: [DVec3; 3],
    /// ∫ t ∇σ_t dt, t from q.
    pub first_moment: [DVec3; 3],
}

impl EdgeMoments {
    /// ∇τ with respect to the far end of a finite edge.
    pub fn far_gradient(&self, direction: DVec3, length: f64) -> [DVec3; 3] {
        let per_length = 1.0 / length;
        core::array::from_fn(|c| (direction * self.optical_depth[c] + self.first_moment[c]) * per_length)
    }

    /// ∇τ with respect to the near end; an infinite edge keeps its direction.
    pub fn near_gradient(&self, direction: DVec3, length: f64) -> [DVec3; 3] {
        if length.is_infinite() {
            return self.gradient;
        }
        let far = self.far_gradient(direction, length);
        core::array::from_fn(|c| self.gradient[c] - far[c])
    }
}

impl<'a> Line<'a> {
    /// An edge whose media count from its origin on.
    pub fn new(media: &'a [Medium<'a>], origin: DVec3, direction: DVec3, length: f64, segments: &'a [Segment]) -> Self {
        Self { media, origin, direction, start: 0.0, start_normal: DVec3::ZERO, segments_start: 0.0, length, segments }
    }

    pub(super) fn medium(&self, index: u32) -> Option<&'a Medium<'a>> {
        self.media.get(index as usize)
    }

    /// The stretches in order, empty ones left out.
    pub(super) fn stretches(&self) -> impl Iterator<Item = (Stretch, &'a Segment)> + use<'a> {
        let Self { origin, direction, start, segments_start, length, segments, .. } = *self;
        let last = segments.len().wrapping_sub(1);
        let mut begin = start;
        segments.iter().enumerate().filter_map(move |(i, segment)| {
            let end = if i == last { length } else { (segments_start + f64::from(segment.end)).min(length) };
            let stretch = Stretch { origin, direction, start: begin, end };
            (end > begin).then(|| {
                begin = end;
                (stretch, segment)
            })
        })
    }
}

/// τ of the whole line, per channel.
pub fn optical_depth(line: &Line) -> Colour {
    let mut total = Colour::ZERO;
    for (stretch, segment) in line.stretches() {
        if let Some(medium) = line.medium(segment.medium) {
            total += scaled(medium.sigma_t, medium.density.integral(&stretch));
        }
    }
    total
}

/// Beyond this optical depth less than 2⁻⁶⁴ arrives, the film's least bit for light of radiance 1.
const NEGLIGIBLE_DEPTH: f64 = 44.4;

/// τ of the whole line, or infinity as soon as it is known to be beyond [`NEGLIGIBLE_DEPTH`] in all channels: the rest is not looked at.
pub fn optical_depth_or_dark(line: &Line) -> Colour {
    let mut total = Colour::ZERO;
    for (stretch, segment) in line.stretches() {
        let Some(medium) = line.medium(segment.medium) else { continue };
        let left = (Colour::splat(NEGLIGIBLE_DEPTH) - total) / medium.sigma_t;
        match medium.density.invert(&stretch, left.max_element().max(0.0)) {
            Inversion::Beyond(integral) => total += scaled(medium.sigma_t, integral),
            Inversion::At(_) => return Colour::INFINITY,
        }
    }
    total
}

/// σ·integral, where no extinction over an infinite distance is none.
pub(super) fn scaled(sigma: Colour, integral: f64) -> Colour {
    Colour::select(sigma.cmpgt(Colour::ZERO), sigma * integral, Colour::ZERO)
}

/// τ and what its gradients at both ends need.
pub fn moments(line: &Line) -> EdgeMoments {
    let mut sum = Sum::new(line);
    for (stretch, segment) in line.stretches() {
        let medium = line.medium(segment.medium);
        sum.add(line, stretch.start, segment, medium, &medium.map_or_else(Moments::default, |m| m.density.moments(&stretch)));
    }
    sum.moments
}

/// Adds up stretch by stretch.
struct Sum {
    moments: EdgeMoments,
    /// The face before the next stretch, if there is one, and σ_t before it.
    face: Option<(DVec3, Colour)>,
}

impl Sum {
    fn new(line: &Line) -> Self {
        Self { moments: EdgeMoments::default(), face: (line.start > 0.0).then_some((line.start_normal, Colour::ZERO)) }
    }

    /// A stretch from `start`, of which `m` are the moments.
    fn add(&mut self, line: &Line, start: f64, segment: &Segment, medium: Option<&Medium>, m: &Moments) {
        let sigma_t = medium.map_or(Colour::ZERO, |medium| medium.sigma_t);
        self.moments.optical_depth += scaled(sigma_t, m.integral);
        for c in 0..3 {
            self.moments.gradient[c] += sigma_t[c] * m.gradient;
            self.moments.first_moment[c] += sigma_t[c] * m.first_moment;
        }
        if let Some((normal, before)) = self.face {
            add_face(&mut self.moments, line.direction, start, normal, before, sigma_t * m.at_start);
        }
        self.face = Some((segment.normal.wide(), sigma_t * m.at_end));
    }
}

/// A face crossed at distance `t`, σ_t jumping from `before` to `after`: −(σ₁ − σ₂) n/(n·direction).
pub(super) fn add_face(sum: &mut EdgeMoments, direction: DVec3, t: f64, normal: DVec3, before: Colour, after: Colour) {
    if before == after {
        return;
    }
    let slope = normal / normal.dot(direction);
    for c in 0..3 {
        let jump = (after[c] - before[c]) * slope;
        sum.gradient[c] += jump;
        sum.first_moment[c] += t * jump;
    }
}

/// A collision distance from one uniform number u ∈ (0, 1). The cdf is the mean of the channels' cdfs, 1 − exp(−τ), so that one
/// number serves chromatic media too; the pdf is the mean of σ_t·exp(−τ).
pub fn sample_distance(line: &Line, u: f64) -> Flight {
    find_collision(line, u, |medium, stretch, target| medium.density.invert(stretch, target))
}

/// The same with any way to invert a stretch's integral.
#[inline(always)]
pub(super) fn find_collision(line: &Line, u: f64, invert: impl Fn(&Medium, &Stretch, f64) -> Inversion) -> Flight {
    let mut optical_depth = Colour::ZERO;
    for (stretch, segment) in line.stretches() {
        let Some(medium) = line.medium(segment.medium) else { continue };
        let target = density_until(optical_depth, medium.sigma_t, u);
        match invert(medium, &stretch, target) {
            Inversion::At(t) => {
                optical_depth += scaled(medium.sigma_t, target);
                return collision(&stretch, t, segment.medium, medium, optical_depth);
            }
            Inversion::Beyond(integral) => optical_depth += scaled(medium.sigma_t, integral),
        }
    }
    Flight::Passed { optical_depth, probability: mean(transmittance(optical_depth)) }
}

/// The same as [`sample_distance`], and the moments of what was flown: up to the collision, or to the end.
pub fn sample_distance_with_moments(line: &Line, u: f64) -> (Flight, EdgeMoments) {
    let mut sum = Sum::new(line);
    for (stretch, segment) in line.stretches() {
        let Some(medium) = line.medium(segment.medium) else {
            sum.add(line, stretch.start, segment, None, &Moments::default());
            continue;
        };
        let target = density_until(sum.moments.optical_depth, medium.sigma_t, u);
        let (found, moments) = medium.density.invert_with_moments(&stretch, target);
        sum.add(line, stretch.start, segment, Some(medium), &moments);
        if let Inversion::At(t) = found {
            return (collision(&stretch, t, segment.medium, medium, sum.moments.optical_depth), sum.moments);
        }
    }
    let optical_depth = sum.moments.optical_depth;
    (Flight::Passed { optical_depth, probability: mean(transmittance(optical_depth)) }, sum.moments)
}

fn collision(stretch: &Stretch, t: f64, index: u32, medium: &Medium, optical_depth: Colour) -> Flight {
    let (density, along) = medium.density.at_and_along(stretch, t);
    let pdf = mean(medium.sigma_t * along * transmittance(optical_depth));
    Flight::Collision(Collision { t, medium: index, optical_depth, extinction: medium.sigma_t * density, pdf })
}

/// The density with which [`sample_distance`] makes a collision at the end of a finite line, whose optical depth is given.
pub fn collision_pdf(line: &Line, optical_depth: Colour) -> f64 {
    let last = line.stretches().last().and_then(|(stretch, segment)| Some((stretch, line.medium(segment.medium)?)));
    last.map_or(0.0, |(stretch, medium)| {
        mean(medium.sigma_t * medium.density.along(&stretch, line.length) * transmittance(optical_depth))
    })
}

/// The uniform number from which [`sample_distance`] makes a collision at the end of `line`.
pub fn distance_number(line: &Line) -> f64 {
    mean(absorptance(optical_depth(line)))
}

/// The density integral D ≥ 0 at which mean(exp(−τ − σD)) = 1 − u; infinite if it never gets there.
fn density_until(tau: Colour, sigma: Colour, u: f64) -> f64 {
    let survival = 1.0 - u;
    let grey = |c: Colour| c.x == c.y && c.x == c.z;
    if grey(tau) && grey(sigma) {
        return if sigma.x > 0.0 { ((-log1p(-u) - tau.x) / sigma.x).max(0.0) } else { f64::INFINITY };
    }
    let never = Colour::select(sigma.cmpgt(Colour::ZERO), Colour::ZERO, transmittance(tau));
    if mean(never) >= survival {
        return f64::INFINITY;
    }
    // The mean is convex and falls with D, so Newton climbs from 0 to the root without overshooting.
    let mut d = 0.0;
    loop {
        let t = transmittance(tau + sigma * d);
        let step = (mean(t) - survival) / mean(sigma * t);
        if !(step > 4.0 * f64::EPSILON * d) {
            return d;
        }
        d += step;
    }
}
