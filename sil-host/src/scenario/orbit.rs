//! The `[orbit]` of a scenario: Keplerian elements, or a state.

use super::text::Text;
use crate::error::HostError;
use crate::world::attitude::{Vector, dot};
use crate::world::orbit::state_of_elements;
use serde::Deserialize;
use toml::Spanned;

/// Semi-major axis, km: from just above the air to beyond the Moon.
const SEMI_MAJOR_AXIS_KM: (f64, f64) = (6_478.0, 500_000.0);
/// A lower perigee is no orbit, km from the Earth's centre.
const PERIGEE_MIN_KM: f64 = 6_478.0;
/// GM of the Earth, km³/s² (EGM2008).
const EARTH_GM_KM3_S2: f64 = 398_600.4418;
const ECCENTRICITY: (f64, f64) = (0.0, 0.95);
const INCLINATION_DEG: (f64, f64) = (0.0, 180.0);
const ANGLE_DEG: (f64, f64) = (-360.0, 360.0);
const POSITION_KM: (f64, f64) = (-500_000.0, 500_000.0);
const VELOCITY_KM_S: (f64, f64) = (-12.0, 12.0);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOrbit {
    a_km: Option<Spanned<f64>>,
    e: Option<Spanned<f64>>,
    i_deg: Option<Spanned<f64>>,
    raan_deg: Option<Spanned<f64>>,
    argp_deg: Option<Spanned<f64>>,
    true_anomaly_deg: Option<Spanned<f64>>,
    position_km: Option<Spanned<[f64; 3]>>,
    velocity_km_s: Option<Spanned<[f64; 3]>>,
}

/// Position (km) and velocity (km/s), ICRS.
pub(super) fn state(text: &Text<'_>, raw: &Spanned<RawOrbit>) -> Result<(Vector, Vector), HostError> {
    let orbit = raw.get_ref();
    let elements = [
        ("orbit.e", &orbit.e, ECCENTRICITY),
        ("orbit.i_deg", &orbit.i_deg, INCLINATION_DEG),
        ("orbit.raan_deg", &orbit.raan_deg, ANGLE_DEG),
        ("orbit.argp_deg", &orbit.argp_deg, ANGLE_DEG),
        ("orbit.true_anomaly_deg", &orbit.true_anomaly_deg, ANGLE_DEG),
    ];
    match (&orbit.a_km, &orbit.position_km, &orbit.velocity_km_s) {
        (Some(a_km), None, None) => {
            let a = text.number("orbit.a_km", Some(a_km), 0.0, SEMI_MAJOR_AXIS_KM)?;
            let mut values = [0.0; 5];
            for (value, (key, raw, range)) in values.iter_mut().zip(elements) {
                *value = text.number(key, raw.as_ref(), 0.0, range)?;
            }
            let [e, i, raan, argp, anomaly] = values;
            // A fault that the ranges let through is one of eccentricity and axis together.
            let (key, at) = match &orbit.e {
                Some(e) => ("orbit.e", e.span().start),
                None => ("orbit.a_km", a_km.span().start),
            };
            refuse_low(text, at, key, a * (1.0 - e))?;
            state_of_elements(a, e, i, raan, argp, anomaly)
                .map_err(|error| text.fault(at, key, &error.to_string(), "give another orbit"))
        }
        (None, Some(position), Some(velocity)) => {
            if let Some((key, value, _)) = elements.iter().find(|(_, value, _)| value.is_some()) {
                let at = value.as_ref().map_or(raw.span().start, |value| value.span().start);
                return Err(text.fault(at, key, "elements and a state exclude each other", "remove one of them"));
            }
            let r = text.triple("orbit.position_km", position, POSITION_KM)?;
            let v = text.triple("orbit.velocity_km_s", velocity, VELOCITY_KM_S)?;
            let at = velocity.span().start;
            let perigee_km = perigee_km(r, v)
                .ok_or_else(|| text.fault(at, "orbit.velocity_km_s", "the orbit is not closed", "use less than escape velocity"))?;
            refuse_low(text, at, "orbit.velocity_km_s", perigee_km)?;
            Ok((r, v))
        }
        _ => Err(text.fault(
            raw.span().start,
            "orbit",
            "neither elements nor a state",
            "give a_km and the other elements, or position_km and velocity_km_s",
        )),
    }
}

/// Perigee distance of a state, km; `None` when its orbit is not closed. From the energy and the eccentricity vector's
/// length, `e² = 1 - h² / (GM a)`.
fn perigee_km(r: Vector, v: Vector) -> Option<f64> {
    let distance = libm::sqrt(dot(r, r));
    let energy = 0.5 * dot(v, v) - EARTH_GM_KM3_S2 / distance;
    // Written so that a position of zero length is refused as well.
    if !(energy < 0.0 && distance > 0.0) || energy == f64::NEG_INFINITY {
        return None;
    }
    let a = -0.5 * EARTH_GM_KM3_S2 / energy;
    let rv = dot(r, v);
    let momentum_square = dot(r, r) * dot(v, v) - rv * rv;
    let e = libm::sqrt((1.0 - momentum_square / (EARTH_GM_KM3_S2 * a)).max(0.0));
    Some(a * (1.0 - e))
}

fn refuse_low(text: &Text<'_>, at: usize, key: &str, perigee_km: f64) -> Result<(), HostError> {
    if perigee_km >= PERIGEE_MIN_KM {
        return Ok(());
    }
    let what = format!("the perigee is {perigee_km:.0} km from the Earth's centre: in the air or the ground");
    Err(text.fault(at, key, &what, &format!("raise it above {PERIGEE_MIN_KM} km")))
}
