//! An attitude by the Earth alone: the star path is shut and no attitude is carried on.
//!
//! The limb shows where the Earth's centre is, the orbit where it should be: two axes, as of a single star.
//! The third, about that direction, is the Sun's: the orbit says how far it stands from the Earth, the
//! terminator on which side. It is good to some degrees, enough to point an antenna or a panel until the
//! stars are back. Each image gives one of its own: the clouds that bend the terminator stay for minutes, and
//! no filter averages them.
//!
//! In: the second's image, orbit, Sun. Out: an attitude, and the Earth that it rests on. The orbit learns
//! nothing of it.

use super::VIEW_SIGMA_RAD;
use crate::attitude::VectorPair;
use crate::attitude::wahba::svd;
use crate::earth::centre::CentrePrior;
use crate::earth::terminator::{self, SunSeen};
use crate::earth::view::View;
use crate::earth::{Body, EarthFix};
use crate::frames::{Direction, EarthPath, Icrs, Rotation, StarPath};
use crate::sensor::Sensor;
use crate::sensor::propagation::Ephemeris;
use crate::sensor::record::{EarthRecord, Looked, Solution};
use crate::telemetry::AttitudeReport;
use fsw_hal::{Detector, DetectorError, Stage, StageMeter};

/// Greatest standard deviation about the Earth's direction that is told, rad: 10 deg.
const TOLD_RAD: f32 = 0.175;
/// Sigmas within which the distance by the limb must be that of the orbit.
const DISTANCE_SIGMAS: f32 = 4.0;
/// The Sun's direction turns about that of the Earth, and hardly moves it: their weights in Wahba's problem
/// as sigmas, rad.
const WEIGHTS_RAD: [f32; 2] = [1e-3, 0.03];

/// Earth and Sun as orbit and time have them.
struct Known {
    to_earth: Direction<Icrs>,
    to_sun: Direction<Icrs>,
    distance_km: f32,
    sigma_km: f32,
}

/// Earth and Sun as an image shows them, how the Earth's axes lie not known.
struct Seen {
    fix: EarthFix,
    sun: SunSeen,
}

impl Sensor<'_> {
    /// The attitude of this second, in which the star path is shut, by Earth and Sun; none without an orbit.
    #[inline(never)]
    pub(in crate::sensor) fn attitude_by_earth(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: &Ephemeris,
    ) -> Result<(EarthRecord, Option<Solution>), DetectorError> {
        let Some(known) = self.known_earth(ephemeris) else { return Ok(Default::default()) };
        meter.begin(Stage::Search);
        let seen = self.see_sun(detector, -known.to_earth.dot(&known.to_sun));
        meter.end(Stage::Search);
        let Some(seen) = seen? else { return Ok(Default::default()) };
        let Some(rough) = self.turned_to(&seen.fix, &seen.sun, &known) else { return Ok(Default::default()) };
        let body = self.body(ephemeris, &rough);
        let Some(view) = View::new(&seen.fix.centre_km, &body) else { return Ok(Default::default()) };
        meter.begin(Stage::Limb);
        let strips = self.strips_about(detector, &body, &view);
        meter.end(Stage::Limb);
        let looked = self.fit(meter, &body, (&strips?, CentrePrior::from_fix(&seen.fix).as_ref()), true);
        let solution = match &looked {
            Looked::Found(fix) => self.by_earth(fix, &seen.sun, &known),
            _ => None,
        };
        Ok((EarthRecord { dark: solution.map(|_| false), looked }, solution))
    }

    /// Where the Earth is, if the orbit says so well enough.
    fn known_earth(&self, ephemeris: &Ephemeris) -> Option<Known> {
        self.orbit.state()?;
        let (position_km, covariance_km2) =
            self.orbit.place(self.parameters.orbit.body, ephemeris.terrestrial_us)?;
        let position_km = position_km.map(|axis| axis as f32);
        let distance_km = libm::sqrtf(position_km.dot(&position_km));
        let sigma_km = libm::sqrtf(covariance_km2.trace().max(0.0) as f32);
        let to_earth = Direction::new(-position_km)?;
        let known = Known { to_earth, to_sun: ephemeris.sun, distance_km, sigma_km };
        (sigma_km < VIEW_SIGMA_RAD * distance_km).then_some(known)
    }

    /// Earth and Sun in the image, nothing known but the angle at the Earth between Sun and sensor, `phase`
    /// its cosine.
    #[inline(never)]
    fn see_sun(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        phase: f32,
    ) -> Result<Option<Seen>, DetectorError> {
        // How its axes lie is not known: of so flat an ellipsoid any will do.
        let body = Body::new(&Direction::z(), None, &self.parameters.earth);
        let (limb_sensor, mut buffers) = self.limb_sensor(&body);
        let Ok((fix, view)) = limb_sensor.search(detector, &mut buffers)? else { return Ok(None) };
        let (camera, parameters) = (limb_sensor.camera, limb_sensor.parameters);
        let sun = terminator::sun_seen(detector, buffers.buffer, (camera, &view), phase, parameters)?;
        Ok(sun.filter(|sun| sun.sigma_rad < TOLD_RAD).map(|sun| Seen { fix, sun }))
    }

    /// The attitude that has Earth and Sun where they are seen.
    #[inline(never)]
    fn turned_to(&self, fix: &EarthFix, sun: &SunSeen, known: &Known) -> Option<Rotation<Icrs, StarPath>> {
        let to_star_path = self.mounting().inverse();
        let pair = |seen: &Direction<EarthPath>, reference, sigma_rad| VectorPair {
            measured: to_star_path.apply(seen),
            reference,
            sigma_rad,
        };
        let [earth_rad, sun_rad] = WEIGHTS_RAD;
        let earth = pair(&Direction::new(fix.centre_km)?, known.to_earth, earth_rad);
        svd::solve(&[earth, pair(&sun.direction, known.to_sun, sun_rad)]).ok()
    }

    /// The attitude by the Earth's centre as strips across its limb show it, and the Sun; `None` where that
    /// Earth is not to be told by itself, or not as far as the orbit has it.
    fn by_earth(&self, fix: &EarthFix, sun: &SunSeen, known: &Known) -> Option<Solution> {
        let (direction_rad, along_km) = fix.sigmas();
        let off_km = libm::fabsf(fix.distance_km() - known.distance_km);
        let agrees = off_km < DISTANCE_SIGMAS * libm::hypotf(along_km, known.sigma_km);
        if !agrees || !self.parameters.earth.plausible.is_told(fix) {
            return None;
        }
        let attitude = self.turned_to(fix, sun, known)?;
        let place_rad = known.sigma_km / known.distance_km;
        let misalignment_rad = self.parameters.orbit.misalignment_sigma_rad;
        let [across2, place2, misalignment2, about2] =
            [direction_rad, place_rad, misalignment_rad, sun.sigma_rad].map(|sigma| sigma * sigma);
        let across2 = across2 + place2 + misalignment2;
        let sigma = |axis: f32| libm::sqrtf(across2 + (about2 - across2).max(0.0) * axis * axis);
        Some(Solution {
            attitude: AttitudeReport {
                quaternion: attitude.quaternion(),
                sigma_rad: (*attitude.apply(&known.to_earth).vector()).map(sigma).into(),
                log10_false: 0.0,
                age_s: 0,
            },
            filtered: None,
            rate_rad_s: None,
            focal_ratio: None,
            predicted: true,
        })
    }
}
