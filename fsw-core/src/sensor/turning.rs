//! How fast the sensor turns while no attitude is known (thesis §3.1.5: HARM and LARM).
//!
//! In: the streaks of an image, or its measured stars where they were not identified. Out: the rate in the report, and what
//! must be remembered for the next image.
//!
//! - HARM. The ends of the streaks and the exposure give the rate but for its sense. It is settled by the next image: the
//!   streaks' middles are carried on by the one and the other sense, and the one counts that finds streaks there. A star
//!   that is seen twice also gives the rate over the time between the images, better than the ends of its streak do, but as a
//!   mean over that time: two such means tell the rate now, one alone is believed as far as a free body may have changed
//!   ([`CHANGE`]).
//! - LARM. Stars that were measured but not identified are matched with those of the image before by their separations.
//!
//! Lines that stand where lines stood in the last image are the Earth's limb, its clouds and spacecraft parts: a star moves by
//! twice its streak and more.
//!
//! What is not known is not said: no rate where too few streaks agree and no other image has confirmed it, none that
//! contradicts the last one; either sense where no streak went on.

mod seen;

use super::Sensor;
use crate::attitude::filter::seconds;
use crate::attitude::marks::{CHANGE, FASTEST_RAD_S, MAX_MARKS, Mark, encounters, matched};
use crate::attitude::rate::{self, Arc, MAX_ARCS, Rate, corrected, is_like, joined, widened};
use crate::image::streaks::Streak;
use crate::stars::identify::NotIdentified;
use crate::stars::{Measured, row_delay_s};
use crate::telemetry::{RateReport, RateSource, Report, Status};
use fsw_hal::{Detector, DetectorError, LocalTime, Stage, StageMeter};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};
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
/// Equations beyond the three unknowns that make a rate of one image believed: three whole streaks, or two and two cut ones.
const FEWEST_SPARE: usize = 3;
/// Shortest and longest time between two images that are compared, s.
const BETWEEN_S: (f32, f32) = (0.1, 4.5);
/// Largest standard deviation of a rate that is reported, as a share of it.
const LARGEST_SHARE: f32 = 0.4;
/// Expected number of chance encounters up to which one encounter settles the sense.
const BY_CHANCE: f32 = 0.03;
/// The sense is known from so many encounters on, and so many are counted at most.
const SURE: i8 = 2;
const MOST_SURE: i8 = 4;

/// What is remembered from image to image.
#[derive(Debug, Default)]
pub(super) struct Turning {
    marks: Vec<Mark, MAX_MARKS>,
    /// Middles of its streaks, px.
    middles_px: Vec<[f32; 2], MAX_STREAKS>,
    /// Instant of both.
    taken: LocalTime,
    /// Rate by the streaks of that image, of the sense that is believed more.
    streaks: Option<Rate>,
    /// Encounters that spoke for this sense less those against.
    sense: i8,
    /// Mean rate up to that image from the one before, if that was a second before.
    mean: Option<(Vector3<f32>, Matrix3<f32>)>,
    /// The rate that was told, where its sense was known, and its covariance, rad/s.
    told: Option<(Vector3<f32>, Matrix3<f32>)>,
    /// What to do with the next image.
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
        (!self.marks.is_empty() && (BETWEEN_S.0..=BETWEEN_S.1).contains(&elapsed_s)).then_some(elapsed_s)
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
        let rate = rate::solve(&arcs).filter(|rate| rate.rad_s.norm() < FASTEST_RAD_S);
        let elapsed_s = self.turning.elapsed_s(self.now);
        let mut before = core::mem::take(&mut self.turning);
        let (next, middles_px) = (before.next, core::mem::take(&mut before.middles_px));
        self.turning = Turning { marks, middles_px, taken: self.now, next, ..Turning::default() };
        let Some(rate) = rate else { return };
        let agree = |index: usize| (rate.arcs >> index) & 1 == 1;
        let agreeing = arcs.iter().enumerate().filter(|(index, _)| agree(*index));
        let (whole, cut) = agreeing.fold(
            (0, 0),
            |(whole, cut), (_, arc)| {
                if arc.whole { (whole + 1, cut) } else { (whole, cut + 1) }
            },
        );

