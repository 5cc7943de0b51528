//! What the host computes itself: copies of the built-in kinds through the traits for it give the same images, with every sampler, with and
//! without shifts; derivatives agree with differences; what is not known is refused; what is no value never enters the film.
//!
//! A copy's images are those of the original to rounding: the numbers are the same, and rays of single precision pass some rounding on.

#[path = "../toy/mod.rs"]
mod toy;

#[path = "../metropolis/chains.rs"]
#[allow(dead_code)]
mod chains;

mod bsdf;
mod density;
mod images;
mod light;
mod phase;
mod surface_point;
