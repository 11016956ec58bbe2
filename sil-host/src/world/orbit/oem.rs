//! Orbit Ephemeris Messages of the CCSDS as key-value text.
//!
//! In: text (CCSDS 502.0-B-2 and -3, sec. 5). Out: a list of segments, each with its samples. Read are
//! `REF_FRAME` (GCRF, ICRF, EME2000, ITRF, TEME), `CENTER_NAME` (EARTH), `TIME_SYSTEM` (UTC, TAI, TT, TDB,
//! GPS), `USEABLE_START_TIME` and `USEABLE_STOP_TIME` and the lines of time and position; velocities,
//! accelerations and covariances are not used.

use super::track::{Frame, Samples};
use crate::world::time::civil_time::{self, Clock};
use crate::world::time::earth_orientation::LineFault;

/// What the metadata of a segment say.
#[derive(Default)]
struct Meta {
    frame: Option<Frame>,
    clock: Option<Clock>,
    /// As shown by the clock, µs.
    usable: [Option<i64>; 2],
}

/// The segments of a message, in its order.
///
/// # Errors
/// The first line that cannot be read or is not supported.
pub fn read(text: &str) -> Result<Vec<Samples>, LineFault> {
    let mut segments: Vec<Samples> = Vec::new();
    let mut meta: Option<Meta> = None;
    let (mut in_meta, mut in_covariance) = (false, false);
    let mut clock = Clock::Utc;
    let mut usable = [None; 2];
    for (index, line) in text.lines().enumerate() {
        let fault = |what: &str| (index + 1, what.to_owned());
        let line = line.trim();
        if index == 0 && !line.starts_with("CCSDS_OEM_VERS") {
            return Err(fault("is no first line of an OEM (CCSDS_OEM_VERS = ...)"));
        }
        match line {
            "" => {}
            "META_START" => (in_meta, meta) = (true, Some(Meta::default())),
            "META_STOP" => {
                let Meta { frame, clock: named, usable: limits } =
                    meta.take().ok_or_else(|| fault("stands without META_START"))?;
                let frame = frame.ok_or_else(|| fault("ends metadata without REF_FRAME"))?;
                clock = named.ok_or_else(|| fault("ends metadata without TIME_SYSTEM"))?;
                (in_meta, usable) = (false, limits);
                segments.push(Samples { frame, places: Vec::new() });
            }
            "COVARIANCE_START" => in_covariance = true,
            "COVARIANCE_STOP" => in_covariance = false,
            _ if in_covariance || line.starts_with("COMMENT") => {}
            _ if in_meta => {
                let (key, value) = line.split_once('=').ok_or_else(|| fault("is no KEY = value"))?;
                if let Some(meta) = &mut meta {
                    note(meta, key.trim(), value.trim()).map_err(|what| fault(&what))?;
                }
            }
            _ if segments.is_empty() => {
                // The header: version, originator, date.
                if !line.contains('=') {
                    return Err(fault("stands before the metadata"));
                }
            }
            _ => {
                let (shown_us, place) = sample(line).ok_or_else(|| fault("is no time with a position"))?;
                let within = usable[0].is_none_or(|first| shown_us >= first)
                    && usable[1].is_none_or(|last| shown_us <= last);
                let places = segments.last_mut().map(|segment| &mut segment.places);
                if let Some(places) = places.filter(|_| within) {
                    let time_us = clock.tt_us(shown_us);
                    if places.last().is_some_and(|(last, _)| *last >= time_us) {
                        return Err(fault("is not later than the sample before it"));
                    }
                    places.push((time_us, place));
                }
            }
        }
    }
    segments.retain(|segment| !segment.places.is_empty());
    if segments.is_empty() {
        return Err((1, "begins a message without samples".to_owned()));
    }
    Ok(segments)
}

