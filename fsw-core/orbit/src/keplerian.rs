//! Kepler's elements of an orbit (thesis §5.2.1, A.1.3), for reports.
//!
//! They are made of the equinoctial ones, [`super::elements`], and are as exact in the singular cases: an
//! orbit without a perigee has an argument of perigee of 0, one without a node a right ascension of 0, and
//! the angles after these count from there. Nothing on board is computed with them.

use super::elements::{Equinoctial, angle_rad, radius_and_axis_km};
use core::f64::consts::{PI, TAU};
use fsw_ground::matrix::{dot, plus_scaled, scaled};
use fsw_ground::trigonometry::sine_cosine_f64;
use nalgebra::Vector3;

/// Below this eccentricity, and below this tangent of half the inclination to the equator, there is no
/// perigee and no node: rounding places them at random.
const SINGULAR: f64 = 1e-11;

/// Elements of a closed orbit, osculating, about the axes in which the state is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keplerian {
    /// Semi-major axis, km.
    pub semi_major_axis_km: f64,
    /// Eccentricity, 0 to 0.97.
    pub eccentricity: f64,
    /// Inclination, rad, 0 to π.
    pub inclination_rad: f64,
    /// Right ascension of the ascending node, rad, 0 to 2π.
    pub node_rad: f64,
    /// Argument of perigee, rad, 0 to 2π.
    pub perigee_rad: f64,
    /// True anomaly, rad, 0 to 2π.
    pub anomaly_rad: f64,
}

/// The same angle from 0 to 2π; from -4π to 4π.
fn positive(angle_rad: f64) -> f64 {
    let once = if angle_rad < 0.0 { angle_rad + TAU } else { angle_rad };
    let twice = if once < 0.0 { once + TAU } else { once };
    if twice >= TAU { twice - TAU } else { twice }
}

/// Angle of a direction with components of any length, and that length.
fn polar([x, y]: [f64; 2]) -> (f64, f64) {
    let length = libm::sqrt(x * x + y * y);
    if length > 0.0 { (angle_rad(y / length, x / length), length) } else { (0.0, 0.0) }
}

impl Keplerian {
    /// Of a position (km) and a velocity (km/s) about a body of this gravitational parameter (km³/s²); `None`
    /// where they are not those of a closed orbit of an eccentricity up to 0.97.
    #[inline(never)]
    pub fn of(mu_km3_s2: f64, position_km: &Vector3<f64>, velocity_km_s: &Vector3<f64>) -> Option<Self> {
        let elements = Equinoctial::of(mu_km3_s2, position_km, velocity_km_s)?;
        let ([h, k], [p, q]) = (elements.eccentricity, elements.inclination);
        let [f, g] = elements.axes();
        let (perigee_longitude_rad, eccentricity) = polar([k, h]);
        let (node_rad, half_tangent) = polar([q, p]);
        let (tilt_rad, _) = polar([1.0, half_tangent]);
        let node_rad = if half_tangent < SINGULAR { 0.0 } else { node_rad };
        let counted_rad = if elements.retrograde { -node_rad } else { node_rad };
        let longitude_rad = if eccentricity < SINGULAR { counted_rad } else { perigee_longitude_rad };
        let (place_rad, _) = polar([dot(&f, position_km), dot(&g, position_km)]);
        let (_, semi_major_axis_km) = radius_and_axis_km(mu_km3_s2, position_km, velocity_km_s);
        Some(Self {
            semi_major_axis_km,
            eccentricity,
            inclination_rad: if elements.retrograde { PI - 2.0 * tilt_rad } else { 2.0 * tilt_rad },
            node_rad: positive(node_rad),
            perigee_rad: positive(longitude_rad - counted_rad),
            anomaly_rad: positive(place_rad - longitude_rad),
        })
    }

    /// Position (km) and velocity (km/s) about such a body; `None` where the elements are not those of a
    /// closed orbit.
    pub fn state(&self, mu_km3_s2: f64) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let e = self.eccentricity;
        let parameter_km = self.semi_major_axis_km * (1.0 - e * e);
        // Also refuses what is not finite.
        if !(parameter_km > 0.0 && parameter_km < 1e9 && (0.0..1.0).contains(&e)) {
            return None;
        }
        let angles = [self.inclination_rad, self.node_rad, self.perigee_rad, self.anomaly_rad];
        if !angles.iter().all(|angle| libm::fabs(*angle) <= 2.0 * TAU) {
            return None;
        }
        let [(si, ci), (sn, cn), (sp, cp), (sa, ca)] = angles.map(sine_cosine_f64);
        // Towards the perigee, and a quarter of the way round.
        let towards = Vector3::new(cn * cp - sn * sp * ci, sn * cp + cn * sp * ci, sp * si);
        let across = Vector3::new(-cn * sp - sn * cp * ci, cn * cp * ci - sn * sp, cp * si);
        let radius_km = parameter_km / (1.0 + e * ca);
        let speed = libm::sqrt(mu_km3_s2 / parameter_km);
        let at = |x: f64, y: f64| plus_scaled(&scaled(&towards, x), y, &across);
        Some((at(radius_km * ca, radius_km * sa), at(-speed * sa, speed * (e + ca))))
    }
}

#[cfg(test)]
mod tests;
