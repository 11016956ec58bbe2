//! A trajectory about the Earth, and the truth of each of its instants.
//!
//! In: orbit, pointing, mounting, the Earth's looks, the camera's optics. Out: [`Truth`]. Frame of
//! `quaternion` and `rate_rad_s`: the star path; the rate is the exact derivative of the attitude.

use super::moving_frame::MovingFrame;
use super::pointing::{Mount, Pointing};
use crate::world::attitude::{Vector, apply, compose, matrix, normalised, quaternion};
use crate::world::body;
use crate::world::earth::image::{EarthImage, View};
use crate::world::earth::{EarthModel, Ellipsoid};
use crate::world::lens::optics::Optics;
use crate::world::orbit::TruthOrbit;
use crate::world::sky::sun;
use crate::world::time::ephemeris;
use crate::world::vector::{angle, length, minus, plus, times, transposed, unit};

/// An orbit, and how the camera looks from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// The orbit.
    pub orbit: TruthOrbit,
    /// Where the Earth path looks, and how well.
    pub pointing: Pointing,
    /// Where the star path looks beside it.
    pub mount: Mount,
    /// The looks of the Earth.
    pub earth: EarthModel,
}

/// How an exposure looks at the Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Seed of the run: of clouds and of the horizon.
    pub seed: u64,
    /// Width of the PSF, px.
    pub psf_sigma_px: f64,
    /// Exposure, s.
    pub exposure_s: f64,
    /// From a row to the next, s; 0 for a global shutter.
    pub row_time_s: f64,
    /// Share of the path's light that filters and shutters let through.
    pub transmission: f64,
}

/// What the sensor can do (thesis tab. 8.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum SensorState {
    /// Earth and stars are seen.
    #[default]
    Full = 0,
    /// The Sun is in the Earth path and blinds the detector.
    SunInEarthPath = 1,
    /// No lit limb is on the detector: the Sun is behind the Earth, or the night side fills the view.
    Eclipse = 2,
    /// The Sun is in the star path and blinds the detector.
    SunInStarPath = 3,
    /// The same, and its image lies on that of the Earth.
    SunInStarPathOverEarth = 4,
}

impl SensorState {
    /// Whether the Sun blinds the whole detector.
    pub fn is_blinded(self) -> bool {
        matches!(self, Self::SunInEarthPath | Self::SunInStarPath | Self::SunInStarPathOverEarth)
    }
}

/// The truth of an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// The instant, TT, µs since J2000.
    pub instant_us: i64,
    /// ICRS to star path.
    pub quaternion: [f64; 4],
    /// Rate in the star path's axes, rad/s.
    pub rate_rad_s: Vector,
    /// Position about the central body, ICRS axes, km.
    pub position_km: Vector,
    /// Velocity about the central body, ICRS axes, km/s.
    pub velocity_km_s: Vector,
    /// Unit vector to the Sun, ICRS axes.
    pub sun: Vector,
    /// ICRS to Earth path.
    pub earth_path: [Vector; 3],
    /// What the sensor can do.
    pub state: SensorState,
    /// The Earth's figure from there, with the equator of date.
    pub ellipsoid: Ellipsoid,
    /// Whether the Earth comes near the star path's field, where no grey filter dims it.
    pub earth_in_star_path: bool,
    /// Limb on the detector that is lit, degrees of azimuth about the Earth's centre.
    pub lit_limb_deg: f64,
}

impl Truth {
    /// The lit limb on the detector: the ellipsoid's normals and the places, ICRS axes, km. `optics` are those of
    /// the star path.
    pub fn lit_limb(&self, optics: &Optics) -> impl Iterator<Item = (Vector, Vector)> {
        self.ellipsoid.lit_limb(self.sun, move |d| in_field(optics, apply(&self.earth_path, d)))
    }

    /// Rate in the axes of the body, which are those of the Earth path, rad/s.
    pub fn body_rate_rad_s(&self) -> Vector {
        apply(&self.earth_path, apply(&transposed(&matrix(self.quaternion)), self.rate_rad_s))
    }
}

