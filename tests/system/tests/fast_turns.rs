//! Turns so fast that stars are lines in the shortest exposure: an attitude by the middles of the lines.

use crate::flights::{fly, member};
use sil_host::scenario::Scenario;
use std::path::Path;
use system_tests::amount;

/// Seconds flown of each turn.
const SECONDS: u32 = 45;
/// An attitude is owed within so many seconds of the start.
const FIRST_S: u32 = 30;

/// A spacecraft that turns freely, deg/s about the axes of its Earth path, before some part of the sky.
fn turning(rate_deg_s: [f64; 3], [ra_deg, dec_deg, roll_deg]: [f64; 3]) -> Scenario {
    let text = include_str!("../../families/spin.toml");
    let (head, rest) = text.split_once("ra_deg").expect("a pointing");
    let (_, tail) = rest.split_once("rate_deg_s = [0.3, 0.4, 0.1]").expect("a rate");
    let text = format!(
        "{head}ra_deg = {ra_deg:?}\ndec_deg = {dec_deg:?}\nroll_deg = {roll_deg:?}\nrate_deg_s = {rate_deg_s:?}{tail}"
    );
    let mut scenario = Scenario::parse(Path::new("a fast turn"), &text).unwrap();
    scenario.duration_s = SECONDS;
    scenario
}

#[test]
fn at_three_to_five_degrees_a_second_an_attitude_comes_within_half_a_minute_and_none_is_wrong() {
    let (mut first_in_time, mut told, mut seconds, mut worst) = (0, 0, 0, 0.0f64);
    let turns = amount(6, 24);
    for number in 0..turns {
        let size = 3.0 + 2.0 * f64::from(number) / f64::from(turns);
        // About an axis that goes round, most of it across the line of sight.
        let about = 2.4 * f64::from(number);
        let rate = [0.9 * size * about.cos(), 0.9 * size * about.sin(), 0.43 * size];
        let mut first = None;
        fly(
            &turning(rate, [37.0 * f64::from(number) % 360.0, 11.0 * f64::from(number % 12) - 60.0, 20.0]),
            |second| {
                seconds += 1;
                if let Some(attitude) = second.judged.attitude_rad {
                    first.get_or_insert(second.cycle);
                    told += 1;
                    worst = worst.max(attitude.worst_sigma());
                }
            },
        );
        println!("{size:.2} deg/s: first attitude after {first:?} s");
        first_in_time += u32::from(first.is_some_and(|first| first <= FIRST_S));
    }
    println!(
        "attitude told in {told} of {seconds} s, {worst:.1} sigma at worst; in time in {first_in_time} of {turns}"
    );
    assert!(worst < 6.0);
    assert!(10 * first_in_time >= 8 * turns && 4 * told >= seconds);
}

/// At 3.3 deg/s the limb is drawn out by 70 px: centres of it were 10 sigma off.
#[test]
fn no_earth_is_measured_where_stars_are_lines() {
    let mut scenario = turning([-0.022, 1.808, -2.763], [111.946, -7.328, 152.653]);
    scenario.duration_s = 60;
    let (mut seen, mut told) = (0, 0);
    fly(&scenario, |second| {
        let identified = second.judged.attitude_rad.is_some();
        seen += u32::from(identified && second.judged.lit_limb_deg > 30.0);
        told += u32::from(second.judged.earth.is_some());
    });
    println!("a lit limb in {seen} seconds with an attitude, a centre of it in {told}");
    assert!(seen >= 4 && told == 0);
}

/// Among 40 false stars, which look round, stars drawn out by 8 to 11 px in a slew were taken for points: of
/// the faint ones parts were, and an attitude was 6.9 sigma off.
#[test]
fn false_stars_do_not_make_parts_of_drawn_stars_pass_for_whole_ones() {
    let (mut told, mut worst) = (0, 0.0f64);
    for run in 0..u64::from(amount(12u32, 96)) {
        fly(&member("any.toml", "any-false-stars.toml", 1, run), |second| {
            let attitude = second.judged.attitude_rad;
            if let Some(attitude) = attitude.filter(|_| (9..35).contains(&second.cycle)) {
                told += 1;
                worst = worst.max(attitude.worst_sigma());
            }
        });
    }
    println!("attitude told in {told} s, {worst:.1} sigma at worst");
    // Of 600 errors chance has one beyond it in 100 trials.
    assert!(worst < 4.3);
}
