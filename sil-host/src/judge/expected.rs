//! The mode the geometry asks for, and whether the sensor's is right.
//!
//! The Sun in a path: Sun outage; no lit limb in the field: eclipse; else tracking. For [`GRACE_S`] after the
//! start and after a change of the geometry any mode is right that leads from the old one to the new. A lit
//! arc shorter than [`FAINT_LIMB_DEG`] is neither light nor dark: tracking and eclipse are both right. An
//! Earth outside the field, or larger than it, has no limb there: eclipse; but a sensor without an orbit
//! cannot know it, and tracking, in which it goes on searching, is right as well. With the Earth path shut
//! against the Sun it is not seen whether a limb is lit: tracking and eclipse are both right. An Earth in the star path,
//! where no filter dims it, blinds as the Sun does, and which of the two it is cannot be known without an
//! attitude: a Sun outage is right as well. While the sensor turns faster than [`TRACKABLE_DEG_S`] stars are
//! streaks, and whether they can be followed is the sensor's affair: every mode is right but a Sun outage,
//! for an acquisition that goes on for long ends in safe mode and the self-test. When it comes to rest the
//! grace begins.

use super::second::{Judged, sun};
use crate::world::scene::SensorState;
use fsw_core::modes::Mode;
use serde::Serialize;

/// Time allowed after the start and after a change of the geometry, s: self-test, two images for the rate,
/// and the seconds for which the Earth must be dark or lit before it counts as such.
pub const GRACE_S: u32 = 10;
/// A lit arc of the limb up to this length may be called dark, deg: less cannot be distinguished from the
/// terminator's twilight.
pub const FAINT_LIMB_DEG: f64 = 10.0;
/// Rate above which no mode is asked for, deg/s: images of 400 ms are streaks of 6 px on the reference
/// camera, and soon no longer found as stars.
pub const TRACKABLE_DEG_S: f64 = 0.3;
/// Most disagreements kept, the longest.
const KEPT: usize = 12;

/// The mode that a state asks for.
pub fn mode_of(state: SensorState) -> Mode {
    match state {
        state if sun(state) => Mode::SunOutage,
        SensorState::Eclipse => Mode::Eclipse,
        _ => Mode::Tracking,
    }
}

/// The mode that a second asks for.
pub fn expected_mode(second: &Judged) -> Mode {
    if second.spared { Mode::Tracking } else { mode_of(second.state) }
}

/// A stretch of seconds in which the mode was not as the geometry says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Disagreement {
    /// First second.
    pub from_s: u32,
    /// How many.
    pub seconds: u32,
    /// The mode flown, in its first second.
    pub mode: &'static str,
    /// The mode the geometry asks for, in its first second.
    pub expected: &'static str,
}

/// Judges the modes of a run, second after second.
#[derive(Clone, Debug, Default)]
pub struct ModeJudge {
    seconds: u32,
    right: u32,
    faint: u32,
    fast: u32,
    /// Expectation before and after the last change of the geometry, and when it changed.
    before: Option<Mode>,
    expected: Option<Mode>,
    changed_at: u32,
    /// Since when the mode that the geometry asks for is waited for; and the longest wait.
    waits_since: Option<u32>,
    latest_s: Option<u32>,
    present: Option<Disagreement>,
    longest: Vec<Disagreement>,
}

/// A mode's word.
pub fn word(mode: Mode) -> &'static str {
    match mode {
        Mode::SelfTest => "self-test",
        Mode::Acquisition => "acquisition",
        Mode::Tracking => "tracking",
        Mode::Eclipse => "eclipse",
        Mode::SunOutage => "sun-outage",
        Mode::Safe => "safe",
        Mode::CommandedSafe => "commanded-safe",
    }
}

impl ModeJudge {
    /// Adds a second; gives whether its mode is right.
    pub fn add(&mut self, second: &Judged) -> bool {
        let expected = expected_mode(second);
        if self.expected != Some(expected) {
            self.before = self.expected.replace(expected);
            self.changed_at = second.cycle;
            if self.before.is_some() {
                self.waits_since.get_or_insert(second.cycle);
            }
        }
        let fast = !second.sun() && second.rate_deg_s > TRACKABLE_DEG_S;
        if fast {
            self.changed_at = second.cycle + 1;
        }
        let faint = !second.sun() && second.lit_limb_deg <= FAINT_LIMB_DEG && second.lit_limb_deg > 0.0;
        let grace = second.cycle < self.changed_at + GRACE_S;
        let leads_there = match second.mode {
            Mode::SelfTest => self.before.is_none(),
            Mode::Acquisition => true,
            Mode::Safe | Mode::CommandedSafe => false,
            // Out of a Sun outage the sensor may pass through tracking into eclipse, and the other way.
            Mode::Tracking | Mode::Eclipse => !second.sun() || Some(second.mode) == self.before,
            Mode::SunOutage => Some(second.mode) == self.before,
        };
        let either = (faint || second.spared) && matches!(second.mode, Mode::Tracking | Mode::Eclipse);
        // Without an orbit an Earth that shows no lit limb cannot be distinguished from one that was not
        // found yet.
        let unknown = expected == Mode::Eclipse && second.orbit.is_none() && second.mode == Mode::Tracking;
        let flooded = second.earth_in_star_path && second.mode == Mode::SunOutage;
        let followed = fast && second.mode != Mode::SunOutage;
        let arrived = second.mode == expected || either || unknown || flooded || followed;
        if let Some(since) = self.waits_since {
            self.latest_s = self.latest_s.max(Some(second.cycle - since));
        }
        if arrived {
            self.waits_since = None;
        }
        let right = arrived || (grace && leads_there);
        self.seconds += 1;
        self.right += u32::from(right);
        self.faint += u32::from(faint);
        self.fast += u32::from(fast);
        if right {
            self.close();
        } else {
            self.present
                .get_or_insert(Disagreement {
                    from_s: second.cycle,
                    seconds: 0,
                    mode: word(second.mode),
                    expected: word(expected),
                })
                .seconds += 1;
        }
        right
    }

    /// Ends a stretch of disagreement; the longest are kept.
    fn close(&mut self) {
        if let Some(ended) = self.present.take() {
            self.longest.push(ended);
            self.longest.sort_by_key(|stretch| (std::cmp::Reverse(stretch.seconds), stretch.from_s));
            self.longest.truncate(KEPT);
        }
    }

    /// Share of seconds whose mode was right.
    pub fn share(&self) -> Option<f64> {
        (self.seconds > 0).then(|| f64::from(self.right) / f64::from(self.seconds))
    }

    /// Longest time from a change of the geometry to the mode that it asks for.
    pub fn latest_s(&self) -> Option<u32> {
        self.latest_s
    }

    /// Seconds in which the lit arc was too short to call.
    pub fn faint_s(&self) -> u32 {
        self.faint
    }

    /// Seconds in which the sensor turned too fast to ask for a mode.
    pub fn fast_s(&self) -> u32 {
        self.fast
    }

    /// The longest stretches of disagreement, the longest first.
    pub fn disagreements(mut self) -> Vec<Disagreement> {
        self.close();
        self.longest
    }
}

#[cfg(test)]
mod tests;
