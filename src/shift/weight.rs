//! The weights W of a batch's members, mode by mode.

use super::batch::Member;
use super::link::{Link, LinkValue, MAX_LINKS, MAX_WINGS, Shiftable};
use super::BatchStats;
use crate::math::{Colour, DVec2, DVec3, exp, luminance};
use crate::medium::Line;
use crate::path::{Move, Wing, log_gradient};
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

fn links(path: &Shiftable) -> impl Iterator<Item = (usize, &Link)> {
    path.links.iter().enumerate().filter_map(|(i, link)| Some((i, link.as_ref()?)))
}

/// W = f(y)/f(x). Where f(y) = 0 the splat stays at x; so it does where x or y is within a radius of a neighbour, which keeps
/// 1/d² from making the variance infinite. Both tests are symmetric in x and y.
pub(super) fn exact(
    path: &Shiftable,
    radius: f64,
    members: &[Member],
    splat: &mut impl FnMut(DVec2, Colour),
) -> BatchStats {
    let Some((own, others)) = members.split_first() else { return BatchStats::default() };
    let share = 1.0 / members.len() as f64;
    let clear = |member: &Member, i: usize| {
        member.image.is_some_and(|image| image.distance > radius) && member.links[i].distance > radius
    };
    let mut stats = BatchStats::default();
    let mut at_own: Colour = links(path).map(|(i, link)| carried(link, &own.links[i])).sum();
    for member in others {
        let mut there = Colour::ZERO;
        for (i, link) in links(path) {
            let accepted = clear(own, i) && clear(member, i) && member.links[i].colour.max_element() > 0.0;
            stats.shifts += 1;
            stats.stays += u64::from(!accepted);
            if accepted {
                there += carried(link, &member.links[i]);
            } else {
                at_own += carried(link, &own.links[i]);
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

/// W = exp⟨∇log f*, offset⟩, whatever is in the way; the splat stays at x if y is off the image or where the medium of x is empty.
pub(super) fn log_linear(
    scene: &Scene,
    path: &Shiftable,
    members: &[Member],
    splat: &mut impl FnMut(DVec2, Colour),
) -> BatchStats {
    let (Some((own, others)), Some(medium)) = (members.split_first(), scene.medium(path.medium)) else {
        return BatchStats::default();
    };
    let share = 1.0 / members.len() as f64;
    let gradients: [_; MAX_LINKS] =
        core::array::from_fn(|i| path.links[i].as_ref().map(|link| group_gradients(scene, path, link, &own.links[i])));
    let at_x: Colour = links(path).map(|(i, link)| carried(link, &own.links[i])).sum();
    let mut at_own = at_x;
    let mut stats = BatchStats::default();
    for member in others {
        stats.shifts += 1;
        let Some(image) = member.image.filter(|_| medium.density.at(member.y) > 0.0) else {
            at_own += at_x;
            stats.stays += 1;
            continue;
        };
        let mut there = Colour::ZERO;
        for (i, link) in links(path) {
            for (g, (wing, rest)) in groups(link, &own.links[i]).into_iter().enumerate() {
                let gradient = gradients[i].map_or(DVec3::ZERO, |gradients| gradients[g]);
                there += own.links[i].colour * rest * (wing * exp(gradient.dot(member.y - path.x)));
            }
        }
        splat(image.pixel, there * share);
    }
    splat(path.image.pixel, at_own * share);
    stats
}

/// ∇log f* of each group of a link; 0 for groups that carry nothing.
fn group_gradients(scene: &Scene, path: &Shiftable, link: &Link, value: &LinkValue) -> [DVec3; GROUPS] {
    let (direction, length) = super::link::towards(path.x, &link.next);
    let next_line = Line {
        media: scene.media,
        origin: path.x,
        direction,
        start: 0.0,
        start_normal: DVec3::ZERO,
        length,
        segments: link.media.segments(),
    };
    let gradient = |next_wing: Option<Wing>, colour: Colour| {
        let Some(medium) = scene.medium(path.medium).filter(|_| luminance(colour) > 0.0) else { return DVec3::ZERO };
        let m = Move {
            x: path.x,
            medium,
            previous: crate::path::Neighbour::Camera,
            next: link.neighbour(),
            previous_line: path.camera_line(scene),
            next_line,
            previous_wing: None,
            next_wing,
        };
        log_gradient(&scene.camera, &m).map_or(DVec3::ZERO, |g| g.of_luminance(colour))
    };
    core::array::from_fn(|g| {
        let wing = g.checked_sub(1);
        let rest = wing.map_or(link.plain, |wing| link.wings[wing].1);
        gradient(wing.and_then(|wing| link.wing(wing)), value.colour * rest)
    })
}
