//! Kepler's elements, and what counts as an orbit about a body.
//!
//! In: elements (km, degrees), or position and velocity. Out: position and velocity in the axes the angles
//! are counted in, or why it is no orbit: an ellipse within `orbit_km` of the body's row.

use super::OrbitError;
use super::gravity::mu_km3_s2;
use crate::world::attitude::Vector;
use crate::world::vector::{cross, length, plus, times};
use fsw_core::orbit::body::CentralBody;

/// Position (km) and velocity (km/s) of Kepler's elements, in the axes the angles are counted in.
///
/// # Errors
/// When the elements are no ellipse that clears the body; the message names the value.
pub fn state_of_elements(
    body: CentralBody,
    [a_km, e, i_deg, raan_deg, argp_deg, true_anomaly_deg]: [f64; 6],
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
    check_apsides(body, a_km, e)?;
    let angles = [i_deg, raan_deg, argp_deg, true_anomaly_deg].map(|a| libm::sincos(a.to_radians()));
    let [(si, ci), (so, co), (sw, cw), (sv, cv)] = angles;
    let towards_perigee = [co * cw - so * sw * ci, so * cw + co * sw * ci, sw * si];
    let ahead = [-co * sw - so * cw * ci, -so * sw + co * cw * ci, cw * si];
    let parameter = a_km * (1.0 - e * e);
    let radius = parameter / (1.0 + e * cv);
    let speed = (mu_km3_s2(body) / parameter).sqrt();
    let position = plus(times(radius * cv, towards_perigee), radius * sv, ahead);
    let velocity = plus(times(-speed * sv, towards_perigee), speed * (e + cv), ahead);
    Ok((position, velocity))
}

fn check_apsides(body: CentralBody, a_km: f64, e: f64) -> Result<(), OrbitError> {
    let [least_km, greatest_km] = body.facts().orbit_km;
    let (perigee, apogee) = (a_km * (1.0 - e), a_km * (1.0 + e));
    if perigee < least_km {
        return Err(OrbitError::Perigee(perigee, least_km));
    }
    if apogee > greatest_km {
        return Err(OrbitError::Apogee(apogee, greatest_km));
    }
    Ok(())
}

/// Refuses a start that is not on an ellipse clear of the body.
///
/// # Errors
/// When it is not; the message says why.
pub fn check_state(body: CentralBody, position: Vector, velocity: Vector) -> Result<(), OrbitError> {
    if !position.iter().all(|c| c.is_finite()) {
        return Err(OrbitError::NotFinite("the position"));
    }
    if !velocity.iter().all(|c| c.is_finite()) {
        return Err(OrbitError::NotFinite("the velocity"));
    }
    let (r, v) = (length(position), length(velocity));
    let [least_km, _] = body.facts().orbit_km;
    if r < least_km {
        return Err(OrbitError::Perigee(r, least_km));
    }
    let mu = mu_km3_s2(body);
    let per_a = 2.0 / r - v * v / mu;
    if per_a <= 0.0 {
        return Err(OrbitError::Escape(v));
    }
    let momentum = length(cross(position, velocity));
    let e = (1.0 - momentum * momentum / mu * per_a).max(0.0).sqrt();
    check_apsides(body, per_a.recip(), e)
}
