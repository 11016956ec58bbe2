use super::*;
use crate::mock::{Access, Board, Counter};
use core::f32::consts::PI;
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use fsw_hal::{ClockError, LocalTime, ReadingError};
use lsm6dsv16x_rs::blocking::I2CAddress;
use proptest::prelude::*;
use st_mems_bus::blocking::i2c::I2cBus;

const FUNC_CFG_ACCESS: u8 = 0x01;
const FIFO_CTRL3: u8 = 0x09;
const FIFO_CTRL4: u8 = 0x0A;
const WHO_AM_I: u8 = 0x0F;
const CTRL2: u8 = 0x11;
const CTRL3: u8 = 0x12;
const CTRL6: u8 = 0x15;
const FIFO_STATUS: u8 = 0x1B;
const OUT_TEMP: u8 = 0x20;
const FIFO_TAG: u8 = 0x78;
const FIFO_DATA: u8 = 0x79;
/// Of `FIFO_STATUS2`.
const OVERRUN: u8 = 0x40;

type Part<'b> = Lsm6dsv16xGyro<I2cBus<&'b Board>, &'b Board, Counter<'b>>;

/// A reset ends at once; the queue is emptied by bypass, and gives its samples one after the other.
fn reaction(board: &Board, registers: &mut [u8; 256], register: u8, access: Access) {
    let mut queue = board.queue.borrow_mut();
    let value = registers[usize::from(register)];
    let mut set = |register: u8, values: &[u8]| {
        registers[usize::from(register)..][..values.len()].copy_from_slice(values);
    };
    match (access, register) {
        (Access::Written, CTRL3) if value & 1 == 1 => {
            set(CTRL3, &[0x44]);
            [CTRL2, CTRL6, FIFO_CTRL3, FIFO_CTRL4].iter().for_each(|register| set(*register, &[0]));
        }
        (Access::Written, FIFO_CTRL4) if value & 7 == 0 => queue.clear(),
        (Access::Read, FIFO_STATUS) => {
            let overrun = if queue.len() > 511 { OVERRUN } else { 0 };
            let level = queue.len().min(511);
            set(FIFO_STATUS, &[level as u8, (level >> 8) as u8 | overrun]);
        }
        // The tag stands in the upper five bits.
        (Access::Read, FIFO_TAG) => set(FIFO_TAG, &[u8::from(!queue.is_empty()) << 3]),
        (Access::Read, FIFO_DATA) => {
            let sample = queue.pop_front().unwrap_or_default();
            let bytes: std::vec::Vec<u8> = sample.iter().flat_map(|axis| axis.to_le_bytes()).collect();
            set(FIFO_DATA, &bytes);
        }
        _ => {}
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

/// A second passes, in which the part takes these samples.
fn second(board: &Board, samples: impl IntoIterator<Item = [i16; 3]>) {
    board.queue.borrow_mut().extend(samples);
    board.now_us.set(board.now_us.get() + 1_000_000);
}

/// A gyro that has warmed up.
fn warm<'b>(board: &'b Board, mounting: Mounting) -> Part<'b> {
    let mut gyro = gyro(board, mounting);
    assert_eq!(gyro.angular_rate().unwrap(), None);
    second(board, [[9_999; 3]; 60]);
    assert_eq!(gyro.angular_rate().unwrap(), None);
    gyro
}

fn kind(error: &PartError<Error<ErrorKind>>) -> ReadingError {
    fsw_hal::Error::kind(error)
}

#[test]
fn the_first_call_starts_the_part_with_these_bytes_in_this_order() {
    let board = board();
    let mut gyro = gyro(&board, Mounting::ALIGNED);
    assert_eq!(gyro.angular_rate().unwrap(), None);
    let expected: [&[u8]; 8] = [
        // Reset of the control registers.
        &[CTRL3, 0x45],
        &[FUNC_CFG_ACCESS, 0],
        // Block data update; 125 deg/s; 60 Hz into the queue; 60 Hz; queue emptied, then running.
        &[CTRL3, 0x44],
        &[CTRL6, 0],
        &[FIFO_CTRL3, 0x50],
        &[CTRL2, 5],
        &[FIFO_CTRL4, 0],
        &[FIFO_CTRL4, 6],
    ];
    assert_eq!(board.written(), expected);
    assert_eq!(board.transfers.borrow()[0], ([WHO_AM_I].to_vec(), [0x70].to_vec()));
}

