//! What the driver crates of gyro and magnetometer have in common: their errors, and when they are started.

use fsw_hal::{Clock, ClockError, Error, LocalTime, ReadingError};

/// Why a part gave no reading. `E` is the error of its driver crate, which names that of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartError<E> {
    /// The bus failed, or a register had a value that the part never has.
    Driver(E),
    /// The clock failed.
    Clock(ClockError),
    /// Another part answers at this address: its identity.
    WrongPart(u8),
    /// A register that makes the scale does not hold what was written.
    Readback,
    /// Its reset does not end.
    Reset,
    /// There is no new reading though several should have come: the part has stopped.
    Stopped,
    /// An axis is at the end of its scale.
    Saturated,
}

impl<E: core::fmt::Debug> Error<ReadingError> for PartError<E> {
    fn kind(&self) -> ReadingError {
        match self {
            Self::Saturated => ReadingError::Saturated,
            Self::Reset | Self::Stopped | Self::Clock(ClockError::Timeout) => ReadingError::Timeout,
            _ => ReadingError::Bus,
        }
    }
}

/// Whether an axis stands at an end of the converter.
pub(crate) fn saturated(raw: [i16; 3]) -> bool {
    raw.iter().any(|axis| matches!(*axis, i16::MIN | i16::MAX))
}

/// Since when a part runs or was read last; `None` where it is to be started.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Running(Option<LocalTime>);

impl Running {
    /// The last sign of life.
    pub(crate) fn since(self) -> Option<LocalTime> {
        self.0
    }

    /// A sign of life.
    pub(crate) fn seen(&mut self, now: LocalTime) {
        self.0 = Some(now);
    }

    /// No new reading: not an error where the last sign of life is no older than `stale_us`.
    pub(crate) fn nothing<T, E>(self, now: LocalTime, stale_us: i64) -> Result<Option<T>, PartError<E>> {
        match self.0 {
            Some(seen) if now.us_since(seen) <= stale_us => Ok(None),
            _ => Err(PartError::Stopped),
        }
    }

    /// After a failure of the part it is to be started anew; a reading at the end of the scale is none.
    pub(crate) fn conclude<T, E>(&mut self, result: Result<T, PartError<E>>) -> Result<T, PartError<E>> {
        if result.as_ref().is_err_and(|error| !matches!(error, PartError::Saturated | PartError::Clock(_))) {
            self.0 = None;
        }
        result
    }
}

/// The clock's time.
pub(crate) fn now<C: Clock, E>(clock: &mut C) -> Result<LocalTime, PartError<E>> {
    clock.local_time().map_err(|error| PartError::Clock(error.kind()))
}
