//! What the integration tests share.
//!
//! | question | file |
//! |---|---|
//! | how does the library see the reference's worlds, edges and paths? | [`host`] |
//! | media, and grids on which bricks matter | [`media`] |
//! | do samples follow a distribution? | [`statistics`] |

// Each integration test that says `mod common;` uses only a part of it.
#![allow(dead_code)]

pub mod host;
pub mod media;
pub mod statistics;

use crate::reference::selftest::Worst;

/// Says how large an error really is, and fails if it is larger than it may be.
pub fn assert_below(worst: &Worst, tolerance: f64) {
    println!("worst of {}: {:.1e} at {}", worst.count, worst.error, worst.of);
    assert!(worst.count > 0 && worst.error <= tolerance, "{worst:?} > {tolerance:e}");
}
