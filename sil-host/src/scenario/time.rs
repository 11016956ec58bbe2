//! Civil time to the clock of the flight code.
//!
//! In: UTC as `YYYY-MM-DDTHH:MM:SS`, from 2017 on. Out: Terrestrial Time, microseconds since J2000.0
//! (2000-01-01T12:00:00 TT): `TT = UTC + (TAI - UTC) + 32.184 s` with TAI - UTC = 37 s, in force since 2017-01-01; no
//! later leap second has been announced. Days by the Gregorian calendar's rule.

/// TT less UTC, µs.
const TT_MINUS_UTC_US: i64 = 37_000_000 + 32_184_000;
/// First and last year taken.
const YEARS: (i64, i64) = (2017, 2060);

/// Days from 2000-01-01 to the first of March of `year`, then months of 30 or 31 days in the order that puts February
/// last: the usual count of days that needs no table.
fn days_since_2000(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month < 3 { (year - 1, month + 9) } else { (year, month - 3) };
    let whole_years = 365 * year + year / 4 - year / 100 + year / 400;
    // 730,426 is the same count for 2000-01-01 (year 1999, month 10, day 1).
    whole_years + (153 * month + 2) / 5 + day - 730_426
}

/// Days of a month.
fn days_of_month(year: i64, month: i64) -> i64 {
    let (next_year, next_month) = if month == 12 { (year + 1, 1) } else { (year, month + 1) };
    days_since_2000(next_year, next_month, 1) - days_since_2000(year, month, 1)
}

/// The digits of `text` between `from` and `to` as a number.
fn digits(text: &str, from: usize, to: usize) -> Option<i64> {
    let part = text.get(from..to)?;
    part.bytes().all(|byte| byte.is_ascii_digit()).then(|| part.parse().ok()).flatten()
}

/// TT in microseconds since J2000.0, or what is wrong with the text.
pub(super) fn tt_us(text: &str) -> Result<i64, &'static str> {
    let text = text.strip_suffix('Z').unwrap_or(text);
    let separators = [(4, b'-'), (7, b'-'), (10, b'T'), (13, b':'), (16, b':')];
    let shaped =
        text.len() == 19 && separators.iter().all(|(at, byte)| text.as_bytes().get(*at) == Some(byte));
    let fields = [(0, 4), (5, 7), (8, 10), (11, 13), (14, 16), (17, 19)];
    let numbers: Vec<i64> = fields.iter().filter_map(|(from, to)| digits(text, *from, *to)).collect();
    let ([year, month, day, hour, minute, second], true) =
        (numbers[..].try_into().unwrap_or([-1; 6]), shaped)
    else {
        return Err("is no time of the form 2026-09-23T18:00:00");
    };
    if !(YEARS.0..=YEARS.1).contains(&year) {
        return Err("is not within 2017 to 2060");
    }
    let date = (1..=12).contains(&month) && (1..=days_of_month(year, month)).contains(&day);
    if !(date && hour < 24 && minute < 60 && second < 60) {
        return Err("is no day or hour of the calendar");
    }
    let seconds = days_since_2000(year, month, day) * 86_400 + hour * 3600 + minute * 60 + second;
    Ok((seconds - 43_200) * 1_000_000 + TT_MINUS_UTC_US)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_those_of_the_julian_date() {
        // JD of 2026-09-23T18:00:00 UTC is 2461307.25; J2000.0 is 2451545.0.
        let seconds = (2_461_307.25 - 2_451_545.0) * 86_400.0 + 69.184;
        assert_eq!(tt_us("2026-09-23T18:00:00"), Ok((seconds * 1e6) as i64));
        assert_eq!(tt_us("2026-09-23T18:00:00Z"), tt_us("2026-09-23T18:00:00"));
        // 2024-02-29 exists; the day after it is the first of March.
        let day = tt_us("2024-03-01T00:00:00").unwrap() - tt_us("2024-02-29T00:00:00").unwrap();
        assert_eq!(day, 86_400_000_000);
        // JD 2457754.5 is 2017-01-01T00:00.
        assert_eq!(tt_us("2017-01-01T00:00:00"), Ok((6209 * 86_400 + 43_200) * 1_000_000 + 69_184_000));
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for text in [
            "",
            "now",
            "2026-09-23",
            "2026-09-23 18:00:00",
            "2026-02-29T00:00:00",
            "2026-13-01T00:00:00",
            "2026-04-31T00:00:00",
            "2026-01-01T24:00:00",
            "2016-12-31T00:00:00",
            "2026-09-23T18:00:0é",
            "+026-09-23T18:00:00",
        ] {
            assert!(tt_us(text).is_err(), "{text}");
        }
    }
}
