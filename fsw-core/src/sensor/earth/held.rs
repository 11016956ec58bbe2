//! An attitude that is held to the Earth while the star path is shut.
//!
//! Without stars the attitude is carried on, and grows worse by the minute. The Earth path still shows the
//! limb, and the orbit says where its centre is: the direction to it gives two axes of the attitude, as a
//! single star does, once it is known better than the carried attitude: in GEO after two minutes, in a low
//! orbit, whose limb leaves it 0.2 deg, later. About that direction the attitude is carried on. An Earth that
//! contradicts it tells of a turn that nobody measured: nothing is told then. The orbit learns nothing of
//! such a limb: the attitude would be counted twice.
//!
//! In: the carried attitude, the orbit, the second's limb. Out: the attitude corrected.

use super::{Prediction, add_turn};
use crate::attitude::VectorPair;
use crate::earth::centre::CentrePrior;
use crate::earth::{Body, EarthFix};
use crate::frames::{Direction, EarthPath, Icrs, Rotation};
use crate::matrix::{dot, inverse, product, symmetric_product};
use crate::sensor::Sensor;
use crate::sensor::attitude::sigma_across;
use crate::sensor::propagation::Ephemeris;
use crate::sensor::record::{EarthRecord, Looked};
use fsw_hal::{Detector, DetectorError, Stage, StageMeter};
use nalgebra::{Matrix3, Vector3};

/// What is known of a direction before the limb is measured, rad: nothing. It leaves the orbit's range alone.
const UNKNOWN_RAD: f64 = 0.1;
/// Sigmas, of the worse of both, from which the Earth contradicts the attitude: errors of the limb last, so
/// that what was held to it differs by less.
const CONTRADICTION: f32 = 4.0;
/// The limb's heights stay for minutes, and what they shift is not averaged. The filter counts 0.35 of a
/// variance as such: so many sigmas make it all.
const LASTING: f32 = 1.7;

impl Sensor<'_> {
    /// Measures the limb of this second, in which the star path is shut, and corrects the carried attitude by
    /// it.
    #[inline(never)]
    pub(in crate::sensor) fn hold_by_earth(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: &Ephemeris,
    ) -> Result<EarthRecord, DetectorError> {
        let carried = self.motion.as_ref().and_then(|motion| motion.at(self.now));
        let Some((rotation, sigma_rad)) = carried else { return Ok(EarthRecord::default()) };
        let body = self.body(ephemeris, &rotation);
        let by_orbit =
            self.prediction(&body, &rotation, ephemeris.terrestrial_us).filter(Prediction::is_known);
        let Some(by_orbit) = by_orbit else { return Ok(EarthRecord::default()) };
        let predicted = by_orbit.seen_by(self.mounting().matrix(), sigma_rad);
        meter.begin(Stage::Limb);
        let unlit = self.unlit(&predicted);
        meter.end(Stage::Limb);
        let looked = match unlit {
            Some(unlit) => unlit,
            None => self.find_predicted(detector, meter, &body, &predicted)?,
        };
        let path = self.earth_path(&rotation);
        let seen = match &looked {
            Looked::Found(fix) => self.direction_to_earth(&by_orbit, fix, &path),
            _ => None,
        };
        if let (Some(seen), Some(motion)) = (seen, self.motion.as_mut()) {
            let across_rad = sigma_across(sigma_rad, seen.measured.vector());
            let off = seen.measured.vector().cross(rotation.apply(&seen.reference).vector());
            if off.norm() > CONTRADICTION * seen.sigma_rad.max(across_rad) {
                motion.contradict(self.now);
            } else if seen.sigma_rad < across_rad {
                let lasting = VectorPair { sigma_rad: LASTING * seen.sigma_rad, ..seen };
                motion.measurement_update_star(&lasting, self.now);
            }
        }
        Ok(EarthRecord { dark: Some(matches!(looked, Looked::Dark)), looked })
    }

    /// The Earth in strips across the predicted limb. Where too few of them can be placed it is not looked
    /// for: the second has no time for a search.
    #[inline(never)]
    fn find_predicted(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        body: &Body,
        predicted: &Prediction,
    ) -> Result<Looked, DetectorError> {
        let strips = self.predicted_strips(detector, meter, body, Some(predicted))?;
        if !self.has_enough(&strips) {
            return Ok(Looked::Not);
        }
        let prior = CentrePrior::new(predicted.centre_km, &predicted.covariance_km2);
        Ok(self.fit(meter, body, (&strips, prior.as_ref()), false))
    }

    /// The direction to the Earth's centre as the limb and the orbit's range give it, beside where the orbit
    /// has it; its sigma holds the orbit and the paths' misalignment.
    fn direction_to_earth(
        &self,
        by_orbit: &Prediction,
        fix: &EarthFix,
        path: &Rotation<Icrs, EarthPath>,
    ) -> Option<VectorPair> {
        let predicted_km = by_orbit.centre_km.map(f64::from);
        let mut prior_km2 = by_orbit.covariance_km2;
        let unknown = Matrix3::from_diagonal_element(UNKNOWN_RAD * UNKNOWN_RAD);
        add_turn(&mut prior_km2, &by_orbit.centre_km, &unknown);
        let (prior, seen) = (inverse(&prior_km2)?, inverse(&fix.covariance_km2.map(f64::from))?);
        let covariance_km2 = inverse(&(prior + seen))?;
        let away_km = fix.centre_km.map(f64::from) - predicted_km;
        let centre_km = predicted_km + product(&covariance_km2, &product(&seen, &away_km));
        // Of both axes across: the measurement's errors and the orbit's.
        let across = |covariance_km2: &Matrix3<f64>| {
            let along =
                dot(&predicted_km, &product(covariance_km2, &predicted_km)) / predicted_km.norm_squared();
            (covariance_km2.trace() - along) / predicted_km.norm_squared()
        };
        let variance = across(&covariance_km2) + across(&by_orbit.covariance_km2);
        let in_path =
            |vector_km: Vector3<f64>| Direction::<EarthPath>::new(vector_km.map(|axis| axis as f32));
        Some(VectorPair {
            measured: self.mounting().inverse().apply(&in_path(centre_km)?),
            reference: path.inverse().apply(&in_path(predicted_km)?),
            sigma_rad: libm::sqrtf(variance.max(0.0) as f32),
        })
    }
}

impl Prediction {
    /// The same as an attitude of these standard deviations about the star path's axes, rad, sees it.
    fn seen_by(&self, to_path: &Matrix3<f32>, sigma_rad: [f32; 3]) -> Self {
        let variance =
            Matrix3::from_diagonal(&Vector3::from(sigma_rad).map(|sigma| f64::from(sigma * sigma)));
        let in_path = symmetric_product(&to_path.map(f64::from), &variance);
        let mut covariance_km2 = self.covariance_km2;
        add_turn(&mut covariance_km2, &self.centre_km, &in_path);
        Self { covariance_km2, ..*self }
    }
}
