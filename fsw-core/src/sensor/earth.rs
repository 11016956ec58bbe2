//! The Earth's half of a second: limb, centre, position, orbit.

use super::workspace::Readout;
use super::{Ephemeris, Sensor};
use crate::earth::centre::Expected;
use crate::earth::look::{EVENLY, HeightVariance, Look, Room, SEARCH_SIGMA_PX};
use crate::earth::view::View;
use crate::earth::{Body, Demand, EarthFix, Refusal, Strips};
use crate::frames::{Icrs, Rotation, StarPath};
use crate::matrix::{inverse, product, product_transposed};
use crate::orbit::filter::Update;
use crate::orbit::point::{PositionFix, earth_to_icrs};
use crate::telemetry::{EarthReport, EarthStatus, Event, Fault, OrbitReport, Report, Status};
use fsw_hal::{Detector, DetectorError, Stage, StageMeter};
use nalgebra::{Matrix3, Vector3};

/// Seconds in a row in which strips gave no centre, after which the whole detector is searched in one second.
const STRIP_PATIENCE: u8 = 3;

/// Sigma of the Earth's place below which it is known well enough to say what is hidden, rad.
const VIEW_SIGMA_RAD: f32 = 0.06;
/// ... and to say that no limb in the field is lit, rad: there the Sun's height at the limb counts, which changes little with the
/// place.
const DARK_SIGMA_RAD: f32 = 0.3;

/// The Earth as the orbit predicts it.
struct Prediction {
    view: View,
    /// Covariance of its centre in the Earth path, km².
    covariance_km2: Matrix3<f32>,
    /// Sigma of its place in all, rad.
    sigma_rad: f32,
    centre_km: Vector3<f32>,
}

impl Prediction {
    /// Whether the Earth's place is known well enough to say what is hidden.
    fn is_known(&self) -> bool {
        self.sigma_rad < VIEW_SIGMA_RAD
    }
}

/// What looking for the Earth came to.
enum Looked {
    /// No limb in the field is lit.
    Dark,
    /// Too little of it is lit well.
    Faint,
    /// The Earth's centre.
    Found(EarthFix),
    /// None, and why.
    Refused(Refusal),
}

/// A symmetric matrix in the axes to which `path` rotates.
fn rotated(path: &Matrix3<f64>, matrix: &Matrix3<f64>) -> Matrix3<f32> {
    product_transposed(&product(path, matrix), path).map(|element| element as f32)
}

