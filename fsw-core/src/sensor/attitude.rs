//! The attitude of a second: an image's taken into the filter, or the filter's own, with the errors that all
//! stars share and no filter averages.

use super::Sensor;
use super::freshness::{Age, Solved};
use super::record::{Solution, StarRecord};
use super::timekeeping::SECOND_US;
use super::tracking::TurnChange;
use crate::attitude::filter::{Filter, seconds};
use crate::orbit::constants::LIGHT_KM_S;
use crate::order::fill;
use crate::stars::confirm::Confirmed;
use crate::stars::focal_ratio::FocalRatio;
use crate::telemetry::{AttitudeReport, FilteredAttitude, ImageFault};
use crate::trigonometry::hypotenuse;
use fsw_hal::LocalTime;
use nalgebra::Vector3;

/// Speed of a low orbit: what is not known of a velocity of which nothing is known, km/s.
const ORBITAL_KM_S: f32 = 7.9;
/// Aberration by the Earth's motion about the Sun and a low orbit's about the Earth, (30.3 + 7.9) km/s, rad:
/// 26 arcsec. An attitude whose stars were not corrected for it may be off by so much.
const ABERRATION_RAD: f32 = 1.27e-4;
/// Variance of an attitude whose stars were not corrected for aberration, rad².
const UNCORRECTED_RAD2: f32 = ABERRATION_RAD * ABERRATION_RAD;

/// Whole seconds of a time, at most as many as telemetry holds.
fn whole_seconds(us: i64) -> u16 {
    (us.max(0) / SECOND_US).min(u16::MAX.into()) as u16
}

/// Adds an error that an attitude may have about each axis, rad, to its standard deviations.
pub(super) fn widen(sigma_rad: &mut [f32; 3], by_rad: [f32; 3]) {
    for (sigma, by) in sigma_rad.iter_mut().zip(by_rad) {
        *sigma = hypotenuse(*sigma, by);
    }
}

