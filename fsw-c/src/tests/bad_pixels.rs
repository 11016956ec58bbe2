//! Bad pixels that are given with the tables.

use super::world::{
    GEOMETRY, HalWorld, Memory, Outputs, POWER_ON_US, World, encoded, fly, init, is_hot, parameters, tables,
};
use crate::doors::Bytes;
use crate::status::Status;
use crate::*;
use fsw_core::catalog::Catalogue;
use fsw_core::checksum::crc32;
use fsw_core::image::bad_pixels::BadPixelDetector;
use fsw_core::image::defects::{CRC_FROM, Defects, HEADER_BYTES, MAGIC, VERSION};
use fsw_core::parameters::Parameters;
use fsw_core::sensor;
use fsw_core::telemetry;
use fsw_hal::{Instant, LocalTime};
use std::boxed::Box;
use std::vec::Vec;

const SECONDS: i64 = 4;

/// The file of the world's hot pixels, of a detector of some size.
fn file(width: u16, height: u16) -> Vec<u8> {
    let columns = |y| (0..width).filter(move |x| is_hot(*x, y));
    let (mut starts, mut pixels) = (Vec::from([0u16]), Vec::new());
    for y in 0..height {
        pixels.extend(columns(y));
        starts.push(pixels.len() as u16);
    }
    let words = |words: &[u16]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>();
    let lists = [words(&starts), words(&pixels)].concat();
    let head = [width, height, 0, pixels.len() as u16, 0, 0];
    let total = (HEADER_BYTES + lists.len()) as u32;
    let checked = [&total.to_le_bytes()[..], &words(&head), &lists].concat();
    let begin = words(&[VERSION, HEADER_BYTES as u16]);
    let bytes = [&MAGIC[..], &begin, &crc32(&checked).to_le_bytes(), &checked].concat();
    assert_eq!(bytes.len() - checked.len(), CRC_FROM);
    bytes
}

/// The file of the tests' detector.
pub fn whole() -> Vec<u8> {
    file(GEOMETRY.width_px, GEOMETRY.height_px)
}

fn bytes(of: &[u8]) -> Bytes {
    Bytes { data: of.as_ptr(), length: of.len() }
}

/// Seconds of a world with hot pixels by C, with this file; their telemetry.
fn flown(file: &[u8]) -> Vec<u8> {
    let (memory, mut world) = (Memory::new(), World::new());
    world.hot = true;
    let table = encoded(&parameters());
    let (status, sensor) = init(&memory, &SensorTables { bad_pixels: bytes(file), ..tables(&table) });
    assert_eq!(status, Status::Ok);
    fly(sensor, &mut world, SECONDS).0
}

#[test]
fn bad_pixels_are_corrected_as_they_are_in_rust() {
    let file = whole();
    let corrected = flown(&file);
    assert_ne!(corrected, flown(&[]), "hot pixels are seen");

    let parameters = Parameters { rate_sensor: None, ..parameters() };
    let mut workspace = Box::new(sensor::Workspace::new());
    // SAFETY: the bytes are static.
    let catalogue = Catalogue::open(unsafe { sextant_reference_catalogue().slice() }.unwrap()).unwrap();
    let mut flight = sensor::Sensor::new(catalogue, parameters, &mut workspace).unwrap();
    let (mut expected, mut raw) = (Vec::new(), HalWorld(World::new()));
    raw.0.hot = true;
    for second in 0..SECONDS {
        raw.0.second = second;
        let local_us = raw.0.local_us();
        let report = flight.cycle(
            &mut sensor::Instruments {
                detector: &mut BadPixelDetector::new(&mut raw, Defects::open(&file).unwrap()).unwrap(),
                clock: &mut Instant::new(LocalTime::from_us(local_us), POWER_ON_US + local_us),
                meter: &mut (),
                rate_sensor: &mut (),
                magnetometer: &mut (),
                shutter: &mut (),
            },
            sensor::Command::Continue,
        );
        expected.extend_from_slice(telemetry::encode_next(&report, &mut [0; TELEMETRY_BYTES]).unwrap());
    }
    let (memory, mut world) = (Memory::new(), World::new());
    world.hot = true;
    let table = encoded(&parameters);
    let (_, sensor) = init(&memory, &SensorTables { bad_pixels: bytes(&file), ..tables(&table) });
    assert_eq!(fly(sensor, &mut world, SECONDS).0, expected);
}

#[test]
fn bad_pixels_that_are_damaged_or_of_another_detector_are_refused() {
    let memory = Memory::new();
    let table = encoded(&parameters());
    let whole = whole();
    let (mut damaged, mut version) = (whole.clone(), whole.clone());
    *damaged.last_mut().unwrap() ^= 1;
    version[MAGIC.len()] += 1;
    let other = file(GEOMETRY.width_px, GEOMETRY.height_px - 1);
    for (file, why) in [
        (&damaged[..], Status::BadPixelsDamaged),
        (&whole[..whole.len() - 1], Status::BadPixelsDamaged),
        (&table[..], Status::BadPixelsDamaged),
        (&version[..], Status::BadPixelsVersion),
        (&other[..], Status::BadPixelsMismatch),
    ] {
        let (status, sensor) = init(&memory, &SensorTables { bad_pixels: bytes(file), ..tables(&table) });
        assert!(status == why && sensor.is_null() && memory.is_untouched(), "{status:?}, not {why:?}");
    }
    // Bytes that do not last: in the sensor's own memory.
    let inside = Bytes { data: memory.place().cast(), length: 40 };
    assert_eq!(init(&memory, &SensorTables { bad_pixels: inside, ..tables(&table) }).0, Status::Overlap);
}

#[test]
fn a_second_with_a_detector_of_another_size_than_its_bad_pixels_is_refused() {
    let (memory, mut world) = (Memory::new(), World::new());
    let (table, file) = (encoded(&parameters()), whole());
    let (_, sensor) = init(&memory, &SensorTables { bad_pixels: bytes(&file), ..tables(&table) });
    let mut instruments = world.instruments();
    instruments.detector.geometry.width_px -= 1;
    let mut outputs = Outputs::new();
    // SAFETY: a sensor and whole instruments.
    assert_eq!(unsafe { outputs.cycle(sensor, &instruments, 0) }, Status::Instruments);
    assert_eq!(fly(sensor, &mut world, 1).1.cycle, 0, "nothing was flown before");
}
