//! The sensor's next change of state as it foresees it, where its attitude is not held; where it is,
//! scenarios limit the errors (`next_state_worst_sigma`).

use crate::flights::{self, scenario};
use sil_host::scenario::Scenario;
use sil_host::scenario::orbit_filter::GroundStart;
use sil_host::world::motion::slew::Slew;

/// A second: the sensor's state by the true geometry, and the next as it is foreseen: state, seconds until
/// then, their sigma.
struct Flown {
    state: u8,
    next: Option<(u8, i64, f64)>,
}

/// The true change to `state` nearest to a second.
fn nearest(flown: &[Flown], state: u8, second: i64) -> Option<i64> {
    let changes =
        (1..flown.len()).filter(|k| flown[*k].state != flown[k - 1].state && flown[*k].state == state);
    changes.map(|at| at as i64).min_by_key(|at| (at - second).abs())
}

/// Thesis §8.2.1.3: in an eccentric orbit the path is held at an angle from the horizon. Such an attitude
/// leaves both laws that the sensor knows slowly: nothing wrong is told of the next state.
#[test]
fn an_attitude_held_on_the_horizon_of_an_eccentric_orbit_is_told_nothing_wrong() {
    let path = system_tests::workspace().join("sil-host/orbits/gto-in-plane.toml");
    let mut scenario = Scenario::load(&path).unwrap();
    scenario.duration_s = 9_000;
    scenario.orbit_filter.start = Some(GroundStart {
        position_sigma_km: 5.0,
        velocity_sigma_m_s: 2.0,
        position_error_km: [2.0, -4.0, 3.0],
        velocity_error_m_s: [1.0, -1.0, 1.0],
        drawn: false,
    });
    let mut flown = Vec::new();
    let (mut known, mut told_states) = (0, [0; 2]);
    flights::fly(&scenario, |second| {
        let report = second.report;
        known += u32::from(report.local.is_some());
        if let Some(state) = report.state {
            told_states[usize::from(state as u8 == second.truth.state as u8)] += 1;
        }
        let next =
            report.next_state.map(|next| (next.state as u8, i64::from(next.in_s), f64::from(next.sigma_s)));
        flown.push(Flown { state: second.truth.state as u8, next });
    });
    let mut told = 0;
    for (cycle, (state, in_s, sigma_s)) in (0..flown.len()).filter_map(|k| Some((k, flown[k].next?))) {
        let at_s = cycle as i64 + in_s;
        let Some(true_s) = nearest(&flown, state, at_s) else { continue };
        assert!(((at_s - true_s) as f64).abs() < 5.0 * sigma_s, "{cycle}: {at_s} {true_s} {sigma_s}");
        told += 1;
    }
    println!(
        "attitude and orbit known for {known} s, a next state told in {told}; present states {told_states:?}"
    );
    assert!(known > 1_000);
    assert!(told_states[1] > 50 * told_states[0], "{told_states:?}");
}

#[test]
fn an_attitude_that_is_not_held_ends_what_was_foreseen() {
    // Turned by 5 deg within a minute: the Sun comes at another time, or never.
    let mut scenario = scenario("geo-eclipse", 9_000);
    let slew =
        Slew { start_s: 3_000.0, duration_s: 60.0, axis: [0.0, 1.0, 0.0], angle_rad: 5_f64.to_radians() };
    scenario.pointing.slews.push(slew);
    let mut flown = Vec::new();
    flights::fly(&scenario, |second| {
        let next = second.report.next_state;
        let next = next.map(|next| (next.state as u8, i64::from(next.in_s), f64::from(next.sigma_s)));
        flown.push(Flown { state: second.truth.state as u8, next });
    });
    let foreseen = |from: usize, to: usize| flown[from..to].iter().filter(|s| s.next.is_some()).count();
    assert!(foreseen(2_500, 3_000) > 450);
    // 1.1 deg are passed in its first third; a new look begins with the new attitude, and takes some time.
    assert_eq!(foreseen(3_030, 3_062), 0);
    let (state, in_s, _) = flown[2_999].next.unwrap();
    let comes = nearest(&flown, state, 2_999 + in_s);
    println!("state {state} foreseen for second {}; after the turn it comes at {comes:?}", 2_999 + in_s);
    assert!(comes.is_none_or(|true_s| (2_999 + in_s - true_s).abs() > 200));
    let mut told = 0;
    for (cycle, (state, in_s, sigma_s)) in (4_000..5_000).filter_map(|k| Some((k, flown[k].next?))) {
        let at_s = cycle as i64 + in_s;
        let true_s = nearest(&flown, state, at_s).unwrap();
        assert!(((at_s - true_s) as f64).abs() < 5.0 * sigma_s, "{cycle}: {at_s} {true_s} {sigma_s}");
        told += 1;
    }
    assert!(told > 500, "{told}");
}
