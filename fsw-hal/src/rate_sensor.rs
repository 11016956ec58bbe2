//! Angular rate sensor (gyro) of three axes.
//!
//! Asked once a second. Body axes are those of the Earth path: x along +x px, y along +y px, z out along its line of sight.

/// A reading of the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngularRate {
    /// Middle of the time it was taken over: Terrestrial Time, microseconds since J2000.0.
    pub instant_us: i64,
    /// Rate of the body against inertial space about its x, y, z axes, rad/s, as the sensor has it: bias, scale and
    /// alignment are not corrected.
    pub rad_s: [f32; 3],
}

/// Why a rate sensor did not deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RateSensorError {
    /// An axis turns faster than the sensor can tell.
    Saturated,
    /// The sensor did not answer in time.
    Timeout,
    /// The link to the sensor reported an error.
    Bus,
}

/// A sensor that tells how fast the body turns.
pub trait RateSensor {
    /// The newest reading; `None` where there is none since the last one was taken.
    ///
    /// # Errors
    /// [`RateSensorError::Saturated`] beyond the sensor's range, [`RateSensorError::Timeout`] or
    /// [`RateSensorError::Bus`] when the hardware fails.
    fn angular_rate(&mut self) -> Result<Option<AngularRate>, RateSensorError>;
}
