//! The `[shutters]`, `[gyro]` and `[magnetometer]` of a scenario: shutters of the two paths, sensors beside
//! the camera; without the table there is none.
//!
//! The flight code uses a gyro that loses less in a second than a third of a star window's half side, 0.03
//! deg with the reference camera; that of the defaults is only reported, which `run` and `campaign run` say
//! on stderr.
//!
//! | key | says (standard deviations where nothing else is said) | default |
//! |---|---|---|
//! | `shutters.paths` | the paths that have one: `"neither"`, `"star"`, `"earth"` or `"both"` | - |
//! | `shutters.filter` | the Earth path's filter: `"fixed"`, or `"adaptive"`, which can be put out of the way | fixed |
//! | `shutters.open` | the paths that the first second's command holds open: one, `"both"`, or `"both-clear"` without the filter | none: by the Sun |
//! | `gyro.noise_deg_s` | white noise of a sample | 0.22 |
//! | `gyro.bias_deg_s` | bias at the start | 0.5 |
//! | `gyro.drift_deg_s_h` | walk of the bias, after an hour | 0.15 |
//! | `gyro.scale_error` | scale error of an axis, a share | 0.01 |
//! | `gyro.misalignment_deg` | lean of an axis towards each other one | 0.5 |
//! | `gyro.resolution_deg_s` | step of a reading, 0 for none | 0.07 |
//! | `gyro.range_deg_s` | greatest rate of an axis | 100 |
//! | `magnetometer.noise_ut` | white noise of a sample | 0.2 |
//! | `magnetometer.drift_ut_h` | walk of the zero, after an hour | 0.15 |
//! | `magnetometer.hard_iron_ut` | the spacecraft's own field along x, y, z of the body | `[0, 0, 0]` |
//! | `magnetometer.zero_sigma_ut` | how well that is known, an axis: what the flight code is told | 5 |
//! | `magnetometer.resolution_ut` | step of a reading, 0 for none | 0.043 |
//! | `magnetometer.range_ut` | greatest field along an axis | 80 |
//! | `magnetometer.ring_current_ut` | by how much the ring current weakens the field at the equator | 0.02 |

use super::text::Text;
use crate::error::HostError;
use crate::world::instruments::gyro::GyroModel;
use crate::world::instruments::magnetometer::MagnetometerModel;
use fsw_core::shutting::{EarthFilter, ShutterParameters, Shutters};
use fsw_hal::OpenPaths;
use serde::Deserialize;
use toml::Spanned;

/// Paths with a shutter.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawShuttered {
    Neither,
    Star,
    Earth,
    Both,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawFilter {
    #[default]
    Fixed,
    Adaptive,
}

