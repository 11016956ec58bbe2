//! The truth orbit against finer tolerances, Kepler, conserved quantities, another program and a real
//! satellite.

use super::*;
use crate::world::attitude::{apply, dot};
use crate::world::time::earth_orientation::EarthOrientation;
use crate::world::vector::{cross, transposed, unit};
use fsw_core::orbit::body::CentralBody;
use std::path::PathBuf;

const START_US: i64 = 843_393_969_184_000;
const DAY_S: u32 = 86_400;

fn geo() -> (Vector, Vector) {
    state_of_elements(CentralBody::Earth, [42_164.17, 0.0002, 0.05, 40.0, 10.0, 75.0]).unwrap()
}

fn leo() -> (Vector, Vector) {
    state_of_elements(CentralBody::Earth, [6828.0, 0.001, 51.6, 120.0, 30.0, 15.0]).unwrap()
}

fn gto() -> (Vector, Vector) {
    state_of_elements(CentralBody::Earth, [24_400.0, 0.73, 7.0, 20.0, 178.0, 90.0]).unwrap()
}

/// Gravity of a point and nothing else.
fn point_only() -> Forces {
    Forces { gravity_degree: 0, gravity_order: 0, sun: false, moon: false, ..quiet() }
}

/// Neither air nor light.
fn quiet() -> Forces {
    Forces { drag: false, radiation_pressure: false, ..Forces::default() }
}

fn fly_to(tolerance_km: f64, (r, v): (Vector, Vector), seconds: u32, forces: &Forces) -> TruthOrbit {
    let gravity = Gravity::egm2008(forces.gravity_degree, forces.gravity_order);
    TruthOrbit::fly(Dynamics::new(START_US, gravity, forces), r, v, seconds, tolerance_km).unwrap()
}

/// Greatest distance between two orbits over `seconds`, between the nodes as well as on them, m.
fn apart_m(a: &TruthOrbit, b: &TruthOrbit, seconds: u32) -> f64 {
    let times = (0..=seconds).step_by(37).map(f64::from);
    times.map(|t| 1e3 * length(minus(a.at(t).0, b.at(t).0))).fold(0.0, f64::max)
}

#[test]
fn a_finer_tolerance_moves_a_day_by_little() {
    // Smooth forces, then all: the limb's shadow and the kinks of the air's tables are what steps of any
    // order stumble at.
    let starts = [("GEO", geo(), [5e-4, 1e-3]), ("LEO", leo(), [5e-4, 0.1]), ("GTO", gto(), [2e-3, 5.0])];
    for (name, start, limits_m) in starts {
        for (forces, limit_m) in [quiet(), Forces::default()].iter().zip(limits_m) {
            let orbit = fly_to(TOLERANCE_KM, start, DAY_S, forces);
            let beside =
                |share: f64| apart_m(&orbit, &fly_to(share * TOLERANCE_KM, start, DAY_S, forces), DAY_S);
            let (half, finer) = (beside(0.5), beside(1e-3));
            let count = orbit.pieces.len();
            println!(
                "{name}, drag {}: {count} nodes, half {half:.6} m, a thousandth {finer:.6} m",
                forces.drag
            );
            assert!(half < limit_m && finer < limit_m, "{name}");
        }
    }
}

#[test]
fn a_run_is_the_same_however_long_it_is() {
    let (r, v) = leo();
    let orbits = [6000, 600].map(|seconds| TruthOrbit::new(START_US, r, v, seconds).unwrap());
    for t in [-2.0, 0.0, 0.5, 333.3, 599.5, 602.0] {
        assert_eq!(orbits[0].at(t), orbits[1].at(t));
    }
}

#[test]
fn velocity_is_the_slope_of_position() {
    for start in [leo(), geo(), gto()] {
        let orbit = TruthOrbit::new(START_US, start.0, start.1, 6000).unwrap();
        assert_eq!(orbit.at(0.0), start);
        for t in [-1.5, 0.1, 2.5, 333.3, 5999.0, 6001.9] {
            let slope = times(1e2, minus(orbit.at(t + 5e-3).0, orbit.at(t - 5e-3).0));
            assert!(length(minus(slope, orbit.at(t).1)) < 1e-8, "{t}");
        }
    }
}

