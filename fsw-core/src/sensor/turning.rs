//! How fast the sensor turns while no attitude is known: what is asked of the image, and what of the room
//! [`crate::rate`].
//!
//! In: the streaks of an image, or its measured stars where they were not identified. Out: the rate, and what
//! must be remembered for the next image: whether it is searched for lines, and how long it is exposed. Where
//! stars are lines in the shortest exposure too, the middles of whole ones are stars to be identified
//! (`streaks`).
//!
//! Lines that stand where lines stood in the last image are the Earth's limb, its clouds and spacecraft
//! parts: a star moves by twice its streak and more.

mod streaks;

use super::Sensor;
use super::propagation::Ephemeris;
use super::record::StarRecord;
use super::tracking::TurnChange;
use crate::attitude::filter::{Filter, Rate, free_body_change, seconds};
use crate::image::streaks::Streak;
use crate::order::fill;
use crate::rate::arcs::{Arc, MAX_ARCS};
use crate::rate::marks::{DetectorScale, MAX_MARKS, Mark};
use crate::rate::sense::{Estimate, RateHistory};
use crate::rate::streaks::arc_of;
use crate::stars::identify::NotIdentified;
use crate::stars::{MeasuredStar, row_delay_s};
use crate::telemetry::{Activity, Outcome, RateReport, RateSource};
use crate::trigonometry::hypotenuse;
use fsw_hal::{Detector, DetectorError, LocalTime, Stage, StageMeter};
use heapless::Vec;
use nalgebra::Vector3;
use streaks::{MAX_STREAKS, SAME_PX};

/// An image of whose spots more than one in so many stand on clouds or a limb shows the Earth.
const CLOUDS_SHARE: usize = 3;
/// Streaks at least so long are sought as lines in the next image, shorter ones by the scan, px.
const LONG_PX: f32 = 30.0;
/// Fewest stars of which a scan says that the sensor does not turn fast, if fewer than one in `DRAWN_SHARE`
/// is drawn out: of stars at rest, pairs and hits are.
const FEWEST_STARS: usize = 4;
pub(super) const DRAWN_SHARE: usize = 4;
/// Fewer streaks so long are satellites and hits.
const FEWEST_LINES: usize = 2;
/// Searches for lines that may give no rate before stars are looked for after each: an Earth at rest has
/// lines too.
const MOST_MISSES: u8 = 3;
/// A good length of streaks, px; the exposure is shortened by a whole number, at most so much, and so much
/// where no streak was seen.
const GOOD_PX: f32 = 100.0;
const LARGEST_DIVISOR: u8 = 4;
const UNSEEN_DIVISOR: u8 = 3;
/// Length of the streaks in an image that is scanned for stars once their rate is known, px: they look like
/// stars, and have lost no more light than their length had spread. The exposure is shortened for it by a
/// whole number, at most so much: with less light a field has too few stars. What then is longer than the
/// greatest length is not scanned: the rate is told from lines in every image instead.
const SCANNED_PX: f32 = 3.0;
pub(super) const GREATEST_SCANNED_PX: f32 = 6.0;
const LARGEST_SCAN_DIVISOR: f32 = 8.0;
/// Shortest and longest time between two images that are compared, s.
const BETWEEN_S: (f32, f32) = (0.1, 4.5);
/// Largest standard deviation of a rate that is reported, as a share of it.
const LARGEST_SHARE: f32 = 0.4;
/// Marks that move less from image to image may be fixed to the detector, as bad pixels and the Sun's glare
/// are: no rate of theirs is told. Spots in the glare seem to move by up to 2.2 px.
const LEAST_MOTION_PX: f32 = 3.0;

/// What is remembered from image to image.
#[derive(Debug, Default)]
pub(super) struct Turning {
    history: RateHistory,
    /// Middles of the image's streaks, px.
    middles_px: Vec<[f32; 2], MAX_STREAKS>,
    /// Instant of the image.
    taken: LocalTime,
    /// The rate that was told last, its sense being known, and the instant of its image.
    told: Option<(RateReport, LocalTime)>,
    /// What to do with the next one.
    next: Next,
    /// The stars that are identified, or were last, are the middles of lines.
    of_lines: bool,
    /// Images with lines whose stars are not searched for without a hypothesis.
    unsearched: u8,
}

