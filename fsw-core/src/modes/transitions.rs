//! The table of transitions: what leads from mode to mode.
//!
//! In: a row's conditions, the counters of [`Modes`], the results of a second. Out: the first row that holds.
//! [`Modes::next`] changes modes by [`TRANSITIONS`] alone; `sil-host modes` makes of it the page `MODES.md`
//! and the diagram. Only the host reads [`FORCED`] and the words, so the linker leaves them out of the image.

use super::Mode::{self, Acquisition, CommandedSafe, Eclipse, Safe, SelfTest, SunOutage, Tracking};
use super::{Guard, ModeInputs, ModeParameters, Modes, reached};

/// What a row asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// No star can be seen.
    Blinded,
    /// There is an image, and it is not blinded.
    Clear,
    /// Detector and self-test did not fail.
    Sound,
    /// An attitude was found or confirmed.
    Attitude,
    /// It is predicted for the next second within the tracking gate.
    Predicted,
    /// Faults in a row, without an attitude.
    Faults,
    /// Time since tracking was lost, a Sun outage began or ended, or safe mode ended.
    Dwelt,
    /// Time without an attitude, of a mode that has one.
    Lost,
    /// Time without an attitude, of acquisition.
    SearchedInVain,
    /// Time for which the limb's light contradicts the mode.
    LightSettled,
    /// Time in the mode before the light may change it.
    LightDwelt,
    /// Time of images that are not blinded.
    ClearSettled,
    /// Time in a Sun outage.
    OutageTimedOut,
    /// Time of passed self-tests.
    Healthy,
}

impl Condition {
    /// In words, and the parameter of the group `modes` whose seconds stand before them.
    pub const fn words(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::Blinded => ("no star can be seen: the detector is blinded, or the star path shut", None),
            Self::Clear => ("an image that is not blinded", None),
            Self::Sound => ("no fault of detector or self-test", None),
            Self::Attitude => ("an attitude", None),
            Self::Predicted => ("the next attitude is predicted to the tracking gate", None),
            Self::Faults => ("of faults in a row without an attitude", Some("fault_patience_s")),
            Self::Dwelt => {
                ("since tracking was lost, a Sun outage began or ended or safe mode ended", Some("dwell_s"))
            }
            Self::Lost => ("without an attitude", Some("patience_s")),
            Self::SearchedInVain => ("without an attitude", Some("acquisition_timeout_s")),
            Self::LightSettled => ("of light at the limb that contradicts the mode", Some("settle_s")),
            Self::LightDwelt => ("in the mode", Some("dwell_s")),
            Self::ClearSettled => ("of images in a row that are not blinded", Some("settle_s")),
            Self::OutageTimedOut => ("in the mode", Some("outage_timeout_s")),
            Self::Healthy => ("of self-tests in a row that passed", Some("healthy_s")),
        }
    }

    fn holds(self, modes: &Modes, inputs: &ModeInputs, parameters: &ModeParameters) -> bool {
        let (count_us, seconds) = match self {
            Self::Blinded => return inputs.blinded,
            Self::Clear => return inputs.is_clear(),
            Self::Sound => return !inputs.fault,
            Self::Attitude => return inputs.attitude,
            Self::Predicted => return inputs.predicted,
            Self::Faults => (modes.with_fault_us, parameters.fault_patience_s),
            Self::Dwelt => (modes.lost_us.unwrap_or(i64::MAX), parameters.dwell_s),
            Self::Lost => (modes.without_attitude_us, parameters.patience_s),
            Self::SearchedInVain => (modes.without_attitude_us, parameters.acquisition_timeout_s),
            Self::LightSettled => (modes.earth_changed_us, parameters.settle_s),
            Self::LightDwelt => (modes.in_mode_us, parameters.dwell_s),
            Self::ClearSettled => (modes.clear_us, parameters.settle_s),
            Self::OutageTimedOut => (modes.in_mode_us, parameters.outage_timeout_s),
            Self::Healthy => (modes.healthy_us, parameters.healthy_s),
        };
        reached(count_us, seconds)
    }
}

/// A row: from these modes, when all of its conditions hold, by this guard.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    /// The modes that are left.
    pub from: &'static [Mode],
    /// What must hold.
    pub when: &'static [Condition],
    /// What the event tells.
    pub guard: Guard,
    /// The mode that is entered; of two the second where no limb in the field is lit.
    pub to: &'static [Mode],
}

impl Transition {
    fn holds(&self, modes: &Modes, inputs: &ModeInputs, parameters: &ModeParameters) -> bool {
        self.from.contains(&modes.mode)
            && self.when.iter().all(|condition| condition.holds(modes, inputs, parameters))
    }
}

