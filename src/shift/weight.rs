//! The weights W of a batch's members, mode by mode.

use super::BatchStats;
use super::batch::Member;
use super::link::{Link, LinkValue, MAX_LINKS, MAX_WINGS, Shiftable, towards};
use crate::math::{Colour, DVec2, DVec3, exp, luminance};
use crate::medium::Line;
use crate::path::{LogGradient, Move, Neighbour, log_gradient, wing_log_gradient};
use crate::scene::Scene;

/// Contributions of a link that change alike: those without a wing, and each wing.
const GROUPS: usize = 1 + MAX_WINGS;

/// Per group, the phase function at the far end (1 for the plain group) and what stays.
fn groups(link: &Link, value: &LinkValue) -> [(f64, Colour); GROUPS] {
    core::array::from_fn(|g| match g.checked_sub(1) {
        None => (1.0, link.plain),
        Some(wing) => (value.wings[wing], link.wings[wing].1),
    })
}

/// What all contributions along `link` carry at `value`.
fn carried(link: &Link, value: &LinkValue) -> Colour {
    value.colour * groups(link, value).iter().map(|(wing, rest)| *wing * *rest).sum::<Colour>()
}

impl Shiftable {
    /// What the path carries where it was sampled.
    pub(super) fn carried(&self, scene: &Scene) -> Colour {
        links(self).map(|(i, link)| carried(link, &self.value(scene, i))).sum()
    }
}

fn links(path: &Shiftable) -> impl Iterator<Item = (usize, &Link)> {
    path.links.iter().enumerate().filter_map(|(i, link)| Some((i, link.as_ref()?)))
}

/// Largest weight, and inverse of the smallest, with which `exact` and `log_linear` move a splat. The relation "f(x) and f(y) differ by
/// this factor at most" is symmetric, so keeping the splat at x otherwise costs no bias, and no factor of f (1/d² next to a neighbour,
/// σ_s(y)/σ_s(x) where a density runs out) can make the variance infinite. A linear log f means nothing beyond it either.
const MAX_RATIO: f64 = 4.0;

fn moves(ratio: f64) -> bool {
    ratio * MAX_RATIO >= 1.0 && ratio <= MAX_RATIO
}

/// W = f(y)/f(x), or 1 at x itself where that is 0 or out of bounds.
pub(super) fn exact(path: &Shiftable, members: &[Member], splat: &mut impl FnMut(DVec2, Colour)) -> BatchStats {
    let Some((own, others)) = members.split_first() else { return BatchStats::default() };
    let share = 1.0 / members.len() as f64;
    let mut stats = BatchStats::default();
    let mut at_own: Colour = links(path).map(|(i, link)| carried(link, &own.links[i])).sum();
    for member in others {
        let mut there = Colour::ZERO;
        for (i, link) in links(path) {
            let (here, y) = (&own.links[i], &member.links[i]);
            let ratio = luminance(y.colour) / luminance(here.colour);
            let pairs = groups(link, here).into_iter().zip(groups(link, y));
            for ((wing, rest), (wing_y, _)) in pairs.filter(|((_, rest), _)| *rest != Colour::ZERO) {
                stats.shifts += 1;
                if moves(ratio * wing_y / wing) {
                    there += y.colour * rest * wing_y;
                } else {
                    at_own += here.colour * rest * wing;
                    stats.stays += 1;
                }
            }
        }
        if let Some(image) = member.image {
            splat(image.pixel, there * share);
        }
    }
    splat(path.image.pixel, at_own * share);
    stats
}

