//! How the two paths look: the Earth path by the law the satellite is pointed with, the star path from the
//! mounting.
//!
//! In: time, orbit, [`Pointing`], mounting angles. Out: frames with their rates, ICRS to Earth path;
//! direction cosine matrices take components of the first frame to components of the second. The body's axes
//! are those of the Earth path.
//!
//! | law | Earth path |
//! |---|---|
//! | nadir | z to the Earth's centre, x along flight in the orbit plane, y = z x x, against the orbit normal (LVLH); then `off_nadir_deg` turns the line of sight from nadir towards flight, z = cos · nadir + sin · flight; `roll_deg` then turns about z |
//! | horizon | as nadir, but from nadir by `asin(a / r) - below`: z stays `below_deg` below the horizon of a sphere of the equator's radius `a`, whatever the distance `r` (thesis §8.2.1.3) |
//! | inertial | z to a right ascension and declination, x east, y north; then turned about z by a roll |
//! | spin | so at the start, then turning freely ([`Tumble`]) |
//!
//! Slews turn the body from there, one after the other, and the jitter from where they leave it. The rate is
//! the exact derivative: of the nadir law `ω = h / r² + (r f / h) r̂` with `h = r x v` and `f` the
//! acceleration along it. The star path's frame is that of the Earth path turned about x, then y, then z of
//! the turned frame: `[0, 90, 0]` looks along flight, `[90, 0, 0]` along the orbit normal when the Earth path
//! looks to nadir.

use super::jitter::Jitter;
use super::moving_frame::MovingFrame;
use super::slew::Slew;
use super::tumble::Tumble;
use crate::world::attitude::{Vector, apply, dot, quaternion, rotation};
use crate::world::earth::Figure;
use crate::world::orbit::TruthOrbit;
use crate::world::vector::{cross, length, minus, plus, product, times, transposed, unit};

/// Half the time over which the orbit's acceleration is a difference of velocities, s. It gives the turning
/// of the orbit's plane only, some 1e-6 rad/s, to 1e-6 of itself.
const ACCELERATION_STEP_S: f64 = 0.25;

/// What the Earth path's line of sight is held to.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// The Earth's centre.
    Nadir {
        /// Angle of the line of sight from nadir towards flight, degrees.
        off_nadir_deg: f64,
        /// Angle by which the frame is then turned about the line of sight, degrees.
        roll_deg: f64,
    },
    /// The horizon ahead.
    Horizon {
        /// Angle of the line of sight from the horizon towards nadir, degrees.
        below_deg: f64,
        /// Angle by which the frame is then turned about the line of sight, degrees.
        roll_deg: f64,
    },
    /// A direction in space.
    Inertial(Aim),
    /// Nothing: the body turns freely.
    Spin(Tumble),
}

/// Where the satellite is pointed, and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct Pointing {
    /// The law.
    pub law: Law,
    /// Slews from there, in the order of time; none begins before the one ahead of it is over.
    pub slews: Vec<Slew>,
    /// What is wrong with the pointing.
    pub jitter: Jitter,
}

impl Pointing {
    /// Whether it only follows the orbit or rests: no slews, no jitter, no spin.
    pub fn turns_evenly(&self) -> bool {
        self.slews.is_empty() && self.jitter.is_none() && !matches!(self.law, Law::Spin(_))
    }
}

impl Default for Pointing {
    fn default() -> Self {
        Self::nadir(0.0, 0.0)
    }
}

impl From<Law> for Pointing {
    fn from(law: Law) -> Self {
        Self { law, slews: Vec::new(), jitter: Jitter::default() }
    }
}

impl Pointing {
    /// By the nadir law, without slew and jitter.
    pub fn nadir(off_nadir_deg: f64, roll_deg: f64) -> Self {
        Law::Nadir { off_nadir_deg, roll_deg }.into()
    }

