//! The calls as C makes them.

mod bad_pixels;
mod link;
mod resuming;
mod spoilt;
mod world;

use crate::doors::Bytes;
use crate::instruments::Reply;
use crate::results::{CycleResult, FAULT_CLOCK, FAULT_DETECTOR, Mode, Outcome};
use crate::status::Status;
use crate::*;
use core::ffi::CStr;
use core::ptr::{null, null_mut};
use fsw_core::catalog::Catalogue;
use fsw_core::image::calibration::Calibration;
use fsw_core::parameters::Parameters;
use fsw_core::sensor;
use fsw_core::telemetry;
use fsw_hal::{
    AngularRate, Clock as _, ClockError, Detector as _, DetectorError, Instant, LocalTime, Magnetometer as _,
    OpenPaths, RateSensor as _, ReadingError, Shutter as _, ShutterError,
};
use std::boxed::Box;
use std::vec::Vec;
use world::{HalWorld, Memory, Outputs, POWER_ON_US, World, encoded, fly, init, parameters, tables};

#[test]
fn seconds_flown_by_c_give_the_telemetry_of_rust() {
    let parameters = Parameters { rate_sensor: None, ..parameters() };
    let (memory, mut world) = (Memory::new(), World::new());
    let (status, sensor) = init(&memory, &tables(&encoded(&parameters)));
    assert_eq!(status, Status::Ok);
    let (stream, result) = fly(sensor, &mut world, 4);

    let mut workspace = Box::new(sensor::Workspace::new());
    // SAFETY: the bytes are static.
    let catalogue = unsafe { sextant_reference_catalogue().slice() }.unwrap();
    let catalogue = Catalogue::open(catalogue).unwrap();
    let mut flight = sensor::Sensor::new(catalogue, parameters, &mut workspace).unwrap();
    let (mut expected, mut detector) = (Vec::new(), HalWorld(World::new()));
    let mut last = telemetry::Report::default();
    for second in 0..4 {
        detector.0.second = second;
        let local_us = detector.0.local_us();
        let clock = &mut Instant::new(LocalTime::from_us(local_us), POWER_ON_US + local_us);
        let mut instruments = sensor::Instruments {
            detector: &mut detector,
            clock,
            meter: &mut (),
            rate_sensor: &mut (),
            magnetometer: &mut (),
            shutter: &mut (),
        };
        last = flight.cycle(&mut instruments, sensor::Command::Continue);
        expected.extend_from_slice(telemetry::encode_next(&last, &mut [0; TELEMETRY_BYTES]).unwrap());
    }
    assert_eq!(stream, expected);
    assert_eq!(result, CycleResult::from(&last));
    assert_eq!((result.cycle, result.mode), (3, Mode::Acquisition));
    assert_eq!(result.outcome, Outcome::NotIdentified);
    let [begun, ended] = world.marks;
    assert!(begun == ended && begun > 4);
}

#[test]
fn a_cycle_that_took_too_long_is_told_by_the_next_one() {
    let parameters = encoded(&parameters());
    let memory = Memory::new();
    let (_, sensor) = init(&memory, &tables(&parameters));
    let mut world = World::new();
    let mut overran = |late: bool| {
        world.late = late;
        let (stream, _) = fly(sensor, &mut world, 1);
        let report = telemetry::decode(telemetry::split_first(&stream).unwrap().0).unwrap();
        report.events.contains(&telemetry::Event::Overran)
    };
    assert_eq!([false, true, false].map(&mut overran), [false, true, false]);
}

#[test]
fn a_failing_instrument_is_told_in_the_result() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    world.clock = Reply::NotSynchronised as u32;
    assert_eq!(fly(sensor, &mut world, 1).1.faults, FAULT_CLOCK);
    // Any number that is no reply is a failed link.
    for reply in [Reply::Bus as u32, Reply::Timeout as u32, 1000] {
        (world.clock, world.reading) = (Reply::Ok as u32, reply);
        let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
        assert_eq!(fly(sensor, &mut world, 1).1.faults, FAULT_DETECTOR);
    }
    let _ = sensor;
}

