//! Metropolis light transport against the path sampler, against what is known about chains, and call against call.
//!
//! | question | file |
//! |---|---|
//! | the same image as the path sampler's, with and without shifts? | [`agreement`] |
//! | is a joined path prepared for shifting like any other sampler's? | [`shiftable`] |
//! | 1 in a furnace, all lengths together? | [`furnace`] |
//! | right from the first mutation on, whatever the bootstrap? | [`start`] |
//! | are techniques tried as often as was learned? | [`techniques`] |
//! | is a subpath that a mutation does not change still the right one? | [`kept`] |
//! | which numbers make a path? | [`inverse`] |
//! | the same bits however calls are divided? | [`determinism`] |
//! | what if a callback stops? | [`stops`] |
//! | what if the scene has values beyond all numbers? | [`robustness`] |
//! | what if a chain gets another scene, seed or table than its samples had? | [`strangers`] |
//! | is no memory allocated? | [`allocation`] |

#[path = "../common/statistics.rs"]
#[allow(dead_code)]
mod statistics;
#[path = "../toy/mod.rs"]
mod toy;

mod agreement;
mod allocation;
mod chains;
mod determinism;
mod furnace;
mod inverse;
mod kept;
mod plan;
mod robustness;
mod shiftable;
mod start;
mod stops;
mod strangers;
mod techniques;

use volgrad::sampler::bidirectional::thesis;
use volgrad::shift::{self, Kernel, Mode, Radius};

/// One of each unbiased mode and kernel, with runs of one vertex and more.
fn unbiased_shifts() -> [shift::Options; 5] {
    let disk = Kernel::Disk(Radius::Pixels(1.0));
    let options = |mode, kernel, run| {
        let count = if kernel == Kernel::Tile { 8 } else { 3 };
        shift::Options { run, ..shift::Options::new(mode, kernel, count) }
    };
    [
        options(Mode::Exact, disk, 1),
        options(Mode::Exact, Kernel::Ball(0.35), 4),
        options(Mode::TwoLevel, disk, 3),
        options(Mode::Exchangeable, Kernel::Tile, 2),
        options(Mode::Exchangeable, disk, 4),
    ]
}

/// The thesis' estimator, whose radius shrinks.
const THESIS: thesis::Options = thesis::Options { radius: 0.35, count: 3, alpha: 0.7, clamp: f64::INFINITY, as_printed: false };