/// Open paths.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RawOpen {
    Star,
    Earth,
    Both,
    BothClear,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawShutters {
    paths: RawShuttered,
    #[serde(default)]
    filter: RawFilter,
    open: Option<RawOpen>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawGyro {
    noise_deg_s: Option<Spanned<f64>>,
    bias_deg_s: Option<Spanned<f64>>,
    drift_deg_s_h: Option<Spanned<f64>>,
    scale_error: Option<Spanned<f64>>,
    misalignment_deg: Option<Spanned<f64>>,
    resolution_deg_s: Option<Spanned<f64>>,
    range_deg_s: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMagnetometer {
    noise_ut: Option<Spanned<f64>>,
    drift_ut_h: Option<Spanned<f64>>,
    hard_iron_ut: Option<Spanned<[f64; 3]>>,
    zero_sigma_ut: Option<Spanned<f64>>,
    resolution_ut: Option<Spanned<f64>>,
    range_ut: Option<Spanned<f64>>,
    ring_current_ut: Option<Spanned<f64>>,
}

/// The flight code's parameters of shutters and filter.
pub(super) fn shutters(raw: &RawShutters) -> ShutterParameters {
    let paths = match raw.paths {
        RawShuttered::Neither => Shutters::Neither,
        RawShuttered::Star => Shutters::Star,
        RawShuttered::Earth => Shutters::Earth,
        RawShuttered::Both => Shutters::Both,
    };
    let filter = match raw.filter {
        RawFilter::Fixed => EarthFilter::Fixed,
        RawFilter::Adaptive => EarthFilter::Adaptive,
    };
    ShutterParameters { paths, filter, ..ShutterParameters::default() }
}

/// The paths that a command holds open.
pub(super) fn held_open(raw: &RawShutters) -> Option<OpenPaths> {
    raw.open.map(|paths| match paths {
        RawOpen::Star => OpenPaths::Star,
        RawOpen::Earth => OpenPaths::Earth,
        RawOpen::Both => OpenPaths::Both,
        RawOpen::BothClear => OpenPaths::BothClear,
    })
}

/// The gyro's errors.
pub(super) fn gyro(text: &Text<'_>, raw: &Option<RawGyro>) -> Result<Option<GyroModel>, HostError> {
    let Some(raw) = raw else { return Ok(None) };
    let number = |key: &str, value: &Option<Spanned<f64>>, default, range| {
        text.number(&format!("gyro.{key}"), value.as_ref(), default, range)
    };
    let default = GyroModel::default();
    Ok(Some(GyroModel {
        noise_deg_s: number("noise_deg_s", &raw.noise_deg_s, default.noise_deg_s, (0.0, 10.0))?,
        bias_deg_s: number("bias_deg_s", &raw.bias_deg_s, default.bias_deg_s, (0.0, 10.0))?,
        drift_deg_s_h: number("drift_deg_s_h", &raw.drift_deg_s_h, default.drift_deg_s_h, (0.0, 10.0))?,
        scale_error: number("scale_error", &raw.scale_error, default.scale_error, (0.0, 0.2))?,
        misalignment_deg: number(
            "misalignment_deg",
            &raw.misalignment_deg,
            default.misalignment_deg,
            (0.0, 10.0),
        )?,
        resolution_deg_s: number(
            "resolution_deg_s",
            &raw.resolution_deg_s,
            default.resolution_deg_s,
            (0.0, 10.0),
        )?,
        range_deg_s: number("range_deg_s", &raw.range_deg_s, default.range_deg_s, (0.1, 2000.0))?,
    }))
}

/// The magnetometer's errors.
pub(super) fn magnetometer(
    text: &Text<'_>,
    raw: Option<&RawMagnetometer>,
) -> Result<Option<MagnetometerModel>, HostError> {
    let Some(raw) = raw else { return Ok(None) };
    let number = |key: &str, value: &Option<Spanned<f64>>, default, range| {
        text.number(&format!("magnetometer.{key}"), value.as_ref(), default, range)
    };
    let default = MagnetometerModel::default();
    Ok(Some(MagnetometerModel {
        noise_ut: number("noise_ut", &raw.noise_ut, default.noise_ut, (0.0, 100.0))?,
        drift_ut_h: number("drift_ut_h", &raw.drift_ut_h, default.drift_ut_h, (0.0, 100.0))?,
        hard_iron_ut: match &raw.hard_iron_ut {
            Some(field) => text.array("magnetometer.hard_iron_ut", field, (-1000.0, 1000.0))?,
            None => default.hard_iron_ut,
        },
        zero_sigma_ut: number("zero_sigma_ut", &raw.zero_sigma_ut, default.zero_sigma_ut, (1e-3, 1000.0))?,
        resolution_ut: number("resolution_ut", &raw.resolution_ut, default.resolution_ut, (0.0, 100.0))?,
        range_ut: number("range_ut", &raw.range_ut, default.range_ut, (1.0, 10_000.0))?,
        ring_current_ut: number(
            "ring_current_ut",
            &raw.ring_current_ut,
            default.ring_current_ut,
            (0.0, 1.0),
        )?,
    }))
}
