//! What did not serve in a second: one field a source, each with a reason of its own.

use crate::orbit::observation::FixError;
use fsw_hal::{ClockError, DetectorError, ReadingError, ShutterError};
use serde::{Deserialize, Serialize};

/// What did not serve in a second; nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Faults {
    /// The detector failed. Where there are stars or an attitude they are of the windows that it did deliver;
    /// else nothing was measured after that in this second.
    pub detector: Option<DetectorFault>,
    /// The image was not used for its instant; the attitude, where there is one, is predicted.
    pub image: Option<ImageFault>,
    /// The clock did not serve; what Terrestrial Time rests on is [`super::Report::clock`].
    pub clock: Option<ClockFault>,
    /// The rate sensor gave no reading that can be used; `None` also where none is on board.
    pub rate_sensor: Option<ReadingFault>,
    /// Why the magnetometer gave no reading, where there is one and the orbit is known.
    pub magnetometer: Option<ReadingFault>,
    /// The shutters, which are on board by the parameters, did not move: where they stand is not known.
    pub shutter: Option<ShutterFault>,
    /// The Earth's centre was no position for the orbit filter.
    pub fix: Option<FixFault>,
    /// Tiles or windows too crowded to be searched whole: their faintest spots are missing.
    pub crowded: u16,
}

/// Why the detector did not serve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DetectorFault {
    /// A window or buffer was refused: a fault of ours.
    Request,
    /// The geometry is not the one the parameters were made for.
    Geometry,
    /// The hardware did not deliver, or a window read twice was not the same.
    Hardware,
}

impl From<DetectorError> for DetectorFault {
    fn from(error: DetectorError) -> Self {
        match error {
            DetectorError::OutsideDetector | DetectorError::BufferLength | DetectorError::Exposure => {
                Self::Request
            }
            _ => Self::Hardware,
        }
    }
}

/// Why an image was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ImageFault {
    /// It has the instant or the very noise of an image before, or its stars stand still: that image once
    /// more.
    Repeated,
    /// It is older than what has been seen already.
    OutOfOrder,
    /// Its instant lies ahead of the clock, or more than ten seconds behind.
    Implausible,
    /// After seconds without an attitude its stars stand elsewhere than the rate has led them: the next image
    /// decides.
    Unexpected,
}

/// Why the clock did not serve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ClockFault {
    /// Not synchronised.
    NotSynchronised,
    /// It gave an instant outside the years in which it is believed.
    Implausible,
    /// The hardware did not answer.
    Hardware,
    /// The counter went backwards: local time begins anew.
    CounterReset,
}

impl From<ClockError> for ClockFault {
    fn from(kind: ClockError) -> Self {
        match kind {
            ClockError::NotSynchronised => Self::NotSynchronised,
            _ => Self::Hardware,
        }
    }
}

/// Why the rate sensor or the magnetometer, which is on board by the parameters, gave no reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ReadingFault {
    /// It had no new reading.
    Silent,
    /// Its reading was older than a second and a half, or ahead of the image.
    Stale,
    /// Its reading was not a number.
    NotFinite,
    /// What it measures is beyond its range.
    Saturated,
    /// The hardware did not answer.
    Hardware,
    /// What is known from stars and orbit contradicted its readings time after time: it is not asked until
    /// the restart.
    ShutOut,
}

impl From<ReadingError> for ReadingFault {
    fn from(error: ReadingError) -> Self {
        match error {
            ReadingError::Saturated => Self::Saturated,
            _ => Self::Hardware,
        }
    }
}

/// Why a shutter did not move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ShutterFault {
    /// It did not arrive where it was sent.
    Stuck,
    /// The hardware did not answer.
    Hardware,
}

impl From<ShutterError> for ShutterFault {
    fn from(error: ShutterError) -> Self {
        match error {
            ShutterError::Stuck => Self::Stuck,
            _ => Self::Hardware,
        }
    }
}

/// Why the orbit filter refused a fix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FixFault {
    /// Not finite, or farther or nearer than the orbit can be.
    Impossible,
    /// Its covariance is not positive definite.
    Covariance,
}

impl From<FixError> for FixFault {
    fn from(error: FixError) -> Self {
        match error {
            FixError::Impossible => Self::Impossible,
            FixError::Covariance => Self::Covariance,
        }
    }
}