#[test]
fn every_reply_is_an_error_of_its_instrument_and_any_other_number_a_failed_link() {
    let mut world = World::new();
    let instruments = world.instruments();
    // SAFETY: the callbacks are whole and the world lasts.
    let (mut detector, mut clock, mut gyro, mut magnetometer, _, mut shutter) = unsafe { instruments.lend() };
    let answer = |reply: u32| {
        // SAFETY: the context is the world, which nobody else uses meanwhile.
        let world = unsafe { world::world(instruments.detector.context) };
        (world.reading, world.clock, world.rate, world.shutter) = (reply, reply, reply, reply);
        world.open
    };
    let (window, mut pixel) = (fsw_hal::Window { x: 0, y: 0, width: 1, height: 1 }, [0]);
    for (reply, of_detector, of_clock, of_reading, of_shutter) in [
        (
            Reply::Timeout as u32,
            DetectorError::Timeout,
            ClockError::Timeout,
            ReadingError::Timeout,
            ShutterError::Timeout,
        ),
        (Reply::Bus as u32, DetectorError::Bus, ClockError::Bus, ReadingError::Bus, ShutterError::Bus),
        (
            Reply::NotExposed as u32,
            DetectorError::NotExposed,
            ClockError::Bus,
            ReadingError::Bus,
            ShutterError::Bus,
        ),
        (
            Reply::Exposure as u32,
            DetectorError::Exposure,
            ClockError::Bus,
            ReadingError::Bus,
            ShutterError::Bus,
        ),
        (
            Reply::NotSynchronised as u32,
            DetectorError::Bus,
            ClockError::NotSynchronised,
            ReadingError::Bus,
            ShutterError::Bus,
        ),
        (
            Reply::Saturated as u32,
            DetectorError::Bus,
            ClockError::Bus,
            ReadingError::Saturated,
            ShutterError::Bus,
        ),
        (Reply::Stuck as u32, DetectorError::Bus, ClockError::Bus, ReadingError::Bus, ShutterError::Stuck),
        (u32::MAX, DetectorError::Bus, ClockError::Bus, ReadingError::Bus, ShutterError::Bus),
    ] {
        answer(reply);
        assert_eq!(detector.read(window, &mut pixel), Err(of_detector));
        assert_eq!(clock.terrestrial_us(LocalTime::default()), Err(of_clock));
        assert_eq!(gyro.angular_rate(), Err(of_reading));
        assert_eq!(magnetometer.magnetic_field(), Err(of_reading));
        assert_eq!(shutter.open(OpenPaths::Star), Err(of_shutter));
    }
    answer(Reply::NoReading as u32);
    assert_eq!((gyro.angular_rate(), magnetometer.magnetic_field()), (Ok(None), Ok(None)));
    assert_eq!(answer(Reply::Ok as u32), Some([true, false, false]));
    assert_eq!(shutter.open(OpenPaths::Earth), Ok(()));
    assert_eq!(answer(Reply::Ok as u32), Some([false, true, false]));
    assert_eq!(shutter.open(OpenPaths::BothClear), Ok(()));
    assert_eq!(answer(Reply::Ok as u32), Some([true, true, true]));
    let instant = LocalTime::from_us(50_000);
    assert_eq!(gyro.angular_rate(), Ok(Some(AngularRate { instant, rad_s: [1.0, 2.0, 3.0] })));
    // What does not fit is refused before the callback could write beyond the pixels.
    let beyond = fsw_hal::Window { x: 320, ..window };
    assert_eq!(detector.read(beyond, &mut pixel), Err(DetectorError::OutsideDetector));
    assert_eq!(detector.read(window, &mut [0; 2]), Err(DetectorError::BufferLength));
}

#[test]
fn zeroed_memory_is_an_empty_workspace() {
    let zeroed = Box::<sensor::Workspace>::new_zeroed();
    // SAFETY: what this test is about: all of it are numbers, and the variant and lengths 0 are valid.
    let zeroed = unsafe { zeroed.assume_init() };
    let empty = Box::new(sensor::Workspace::new());
    assert_eq!(std::format!("{zeroed:?}"), std::format!("{empty:?}"));
}

#[test]
fn a_sensor_in_a_cycle_refuses_calls_and_flies_on() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
    (world.nested, world.table) = (sensor, encoded(&parameters()));
    let (_, result) = fly(sensor, &mut world, 2);
    assert_eq!((world.nested_init, world.nested_cycle), (Status::Busy, Status::Busy));
    assert_eq!((result.cycle, result.faults), (1, 0));
}

#[test]
fn a_sensor_that_was_copied_and_memory_without_one_are_refused() {
    let (memory, mut world) = (Memory::new(), World::new());
    assert_eq!(init(&memory, &tables(&encoded(&parameters()))).0, Status::Ok);
    let (copy, empty) = (memory.copy(), Memory::new());
    for place in [copy.place(), empty.place()] {
        // SAFETY: memory of a sensor's length.
        let status = unsafe { Outputs::new().cycle(place.cast(), &world.instruments(), 0) };
        assert_eq!(status, Status::NotASensor);
    }
}

