//! Means and standard errors from independent batches, and how far two estimates are apart.

use super::scenes::World;
use volgrad::film::{Cell, Count, Film};
use volgrad::math::{Colour, luminance};
use volgrad::sampler::{Options, PathTracer, Stats};

/// Batches per estimate: enough for standard errors that are right to 9 %, and for nearly normal scores.
pub const BATCHES: u64 = 64;

/// How many times the samples of a quick run the environment asks for: VOLGRAD_LONG set is `make validate`.
pub fn scale() -> u64 {
    if std::env::var_os("VOLGRAD_LONG").is_some() { 20 } else { 1 }
}

/// Image means of [`BATCHES`] independent batches.
#[derive(Clone, Debug)]
pub struct Estimate {
    batches: Vec<Vec<Colour>>,
    pub stats: Stats,
    /// Splats that the film left out.
    pub dropped: u64,
}

/// A mean and its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    pub value: f64,
    pub error: f64,
}

impl Mean {
    /// Of independent values.
    pub fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let n = values.clone().count() as f64;
        let value = values.clone().sum::<f64>() / n;
        let variance = values.map(|v| (v - value) * (v - value)).sum::<f64>() / (n - 1.0);
        Self { value, error: (variance / n).sqrt() }
    }

    /// The difference to an exact value in standard errors.
    pub fn z_to(&self, exact: f64) -> f64 {
        (self.value - exact) / self.error
    }
}

/// The worst scores of one comparison.
#[derive(Clone, Copy, Debug)]
pub struct Scores {
    /// Over pixels, in luminance.
    pub pixel: f64,
    /// Of the image's sum, over channels.
    pub total: f64,
    /// Of the total's luminance, and its standard error, relative to the other estimate's.
    pub bias: f64,
    pub error: f64,
    pub dropped: u64,
}

impl Estimate {
    /// Renders [`BATCHES`] films of `passes` paths per pixel, on two threads.
    pub fn of_path_tracer(world: &World, options: Options, passes: u64) -> Self {
        let scene = world.scene();
        let tracer = PathTracer { scene: &scene, queries: &world.geometry, options };
        let pixels = scene.camera.width * scene.camera.height;
        Self::of_batches(world, passes, |batch, film| {
            let mut stats = Stats::default();
            for pass in batch * passes..(batch + 1) * passes {
                tracer.sample_pixels(pass, 0..pixels, film, &mut stats).expect("the toy host never stops");
            }
            stats
        })
    }

    /// Any sampler's batches: `fill(batch, film)` adds `passes` samples per pixel.
    pub fn of_batches(world: &World, passes: u64, fill: impl Fn(u64, &mut Film) -> Stats + Sync) -> Self {
        let camera = &world.camera;
        let cells = (camera.width * camera.height) as usize;
        let one = |batch: u64| {
            let (cells, dropped) = (vec![Cell::default(); cells], Count::default());
            let mut film =
                Film { width: camera.width, height: camera.height, cells: &cells, dropped: &dropped, is_shared: false };
            let stats = fill(batch, &mut film);
            (cells.iter().map(|cell| cell.value() / passes as f64).collect(), stats, dropped.get())
        };
        let half = |first: u64| (first..BATCHES).step_by(2).map(one).collect::<Vec<(Vec<Colour>, Stats, u64)>>();
        let (even, odd) = std::thread::scope(|scope| {
            let odd = scope.spawn(|| half(1));
            (half(0), odd.join().expect("a batch panicked"))
        });
        let (mut stats, mut dropped) = (Stats::default(), 0);
        let batches = even.into_iter().chain(odd).map(|(image, s, d)| {
            dropped += d;
            stats.paths += s.paths;
            stats.shifted_paths += s.shifted_paths;
            stats.shifts += s.shifts;
            stats.stays += s.stays;
            image
        });
        let batches = batches.collect();
        Self { batches, stats, dropped }
    }

    pub fn pixels(&self) -> usize {
        self.batches[0].len()
    }

    pub fn pixel(&self, index: usize) -> Mean {
        Mean::of(self.batches.iter().map(|image| luminance(image[index])))
    }

    /// The image's mean, in one channel.
    pub fn channel(&self, channel: usize) -> Mean {
        let n = self.pixels() as f64;
        Mean::of(self.batches.iter().map(|image| image.iter().map(|c| c[channel]).sum::<f64>() / n))
    }

    /// The image's mean luminance.
    pub fn total(&self) -> Mean {
        let n = self.pixels() as f64;
        Mean::of(self.batches.iter().map(|image| image.iter().copied().map(luminance).sum::<f64>() / n))
    }

    /// Scores of the difference to an estimate made of the same paths, batch by batch: what both share cancels.
    pub fn paired_scores(&self, other: &Self) -> Scores {
        let difference = self.minus(other);
        let total = other.total().value;
        // Sums in different orders differ by some rounding.
        let z = |mean: Mean| if mean.value.abs() < 1e-12 * total { 0.0 } else { mean.value / mean.error };
        let worst = |scores: &mut dyn Iterator<Item = f64>| scores.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        Scores {
            pixel: worst(&mut (0..self.pixels()).map(|i| z(difference.pixel(i)))),
            total: worst(&mut (0..3).map(|c| z(difference.channel(c)))),
            bias: difference.total().value / total,
            error: difference.total().error / total,
            dropped: self.dropped + other.dropped,
        }
    }

    /// The difference, batch by batch.
    pub fn minus(&self, other: &Self) -> Self {
        self.with(other, |a, b| a - b)
    }

    /// The sums of both, batch by batch.
    pub fn plus(&self, other: &Self) -> Self {
        Self { dropped: self.dropped + other.dropped, ..self.with(other, |a, b| a + b) }
    }

    fn with(&self, other: &Self, join: fn(Colour, Colour) -> Colour) -> Self {
        let join = |(a, b): (&Vec<Colour>, &Vec<Colour>)| a.iter().zip(b).map(|(a, b)| join(*a, *b)).collect();
        Self { batches: self.batches.iter().zip(&other.batches).map(join).collect(), ..self.clone() }
    }
}
