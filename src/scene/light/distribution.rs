//! Discrete distributions as running sums of probabilities: the last is 1, or 0 if nothing is ever picked.

use super::Light;

/// Takes the weight from a constant environment that is not alone. Going on finds it as well as next-event estimation, which samples its
/// direction from the same density: the picks are better spent on what only they find. (`cloud`, sky and sun: 1.9 times less variance.)
pub fn leave_constant_sky_to_chance(lights: &[Light], weights: &mut [f64]) {
    let constant = lights.iter().position(|light| matches!(light, Light::Environment { .. }));
    let total: f64 = weights.iter().sum();
    if let Some(weight) = constant.and_then(|i| weights.get_mut(i)).filter(|weight| total > **weight) {
        *weight = 0.0;
    }
}

/// Weights to running sums of probabilities. Without any weight nothing is ever picked.
pub fn accumulate(weights: &mut [f64]) {
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    for weight in weights.iter_mut() {
        sum += *weight;
        *weight = if total > 0.0 { sum / total } else { 0.0 };
    }
}

/// Probability of element `i`.
pub fn probability(sums: &[f64], i: usize) -> f64 {
    sums.get(i).map_or(0.0, |sum| sum - start(sums, i))
}

/// Where the numbers that pick element `i` begin.
fn start(sums: &[f64], i: usize) -> f64 {
    i.checked_sub(1).and_then(|before| sums.get(before)).copied().unwrap_or(0.0)
}

/// The element that the number `u` picks, and where within its share of the numbers u is. None if no element has any.
pub fn pick(sums: &[f64], u: f64) -> Option<(usize, f64)> {
    let i = sums.partition_point(|sum| *sum <= u);
    let end = sums.get(i)?;
    let share = probability(sums, i);
    Some((i, 1.0 - (end - u) / share))
}

/// The inverse of [`pick`]: the number that picks element `i` and leaves `rest`, in [0, 1]. None if it is never picked.
pub fn number(sums: &[f64], i: usize, rest: f64) -> Option<f64> {
    let (end, share) = (*sums.get(i)?, probability(sums, i));
    // Neither rounding nor a rest of 1 may lead to a neighbour.
    let u = (end - (1.0 - rest) * share).max(start(sums, i)).min(end.next_down());
    (share > 0.0).then_some(u)
}
