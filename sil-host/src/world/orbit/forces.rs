//! What pulls and pushes a satellite.
//!
//! In: position and velocity in GCRF (km, km/s), time. Out: acceleration, km/s². The Earth's field in ITRF
//! ([`super::gravity`]); Sun and Moon as points, `mu (d / d³ - s / s³)`; drag `-rho |v| v Cd A / 2 m` against
//! air that turns with the Earth ([`super::atmosphere`]); the Sun's light ([`super::radiation`]). Left out:
//! tides of the crust and the sea, relativity, the Earth's own light, planets; a day of Jason-2 in [`super`]
//! bounds them. What each force moves a low orbit (450 km, 100 kg, 1 m²) in a day: field beyond J2 4.5 km,
//! beyond degree 4 930 m, beyond 10 350 m, degrees 21 to 36 (beyond the default) 210 m, Sun 39 m, Moon 37 m,
//! drag 9.1 km, sunlight 14 m.

use super::gravity::Gravity;
use super::{atmosphere, radiation};
use crate::world::attitude::{Vector, apply};
use crate::world::body;
use crate::world::time::earth_orientation::EarthOrientation;
use crate::world::time::ephemeris::EARTH_RATE_RAD_S;
use crate::world::vector::{cross, length, minus, plus, times, transposed};
use fsw_core::orbit::body::CentralBody;

/// The Sun's attraction, km³/s².
const MU_SUN: f64 = 132_712_440_041.279_42;

/// What drag and light find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Satellite {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Area that the air meets, m².
    pub drag_area_m2: f64,
    /// Coefficient of drag.
    pub cd: f64,
    /// Area that sunlight meets, m².
    pub radiation_area_m2: f64,
    /// Coefficient of radiation pressure: 1 takes all light up, 2 throws it straight back.
    pub cr: f64,
}

/// Which forces act.
#[derive(Debug, Clone, PartialEq)]
pub struct Forces {
    /// What they act about.
    pub body: CentralBody,
    /// Degree of the body's field; below 2 a point.
    pub gravity_degree: usize,
    /// Its order.
    pub gravity_order: usize,
    /// Whether the Sun pulls.
    pub sun: bool,
    /// Whether the Moon pulls, about the Moon the Earth.
    pub moon: bool,
    /// Whether the air brakes: about the Earth alone.
    pub drag: bool,
    /// Whether sunlight pushes.
    pub radiation_pressure: bool,
    /// What it acts on.
    pub satellite: Satellite,
    /// How the Earth stands.
    pub orientation: EarthOrientation,
}

impl Default for Forces {
    fn default() -> Self {
        Self {
            body: CentralBody::Earth,
            gravity_degree: 20,
            gravity_order: 20,
            sun: true,
            moon: true,
            drag: true,
            radiation_pressure: true,
            satellite: Satellite {
                mass_kg: 100.0,
                drag_area_m2: 1.0,
                cd: 2.2,
                radiation_area_m2: 1.0,
                cr: 1.3,
            },
            orientation: EarthOrientation::default(),
        }
    }
}

impl Forces {
    /// All that there are about a body.
    pub fn about(body: CentralBody) -> Self {
        let default = Self::default();
        let degree = default.gravity_degree.min(super::gravity::largest(body));
        Self {
            body,
            gravity_degree: degree,
            gravity_order: degree,
            moon: body != CentralBody::Mars,
            drag: body.facts().air,
            ..default
        }
    }

    /// Coefficient of drag times area over mass, m²/kg; 0 where the air does not act.
    pub fn drag_m2_kg(&self) -> f64 {
        let Satellite { mass_kg, drag_area_m2, cd, .. } = self.satellite;
        if self.drag { cd * drag_area_m2 / mass_kg } else { 0.0 }
    }

    /// Coefficient of radiation pressure times area over mass, m²/kg; 0 where sunlight does not act.
    pub fn radiation_m2_kg(&self) -> f64 {
        let Satellite { mass_kg, radiation_area_m2, cr, .. } = self.satellite;
        if self.radiation_pressure { cr * radiation_area_m2 / mass_kg } else { 0.0 }
    }
}

/// What the sky holds at one time.
#[derive(Debug, Clone, Copy)]
struct Surroundings {
    sun: Vector,
    neighbour: Option<(Vector, f64)>,
    fixed: [Vector; 3],
}

/// The equation of motion of a run.
#[derive(Debug)]
pub(super) struct Dynamics<'a> {
    start_us: i64,
    gravity: Gravity,
    forces: &'a Forces,
    /// The last surroundings: several stages of a step share a time.
    last: Option<(f64, Surroundings)>,
}

impl<'a> Dynamics<'a> {
    pub(super) fn new(start_us: i64, gravity: Gravity, forces: &'a Forces) -> Self {
        Self { start_us, gravity, forces, last: None }
    }

    /// The instant of time 0, TT, µs since J2000.0.
    pub(super) fn start_us(&self) -> i64 {
        self.start_us
    }

    /// What is flown about.
    pub(super) fn body(&self) -> CentralBody {
        self.forces.body
    }

    fn surroundings(&mut self, t_s: f64) -> Surroundings {
        if let Some((at_s, surroundings)) = self.last
            && at_s == t_s
        {
            return surroundings;
        }
        let time_us = self.start_us + libm::rint(t_s * 1e6) as i64;
        let forces = self.forces;
        let needs_sun = forces.sun || forces.drag || forces.radiation_pressure;
        let surroundings = Surroundings {
            sun: if needs_sun { body::sun_km(forces.body, time_us) } else { [0.0; 3] },
            neighbour: forces.moon.then(|| body::neighbour(forces.body, time_us)).flatten(),
            fixed: match forces.body {
                CentralBody::Earth => forces.orientation.gcrf_to_itrf(time_us),
                other => body::icrs_to_fixed(other, time_us),
            },
        };
        self.last = Some((t_s, surroundings));
        surroundings
    }

    /// Acceleration `t_s` seconds after the start.
    pub(super) fn acceleration(&mut self, t_s: f64, r: Vector, v: Vector) -> Vector {
        let Surroundings { sun, neighbour, fixed: itrf } = self.surroundings(t_s);
        let in_itrf = apply(&itrf, r);
        let mut sum = apply(&transposed(&itrf), self.gravity.acceleration(in_itrf));
        if self.forces.sun {
            sum = plus(sum, 1.0, third_body(r, sun, MU_SUN));
        }
        if let Some((place, mu)) = neighbour {
            sum = plus(sum, 1.0, third_body(r, place, mu));
        }
        if self.forces.drag {
            // Against the crust the air rests; the pole in the crust (0.5 arcsec) is of no moment here.
            let density = atmosphere::density_kg_m3(in_itrf, apply(&itrf, sun));
            let through_air = minus(v, times(EARTH_RATE_RAD_S, cross(itrf[2], r)));
            let share = 0.5e3 * density * self.forces.drag_m2_kg();
            sum = plus(sum, -share * length(through_air), through_air);
        }
        if self.forces.radiation_pressure {
            let radius_km = self.forces.body.facts().radius_km;
            sum = plus(sum, 1.0, radiation::acceleration(r, sun, (radius_km, self.forces.radiation_m2_kg())));
        }
        sum
    }
}

/// Pull of a body at `body` beyond its pull on the central body.
fn third_body(r: Vector, body: Vector, mu: f64) -> Vector {
    let d = minus(body, r);
    let (near, far) = (length(d), length(body));
    minus(times(mu / (near * near * near), d), times(mu / (far * far * far), body))
}