#[test]
fn a_point_keeps_the_orbit_of_kepler() {
    for (name, start, a_km) in [("LEO", leo(), 6828.0f64), ("GTO", gto(), 24_400.0)] {
        let period_s = std::f64::consts::TAU * (a_km * a_km * a_km / MU_EARTH).sqrt();
        let orbit = fly_to(TOLERANCE_KM, start, DAY_S, &point_only());
        let turns = (f64::from(DAY_S) / period_s).floor();
        let back = 1e3 * length(minus(orbit.at(turns * period_s).0, start.0));
        let energy = |t: f64| {
            let (r, v) = orbit.at(t);
            0.5 * dot(v, v) - MU_EARTH / length(r)
        };
        let drift = (energy(f64::from(DAY_S)) / energy(0.0) - 1.0).abs();
        println!("{name}: {back:.6} m after {turns} turns, energy {drift:.1e}");
        assert!(back < 1e-3 && drift < 1e-11, "{name}");
    }
}

#[test]
fn a_field_that_turns_keeps_jacobis_integral() {
    // E - w . h about the pole of the start, which moves 0.2 arcsec in the day.
    let (r, v) = leo();
    let forces = Forces { sun: false, moon: false, ..quiet() };
    let orbit = fly_to(TOLERANCE_KM, (r, v), DAY_S, &forces);
    let field = Gravity::egm2008(20, 20);
    let pole = forces.orientation.gcrf_to_itrf(START_US)[2];
    let integral = |t: f64| {
        let (r, v) = orbit.at(t);
        let itrf = forces.orientation.gcrf_to_itrf(orbit.instant_us(t));
        // The angle of rotation gains 2 pi * 1.00273781191135448 a day.
        let rate = std::f64::consts::TAU * 1.002_737_811_911_354_5 / 86_400.0;
        0.5 * dot(v, v) - field.potential(apply(&itrf, r)) - rate * dot(pole, cross(r, v))
    };
    let worst =
        (1..=24).map(|k| (integral(f64::from(k) * 3600.0) / integral(0.0) - 1.0).abs()).fold(0.0, f64::max);
    println!("Jacobi's integral: {worst:.1e} of itself");
    assert!(worst < 1.5e-9, "{worst}");
}

#[test]
fn what_each_force_moves_a_low_orbit_in_a_day() {
    let start = leo();
    let all = Forces::default();
    let whole = fly_to(TOLERANCE_KM, start, DAY_S, &all);
    let moved = |name: &str, forces: &Forces| {
        let metres = apart_m(&whole, &fly_to(TOLERANCE_KM, start, DAY_S, forces), DAY_S);
        println!("| {name} | {metres:.1} |");
        metres
    };
    println!("| without | m in a day, 450 km, 100 kg, 1 m2 |");
    let field = |degree| Forces { gravity_degree: degree, gravity_order: degree, ..all.clone() };
    let zonal = Forces { gravity_degree: 2, gravity_order: 0, ..all.clone() };
    let j2 = moved("all of the field but point and J2", &zonal);
    let point = moved("all of the field but the point", &field(0));
    let four = moved("degrees above 4", &field(4));
    let ten = moved("degrees above 10", &field(10));
    let beyond = moved("degrees 21 to 36 (that is, with them)", &field(36));
    let sun = moved("the Sun", &Forces { sun: false, ..all.clone() });
    let moon = moved("the Moon", &Forces { moon: false, ..all.clone() });
    let drag = moved("drag", &Forces { drag: false, ..all.clone() });
    let light = moved("the Sun's light", &Forces { radiation_pressure: false, ..all.clone() });
    assert!(point > 1e5 && j2 < point && four < j2 && ten < four && beyond < ten);
    // Drag by hand: 3/2 n t² a with a = rho v² Cd A / 2 m, rho between 8e-13 and 4e-12 at 440 to 460 km.
    assert!((1e3..4e4).contains(&drag), "{drag}");
    assert!((1.0..300.0).contains(&sun) && (1.0..600.0).contains(&moon) && (1.0..100.0).contains(&light));
}

#[test]
fn drag_pulls_a_low_satellite_down_and_out() {
    let start = state_of_elements(CentralBody::Earth, [6518.0, 0.0, 51.6, 0.0, 0.0, 0.0]).unwrap();
    let heavy = Forces::default();
    let light = Forces { satellite: forces::Satellite { mass_kg: 5.0, ..heavy.satellite }, ..heavy };
    let refused = TruthOrbit::with_forces(START_US, start.0, start.1, DAY_S, &light).unwrap_err();
    assert!(matches!(refused, OrbitError::Ground(t, _) if t > 300.0 && t < 20_000.0), "{refused}");
}

