//! Self-test, and lost in space: an image scanned for stars, which are identified by the attitude known last,
//! or without prior knowledge.

use super::record::StarRecord;
use super::timekeeping::SECOND_US;
use super::tracking::{EXPECTED_LOG10_FALSE, PART_PX, TurnChange};
use super::turning::DRAWN_SHARE;
use super::{Sensor, Workspace};
use crate::attitude::filter::seconds;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::image::DetectionMethod;
use crate::image::scan::{self, Smear};
use crate::image::turn::Turn;
use crate::plan;
use crate::stars::confirm::Confirmed;
use crate::stars::focal_ratio::FocalRatio;
use crate::stars::identify::{NotIdentified, Progress};
use crate::stars::reidentify::reidentify;
use crate::stars::{Match, StarField};
use crate::telemetry::{DetectorFault, Outcome};
use fsw_hal::{Detector, DetectorError, LocalTime, Stage, StageMeter};

/// In the second of the scan identification has this part of its allowance.
const SCANNING_SHARE: u32 = 12;
/// For so long the first image is searched, and how often they may double: after a burst of noise the last
/// noisy image is searched for 16 s at most.
const FIRST_PATIENCE_US: i64 = 2 * SECOND_US;
const MOST_DOUBLINGS: u8 = 3;
/// A focal length off by less, share, moves the stars in the corner by a tenth of a pixel at most.
const UNSEEN_STRETCH: f32 = 1e-4;
/// Error of a star's centre that the sensor's turning has moved by up to 4 px as nobody knows, px.
const MOVED_PX: f32 = 0.2;
/// Fewer spots of a whole image that are drawn out do not say that the sensor turns.
const FEWEST_STREAKS: u32 = 6;

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

    /// Lost in space: scan, then identify, near to the attitude known last if there is one. A search that
    /// needs longer goes on with the same image, for [`FIRST_PATIENCE_US`] at first: hits and false stars of
    /// the next image are others. Each image given up doubles the time of the next, up to [`MOST_DOUBLINGS`]
    /// times, so that a search that truly needs long comes to its end; none does while
    /// [`Self::track_again`] may find the stars of the next image. `None` where the search begins anew in the
    /// next second.
    #[inline(never)]
    pub(super) fn acquire(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        stars: &mut StarRecord,
    ) -> Result<Option<Outcome>, DetectorError> {
        let scans = self.searching_since.is_none();
        let turn = if scans { self.turn_in_exposure() } else { None };
        if scans {
            meter.begin(Stage::Scan);
            let scanned = self.scan(detector, turn);
            meter.end(Stage::Scan);
            scanned?;
        }
        let detections = &mut self.workspace.detections;
        stars.count(detections.spots().len(), detections);
        if scans {
            // It is exposed shorter where it turns.
            let moved = self.turning.divisor() > 1 && turn.is_none();
            let smear = detections.smear(FEWEST_STREAKS);
            self.turn_change = match TurnChange::of(smear) {
                TurnChange::Changing if self.turning.showed_lines() => TurnChange::Onset,
                // A turn that nobody saw lost the attitude, and may end within this image.
                _ if self.motion.is_lost_in_turn() && turn.is_none() => TurnChange::Onset,
                change => change,
            };
            match smear {
                Smear::Points | Smear::Blurred | Smear::MostlyBlurred if moved => detections.doubt(MOVED_PX),
                Smear::Points | Smear::Blurred | Smear::MostlyBlurred => {}
                Smear::Drawn => detections.keep_drawn(),
                Smear::Streaks => return Ok(Some(Outcome::TooFast)),
            }
        }
        meter.begin(Stage::Identify);
        let outcome = self.identify(scans, stars);
        meter.end(Stage::Identify);
        Ok(outcome)
    }

    /// Searches the whole image for stars, drawn out by a `turn` where it is known.
    #[inline(never)]
    fn scan(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        turn: Option<Turn>,
    ) -> Result<(), DetectorError> {
        let method = DetectionMethod {
            parameters: &self.parameters.detection,
            calibration: self.calibration.as_ref(),
            turn,
        };
        self.sought = self.now;
        let Workspace { shared, detections, repeated, .. } = &mut *self.workspace;
        scan::scan(detector, &mut shared.readout().buffer, method, detections)?;
        repeated.put_first(detections);
        Ok(())
    }

    /// Identifies the stars of an image that was `scanned` near to the attitude known last, else begins to
    /// search for them without one. In later seconds the search goes on.
    fn identify(&mut self, scanned: bool, stars: &mut StarRecord) -> Option<Outcome> {
        if scanned {
            self.workspace.take_measured(&self.camera, None, 0.0);
            if self.reidentify(stars) {
                return Some(Outcome::Identified);
            }
            if stars.image_fault.is_some() {
                return Some(Outcome::NotIdentified(NotIdentified::NoMatch));
            }
            self.searching_since = Some(self.now);
            self.workspace.shared.begin_identification();
        }
        self.search_stars(scanned, stars)
    }

    /// Whether the stars are found near to the attitude known last; takes the new one.
    #[inline(never)]
    pub(super) fn reidentify(&mut self, stars: &mut StarRecord) -> bool {
        let mut hypotheses = self.hypotheses().into_iter().chain([self.likeliest_now()]).flatten();
        let found = hypotheses.find_map(|former| self.find_near(&former, self.camera.area_px()));
        found.is_some_and(|(confirmed, log10_false)| {
            self.take_identified(&confirmed, log10_false, self.now, stars)
        })
    }

    /// The likeliest attitude of the last search that found none, carried to this second by the rate that
    /// was told last.
    #[inline(never)]
    fn likeliest_now(&self) -> Option<Rotation<Icrs, StarPath>> {
        let (attitude, image) = self.likeliest?;
        let Some(rate) = self.turning.rate_at(self.now) else { return Some(attitude) };
        Some(attitude.turned(&(rate.rad_s * seconds(self.now.us_since(image)))))
    }

    /// The stars found in so many pixels identified near to an attitude. Where the filter expects the new one,
    /// weaker evidence is enough.
    pub(super) fn find_near(
        &self,
        former: &Rotation<Icrs, StarPath>,
        searched_px: f32,
    ) -> Option<(Confirmed, f32)> {
        let limit = self.parameters.identification.log10_false_limit;
        self.identify_near(former, searched_px, limit.max(EXPECTED_LOG10_FALSE))
            .filter(|(confirmed, log10_false)| *log10_false <= limit || self.is_expected(confirmed))
    }

    /// The stars found in so many pixels identified near to an attitude.
    #[inline(never)]
    fn identify_near(
        &self,
        former: &Rotation<Icrs, StarPath>,
        searched_px: f32,
        log10_false_limit: f32,
    ) -> Option<(Confirmed, f32)> {
        let measured = &self.workspace.measured;
        let field = StarField::windows(measured, &self.catalogue, &self.camera, searched_px)
            .without(self.workspace.detections.unread_px())
            .calibrated(self.calibration.as_ref());
        reidentify(former, &field, &self.parameters.identification, log10_false_limit)
    }

    /// Goes on with the search without an attitude, in the second of the scan for a [`SCANNING_SHARE`]th of
    /// the allowance: the scan has most of that second. `None` where there is none that could go on.
    #[inline(never)]
    fn search_stars(&mut self, scanned: bool, stars: &mut StarRecord) -> Option<Outcome> {
        let identification = &self.parameters.identification;
        let share = if scanned { SCANNING_SHARE } else { 1 };
        let field = StarField::whole(&self.workspace.measured, &self.catalogue, &self.camera)
            .without(self.workspace.detections.unread_px())
            .calibrated(self.calibration.as_ref());
        let identifier = self.workspace.shared.identifier();
        let progress = identifier.map(|identifier| {
            identifier.advance(&field, identification, identification.pairs_per_cycle / share)
        });
        self.conclude(progress.as_ref(), stars)
    }

    /// What the identification came to in this second.
    #[inline(never)]
    fn conclude(&mut self, progress: Option<&Progress>, stars: &mut StarRecord) -> Option<Outcome> {
        let since = self.searching_since.take().unwrap_or(self.now);
        match progress? {
            Progress::Searching => {
                // The few stars of lines are found in a second or not at all.
                let of_lines = self.turning.is_of_lines();
                let again = self.gate_again_px().is_some();
                let doublings = if of_lines || again { 0 } else { self.images_given_up };
                let patience_us = (FIRST_PATIENCE_US << doublings) - SECOND_US;
                // To the nearest second: calls are never exactly a second apart.
                if self.now.us_since(since) + SECOND_US / 2 < patience_us {
                    self.searching_since = Some(since);
                    return Some(Outcome::Searching);
                }
                if !of_lines {
                    self.images_given_up = (doublings + 1).min(MOST_DOUBLINGS);
                }
                self.keep_likeliest(since);
                Some(Outcome::Searching)
            }
            Progress::NotIdentified(reason) => {
                self.keep_likeliest(since);
                Some(Outcome::NotIdentified(*reason))
            }
            Progress::Identified(confirmed, log10_false) => {
                let taken = self.take_identified(confirmed, *log10_false, since, stars);
                Some(if taken { Outcome::Identified } else { Outcome::NotIdentified(NotIdentified::NoMatch) })
            }
        }
    }

    /// Keeps the likeliest attitude of a search that found none in the image of the instant.
    #[inline(never)]
    fn keep_likeliest(&mut self, image: LocalTime) {
        let likeliest = self.workspace.shared.identifier().and_then(|search| search.likeliest().copied());
        self.likeliest = likeliest.map(|attitude| (attitude, image));
    }

    /// Takes the attitude of identified stars of the instant `image`. Where some of them are parts of what the
    /// sensor's turning has drawn out, these are believed less. Where another focal length suits them, by that
    /// one: stars that do not stand evenly about the middle turn the attitude of a wrong one. Whether it could
    /// be taken.
    #[inline(never)]
    fn take_identified(
        &mut self,
        confirmed: &Confirmed,
        log10_false: f32,
        image: LocalTime,
        stars: &mut StarRecord,
    ) -> bool {
        self.images_given_up = 0;
        let has_parts = self.has_parts(confirmed);
        let FocalRatio { ratio, sigma } = confirmed.focal_ratio;
        let stretched = !has_parts && (ratio - 1.0).abs() > (3.0 * sigma).max(UNSEEN_STRETCH);
        if has_parts {
            self.workspace.detections.doubt_round(PART_PX);
        } else if stretched {
            self.refine_focal_length(&confirmed.focal_ratio, image);
        } else {
            return self.measurement_update(confirmed, log10_false, image, stars);
        }
        self.workspace.take_measured(&self.camera, None, 0.0);
        let limit = self.parameters.identification.log10_false_limit;
        let Some((mut again, log10_false)) =
            self.identify_near(&confirmed.attitude, self.camera.area_px(), limit)
        else {
            return false;
        };
        if stretched {
            // What the image shows of it is taken already.
            again.focal_ratio.sigma = f32::INFINITY;
        }
        self.measurement_update(&again, log10_false, image, stars)
    }

    /// Whether one in [`DRAWN_SHARE`] of the identified stars or more, but not all, are drawn out by a turn of
    /// which nothing is known: those that look round are parts, be there ever so many round hits and false
    /// stars in the image.
    fn has_parts(&self, confirmed: &Confirmed) -> bool {
        let spots = self.workspace.detections.spots();
        let is_drawn = |found: &&Match| {
            let centre_px =
                self.workspace.measured.get(usize::from(found.measured)).map(|star| star.centre_px);
            spots.iter().any(|spot| spot.drawn_px > 0 && Some(spot.centre_px()) == centre_px)
        };
        let (all, drawn) = (confirmed.matches.len(), confirmed.matches.iter().filter(is_drawn).count());
        drawn < all && all <= DRAWN_SHARE * drawn && self.turn_in_exposure().is_none()
    }
}
