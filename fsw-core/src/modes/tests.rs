use super::Mode::{Acquisition, CommandedSafe, Eclipse, Safe, SelfTest, SunOutage, Tracking};
use super::*;
use proptest::prelude::*;
use std::{vec, vec::Vec};

const PARAMETERS: ModeParameters = ModeParameters {
    patience_s: 3,
    dwell_s: 9,
    fault_patience_s: 4,
    settle_s: 2,
    acquisition_timeout_s: 20,
    outage_timeout_s: 30,
    healthy_s: 5,
};

const NOTHING: ModeInputs =
    ModeInputs { attitude: false, predicted: false, blinded: false, dark: None, fault: false };
const ATTITUDE: ModeInputs = ModeInputs { attitude: true, predicted: true, ..NOTHING };
const LIT: ModeInputs = ModeInputs { dark: Some(false), ..ATTITUDE };
const DARK: ModeInputs = ModeInputs { dark: Some(true), ..ATTITUDE };
const BLINDED: ModeInputs = ModeInputs { blinded: true, ..NOTHING };
const FAULT: ModeInputs = ModeInputs { fault: true, ..NOTHING };

prop_compose! {
    fn inputs()(
        [attitude, predicted, blinded, fault] in any::<[bool; 4]>(),
        dark in any::<Option<bool>>(),
    ) -> ModeInputs {
        ModeInputs { attitude, predicted, blinded, dark, fault }
    }
}

fn machine(mode: Mode) -> Modes {
    let mut modes = Modes::default();
    modes.enter(mode);
    modes
}

/// Modes after each of the seconds.
fn after(mode: Mode, seconds: &[ModeInputs]) -> Vec<Mode> {
    after_steps(mode, seconds, 1_000_000)
}

/// The same where the seconds are `step_us` apart.
fn after_steps(mode: Mode, seconds: &[ModeInputs], step_us: i64) -> Vec<Mode> {
    after_steps_with(mode, seconds, step_us, &PARAMETERS)
}

fn after_steps_with(
    mode: Mode,
    seconds: &[ModeInputs],
    step_us: i64,
    parameters: &ModeParameters,
) -> Vec<Mode> {
    let mut modes = machine(mode);
    let mut now = LocalTime::from_us(77);
    let step = |inputs: &ModeInputs| {
        let before = modes.mode();
        now = now.plus_us(step_us);
        let guard = modes.next(now, inputs, parameters);
        assert_eq!(guard.is_some(), before != modes.mode(), "a guard is given exactly when the mode changes");
        modes.mode()
    };
    seconds.iter().map(step).collect()
}

#[test]
fn the_sensor_begins_with_its_self_test_and_goes_on_when_it_passes() {
    assert_eq!(Modes::default().mode(), SelfTest);
    assert_eq!(after(SelfTest, &[NOTHING]), [Acquisition]);
    assert_eq!(after(SelfTest, &[FAULT, FAULT, NOTHING]), [SelfTest, SelfTest, Acquisition]);
}

#[test]
fn acquisition_needs_an_attitude_and_a_rate_that_predicts_the_next() {
    assert_eq!(after(Acquisition, &[ModeInputs { predicted: false, ..ATTITUDE }]), [Acquisition]);
    // A prediction without an attitude of this second rests on old ones.
    assert_eq!(after(Acquisition, &[ModeInputs { attitude: false, ..ATTITUDE }]), [Acquisition]);
    assert_eq!(after(Acquisition, &[ATTITUDE]), [Tracking]);
    assert_eq!(after(Acquisition, &[DARK]), [Eclipse]);
}

#[test]
fn a_field_without_stars_ends_in_safe_mode_which_tries_again() {
    let modes = after(Acquisition, &[NOTHING; 27]);
    assert!(modes[..19].iter().all(|mode| *mode == Acquisition));
    assert!(modes[19..24].iter().all(|mode| *mode == Safe));
    assert_eq!(modes[24..26], [Acquisition; 2]);
}

#[test]
fn attitudes_that_predict_no_other_do_not_end_in_safe_mode() {
    assert_eq!(after(Acquisition, &[ModeInputs { predicted: false, ..ATTITUDE }; 60]), [Acquisition; 60]);
}

