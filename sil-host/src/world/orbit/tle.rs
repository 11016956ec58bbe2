//! Two-line elements.
//!
//! In: the two lines, an instant. Out: position (km) and velocity (km/s) then, GCRF. The elements are mean
//! ones and only SGP4 gives them meaning (crate `sgp4`, after Vallado et al. 2006, with the constants WGS72
//! and the sidereal time of those who make the elements); its frame TEME is turned to GCRF. The state is as
//! good as the elements: about 1 km at their epoch, 1 to 3 km a day away from it.

use crate::world::attitude::{Vector, apply};
use crate::world::time::civil_time::Clock;
use crate::world::time::earth_orientation::EarthOrientation;
use crate::world::vector::transposed;
use sgp4::{Constants, Elements, MinutesSinceEpoch};

/// Unix time of 2000-01-01T12:00:00, µs.
const NOON_2000_UNIX_US: i64 = 946_728_000_000_000;

/// Position and velocity at `time_us` (TT, µs since J2000.0).
///
/// # Errors
/// What is wrong with the lines, and whether with the first (0) or the second (1).
pub fn state(
    lines: [&str; 2],
    time_us: i64,
    orientation: &EarthOrientation,
) -> Result<(Vector, Vector), (usize, String)> {
    for (index, line) in lines.iter().enumerate() {
        check(line, index).map_err(|what| (index, what))?;
    }
    let elements = Elements::from_tle(None, lines[0].as_bytes(), lines[1].as_bytes())
        .map_err(|error| (usize::from(!error.to_string().contains("TLE line 1")), error.to_string()))?;
    let second = |error: &dyn std::fmt::Display| (1, format!("cannot be flown: {error}"));
    let constants =
        Constants::from_elements_afspc_compatibility_mode(&elements).map_err(|error| second(&error))?;
    let epoch_us = Clock::Utc.tt_us(elements.datetime.and_utc().timestamp_micros() - NOON_2000_UNIX_US);
    let minutes = MinutesSinceEpoch((time_us - epoch_us) as f64 / 60e6);
    let state = constants.propagate_afspc_compatibility_mode(minutes).map_err(|error| second(&error))?;
    let to_gcrf = transposed(&orientation.gcrf_to_teme(time_us));
    Ok((apply(&to_gcrf, state.position), apply(&to_gcrf, state.velocity)))
}

/// Shape and check sum of a line.
fn check(line: &str, index: usize) -> Result<(), String> {
    if !(line.is_ascii() && line.len() == 69) {
        return Err(format!("has not the 69 characters of a TLE line {}", index + 1));
    }
    if line.as_bytes()[0] != b'1' + index as u8 {
        return Err(format!("does not begin with {}", index + 1));
    }
    // Digits count themselves, a minus one; the last digit is the sum's last.
    let sum: u32 = line[..68].chars().map(|c| if c == '-' { 1 } else { c.to_digit(10).unwrap_or(0) }).sum();
    let (found, given) = (sum % 10, &line[68..]);
    if given != found.to_string() {
        return Err(format!("has the check digit {given} where {found} is right"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::time::civil_time;
    use crate::world::vector::{length, minus};

    const LINES: [&str; 2] = [
        "1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927",
        "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537",
    ];

    #[test]
    fn states_are_those_of_another_program() {
        // Python's sgp4 2.27 (Vallado's own code) turned with ERFA: xys06a, era00, gmst82, UT1 = UTC.
        for (utc, r, v) in [
            (
                "2008-09-20T12:25:40",
                [4086.2504115004886, -1002.173116916544, 5240.148139080426],
                [2.527038386279261, 7.254818279497106, -0.5855022606743927],
            ),
            (
                "2008-09-22T06:00:00",
                [3139.0456843983675, 5928.01808027736, -537.2343720746455],
                [-4.4593806662995785, 1.8284796108958312, -6.006269245969944],
            ),
        ] {
            let time_us = civil_time::tt_us(utc).unwrap();
            let (position, velocity) = state(LINES, time_us, &EarthOrientation::default()).unwrap();
            let apart = (1e3 * length(minus(position, r)), 1e6 * length(minus(velocity, v)));
            println!("{utc}: {:.4} m, {:.4} mm/s", apart.0, apart.1);
            assert!(apart.0 < 0.05 && apart.1 < 0.05);
        }
    }

    #[test]
    fn faulty_lines_are_refused_with_the_reason() {
        let at = civil_time::tt_us("2008-09-20T12:25:40").unwrap();
        let refused =
            |first: &str, second: &str| state([first, second], at, &EarthOrientation::default()).unwrap_err();
        let (line, what) = refused(&LINES[0].replace("2927", "2928"), LINES[1]);
        assert!(line == 0 && what == "has the check digit 8 where 7 is right", "{what}");
        assert_eq!(refused(LINES[0], &LINES[1][..68]).0, 1);
        assert_eq!(refused(LINES[1], LINES[0]).0, 0);
        assert_eq!(refused(LINES[0], &LINES[1].replace("25544", "2554é")).0, 1);
        // Another satellite's second line: the numbers differ; the sum is kept.
        let other = LINES[1].replace("25544", "25553");
        assert!(refused(LINES[0], &other).1.contains("NORAD"), "{:?}", refused(LINES[0], &other));
    }
}
