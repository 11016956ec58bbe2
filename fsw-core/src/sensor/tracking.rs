//! Known stars followed in windows about their predicted places.

use super::Sensor;
use super::propagation::Ephemeris;
use super::record::StarRecord;
use super::timekeeping::SECOND_US;
use crate::attitude::filter::Filter;
use crate::camera::{Camera, CameraParameters};
use crate::earth::reach;
use crate::earth::view::{EarthMask, View};
use crate::frames::{Icrs, Rotation, StarPath};
use crate::image::DetectionMethod;
use crate::image::matched::LEAST_WAY_PX;
use crate::image::scan::Smear;
use crate::image::turn::Turn;
use crate::order::fill;
use crate::plan::{self, MAX_GATE_PX, MAX_STAR_WINDOWS};
use crate::stars::confirm::{Confirmed, confirm_among, match_predicted_stars};
use crate::stars::predict::{MAX_FIELD_STARS, Predicted, field_stars};
use crate::stars::{StarField, direction_after, row_delay_s};
use crate::telemetry::{Activity, Outcome};
use crate::trigonometry::hypotenuse;
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Stage, StageMeter, Window};
use heapless::Vec;
use nalgebra::Vector3;

/// Largest common logarithm of the chance that spots anywhere in the windows match as well as the stars of an
/// attitude do: as often as not. Parts of streaks, as a fast slew begins, matched as chance does in 95 %.
const MOST_LOG10_CHANCE: f32 = -0.3;

/// A match that chance gives once in a hundred images or more often must be where the filter expects it: of
/// stars drawn out one in sixty was beyond four sigma, where a hit or a part of another streak was taken for
/// a star.
const SURE_LOG10_CHANCE: f32 = -2.0;

/// Largest common logarithm of the false-identification probability of an attitude that is within three sigma
/// of what the filter expects.
pub(super) const EXPECTED_LOG10_FALSE: f32 = -5.0;

/// Stars that were missing for so long may be anywhere, us: where `modes.patience_s` is a minute chance
/// matched in one of 60 flights, 16 deg off.
const FOLLOWED_US: i64 = 5 * SECOND_US;

/// Fewer spots of the windows that are drawn out do not say that the sensor turns. Of particles' tracks few
/// meet a window.
const FEWEST_STREAKS: u32 = 2;

/// How the turn changes within an exposure, as far as the stars show it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum TurnChange {
    #[default]
    Steady,
    /// Many stars look otherwise than the turn that is told would make them.
    Changing,
    /// The turn begins and goes far: most stars look otherwise that did not in the image before, or less than
    /// half are left. Of 330 flights of slews and jitter one was 24 sigma off without it. Or it ends: the image
    /// before showed lines. Of 120 flights one was 26 sigma off without that. Or a search's image follows a
    /// turn that lost the attitude: 6 sigma in one of 120.
    Onset,
}

impl TurnChange {
    /// What one image shows by itself.
    pub(super) fn of(smear: Smear) -> Self {
        match smear {
            Smear::Blurred | Smear::MostlyBlurred => Self::Changing,
            Smear::Points | Smear::Drawn | Smear::Streaks => Self::Steady,
        }
    }

    /// Standard deviation of the mean of the light from where it is in the middle of the exposure, px. Where
    /// a turn begins in the middle it is a sixth of the way, and ways up to 4 px, from which on stars no
    /// longer look round, have this sixth, rms.
    fn sigma_px(self) -> f32 {
        match self {
            Self::Steady => 0.0,
            Self::Changing => 0.4,
            Self::Onset => 2.0,
        }
    }
}

/// An image of fewer stars shows half as many in the next by chance.
const MANY_STARS: u8 = 8;

/// What windows showed of the stars in an image.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Followed {
    stars: u8,
    /// They were [points](Smear::Points).
    sharp: bool,
}

/// Error of a spot that looks round among stars that are drawn out: it is a part of a faint one of up to 8 px,
/// of which 3 px are seen anywhere, or a hit.
pub(super) const PART_PX: f32 = 1.5;

/// The stars expected in the image, and the windows in which they are sought.
struct Expectation {
    attitude: Rotation<Icrs, StarPath>,
    stars: Vec<Predicted, MAX_FIELD_STARS>,
    windows: Vec<Window, MAX_STAR_WINDOWS>,
}