impl Sensor<'_> {
    /// The Earth's shape, limb and light as the Earth path sees them with this attitude.
    pub(super) fn body(&self, ephemeris: &Ephemeris, attitude: &Rotation<Icrs, StarPath>) -> Body {
        let path = attitude.then(&self.star_to_earth);
        Body::new(&path.apply(&ephemeris.pole), Some(&path.apply(&ephemeris.sun)), &self.parameters.earth)
    }

    /// The Earth as it must look from where the orbit says, if its place is known well enough to say what it hides.
    pub(super) fn known_view(&self, body: &Body, attitude: &Rotation<Icrs, StarPath>) -> Option<View> {
        self.prediction(body, attitude).filter(Prediction::is_known).map(|predicted| predicted.view)
    }

    /// Looks for the Earth in the image of this second, whose attitude is known, and takes its centre into the orbit.
    #[inline(never)]
    pub(super) fn look_at_earth(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: &Ephemeris,
        attitude: &Rotation<Icrs, StarPath>,
        report: &mut Report,
    ) {
        let body = self.body(ephemeris, attitude);
        match self.find_earth(detector, meter, &body, attitude) {
            Ok(Looked::Found(fix)) => {
                self.strip_misses = 0;
                meter.begin(Stage::Orbit);
                self.report_earth(&fix, report);
                self.update_orbit(&fix, attitude, report);
                meter.end(Stage::Orbit);
            }
            Ok(Looked::Refused(refusal)) => {
                self.strip_misses =
                    if self.strip_misses < STRIP_PATIENCE { self.strip_misses + 1 } else { 0 };
                report.earth_status = EarthStatus::Refused(refusal);
            }
            Ok(Looked::Dark) => self.report_light(EarthStatus::Dark, report),
            Ok(Looked::Faint) => self.report_light(EarthStatus::Faint, report),
            Err(error) => report.status = Status::DetectorFault(Fault::from(error)),
        }
    }

    /// Where the Earth is: from strips across the limb that the orbit predicts; where it hardly does, from strips across the
    /// limb that a search of the whole detector found (a search alone would give a centre only good enough for that).
    #[inline(never)]
    fn find_earth(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        body: &Body,
        attitude: &Rotation<Icrs, StarPath>,
    ) -> Result<Looked, DetectorError> {
        meter.begin(Stage::Limb);
        let predicted = self.prediction(body, attitude);
        let parameters = &self.parameters.earth;
        let light = predicted
            .as_ref()
            .filter(|predicted| predicted.sigma_rad < DARK_SIGMA_RAD)
            .map(|predicted| (predicted.view.light(&self.camera, 0.0, parameters), predicted.is_known()));
        meter.end(Stage::Limb);
        match light {
            Some((light, _)) if light.lit_rad == 0.0 => return Ok(Looked::Dark),
            Some((light, true)) if light.usable_rad < parameters.fit.least_arc_deg.to_radians() => {
                return Ok(Looked::Faint);
            }
            _ => {}
        }
        meter.begin(Stage::Limb);
        let mut strips = Strips::default();
        if let Some(Prediction { view, covariance_km2, .. }) = &predicted
            && self.strip_misses < STRIP_PATIENCE
        {
            let variance = HeightVariance { everywhere_km2: 0.0, centre_km2: *covariance_km2 };
            let (look, mut room) = self.looking(body)?;
            strips = look.read_strips(detector, view, &variance, &EVENLY, &mut room)?;
        }
        meter.end(Stage::Limb);
        let mut rough = None;
        // The whole detector is searched if fewer than 2/3 of the strips could be placed: the orbit is not sure of the rest.
        if strips.read < usize::from(self.parameters.earth.fit.fewest_points).max(2 * strips.unsure) {
            meter.begin(Stage::Search);
            let searched = self.search(detector, body);
            meter.end(Stage::Search);
            match searched? {
                Ok((read, expected)) => (strips, rough) = (read, expected),
                Err(refusal) => return Ok(Looked::Refused(refusal)),
            }
        }
        meter.begin(Stage::Centre);
        // After fixes that failed or disagreed with the orbit the next is made without it.
        let believed = self.orbit.rejections() == 0 && self.strip_misses < STRIP_PATIENCE;
        let orbit = predicted.filter(|_| believed).and_then(|predicted| self.expected(&predicted, attitude));
        let demand = self.parameters.earth.in_strips(&strips, orbit.is_none());
        // Strips that agree on another body than the search do not agree with what is expected either.
        let fix = self.fit(body, &demand, orbit.or(rough).as_ref());
        meter.end(Stage::Centre);
        Ok(fix.map_or_else(Looked::Refused, Looked::Found))
    }

    /// The Earth as the orbit predicts it; `None` without an orbit.
    fn prediction(&self, body: &Body, attitude: &Rotation<Icrs, StarPath>) -> Option<Prediction> {
        let (state, covariance) = (self.orbit.state()?, self.orbit.position_covariance_km2()?);
        let path = self.earth_path(attitude);
        let centre_km = product(&path, &state.position_km).map(|axis| -axis as f32);
        let view = View::new(&centre_km, body)?;
        let covariance_km2 = rotated(&path, &covariance);
        let sigma_rad = libm::sqrtf(covariance_km2.trace().max(0.0)) / view.limb_distance_km();
        Some(Prediction { view, covariance_km2, sigma_rad, centre_km })
    }

    /// What the fit of the centre expects by a prediction with the same attitude.
    #[inline(never)]
    fn expected(&self, predicted: &Prediction, attitude: &Rotation<Icrs, StarPath>) -> Option<Expected> {
        let information = inverse(&self.orbit.position_covariance_km2()?)?;
        let information = rotated(&self.earth_path(attitude), &information);
        Some(Expected { centre_km: predicted.centre_km, information })
    }

    /// From ICRS to the Earth path.
    fn earth_path(&self, attitude: &Rotation<Icrs, StarPath>) -> Matrix3<f64> {
        attitude.then(&self.star_to_earth).matrix().map(f64::from)
    }

    /// Searches the whole detector and fills the workspace with the limb points of strips across what was found. Gives the strips, and
    /// where the Earth is by the search.
    #[inline(never)]
    fn search(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        body: &Body,
    ) -> Result<Result<(Strips, Option<Expected>), Refusal>, DetectorError> {
        let (look, mut room) = self.looking(body)?;
        let (rough, view) = match look.search(detector, &mut room)? {
            Ok(found) => found,
            Err(refusal) => return Ok(Err(refusal)),
        };
        let variance = look.height_variance(&view, SEARCH_SIGMA_PX);
        let read = look.read_strips(detector, &view, &variance, &EVENLY, &mut room)?;
        Ok(Ok((read, Expected::after(&rough))))
    }

    /// The centre of the points in the workspace.
    fn fit(
        &mut self,
        body: &Body,
        demand: &Demand,
        expected: Option<&Expected>,
    ) -> Result<EarthFix, Refusal> {
        let (look, mut room) = self.looking(body).map_err(|_| Refusal::TooFewPoints)?;
        look.fit(demand, expected, &mut room)
    }

    /// Who looks at the Earth, and the room to do it in.
    fn looking<'a>(&'a mut self, body: &'a Body) -> Result<(Look<'a>, Room<'a>), DetectorError> {
        let Readout { buffer, limb, rays } = self.workspace.shared.readout()?;
        let room = Room { buffer, points: limb, rays };
        Ok((Look { camera: &self.camera, body, parameters: &self.parameters.earth }, room))
    }

    /// Reports that there is nothing to measure, of which no strip is to blame.
    fn report_light(&mut self, status: EarthStatus, report: &mut Report) {
        self.strip_misses = 0;
        report.earth_status = status;
    }

    /// Reports the Earth as found.
    fn report_earth(&self, fix: &EarthFix, report: &mut Report) {
        let distance_km = libm::sqrtf(fix.centre_km.dot(&fix.centre_km));
        let (sigma_rad, sigma_km) = fix.sigmas();
        report.earth_status = EarthStatus::Found;
        report.earth = Some(EarthReport {
            direction: (fix.centre_km * (1.0 / distance_km.max(1.0))).into(),
            sigma_rad,
            distance_km,
            sigma_km,
            inliers: fix.inliers.count_ones() as u16,
            arc_deg: fix.arc_rad.to_degrees(),
            rms_px: fix.rms_px,
        });
        for (index, point) in self.workspace.shared.limb_points().iter().enumerate() {
            if fix.holds(index) && report.limb_px.push(point.centre_px).is_err() {
                break;
            }
        }
    }

    /// Takes the Earth's centre into the orbit (eq. 5.4).
    #[inline(never)]
    fn update_orbit(&mut self, fix: &EarthFix, attitude: &Rotation<Icrs, StarPath>, report: &mut Report) {
        let (Some(found), Some(instant_us)) = (report.attitude, report.instant_us) else { return };
        let [x, y, z] = found.sigma_rad.map(|sigma| sigma * sigma);
        let attitude_covariance = Matrix3::from_diagonal(&Vector3::new(x, y, z));
        let mounting = self.star_to_earth.inverse();
        // The filter has its own account of errors that last.
        let EarthFix { centre_km, noise_km2, place_km, .. } = fix;
        let to_icrs = earth_to_icrs(attitude, &mounting);
        let fix = PositionFix::new(centre_km, noise_km2, place_km, &to_icrs, &attitude_covariance, &mounting);
        let Some(mut position) = fix else { return };
        if let Some(state) = self.orbit.state() {
            position = position.without_aberration(&state.velocity_km_s);
        }
        let (nis, event) = match self.orbit.update(instant_us, &position, &to_icrs, &self.parameters.orbit) {
            Update::Begun => (None, None),
            Update::Started => (None, Some(Event::OrbitStarted)),
            Update::Restarted => (None, Some(Event::OrbitRestarted)),
            Update::Accepted { nis } => (Some(nis), None),
            Update::Rejected { nis } => (Some(nis), Some(Event::FixRejected)),
            Update::Refused(_) => (None, Some(Event::FixRefused)),
        };
        if let Some(event) = event {
            report.note(event);
        }
        if !matches!(event, Some(Event::FixRejected | Event::FixRefused)) {
            self.fixed_us = instant_us;
        }
        self.nis = nis;
    }

    /// Reports the orbit as it stands after this second.
    #[inline(never)]
    pub(super) fn report_orbit(&mut self, report: &mut Report) {
        let nis = self.nis.take();
        let (Some(state), Some(position), Some(velocity)) =
            (self.orbit.state(), self.orbit.position_sigma_km(), self.orbit.velocity_sigma_km_s())
        else {
            return;
        };
        let single = |value: Option<f64>| value.unwrap_or(0.0) as f32;
        let since_fix_us = state.time_us.saturating_sub(self.fixed_us).max(0);
        report.orbit = Some(OrbitReport {
            position_km: state.position_km.into(),
            velocity_km_s: state.velocity_km_s.into(),
            sigma_position_km: position.map(|sigma| sigma as f32),
            sigma_velocity_km_s: velocity.map(|sigma| sigma as f32),
            limb_height_km: single(self.orbit.limb_height_km()),
            limb_height_sigma_km: single(self.orbit.limb_height_sigma_km()),
            nis,
            since_fix_s: (since_fix_us / 1_000_000).min(u32::MAX.into()) as u32,
            settled: self.orbit.settled(),
        });
        if self.orbit.settled() && !self.converged {
            report.note(Event::OrbitConverged);
        }
        self.converged = self.orbit.settled();
    }
}
