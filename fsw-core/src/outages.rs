//! Prediction of what the sensor can do (thesis §8.2, tab. 8.1, figs. 8.5 to 8.10).
//!
//! In: an orbit, the law by which the satellite is pointed, camera and mounting. Out: the state of the
//! sensor, 0 to 4, at an instant, and the next second at which it changes.
//!
//! | state | when |
//! |---|---|
//! | 0 full | a lit limb is in the field and no Sun |
//! | 1 Sun in the Earth path | the Sun's disc touches the field of the Earth path and is not hidden whole |
//! | 2 eclipse | no lit limb is in the field, and no Sun |
//! | 3 Sun in the star path | its disc touches the field of the star path and is not hidden whole |
//! | 4 Sun in the star path over the Earth | the same, and its image lies on that of the Earth |
//!
//! With the Sun in both paths it is state 1. Earth and limb are those of the solid body: a Sun seen through
//! the air still blinds. Assumes that the law is kept to the pointing error; slews are not predicted.
//!
//! Errors: the Sun's direction 0.007 deg ([`Bodies`]), which is 2 s in GEO and 0.1 s in a low orbit; an
//! azimuth of the limb 0.5 deg. Work: one state projects 720 limb points at most; [`Forecast::step`] asks for
//! [`STEP_S`] + 1 states at most, mostly for one. On board an [`Outlook`] asks for one a second.

mod outlook;

use crate::camera::Camera;
use crate::earth::view::View;
use crate::earth::{Body, EarthParameters};
use crate::frames::{Direction, EarthPath, Icrs, Lvlh, Rotation, StarPath};
use crate::orbit::OrbitState;
use crate::orbit::body::CentralBody;
use crate::orbit::constants::{AU_KM, MICROSECONDS};
use crate::orbit::dynamics::PropagationError;
use crate::orbit::ephemeris::Bodies;
use crate::orbit::forces::Forces;
use crate::orbit::lvlh::lvlh;
use crate::trigonometry::sine_cosine;
use nalgebra::{Matrix3, Vector3};
pub use outlook::{Change, Outlook};
use serde::{Deserialize, Serialize};

/// Angular radius of the Sun at 1 au, rad (0.2666 deg).
const SUN_RADIUS_RAD: f32 = 4.653e-3;
/// Seconds of a step. A state that lasts no longer than a step may be passed over: the shortest of thesis
/// fig. 8.5 last 12 s.
pub const STEP_S: u8 = 5;

/// What the sensor can do (thesis tab. 8.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum SensorState {
    /// Earth and stars are seen.
    Full = 0,
    /// The Sun is in the Earth path and blinds the detector.
    SunInEarthPath = 1,
    /// No lit limb is on the detector; stars are seen.
    Eclipse = 2,
    /// The Sun is in the star path and blinds the detector.
    SunInStarPath = 3,
    /// The same, and its image lies on that of the Earth.
    SunInStarPathOverEarth = 4,
}

impl SensorState {
    /// Of a field without the Sun, whether a limb in it is lit or not.
    pub(crate) fn by_light(lit: bool) -> Self {
        if lit { Self::Full } else { Self::Eclipse }
    }

    /// Whether it is the limb that it tells of, not the Sun.
    fn rests_on_limb(self) -> bool {
        matches!(self, Self::Full | Self::Eclipse)
    }
}

/// Law by which the Earth path is pointed.
#[derive(Clone, Copy, Debug)]
pub enum PointingLaw {
    /// At rest against local vertical and local horizontal; see [`PointingLaw::nadir`].
    Local(Rotation<Lvlh, EarthPath>),
    /// At a fixed angle below the horizon of a sphere of the equator's radius: what an eccentric orbit needs
    /// (thesis §8.2.1.3).
    Horizon {
        /// From the horizon ahead towards nadir, rad.
        below_rad: f32,
        /// About the line of sight, rad.
        roll_rad: f32,
    },
    /// At rest in space.
    Inertial(Rotation<Icrs, EarthPath>),
}

impl PointingLaw {
    /// At a fixed angle from nadir towards flight; then the frame turns about the line of sight by the roll.
    pub fn nadir(off_nadir_rad: f32, roll_rad: f32) -> Self {
        Self::Local(from_nadir(off_nadir_rad, roll_rad))
    }

    /// The attitude of the Earth path; `None` where position and velocity span no plane.
    pub(crate) fn earth_path(
        &self,
        about: CentralBody,
        orbit: &OrbitState,
    ) -> Option<Rotation<Icrs, EarthPath>> {
        let path = match self {
            Self::Local(path) => *path,
            Self::Horizon { below_rad, roll_rad } => {
                let equator_km = about.facts().radius_km;
                let radius = libm::sqrt(orbit.position_km.norm_squared()).max(equator_km);
                from_nadir(libm::asinf((equator_km / radius) as f32) - below_rad, *roll_rad)
            }
            Self::Inertial(path) => return Some(*path),
        };
        Some(local_axes(orbit)?.then(&path))
    }
}

/// The Earth path at an angle from nadir towards flight, then turned about its line of sight by the roll.
fn from_nadir(off_nadir_rad: f32, roll_rad: f32) -> Rotation<Lvlh, EarthPath> {
    let (sine, cosine) = sine_cosine(off_nadir_rad);
    let raised = Matrix3::new(cosine, 0.0, -sine, 0.0, 1.0, 0.0, sine, 0.0, cosine);
    let (sine, cosine) = sine_cosine(roll_rad);
    let rolled = Matrix3::new(cosine, sine, 0.0, -sine, cosine, 0.0, 0.0, 0.0, 1.0);
    Rotation::from_orthogonal(rolled * raised)
}

