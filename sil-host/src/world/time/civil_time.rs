//! Civil time to the clock of the program: the only place that knows of leap seconds.
//!
//! In: calendar dates on the clocks of UTC, TAI, TT, TDB and the navigation satellites. Out: Terrestrial
//! Time, microseconds since J2000.0 (2000-01-01T12:00:00 TT). `TT = TAI + 32.184 s`, `TAI = UTC + n` with n
//! from the table of the IERS (Bulletin C; none after 2017 has been announced), `TDB = TT + 1.657 ms sin g`
//! with the Earth's mean anomaly g (right to 0.05 ms). Days by the Gregorian calendar's rule. The leap second
//! itself, 23:59:60, is refused.

/// TT less TAI, µs.
const TT_MINUS_TAI_US: i64 = 32_184_000;
/// First and last year taken; before 1972 UTC had no whole seconds.
const YEARS: (i64, i64) = (1972, 2060);
/// A day, µs.
pub const DAY_US: i64 = 86_400_000_000;

/// TAI less UTC from the first of a month on: year, month, s.
const LEAP_SECONDS: [(i64, i64, i64); 28] = [
    (1972, 1, 10),
    (1972, 7, 11),
    (1973, 1, 12),
    (1974, 1, 13),
    (1975, 1, 14),
    (1976, 1, 15),
    (1977, 1, 16),
    (1978, 1, 17),
    (1979, 1, 18),
    (1980, 1, 19),
    (1981, 7, 20),
    (1982, 7, 21),
    (1983, 7, 22),
    (1985, 7, 23),
    (1988, 1, 24),
    (1990, 1, 25),
    (1991, 1, 26),
    (1992, 7, 27),
    (1993, 7, 28),
    (1994, 7, 29),
    (1996, 1, 30),
    (1997, 7, 31),
    (1999, 1, 32),
    (2006, 1, 33),
    (2009, 1, 34),
    (2012, 7, 35),
    (2015, 7, 36),
    (2017, 1, 37),
];

/// A clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Coordinated Universal Time.
    Utc,
    /// International Atomic Time.
    Tai,
    /// Terrestrial Time.
    Tt,
    /// Barycentric Dynamical Time.
    Tdb,
    /// GPS, and Galileo and QZSS with it: TAI - 19 s.
    Gps,
    /// BeiDou: TAI - 33 s.
    BeiDou,
}

impl Clock {
    /// TT of what this clock shows, both in µs since 2000-01-01T12:00:00 on their own clock.
    pub fn tt_us(self, shown_us: i64) -> i64 {
        let seconds = |s: i64| shown_us + s * 1_000_000 + TT_MINUS_TAI_US;
        match self {
            Self::Utc => seconds(tai_minus_utc(|change_us, _| change_us <= shown_us)),
            Self::Tai => seconds(0),
            Self::Tt => shown_us,
            Self::Tdb => {
                let days = shown_us as f64 / DAY_US as f64;
                let anomaly = (357.529 + 0.985_600_28 * days).to_radians();
                shown_us - libm::rint(1657.0 * libm::sin(anomaly)) as i64
            }
            Self::Gps => seconds(19),
            Self::BeiDou => seconds(33),
        }
    }
}

/// TAI less UTC, s, after the last change that `is_past`; it is given the change (UTC, µs since noon of
/// 2000-01-01) and the new difference.
fn tai_minus_utc(is_past: impl Fn(i64, i64) -> bool) -> i64 {
    let mut difference = LEAP_SECONDS[0].2;
    for (year, month, seconds) in LEAP_SECONDS {
        if is_past(days_since_2000(year, month, 1) * DAY_US - DAY_US / 2, seconds) {
            difference = seconds;
        }
    }
    difference
}

fn tt_minus_utc_us(tt_us: i64) -> i64 {
    let tai_us = tt_us - TT_MINUS_TAI_US;
    let seconds = tai_minus_utc(|change_us, seconds| change_us + seconds * 1_000_000 <= tai_us);
    seconds * 1_000_000 + TT_MINUS_TAI_US
}

