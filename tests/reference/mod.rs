//! The reference implementation: light paths in participating media, their contribution f and its gradient, in f64,
//! slow and obvious. It exists to be checked against, so it shares no code with the library.
//!
//! | question | file |
//! |---|---|
//! | what is in the world? | [`camera`], [`phase`], [`microfacets`], [`grid`], [`medium`], [`world`] |
//! | which media does an edge cross? | [`segments`] |
//! | τ along an edge, its gradient, distances | [`optical_depth`], [`optical_depth_gradient`], [`distance`] |
//! | f(x̄), factor by factor | [`path`], [`contribution`], [`factors`] |
//! | ∇ log f by formula, and by differences | [`gradient`], [`differences`] |
//! | random worlds and paths | [`random`], [`scenes`], [`random_paths`] |
//! | is the reference itself right? | [`selftest`], [`selftest_values`] |
//!
//! Everything is in world units; σ is per world unit; radiometric quantities are linear RGB.
//! There are no occluders here: every edge is taken as visible.
//!
//! Source: [Lu20] = G. Lu, *Gradient-Domain Volume Rendering*, MSc thesis, Utrecht University 2020.
//! Where a formula differs from the one printed there, the comment next to it says so.

// Each integration test that says `mod reference;` uses only a part of it.
#![allow(dead_code)]

pub mod camera;
pub mod contribution;
pub mod differences;
pub mod distance;
pub mod factors;
pub mod gradient;
pub mod grid;
pub mod medium;
pub mod microfacets;
pub mod optical_depth;
pub mod optical_depth_gradient;
pub mod path;
pub mod phase;
pub mod random;
pub mod random_paths;
pub mod scenes;
pub mod segments;
pub mod selftest;
pub mod selftest_values;
pub mod vector;
pub mod world;
