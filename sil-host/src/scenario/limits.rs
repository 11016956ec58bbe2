//! What a scenario demands of a run: the `[limits]` of its file.
//!
//! Every limit is a figure of the judge's summary ([`crate::judge::Figures`]), a direction and a value. All
//! are optional; a run without limits is flown and shown but cannot fail.

use super::text::Text;
use crate::error::HostError;
use serde::Serialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// On which side of its value a limit is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The figure must not be less.
    AtLeast,
    /// The figure must not be more.
    AtMost,
}

/// A figure on which a limit can be set.
#[derive(Debug, PartialEq)]
pub struct Limitable {
    /// Key in the file and in `summary.json`.
    pub key: &'static str,
    /// What it is, for people.
    pub words: &'static str,
    /// Its unit; empty for shares, which are shown in percent.
    pub unit: &'static str,
    /// The side on which it is kept.
    pub side: Side,
    /// Values a limit may take.
    pub range: (f64, f64),
}

const fn share(key: &'static str, words: &'static str) -> Limitable {
    Limitable { key, words, unit: "", side: Side::AtLeast, range: (0.0, 1.0) }
}

const fn at_most(key: &'static str, words: &'static str, unit: &'static str, most: f64) -> Limitable {
    Limitable { key, words, unit, side: Side::AtMost, range: (0.0, most) }
}

/// Every figure that can be limited.
pub const LIMITABLE: [Limitable; 17] = [
    share("attitude_valid_share", "attitude valid outside Sun states"),
    share("within_3_sigma_share", "attitude error within 3 reported sigma"),
    share("position_within_3_sigma_share", "position error within 3 reported sigma"),
    share("mode_share", "mode as the geometry says"),
    share("rate_share", "rate known while no attitude is, outside Sun states"),
    share("rate_within_3_sigma_share", "rate without an attitude within 3 reported sigma"),
    at_most("rate_error_percent", "size of a rate without an attitude, median error", "%", 100.0),
    at_most("rate_axis_deg", "axis of a rate without an attitude, median error", "deg", 180.0),
    at_most("first_attitude_s", "first attitude", "s", 1e6),
    at_most("filtered_rms_arcsec", "filtered attitude error, worst axis across, rms", "arcsec", 1e6),
    at_most("attitude_rms_arcsec", "attitude error, worst axis across, rms", "arcsec", 1e6),
    at_most("earth_direction_rms_deg", "Earth's direction, rms per axis", "deg", 180.0),
    at_most("earth_distance_rms_km", "Earth's distance, rms", "km", 1e6),
    at_most("final_position_km", "3-D position error at the end", "km", 1e6),
    at_most("last_orbit_position_km", "3-D position error of the last orbit, rms", "km", 1e6),
    at_most("last_orbit_velocity_m_s", "3-D velocity error of the last orbit, rms", "m/s", 1e6),
    at_most("position_jump_sigma", "largest position jump in a second", "sigma", 1e3),
];

/// A limit of a scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The figure.
    pub of: &'static Limitable,
    /// Its value, in the figure's unit.
    pub value: f64,
}

/// Reads the `[limits]`.
pub(super) fn read(
    text: &Text<'_>,
    raw: &BTreeMap<Spanned<String>, Spanned<f64>>,
) -> Result<Vec<Limit>, HostError> {
    let known = |key: &str| LIMITABLE.iter().find(|limitable| limitable.key == key);
    for key in raw.keys() {
        if known(key.get_ref()).is_none() {
            let names = LIMITABLE.map(|limitable| limitable.key).join(", ");
            let (at, key) = (key.span().start, format!("limits.{}", key.get_ref()));
            return Err(text.fault(at, &key, "unknown limit", &format!("use one of {names}")));
        }
    }
    // In the order of the table, whatever that of the file.
    let mut limits = Vec::new();
    for of in &LIMITABLE {
        if let Some((key, value)) = raw.iter().find(|(key, _)| key.get_ref() == of.key) {
            let key = format!("limits.{}", key.get_ref());
            limits.push(Limit { of, value: text.number(&key, Some(value), 0.0, of.range)? });
        }
    }
    Ok(limits)
}
