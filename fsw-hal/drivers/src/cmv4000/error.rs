//! What can go wrong with the detector.

use fsw_hal::{ClockError, DetectorError};

/// Why an image or a window of it was not delivered. `S`, `G` and `P` are the errors of the bus, of the pins
/// and of the pixel port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<S, G, P> {
    /// The registers' bus failed.
    Spi(S),
    /// A pin failed.
    Pin(G),
    /// The pixel port failed.
    Port(P),
    /// The clock failed.
    Clock(ClockError),
    /// A register does not hold what was written.
    Readback {
        /// Its address.
        address: u8,
        /// What was written.
        wrote: u8,
        /// What was read.
        read: u8,
    },
    /// The frame has not ended a quarter of its time after it should have.
    NoFrame,
    /// Fewer or more pixels came than were asked for.
    Short {
        /// Pixels that came.
        came: usize,
        /// Pixels that should have come.
        expected: usize,
    },
    /// The exposure is shorter than one row time or longer than [`EXPOSURE_MAX`](super::EXPOSURE_MAX).
    Exposure,
    /// The window leaves the detector.
    OutsideDetector,
    /// The buffer's length is not the window's area.
    BufferLength,
    /// No image is there.
    NotExposed,
}

impl<S, G, P> Error<S, G, P> {
    /// Whether the hardware failed, and not the request.
    pub(super) fn is_of_hardware(&self) -> bool {
        !matches!(self, Self::Exposure | Self::OutsideDetector | Self::BufferLength | Self::NotExposed)
    }
}

impl<S: core::fmt::Debug, G: core::fmt::Debug, P: core::fmt::Debug> fsw_hal::Error<DetectorError>
    for Error<S, G, P>
{
    fn kind(&self) -> DetectorError {
        match self {
            Self::Spi(_) | Self::Pin(_) | Self::Port(_) | Self::Readback { .. } | Self::Short { .. } => {
                DetectorError::Bus
            }
            Self::Clock(ClockError::Timeout) | Self::NoFrame => DetectorError::Timeout,
            Self::Clock(_) => DetectorError::Bus,
            Self::Exposure => DetectorError::Exposure,
            Self::OutsideDetector => DetectorError::OutsideDetector,
            Self::BufferLength => DetectorError::BufferLength,
            Self::NotExposed => DetectorError::NotExposed,
        }
    }
}

/// Why a driver was not made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingsError {
    /// The clock is outside 5 to 48 MHz.
    Clock,
    /// The window of rows is empty or leaves the detector.
    Rows,
    /// The analogue table names a register that the driver writes itself, or none.
    Analogue,
}
