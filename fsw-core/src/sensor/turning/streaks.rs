//! The streaks of an image: where they are sought, and their measurement.
//!
//! In: an exposed image, what is remembered of the last one. Out: its streaks, also those that are sought
//! only where the last image and the rate predict them.

use crate::frames::Direction;
use crate::image::scan::{MAX_DETECTIONS, MAX_STREAK_PLACES};
use crate::image::streaks::{Piece, Streak, follow, search};
use crate::order::{fill, sort};
use crate::rate::arcs::{MAX_ARCS, misfits};
use crate::rate::marks::{MAX_MARKS, Mark, rotated};
use crate::rate::streaks::{arc_of, middle_of, middle_sigma_px};
use crate::sensor::Sensor;
use crate::sensor::record::StarRecord;
use crate::stars::{MeasuredStar, row_delay_s};
use crate::telemetry::{Outcome, RateReport};
use fsw_hal::{Detector, DetectorError};
use heapless::Vec;
use nalgebra::Vector3;

/// Streaks measured in an image.
pub(super) const MAX_STREAKS: usize = MAX_ARCS;
/// What lies so near to a streak is the same line, px.
pub(super) const SAME_PX: f32 = 6.0;
/// Fewest whole streaks whose stars are sought without a hypothesis.
const FEWEST_MIDDLES: usize = 7;
/// After a search without a hypothesis so many images with lines begin none.
const UNSEARCHED: u8 = 2;
/// Columns of profiles that may be sampled in a second that has scanned for stars.
const COLUMNS_AFTER_SCAN: usize = 2_000;