#[test]
fn tracking_goes_on_until_patience_is_at_its_end() {
    for mode in [Tracking, Eclipse] {
        assert_eq!(after(mode, &[NOTHING, NOTHING, NOTHING]), [mode, mode, Acquisition]);
        assert_eq!(after(mode, &[NOTHING, NOTHING, ATTITUDE, NOTHING, NOTHING]), [mode; 5]);
    }
}

#[test]
fn eclipse_follows_the_light_once_it_has_settled_and_the_mode_has_lasted() {
    for (mode, own, other, to) in [(Tracking, LIT, DARK, Eclipse), (Eclipse, DARK, LIT, Tracking)] {
        // In the mode for long enough: two seconds of the other light in a row.
        let modes = after(mode, &[vec![own; 9], vec![other, own, other, other, other]].concat());
        assert_eq!(changes(&modes), [12], "{mode:?}");
        assert_eq!(modes[12..], [to, to]);
        // Light that changes as soon as the mode has begun waits until it has lasted; for the way back, too.
        let modes = after(mode, &[vec![other; 10], vec![own; 12]].concat());
        assert_eq!(changes(&modes), [8, 17], "{mode:?}");
    }
    // Where it is not known, the mode stays.
    assert_eq!(after(Eclipse, &[ATTITUDE; 20]), [Eclipse; 20]);
}

#[test]
fn the_sun_interrupts_every_mode_that_looks() {
    for mode in [Acquisition, Tracking, Eclipse] {
        assert_eq!(after(mode, &[BLINDED, BLINDED]), [SunOutage, SunOutage]);
    }
    assert_eq!(after(Safe, &[BLINDED]), [Safe]);
    assert_eq!(after(CommandedSafe, &[BLINDED]), [CommandedSafe]);
    assert_eq!(after(SelfTest, &[BLINDED, BLINDED]), [Acquisition, SunOutage]);
}

#[test]
fn after_the_sun_an_attitude_that_was_predicted_well_saves_the_acquisition() {
    assert_eq!(after(SunOutage, &[BLINDED, ATTITUDE]), [SunOutage, Tracking]);
    assert_eq!(after(SunOutage, &[BLINDED, DARK]), [SunOutage, Eclipse]);
    // Without stars it is looked for them for a while, and by a good prediction tracked all the same.
    assert_eq!(after(SunOutage, &[NOTHING; 2]), [SunOutage, Acquisition]);
    assert_eq!(after(SunOutage, &[ModeInputs { attitude: false, ..ATTITUDE }; 2]), [SunOutage, Tracking]);
    assert_eq!(after(SunOutage, &[BLINDED; 30])[28..], [SunOutage, Safe]);
}

#[test]
fn an_outage_lasts_for_a_while_and_so_does_acquisition() {
    let seen = ModeInputs { predicted: false, ..ATTITUDE };
    for blinded in 1..30 {
        let modes = after(Tracking, &[vec![BLINDED; blinded], vec![seen], vec![ATTITUDE; 12]].concat());
        // To the outage in the first second.
        let left = (blinded + 1).max(9);
        assert_eq!(changes(&modes), [left], "{blinded}");
        assert_eq!((modes[0], modes[left]), (SunOutage, Tracking), "{blinded}");
    }
    // Blinded as soon as tracking was lost, and in the first second of acquisition.
    assert_eq!(
        changes(&after(Tracking, &[[NOTHING; 3], [BLINDED; 3], [BLINDED; 3], [BLINDED; 3]].concat())),
        [2, 11]
    );
    assert_eq!(after(Acquisition, &[BLINDED]), [SunOutage]);
}

#[test]
fn faults_in_a_row_end_in_safe_mode_from_everywhere_and_single_ones_do_not() {
    for mode in [SelfTest, Acquisition, SunOutage] {
        assert_eq!(after(mode, &[FAULT; 4])[3], Safe, "{mode:?}");
    }
    // Tracking is lost first; the faults go on counting.
    assert_eq!(after(Tracking, &[FAULT; 4]), [Tracking, Tracking, Acquisition, Safe]);
    assert_eq!(after(Tracking, &[FAULT, FAULT, ATTITUDE, FAULT, FAULT, ATTITUDE]), [Tracking; 6]);
}

#[test]
fn a_fault_beside_an_attitude_is_borne() {
    assert_eq!(after(Tracking, &[ModeInputs { fault: true, ..ATTITUDE }; 20]), [Tracking; 20]);
}

