//! A state of an orbit as a file gives it: `{"t_s":..,"r_km":[x,y,z],"v_km_s":[x,y,z]}`.
//!
//! `t_s` is TT, seconds since J2000.0; position and velocity are along the ICRS axes, about the centre of the
//! Earth or of the `"body"`, `"moon"` or `"mars"`. Other keys are left alone.

use fsw_core::orbit::OrbitState;
use fsw_core::orbit::body::CentralBody;
use fsw_core::orbit::constants::MICROSECONDS;
use fsw_core::orbit::dynamics::plausible;
use serde::{Deserialize, Deserializer, de::Error};

/// A century: for longer the positions of Sun and Moon are not made.
const LATEST_S: f64 = 3.2e9;

/// The state as given.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct StateInput {
    /// TT, seconds since J2000.0.
    pub t_s: f64,
    /// Position, km.
    pub r_km: [f64; 3],
    /// Velocity, km/s.
    pub v_km_s: [f64; 3],
    /// What the satellite flies about.
    #[serde(default, deserialize_with = "named")]
    pub body: CentralBody,
}

fn named<'de, D: Deserializer<'de>>(deserializer: D) -> Result<CentralBody, D::Error> {
    body(&String::deserialize(deserializer)?).map_err(D::Error::custom)
}

/// The body of a name.
///
/// # Errors
/// In words, where there is none.
pub fn body(name: &str) -> Result<CentralBody, String> {
    let known = CentralBody::ALL.map(CentralBody::name).join(", ");
    CentralBody::of_name(name).ok_or_else(|| format!("no body is called {name}; known are {known}"))
}

/// The time in microseconds.
///
/// # Errors
/// Where it is no time within a century of J2000.0.
pub fn time_us(t_s: f64) -> Result<i64, String> {
    if t_s.abs() < LATEST_S {
        Ok((t_s * MICROSECONDS).round() as i64)
    } else {
        Err(format!("t_s is {t_s}: not within a century of J2000.0"))
    }
}

impl StateInput {
    /// The state.
    ///
    /// # Errors
    /// In words, where it is none of a satellite.
    pub fn state(&self) -> Result<OrbitState, String> {
        let Self { t_s, r_km, v_km_s, body } = *self;
        let (position_km, velocity_km_s) = (r_km.into(), v_km_s.into());
        if !plausible(body, &position_km, &velocity_km_s) {
            let [lowest_km, highest_km] = body.facts().bounds_km;
            return Err(format!(
                "no state of a satellite: r_km must be {lowest_km} to {highest_km} km long, v_km_s below 30 km/s"
            ));
        }
        Ok(OrbitState { time_us: time_us(t_s)?, position_km, velocity_km_s })
    }
}
