//! Precise orbits in the format SP3, versions c and d (and a and b, which are parts of it).
//!
//! In: text. Out: samples in ITRF. Read are version and frame (line 1), the clock (`%c`), epochs (`*`) and
//! positions (`P`, km; zeros mark what is missing and are left out). Velocities (`V`) are not: the format has
//! dm/s, but some makers write m/s. Format: Hilla, "The Extended Standard Product 3 Orbit Format
//! (SP3-d)", 2016.

use super::track::{Frame, Samples};
use crate::world::time::civil_time::{self, Clock};
use crate::world::time::earth_orientation::LineFault;

/// The positions of `satellite`, or of the only one in the file.
///
/// # Errors
/// The first line that cannot be read.
pub fn read(text: &str, satellite: Option<&str>) -> Result<Samples, LineFault> {
    let head = text.lines().next().unwrap_or_default();
    if !(head.len() > 50
        && head.is_ascii()
        && head.starts_with('#')
        && matches!(&head[1..2], "a" | "b" | "c" | "d"))
    {
        return Err((1, "is no first line of an SP3 file".to_owned()));
    }
    // Versions a and b have no clock line: theirs is that of GPS.
    let (mut clock, mut clock_known) = (Clock::Gps, false);
    let mut satellite = satellite.map(str::to_owned);
    let mut now_us = None;
    let mut samples = Samples { frame: Frame::Itrf, places: Vec::new() };
    for (index, line) in text.lines().enumerate() {
        let fault = |what: &str| (index + 1, what.to_owned());
        if !line.is_ascii() {
            return Err(fault("has characters that SP3 does not"));
        }
        if line.starts_with("EOF") {
            break;
        } else if let Some(rest) = line.strip_prefix("%c") {
            if !clock_known {
                clock = named_clock(rest.get(7..10).unwrap_or_default())
                    .ok_or_else(|| fault("names no clock that is known"))?;
                clock_known = true;
            }
        } else if let Some(rest) = line.strip_prefix("* ") {
            let shown_us = epoch(rest).ok_or_else(|| fault("is no epoch"))?;
            now_us = Some(clock.tt_us(shown_us));
        } else if let Some(rest) = line.strip_prefix('P') {
            let place = place(rest).ok_or_else(|| fault("is no position"))?;
            let time_us = now_us.ok_or_else(|| fault("stands before the first epoch"))?;
            let (name, place) = place;
            match &satellite {
                Some(wanted) if *wanted == name => {}
                Some(_) => continue,
                None => satellite = Some(name),
            }
            if samples.places.last().is_some_and(|(last, _)| *last >= time_us) {
                return Err(fault("is not later than the sample before it"));
            }
            if place != [0.0; 3] {
                samples.places.push((time_us, place));
            }
        }
    }
    if samples.places.is_empty() {
        return Err((1, format!("holds no position of {}", satellite.as_deref().unwrap_or("a satellite"))));
    }
    Ok(samples)
}

fn named_clock(name: &str) -> Option<Clock> {
    Some(match name {
        "GPS" | "GAL" | "QZS" | "IRN" | "ccc" => Clock::Gps,
        "TAI" => Clock::Tai,
        "UTC" | "GLO" => Clock::Utc,
        "BDT" | "BDS" => Clock::BeiDou,
        _ => return None,
    })
}

/// What the clock shows: year, month, day, hour, minute, second.
fn epoch(rest: &str) -> Option<i64> {
    let fields: Vec<&str> = rest.split_whitespace().collect();
    let [year, month, day, hour, minute, second] = fields[..] else { return None };
    let date = [year, month, day, hour, minute].map(|field| field.parse().unwrap_or(-1));
    let second: f64 = second.parse().ok()?;
    civil_time::shown_us(date, libm::rint(second * 1e6) as i64).ok()
}

/// Name and position, in fixed columns.
fn place(rest: &str) -> Option<(String, [f64; 3])> {
    let number = |from: usize| {
        let value: f64 = rest.get(from..from + 14)?.trim().parse().ok()?;
        value.is_finite().then_some(value)
    };
    // Two-digit satellites of version a are those of GPS.
    let name = rest.get(0..3)?.trim();
    let name =
        if name.starts_with(|c: char| c.is_ascii_digit()) { format!("G{name:0>2}") } else { name.to_owned() };
    Some((name, [number(3)?, number(17)?, number(31)?]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "\
#cV2008  8 30 21  0  0.00000000       2 DORIS ITR05 FIT  LCA
## 1494 594000.00000000    60.00000000 54708 0.8750000000000
+    2   L27L28  0  0  0  0  0  0  0  0  0  0  0  0  0  0  0
%c L  cc TAI ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc
%c cc cc ccc ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc
*  2008  8 30 21  0  0.00000000
PL27   4568.999996  -1248.011684  -6092.098073 999999.999999
VL27   5265.229178   3131.587619   3304.883158 999999.999999
PL28      0.000000      0.000000      0.000000 999999.999999
*  2008  8 30 21  1  0.00000000
PL27   4878.501723  -1059.644822  -5884.398993 999999.999999
PL28   4878.501723  -1059.644822  -5884.398993 999999.999999
EOF
";

    #[test]
    fn positions_of_the_wanted_satellite_are_read_on_its_clock() {
        let samples = read(FILE, None).unwrap();
        assert_eq!(samples.frame, Frame::Itrf);
        // TAI is 33 s ahead of UTC in 2008.
        let expected_us = civil_time::tt_us("2008-08-30T20:59:27").unwrap();
        assert_eq!(samples.places[0], (expected_us, [4568.999996, -1248.011684, -6092.098073]));
        assert_eq!(samples.places.len(), 2);
        let other = read(FILE, Some("L28")).unwrap();
        assert_eq!(other.places.len(), 1);
        assert_eq!(other.places[0].0, expected_us + 60_000_000);
    }

    #[test]
    fn faults_name_the_line() {
        let fault = |from: &str, to: &str| read(&FILE.replace(from, to), None).unwrap_err();
        assert_eq!(fault("#c", "#e").0, 1);
        assert_eq!(fault("TAI", "XYZ").0, 4);
        assert_eq!(fault("*  2008  8 30 21  0", "*  2008 18 30 21  0").0, 6);
        assert_eq!(fault("4568.999996", "4568.9x9996").0, 7);
        assert_eq!(fault("*  2008  8 30 21  1", "*  2008  8 30 21  0").0, 11);
        assert!(read(FILE, Some("G01")).unwrap_err().1.contains("G01"));
        assert_eq!(read("", None).unwrap_err().0, 1);
        assert_eq!(read("#cü", None).unwrap_err().0, 1);
    }
}
