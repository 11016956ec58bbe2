//! The filter's measurement update by an attitude or a single star, adaptation of the process noise,
//! reinitialisation.

use super::blocks::product;
use super::{
    ATTITUDE, CONSISTENCY_IMAGES, CORRELATED_SHARE, FIRST_PROCESS_NOISE_RAD, Filter, MAX_RATE_BASE_S,
    MAX_STEP_S, MIN_RATE_BASE_S, MRAD, NOISE_DECAY, NOISE_GROWTH, RATE, RESTART_NIS, Rate, seconds, square,
    squares,
};
use crate::attitude::VectorPair;
use crate::attitude::covariance::Information;
use crate::frames::{Icrs, Rotation, StarPath};
use fsw_hal::LocalTime;
use nalgebra::{Matrix3, Vector3};

impl Filter {
    /// Measurement update by an attitude; one of an earlier instant, or with NIS >= 40, reinitialises the
    /// filter. Whether it contradicts the rate sensor: its readings led elsewhere.
    pub fn measurement_update(
        &mut self,
        attitude: Rotation<Icrs, StarPath>,
        sigma_rad: [f32; 3],
        instant: LocalTime,
    ) -> bool {
        let mut then = *self;
        let propagated = then.propagate(instant, None);
        let innovation = attitude.angle_from(&then.attitude);
        let variance = squares(&Vector3::from(sigma_rad));
        if propagated && then.correct_attitude(&innovation, &variance) {
            (then.updated_at, then.rate_seen_at) = (instant, instant);
            *self = then;
            false
        } else {
            let contradicts = propagated && self.sensor.is_some();
            *self = self.begun_after((&then, propagated), attitude, sigma_rad, instant);
            contradicts
        }
    }

    /// Begins anew with an attitude, and the rate from the last one to it.
    pub fn reinitialise(
        &mut self,
        attitude: Rotation<Icrs, StarPath>,
        sigma_rad: [f32; 3],
        instant: LocalTime,
    ) {
        let mut then = *self;
        let propagated = then.propagate(instant, None);
        *self = self.begun_after((&then, propagated), attitude, sigma_rad, instant);
    }

    /// The same, the state being carried on to the instant where it could be `propagated`.
    fn begun_after(
        &self,
        (then, propagated): (&Self, bool),
        attitude: Rotation<Icrs, StarPath>,
        sigma_rad: [f32; 3],
        instant: LocalTime,
    ) -> Self {
        let anew = Self {
            sensor: self.sensor,
            reading: self.reading,
            contradicted_at: propagated.then_some(instant).or(self.contradicted_at),
            ..Self::new(attitude, sigma_rad, instant)
        };
        let elapsed_s = seconds(instant.us_since(self.updated_at));
        anew.with_rate_after(then, &attitude.angle_from(&then.attitude), elapsed_s)
    }

    /// Measurement update by a single star: two axes across its direction. `false`, and no change, where
    /// the state cannot be propagated to `instant` or the innovation exceeds the limit.
    #[inline(never)]
    pub fn measurement_update_star(&mut self, star: &VectorPair, instant: LocalTime) -> bool {
        if !self.measurement_update_direction(star, instant) {
            return false;
        }
        let direction = self.attitude.apply(&star.reference);
        let coloured = direction.vector().map(|axis| square(star.sigma_rad) * (1.0 - axis * axis));
        self.variance = self.variance.sup(&coloured);
        (self.updated_at, self.rate_seen_at) = (instant, instant);
        true
    }

    /// The same by a direction that no image shows: the attitude's age goes on.
    #[inline(never)]
    pub fn measurement_update_direction(&mut self, pair: &VectorPair, instant: LocalTime) -> bool {
        let mut then = *self;
        if !then.propagate(instant, None) {
            return false;
        }
        let expected = then.attitude.apply(&pair.reference);
        let expected = expected.vector();
        let innovation = pair.measured.vector().cross(expected);
        // Two axes across the direction.
        let away = if expected.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
        let Some(right) = away.cross(expected).try_normalize(1e-3) else { return false };
        let up = expected.cross(&right);
        let (p, variance) = (then.covariance.at(ATTITUDE, ATTITUDE), square(pair.sigma_rad));
        let (across, both, along) = (right.dot(&(p * right)), right.dot(&(p * up)), up.dot(&(p * up)));
        let (across, along) = (across + variance, along + variance);
        // S⁻¹ = E (Eᵀ P E + R)⁻¹ Eᵀ with E the two axes.
        let per = 1.0 / (across * along - both * both);
        let inverse = (right * right.transpose() * along + up * up.transpose() * across
            - (right * up.transpose() + up * right.transpose()) * both)
            * per;
        let left = Matrix3::identity() - product(&p, &inverse);
        if !then.correct(ATTITUDE, &innovation, &inverse, &left, 2.0) {
            return false;
        }
        *self = then;
        true
    }

