//! Mode transitions (thesis §8).
//!
//! In: the present mode and the results of the second. Out: the next mode and the guard that fired,
//! by the table [`TRANSITIONS`]: the first row that holds decides. The page `MODES.md` lists its rows
//! (`sil-host modes` writes it).
//!
//! Acquisition and Sun outage both identify stars wherever an image shows them, so nothing is lost by staying
//! in them; tracking and eclipse both track stars.
//!
//! Seconds are local time between the calls; a longer gap
//! counts as `LONGEST_STEP_US`, because no image was taken in it.

mod transitions;

pub use transitions::{Condition, FORCED, Forced, TRANSITIONS, Transition};

use fsw_ground::table::parameter_group;
use fsw_ground::word_sum;
use fsw_hal::LocalTime;
use serde::{Deserialize, Serialize};
use transitions::decide;

/// Longest time that a call adds to the counters, microseconds; the first call adds one second.
const LONGEST_STEP_US: i64 = 2 * SECOND_US;
const SECOND_US: i64 = 1_000_000;

/// Mode of the sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// Detector and clock are tested before their data are used.
    #[default]
    SelfTest,
    /// Stars are identified: in windows where a filter still predicts them, else in the whole image.
    Acquisition,
    /// Windows about predicted stars and about the Earth's limb are read.
    Tracking,
    /// As tracking, but no limb in the field is lit: stars alone, the orbit is propagated.
    Eclipse,
    /// The Sun blinds the detector, or did some seconds ago: attitude by the last rate, orbit propagated; of
    /// an image that is not blinded stars are identified.
    SunOutage,
    /// After persistent faults or a time-out: the orbit is propagated, the self-test repeated in every
    /// second.
    Safe,
    /// By command, or without a parameter table that can be used: the orbit is propagated, no image is taken
    /// until a command ends it.
    CommandedSafe,
}

impl Mode {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::SelfTest,
        Self::Acquisition,
        Self::Tracking,
        Self::Eclipse,
        Self::SunOutage,
        Self::Safe,
        Self::CommandedSafe,
    ];

    /// Whether the sensor looks for neither stars nor Earth, by itself or by command.
    pub fn is_safe(self) -> bool {
        matches!(self, Self::Safe | Self::CommandedSafe)
    }
}

/// Why a mode was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Guard {
    /// The self-test passed.
    SelfTestPassed,
    /// Attitude and rate are known.
    AttitudeKnown,
    /// No attitude for too long.
    AttitudeLost,
    /// No limb in the field is lit.
    EarthDark,
    /// A limb in the field is lit.
    EarthLit,
    /// The detector is blinded.
    Blinded,
    /// It no longer is.
    SunGone,
    /// The mode lasted too long.
    TimedOut,
    /// Faults in too many seconds in a row.
    Faults,
    /// The self-test passed for long enough in safe mode.
    Healthy,
    /// A command.
    Commanded,
    /// Parameter table and copy, the attitude's filter or the mode were damaged in memory.
    MemoryDamaged,
}

parameter_group! {
    /// Persistence times and time-outs.
    pub struct ModeParameters in "modes" {
        /// Time without an attitude after which stars are acquired anew.
        patience_s: u16 = 3, 1..=60, "s",
            "an image in a hundred may give no attitude (limit of 99 %): three in a row by chance once in \
             1e6";
        /// Least time of a Sun outage, and of acquisition after a loss of tracking, a Sun outage or safe
        /// mode: they go on identifying stars as hardly chance would. What lost them, a slew, a gyro that is
        /// wrong or the Sun's glare, may lose them again. Least time of tracking and of eclipse before the
        /// limb's light leads from one to the other.
        dwell_s: u16 = 10, 1..=600, "s",
            "chosen: no three changes of mode within 10 s for want of stars or of light";
        /// Time of faults in a row, without an attitude, before safe mode.
        fault_patience_s: u16 = 13, 1..=600, "s",
            "`patience_s` and ten more: bursts of faults of ten seconds are borne in acquisition, and no three \
             changes of mode lie within 10 s";
        /// Time for which the Earth must be dark, or lit, before it counts as such, and a detector that was
        /// blinded clear before acquisition begins.
        settle_s: u16 = 3, 1..=60, "s",
            "two wrong frames change no mode; in LEO the Sun moves 0.2 deg, less than from `lit_deg` to \
             `usable_deg`";
        /// Longest time of acquisition without an attitude.
        acquisition_timeout_s: u16 = 300, 5..=10_000, "s",
            "eleven whole searches of 28 s: 1,488 sides of 16,000 to 29,000 pairs at `pairs_per_cycle`";
        /// Longest Sun outage.
        outage_timeout_s: u16 = 7200, 10..=60_000, "s",
            "the longest outage in GEO, 75 min, and half as much again";
        /// Time for which the self-test must pass before safe mode ends.
        healthy_s: u16 = 3, 1..=10_000, "s",
            "a detector that fails in half of the seconds passes three times in a row in one of eight; an \
             attitude is owed ten seconds after the fault";
    }
}

