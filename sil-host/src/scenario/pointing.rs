//! The `[pointing]` of a scenario: the law, slews, jitter.
//!
//! | key | says | default |
//! |---|---|---|
//! | `law` | `"nadir"`, `"horizon"`, `"inertial"` or `"spin"` ([`crate::world::motion::pointing`]) | `"nadir"` |
//! | `off_nadir_deg` | nadir: line of sight of the Earth path from nadir towards flight | 0 |
//! | `below_deg` | horizon: line of sight of the Earth path from the horizon ahead towards nadir | 0 |
//! | `ra_deg`, `dec_deg` | inertial, spin: ICRS direction of the Earth path's line of sight, at the start | needed |
//! | `roll_deg` | then turned about it | 0 |
//! | `rate_deg_s` | spin: rate about x, y, z of the body (the Earth path's axes) at the start, 15 deg/s at most | needed |
//! | `inertia` | spin: ratios of the moments of inertia about these axes | `[1, 1, 1]`: the rate stays |
//! | `[[pointing.slews]]` | nadir, horizon, inertial: `start_s`, `duration_s`, `axis` (in the body), `angle_deg` | none |
//! | `[pointing.jitter]` | `random_arcsec` about x, y, z (one sigma), `correlation_s` | none, 30 |
//! | `[[pointing.jitter.lines]]` | `frequency_hz`, `amplitude_arcsec` about x, y, z | none |

use super::text::Text;
use super::{ANGLE_DEG, DURATION_S};
use crate::error::HostError;
use crate::world::attitude::{Vector, quaternion};
use crate::world::motion::jitter::{JitterModel, Line};
use crate::world::motion::pointing::{Aim, Law, Pointing};
use crate::world::motion::slew::{PEAK, Slew};
use crate::world::motion::tumble::Tumble;
use crate::world::vector::{length, unit};
use serde::Deserialize;
use toml::Spanned;