/// Takes a line of metadata.
fn note(meta: &mut Meta, key: &str, value: &str) -> Result<(), String> {
    let time = || civil_time::parse(value).map(Some).map_err(|what| format!("{key} {what}"));
    match key {
        "REF_FRAME" => {
            meta.frame = Some(match value {
                "GCRF" | "ICRF" => Frame::Gcrf,
                "EME2000" | "J2000" => Frame::Eme2000,
                "TEME" => Frame::Teme,
                _ if value.starts_with("ITRF") => Frame::Itrf,
                _ => return Err(format!("REF_FRAME {value} is not one of GCRF, ICRF, EME2000, ITRF, TEME")),
            });
        }
        "TIME_SYSTEM" => {
            meta.clock = Some(match value {
                "UTC" => Clock::Utc,
                "TAI" => Clock::Tai,
                "TT" => Clock::Tt,
                "TDB" => Clock::Tdb,
                "GPS" => Clock::Gps,
                _ => return Err(format!("TIME_SYSTEM {value} is not one of UTC, TAI, TT, TDB, GPS")),
            });
        }
        "CENTER_NAME" if !value.eq_ignore_ascii_case("EARTH") => {
            return Err(format!("CENTER_NAME {value} is not EARTH"));
        }
        "USEABLE_START_TIME" => meta.usable[0] = time()?,
        "USEABLE_STOP_TIME" => meta.usable[1] = time()?,
        _ => {}
    }
    Ok(())
}

/// Time and position of a line of the ephemeris, in which six or nine numbers follow the time.
fn sample(line: &str) -> Option<(i64, [f64; 3])> {
    let mut fields = line.split_whitespace();
    let shown_us = civil_time::parse(fields.next()?).ok()?;
    let numbers: Vec<f64> = fields.map(str::parse).collect::<Result<_, _>>().ok()?;
    let sound = matches!(numbers.len(), 6 | 9) && numbers.iter().all(|number| number.is_finite());
    sound.then(|| (shown_us, [numbers[0], numbers[1], numbers[2]]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "\
CCSDS_OEM_VERS = 2.0
CREATION_DATE = 2026-01-01T00:00:00
ORIGINATOR = NONE

META_START
OBJECT_NAME = SEXTANT
CENTER_NAME = EARTH
REF_FRAME = EME2000
TIME_SYSTEM = UTC
START_TIME = 2026-09-23T18:00:00.000
USEABLE_START_TIME = 2026-09-23T18:01:00.000
STOP_TIME = 2026-09-23T18:02:00.000
META_STOP
COMMENT made by hand
2026-09-23T18:00:00.000 7000.0 0.0 0.0 0.0 7.5 0.0
2026-266T18:01:00.000 6990.0 450.0 0.0 -0.1 7.5 0.0
2026-09-23T18:02:00.000 6960.0 900.0 0.0 -0.2 7.5 0.0 0.0 0.0 0.0
COVARIANCE_START
EPOCH = 2026-09-23T18:00:00
1.0
COVARIANCE_STOP
";

    #[test]
    fn samples_in_the_usable_time_are_read() {
        let segments = read(FILE).unwrap();
        assert_eq!((segments.len(), segments[0].frame), (1, Frame::Eme2000));
        let first_us = civil_time::tt_us("2026-09-23T18:01:00").unwrap();
        let expected = [(first_us, [6990.0, 450.0, 0.0]), (first_us + 60_000_000, [6960.0, 900.0, 0.0])];
        assert_eq!(segments[0].places, expected);
    }

    #[test]
    fn faults_name_the_line() {
        let fault = |from: &str, to: &str| read(&FILE.replacen(from, to, 1)).unwrap_err();
        assert_eq!(fault("CCSDS_OEM_VERS", "CCSDS_OPM_VERS").0, 1);
        assert_eq!(fault("CENTER_NAME = EARTH", "CENTER_NAME = MARS").0, 7);
        let (line, what) = fault("EME2000", "TOD");
        assert!(line == 8 && what.contains("TOD"));
        assert_eq!(fault("= UTC", "= UT1").0, 9);
        assert_eq!(fault("REF_FRAME = EME2000\n", "").0, 12);
        assert_eq!(fault("7000.0 0.0", "7000.0").0, 15);
        assert_eq!(fault("2026-09-23T18:02:00.000 6960.0", "2026-09-23T18:01:00.000 6960.0").0, 17);
        assert_eq!(read("").unwrap_err().0, 1);
    }
}
