//! What the flight code is told of a scenario: lens, bad pixels, parameters, the state by the ground.
//!
//! Made here alone, through what is believed of camera, mounting, shutter and gyro ([`super::believed`]).

use super::Scenario;
use crate::calibration::pictures::GAIN_FOUND;
use crate::error::HostError;
use crate::flight::{self, StarCalibration};
use crate::formats::camera_file::CameraFile;
use crate::formats::defects_file;
use crate::judge::second::orbit_axes;
use crate::world::attitude::apply;
use crate::world::instruments::magnetometer::MagnetometerModel;
use crate::world::motion::slew::Slew;
use crate::world::vector::{plus, transposed};
use fsw_core::attitude::filter::RateSensorNoise;
use fsw_core::camera::Camera;
use fsw_core::image::calibration::Calibration;
use fsw_core::orbit::OrbitState;
use fsw_core::orbit::parameters::{Misalignment, OrbitParameters};
use fsw_core::parameters::{
    ImagingParameters, MountParameters, ParameterError, Parameters, TrackingParameters,
};
use fsw_core::stars::identify::IdentificationParameters;

impl Scenario {
    /// What the flight code knows of the lens; nothing where it cannot be calibrated.
    ///
    /// # Errors
    /// When the camera file names a table that cannot be read.
    pub fn calibration(&self) -> Result<Option<StarCalibration>, HostError> {
        let made = flight::calibration(&self.camera, &self.imaging, &self.detector)?;
        Ok(made.map(|calibration| calibration.with_gain(self.believed.gain() / GAIN_FOUND)))
    }

    /// The camera as the flight code is told it.
    pub fn believed_camera(&self) -> CameraFile {
        self.believed.camera(&flight::calibrated_camera(&self.camera))
    }

    /// The flight code's parameters for this scenario, with this calibration: the only place where they are
    /// made, all from what is [believed](super::Believed).
    pub fn flight_parameters(&self, calibration: Option<&Calibration>) -> Parameters {
        let camera = flight::camera_parameters(&self.believed_camera());
        let defaults = Parameters::for_camera(camera).about(self.forces.body);
        let star_to_earth = self.believed.star_to_earth(&self.mount).map(|part| part as f32);
        let mount = MountParameters { star_to_earth, ..defaults.mount };
        let row_time_s = self.believed.row_time_s(self.imaging.shutter.row_time_s());
        let calibration_crc = calibration.map_or(0, Calibration::crc);
        let identification = match calibration {
            Some(_) => IdentificationParameters::of_calibrated_lens(),
            None => IdentificationParameters::default(),
        };
        // One that the flight code would refuse, as too noisy, is left to the report.
        let rate_sensor = self.gyro_noise().filter(|noise| check_gyro(&defaults, *noise).is_ok());
        // What is beyond the parameters' range flies with its end.
        let [drag_m2_kg, radiation_m2_kg] =
            [self.forces.drag_m2_kg(), self.forces.radiation_m2_kg()].map(|share| share.min(10.0) as f32);
        let manoeuvre_rad_s2 = self.pointing.slews.iter().map(Slew::peak_rad_s2).fold(0.0, f64::max).min(1.0);
        let tracking = TrackingParameters { manoeuvre_rad_s2: manoeuvre_rad_s2 as f32, ..defaults.tracking };
        let mut orbit = OrbitParameters { drag_m2_kg, radiation_m2_kg, ..defaults.orbit };
        orbit.observation = self.orbit_filter.observation.unwrap_or(orbit.observation);
        if let Some(sigma_deg) = self.orbit_filter.misalignment_sigma_deg {
            orbit.misalignment = Misalignment::Estimated;
            orbit.misalignment_sigma_rad = sigma_deg.to_radians() as f32;
        }
        let mut parameters = Parameters {
            identification,
            tracking,
            orbit,
            rate_sensor,
            magnetometer: self.magnetometer.as_ref().map(MagnetometerModel::flight_errors),
            shutter: self.shutters,
            imaging: ImagingParameters {
                exposure_us: self.exposure_us,
                row_time_ns: libm::round(1e9 * row_time_s) as u32,
                calibration_crc,
            },
            mount,
            ..defaults
        };
        for told in &self.parameters {
            told.put_into(&mut parameters);
        }
        parameters
    }

    /// Why the gyro is on board and not used, where that is so.
    pub fn unused_gyro(&self) -> Option<String> {
        let (flight, noise) = (self.flight_parameters(None), self.gyro_noise()?);
        let refusal = check_gyro(&flight, noise).err()?;
        let camera = Camera::new(flight.camera).ok()?;
        let (noise_deg, most_deg) =
            (noise.white_rad.to_degrees(), flight.most_white_rad(&camera).to_degrees());
        Some(format!(
            "the gyro is not used, only reported, as {refusal}: it loses {noise_deg:.2} deg in a second, of at most \
             {most_deg:.2} deg, a third of a star window's half side; see the table [gyro]"
        ))
    }

    /// The gyro's errors as the flight code is told them.
    fn gyro_noise(&self) -> Option<RateSensorNoise> {
        Some(self.believed.gyro(self.gyro.as_ref()?).flight_noise())
    }

    /// Says on stderr, in a line, what is on board and not used.
    pub fn warn(&self) {
        if let Some(words) = self.unused_gyro() {
            eprintln!("{}: {}: {words}", crate::words::name(), self.file.display());
        }
    }

    /// The file of the detector's defects as they are known on board.
    pub fn known_defects(&self) -> Vec<u8> {
        let geometry = self.camera.geometry();
        let known = self.disturbances.surveyed(self.seed, geometry);
        defects_file::table([geometry.width_px, geometry.height_px], &known, &[])
    }

    /// The state that the ground tells the flight code at the start.
    pub fn ground_state(&self) -> Option<OrbitState> {
        let start = self.orbit_filter.start.as_ref()?;
        let (r, v) = (self.position_km, self.velocity_km_s);
        let axes = transposed(&orbit_axes(r, v)?);
        let [position_error_km, velocity_error_m_s] = start.errors(self.seed);
        let velocity_error_km_s = velocity_error_m_s.map(|error| 1e-3 * error);
        Some(OrbitState {
            time_us: self.start_us,
            position_km: plus(r, 1.0, apply(&axes, position_error_km)).into(),
            velocity_km_s: plus(v, 1.0, apply(&axes, velocity_error_km_s)).into(),
        })
    }
}

/// Whether the flight code takes a gyro of these errors, beside these parameters.
fn check_gyro(parameters: &Parameters, noise: RateSensorNoise) -> Result<(), ParameterError> {
    Parameters { rate_sensor: Some(noise), ..*parameters }.check().map(|_| ())
}
