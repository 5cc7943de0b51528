//! Batches of the thesis' estimator in a chain. [Lu20 alg. 3]
//!
//! Differs from [Lu20 alg. 3]: a path's batch is its own wherever the chain goes, and a path that is not available is splatted alone; as printed,
//! X_0 never becomes X_1, and a path that is not available leaves the batch of the one before it in X_1.

use super::chain::{Metropolis, State};
use crate::film::Film;
use crate::math::Colour;
use crate::sampler::bidirectional::Joined;
use crate::sampler::bidirectional::thesis::{EMPTY, Moving, Options};
use crate::sampler::path_tracer::Stats;
use crate::sampler::primary::chain_shift_numbers;
use crate::scene::{Queries, Stop};
use crate::shift::BatchStats;

impl<'a, Q: Queries> Metropolis<'a, Q> {
    /// Splats the batch of an available path that mutation number `born` made, in the place of `value`.
    pub(super) fn splat_thesis(
        &self,
        options: &Options,
        state: &State,
        born: u64,
        path: &Joined<'_, 'a>,
        value: Colour,
        film: &mut Film,
        stats: &mut Stats,
    ) -> Result<(), Stop> {
        let (_, mut random) = chain_shift_numbers(self.options.seed, state.index, born);
        let samples = born as f64 * f64::from(state.start.chains);
        let mut members = EMPTY;
        let count = Moving::new(path, self.queries)?.batch(options, samples, &mut random, &mut members, stats)?;
        let Some(count) = count else {
            film.add(path.connection.pixel, value);
            return Ok(());
        };
        for (pixel, w) in members.iter().take(count) {
            film.add(*pixel, value * (w / options.count as f64));
        }
        stats.add_batch(&BatchStats { shifts: options.count as u64, ..BatchStats::default() });
        Ok(())
    }
}