#[test]
fn safe_mode_ends_as_soon_as_the_self_test_has_passed_for_long_enough() {
    let seconds =
        [[FAULT; 30].to_vec(), [NOTHING; 4].to_vec(), [FAULT].to_vec(), [NOTHING; 6].to_vec()].concat();
    let modes = after(Safe, &seconds);
    assert_eq!(modes.iter().position(|mode| *mode != Safe), Some(39));
    assert_eq!(modes[39..], [Acquisition; 2]);
    // What made it safe may come back: acquisition goes on for as long as after a loss of tracking.
    let modes = after(Safe, &[ATTITUDE; 16]);
    assert_eq!(modes[4..], [&[Acquisition; 9][..], &[Tracking; 3]].concat());
}

#[test]
fn stars_that_are_lost_at_once_are_not_tracked_again_at_once() {
    // Found for two seconds, lost for three, found again.
    let flapping = [ATTITUDE, ATTITUDE, NOTHING, NOTHING, NOTHING].repeat(8);
    let modes = after(Acquisition, &flapping);
    assert_eq!(modes[1..5], [Tracking, Tracking, Tracking, Acquisition]);
    assert_eq!(modes.iter().skip(4).position(|mode| *mode == Tracking), Some(11));
    // However long tracking went on: what lost it may do so again.
    let long = [[ATTITUDE; 12].to_vec(), [NOTHING; 3].to_vec(), [ATTITUDE; 9].to_vec()].concat();
    assert_eq!(after(Acquisition, &long)[13..], [&[Tracking][..], &[Acquisition; 9], &[Tracking]].concat());
}

/// Seconds in which the mode is another than in the one before.
fn changes(modes: &[Mode]) -> Vec<usize> {
    (1..modes.len()).filter(|second| modes[*second] != modes[second - 1]).collect()
}

/// Stretches of seconds that are alike, and single ones, as long as all time-outs of `PARAMETERS` together.
fn history() -> impl Strategy<Value = Vec<ModeInputs>> {
    let stretch = (inputs(), prop_oneof![2 => 1usize..4, 1 => 1usize..40]);
    let seconds = |stretches: Vec<(ModeInputs, usize)>| {
        stretches.iter().flat_map(|(inputs, length)| vec![*inputs; *length]).collect()
    };
    prop::collection::vec(stretch, 1..24).prop_map(seconds)
}

/// A change of mode: the second it came in, from, guard, to.
type Change = (usize, Mode, Guard, Mode);

/// The changes of a flight, a second apart.
fn flown(modes: &mut Modes, seconds: &[ModeInputs], parameters: &ModeParameters) -> Vec<Change> {
    let mut changes = Vec::new();
    for (second, inputs) in seconds.iter().enumerate() {
        let from = modes.mode();
        if let Some(guard) = modes.next(LocalTime::from_us(second as i64 * 1_000_000), inputs, parameters) {
            changes.push((second, from, guard, modes.mode()));
        }
    }
    changes
}

/// The rows of the table that lead so.
fn rows_of((_, from, guard, to): &Change) -> impl Iterator<Item = usize> {
    let leads = move |row: &Transition| row.from.contains(from) && row.guard == *guard && row.to.contains(to);
    TRANSITIONS.iter().enumerate().filter(move |(_, row)| leads(row)).map(|(number, _)| number)
}

