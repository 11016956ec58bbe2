//! The `[[faults]]` of a scenario: what is broken, from when to when.
//!
//! Every entry has `kind`, `from_s` and `until_s` (the second after the last). `time-out`, `dropped-window`,
//! `late-frame`, `doubled-image`, `wrong-geometry`, `bit-flips` and `restart` take `share`, a probability
//! (default 1; bit flips have none); `stuck-row` takes `row`; `noise-burst` takes `sigma_dn`; `late-image` takes
//! `late_s`, `clock-step` `step_s`, `proton-storm` `hits`, `gyro-offset` `rate_deg_s` and `magnetometer-offset`
//! `field_ut`; `clock-invalid`, `blinded`, `gyro-silent`, `magnetometer-silent` and `shutter-stuck` take nothing. See [`crate::harness::faults`] for what each does.

use super::text::Text;
use crate::error::HostError;
use crate::harness::faults::{Fault, FaultKind};
use serde::Deserialize;
use toml::Spanned;

/// Most faults in a scenario.
const FAULTS_MAX: usize = 100;
const SHARE: (f64, f64) = (0.0, 1.0);
const SIGMA_DN: (f64, f64) = (0.0, 65_535.0);
const LATE_S: (f64, f64) = (0.0, 60.0);
const STEP_S: (f64, f64) = (-86_400.0, 86_400.0);
const RATE_DEG_S: (f64, f64) = (-100.0, 100.0);
const FIELD_UT: (f64, f64) = (-1000.0, 1000.0);
const ROW: (i64, i64) = (0, u16::MAX as i64);
const HITS: (i64, i64) = (0, 100_000);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFault {
    kind: Spanned<String>,
    from_s: Spanned<i64>,
    until_s: Spanned<i64>,
    share: Option<Spanned<f64>>,
    row: Option<Spanned<i64>>,
    sigma_dn: Option<Spanned<f64>>,
    late_s: Option<Spanned<f64>>,
    step_s: Option<Spanned<f64>>,
    hits: Option<Spanned<i64>>,
    rate_deg_s: Option<Spanned<f64>>,
    field_ut: Option<Spanned<f64>>,
}

/// Reads the `[[faults]]` of a run of `duration_s`.
pub(super) fn read(text: &Text<'_>, raw: &[RawFault], duration_s: u32) -> Result<Vec<Fault>, HostError> {
    if let Some(beyond) = raw.get(FAULTS_MAX) {
        let what = format!("more than {FAULTS_MAX} of them");
        return Err(text.fault(beyond.kind.span().start, "faults", &what, "remove some"));
    }
    raw.iter().map(|raw| fault(text, raw, duration_s)).collect()
}

fn fault(text: &Text<'_>, raw: &RawFault, duration_s: u32) -> Result<Fault, HostError> {
    let seconds = |key, value: &Spanned<i64>, least: u32| {
        text.whole(key, Some(value), 0, (least.into(), duration_s.into())).map(|second| second as u32)
    };
    let from_s = seconds("faults.from_s", &raw.from_s, 0)?;
    let until_s = seconds("faults.until_s", &raw.until_s, from_s + 1)?;
    Ok(Fault { kind: kind(text, raw)?, from_s, until_s })
}

/// The kind, with its own key; those of other kinds are refused.
fn kind(text: &Text<'_>, raw: &RawFault) -> Result<FaultKind, HostError> {
    let word = raw.kind.get_ref().as_str();
    let own = match word {
        "time-out" | "dropped-window" | "late-frame" | "doubled-image" | "wrong-geometry" | "bit-flips"
        | "restart" => "share",
        "late-image" => "late_s",
        "clock-step" => "step_s",
        "clock-invalid" | "blinded" | "gyro-silent" | "magnetometer-silent" | "shutter-stuck" => "",
        "proton-storm" => "hits",
        "gyro-offset" => "rate_deg_s",
        "magnetometer-offset" => "field_ut",
        "stuck-row" => "row",
        "noise-burst" => "sigma_dn",
        _ => {
            let to_do = "use time-out, dropped-window, late-frame, doubled-image, late-image, clock-step, clock-invalid, \
                         wrong-geometry, stuck-row, bit-flips, noise-burst, blinded, proton-storm, gyro-offset, gyro-silent, \
                         magnetometer-offset, magnetometer-silent, shutter-stuck or restart";
            let what = format!("`{word}` is no fault");
            return Err(text.fault(raw.kind.span().start, "faults.kind", &what, to_do));
        }
    };
    let given = [
        ("share", raw.share.as_ref().map(Spanned::span)),
        ("row", raw.row.as_ref().map(Spanned::span)),
        ("sigma_dn", raw.sigma_dn.as_ref().map(Spanned::span)),
        ("late_s", raw.late_s.as_ref().map(Spanned::span)),
        ("step_s", raw.step_s.as_ref().map(Spanned::span)),
        ("hits", raw.hits.as_ref().map(Spanned::span)),
        ("rate_deg_s", raw.rate_deg_s.as_ref().map(Spanned::span)),
        ("field_ut", raw.field_ut.as_ref().map(Spanned::span)),
    ];
    for (key, span) in given {
        match span {
            Some(span) if key != own => {
                let what = format!("a {word} has none");
                return Err(text.fault(span.start, &format!("faults.{key}"), &what, "remove it"));
            }
            None if key == own && (own != "share" || word == "bit-flips") => {
                let what = format!("a {word} needs one");
                return Err(text.fault(raw.kind.span().start, &format!("faults.{key}"), &what, "add it"));
            }
            _ => {}
        }
    }
    let share = text.number("faults.share", raw.share.as_ref(), 1.0, SHARE)?;
    Ok(match word {
        "time-out" => FaultKind::TimeOut(share),
        "dropped-window" => FaultKind::DroppedWindow(share),
        "late-frame" => FaultKind::LateFrame(share),
        "doubled-image" => FaultKind::DoubledImage(share),
        "late-image" => {
            FaultKind::LateImage(text.number("faults.late_s", raw.late_s.as_ref(), 0.0, LATE_S)?)
        }
        "clock-step" => {
            FaultKind::ClockStep(text.number("faults.step_s", raw.step_s.as_ref(), 0.0, STEP_S)?)
        }
        "clock-invalid" => FaultKind::ClockInvalid,
        "blinded" => FaultKind::Blinded,
        "gyro-silent" => FaultKind::GyroSilent,
        "magnetometer-silent" => FaultKind::MagnetometerSilent,
        "shutter-stuck" => FaultKind::ShutterStuck,
        "proton-storm" => {
            FaultKind::ProtonStorm(text.whole("faults.hits", raw.hits.as_ref(), 0, HITS)? as u32)
        }
        "gyro-offset" => FaultKind::GyroOffset(text.number(
            "faults.rate_deg_s",
            raw.rate_deg_s.as_ref(),
            0.0,
            RATE_DEG_S,
        )?),
        "magnetometer-offset" => FaultKind::MagnetometerOffset(text.number(
            "faults.field_ut",
            raw.field_ut.as_ref(),
            0.0,
            FIELD_UT,
        )?),
        "wrong-geometry" => FaultKind::WrongGeometry(share),
        "bit-flips" => FaultKind::BitFlips(share),
        "restart" => FaultKind::Restart(share),
        "stuck-row" => FaultKind::StuckRow(text.whole("faults.row", raw.row.as_ref(), 0, ROW)? as u16),
        _ => FaultKind::NoiseBurst(text.number("faults.sigma_dn", raw.sigma_dn.as_ref(), 0.0, SIGMA_DN)?),
    })
}
