//! The `[believed]` of a scenario: how what the flight code is told differs from what is.
//!
//! The world's tables say what is. Here every key is *told less true*: 0 for no difference. The defaults are
//! those of a camera that was calibrated on the ground, on a cooler day, and launched; they are differences
//! of one instrument, the same in every scenario, and do not change with the seed. `differences = false` sets
//! to zero all that the table does not name, so that `[believed]` with this line alone tells the truth.
//!
//! ```toml
//! [believed]
//! differences = false              # all others 0 ...
//! optical_centre_px = [0.05, 0.0]  # ... but this
//! ```
//!
//! | key | default | where the default comes from |
//! |---|---|---|
//! | `focal_length_ppm` | -50 | calibrated 5 K cooler; the lens grows by 10 ppm a kelvin ([`pictures`]) |
//! | `optical_centre_px` | `[0.05, -0.05]` | a lens that moved in its barrel at launch by 0.4 um, pixels of 7.5 um |
//! | `distortion_px` | 0.02 | radial, at the farthest corner; chosen: twice the centroid error of a star of V = 3, for what settles |
//! | `mount_deg` | `[0.003, -0.002, 0.002]` | turns of the star path about its x, y, z: 10 arcsec of a theodolite |
//! | `row_time_percent` | 0.01 | 100 ppm: the quartz of the detector's sequencer |
//! | `gyro_noise_percent` | -20 | noise, walk, bias: a data sheet quotes the typical specimen |
//! | `gyro_scale_percent` | 0.3 | the gyro's readings are so much too large: calibrated at one temperature |
//! | `clock_offset_s` | 0.02 | the way and the processing of a time message from the ground |
//! | `clock_drift_ppm` | 1 | a temperature-compensated quartz: 0.09 s a day |
//! | `detector_gain_percent` | 3 | electrons a digital number, by a photon transfer curve ([`pictures`]) |
//!
//! The camera's differences come beside what `sil-host calibrate` errs by: the reference camera flies as it
//! was calibrated ([`crate::flight::calibrated_camera`]). Its star calibration is made once, from pictures of
//! the cooler lens, and has the gain's difference and no other key ([`crate::calibration`]). What each
//! difference costs is told by `sil-host campaign belief` ([`crate::campaign::belief`]).
//!
//! [`pictures`]: crate::calibration::pictures

use super::text::Text;
use crate::calibration::pictures::{FOCAL_LENGTH_PER_K, GAIN_FOUND, WARMER_K};
use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use crate::world::attitude::{Vector, apply, matrix, quaternion, rotation, small_turn};
use crate::world::instruments::gyro::GyroModel;
use crate::world::motion::pointing::Mount;
use crate::world::vector::{minus, plus, product};
use fsw_hal::{Instant, LocalTime};
use serde::Deserialize;
use toml::Spanned;

/// What the flight code is told, less what is true.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Believed {
    /// Focal length, parts per million.
    pub focal_length_ppm: f64,
    /// Optical centre, px.
    pub optical_centre_px: [f64; 2],
    /// Radial distortion at the farthest corner, px.
    pub distortion_px: f64,
    /// Star path to Earth path: turns about the axes of the star path, degrees.
    pub mount_deg: [f64; 3],
    /// Time from a row to the next, percent.
    pub row_time_percent: f64,
    /// Noise, walk and bias of the gyro, percent.
    pub gyro_noise_percent: f64,
    /// Readings of the gyro, percent.
    pub gyro_scale_percent: f64,
    /// Clock at the start, s.
    pub clock_offset_s: f64,
    /// Rate of the clock, parts per million.
    pub clock_drift_ppm: f64,
    /// Electrons a digital number, percent.
    pub detector_gain_percent: f64,
}

impl Default for Believed {
    fn default() -> Self {
        Self {
            focal_length_ppm: -1e6 * FOCAL_LENGTH_PER_K * WARMER_K,
            optical_centre_px: [0.05, -0.05],
            distortion_px: 0.02,
            mount_deg: [0.003, -0.002, 0.002],
            row_time_percent: 0.01,
            gyro_noise_percent: -20.0,
            gyro_scale_percent: 0.3,
            clock_offset_s: 0.02,
            clock_drift_ppm: 1.0,
            detector_gain_percent: 100.0 * (GAIN_FOUND - 1.0),
        }
    }
}

