//! Truth orbit: where the satellite is at any time of a run, a pure function.
//!
//! In: position and velocity at the start with the forces that act, or the samples of an orbit file; GCRF
//! axes about the central body, km and km/s. Out: both at any time of the run.
//!
//! | module | does |
//! |---|---|
//! | `elements` | Kepler's elements to a state; what is an orbit about a body |
//! | [`tle`] | two-line elements to a state |
//! | [`forces`], [`gravity`], [`atmosphere`], [`radiation`] | acceleration |
//! | `integrator` | steps from node to node |
//! | [`oem`], [`sp3`] | orbit files to samples |
//! | [`track`] | samples to nodes |
//!
//! Between nodes runs the polynomial of fifth degree that has position, velocity and acceleration of both;
//! velocity is its slope. Error of a day (greatest distance from a run with a thousandth of the tolerance,
//! between nodes as well as on them), and cost on a desktop core:
//!
//! | orbit | gravity alone | all forces | nodes | set up |
//! |---|---|---|---|---|
//! | GEO | 0.06 mm | 0.07 mm | 125 | 14 ms |
//! | 450 km | 0.05 mm | 4 cm | 1227 | 180 ms |
//! | GTO, 210 km by 36,000 km | 0.5 mm | 1.3 m | 402 | |
//!
//! What steps of high order stumble at are the edge of the Earth's shadow (LEO) and the kinks of the air's
//! tables (GTO). A call of [`TruthOrbit::at`] takes 50 to 80 ns.
//!
//! Against GMAT's trajectories with its forces (EGM96 2 x 2, Sun, Moon) after 7 days: LEO 6 cm; GEO 2.1 m,
//! 0.3 m a day, where the Moon's place (10 arcsec) is what differs most. A day of Jason-2 (1336 km) from one
//! state of its precise orbit, nothing fitted: 2 m radial, 12 m along, 6 m across, with 36 x 36 7 m along;
//! all that is left out or guessed is in this.

pub mod atmosphere;
mod elements;
pub mod forces;
pub mod gravity;
mod integrator;
pub mod oem;
pub mod radiation;
pub mod sp3;
pub mod tle;
pub mod track;

pub use elements::{check_state, state_of_elements};
pub use forces::Forces;
pub use gravity::{MU_EARTH, mu_km3_s2};

use super::vector::{length, minus, plus, times};
use crate::world::attitude::Vector;
use crate::world::time::civil_time;
use forces::Dynamics;
use fsw_core::orbit::body::CentralBody;
use gravity::Gravity;
use integrator::Node;
use std::sync::Arc;

/// Error of a step that is let pass, km.
const TOLERANCE_KM: f64 = 1e-10;
/// How far the nodes reach beyond the run on either side, s: exposures and rates look a little before and
/// after.
const MARGIN_S: f64 = 2.0;
/// Longest run, s.
pub const LONGEST_S: u32 = 60 * 86_400;

/// Why an orbit cannot be flown.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OrbitError {
    /// A value is not finite.
    #[error("{0} is no number")]
    NotFinite(&'static str),
    /// The eccentricity is not that of an ellipse.
    #[error("eccentricity {0} is not that of an ellipse (0 to below 1)")]
    Eccentricity(f64),
    /// The semi-major axis is not positive.
    #[error("semi-major axis {0} km is not positive")]
    SemiMajorAxis(f64),
    /// The orbit comes too close to the body.
    #[error("perigee at {0:.1} km from the centre is below {1} km")]
    Perigee(f64, f64),
    /// The orbit leads too far, where the body no longer rules it.
    #[error("apogee at {0:.0} km from the centre is beyond {1} km")]
    Apogee(f64, f64),
    /// The velocity is enough to escape.
    #[error("a speed of {0:.3} km/s leaves the body")]
    Escape(f64),
    /// The run is too long.
    #[error("{0} s is longer than {LONGEST_S} s")]
    Duration(u32),
    /// The satellite comes down.
    #[error("{0:.0} s after the start the satellite is below {1} km from the centre")]
    Ground(f64, f64),
    /// The run is not inside the file: its first and last instant, TT, µs since J2000.
    #[error("the run is not within {} to {} UTC, which the file spans", civil_time::utc_text(*.0), civil_time::utc_text(*.1))]
    Span(i64, i64),
    /// Samples lie too far apart: the instant, and s to the next.
    #[error("after {} UTC there is no sample for {:.0} s, too long for this orbit", civil_time::utc_text(*.0), .1)]
    Sparse(i64, f64),
    /// There are too few samples.
    #[error("{0} samples are too few, 12 are needed")]
    Few(usize),
    /// The Earth's orientation is not known then.
    #[error("the Earth orientation file does not cover {} UTC", civil_time::utc_text(*.0))]
    Orientation(i64),
}

/// An orbit over the time of a run; a copy is cheap.
#[derive(Debug, Clone, PartialEq)]
pub struct TruthOrbit {
    body: CentralBody,
    start_us: i64,
    /// The first begins before the start, the last ends after the end.
    pieces: Arc<[Piece]>,
}

impl TruthOrbit {
    /// Flies about the Earth from `start_us` (TT since J2000) over `seconds` under all forces
    /// ([`Forces::default`]).
    ///
    /// # Errors
    /// When the start is no orbit that clears the body, or the air brings the satellite down.
    pub fn new(
        start_us: i64,
        position_km: Vector,
        velocity_km_s: Vector,
        seconds: u32,
    ) -> Result<Self, OrbitError> {
        Self::with_forces(start_us, position_km, velocity_km_s, seconds, &Forces::default())
    }

