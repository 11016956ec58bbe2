//! An estimated quantity through a run: its errors with the sigmas reported for them, and what they come to.
//!
//! Errors follow each other for minutes (a filter, a horizon's height), so a run of an hour is a few samples,
//! not 3,600. How many is told from the errors: with `m(b)` the mean square of the means over blocks of `b`
//! seconds, `b m(b) / m(1)` grows with `b` up to the time for which errors go together (Flyvbjerg and
//! Petersen 1989). The largest value is taken, which makes the band of the mean square wider rather than
//! narrower than it is.

use super::chi_square::{band_99, two_sided};
use super::second::Axes;
use crate::world::attitude::Vector;
use serde::Serialize;

/// Errors and sigmas of a quantity, second by second.
#[derive(Clone, Debug)]
pub struct Series {
    /// Axes that count, 1 to 3.
    axes: usize,
    seconds: Vec<u32>,
    samples: Vec<Axes>,
    /// Independent deviates of the axes together.
    deviates: Vec<Vector>,
    not_finite: u32,
}

/// What a series comes to, in the quantity's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// Seconds with the quantity.
    pub seconds: u32,
    /// Root mean square error of each axis.
    pub rms_axes: Vec<f64>,
    /// Mean error of each axis: what lasts (bias, ECSS-E-ST-60-20C).
    pub bias_axes: Vec<f64>,
    /// Root mean square of each axis about its mean: what does not last.
    pub noise_axes: Vec<f64>,
    /// Root mean square of the error's length.
    pub rms: f64,
    /// Length of the error that 95 % of the seconds do not exceed.
    pub error_95: f64,
    /// Root mean square of the reported sigma of each axis.
    pub sigma_axes: Vec<f64>,
    /// Root mean square of the length of the reported sigmas.
    pub sigma: f64,
    /// Share of the errors, axis by axis, within 1, 2 and 3 reported sigma; 0.683, 0.954, 0.997 of right
    /// ones.
    pub within_share: [f64; 3],
    /// Share of the seconds with every axis within 3 sigma.
    pub all_within_3_share: f64,
    /// Share of the seconds with an axis beyond 4 sigma; 0.00006 an axis of right ones.
    pub beyond_4_share: f64,
    /// Mean of the normalised error squared over the seconds (NEES, with the correlations of the axes where
    /// they are known) over its degrees of freedom; 1 where sigmas are right.
    pub normalised_square: f64,
    /// Mean of error / sigma over the seconds, of the axis where it is largest.
    pub bias_sigma: f64,
    /// For so long errors go together, s.
    pub correlation_s: f64,
    /// 99 % of runs with right sigmas have a mean square between these.
    pub band_99: [f64; 2],
    /// Probability of such a mean square or one farther from 1, if the sigmas are right.
    pub consistency: f64,
    /// Largest error over its sigma.
    pub largest_sigma: f64,
    /// Largest change of an error from one second to the next, over the sigma before it; and the second of
    /// it.
    pub jump_sigma: Option<(f64, u32)>,
}

/// How the sigmas of a quantity stand to its errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SigmaFit {
    /// As 99 % of runs with right sigmas.
    Right,
    /// The errors are smaller.
    TooLarge,
    /// The errors are larger.
    TooSmall,
}

impl Statistics {
    /// How the sigmas stand to the errors, by [`Self::band_99`].
    pub fn sigma_fit(&self) -> SigmaFit {
        let [low, high] = self.band_99;
        match self.normalised_square {
            square if square < low => SigmaFit::TooLarge,
            square if square > high => SigmaFit::TooSmall,
            _ => SigmaFit::Right,
        }
    }
}

impl Series {
    /// Nothing yet, of so many axes.
    pub fn new(axes: usize) -> Self {
        Self { axes, seconds: Vec::new(), samples: Vec::new(), deviates: Vec::new(), not_finite: 0 }
    }

    /// Adds a second whose axes are independent. One with a number that is not finite or a sigma that is not
    /// positive is only counted.
    pub fn add(&mut self, second: u32, of: Axes) {
        self.add_correlated(second, of, [0, 1, 2].map(|axis| of.error[axis] / of.sigma[axis]));
    }

    /// The same of axes that are not, with [`Correlated::deviates`](super::second::Correlated).
    pub fn add_correlated(&mut self, second: u32, of: Axes, deviates: Vector) {
        let counted = |values: &Vector| values.iter().take(self.axes).all(|value| value.is_finite());
        let sigmas = of.sigma.iter().take(self.axes).all(|sigma| *sigma > 0.0);
        if sigmas && [of.error, of.sigma, deviates].iter().all(counted) {
            self.seconds.push(second);
            self.samples.push(of);
            self.deviates.push(deviates);
        } else {
            self.not_finite += 1;
        }
    }

    /// Seconds with a number that is not finite or a sigma that is not positive.
    pub fn not_finite(&self) -> u32 {
        self.not_finite
    }

