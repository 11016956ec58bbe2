//! The small forces on a satellite, in f32: the Earth's field beyond J2, Sun and Moon, drag, the Sun's light.
//!
//! In: position and velocity (ICRS axes, km, km/s) and the time. Out: acceleration, km/s². All are computed
//! along the axes of the equator of date (about the Earth x towards the celestial intermediate origin), in
//! which the body turns about z by its rotation angle. About the Moon the Earth takes the Moon's place, about
//! Mars there is no second body and no drag.
//!
//! - Field: [`super::gravity`]. UT1 is taken as TT less 69.2 s ([`super::ephemeris`]); a
//!   second of that is 15 arcsec of longitude, 7e-5 of the tesserals' pull: 0.3 m of LEO's 4 km a day.
//! - Sun and Moon: their pull less that on the central body, by Battin's formula (*An Introduction to the
//!   Mathematics and Methods of Astrodynamics*, §8.4), which loses no digits in the difference. Where they
//!   stand is constant over one call, 150 s at most, in which the Moon moves by 0.02 deg.
//! - Drag: `-rho |v| v Cd A / 2 m` against air that turns with the Earth, [`super::atmosphere`].
//! - Light: 4.56e-6 N/m² at 1 au away from the Sun, on a ball; the Earth's shadow is a cone with a penumbra
//!   in which the light falls off linearly. Left out: the shadow's flattening (21 km at the poles, 3 s in
//!   LEO), the Earth's own light.
//!
//! f32 rounds positions to 0.25 m in LEO and 2 m in GEO, 1e-7 of these forces. Cost on the target: drag 1,400
//! cycles a call; see also [`super::gravity`].

use super::body::EARTH;
use super::constants::{AU_KM, MU_SUN_KM3_S2};
use super::ephemeris::{Bodies, equator_axes, rotation_rad};
use super::forces::Forces;
use super::{OrbitState, atmosphere, gravity};
use fsw_ground::trigonometry::sine_cosine;
use nalgebra::{Matrix3, Vector3};

/// Of the Earth, whose air alone is modelled.
const RADIUS_KM: f32 = EARTH.radius_km as f32;
const RATE_RAD_S: f32 = EARTH.rate_rad_s as f32;
/// Flattening of the Earth (WGS84).
const FLATTENING: f32 = 1.0 / 298.257_22;
/// Cosine and sine of the 30 deg by which the air's bulge follows the Sun.
const LAG: [f32; 2] = [0.866_025_4, 0.5];
/// Pressure of sunlight at 1 au over 1 m²/kg, km/s².
const LIGHT_KM_S2: f32 = 4.56e-9;
/// Angular radius of the Sun at 1 au, rad.
const SUN_RAD: f32 = 4.65e-3;

/// What does not change during one call of the propagation.
pub(super) struct Perturbations {
    forces: Forces,
    /// From ICRS.
    to_equator: Matrix3<f32>,
    /// The body's rotation at the start, rad.
    rotation_rad: f32,
    /// Unit vector to the Sun.
    sun: Vector3<f32>,
    /// Places of the Sun and the neighbour, km, and their gravitational parameters, km³/s².
    bodies: [(Vector3<f32>, f32); 2],
    /// Acceleration by its light, km/s².
    light_km_s2: f32,
}

impl Perturbations {
    /// From a time on, with the bodies of that time.
    #[inline(never)]
    pub(super) fn at(forces: Forces, time_us: i64, bodies: &Bodies) -> Self {
        let Bodies { sun_km, neighbour_km, neighbour_km3_s2, pole } = bodies;
        let to_equator = equator_axes(pole);
        let [sun_km, neighbour_km] =
            [sun_km, neighbour_km].map(|place| to_equator * place.map(|axis| axis as f32));
        let sun_au = sun_km * (1.0 / AU_KM as f32);
        let square = sun_au.dot(&sun_au);
        Self {
            bodies: [(sun_km, MU_SUN_KM3_S2 as f32), (neighbour_km, *neighbour_km3_s2 as f32)],
            forces,
            to_equator,
            rotation_rad: rotation_rad(forces.body, time_us),
            sun: sun_au / libm::sqrtf(square),
            light_km_s2: LIGHT_KM_S2 * forces.radiation_m2_kg / square,
        }
    }