/// Whether the Earth path has a direction, its axes, in the field; `optics` are those of the star path.
fn in_field(optics: &Optics, direction: Vector) -> bool {
    optics.earth_path().project(direction).is_some_and(|pixel| optics.on_detector(pixel))
}

/// How far inside the field of the Earth path a direction is, rad; negative outside.
fn inside_rad(optics: &Optics, direction: Vector) -> f64 {
    let inside = |pixel| optics.inside_px(pixel) / optics.focal_length_px();
    optics.earth_path().project(direction).map_or(f64::MIN, inside)
}

/// Steps of an exposure: its attitude is the mean of their middles, and at their ends the scene asks for the rate.
pub(in crate::world) const EXPOSURE_STEPS: u32 = 32;

impl Trajectory {
    /// ICRS to star path.
    fn star_path(&self, t_s: f64) -> MovingFrame {
        self.beside(&self.pointing.earth_path(t_s, &self.orbit))
    }

    /// ICRS to star path from ICRS to Earth path.
    fn beside(&self, earth_path: &MovingFrame) -> MovingFrame {
        earth_path.then(&MovingFrame::fixed(self.mount.earth_to_star()))
    }

    /// ICRS to Earth path.
    pub fn earth_path(&self, t_s: f64) -> [Vector; 3] {
        self.pointing.earth_path(t_s, &self.orbit).matrix
    }

    /// ICRS to star path, as a quaternion.
    pub fn quaternion(&self, t_s: f64) -> [f64; 4] {
        quaternion(&self.star_path(t_s).matrix)
    }

    /// Rate in the star path's axes, rad/s.
    pub fn rate_rad_s(&self, t_s: f64) -> Vector {
        self.star_path(t_s).rate_rad_s
    }

    /// Means of attitude (ICRS to star path) and rate (star path's axes, rad/s) over an exposure of `time_s` about
    /// `t_s`; `None` where it turns evenly: then they are those of the middle.
    pub fn mean_over(&self, t_s: f64, time_s: f64) -> Option<([f64; 4], Vector)> {
        if self.pointing.turns_evenly() {
            return None;
        }
        let at = |share: f64| self.quaternion(t_s + (share - 0.5) * time_s);
        let middle = at(0.5);
        let mut sum = [0.0; 4];
        for step in 0..EXPOSURE_STEPS {
            let one = at((f64::from(step) + 0.5) / f64::from(EXPOSURE_STEPS));
            let sign = one.iter().zip(&middle).map(|(a, b)| a * b).sum::<f64>().signum();
            for (sum, part) in sum.iter_mut().zip(one) {
                *sum += sign * part;
            }
        }
        let [bx, by, bz, bw] = at(0.0);
        let [x, y, z, w] = normalised(compose(at(1.0), [-bx, -by, -bz, bw]))?;
        let half_sine = length([x, y, z]);
        let per_s =
            if half_sine > 0.0 { 2.0 * libm::atan2(half_sine, w) / (half_sine * time_s) } else { 0.0 };
        Some((normalised(sum)?, times(per_s, [x, y, z])))
    }

    /// `v / c` of the satellite about the Sun.
    pub fn aberration(&self, t_s: f64) -> Vector {
        let about_sun = body::velocity_km_s(self.orbit.body(), self.orbit.instant_us(t_s));
        times(ephemeris::LIGHT_KM_S.recip(), plus(self.orbit.at(t_s).1, 1.0, about_sun))
    }