/// Results of a second that the guards use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ModeInputs {
    /// An attitude was found or confirmed.
    pub attitude: bool,
    /// The attitude that the rate predicts for the next second is within the tracking gate.
    pub predicted: bool,
    /// No star can be seen: the detector is blinded, or the star path shut before it would be.
    pub blinded: bool,
    /// Whether no limb in the field is lit; `None` where it is not known.
    pub dark: Option<bool>,
    /// The detector or the self-test failed.
    pub fault: bool,
}

impl ModeInputs {
    /// There is an image, and it is not blinded.
    fn is_clear(&self) -> bool {
        !self.blinded && !self.fault
    }
}

/// The present mode and the counters of its guards, microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modes {
    mode: Mode,
    /// Of the last call.
    instant: Option<LocalTime>,
    in_mode_us: i64,
    without_attitude_us: i64,
    with_fault_us: i64,
    /// Uninterrupted time of passed self-tests in safe mode.
    healthy_us: i64,
    /// Since tracking was last lost, a Sun outage began or ended, or safe mode ended; `None` where none did.
    lost_us: Option<i64>,
    /// Uninterrupted time of images that are not blinded in a Sun outage.
    clear_us: i64,
    /// Uninterrupted time for which the limb's light contradicts the mode (dark in tracking, lit in
    /// eclipse).
    earth_changed_us: i64,
}

/// Whether a count has reached `seconds`, to the nearest second: calls are never exactly a second apart.
fn reached(count_us: i64, seconds: u16) -> bool {
    count_us.saturating_add(SECOND_US / 2) >= i64::from(seconds) * SECOND_US
}

impl Modes {
    /// The present mode.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Sum of the words of mode and counters.
    pub fn word_sum(&self) -> u32 {
        let Self { in_mode_us, without_attitude_us, with_fault_us, healthy_us, .. } = *self;
        let Self { clear_us, earth_changed_us, .. } = *self;
        let counters =
            [in_mode_us, without_attitude_us, with_fault_us, healthy_us, clear_us, earth_changed_us];
        let rest = [self.instant.map_or(-1, LocalTime::as_us), self.lost_us.unwrap_or(-1)];
        let longs = counters.into_iter().chain(rest).map(|us| word_sum::of_long(us as u64));
        longs.fold(self.mode as u32, u32::wrapping_add)
    }

    /// Enters a mode; its counters are reset.
    pub fn enter(&mut self, mode: Mode) {
        *self = Self { mode, instant: self.instant, ..Self::default() };
    }

    /// The mode in which another parameter table is used first.
    pub fn with_new_parameters(&self) -> Mode {
        match self.mode {
            Mode::SelfTest | Mode::Safe | Mode::CommandedSafe => self.mode,
            _ => Mode::Acquisition,
        }
    }

    /// Evaluates the second that ended at `now`; returns the guard if the mode changes.
    pub fn next(
        &mut self,
        now: LocalTime,
        inputs: &ModeInputs,
        parameters: &ModeParameters,
    ) -> Option<Guard> {
        let elapsed_us =
            self.instant.map_or(SECOND_US, |before| now.us_since(before)).clamp(0, LONGEST_STEP_US);
        self.instant = Some(now);
        let count = |us: i64, goes_on: bool| if goes_on { us.saturating_add(elapsed_us) } else { 0 };
        let earth_changed = match self.mode {
            Mode::Tracking => inputs.dark == Some(true),
            Mode::Eclipse => inputs.dark == Some(false),
            _ => false,
        };
        self.in_mode_us = count(self.in_mode_us, true);
        self.without_attitude_us = count(self.without_attitude_us, !inputs.attitude);
        self.with_fault_us = count(self.with_fault_us, inputs.fault && !inputs.attitude);
        self.healthy_us = count(self.healthy_us, self.mode == Mode::Safe && !inputs.fault);
        self.clear_us = count(self.clear_us, self.mode == Mode::SunOutage && inputs.is_clear());
        self.lost_us = self.lost_us.map(|us| count(us, true));
        self.earth_changed_us = count(self.earth_changed_us, earth_changed);
        let (mode, guard) = decide(self, inputs, parameters)?;
        let Self { with_fault_us, lost_us, .. } = *self;
        self.enter(mode);
        // These go on over changes of mode.
        self.with_fault_us = with_fault_us;
        let begins = matches!(guard, Guard::AttitudeLost | Guard::Blinded | Guard::SunGone | Guard::Healthy);
        self.lost_us = if begins { Some(0) } else { lost_us };
        Some(guard)
    }
}

#[cfg(test)]
mod tests;