    /// Acceleration `since_s` after the start, km/s², ICRS axes.
    #[inline(never)]
    pub(super) fn acceleration(&self, r: &Vector3<f64>, v: &Vector3<f64>, since_s: f32) -> Vector3<f64> {
        let r = self.to_equator * r.map(|axis| axis as f32);
        let v = self.to_equator * v.map(|axis| axis as f32);
        let Forces { body, degree, order, drag_m2_kg, .. } = self.forces;
        let facts = body.facts();
        let (sine, cosine) = sine_cosine(self.rotation_rad + facts.rate_rad_s as f32 * since_s);
        let mut sum = gravity::acceleration(body, (&r, [sine, cosine]), degree, order);
        if self.forces.sun_and_moon {
            for (place, mu) in &self.bodies {
                sum += tide(place, *mu, &r);
            }
        }
        if facts.air && drag_m2_kg > 0.0 {
            let [lag_cosine, lag_sine] = LAG;
            let [x, y, z] = self.sun.into();
            let apex = Vector3::new(lag_cosine * x - lag_sine * y, lag_sine * x + lag_cosine * y, z);
            let cosine = apex.dot(&r) / libm::sqrtf(r.dot(&r));
            sum += drag(&r, &v, atmosphere::bulge(cosine)) * drag_m2_kg;
        }
        sum += self.sun * (-self.light_km_s2 * sunlight(&r, &self.sun, facts.radius_km as f32));
        self.to_equator.tr_mul(&sum).map(f64::from)
    }
}

/// Pull of a body at `body` on a satellite at `r` less its pull on the central body, km/s²; 0 where there is
/// no such body (`mu` = 0).
fn tide(body: &Vector3<f32>, mu: f32, r: &Vector3<f32>) -> Vector3<f32> {
    let apart = body - r;
    // The bounds of the state include the Moon's place; at least 1,000 km, about half the Moon's radius, keep
    // the pull finite.
    let near = apart.dot(&apart).max(1e6);
    let far = body.dot(body).max(1e6);
    let q = r.dot(&(r - body * 2.0)) / far;
    let root = libm::sqrtf((1.0 + q).max(0.0));
    let f = q * (3.0 + q * (3.0 + q)) / (1.0 + (1.0 + q) * root);
    (r + body * f) * (-mu / (near * libm::sqrtf(near)))
}

/// Acceleration by drag per m²/kg, km/s²; position and velocity along the axes of the equator.
fn drag(r: &Vector3<f32>, v: &Vector3<f32>, bulge: f32) -> Vector3<f32> {
    let distance = libm::sqrtf(r.dot(r));
    let sine = r.z / distance;
    // The ellipse to the first order of its flattening: within 0.02 km.
    let height_km = distance - RADIUS_KM * (1.0 - FLATTENING * sine * sine);
    let through_air = Vector3::new(v.x + RATE_RAD_S * r.y, v.y - RATE_RAD_S * r.x, v.z);
    let speed = libm::sqrtf(through_air.dot(&through_air));
    // A half, and 1,000 m of a km.
    through_air * (-500.0 * atmosphere::density_kg_m3(height_km, bulge) * speed)
}

/// Size of the drag on a satellite at the mean of the day's least and greatest density, km/s²; the pole's
/// motion since J2000.0 is left out.
#[inline(never)]
pub(super) fn mean_drag_km_s2(state: &OrbitState, drag_m2_kg: f32) -> f32 {
    let [r, v] = [&state.position_km, &state.velocity_km_s].map(|vector| vector.map(|axis| axis as f32));
    let drag = drag(&r, &v, 0.5);
    drag_m2_kg * libm::sqrtf(drag.dot(&drag))
}

/// Share of the Sun's disc that is seen behind a ball, 0 to 1.
fn sunlight(r: &Vector3<f32>, sun: &Vector3<f32>, radius_km: f32) -> f32 {
    let along = r.dot(sun);
    if along > 0.0 {
        return 1.0;
    }
    let beside = r - sun * along;
    let beyond_km = libm::sqrtf(beside.dot(&beside)) - radius_km;
    // The penumbra's half width; at least 1 km.
    let half_km = (-along * SUN_RAD).max(1.0);
    (0.5 + 0.5 * beyond_km / half_km).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests;