/// What to do with the next image.
#[derive(Clone, Copy, Debug, Default)]
struct Next {
    /// It is searched for lines instead of stars.
    seeks: bool,
    /// Searches for lines since the last rate or attitude that gave no rate.
    misses: u8,
    /// The exposure of one that is searched for lines is divided by this: long streaks leave the field, and
    /// their pixels gather dark current.
    divisor: u8,
    /// The same of one that is scanned for stars.
    scan_divisor: u8,
}

impl Next {
    /// After a scan of so many stars that were not identified. While it shows enough of them searches that
    /// gave no rate stay counted: of an Earth that fills the field, whose clouds are lines, every other image
    /// is scanned, not one in four.
    fn after_scan(self, seeks: bool, stars: usize) -> Self {
        if stars < FEWEST_STARS {
            Self { seeks, ..Self::default() }
        } else {
            Self { seeks, scan_divisor: 1, ..self }
        }
    }

    /// After a search that found these streaks, exposed for the nominal time over the divisor, and gave a
    /// rate or none.
    fn after_lines(self, streaks: &[Streak], has_rate: bool) -> Self {
        let long = streaks.iter().filter(|streak| streak.length_px() >= LONG_PX).count();
        let misses = if has_rate { 0 } else { self.misses.saturating_add(1) };
        let divisor = self.divisor.max(1);
        if long < FEWEST_LINES {
            // Perhaps a shorter exposure shows more, and a longer one the next time.
            let divisor = if divisor > 1 { 1 } else { UNSEEN_DIVISOR };
            let seeks = misses < MOST_MISSES && long >= streaks.len() / 2;
            return Self { seeks, misses, divisor, scan_divisor: 1 };
        }
        let wanted = mean_px(streaks) * f32::from(divisor) / GOOD_PX;
        let divisor = (wanted as u8).clamp(1, LARGEST_DIVISOR);
        Self { seeks: misses < MOST_MISSES, misses, divisor, scan_divisor: 1 }
    }
}

/// The divisor of an exposure in which stars are drawn out by so much, px.
pub(super) fn short_divisor(drawn_px: f32) -> u8 {
    libm::ceilf(drawn_px / SCANNED_PX).clamp(1.0, LARGEST_SCAN_DIVISOR) as u8
}

/// Mean length of streaks, px; 0 of none.
fn mean_px(streaks: &[Streak]) -> f32 {
    streaks.iter().fold(0.0, |sum, streak| sum + streak.length_px()) / streaks.len().max(1) as f32
}

impl Turning {
    /// Forgets all, as when an attitude is known.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The same, but the next image is exposed as this one was: with its attitude the filter knows the rate.
    fn keep_exposure(&mut self) {
        let next = Next { scan_divisor: self.next.scan_divisor, ..Next::default() };
        *self = Self { next, ..Self::default() };
    }

    /// Leaves the streaks that do not stand where one stood in the last image, and keeps the middles of all
    /// for the next.
    fn leave_moving(&mut self, streaks: &mut Vec<Streak, MAX_STREAKS>) {
        let before = core::mem::take(&mut self.middles_px);
        fill(&mut self.middles_px, streaks.iter().map(Streak::middle_px));
        streaks.retain(|streak| !before.iter().any(|middle_px| streak.holds(*middle_px, SAME_PX)));
    }

    /// The rate at an instant, by the one told last and what it may have changed since: in a second by so much
    /// about every axis, one sigma, rad/s. `None` where that was too long ago.
    fn told_at(&self, instant: LocalTime, change: &Vector3<f32>) -> Option<RateReport> {
        let (report, told_at) = self.told?;
        let elapsed_s = libm::fabsf(seconds(instant.us_since(told_at)));
        let sigma_rad_s = Vector3::from(report.sigma_rad_s).zip_map(&(change * elapsed_s), hypotenuse);
        (elapsed_s <= BETWEEN_S.1).then_some(RateReport { sigma_rad_s: sigma_rad_s.into(), ..report })
    }

    /// The same of a free body.
    pub(super) fn rate_at(&self, instant: LocalTime) -> Option<Rate> {
        let change = free_body_change(&self.told?.0.rad_s.into());
        self.told_at(instant, &Vector3::repeat(change)).as_ref().map(rate_of)
    }

