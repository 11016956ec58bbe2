//! A random walk of which any step can be asked without those before it.
//!
//! In: counter-based noise, a row of it, a step. Out: `W(step)`, with `W(0) = 0` and independent Gaussian
//! increments of variance 1. It is a Brownian bridge: the end is drawn first, then the middle of every
//! interval that holds the step, `W((a + b) / 2) = (W(a) + W(b)) / 2 + sqrt((b - a) / 4) g`; twenty halvings
//! reach any of the 2²⁰ steps.

use super::noise::Noise;

/// Last step, twelve days of seconds.
pub const STEPS: u32 = 1 << 20;

/// The walk of `row` at `step`; beyond [`STEPS`] it stays.
pub fn at(noise: &Noise, row: u32, step: u32) -> f64 {
    let (mut from, mut before) = (0, 0.0);
    let (mut to, mut after) = (STEPS, f64::from(STEPS).sqrt() * noise.gaussian(STEPS, row));
    if step >= to {
        return after;
    }
    // from <= step < to, so an interval of one step is never halved.
    while from < step {
        let half = (to - from) / 2;
        let middle = from + half;
        let value = 0.5 * (before + after) + (0.5 * f64::from(half)).sqrt() * noise.gaussian(middle, row);
        if step < middle {
            (to, after) = (middle, value);
        } else {
            (from, before) = (middle, value);
        }
    }
    before
}

#[cfg(test)]
mod tests {
    use super::super::noise::Stream;
    use super::*;

    /// 99 % for all twelve figures of the first test together.
    const SIGMAS: f64 = 3.34;

    #[test]
    fn increments_have_unit_variance_and_know_nothing_of_each_other() {
        let noise = Noise::new(4, 0, Stream::RateSensor);
        // Across the middle of the whole, where two halves meet, too.
        for first in [0, STEPS / 2 - 5000, 700_001] {
            let count = 10_000;
            let walk: Vec<f64> = (first..=first + count).map(|step| at(&noise, 3, step)).collect();
            let steps: Vec<f64> = walk.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let n = f64::from(count);
            let variance = steps.iter().map(|step| step * step).sum::<f64>() / n;
            assert!((variance - 1.0).abs() < SIGMAS * (2.0 / n).sqrt(), "{variance}");
            for lag in [1, 2, 64] {
                let sum: f64 = steps.iter().zip(&steps[lag..]).map(|(a, b)| a * b).sum();
                assert!((sum / n.sqrt()).abs() < SIGMAS, "{first}, lag {lag}: {sum}");
            }
        }
    }

    #[test]
    fn the_variance_grows_with_the_steps() {
        let seeds = 4000;
        for step in [1, 100, 3600, 86_400, STEPS] {
            let square = |seed| at(&Noise::new(seed, 0, Stream::RateSensor), 0, step).powi(2);
            let mean = (0..seeds).map(square).sum::<f64>() / seeds as f64 / f64::from(step);
            assert!((mean - 1.0).abs() < 2.576 * (2.0 / seeds as f64).sqrt(), "{step}: {mean}");
        }
        assert_eq!(at(&Noise::new(1, 0, Stream::RateSensor), 0, 0), 0.0);
    }
}
