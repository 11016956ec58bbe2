//! The one table of everything that is set for a mission, checked before it is used.
//!
//! Each room's parameters live with the room; this table gathers them. [`Parameters::check`] is the door: it refuses a
//! table with a value outside its range and names it, and the table in force stays. A table travels as a
//! [`packet`] of version [`VERSION`].

use crate::attitude::filter::RateSensorNoise;
use crate::camera::{Camera, CameraError, CameraParameters};
use crate::earth::EarthParameters;
use crate::frames::{EarthPath, Rotation, StarPath};
use crate::image::DetectionParameters;
use crate::modes::ModeParameters;
use crate::orbit::parameters::OrbitParameters;
use crate::packet::{self, PacketError};
use crate::stars::identify::IdentificationParameters;
use serde::{Deserialize, Serialize};

/// Version of the table's layout.
pub const VERSION: u8 = 6;
/// A buffer of this length holds any table.
pub const MAX_TABLE_BYTES: usize = 512;

/// Parameters of star tracking.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackingParameters {
    /// Half the side of the area searched about a predicted star, px (default 5, 3 to 24). A star is taken within
    /// half of it once the others have corrected the prediction.
    pub gate_px: u16,
    /// Fewest stars that make an attitude (default 3, 3 to 16).
    pub fewest_stars: u16,
    /// Largest standard deviation with which an attitude that is only carried on is reported, rad (default 0.01, 1e-4 to
    /// 0.1).
    pub carried_sigma_rad: f32,
}

/// How the two paths stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MountParameters {
    /// Rotation from the star path's to the Earth path's frame, `[x, y, z, w]`, of unit length to 1e-3 (default: none).
    pub star_to_earth: [f32; 4],
}

impl Default for MountParameters {
    fn default() -> Self {
        Self { star_to_earth: [0.0, 0.0, 0.0, 1.0] }
    }
}

impl Default for TrackingParameters {
    fn default() -> Self {
        Self { gate_px: 5, fewest_stars: 3, carried_sigma_rad: 0.01 }
    }
}

/// All parameters of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// The lens and the detector behind it.
    pub camera: CameraParameters,
    /// The two lines of sight.
    pub mount: MountParameters,
    /// Exposure time, microseconds (100 to 1,000,000, and with the readout of all rows at most a second).
    pub exposure_us: u32,
    /// From a row's exposure to the next row's, ns (default 0: a global shutter; 0 to 500,000).
    pub row_time_ns: u32,
    /// CRC of the calibration that belongs to lens and detector; 0: none.
    pub calibration_crc: u32,
    /// Star detection.
    pub detection: DetectionParameters,
    /// Star identification.
    pub identification: IdentificationParameters,
    /// Catalogue pairs that identification may look at in one second (default 560,000; 10,000 to 4,000,000), confirmations counted in
    /// proportion: a pair costs about 130 cycles on the target.
    pub pairs_per_cycle: u32,
    /// Star tracking.
    pub tracking: TrackingParameters,
    /// The rate sensor that carries the attitude from image to image; none (the default): the filter's own rate does. What it loses in a
    /// second must be less than a third of the gate, else no star would be found where it is predicted: a gyro of a car (0.2
    /// deg/s) is no such sensor.
    pub rate_sensor: Option<RateSensorNoise>,
    /// The Earth's figure, limb and centre.
    pub earth: EarthParameters,
    /// Propagation and filter of the orbit.
    pub orbit: OrbitParameters,
    /// Patience and time-outs.
    pub modes: ModeParameters,
}

/// Why a table was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterError {
    /// The camera's values are impossible.
    Camera(CameraError),
    /// The named value is outside its range (or not finite).
    Range(&'static str),
    /// Exposure and readout, `exposure_us` and `row_time_ns` times the rows, do not fit into a second.
    ExposureBeyondSecond,
}

impl core::fmt::Display for ParameterError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Camera(_) => f.write_str("the camera's values are impossible"),
            Self::Range(name) => write!(f, "{name} is outside its range"),
            Self::ExposureBeyondSecond => {
                f.write_str("exposure_us and row_time_ns of all rows are longer than a second: shorten one")
            }
        }
    }
}

impl Parameters {
    /// The defaults for a camera.
    pub fn for_camera(camera: CameraParameters) -> Self {
        Self {
            camera,
            mount: MountParameters::default(),
            exposure_us: 100_000,
            row_time_ns: 0,
            calibration_crc: 0,
            detection: DetectionParameters::default(),
            identification: IdentificationParameters::default(),
            pairs_per_cycle: 560_000,
            tracking: TrackingParameters::default(),
            rate_sensor: None,
            earth: EarthParameters::default(),
            orbit: OrbitParameters::default(),
            modes: ModeParameters::default(),
        }
    }

