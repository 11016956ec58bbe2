//! An attitude by the Earth alone: the star path is shut and no attitude is carried on.
//!
//! The limb shows where the Earth's centre is, the orbit where it should be: two axes, as of a single star.
//! The third, about that direction, is the magnetic field's where a magnetometer reads it, good to half a
//! degree in a low orbit, or the Sun's: the orbit says how far it stands from the Earth, the terminator on
//! which side. That is good to some degrees, enough to point an antenna or a panel until the stars are back.
//! Each image gives one of its own: the clouds that bend the terminator stay for minutes, and no filter
//! averages them.
//!
//! In: the second's image, orbit, Sun, field. Out: an attitude, and the Earth that it rests on. The orbit
//! learns nothing of it.

use super::VIEW_SIGMA_RAD;
use crate::attitude::VectorPair;
use crate::attitude::wahba::svd;
use crate::earth::centre::CentrePrior;
use crate::earth::terminator::{self, SunSeen};
use crate::earth::view::View;
use crate::earth::{Body, EarthFix, FitError};
use crate::frames::{Direction, EarthPath, Icrs, Rotation, StarPath};
use crate::magnetism::CONTRADICTION;
use crate::sensor::Sensor;
use crate::sensor::propagation::Ephemeris;
use crate::sensor::record::{EarthRecord, Field, Looked, Solution};
use crate::telemetry::AttitudeReport;
use crate::trigonometry::hypotenuse;
use fsw_hal::{Detector, DetectorError, Stage, StageMeter};

/// Greatest standard deviation about the Earth's direction that is told, rad: 10 deg.
const TOLD_RAD: f32 = 0.175;
/// Sigmas within which the distance by the limb must be that of the orbit.
const DISTANCE_SIGMAS: f32 = 4.0;
/// A terminator is no better than this, 2.3 deg: where the field is, it is not looked for.
const BEST_TERMINATOR_RAD: f32 = 0.04;
/// The other direction turns about that of the Earth, and hardly moves it: their weights in Wahba's problem
/// as sigmas, rad.
const WEIGHTS_RAD: [f32; 2] = [1e-3, 0.03];

/// Earth and Sun as orbit and time have them.
struct Known {
    to_earth: Direction<Icrs>,
    to_sun: Direction<Icrs>,
    distance_km: f32,
    sigma_km: f32,
}

/// A direction beside that of the Earth.
#[derive(Clone, Copy)]
struct Beside {
    seen: Direction<EarthPath>,
    reference: Direction<Icrs>,
    /// Standard deviation about the Earth's direction, rad.
    sigma_rad: f32,
    is_magnetic: bool,
}

/// The Earth as an image shows it, how its axes lie not known, and what stands beside it.
struct Seen {
    fix: EarthFix,
    beside: Beside,
}

impl Beside {
    /// The Sun.
    fn of_sun(sun: &SunSeen, known: &Known) -> Self {
        let SunSeen { direction, sigma_rad } = *sun;
        Self { seen: direction, reference: known.to_sun, sigma_rad, is_magnetic: false }
    }

    /// The magnetic field, `sigma_rad` that of its direction. `None` where it is not as far from the Earth as
    /// it should be.
    fn of_field(
        (seen, reference, sigma_rad): (Direction<EarthPath>, Direction<Icrs>, f32),
        fix: &EarthFix,
        known: &Known,
    ) -> Option<Self> {
        let cosine = known.to_earth.dot(&reference);
        let (direction_rad, _) = fix.sigmas();
        let off = libm::fabsf(Direction::new(fix.centre_km)?.dot(&seen) - cosine);
        let agrees = off < CONTRADICTION * hypotenuse(sigma_rad, direction_rad);
        let sine = libm::sqrtf((1.0 - cosine * cosine).max(1e-6));
        // An Earth that is off across turns the field about it, the more the nearer they are.
        let sigma_rad = hypotenuse(sigma_rad, cosine * direction_rad) / sine;
        agrees.then_some(Self { seen, reference, sigma_rad, is_magnetic: true })
    }
}

