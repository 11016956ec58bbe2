//! How fast the sensor turns while no attitude is known: what is asked of the image, and what of the room [`crate::rate`].
//!
//! In: the streaks of an image, or its measured stars where they were not identified. Out: the rate in the report, and what must be
//! remembered for the next image: whether it is searched for lines, and how long it is exposed.
//!
//! Lines that stand where lines stood in the last image are the Earth's limb, its clouds and spacecraft parts: a star moves by
//! twice its streak and more.

mod seen;

use super::Sensor;
use crate::attitude::filter::seconds;
use crate::image::streaks::Streak;
use crate::rate::arcs::{Arc, MAX_ARCS, widened};
use crate::rate::marks::{CHANGE, Field, MAX_MARKS, Mark, matched};
use crate::rate::sense::{Estimate, Memory};
use crate::stars::identify::NotIdentified;
use crate::stars::{Measured, row_delay_s};
use crate::telemetry::{RateReport, RateSource, Report, Status};
use fsw_hal::{Detector, DetectorError, LocalTime, Stage, StageMeter};
use heapless::Vec;
use seen::{MAX_STREAKS, SAME_PX, arc_of, mark_of};

/// Streaks at least so long are sought as lines in the next image, shorter ones by the scan, px.
const LONG_PX: f32 = 30.0;
/// Fewest stars of which a scan says that the sensor does not turn fast, if fewer than one in `DRAWN_SHARE` is drawn out: of
/// stars at rest, pairs and hits are.
const FEWEST_STARS: usize = 4;
const DRAWN_SHARE: usize = 4;
/// Fewer streaks so long are satellites and hits.
const FEWEST_LINES: usize = 2;
/// Searches for lines in a row that may tell no rate before stars are looked for again: an Earth at rest has lines too.
const MOST_MISSES: u8 = 3;
/// A good length of streaks, px; the exposure is shortened by a whole number, at most so much, and so much where no
/// streak was seen.
const GOOD_PX: f32 = 100.0;
const LARGEST_DIVISOR: u8 = 4;
const UNSEEN_DIVISOR: u8 = 3;
/// Shortest and longest time between two images that are compared, s.
const BETWEEN_S: (f32, f32) = (0.1, 4.5);
/// Largest standard deviation of a rate that is reported, as a share of it.
const LARGEST_SHARE: f32 = 0.4;
/// What is remembered from image to image.
#[derive(Debug, Default)]
pub(super) struct Turning {
    memory: Memory,
    /// Middles of the image's streaks, px.
    middles_px: Vec<[f32; 2], MAX_STREAKS>,
    /// Instant of the image.
    taken: LocalTime,
    /// What to do with the next one.
    next: Next,
}

/// What to do with the next image.
#[derive(Clone, Copy, Debug, Default)]
struct Next {
    /// It is searched for lines instead of stars.
    seeks: bool,
    /// Searches for lines in a row that told no rate.
    misses: u8,
    /// The exposure is divided by this: long streaks leave the field, and their pixels gather dark current.
    divisor: u8,
}

impl Next {
    /// After a search that found these streaks, exposed for the nominal time over the divisor, and told a rate or none.
    fn after_lines(self, streaks: &[Streak], told: bool) -> Self {
        let long = streaks.iter().filter(|streak| streak.length_px() >= LONG_PX).count();
        let misses = if told { 0 } else { self.misses.saturating_add(1) };
        let divisor = self.divisor.max(1);
        if long < FEWEST_LINES {
            // Perhaps a shorter exposure shows more, and a longer one the next time.
            let divisor = if divisor > 1 { 1 } else { UNSEEN_DIVISOR };
            return Self { seeks: misses < MOST_MISSES && long >= streaks.len() / 2, misses, divisor };
        }
        let mean_px = streaks.iter().fold(0.0, |sum, streak| sum + streak.length_px()) / streaks.len() as f32;
        let wanted = mean_px * f32::from(divisor) / GOOD_PX;
        Self { seeks: misses < MOST_MISSES, misses, divisor: (wanted as u8).clamp(1, LARGEST_DIVISOR) }
    }
}

impl Turning {
    /// Forgets all, as when an attitude is known.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Leaves the streaks that do not stand where one stood in the last image, and keeps the middles of all for the next.
    fn leave_moving(&mut self, streaks: &mut Vec<Streak, MAX_STREAKS>) {
        let middles_px = streaks.iter().map(Streak::middle_px).take(MAX_STREAKS).collect();
        let before = core::mem::replace(&mut self.middles_px, middles_px);
        streaks.retain(|streak| !before.iter().any(|middle_px| streak.holds(*middle_px, SAME_PX)));
    }

    /// Whether the next image is searched for lines.
    pub(super) fn seeks_streaks(&self) -> bool {
        self.next.seeks
    }

    /// Seconds since the marks were taken, where they can be compared with an image of the instant `now`.
    fn elapsed_s(&self, now: LocalTime) -> Option<f32> {
        let elapsed_s = seconds(now.us_since(self.taken));
        (!self.memory.marks.is_empty() && (BETWEEN_S.0..=BETWEEN_S.1).contains(&elapsed_s))
            .then_some(elapsed_s)
    }
}

