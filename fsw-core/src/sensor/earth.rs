//! The Earth stage of a second: limb, centre, position.

mod alone;
mod held;

use super::Sensor;
use super::propagation::Ephemeris;
use super::record::{EarthRecord, Events, FixRecord, Looked, Record};
use super::tracking::turn_of;
use super::workspace::Readout;
use crate::earth::centre::CentrePrior;
use crate::earth::limb_sensor::{
    Buffers, EVEN_STRIPS, HeightVariance, LimbSensor, SEARCH_SIGMA_PX, StripSelection,
};
use crate::earth::view::View;
use crate::earth::{Body, FitError, Strips};
use crate::frames::{EarthPath, Icrs, Rotation, StarPath};
use crate::image::scan::MAX_DETECTIONS;
use crate::image::turn::Turn;
use crate::matrix::{add_scaled, cross_matrix, product, symmetric_product};
use crate::modes::Mode;
use crate::telemetry::AttitudeReport;
use fsw_hal::{Detector, DetectorError, Stage, StageMeter};
use nalgebra::{Matrix3, Vector3};

/// Seconds in a row without a centre, after which no strips are read but the whole detector is searched ...
const STRIP_PATIENCE: u8 = 3;
/// ... and after which it is searched only in one of [`SEARCH_EVERY`] seconds: a search costs as much as five
/// seconds of tracking, and the dark lasts half an hour. Chosen.
const SEARCH_PATIENCE: u8 = 60;
const SEARCH_EVERY: u32 = 8;

/// Sigma of the Earth's place below which it is known well enough to say what is hidden, rad.
const VIEW_SIGMA_RAD: f32 = 0.06;
/// ... and to say that no limb in the field is lit, rad: there the Sun's height at the limb counts, which
/// changes little with the place.
const DARK_SIGMA_RAD: f32 = 0.3;

/// The Earth as the orbit predicts it, or while that is not known as the last fix does.
struct Prediction {
    view: View,
    /// Its centre in the Earth path, km.
    centre_km: Vector3<f32>,
    /// Covariance of its centre in the Earth path, km².
    covariance_km2: Matrix3<f64>,
    /// Sigma of its place in all, rad.
    sigma_rad: f32,
    /// Whether by the orbit: one fix may be false, and must not hide what would contradict it.
    by_orbit: bool,
}

/// Adds to the covariance of a place, km², that of a turn of the axes it is seen in, rad².
fn add_turn(covariance_km2: &mut Matrix3<f64>, place_km: &Vector3<f32>, turn_rad2: &Matrix3<f64>) {
    let lever = cross_matrix(&place_km.map(f64::from));
    add_scaled(covariance_km2, 1.0, &symmetric_product(&lever, turn_rad2));
}

impl Prediction {
    /// Whether the Earth's place is known well enough to say what is hidden.
    fn is_known(&self) -> bool {
        self.by_orbit && self.sigma_rad < VIEW_SIGMA_RAD
    }
}