/// Takes one difference over.
type Take = fn(&mut Believed, &Believed);

/// The differences one by one, by their keys.
pub const PARTS: [(&str, Take); 10] = [
    ("focal_length_ppm", |to, from| to.focal_length_ppm = from.focal_length_ppm),
    ("optical_centre_px", |to, from| to.optical_centre_px = from.optical_centre_px),
    ("distortion_px", |to, from| to.distortion_px = from.distortion_px),
    ("mount_deg", |to, from| to.mount_deg = from.mount_deg),
    ("row_time_percent", |to, from| to.row_time_percent = from.row_time_percent),
    ("gyro_noise_percent", |to, from| to.gyro_noise_percent = from.gyro_noise_percent),
    ("gyro_scale_percent", |to, from| to.gyro_scale_percent = from.gyro_scale_percent),
    ("clock_offset_s", |to, from| to.clock_offset_s = from.clock_offset_s),
    ("clock_drift_ppm", |to, from| to.clock_drift_ppm = from.clock_drift_ppm),
    ("detector_gain_percent", |to, from| to.detector_gain_percent = from.detector_gain_percent),
];

impl Believed {
    /// No difference: the flight code is told the truth.
    pub const TRUTH: Self = Self {
        focal_length_ppm: 0.0,
        optical_centre_px: [0.0; 2],
        distortion_px: 0.0,
        mount_deg: [0.0; 3],
        row_time_percent: 0.0,
        gyro_noise_percent: 0.0,
        gyro_scale_percent: 0.0,
        clock_offset_s: 0.0,
        clock_drift_ppm: 0.0,
        detector_gain_percent: 0.0,
    };

    /// The camera as the flight code is told it; `camera` is as it was calibrated, on a day as warm.
    pub fn camera(&self, camera: &CameraFile) -> CameraFile {
        let mut told = camera.clone();
        told.focal_length_px *= 1.0 + 1e-6 * self.focal_length_ppm;
        for (at, by) in told.optical_centre_px.iter_mut().zip(self.optical_centre_px) {
            *at += by;
        }
        let far =
            |side: u16, centre: f64| centre.max(f64::from(side) - 1.0 - centre) / camera.focal_length_px;
        let [x, y] = camera.optical_centre_px;
        let corner = libm::hypot(far(camera.width_px, x), far(camera.height_px, y));
        told.distortion.k1 += self.distortion_px / (camera.focal_length_px * corner.powi(3));
        told
    }

    /// Star path to Earth path as the flight code is told it, a quaternion.
    pub fn star_to_earth(&self, mount: &Mount) -> [f64; 4] {
        let turn = |axis: usize| rotation(axis, self.mount_deg[axis].to_radians());
        let turned = product(&turn(2), &product(&turn(1), &turn(0)));
        quaternion(&product(&matrix(mount.star_to_earth()), &turned))
    }

    /// By what the Earth path is turned against what the flight code is told, as its pixels show it: a rotation
    /// vector in it, rad. The mount, and an optical centre told wrong, which turns both paths.
    pub fn misalignment_rad(&self, mount: &Mount, camera: &CameraFile) -> Vector {
        let star_to_earth = mount.star_to_earth();
        let of_mount = small_turn(star_to_earth, self.star_to_earth(mount));
        // What is seen at a pixel is told to be beside it; the star path's x runs against the pixels.
        let [x, y] = self.optical_centre_px.map(|px| px / camera.focal_length_px);
        let in_star_path = [y, if camera.mirrored { x } else { -x }, 0.0];
        let by_star_path = apply(&matrix(star_to_earth), in_star_path);
        let by_earth_path = [y, -x, 0.0];
        plus(minus(of_mount, by_earth_path), 1.0, by_star_path)
    }

    /// From a row's exposure to the next row's, s.
    pub fn row_time_s(&self, row_time_s: f64) -> f64 {
        row_time_s * (1.0 + 0.01 * self.row_time_percent)
    }

