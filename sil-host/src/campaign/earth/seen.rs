//! What the ways of looking make of a frame, and how wrong they are.
//!
//! In: a frame with its truth. Out: for every [`Way`] a [`Seen`]: the error of the direction to the Earth's
//! centre on two axes across it, of the distance, their sigmas, and what the covariance says of them.
//!
//! Axes: x across the line to the centre towards the Sun, y across both. Truth is the vector to the centre,
//! displaced by the aberration with which the world draws the Earth (the orbit takes it off, not the Earth
//! room).

use super::cases::{Case, Drawn};
use super::limit::{self, Limb};
use crate::commands::earth::of_a_mean_sphere;
use crate::error::HostError;
use crate::flight;
use crate::formats::picture::Picture;
use crate::world::attitude::{Vector, apply, dot};
use crate::world::earth::EQUATOR_KM;
use crate::world::earth::heights::Heights;
use crate::world::noise::Noise;
use crate::world::time::ephemeris::LIGHT_KM_S;
use crate::world::vector::{cross, length, minus, plus, times, unit};
use fsw_core::camera::Camera;
use fsw_core::earth::centre::{self, CentrePrior};
use fsw_core::earth::comparison::scale::{LimbPoints, Scale};
use fsw_core::earth::comparison::{filters, thesis};
use fsw_core::earth::limb::{BREADTH, MAX_LENGTH};
use fsw_core::earth::limb_sensor::{self, Buffers, EVEN_STRIPS, HeightVariance, LimbSensor};
use fsw_core::earth::search::Points;
use fsw_core::earth::view::View;
use fsw_core::earth::{Body, EarthFix, EarthParameters, FitCriteria, FitError, Strips};
use fsw_core::frames::{Direction, EarthPath, Icrs, Rotation, StarPath};
use fsw_core::matrix::inverse;
use fsw_core::orbit::point::{PositionFix, earth_to_icrs};
use fsw_hal::{Detector, DetectorError};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Rows of the noise for the orbit's errors and for the attitude's.
const ORBIT: u32 = 0;
const ATTITUDE: u32 = 1;
/// Shares of the pixels that are darker than what counts as dark and as bright, and where the latter goes.
const DARK_SHARE: f64 = 0.02;
const BRIGHT_SHARE: f64 = 0.99;
const WHITE_SHARE: f64 = 0.9;
const ARCSEC_RAD: f64 = std::f64::consts::PI / (180.0 * 3600.0);
/// Sigma of the orbit's prediction an axis, km.
const ORBIT_SIGMA_KM: f64 = 3.0;
/// Sigma of the star attitude about x, y, z of the star path, arcsec: that of `sil-host campaign acquire`.
const ATTITUDE_ARCSEC: [f64; 3] = [1.5, 1.5, 5.2];

/// A way of looking.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// Nothing known: a mean sphere, lit all round.
    Lost,
    /// The pole known, the Sun not.
    Pole,
    /// Both known, as after the first attitude.
    Sun,
    /// In strips about where the orbit expects the limb.
    Tracked,
    /// As `Sun`, the limb in a strip by the exponential filter.
    Exponential,
    /// As `Sun`, by the polynomial of the fifth order.
    Polynomial,
    /// The thesis's method.
    Thesis,
}

/// All, in the order of the table.
pub const WAYS: [Way; 7] =
    [Way::Lost, Way::Pole, Way::Sun, Way::Tracked, Way::Exponential, Way::Polynomial, Way::Thesis];

impl Way {
    /// Whether the goals are those of this way: the flight's, which looks at the Earth when it has an
    /// attitude and so knows pole and Sun.
    pub fn has_goal(self) -> bool {
        matches!(self, Self::Sun | Self::Tracked)
    }
}

/// What a way came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// The way.
    pub way: Way,
    /// Why there is no centre; none where there is one.
    pub refused: Option<String>,
    /// The centre.
    pub fix: Option<Fix>,
}