/// TT less UTC at an instant (TT, µs since J2000.0), s.
pub fn tt_minus_utc_s(tt_us: i64) -> f64 {
    tt_minus_utc_us(tt_us) as f64 * 1e-6
}

/// Days from 2000-01-01 to the first of March of `year`, then months of 30 or 31 days in the order that puts
/// February last: the usual count of days that needs no table.
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

/// What a clock shows at a date, µs since 2000-01-01T12:00:00, or what is wrong with the date. `second_us`
/// counts within the minute.
pub fn shown_us([year, month, day, hour, minute]: [i64; 5], second_us: i64) -> Result<i64, &'static str> {
    if !(YEARS.0..=YEARS.1).contains(&year) {
        return Err("is not within 1972 to 2060");
    }
    let date = (1..=12).contains(&month) && (1..=days_of_month(year, month)).contains(&day);
    let time = (0..24).contains(&hour) && (0..60).contains(&minute) && (0..60_000_000).contains(&second_us);
    if !(date && time) {
        return Err("is no day or hour of the calendar");
    }
    let minutes = days_since_2000(year, month, day) * 1440 + hour * 60 + minute;
    Ok(minutes * 60_000_000 + second_us - DAY_US / 2)
}

/// The digits of `text` as a number.
fn digits(text: &str) -> Option<i64> {
    let all = !text.is_empty() && text.len() < 10 && text.bytes().all(|byte| byte.is_ascii_digit());
    all.then(|| text.parse().ok()).flatten()
}

/// Hours, minutes and µs of `HH:MM:SS` or `HH:MM:SS.sss`.
fn time_of_day(text: &str) -> Option<(i64, i64, i64)> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let mut parts = whole.split(':');
    let mut next = || parts.next().filter(|part| part.len() == 2).and_then(digits);
    let (hour, minute, second) = (next()?, next()?, next()?);
    let fraction_us = digits(fraction.get(..fraction.len().min(9))?)? as f64
        * libm::pow(10.0, 6.0 - fraction.len().min(9) as f64);
    (parts.next().is_none()).then_some((hour, minute, second * 1_000_000 + libm::rint(fraction_us) as i64))
}

/// What a clock shows, from `YYYY-MM-DDTHH:MM:SS` or `YYYY-DDDTHH:MM:SS` (day of the year), either with a
/// fraction and a `Z`; µs since 2000-01-01T12:00:00.
pub fn parse(text: &str) -> Result<i64, &'static str> {
    const SHAPE: &str = "is no time of the form 2026-09-23T18:00:00";
    let (date, time) = text.strip_suffix('Z').unwrap_or(text).split_once('T').ok_or(SHAPE)?;
    let (hour, minute, second_us) = time_of_day(time).ok_or(SHAPE)?;
    let parts: Vec<Option<i64>> = date.split('-').map(digits).collect();
    let lengths: Vec<usize> = date.split('-').map(str::len).collect();
    match (&parts[..], &lengths[..]) {
        ([Some(year), Some(month), Some(day)], [4, 2, 2]) => {
            shown_us([*year, *month, *day, hour, minute], second_us)
        }
        ([Some(year), Some(day)], [4, 3]) => {
            let first = shown_us([*year, 1, 1, hour, minute], second_us)?;
            let last = days_since_2000(year + 1, 1, 1) - days_since_2000(*year, 1, 1);
            let fits = (1..=last).contains(day);
            if fits { Ok(first + (day - 1) * DAY_US) } else { Err("is no day or hour of the calendar") }
        }
        _ => Err(SHAPE),
    }
}

/// TT in microseconds since J2000.0 of a time in UTC, or what is wrong with the text.
pub fn tt_us(text: &str) -> Result<i64, &'static str> {
    parse(text).map(|utc_us| Clock::Utc.tt_us(utc_us))
}

/// The UTC of an instant (TT, µs since J2000.0) to the second, for messages.
pub fn utc_text(tt_us: i64) -> String {
    let mut text = shown_text(tt_us - tt_minus_utc_us(tt_us));
    text.truncate("YYYY-MM-DDTHH:MM:SS".len());
    text
}

