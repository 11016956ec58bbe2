//! Self-test, and lost in space: an image scanned for stars, which are identified without prior knowledge.

use super::Sensor;
use super::record::StarRecord;
use super::timekeeping::SECOND_US;
use crate::image::DetectionMethod;
use crate::image::scan;
use crate::plan;
use crate::stars::StarField;
use crate::stars::identify::Progress;
use crate::telemetry::{DetectorFault, Outcome};
use fsw_hal::{Detector, DetectorError, Stage, StageMeter};

/// In the second of the scan identification has this part of its allowance.
const SCANNING_SHARE: u32 = 10;
/// For so long the first image is searched, and how often they may double: after a burst of noise the last
/// noisy image is searched for 16 s at most.
const FIRST_PATIENCE_US: i64 = 2 * SECOND_US;
const MOST_DOUBLINGS: u8 = 3;

impl Sensor<'_> {
    /// Self-test: an image can be taken, and a window read twice gives the same values.
    #[inline(never)]
    pub(super) fn self_test(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
    ) -> Result<Outcome, DetectorFault> {
        for probe in &plan::probes(&detector.geometry()) {
            let area = probe.area();
            let buffer = &mut self.workspace.shared.readout().buffer;
            let halves = buffer.split_at_mut_checked(area);
            let halves = halves.and_then(|(first, rest)| Some((first, rest.get_mut(..area)?)));
            let (first, second) = halves.ok_or(DetectorFault::Request)?;
            detector.read(*probe, first)?;
            detector.read(*probe, second)?;
            if first != second {
                return Err(DetectorFault::Hardware);
            }
        }
        Ok(Outcome::SelfTestPassed)
    }

    /// Lost in space: scan, then identify; a search that needs longer goes on with the same image, for
    /// [`FIRST_PATIENCE_US`] at first: hits and false stars of the next image are others. Each image given up
    /// doubles the time of the next, up to [`MOST_DOUBLINGS`] times, so that a search that truly needs long
    /// comes to its end. `None` where the search begins anew in the next second.
    #[inline(never)]
    pub(super) fn acquire(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        stars: &mut StarRecord,
    ) -> Result<Option<Outcome>, DetectorError> {
        let scans = self.searching_since.is_none();
        if scans {
            meter.begin(Stage::Scan);
            let scanned = self.scan(detector);
            meter.end(Stage::Scan);
            scanned?;
        }
        let detections = &self.workspace.detections;
        stars.count(detections.spots().len(), detections);
        if scans {
            if detections.too_fast() {
                return Ok(Some(Outcome::TooFast));
            }
            self.begin_identification();
        }
        meter.begin(Stage::Identify);
        let progress = self.identify(scans);
        meter.end(Stage::Identify);
        Ok(self.conclude(progress.as_ref(), stars))
    }

    /// Searches the whole image for stars.
    fn scan(&mut self, detector: &mut impl Detector<Error = DetectorError>) -> Result<(), DetectorError> {
        let method = DetectionMethod {
            parameters: &self.parameters.detection,
            calibration: self.calibration.as_ref(),
        };
        let buffer = &mut self.workspace.shared.readout().buffer;
        scan::scan(detector, buffer, method, &mut self.workspace.detections)
    }

    /// Begins to identify the stars of the image that was scanned.
    #[inline(never)]
    fn begin_identification(&mut self) {
        self.workspace.take_measured(&self.camera, None, 0.0);
        self.workspace.shared.begin_identification();
        self.searching_since = Some(self.now);
    }

    /// Goes on with the identification, in the second of the scan for a [`SCANNING_SHARE`]th of the
    /// allowance: the scan has most of that second. `None` where there is none that could go on.
    fn identify(&mut self, scanned: bool) -> Option<Progress> {
        let identification = &self.parameters.identification;
        let share = if scanned { SCANNING_SHARE } else { 1 };
        let field = StarField::whole(&self.workspace.measured, &self.catalogue, &self.camera)
            .calibrated(self.calibration.as_ref());
        let identifier = self.workspace.shared.identifier()?;
        Some(identifier.advance(&field, identification, identification.pairs_per_cycle / share))
    }

    /// What the identification came to in this second.
    #[inline(never)]
    fn conclude(&mut self, progress: Option<&Progress>, stars: &mut StarRecord) -> Option<Outcome> {
        let since = self.searching_since.take().unwrap_or(self.now);
        match progress? {
            Progress::Searching => {
                let patience_us = (FIRST_PATIENCE_US << self.images_given_up) - SECOND_US;
                // To the nearest second: calls are never exactly a second apart.
                if self.now.us_since(since) + SECOND_US / 2 >= patience_us {
                    self.images_given_up = (self.images_given_up + 1).min(MOST_DOUBLINGS);
                } else {
                    self.searching_since = Some(since);
                }
                Some(Outcome::Searching)
            }
            Progress::NotIdentified(reason) => Some(Outcome::NotIdentified(*reason)),
            Progress::Identified(confirmed, log10_false) => {
                self.images_given_up = 0;
                self.measurement_update(confirmed, *log10_false, since, stars);
                Some(Outcome::Identified)
            }
        }
    }
}