/// A centre beside the truth.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fix {
    /// Error of the direction towards the Sun and across, deg.
    pub error_deg: [f64; 2],
    /// Sigmas of these, deg; none for the thesis's method, nor below.
    pub sigma_deg: Option<[f64; 2]>,
    /// Error of the half angle of the limb, deg.
    pub radius_error_deg: f64,
    /// Error of the distance, km.
    pub distance_error_km: f64,
    /// Its sigma, km.
    pub distance_sigma_km: Option<f64>,
    /// Normalised error squared of the centre, three degrees of freedom.
    pub nees: Option<f64>,
    /// Error of the direction with the distance known, deg.
    pub known_distance_error_deg: Option<[f64; 2]>,
    /// Arc, deg.
    pub arc_deg: Option<f64>,
    /// Root mean square of the points about the limb, px.
    pub rms_px: Option<f64>,
    /// By what share of itself the focal length seems longer, the distance known from the orbit, and its
    /// sigma; when tracking.
    pub focal_length: Option<[f64; 2]>,
    /// Error of the position made with a star attitude, an axis across the line to the centre and along it,
    /// and its sigmas, km.
    pub position_km: Option<[f64; 2]>,
    /// Its sigmas, km.
    pub position_sigma_km: Option<[f64; 2]>,
}

impl Fix {
    /// Every number through `of`.
    pub(super) fn map(&mut self, of: fn(f64) -> f64) {
        let single = [&mut self.radius_error_deg, &mut self.distance_error_km];
        let optional = [&mut self.distance_sigma_km, &mut self.nees, &mut self.arc_deg, &mut self.rms_px]
            .into_iter()
            .flatten();
        let pairs = [
            &mut self.sigma_deg,
            &mut self.known_distance_error_deg,
            &mut self.focal_length,
            &mut self.position_km,
            &mut self.position_sigma_km,
        ];
        let pairs = pairs.into_iter().flatten().flatten();
        for value in single.into_iter().chain(optional).chain(pairs).chain(&mut self.error_deg) {
            *value = of(*value);
        }
    }
}

/// A frame held, with all that is known of it.
pub struct Frame {
    picture: Picture,
    camera: Camera,
    focal_length_px: f64,
    exposure_us: u32,
    /// To the centre as it is seen, Earth path's frame, km.
    centre_km: Vector,
    /// Axes across it.
    axes: [Vector; 2],
    pole: Vector,
    sun: Vector,
    position_km: Vector,
    velocity_km_s: Vector,
    /// As the stars show it.
    attitude: Rotation<Icrs, StarPath>,
    mounting: Rotation<EarthPath, StarPath>,
}

impl Frame {
    /// Reads a view's frame out.
    ///
    /// # Errors
    /// None but a fault of this program.
    pub fn new(mut drawn: Drawn, case: &Case, noise: &Noise) -> Result<Self, HostError> {
        let fault = |what: String| HostError::usage(what, "report this");
        let geometry = drawn.scene.geometry();
        let mut pixels = vec![0; geometry.whole().area()];
        drawn.scene.read(geometry.whole(), &mut pixels).map_err(|error| fault(format!("{error:?}")))?;
        let picture =
            Picture::from_pixels(geometry, pixels).ok_or_else(|| fault("the frame is none".into()))?;
        let truth = &drawn.truth;
        let path = |vector: Vector| apply(&truth.earth_path, vector);
        let down_km = times(-1.0, truth.position_km);
        let ahead = times(length(down_km) / LIGHT_KM_S, truth.velocity_km_s);
        let down = unit(down_km);
        let across = minus(ahead, times(dot(ahead, down), down));
        let centre_km = path(plus(down_km, 1.0, across));
        let (centre, sun) = (unit(centre_km), path(truth.sun));
        let x = unit(minus(sun, times(dot(sun, centre), centre)));
        let errs = |axis: u32| ARCSEC_RAD * ATTITUDE_ARCSEC[axis as usize] * noise.gaussian(axis, ATTITUDE);
        let rotation = |q: [f64; 4]| q.map(|part| part as f32);
        let attitude = Rotation::from_quaternion(rotation(truth.quaternion))
            .map(|attitude| attitude.turned(&Vector3::new(0, 1, 2).map(|axis| errs(axis) as f32)));
        let mounting =
            Rotation::<StarPath, EarthPath>::from_quaternion(rotation(drawn.mount.star_to_earth()));
        let (Some(attitude), Some(mounting)) = (attitude, mounting) else {
            return Err(fault("the attitude is none".into()));
        };
        Ok(Self {
            picture,
            camera: flight::camera(&drawn.camera, Path::new("the camera of the campaign"))?,
            focal_length_px: drawn.camera.focal_length_px,
            exposure_us: case.exposure_us,
            centre_km,
            axes: [x, cross(centre, x)],
            pole: path(truth.ellipsoid.equator()[2]),
            sun,
            position_km: truth.position_km,
            velocity_km_s: truth.velocity_km_s,
            attitude,
            mounting: mounting.inverse(),
        })
    }

