//! The sensor's next change of state as it foresees it, flown from pixels, beside what then comes.

use crate::flights::{self, scenario};
use sil_host::scenario::Scenario;
use sil_host::world::motion::slew::Slew;

/// The sensor's state by the true geometry, and the next as it is foreseen: state, seconds until then, their
/// sigma, seconds that it lasts.
struct Flown {
    state: u8,
    next: Option<(u8, i64, f64, Option<i64>)>,
    /// Attitude and orbit are known.
    known: bool,
}

fn fly(name: &str, seconds: u32, change: impl FnOnce(&mut Scenario)) -> Vec<Flown> {
    let mut scenario = scenario(name, seconds);
    change(&mut scenario);
    let mut flown = Vec::new();
    flights::fly(&scenario, |second| {
        let next = second.report.next_state.map(|next| {
            let lasts_s = next.lasts_s.map(i64::from);
            (next.state as u8, i64::from(next.in_s), f64::from(next.sigma_s), lasts_s)
        });
        flown.push(Flown { state: second.truth.state as u8, next, known: second.report.local.is_some() });
    });
    flown
}

/// The true change to `state` nearest to a second: its first second, and how long it lasts.
fn nearest(flown: &[Flown], state: u8, second: i64) -> Option<(i64, Option<i64>)> {
    let changes: Vec<usize> = (1..flown.len()).filter(|k| flown[*k].state != flown[k - 1].state).collect();
    let of_state = (0..changes.len()).filter(|index| flown[changes[*index]].state == state);
    let found = of_state.min_by_key(|index| (changes[*index] as i64 - second).abs())?;
    let ends = changes.get(found + 1).map(|end| (end - changes[found]) as i64);
    Some((changes[found] as i64, ends))
}

/// Flies a scenario and judges each second that foresees something. A change that the flight does not reach
/// is judged by nothing. Gives the share of seconds with attitude and orbit in which something is foreseen.
fn judge(name: &str, seconds: u32, well_known_s: f64) -> f64 {
    let flown = fly(name, seconds, |_| ());
    let (mut known, mut told, mut errors_s, mut lengths_s) = (0, 0, Vec::new(), Vec::new());
    for (cycle, second) in flown.iter().enumerate() {
        known += u32::from(second.known);
        let Some((state, in_s, sigma_s, lasts_s)) = second.next else { continue };
        told += 1;
        let at_s = cycle as i64 + in_s;
        // A sixth of a revolution at least lies between the changes to one state.
        let Some((true_s, truly_lasts_s)) = nearest(&flown, state, at_s)
            .filter(|(true_s, _)| (at_s - true_s).abs() < 900 && at_s < i64::from(seconds))
        else {
            continue;
        };
        let error_s = (at_s - true_s) as f64;
        assert!(error_s.abs() < 5.0 * sigma_s, "{name}, {cycle} s: {error_s} s of {sigma_s:.1}");
        if sigma_s < well_known_s {
            errors_s.push(error_s.abs());
            lengths_s.extend(lasts_s.zip(truly_lasts_s).map(|(told, truth)| (told - truth).abs()));
        }
    }
    errors_s.sort_by(f64::total_cmp);
    let (count, of_lengths) = (errors_s.len(), lengths_s.len());
    let [median, most] = [errors_s[count / 2], errors_s[count - 1]];
    let longest = lengths_s.iter().max().copied().unwrap_or(i64::MAX);
    println!(
        "{name}: foreseen in {told} s of {known}; where the sigma is below {well_known_s} s: {count} s, off by \
         {median} s in the median, {most} s at most; its length ({of_lengths} s) by {longest} s at most"
    );
    assert!(count > 1_000 && of_lengths > 500);
    assert!(median <= 2.0 && most < 5.0 * well_known_s && longest < 10);
    f64::from(told) / f64::from(known)
}

#[test]
fn eclipse_and_sun_of_a_low_orbit_come_when_they_are_foreseen() {
    assert!(judge("sso-noon-midnight", 18_150, 2.0) > 0.7);
}

#[test]
fn an_eclipse_in_geo_comes_when_it_is_foreseen() {
    assert!(judge("geo-eclipse", 14_400, 4.0) > 0.7);
}

#[test]
fn an_attitude_that_is_not_held_ends_what_was_foreseen() {
    // Turned by 5 deg within a minute: the Sun comes at another time, or never.
    let flown = fly("geo-eclipse", 9_000, |scenario| {
        let slew =
            Slew { start_s: 3_000.0, duration_s: 60.0, axis: [0.0, 1.0, 0.0], angle_rad: 5_f64.to_radians() };
        scenario.pointing.slews.push(slew);
    });
    let foreseen = |from: usize, to: usize| flown[from..to].iter().filter(|s| s.next.is_some()).count();
    assert!(foreseen(2_500, 3_000) > 450);
    // 1.1 deg are passed in its first third; a new look begins with the new attitude, and takes some time.
    assert_eq!(foreseen(3_030, 3_062), 0);
    let (state, in_s, ..) = flown[2_999].next.unwrap();
    let comes = nearest(&flown, state, 2_999 + in_s);
    println!("state {state} foreseen for second {}; after the turn it comes at {comes:?}", 2_999 + in_s);
    assert!(comes.is_none_or(|(true_s, _)| (2_999 + in_s - true_s).abs() > 200));
    let mut told = 0;
    for (cycle, (state, in_s, sigma_s, _)) in (4_000..5_000).filter_map(|k| Some((k, flown[k].next?))) {
        let at_s = cycle as i64 + in_s;
        let (true_s, _) = nearest(&flown, state, at_s).unwrap();
        assert!(((at_s - true_s) as f64).abs() < 5.0 * sigma_s, "{cycle}: {at_s} {true_s} {sigma_s}");
        told += 1;
    }
    assert!(told > 500, "{told}");
}
