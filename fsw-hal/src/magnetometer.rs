//! Magnetometer of three axes.
//!
//! Asked once a second. Body axes are those of the Earth path, as in [`crate::rate_sensor`].

use crate::clock::LocalTime;
use crate::error::{Error, ErrorType, ReadingError};

/// A reading of the magnetic flux density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagneticField {
    /// Middle of the time it was taken over.
    pub instant: LocalTime,
    /// Flux density along x, y, z of the body, microtesla, as the sensor has it: the spacecraft's own field
    /// is in it.
    pub ut: [f32; 3],
}

/// A sensor of the magnetic field.
pub trait Magnetometer: ErrorType<Error: Error<ReadingError>> {
    /// The newest reading; `None` where there is none since the last one was taken.
    ///
    /// # Errors
    /// [`ReadingError::Saturated`] beyond the sensor's range, [`ReadingError::Timeout`] or
    /// [`ReadingError::Bus`] when the hardware fails.
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, Self::Error>;
}

impl<S: Magnetometer + ?Sized> Magnetometer for &mut S {
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, Self::Error> {
        S::magnetic_field(self)
    }
}

/// None on board: there is never a reading.
impl Magnetometer for () {
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, Self::Error> {
        Ok(None)
    }
}

/// Where it is `None` there is never a reading.
impl<S: Magnetometer> Magnetometer for Option<S> {
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, Self::Error> {
        self.as_mut().map_or(Ok(None), S::magnetic_field)
    }
}