    /// The gyro as its data sheet has it.
    pub fn gyro(&self, gyro: &GyroModel) -> GyroModel {
        let share = 1.0 + 0.01 * self.gyro_noise_percent;
        GyroModel {
            noise_deg_s: gyro.noise_deg_s * share,
            bias_deg_s: gyro.bias_deg_s * share,
            drift_deg_s_h: gyro.drift_deg_s_h * share,
            ..*gyro
        }
    }

    /// What the gyro's driver makes of a reading, rad/s.
    pub fn gyro_reading(&self, rad_s: [f32; 3]) -> [f32; 3] {
        rad_s.map(|rate| (f64::from(rate) * (1.0 + 0.01 * self.gyro_scale_percent)) as f32)
    }

    /// What counter and clock read `elapsed_us` after power-on, where it is truly `terrestrial_us`; both run
    /// on one quartz.
    pub fn clock(&self, elapsed_us: i64, terrestrial_us: i64) -> Instant {
        let gained_us = (elapsed_us as f64 * 1e-6 * self.clock_drift_ppm).round() as i64;
        let offset_us = (1e6 * self.clock_offset_s).round() as i64;
        Instant::new(LocalTime::from_us(elapsed_us + gained_us), terrestrial_us + offset_us + gained_us)
    }

    /// Electrons a digital number, of the true ones.
    pub fn gain(&self) -> f64 {
        1.0 + 0.01 * self.detector_gain_percent
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBelieved {
    differences: Option<bool>,
    focal_length_ppm: Option<Spanned<f64>>,
    optical_centre_px: Option<Spanned<[f64; 2]>>,
    distortion_px: Option<Spanned<f64>>,
    mount_deg: Option<Spanned<[f64; 3]>>,
    row_time_percent: Option<Spanned<f64>>,
    gyro_noise_percent: Option<Spanned<f64>>,
    gyro_scale_percent: Option<Spanned<f64>>,
    clock_offset_s: Option<Spanned<f64>>,
    clock_drift_ppm: Option<Spanned<f64>>,
    detector_gain_percent: Option<Spanned<f64>>,
}

/// Reads the table.
pub(super) fn read(text: &Text<'_>, raw: &RawBelieved) -> Result<Believed, HostError> {
    let number = |key: &str, value: &Option<Spanned<f64>>, default: f64, most: f64| {
        text.number(&format!("believed.{key}"), value.as_ref(), default, (-most, most))
    };
    let default = if raw.differences == Some(false) { Believed::TRUTH } else { Believed::default() };
    let gain = (&raw.detector_gain_percent, default.detector_gain_percent);
    Ok(Believed {
        focal_length_ppm: number("focal_length_ppm", &raw.focal_length_ppm, default.focal_length_ppm, 1e5)?,
        optical_centre_px: match &raw.optical_centre_px {
            Some(centre) => text.array("believed.optical_centre_px", centre, (-100.0, 100.0))?,
            None => default.optical_centre_px,
        },
        distortion_px: number("distortion_px", &raw.distortion_px, default.distortion_px, 100.0)?,
        mount_deg: match &raw.mount_deg {
            Some(turns) => text.array("believed.mount_deg", turns, (-10.0, 10.0))?,
            None => default.mount_deg,
        },
        row_time_percent: number("row_time_percent", &raw.row_time_percent, default.row_time_percent, 100.0)?,
        gyro_noise_percent: number(
            "gyro_noise_percent",
            &raw.gyro_noise_percent,
            default.gyro_noise_percent,
            99.0,
        )?,
        gyro_scale_percent: number(
            "gyro_scale_percent",
            &raw.gyro_scale_percent,
            default.gyro_scale_percent,
            99.0,
        )?,
        clock_offset_s: number("clock_offset_s", &raw.clock_offset_s, default.clock_offset_s, 3600.0)?,
        clock_drift_ppm: number("clock_drift_ppm", &raw.clock_drift_ppm, default.clock_drift_ppm, 1000.0)?,
        detector_gain_percent: number("detector_gain_percent", gain.0, gain.1, 90.0)?,
    })
}

#[cfg(test)]
mod tests;
