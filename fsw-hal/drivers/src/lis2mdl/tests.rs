use super::*;
use crate::mock::{Access, Board, Counter};
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use fsw_hal::{LocalTime, ReadingError};
use lis2mdl_rs::blocking::I2CAddress;
use proptest::prelude::*;
use st_mems_bus::blocking::i2c::I2cBus;

const WHO_AM_I: u8 = 0x4F;
const CFG_A: u8 = 0x60;
const CFG_B: u8 = 0x61;
const CFG_C: u8 = 0x62;
const STATUS: u8 = 0x67;
const OUT: u8 = 0x68;
const OUT_TEMP: u8 = 0x6E;
/// Ready, and overrun.
const READY: u8 = 0x08;
const OVERRUN: u8 = 0x80;

type Part<'b> = Lis2mdlMagnetometer<I2cBus<&'b Board>, &'b Board, Counter<'b>>;

/// A reset ends at once; a sample that is read is no longer new.
fn reaction(_: &Board, registers: &mut [u8; 256], register: u8, access: Access) {
    if register == CFG_A && access == Access::Written && registers[usize::from(CFG_A)] & 0x20 != 0 {
        registers[usize::from(CFG_A)] = 3;
        (registers[usize::from(CFG_B)], registers[usize::from(CFG_C)]) = (0, 0);
    }
    if register == OUT + 5 && access == Access::Read {
        registers[usize::from(STATUS)] = 0;
    }
}

fn board() -> Board {
    let board = Board::new(0x1E, reaction);
    board.set(WHO_AM_I, &[0x40]);
    board
}

fn magnetometer<'b>(board: &'b Board, mounting: Mounting) -> Part<'b> {
    let part = Lis2mdl::new_i2c(board, I2CAddress::I2cAdd, board);
    Lis2mdlMagnetometer::new(part, Counter(board), mounting)
}

/// A new sample, of several that nobody read.
fn sample(board: &Board, axes: [i16; 3]) {
    board.set_axes(OUT, axes);
    board.set(STATUS, &[READY | OVERRUN]);
}

#[test]
fn the_first_call_starts_the_part_with_these_bytes_in_this_order() {
    let board = board();
    assert_eq!(magnetometer(&board, Mounting::ALIGNED).magnetic_field().unwrap(), None);
    // Reset; block data update; compensation of temperature; offset cancelled; 50 Hz; continuous.
    let written = board.written();
    assert_eq!(written[0][0], CFG_A);
    assert_ne!(written[0][1] & 0x20, 0);
    let expected: [&[u8]; 5] = [&[CFG_C, 0x10], &[CFG_A, 0x83], &[CFG_B, 2], &[CFG_A, 0x8B], &[CFG_A, 0x88]];
    assert_eq!(written[1..], expected);
    assert_eq!(board.transfers.borrow()[0], ([WHO_AM_I].to_vec(), [0x40].to_vec()));
}

#[test]
fn a_field_is_told_in_microtesla_of_the_body_at_its_instant() {
    let board = board();
    let over = Mounting::new([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]).unwrap();
    let mut magnetometer = magnetometer(&board, over);
    magnetometer.magnetic_field().unwrap();
    board.now_us.set(1_000_000);
    sample(&board, [100, -200, 300]);
    board.set(OUT_TEMP, &80i16.to_le_bytes());
    let reading = magnetometer.magnetic_field().unwrap().unwrap();
    assert_eq!(reading.instant, LocalTime::from_us(990_000));
    // 0.15 uT a digit.
    for (told, expected) in reading.ut.iter().zip([-30.0, 15.0, -45.0]) {
        assert!((told - expected).abs() < 1e-4, "{:?}", reading.ut);
    }
    assert_eq!(magnetometer.temperature_c(), Some(35.0));
}

#[test]
fn a_sample_is_told_once_and_a_part_that_stopped_is_told_and_started_anew() {
    let board = board();
    let mut magnetometer = magnetometer(&board, Mounting::ALIGNED);
    magnetometer.magnetic_field().unwrap();
    sample(&board, [1, 2, 3]);
    assert!(magnetometer.magnetic_field().unwrap().is_some());
    assert_eq!(magnetometer.magnetic_field().unwrap(), None);
    board.now_us.set(STALE_US + 1);
    let error = magnetometer.magnetic_field().unwrap_err();
    assert!(matches!(error, PartError::Stopped));
    assert_eq!(fsw_hal::Error::<ReadingError>::kind(&error), ReadingError::Timeout);
    board.transfers.borrow_mut().clear();
    assert_eq!(magnetometer.magnetic_field().unwrap(), None);
    assert_eq!(board.transfers.borrow()[0].0, [WHO_AM_I]);
}

#[test]
fn what_is_wrong_with_the_part_is_told() {
    let another = board();
    another.set(WHO_AM_I, &[0x33]);
    let error = magnetometer(&another, Mounting::ALIGNED).magnetic_field().unwrap_err();
    assert!(matches!(error, PartError::WrongPart(0x33)));

    let endless = Board::new(0x1E, |_, _, _, _| ());
    endless.set(WHO_AM_I, &[0x40]);
    let error = magnetometer(&endless, Mounting::ALIGNED).magnetic_field().unwrap_err();
    assert!(matches!(error, PartError::Reset));

    let saturated = board();
    let mut magnetometer = magnetometer(&saturated, Mounting::ALIGNED);
    magnetometer.magnetic_field().unwrap();
    sample(&saturated, [0, i16::MIN, 0]);
    let error = magnetometer.magnetic_field().unwrap_err();
    assert_eq!(fsw_hal::Error::<ReadingError>::kind(&error), ReadingError::Saturated);
}

#[test]
fn every_transaction_that_fails_is_told_and_the_next_call_starts_anew() {
    let count = {
        let board = board();
        let mut magnetometer = magnetometer(&board, Mounting::ALIGNED);
        magnetometer.magnetic_field().unwrap();
        sample(&board, [5; 3]);
        magnetometer.magnetic_field().unwrap().unwrap();
        board.transfers.borrow().len()
    };
    for number in 0..count {
        let board = board();
        let mut magnetometer = magnetometer(&board, Mounting::ALIGNED);
        board.failing.set(Some(number));
        let first = magnetometer.magnetic_field();
        sample(&board, [5; 3]);
        let error = first.and_then(|_| magnetometer.magnetic_field()).unwrap_err();
        let expected = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
        assert!(matches!(&error, PartError::Driver(Error::Bus(kind)) if *kind == expected));
        assert_eq!(fsw_hal::Error::<ReadingError>::kind(&error), ReadingError::Bus);
        board.transfers.borrow_mut().clear();
        board.failing.set(None);
        magnetometer.magnetic_field().unwrap();
        assert_eq!(board.transfers.borrow()[0].0, [WHO_AM_I]);
    }
}

proptest! {
    #[test]
    fn whatever_stands_in_the_registers_a_field_is_finite_and_within_the_scale(
        axes in prop::array::uniform3(any::<i16>()),
    ) {
        let board = board();
        let mut magnetometer = magnetometer(&board, Mounting::ALIGNED);
        magnetometer.magnetic_field().unwrap();
        sample(&board, axes);
        match magnetometer.magnetic_field() {
            Ok(Some(reading)) => prop_assert!(reading.ut.iter().all(|ut| ut.abs() < 4_916.0)),
            other => prop_assert!(matches!(other, Err(PartError::Saturated)) && saturated(axes)),
        }
    }
}
