//! The `[parameters]` of a scenario: values of the flight code's parameter table that are not its defaults, by
//! the names of `fsw-core/PARAMETERS.md`.
//!
//! ```toml
//! [parameters]
//! tracking.gate_px = 8
//! earth.fit.least_arc_deg = 5.0
//! orbit.dynamics = "J2"
//! ```
//!
//! What another table of the scenario says is refused here, and so is all that the flight code would refuse.

use super::Scenario;
use super::text::Text;
use crate::error::HostError;
use crate::formats::toml_keys;
use crate::words::nearest_first;
use fsw_core::parameters::table::Row;
use fsw_core::parameters::{GROUPS, ParameterError, Parameters};
use toml::Value;

/// What other tables say: the begin of the parameter's name, and the key.
const ELSEWHERE: [(&str, &str); 13] = [
    ("imaging.exposure_us", "scenario.exposure_ms"),
    ("imaging.row_time_ns", "optics.row_time_us"),
    ("imaging.calibration_crc", "camera.file"),
    ("mount.star_to_earth", "[mount]"),
    ("rate_sensor.", "[gyro]"),
    ("magnetometer.noise_ut", "magnetometer.noise_ut"),
    ("magnetometer.zero_ut", "magnetometer.zero_sigma_ut"),
    ("magnetometer.walk_ut", "magnetometer.drift_ut_h"),
    ("shutter.paths", "shutters.paths"),
    ("shutter.filter", "shutters.filter"),
    ("orbit.body", "body.name"),
    ("orbit.observation", "orbit_filter.observation"),
    ("orbit.misalignment", "orbit_filter.misalignment_sigma_deg"),
];

/// A parameter and its value: a number, several, or the number of a choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    row: &'static Row,
    values: Vec<f32>,
    /// Line of the file, from 1.
    line: usize,
}

impl Told {
    /// Group and name.
    fn name(&self) -> String {
        name(self.row)
    }

    /// Puts it into a table; `false` where the table has none of it.
    pub fn put_into(&self, parameters: &mut Parameters) -> bool {
        parameters.set(self.row.group, self.row.name, &self.values)
    }
}

fn name(row: &Row) -> String {
    format!("{}.{}", row.group, row.name)
}

/// Reads the `[parameters]`.
pub(super) fn read(text: &Text<'_>, raw: &toml::Table) -> Result<Vec<Told>, HostError> {
    let mut named = Vec::new();
    gather("", raw, &mut named);
    let lines = if named.is_empty() { Vec::new() } else { toml_keys::keys(text.text) };
    let line = |key: &str| lines.iter().find(|(of, _)| of == key).map_or(1, |(_, line)| *line);
    let told = named.into_iter().map(|(key, value)| {
        let full = format!("parameters.{key}");
        let line = line(&full);
        let fault = |what: &str, to_do: &str| {
            HostError::input(text.path, Some(line), format!("{full}: {what}"), to_do)
        };
        if let Some((_, other)) = ELSEWHERE.iter().find(|(begin, _)| key.starts_with(begin)) {
            return Err(fault("another table of the scenario says this", &format!("use {other}")));
        }
        let Some(row) = GROUPS.into_iter().flatten().find(|row| name(row) == key) else {
            let names: Vec<_> = GROUPS.into_iter().flatten().map(name).collect();
            let near = nearest_first(&key, names.iter().map(String::as_str));
            return Err(fault("unknown parameter", &format!("{near}see `sil-host parameters`")));
        };
        let values = numbers(row, value).ok_or_else(|| fault("a value of another kind", &wanted(row)))?;
        Ok(Told { row, values, line })
    });
    told.collect()
}

/// All values below a table with their names.
fn gather<'v>(path: &str, table: &'v toml::Table, into: &mut Vec<(String, &'v Value)>) {
    for (key, value) in table {
        let name = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        match value {
            Value::Table(below) => gather(&name, below, into),
            value => into.push((name, value)),
        }
    }
}

/// A number, all numbers of an array, or the number of a choice.
fn numbers(row: &Row, value: &Value) -> Option<Vec<f32>> {
    match value {
        Value::Array(values) => values.iter().map(number).collect(),
        Value::String(word) => {
            let place = row.choices()?.position(|choice| choice == word)?;
            Some(vec![place as f32])
        }
        value if row.choices().is_none() => Some(vec![number(value)?]),
        _ => None,
    }
}

fn number(value: &Value) -> Option<f32> {
    match value {
        Value::Float(number) => Some(*number as f32),
        Value::Integer(number) => Some(*number as f32),
        _ => None,
    }
}

/// What a parameter may be.
fn wanted(row: &Row) -> String {
    let kind = match row.kind {
        "u16" | "u32" => "a whole number, ",
        "f32" => "a number, ",
        kind if kind.starts_with('[') => "all its numbers, ",
        _ => "",
    };
    format!("use {kind}{}", row.range)
}

/// Whether the flight code takes what a scenario tells it here.
pub(super) fn check(scenario: &Scenario) -> Result<(), HostError> {
    let fault = |told: &Told, what: &str, to_do: &str| {
        let what = format!("parameters.{}: {what}", told.name());
        Err(HostError::input(&scenario.file, Some(told.line), what, to_do))
    };
    // Without any the flight code itself says at the start what it refuses.
    let Some(first) = scenario.parameters.first() else { return Ok(()) };
    let mut parameters = scenario.flight_parameters(None);
    if let Some(told) = scenario.parameters.iter().find(|told| !told.put_into(&mut parameters)) {
        return match told.row.group {
            "magnetometer" => fault(told, "there is none on board", "add [magnetometer]"),
            "shutter" => fault(told, "there is none on board", "add [shutters]"),
            _ => fault(told, "a value of another kind", &wanted(told.row)),
        };
    }
    let Err(error) = parameters.check() else { return Ok(()) };
    let (ParameterError::Range(refused) | ParameterError::NotOfBody(refused)) = error else {
        return fault(first, &error.to_string(), "remove it");
    };
    match scenario.parameters.iter().find(|told| told.name() == refused) {
        Some(told) => fault(told, &error.to_string(), &wanted(told.row)),
        None => {
            let of_group = |told: &&Told| refused.starts_with(told.row.group);
            let told = scenario.parameters.iter().find(of_group).unwrap_or(first);
            fault(told, &format!("with it {error}"), &format!("set {refused} too"))
        }
    }
}

#[cfg(test)]
mod tests;
