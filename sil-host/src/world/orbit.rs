//! Truth orbit: the Earth's two-body attraction and oblateness, Sun and Moon.
//!
//! In: position and velocity at the start, ICRS axes about the Earth's centre, km and km/s. Out: both at any time of the
//! run, a pure function. Runge and Kutta's fourth order with a step of [`STEP_S`] from node to node, cubic Hermite
//! interpolation between them. Forces: `-mu r / r³`, J2 about the pole of date, third bodies
//! `mu_b (d / d³ - s / s³)`; neither drag, solar pressure nor the rest of the field, which is the same world the
//! flight's filter is told of. [`Forces::sectorial`] adds C22 and S22 for comparison with other programs.
//!
//! Error after a day against half the step: below 0.1 mm in GEO, 21 mm in a low orbit, 6 mm in GTO. With C22 and S22,
//! against GMAT's trajectories: 1.4 m a day in GEO, 1.1 m in a low orbit.

use super::attitude::{Vector, apply, dot};
use super::ephemeris;
use super::vector::{cross, length, minus, plus, times, transposed};
use std::sync::Arc;

/// The Earth's attraction, km³/s².
pub const MU_EARTH: f64 = 398_600.441_8;
/// The Sun's, km³/s².
const MU_SUN: f64 = 132_712_440_041.279_42;
/// The Moon's, km³/s².
const MU_MOON: f64 = 4_902.800_118;
/// Radius to which the coefficients of the field belong, km (EGM96).
const FIELD_RADIUS_KM: f64 = 6_378.136_3;
/// Oblateness, EGM96.
const J2: f64 = 1.082_626_683e-3;
/// Ellipticity of the equator, EGM96, not normalised.
const C22: f64 = 1.574_460_4e-6;
const S22: f64 = -9.038_038e-7;

/// Step of the integration, s.
pub const STEP_S: f64 = 5.0;
/// Least distance from the Earth's centre, km: 100 km above the equator.
pub const LEAST_RADIUS_KM: f64 = 6478.0;
/// Greatest distance, km: beyond, the Earth no longer rules the orbit.
pub const GREATEST_RADIUS_KM: f64 = 500_000.0;
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
    /// The orbit comes too close to the Earth.
    #[error("perigee at {0:.1} km from the Earth's centre is below {LEAST_RADIUS_KM} km")]
    Perigee(f64),
    /// The orbit leaves the Earth too far.
    #[error("apogee at {0:.0} km from the Earth's centre is beyond {GREATEST_RADIUS_KM} km")]
    Apogee(f64),
    /// The velocity is enough to escape.
    #[error("a speed of {0:.3} km/s leaves the Earth")]
    Escape(f64),
    /// The run is too long.
    #[error("{0} s is longer than {LONGEST_S} s")]
    Duration(u32),
}

/// Position (km) and velocity (km/s) of Kepler's elements, in the axes the angles are counted in.
///
/// # Errors
/// When the elements are no ellipse that clears the Earth; the message names the value.
pub fn state_of_elements(
    a_km: f64,
    e: f64,
    i_deg: f64,
    raan_deg: f64,
    argp_deg: f64,
    true_anomaly_deg: f64,
) -> Result<(Vector, Vector), OrbitError> {
    let named = [
        (a_km, "the semi-major axis"),
        (e, "the eccentricity"),
        (i_deg, "the inclination"),
        (raan_deg, "the right ascension of the node"),
        (argp_deg, "the argument of perigee"),
        (true_anomaly_deg, "the true anomaly"),
    ];
    if let Some((_, name)) = named.iter().find(|(value, _)| !value.is_finite()) {
        return Err(OrbitError::NotFinite(name));
    }
    if !(0.0..1.0).contains(&e) {
        return Err(OrbitError::Eccentricity(e));
    }
    if a_km <= 0.0 {
        return Err(OrbitError::SemiMajorAxis(a_km));
    }
    check_apsides(a_km, e)?;
    let angles = [i_deg, raan_deg, argp_deg, true_anomaly_deg].map(|a| libm::sincos(a.to_radians()));
    let [(si, ci), (so, co), (sw, cw), (sv, cv)] = angles;
    let towards_perigee = [co * cw - so * sw * ci, so * cw + co * sw * ci, sw * si];
    let ahead = [-co * sw - so * cw * ci, -so * sw + co * cw * ci, cw * si];
    let parameter = a_km * (1.0 - e * e);
    let radius = parameter / (1.0 + e * cv);
    let speed = (MU_EARTH / parameter).sqrt();
    let position = plus(times(radius * cv, towards_perigee), radius * sv, ahead);
    let velocity = plus(times(-speed * sv, towards_perigee), speed * (e + cv), ahead);
    Ok((position, velocity))
}

