use super::*;
use crate::body::EARTH;
use crate::forces::Dynamics;
use crate::reference::{self, circular, orbit_file, period_s, samples, time_us};
use std::vec::Vec;

/// Those that fly by default.
const FULL: Forces = Dynamics::Full.forces(0.022, 0.013);

/// By calls of at most `call_s`.
fn carry(forces: &Forces, state: &OrbitState, to_us: i64, call_s: i64) -> OrbitState {
    let mut state = *state;
    while state.time_us < to_us {
        state = forces.propagate(&state, (to_us - state.time_us).min(call_s * 1_000_000)).unwrap();
    }
    state
}

fn apart_m(a: &OrbitState, b: &OrbitState) -> f64 {
    (a.position_km - b.position_km).norm() * 1e3
}

#[test]
fn integration_is_good_to_a_metre_after_a_low_orbit() {
    let start = circular(6_828.0, 51.6);
    let end = start.time_us + (period_s(6_828.0) * 1e6) as i64;
    let fine = carry(&Forces::KEPLER, &start, end, 1);
    let normal = apart_m(&carry(&Forces::KEPLER, &start, end, 100), &fine);
    let coarse = apart_m(&carry(&Forces::KEPLER, &start, end, 150), &fine);
    std::println!("one LEO orbit: {normal:.3} m at 25 s steps, {coarse:.3} m at 37.5 s");
    assert!(normal < 1.0, "{normal}");
    assert!(coarse < 3.0, "{coarse}");
}

#[test]
fn a_point_mass_keeps_energy_and_closes_the_ellipse() {
    let mut start = circular(7_000.0, 98.0);
    start.velocity_km_s *= 1.1;
    let energy =
        |s: &OrbitState| 0.5 * s.velocity_km_s.norm_squared() - EARTH.mu_km3_s2 / s.position_km.norm();
    let axis = -0.5 * EARTH.mu_km3_s2 / energy(&start);
    let end = carry(&Forces::KEPLER, &start, start.time_us + (period_s(axis) * 1e6) as i64, 20);
    assert!((energy(&end) / energy(&start) - 1.0).abs() < 1e-9);
    assert!(apart_m(&start, &end) < 1.0, "{}", apart_m(&start, &end));
}

#[test]
fn there_and_back_is_the_same_place() {
    let start = circular(42_164.0, 1.0);
    let back = FULL.propagate(&FULL.propagate(&start, 60_000_000).unwrap(), -60_000_000).unwrap();
    assert!(apart_m(&start, &back) < 1e-3);
}

#[test]
fn the_bulge_is_that_of_the_reference_field() {
    // Against the potential's gradient by Cunningham's recursion, whose tesserals of degree two are 2e-3 of
    // the bulge.
    let field =
        |bulge_km2| Field { mu_km3_s2: EARTH.mu_km3_s2, bulge_km2, pole: Vector3::z(), perturbations: None };
    for (x, y, z) in [
        (6_828.0, 0.0, 0.0),
        (0.0, 5_000.0, 5_000.0),
        (1_000.0, 2_000.0, 6_700.0),
        (20_000.0, 1.0, -36_000.0),
    ] {
        let r = Vector3::new(x, y, z);
        let ours = field(Forces::J2.bulge_km2()).acceleration(&r, &Vector3::zeros());
        let point = field(0.0).acceleration(&r, &Vector3::zeros());
        let theirs = reference::field_acceleration(&r, 2);
        assert!((ours - theirs).norm() < 0.02 * (ours - point).norm(), "{r}");
    }
}

/// Distances from GMAT with the same forces, hourly, m; and last that of the reference after a day.
fn against_gmat(name: &str) -> Option<Vec<f64>> {
    let text = orbit_file(name)?;
    let rows = samples(&text);
    // 2023-05-16 20:00 UTC; TT - UTC = 69.184 s.
    let time = |elapsed: f64| time_us(8_535.5 + 20.0 / 24.0 + elapsed / 86_400.0, 69.184);
    let state = |row: &[f64; 7]| OrbitState {
        time_us: time(row[0]),
        position_km: Vector3::new(row[1], row[2], row[3]),
        velocity_km_s: Vector3::new(row[4], row[5], row[6]),
    };
    let mut here = state(&rows[0]);
    let mut errors = Vec::new();
    for row in &rows {
        here = carry(&Forces::J2, &here, time(row[0]), 100);
        errors.push(apart_m(&here, &state(row)));
    }
    // The reference propagator proves frame, time and ephemeris.
    let mut exact = state(&rows[0]);
    for row in rows.iter().take(25).skip(1) {
        let span_s = (time(row[0]) - exact.time_us) as f64 / 1e6;
        for _ in 0..36 {
            exact = reference::propagate(&exact, span_s / 36.0, 10.0, 2);
        }
    }
    let exact = apart_m(&exact, &state(&rows[24]));
    std::println!(
        "{name}: 2 h {:.0} m, 1 day {:.0} m, 7 days {:.0} m; the reference 1 day {exact:.1} m",
        errors[2],
        errors[24],
        errors[168]
    );
    errors.push(exact);
    Some(errors)
}