    /// What the seconds from `first` on come to, in units of `1 / scale`; `None` of none.
    pub fn statistics(&self, first: u32, scale: f64) -> Option<Statistics> {
        let from = self.seconds.partition_point(|second| *second < first);
        let (seconds, samples) = (&self.seconds[from..], &self.samples[from..]);
        let count = samples.len() as f64;
        if samples.is_empty() {
            return None;
        }
        let axes = 0..self.axes;
        let rms_of = |of: &dyn Fn(&Axes, usize) -> f64| -> Vec<f64> {
            let mean = |axis| samples.iter().map(|sample| of(sample, axis).powi(2)).sum::<f64>() / count;
            axes.clone().map(|axis| scale * libm::sqrt(mean(axis))).collect()
        };
        let length = |parts: &[f64]| libm::sqrt(parts.iter().map(|part| part * part).sum());
        let (rms_axes, sigma_axes) =
            (rms_of(&|sample, axis| sample.error[axis]), rms_of(&|sample, axis| sample.sigma[axis]));
        let bias_axes: Vec<f64> = axes
            .clone()
            .map(|axis| scale * samples.iter().map(|sample| sample.error[axis]).sum::<f64>() / count)
            .collect();
        let about = |(rms, bias): (&f64, &f64)| libm::sqrt((rms * rms - bias * bias).max(0.0));
        let noise_axes = rms_axes.iter().zip(&bias_axes).map(about).collect();
        let mut lengths: Vec<f64> = samples.iter().map(|sample| length(&sample.error[..self.axes])).collect();
        lengths.sort_by(f64::total_cmp);
        let of_axes = |of: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
            axes.clone().map(|axis| (0..samples.len()).map(|index| of(index, axis)).collect()).collect()
        };
        let normalised = of_axes(&|index, axis| samples[index].error[axis] / samples[index].sigma[axis]);
        let deviates = of_axes(&|index, axis| self.deviates[from + index][axis]);
        let each = || normalised.iter().flatten();
        let all = count * self.axes as f64;
        let normalised_square = deviates.iter().flatten().map(|deviate| deviate * deviate).sum::<f64>() / all;
        let correlation_s = correlation(&deviates);
        let freedom = all / correlation_s;
        let worst = |index: usize| normalised.iter().map(|axis| axis[index].abs()).fold(0.0, f64::max);
        Some(Statistics {
            seconds: samples.len() as u32,
            rms: length(&rms_axes),
            rms_axes,
            bias_axes,
            noise_axes,
            error_95: scale * lengths[((0.95 * count).ceil() as usize).clamp(1, lengths.len()) - 1],
            sigma: length(&sigma_axes),
            sigma_axes,
            within_share: [1.0, 2.0, 3.0]
                .map(|sigmas| each().filter(|deviate| deviate.abs() <= sigmas).count() as f64 / all),
            all_within_3_share: (0..samples.len()).filter(|index| worst(*index) <= 3.0).count() as f64
                / count,
            beyond_4_share: (0..samples.len()).filter(|index| worst(*index) > 4.0).count() as f64 / count,
            normalised_square,
            bias_sigma: normalised
                .iter()
                .map(|axis| (axis.iter().sum::<f64>() / count).abs())
                .fold(0.0, f64::max),
            correlation_s,
            band_99: band_99(freedom),
            consistency: two_sided(normalised_square, freedom),
            largest_sigma: (0..samples.len()).map(worst).fold(0.0, f64::max),
            jump_sigma: self.largest_jump(seconds, samples),
        })
    }

    fn largest_jump(&self, seconds: &[u32], samples: &[Axes]) -> Option<(f64, u32)> {
        let pairs = samples.windows(2).zip(seconds.windows(2)).filter(|(_, at)| at[1] == at[0] + 1);
        let jump = |pair: &[Axes]| {
            let of = |axis: usize| ((pair[1].error[axis] - pair[0].error[axis]) / pair[0].sigma[axis]).abs();
            (0..self.axes).map(of).fold(0.0, f64::max)
        };
        pairs.map(|(pair, at)| (jump(pair), at[1])).max_by(|one, other| one.0.total_cmp(&other.0))
    }
}

/// For how many samples errors go together; 1 for independent ones.
fn correlation(normalised: &[Vec<f64>]) -> f64 {
    let mean_square = |block: usize| {
        let means = normalised.iter().flat_map(|axis| {
            axis.chunks_exact(block).map(move |chunk| chunk.iter().sum::<f64>() / block as f64)
        });
        let (sum, count) = means.fold((0.0, 0), |(sum, count), mean| (sum + mean * mean, count + 1));
        sum / f64::from(count.max(1))
    };
    let single = mean_square(1);
    let length = normalised.first().map_or(0, Vec::len);
    let blocks = std::iter::successors(Some(2), |block| Some(2 * block)).take_while(|block| *block <= length);
    blocks.map(|block| block as f64 * mean_square(block) / single).fold(1.0, f64::max).min(length as f64)
}

#[cfg(test)]
mod tests;