#[test]
fn refused_tables_leave_the_sensor_with_its_old_ones() {
    let (memory, mut world) = (Memory::new(), World::new());
    let good = encoded(&parameters());
    let (_, sensor) = init(&memory, &tables(&good));
    fly(sensor, &mut world, 3);

    let mut version = good.clone();
    version[0] ^= 1;
    let length = version.len() - 4;
    let crc = fsw_core::checksum::crc32(&version[..length]);
    version[length..].copy_from_slice(&crc.to_le_bytes());
    let mut damaged = good.clone();
    damaged[10] ^= 1;
    let mut beyond = parameters();
    beyond.imaging.exposure_us = 0;
    let mut other_lens = parameters();
    // SAFETY: the bytes are static.
    let calibration = Calibration::open(unsafe { sextant_reference_calibration().slice() }.unwrap()).unwrap();
    other_lens.imaging.calibration_crc = calibration.crc();
    let (beyond, other_lens) = (encoded(&beyond), encoded(&other_lens));
    let none = Bytes { data: null(), length: 0 };
    static NOT_A_TABLE: &[u8] = &[7; 400];

    let refused = [
        (tables(&version), Status::ParametersVersion),
        (tables(&damaged), Status::ParametersDamaged),
        (tables(&[]), Status::ParametersDamaged),
        (tables(&beyond), Status::ParametersRange),
        (tables(&other_lens), Status::CalibrationMismatch),
        (SensorTables { calibration: none, ..tables(&other_lens) }, Status::CalibrationMismatch),
        (
            SensorTables { calibration: Bytes::of(NOT_A_TABLE), ..tables(&other_lens) },
            Status::CalibrationDamaged,
        ),
        (SensorTables { catalogue: Bytes::of(NOT_A_TABLE), ..tables(&good) }, Status::CatalogueDamaged),
        (SensorTables { catalogue: none, ..tables(&good) }, Status::CatalogueDamaged),
        (SensorTables { catalogue: Bytes { length: 9, ..none }, ..tables(&good) }, Status::Null),
    ];
    for (tables, status) in refused {
        assert_eq!(init(&memory, &tables), (status, null_mut()));
    }
    world.second = 3;
    let mut outputs = Outputs::new();
    // SAFETY: a sensor and whole instruments.
    assert_eq!(unsafe { outputs.cycle(sensor, &world.instruments(), 0) }, Status::Ok);
    assert_eq!(outputs.result.cycle, 3);
    // A calibration that the table does not name is not looked at.
    let unused = SensorTables { calibration: Bytes::of(NOT_A_TABLE), ..tables(&good) };
    assert_eq!(init(&memory, &unused).0, Status::Ok);
}

#[test]
fn outputs_within_the_sensor_or_one_another_are_refused() {
    let (memory, mut world) = (Memory::new(), World::new());
    let table = encoded(&parameters());
    let (_, sensor) = init(&memory, &tables(&table));
    let (instruments, mut outputs) = (world.instruments(), Outputs::new());
    let inside = memory.place().wrapping_byte_add(1024);
    let (telemetry, length) = (outputs.telemetry.as_mut_ptr(), &raw mut outputs.length);
    let result = &raw mut outputs.result;
    let cases = [
        (inside.cast(), length, result),
        (telemetry, inside.cast(), result),
        (telemetry, length, inside.cast()),
        (telemetry, result.cast(), result),
        (result.cast(), length, result),
    ];
    for (telemetry, length, result) in cases {
        // SAFETY: what overlaps is refused before it is written.
        let status =
            unsafe { sextant_cycle(sensor, &instruments, 0, telemetry, TELEMETRY_BYTES, length, result) };
        assert_eq!(status, Status::Overlap);
    }
    let within = Bytes { data: inside.cast(), length: 100 };
    assert_eq!(init(&memory, &SensorTables { catalogue: within, ..tables(&table) }).0, Status::Overlap);
    // SAFETY: as above.
    let status = unsafe { sextant_init(memory.place(), SENSOR_BYTES, &tables(&table), inside.cast()) };
    assert_eq!(status, Status::Overlap);
    assert_eq!(fly(sensor, &mut world, 1).1.cycle, 0);
}

#[test]
fn the_version_is_that_of_the_package() {
    // SAFETY: a static string.
    let version = unsafe { CStr::from_ptr(sextant_version()) };
    assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
}
