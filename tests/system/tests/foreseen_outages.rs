//! The sensor's next change of state as it foresees it, where its attitude is not held; where it is, scenarios
//! limit the errors (`next_state_worst_sigma`).

use crate::flights::{self, scenario};
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
