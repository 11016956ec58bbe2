//! Angular rate sensor (gyro) of three axes.
//!
//! Asked once a second. Body axes are those of the Earth path: x along +x px, y along +y px, z out along its
//! line of sight.

use crate::clock::LocalTime;
use crate::error::{Error, ErrorType, ReadingError};

/// A reading of the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngularRate {
    /// Middle of the time it was taken over.
    pub instant: LocalTime,
    /// Rate of the body against inertial space about its x, y, z axes, rad/s, as the sensor has it: bias,
    /// scale and alignment are not corrected.
    pub rad_s: [f32; 3],
}

/// A sensor of the body's angular rate.
pub trait RateSensor: ErrorType<Error: Error<ReadingError>> {
    /// The newest reading; `None` where there is none since the last one was taken.
    ///
    /// # Errors
    /// [`ReadingError::Saturated`] beyond the sensor's range, [`ReadingError::Timeout`] or
    /// [`ReadingError::Bus`] when the hardware fails.
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, Self::Error>;
}

impl<S: RateSensor + ?Sized> RateSensor for &mut S {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, Self::Error> {
        S::angular_rate(self)
    }
}

/// None on board: there is never a reading.
impl RateSensor for () {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, Self::Error> {
        Ok(None)
    }
}

/// Where it is `None` there is never a reading.
impl<S: RateSensor> RateSensor for Option<S> {
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, Self::Error> {
        self.as_mut().map_or(Ok(None), S::angular_rate)
    }
}