const fn row(
    from: &'static [Mode],
    when: &'static [Condition],
    guard: Guard,
    to: &'static [Mode],
) -> Transition {
    Transition { from, when, guard, to }
}

/// Modes in which stars are tracked.
const TRACKED: &[Mode] = &[Tracking, Eclipse];

/// The table, evaluated from its top: the first row that holds decides.
pub const TRANSITIONS: &[Transition] = {
    use Condition::*;
    &[
        row(&[SelfTest, Acquisition, Tracking, Eclipse, SunOutage], &[Faults], Guard::Faults, &[Safe]),
        row(TRACKED, &[Blinded], Guard::Blinded, &[SunOutage]),
        row(&[Acquisition], &[Blinded, Dwelt], Guard::Blinded, &[SunOutage]),
        row(&[SelfTest], &[Sound], Guard::SelfTestPassed, &[Acquisition]),
        row(&[Acquisition], &[Attitude, Predicted, Dwelt], Guard::AttitudeKnown, TRACKED),
        row(&[Acquisition], &[SearchedInVain], Guard::TimedOut, &[Safe]),
        row(TRACKED, &[Lost], Guard::AttitudeLost, &[Acquisition]),
        row(&[Tracking], &[LightSettled, LightDwelt], Guard::EarthDark, &[Eclipse]),
        row(&[Eclipse], &[LightSettled, LightDwelt], Guard::EarthLit, &[Tracking]),
        row(&[SunOutage], &[Clear, Attitude, Predicted, Dwelt], Guard::SunGone, TRACKED),
        row(&[SunOutage], &[ClearSettled, Predicted, Dwelt], Guard::SunGone, TRACKED),
        row(&[SunOutage], &[ClearSettled, Dwelt], Guard::SunGone, &[Acquisition]),
        row(&[SunOutage], &[OutageTimedOut], Guard::TimedOut, &[Safe]),
        row(&[Safe], &[Healthy], Guard::Healthy, &[Acquisition]),
    ]
};

/// The first row of the table that holds: the mode that it leads to, and its guard.
pub(super) fn decide(
    modes: &Modes,
    inputs: &ModeInputs,
    parameters: &ModeParameters,
) -> Option<(Mode, Guard)> {
    let row = TRANSITIONS.iter().find(|row| row.holds(modes, inputs, parameters))?;
    let to = match row.to {
        [_, dark] if inputs.dark == Some(true) => dark,
        [to, ..] => to,
        [] => return None,
    };
    Some((*to, row.guard))
}

/// A change before a second begins, whatever the guards say.
#[derive(Clone, Copy, Debug)]
pub struct Forced {
    /// The modes that are left.
    pub from: &'static [Mode],
    /// What leads to it, for people.
    pub cause: &'static str,
    /// What the event tells.
    pub guard: Guard,
    /// The mode that is entered; `None`: the same, its counters begin anew.
    pub to: Option<Mode>,
}

/// Those in which no attitude is sought that a command or damage could make wrong.
const APART: &[Mode] = &[SelfTest, Safe, CommandedSafe];
const OTHERS: &[Mode] = &[Acquisition, Tracking, Eclipse, SunOutage];

/// Changes by a command or by damage, in no order: each has its own cause.
pub const FORCED: &[Forced] = &[
    Forced { from: &Mode::ALL, cause: "command `reacquire`", guard: Guard::Commanded, to: Some(Acquisition) },
    Forced { from: &Mode::ALL, cause: "command `restart`", guard: Guard::Commanded, to: Some(SelfTest) },
    Forced { from: &Mode::ALL, cause: "command `safe`", guard: Guard::Commanded, to: Some(CommandedSafe) },
    Forced { from: OTHERS, cause: "another parameter table", guard: Guard::Commanded, to: Some(Acquisition) },
    Forced { from: APART, cause: "another parameter table", guard: Guard::Commanded, to: None },
    Forced {
        from: &Mode::ALL,
        cause: "parameter table and copy damaged",
        guard: Guard::MemoryDamaged,
        to: Some(CommandedSafe),
    },
    Forced {
        from: OTHERS,
        cause: "attitude's filter damaged",
        guard: Guard::MemoryDamaged,
        to: Some(Acquisition),
    },
    Forced { from: APART, cause: "attitude's filter damaged", guard: Guard::MemoryDamaged, to: None },
    Forced { from: &Mode::ALL, cause: "mode or its counters damaged", guard: Guard::MemoryDamaged, to: None },
];