    /// The rate that the last image's streaks told, at an instant at which its search goes on.
    fn rate_under_search(&self, instant: LocalTime) -> Option<RateReport> {
        self.told.filter(|(_, told_at)| *told_at == self.taken)?;
        self.told_at(instant, self.history.possible_change()?).filter(says_enough)
    }

    /// Whether the stars that are identified are the middles of lines.
    pub(super) fn is_of_lines(&self) -> bool {
        self.of_lines
    }

    /// How far the middles of lines are from the mean of the turn within an exposure of so many seconds
    /// where it changes meanwhile, as it possibly does: one sigma about every axis, rad. At a constant change
    /// `a` the ends are `a T² / 8` beside the place of mid-exposure, the mean `a T² / 24`.
    pub(super) fn middle_sigma_rad(&self, exposure_s: f32) -> Vector3<f32> {
        let change = self.history.possible_change().copied().unwrap_or_default();
        change * (exposure_s * exposure_s / 12.0)
    }

    /// Whether the last image showed lines.
    pub(super) fn showed_lines(&self) -> bool {
        !self.middles_px.is_empty()
    }

    /// Whether the next image is searched for lines.
    pub(super) fn seeks_streaks(&self) -> bool {
        self.next.seeks
    }

    /// By what the exposure of this second's image is divided.
    pub(super) fn divisor(&self) -> u8 {
        if self.next.seeks { self.next.divisor } else { self.next.scan_divisor }
    }

    /// Seconds since the marks were taken, where they can be compared with an image of the instant `now`.
    fn elapsed_s(&self, now: LocalTime) -> Option<f32> {
        let elapsed_s = seconds(now.us_since(self.taken));
        (!self.history.marks.is_empty() && (BETWEEN_S.0..=BETWEEN_S.1).contains(&elapsed_s))
            .then_some(elapsed_s)
    }
}