    /// Looks in all ways; `noise` errs for the orbit.
    pub fn look(&mut self, noise: &Noise) -> Result<Vec<Seen>, HostError> {
        WAYS.into_iter().map(|way| self.look_by(way, noise)).collect()
    }

    /// The best that any unbiased method could do with this frame, Sun and pole known.
    pub fn limit_deg(&self, heights: &Heights) -> Option<[f64; 2]> {
        let parameters = EarthParameters::default();
        let body = Body::new(&direction(self.pole), Some(&direction(self.sun)), &parameters);
        let view = View::new(&Vector3::from(self.centre_km).map(|c| c as f32), &body)?;
        limit::direction_deg(&Limb::of(&view, &self.camera, self.axes, &parameters), heights)
    }

    /// Looks in one way.
    ///
    /// # Errors
    /// None but a fault of this program.
    pub fn look_by(&mut self, way: Way, noise: &Noise) -> Result<Seen, HostError> {
        let fault = |error| HostError::usage(format!("the frame failed ({error:?})"), "report this");
        self.picture.expose(self.exposure_us).map_err(fault)?;
        let fix = if way == Way::Thesis {
            let points = self.points_of_the_thesis().map_err(fault)?;
            self.circle_of_the_thesis(&points, thesis::ECCENTRICITY)
        } else {
            self.by_the_flight_code(way, noise).map_err(fault)?
        };
        Ok(match fix {
            Ok(fix) => Seen { way, refused: None, fix: Some(fix) },
            Err(refusal) => Seen { way, refused: Some(format!("{refusal:?}")), fix: None },
        })
    }

    fn by_the_flight_code(
        &mut self,
        way: Way,
        noise: &Noise,
    ) -> Result<Result<Fix, FitError>, DetectorError> {
        let mut parameters = EarthParameters::default();
        if way == Way::Lost {
            parameters = of_a_mean_sphere(parameters);
        }
        let sun = Some(direction(self.sun)).filter(|_| !matches!(way, Way::Lost | Way::Pole));
        let body = Body::new(&direction(self.pole), sun.as_ref(), &parameters);
        let limb_sensor =
            LimbSensor { camera: &self.camera, body: &body, parameters: &parameters, turn: None };
        let longer = usize::from(self.picture.geometry().width_px.max(self.picture.geometry().height_px));
        let (mut buffer, mut points) = (vec![0; longer.max(BREADTH * MAX_LENGTH)], Points::new());
        let mut rays = Box::new(centre::RayBuffer::new());
        let mut buffers = Buffers { buffer: &mut buffer, points: &mut points, rays: &mut rays };
        let picture = &mut self.picture;
        let tracked = match way {
            Way::Tracked => match Tracked::new(&limb_sensor, self.centre_km, noise) {
                Some(tracked) => Some(tracked),
                None => return Ok(Err(FitError::Degenerate)),
            },
            _ => None,
        };
        let fix = match (way, &tracked) {
            (_, Some(tracked)) => tracked.fix(&limb_sensor, picture, &mut buffers)?,
            (Way::Exponential, _) => {
                limb_sensor::acquire_with(&limb_sensor, picture, &mut buffers, filters::exponential)?.fix
            }
            (Way::Polynomial, _) => {
                limb_sensor::acquire_with(&limb_sensor, picture, &mut buffers, filters::polynomial)?.fix
            }
            _ => limb_sensor::acquire(&limb_sensor, picture, &mut buffers)?.fix,
        };
        let scale =
            tracked.filter(|_| fix.is_ok()).and_then(|tracked| tracked.scale(&limb_sensor, &mut buffers));
        Ok(fix.map(|fix| {
            let focal_length = scale.map(|scale| [f64::from(scale.share), scale.sigma.into()]);
            Fix { focal_length, ..self.judged(&fix) }
        }))
    }