/// What has to be seen in the seconds up to a change that has this guard, and how long.
fn borne_out(seconds: &[ModeInputs], changes: &[Change], number: usize) -> bool {
    let (second, from, guard, _) = changes[number];
    let before = &changes[..number];
    let entered = before.last().map_or(0, |(second, ..)| second + 1);
    // Of the seconds in this mode, where `whole` of all, so many were so without a gap.
    let lasted = |count: u16, begin: usize, so: &dyn Fn(&ModeInputs) -> bool| {
        second + 1 >= begin + usize::from(count)
            && seconds[second + 1 - usize::from(count)..=second].iter().all(so)
    };
    let in_mode = |count: u16| lasted(count, entered, &|_| true);
    let last_loss = before.iter().rev().find(|(_, _, guard, _)| {
        matches!(guard, Guard::AttitudeLost | Guard::Blinded | Guard::SunGone | Guard::Healthy)
    });
    let dwelt = last_loss.is_none_or(|(loss, ..)| second - loss >= usize::from(PARAMETERS.dwell_s));
    let now = &seconds[second];
    let without = |inputs: &ModeInputs| !inputs.attitude;
    let clear = |inputs: &ModeInputs| !inputs.blinded && !inputs.fault;
    match guard {
        Guard::SelfTestPassed => from == SelfTest && !now.fault,
        Guard::AttitudeKnown => now.attitude && now.predicted && dwelt,
        Guard::AttitudeLost => lasted(PARAMETERS.patience_s, entered, &without),
        Guard::EarthDark | Guard::EarthLit => {
            let dark = Some(guard == Guard::EarthDark);
            lasted(PARAMETERS.settle_s, entered, &|inputs| inputs.dark == dark) && in_mode(PARAMETERS.dwell_s)
        }
        Guard::Blinded => now.blinded && (from != Acquisition || dwelt),
        Guard::SunGone => {
            let settled = lasted(PARAMETERS.settle_s, entered, &clear);
            dwelt && clear(now) && (settled || now.attitude && now.predicted)
        }
        Guard::TimedOut if from == SunOutage => in_mode(PARAMETERS.outage_timeout_s),
        Guard::TimedOut => lasted(PARAMETERS.acquisition_timeout_s, entered, &without),
        // Over changes of mode.
        Guard::Faults => lasted(PARAMETERS.fault_patience_s, 0, &|inputs| inputs.fault && !inputs.attitude),
        Guard::Healthy => lasted(PARAMETERS.healthy_s, entered, &|inputs| !inputs.fault),
        Guard::Commanded | Guard::MemoryDamaged => false,
    }
}

proptest! {
    #[test]
    fn every_change_is_a_row_of_the_table_and_the_seconds_before_bear_its_guard_out(
        begin in prop::sample::select(&Mode::ALL[..]),
        seconds in history(),
    ) {
        let changes = flown(&mut machine(begin), &seconds, &PARAMETERS);
        for (number, change) in changes.iter().enumerate() {
            prop_assert!(rows_of(change).next().is_some(), "{change:?}");
            prop_assert!(borne_out(&seconds, &changes, number), "{:?}", &changes[..=number]);
        }
    }

    #[test]
    fn good_seconds_lead_to_tracking_from_whatever_state_any_history_left(
        begin in prop::sample::select(&Mode::ALL[..6]),
        seconds in history(),
        dark in any::<bool>(),
    ) {
        // The longest way is through safe mode: `healthy_s`, then `dwell_s`, and a second of tracking.
        let good = if dark { DARK } else { LIT };
        let seconds: Vec<_> = seconds.iter().copied().chain([good; 5 + 9 + 1]).collect();
        let mut modes = machine(begin);
        flown(&mut modes, &seconds, &PARAMETERS);
        prop_assert_eq!(modes.mode(), if dark { Eclipse } else { Tracking });
    }

    #[test]
    fn the_mode_changes_no_more_than_twice_in_ten_seconds_however_stars_light_faults_and_the_sun_come_and_go(
        begin in prop::sample::select(&Mode::ALL[..]),
        seconds in prop::collection::vec(any::<([bool; 4], Option<bool>)>(), 60..200),
        longest_fault in 1usize..40,
        longest_glare in 1usize..40,
        longest_light in 1usize..12,
    ) {
        type Drawn = ([bool; 4], Option<bool>);
        // In every second stretch of time the detector fails in every second, or the Sun may blind it, or
        // the light of the limb is another: a blinded image is an image.
        let of = |(second, ([attitude, predicted, fault, glare], dark)): (usize, &Drawn)| {
            let fails = (second / longest_fault) % 2 == 1;
            let blinded = *glare && (second / longest_glare) % 2 == 1 && !fails;
            let attitude = *attitude && !fails && !blinded;
            let night = (second / longest_light) % 2 == 1;
            let dark = dark.map(|other| if longest_light > 1 { night } else { other });
            ModeInputs { attitude, predicted: *predicted, blinded, fault: *fault && !blinded || fails, dark }
        };
        let seconds: Vec<_> = seconds.iter().enumerate().map(of).collect();
        let mut changes = flown(&mut machine(begin), &seconds, &ModeParameters::default());
        // A start is once: the first search follows it without a dwell.
        changes.retain(|(_, from, ..)| *from != SelfTest);
        prop_assert!(changes.windows(3).all(|three| three[2].0 - three[0].0 >= 10), "{:?}", changes);
    }
}

