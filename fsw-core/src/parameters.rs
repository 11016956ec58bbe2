//! The one table of everything that is set for a mission, checked before it is used.
//!
//! Each room declares its parameters where they are used, by the macro of [`table`]; this table gathers them.
//! [`Parameters::check`] refuses a table with a value outside its range and names it; the table in force
//! stays. A table travels as a [`packet`] of version [`VERSION`]. The page `PARAMETERS.md` lists all of them
//! (`sil-host parameters` writes it).

use crate::attitude::filter::RateSensorNoise;
use crate::camera::{Camera, CameraError, CameraParameters};
use crate::earth::EarthParameters;
use crate::earth::parameters as earth;
use crate::frames::{EarthPath, Rotation, StarPath};
use crate::image::DetectionParameters;
use crate::magnetism::MagnetometerErrors;
use crate::modes::ModeParameters;
use crate::orbit::body::{BodyLimb, CentralBody, EARTH};
use crate::orbit::parameters::OrbitParameters;
use crate::packet::{self, PacketError};
use crate::shutting::ShutterParameters;
use crate::stars::identify::IdentificationParameters;
use core::fmt;
use serde::{Deserialize, Serialize};
use table::{Row, parameter_group};

pub use fsw_ground::table;

/// Version of the table: it moves with its layout, and with the name, default or range of any parameter.
pub const VERSION: u8 = 27;
/// Checksum of all parameters of this version: names, types, defaults, ranges, in their order.
pub const CHECKSUM: u32 = 0x9EB9_A005;
/// A buffer of this length holds any table.
pub const MAX_TABLE_BYTES: usize = 512;
/// The ellipsoid of another body than the Earth is within this share of its radius.
const ELLIPSOID_SHARE: f32 = 0.01;

/// The rows of all parameters but the camera's, group by group, for the host.
pub const GROUPS: [&[Row]; 18] = [
    ImagingParameters::ROWS,
    MountParameters::ROWS,
    DetectionParameters::ROWS,
    IdentificationParameters::ROWS,
    TrackingParameters::ROWS,
    RateSensorNoise::ROWS,
    MagnetometerErrors::ROWS,
    ShutterParameters::ROWS,
    earth::Ellipsoid::ROWS,
    earth::LimbParameters::ROWS,
    earth::LightParameters::ROWS,
    earth::StripParameters::ROWS,
    earth::SearchParameters::ROWS,
    earth::FitParameters::ROWS,
    earth::HorizonParameters::ROWS,
    earth::PlausibleParameters::ROWS,
    OrbitParameters::ROWS,
    ModeParameters::ROWS,
];

parameter_group! {
    /// Exposure, and what belongs to the detector.
    pub struct ImagingParameters in "imaging" {
        /// Exposure time.
        exposure_us: u32 = 100_000, 100..=1_000_000, "us", "thesis 7.1: 0.1 s";
        /// From a row's exposure to the next row's.
        row_time_ns: u32 = 0, 0..=500_000, "ns", "a global shutter";
        /// CRC of the calibration that belongs to lens and detector; 0: none.
        calibration_crc: u32 = 0, one of "0, the CRC of a calibration", "",
            "told by the ground with the calibration";
    }
}

parameter_group! {
    /// Star tracking.
    pub struct TrackingParameters in "tracking" {
        /// Half the side of the area searched about a predicted star. A star is taken within half of it once
        /// the others have corrected the prediction.
        gate_px: u16 = 5, 3..=24, "px",
            "3 sigma of the prediction with margin; a larger one takes wrong stars";
        /// Fewest stars that make an attitude.
        fewest_stars: u16 = 3, 3..=16, "", "two fix an attitude, the third shows a wrong one";
        /// Largest standard deviation with which an attitude that is only carried on is reported.
        carried_sigma_rad: f32 = 0.01, 1e-4..=0.1, "rad",
            "30 px of the reference camera: beyond the widest gate, 24 px, no window would show its star";
        /// Angular acceleration of the manoeuvres that may begin while no star is seen; 0: none does. Without
        /// a rate sensor an attitude that is carried on has an error of half of it by the square of its age.
        manoeuvre_rad_s2: f32 = 0.0, 0.0..=1.0, "rad/s^2", "none: who turns without stars has a gyro";
    }
}