impl Sensor<'_> {
    /// Lost in space: an attitude, or how it turns where there is none. (The steps are called from here, not from each other,
    /// so that their lists do not lie on the stack together.)
    pub(super) fn acquire_or_turn(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        report: &mut Report,
    ) {
        let new_image = self.searching_since.is_none();
        if new_image && self.turning.next.seeks {
            return self.seek_streaks(detector, meter, report);
        }
        self.acquire(detector, meter, report);
        match report.status {
            Status::Identified => self.turning.forget(),
            Status::TooFast => {
                if let Err(error) = self.turn_by_scan(detector, report) {
                    report.status = Status::DetectorFault(error.into());
                }
            }
            Status::Searching | Status::NotIdentified(_) if new_image => self.turn_by_stars(report),
            _ => {}
        }
    }

    /// A second in which the image is searched for lines instead of stars.
    #[inline(never)]
    fn seek_streaks(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        report: &mut Report,
    ) {
        meter.begin(Stage::Scan);
        let found = self.lines(detector);
        meter.end(Stage::Scan);
        let mut streaks = match found {
            Ok(streaks) => streaks,
            Err(error) => return report.status = Status::DetectorFault(error.into()),
        };
        self.turning.leave_moving(&mut streaks);
        report.detections = streaks.len() as u16;
        report.status = if streaks.len() >= FEWEST_LINES {
            Status::TooFast
        } else {
            Status::NotIdentified(NotIdentified::TooFewStars)
        };
        let exposure_us = self.line_exposure_us();
        self.turn_by(&streaks, exposure_us, report);
        self.turning.next = self.turning.next.after_lines(&streaks, report.rate.is_some());
    }

    /// After a scan that showed streaks: measures those it has touched.
    ///
    /// # Errors
    /// Of the detector.
    #[inline(never)]
    fn turn_by_scan(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        report: &mut Report,
    ) -> Result<(), DetectorError> {
        let mut streaks = self.streaks_of_scan(detector)?;
        self.turning.leave_moving(&mut streaks);
        let long = streaks.iter().filter(|streak| streak.length_px() >= LONG_PX).count();
        self.turn_by(&streaks, self.parameters.imaging.exposure_us, report);
        let seeks = report.rate.is_none() || 2 * long >= streaks.len();
        self.turning.next = Next { seeks, ..Next::default() };
        Ok(())
    }

    /// What the room of the rate needs to know of the camera.
    fn rate_field(&self) -> Field {
        Field { rad_per_px: self.camera.rad_per_px(), area_px: self.camera.area_px() }
    }

    /// The rate from the streaks of this second's image and what is remembered of the last.
    #[inline(never)]
    fn turn_by(&mut self, streaks: &[Streak], exposure_us: u32, report: &mut Report) {
        let row_time_s = self.row_time_s();
        let exposure_s = exposure_us as f32 * 1e-6;
        let longest_px = streaks.iter().fold(0.0f32, |longest, streak| longest.max(streak.length_px()));
        let mut arcs: Vec<Arc, MAX_ARCS> = Vec::new();
        let mut marks: Vec<Mark, MAX_MARKS> = Vec::new();
        for streak in streaks {
            if let Some(arc) = arc_of(&self.camera, streak, exposure_s, row_time_s, longest_px) {
                let _ = arcs.push(arc);
            }
            if !streak.cut
                && let Some(mark) = mark_of(&self.camera, streak, row_time_s)
            {
                let _ = marks.push(mark);
            }
        }
        let (elapsed_s, field) = (self.turning.elapsed_s(self.now), self.rate_field());
        self.turning.taken = self.now;
        if let Some(found) = self.turning.memory.take_streaks(&arcs, marks, elapsed_s, field) {
            let source = if found.from_both { RateSource::Both } else { RateSource::Streaks };
            report_rate(report, found.estimate, (source, found.either_sense, found.whole));
        }
    }

    /// After a scan whose stars were not identified: the rate from the stars of the last image, and what to look for next.
    #[inline(never)]
    fn turn_by_stars(&mut self, report: &mut Report) {
        let detections = &self.workspace.detections;
        let stars = self.workspace.measured.len();
        let drawn = detections.spots().iter().filter(|spot| spot.drawn_px > 0 && !spot.extended).count();
        let seeks = stars < FEWEST_STARS || DRAWN_SHARE * (drawn + detections.streaks() as usize) >= stars;
        let row_time_s = self.row_time_s();
        let mark = |star: &Measured| Mark {
            direction: *star.direction.vector(),
            sigma_rad: [star.sigma_px * self.camera.rad_per_px(); 2],
            late_s: row_delay_s(&self.camera, star.centre_px, row_time_s),
        };
        let marks: Vec<Mark, MAX_MARKS> = self.workspace.measured.iter().take(MAX_MARKS).map(mark).collect();
        let elapsed_s = self.turning.elapsed_s(self.now);
        let rate = elapsed_s.and_then(|elapsed_s| matched(&self.turning.memory.marks, &marks, elapsed_s));
        let next = Next { seeks, ..Next::default() };
        self.turning =
            Turning { memory: Memory::of_marks(marks), taken: self.now, next, ..Turning::default() };
        if let Some(rate) = rate {
            let off = 0.5 * CHANGE * rate.rad_s.norm_squared() * elapsed_s.unwrap_or(1.0);
            report_rate(
                report,
                (rate.rad_s, widened(rate.covariance, off)),
                (RateSource::Images, false, rate.count()),
            );
        }
    }
}

/// Puts a rate into the report, unless it says too little.
#[inline(never)]
fn report_rate(
    report: &mut Report,
    (rate, covariance): Estimate,
    (source, either_sense, stars): (RateSource, bool, u32),
) {
    let sigma = covariance.diagonal().map(|variance| libm::sqrtf(variance.max(0.0)));
    let size = rate.norm();
    // A rate of which one component is open (a single streak, or streaks that all lie together) is none. A slow one may be
    // known to a part of a pixel a second only.
    if sigma.norm() < LARGEST_SHARE * size || source == RateSource::Images && size.is_finite() {
        let stars = stars.min(u8::MAX.into()) as u8;
        report.rate =
            Some(RateReport { rad_s: rate.into(), sigma_rad_s: sigma.into(), source, either_sense, stars });
    }
}