#[test]
fn a_rate_is_the_mean_of_the_second_in_rad_s_of_the_body_at_its_middle() {
    let board = board();
    let over = Mounting::new([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]).unwrap();
    let mut gyro = warm(&board, over);
    // Half of the samples 100 digits more, half less.
    second(&board, (0..60).map(|at| [1_000, -2_000, 30_000].map(|axis| axis + 100 - 200 * (at % 2))));
    board.set(OUT_TEMP, &(-2_560i16).to_le_bytes());
    let reading = gyro.angular_rate().unwrap().unwrap();
    assert_eq!(reading.instant, LocalTime::from_us(2_000_000 - 500_010));
    // 4.375 mdeg/s a digit: 4.375, -8.75 and 131.25 deg/s about the part's axes.
    for (told, expected_deg) in reading.rad_s.iter().zip([-8.75, 4.375, -131.25]) {
        assert!((told - expected_deg * PI / 180.0).abs() < 1e-6, "{:?}", reading.rad_s);
    }
    assert_eq!(gyro.temperature_c(), Some(15.0));
}

#[test]
fn samples_are_told_once_and_a_part_that_stopped_is_told_and_started_anew() {
    let board = board();
    let mut gyro = warm(&board, Mounting::ALIGNED);
    second(&board, [[1, 2, 3]; 60]);
    assert!(gyro.angular_rate().unwrap().is_some());
    let read_us = board.now_us.get();
    assert_eq!(gyro.angular_rate().unwrap(), None);
    board.now_us.set(read_us + STALE_US);
    assert_eq!(gyro.angular_rate().unwrap(), None);
    board.now_us.set(read_us + STALE_US + 1);
    let error = gyro.angular_rate().unwrap_err();
    assert!(matches!(error, PartError::Stopped));
    assert_eq!(kind(&error), ReadingError::Timeout);
    board.transfers.borrow_mut().clear();
    assert_eq!(gyro.angular_rate().unwrap(), None);
    assert_eq!(board.transfers.borrow()[0].0, [WHO_AM_I]);
}

#[test]
fn a_queue_of_more_than_a_second_or_overrun_is_no_reading() {
    for samples in [usize::from(MAX_SAMPLES) + 1, 511, 600] {
        let board = board();
        let mut gyro = warm(&board, Mounting::ALIGNED);
        second(&board, std::vec![[1_000; 3]; samples]);
        assert_eq!(gyro.angular_rate().unwrap(), None, "{samples}");
        assert!(board.queue.borrow().is_empty());
        second(&board, [[500; 3]; 60]);
        let rate = gyro.angular_rate().unwrap().unwrap().rad_s[0];
        assert!((rate - 500.0 * RAD_S_PER_DIGIT).abs() < 1e-6);
    }
    let board = board();
    let mut gyro = warm(&board, Mounting::ALIGNED);
    second(&board, [[1_000; 3]; MAX_SAMPLES as usize]);
    assert!(gyro.angular_rate().unwrap().is_some());
}

#[test]
fn a_sample_at_the_end_of_its_scale_is_refused_and_the_part_goes_on() {
    for end in [i16::MIN, i16::MAX] {
        for axis in 0..3 {
            let board = board();
            let mut gyro = warm(&board, Mounting::ALIGNED);
            let mut samples = [[100; 3]; 60];
            samples[30][axis] = end;
            second(&board, samples);
            let error = gyro.angular_rate().unwrap_err();
            assert_eq!(kind(&error), ReadingError::Saturated);
            board.transfers.borrow_mut().clear();
            second(&board, [[100; 3]; 60]);
            assert!(gyro.angular_rate().unwrap().is_some());
            assert!(board.written().is_empty());
        }
    }
}