parameter_group! {
    /// How the two paths stand to each other.
    pub struct MountParameters in "mount" {
        /// Rotation from the star path's to the Earth path's frame, `[x, y, z, w]`, of unit length to 1e-3.
        star_to_earth: [f32; 4] = [0.0, 0.0, 0.0, 1.0], -1.001..=1.001, "", "one lens, one detector: none";
        /// Standard deviation of the place of the optical centre along x and y against where it was
        /// calibrated. It turns all stars of an image alike: an error of every attitude that lasts.
        boresight_sigma_px: f32 = 0.05, 0.0..=5.0, "px",
            "a lens that moved in its barrel by 0.4 um at launch, pixels of 7.5 um; bias from calibration to flight, ECSS-E-ST-60-20C";
    }
}

/// All parameters of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// The lens and the detector behind it.
    pub camera: CameraParameters,
    /// The two lines of sight.
    pub mount: MountParameters,
    /// Exposure and detector.
    pub imaging: ImagingParameters,
    /// Star detection.
    pub detection: DetectionParameters,
    /// Star identification.
    pub identification: IdentificationParameters,
    /// Star tracking.
    pub tracking: TrackingParameters,
    /// The rate sensor that carries the attitude from image to image; none (the default): the filter's own
    /// rate does. What it loses in a second must be less than a third of the gate, else no star would be
    /// found where it is predicted: a gyro of a car (0.2 deg/s) is no such sensor.
    pub rate_sensor: Option<RateSensorNoise>,
    /// The magnetometer beside the camera; none (the default): none is asked.
    pub magnetometer: Option<MagnetometerErrors>,
    /// The shutters of the paths; none (the default): both are always open.
    pub shutter: Option<ShutterParameters>,
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
    /// Exposure and the readout of all rows do not fit into a second.
    ExposureBeyondSecond,
    /// The named value asks for what the body of `orbit.body` has not.
    NotOfBody(&'static str),
}

impl Parameters {
    /// The defaults for a camera.
    pub fn for_camera(camera: CameraParameters) -> Self {
        Self {
            camera,
            mount: MountParameters::default(),
            imaging: ImagingParameters::default(),
            detection: DetectionParameters::default(),
            identification: IdentificationParameters::default(),
            tracking: TrackingParameters::default(),
            rate_sensor: None,
            magnetometer: None,
            shutter: None,
            earth: EarthParameters::default(),
            orbit: OrbitParameters::default(),
            modes: ModeParameters::default(),
        }
    }

    /// The same about another body: its ellipsoid, its limb and what it has of the forces. About the Earth
    /// nothing changes.
    pub fn about(mut self, body: CentralBody) -> Self {
        let facts = body.facts();
        self.orbit = self.orbit.about(body);
        let Some(limb) = &facts.limb else { return self };
        let BodyLimb { height_km, height_sigma_km, scatter_km, scale_height_km, lommel_share, .. } = *limb;
        let [sigma_km, cell_km] = limb.field_km;
        self.earth.ellipsoid =
            earth::Ellipsoid { equatorial_km: facts.radius_km as f32, polar_km: facts.polar_km as f32 };
        self.earth.limb = earth::LimbParameters {
            height_km,
            height_sigma_km,
            scatter_km,
            scale_height_km,
            lommel_share,
            ..self.earth.limb
        };
        self.earth.light.twilight_deg = limb.twilight_deg;
        // The default's cells of an Earth's radius.
        let share = (facts.radius_km / EARTH.radius_km) as f32;
        self.earth.horizon = earth::HorizonParameters {
            sigma_km,
            cell_km,
            cloud_cell_km: share * self.earth.horizon.cloud_cell_km,
            ..self.earth.horizon
        };
        self
    }