impl Sensor<'_> {
    /// Measures the streaks in the image.
    pub(super) fn lines(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
    ) -> Result<Vec<Streak, MAX_STREAKS>, DetectorError> {
        let mut pieces = search::Pieces::new();
        search::search(detector, &mut self.workspace.shared.readout().buffer, &mut pieces)?;
        let mut streaks = Vec::new();
        let mut columns = follow::MAX_COLUMNS;
        for piece in pieces.iter().chain(&self.expected_pieces()) {
            self.measure(detector, piece, &mut streaks, &mut columns)?;
        }
        Ok(streaks)
    }

    /// Where the streaks of the last image go on at the rate that was found, be they ever so faint beside
    /// others.
    #[inline(never)]
    fn expected_pieces(&self) -> Vec<Piece, MAX_MARKS> {
        let mut pieces = Vec::new();
        let memory = &self.turning.history;
        let (Some(elapsed_s), Some(rate)) = (self.turning.elapsed_s(self.now), memory.known_rate()) else {
            return pieces;
        };
        let half_s = 0.5 * self.exposure_s();
        let row_time_s = self.row_time_s();
        let piece = |mark: &Mark| {
            let place = |after_s: f32| self.place(&rotated(mark, rate, after_s - mark.late_s));
            // Its row's delay hardly depends on itself.
            let middle_s = elapsed_s + row_delay_s(&self.camera, place(elapsed_s)?, row_time_s);
            let ([from_x, from_y], [to_x, to_y]) = (place(middle_s - half_s)?, place(middle_s + half_s)?);
            let (x, y) = (to_x - from_x, to_y - from_y);
            let per = 1.0 / libm::sqrtf(x * x + y * y).max(1.0);
            let piece =
                Piece { at_px: place(middle_s)?, along: [x * per, y * per], strength: 0, background: 0 };
            self.camera.contains(piece.at_px, 0.0).then_some(piece)
        };
        fill(&mut pieces, memory.marks.iter().filter_map(piece));
        pieces
    }

    /// Where a direction of the star path falls, px.
    #[inline(never)]
    fn place(&self, there: &Vector3<f32>) -> Option<[f32; 2]> {
        self.camera.project(&Direction::new(*there)?)
    }

    /// Measures the streak of a piece, unless it is known already.
    #[inline(never)]
    fn measure(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        piece: &Piece,
        streaks: &mut Vec<Streak, MAX_STREAKS>,
        columns: &mut usize,
    ) -> Result<(), DetectorError> {
        // Half a binned line may lie beside the streak.
        if streaks.is_full() || streaks.iter().any(|streak| streak.holds(piece.at_px, SAME_PX)) {
            return Ok(());
        }
        if let Some(streak) =
            follow::follow(detector, &mut self.workspace.shared.readout().buffer, piece, columns)?
            && !streaks.iter().any(|known| {
                known.holds(streak.middle_px(), SAME_PX) || streak.holds(known.middle_px(), SAME_PX)
            })
        {
            let _ = streaks.push(streak);
        }
        Ok(())
    }

    /// The streaks that a star scan has touched.
    ///
    /// # Errors
    /// Of the detector.
    pub(super) fn streaks_of_scan(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
    ) -> Result<Vec<Streak, MAX_STREAKS>, DetectorError> {
        let mut streaks = Vec::new();
        let mut columns = COLUMNS_AFTER_SCAN;
        for piece in &self.expected_pieces() {
            self.measure(detector, piece, &mut streaks, &mut columns)?;
        }
        for index in 0..MAX_DETECTIONS + MAX_STREAK_PLACES {
            let detections = &self.workspace.detections;
            let mut drawn = detections.spots().iter().filter(|spot| spot.drawn_px > 0 && !spot.extended);
            let count = drawn.clone().count();
            let place = match drawn.nth(index) {
                Some(spot) => spot.centre_px().map(|at| libm::floorf(at.max(0.0) + 0.5) as u16),
                None => match detections.streak_places().get(index - count) {
                    Some(place) => *place,
                    None => break,
                },
            };
            let piece = follow::piece_at(detector, &mut self.workspace.shared.readout().buffer, place)?;
            if let Some(piece) = piece {
                self.measure(detector, &piece, &mut streaks, &mut columns)?;
            }
        }
        Ok(streaks)
    }

    /// Identifies the stars of lines that gave a rate, by their middles: near to the attitude known last,
    /// else the next second searches for them without one. A search that finds nothing in its second is not
    /// begun again for [`UNSEARCHED`] images, in which the rate is told.
    #[inline(never)]
    pub(super) fn identify_lines(&mut self, stars: &mut StarRecord) {
        self.turning.of_lines = true;
        self.workspace.detections.clear();
        if !self.workspace.measured.is_empty() && self.reidentify(stars) {
            stars.outcome = Some(Outcome::Identified);
            stars.rate = None;
        } else if self.turning.unsearched > 0 || self.workspace.measured.len() < FEWEST_MIDDLES {
            self.turning.unsearched = self.turning.unsearched.saturating_sub(1);
        } else {
            self.turning.unsearched = UNSEARCHED;
            self.searching_since = Some(self.now);
            self.workspace.shared.begin_identification();
        }
    }

    /// Takes the middles of whole streaks that turn at the rate for measured stars, brightest first; none
    /// without a rate, or where rows are late by a turn whose sense is not known.
    #[inline(never)]
    pub(super) fn take_middles(&mut self, streaks: &[Streak], rate: Option<&RateReport>) {
        self.workspace.measured.clear();
        let row_time_s = self.row_time_s();
        let Some(rate) = rate.filter(|rate| !rate.either_sense || row_time_s == 0.0) else { return };
        let rate_rad_s = Vector3::from(rate.rad_s);
        let mut whole: Vec<&Streak, MAX_STREAKS> = Vec::new();
        fill(&mut whole, streaks.iter().filter(|streak| !streak.cut));
        sort(&mut whole, |one, other| one.light * one.length_px() > other.light * other.length_px());
        let exposure_s = self.exposure_s();
        let stars = whole.iter().filter_map(|streak| {
            let middle = Direction::new(middle_of(&self.camera, streak, &rate_rad_s)?)?;
            let arc = arc_of(&self.camera, streak, exposure_s, row_time_s, streak.length_px())?;
            let [off, _] = misfits(&arc, &rate_rad_s)?;
            let sigma_px = middle_sigma_px(streak, off);
            let star = MeasuredStar::new(&self.camera, self.camera.project(&middle)?, sigma_px)?;
            star.at_mid_frame(&self.camera, &rate_rad_s, row_time_s)
        });
        fill(&mut self.workspace.measured, stars);
    }
}
