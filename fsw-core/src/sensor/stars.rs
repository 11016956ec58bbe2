//! The star half of a second: self-test, acquisition, tracking, waiting for the Sun to leave.

use super::timekeeping::SECOND_US;
use super::{ABERRATION_RAD, Ephemeris, Sensor};
use crate::attitude::filter::Filter;
use crate::earth::reach;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::image::DetectionMethod;
use crate::image::scan;
use crate::modes::Mode;
use crate::orbit::constants::LIGHT_KM_S;
use crate::parameters::TrackingParameters;
use crate::plan;
use crate::stars::confirm::{Confirmed, Match, confirm_among, expected_stars};
use crate::stars::identify::Progress;
use crate::stars::predict::{Predicted, field_stars};
use crate::stars::{Field, row_delay_s, seen_later};
use crate::telemetry::{AttitudeReport, Event, Fault, FilteredAttitude, Report, StarReport, Status};
use fsw_hal::{Detector, DetectorError, LocalTime, Stage, StageMeter};

/// In the second of the scan identification has this part of its allowance.
const SCANNING_SHARE: u32 = 10;
/// For so long the first image is searched, and how often they may double: after a burst of noise the last noisy image
/// is searched for 16 s at most.
const FIRST_PATIENCE_US: i64 = 2 * SECOND_US;
const MOST_DOUBLINGS: u8 = 3;
/// Speed of a low orbit: what is not known of a velocity of which nothing is known, km/s.
const ORBITAL_KM_S: f64 = 7.9;
/// Angular radius of the Sun, rad: 0.267 deg.
const SUN_RADIUS_RAD: f32 = 4.66e-3;
/// Variance of an attitude whose stars were not corrected for aberration, rad².
const UNCORRECTED: f32 = ABERRATION_RAD * ABERRATION_RAD;

/// Whole seconds of a time, at most as many as telemetry holds.
fn whole_seconds(us: i64) -> u16 {
    (us.max(0) / SECOND_US).min(u16::MAX.into()) as u16
}