#[test]
fn every_row_of_the_table_decides_in_some_sequence() {
    // Of a row that leads as another does, the sequence that only it explains.
    let seen = ModeInputs { predicted: false, ..ATTITUDE };
    let carried = ModeInputs { attitude: false, ..ATTITUDE };
    let sequences: [(usize, Mode, Vec<ModeInputs>); 14] = [
        (0, Acquisition, vec![FAULT; 4]),
        (1, Eclipse, vec![BLINDED]),
        (2, Acquisition, vec![BLINDED]),
        (3, SelfTest, vec![NOTHING]),
        (4, Acquisition, vec![DARK]),
        (5, Acquisition, vec![NOTHING; 20]),
        (6, Tracking, vec![NOTHING; 3]),
        (7, Tracking, vec![DARK; 9]),
        (8, Eclipse, vec![LIT; 9]),
        (9, SunOutage, vec![BLINDED, ATTITUDE]),
        (10, SunOutage, vec![carried; 2]),
        (11, SunOutage, vec![seen; 2]),
        (12, SunOutage, vec![BLINDED; 30]),
        (13, Safe, vec![NOTHING; 5]),
    ];
    assert_eq!(sequences.len(), TRANSITIONS.len());
    for (row, begin, seconds) in sequences {
        let changes = flown(&mut machine(begin), &seconds, &PARAMETERS);
        assert_eq!(changes.len(), 1, "{row}: {changes:?}");
        assert_eq!(changes[0].0, seconds.len() - 1, "{row}: only its last second decides");
        assert!(rows_of(&changes[0]).any(|found| found == row), "{row}: {changes:?}");
    }
}

#[test]
fn the_table_has_a_way_out_of_every_mode_and_uses_every_parameter() {
    for mode in Mode::ALL {
        let left = TRANSITIONS.iter().any(|row| row.from.contains(&mode));
        assert_eq!(left, mode != CommandedSafe, "{mode:?}: only a command ends it");
        let entered = TRANSITIONS.iter().any(|row| row.to.contains(&mode));
        assert_eq!(entered, mode != SelfTest && mode != CommandedSafe, "{mode:?}");
    }
    assert!(TRANSITIONS.iter().all(|row| row.to.iter().all(|to| row.from != [*to])));
    let named = |name| TRANSITIONS.iter().flat_map(|row| row.when).any(|of| of.words().1 == Some(name));
    assert!(ModeParameters::ROWS.iter().all(|parameter| named(parameter.name)));
    // Each cause of its own leads from every mode, by one row.
    for cause in FORCED.iter().map(|row| row.cause) {
        for mode in Mode::ALL {
            let rows = FORCED.iter().filter(|row| row.cause == cause && row.from.contains(&mode));
            assert_eq!(rows.count(), 1, "{cause} in {mode:?}");
        }
    }
}

proptest! {
    #[test]
    fn no_guard_leaves_commanded_safe(
        seconds in prop::collection::vec(inputs(), 1..400),
        step_us in prop_oneof![Just(1_000_000), -5_000_000i64..4_000_000_000],
    ) {
        let modes = after_steps(CommandedSafe, &seconds, step_us);
        prop_assert!(modes.iter().all(|mode| *mode == CommandedSafe));
    }
}

#[test]
fn time_outs_are_of_local_time_and_a_gap_counts_for_two_seconds() {
    // Patience is 3 s: three calls, or six at half the time, or two about long gaps.
    assert_eq!(after_steps(Tracking, &[NOTHING; 3], 1_040_000)[1..], [Tracking, Acquisition]);
    assert_eq!(after_steps(Tracking, &[NOTHING; 3], 960_000)[1..], [Tracking, Acquisition]);
    assert_eq!(after_steps(Tracking, &[NOTHING; 4], 500_000)[2..], [Tracking, Acquisition]);
    assert_eq!(after_steps(Tracking, &[NOTHING; 2], 3_600_000_000), [Tracking, Acquisition]);
    // A counter that goes backwards counts for nothing.
    assert_eq!(after_steps(Tracking, &[NOTHING; 3], -5)[1..], [Tracking, Tracking]);
}
