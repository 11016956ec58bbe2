//! Gyro LSM6DSV16X of STMicroelectronics, by the maker's own driver crate `lsm6dsv16x-rs`.
//!
//! In: the crate's driver on a bus, a clock, the mounting. Out: the [`RateSensor`] of `fsw-hal`, rad/s in body
//! axes.
//!
//! Why this crate: the maker keeps it (2.2.0, on `embedded-hal` 1.0, tested on both buses), it knows every
//! register of the part, has a blocking face, and its licence, BSD-3-Clause, asks for its notice alone.
//!
//! Registers and scale are those of ST's data sheet of the part, as the crate has them.
//!
//! - Range ±125 deg/s, 4.375 mdeg/s a digit, 240 Hz; a sensor that turns faster sees streaks and no stars.
//! - A reading is the newest sample. Asked once a second the part overwrites 239 of 240: no fault. The
//!   registers of a sample stay together while they are read (block data update).
//! - Its instant is half a period before it was read: within 2.1 ms, 0.13 arcsec at 60 arcsec/s.
//! - No new sample: `None` up to [`STALE_US`] after the last, then the part has stopped, is told as
//!   [`RateSensorError::Timeout`](fsw_hal::RateSensorError) and started anew by the next call.
//! - The range is read back with each reading; an axis at the end of the converter is refused as saturated.
//!   Every other reading is finite, as the mounting is.
//! - The temperature is read with the rate and kept for housekeeping ([`Lsm6dsv16xGyro::temperature_c`]); bias and scale
//!   are not corrected here, the filter estimates them.

use crate::mounting::Mounting;
use crate::part::{PartError, Running, now, saturated};
use embedded_hal::delay::DelayNs;
use fsw_hal::{AngularRate, Clock, ErrorType, RateSensor};
use lsm6dsv16x_rs::blocking::prelude::{GyFullScale, MainBank, Odr, Reset};
use lsm6dsv16x_rs::blocking::{Error, ID, Lsm6dsv16x, from_fs125_to_mdps, from_lsb_to_celsius};
use st_mems_bus::blocking::BusOperation;

/// Between two samples, us: 240 Hz.
const PERIOD_US: i64 = 4_167;
/// So long after the last sample, or after a start, the part has stopped, us: 24 periods.
pub const STALE_US: i64 = 100_000;
/// The reset of the control registers is looked at so often, and so long waited in between.
const RESET_LOOKS: u8 = 10;
const RESET_US: u32 = 100;
const RAD_PER_MDEG: f32 = core::f32::consts::PI / 180_000.0;

/// The gyro.
pub struct Lsm6dsv16xGyro<B: BusOperation, T: DelayNs, C> {
    part: Lsm6dsv16x<B, T, MainBank>,
    clock: C,
    mounting: Mounting,
    running: Running,
    temperature_c: Option<f32>,
}

impl<B: BusOperation, T: DelayNs, C: Clock> Lsm6dsv16xGyro<B, T, C> {
    /// A gyro that is started with the first call.
    pub fn new(part: Lsm6dsv16x<B, T, MainBank>, clock: C, mounting: Mounting) -> Self {
        Self { part, clock, mounting, running: Running::default(), temperature_c: None }
    }

    /// Temperature of the part at the last reading, deg C.
    pub fn temperature_c(&self) -> Option<f32> {
        self.temperature_c
    }

    fn start(&mut self) -> Result<(), PartError<Error<B::Error>>> {
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
        part.gy_data_rate_set(Odr::_240hz).map_err(PartError::Driver)
    }

    fn newest(&mut self) -> Result<Option<AngularRate>, PartError<Error<B::Error>>> {
        if self.running.since().is_none() {
            self.start()?;
            self.running.seen(now(&mut self.clock)?);
        }
        let ready = self.part.flag_data_ready_get().map_err(PartError::Driver)?;
        let read = now(&mut self.clock)?;
        if ready.drdy_gy == 0 {
            return self.running.nothing(read, STALE_US);
        }
        if self.part.gy_full_scale_get().map_err(PartError::Driver)? != GyFullScale::_125dps {
            return Err(PartError::Readback);
        }
        let temperature = self.part.temperature_raw_get().map_err(PartError::Driver)?;
        let raw = self.part.angular_rate_raw_get().map_err(PartError::Driver)?;
        self.temperature_c = Some(from_lsb_to_celsius(temperature));
        self.running.seen(read);
        if saturated(raw) {
            return Err(PartError::Saturated);
        }
        let rad_s = raw.map(|axis| from_fs125_to_mdps(axis) * RAD_PER_MDEG);
        Ok(Some(AngularRate { instant: read.plus_us(-PERIOD_US / 2), rad_s: self.mounting.to_body(rad_s) }))
    }
}

impl<B: BusOperation, T: DelayNs, C> ErrorType for Lsm6dsv16xGyro<B, T, C> {
    type Error = PartError<Error<B::Error>>;
}

impl<B: BusOperation, T: DelayNs, C: Clock> RateSensor for Lsm6dsv16xGyro<B, T, C> {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, Self::Error> {
        let newest = self.newest();
        self.running.conclude(newest)
    }
}

#[cfg(test)]
mod tests;