/// Local vertical and local horizontal of a state; `None` where it spans no plane.
pub(crate) fn local_axes(orbit: &OrbitState) -> Option<Rotation<Icrs, Lvlh>> {
    let axes = lvlh(&orbit.position_km, &orbit.velocity_km_s)?;
    Some(Rotation::from_orthogonal(axes.map(|element| element as f32)))
}

/// What a forecast rests on.
#[derive(Clone, Copy, Debug)]
pub struct Forecast<'a> {
    /// Lens and detector of both paths.
    pub camera: &'a Camera,
    /// Mounting.
    pub star_to_earth: Rotation<StarPath, EarthPath>,
    /// How the satellite is pointed.
    pub pointing: PointingLaw,
    /// The Earth's shape, and from which elevation of the Sun its limb is lit.
    pub earth: &'a EarthParameters,
    /// Forces on the satellite, and what it flies about.
    pub forces: Forces,
}

/// Whether a disc about the Sun's direction in the star path and in the Earth path touches the field of the
/// one and of the other; neither where it is `hidden`, which is asked only where one is touched.
pub(crate) fn fields_met(
    camera: &Camera,
    (in_star_path, in_earth_path): (&Direction<StarPath>, &Direction<EarthPath>),
    radius_rad: f32,
    hidden: impl FnOnce() -> bool,
) -> (bool, bool) {
    let star = camera.star_field_meets(in_star_path, radius_rad);
    let earth = camera.earth_field_meets(in_earth_path, radius_rad);
    if (star || earth) && hidden() { (false, false) } else { (star, earth) }
}

/// The state by the fields of star path and Earth path that the Sun's disc touches; `None` where it touches
/// neither, and where it is in the star path and nobody knows whether over the body or beside it. `view`: the
/// body as the Earth path sees it.
pub(crate) fn state_by_sun(
    camera: &Camera,
    in_star_path: &Direction<StarPath>,
    touched: (bool, bool),
    view: Option<&View>,
) -> Option<SensorState> {
    match touched {
        (_, true) => Some(SensorState::SunInEarthPath),
        (false, false) => None,
        (true, false) => {
            let view = view?;
            // Where the Sun's image lies, the Earth path sees what it sees there.
            let seen = camera.project(in_star_path).and_then(|at| camera.earth_direction(at));
            Some(match seen.is_some_and(|direction| view.hides_disc(&direction, 0.0)) {
                true => SensorState::SunInStarPathOverEarth,
                false => SensorState::SunInStarPath,
            })
        }
    }
}

impl Forecast<'_> {
    /// The sensor's state at a state of the orbit; `None` where that is none of a satellite (inside the
    /// Earth, straight up).
    pub fn state(&self, orbit: &OrbitState) -> Option<SensorState> {
        let (view, sun) = self.view(orbit)?;
        let in_star_path = self.star_to_earth.inverse().apply(&sun);
        let hidden = || view.hides_disc(&sun, SUN_RADIUS_RAD);
        let touched = fields_met(self.camera, (&in_star_path, &sun), SUN_RADIUS_RAD, hidden);
        let by_light = || SensorState::by_light(view.lit_margin_rad(self.camera, self.earth, 0.0) > 0.0);
        let by_sun = state_by_sun(self.camera, &in_star_path, touched, Some(&view));
        Some(by_sun.unwrap_or_else(by_light))
    }

    /// How much of the limb in the field is lit, see [`View::lit_margin_rad`].
    fn lit_margin_rad(&self, orbit: &OrbitState) -> Option<f32> {
        let (view, _) = self.view(orbit)?;
        Some(view.lit_margin_rad(self.camera, self.earth, f32::INFINITY))
    }

    /// The body and the Sun as the Earth path sees them.
    fn view(&self, orbit: &OrbitState) -> Option<(View, Direction<EarthPath>)> {
        let path = self.pointing.earth_path(self.forces.body, orbit)?;
        let bodies = Bodies::at(self.forces.body, orbit.time_us);
        let to_sun = (bodies.sun_km - orbit.position_km).map(|axis| (axis / AU_KM) as f32);
        let sun: Direction<EarthPath> = path.apply(&Direction::new(to_sun)?);
        let pole = path.apply(&Direction::new(bodies.pole.map(|axis| axis as f32))?);
        let body = Body::at_height(&pole, Some(&sun), &self.earth.ellipsoid, 0.0);
        let centre_km: Vector3<f32> = path.matrix() * orbit.position_km.map(|axis| -axis as f32);
        Some((View::new(&centre_km, &body)?, sun))
    }

    /// Goes on from `orbit`, whose state is `state`, to the first whole second in which it is another one, at
    /// most [`STEP_S`] seconds.
    ///
    /// # Errors
    /// When the orbit leaves the bounds of the dynamics, or has no state there.
    pub fn step(
        &self,
        orbit: &OrbitState,
        state: SensorState,
    ) -> Result<(OrbitState, SensorState), PropagationError> {
        let after = |seconds: u8| {
            let later = self.forces.propagate(orbit, i64::from(seconds) * MICROSECONDS as i64)?;
            let state = self.state(&later).ok_or(PropagationError::Impossible)?;
            Ok((later, state))
        };
        let end = after(STEP_S)?;
        if end.1 == state {
            return Ok(end);
        }
        for seconds in 1..STEP_S {
            let sooner = after(seconds)?;
            if sooner.1 != state {
                return Ok(sooner);
            }
        }
        Ok(end)
    }
}

#[cfg(test)]
mod tests;
