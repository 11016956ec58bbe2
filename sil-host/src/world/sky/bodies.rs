//! What is in the sky beside stars and Earth: planets, other satellites, the Moon, the Sun's light.
//!
//! In: which of them there are ([`BodiesModel`]), the truth of an exposure. Out: points of light for the star
//! path ([`BodiesModel::points`]) and light on the detector ([`BodyLight`]). The Moon is drawn in both paths,
//! behind the Earth where that stands before it; the stars behind the Moon are drawn through it.

use super::moon::{self, MoonImage, MoonView, STEP_PX};
use super::planets;
use super::satellites::{self, CROSSINGS_AN_HOUR_MAX, Satellite};
use super::sun::SunLight;
use crate::world::attitude::{Vector, apply, matrix};
use crate::world::earth::Ellipsoid;
use crate::world::lens::optics::Optics;
use crate::world::motion::Motion;
use crate::world::motion::trajectory::{Trajectory, Truth};
use crate::world::time::ephemeris;
use crate::world::vector::{length, transposed};
use fsw_hal::Window;

/// Most steps of a moving Moon.
const STEPS_MAX: f64 = 256.0;

/// What there is in the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodiesModel {
    /// Mercury to Saturn.
    pub planets: bool,
    /// The Moon.
    pub moon: bool,
    /// The Sun's image with halo, bloom and ghost, and its stray light. A Sun in the field veils the detector
    /// without it too.
    pub sun_light: bool,
    /// Satellites that cross the field in an hour, on average.
    pub satellites_an_hour: f64,
}

impl BodiesModel {
    /// Stars and Earth alone.
    pub const NONE: Self = Self { planets: false, moon: false, sun_light: false, satellites_an_hour: 0.0 };
    /// All of them, ten satellites an hour.
    pub const ALL: Self = Self { planets: true, moon: true, sun_light: true, satellites_an_hour: 10.0 };

    /// Whether all values make sense.
    pub fn is_sound(&self) -> bool {
        (0.0..=CROSSINGS_AN_HOUR_MAX).contains(&self.satellites_an_hour)
    }

    /// The points of light at `t_s` of the run `seed`.
    pub fn points(&self, seed: u64, t_s: f64, motion: &Motion, optics: &Optics) -> Vec<Point> {
        let mut points = Vec::new();
        if let Some(trajectory) = motion.trajectory().filter(|_| self.planets) {
            let planets = planets::at(trajectory.orbit.instant_us(t_s));
            let fixed = |p: planets::Planet| Point { place: Place::Fixed(p.direction), v: p.v, b_v: p.b_v };
            points.extend(planets.map(fixed));
        }
        let satellites = satellites::about(seed, t_s, self.satellites_an_hour, motion, optics);
        let moving = |s: Satellite| Point { v: s.v(t_s), b_v: SUNLIT_B_V, place: Place::Moving(s) };
        points.extend(satellites.into_iter().map(moving));
        points
    }
}

/// Colour index of sunlight.
const SUNLIT_B_V: f64 = 0.65;

/// A point of light that is no star.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    place: Place,
    /// Visual magnitude.
    pub v: f64,
    /// Colour index.
    pub b_v: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Fixed(Vector),
    Moving(Satellite),
}

impl Point {
    /// Unit vector to it, ICRS.
    pub fn direction(&self, t_s: f64) -> Vector {
        match &self.place {
            Place::Fixed(direction) => *direction,
            Place::Moving(satellite) => satellite.direction(t_s),
        }
    }

    /// Rate at which it moves among the stars, rad/s.
    pub fn rate_rad_s(&self) -> f64 {
        match &self.place {
            Place::Fixed(_) => 0.0,
            Place::Moving(satellite) => satellite.rate_rad_s(),
        }
    }
}

/// A path as an exposure sees through it.
#[derive(Debug, Clone, Copy)]
struct Path<'a> {
    optics: &'a Optics,
    /// Share of the light that entered the aperture.
    transmission: f64,
    /// Whether the grey filter stands in it.
    filtered: bool,
}

/// The settings of an exposure.
#[derive(Debug, Clone, Copy)]
pub struct Exposing {
    /// Middle of the exposure since the start, s.
    pub t_s: f64,
    /// Its length, s.
    pub time_s: f64,
    /// Width of the PSF, px.
    pub psf_sigma_px: f64,
    /// Shares of the light that pass star path and Earth path, mirror and filters included.
    pub transmissions: [f64; 2],
}

