//! How the two paths are mounted, by stars that both of them show (thesis tab. 9.1 and §9.2).
//!
//! Where the filter of the Earth path is out of the way and no light of the Earth is in it, that path is a
//! second field of stars on the same detector. Its attitude against that of the star path is the mounting,
//! with whatever lens and mirror add to it: the angle that an orbit by the limb cannot tell from a place
//! farther along.
//!
//! In: an image with both fields, its attitude by the star path. Out: how many stars the Earth path showed;
//! the misalignment that the orbit goes on with. A field whose stars contradict each other says nothing.

use super::Sensor;
use super::propagation::Ephemeris;
use super::workspace::measured;
use crate::attitude::VectorPair;
use crate::attitude::covariance::Information;
use crate::attitude::filter::Filter;
use crate::attitude::wahba::svd;
use crate::camera::{Camera, CameraParameters};
use crate::earth::reach;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::image::DetectionMethod;
use crate::image::turn::Turn;
use crate::matrix::symmetric_product;
use crate::order::fill;
use crate::plan::{self, MAX_STAR_WINDOWS};
use crate::stars::confirm::{MAX_FEW_STARS, match_predicted_stars};
use crate::stars::predict::field_stars;
use crate::stars::{MeasuredStar, StarField};
use crate::telemetry::AttitudeReport;
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Stage, StageMeter, Window};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// One of so many seconds: what is wrong with a star's place, pixel, lens and neighbours, lasts for some.
const EVERY: u32 = 16;
/// Two stars fix a field's attitude, a third one tests it.
const FEWEST_STARS: usize = 3;
/// Most spots in windows about [`MAX_FEW_STARS`] stars that are used.
const MAX_SPOTS: usize = 2 * MAX_FEW_STARS;
/// Sigmas within which the square of a field's residuals over theirs must be what is expected.
const SQUARE_SIGMAS: f32 = 4.0;

/// The Earth path as if it were a star path, which differs by the mirror alone.
struct SecondField {
    camera: Camera,
    attitude: Rotation<Icrs, StarPath>,
    windows: Vec<Window, MAX_STAR_WINDOWS>,
    /// Of this path in its own axes, where it is known.
    rate_rad_s: Option<Vector3<f32>>,
}

impl SecondField {
    /// How the path turns during an exposure.
    fn turn(&self, exposure_s: f32) -> Option<Turn> {
        let CameraParameters { optical_centre_px, focal_length_px, mirrored, .. } = *self.camera.parameters();
        let turn_rad = self.rate_rad_s? * exposure_s;
        Some(Turn::new(optical_centre_px, focal_length_px, mirrored, turn_rad.into()))
    }
}

/// The mounting as an image shows it.
struct Mounted {
    stars: u8,
    /// By what the Earth path is turned against where it was taken to be, and the covariance of that: a
    /// rotation vector in the Earth path.
    turn_rad: Vector3<f32>,
    covariance_rad2: Matrix3<f32>,
}

