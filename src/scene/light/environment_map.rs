//! Light from infinitely far away as an image tells: latitude-longitude, bilinear, sampled by its luminance.
//!
//! Texel (i, j) lies at longitude (i + ½)/width of a turn, which wraps around, and latitude j/(height − 1) of the way from the up to the
//! down pole: the first and the last row are the poles. Four neighbouring texels are the corners of a cell.
//! Source: Mitsuba 3, `envmap`. Differs from it in the density, which is constant per cell in solid angle instead of on the image, so
//! that it stays finite at the poles.

use super::distribution::{accumulate, number, pick, probability};
use crate::math::{Colour, DMat3, DVec2, DVec3, Rgb, atan2, cos, floor, luminance, sin, sqrt};
use core::f64::consts::PI;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentMap<'a> {
    texels: &'a [Rgb],
    width: usize,
    height: usize,
    /// Orthonormal; its columns are the map's axes in the world. y is up; longitude grows from −z by +x.
    to_world: DMat3,
    scale: Colour,
    /// As [`running_sums`] leaves them: of the probabilities of each row's cells, and of the rows.
    columns: &'a [f64],
    rows: &'a [f64],
}

/// Length of [`running_sums`]' result for an image of two rows or more.
pub fn sums_length(width: usize, height: usize) -> usize {
    (width + 1) * height.saturating_sub(1)
}

/// From texels to what their map is sampled with: running sums of probabilities over the columns of each row of cells, then over the rows.
pub fn running_sums(texels: &[Rgb], width: usize, height: usize, scale: Colour, sums: &mut [f64]) {
    let row_count = height.saturating_sub(1);
    let Some((columns, rows)) = sums.split_at_mut_checked(width * row_count) else { return };
    let weight =
        |i: usize, j: usize| texels.get(j * width + wrapped(i, width)).map_or(0.0, |texel| luminance(texel.wide() * scale));
    for (j, (columns, row)) in columns.chunks_exact_mut(width.max(1)).zip(rows.iter_mut()).enumerate() {
        for (i, column) in columns.iter_mut().enumerate() {
            *column = weight(i, j) + weight(i + 1, j) + weight(i, j + 1) + weight(i + 1, j + 1);
        }
        let heights = [j, j + 1].map(|j| cos(PI * j as f64 / row_count as f64));
        *row = columns.iter().sum::<f64>() * (heights[0] - heights[1]);
        accumulate(columns);
    }
    accumulate(rows);
}

/// The column after the last is the first.
fn wrapped(i: usize, width: usize) -> usize {
    if i < width { i } else { 0 }
}

/// A place on the image: its cell's first texel, and where between the four corners.
struct Place {
    i: usize,
    j: usize,
    within: DVec2,
}

impl<'a> EnvironmentMap<'a> {
    /// `sums` are those of the same arguments. None if the lengths do not fit.
    pub fn new(
        texels: &'a [Rgb],
        width: usize,
        height: usize,
        to_world: DMat3,
        scale: Colour,
        sums: &'a [f64],
    ) -> Option<Self> {
        let fits = width > 0 && height > 1 && texels.len() == width * height && sums.len() == sums_length(width, height);
        let (columns, rows) = sums.split_at_checked(width * height.saturating_sub(1))?;
        fits.then_some(Self { texels, width, height, to_world, scale, columns, rows })
    }

    /// Radiance from the unit direction `to_sky`.
    pub fn radiance(&self, to_sky: DVec3) -> Colour {
        let place = self.place(self.to_world.transpose() * to_sky);
        let [[a, b], [c, d]] = self.corners(&place);
        let DVec2 { x, y } = place.within;
        self.scale * (a.lerp(b, x)).lerp(c.lerp(d, x), y)
    }