        // The sense of the last image's rate, which cannot have turned over in a few seconds.
        let last = before.streaks.as_ref().filter(|_| elapsed_s.is_some());
        let turned = |rate: &Rate| rate::opposite(&arcs, rate);
        let against = last.is_some_and(|last| last.rad_s.dot(&rate.rad_s) < 0.0);
        let Some(mut rate) = (if against { turned(&rate) } else { Some(rate) }) else { return };
        let elapsed_s = elapsed_s.unwrap_or(1.0);
        let change = CHANGE * rate.rad_s.norm_squared();
        let like = last.and_then(|last| is_like(&rate, last, change * elapsed_s));
        let repeats = like == Some(true);
        let mut sense = if last.is_some() { before.sense } else { 0 };
        if last.is_some() && !repeats {
            // One of the two is wrong; whatever was concluded from them is not kept.
            sense = 0;
        }
        let images = (&before.marks[..], &self.turning.marks[..]);
        let mut there = Vec::new();
        let mut meet = |rate: &Rate, sign: f32| {
            // Between two images the mean of both rates counts, and what a body may do beside it.
            let (mean, covariance, off) = match last.filter(|_| repeats) {
                Some(last) => {
                    ((rate.rad_s + last.rad_s * sign) * 0.5, (rate.covariance + last.covariance) * 0.25, 0.1)
                }
                None => (rate.rad_s, rate.covariance, 0.5),
            };
            let off = off * change * elapsed_s;
            let covariance = widened(covariance, off);
            let chance = encounters(&mut there, images, (&mean, &covariance), elapsed_s, &self.camera);
            (there.len(), chance)
        };
        let other = turned(&rate);
        let (back, _) = other.as_ref().map_or((0, 0.0), |other| meet(other, -1.0));
        let (_, chance) = meet(&rate, 1.0);
        let gain = there.len() as i8 - back as i8;
        // One encounter settles it where chance would hardly bring one about.
        let weight = if chance < BY_CHANCE { SURE } else { 1 };
        sense = (sense + weight * gain.clamp(-2, 2)).clamp(-MOST_SURE, MOST_SURE);
        let mut mean = None;
        if sense < 0 {
            let Some(other) = other else { return };
            (rate, sense) = (other, -sense);
        } else if gain > 0 {
            mean = rate::solve(&there).filter(|mean| is_like(mean, &rate, change * elapsed_s) == Some(true));
        }
        let sure = sense >= SURE;
        let off = 0.5 * change * elapsed_s;
        let (mut best, mut source) = ((rate.rad_s, rate.covariance), RateSource::Streaks);
        if let Some(mean) = mean.as_ref().filter(|_| sure) {
            // The mean is that of half the time before: as it is, with what may have changed since, or carried on by the mean
            // before it.
            let mut now = (mean.rad_s, widened(mean.covariance, off));
            if let Some((last, covariance)) = before.mean.filter(|_| elapsed_s < 1.5) {
                let wander = change * rate.rad_s.norm();
                let carried = (
                    mean.rad_s * 1.5 - last * 0.5,
                    widened(mean.covariance * 2.25 + covariance * 0.25, wander),
                );
                if carried.1.trace() < now.1.trace() {
                    now = carried;
                }
            }
            if let Some(both) = joined(best, now) {
                (best, source) = (both, RateSource::Both);
            }
        } else if sure
            && gain > 0
            && chance < BY_CHANCE
            && let Some(both) = corrected(best, &there, off)
        {
            // Too few for a mean of their own.
            (best, source) = (both, RateSource::Both);
        }
        if sure
            && repeats
            && let Some((told, covariance)) = before.told
        {
            // What was told of the last image, with what may have changed since.
            best = joined(best, (told, widened(covariance, change * elapsed_s))).unwrap_or(best);
        }
        self.turning.sense = sense;
        self.turning.told = sure.then_some(best);
        let confirmed = mean.is_some() || repeats;
        self.turning.mean = mean.map(|mean| (mean.rad_s, mean.covariance));
        self.turning.streaks = Some(rate);
        // A contradiction is none of the last image's if that one had less to say.
        let contradicts = like == Some(false) && before.sense >= SURE;
        // Among many lines of which most disagree, some agree by chance.
        let alone = 2 * whole + cut >= FEWEST_SPARE + 3 && 2 * (whole + cut) >= arcs.len();
        if confirmed || alone && !contradicts {
            report_rate(report, best, (source, !sure, whole as u32));
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
        let rate = elapsed_s.and_then(|elapsed_s| matched(&self.turning.marks, &marks, elapsed_s));
        let next = Next { seeks, ..Next::default() };
        self.turning = Turning { marks, taken: self.now, next, ..Turning::default() };
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
    (rate, covariance): (Vector3<f32>, Matrix3<f32>),
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