impl Sensor<'_> {
    /// The attitude of this second, in which the star path is shut, by the Earth, and by the magnetic field
    /// or the Sun; none without an orbit. Whether it rests on the field.
    #[inline(never)]
    pub(in crate::sensor) fn attitude_by_earth(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        meter: &mut impl StageMeter,
        ephemeris: &Ephemeris,
        field: Option<&Field>,
    ) -> Result<(EarthRecord, Option<Solution>, bool), DetectorError> {
        let Some(known) = self.known_earth(ephemeris) else { return Ok(Default::default()) };
        meter.begin(Stage::Search);
        let seen = self.see_earth(detector, &known, field);
        meter.end(Stage::Search);
        let Some(Seen { fix, beside }) = seen? else { return Ok(Default::default()) };
        let Some(rough) = self.turned_to(&fix, &beside, &known) else { return Ok(Default::default()) };
        let body = self.body(ephemeris, &rough);
        let Some(view) = View::new(&fix.centre_km, &body) else { return Ok(Default::default()) };
        meter.begin(Stage::Limb);
        let strips = self.strips_about(detector, &body, &view);
        meter.end(Stage::Limb);
        let looked = self.fit(meter, &body, (&strips?, CentrePrior::from_fix(&fix).as_ref()), true);
        let solution = match &looked {
            Looked::Found(fix) => self.by_earth(fix, &beside, &known),
            _ => None,
        };
        // What gives no attitude is not where the orbit has the Earth, or too uncertain.
        let looked = match looked {
            Looked::Found(_) if solution.is_none() => Looked::Refused(FitError::Uncertain),
            looked => looked,
        };
        let is_magnetic = beside.is_magnetic && solution.is_some();
        Ok((EarthRecord { dark: solution.map(|_| false), looked }, solution, is_magnetic))
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

    /// The Earth in the image, nothing known but the orbit, and the better of field and Sun.
    #[inline(never)]
    fn see_earth(
        &mut self,
        detector: &mut impl Detector<Error = DetectorError>,
        known: &Known,
        field: Option<&Field>,
    ) -> Result<Option<Seen>, DetectorError> {
        let field = field.and_then(|field| self.magnetic_direction(field));
        // How its axes lie is not known: of so flat an ellipsoid any will do.
        let body = Body::new(&Direction::z(), None, &self.parameters.earth);
        let (limb_sensor, mut buffers) = self.limb_sensor(&body);
        let Ok((fix, view)) = limb_sensor.search(detector, &mut buffers)? else { return Ok(None) };
        let (camera, parameters) = (limb_sensor.camera, limb_sensor.parameters);
        let by_field = field.and_then(|field| Beside::of_field(field, &fix, known));
        let by_sun = if by_field.is_some_and(|field| field.sigma_rad < BEST_TERMINATOR_RAD) {
            None
        } else {
            let phase = -known.to_earth.dot(&known.to_sun);
            let sun = terminator::sun_seen(detector, buffers.buffer, (camera, &view), phase, parameters)?;
            sun.map(|sun| Beside::of_sun(&sun, known))
        };
        let both = [by_field, by_sun].into_iter().flatten();
        let better = both.reduce(|one, other| if other.sigma_rad < one.sigma_rad { other } else { one });
        Ok(better.filter(|beside| beside.sigma_rad < TOLD_RAD).map(|beside| Seen { fix, beside }))
    }

    /// The attitude that has the Earth and what stands beside it where they are seen.
    #[inline(never)]
    fn turned_to(&self, fix: &EarthFix, beside: &Beside, known: &Known) -> Option<Rotation<Icrs, StarPath>> {
        let to_star_path = self.mounting().inverse();
        let pair = |seen: &Direction<EarthPath>, reference, sigma_rad| VectorPair {
            measured: to_star_path.apply(seen),
            reference,
            sigma_rad,
        };
        let [earth_rad, beside_rad] = WEIGHTS_RAD;
        let earth = pair(&Direction::new(fix.centre_km)?, known.to_earth, earth_rad);
        svd::solve(&[earth, pair(&beside.seen, beside.reference, beside_rad)]).ok()
    }

    /// The attitude by the Earth's centre as strips across its limb show it, and what stands beside it;
    /// `None` where that Earth is not to be told by itself, or not as far as the orbit has it.
    fn by_earth(&self, fix: &EarthFix, beside: &Beside, known: &Known) -> Option<Solution> {
        let (direction_rad, along_km) = fix.sigmas();
        let off_km = libm::fabsf(fix.distance_km() - known.distance_km);
        let agrees = off_km < DISTANCE_SIGMAS * hypotenuse(along_km, known.sigma_km);
        if !agrees || !self.parameters.earth.plausible.is_told(fix, true) {
            return None;
        }
        let attitude = self.turned_to(fix, beside, known)?;
        let place_rad = known.sigma_km / known.distance_km;
        let misalignment_rad = self.parameters.orbit.misalignment_sigma_rad;
        let [across2, place2, misalignment2, about2] =
            [direction_rad, place_rad, misalignment_rad, beside.sigma_rad].map(|sigma| sigma * sigma);
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