fn check_apsides(a_km: f64, e: f64) -> Result<(), OrbitError> {
    let (perigee, apogee) = (a_km * (1.0 - e), a_km * (1.0 + e));
    if perigee < LEAST_RADIUS_KM {
        return Err(OrbitError::Perigee(perigee));
    }
    if apogee > GREATEST_RADIUS_KM {
        return Err(OrbitError::Apogee(apogee));
    }
    Ok(())
}

/// Which forces act beside the Earth's point mass and J2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Forces {
    /// Sun and Moon.
    pub sun_and_moon: bool,
    /// C22 and S22 of the Earth's field.
    pub sectorial: bool,
}

impl Default for Forces {
    fn default() -> Self {
        Self { sun_and_moon: true, sectorial: false }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    position: Vector,
    velocity: Vector,
}

/// An orbit over the time of a run; a copy is cheap.
#[derive(Debug, Clone, PartialEq)]
pub struct TruthOrbit {
    start_us: i64,
    step_s: f64,
    /// The first node lies a step before the start.
    nodes: Arc<[Node]>,
}

impl TruthOrbit {
    /// Integrates from `start_us` (TT since J2000) over `seconds`.
    ///
    /// # Errors
    /// When the start is no orbit about the Earth that clears it.
    pub fn new(
        start_us: i64,
        position_km: Vector,
        velocity_km_s: Vector,
        seconds: u32,
    ) -> Result<Self, OrbitError> {
        Self::with_forces(start_us, position_km, velocity_km_s, seconds, Forces::default(), STEP_S)
    }

    /// As [`Self::new`], with other forces and step.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_forces(
        start_us: i64,
        position_km: Vector,
        velocity_km_s: Vector,
        seconds: u32,
        forces: Forces,
        step_s: f64,
    ) -> Result<Self, OrbitError> {
        check_state(position_km, velocity_km_s)?;
        if seconds > LONGEST_S {
            return Err(OrbitError::Duration(seconds));
        }
        let mut field = Field { start_us, forces, bodies: Bodies::at(start_us), at_s: 0.0 };
        let start = Node { position: position_km, velocity: velocity_km_s };
        let count = (f64::from(seconds) / step_s).ceil() as usize + 3;
        let mut nodes = Vec::with_capacity(count);
        nodes.push(field.step(start, 0.0, -step_s));
        nodes.push(start);
        let mut node = start;
        for k in 0..count - 2 {
            node = field.step(node, k as f64 * step_s, step_s);
            nodes.push(node);
        }
        Ok(Self { start_us, step_s, nodes: nodes.into() })
    }

    /// The instant of `t_s` = 0, TT, µs since J2000.
    pub fn start_us(&self) -> i64 {
        self.start_us
    }

    /// The instant of `t_s`, TT, µs since J2000, rounded.
    pub fn instant_us(&self, t_s: f64) -> i64 {
        self.start_us + libm::rint(t_s * 1e6) as i64
    }

    /// Position (km) and velocity (km/s) `t_s` seconds after the start. Outside the run the orbit is held to the last
    /// step's curve, which is good for seconds only.
    pub fn at(&self, t_s: f64) -> (Vector, Vector) {
        let place = t_s / self.step_s + 1.0;
        let last = self.nodes.len() - 2;
        let index = (place.max(0.0) as usize).min(last);
        let (u, h) = (place - index as f64, self.step_s);
        let (a, b) = (self.nodes[index], self.nodes[index + 1]);
        let (uu, uuu) = (u * u, u * u * u);
        let chord = minus(b.position, a.position);
        let position = plus(a.position, 3.0 * uu - 2.0 * uuu, chord);
        let position = plus(position, h * (uuu - 2.0 * uu + u), a.velocity);
        let position = plus(position, h * (uuu - uu), b.velocity);
        let velocity = times(6.0 * (u - uu) / h, chord);
        let velocity = plus(velocity, 3.0 * uu - 4.0 * u + 1.0, a.velocity);
        (position, plus(velocity, 3.0 * uu - 2.0 * u, b.velocity))
    }
}

/// Refuses a start that is not on an ellipse clear of the Earth.
fn check_state(position: Vector, velocity: Vector) -> Result<(), OrbitError> {
    if !position.iter().all(|c| c.is_finite()) {
        return Err(OrbitError::NotFinite("the position"));
    }
    if !velocity.iter().all(|c| c.is_finite()) {
        return Err(OrbitError::NotFinite("the velocity"));
    }
    let (r, v) = (length(position), length(velocity));
    if r < LEAST_RADIUS_KM {
        return Err(OrbitError::Perigee(r));
    }
    let per_a = 2.0 / r - v * v / MU_EARTH;
    if per_a <= 0.0 {
        return Err(OrbitError::Escape(v));
    }
    let momentum = length(cross(position, velocity));
    let e = (1.0 - momentum * momentum / MU_EARTH * per_a).max(0.0).sqrt();
    check_apsides(per_a.recip(), e)
}

