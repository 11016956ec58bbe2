//! The `[orbit_filter]` of a scenario: what the flight code's orbit filter is told to do, and what it is told
//! of the orbit at the start.
//!
//! | key | says | default |
//! |---|---|---|
//! | `observation` | what it takes of an image, in the words of `fsw-core/PARAMETERS.md` | the flight code's |
//! | `misalignment_sigma_deg` | the star path's mounting to the Earth path is known so well about every axis, and learned | it is not learned |
//! | `start.position_sigma_km`, `start.velocity_sigma_m_s` | a state from the ground, known so well along every axis | none: the filter begins with the images |
//! | `start.position_error_km`, `start.velocity_error_m_s` | by so much that state is wrong: radial, along, cross | `[0, 0, 0]` |
//! | `start.drawn` | these errors are drawn instead, by the sigmas, from the flight's seed | false |

use super::text::Text;
use crate::error::HostError;
use crate::world::attitude::Vector;
use crate::world::noise::{Noise, Stream};
use fsw_core::orbit::parameters::Observation;
use serde::Deserialize;
use toml::Spanned;

const SIGMA_KM: (f64, f64) = (1e-3, 1e5);
const MISALIGNMENT_DEG: (f64, f64) = (1e-4, 1.0);
const SIGMA_M_S: (f64, f64) = (1e-3, 1e4);
const ERROR_KM: (f64, f64) = (-1e5, 1e5);
const ERROR_M_S: (f64, f64) = (-1e4, 1e4);

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOrbitFilter {
    observation: Option<Observation>,
    misalignment_sigma_deg: Option<Spanned<f64>>,
    start: Option<RawStart>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStart {
    position_sigma_km: Spanned<f64>,
    velocity_sigma_m_s: Spanned<f64>,
    position_error_km: Option<Spanned<Vector>>,
    velocity_error_m_s: Option<Spanned<Vector>>,
    drawn: Option<Spanned<bool>>,
}

/// A state from the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundStart {
    /// Sigma along every axis, km.
    pub position_sigma_km: f64,
    /// Sigma along every axis, m/s.
    pub velocity_sigma_m_s: f64,
    /// Told less true: radial, along, cross, km.
    pub position_error_km: Vector,
    /// The same of the velocity, m/s.
    pub velocity_error_m_s: Vector,
    /// Whether the flight's seed draws these errors instead.
    pub drawn: bool,
}

impl GroundStart {
    /// Errors of position, km, and velocity, m/s, in the flight of a seed.
    pub fn errors(&self, seed: u64) -> [Vector; 2] {
        if !self.drawn {
            return [self.position_error_km, self.velocity_error_m_s];
        }
        let noise = Noise::new(seed, 0, Stream::GroundStart);
        let sigmas = [self.position_sigma_km, self.velocity_sigma_m_s];
        [0, 1].map(|of| [0, 1, 2].map(|axis| sigmas[of as usize] * noise.gaussian(axis, of)))
    }
}

/// What the orbit filter is told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OrbitFilterModel {
    /// What it takes of an image; none: what the flight code's parameters say.
    pub observation: Option<Observation>,
    /// Sigma of the misalignment of the paths that it learns, deg; none: it is not learned.
    pub misalignment_sigma_deg: Option<f64>,
    /// The state it begins with.
    pub start: Option<GroundStart>,
}

/// Reads the `[orbit_filter]`.
pub(super) fn read(text: &Text<'_>, raw: &RawOrbitFilter) -> Result<OrbitFilterModel, HostError> {
    let number = |key: &str, value: &Spanned<f64>, range| {
        text.number(&format!("orbit_filter.start.{key}"), Some(value), 0.0, range)
    };
    let triple = |key: &str, value: &Option<Spanned<Vector>>, range| match value {
        Some(value) => text.array(&format!("orbit_filter.start.{key}"), value, range),
        None => Ok([0.0; 3]),
    };
    let start = |raw: &RawStart| -> Result<GroundStart, HostError> {
        let drawn = raw.drawn.as_ref().filter(|drawn| *drawn.get_ref());
        if let Some(drawn) =
            drawn.filter(|_| raw.position_error_km.is_some() || raw.velocity_error_m_s.is_some())
        {
            let to_do = "leave out drawn, or position_error_km and velocity_error_m_s";
            let at = drawn.span().start;
            return Err(text.fault(at, "orbit_filter.start.drawn", "the errors are given as well", to_do));
        }
        Ok(GroundStart {
            position_sigma_km: number("position_sigma_km", &raw.position_sigma_km, SIGMA_KM)?,
            velocity_sigma_m_s: number("velocity_sigma_m_s", &raw.velocity_sigma_m_s, SIGMA_M_S)?,
            position_error_km: triple("position_error_km", &raw.position_error_km, ERROR_KM)?,
            velocity_error_m_s: triple("velocity_error_m_s", &raw.velocity_error_m_s, ERROR_M_S)?,
            drawn: drawn.is_some(),
        })
    };
    let misalignment = |value: &Spanned<f64>| {
        text.number("orbit_filter.misalignment_sigma_deg", Some(value), 0.0, MISALIGNMENT_DEG)
    };
    Ok(OrbitFilterModel {
        observation: raw.observation,
        misalignment_sigma_deg: raw.misalignment_sigma_deg.as_ref().map(misalignment).transpose()?,
        start: raw.start.as_ref().map(start).transpose()?,
    })
}

#[cfg(test)]
mod tests;