    /// ICRS to Earth path `t_s` seconds after the start.
    pub fn earth_path(&self, t_s: f64, orbit: &TruthOrbit) -> MovingFrame {
        let held = match &self.law {
            Law::Nadir { off_nadir_deg, roll_deg } => {
                let off_nadir = rotation(1, off_nadir_deg.to_radians());
                let turned = product(&rotation(2, roll_deg.to_radians()), &off_nadir);
                lvlh(t_s, orbit).then(&MovingFrame::fixed(turned))
            }
            Law::Horizon { below_deg, roll_deg } => {
                let horizon = towards_horizon(t_s, orbit, below_deg.to_radians());
                let roll = MovingFrame::fixed(rotation(2, roll_deg.to_radians()));
                lvlh(t_s, orbit).then(&horizon).then(&roll)
            }
            Law::Inertial(aim) => MovingFrame::fixed(aim.matrix()),
            Law::Spin(tumble) => tumble.at(t_s),
        };
        let turned = self.slews.iter().fold(held, |frame, slew| frame.then(&slew.at(t_s)));
        turned.then(&self.jitter.at(t_s))
    }
}

/// ICRS to the frame that looks to nadir, x along flight.
fn lvlh(t_s: f64, orbit: &TruthOrbit) -> MovingFrame {
    let (position, velocity) = orbit.at(t_s);
    let [before, after] = [-ACCELERATION_STEP_S, ACCELERATION_STEP_S].map(|step_s| orbit.at(t_s + step_s).1);
    let acceleration = times(0.5 / ACCELERATION_STEP_S, minus(after, before));
    let momentum = cross(position, velocity);
    let (up, normal) = (unit(position), unit(momentum));
    let (nadir, y) = (times(-1.0, up), times(-1.0, normal));
    let matrix = [cross(y, nadir), y, nadir];
    let along_orbit = times(dot(position, position).recip(), momentum);
    let of_plane = length(position) / length(momentum) * dot(acceleration, normal);
    MovingFrame { matrix, rate_rad_s: apply(&matrix, plus(along_orbit, of_plane, up)) }
}

/// LVLH turned about y, towards flight, to `below_rad` below the horizon; with `sine = a / r` the angle
/// changes by `-sine / cosine r' / r` a second.
fn towards_horizon(t_s: f64, orbit: &TruthOrbit, below_rad: f64) -> MovingFrame {
    let (position, velocity) = orbit.at(t_s);
    let square = dot(position, position);
    let sine = Figure::of(orbit.body()).equator_km / square.sqrt();
    let (angle, cosine) = (libm::asin(sine.min(1.0)), (1.0 - sine * sine).max(1e-9).sqrt());
    let change = -sine / cosine * dot(position, velocity) / square;
    MovingFrame { matrix: rotation(1, angle - below_rad), rate_rad_s: [0.0, change, 0.0] }
}

/// A direction in space for the line of sight, and a roll about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    /// Right ascension, ICRS, degrees.
    pub ra_deg: f64,
    /// Declination, ICRS, degrees.
    pub dec_deg: f64,
    /// Turning about the line of sight from x east, y north, degrees.
    pub roll_deg: f64,
}

impl Aim {
    /// ICRS to a frame whose z is the line of sight.
    pub fn matrix(&self) -> [Vector; 3] {
        let (sr, cr) = sine_cosine(self.ra_deg);
        let (sd, cd) = sine_cosine(self.dec_deg);
        let frame = [[-sr, cr, 0.0], [-sd * cr, -sd * sr, cd], [cd * cr, cd * sr, sd]];
        product(&rotation(2, self.roll_deg.to_radians()), &frame)
    }
}

/// How the star path is mounted beside the Earth path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mount {
    /// Angles about x, then y, then z of the turned frame, degrees.
    pub star_path_deg: [f64; 3],
}

impl Mount {
    /// Earth path to star path.
    pub fn earth_to_star(&self) -> [Vector; 3] {
        let [x, y, z] = self.star_path_deg.map(f64::to_radians);
        product(&rotation(2, z), &product(&rotation(1, y), &rotation(0, x)))
    }

    /// The quaternion `[x, y, z, w]` whose matrix takes components in the star path's frame to the Earth
    /// path's.
    pub fn star_to_earth(&self) -> [f64; 4] {
        quaternion(&transposed(&self.earth_to_star()))
    }
}

fn sine_cosine(degrees: f64) -> (f64, f64) {
    libm::sincos(degrees.to_radians())
}

#[cfg(test)]
mod tests;
