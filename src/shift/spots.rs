//! Where offsets lead: steps on the image, and copies of the path in space.

use super::kernel::{Kernel, MAX_SHIFTS, Mode, Options, fill_with_unit_ball};
use super::place::Draw;
use super::run::Shiftable;
use super::tile::Tiling;
use crate::math::{DVec2, DVec3, DVec4};
use crate::scene::Camera;

/// Copies of the path in space, each at an offset from its first vertex. Axis by axis, so that a processor weighs several at once.
pub(super) struct Spots {
    /// All members other than the path itself, also those that are not here: off the sampled image, or left out since.
    pub members: usize,
    count: usize,
    offsets: [[f64; ROOM]; 3],
    pixels: [DVec2; ROOM],
}

/// Spots that are weighed together.
pub(super) const LANES: usize = 4;
const ROOM: usize = MAX_SHIFTS.next_multiple_of(LANES);

impl Default for Spots {
    fn default() -> Self {
        Self { members: 0, count: 0, offsets: [[0.0; ROOM]; 3], pixels: [DVec2::ZERO; ROOM] }
    }
}

impl Spots {
    /// Makes those of a batch.
    pub fn fill(&mut self, camera: &Camera, options: &Options, path: &Shiftable, draw: &mut Draw<impl FnMut() -> f64>) {
        (self.members, self.count) = (0, 0);
        spots(camera, options, path, draw, |offset, pixel| {
            self.members += 1;
            if let Some(pixel) = pixel {
                self.push(offset, pixel);
            }
        });
    }

    fn push(&mut self, offset: DVec3, pixel: DVec2) {
        let i = self.count;
        let Some(slot) = self.pixels.get_mut(i) else { return };
        *slot = pixel;
        for (axis, coordinate) in self.offsets.iter_mut().zip(offset.to_array()) {
            axis[i] = coordinate;
        }
        self.count = i + 1;
    }

    /// Leaves out those whose offset is not to be kept.
    pub fn retain(&mut self, keep: impl Fn(DVec3) -> bool) {
        let all = core::mem::take(&mut self.count);
        for i in 0..all.min(ROOM) {
            let offset = DVec3::from_array(self.offsets.each_ref().map(|axis| axis[i]));
            if keep(offset) {
                self.push(offset, self.pixels[i]);
            }
        }
    }

    pub fn len(&self) -> usize {
        self.count
    }

    /// How far they are away along each axis at most.
    pub fn reach(&self) -> DVec3 {
        let mut reach = [DVec4::ZERO; 3];
        for (offsets, _) in self.blocks() {
            reach = core::array::from_fn(|axis| reach[axis].max(offsets[axis].abs()));
        }
        DVec3::from_array(reach.map(DVec4::max_element))
    }

    /// Pixels of up to [`LANES`] of them, and their offsets, axis by axis. (What is in lanes without a pixel has no meaning.)
    pub fn blocks(&self) -> impl Iterator<Item = ([DVec4; 3], &[DVec2])> {
        let [x, y, z] = self.offsets.each_ref().map(|axis| axis.as_chunks::<LANES>().0);
        let offsets = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z].map(DVec4::from_array));
        offsets.zip(self.pixels.get(..self.count).unwrap_or(&[]).chunks(LANES))
    }
}

/// Calls `member` with the steps on the image, in pixels, to the members other than the path itself. `side` is that of a pixel, in world
/// units, where the first vertex is.
pub(super) fn steps(
    camera: &Camera,
    options: &Options,
    own: DVec2,
    side: f64,
    draw: &mut Draw<impl FnMut() -> f64>,
    mut member: impl FnMut(DVec2),
) {
    let Kernel::Disk(radius) = options.kernel else {
        return Tiling::new(camera, options.tile_side(), draw.tiles).others(own).for_each(member);
    };
    let radius = radius.in_pixels(side);
    in_unit_ball(options, draw, |step| member(radius * DVec2::from_array(step)));
}

/// Calls `member` with offsets in a disk or ball of radius 1, around a common centre if the mode wants one.
#[inline(always)]
fn in_unit_ball<const N: usize>(options: &Options, draw: &mut Draw<impl FnMut() -> f64>, mut member: impl FnMut([f64; N])) {
    // First the centre: the path itself, or beside it.
    let mut points = [[0.0; N]; 1 + MAX_SHIFTS];
    let drawn = if options.mode == Mode::Exchangeable { 0 } else { 1 };
    fill_with_unit_ball(points.get_mut(drawn..=options.count).unwrap_or(&mut []), &mut draw.random);
    let [centre, points @ ..] = &points;
    for point in points.iter().take(options.count) {
        member(core::array::from_fn(|axis| centre[axis] + point[axis]));
    }
}

/// Moves the path's first vertex in space: calls `member` with the offset, and the pixel where the member is seen (None: not on the
/// sampled image), for each other than the path itself.
#[inline(always)]
pub(super) fn spots(
    camera: &Camera,
    options: &Options,
    path: &Shiftable,
    draw: &mut Draw<impl FnMut() -> f64>,
    mut member: impl FnMut(DVec3, Option<DVec2>),
) {
    let (own, x) = (path.image.pixel, path.first().x);
    if let Kernel::Ball(radius) = options.kernel {
        let lens = camera.on_lens(path.image.ray.origin);
        return in_unit_ball(options, draw, |offset| {
            let offset = radius * DVec3::from_array(offset);
            member(offset, camera.pixel(x + offset, lens));
        });
    }
    // Parallel to the image plane: a step on the image is as long at all depths, in pixels there.
    let side = camera.pixel_size() * camera.depth(x);
    let (right, down) = (side * camera.right, -side * camera.up);
    steps(camera, options, own, side, draw, |step| {
        let pixel = own + step;
        member(step.x * right + step.y * down, Some(pixel).filter(|pixel| camera.samples(*pixel)));
    });
}
