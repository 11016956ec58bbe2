//! A gyro of three axes behind the rate sensor's trait.
//!
//! In: the truth of a cycle, a seed. Out: the rate in body axes as a MEMS sensor measures it, a pure function
//! of (scenario, seed, cycle). `ω = round((1 + s) M ω_true + b + d W(t) + w)`: scale errors `s`, misalignment
//! `M`, bias `b` of the run, white noise `w` of the sample, and a random walk of the bias
//! ([`crate::world::random_walk`]). The figures of the default are those of thesis §A.3.2.2 and tab. A.13
//! (Bosch DRS-MM2.0): noise 0.22 deg/s, drift 0.15 deg/s/h, read as the walk's standard deviation after an
//! hour, range 100 deg/s, 17.5 mV/(deg/s) through 12 bits over 5 V. That sensor has one axis; three like it
//! are flown. The thesis gives neither bias nor scale nor alignment: 0.5 deg/s, 1 % and 0.5 deg are ordinary
//! for a car's.

use crate::world::attitude::{Vector, dot};
use crate::world::motion::trajectory::Truth;
use crate::world::noise::{Noise, Stream};
use crate::world::random_walk;
use fsw_core::attitude::filter::RateSensorNoise;
use fsw_hal::{AngularRate, LocalTime, RateSensor, ReadingError};

/// A slow turn, deg/s.
const SLOW_DEG_S: f64 = 0.1;
/// Steps of the bias's walk in the time its drift is given for.
const STEPS_AN_HOUR: f64 = 3600.0;

/// The errors of a gyro; standard deviations where nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroModel {
    /// White noise of a sample, deg/s.
    pub noise_deg_s: f64,
    /// Bias at the start, deg/s.
    pub bias_deg_s: f64,
    /// Change of the bias after an hour, deg/s; it grows with the root of time.
    pub drift_deg_s_h: f64,
    /// Scale error of an axis, a share.
    pub scale_error: f64,
    /// Angle by which an axis leans towards each of the others, deg.
    pub misalignment_deg: f64,
    /// Step of the reading, deg/s; 0 for none.
    pub resolution_deg_s: f64,
    /// Range of an axis, deg/s.
    pub range_deg_s: f64,
}

impl Default for GyroModel {
    fn default() -> Self {
        Self {
            noise_deg_s: 0.22,
            bias_deg_s: 0.5,
            drift_deg_s_h: 0.15,
            scale_error: 0.01,
            misalignment_deg: 0.5,
            resolution_deg_s: 0.07,
            range_deg_s: 100.0,
        }
    }
}

impl GyroModel {
    /// What the flight code's parameters say of it: rounding counts as noise; scale error and lean are those
    /// of a slow turn, in which they are as constant as the bias.
    pub fn flight_noise(&self) -> RateSensorNoise {
        let rad = |deg: f64| deg.to_radians() as f32;
        RateSensorNoise {
            white_rad: rad(self.noise_deg_s.hypot(self.resolution_deg_s / 12.0_f64.sqrt())),
            walk_rad_s: rad(self.drift_deg_s_h / STEPS_AN_HOUR.sqrt()),
            bias_rad_s: rad(self
                .bias_deg_s
                .max(SLOW_DEG_S * self.scale_error.hypot(self.misalignment_deg.to_radians()))),
        }
    }

    /// What the gyro reads in a cycle in which the body turns at `rate_deg_s`, deg/s; `None` beyond its
    /// range.
    pub fn reading_deg_s(&self, rate_deg_s: Vector, seed: u64, cycle: u64) -> Option<Vector> {
        // Rows of the run's noise: 0 scale, 1 bias, 2 and 3 alignment, 4 to 6 the walks.
        let run = Noise::new(seed, 0, Stream::RateSensor);
        let sample = Noise::new(seed, cycle, Stream::RateSensor);
        let lean = self.misalignment_deg.to_radians();
        let step = u32::try_from(cycle).unwrap_or(u32::MAX);
        let mut reading = [0.0; 3];
        for (axis, slot) in (0u32..).zip(&mut reading) {
            let k = axis as usize;
            let mut along = [0.0; 3];
            along[k] = 1.0;
            along[(k + 1) % 3] = lean * run.gaussian(axis, 2);
            along[(k + 2) % 3] = lean * run.gaussian(axis, 3);
            let walk = random_walk::at(&run, 4 + axis, step) / STEPS_AN_HOUR.sqrt();
            let bias = self.bias_deg_s * run.gaussian(axis, 1) + self.drift_deg_s_h * walk;
            let scaled = (1.0 + self.scale_error * run.gaussian(axis, 0)) * dot(along, rate_deg_s);
            let value = scaled + bias + self.noise_deg_s * sample.gaussian(axis, 7);
            *slot = super::rounded(value, self.resolution_deg_s);
        }
        reading.iter().all(|value| value.abs() <= self.range_deg_s).then_some(reading)
    }
}

