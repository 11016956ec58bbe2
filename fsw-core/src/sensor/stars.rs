//! The star half of a second: self-test, acquisition, tracking, waiting for the Sun to leave.

use super::{Instruments, Sensor, Sky};
use crate::attitude::filter::Filter;
use crate::earth::reach;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::image::Method;
use crate::image::blinding::blinded;
use crate::image::scan;
use crate::orbit::constants::LIGHT_KM_S;
use crate::parameters::TrackingParameters;
use crate::plan;
use crate::stars::confirm::{Confirmed, Match, confirm_among, expected_stars};
use crate::stars::identify::Progress;
use crate::stars::predict::{Predicted, field_stars};
use crate::stars::{Field, row_delay_s, seen_later};
use crate::telemetry::{AttitudeReport, Fault, FilteredAttitude, Report, StarReport, Status};
use fsw_hal::{Clock, Detector, DetectorError, Stage, StageMeter};

/// In the second of the scan identification has this part of its allowance.
const SCANNING_SHARE: u32 = 10;
/// Seconds for which the first image is searched, and how often they may double: after a burst of noise the last noisy image
/// is searched for 16 s at most.
const FIRST_PATIENCE_S: u32 = 2;
const MOST_DOUBLINGS: u8 = 3;
/// Speed of a low orbit: what is not known of a velocity of which nothing is known, km/s.
const ORBITAL_KM_S: f64 = 7.9;