    /// The truth `t_s` seconds after the start, for a camera whose star path is `optics`.
    pub fn truth(&self, t_s: f64, optics: &Optics) -> Truth {
        let (position_km, velocity_km_s) = self.orbit.at(t_s);
        let instant_us = self.orbit.instant_us(t_s);
        let earth_path = self.pointing.earth_path(t_s, &self.orbit);
        let MovingFrame { matrix: star_path, rate_rad_s } = self.beside(&earth_path);
        let earth_path = earth_path.matrix;
        let about = self.orbit.body();
        let sun = unit(minus(body::sun_km(about, instant_us), position_km));
        let ellipsoid = Ellipsoid::new(about, &body::icrs_to_equator(about, instant_us), position_km);
        let lit_limb_deg = ellipsoid.lit_limb_deg(sun, |d| in_field(optics, apply(&earth_path, d)));
        let in_earth_path = sun::touches(&optics.earth_path(), apply(&earth_path, sun));
        let in_star_path = sun::touches(optics, apply(&star_path, sun));
        let shines = (in_earth_path || in_star_path) && !ellipsoid.hides(sun, sun::RADIUS_RAD);
        // Where the Sun's image lies, the Earth path sees what it sees there.
        let over_earth = || {
            let pixel = optics.project(apply(&star_path, sun));
            let seen = pixel.and_then(|pixel| optics.earth_path().unproject(pixel));
            seen.is_some_and(|d| ellipsoid.hides(apply(&transposed(&earth_path), d), 0.0))
        };
        let lit =
            lit_limb_deg > 0.0 || ellipsoid.has_lit_limb(sun, |d| inside_rad(optics, apply(&earth_path, d)));
        let state = match (shines, lit) {
            (true, _) if in_earth_path => SensorState::SunInEarthPath,
            (true, _) if over_earth() => SensorState::SunInStarPathOverEarth,
            (true, _) => SensorState::SunInStarPath,
            (false, true) => SensorState::Full,
            (false, false) => SensorState::Eclipse,
        };
        let highest_km = ellipsoid.figure().equator_km + self.earth.atmosphere_top_km;
        let earth_rad = libm::asin((highest_km / length(position_km)).min(1.0));
        let nadir_rad = angle(star_path[2], times(-1.0, position_km));
        Truth {
            instant_us,
            quaternion: quaternion(&star_path),
            rate_rad_s,
            position_km,
            velocity_km_s,
            sun,
            earth_path,
            state,
            ellipsoid,
            earth_in_star_path: nadir_rad <= earth_rad + libm::acos(optics.cone_cosine(0.0)),
            lit_limb_deg,
        }
    }

    /// The Earth's light through the Earth path in an exposure about the time of `truth`.
    pub fn earth_image(&self, truth: &Truth, optics: &Optics, look: &Look) -> EarthImage {
        self.image(truth, &truth.earth_path, truth.body_rate_rad_s(), optics, look)
    }

    /// The Earth's light through the star path, where any of it may fall into the field: no grey filter dims
    /// it there, so its lit side floods what it covers. `look.transmission` is that of the star path, mirror
    /// included.
    pub fn earth_in_star_path(&self, truth: &Truth, optics: &Optics, look: &Look) -> Option<EarthImage> {
        if !truth.earth_in_star_path {
            return None;
        }
        let mut star_path = matrix(truth.quaternion);
        let [x, y, z] = truth.rate_rad_s;
        let mut rate = truth.rate_rad_s;
        if optics.mirrored() {
            // The lens behind the mirror sees everything turned over in x; a rate is turned the other way.
            star_path[0] = times(-1.0, star_path[0]);
            rate = [x, -y, -z];
        }
        let unfiltered =
            look.transmission / (self.earth.mirror_transmission * self.earth.filter_transmission);
        Some(self.image(truth, &star_path, rate, optics, &Look { transmission: unfiltered, ..*look }))
    }

    fn image(
        &self,
        truth: &Truth,
        path: &[Vector; 3],
        rate_rad_s: Vector,
        optics: &Optics,
        look: &Look,
    ) -> EarthImage {
        let view = View {
            ellipsoid: &truth.ellipsoid,
            earth_path: path,
            rate_rad_s,
            position_km: truth.position_km,
            velocity_c: times(ephemeris::LIGHT_KM_S.recip(), truth.velocity_km_s),
            sun: truth.sun,
            sidereal_rad: body::meridian_rad(truth.ellipsoid.body(), truth.instant_us),
            exposure_s: look.exposure_s,
            row_time_s: look.row_time_s,
            transmission: look.transmission,
        };
        EarthImage::new(&self.earth, look.seed, &optics.earth_path(), look.psf_sigma_px, &view)
    }
}

#[cfg(test)]
mod tests;
