//! Gyro LSM6DSV16X of STMicroelectronics, by the maker's own driver crate `lsm6dsv16x-rs`.
//!
//! In: the crate's driver on a bus, a clock, the mounting. Out: the [`RateSensor`] of `fsw-hal`, rad/s in
//! body axes.
//!
//! Why this crate: the maker keeps it (2.2.0, on `embedded-hal` 1.0, tested on both buses), it knows every
//! register of the part, has a blocking face, and its licence, BSD-3-Clause, asks for its notice alone.
//!
//! Registers and scale are those of ST's data sheet of the part, as the crate has them.
//!
//! - Range ±125 deg/s, 4.375 mdeg/s a digit; a sensor that turns faster sees streaks and no stars.
//! - The part samples at 60 Hz into its queue. A reading is the mean of all samples since the last one: the
//!   angle turned, over its time, with the noise of a second and not of a sample. Its instant is the middle of
//!   that time, within half a period, 8.3 ms.
//! - A queue of more than [`MAX_SAMPLES`], or one that ran over, tells of no second: it is emptied, and there
//!   is no reading. So it is at first, while the part warms up.
//! - No sample: `None` up to [`STALE_US`] after the last; then the part has stopped, which is told as a
//!   time-out, and the next call starts it anew.
//! - The range is read back with each reading; a sample at the end of the converter is refused as saturated.
//!   Every other reading is finite, as the mounting is.
//! - The temperature is read with the rate and kept for housekeeping
//!   ([`Lsm6dsv16xGyro::temperature_c`]); bias and scale are not corrected here, the filter estimates them.
//!
//! Cost: 13 bytes a sample on the bus with their addresses, 60 samples a second: 18 ms of I2C at 400 kHz.

use crate::mounting::Mounting;
use crate::part::{PartError, Running, now, saturated};
use embedded_hal::delay::DelayNs;
use fsw_hal::{AngularRate, Clock, ErrorType, RateSensor};
use lsm6dsv16x_rs::blocking::prelude::{FifoBatch, FifoMode, GyFullScale, MainBank, Odr, Reset, Tag};
use lsm6dsv16x_rs::blocking::{Error, ID, Lsm6dsv16x, from_lsb_to_celsius};
use st_mems_bus::blocking::BusOperation;

/// Between two samples, us: 60 Hz.
const PERIOD_US: i64 = 16_667;
/// Most samples of a reading: of 1.25 s.
pub const MAX_SAMPLES: u16 = 75;
/// So long after the last sample, or after a start, the part has stopped, us: 6 periods.
pub const STALE_US: i64 = 100_000;
/// The reset of the control registers is looked at so often, and so long waited in between.
const RESET_LOOKS: u8 = 10;
const RESET_US: u32 = 100;
/// 4.375 mdeg/s.
const RAD_S_PER_DIGIT: f32 = 4.375e-3 * core::f32::consts::PI / 180.0;

type Failure<B> = PartError<Error<<B as BusOperation>::Error>>;

/// The gyro.
pub struct Lsm6dsv16xGyro<B: BusOperation, T: DelayNs, C> {
    part: Lsm6dsv16x<B, T, MainBank>,
    clock: C,
    mounting: Mounting,
    running: Running,
    /// Whether the queue holds samples since the last reading alone.
    warm: bool,
    temperature_c: Option<f32>,
}

impl<B: BusOperation, T: DelayNs, C: Clock> Lsm6dsv16xGyro<B, T, C> {
    /// A gyro that is started with the first call.
    pub fn new(part: Lsm6dsv16x<B, T, MainBank>, clock: C, mounting: Mounting) -> Self {
        Self { part, clock, mounting, running: Running::default(), warm: false, temperature_c: None }
    }

    /// Temperature of the part at the last reading, deg C.
    pub fn temperature_c(&self) -> Option<f32> {
        self.temperature_c
    }