/// The gyro in one cycle.
#[derive(Debug, Clone, Copy)]
pub struct Gyro<'a> {
    /// Its errors.
    pub model: &'a GyroModel,
    /// The seed of the run.
    pub seed: u64,
    /// The cycle.
    pub cycle: u64,
    /// Its instant.
    pub instant: LocalTime,
    /// The truth of that cycle.
    pub truth: &'a Truth,
}

impl fsw_hal::ErrorType for Gyro<'_> {
    type Error = ReadingError;
}

impl RateSensor for Gyro<'_> {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, ReadingError> {
        let rate_deg_s = self.truth.body_rate_rad_s().map(f64::to_degrees);
        let reading = self.model.reading_deg_s(rate_deg_s, self.seed, self.cycle);
        let rad_s = reading.ok_or(ReadingError::Saturated)?.map(|value| value.to_radians() as f32);
        Ok(Some(AngularRate { instant: self.instant, rad_s }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Allan variance of means over `length` samples, and how many differences it rests on.
    fn allan(samples: &[f64], length: usize) -> (f64, f64) {
        let means: Vec<f64> =
            samples.chunks_exact(length).map(|c| c.iter().sum::<f64>() / length as f64).collect();
        let count = (means.len() - 1) as f64;
        (means.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>() / (2.0 * count), count)
    }

    #[test]
    fn noise_density_and_bias_walk_are_those_asked_for() {
        let model = GyroModel::default();
        let samples: Vec<Vector> =
            (0..400_000).map(|cycle| model.reading_deg_s([0.07, 0.0, -0.02], 11, cycle).unwrap()).collect();
        // Variance a sample with that of rounding; the walk's own, K² t / 3, has K = 0.15 deg/s in an hour.
        let white = model.noise_deg_s.powi(2) + model.resolution_deg_s.powi(2) / 12.0;
        let walk = model.drift_deg_s_h.powi(2) / 3600.0;
        for axis in 0..3 {
            let series: Vec<f64> = samples.iter().map(|sample| sample[axis]).collect();
            for length in [1, 4, 1024, 4096] {
                let (variance, count) = allan(&series, length);
                let time = length as f64;
                // The walk's means over whole samples: K² (t / 3 + 1 / (6 t)).
                let expected = white / time + walk * (time / 3.0 + 1.0 / (6.0 * time));
                // Neighbouring differences share a mean: two thirds as many degrees of freedom as
                // differences. All twelve comparisons together hold for a right gyro with 99 %.
                let bound = 3.34 * (2.0 / (2.0 / 3.0 * count)).sqrt();
                println!("axis {axis}, {length} s: {:.5} deg/s for {:.5}", variance.sqrt(), expected.sqrt());
                assert!((variance / expected - 1.0).abs() < bound, "axis {axis}, {length} s");
            }
        }
    }

    #[test]
    fn the_errors_of_a_run_have_their_deviations() {
        let quiet = GyroModel { noise_deg_s: 0.0, resolution_deg_s: 0.0, ..GyroModel::default() };
        let seeds = 4000;
        let mut squares = [0.0; 3];
        for seed in 0..seeds {
            let bias = quiet.reading_deg_s([0.0; 3], seed, 0).unwrap();
            let turning = quiet.reading_deg_s([10.0, 0.0, 0.0], seed, 0).unwrap();
            squares[0] += bias[0].powi(2) / quiet.bias_deg_s.powi(2);
            squares[1] += ((turning[0] - bias[0]) / 10.0 - 1.0).powi(2) / quiet.scale_error.powi(2);
            squares[2] +=
                ((turning[1] - bias[1]) / 10.0).powi(2) / quiet.misalignment_deg.to_radians().powi(2);
        }
        // All three together hold for a right gyro with 99 %.
        for square in squares {
            let mean = square / seeds as f64;
            assert!((mean - 1.0).abs() < 2.935 * (2.0 / seeds as f64).sqrt() + 1e-3, "{squares:?}");
        }
    }

    #[test]
    fn readings_come_in_steps_and_end_at_the_range() {
        let model = GyroModel::default();
        for value in model.reading_deg_s([3.0, -7.0, 0.1], 2, 77).unwrap() {
            let steps = value / model.resolution_deg_s;
            assert!((steps - libm::rint(steps)).abs() < 1e-9);
        }
        assert!(model.reading_deg_s([120.0, 0.0, 0.0], 2, 77).is_none());
    }

    #[test]
    fn a_cycle_alone_reads_the_same_and_another_seed_does_not() {
        let model = GyroModel::default();
        let read = |seed, cycle| model.reading_deg_s([1.0, 2.0, 3.0], seed, cycle);
        assert_eq!(read(1, 5000), read(1, 5000));
        assert_ne!(read(1, 5000), read(2, 5000));
        assert_ne!(read(1, 5000), read(1, 5001));
    }
}
