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
fn eclipse_follows_the_light_once_it_has_settled() {
    assert_eq!(
        after(Tracking, &[DARK, LIT, DARK, DARK, DARK]),
        [Tracking, Tracking, Tracking, Eclipse, Eclipse]
    );
    assert_eq!(after(Eclipse, &[LIT, DARK, LIT, LIT, LIT]), [Eclipse, Eclipse, Eclipse, Tracking, Tracking]);
    // Where it is not known, the mode stays.
    assert_eq!(after(Eclipse, &[ATTITUDE; 4]), [Eclipse; 4]);
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

proptest! {
    #[test]
    fn the_mode_changes_no_more_than_twice_in_ten_seconds_however_stars_faults_and_the_sun_come_and_go(
        seconds in prop::collection::vec(any::<(bool, bool, bool, bool)>(), 60..200),
        longest_fault in 1usize..40,
        longest_glare in 1usize..40,
        dark in any::<Option<bool>>(),
    ) {
        // In every second stretch of time the detector fails in every second, or the Sun may blind it: a
        // blinded image is an image.
        let of = |(second, (attitude, predicted, fault, glare)): (usize, &(bool, bool, bool, bool))| {
            let fails = (second / longest_fault) % 2 == 1;
            let blinded = *glare && (second / longest_glare) % 2 == 1 && !fails;
            let attitude = *attitude && !fails && !blinded;
            ModeInputs { attitude, predicted: *predicted, blinded, fault: *fault && !blinded || fails, dark }
        };
        let parameters = ModeParameters { acquisition_timeout_s: 10_000, ..ModeParameters::default() };
        let seconds: Vec<_> = seconds.iter().enumerate().map(of).collect();
        let modes = after_steps_with(Tracking, &seconds, 1_000_000, &parameters);
        let changes: Vec<_> = changes(&modes).into_iter().map(|second| (second, modes[second])).collect();
        prop_assert!(changes.windows(3).all(|three| three[2].0 - three[0].0 >= 10), "{:?}", changes);
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
fn no_sequence_of_seconds_is_stuck_for_ever() {
    // From every mode but commanded safe, good seconds lead to tracking within `healthy_s`, `dwell_s` and two more.
    for mode in [SelfTest, Acquisition, Tracking, Eclipse, SunOutage, Safe] {
        assert_eq!(after(mode, &[LIT; 19]).last(), Some(&Tracking), "{mode:?}");
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
