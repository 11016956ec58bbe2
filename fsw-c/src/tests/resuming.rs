//! A second that takes up what was known before a restart.

use super::world::{Memory, Outputs, POWER_ON_US, World, encoded, fly, init, parameters, tables};
use crate::doors::Bytes;
use crate::memory::SensorMemory;
use crate::results::CommandResult;
use crate::status::Status;
use crate::*;
use fsw_core::command::Refusal;
use fsw_core::telemetry::{self, MOTION_CORRELATIONS, OrbitReport, Report};
use std::vec::Vec;

const MISALIGNMENT_RAD: [f32; 3] = [1e-4, -2e-4, 5e-5];
const SIGMA_RAD: [f32; 3] = [1e-5, 2e-5, 4e-5];
const RADIUS_KM: f64 = 7000.0;
/// Of a circle about the Earth.
const RATE_RAD_S: f64 = 1.078_007e-3;

/// Telemetry of so many seconds before power-on: a circle in the equator's plane.
fn kept(age_s: i64) -> Vec<u8> {
    kept_with(age_s, SIGMA_RAD)
}

fn kept_with(age_s: i64, misalignment_sigma_rad: [f32; 3]) -> Vec<u8> {
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
        misalignment_sigma_rad,
        nis: None,
        nis_freedom: 0,
        since_fix_s: 20,
        settled: true,
    };
    let instant_us = Some(POWER_ON_US - age_s * 1_000_000);
    let report = Report { instant_us, orbit: Some(orbit), ..Report::default() };
    telemetry::encode_next(&report, &mut [0; TELEMETRY_BYTES]).unwrap().to_vec()
}

fn resume(sensor: *mut SensorMemory, world: &mut World, kept: Bytes) -> (Status, Outputs) {
    let mut outputs = Outputs::new();
    let instruments = world.instruments();
    let (telemetry, length) = (outputs.telemetry.as_mut_ptr(), &raw mut outputs.length);
    let result = &raw mut outputs.result;
    // SAFETY: a sensor, whole instruments, bytes that last, outputs of the right lengths.
    let status = unsafe {
        sextant_cycle_resumed(sensor, kept, &instruments, telemetry, TELEMETRY_BYTES, length, result)
    };
    world.second += 1;
    (status, outputs)
}

fn bytes(kept: &[u8]) -> Bytes {
    Bytes { data: kept.as_ptr(), length: kept.len() }
}

#[test]
fn orbit_and_mounting_of_before_a_restart_go_on() {
    const AGE_S: i64 = 600;
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    let (_, first) = fly(sensor, &mut world, 1);
    assert!(!first.orbit.known && first.terrestrial_us > 0);

    let (status, Outputs { result, .. }) = resume(sensor, &mut world, bytes(&kept(AGE_S)));
    assert_eq!((status, result.command), (Status::Ok, CommandResult::Done));
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
fn an_orbit_older_than_a_hundred_minutes_is_refused_and_the_second_is_flown() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    fly(sensor, &mut world, 1);
    let (status, Outputs { result, .. }) = resume(sensor, &mut world, bytes(&kept(6001)));
    assert_eq!((status, result.command), (Status::Ok, CommandResult::Refused));
    assert_eq!(result.refusal, u32::from(Refusal::Epoch.code()));
    assert_eq!((result.cycle, result.orbit.known), (1, false));
}

#[test]
fn what_is_no_frame_with_an_orbit_is_refused_and_nothing_flown() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    let (stream, _) = fly(sensor, &mut world, 1);
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
        assert_eq!(resume(sensor, &mut world, kept).0, refusal);
    }
    let (status, Outputs { result, .. }) = resume(sensor, &mut world, bytes(&good));
    assert_eq!((status, result.cycle, result.command), (Status::Ok, 1, CommandResult::Done));
}

#[test]
fn instruments_that_are_refused_leave_the_mounting_as_it_was() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    fly(sensor, &mut world, 1);
    let (good, mut outputs) = (kept(60), Outputs::new());
    let mut spoilt = world.instruments();
    spoilt.detector.read = None;
    let (telemetry, length) = (outputs.telemetry.as_mut_ptr(), &raw mut outputs.length);
    let result = &raw mut outputs.result;
    for (instruments, refusal) in
        [(&raw const spoilt, Status::Instruments), (core::ptr::null(), Status::Null)]
    {
        // SAFETY: a sensor, bytes that last, outputs of the right lengths; the instruments are refused.
        let status = unsafe {
            sextant_cycle_resumed(
                sensor,
                bytes(&good),
                instruments,
                telemetry,
                TELEMETRY_BYTES,
                length,
                result,
            )
        };
        assert_eq!(status, refusal);
    }
    // A mounting without a sigma is none: the orbit begins with what is known of it, which is nothing.
    let (status, _) = resume(sensor, &mut world, bytes(&kept_with(60, [0.0; 3])));
    assert_eq!(status, Status::Ok);
    assert_eq!(fly(sensor, &mut world, 3).1.orbit.misalignment_rad, [0.0; 3]);
}
