//! Magnetometer of three axes.
//!
//! Asked once a second. Body axes are those of the Earth path, as in [`crate::rate_sensor`].

use crate::clock::LocalTime;
use crate::error::{self, Error, ErrorType};

/// A reading of the magnetic flux density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagneticField {
    /// Middle of the time it was taken over.
    pub instant: LocalTime,
    /// Flux density along x, y, z of the body, microtesla, as the sensor has it: the spacecraft's own field
    /// is in it.
    pub ut: [f32; 3],
}

/// Why a magnetometer did not deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The field along an axis is beyond the sensor's range.
    Saturated,
    /// The sensor did not answer in time.
    Timeout,
    /// The link to the sensor reported an error.
    Bus,
}

impl error::ErrorKind for ErrorKind {}

/// A sensor of the magnetic field.
pub trait Magnetometer: ErrorType<Error: Error<ErrorKind>> {
    /// The newest reading; `None` where there is none since the last one was taken.
    ///
    /// # Errors
    /// [`ErrorKind::Saturated`] beyond the sensor's range, [`ErrorKind::Timeout`] or
    /// [`ErrorKind::Bus`] when the hardware fails.
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
