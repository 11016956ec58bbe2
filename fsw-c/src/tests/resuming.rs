//! A second that takes up what was known before a restart.

use super::world::{Memory, POWER_ON_US, World, encoded, fly, init, parameters, tables};
use crate::doors::Bytes;
use crate::memory::SensorMemory;
use crate::status::Status;
use crate::*;
use fsw_core::telemetry::{self, MOTION_CORRELATIONS, OrbitReport, Report};
use std::vec::Vec;

const MISALIGNMENT_RAD: [f32; 3] = [1e-4, -2e-4, 5e-5];
const SIGMA_RAD: [f32; 3] = [1e-5, 2e-5, 4e-5];
const RADIUS_KM: f64 = 7000.0;
/// Of a circle about the Earth.
const RATE_RAD_S: f64 = 1.078_007e-3;

/// Telemetry of so many seconds before power-on: a circle in the equator's plane.
fn kept(age_s: i64) -> Vec<u8> {
    let orbit = OrbitReport {
        position_km: [RADIUS_KM, 0.0, 0.0],
        velocity_km_s: [0.0, RADIUS_KM * RATE_RAD_S, 0.0],
        sigma_position_km: [3.0, 4.0, 2.0],
        sigma_velocity_km_s: [0.003, 0.004, 0.002],
        correlations: [0.0; MOTION_CORRELATIONS],
        sigma_hill_km: [3.0, 4.0, 2.0],
        elements: None,
        limb_height_km: 0.0,
        limb_height_sigma_km: 0.5,
        misalignment_rad: MISALIGNMENT_RAD,
        misalignment_sigma_rad: SIGMA_RAD,
        nis: None,
        nis_freedom: 0,
        since_fix_s: 20,
        settled: true,
    };
    let instant_us = Some(POWER_ON_US - age_s * 1_000_000);
    let report = Report { instant_us, orbit: Some(orbit), ..Report::default() };
    telemetry::encode_next(&report, &mut [0; TELEMETRY_BYTES]).unwrap().to_vec()
}

fn resume(sensor: *mut SensorMemory, kept: Bytes) -> Status {
    // SAFETY: a sensor, bytes that last or are refused.
    unsafe { sextant_resume(sensor, kept) }
}

fn bytes(kept: &[u8]) -> Bytes {
    Bytes { data: kept.as_ptr(), length: kept.len() }
}

#[test]
fn orbit_and_mounting_of_before_a_restart_go_on() {
    const AGE_S: i64 = 600;
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    assert_eq!(resume(sensor, bytes(&kept(AGE_S))), Status::Ok);
    // The gap is crossed over some seconds.
    let (_, result) = fly(sensor, &mut world, 3);
    let orbit = result.orbit;
    assert!(orbit.known);
    assert_eq!(orbit.misalignment_rad, MISALIGNMENT_RAD);
    for (told, before) in orbit.misalignment_sigma_rad.iter().zip(SIGMA_RAD) {
        assert!((told / before - 1.0).abs() < 1e-5, "{told} of {before}");
    }
    let turned = RATE_RAD_S * (AGE_S as f64 + result.local_us as f64 * 1e-6);
    let circle = [RADIUS_KM * turned.cos(), RADIUS_KM * turned.sin(), 0.0];
    let off = orbit.position_km.iter().zip(circle).map(|(one, other)| (one - other).powi(2)).sum::<f64>();
    // J2 moves it by less than 3/2 J2 (R/r)^2 of its way, and radially as much again.
    assert!(off.sqrt() < 2.0 * 1.5 * 1.083e-3 * turned * RADIUS_KM, "{} km", off.sqrt());
}

#[test]
fn an_orbit_older_than_two_hours_is_forgotten_and_the_seconds_are_flown() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    assert_eq!(resume(sensor, bytes(&kept(7201))), Status::Ok);
    let (_, result) = fly(sensor, &mut world, 3);
    assert_eq!((result.cycle, result.orbit.known), (2, false));
}

#[test]
fn safe_that_was_commanded_goes_on_without_an_orbit_too() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    let safe = Report { mode: fsw_core::modes::Mode::CommandedSafe, ..Report::default() };
    let frame = telemetry::encode_next(&safe, &mut [0; TELEMETRY_BYTES]).unwrap().to_vec();
    assert_eq!(resume(sensor, bytes(&frame)), Status::Ok);
    let (_, result) = fly(sensor, &mut world, 70);
    assert_eq!(result.mode, results::Mode::CommandedSafe);
}

#[test]
fn what_is_no_frame_with_an_orbit_is_refused_and_nothing_changed() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    let (stream, _) = fly(sensor, &mut world, 1);
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    let good = kept(60);
    let (mut turned, mut version) = (good.clone(), good.clone());
    turned[40] ^= 4;
    version[2] += 1;
    let nothing = Bytes { data: core::ptr::null(), length: 0 };
    let null = Bytes { data: core::ptr::null(), length: 9 };
    for (kept, refusal) in [
        (bytes(&turned), Status::Kept),
        (bytes(&version), Status::Kept),
        (bytes(&good[..good.len() - 1]), Status::Kept),
        (bytes(&good[..1]), Status::Kept),
        (bytes(&stream), Status::Kept),
        (nothing, Status::Kept),
        (null, Status::Null),
    ] {
        assert_eq!(resume(sensor, kept), refusal);
    }
    assert_eq!(resume(core::ptr::null_mut(), bytes(&good)), Status::Null);
    let (_, result) = fly(sensor, &mut world, 2);
    assert!(!result.orbit.known);
    // After the first second it comes too late.
    assert_eq!(resume(sensor, bytes(&good)), Status::Kept);
    assert!(!fly(sensor, &mut world, 2).1.orbit.known);
}