impl Sensor<'_> {
    /// Follows known stars in windows about their predicted places.
    #[inline(never)]
    pub(super) fn track(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: Option<&Ephemeris>,
        stars: &mut StarRecord,
    ) -> Result<Outcome, DetectorError> {
        let gate_px = self.parameters.tracking.gate_px;
        let looked = self.look(detector, meter, (ephemeris, gate_px))?;
        let Some((expectation, clear_windows)) = looked else { return Ok(Outcome::Lost) };
        let smear = self.workspace.detections.smear(FEWEST_STREAKS);
        match smear {
            Smear::Points | Smear::Blurred | Smear::MostlyBlurred => {}
            Smear::Drawn => self.workspace.detections.doubt_round(PART_PX),
            Smear::Streaks => return Ok(Outcome::TooFast),
        }
        self.measure_windows(stars);
        meter.begin(Stage::Confirm);
        let confirmed = self.confirm(&expectation);
        meter.end(Stage::Confirm);
        let seen = confirmed.as_ref().map_or(0, |confirmed| confirmed.matches.len());
        let now = Followed { stars: seen as u8, sharp: smear == Smear::Points };
        let before = core::mem::replace(&mut self.followed, now);
        let begins = smear == Smear::MostlyBlurred && before.sharp
            || before.stars >= MANY_STARS && 2 * now.stars < before.stars;
        self.turn_change = if begins { TurnChange::Onset } else { TurnChange::of(smear) };
        Ok(self.follow(confirmed.as_ref(), clear_windows, stars))
    }

    /// In acquisition: whether windows where the filter, or one that was lost, predicts stars show them, and
    /// hardly by chance. Among clouds windows show stars that a scan takes for texture.
    #[inline(never)]
    pub(super) fn track_again(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: Option<&Ephemeris>,
        stars: &mut StarRecord,
    ) -> Result<bool, DetectorError> {
        let Some(gate_px) = self.gate_again_px() else { return Ok(false) };
        let looked = self.look(detector, meter, (ephemeris, gate_px))?;
        let Some((Expectation { attitude, windows, .. }, _)) = &looked else { return Ok(false) };
        if self.workspace.detections.smear(FEWEST_STREAKS) != Smear::Points {
            return Ok(false);
        }
        self.turn_change = TurnChange::Steady;
        self.measure_windows(stars);
        meter.begin(Stage::Identify);
        let found = self.find_near(attitude, plan::searched_px(windows));
        meter.end(Stage::Identify);
        let taken = found.is_some_and(|(confirmed, log10_false)| {
            self.measurement_update(&confirmed, log10_false, self.now, stars)
        });
        if taken {
            self.images_given_up = 0;
            (stars.activity, stars.outcome) = (Activity::StarTracking, Some(Outcome::Identified));
        }
        Ok(taken)
    }

    /// The gate that holds three sigma of what the filter predicts, or one that was lost, px; as wide as
    /// windows may have it where that is one sigma at least, else `None`.
    pub(super) fn gate_again_px(&self) -> Option<u16> {
        let off_px = self.motion.any().and_then(|motion| self.three_sigma_px(motion, self.now))?;
        let gate_px = self.parameters.tracking.gate_px.max(off_px as u16 + 1).min(MAX_GATE_PX);
        (off_px < 3.0 * f32::from(MAX_GATE_PX)).then_some(gate_px)
    }

    /// Reads windows about the stars of the predicted attitude; `None` without one. Beside what was expected,
    /// how many of the windows something bright does not fill.
    fn look(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        (ephemeris, gate_px): (Option<&Ephemeris>, u16),
    ) -> Result<Option<(Expectation, usize)>, DetectorError> {
        meter.begin(Stage::Predict);
        let expectation = self.expect_stars(ephemeris, &detector.geometry(), gate_px);
        meter.end(Stage::Predict);
        let Some(expectation) = expectation else { return Ok(None) };
        meter.begin(Stage::Windows);
        let method = DetectionMethod {
            parameters: &self.parameters.detection,
            calibration: self.calibration.as_ref(),
            turn: self.turn_in_exposure(),
        };
        self.sought = self.now;
        let read = self.workspace.read_windows(detector, &expectation.windows, &method);
        meter.end(Stage::Windows);
        let clear_windows = expectation.windows.len().saturating_sub(read?);
        Ok(Some((expectation, clear_windows)))
    }

    /// The stars of the predicted attitude, and windows about those that the Earth does not hide, about all
    /// where it would leave too few; `None` without an attitude.
    #[inline(never)]
    fn expect_stars(
        &self,
        ephemeris: Option<&Ephemeris>,
        geometry: &DetectorGeometry,
        gate_px: u16,
    ) -> Option<Expectation> {
        let (attitude, _) = self.motion.any()?.at(self.now)?;
        let mut stars = field_stars(&self.catalogue, &self.camera, &attitude)?;
        self.delay_rows(&mut stars, &attitude);
        // A shut Earth path hides nothing.
        let seen = ephemeris.filter(|_| self.shutting.open().earth());
        let earth = seen.and_then(|ephemeris| self.known_view(ephemeris, &attitude));
        let mask = earth.as_ref().map(|earth| self.mask(earth, gate_px));
        let hidden = |at_px| {
            let seen = mask.as_ref().zip(self.camera.earth_direction(at_px));
            seen.is_some_and(|(mask, direction)| mask.hides(&direction))
        };
        let mut windows = plan::star_windows(&stars, geometry, gate_px, hidden);
        // Twilight hides stars or does not, as the filter and the air have it: better to look than to be
        // lost.
        if windows.len() < usize::from(self.parameters.tracking.fewest_stars) {
            windows = plan::star_windows(&stars, geometry, gate_px, |_| false);
        }
        Some(Expectation { attitude, stars, windows })
    }

    /// Where windows show the Earth: one that the limb's glow reaches is no good either.
    #[inline(never)]
    pub(super) fn mask<'v>(&self, earth: &'v View, gate_px: u16) -> EarthMask<'v> {
        let margin_rad = (f32::from(gate_px) + reach::STRIP_MARGIN_PX) * self.camera.rad_per_px();
        let glow_rad = reach::glow_km(&self.parameters.earth) / earth.limb_distance_km();
        earth.mask(glow_rad + margin_rad, &self.parameters.earth)
    }

    /// Moves predicted stars to where they are at the time of their rows.
    fn delay_rows(&self, predicted: &mut [Predicted], attitude: &Rotation<Icrs, StarPath>) {
        let row_time_s = self.row_time_s();
        let rate = self.motion.any().and_then(Filter::rate).filter(|_| row_time_s > 0.0);
        let Some(rate) = rate else { return };
        for place in predicted {
            let later_s = row_delay_s(&self.camera, place.centre_px, row_time_s);
            let seen = self
                .catalogue
                .star(place.star)
                .map(|star| attitude.apply(&self.catalogue.apparent_direction(&star)));
            let then = seen.and_then(|seen| direction_after(&seen, &rate.rad_s, later_s));
            if let Some(at_px) = then.and_then(|direction| self.camera.project(&direction)) {
                place.centre_px = at_px;
            }
        }
    }

    /// How the sensor turns during the exposure, by the filter's rate, else by the one told last; `None`
    /// where how far stars move by it is not known.
    #[inline(never)]
    pub(super) fn turn_in_exposure(&self) -> Option<Turn> {
        self.turned_in_exposure().map(|turn_rad| turn_of(&self.camera, &turn_rad))
    }

    /// By how much the sensor turns during the exposure about the star path's axes, rad; `None` as above.
    #[inline(never)]
    pub(super) fn turned_in_exposure(&self) -> Option<Vector3<f32>> {
        let filtered = self.motion.as_ref().and_then(Filter::rate);
        let rate = filtered.or_else(|| self.turning.rate_at(self.now))?;
        let exposure_s = self.exposure_s();
        (self.farthest_px(&(rate.sigma_rad_s * exposure_s)) < LEAST_WAY_PX).then(|| rate.rad_s * exposure_s)
    }

    /// Whether the last image's stars are drawn out, by a turn that is not known.
    pub(super) fn is_drawn_by_unknown_turn(&self) -> bool {
        self.workspace.detections.smear(FEWEST_STREAKS) != Smear::Points
            && self.turned_in_exposure().is_none()
    }

    /// By how much the mean of the light may turn the attitude of an image within which the turn changes, one
    /// sigma an axis, rad.
    pub(super) fn change_sigma_rad(&self) -> [f32; 3] {
        let [half_width, half_height] = self.camera.middle_px();
        let sigma_px = self.turn_change.sigma_px();
        let across = sigma_px * self.camera.rad_per_px();
        [across, across, sigma_px / hypotenuse(half_width, half_height)]
    }

    /// Exposure of the last image that was asked for, s.
    pub(super) fn exposure_s(&self) -> f32 {
        self.exposure_us as f32 * 1e-6
    }

    /// From a row to the next, s.
    pub(super) fn row_time_s(&self) -> f32 {
        self.parameters.imaging.row_time_ns as f32 * 1e-9
    }

    /// Turns the spots of the windows into measured stars.
    #[inline(never)]
    fn measure_windows(&mut self, stars: &mut StarRecord) {
        let rate_rad_s = self.motion.any().and_then(Filter::rate).map(|rate| rate.rad_s);
        self.workspace.take_measured(&self.camera, rate_rad_s.as_ref(), self.row_time_s());
        stars.count(self.workspace.measured.len(), &self.workspace.detections);
    }

    /// The measured stars matched with the expected ones. Matching begins with twice the tolerance: with the
    /// whole gate.
    fn confirm(&self, expectation: &Expectation) -> Option<Confirmed> {
        let Expectation { attitude, stars, windows, .. } = expectation;
        let measured = &self.workspace.measured;
        let field = StarField::windows(measured, &self.catalogue, &self.camera, plan::searched_px(windows))
            .without(self.workspace.detections.unread_px())
            .calibrated(self.calibration.as_ref());
        confirm_among(stars, attitude, &field, f32::from(self.parameters.tracking.gate_px) * 0.5)
    }

    /// Takes the attitude into the filter where enough stars confirm it, and chance hardly would; else the
    /// few stars themselves.
    #[inline(never)]
    fn follow(
        &mut self,
        confirmed: Option<&Confirmed>,
        clear_windows: usize,
        stars: &mut StarRecord,
    ) -> Outcome {
        let fewest = usize::from(self.parameters.tracking.fewest_stars);
        match confirmed {
            Some(confirmed) if confirmed.matches.len() >= fewest && self.is_convincing(confirmed) => {
                let taken = self.measurement_update(confirmed, confirmed.log10_chance, self.now, stars);
                if taken { Outcome::Tracked } else { Outcome::Lost }
            }
            _ => self.follow_few(clear_windows, stars).unwrap_or_else(|| {
                if let Some(motion) = self.motion.as_mut() {
                    motion.contradict(self.now);
                }
                Outcome::Lost
            }),
        }
    }

    /// Whether a match is hardly chance, by itself or because it is where the filter expects it. Once stars
    /// were missing for [`FOLLOWED_US`] it must be as sure as an identification.
    fn is_convincing(&self, confirmed: &Confirmed) -> bool {
        let (sure, most) = if self.is_followed() {
            (SURE_LOG10_CHANCE, MOST_LOG10_CHANCE)
        } else {
            (self.parameters.identification.log10_false_limit, EXPECTED_LOG10_FALSE)
        };
        let chance = confirmed.log10_chance;
        chance <= sure || chance <= most && self.is_expected(confirmed)
    }

    /// Whether an image has corrected the filter within [`FOLLOWED_US`].
    fn is_followed(&self) -> bool {
        self.motion.any().is_some_and(|motion| motion.age_us(self.now) < FOLLOWED_US)
    }

    /// Whether an attitude of this second is within three sigma of what the filter expects.
    pub(super) fn is_expected(&self, confirmed: &Confirmed) -> bool {
        let Confirmed { attitude, sigma_rad, .. } = confirmed;
        self.motion.any().is_some_and(|motion| motion.expects(attitude, sigma_rad, self.now))
    }

    /// Too few stars, or too weak a match, for an attitude of their own: each that is where the filter
    /// expects it corrects the filter. Where most of the windows that could show a star show none in its
    /// place, the attitude is lost: a single spot may be anything.
    #[inline(never)]
    fn follow_few(&mut self, clear_windows: usize, stars: &mut StarRecord) -> Option<Outcome> {
        let mut motion = *self.motion.as_ref()?;
        let (attitude, _) = motion.at(self.now)?;
        let field = StarField::whole(&self.workspace.measured, &self.catalogue, &self.camera)
            .calibrated(self.calibration.as_ref());
        let mut few = match_predicted_stars(&attitude, &field, f32::from(self.parameters.tracking.gate_px));
        few.retain(|(_, star)| motion.measurement_update_star(star, self.now));
        if few.is_empty() || 2 * few.len() < clear_windows {
            return None;
        }
        self.motion = motion.into();
        stars.solution = self.propagated(false);
        stars.solution?;
        fill(&mut stars.matches, few.iter().map(|(found, _)| *found));
        Some(Outcome::Tracked)
    }
}

/// A small turn of a camera about its axes, rad, as the image shows it.
pub(super) fn turn_of(camera: &Camera, turn_rad: &Vector3<f32>) -> Turn {
    let CameraParameters { optical_centre_px, focal_length_px, mirrored, .. } = *camera.parameters();
    Turn::new(optical_centre_px, focal_length_px, mirrored, (*turn_rad).into())
}
