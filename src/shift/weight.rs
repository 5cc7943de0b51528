//! The weights W of a batch's members, mode by mode.

use super::gradient::GroupGradients;
use super::kernel::{Mode, Options};
use super::place::Member;
use super::run::{GROUPS, Groups, Progress, Shiftable};
use super::spots::Spots;
use crate::math::{BVec4, Colour, DVec2, DVec4, exp_of_small, luminance};
use crate::scene::Scene;

/// Largest weight, and inverse of the smallest, with which a splat moves where weights are ratios f(y)/f(x). The relation "f(x) and f(y)
/// differ by this factor at most" is symmetric, so keeping the splat at x otherwise costs no bias, and no factor of f (1/d² next to a
/// neighbour, σ_s(y)/σ_s(x) where a density runs out) can make the variance infinite. A linear log f means nothing beyond it either.
const MAX_RATIO: f64 = 4.0;

/// Its logarithm.
const LARGEST_SLOPE: f64 = 2.0 * core::f64::consts::LN_2;

fn moves(ratio: f64) -> bool {
    ratio * MAX_RATIO >= 1.0 && ratio <= MAX_RATIO
}

/// W of several members from ⟨∇log f, offset⟩, and which of them move; 0 for those that stay.
#[inline(always)]
fn linear_weights(options: &Options, slope: DVec4) -> (DVec4, BVec4) {
    let clamped = |w: DVec4| (w.max(DVec4::splat(-options.clamp)).min(DVec4::splat(options.clamp)), BVec4::TRUE);
    match options.mode {
        Mode::FirstOrder => clamped(1.0 + slope),
        Mode::HalfOrder => clamped(1.0 + 0.5 * slope),
        _ => {
            let moves = slope.abs().cmple(DVec4::splat(LARGEST_SLOPE));
            (DVec4::select(moves, exp_of_small(slope), DVec4::ZERO), moves)
        }
    }
}

/// A batch while its splats are made. All weights are divided by the number of members, the path itself included.
pub(super) struct Weighing<'a> {
    path: &'a Shiftable,
    own: Progress,
    /// `rest` of each group, and all that it carries at x.
    rests: Groups,
    carried: Groups,
    /// Bit g: group g carries something.
    carrying: u32,
    share: f64,
    /// What goes to the path's own pixel.
    at_own: Colour,
    pub shifts: u64,
    pub stays: u64,
}

/// What of a member's splat goes to its pixel, and what to the path's own.
#[derive(Clone, Copy, Default)]
struct Split {
    there: Colour,
    stays: Colour,
}

impl<'a> Weighing<'a> {
    pub fn new(scene: &Scene, path: &'a Shiftable, others: usize) -> Self {
        let (own, rests) = (path.own(scene), path.rests());
        let carried: Groups = core::array::from_fn(|g| own.values[g] * rests[g]);
        let share = 1.0 / (others + 1) as f64;
        let mut weighing = Self { path, own, rests, carried, carrying: 0, share, at_own: Colour::ZERO, shifts: 0, stays: 0 };
        for (g, carried) in carried.iter().enumerate() {
            if carried.max_element() > 0.0 {
                weighing.carrying |= 1 << g;
                weighing.at_own += carried * share;
            }
        }
        weighing
    }

    pub fn own(&self) -> &Progress {
        &self.own
    }

    /// The path's own splat.
    pub fn finish(&self, splat: &mut impl FnMut(DVec2, Colour)) {
        splat(self.path.image.pixel, self.at_own);
    }

    /// The groups that carry something.
    fn groups(&self) -> impl Iterator<Item = usize> + use<> {
        let mut left = self.carrying;
        core::iter::from_fn(move || {
            let first = left.trailing_zeros();
            left &= left.wrapping_sub(1);
            Some(first as usize).filter(|first| *first < GROUPS)
        })
    }

    /// Weighs a member's groups; None: that group's splat stays.
    fn split(&mut self, mut weigh: impl FnMut(&Self, usize) -> Option<Colour>) -> Split {
        let mut split = Split::default();
        for g in self.groups() {
            self.shifts += 1;
            match weigh(self, g) {
                Some(there) => split.there += there,
                None => {
                    split.stays += self.carried[g];
                    self.stays += 1;
                }
            }
        }
        split
    }

