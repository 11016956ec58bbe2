//! Pointing errors: shaking at fixed frequencies, and a slow random wandering of the line of sight.
//!
//! In: a [`JitterModel`] and a seed. Out: a small rotation of the body with its rate at any time, a pure
//! function. The components of the rotation vector are sums of sinusoids `a sin(ω t + φ)` with phases from
//! the seed. The random part is a Gauss-Markov process of standard deviation `σ` and correlation time `T`, `E
//! x(t) x(t + d) = σ² exp(-|d| / T)`: [`TERMS`] sinusoids of amplitude `σ sqrt(2 / TERMS)` an axis, one each
//! from equal parts of its spectrum, which is proportional to `1 / (1 + (ω T)²)`. The spectrum is cut at `ω
//! T = 21`, beyond which 3 % of the power lie, so that there is a rate; the correlation is off by at most
//! 0.03 σ².

use super::moving_frame::MovingFrame;
use crate::world::attitude::Vector;
use crate::world::noise::{Noise, Stream};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Sinusoids of the random part, an axis.
pub const TERMS: u32 = 32;
/// An arcsecond, rad.
const ARCSEC_RAD: f64 = std::f64::consts::PI / 648_000.0;

/// Shaking at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude about x, y, z of the body, arcsec.
    pub amplitude_arcsec: Vector,
}

/// How a satellite's pointing shakes and wanders.
#[derive(Debug, Clone, PartialEq)]
pub struct JitterModel {
    /// Standard deviation of the random part about x, y, z of the body, arcsec.
    pub random_arcsec: Vector,
    /// Correlation time of the random part, s; positive.
    pub correlation_s: f64,
    /// Shaking at fixed frequencies.
    pub lines: Vec<Line>,
}

/// A sinusoid about an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Term {
    axis: usize,
    amplitude_rad: f64,
    rad_s: f64,
    phase_rad: f64,
}

/// The shaking of one run; none where there is no model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Jitter {
    terms: Vec<Term>,
}

impl Jitter {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.terms.is_empty()
    }

    /// The shaking that `model` means for `seed`.
    pub fn new(model: &JitterModel, seed: u64) -> Self {
        let noise = Noise::new(seed, 0, Stream::Jitter);
        let mut terms = Vec::new();
        // Row 3 n of the noise draws frequencies, rows 3 n + 1 and 3 n + 2 phases; n is the axis.
        for (axis, row) in [(0, 0), (1, 3), (2, 6)] {
            for part in 0..TERMS {
                let share = (f64::from(part) + noise.uniform(part, row)) / f64::from(TERMS + 1);
                terms.push(Term {
                    axis,
                    amplitude_rad: model.random_arcsec[axis] * ARCSEC_RAD * (2.0 / f64::from(TERMS)).sqrt(),
                    rad_s: libm::tan(FRAC_PI_2 * share) / model.correlation_s,
                    phase_rad: TAU * noise.uniform(part, row + 1),
                });
            }
            for (index, line) in (0..).zip(&model.lines) {
                terms.push(Term {
                    axis,
                    amplitude_rad: line.amplitude_arcsec[axis] * ARCSEC_RAD,
                    rad_s: TAU * line.frequency_hz,
                    phase_rad: TAU * noise.uniform(index, row + 2),
                });
            }
        }
        terms.retain(|term| term.amplitude_rad != 0.0);
        Self { terms }
    }

    /// The shaken body from where it would be at rest.
    pub fn at(&self, t_s: f64) -> MovingFrame {
        let (mut vector_rad, mut change_rad_s) = ([0.0; 3], [0.0; 3]);
        for term in &self.terms {
            let (sine, cosine) = libm::sincos(term.rad_s * t_s + term.phase_rad);
            vector_rad[term.axis] += term.amplitude_rad * sine;
            change_rad_s[term.axis] += term.amplitude_rad * term.rad_s * cosine;
        }
        MovingFrame::turned_by(vector_rad, change_rad_s)
    }
}

#[cfg(test)]
mod tests {
    use super::super::moving_frame::rate_error;
    use super::*;

    fn model() -> JitterModel {
        JitterModel {
            random_arcsec: [40.0, 20.0, 80.0],
            correlation_s: 30.0,
            lines: vec![Line { frequency_hz: 7.0, amplitude_arcsec: [3.0, 0.0, 5.0] }],
        }
    }

    /// Small rotation about each axis, arcsec.
    fn angles(jitter: &Jitter, t_s: f64) -> Vector {
        let [x, y, z] = jitter.at(t_s).matrix;
        [y[2] - z[1], z[0] - x[2], x[1] - y[0]].map(|twice| 0.5 * twice / ARCSEC_RAD)
    }

    #[test]
    fn the_rate_is_the_derivative() {
        let jitter = Jitter::new(&model(), 5);
        for t in [-0.3, 0.0, 12.34, 86_000.7] {
            assert!(rate_error(|t| jitter.at(t), t, 1e-3) < 1e-9, "{t}");
        }
    }

    #[test]
    fn the_random_part_has_the_deviation_and_correlation_asked_for() {
        let random = JitterModel { lines: Vec::new(), ..model() };
        let seeds = 2000;
        let mut products = [[0.0; 3]; 4];
        let delays = [0.0, 10.0, 30.0, 90.0];
        for seed in 0..seeds {
            let jitter = Jitter::new(&random, seed);
            let first = angles(&jitter, 1000.0);
            for (sums, delay) in products.iter_mut().zip(delays) {
                let later = angles(&jitter, 1000.0 + delay);
                (0..3).for_each(|k| sums[k] += first[k] * later[k] / random.random_arcsec[k].powi(2));
            }
        }
        for (sums, delay) in products.iter().zip(delays) {
            let expected = libm::exp(-delay / 30.0);
            for sum in sums {
                let mean = sum / seeds as f64;
                // 99 % of a mean of products of Gaussian numbers, whose variance is at most 2; and the cut.
                let bound = 2.576 * (2.0 / seeds as f64).sqrt() + 0.03;
                assert!((mean - expected).abs() < bound, "after {delay} s: {mean}, {expected}");
            }
        }
    }

    #[test]
    fn a_line_shakes_with_its_amplitude_and_frequency() {
        let shaking = JitterModel { random_arcsec: [0.0; 3], ..model() };
        let jitter = Jitter::new(&shaking, 9);
        let most = (0..1000)
            .map(|k| angles(&jitter, 1e-4 * f64::from(k) * 10.0 / 7.0))
            .fold([0.0; 3], |most, now| [0, 1, 2].map(|k| f64::max(most[k], now[k].abs())));
        assert!((most[0] - 3.0).abs() < 1e-3 && most[1] < 1e-9 && (most[2] - 5.0).abs() < 1e-3, "{most:?}");
        let (now, later) = (angles(&jitter, 3.0), angles(&jitter, 3.0 + 1.0 / 7.0));
        assert!((now[0] - later[0]).abs() < 1e-6);
    }

    #[test]
    fn another_seed_shakes_otherwise_and_none_not_at_all() {
        let at = |seed| Jitter::new(&model(), seed).at(5.0);
        assert_eq!(at(1), at(1));
        assert_ne!(at(1), at(2));
        assert_eq!(Jitter::default().at(5.0).rate_rad_s, [0.0; 3]);
    }
}