/// What pulls beside the Earth, at one time.
#[derive(Debug, Clone, Copy)]
struct Bodies {
    sun: Vector,
    moon: Vector,
    equator: [Vector; 3],
    sidereal: f64,
}

impl Bodies {
    fn at(time_us: i64) -> Self {
        Self {
            sun: ephemeris::sun_km(time_us),
            moon: ephemeris::moon_km(time_us),
            equator: ephemeris::icrs_to_equator(time_us),
            sidereal: ephemeris::sidereal_angle(time_us),
        }
    }
}

struct Field {
    start_us: i64,
    forces: Forces,
    /// The last bodies computed: the end of one step is the start of the next.
    bodies: Bodies,
    at_s: f64,
}

impl Field {
    fn bodies(&mut self, t_s: f64) -> Bodies {
        if t_s != self.at_s {
            self.bodies = Bodies::at(self.start_us + libm::rint(t_s * 1e6) as i64);
            self.at_s = t_s;
        }
        self.bodies
    }

    /// One step of Runge and Kutta.
    fn step(&mut self, from: Node, t_s: f64, h: f64) -> Node {
        let [first, middle, last] = [0.0, 0.5, 1.0].map(|share| self.bodies(t_s + share * h));
        let slope = |bodies: &Bodies, node: Node| Node {
            position: node.velocity,
            velocity: acceleration(node.position, bodies, self.forces),
        };
        let along = |k: f64, slope: Node| Node {
            position: plus(from.position, k, slope.position),
            velocity: plus(from.velocity, k, slope.velocity),
        };
        let a = slope(&first, from);
        let b = slope(&middle, along(0.5 * h, a));
        let c = slope(&middle, along(0.5 * h, b));
        let d = slope(&last, along(h, c));
        let sum = |k: [Vector; 4]| plus(plus(k[0], 2.0, plus(k[1], 1.0, k[2])), 1.0, k[3]);
        Node {
            position: plus(from.position, h / 6.0, sum([a, b, c, d].map(|n| n.position))),
            velocity: plus(from.velocity, h / 6.0, sum([a, b, c, d].map(|n| n.velocity))),
        }
    }
}

/// Acceleration at `r`, km/s².
fn acceleration(r: Vector, bodies: &Bodies, forces: Forces) -> Vector {
    let square = dot(r, r);
    let distance = square.sqrt();
    let central = -MU_EARTH / (square * distance);
    let pole = bodies.equator[2];
    let z = dot(r, pole);
    let share = 1.5 * J2 * (FIELD_RADIUS_KM / distance) * (FIELD_RADIUS_KM / distance);
    let oblate = plus(times(1.0 + share * (1.0 - 5.0 * z * z / square), r), 2.0 * share * z, pole);
    let mut sum = times(central, oblate);
    if forces.sun_and_moon {
        sum = plus(sum, 1.0, third_body(r, bodies.sun, MU_SUN));
        sum = plus(sum, 1.0, third_body(r, bodies.moon, MU_MOON));
    }
    if forces.sectorial {
        sum = plus(sum, 1.0, sectorial(r, bodies));
    }
    sum
}

fn third_body(r: Vector, body: Vector, mu: f64) -> Vector {
    let d = minus(body, r);
    let (near, far) = (length(d), length(body));
    minus(times(mu / (near * near * near), d), times(mu / (far * far * far), body))
}

/// Gradient of `3 mu R² [C22 (x² - y²) + 2 S22 x y] / r⁵` in the axes that turn with the Earth.
fn sectorial(r: Vector, bodies: &Bodies) -> Vector {
    let fixed = super::vector::product(&super::pointing::rotation(2, bodies.sidereal), &bodies.equator);
    let [x, y, z] = apply(&fixed, r);
    let square = dot(r, r);
    let scale = 3.0 * MU_EARTH * FIELD_RADIUS_KM * FIELD_RADIUS_KM / (square * square * square.sqrt());
    let form = C22 * (x * x - y * y) + 2.0 * S22 * x * y;
    let radial = -5.0 * form / square;
    let gradient =
        [2.0 * C22 * x + 2.0 * S22 * y + radial * x, -2.0 * C22 * y + 2.0 * S22 * x + radial * y, radial * z];
    times(scale, apply(&transposed(&fixed), gradient))
}

#[cfg(test)]
#[path = "orbit_tests.rs"]
mod tests;
