//! A magnetometer of three axes behind its trait.
//!
//! In: the truth of a cycle, a seed. Out: the Earth's field ([`super::geomagnetism`]) in body axes as a
//! fluxgate measures it, a pure function of (scenario, seed, cycle): with the spacecraft's own constant
//! field, a random walk of the zero, white noise, in steps. The figures of the default are those of thesis
//! tab. A.12 (FGS1/COB05): noise 0.2 uT, drift 0.2 uT in 110 min, which as a random walk is 0.15 uT after an
//! hour; range 80 uT, 28.6 mV/uT through 12 bits over 5 V.

use super::geomagnetism::field_ut;
use crate::world::attitude::{Vector, apply};
use crate::world::motion::trajectory::Truth;
use crate::world::noise::{Noise, Stream};
use crate::world::random_walk;
use fsw_core::magnetism::MagnetometerErrors;
use fsw_hal::{LocalTime, MagneticField, Magnetometer, ReadingError};

/// Steps of the zero's walk in the time its drift is given for.
const STEPS_AN_HOUR: f64 = 3600.0;

/// The errors of a magnetometer; standard deviations where nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MagnetometerModel {
    /// White noise of a sample, uT.
    pub noise_ut: f64,
    /// Change of the zero after an hour, uT; it grows with the root of time.
    pub drift_ut_h: f64,
    /// The spacecraft's own field in body axes (hard iron), uT.
    pub hard_iron_ut: Vector,
    /// How well it is known, an axis, uT: what the flight code is told.
    pub zero_sigma_ut: f64,
    /// Step of the reading, uT; 0 for none.
    pub resolution_ut: f64,
    /// Greatest field along an axis, uT.
    pub range_ut: f64,
    /// By how much the ring current weakens the field at the equator, uT: 0.02 on a quiet day.
    pub ring_current_ut: f64,
}

impl Default for MagnetometerModel {
    fn default() -> Self {
        Self {
            noise_ut: 0.2,
            drift_ut_h: 0.15,
            hard_iron_ut: [0.0; 3],
            zero_sigma_ut: 5.0,
            resolution_ut: 0.043,
            range_ut: 80.0,
            ring_current_ut: 0.02,
        }
    }
}

impl MagnetometerModel {
    /// What the flight code's parameters say of it: its steps count as noise.
    pub fn flight_errors(&self) -> MagnetometerErrors {
        MagnetometerErrors {
            noise_ut: self.noise_ut.hypot(self.resolution_ut / 12.0_f64.sqrt()).clamp(1e-3, 10.0) as f32,
            zero_ut: self.zero_sigma_ut as f32,
            walk_ut: (self.drift_ut_h / STEPS_AN_HOUR.sqrt()) as f32,
            ..MagnetometerErrors::default()
        }
    }

    /// What the magnetometer reads in a cycle in a field of `field_ut` in body axes, uT; `None` beyond its
    /// range.
    pub fn reading_ut(&self, field_ut: Vector, seed: u64, cycle: u64) -> Option<Vector> {
        let run = Noise::new(seed, 0, Stream::Magnetometer);
        let sample = Noise::new(seed, cycle, Stream::Magnetometer);
        let step = u32::try_from(cycle).unwrap_or(u32::MAX);
        let mut reading = [0.0; 3];
        for (axis, slot) in (0u32..).zip(&mut reading) {
            let walk = random_walk::at(&run, axis, step) / STEPS_AN_HOUR.sqrt();
            let zero = self.hard_iron_ut[axis as usize] + self.drift_ut_h * walk;
            let value = field_ut[axis as usize] + zero + self.noise_ut * sample.gaussian(axis, 3);
            *slot = super::rounded(value, self.resolution_ut);
        }
        reading.iter().all(|value| value.abs() <= self.range_ut).then_some(reading)
    }
}

/// The magnetometer in one cycle.
#[derive(Debug, Clone, Copy)]
pub struct BodyMagnetometer<'a> {
    /// Its errors.
    pub model: &'a MagnetometerModel,
    /// The seed of the run.
    pub seed: u64,
    /// The cycle.
    pub cycle: u64,
    /// Its instant.
    pub instant: LocalTime,
    /// The truth of that cycle.
    pub truth: &'a Truth,
}

impl fsw_hal::ErrorType for BodyMagnetometer<'_> {
    type Error = ReadingError;
}

impl Magnetometer for BodyMagnetometer<'_> {
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, ReadingError> {
        let Truth { position_km, instant_us, earth_path, .. } = self.truth;
        let field = field_ut(*position_km, *instant_us, self.model.ring_current_ut);
        let field = apply(earth_path, field);
        let reading = self.model.reading_ut(field, self.seed, self.cycle);
        let ut = reading.ok_or(ReadingError::Saturated)?.map(|value| value as f32);
        Ok(Some(MagneticField { instant: self.instant, ut }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_have_the_field_the_hard_iron_and_the_noise_asked_for() {
        let model =
            MagnetometerModel { hard_iron_ut: [1.0, -2.0, 3.0], drift_ut_h: 0.0, ..Default::default() };
        let count = 20_000;
        let field = [20.0, -5.0, 31.0];
        let (mut sums, mut squares) = ([0.0; 3], [0.0; 3]);
        for cycle in 0..count {
            let reading = model.reading_ut(field, 3, cycle).unwrap();
            for k in 0..3 {
                let error = reading[k] - field[k] - model.hard_iron_ut[k];
                sums[k] += error;
                squares[k] += error * error;
            }
        }
        let n = count as f64;
        let variance = model.noise_ut.powi(2) + model.resolution_ut.powi(2) / 12.0;
        for k in 0..3 {
            assert!((sums[k] / n).abs() < 2.576 * (variance / n).sqrt(), "{sums:?}");
            assert!((squares[k] / n / variance - 1.0).abs() < 2.576 * (2.0 / n).sqrt(), "{squares:?}");
        }
    }

    #[test]
    fn the_zero_walks_and_strong_fields_are_refused() {
        let model = MagnetometerModel { noise_ut: 0.0, resolution_ut: 0.0, ..Default::default() };
        let seeds = 3000;
        // 110 minutes: the thesis's 0.2 uT.
        let square = |seed| model.reading_ut([0.0; 3], seed, 6600).unwrap()[1].powi(2);
        let deviation = ((0..seeds).map(square).sum::<f64>() / seeds as f64).sqrt();
        assert!((deviation / 0.203 - 1.0).abs() < 2.576 * (0.5 / seeds as f64).sqrt() + 2e-3, "{deviation}");
        assert!(model.reading_ut([0.0, 81.0, 0.0], 1, 0).is_none());
    }
}
