//! What a path meets besides media: cameras, surfaces, lights. One file each, as in src/scene/.

mod adjoint;
mod bsdf;
mod camera;
mod emission;
mod environment_map;
mod guide;
mod inverse;
mod light;
mod rough;
mod spot;

#[path = "../reference/mod.rs"]
mod reference;
#[path = "../common/statistics.rs"]
mod statistics;

use proptest::prelude::*;
use volgrad::math::{DVec2, DVec3, orthonormal_basis};

/// Both sides compute the same in another order.
const ROUNDING: f64 = 1e-12;

/// Uniform on the sphere.
fn direction() -> impl Strategy<Value = DVec3> {
    any::<u64>()
        .prop_map(|seed| DVec3::from_array(reference::random::random_direction(&mut reference::random::generator(seed))))
}

/// At the cosine `height` to `axis`, turned by a share of a full turn.
fn direction_before(axis: DVec3, (height, turn): (f64, f64)) -> DVec3 {
    let (s, t) = orthonormal_basis(axis);
    let (sine, cosine) = (2.0 * std::f64::consts::PI * turn).sin_cos();
    height * axis + (1.0 - height * height).sqrt() * (cosine * s + sine * t)
}

fn unit_square() -> impl Strategy<Value = DVec2> {
    (0.0..1.0_f64, 0.0..1.0_f64).prop_map(DVec2::from)
}