impl Sensor<'_> {
    /// Lost in space: an attitude, or how it turns where there is none. (The steps are called from here, not
    /// from each other, so that their lists do not lie on the stack together.)
    pub(super) fn acquire_or_turn(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: Option<&Ephemeris>,
        stars: &mut StarRecord,
    ) -> Result<(), DetectorError> {
        let new_image = self.searching_since.is_none();
        if new_image && self.turning.seeks_streaks() {
            self.seek_streaks(detector, meter, stars)?;
            meter.begin(Stage::Identify);
            self.identify_lines(stars);
            meter.end(Stage::Identify);
            return Ok(());
        }
        if new_image && self.track_again(detector, meter, ephemeris, stars)? {
            self.turning.keep_exposure();
            return Ok(());
        }
        stars.activity = Activity::StarSearch;
        self.turning.of_lines &= !new_image;
        let outcome = self.acquire(detector, meter, stars)?;
        stars.outcome = outcome;
        match outcome {
            // While stars are lines the next image is searched for lines.
            Some(Outcome::Identified) if self.turning.of_lines => {}
            Some(Outcome::Identified) => self.turning.keep_exposure(),
            Some(Outcome::TooFast) => stars.rate = self.measure_scanned_streaks(detector)?,
            Some(Outcome::Searching | Outcome::NotIdentified(_))
                if new_image && stars.image_fault.is_none() =>
            {
                stars.rate = self.turn_by_stars();
            }
            _ => {}
        }
        self.take_rate(stars.rate.as_ref());
        if !new_image && outcome != Some(Outcome::Identified) {
            stars.rate = self.turning.rate_under_search(self.now);
        }
        Ok(())
    }

    /// A second in which the image is searched for lines instead of stars.
    #[inline(never)]
    fn seek_streaks(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        stars: &mut StarRecord,
    ) -> Result<(), DetectorError> {
        stars.activity = Activity::StreakSearch;
        self.turn_change = TurnChange::Steady;
        meter.begin(Stage::Streaks);
        let found = self.lines(detector);
        meter.end(Stage::Streaks);
        let mut streaks = found?;
        self.turn_by_lines(&mut streaks, stars);
        self.take_rate(stars.rate.as_ref());
        self.take_middles(&streaks, stars.rate.as_ref());
        Ok(())
    }

    /// After a scan that showed streaks: measures those it has touched.
    #[inline(never)]
    fn measure_scanned_streaks(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
    ) -> Result<Option<RateReport>, DetectorError> {
        let mut streaks = self.streaks_of_scan(detector)?;
        Ok(self.turn_by_scan(&mut streaks))
    }

    /// After a second in which the image was searched for lines instead of stars.
    #[inline(never)]
    fn turn_by_lines(&mut self, streaks: &mut Vec<Streak, MAX_STREAKS>, stars: &mut StarRecord) {
        self.turning.leave_moving(streaks);
        stars.detections = streaks.len() as u16;
        stars.outcome = Some(if streaks.len() >= FEWEST_LINES {
            Outcome::TooFast
        } else {
            Outcome::NotIdentified(NotIdentified::TooFewStars)
        });
        let rate = self.turn_by(streaks);
        let next = self.turning.next.after_lines(streaks, rate.is_some());
        self.turning.next = self.scanned_short(next, streaks, rate.is_some());
        stars.rate = rate;
    }

    /// Whether more than one in [`CLOUDS_SHARE`] of the scan's spots stand on or beside an extended object.
    fn shows_clouds(&self) -> bool {
        let spots = self.workspace.detections.spots();
        CLOUDS_SHARE * spots.iter().filter(|spot| spot.extended).count() > spots.len()
    }

    /// After a scan that showed streaks, of those it has touched. Shreds of cloud are drawn out alike by the
    /// slant of the view: six of seven gave a rate 10.9 sigma off. Above an Earth the next image must show
    /// them moved.
    #[inline(never)]
    fn turn_by_scan(&mut self, streaks: &mut Vec<Streak, MAX_STREAKS>) -> Option<RateReport> {
        self.turning.leave_moving(streaks);
        let long = streaks.iter().filter(|streak| streak.length_px() >= LONG_PX).count();
        let rate = self.turn_by(streaks);
        let rate = rate.filter(|rate| !(rate.either_sense && self.shows_clouds()));
        let seeks = rate.is_none() || 2 * long >= streaks.len();
        self.turning.next = self.scanned_short(Next { seeks, ..Next::default() }, streaks, rate.is_some());
        rate
    }

    /// The same, but where streaks gave a rate the next image is scanned with an exposure in which they are
    /// short, if there is one.
    fn scanned_short(&self, next: Next, streaks: &[Streak], has_rate: bool) -> Next {
        let exposures = self.parameters.imaging.exposure_us as f32 / self.exposure_us.max(1) as f32;
        let drawn_px = mean_px(streaks) * exposures;
        let scan_divisor = short_divisor(drawn_px);
        if !has_rate || drawn_px > GREATEST_SCANNED_PX * f32::from(scan_divisor) {
            return next;
        }
        Next { seeks: false, scan_divisor, ..next }
    }

    /// Takes the rate that this second's image gave, its sense being known: the filter's, or that of a filter
    /// which begins with the next attitude.
    fn take_rate(&mut self, report: Option<&RateReport>) {
        let Some(report) = report.filter(|report| !report.either_sense) else { return };
        let rate = rate_of(report);
        if let Some(motion) = self.motion.as_mut() {
            motion.measurement_update_rate(&rate, self.now);
        }
        self.turning.told = Some((*report, self.now));
    }

    /// What the room of the rate needs to know of the camera.
    fn rate_field(&self) -> DetectorScale {
        DetectorScale { rad_per_px: self.camera.rad_per_px(), area_px: self.camera.area_px() }
    }

    /// The rate from the streaks of this second's image and what is remembered of the last.
    #[inline(never)]
    fn turn_by(&mut self, streaks: &[Streak]) -> Option<RateReport> {
        let row_time_s = self.row_time_s();
        let exposure_s = self.exposure_s();
        let longest_px = streaks.iter().fold(0.0f32, |longest, streak| longest.max(streak.length_px()));
        let mut arcs: Vec<Arc, MAX_ARCS> = Vec::new();
        let mut late_s: Vec<f32, MAX_ARCS> = Vec::new();
        for streak in streaks {
            if let Some(arc) = arc_of(&self.camera, streak, exposure_s, row_time_s, longest_px) {
                let _ = arcs.push(arc);
                let _ = late_s.push(row_delay_s(&self.camera, streak.middle_px(), row_time_s));
            }
        }
        let (elapsed_s, field) = (self.turning.elapsed_s(self.now), self.rate_field());
        self.turning.taken = self.now;
        let found = self.turning.history.update_from_streaks((&arcs, &late_s), elapsed_s, field)?;
        let source = if found.from_both { RateSource::Both } else { RateSource::Streaks };
        rate_report(found.estimate, source, found.either_sense, found.whole)
    }

    /// How fast the fastest star of the field moves at a rate, px/s.
    pub(super) fn farthest_px(&self, rate: &Vector3<f32>) -> f32 {
        let camera = self.camera.parameters();
        let [width, height] = [camera.width_px, camera.height_px].map(f32::from);
        hypotenuse(rate.x, rate.y) / self.camera.rad_per_px()
            + libm::fabsf(rate.z) * 0.5 * hypotenuse(width, height)
    }

    /// How far a filter's rate draws the fastest star out in the parameters' exposure, px; 0 without a rate.
    pub(super) fn drawn_px(&self, motion: &Filter) -> f32 {
        let exposure_s = self.parameters.imaging.exposure_us as f32 * 1e-6;
        motion.rate().map_or(0.0, |rate| self.farthest_px(&(rate.rad_s * exposure_s)))
    }

    /// Whether by a filter's rate stars are lines even in the shortest exposure.
    pub(super) fn is_too_fast_to_track(&self, motion: &Filter) -> bool {
        self.drawn_px(motion) > GREATEST_SCANNED_PX * LARGEST_SCAN_DIVISOR
    }

    /// After a scan whose stars were not identified: the rate from the stars of the last image, and what to
    /// look for next.
    #[inline(never)]
    fn turn_by_stars(&mut self) -> Option<RateReport> {
        let detections = &self.workspace.detections;
        let measured = self.workspace.measured.len();
        let lines = detections.drawn().saturating_add(detections.streaks()) as usize;
        let seeks = measured < FEWEST_STARS || DRAWN_SHARE * lines >= measured;
        let row_time_s = self.row_time_s();
        let mark = |star: MeasuredStar| Mark {
            direction: *star.direction.vector(),
            sigma_rad: [star.sigma_px * self.camera.rad_per_px(); 2],
            late_s: row_delay_s(&self.camera, star.centre_px, row_time_s),
        };
        // What stands on clouds or a limb turns with the Earth; its centre is less sure than its sigma says.
        let open = detections.spots().iter().filter(|spot| !spot.extended);
        let stars = open.filter_map(|spot| MeasuredStar::from_detection(&self.camera, spot));
        let mut marks: Vec<Mark, MAX_MARKS> = Vec::new();
        fill(&mut marks, stars.map(mark));
        let elapsed_s = self.turning.elapsed_s(self.now);
        let found = self.turning.history.update_from_stars(marks, elapsed_s);
        self.turning.middles_px.clear();
        self.turning.taken = self.now;
        self.turning.next = self.turning.next.after_scan(seeks, measured);
        let (estimate, count) = found?;
        let moved = self.farthest_px(&estimate.0) * elapsed_s? > LEAST_MOTION_PX;
        if moved { rate_report(estimate, RateSource::Images, false, count) } else { None }
    }
}