#[test]
fn elements_give_a_state_that_has_them() {
    let (a, e, i) = (24_400.0, 0.7, 63.4f64);
    let (r, v) = state_of_elements(CentralBody::Earth, [a, e, i, 40.0, 270.0, 130.0]).unwrap();
    let momentum = cross(r, v);
    assert!((1.0 / (2.0 / length(r) - dot(v, v) / MU_EARTH) / a - 1.0).abs() < 1e-12);
    assert!((momentum[2] / length(momentum) - i.to_radians().cos()).abs() < 1e-12);
    let eccentricity = minus(times(1.0 / MU_EARTH, cross(v, momentum)), times(1.0 / length(r), r));
    assert!((length(eccentricity) - e).abs() < 1e-12);
    assert!((dot(eccentricity, r) / e / length(r) - 130f64.to_radians().cos()).abs() < 1e-12);
    // The node: where the orbit rises, at 40 deg.
    assert!((momentum[0] / -momentum[1] - 40f64.to_radians().tan()).abs() < 1e-12);
    // Perigee at 270 deg: south of the equator.
    assert!(eccentricity[2] < -0.6);
}

#[test]
fn impossible_orbits_are_refused_by_name() {
    let refused =
        |a, e| state_of_elements(CentralBody::Earth, [a, e, 0.0, 0.0, 0.0, 0.0]).unwrap_err().to_string();
    assert_eq!(refused(7000.0, 1.0), "eccentricity 1 is not that of an ellipse (0 to below 1)");
    assert_eq!(refused(7000.0, 0.1), "perigee at 6300.0 km from the centre is below 6478 km");
    assert_eq!(refused(-7000.0, 0.1), "semi-major axis -7000 km is not positive");
    assert_eq!(refused(f64::NAN, 0.1), "the semi-major axis is no number");
    assert!(refused(3e5, 0.8).starts_with("apogee at 540000 km"));
    let start = |r, v| TruthOrbit::new(START_US, r, v, 10).unwrap_err();
    assert_eq!(start([7000.0, 0.0, 0.0], [0.0, 12.0, 0.0]), OrbitError::Escape(12.0));
    assert!(matches!(start([7000.0, 0.0, 0.0], [0.0, 6.0, 0.0]), OrbitError::Perigee(..)));
    assert_eq!(TruthOrbit::new(START_US, geo().0, geo().1, u32::MAX), Err(OrbitError::Duration(u32::MAX)));
}

/// A file of the orbits among the test data; `None`, and a word about it, where there are none.
pub(super) fn data(name: &str) -> Option<String> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let root = std::env::var_os("SEXTANT_DATA").map_or_else(beside, PathBuf::from);
    let text = std::fs::read_to_string(root.join("orbits").join(name)).ok();
    if text.is_none() {
        println!("skipped: no data");
    }
    text
}

/// 2023-05-16 20:00 UTC.
const GMAT_START_US: i64 = 737_539_269_184_000;
/// EGM96 to degree and order 2, with its own attraction: the file's head names 398600.4418, but with that the
/// orbits drift away by 1.0 (LEO) and 0.4 m (GEO) a day, which is what twice the relative difference does to
/// the mean motion.
const EGM96: &str = "2 0 -0.484165371736E-03 0\n\
                     2 1 -0.186987635955E-09 0.119528012031E-08\n\
                     2 2 0.243914352398E-05 -0.140016683654E-05";
const GMAT_MU: f64 = 398_600.441_5;
/// The Earth over that week, IERS 20 C04.
const GMAT_WEEK: &str = "\
2023 5 16 0 60080.00 0.059198 0.492259 -0.0430984 0.000441 -0.000220
2023 5 17 0 60081.00 0.062118 0.493458 -0.0442928 0.000409 -0.000193
2023 5 18 0 60082.00 0.064521 0.494600 -0.0452544 0.000366 -0.000149
2023 5 19 0 60083.00 0.066912 0.495737 -0.0459063 0.000323 -0.000103
2023 5 20 0 60084.00 0.069379 0.496644 -0.0462641 0.000298 -0.000078
2023 5 21 0 60085.00 0.071673 0.497573 -0.0463853 0.000288 -0.000068
2023 5 22 0 60086.00 0.073665 0.498157 -0.0462514 0.000303 -0.000063
2023 5 23 0 60087.00 0.076186 0.498986 -0.0459896 0.000287 -0.000057
2023 5 24 0 60088.00 0.079186 0.500027 -0.0456668 0.000328 -0.000037
";

