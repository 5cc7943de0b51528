//! Pearson's chi-square test of a histogram against the probabilities of its bins.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Below this many expected samples the statistic does not follow a chi-square distribution well.
const LEAST_EXPECTED: f64 = 5.0;

/// Probability that samples which do follow `probabilities` deviate from them as far as `counts` does, or farther.
///
/// Neighbouring bins with few expected samples are pooled. The probabilities sum to 1.
pub fn chi_square_p_value(counts: &[u64], probabilities: &[f64]) -> f64 {
    assert_eq!(counts.len(), probabilities.len());
    assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-6, "probabilities sum to 1");
    let total = counts.iter().sum::<u64>() as f64;
    let bins = pooled(counts.iter().map(|&n| n as f64).zip(probabilities.iter().map(|p| p * total)));
    let statistic: f64 = bins.iter().map(|(observed, expected)| (observed - expected).powi(2) / expected).sum();
    ChiSquared::new(bins.len() as f64 - 1.0).expect("two bins or more").sf(statistic)
}

/// Joins (observed, expected) with what follows until enough are expected; the rest goes to the last bin.
fn pooled(bins: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut result: Vec<(f64, f64)> = Vec::new();
    let mut open = (0.0, 0.0);
    for (observed, expected) in bins {
        open = (open.0 + observed, open.1 + expected);
        if open.1 >= LEAST_EXPECTED {
            result.push(std::mem::take(&mut open));
        }
    }
    if let Some(last) = result.last_mut() {
        *last = (last.0 + open.0, last.1 + open.1);
    }
    result
}
