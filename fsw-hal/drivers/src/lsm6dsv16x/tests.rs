use super::*;
use crate::mock::{Access, Board, Counter};
use core::f32::consts::PI;
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use fsw_hal::{ClockError, LocalTime, RateSensorError};
use lsm6dsv16x_rs::blocking::I2CAddress;
use proptest::prelude::*;
use st_mems_bus::blocking::i2c::I2cBus;

const FUNC_CFG_ACCESS: u8 = 0x01;
const WHO_AM_I: u8 = 0x0F;
const CTRL2: u8 = 0x11;
const CTRL3: u8 = 0x12;
const CTRL6: u8 = 0x15;
const STATUS: u8 = 0x1E;
const OUT_TEMP: u8 = 0x20;
const OUT_G: u8 = 0x22;
const GDA: u8 = 2;

type Part<'b> = Lsm6dsv16xGyro<I2cBus<&'b Board>, &'b Board, Counter<'b>>;

/// A reset ends at once; a sample that was read is no longer new.
fn reaction(registers: &mut [u8; 256], register: u8, access: Access) {
    if register == CTRL3 && access == Access::Written && registers[usize::from(CTRL3)] & 1 == 1 {
        registers[usize::from(CTRL3)] = 0x44;
        (registers[usize::from(CTRL2)], registers[usize::from(CTRL6)]) = (0, 0);
    }
    if register == OUT_G + 5 && access == Access::Read {
        registers[usize::from(STATUS)] &= !GDA;
    }
}

fn board() -> Board {
    let board = Board::new(0x6A, reaction);
    board.set(WHO_AM_I, &[0x70]);
    board.set(CTRL3, &[0x44]);
    board
}

fn gyro<'b>(board: &'b Board, mounting: Mounting) -> Part<'b> {
    Lsm6dsv16xGyro::new(Lsm6dsv16x::new_i2c(board, I2CAddress::I2cAddL, board), Counter(board), mounting)
}

/// A new sample.
fn sample(board: &Board, axes: [i16; 3]) {
    board.set_axes(OUT_G, axes);
    board.set(STATUS, &[board.get(STATUS) | GDA]);
}

fn second(board: &Board) {
    board.now_us.set(board.now_us.get() + 1_000_000);
}

#[test]
fn the_first_call_starts_the_part_with_these_bytes_in_this_order() {
    let board = board();
    let mut gyro = gyro(&board, Mounting::ALIGNED);
    assert_eq!(gyro.angular_rate().unwrap(), None);
    // Reset of the control registers; block data update; 125 deg/s; 240 Hz.
    let expected: [&[u8]; 5] =
        [&[CTRL3, 0x45], &[FUNC_CFG_ACCESS, 0], &[CTRL3, 0x44], &[CTRL6, 0], &[CTRL2, 7]];
    assert_eq!(board.written(), expected);
    assert_eq!(board.transfers.borrow()[0], ([WHO_AM_I].to_vec(), [0x70].to_vec()));
}

#[test]
fn a_rate_is_told_in_rad_s_of_the_body_at_its_instant() {
    let board = board();
    let over = Mounting::new([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]).unwrap();
    let mut gyro = gyro(&board, over);
    gyro.angular_rate().unwrap();
    second(&board);
    sample(&board, [1_000, -2_000, 32_766]);
    board.set(OUT_TEMP, &(-2_560i16).to_le_bytes());
    let reading = gyro.angular_rate().unwrap().unwrap();
    assert_eq!(reading.instant, LocalTime::from_us(1_000_000 - 2_083));
    // 4.375 mdeg/s a digit: 4.375, -8.75 and 143.35 deg/s about the part's axes.
    for (told, expected_deg) in reading.rad_s.iter().zip([-8.75, 4.375, -143.351_25]) {
        assert!((told - expected_deg * PI / 180.0).abs() < 1e-6, "{:?}", reading.rad_s);
    }
    assert_eq!(gyro.temperature_c(), Some(15.0));
}

#[test]
fn a_sample_is_told_once_and_a_part_that_stopped_is_told_and_started_anew() {
    let board = board();
    let mut gyro = gyro(&board, Mounting::ALIGNED);
    gyro.angular_rate().unwrap();
    sample(&board, [1, 2, 3]);
    assert!(gyro.angular_rate().unwrap().is_some());
    assert_eq!(gyro.angular_rate().unwrap(), None);
    board.now_us.set(STALE_US);
    assert_eq!(gyro.angular_rate().unwrap(), None);
    board.now_us.set(STALE_US + 1);
    let error = gyro.angular_rate().unwrap_err();
    assert_eq!(fsw_hal::Error::<RateSensorError>::kind(&error), RateSensorError::Timeout);
    assert!(matches!(error, PartError::Stopped));
    board.transfers.borrow_mut().clear();
    assert_eq!(gyro.angular_rate().unwrap(), None);
    assert_eq!(board.written().len(), 5);
}

