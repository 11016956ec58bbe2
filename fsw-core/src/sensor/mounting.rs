//! How the two paths are mounted, by stars that both of them show (thesis tab. 9.1 and §9.2).
//!
//! Where the filter of the Earth path is out of the way and no light of the Earth is in it, that path is a
//! second field of stars on the same detector. Its attitude against that of the star path is the mounting,
//! with whatever lens and mirror add to it: the angle that an orbit by the limb cannot tell from a place
//! farther along.
//!
//! In: an image with both fields, its attitude by the star path. Out: how many stars the Earth path showed;
//! the misalignment that the orbit goes on with. Stars that contradict each other say nothing; one or two, any
//! of which may be none, wait for another image that agrees with them.

use super::Sensor;
use super::orbit::covariance_rad2;
use super::propagation::Ephemeris;
use super::tracking::turn_of;
use super::workspace::measured;
use crate::attitude::VectorPair;
use crate::attitude::filter::Filter;
use crate::camera::Camera;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::image::DetectionMethod;
use crate::matrix::{Cholesky, add_to_diagonal, cross, dot, rotate_into, scaled, symmetric_product};
use crate::orbit::filter::SeenTurn;
use crate::order::fill;
use crate::plan::{self, MAX_STAR_WINDOWS};
use crate::stars::confirm::{MAX_FEW_STARS, match_predicted_stars};
use crate::stars::predict::field_stars;
use crate::stars::{MeasuredStar, StarField};
use crate::telemetry::AttitudeReport;
use crate::trigonometry::hypotenuse;
use fsw_hal::{Detector, DetectorError, DetectorGeometry, Stage, StageMeter, Window};
use heapless::Vec;
use nalgebra::{Matrix3, RowVector3, Vector3};

/// One of so many seconds.
const EVERY: u32 = 16;
/// Way of the field over the stars to the next image that counts, px: what is wrong with a star's place, pixel
/// and neighbours, stays while it stays where it is. Of 60 flights at rest the mounting was 9 sigma off.
const LEAST_MOVE_PX: f32 = 2.0;
/// So many stars that agree are believed at once, fewer with another image.
const SURE_STARS: u8 = 3;
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

/// What the stars of a path say of its turn against where it was taken to be, a rotation vector in it.
#[derive(Default)]
struct Turned {
    /// Their equations as a triangle: three coefficients, then what was measured, of unit variance.
    triangle: [[f32; 4]; 3],
    /// Square of the residuals.
    square: f32,
    stars: u8,
}

impl Turned {
    /// Takes a star in: the turn `v` moves it from its predicted direction `p` by `p × v`, which along the
    /// first of two axes across `p` is minus the second's product with `v`, along the second the first's.
    fn add(
        &mut self,
        VectorPair { measured, reference, sigma_rad }: &VectorPair,
        attitude: &Rotation<Icrs, StarPath>,
    ) {
        let predicted = attitude.apply(reference);
        let p = predicted.vector();
        // No star of a field is at its pole.
        let along = scaled(&Vector3::new(p.z, 0.0, -p.x), 1.0 / hypotenuse(p.z, p.x));
        let across = cross(p, &along);
        let off = measured.vector() - p;
        for (axis, by) in [(along, -across), (across, along)] {
            let mut equation = [by.x, by.y, by.z, dot(&axis, &off)].map(|value| value / sigma_rad);
            rotate_into(&mut self.triangle, &mut equation);
            let [.., left] = equation;
            self.square += left * left;
        }
        self.stars += 1;
    }

    /// Whether the residuals are as the stars' sigmas say; one star has none.
    fn agrees(&self) -> bool {
        let freedom = (2.0 * f32::from(self.stars) - 3.0).max(0.0);
        // False for what is no number, too.
        self.square <= freedom + SQUARE_SIGMAS * libm::sqrtf(2.0 * freedom)
    }

    /// The same where the path is turned by `also_rad2`, a covariance, on top of it. `None` where that is none.
    fn with(&self, also_rad2: &Matrix3<f32>) -> Option<SeenTurn> {
        let rows = self.triangle.map(|[x, y, z, _]| RowVector3::new(x, y, z));
        let sensitivity = Matrix3::from_rows(&rows);
        let measured = self.triangle.map(|[.., measured]| measured).into();
        let mut covariance = symmetric_product(&sensitivity, also_rad2);
        add_to_diagonal(&mut covariance, 1.0);
        let factor = Cholesky::of(&covariance)?;
        Some(SeenTurn { sensitivity: factor.whitened(&sensitivity), measured: factor.whitened(&measured) })
    }
}