    /// A centre of the flight code beside the truth.
    fn judged(&self, fix: &EarthFix) -> Fix {
        let seen_km: Vector = fix.centre_km.map(f64::from).into();
        let covariance = fix.covariance_km2.map(f64::from);
        let (distance_km, truth) = (length(self.centre_km), Vector3::from(unit(self.centre_km)));
        let [x, y] = self.axes.map(Vector3::from);
        let error = Vector3::from(minus(seen_km, self.centre_km));
        let sigma_km = |axis: &Vector3<f64>| axis.dot(&(covariance * axis)).max(0.0).sqrt();
        let deg = |across_km: f64| (across_km / distance_km).to_degrees();
        // Given the distance, what is left of the error across: that of a measurement without noise.
        let along = covariance * truth / sigma_km(&truth).powi(2).max(1e-12);
        let left = error - along * truth.dot(&error);
        let mut judged = self.beside(seen_km);
        judged.sigma_deg = Some([deg(sigma_km(&x)), deg(sigma_km(&y))]);
        judged.distance_sigma_km = Some(sigma_km(&truth));
        judged.nees = inverse(&covariance).map(|inverse| error.dot(&(inverse * error)));
        judged.known_distance_error_deg = Some([deg(x.dot(&left)), deg(y.dot(&left))]);
        judged.arc_deg = Some(f64::from(fix.arc_rad).to_degrees());
        judged.rms_px = Some(fix.rms_px.into());
        if let Some((error_km, sigma_km)) = self.position(fix) {
            (judged.position_km, judged.position_sigma_km) = (Some(error_km), Some(sigma_km));
        }
        judged
    }

    /// Error and sigma of the position that this centre and the stars' attitude make: an axis across the line
    /// to the centre, and along it, km.
    fn position(&self, fix: &EarthFix) -> Option<([f64; 2], [f64; 2])> {
        let variances = ATTITUDE_ARCSEC.map(|sigma| (ARCSEC_RAD * sigma).powi(2) as f32);
        let attitude_covariance = Matrix3::from_diagonal(&Vector3::from(variances));
        let EarthFix { centre_km, covariance_km2, linearisation_km, .. } = fix;
        let to_icrs = earth_to_icrs(&self.attitude, &self.mounting);
        let fix = PositionFix::new(
            centre_km,
            [covariance_km2, &Matrix3::zeros()],
            linearisation_km,
            &to_icrs,
            &attitude_covariance,
            &self.mounting,
        )?
        .without_aberration(&self.velocity_km_s.into());
        let up = Vector3::from(unit(self.position_km));
        let error = fix.position_km - Vector3::from(self.position_km);
        let along_km = up.dot(&error);
        let along_km2 = up.dot(&(fix.covariance_km2 * up));
        let of_an_axis = |both_km2: f64, along_km2: f64| (0.5 * (both_km2 - along_km2)).max(0.0).sqrt();
        let across_km = of_an_axis(error.dot(&error), along_km * along_km);
        let across_sigma_km = of_an_axis(fix.covariance_km2.trace(), along_km2);
        Some(([across_km, along_km], [across_sigma_km, along_km2.max(0.0).sqrt()]))
    }

    /// A vector to the centre beside the truth.
    fn beside(&self, seen_km: Vector) -> Fix {
        let (seen, distance_km) = (unit(seen_km), length(seen_km));
        let truth_km = length(self.centre_km);
        let half_deg = |distance_km: f64| libm::asin((EQUATOR_KM / distance_km).min(1.0)).to_degrees();
        Fix {
            error_deg: self.axes.map(|axis| dot(seen, axis).to_degrees()),
            radius_error_deg: half_deg(distance_km) - half_deg(truth_km),
            distance_error_km: distance_km - truth_km,
            ..Fix::default()
        }
    }

    /// The limb points by the thesis's local criteria. Its thresholds are those of pictures that fill their
    /// scale, so it gets the frame stretched (`stretched`).
    ///
    /// # Errors
    /// Of the detector.
    pub fn points_of_the_thesis(&self) -> Result<Points, DetectorError> {
        let mut points = Points::new();
        let mut picture = stretched(&self.picture).ok_or(DetectorError::BufferLength)?;
        picture.expose(self.exposure_us)?;
        thesis::limb_points(&mut picture, &mut [0; 4096], &mut points)?;
        Ok(points)
    }