#[test]
fn another_part_another_range_another_sample_and_a_reset_without_end_are_told() {
    let another = board();
    another.set(WHO_AM_I, &[0x6C]);
    let error = gyro(&another, Mounting::ALIGNED).angular_rate().unwrap_err();
    assert!(matches!(error, PartError::WrongPart(0x6C)));
    assert_eq!(kind(&error), ReadingError::Bus);

    let endless = Board::new(0x6A, |_, _, _, _| ());
    endless.set(WHO_AM_I, &[0x70]);
    let error = gyro(&endless, Mounting::ALIGNED).angular_rate().unwrap_err();
    assert!(matches!(error, PartError::Reset));
    assert_eq!(kind(&error), ReadingError::Timeout);

    let upset = board();
    let mut gyro = warm(&upset, Mounting::ALIGNED);
    upset.set(CTRL6, &[4]);
    second(&upset, [[100; 3]; 60]);
    assert!(matches!(gyro.angular_rate(), Err(PartError::Readback)));
    assert_eq!(gyro.angular_rate().unwrap(), None);
    assert_eq!(upset.get(CTRL6), 0);

    // Level and queue disagree: what comes is not a sample of the gyro.
    let empty = Board::new(0x6A, |board, registers, register, access| {
        reaction(board, registers, register, access);
        if register == FIFO_TAG {
            registers[usize::from(FIFO_TAG)] = 2 << 3;
        }
    });
    empty.set(WHO_AM_I, &[0x70]);
    empty.set(CTRL3, &[0x44]);
    let mut gyro = warm(&empty, Mounting::ALIGNED);
    second(&empty, [[100; 3]; 60]);
    assert!(matches!(gyro.angular_rate(), Err(PartError::Readback)));
}

#[test]
fn every_transaction_that_fails_is_told_and_the_next_call_starts_anew() {
    let fly = |board: &Board, gyro: &mut Part| {
        gyro.angular_rate()?;
        second(board, [[5; 3]; 2]);
        gyro.angular_rate()?;
        second(board, [[5; 3]; 2]);
        gyro.angular_rate()
    };
    let count = {
        let board = board();
        fly(&board, &mut gyro(&board, Mounting::ALIGNED)).unwrap().unwrap();
        board.transfers.borrow().len()
    };
    for number in 0..count {
        let board = board();
        let mut gyro = gyro(&board, Mounting::ALIGNED);
        board.failing.set(Some(number));
        let error = fly(&board, &mut gyro).unwrap_err();
        let expected = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
        assert!(matches!(&error, PartError::Driver(Error::Bus(kind)) if *kind == expected));
        assert_eq!(kind(&error), ReadingError::Bus);
        board.transfers.borrow_mut().clear();
        board.failing.set(None);
        gyro.angular_rate().unwrap();
        assert_eq!(board.transfers.borrow()[0].0, [WHO_AM_I]);
    }
}

#[test]
fn a_clock_that_fails_is_told() {
    let board = board();
    let mut gyro = warm(&board, Mounting::ALIGNED);
    second(&board, [[5; 3]; 60]);
    board.clock_fails.set(true);
    let error = gyro.angular_rate().unwrap_err();
    assert!(matches!(error, PartError::Clock(ClockError::Timeout)));
    assert_eq!(kind(&error), ReadingError::Timeout);
    board.clock_fails.set(false);
    assert!(gyro.angular_rate().unwrap().is_some());
}

proptest! {
    #[test]
    fn whatever_the_samples_are_a_rate_is_finite_and_within_the_scale(
        samples in prop::collection::vec(prop::array::uniform3(any::<i16>()), 1..=75),
        temperature in any::<i16>(),
    ) {
        let board = board();
        let mut gyro = warm(&board, Mounting::ALIGNED);
        let any_saturated = samples.iter().any(|sample| saturated(*sample));
        second(&board, samples);
        board.set(OUT_TEMP, &temperature.to_le_bytes());
        match gyro.angular_rate() {
            Ok(Some(reading)) => prop_assert!(reading.rad_s.iter().all(|rate| rate.abs() < 2.51)),
            other => prop_assert!(matches!(other, Err(PartError::Saturated)) && any_saturated),
        }
    }
}