#[test]
fn another_programs_trajectories_are_met_with_its_forces() {
    for (name, limit_m) in [("geo_j2.json", 3.0), ("leo_iss_j2.json", 0.2)] {
        let Some(text) = data(name) else { continue };
        let file: serde_json::Value = serde_json::from_str(&text).unwrap();
        let samples: Vec<[f64; 7]> = serde_json::from_value(file["samples"].clone()).unwrap();
        let [_, x, y, z, u, v, w] = samples[0];
        let week = |orientation: EarthOrientation| {
            let forces = Forces { orientation, ..quiet() };
            let gravity = Gravity::of_table(GMAT_MU, EGM96, 2);
            let dynamics = Dynamics::new(GMAT_START_US, gravity, &forces);
            let orbit =
                TruthOrbit::fly(dynamics, [x, y, z], [u, v, w], 7 * DAY_S + 10, TOLERANCE_KM).unwrap();
            let apart = |s: &[f64; 7]| 1e3 * length(minus(orbit.at(s[0]).0, [s[1], s[2], s[3]]));
            let within = |end_s: f64| samples.iter().filter(|s| s[0] <= end_s).map(apart).fold(0.0, f64::max);
            (within(86_401.0), within(1e9))
        };
        let (day, seven) = week(EarthOrientation::read(GMAT_WEEK).unwrap());
        let (_, without) = week(EarthOrientation::default());
        println!("{name}: {day:.3} m in a day, {seven:.3} m in a week; with UT1 = UTC {without:.3} m");
        assert!(seven < limit_m, "{name}: {seven} m");
    }
}

/// `difference` along radius, flight and orbit normal of a state, m.
fn radial_along_cross(difference: Vector, (r, v): (Vector, Vector)) -> Vector {
    let (up, normal) = (unit(r), unit(cross(r, v)));
    [up, cross(normal, up), normal].map(|axis| 1e3 * dot(difference, axis))
}

#[test]
fn a_real_satellite_is_followed_for_a_day_from_its_first_state() {
    let (Some(text), Some(series)) = (data("jason2.sp3"), data("eopc04_excerpt.txt")) else { return };
    let orientation = EarthOrientation::read(&series).unwrap();
    let samples = sp3::read(&text, Some("L27")).unwrap();
    // An hour into the file, so that the interpolation is at its best.
    let start_us = samples.places[60].0;
    let real = TruthOrbit::along(&samples, start_us, DAY_S, &orientation).unwrap();
    // An error of 1 mm/s along flight moves the next day by 3 * 86,400 s * 1 mm/s = 260 m: the file's
    // velocity, rounded and 0.9 mm/s off the slope of its positions, misses by that; the slope itself is good
    // to some 0.05 mm/s. Jason-2: 506 kg, 9.5 m² of panels towards the Sun, some 5 m² across flight.
    let satellite =
        forces::Satellite { mass_kg: 506.0, drag_area_m2: 5.0, cd: 2.2, radiation_area_m2: 10.0, cr: 1.3 };
    // The velocity of the file, m/s in turning axes.
    let turn = orientation.gcrf_to_itrf(start_us);
    let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("VL27")).collect();
    let numbers: Vec<f64> =
        lines[60].split_whitespace().skip(1).map(|field| field.parse().unwrap()).collect();
    let in_itrf = times(1e-3, [numbers[0], numbers[1], numbers[2]]);
    let (r, v) = real.at(0.0);
    let carried = times(crate::world::time::ephemeris::EARTH_RATE_RAD_S, cross(turn[2], r));
    let of_file = plus(apply(&transposed(&turn), in_itrf), 1.0, carried);
    println!("velocity: interpolated less file {:.3} mm/s", 1e6 * length(minus(v, of_file)));
    for (name, velocity, degree, limits) in [
        ("file's velocity, 20 x 20", of_file, 20, [10.0, 400.0, 12.0]),
        ("interpolated velocity, 20 x 20", v, 20, [5.0, 25.0, 12.0]),
        ("interpolated velocity, 36 x 36", v, 36, [5.0, 20.0, 12.0]),
    ] {
        let forces = Forces {
            gravity_degree: degree,
            gravity_order: degree,
            satellite,
            orientation: orientation.clone(),
            ..Forces::default()
        };
        let flown = TruthOrbit::with_forces(start_us, r, velocity, DAY_S, &forces).unwrap();
        let mut worst = [0.0f64; 3];
        for t in (0..=DAY_S).step_by(60).map(f64::from) {
            let parts = radial_along_cross(minus(flown.at(t).0, real.at(t).0), real.at(t));
            worst = [0, 1, 2].map(|k| worst[k].max(parts[k].abs()));
        }
        println!("{name}: radial {:.1}, along {:.1}, cross {:.1} m in a day", worst[0], worst[1], worst[2]);
        assert!((0..3).all(|k| worst[k] < limits[k]), "{worst:?}");
    }
}