impl Sensor<'_> {
    /// The attitude that this second's own image gave.
    pub(super) fn attitude_of_this_second(&self, report: &Report) -> Option<Rotation<Icrs, StarPath>> {
        let attitude =
            report.attitude.filter(|attitude| attitude.age_s == 0 && report.status != Status::Blinded)?;
        Rotation::from_quaternion(attitude.quaternion)
    }

    /// Takes an image; whether the Sun blinds it.
    fn expose(&mut self, detector: &mut impl Detector) -> Result<bool, DetectorError> {
        self.expose_for(detector, self.parameters.imaging.exposure_us)
    }

    /// Takes an image of this exposure time; whether the Sun blinds it.
    pub(super) fn expose_for(
        &mut self,
        detector: &mut impl Detector,
        exposure_us: u32,
    ) -> Result<bool, DetectorError> {
        detector.expose(exposure_us)?;
        let probes = plan::probes(&detector.geometry());
        let mut blind = 0;
        for probe in &probes {
            let buffer = &mut self.workspace.shared.readout()?.buffer;
            let pixels = buffer.get_mut(..probe.area()).ok_or(DetectorError::BufferLength)?;
            detector.read(*probe, pixels)?;
            blind += usize::from(blinded(pixels, detector.geometry().bits));
        }
        Ok(blind == probes.len())
    }

    /// Self-test: an image can be taken, and a window read twice gives the same values.
    #[inline(never)]
    pub(super) fn prove(&mut self, detector: &mut impl Detector, report: &mut Report) {
        report.status = match self.expose(detector).and_then(|_| self.reads_alike(detector)) {
            Ok(true) => Status::Proved,
            Ok(false) => Status::DetectorFault(Fault::Hardware),
            Err(error) => Status::DetectorFault(error.into()),
        };
    }

    /// Whether every probe reads the same twice.
    fn reads_alike(&mut self, detector: &mut impl Detector) -> Result<bool, DetectorError> {
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

    /// Lost in space: scan, then identify; a search that needs longer goes on with the same image, for [`FIRST_PATIENCE_S`]
    /// seconds at first: hits and false stars of the next image are others. Each image given up doubles the time of the next,
    /// up to [`MOST_DOUBLINGS`] times, so that a search that truly needs long comes to its end.
    #[inline(never)]
    pub(super) fn acquire(
        &mut self,
        instruments: &mut Instruments<impl Detector, impl Clock, impl StageMeter>,
        report: &mut Report,
    ) {
        let mut allowance = self.parameters.identification.pairs_per_cycle;
        if self.searching_since.is_none() {
            // The scan has most of this second.
            allowance /= SCANNING_SHARE;
            instruments.meter.begin(Stage::Scan);
            let scanned = self.scan(instruments.detector);
            instruments.meter.end(Stage::Scan);
            match scanned {
                Ok(true) => {}
                Ok(false) => return report.status = Status::Blinded,
                Err(error) => return report.status = Status::DetectorFault(error.into()),
            }
            report.detections = self.workspace.detections.spots().len() as u16;
            if self.workspace.detections.too_fast() {
                return report.status = Status::TooFast;
            }
            self.workspace.take_measured(&self.camera, None, 0.0);
            self.workspace.shared.begin_identification();
            self.searching_since = Some(self.cycle);
        }
        report.detections = self.workspace.detections.spots().len().min(usize::from(u16::MAX)) as u16;
        let field = Field::whole(&self.workspace.measured, &self.catalogue, &self.camera)
            .calibrated(self.calibration.as_ref());
        let identification = &self.parameters.identification;
        instruments.meter.begin(Stage::Identify);
        let Some(identifier) = self.workspace.shared.identifier() else {
            // Another image was read meanwhile: the search begins anew.
            self.searching_since = None;
            instruments.meter.end(Stage::Identify);
            return report.status = Status::Waiting;
        };
        let progress = identifier.advance(&field, identification, allowance);
        instruments.meter.end(Stage::Identify);
        match progress {
            Progress::Searching => {
                report.status = Status::Searching;
                let searched_s =
                    self.searching_since.map_or(0, |since| self.cycle.wrapping_sub(since)).saturating_add(1);
                if searched_s >= FIRST_PATIENCE_S << self.images_given_up {
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
                let image_cycle = self.searching_since.take().unwrap_or(self.cycle);
                self.learn(&confirmed, log10_false, image_cycle, report);
            }
        }
    }

    /// Takes an image and searches all of it; `false` when it is blinded.
    fn scan(&mut self, detector: &mut impl Detector) -> Result<bool, DetectorError> {
        if self.expose(detector)? {
            return Ok(false);
        }
        let method =
            Method { parameters: &self.parameters.detection, calibration: self.calibration.as_ref() };
        let buffer = &mut self.workspace.shared.readout()?.buffer;
        scan::scan(detector, buffer, method, &mut self.workspace.detections)?;
        Ok(true)
    }

    /// Follows known stars in windows about their predicted places.
    #[inline(never)]
    pub(super) fn track(
        &mut self,
        instruments: &mut Instruments<impl Detector, impl Clock, impl StageMeter>,
        sky: &Sky,
        report: &mut Report,
    ) {
        let TrackingParameters { gate_px, fewest_stars, .. } = self.parameters.tracking;
        instruments.meter.begin(Stage::Predict);
        let geometry = instruments.detector.geometry();
        let prediction =
            self.motion.as_ref().and_then(|motion| motion.at(self.cycle)).and_then(|(attitude, _)| {
                let mut predicted = field_stars(&self.catalogue, &self.camera, &attitude)?;
                self.delay_rows(&mut predicted, &attitude);
                let earth = self.known_view(&self.body(sky, &attitude), &attitude);
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
        instruments.meter.end(Stage::Predict);
        let Some((attitude, predicted, windows)) = prediction else { return report.status = Status::Lost };

        instruments.meter.begin(Stage::Windows);
        let detector = &mut *instruments.detector;
        let read = match self.expose(detector) {
            Ok(false) => {
                let parameters = &self.parameters.detection;
                let method = Method { parameters, calibration: self.calibration.as_ref() };
                self.workspace.read_windows(detector, &windows, &method).map(Some)
            }
            Ok(true) => Ok(None),
            Err(error) => Err(error),
        };
        instruments.meter.end(Stage::Windows);
        let washed = match read {
            Ok(Some(washed)) => washed,
            Ok(None) => return self.carry(report),
            Err(error) => return report.status = Status::DetectorFault(error.into()),
        };

        if self.workspace.detections.too_fast() {
            return report.status = Status::TooFast;
        }
        let rate_rad_s = self.motion.as_ref().and_then(Filter::rate).map(|rate| rate.rad_s);
        self.workspace.take_measured(&self.camera, rate_rad_s.as_ref(), self.row_time_s());
        let measured = &self.workspace.measured;
        report.detections = measured.len() as u16;
        let field = Field::windows(measured, &self.catalogue, &self.camera, plan::searched_px(&windows))
            .calibrated(self.calibration.as_ref());
        instruments.meter.begin(Stage::Confirm);
        // Matching begins with twice the tolerance: with the whole gate.
        let confirmed = confirm_among(&predicted, &attitude, &field, f32::from(gate_px) * 0.5);
        instruments.meter.end(Stage::Confirm);
        match confirmed {
            Some(confirmed) if confirmed.matches.len() >= usize::from(fewest_stars) => {
                report.status = Status::Tracked;
                self.learn(&confirmed, confirmed.log10_chance, self.cycle, report);
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
        let Some((attitude, _)) = motion.at(self.cycle) else { return };
        let field = Field::whole(&self.workspace.measured, &self.catalogue, &self.camera)
            .calibrated(self.calibration.as_ref());
        let mut few = expected_stars(&attitude, &field, f32::from(self.parameters.tracking.gate_px));
        few.retain(|(_, star)| motion.observe_star(star, self.cycle));
        if few.is_empty() || 2 * few.len() < clear_windows {
            return;
        }
        self.motion = Some(motion);
        if self.tell_carried(report) {
            report.status = Status::Tracked;
            few.iter().for_each(|(found, _)| self.tell_star(found, report));
        }
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

    /// Asks only whether the Sun still blinds, and carries the attitude on.
    #[inline(never)]
    pub(super) fn await_sunset(&mut self, detector: &mut impl Detector, report: &mut Report) {
        match self.expose(detector) {
            Ok(true) => self.carry(report),
            Ok(false) => report.status = Status::Waiting,
            Err(error) => report.status = Status::DetectorFault(error.into()),
        }
        if let Some(motion) = &mut self.motion {
            motion.carry(self.cycle, None);
        }
    }

    /// Reports a blinded second, with the attitude that the last rate gives.
    fn carry(&self, report: &mut Report) {
        report.status = Status::Blinded;
        self.tell_carried(report);
    }

    /// Reports the filter's attitude as the second's, as long as its sigma is worth something; whether it is.
    fn tell_carried(&self, report: &mut Report) -> bool {
        let Some((motion, (attitude, sigma_rad))) =
            self.motion.as_ref().and_then(|motion| Some((motion, motion.at(self.cycle)?)))
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
                age_s: motion.age(self.cycle).min(u16::MAX.into()) as u16,
            });
            report.rate_rad_s = motion.rate().map(|rate| rate.rad_s.into());
        }
        known
    }

    /// Whether the attitude carried to the next second is within the gate about predicted stars, at three sigma.
    pub(super) fn attitude_was_carried_well(&self) -> bool {
        let gate_rad = f32::from(self.parameters.tracking.gate_px) * self.camera.rad_per_px();
        // Roll moves a star by its distance from the line of sight.
        let [right, bottom] = self.camera.middle_px();
        let lever = libm::sqrtf(right * right + bottom * bottom) * self.camera.rad_per_px();
        let next = self.motion.as_ref().and_then(|motion| motion.at(self.cycle.wrapping_add(1)));
        next.is_some_and(|(_, [x, y, z])| {
            3.0 * libm::sqrtf(x * x + y * y + (lever * z) * (lever * z)) < gate_rad
        })
    }

    /// Sigmas of an attitude with what is not known of the orbital velocity, whose aberration turns all stars alike (5
    /// arcsec in a low orbit); about the line of sight it does not turn them.
    fn with_aberration(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let velocity = self.orbit.velocity_sigma_km_s().unwrap_or([ORBITAL_KM_S; 3]);
        let [u, v, w] = velocity.map(|sigma| (sigma.min(ORBITAL_KM_S) / LIGHT_KM_S) as f32);
        // Of three axes two lie across the line of sight: the mean of their variances.
        let square = (u * u + v * v + w * w) * (1.0 / 3.0);
        [libm::sqrtf(x * x + square), libm::sqrtf(y * y + square), z]
    }

    /// Takes over the attitude that an image taught, and reports it.
    #[inline(never)]
    fn learn(&mut self, confirmed: &Confirmed, log10_false: f32, image_cycle: u32, report: &mut Report) {
        let (attitude, sigma_rad) = (confirmed.attitude, confirmed.sigma_rad);
        match &mut self.motion {
            Some(motion) => motion.observe(attitude, sigma_rad, image_cycle),
            None => self.motion = Some(Filter::begin(attitude, sigma_rad, image_cycle)),
        }
        let sigma_rad = self.with_aberration(sigma_rad);
        report.filtered =
            self.motion.as_ref().and_then(|motion| motion.at(image_cycle)).map(|(attitude, sigma_rad)| {
                FilteredAttitude {
                    quaternion: attitude.quaternion(),
                    sigma_rad: self.with_aberration(sigma_rad),
                }
            });
        report.attitude = Some(AttitudeReport {
            quaternion: attitude.quaternion(),
            sigma_rad,
            log10_false,
            age_s: self.cycle.wrapping_sub(image_cycle).min(u16::MAX.into()) as u16,
        });
        report.rate_rad_s = self.motion.as_ref().and_then(Filter::rate).map(|rate| rate.rad_s.into());
        report.focal_ratio = confirmed.focal_ratio;
        confirmed.matches.iter().for_each(|found| self.tell_star(found, report));
    }

    /// Reports a star with its name.
    fn tell_star(&self, found: &Match, report: &mut Report) {
        let seen = self.workspace.measured.get(usize::from(found.measured));
        if let (Some(seen), Some(star)) = (seen, self.catalogue.star(found.star)) {
            let recognised =
                StarReport { hip: star.hip, centre_px: seen.centre_px, residual_px: found.residual_px };
            // The report holds as many stars as confirmation matches.
            let _ = report.stars.push(recognised);
        }
    }
}