    /// Writes the table as a packet and gives the bytes used.
    ///
    /// # Errors
    /// [`PacketError::Buffer`] when `buffer` is shorter than the packet; [`MAX_TABLE_BYTES`] always suffice.
    pub fn encode<'a>(&self, buffer: &'a mut [u8]) -> Result<&'a [u8], PacketError> {
        packet::encode(VERSION, self, buffer)
    }

    /// Reads a table; it is still to be [checked](Parameters::check).
    ///
    /// # Errors
    /// See [`PacketError`].
    pub fn decode(packet: &[u8]) -> Result<Self, PacketError> {
        packet::decode(VERSION, packet)
    }

    /// Checks every value against its range and gives the camera and the rotation between the paths.
    ///
    /// # Errors
    /// The first value that fails, by name.
    pub fn check(&self) -> Result<(Camera, Rotation<StarPath, EarthPath>), ParameterError> {
        let camera = Camera::new(self.camera).map_err(ParameterError::Camera)?;
        let Self { detection, identification, tracking, .. } = self;
        let norm = self.mount.star_to_earth.iter().fold(0.0, |sum, q| sum + q * q);
        let star_to_earth = Some(self.mount.star_to_earth)
            .filter(|_| (0.998..=1.002).contains(&norm))
            .and_then(Rotation::from_quaternion)
            .ok_or(ParameterError::Range("star_to_earth"))?;
        let [first, second, third] = identification.centroid_sigma_px;
        let integers = [
            ("exposure_us", self.exposure_us, 100, 1_000_000),
            ("row_time_ns", self.row_time_ns, 0, 500_000),
            ("pairs_per_cycle", self.pairs_per_cycle, 10_000, 4_000_000),
            ("threshold_sigma_tenths", detection.threshold_sigma_tenths.into(), 30, 200),
            ("peak_to_region_percent", detection.peak_to_region_percent.into(), 100, 1000),
            ("peak_to_inner_percent", detection.peak_to_inner_percent.into(), 100, 1000),
            ("inner_to_outer_percent", detection.inner_to_outer_percent.into(), 100, 1000),
            ("inner_share_percent", detection.inner_share_percent.into(), 0, 100),
            ("skirt_share_percent", detection.skirt_share_percent.into(), 1, 50),
            ("centroid_floor_millipx", detection.centroid_floor_millipx.into(), 1, 1000),
            ("gate_px", tracking.gate_px.into(), 3, 24),
            ("fewest_stars", tracking.fewest_stars.into(), 3, 16),
        ];
        let reals = [
            ("centroid_sigma_px[0]", first, 0.05, 3.0),
            ("centroid_sigma_px[1]", second, 0.05, 3.0),
            ("centroid_sigma_px[2]", third, 0.05, 3.0),
            ("scale_uncertainty", identification.scale_uncertainty, 0.0, 0.01),
            ("carried_sigma_rad", tracking.carried_sigma_rad, 1e-4, 0.1),
            ("log10_false_limit", identification.log10_false_limit, -30.0, -2.0),
        ];
        let gate_rad = f32::from(tracking.gate_px) * camera.rad_per_px();
        // What is not there is in its range.
        let RateSensorNoise { white_rad, walk_rad_s, bias_rad_s } = self
            .rate_sensor
            .unwrap_or(RateSensorNoise { white_rad: 1e-7, walk_rad_s: 0.0, bias_rad_s: 1e-7 });
        let rate_sensor = [
            ("rate_sensor.white_rad", white_rad, 1e-8, gate_rad * (1.0 / 3.0)),
            ("rate_sensor.walk_rad_s", walk_rad_s, 0.0, 1e-3),
            ("rate_sensor.bias_rad_s", bias_rad_s, 1e-8, 0.1),
        ];
        let modes = self.modes.ranges();
        let wrong_integer =
            integers.iter().chain(&modes).find(|(_, value, low, high)| !(low..=high).contains(&value));
        let (earth, orbit) = (self.earth.ranges(), self.orbit.ranges());
        let wrong_real = reals
            .iter()
            .chain(&rate_sensor)
            .chain(&earth)
            .chain(&orbit)
            .find(|(_, value, low, high)| !(low..=high).contains(&value));
        let readout_us = u64::from(self.row_time_ns) * u64::from(self.camera.height_px) / 1000;
        if u64::from(self.exposure_us) + readout_us > 1_000_000 {
            return Err(ParameterError::ExposureBeyondSecond);
        }
        match (wrong_integer, wrong_real) {
            (Some((name, ..)), _) | (None, Some((name, ..))) => Err(ParameterError::Range(name)),
            (None, None) => Ok((camera, star_to_earth)),
        }
    }
}

#[cfg(test)]
mod tests;