    /// Measurement update by a rate that was measured without an attitude; none of a filter with a rate
    /// sensor. `false`, and no change, where the state cannot be propagated to `instant` or the innovation
    /// exceeds the limit.
    pub fn measurement_update_rate(&mut self, rate: &Rate, instant: LocalTime) -> bool {
        let mut then = *self;
        if self.sensor.is_some() || !then.propagate(instant, None) {
            return false;
        }
        let innovation = rate.rad_s - then.driven;
        let taken = then.correct_block(RATE, &innovation, &squares(&rate.sigma_rad_s));
        if taken {
            then.rate_seen_at = instant;
            *self = then;
        }
        taken
    }

    /// Correction by an attitude, three axes.
    fn correct_attitude(&mut self, innovation: &Vector3<f32>, variance: &Vector3<f32>) -> bool {
        let correct = self.correct_block(ATTITUDE, innovation, &(variance * (1.0 - CORRELATED_SHARE)));
        if correct {
            self.variance = *variance;
        }
        correct
    }

    /// Correction by one of the states, three axes of an error of so much variance, mrad and s.
    fn correct_block(&mut self, observed: usize, innovation: &Vector3<f32>, variance: &Vector3<f32>) -> bool {
        let white = Matrix3::from_diagonal(variance);
        let sum = self.covariance.at(observed, observed) + white;
        let Some(inverse) = Information::from_sum(sum).covariance_rad2() else { return false };
        // `covariance_rad2` returns rad² for a matrix in 1 / mrad².
        let inverse = inverse * (MRAD * MRAD);
        // I - P S⁻¹ as R S⁻¹, without cancellation where S is much greater than R.
        self.correct(observed, innovation, &inverse, &product(&white, &inverse), 3.0)
    }

    /// Kalman correction by the state of number `observed`: `inverse` of the innovation's covariance, 1 /
    /// mrad², `left` = I - K for that state's row, `freedom` of the innovation; `false`, and no change, for a
    /// NIS of 40 or more.
    #[inline(never)]
    fn correct(
        &mut self,
        observed: usize,
        innovation: &Vector3<f32>,
        inverse: &Matrix3<f32>,
        left: &Matrix3<f32>,
        freedom: f32,
    ) -> bool {
        let nis = innovation.dot(&(inverse * innovation)) * (MRAD * MRAD);
        if nis.is_nan() || nis >= RESTART_NIS {
            return false;
        }
        self.update_process_noise(nis / freedom);
        let before = self.covariance;
        for row in [ATTITUDE, RATE] {
            let gain = product(&before.at(row, observed), inverse);
            let step = gain * innovation;
            if row == ATTITUDE {
                self.attitude = self.attitude.turned(&step);
            } else {
                self.driven += step;
            }
            for column in row..=RATE {
                let block = if row == observed {
                    product(left, &before.at(row, column))
                } else {
                    before.at(row, column) - product(&gain, &before.at(observed, column))
                };
                self.covariance.set_block(row, column, block);
            }
        }
        // Renormalises the rotation matrix.
        if let Some(attitude) = Rotation::from_quaternion(self.attitude.quaternion()) {
            self.attitude = attitude;
        }
        true
    }

    /// Adapts the process noise to the mean NIS; not with a rate sensor, whose noise is given.
    fn update_process_noise(&mut self, square: f32) {
        self.mean_nis += (square - self.mean_nis) * (1.0 / CONSISTENCY_IMAGES);
        if self.sensor.is_some() {
            return;
        }
        let factor = match self.mean_nis {
            above if above > NOISE_GROWTH.0 => NOISE_GROWTH.1,
            below if below < NOISE_DECAY.0 => NOISE_DECAY.1,
            _ => 1.0,
        };
        let (least, greatest) = self.process_noise_limits();
        self.process_noise_psd = (self.process_noise_psd * factor).max(least).min(greatest);
    }

    /// Reinitialised filter with a rate from the state before: corrected by the innovation over the elapsed
    /// time if that is 0.05 to 10 s, else the old rate with a larger covariance.
    fn with_rate_after(mut self, before: &Self, innovation: &Vector3<f32>, elapsed_s: f32) -> Self {
        let per_second = 1.0 / elapsed_s.max(MIN_RATE_BASE_S);
        let rate = innovation * per_second;
        if (MIN_RATE_BASE_S..=MAX_RATE_BASE_S).contains(&elapsed_s) && self.sensor.is_none() {
            self.driven += before.driven + rate;
            self.covariance.set_block(ATTITUDE, RATE, Matrix3::from_diagonal(&(self.variance * per_second)));
            let both = (self.variance + before.variance) * (per_second * per_second);
            self.covariance.set_block(RATE, RATE, Matrix3::from_diagonal(&both));
            self.has_rate = true;
        } else if before.has_rate {
            // After a longer gap the old rate is kept, its variance increased by the initial process noise.
            let changed = Matrix3::from_diagonal_element(
                square(FIRST_PROCESS_NOISE_RAD) * elapsed_s.clamp(0.0, MAX_STEP_S),
            );
            self.driven += before.driven;
            self.covariance.set_block(RATE, RATE, before.covariance.at(RATE, RATE) + changed);
            self.has_rate = true;
        }
        if before.has_rate && self.sensor.is_none() {
            let (least, greatest) = self.process_noise_limits();
            self.process_noise_psd = (square(rate.norm()) * per_second).max(least).min(greatest);
        }
        self
    }
}