impl Sensor<'_> {
    /// Measures the mounting in an image that shows stars through both paths, other ones than the last or
    /// elsewhere, and tells the orbit of it. How many stars the Earth path showed that do not contradict each
    /// other; `None` in a second without a look.
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
        let Some(star_path) = Rotation::<Icrs, StarPath>::from_quaternion(attitude.quaternion) else {
            return Ok(None);
        };
        let sight = star_path.then(&self.mounting()).matrix().row(2).transpose();
        let least_move_rad = LEAST_MOVE_PX * self.camera.rad_per_px();
        let moved = sight - self.mounting_seen_at;
        if dot(&moved, &moved) < least_move_rad * least_move_rad {
            return Ok(None);
        }
        meter.begin(Stage::Limb);
        let seen = self.see_mounting(detector, ephemeris, (&star_path, attitude.sigma_rad));
        meter.end(Stage::Limb);
        let Some((stars, turn)) = seen? else { return Ok(Some(0)) };
        self.mounting_seen_at = sight;
        meter.begin(Stage::Orbit);
        self.orbit.observe_mounting(&turn, stars >= SURE_STARS, &self.parameters.orbit);
        meter.end(Stage::Orbit);
        Ok(Some(stars))
    }

    /// How many stars of the Earth path are seen, and what they say of its turn; `None` where there are none,
    /// they contradict each other, or it is not known where the Earth hides them.
    fn see_mounting(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        ephemeris: &Ephemeris,
        (star_path, sigma_rad): (&Rotation<Icrs, StarPath>, [f32; 3]),
    ) -> Result<Option<(u8, SeenTurn)>, DetectorError> {
        let field = self.second_field(ephemeris, star_path, &detector.geometry());
        let Some(field) = field else { return Ok(None) };
        let (parameters, calibration) = (&self.parameters.detection, self.calibration.as_ref());
        let turn =
            field.rate_rad_s.map(|rate_rad_s| turn_of(&field.camera, &(rate_rad_s * self.exposure_s())));
        let method = DetectionMethod { parameters, calibration, turn };
        self.workspace.read_windows(detector, &field.windows, &method)?;
        Ok(self.turn_seen(&field, sigma_rad))
    }

    /// The Earth path's stars that no part of the Earth hides, by the attitude of the star path; `None` where
    /// it is not known where the Earth is.
    #[inline(never)]
    fn second_field(
        &self,
        ephemeris: &Ephemeris,
        star_path: &Rotation<Icrs, StarPath>,
        geometry: &DetectorGeometry,
    ) -> Option<SecondField> {
        let camera = self.camera.of_earth_path();
        let attitude = Rotation::from_quaternion(star_path.then(&self.mounting()).quaternion())?;
        let view = self.known_view(ephemeris, star_path)?;
        let gate_px = self.parameters.tracking.gate_px;
        let mask = self.mask(&view, gate_px);
        let hidden = |at_px| camera.earth_direction(at_px).is_none_or(|direction| mask.covers(&direction));
        let stars = field_stars(&self.catalogue, &camera, &attitude)?;
        let mut windows = plan::star_windows(&stars, geometry, gate_px, hidden);
        windows.truncate(MAX_FEW_STARS);
        let rate = self.motion.as_ref().and_then(Filter::rate);
        let rate_rad_s = rate.map(|rate| self.mounting().matrix() * rate.rad_s);
        Some(SecondField { camera, attitude, windows, rate_rad_s })
    }

    /// What the spots of the windows say of the path's turn.
    #[inline(never)]
    fn turn_seen(&self, field: &SecondField, sigma_rad: [f32; 3]) -> Option<(u8, SeenTurn)> {
        let SecondField { camera, attitude, rate_rad_s, .. } = field;
        let mut spots = Vec::<MeasuredStar, MAX_SPOTS>::new();
        let detections = &self.workspace.detections;
        fill(&mut spots, measured(detections, camera, rate_rad_s.as_ref(), self.row_time_s()));
        let stars = StarField::whole(&spots, &self.catalogue, camera).calibrated(self.calibration.as_ref());
        let mut turned = Turned::default();
        for (_, pair) in &match_predicted_stars(attitude, &stars, f32::from(self.parameters.tracking.gate_px))
        {
            turned.add(pair, attitude);
        }
        let turn = turned.with(&self.in_earth_path(&covariance_rad2(sigma_rad)))?;
        (turned.stars > 0 && turned.agrees()).then_some((turned.stars, turn))
    }
}
