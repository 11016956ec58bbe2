//! Arguments spoilt at random: refused, with nothing flown and nothing written.

use super::bad_pixels;
use super::world::{Memory, Outputs, World, encoded, fly, init, parameters, tables};
use crate::doors::Bytes;
use crate::instruments::{Magnetometer, Meter, RateSensor};
use crate::status::Status;
use crate::*;
use core::ptr::null_mut;
use fsw_core::image::calibration::Calibration;
use proptest::prelude::*;

/// A pointer that may be null or off by a byte.
fn spoilt<T>(pointer: *mut T, how: u8) -> *mut T {
    match how {
        0 => null_mut(),
        1 => pointer.wrapping_byte_add(1),
        _ => pointer,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn spoilt_arguments_of_init_are_refused(
        [memory_is, tables_is, sensor_is] in [0u8..6, 0u8..6, 0u8..6],
        bytes in prop_oneof![0..sextant_sensor_bytes() * 2, Just(usize::MAX), Just(SENSOR_BYTES)],
        parameters_length in 0usize..600,
    ) {
        let (memory, table) = (Memory::new(), encoded(&parameters()));
        let (good, mut sensor) = (tables(&table), null_mut());
        let lengths = parameters_length.min(table.len());
        let mut given = SensorTables { parameters: Bytes { length: lengths, ..good.parameters }, ..good };
        let place = spoilt(memory.place(), memory_is);
        let (tables, handle) = (spoilt(&raw mut given, tables_is), spoilt(&raw mut sensor, sensor_is));
        let bytes = if memory_is == 1 { bytes.min(SENSOR_BYTES - 1) } else { bytes };
        // SAFETY: what is null, misaligned or of a wrong length is refused; the rest is sound.
        let status = unsafe { sextant_init(place, bytes, tables, handle) };
        let spoilt = [memory_is, tables_is, sensor_is];
        let sound = !spoilt.contains(&0) && !spoilt.contains(&1);
        let long_enough = (sextant_sensor_bytes()..=isize::MAX as usize).contains(&bytes);
        let expected = sound && long_enough && lengths == table.len();
        prop_assert_eq!(status == Status::Ok, expected);
        prop_assert_eq!(sensor.is_null(), !expected);
        if !expected {
            prop_assert!(memory.is_untouched(), "untouched");
        }
        if sound && long_enough && !expected {
            prop_assert_eq!(status, Status::ParametersDamaged);
        }
    }

    #[test]
    fn spoilt_arguments_of_cycle_are_refused(
        [sensor_is, instruments_is, telemetry_is, length_is, result_is] in prop::array::uniform5(0u8..8),
        bytes in prop_oneof![Just(TELEMETRY_BYTES), 0..TELEMETRY_BYTES, Just(usize::MAX)],
        command in prop_oneof![0u32..4, any::<u32>()],
        missing in 0usize..11,
        bits in prop_oneof![Just(10u8), any::<u8>()],
    ) {
        let (memory, mut world, mut outputs) = (Memory::new(), World::new(), Outputs::new());
        let (_, sensor) = init(&memory, &tables(&encoded(&parameters())));
        let mut instruments = world.instruments();
        instruments.detector.geometry.bits = bits;
        match missing {
            0 => instruments.detector.start_exposure = None,
            1 => instruments.detector.finish_exposure = None,
            2 => instruments.detector.read = None,
            3 => instruments.clock.local_time = None,
            4 => instruments.clock.terrestrial_time = None,
            5 => instruments.detector.geometry.width_px = 0,
            6 => instruments.detector.geometry.height_px = 0,
            7 => instruments.meter = Meter { context: null_mut(), begin: None, end: None, overran: None },
            8 => instruments.rate_sensor = RateSensor { context: null_mut(), angular_rate: None },
            9 => instruments.magnetometer = Magnetometer { context: null_mut(), magnetic_field: None },
            _ => {}
        }
        // One byte off is no fault of bytes.
        let telemetry_is = if telemetry_is == 1 { 2 } else { telemetry_is };
        let telemetry = spoilt(outputs.telemetry.as_mut_ptr(), telemetry_is);
        let (length, result) = (&raw mut outputs.length, &raw mut outputs.result);
        // SAFETY: what is null, misaligned, missing or of a wrong length is refused; the rest is sound.
        let status = unsafe {
            sextant_cycle(
                spoilt(sensor, sensor_is),
                spoilt(&raw mut instruments, instruments_is),
                command,
                telemetry,
                bytes,
                spoilt(length, length_is),
                spoilt(result, result_is),
            )
        };
        let places = [sensor_is, instruments_is, telemetry_is, length_is, result_is];
        let sound = !places.contains(&0) && !places.contains(&1);
        let whole = missing > 6 && (1..=16).contains(&bits);
        let expected = sound && whole && command < 4 && bytes == TELEMETRY_BYTES;
        prop_assert_eq!(status == Status::Ok, expected, "{:?}", status);
        prop_assert_eq!(outputs.length > 0, expected);
        if !expected {
            prop_assert!(outputs.telemetry.iter().all(|byte| *byte == 0xA5), "untouched");
            world.second = 7;
            prop_assert_eq!(fly(sensor, &mut world, 1).1.cycle, 0, "not flown");
        }
    }

    #[test]
    fn damaged_tables_are_refused(at in any::<prop::sample::Index>(), flip in 1u8..=255, which in 0u8..4) {
        let memory = Memory::new();
        let mut parameters = parameters();
        // SAFETY: the bytes are static.
        let of = |bytes: Bytes| unsafe { bytes.slice() }.unwrap().to_vec();
        let (catalogue, calibration) = (sextant_reference_catalogue(), sextant_reference_calibration());
        parameters.imaging.calibration_crc = Calibration::open(&of(calibration)).unwrap().crc();
        let mut copies = [encoded(&parameters), of(catalogue), of(calibration), bad_pixels::whole()];
        let damaged = &mut copies[usize::from(which)];
        let place = at.index(damaged.len());
        damaged[place] ^= flip;
        let bytes = |index: usize| Bytes { data: copies[index].as_ptr(), length: copies[index].len() };
        let [parameters, catalogue, calibration, bad_pixels] = [0, 1, 2, 3].map(bytes);
        let tables = SensorTables { parameters, catalogue, calibration, bad_pixels };
        let (status, sensor) = init(&memory, &tables);
        let expected: &[Status] = match which {
            0 => &[Status::ParametersDamaged],
            1 => &[Status::CatalogueDamaged, Status::CatalogueVersion],
            2 => &[Status::CalibrationDamaged, Status::CalibrationVersion],
            _ => &[Status::BadPixelsDamaged, Status::BadPixelsVersion],
        };
        prop_assert!(expected.contains(&status), "{:?}", status);
        prop_assert!(sensor.is_null());
    }
}