/// A rate as it is reported; `None` where it says too little.
#[inline(never)]
fn rate_report(
    (rate, covariance): Estimate,
    source: RateSource,
    either_sense: bool,
    stars: u32,
) -> Option<RateReport> {
    let sigma = covariance.diagonal().map(|variance| libm::sqrtf(variance.max(0.0)));
    let report = RateReport {
        rad_s: rate.into(),
        sigma_rad_s: sigma.into(),
        source,
        either_sense,
        stars: stars.min(u8::MAX.into()) as u8,
    };
    Some(report).filter(says_enough)
}

/// Whether the standard deviation of a rate is below [`LARGEST_SHARE`] of it. That of a rate of which one
/// component is open (a single streak, or streaks that all lie together) is not. One from two images may be
/// slow, and then known to a part of a pixel a second only.
fn says_enough(report: &RateReport) -> bool {
    let Rate { rad_s, sigma_rad_s } = rate_of(report);
    let size = rad_s.norm();
    sigma_rad_s.norm() < LARGEST_SHARE * size || report.source == RateSource::Images && size.is_finite()
}

/// A rate that was reported, as the filter takes it.
fn rate_of(report: &RateReport) -> Rate {
    Rate { rad_s: report.rad_s.into(), sigma_rad_s: report.sigma_rad_s.into() }
}

#[cfg(test)]
mod tests;