impl Sensor<'_> {
    /// The attitude that this second's own image gave.
    pub(super) fn attitude_of_this_second(&self, report: &Report) -> Option<Rotation<Icrs, StarPath>> {
        let predicted = matches!(report.status, Status::Blinded | Status::ImageRefused(_));
        let attitude = report.attitude.filter(|attitude| attitude.age_s == 0 && !predicted)?;
        Rotation::from_quaternion(attitude.quaternion)
    }

    /// Self-test: an image can be taken, and a window read twice gives the same values.
    #[inline(never)]
    pub(super) fn self_test(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        report: &mut Report,
    ) {
        report.status = match self.reads_alike(detector) {
            Ok(true) => Status::SelfTestPassed,
            Ok(false) => Status::DetectorFault(Fault::Hardware),
            Err(error) => Status::DetectorFault(error.into()),
        };
    }

    /// Whether every probe reads the same twice.
    fn reads_alike(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
    ) -> Result<bool, DetectorError> {
        for probe in &plan::probes(&detector.geometry()) {
            let area = probe.area();
            let buffer = &mut self.workspace.shared.readout()?.buffer;
            let (first, rest) = buffer.split_at_mut_checked(area).ok_or(DetectorError::BufferLength)?;
            let second = rest.get_mut(..area).ok_or(DetectorError::BufferLength)?;
            detector.read(*probe, first)?;
            detector.read(*probe, second)?;
            if first != second {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Lost in space: scan, then identify; a search that needs longer goes on with the same image, for [`FIRST_PATIENCE_US`]
    /// at first: hits and false stars of the next image are others. Each image given up doubles the time of the next,
    /// up to [`MOST_DOUBLINGS`] times, so that a search that truly needs long comes to its end.
    #[inline(never)]
    pub(super) fn acquire(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        report: &mut Report,
    ) {
        let mut allowance = self.parameters.identification.pairs_per_cycle;
        if self.searching_since.is_none() {
            // The scan has most of this second.
            allowance /= SCANNING_SHARE;
            meter.begin(Stage::Scan);
            let scanned = self.scan(detector);
            meter.end(Stage::Scan);
            if let Err(error) = scanned {
                return report.status = Status::DetectorFault(error.into());
            }
            report.detections = self.workspace.detections.spots().len() as u16;
            if self.workspace.detections.too_fast() {
                return report.status = Status::TooFast;
            }
            self.workspace.take_measured(&self.camera, None, 0.0);
            self.workspace.shared.begin_identification();
            self.searching_since = Some(self.now);
        }
        report.detections = self.workspace.detections.spots().len().min(usize::from(u16::MAX)) as u16;
        report.crowded = self.crowded();
        let field = Field::whole(&self.workspace.measured, &self.catalogue, &self.camera)
            .calibrated(self.calibration.as_ref());
        let identification = &self.parameters.identification;
        meter.begin(Stage::Identify);
        let Some(identifier) = self.workspace.shared.identifier() else {
            // Another image was read meanwhile: the search begins anew.
            self.searching_since = None;
            meter.end(Stage::Identify);
            return report.status = Status::Waiting;
        };
        let progress = identifier.advance(&field, identification, allowance);
        meter.end(Stage::Identify);
        match progress {
            Progress::Searching => {
                report.status = Status::Searching;
                let since_us = self.searching_since.map_or(0, |since| self.now.us_since(since));
                let patience_us = (FIRST_PATIENCE_US << self.images_given_up) - SECOND_US;
                // To the nearest second: calls are never exactly a second apart.
                if since_us + SECOND_US / 2 >= patience_us {
                    self.searching_since = None;
                    self.images_given_up = (self.images_given_up + 1).min(MOST_DOUBLINGS);
                }
            }
            Progress::NotIdentified(reason) => {
                self.searching_since = None;
                report.status = Status::NotIdentified(reason);
            }
            Progress::Identified(confirmed, log10_false) => {
                report.status = Status::Identified;
                self.images_given_up = 0;
                let image = self.searching_since.take().unwrap_or(self.now);
                self.measurement_update(&confirmed, log10_false, image, report);
            }
        }
    }

    /// Searches the whole image for stars.
    fn scan(&mut self, detector: &mut impl Detector<Error = DetectorError>) -> Result<(), DetectorError> {
        let method = DetectionMethod {
            parameters: &self.parameters.detection,
            calibration: self.calibration.as_ref(),
        };
        let buffer = &mut self.workspace.shared.readout()?.buffer;
        scan::scan(detector, buffer, method, &mut self.workspace.detections)
    }

    /// Follows known stars in windows about their predicted places.
    #[inline(never)]
    pub(super) fn track(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: Option<&Ephemeris>,
        report: &mut Report,
    ) {
        let TrackingParameters { gate_px, fewest_stars, .. } = self.parameters.tracking;
        meter.begin(Stage::Predict);
        let geometry = detector.geometry();
        let prediction =
            self.motion.as_ref().and_then(|motion| motion.at(self.now)).and_then(|(attitude, _)| {
                let mut predicted = field_stars(&self.catalogue, &self.camera, &attitude)?;
                self.delay_rows(&mut predicted, &attitude);
                let earth = ephemeris
                    .and_then(|ephemeris| self.known_view(&self.body(ephemeris, &attitude), &attitude));
                // A window that the limb's glow reaches is no good either.
                let margin_rad = (f32::from(gate_px) + reach::STRIP_MARGIN_PX) * self.camera.rad_per_px();
                let mask = earth.as_ref().map(|earth| {
                    let glow_rad = reach::glow_km(&self.parameters.earth) / earth.limb_distance_km();
                    earth.mask(glow_rad + margin_rad, &self.parameters.earth)
                });
                let hidden = |at_px| {
                    let seen = mask.as_ref().zip(self.camera.earth_direction(at_px));
                    seen.is_some_and(|(veil, direction)| veil.hides(&direction))
                };
                let windows = plan::star_windows(&predicted, &geometry, gate_px, hidden);
                Some((attitude, predicted, windows))
            });
        meter.end(Stage::Predict);
        let Some((attitude, predicted, windows)) = prediction else { return report.status = Status::Lost };

        meter.begin(Stage::Windows);
        let method = DetectionMethod {
            parameters: &self.parameters.detection,
            calibration: self.calibration.as_ref(),
        };
        let read = self.workspace.read_windows(detector, &windows, &method);
        meter.end(Stage::Windows);
        let washed = match read {
            Ok(washed) => washed,
            Err(error) => return report.status = Status::DetectorFault(error.into()),
        };

        if self.workspace.detections.too_fast() {
            return report.status = Status::TooFast;
        }
        let rate_rad_s = self.motion.as_ref().and_then(Filter::rate).map(|rate| rate.rad_s);
        self.workspace.take_measured(&self.camera, rate_rad_s.as_ref(), self.row_time_s());
        let measured = &self.workspace.measured;
        report.detections = measured.len() as u16;
        report.crowded = self.crowded();
        let field = Field::windows(measured, &self.catalogue, &self.camera, plan::searched_px(&windows))
            .calibrated(self.calibration.as_ref());
        meter.begin(Stage::Confirm);
        // Matching begins with twice the tolerance: with the whole gate.
        let confirmed = confirm_among(&predicted, &attitude, &field, f32::from(gate_px) * 0.5);
        meter.end(Stage::Confirm);
        match confirmed {
            Some(confirmed) if confirmed.matches.len() >= usize::from(fewest_stars) => {
                report.status = Status::Tracked;
                self.measurement_update(&confirmed, confirmed.log10_chance, self.now, report);
            }
            _ => self.follow_few(windows.len().saturating_sub(washed), report),
        }
    }

    /// Too few stars for an attitude of their own: each that is where the filter expects it corrects the filter. Where most of
    /// the windows that could show a star show none in its place, the attitude is lost: a single spot may be anything.
    #[inline(never)]
    fn follow_few(&mut self, clear_windows: usize, report: &mut Report) {
        report.status = Status::Lost;
        let Some(mut motion) = self.motion else { return };
        let Some((attitude, _)) = motion.at(self.now) else { return };
        let field = Field::whole(&self.workspace.measured, &self.catalogue, &self.camera)
            .calibrated(self.calibration.as_ref());
        let mut few = expected_stars(&attitude, &field, f32::from(self.parameters.tracking.gate_px));
        few.retain(|(_, star)| motion.observe_star(star, self.now));
        if few.is_empty() || 2 * few.len() < clear_windows {
            return;
        }
        self.motion = Some(motion);
        if self.report_predicted(report) {
            report.status = Status::Tracked;
            few.iter().for_each(|(found, _)| self.report_star(found, report));
        }
    }

    /// Tiles or windows of the image that were too crowded to be searched whole.
    fn crowded(&self) -> u16 {
        self.workspace.detections.crowded_tiles().min(u16::MAX.into()) as u16
    }

    /// From a row to the next, s.
    pub(super) fn row_time_s(&self) -> f32 {
        self.parameters.imaging.row_time_ns as f32 * 1e-9
    }

    /// Moves predicted stars to where they are at the time of their rows.
    fn delay_rows(&self, predicted: &mut [Predicted], attitude: &Rotation<Icrs, StarPath>) {
        let row_time_s = self.row_time_s();
        let rate = self.motion.as_ref().and_then(Filter::rate).filter(|_| row_time_s > 0.0);
        let Some(rate) = rate else { return };
        for place in predicted {
            let later_s = row_delay_s(&self.camera, place.centre_px, row_time_s);
            let seen =
                self.catalogue.star(place.star).map(|star| attitude.apply(&self.catalogue.seen(&star)));
            let then = seen.and_then(|seen| seen_later(&seen, &rate.rad_s, later_s));
            if let Some(at_px) = then.and_then(|direction| self.camera.project(&direction)) {
                place.centre_px = at_px;
            }
        }
    }

    /// Reports a blinded second, with the attitude that the last rate gives; at the begin of an outage also whether the Sun is where
    /// it can blind.
    pub(super) fn report_blinded(&self, ephemeris: Option<&Ephemeris>, report: &mut Report) {
        report.status = Status::Blinded;
        self.report_predicted(report);
        if report.mode != Mode::SunOutage && ephemeris.is_some_and(|ephemeris| self.sun_is_in_path(ephemeris))
        {
            report.note(Event::SunInPath);
        }
    }

    /// Whether the Sun's disc touches the field of a path, by the predicted attitude.
    fn sun_is_in_path(&self, ephemeris: &Ephemeris) -> bool {
        let Some((attitude, _)) = self.motion.as_ref().and_then(|motion| motion.at(self.now)) else {
            return false;
        };
        let in_star_path = attitude.apply(&ephemeris.sun);
        let in_earth_path = self.star_to_earth.apply(&in_star_path);
        let radius_px = SUN_RADIUS_RAD / self.camera.rad_per_px();
        [self.camera.project(&in_star_path), self.camera.project_earth(&in_earth_path)]
            .into_iter()
            .flatten()
            .any(|at_px| self.camera.contains(at_px, -radius_px))
    }

    /// Reports the filter's attitude as the second's, as long as its sigma is worth something; whether it is.
    pub(super) fn report_predicted(&self, report: &mut Report) -> bool {
        let Some((motion, (attitude, sigma_rad))) =
            self.motion.as_ref().and_then(|motion| Some((motion, motion.at(self.now)?)))
        else {
            return false;
        };
        let sigma_rad = self.with_aberration(sigma_rad);
        let limit = self.parameters.tracking.carried_sigma_rad;
        let known = sigma_rad.iter().all(|sigma| *sigma <= limit);
        if known {
            report.attitude = Some(AttitudeReport {
                quaternion: attitude.quaternion(),
                sigma_rad,
                log10_false: 0.0,
                age_s: whole_seconds(motion.age_us(self.now)),
            });
            report.rate_rad_s = motion.rate().map(|rate| rate.rad_s.into());
        }
        known
    }

    /// Whether the attitude predicted for the next second is within the gate about predicted stars, at three sigma.
    pub(super) fn prediction_is_within_gate(&self) -> bool {
        let gate_rad = f32::from(self.parameters.tracking.gate_px) * self.camera.rad_per_px();
        // Roll moves a star by its distance from the line of sight.
        let [right, bottom] = self.camera.middle_px();
        let lever = libm::sqrtf(right * right + bottom * bottom) * self.camera.rad_per_px();
        let next = self.motion.as_ref().and_then(|motion| motion.at(self.now.plus_us(SECOND_US)));
        next.is_some_and(|(_, [x, y, z])| {
            3.0 * libm::sqrtf(x * x + y * y + (lever * z) * (lever * z)) < gate_rad
        })
    }

    /// Sigmas of an attitude with what is not known of the orbital velocity, whose aberration turns all stars alike (5
    /// arcsec in a low orbit); about the line of sight it does not turn them.
    fn with_aberration(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        if !self.aberration_corrected {
            return [libm::sqrtf(x * x + UNCORRECTED), libm::sqrtf(y * y + UNCORRECTED), z];
        }
        let velocity = self.orbit.velocity_sigma_km_s().unwrap_or([ORBITAL_KM_S; 3]);
        let [u, v, w] = velocity.map(|sigma| (sigma.min(ORBITAL_KM_S) / LIGHT_KM_S) as f32);
        // Of three axes two lie across the line of sight: the mean of their variances.
        let square = (u * u + v * v + w * w) * (1.0 / 3.0);
        [libm::sqrtf(x * x + square), libm::sqrtf(y * y + square), z]
    }

    /// Takes the attitude of an image into the filter, and reports it.
    #[inline(never)]
    fn measurement_update(
        &mut self,
        confirmed: &Confirmed,
        log10_false: f32,
        image: LocalTime,
        report: &mut Report,
    ) {
        let (attitude, sigma_rad) = (confirmed.attitude, confirmed.sigma_rad);
        match &mut self.motion {
            Some(motion) => motion.observe(attitude, sigma_rad, image),
            None => self.motion = Some(Filter::begin(attitude, sigma_rad, image)),
        }
        let sigma_rad = self.with_aberration(sigma_rad);
        report.filtered =
            self.motion.as_ref().and_then(|motion| motion.at(image)).map(|(attitude, sigma_rad)| {
                FilteredAttitude {
                    quaternion: attitude.quaternion(),
                    sigma_rad: self.with_aberration(sigma_rad),
                }
            });
        report.attitude = Some(AttitudeReport {
            quaternion: attitude.quaternion(),
            sigma_rad,
            log10_false,
            age_s: whole_seconds(self.now.us_since(image)),
        });
        report.rate_rad_s = self.motion.as_ref().and_then(Filter::rate).map(|rate| rate.rad_s.into());
        report.focal_ratio = confirmed.focal_ratio;
        confirmed.matches.iter().for_each(|found| self.report_star(found, report));
    }

    /// Reports a star with its name.
    fn report_star(&self, found: &Match, report: &mut Report) {
        let seen = self.workspace.measured.get(usize::from(found.measured));
        if let (Some(seen), Some(star)) = (seen, self.catalogue.star(found.star)) {
            let recognised =
                StarReport { hip: star.hip, centre_px: seen.centre_px, residual_px: found.residual_px };
            // The report holds as many stars as confirmation matches.
            let _ = report.stars.push(recognised);
        }
    }
}