    /// The thesis's circle through these points, circularised with an eccentricity, as a vector: its centre
    /// through the lens, the distance from its radius (eq. 2.8).
    ///
    /// # Errors
    /// Why there is none.
    pub fn circle_of_the_thesis(&self, points: &Points, eccentricity: f32) -> Result<Fix, FitError> {
        let at = |vector: Vector| self.camera.project_earth(&direction(vector));
        // The pole's direction on the detector, where the centre and a place north of it are before the
        // camera.
        let north_km = plus(self.centre_km, 0.1 * EQUATOR_KM, self.pole);
        let pole_px = match at(self.centre_km).zip(at(north_km)) {
            Some((centre, north)) => [north[0] - centre[0], north[1] - centre[1]],
            None => [self.pole[0] as f32, self.pole[1] as f32],
        };
        thesis::circle(points, pole_px, eccentricity).map(|circle| {
            let [cx, cy] = self.camera.parameters().optical_centre_px;
            let [x, y] = circle.centre_px;
            let f = self.focal_length_px;
            // Straight through the lens' middle: the centre may stand outside the field.
            let seen = unit([f64::from(x - cx) / f, f64::from(y - cy) / f, 1.0]);
            let half_rad = libm::atan(f64::from(circle.radius_px) / f);
            let distance_km = EQUATOR_KM / libm::sin(half_rad);
            self.beside(times(distance_km, seen))
        })
    }
}

/// A picture whose dark is 0 and whose brightest hundredth begins at `WHITE_SHARE` of full scale.
fn stretched(picture: &Picture) -> Option<Picture> {
    let mut sorted = picture.pixels().to_vec();
    sorted.sort_unstable();
    let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).map(|raw| f64::from(*raw));
    let (dark, white) = (at(DARK_SHARE)?, at(BRIGHT_SHARE)?);
    let full_scale = f64::from(picture.geometry().full_scale());
    let gain = WHITE_SHARE * full_scale / (white - dark).max(1.0);
    let pixel = |raw: &u16| (gain * (f64::from(*raw) - dark)).round().clamp(0.0, full_scale) as u16;
    Picture::from_pixels(picture.geometry(), picture.pixels().iter().map(pixel).collect())
}

/// What an orbit says of the centre, as in every second of tracking.
struct Tracked {
    view: View,
    prior: CentrePrior,
    criteria: FitCriteria,
}

impl Tracked {
    fn new(limb_sensor: &LimbSensor, centre_km: Vector, noise: &Noise) -> Option<Self> {
        let errs = |axis: u32| ORBIT_SIGMA_KM * noise.gaussian(axis, ORBIT);
        let centre_km = Vector3::new(0, 1, 2).map(|axis: u32| (centre_km[axis as usize] + errs(axis)) as f32);
        let information = Matrix3::identity() * (1.0 / (ORBIT_SIGMA_KM * ORBIT_SIGMA_KM) as f32);
        let view = View::new(&centre_km, limb_sensor.body)?;
        let criteria = limb_sensor
            .parameters
            .strip_criteria(&Strips { km_per_px: limb_sensor.km_per_px(&view), ..Strips::default() }, false);
        Some(Self { view, prior: CentrePrior { centre_km, information }, criteria })
    }

    /// The centre from strips about where it is expected.
    fn fix(
        &self,
        limb_sensor: &LimbSensor,
        picture: &mut Picture,
        buffers: &mut Buffers,
    ) -> Result<Result<EarthFix, FitError>, DetectorError> {
        let everywhere_km2 = (ORBIT_SIGMA_KM * ORBIT_SIGMA_KM) as f32;
        let variance = HeightVariance { everywhere_km2, centre_km2: Matrix3::zeros() };
        let strips = limb_sensor.read_strips(picture, &self.view, &variance, &EVEN_STRIPS, buffers)?;
        Ok(limb_sensor.fit(
            &limb_sensor.parameters.strip_criteria(&strips, false),
            Some(&self.prior),
            buffers,
        ))
    }

    /// The focal length, by the points in the room and the distance that the orbit says.
    fn scale(&self, limb_sensor: &LimbSensor, buffers: &mut Buffers) -> Option<Scale> {
        let LimbSensor { camera, body, parameters, .. } = *limb_sensor;
        let (points, criteria, prior) = (buffers.points.as_slice(), &self.criteria, Some(&self.prior));
        let measured = LimbPoints { points, camera, body, criteria, prior, parameters };
        let known = [self.prior.centre_km.norm(), ORBIT_SIGMA_KM as f32];
        Scale::by_the_earth(&measured, known, buffers.rays).ok()
    }
}

fn direction(vector: Vector) -> Direction<EarthPath> {
    Direction::new(Vector3::from(unit(vector)).map(|c| c as f32)).expect("a unit vector is a direction")
}
