//! A magnetometer beside the camera: how far it is to be believed.
//!
//! In: its reading less the field that orbit and attitude have there. Out: its zero, which is the
//! spacecraft's own field, and whether it tells the truth.
//!
//! The field itself is known to [`MagnetometerErrors::field_ut`] only, for minutes the same: readings do not
//! average that out. So a reading counts as one in [`LASTING_S`] in all that it corrects.

use fsw_ground::table::parameter_group;
use nalgebra::Vector3;

/// Time for which the model's error lasts, s: a satellite in a low orbit passes over 2,000 km of ground.
pub const LASTING_S: f32 = 300.0;
/// Sigmas of a reading, an axis, beyond which it contradicts orbit and attitude: 1e-6 an axis by chance.
pub const CONTRADICTION: f32 = 5.0;
/// Contradictions in a row after which it is not asked any more.
const MOST_DOUBTS: u8 = 3;

parameter_group! {
    /// The errors of a magnetometer, an axis; there is none unless it is set.
    pub struct MagnetometerErrors in "magnetometer" {
        /// Standard deviation of the noise of a reading.
        noise_ut: f32 = 0.25, 1e-3..=10.0, "uT", "thesis tab. A.12: 0.2 uT, and its steps";
        /// Standard deviation of its zero at first: the spacecraft's own field.
        zero_ut: f32 = 5.0, 1e-3..=1000.0, "uT", "chosen: a small satellite without a boom";
        /// Standard deviation of the change of its zero in a second.
        walk_ut: f32 = 2.5e-3, 0.0..=1.0, "uT", "thesis tab. A.12: 0.2 uT in 110 min";
        /// Standard deviation of the Earth's field against the model.
        field_ut: f32 = 0.15, 0.01..=10.0, "uT",
            "degrees 9 to 13 0.04 uT at 450 km, five years 0.09, a storm 0.1";
    }
}

/// What is known of a magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Magnetism {
    /// Its zero along the axes of the Earth path, uT.
    zero_ut: Vector3<f32>,
    /// Variance of it, an axis, uT².
    variance_ut2: f32,
    /// Readings in a row that contradicted orbit and attitude.
    doubts: u8,
}

/// Nothing is known.
impl Default for Magnetism {
    fn default() -> Self {
        Self { zero_ut: Vector3::zeros(), variance_ut2: f32::INFINITY, doubts: 0 }
    }
}

impl Magnetism {
    /// Its zero along the axes of the Earth path, uT.
    pub fn zero_ut(&self) -> Vector3<f32> {
        self.zero_ut
    }

    /// Standard deviation of the zero, an axis, uT.
    pub fn zero_sigma_ut(&self) -> f32 {
        libm::sqrtf(self.variance_ut2)
    }

    /// Whether it has contradicted orbit and attitude so often that it is not asked any more.
    pub fn is_shut_out(&self) -> bool {
        self.doubts >= MOST_DOUBTS
    }

    /// After some seconds the zero is another, and known no worse than by the parameters.
    pub fn propagate(&mut self, elapsed_s: f32, errors: &MagnetometerErrors) {
        let grown = self.variance_ut2 + errors.walk_ut * errors.walk_ut * elapsed_s.max(0.0);
        self.variance_ut2 = grown.min(errors.zero_ut * errors.zero_ut);
    }

    /// Variance, an axis, of a reading less zero and field: what it errs by from second to second, and what
    /// lasts. `field_ut` is that of the field.
    fn variances_ut2(&self, errors: &MagnetometerErrors, field_ut: f32) -> [f32; 2] {
        [errors.noise_ut * errors.noise_ut, field_ut * field_ut + self.variance_ut2]
    }

    /// Standard deviation of one reading less zero and field, an axis, uT.
    pub fn sigma_ut(&self, errors: &MagnetometerErrors, field_ut: f32) -> f32 {
        let [noise, lasting] = self.variances_ut2(errors, field_ut);
        libm::sqrtf(noise + lasting)
    }

    /// The same with which a filter may take a reading every second.
    pub fn averaged_sigma_ut(&self, errors: &MagnetometerErrors, field_ut: f32) -> f32 {
        let [noise, lasting] = self.variances_ut2(errors, field_ut);
        libm::sqrtf(noise + LASTING_S * lasting)
    }

    /// Takes a reading less the field that stars and orbit have there, uT, Earth path; `field_ut` is the
    /// field's standard deviation. One that contradicts what is known of the zero is not taken.
    pub fn learn(&mut self, off_ut: &Vector3<f32>, errors: &MagnetometerErrors, field_ut: f32) {
        let innovation = off_ut - self.zero_ut;
        let most_ut = CONTRADICTION * self.sigma_ut(errors, field_ut);
        // False for NaN.
        if !innovation.iter().all(|axis| libm::fabsf(*axis) < most_ut) {
            self.doubts = self.doubts.saturating_add(1);
            return;
        }
        self.doubts = 0;
        let measured = errors.noise_ut * errors.noise_ut + LASTING_S * field_ut * field_ut;
        let gain = self.variance_ut2 / (self.variance_ut2 + measured);
        self.zero_ut += innovation * gain;
        self.variance_ut2 *= 1.0 - gain;
    }
}

#[cfg(test)]
mod tests;
