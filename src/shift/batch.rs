//! A batch: the path where it was sampled and its shifted copies, as weighted splats. [Lu20 alg. 2]
//!
//! Differs from [Lu20 alg. 2]: the radius does not shrink within a batch, and the unbiased modes evaluate f(y), visibility included.

use super::evaluate::{CHUNK, Evaluation, Hits};
use super::gradient::group_gradients;
use super::place::{Draw, Member, Members, place, place_on_rays};
use super::run::Shiftable;
use super::spots::Spots;
use super::tile::Tile;
use super::weight::Weighing;
use super::{Mode, Options};
use crate::math::{Colour, DVec2};
use crate::scene::{Hit, Queries, Scene, Stop};

/// What became of a batch's offsets; those that change several contributions differently count once for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BatchStats {
    pub shifts: u64,
    /// Those whose splat stayed at the path's own pixel.
    pub stays: u64,
    pub rays: u64,
    pub occlusion_rays: u64,
    pub overflows: u64,
}

/// Room for the work on one batch after another. What only some modes need is made when they do: it is large.
#[derive(Default)]
pub struct Scratch {
    spots: Spots,
    evaluated: Option<Evaluated>,
    exact: Option<Members>,
}

/// What a slot holds, made if it is empty. Out of line: what is made passes over the stack, and need not stay there.
#[inline(never)]
pub fn made<T: Default>(slot: &mut Option<T>) -> &mut T {
    slot.get_or_insert_default()
}

/// Members whose f is evaluated, and answers about their rays.
struct Evaluated {
    members: Members,
    hits: Hits,
}

impl Default for Evaluated {
    fn default() -> Self {
        Self { members: Members::default(), hits: [Hit::EMPTY; CHUNK] }
    }
}

/// Splats the path and its shifted copies: `splat(pixel, rgb)` is called `options.count` + 1 times at most. The colours' expected
/// sum is the path's own. `tile` has the camera rays if [`Options::has_views`].
pub fn shift<Q: Queries>(
    scene: &Scene,
    queries: &Q,
    options: &Options,
    path: &Shiftable,
    tile: Option<&Tile>,
    draw: Draw<impl FnMut() -> f64>,
    splat: impl FnMut(DVec2, Colour),
) -> Result<BatchStats, Stop> {
    Scratch::default().shift(scene, queries, options, path, tile, draw, splat)
}

impl Scratch {
    /// The same as [`shift`].
    pub fn shift<Q: Queries>(
        &mut self,
        scene: &Scene,
        queries: &Q,
        options: &Options,
        path: &Shiftable,
        tile: Option<&Tile>,
        mut draw: Draw<impl FnMut() -> f64>,
        mut splat: impl FnMut(DVec2, Colour),
    ) -> Result<BatchStats, Stop> {
        if path.first().place.is_surface() && !options.moves_surfaces() {
            splat(path.image.pixel, path.carried(scene));
            return Ok(BatchStats::default());
        }
        let Self { spots, evaluated, exact } = self;
        if !options.mode.evaluates() {
            return Ok(linear(scene, options, path, draw, spots, splat));
        }
        let Evaluated { members, hits } = made(evaluated);
        let members = match tile {
            Some(tile) => place_on_rays(scene, path, tile, members),
            None => place(&scene.camera, options, path, &mut draw, members),
        };
        let mut weighing = Weighing::new(scene, path, members.len());
        let mut evaluation = Evaluation::new(scene, queries, path, hits);
        match options.mode {
            // Those of `linear`.
            Mode::FirstOrder | Mode::HalfOrder | Mode::LogLinear => {}
            Mode::LinearDepth => {
                members.iter_mut().for_each(|member| member.predict(scene, path));
                members.iter().for_each(|member| weighing.ratio(member, &mut splat));
            }
            Mode::Exact => {
                evaluation.run(members)?;
                members.iter().for_each(|member| weighing.ratio(member, &mut splat));
            }
            Mode::TwoLevel => {
                let exact = made(exact);
                two_level(&mut evaluation, &mut weighing, options, members, exact, &mut draw, &mut splat)?;
            }
            Mode::Exchangeable => {
                evaluation.run(members)?;
                weighing.exchangeable(members, &mut splat);
            }
        }
        weighing.finish(&mut splat);
        Ok(BatchStats { shifts: weighing.shifts, stays: weighing.stays, ..evaluation.stats })
    }
}

/// Weights from the gradients at x, whatever is in the way; a splat stays where y is off the image or a vertex leaves its medium.
fn linear(
    scene: &Scene,
    options: &Options,
    path: &Shiftable,
    mut draw: Draw<impl FnMut() -> f64>,
    spots: &mut Spots,
    mut splat: impl FnMut(DVec2, Colour),
) -> BatchStats {
    spots.fill(&scene.camera, options, path, &mut draw);
    if !path.surely_stays_in_media(scene, spots.reach()) {
        spots.retain(|offset| path.stays_in_media(scene, offset));
    }
    let mut weighing = Weighing::new(scene, path, spots.members);
    let gradients = group_gradients(&scene.camera, scene, path, weighing.own());
    weighing.linear(options, &gradients, spots, &mut splat);
    weighing.finish(&mut splat);
    BatchStats { shifts: weighing.shifts, stays: weighing.stays, ..BatchStats::default() }
}

/// `LinearDepth` for all members, and what `Exact` differs for `exact_count` of them in the name of all.
fn two_level<Q: Queries>(
    evaluation: &mut Evaluation<Q>,
    weighing: &mut Weighing,
    options: &Options,
    members: &mut [Member],
    exact: &mut Members,
    draw: &mut Draw<impl FnMut() -> f64>,
    splat: &mut impl FnMut(DVec2, Colour),
) -> Result<(), Stop> {
    let mut chosen = [0; super::MAX_SHIFTS];
    let mut slots = chosen.iter_mut().zip(&mut exact.0);
    let wanted = options.exact_count.min(members.len());
    let mut count = 0;
    // Selection sampling: every subset of that size is equally likely. Source: D. Knuth, TAOCP 2, 3.4.2, algorithm S.
    for (index, member) in members.iter().enumerate() {
        if (draw.random)() * ((members.len() - index) as f64) < (wanted - count) as f64
            && let Some((number, slot)) = slots.next()
        {
            (*number, *slot) = (index, *member);
            count += 1;
        }
    }
    let exact = exact.0.get_mut(..count).unwrap_or(&mut []);
    evaluation.run(exact)?;
    members.iter_mut().for_each(|member| member.predict(evaluation.scene, evaluation.path));
    let mut corrections = chosen.iter().zip(exact.iter()).peekable();
    let share = members.len() as f64 / wanted as f64;
    for (index, member) in members.iter().enumerate() {
        match corrections.next_if(|(chosen, _)| **chosen == index) {
            Some((_, exact)) => weighing.corrected(member, exact, share, splat),
            None => weighing.ratio(member, splat),
        }
    }
    Ok(())
}