    /// Sets the parameter of a group and a name, for the host: a number, several, or the number of a choice.
    /// `false`, and no change, where there is none of this name and kind. The table is still to be
    /// [checked](Parameters::check).
    pub fn set(&mut self, group: &str, name: &str, values: &[f32]) -> bool {
        let earth = &mut self.earth;
        match group {
            "imaging" => self.imaging.set(name, values),
            "mount" => self.mount.set(name, values),
            "detection" => self.detection.set(name, values),
            "identification" => self.identification.set(name, values),
            "tracking" => self.tracking.set(name, values),
            "rate_sensor" => self.rate_sensor.as_mut().is_some_and(|noise| noise.set(name, values)),
            "magnetometer" => self.magnetometer.as_mut().is_some_and(|errors| errors.set(name, values)),
            "shutter" => self.shutter.as_mut().is_some_and(|shutter| shutter.set(name, values)),
            "earth.ellipsoid" => earth.ellipsoid.set(name, values),
            "earth.limb" => earth.limb.set(name, values),
            "earth.light" => earth.light.set(name, values),
            "earth.strips" => earth.strips.set(name, values),
            "earth.search" => earth.search.set(name, values),
            "earth.fit" => earth.fit.set(name, values),
            "earth.horizon" => earth.horizon.set(name, values),
            "earth.plausible" => earth.plausible.set(name, values),
            "orbit" => self.orbit.set(name, values),
            "modes" => self.modes.set(name, values),
            _ => false,
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
        let groups = [
            self.imaging.first_out_of_range(),
            self.mount.first_out_of_range(),
            self.detection.first_out_of_range(),
            self.identification.first_out_of_range(),
            self.tracking.first_out_of_range(),
            self.rate_sensor.and_then(|noise| noise.first_out_of_range()),
            self.rate_sensor.and_then(|noise| self.loses_the_stars(&noise, &camera)),
            self.magnetometer.and_then(|errors| errors.first_out_of_range()),
            self.shutter.and_then(|shutter| shutter.first_out_of_range()),
            self.earth.first_out_of_range(),
            self.orbit.first_out_of_range(),
            self.modes.first_out_of_range(),
        ];
        if let Some(name) = groups.into_iter().flatten().next() {
            return Err(ParameterError::Range(name));
        }
        if let Some(name) = self.first_not_of_body() {
            return Err(ParameterError::NotOfBody(name));
        }
        let readout_us = u64::from(self.imaging.row_time_ns) * u64::from(self.camera.height_px) / 1000;
        if u64::from(self.imaging.exposure_us) + readout_us > 1_000_000 {
            return Err(ParameterError::ExposureBeyondSecond);
        }
        let norm = self.mount.star_to_earth.iter().fold(0.0, |sum, q| sum + q * q);
        let star_to_earth = Rotation::from_quaternion(self.mount.star_to_earth);
        match star_to_earth.filter(|_| (0.998..=1.002).contains(&norm)) {
            Some(star_to_earth) => Ok((camera, star_to_earth)),
            None => Err(ParameterError::Range("mount.star_to_earth")),
        }
    }

    /// The first value that does not go with the body. The Earth's ellipsoid is free: pictures of other
    /// bodies are taken by it.
    fn first_not_of_body(&self) -> Option<&'static str> {
        let radius_km = self.orbit.body.facts().radius_km as f32;
        let off_km = self.earth.ellipsoid.equatorial_km - radius_km;
        let another =
            self.orbit.body != CentralBody::Earth && libm::fabsf(off_km) > ELLIPSOID_SHARE * radius_km;
        let magnetic = self.orbit.body != CentralBody::Earth && self.magnetometer.is_some();
        another
            .then_some("earth.ellipsoid.equatorial_km")
            .or(magnetic.then_some("magnetometer"))
            .or(self.orbit.first_not_of_body())
    }

    /// Greatest `rate_sensor.white_rad` that does not lose the stars in a second: a third of the gate, rad.
    pub fn most_white_rad(&self, camera: &Camera) -> f32 {
        f32::from(self.tracking.gate_px) * camera.rad_per_px() * (1.0 / 3.0)
    }

    fn loses_the_stars(&self, noise: &RateSensorNoise, camera: &Camera) -> Option<&'static str> {
        (noise.white_rad > self.most_white_rad(camera)).then_some("rate_sensor.white_rad")
    }
}

impl fmt::Display for ParameterError {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Camera(error) => write!(out, "the camera is impossible: {error}"),
            Self::Range(name) => write!(out, "{name} is outside its range"),
            Self::NotOfBody(name) => write!(out, "{name} asks for what the body of orbit.body has not"),
            Self::ExposureBeyondSecond => out.write_str(
                "imaging.exposure_us and imaging.row_time_ns of all rows are longer than a second: shorten one",
            ),
        }
    }
}

#[cfg(test)]
mod tests;