#[test]
fn samples_that_were_overwritten_are_no_fault() {
    let board = board();
    let mut gyro = gyro(&board, Mounting::ALIGNED);
    gyro.angular_rate().unwrap();
    for value in 1..=10 {
        second(&board);
        sample(&board, [-value; 3]);
        sample(&board, [value; 3]);
        let told = gyro.angular_rate().unwrap().unwrap().rad_s[0];
        assert!((told / (4.375e-3 * PI / 180.0) - f32::from(value)).abs() < 1e-4);
    }
}

#[test]
fn an_axis_at_the_end_of_its_scale_is_refused_and_the_part_goes_on() {
    for end in [i16::MIN, i16::MAX] {
        for axis in 0..3 {
            let board = board();
            let mut gyro = gyro(&board, Mounting::ALIGNED);
            gyro.angular_rate().unwrap();
            let mut axes = [100; 3];
            axes[axis] = end;
            sample(&board, axes);
            let error = gyro.angular_rate().unwrap_err();
            assert_eq!(fsw_hal::Error::<RateSensorError>::kind(&error), RateSensorError::Saturated);
            board.transfers.borrow_mut().clear();
            sample(&board, [100; 3]);
            assert!(gyro.angular_rate().unwrap().is_some());
            assert!(board.written().is_empty());
        }
    }
}

#[test]
fn another_part_another_range_and_a_reset_without_end_are_told() {
    let board_of_another = board();
    board_of_another.set(WHO_AM_I, &[0x6C]);
    let error = gyro(&board_of_another, Mounting::ALIGNED).angular_rate().unwrap_err();
    assert!(matches!(error, PartError::WrongPart(0x6C)));
    assert_eq!(fsw_hal::Error::<RateSensorError>::kind(&error), RateSensorError::Bus);

    let endless = Board::new(0x6A, |_, _, _| ());
    endless.set(WHO_AM_I, &[0x70]);
    let error = gyro(&endless, Mounting::ALIGNED).angular_rate().unwrap_err();
    assert!(matches!(error, PartError::Reset));
    assert_eq!(fsw_hal::Error::<RateSensorError>::kind(&error), RateSensorError::Timeout);

    let upset = board();
    let mut gyro = gyro(&upset, Mounting::ALIGNED);
    gyro.angular_rate().unwrap();
    upset.set(CTRL6, &[4]);
    sample(&upset, [100; 3]);
    assert!(matches!(gyro.angular_rate(), Err(PartError::Readback)));
    sample(&upset, [100; 3]);
    assert!(gyro.angular_rate().unwrap().is_some());
}

#[test]
fn every_transaction_that_fails_is_told_and_the_next_call_starts_anew() {
    let count = {
        let board = board();
        let mut gyro = gyro(&board, Mounting::ALIGNED);
        gyro.angular_rate().unwrap();
        sample(&board, [5; 3]);
        gyro.angular_rate().unwrap().unwrap();
        board.transfers.borrow().len()
    };
    for number in 0..count {
        let board = board();
        let mut gyro = gyro(&board, Mounting::ALIGNED);
        board.failing.set(Some(number));
        let first = gyro.angular_rate();
        sample(&board, [5; 3]);
        let error = first.and_then(|_| gyro.angular_rate()).unwrap_err();
        let expected = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
        assert!(matches!(&error, PartError::Driver(Error::Bus(kind)) if *kind == expected));
        assert_eq!(fsw_hal::Error::<RateSensorError>::kind(&error), RateSensorError::Bus);
        board.transfers.borrow_mut().clear();
        board.failing.set(None);
        gyro.angular_rate().unwrap();
        assert_eq!(board.transfers.borrow()[0].0, [WHO_AM_I]);
    }
}

#[test]
fn a_clock_that_fails_is_told() {
    let board = board();
    let mut gyro = gyro(&board, Mounting::ALIGNED);
    gyro.angular_rate().unwrap();
    sample(&board, [5; 3]);
    board.clock_fails.set(true);
    let error = gyro.angular_rate().unwrap_err();
    assert!(matches!(error, PartError::Clock(ClockError::Timeout)));
    assert_eq!(fsw_hal::Error::<RateSensorError>::kind(&error), RateSensorError::Timeout);
    board.clock_fails.set(false);
    assert!(gyro.angular_rate().unwrap().is_some());
}

proptest! {
    #[test]
    fn whatever_stands_in_the_registers_a_rate_is_finite_and_within_the_scale(
        axes in prop::array::uniform3(any::<i16>()),
        temperature in any::<i16>(),
    ) {
        let board = board();
        let mut gyro = gyro(&board, Mounting::ALIGNED);
        gyro.angular_rate().unwrap();
        sample(&board, axes);
        board.set(OUT_TEMP, &temperature.to_le_bytes());
        match gyro.angular_rate() {
            Ok(Some(reading)) => prop_assert!(reading.rad_s.iter().all(|rate| rate.abs() < 2.51)),
            other => prop_assert!(matches!(other, Err(PartError::Saturated)) && saturated(axes)),
        }
    }
}
