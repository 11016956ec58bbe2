//! Orbit files followed: against samples left out, velocities not used, an orbit flown and sampled.

use super::*;
use crate::world::attitude::apply;
use crate::world::orbit::tests::data;
use crate::world::orbit::{TruthOrbit, sp3, state_of_elements};
use crate::world::time::ephemeris::EARTH_RATE_RAD_S;
use crate::world::vector::{cross, minus, plus, times};
use fsw_core::orbit::body::CentralBody;

const START_US: i64 = 843_393_969_184_000;

/// Samples of a low orbit every `step_s`, from 20 min before the start to 20 min after two hours, in `frame`.
fn sampled(step_s: usize, frame: Frame) -> (TruthOrbit, Samples) {
    let (r, v) = state_of_elements(CentralBody::Earth, [6828.0, 0.001, 51.6, 120.0, 30.0, 15.0]).unwrap();
    let orbit = TruthOrbit::new(START_US, r, v, 10_000).unwrap();
    let orientation = EarthOrientation::default();
    let places = (0..10_000).step_by(step_s).map(|t| {
        let time_us = START_US + t as i64 * 1_000_000;
        let turn = transposed(&frame.to_gcrf(time_us, &orientation));
        (time_us, apply(&turn, orbit.at(t as f64).0))
    });
    let samples = Samples { frame, places: places.collect() };
    (orbit, samples)
}

#[test]
fn a_sampled_orbit_is_met_between_the_samples_in_every_frame() {
    for frame in [Frame::Gcrf, Frame::Eme2000, Frame::Teme, Frame::Itrf] {
        let (orbit, samples) = sampled(60, frame);
        let track = TruthOrbit::along(&samples, START_US + 1_200_000_000, 6000, &EarthOrientation::default())
            .unwrap();
        let (mut worst_m, mut worst_mm_s) = (0.0f64, 0.0f64);
        for k in 0..6000 {
            let t = f64::from(k) + 0.3;
            let ((r, v), (place, velocity)) = (orbit.at(t + 1200.0), track.at(t));
            worst_m = worst_m.max(1e3 * length(minus(r, place)));
            worst_mm_s = worst_mm_s.max(1e6 * length(minus(v, velocity)));
        }
        println!("{frame:?}: {worst_m:.5} m, {worst_mm_s:.4} mm/s");
        assert!(worst_m < 0.01 && worst_mm_s < 0.5, "{frame:?}");
    }
}

#[test]
fn every_other_sample_is_found_from_the_rest() {
    let (Some(text), Some(series)) = (data("jason2.sp3"), data("eopc04_excerpt.txt")) else { return };
    let orientation = EarthOrientation::read(&series).unwrap();
    let all = sp3::read(&text, None).unwrap();
    let half = Samples { places: all.places.iter().copied().step_by(2).collect(), ..all.clone() };
    let (first, last) = (half.places[0].0, half.places[half.places.len() - 1].0);
    let seconds = ((last - first) / 1_000_000) as u32;
    let track = TruthOrbit::along(&half, first, seconds, &orientation).unwrap();
    let whole = TruthOrbit::along(&all, first, seconds, &orientation).unwrap();
    let (mut inner, mut edge, mut speed) = (0.0f64, 0.0f64, 0.0f64);
    let velocities: Vec<&str> = text.lines().filter(|line| line.starts_with('V')).collect();
    for (k, (time_us, place)) in all.places.iter().enumerate().take_while(|(_, place)| place.0 <= last) {
        let t = (time_us - first) as f64 * 1e-6;
        let turn = orientation.gcrf_to_itrf(*time_us);
        let apart = 1e3 * length(minus(apply(&turn, track.at(t).0), *place));
        let at_edge = k < POINTS || k + POINTS > all.places.len();
        if at_edge {
            edge = edge.max(apart)
        } else {
            inner = inner.max(apart)
        }
        // The file's own velocities, m/s in axes that turn, were not used.
        let (r, v) = whole.at(t);
        let turning = minus(v, times(EARTH_RATE_RAD_S, cross(turn[2], r)));
        let fields: Vec<f64> = velocities[k].split_whitespace().skip(1).map(|f| f.parse().unwrap()).collect();
        let difference = plus(apply(&turn, turning), -1e-3, [fields[0], fields[1], fields[2]]);
        if !at_edge {
            speed = speed.max(1e6 * length(difference));
        }
    }
    println!(
        "left out: {inner:.4} m inside, {edge:.4} m at the ends; velocity {speed:.3} mm/s from the file's"
    );
    assert!(inner < 0.05 && edge < 1.0 && speed < 2.0);
}

#[test]
fn runs_that_the_samples_do_not_carry_are_refused() {
    let (_, samples) = sampled(60, Frame::Gcrf);
    let none = EarthOrientation::default();
    let refused = |samples: &Samples, from_s: i64, seconds| {
        TruthOrbit::along(samples, START_US + from_s * 1_000_000, seconds, &none).unwrap_err().to_string()
    };
    let span = "the run is not within 2026-09-23T00:05:00 to 2026-09-23T02:51:00 UTC, which the file spans";
    assert_eq!(refused(&samples, -1, 10), span);
    assert_eq!(refused(&samples, 0, 9961), span);
    assert!(TruthOrbit::along(&samples, START_US, 9960, &none).is_ok());
    let mut holed = samples.clone();
    holed.places.drain(50..60);
    assert!(refused(&holed, 0, 6000).contains("no sample for 660 s"));
    let few = Samples { places: samples.places[..11].to_vec(), ..samples.clone() };
    assert!(refused(&few, 0, 60).contains("11 samples"));
    let series = "2026 9 24 0 61307.00 0.1 0.3 0.0 0 0\n2026 9 25 0 61308.00 0.1 0.3 0.0 0 0\n";
    let later = EarthOrientation::read(series).unwrap();
    let itrf = Samples { frame: Frame::Itrf, ..samples };
    let error = TruthOrbit::along(&itrf, START_US, 60, &later).unwrap_err().to_string();
    assert!(error.contains("does not cover 2026-09-23T00:05:00 UTC"), "{error}");
}