    /// ∂log radiance/∂to_sky per colour channel. Radiance is smooth within a cell only; on its border this is the gradient of the cell
    /// that follows, at the poles, where longitude means nothing, 0.
    pub fn log_gradient(&self, to_sky: DVec3) -> [DVec3; 3] {
        let v = self.to_world.transpose() * to_sky;
        let across = sqrt(v.x * v.x + v.z * v.z);
        if !(across > 0.0) {
            return [DVec3::ZERO; 3];
        }
        let place = self.place(v);
        let [[a, b], [c, d]] = self.corners(&place);
        let DVec2 { x, y } = place.within;
        let radiance = (a.lerp(b, x)).lerp(c.lerp(d, x), y);
        let (by_column, by_row) = ((b - a).lerp(d - c, y), (c - a).lerp(d - b, x));
        let column = DVec3::new(-v.z, 0.0, v.x) * (self.width as f64 / (2.0 * PI * across * across));
        let row = DVec3::new(v.y * v.x / across, -across, v.y * v.z / across) * (self.rows.len() as f64 / PI);
        core::array::from_fn(|channel| {
            if radiance[channel] > 0.0 {
                self.to_world * (by_column[channel] * column + by_row[channel] * row) / radiance[channel]
            } else {
                DVec3::ZERO
            }
        })
    }

    /// A direction to the sky and its density per steradian; None if the map is black.
    pub fn sample(&self, u: DVec2) -> Option<(DVec3, f64)> {
        let (j, down) = pick(self.rows, u.y)?;
        let (i, along) = pick(self.columns_of(j), u.x)?;
        let [top, bottom] = self.heights(j);
        let height = top + (bottom - top) * down;
        let across = sqrt((1.0 - height * height).max(0.0));
        let longitude = 2.0 * PI * (i as f64 + 0.5 + along) / self.width as f64;
        let v = DVec3::new(across * sin(longitude), height, -across * cos(longitude));
        Some((self.to_world * v, self.density(i, j)))
    }

    /// The numbers from which [`EnvironmentMap::sample`] makes a direction; None if it never does.
    pub fn invert(&self, to_sky: DVec3) -> Option<DVec2> {
        let v = self.to_world.transpose() * to_sky;
        let Place { i, j, within } = self.place(v);
        let [top, bottom] = self.heights(j);
        let down = (top - v.y) / (top - bottom);
        let x = number(self.columns_of(j), i, within.x.clamp(0.0, 1.0))?;
        Some(DVec2::new(x, number(self.rows, j, down.clamp(0.0, 1.0))?))
    }

    /// Density of [`EnvironmentMap::sample`].
    pub fn pdf(&self, to_sky: DVec3) -> f64 {
        let Place { i, j, .. } = self.place(self.to_world.transpose() * to_sky);
        self.density(i, j)
    }

    /// In cell (i, j), per steradian.
    fn density(&self, i: usize, j: usize) -> f64 {
        let [top, bottom] = self.heights(j);
        let solid_angle = (top - bottom) * 2.0 * PI / self.width as f64;
        probability(self.rows, j) * probability(self.columns_of(j), i) / solid_angle
    }

    fn columns_of(&self, j: usize) -> &'a [f64] {
        self.columns.get(j * self.width..(j + 1) * self.width).unwrap_or(&[])
    }

    /// Heights on the unit sphere between which row `j` of cells lies.
    fn heights(&self, j: usize) -> [f64; 2] {
        [j, j + 1].map(|j| cos(PI * j as f64 / self.rows.len() as f64))
    }

    fn place(&self, v: DVec3) -> Place {
        let width = self.width as f64;
        let column = atan2(v.x, -v.z) * (width / (2.0 * PI)) - 0.5;
        let column = column - width * floor(column / width);
        let row = atan2(sqrt(v.x * v.x + v.z * v.z), v.y) * (self.rows.len() as f64 / PI);
        let (i, j) = ((column as usize).min(self.width - 1), (row as usize).min(self.rows.len() - 1));
        Place { i, j, within: DVec2::new(column - i as f64, row - j as f64) }
    }

    /// Texels (i, j), (i + 1, j) and those below them.
    fn corners(&self, place: &Place) -> [[Colour; 2]; 2] {
        [place.j, place.j + 1].map(|j| {
            [place.i, wrapped(place.i + 1, self.width)]
                .map(|i| self.texels.get(j * self.width + i).map_or(Colour::ZERO, |texel| texel.wide()))
        })
    }
}