#[test]
fn a_low_orbit_agrees_with_gmat() {
    if let Some(errors) = against_gmat("leo_iss_j2.json") {
        assert!(errors[24] < 100.0);
        assert!(errors[169] < 100.0);
    }
}

#[test]
fn a_geostationary_orbit_agrees_with_gmat() {
    if let Some(errors) = against_gmat("geo_j2.json") {
        assert!(errors[24] < 100.0);
        assert!(errors[169] < 100.0);
    }
}

#[test]
fn a_real_orbit_is_predicted() {
    let Some(states) = reference::jason2() else { return };
    let mut worst = [0.0f64; 3];
    for start in (0..4_000).step_by(200) {
        for (index, minutes) in [(0, 35), (1, 112), (2, 1_440)] {
            let end = carry(&FULL, &states[start], states[start + minutes].time_us, 100);
            worst[index] = worst[index].max(apart_m(&end, &states[start + minutes]));
        }
    }
    std::println!(
        "Jason-2, worst of 20: 35 min {:.0} m, one orbit {:.0} m, a day {:.0} m",
        worst[0],
        worst[1],
        worst[2]
    );
    assert!(worst[0] < 600.0 && worst[1] < 2_000.0 && worst[2] < 15_000.0);
}

#[test]
fn the_transition_is_the_derivative_of_the_propagation() {
    let mut eccentric = circular(6_900.0, 63.0);
    eccentric.velocity_km_s *= 1.25;
    for start in [circular(6_828.0, 51.6), circular(42_164.0, 0.1), eccentric] {
        for (span_s, limit) in [(1, 1e-6), (60, 2e-6), (150, 1e-4)] {
            let move_by = |state: &OrbitState| FULL.propagate(state, span_s * 1_000_000).unwrap();
            let end = move_by(&start);
            let motion = FULL.transition(&start, &end);
            let block = |row: usize, column: usize| Matrix3::from_fn(|i, j| motion[row + i][column + j]);
            let (rr, rv, vr, vv) = (block(0, 0), block(0, 3), block(3, 0), block(3, 3));
            let dt = span_s as f64;
            for axis in 0..3 {
                let mut along = Vector3::zeros();
                along[axis] = 1.0;
                let shifted = |dr: f64, dv: f64| {
                    let mut state = start;
                    state.position_km += along * dr;
                    state.velocity_km_s += along * dv;
                    let after = move_by(&state);
                    (after.position_km - end.position_km, after.velocity_km_s - end.velocity_km_s)
                };
                let (r, v) = shifted(0.01, 0.0);
                assert!((r / 0.01 - rr * along).norm() < limit, "rr {span_s}");
                assert!((v / 0.01 - vr * along).norm() * dt < limit, "vr {span_s}");
                let (r, v) = shifted(0.0, 1e-5);
                assert!((r / 1e-5 - rv * along).norm() / dt < limit, "rv {span_s}");
                assert!((v / 1e-5 - vv * along).norm() < limit, "vv {span_s}");
            }
        }
    }
}

#[test]
fn what_no_satellite_does_is_refused() {
    let good = circular(7_000.0, 0.0);
    assert_eq!(FULL.propagate(&good, MAX_SPAN_US + 1), Err(PropagationError::TooLong));
    assert_eq!(FULL.propagate(&good, i64::MIN), Err(PropagationError::TooLong));
    let late = OrbitState { time_us: i64::MAX, ..good };
    assert_eq!(FULL.propagate(&late, 1), Err(PropagationError::TooLong));
    for radius in [0.0, 100.0, f64::NAN, f64::INFINITY, 1e9] {
        let bad = OrbitState { position_km: Vector3::new(radius, 0.0, 0.0), ..good };
        assert_eq!(FULL.propagate(&bad, 1_000_000), Err(PropagationError::Impossible));
    }
    let dropped = OrbitState { velocity_km_s: Vector3::new(-15.0, 0.0, 0.0), ..good };
    assert_eq!(FULL.propagate(&dropped, MAX_SPAN_US), Err(PropagationError::Impossible));
    // At the Moon's place the pull stays finite.
    let moon = crate::ephemeris::Bodies::at(crate::body::CentralBody::Earth, 0).neighbour_km;
    let there = OrbitState { time_us: 0, position_km: moon, velocity_km_s: Vector3::zeros() };
    assert!(FULL.propagate(&there, 1_000_000).is_ok());
}
