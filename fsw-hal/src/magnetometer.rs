//! Magnetometer of three axes.
//!
//! Asked once a second. Body axes are those of the Earth path, as in [`crate::rate_sensor`].

/// A reading of the magnetic flux density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagneticField {
    /// Middle of the time it was taken over: Terrestrial Time, microseconds since J2000.0.
    pub instant_us: i64,
    /// Flux density along x, y, z of the body, microtesla, as the sensor has it: the spacecraft's own field is in it.
    pub ut: [f32; 3],
}

/// Why a magnetometer did not deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MagnetometerError {
    /// The field along an axis is stronger than the sensor can tell.
    Saturated,
    /// The sensor did not answer in time.
    Timeout,
    /// The link to the sensor reported an error.
    Bus,
}

/// A sensor of the magnetic field.
pub trait Magnetometer {
    /// The newest reading; `None` where there is none since the last one was taken.
    ///
    /// # Errors
    /// [`MagnetometerError::Saturated`] beyond the sensor's range, [`MagnetometerError::Timeout`] or
    /// [`MagnetometerError::Bus`] when the hardware fails.
    fn magnetic_field(&mut self) -> Result<Option<MagneticField>, MagnetometerError>;
}