    fn add(&mut self, pixel: Option<DVec2>, split: Split, splat: &mut impl FnMut(DVec2, Colour)) {
        self.at_own += split.stays * self.share;
        if let Some(pixel) = pixel {
            splat(pixel, split.there * self.share);
        }
    }

    /// W = f(y)/f(x), or 1 at x itself where that is 0 or out of bounds.
    pub fn ratio(&mut self, member: &Member, splat: &mut impl FnMut(DVec2, Colour)) {
        let split = self.split_ratio(member);
        self.add(member.pixel(), split, splat);
    }

    fn split_ratio(&mut self, member: &Member) -> Split {
        self.split(|own, g| {
            let y = member.value.as_ref()?.values[g];
            let ratio = luminance(y) / luminance(own.own.values[g]);
            moves(ratio).then(|| y * own.rests[g])
        })
    }

    /// `cheap`, corrected by `exact` in the name of `share` members.
    pub fn corrected(&mut self, cheap: &Member, exact: &Member, share: f64, splat: &mut impl FnMut(DVec2, Colour)) {
        let (c, e) = (self.split_ratio(cheap), self.split_ratio(exact));
        let there = c.there + (e.there - c.there) * share;
        let stays = c.stays + (e.stays - c.stays) * share;
        self.add(cheap.pixel(), Split { there, stays }, splat);
    }

    /// W from ⟨∇log f, offset⟩; 1 at x itself for members without a spot.
    pub fn linear(
        &mut self,
        options: &Options,
        gradients: &GroupGradients,
        spots: &Spots,
        splat: &mut impl FnMut(DVec2, Colour),
    ) {
        let mut stay_counts = [spots.members - spots.len(); GROUPS];
        for ([x, y, z], pixels) in spots.blocks() {
            let mut there = [DVec4::ZERO; 3];
            let lanes = (1 << pixels.len()) - 1;
            for g in self.groups() {
                let slope = gradients[g].x * x + gradients[g].y * y + gradients[g].z * z;
                let (weight, moves) = linear_weights(options, slope);
                if !moves.all() {
                    stay_counts[g] += (!moves.bitmask() & lanes).count_ones() as usize;
                }
                for (channel, carried) in there.iter_mut().zip(self.carried[g].to_array()) {
                    *channel += carried * weight;
                }
            }
            let [r, g, b] = there.map(|channel| (channel * self.share).to_array());
            for (pixel, ((r, g), b)) in pixels.iter().zip(r.into_iter().zip(g).zip(b)) {
                splat(*pixel, Colour::new(r, g, b));
            }
        }
        for g in self.groups() {
            self.shifts += spots.members as u64;
            self.stays += stay_counts[g] as u64;
            self.at_own += self.carried[g] * (stay_counts[g] as f64 * self.share);
        }
    }

    /// W = s(y)/Σs over all members, s being the luminance of what changes. Where f(y) = 0 a member gets nothing.
    pub fn exchangeable(&mut self, members: &[Member], splat: &mut impl FnMut(DVec2, Colour)) {
        self.at_own = Colour::ZERO;
        let mut factors = [Colour::ZERO; GROUPS];
        for g in self.groups() {
            let s = |value: &Progress| luminance(value.values[g]);
            let others = members.iter().map(|member| member.value.as_ref().map_or(0.0, s));
            self.shifts += members.len() as u64;
            self.stays += others.clone().filter(|s| !(*s > 0.0)).count() as u64;
            let own = s(&self.own);
            let share = own / (own + others.sum::<f64>());
            // s(x) > 0 unless it underflows; the contribution is then nothing too.
            factors[g] = if own > 0.0 { self.rests[g] * share } else { Colour::ZERO };
            self.at_own += self.own.values[g] * factors[g];
        }
        for member in members {
            let (Some(image), Some(value)) = (member.image, &member.value) else { continue };
            let there: Colour = self.groups().map(|g| value.values[g] * factors[g]).sum();
            splat(image.pixel, there);
        }
    }
}