impl Sensor<'_> {
    /// Measures the mounting in an image that shows stars through both paths, and tells the orbit of it. How
    /// many stars the Earth path showed; 0 where they fix no attitude, `None` in a second without a look.
    ///
    /// # Errors
    /// Of the detector.
    #[inline(never)]
    pub(super) fn measure_mounting(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: &Ephemeris,
        attitude: &AttitudeReport,
    ) -> Result<Option<u8>, DetectorError> {
        if !self.cycle.is_multiple_of(EVERY) || self.turning.is_of_lines() {
            return Ok(None);
        }
        meter.begin(Stage::Limb);
        let seen = self.see_mounting(detector, ephemeris, attitude);
        meter.end(Stage::Limb);
        let Some(Mounted { stars, turn_rad, covariance_rad2 }) = seen? else { return Ok(Some(0)) };
        meter.begin(Stage::Orbit);
        self.orbit.observe_mounting(&turn_rad, &covariance_rad2, &self.parameters.orbit);
        meter.end(Stage::Orbit);
        Ok(Some(stars))
    }

    /// The mounting by the stars of the Earth path; `None` where they fix no attitude, or it is not known
    /// where the Earth hides them.
    fn see_mounting(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        ephemeris: &Ephemeris,
        attitude: &AttitudeReport,
    ) -> Result<Option<Mounted>, DetectorError> {
        let field = self.second_field(ephemeris, attitude, &detector.geometry());
        let Some(field) = field else { return Ok(None) };
        let (parameters, calibration) = (&self.parameters.detection, self.calibration.as_ref());
        let method = DetectionMethod { parameters, calibration, turn: field.turn(self.exposure_s()) };
        self.workspace.read_windows(detector, &field.windows, &method)?;
        Ok(self.mounted(&field, attitude.sigma_rad))
    }

    /// The Earth path's stars that no part of the Earth hides, by the attitude of the star path; `None` where
    /// it is not known where the Earth is.
    #[inline(never)]
    fn second_field(
        &self,
        ephemeris: &Ephemeris,
        attitude: &AttitudeReport,
        geometry: &DetectorGeometry,
    ) -> Option<SecondField> {
        let star_path = Rotation::from_quaternion(attitude.quaternion)?;
        let camera = self.camera.of_earth_path();
        let attitude = Rotation::from_quaternion(star_path.then(&self.mounting()).quaternion())?;
        let view = self.known_view(ephemeris, &star_path)?;
        let gate_px = self.parameters.tracking.gate_px;
        let glow_rad = reach::glow_km(&self.parameters.earth) / view.limb_distance_km();
        let mask = view.mask(glow_rad + f32::from(gate_px) * camera.rad_per_px(), &self.parameters.earth);
        let hidden = |at_px| camera.earth_direction(at_px).is_none_or(|direction| mask.covers(&direction));
        let stars = field_stars(&self.catalogue, &camera, &attitude)?;
        let mut windows = plan::star_windows(&stars, geometry, gate_px, hidden);
        windows.truncate(MAX_FEW_STARS);
        let rate = self.motion.as_ref().and_then(Filter::rate);
        let rate_rad_s = rate.map(|rate| self.mounting().matrix() * rate.rad_s);
        Some(SecondField { camera, attitude, windows, rate_rad_s })
    }

    /// The mounting by the spots of the windows; `None` where they are too few or contradict each other.
    #[inline(never)]
    fn mounted(&self, field: &SecondField, sigma_rad: [f32; 3]) -> Option<Mounted> {
        let SecondField { camera, attitude, rate_rad_s, .. } = field;
        let mut spots = Vec::<MeasuredStar, MAX_SPOTS>::new();
        let detections = &self.workspace.detections;
        fill(&mut spots, measured(detections, camera, rate_rad_s.as_ref(), self.row_time_s()));
        let stars = StarField::whole(&spots, &self.catalogue, camera).calibrated(self.calibration.as_ref());
        let matches = match_predicted_stars(attitude, &stars, f32::from(self.parameters.tracking.gate_px));
        if matches.len() < FEWEST_STARS {
            return None;
        }
        let mut pairs = Vec::<VectorPair, MAX_FEW_STARS>::new();
        fill(&mut pairs, matches.iter().map(|(_, pair)| *pair));
        let seen = svd::solve(&pairs).ok()?;
        let square = pairs.iter().fold(0.0, |sum, VectorPair { measured, reference, sigma_rad }| {
            let off = measured.vector() - seen.apply(reference).vector();
            sum + off.dot(&off) / (sigma_rad * sigma_rad)
        });
        let freedom = 2.0 * pairs.len() as f32 - 3.0;
        // Refuses what is no number, too.
        let agree = square <= freedom + SQUARE_SIGMAS * libm::sqrtf(2.0 * freedom);
        let [x, y, z] = sigma_rad.map(|sigma| sigma * sigma);
        let of_star_path = Matrix3::from_diagonal(&Vector3::new(x, y, z));
        let covariance_rad2 = Information::of(&pairs).covariance_rad2().filter(|_| agree)?
            + symmetric_product(self.mounting().matrix(), &of_star_path);
        Some(Mounted { stars: pairs.len() as u8, turn_rad: seen.angle_from(attitude), covariance_rad2 })
    }
}