/// What a clock shows (µs since 2000-01-01T12:00:00) as [`parse`] reads it, with six decimals of a second.
pub fn shown_text(shown_us: i64) -> String {
    let (seconds, us) = (shown_us.div_euclid(1_000_000) + 43_200, shown_us.rem_euclid(1_000_000));
    let (days, second) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    let mut year = 2000 + days.div_euclid(366);
    while days_since_2000(year + 1, 1, 1) <= days {
        year += 1;
    }
    let month = (2..=12).rev().find(|month| days_since_2000(year, *month, 1) <= days).unwrap_or(1);
    let day = days - days_since_2000(year, month, 1) + 1;
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{us:06}")
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
        assert_eq!(tt_us("2026-266T18:00:00.000"), tt_us("2026-09-23T18:00:00"));
        assert_eq!(parse("2000-01-01T12:00:01.25"), Ok(1_250_000));
        // 2024-02-29 exists; the day after it is the first of March.
        let day = tt_us("2024-03-01T00:00:00").unwrap() - tt_us("2024-02-29T00:00:00").unwrap();
        assert_eq!(day, 86_400_000_000);
        // JD 2457754.5 is 2017-01-01T00:00.
        assert_eq!(tt_us("2017-01-01T00:00:00"), Ok((6209 * 86_400 + 43_200) * 1_000_000 + 69_184_000));
    }

    #[test]
    fn a_time_shown_is_read_as_itself() {
        for shown_us in [-1, 0, 1, 843_458_400_123_456, -86_400_000_000 * 400, 951_782_400_000_000] {
            assert_eq!(parse(&shown_text(shown_us)), Ok(shown_us), "{}", shown_text(shown_us));
        }
        assert_eq!(shown_text(1_250_000), "2000-01-01T12:00:01.250000");
    }

    #[test]
    fn leap_seconds_lengthen_the_day_before_them() {
        for (before, after, seconds) in [
            ("2016-12-31T23:59:59", "2017-01-01T00:00:00", 2),
            ("2008-12-31T23:59:59", "2009-01-01T00:00:00", 2),
            ("2012-06-30T23:59:59", "2012-07-01T00:00:00", 2),
            ("2010-12-31T23:59:59", "2011-01-01T00:00:00", 1),
        ] {
            assert_eq!(tt_us(after).unwrap() - tt_us(before).unwrap(), seconds * 1_000_000, "{after}");
            for text in [before, after] {
                assert_eq!(utc_text(tt_us(text).unwrap()), text);
            }
        }
        assert_eq!(tt_minus_utc_s(tt_us("2008-08-30T21:00:00").unwrap()), 65.184);
    }

    #[test]
    fn clocks_differ_by_what_they_are_defined_to() {
        // GPS is 18 s ahead of UTC since 2017, BeiDou 4 s; TDB and TT differ by less than 2 ms.
        let noon = parse("2026-09-23T12:00:00").unwrap();
        let utc = Clock::Utc.tt_us(noon);
        assert_eq!(utc - Clock::Gps.tt_us(noon), 18_000_000);
        assert_eq!(utc - Clock::BeiDou.tt_us(noon), 4_000_000);
        assert_eq!(utc - Clock::Tai.tt_us(noon), 37_000_000);
        let tdb_less_tt = Clock::Tt.tt_us(noon) - Clock::Tdb.tt_us(noon);
        // SOFA's dtdb gives -1.639 ms for this date.
        assert!((tdb_less_tt + 1639).abs() < 60, "{tdb_less_tt}");
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for text in [
            "",
            "now",
            "2026-09-23",
            "2026-09-23 18:00:00",
            "2026-02-29T00:00:00",
            "2026-366T00:00:00",
            "2026-13-01T00:00:00",
            "2026-04-31T00:00:00",
            "2026-01-01T24:00:00",
            "2016-12-31T23:59:60",
            "1971-12-31T00:00:00",
            "2026-09-23T18:00:0é",
            "+026-09-23T18:00:00",
            "2026-09-23T18:00:00.",
            "2026-09-23T18:00:00:00",
        ] {
            assert!(tt_us(text).is_err(), "{text}");
        }
    }
}