/// W = s(y)/Σs over all members, s being the luminance of what changes. Where f(y) = 0 a member gets nothing.
pub(super) fn exchangeable(path: &Shiftable, members: &[Member], splat: &mut impl FnMut(DVec2, Colour)) -> BatchStats {
    let Some(own) = members.first() else { return BatchStats::default() };
    let mut shares = [[0.0; GROUPS]; MAX_LINKS];
    let mut stats = BatchStats::default();
    for (i, link) in links(path) {
        let mut sums = [0.0; GROUPS];
        for member in members {
            let value = &member.links[i];
            let s = luminance(value.colour);
            stats.stays += u64::from(!(s > 0.0));
            for (sum, (wing, _)) in sums.iter_mut().zip(groups(link, value)) {
                *sum += s * wing;
            }
        }
        stats.shifts += members.len() as u64 - 1;
        let s = luminance(own.links[i].colour);
        for (share, (sum, (wing, _))) in shares[i].iter_mut().zip(sums.iter().zip(groups(link, &own.links[i]))) {
            // s(x) > 0 unless it underflows; the contribution is then nothing too.
            *share = if *sum > 0.0 { s * wing / sum } else { 0.0 };
        }
    }
    for member in members {
        let Some(image) = member.image else { continue };
        let mut there = Colour::ZERO;
        for (i, link) in links(path) {
            let value = &member.links[i];
            for (share, (wing, rest)) in shares[i].iter().zip(groups(link, value)) {
                there += value.colour * rest * (wing * share);
            }
        }
        splat(image.pixel, there);
    }
    stats
}

/// W = exp⟨∇log f*, offset⟩, whatever is in the way; 1 at x itself where y is off the image, where the medium of x is empty, or where W
/// is out of bounds.
pub(super) fn log_linear(
    scene: &Scene,
    path: &Shiftable,
    members: &[Member],
    splat: &mut impl FnMut(DVec2, Colour),
) -> BatchStats {
    let (Some((own, others)), Some(medium)) = (members.split_first(), scene.medium(path.first.medium())) else {
        return BatchStats::default();
    };
    let share = 1.0 / members.len() as f64;
    let gradients: [_; MAX_LINKS] =
        core::array::from_fn(|i| path.links[i].as_ref().map(|link| group_gradients(scene, path, link, &own.links[i])));
    let mut at_own: Colour = links(path).map(|(i, link)| carried(link, &own.links[i])).sum();
    let mut stats = BatchStats::default();
    for member in others {
        let image = member.image.filter(|_| medium.density.at(member.y) > 0.0);
        let mut there = Colour::ZERO;
        for (i, link) in links(path) {
            let Some(gradients) = gradients[i] else { continue };
            let pairs = groups(link, &own.links[i]).into_iter().zip(gradients);
            for ((wing, rest), gradient) in pairs.filter(|((_, rest), _)| *rest != Colour::ZERO) {
                stats.shifts += 1;
                let carried = own.links[i].colour * rest * wing;
                let ratio = exp(gradient.dot(member.y - path.x));
                if image.is_some() && moves(ratio) {
                    there += carried * ratio;
                } else {
                    at_own += carried;
                    stats.stays += 1;
                }
            }
        }
        if let Some(image) = image {
            splat(image.pixel, there * share);
        }
    }
    splat(path.image.pixel, at_own * share);
    stats
}

/// ∇log f* of each group of a link; 0 for groups that carry nothing.
fn group_gradients(scene: &Scene, path: &Shiftable, link: &Link, value: &LinkValue) -> [DVec3; GROUPS] {
    let Some(medium) = scene.medium(path.first.medium()) else { return [DVec3::ZERO; GROUPS] };
    let (camera, next) = (&scene.camera.at(path.image.ray.origin), link.neighbour());
    let (direction, length) = towards(path.x, &link.next);
    let shared = log_gradient(
        camera,
        &Move {
            x: path.x,
            medium,
            previous: Neighbour::Camera,
            next,
            previous_line: path.camera_line(scene),
            next_line: Line::new(scene.media, path.x, direction, length, link.media.segments()),
            previous_wing: None,
            next_wing: None,
        },
    );
    let wing_of = |g: usize| g.checked_sub(1).and_then(|wing| link.wing(wing));
    let groups = groups(link, value);
    core::array::from_fn(|g| {
        let (wing, colour) = (wing_of(g), value.colour * groups[g].1);
        let gradient = shared.filter(|_| luminance(colour) > 0.0).map(|shared| {
            let phase_next = wing.map_or(DVec3::ZERO, |wing| wing_log_gradient(camera, path.x, next, &wing));
            LogGradient { phase_next, ..shared }.of_luminance(colour)
        });
        gradient.unwrap_or(DVec3::ZERO)
    })
}
