//! The `[orbit]` of a scenario: Keplerian elements, or a state.

use super::text::Text;
use crate::error::HostError;
use crate::world::attitude::Vector;
use crate::world::orbit::{TruthOrbit, state_of_elements};
use serde::Deserialize;
use toml::Spanned;

/// Semi-major axis, km: from just above the air to beyond the Moon.
const SEMI_MAJOR_AXIS_KM: (f64, f64) = (6_478.0, 500_000.0);
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
            // What the ranges let through is a fault of eccentricity and axis together.
            let (key, at) = match &orbit.e {
                Some(e) => ("orbit.e", e.span().start),
                None => ("orbit.a_km", a_km.span().start),
            };
            state_of_elements(a, e, i, raan, argp, anomaly)
                .map_err(|error| text.fault(at, key, &error.to_string(), "give another orbit"))
        }
        (None, Some(position), Some(velocity)) => {
            if let Some((key, Some(value), _)) = elements.iter().find(|(_, value, _)| value.is_some()) {
                let what = "elements and a state exclude each other";
                return Err(text.fault(value.span().start, key, what, "remove one of them"));
            }
            let r = text.triple("orbit.position_km", position, POSITION_KM)?;
            let v = text.triple("orbit.velocity_km_s", velocity, VELOCITY_KM_S)?;
            TruthOrbit::new(0, r, v, 0).map(|_| (r, v)).map_err(|error| {
                let key = "orbit.velocity_km_s";
                text.fault(velocity.span().start, key, &error.to_string(), "give another orbit")
            })
        }
        _ => Err(text.fault(
            raw.span().start,
            "orbit",
            "neither elements nor a state",
            "give a_km and the other elements, or position_km and velocity_km_s",
        )),
    }
}