impl Sensor<'_> {
    /// Takes the attitude of an image of the instant `image` into the filter; whether it could be taken: that
    /// of an old image, sold as new, is not.
    #[inline(never)]
    pub(super) fn measurement_update(
        &mut self,
        confirmed: &Confirmed,
        log10_false: f32,
        image: LocalTime,
        stars: &mut StarRecord,
    ) -> bool {
        let (attitude, mut sigma_rad) = (confirmed.attitude, confirmed.sigma_rad);
        let solved = Solved { attitude, sigma_rad, image };
        let age = self.age(&solved);
        match age {
            Age::New => {}
            Age::Unknown(way) => widen(&mut sigma_rad, way.into()),
            Age::Old => {
                stars.image_fault = Some(ImageFault::Repeated);
                stars.solution = self.propagated(true);
                return false;
            }
        }
        (self.former, self.likeliest) = (Some(attitude), None);
        if self.is_unexpected(&solved) {
            stars.image_fault = Some(ImageFault::Unexpected);
            stars.solution = None;
            return false;
        }
        if self.turning.is_of_lines() {
            widen(&mut sigma_rad, self.turning.middle_sigma_rad(self.exposure_s()).into());
        }
        widen(&mut sigma_rad, self.change_sigma_rad());
        self.motion.trust_again(&attitude, &sigma_rad, image);
        let change = self.turn_change;
        let updated = self.motion.as_mut().map(|motion| {
            if change == TurnChange::Onset && !motion.has_rate_sensor() {
                motion.reinitialise(attitude, sigma_rad, image);
                return false;
            }
            if change == TurnChange::Changing {
                motion.expect_change();
            }
            motion.measurement_update(attitude, sigma_rad, image)
        });
        if updated.is_none_or(|contradicts| self.shuts_rate_sensor_out(contradicts)) {
            let begun = Filter::new(attitude, sigma_rad, image);
            self.motion = match self.turning.rate_at(image) {
                Some(rate) => begun.with_rate(&rate).into(),
                None => begun.into(),
            };
        }
        if matches!(age, Age::New) {
            self.verify(solved);
        }
        let filtered = self.motion.as_ref().and_then(|motion| motion.at(image));
        stars.solution = Some(Solution {
            attitude: AttitudeReport {
                quaternion: attitude.quaternion(),
                sigma_rad: self.with_common_errors(sigma_rad),
                log10_false,
                age_s: whole_seconds(self.now.us_since(image)),
            },
            filtered: filtered.map(|(attitude, sigma_rad)| FilteredAttitude {
                quaternion: attitude.quaternion(),
                sigma_rad: self.with_common_errors(sigma_rad),
            }),
            rate_rad_s: self.motion.as_ref().and_then(Filter::rate).map(|rate| rate.rad_s.into()),
            focal_ratio: Some(self.refine_focal_length(&confirmed.focal_ratio, image)),
            predicted: false,
        });
        fill(&mut stars.matches, confirmed.matches.iter().copied());
        true
    }

    /// Takes the focal length that an image of the instant shows into the camera; the image's, over that of
    /// the parameters. The stars of later images are projected with it, and the Earth measured.
    pub(super) fn refine_focal_length(&mut self, seen: &FocalRatio, image: LocalTime) -> f32 {
        let ratio = self.focal_length.ratio() * seen.ratio;
        self.focal_length.update(ratio, seen.sigma, image);
        let told_px = self.parameters.camera.focal_length_px;
        if let Ok(camera) = self.camera.with_focal_length(told_px * self.focal_length.ratio()) {
            self.take_camera(camera);
        }
        ratio
    }

    /// The filter's attitude at this second, `None` where its sigma exceeds `carried_sigma_rad` about an
    /// axis; `predicted` says that no image of this second supports it: then there is none either where the
    /// last images contradicted the filter, as it turns as nobody knows.
    #[inline(never)]
    pub(super) fn propagated(&self, predicted: bool) -> Option<Solution> {
        let motion = self.motion.as_ref().filter(|motion| !predicted || motion.is_steady())?;
        let (attitude, sigma_rad) = motion.at(self.now)?;
        let mut sigma_rad = self.with_common_errors(sigma_rad);
        widen(&mut sigma_rad, [self.manoeuvred_rad(motion); 3]);
        let limit_rad = self.parameters.tracking.carried_sigma_rad;
        sigma_rad.iter().all(|sigma| *sigma <= limit_rad).then(|| Solution {
            attitude: AttitudeReport {
                quaternion: attitude.quaternion(),
                sigma_rad,
                log10_false: 0.0,
                age_s: whole_seconds(motion.age_us(self.now)),
            },
            filtered: None,
            rate_rad_s: motion.rate().map(|rate| rate.rad_s.into()),
            focal_ratio: None,
            predicted,
        })
    }

    /// By how much a manoeuvre may have turned it since the last image, one sigma an axis, rad.
    fn manoeuvred_rad(&self, motion: &Filter) -> f32 {
        let age_s = if motion.has_rate_sensor() { 0.0 } else { seconds(motion.age_us(self.now)) };
        0.5 * self.parameters.tracking.manoeuvre_rad_s2 * age_s * age_s
    }

    /// Whether the attitude predicted for the next second is within the gate about predicted stars, at three
    /// sigma.
    pub(super) fn prediction_is_within_gate(&self) -> bool {
        let off_px =
            self.motion.as_ref().and_then(|motion| self.three_sigma_px(motion, self.now.plus_us(SECOND_US)));
        off_px.is_some_and(|off_px| off_px < f32::from(self.parameters.tracking.gate_px))
    }

    /// Three sigma of where a filter predicts a star in the corner at an instant, px; `None` where it predicts
    /// none that could be tracked. Roll moves a star by its distance from the line of sight.
    pub(super) fn three_sigma_px(&self, motion: &Filter, instant: LocalTime) -> Option<f32> {
        let [right, bottom] = self.camera.middle_px();
        let rad_per_px = self.camera.rad_per_px();
        let lever = libm::sqrtf(right * right + bottom * bottom) * rad_per_px;
        let (_, [x, y, z]) = motion.at(instant).filter(|_| !self.is_too_fast_to_track(motion))?;
        Some(3.0 * libm::sqrtf(x * x + y * y + (lever * z) * (lever * z)) / rad_per_px)
    }

    /// Sigmas of an attitude with the errors that turn all stars alike, which no star of the image shows: the
    /// line of sight against where it was calibrated, and the aberration of what is not known of the orbital
    /// velocity (5 arcsec in a low orbit). About the line of sight they do not turn them.
    fn with_common_errors(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let boresight = self.parameters.mount.boresight_sigma_px * self.camera.rad_per_px();
        let common = boresight * boresight + self.aberration_rad2();
        [libm::sqrtf(x * x + common), libm::sqrtf(y * y + common), z]
    }

    /// Variance an axis of the aberration that is not taken off, rad².
    fn aberration_rad2(&self) -> f32 {
        if !self.aberration_corrected {
            return UNCORRECTED_RAD2;
        }
        let greatest_km2_s2 = 3.0 * ORBITAL_KM_S * ORBITAL_KM_S;
        let all_km2_s2 =
            self.orbit.velocity_trace_km2_s2().map_or(greatest_km2_s2, |all| all.min(greatest_km2_s2));
        // Of three axes two lie across the line of sight: the mean of their variances.
        all_km2_s2 * (1.0 / (3.0 * LIGHT_KM_S * LIGHT_KM_S)) as f32
    }
}

/// Standard deviation across a direction, rad, of an attitude with these about the axes.
pub(super) fn sigma_across(sigma_rad: [f32; 3], direction: &Vector3<f32>) -> f32 {
    let variance = Vector3::from(sigma_rad).map(|sigma| sigma * sigma);
    let across = direction.map(|axis| 1.0 - axis * axis);
    libm::sqrtf(0.5 * variance.dot(&across))
}