    fn start(&mut self) -> Result<(), Failure<B>> {
        let part = &mut self.part;
        let identity = part.device_id_get().map_err(PartError::Driver)?;
        if identity != ID {
            return Err(PartError::WrongPart(identity));
        }
        part.reset_set(Reset::RestoreCtrlRegs).map_err(PartError::Driver)?;
        let mut looks = 0;
        while part.reset_get().map_err(PartError::Driver)? != Reset::Ready {
            if looks == RESET_LOOKS {
                return Err(PartError::Reset);
            }
            looks += 1;
            part.tim.delay_us(RESET_US);
        }
        part.block_data_update_set(1).map_err(PartError::Driver)?;
        part.gy_full_scale_set(GyFullScale::_125dps).map_err(PartError::Driver)?;
        part.fifo_gy_batch_set(FifoBatch::_60hz).map_err(PartError::Driver)?;
        part.gy_data_rate_set(Odr::_60hz).map_err(PartError::Driver)?;
        self.warm = false;
        self.empty()
    }

    /// Empties the queue.
    fn empty(&mut self) -> Result<(), Failure<B>> {
        self.part.fifo_mode_set(FifoMode::BypassMode).map_err(PartError::Driver)?;
        self.part.fifo_mode_set(FifoMode::StreamMode).map_err(PartError::Driver)
    }

    /// The sum of `samples` samples of the queue, digits; and whether one was at the end of its scale.
    fn sum(&mut self, samples: u16) -> Result<([i32; 3], bool), Failure<B>> {
        let (mut sum, mut any_saturated) = ([0; 3], false);
        for _ in 0..samples {
            let sample = self.part.fifo_out_raw_get().map_err(PartError::Driver)?;
            if sample.tag != Tag::GyNcTag {
                return Err(PartError::Readback);
            }
            let [x_low, x_high, y_low, y_high, z_low, z_high] = sample.data;
            let raw = [[x_low, x_high], [y_low, y_high], [z_low, z_high]].map(i16::from_le_bytes);
            any_saturated |= saturated(raw);
            sum.iter_mut().zip(raw).for_each(|(sum, axis)| *sum += i32::from(axis));
        }
        Ok((sum, any_saturated))
    }

    fn newest(&mut self) -> Result<Option<AngularRate>, Failure<B>> {
        if self.running.since().is_none() {
            self.start()?;
            self.running.seen(now(&mut self.clock)?);
        }
        let status = self.part.fifo_status_get().map_err(PartError::Driver)?;
        let (samples, read) = (status.fifo_level, now(&mut self.clock)?);
        if samples == 0 {
            return self.running.nothing(read, STALE_US);
        }
        self.running.seen(read);
        if !self.warm || status.fifo_ovr != 0 || samples > MAX_SAMPLES {
            self.empty()?;
            self.warm = true;
            return Ok(None);
        }
        if self.part.gy_full_scale_get().map_err(PartError::Driver)? != GyFullScale::_125dps {
            return Err(PartError::Readback);
        }
        let temperature = self.part.temperature_raw_get().map_err(PartError::Driver)?;
        self.temperature_c = Some(from_lsb_to_celsius(temperature));
        let (sum, any_saturated) = self.sum(samples)?;
        if any_saturated {
            return Err(PartError::Saturated);
        }
        let rad_s = sum.map(|sum| sum as f32 / f32::from(samples) * RAD_S_PER_DIGIT);
        let instant = read.plus_us(-PERIOD_US * i64::from(samples) / 2);
        Ok(Some(AngularRate { instant, rad_s: self.mounting.to_body(rad_s) }))
    }
}

impl<B: BusOperation, T: DelayNs, C> ErrorType for Lsm6dsv16xGyro<B, T, C> {
    type Error = Failure<B>;
}

impl<B: BusOperation, T: DelayNs, C: Clock> RateSensor for Lsm6dsv16xGyro<B, T, C> {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, Self::Error> {
        let newest = self.newest();
        self.running.conclude(newest)
    }
}

#[cfg(test)]
mod tests;
