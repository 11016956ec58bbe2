use super::*;
use crate::judge::Judge;
use fsw_core::outages;

/// A run of 1,000 s in which the Sun is behind the Earth from `begins` to `ends`.
fn flown(begins: u32, ends: u32, foreseen: impl Fn(u32) -> Option<NextState>) -> Foreseen {
    let mut all = Foreseen::default();
    for cycle in 0..1_000 {
        let state = if (begins..ends).contains(&cycle) { SensorState::Eclipse } else { SensorState::Full };
        let next_state = foreseen(cycle);
        all.add(&Judged { cycle, state, next_state, locally_known: cycle >= 10, ..Judged::default() });
    }
    all
}

fn eclipse(in_s: u32, sigma_s: f32, lasts_s: Option<u32>) -> NextState {
    NextState { state: outages::SensorState::Eclipse, in_s, sigma_s, lasts_s }
}

#[test]
fn a_change_is_held_against_the_one_that_comes() {
    let all =
        flown(400, 600, |cycle| (10..400).contains(&cycle).then(|| eclipse(403 - cycle, 2.0, Some(190))));
    let Agreement { share, time_s, length_s } = all.finish();
    assert_eq!(share, Some(390.0 / 990.0));
    let time_s = time_s.statistics(0, 1.0).unwrap();
    assert_eq!((time_s.seconds, time_s.rms, time_s.sigma, time_s.largest_sigma), (390, 3.0, 2.0, 1.5));
    assert!((length_s.median().unwrap() - 10.0).abs() < 0.3);
}

#[test]
fn one_that_never_comes_is_as_wrong_as_the_run_is_long() {
    let all = flown(1_000, 1_000, |cycle| (cycle == 100).then(|| eclipse(50, 2.0, None)));
    let time_s = all.finish().time_s.statistics(0, 1.0).unwrap();
    assert_eq!((time_s.rms, time_s.largest_sigma), (1_000.0, 500.0));
    assert_eq!(all.finish().length_s.median(), None);
}

#[test]
fn what_may_come_after_the_run_is_not_judged() {
    for (in_s, judged) in [(889, true), (890, false), (5_000, false)] {
        let all = flown(400, 600, |cycle| (cycle == 100).then(|| eclipse(in_s, 2.0, None)));
        assert_eq!(all.finish().time_s.statistics(0, 1.0).is_some(), judged, "{in_s} s");
    }
}

#[test]
fn the_figures_of_a_run_hold_it() {
    let mut judge = Judge::new(1_000, 0.0);
    for cycle in 0..1_000 {
        let state = if cycle < 400 { SensorState::Full } else { SensorState::Eclipse };
        let next_state = (cycle < 400).then(|| eclipse(401 - cycle, 2.0, None));
        judge.add(&Judged { cycle, state, next_state, locally_known: true, ..Judged::default() });
    }
    let figures = judge.finish();
    assert_eq!(figures.next_state_share, Some(0.4));
    assert_eq!(figures.run("next_state").unwrap().largest_sigma, 0.5);
}