/// The Moon in a path.
#[derive(Debug, Clone)]
struct MoonInPath {
    image: MoonImage,
    earth: Ellipsoid,
    /// Path axes to ICRS.
    to_icrs: [Vector; 3],
}

/// Light of Moon and Sun in an exposure.
#[derive(Debug, Clone, Default)]
pub struct BodyLight {
    moons: Vec<MoonInPath>,
    sun: Vec<SunLight>,
}

impl BodyLight {
    /// Of an exposure about the time of `truth`, for a camera whose star path is `optics`.
    pub fn new(
        model: &BodiesModel,
        trajectory: &Trajectory,
        truth: &Truth,
        optics: &Optics,
        exposing: &Exposing,
    ) -> Self {
        let mut light = Self::default();
        if !model.moon && !model.sun_light {
            return light;
        }
        let [star, earth] = exposing.transmissions;
        let earth_optics = optics.earth_path();
        let star_path = Path { optics, transmission: star, filtered: false };
        let earth_path = Path { optics: &earth_optics, transmission: earth, filtered: true };
        let shines = !truth.ellipsoid.hides(truth.sun, super::sun::RADIUS_RAD);
        let (moon_km, sun_km) = (ephemeris::moon_km(truth.instant_us), ephemeris::sun_km(truth.instant_us));
        let aberration = trajectory.aberration(exposing.t_s);
        let view = |axes: &[Vector; 3]| moon::view(moon_km, sun_km, truth.position_km, aberration, axes);
        let axes = [matrix(truth.quaternion), truth.earth_path];
        for (path, axes) in [star_path, earth_path].into_iter().zip(axes) {
            if path.transmission <= 0.0 {
                continue;
            }
            let (aperture_e_s, sun) = (trajectory.earth.aperture_e_s(), apply(&axes, truth.sun));
            if model.sun_light && shines {
                let seen = SunLight::new(path.optics, sun, aperture_e_s, path.transmission, path.filtered);
                light.sun.extend(seen);
            }
            if model.moon {
                let image = moon_through(&path, view(&axes), view, trajectory, truth, exposing);
                let to_icrs = transposed(&axes);
                light.moons.extend(image.map(|image| MoonInPath { image, earth: truth.ellipsoid, to_icrs }));
            }
        }
        light
    }

    /// Adds the electrons of `time_s` to `electrons`, the pixels of `window` row by row.
    pub fn add_to(&self, window: Window, time_s: f64, electrons: &mut [f64]) {
        for moon in &self.moons {
            let hidden = |direction| moon.earth.hides(apply(&moon.to_icrs, direction), 0.0);
            moon.image.add_to(window, time_s, hidden, electrons);
        }
        for sun in &self.sun {
            sun.add_to(window, time_s, electrons);
        }
    }
}

/// The Moon's image through a path; `middle` is its view at mid-exposure, `view` that through other axes.
fn moon_through(
    path: &Path<'_>,
    middle: MoonView,
    view: impl Fn(&[Vector; 3]) -> MoonView,
    trajectory: &Trajectory,
    truth: &Truth,
    exposing: &Exposing,
) -> Option<MoonImage> {
    let f = path.optics.focal_length_px();
    let moved_px = exposing.time_s * length(truth.rate_rad_s) * f;
    // Far from the field no more is to be done.
    let far = moved_px + 20.0 * f * middle.radius_rad();
    if middle.moon[2] < path.optics.cone_cosine(far) {
        return None;
    }
    let steps = (moved_px / STEP_PX).ceil().clamp(1.0, STEPS_MAX);
    let views = (0..steps as u32).map(|step| {
        let t_s = exposing.t_s + exposing.time_s * ((f64::from(step) + 0.5) / steps - 0.5);
        let axes =
            if path.filtered { trajectory.earth_path(t_s) } else { matrix(trajectory.quaternion(t_s)) };
        view(&axes)
    });
    let white_e_s = trajectory.earth.aperture_e_s() * path.transmission / (std::f64::consts::PI * f * f);
    MoonImage::new(path.optics, exposing.psf_sigma_px, white_e_s, views.collect())
}

#[cfg(test)]
pub(in crate::world) mod tests;