/// Fastest turning, deg/s: the thesis's streaks work up to it (§3.1.5).
const RATE_DEG_S: f64 = 15.0;
const DECLINATION_DEG: (f64, f64) = (-90.0, 90.0);
/// Ratios of inertia.
const INERTIA: (f64, f64) = (0.01, 100.0);
/// Least length of an axis as the file has it.
const AXIS_LEAST: f64 = 1e-6;
const SLEW_S: (f64, f64) = (1.0, 86_400.0);
/// A jitter's deviation or amplitude, arcsec: up to a degree.
const JITTER_ARCSEC: (f64, f64) = (0.0, 3600.0);
const CORRELATION_S: (f64, f64) = (0.1, 86_400.0);
const CORRELATION_DEFAULT_S: f64 = 30.0;
const FREQUENCY_HZ: (f64, f64) = (0.0, 200.0);

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPointing {
    law: Option<Spanned<String>>,
    off_nadir_deg: Option<Spanned<f64>>,
    below_deg: Option<Spanned<f64>>,
    roll_deg: Option<Spanned<f64>>,
    ra_deg: Option<Spanned<f64>>,
    dec_deg: Option<Spanned<f64>>,
    rate_deg_s: Option<Spanned<[f64; 3]>>,
    inertia: Option<Spanned<[f64; 3]>>,
    #[serde(default)]
    slews: Vec<Spanned<RawSlew>>,
    jitter: Option<RawJitter>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSlew {
    start_s: Spanned<f64>,
    duration_s: Spanned<f64>,
    axis: Spanned<[f64; 3]>,
    angle_deg: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawJitter {
    random_arcsec: Option<Spanned<[f64; 3]>>,
    correlation_s: Option<Spanned<f64>>,
    #[serde(default)]
    lines: Vec<RawLine>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLine {
    frequency_hz: Spanned<f64>,
    amplitude_arcsec: Spanned<[f64; 3]>,
}

/// The pointing, at rest, of a run of `duration_s`.
pub(super) fn read(text: &Text<'_>, raw: &RawPointing, duration_s: u32) -> Result<Pointing, HostError> {
    let law = raw.law.as_ref().map_or("nadir", |law| law.get_ref());
    let keys = [
        ("off_nadir_deg", raw.off_nadir_deg.as_ref().map(Spanned::span), &["nadir"][..]),
        ("below_deg", raw.below_deg.as_ref().map(Spanned::span), &["horizon"]),
        ("ra_deg", raw.ra_deg.as_ref().map(Spanned::span), &["inertial", "spin"]),
        ("dec_deg", raw.dec_deg.as_ref().map(Spanned::span), &["inertial", "spin"]),
        ("rate_deg_s", raw.rate_deg_s.as_ref().map(Spanned::span), &["spin"]),
        ("inertia", raw.inertia.as_ref().map(Spanned::span), &["spin"]),
        ("slews", raw.slews.first().map(Spanned::span), &["nadir", "horizon", "inertial"]),
    ];
    if !["nadir", "horizon", "inertial", "spin"].contains(&law)
        && let Some(named) = &raw.law
    {
        let what = format!("unknown law \"{law}\"");
        return Err(text.fault(
            named.span().start,
            "pointing.law",
            &what,
            "use nadir, horizon, inertial or spin",
        ));
    }
    for (key, span, laws) in keys {
        if let Some(span) = span.filter(|_| !laws.contains(&law)) {
            let what = format!("means nothing under the law \"{law}\"");
            return Err(text.fault(
                span.start,
                &format!("pointing.{key}"),
                &what,
                "remove it or use another law",
            ));
        }
    }
    let roll_deg = text.number("pointing.roll_deg", raw.roll_deg.as_ref(), 0.0, ANGLE_DEG)?;
    let law = match law {
        "nadir" => {
            let off_nadir_deg =
                text.number("pointing.off_nadir_deg", raw.off_nadir_deg.as_ref(), 0.0, ANGLE_DEG)?;
            Law::Nadir { off_nadir_deg, roll_deg }
        }
        "horizon" => {
            let below_deg = text.number("pointing.below_deg", raw.below_deg.as_ref(), 0.0, ANGLE_DEG)?;
            Law::Horizon { below_deg, roll_deg }
        }
        "inertial" => Law::Inertial(aim(text, raw, roll_deg)?),
        _ => Law::Spin(spin(text, raw, aim(text, raw, roll_deg)?, duration_s)?),
    };
    Ok(Pointing { slews: slews(text, &raw.slews)?, ..law.into() })
}

/// A fault of a key the law cannot do without.
fn missing(text: &Text<'_>, raw: &RawPointing, key: &str) -> HostError {
    let at = raw.law.as_ref().map_or(0, |law| law.span().start);
    text.fault(at, &format!("pointing.{key}"), "is missing", "add it: this law needs it")
}

/// The direction of the line of sight.
fn aim(text: &Text<'_>, raw: &RawPointing, roll_deg: f64) -> Result<Aim, HostError> {
    let number = |key: &str, value: &Option<Spanned<f64>>, range| match value {
        Some(value) => text.number(&format!("pointing.{key}"), Some(value), 0.0, range),
        None => Err(missing(text, raw, key)),
    };
    let ra_deg = number("ra_deg", &raw.ra_deg, ANGLE_DEG)?;
    Ok(Aim { ra_deg, dec_deg: number("dec_deg", &raw.dec_deg, DECLINATION_DEG)?, roll_deg })
}

/// The free body.
fn spin(text: &Text<'_>, raw: &RawPointing, aim: Aim, duration_s: u32) -> Result<Tumble, HostError> {
    let rate = raw.rate_deg_s.as_ref().ok_or_else(|| missing(text, raw, "rate_deg_s"))?;
    let rate_deg_s = text.array("pointing.rate_deg_s", rate, (-RATE_DEG_S, RATE_DEG_S))?;
    let speed = length(rate_deg_s);
    if speed > RATE_DEG_S {
        let what = format!("{speed:.3} deg/s in all is out of range");
        let to_do = format!("turn at {RATE_DEG_S} deg/s at most");
        return Err(text.fault(rate.span().start, "pointing.rate_deg_s", &what, &to_do));
    }
    let inertia = match &raw.inertia {
        None => [1.0; 3],
        Some(inertia) => {
            let [a, b, c] = text.array("pointing.inertia", inertia, INERTIA)?;
            if a + b < c || b + c < a || c + a < b {
                let what = "one moment is more than the sum of the others, which no body has";
                return Err(text.fault(inertia.span().start, "pointing.inertia", what, "give other ratios"));
            }
            [a, b, c]
        }
    };
    Ok(Tumble::new(quaternion(&aim.matrix()), rate_deg_s.map(f64::to_radians), inertia, duration_s))
}

/// The slews, one after the other.
fn slews(text: &Text<'_>, raw: &[Spanned<RawSlew>]) -> Result<Vec<Slew>, HostError> {
    let mut slews: Vec<Slew> = Vec::new();
    for slew in raw {
        let slew = slew.get_ref();
        let latest = DURATION_S.1 as f64;
        let start_s = text.number("pointing.slews.start_s", Some(&slew.start_s), 0.0, (0.0, latest))?;
        let duration_s = text.number("pointing.slews.duration_s", Some(&slew.duration_s), 0.0, SLEW_S)?;
        let angle_deg = text.number("pointing.slews.angle_deg", Some(&slew.angle_deg), 0.0, ANGLE_DEG)?;
        let axis = text.array("pointing.slews.axis", &slew.axis, (-1.0, 1.0))?;
        if length(axis) < AXIS_LEAST {
            let what = "has no length";
            return Err(text.fault(slew.axis.span().start, "pointing.slews.axis", what, "give a direction"));
        }
        if let Some(before) = slews.last().filter(|before| start_s < before.end_s()) {
            let what = format!("begins before the slew ahead of it is over, at {} s", before.end_s());
            let to_do = "give slews in the order of time, none within another";
            return Err(text.fault(slew.start_s.span().start, "pointing.slews.start_s", &what, to_do));
        }
        let slew_of = Slew { start_s, duration_s, axis: unit(axis), angle_rad: angle_deg.to_radians() };
        let peak = slew_of.peak_rad_s().to_degrees();
        if peak > RATE_DEG_S {
            let what = format!("turns at up to {peak:.3} deg/s ({PEAK} times the mean)");
            let to_do = format!("take longer: {RATE_DEG_S} deg/s at most");
            return Err(text.fault(slew.duration_s.span().start, "pointing.slews.duration_s", &what, &to_do));
        }
        slews.push(slew_of);
    }
    Ok(slews)
}

/// What is wrong with the pointing.
pub(super) fn jitter(text: &Text<'_>, raw: &RawPointing) -> Result<Option<JitterModel>, HostError> {
    let Some(raw) = &raw.jitter else { return Ok(None) };
    let key = "pointing.jitter.correlation_s";
    let correlation_s = text.number(key, raw.correlation_s.as_ref(), CORRELATION_DEFAULT_S, CORRELATION_S)?;
    let random_arcsec: Vector = match &raw.random_arcsec {
        Some(random) => text.array("pointing.jitter.random_arcsec", random, JITTER_ARCSEC)?,
        None => [0.0; 3],
    };
    let mut lines = Vec::new();
    for line in &raw.lines {
        let key = "pointing.jitter.lines.frequency_hz";
        let frequency_hz = text.number(key, Some(&line.frequency_hz), 0.0, FREQUENCY_HZ)?;
        let key = "pointing.jitter.lines.amplitude_arcsec";
        let amplitude_arcsec = text.array(key, &line.amplitude_arcsec, JITTER_ARCSEC)?;
        lines.push(Line { frequency_hz, amplitude_arcsec });
    }
    Ok(Some(JitterModel { random_arcsec, correlation_s, lines }))
}