impl Sensor<'_> {
    /// The Earth path's attitude.
    fn earth_path(&self, attitude: &Rotation<Icrs, StarPath>) -> Rotation<Icrs, EarthPath> {
        attitude.then(&self.mounting())
    }

    /// The Earth's shape, limb and light as the Earth path sees them with this attitude.
    pub(super) fn body(&self, ephemeris: &Ephemeris, attitude: &Rotation<Icrs, StarPath>) -> Body {
        let path = self.earth_path(attitude);
        Body::new(&path.apply(&ephemeris.pole), Some(&path.apply(&ephemeris.sun)), &self.parameters.earth)
    }

    /// The Earth as it must look from where the orbit says, if its place is known well enough to say what it
    /// hides.
    pub(super) fn known_view(
        &self,
        ephemeris: &Ephemeris,
        attitude: &Rotation<Icrs, StarPath>,
    ) -> Option<View> {
        let body = self.body(ephemeris, attitude);
        let predicted = self.prediction(&body, attitude, ephemeris.terrestrial_us);
        predicted.filter(Prediction::is_known).map(|predicted| predicted.view)
    }

    /// Measures the Earth in the image of this second, whose attitude is known, and updates the orbit with
    /// its centre. Through a shut Earth path nothing is looked for, nor where stars are lines: a limb drawn
    /// out by 70 px gave centres 10 sigma off; nor where a turn draws it out that is not known: of 43 so
    /// drawn out by 8 to 12 px three were 4 to 7 sigma off.
    #[inline(never)]
    pub(super) fn measure_earth(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: &Ephemeris,
        attitude: &AttitudeReport,
        events: &mut Events,
    ) -> Result<(EarthRecord, FixRecord), DetectorError> {
        let Some(rotation) = Rotation::from_quaternion(attitude.quaternion) else {
            return Ok(Default::default());
        };
        if self.orbit.is_behind() || self.turning.is_of_lines() || self.is_drawn_by_unknown_turn() {
            return Ok(Default::default());
        }
        let body = self.body(ephemeris, &rotation);
        let predicted = self.prediction(&body, &rotation, ephemeris.terrestrial_us);
        meter.begin(Stage::Limb);
        let unlit = predicted.as_ref().and_then(|predicted| self.unlit(predicted));
        meter.end(Stage::Limb);
        let by_orbit = predicted.as_ref().is_some_and(Prediction::is_known).then_some(false);
        let looked = match unlit {
            Some(unlit) => unlit,
            None if self.shutting.open().earth() => {
                self.find_earth(detector, meter, &body, predicted.as_ref())?
            }
            None => Looked::Not,
        };
        let dark = match looked {
            Looked::Dark => Some(true),
            Looked::Faint | Looked::Found(_) => Some(false),
            // What is known to be unlit was not looked for.
            Looked::Not | Looked::Refused(_) => by_orbit,
        };
        self.count_misses(&looked);
        let mut earth = EarthRecord { looked, dark };
        let Looked::Found(fix) = &earth.looked else { return Ok((earth, FixRecord::default())) };
        meter.begin(Stage::Orbit);
        let record =
            self.update_orbit((fix, &body), attitude.sigma_rad, &rotation, ephemeris.terrestrial_us, events);
        meter.end(Stage::Orbit);
        let alone = predicted.is_none_or(|predicted| !predicted.by_orbit);
        if !self.parameters.earth.plausible.is_told(fix, alone) {
            earth.looked = Looked::Refused(FitError::Uncertain);
        }
        Ok((earth, record))
    }

    /// What a second in which the star path is shut has: an attitude that is carried on and held to the
    /// Earth, else one by the Earth, and the magnetic field or the Sun.
    #[inline(never)]
    pub(super) fn observe_earth_alone(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: &Ephemeris,
        record: &mut Record,
    ) -> Result<(), DetectorError> {
        if record.stars.solution.is_some() {
            record.earth = self.hold_by_earth(detector, meter, ephemeris)?;
            record.stars.solution = self.propagated(true);
        } else {
            let field = record.field.as_ref();
            (record.earth, record.stars.solution, record.field_used) =
                self.attitude_by_earth(detector, meter, ephemeris, field)?;
        }
        Ok(())
    }

    /// Counts the seconds in a row in which it was looked for without a centre. Where there is nothing to
    /// measure nothing was missed.
    fn count_misses(&mut self, looked: &Looked) {
        self.earth_misses = match looked {
            Looked::Refused(_) => self.earth_misses.saturating_add(1),
            Looked::Not => self.earth_misses,
            Looked::Dark | Looked::Faint | Looked::Found(_) => 0,
        };
    }

    /// Where the Earth is: from strips across the limb that is predicted; where it hardly is, from strips
    /// across the limb that a search of the whole detector found (a search alone would give a centre only
    /// good enough for that).
    #[inline(never)]
    fn find_earth(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        body: &Body,
        predicted: Option<&Prediction>,
    ) -> Result<Looked, DetectorError> {
        let mut strips = self.predicted_strips(detector, meter, body, predicted)?;
        // After fixes that failed or disagreed with the orbit the next is made without it as prior.
        let consistent = !self.orbit.is_contradicted() && self.earth_misses < STRIP_PATIENCE;
        let mut prior = predicted
            .filter(|_| consistent)
            .and_then(|predicted| CentrePrior::new(predicted.centre_km, &predicted.covariance_km2));
        let by_orbit = prior.is_some() && predicted.is_some_and(|predicted| predicted.by_orbit);
        // The whole detector is searched if fewer than 2/3 of the strips could be placed: the prediction is
        // not sure of the rest.
        if !self.has_enough(&strips) {
            let waits = self.earth_misses >= SEARCH_PATIENCE && !self.cycle.is_multiple_of(SEARCH_EVERY);
            if waits || self.scanned_crowd() {
                return Ok(Looked::Not);
            }
            meter.begin(Stage::Search);
            let searched = self.search(detector, body);
            meter.end(Stage::Search);
            match searched? {
                Ok((read, rough)) => {
                    strips = read;
                    if !by_orbit {
                        prior = rough;
                    }
                }
                Err(refusal) => return Ok(Looked::Refused(refusal)),
            }
        }
        Ok(self.fit(meter, body, (&strips, prior.as_ref()), !by_orbit))
    }

    /// Whether the whole image of this second was searched for stars and had more spots than are kept: a search
    /// of it for the Earth beside that would make 74 million cycles of the second, and waits for one that
    /// tracks.
    fn scanned_crowd(&self) -> bool {
        let scans = matches!(self.modes.mode(), Mode::Acquisition | Mode::SunOutage);
        scans && self.sought == self.now && self.workspace.detections.found() as usize > MAX_DETECTIONS
    }

    /// Whether at least two thirds of the strips could be placed, and enough for a centre.
    fn has_enough(&self, strips: &Strips) -> bool {
        strips.read >= usize::from(self.parameters.earth.fit.fewest_points).max(2 * strips.skipped)
    }

    /// Whether the Earth as predicted has no lit limb in the field, or too little of one; `None` where it has
    /// enough, or the prediction is not good enough to say that it has too little.
    fn unlit(&self, predicted: &Prediction) -> Option<Looked> {
        if !predicted.by_orbit || predicted.sigma_rad >= DARK_SIGMA_RAD {
            return None;
        }
        let parameters = &self.parameters.earth;
        let enough_rad = if predicted.is_known() { parameters.fit.least_arc_deg.to_radians() } else { 0.0 };
        let light = predicted.view.lit_arcs(&self.camera, 0.0, enough_rad, parameters);
        if light.lit_rad == 0.0 {
            return Some(Looked::Dark);
        }
        (light.usable_rad < enough_rad).then_some(Looked::Faint)
    }

    /// Reads strips across the limb that is predicted into the workspace; none without a prediction, nor
    /// after [`STRIP_PATIENCE`] misses.
    fn predicted_strips(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        body: &Body,
        predicted: Option<&Prediction>,
    ) -> Result<Strips, DetectorError> {
        let Some(predicted) = predicted.filter(|_| self.earth_misses < STRIP_PATIENCE) else {
            return Ok(Strips::default());
        };
        meter.begin(Stage::Limb);
        let centre_km2 = predicted.covariance_km2.map(|element| element as f32);
        let variance = HeightVariance { everywhere_km2: 0.0, centre_km2 };
        let strips = StripSelection::dithered(self.cycle, self.orbit.is_busy());
        let (limb_sensor, mut buffers) = self.limb_sensor(body);
        let read = limb_sensor.read_strips(detector, &predicted.view, &variance, &strips, &mut buffers);
        meter.end(Stage::Limb);
        read
    }

    /// The Earth as the orbit predicts it, or while that is not known the last fix; `None` without either.
    #[inline(never)]
    fn prediction(
        &self,
        body: &Body,
        attitude: &Rotation<Icrs, StarPath>,
        terrestrial_us: i64,
    ) -> Option<Prediction> {
        let (position_km, covariance_km2) = self.orbit.place(self.parameters.orbit.body, terrestrial_us)?;
        let path = self.earth_path(attitude).matrix().map(f64::from);
        let centre_km = product(&path, &position_km).map(|axis| -axis as f32);
        let view = View::new(&centre_km, body)?;
        let mut covariance_km2 = symmetric_product(&path, &covariance_km2);
        if let Some(misalignment) = self.orbit.misalignment_covariance_rad2() {
            add_turn(&mut covariance_km2, &centre_km, &misalignment);
        }
        let sigma_rad = libm::sqrtf(covariance_km2.trace().max(0.0) as f32) / view.limb_distance_km();
        let by_orbit = self.orbit.state().is_some();
        Some(Prediction { view, centre_km, covariance_km2, sigma_rad, by_orbit })
    }

    /// Searches the whole detector and fills the workspace with the limb points of strips across what was
    /// found. Gives the strips, and where the Earth is by the search.
    #[inline(never)]
    fn search(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        body: &Body,
    ) -> Result<Result<(Strips, Option<CentrePrior>), FitError>, DetectorError> {
        let (limb_sensor, mut buffers) = self.limb_sensor(body);
        let (rough, view) = match limb_sensor.search(detector, &mut buffers)? {
            Ok(found) => found,
            Err(refusal) => return Ok(Err(refusal)),
        };
        let read = self.strips_about(detector, body, &view)?;
        Ok(Ok((read, CentrePrior::from_fix(&rough))))
    }

    /// Reads strips across a limb that a search found into the workspace.
    #[inline(never)]
    fn strips_about(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        body: &Body,
        view: &View,
    ) -> Result<Strips, DetectorError> {
        let (limb_sensor, mut buffers) = self.limb_sensor(body);
        let variance = limb_sensor.height_variance(view, SEARCH_SIGMA_PX);
        limb_sensor.read_strips(detector, view, &variance, &EVEN_STRIPS, &mut buffers)
    }

    /// The centre of the points in the workspace, once they are moved by how bright the ground is; `alone`:
    /// its prior is no orbit.
    #[inline(never)]
    fn fit(
        &mut self,
        meter: &mut impl StageMeter,
        body: &Body,
        (strips, prior): (&Strips, Option<&CentrePrior>),
        alone: bool,
    ) -> Looked {
        meter.begin(Stage::Centre);
        let points = &mut self.workspace.shared.readout().limb;
        self.usual_ground.correct(points, &self.camera, &self.parameters.earth.limb);
        let criteria = self.parameters.earth.strip_criteria(strips, alone);
        let (limb_sensor, mut buffers) = self.limb_sensor(body);
        // Strips that agree on another body than the search contradict the prior and are refused.
        let fix = limb_sensor.fit(&criteria, prior, &mut buffers);
        meter.end(Stage::Centre);
        fix.map_or_else(Looked::Refused, Looked::Found)
    }

    /// How the Earth path turns during the exposure; `None` where that is not known.
    fn earth_path_turn(&self) -> Option<Turn> {
        let turn_rad = self.mounting().matrix() * self.turned_in_exposure()?;
        Some(turn_of(&self.camera.of_earth_path(), &turn_rad))
    }

    /// The limb sensor and its buffers.
    fn limb_sensor<'a>(&'a mut self, body: &'a Body) -> (LimbSensor<'a>, Buffers<'a>) {
        let turn = self.earth_path_turn();
        let Readout { buffer, limb, rays } = self.workspace.shared.readout();
        let buffers = Buffers { buffer, points: limb, rays };
        (LimbSensor { camera: &self.camera, body, parameters: &self.parameters.earth, turn }, buffers)
    }
}
