//! Magnetometer LIS2MDL of STMicroelectronics, by the maker's own driver crate `lis2mdl-rs`.
//!
//! In: the crate's driver on a bus, a clock, the mounting. Out: the [`Magnetometer`] of `fsw-hal`,
//! microtesla in body axes.
//!
//! Why this crate: as for [`crate::lsm6dsv16x`]; 2.1.0, BSD-3-Clause.
//!
//! Registers and scale are those of ST's data sheet of the part, as the crate has them; how it is driven is
//! told by ST AN5069, revision 3, 2020.
//!
//! - Range ±4.9 mT, 0.15 uT a digit, 50 Hz, compensated for temperature, its offset cancelled in each sample.
//! - A reading is the newest sample; that the part overwrote those before it (its overrun flag) is how it is
//!   meant. The registers of a sample stay together while they are read (block data update).
//! - Its instant is half a period before it was read: within 10 ms.
//! - No new sample, the end of the scale, temperature: as for the gyro; stopped [`STALE_US`] after the last.

use crate::mounting::Mounting;
use crate::part::{PartError, Running, now, saturated};
use embedded_hal::delay::DelayNs;
use fsw_hal::{Clock, ErrorType, MagneticField, Magnetometer};
use lis2mdl_rs::blocking::prelude::{Md, Odr, OnState, SetRst};
use lis2mdl_rs::blocking::{Error, ID, Lis2mdl, from_lsb_to_celsius, from_lsb_to_mgauss};
use st_mems_bus::blocking::BusOperation;

/// Between two samples, us: 50 Hz.
const PERIOD_US: i64 = 20_000;
/// So long after the last sample, or after a start, the part has stopped, us: ten periods.
pub const STALE_US: i64 = 200_000;
const UT_PER_MGAUSS: f32 = 0.1;

type Failure<B> = PartError<Error<<B as BusOperation>::Error>>;

/// The magnetometer.
pub struct Lis2mdlMagnetometer<B: BusOperation, T: DelayNs, C> {
    part: Lis2mdl<B, T, OnState>,
    clock: C,
    mounting: Mounting,
    running: Running,
    temperature_c: Option<f32>,
}

impl<B: BusOperation, T: DelayNs, C: Clock> Lis2mdlMagnetometer<B, T, C> {
    /// A magnetometer that is started with the first call.
    pub fn new(part: Lis2mdl<B, T, OnState>, clock: C, mounting: Mounting) -> Self {
        Self { part, clock, mounting, running: Running::default(), temperature_c: None }
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
        part.sw_reset().map_err(|error| match error {
            Error::HwNoResponse => PartError::Reset,
            error => PartError::Driver(error),
        })?;
        part.block_data_update_set(1).map_err(PartError::Driver)?;
        part.offset_temp_comp_set(1).map_err(PartError::Driver)?;
        part.set_rst_mode_set(SetRst::SensOffCancEveryOdr).map_err(PartError::Driver)?;
        part.data_rate_set(Odr::_50hz).map_err(PartError::Driver)?;
        part.operating_mode_set(Md::ContinuousMode).map_err(PartError::Driver)
    }

    fn newest(&mut self) -> Result<Option<MagneticField>, Failure<B>> {
        if self.running.since().is_none() {
            self.start()?;
            self.running.seen(now(&mut self.clock)?);
        }
        let ready = self.part.mag_data_ready_get().map_err(PartError::Driver)?;
        let read = now(&mut self.clock)?;
        if ready == 0 {
            return self.running.nothing(read, STALE_US);
        }
        let temperature = self.part.temperature_raw_get().map_err(PartError::Driver)?;
        let raw = self.part.magnetic_raw_get().map_err(PartError::Driver)?;
        self.temperature_c = Some(from_lsb_to_celsius(temperature));
        self.running.seen(read);
        if saturated(raw) {
            return Err(PartError::Saturated);
        }
        let ut = raw.map(|axis| from_lsb_to_mgauss(axis) * UT_PER_MGAUSS);
        Ok(Some(MagneticField { instant: read.plus_us(-PERIOD_US / 2), ut: self.mounting.to_body(ut) }))
    }
}

impl<B: BusOperation, T: DelayNs, C> ErrorType for Lis2mdlMagnetometer<B, T, C> {
    type Error = Failure<B>;
}

impl<B: BusOperation, T: DelayNs, C: Clock> Magnetometer for Lis2mdlMagnetometer<B, T, C> {
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, Self::Error> {
        let newest = self.newest();
        self.running.conclude(newest)
    }
}

#[cfg(test)]
mod tests;
