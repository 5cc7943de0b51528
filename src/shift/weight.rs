//! The weights W of a batch's members, mode by mode.

use super::gradient::GroupGradients;
use super::kernel::{Mode, Options};
use super::place::{Member, Spot};
use super::run::{GROUPS, Groups, Progress, Shiftable};
use crate::math::{Colour, DVec2, exp, luminance};
use crate::scene::Scene;

/// Largest weight, and inverse of the smallest, with which a splat moves where weights are ratios f(y)/f(x). The relation "f(x) and f(y)
/// differ by this factor at most" is symmetric, so keeping the splat at x otherwise costs no bias, and no factor of f (1/d² next to a
/// neighbour, σ_s(y)/σ_s(x) where a density runs out) can make the variance infinite. A linear log f means nothing beyond it either.
const MAX_RATIO: f64 = 4.0;

fn moves(ratio: f64) -> bool {
    ratio * MAX_RATIO >= 1.0 && ratio <= MAX_RATIO
}

/// A batch while its splats are made. All weights are divided by the number of members, the path itself included.
pub(super) struct Weighing<'a> {
    path: &'a Shiftable,
    own: Progress,
    /// `rest` of each group, and all that it carries at x.
    rests: Groups,
    carried: Groups,
    /// The groups that carry something.
    groups: [u8; GROUPS],
    group_count: usize,
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
        let mut weighing = Self {
            path,
            own,
            rests,
            carried,
            groups: [0; GROUPS],
            group_count: 0,
            share,
            at_own: Colour::ZERO,
            shifts: 0,
            stays: 0,
        };
        for (g, carried) in carried.iter().enumerate() {
            if carried.max_element() > 0.0 {
                weighing.groups[weighing.group_count] = g as u8;
                weighing.group_count += 1;
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

    fn groups(&self) -> impl Iterator<Item = usize> + use<> {
        let (groups, count) = (self.groups, self.group_count);
        groups.into_iter().take(count).map(usize::from)
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

    /// W from ⟨∇log f, offset⟩; 1 at x itself for a member without a pixel.
    pub fn linear(
        &mut self,
        options: &Options,
        gradients: &GroupGradients,
        spot: &Spot,
        splat: &mut impl FnMut(DVec2, Colour),
    ) {
        let offset = spot.y - self.path.first().x;
        let clamp = |w: f64| w.clamp(-options.clamp, options.clamp);
        let split = self.split(|own, g| {
            spot.pixel?;
            let slope = gradients[g].dot(offset);
            let w = match options.mode {
                Mode::FirstOrder => clamp(1.0 + slope),
                Mode::HalfOrder => clamp(1.0 + 0.5 * slope),
                _ => Some(exp(slope)).filter(|w| moves(*w))?,
            };
            Some(own.carried[g] * w)
        });
        self.add(spot.pixel, split, splat);
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