    /// As [`Self::new`], under other forces and about their body.
    ///
    /// # Errors
    /// As [`Self::new`]; or when the Earth's orientation is not known over the run.
    pub fn with_forces(
        start_us: i64,
        position_km: Vector,
        velocity_km_s: Vector,
        seconds: u32,
        forces: &Forces,
    ) -> Result<Self, OrbitError> {
        check_state(forces.body, position_km, velocity_km_s)?;
        let end_us = start_us + i64::from(seconds) * 1_000_000;
        if let Some(day_us) = forces.orientation.missing(start_us, end_us) {
            return Err(OrbitError::Orientation(day_us));
        }
        let gravity = Gravity::about(forces.body, forces.gravity_degree, forces.gravity_order);
        let dynamics = Dynamics::new(start_us, gravity, forces);
        Self::fly(dynamics, position_km, velocity_km_s, seconds, TOLERANCE_KM)
    }

    fn fly(
        mut dynamics: Dynamics<'_>,
        position: Vector,
        velocity: Vector,
        seconds: u32,
        tolerance_km: f64,
    ) -> Result<Self, OrbitError> {
        if seconds > LONGEST_S {
            return Err(OrbitError::Duration(seconds));
        }
        let (start_us, body) = (dynamics.start_us(), dynamics.body());
        let [least_km, _] = body.facts().orbit_km;
        let mu = mu_km3_s2(body);
        let mut acceleration = |t_s, r, v| dynamics.acceleration(t_s, r, v);
        let start =
            Node { t_s: 0.0, position, velocity, acceleration: acceleration(0.0, position, velocity) };
        let (before, _) = integrator::step(&mut acceleration, &start, -MARGIN_S, tolerance_km);
        let flies = |node: &Node| length(node.position) >= least_km;
        let until_s = f64::from(seconds) + MARGIN_S;
        let way = integrator::integrate(&mut acceleration, mu, start, until_s, tolerance_km, flies);
        match way.last() {
            Some(last) if !flies(last) => Err(OrbitError::Ground(last.t_s, least_km)),
            _ => {
                let nodes: Vec<Node> = std::iter::once(before).chain(way).collect();
                Ok(Self::through(body, start_us, &nodes))
            }
        }
    }

    /// Follows the samples of an orbit file about the Earth from `start_us` over `seconds`.
    ///
    /// # Errors
    /// When the run is not within the samples, these are too few or too far apart, or the Earth's orientation
    /// is not known.
    pub fn along(
        samples: &track::Samples,
        start_us: i64,
        seconds: u32,
        orientation: &crate::world::time::earth_orientation::EarthOrientation,
    ) -> Result<Self, OrbitError> {
        let nodes = track::nodes(samples, start_us, seconds, orientation)?;
        Ok(Self::through(CentralBody::Earth, start_us, &nodes))
    }

    fn through(body: CentralBody, start_us: i64, nodes: &[Node]) -> Self {
        let pieces = nodes.windows(2).map(|pair| Piece::between(&pair[0], &pair[1])).collect();
        Self { body, start_us, pieces }
    }

    /// What it leads about.
    pub fn body(&self) -> CentralBody {
        self.body
    }

    /// The instant of `t_s` = 0, TT, µs since J2000.0.
    pub fn start_us(&self) -> i64 {
        self.start_us
    }

    /// The instant of `t_s`, TT, µs since J2000.0, rounded.
    pub fn instant_us(&self, t_s: f64) -> i64 {
        self.start_us + libm::rint(t_s * 1e6) as i64
    }

    /// Position (km) and velocity (km/s) `t_s` seconds after the start. Outside the run the orbit is held to
    /// the last step's curve, which is good for seconds only.
    pub fn at(&self, t_s: f64) -> (Vector, Vector) {
        let after = self.pieces.partition_point(|piece| piece.from_s <= t_s);
        let piece = &self.pieces[after.max(1) - 1];
        let t = t_s - piece.from_s;
        // Horner's scheme with the derivative.
        let (mut place, mut slope) = (piece.powers[5], [0.0; 3]);
        for power in piece.powers[..5].iter().rev() {
            slope = plus(place, t, slope);
            place = plus(*power, t, place);
        }
        (place, slope)
    }
}

/// The way from one node to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    from_s: f64,
    /// Coefficients of the powers of the time since `from_s`.
    powers: [Vector; 6],
}

impl Piece {
    /// The polynomial with position, velocity and acceleration of both nodes.
    fn between(a: &Node, b: &Node) -> Self {
        let h = b.t_s - a.t_s;
        // What the parabola from the first node lacks at the second: position, velocity, acceleration.
        let parabola = plus(times(h, a.velocity), 0.5 * h * h, a.acceleration);
        let d = minus(minus(b.position, a.position), parabola);
        let e = times(h, plus(minus(b.velocity, a.velocity), -h, a.acceleration));
        let f = times(h * h, minus(b.acceleration, a.acceleration));
        let cube = h * h * h;
        let sum = |d_share: f64, e_share: f64, f_share: f64, power: f64| {
            times(power.recip(), plus(plus(times(d_share, d), e_share, e), f_share, f))
        };
        let powers = [
            a.position,
            a.velocity,
            times(0.5, a.acceleration),
            sum(10.0, -4.0, 0.5, cube),
            sum(-15.0, 7.0, -1.0, cube * h),
            sum(6.0, -3.0, 0.5, cube * h * h),
        ];
        Self { from_s: a.t_s, powers }
    }
}

#[cfg(test)]
mod tests;
