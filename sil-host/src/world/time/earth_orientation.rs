//! How the crust of the Earth stands in space, as observed.
//!
//! In: the IERS series C04 (20 C04, text as published: year, month, day, hour, MJD, x, y, UT1 - UTC, dX, dY
//! and more), or nothing; TT, µs since J2000.0. Out: the rotation from GCRF to ITRF by the CIO, IERS
//! Conventions 2010 ch. 5, `W(x, y, s') R3(ERA) Q(X + dX, Y + dY, s)`.
//!
//! Between the days UT1 - TAI, pole and offsets go straight (error below 0.3 mas); the tides of less than a
//! day (0.4 mas) are left out. Against SOFA's `c2t06a` with the same values: below 1 mas, which is nutation
//! 2000B. Without a file UT1 is UTC and the pole rests: up to 0.9 s and 0.6 arcsec, 14 arcsec about the axis.

use super::civil_time::{self, Clock, DAY_US};
use super::ephemeris::{ARCSEC, earth_rotation_angle, pole_and_locator};
use crate::world::attitude::{Vector, rotation};
use crate::world::vector::product;
use std::sync::Arc;

/// MJD of 2000-01-01.
const MJD_2000: i64 = 51_544;

/// A day's values.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Row {
    /// Midnight UTC: TT, µs since J2000.0.
    midnight_us: i64,
    /// UT1 - TT (s), which has no leaps; x, y, dX, dY (rad).
    values: [f64; 5],
}

/// The Earth's orientation over time; a copy is cheap. The default has UT1 = UTC and a pole at rest.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EarthOrientation {
    rows: Arc<[Row]>,
}

/// What is wrong with a line: its number from 1, and why.
pub type LineFault = (usize, String);

impl EarthOrientation {
    /// Reads a C04 series; lines that begin with `#` are left out.
    ///
    /// # Errors
    /// The first line that cannot be read, or is out of order.
    pub fn read(text: &str) -> Result<Self, LineFault> {
        let mut rows: Vec<Row> = Vec::new();
        for (index, line) in text.lines().enumerate() {
            if line.trim().is_empty() || line.starts_with('#') {
                continue;
            }
            let fault = |what: &str| (index + 1, what.to_owned());
            let row = row(line).ok_or_else(|| fault("is no row of an IERS C04 series"))?;
            if rows.last().is_some_and(|last| last.midnight_us >= row.midnight_us) {
                return Err(fault("is not later than the row before it"));
            }
            rows.push(row);
        }
        if rows.is_empty() {
            return Err((1, "holds no row of an IERS C04 series".to_owned()));
        }
        Ok(Self { rows: rows.into() })
    }

    /// The first day from `from_us` to `to_us` (TT, µs) that does not lie between the rows of two consecutive
    /// days.
    pub fn missing(&self, from_us: i64, to_us: i64) -> Option<i64> {
        if self.rows.is_empty() {
            return None;
        }
        let mut at_us = from_us;
        loop {
            let after = self.rows.partition_point(|row| row.midnight_us <= at_us);
            let bracket = after.checked_sub(1).map(|before| (&self.rows[before], self.rows.get(after)));
            let Some((before, Some(next))) = bracket else { return Some(at_us) };
            // A day with a leap second is longer.
            if next.midnight_us - before.midnight_us > DAY_US + 1_000_000 {
                return Some(at_us);
            }
            if next.midnight_us >= to_us {
                return None;
            }
            at_us = next.midnight_us;
        }
    }

    /// TT - UT1 (s), x, y, dX, dY (rad). Outside the series its first or last day.
    fn values(&self, time_us: i64) -> [f64; 5] {
        let after = self.rows.partition_point(|row| row.midnight_us <= time_us);
        let [ut1_less_tt, x, y, dx, dy] = match (after.checked_sub(1), self.rows.get(after)) {
            (Some(before), Some(next)) => {
                let before = &self.rows[before];
                let length = (next.midnight_us - before.midnight_us) as f64;
                let share = (time_us - before.midnight_us) as f64 / length;
                [0, 1, 2, 3, 4].map(|k| before.values[k] + share * (next.values[k] - before.values[k]))
            }
            (Some(last), None) => self.rows[last].values,
            (None, Some(first)) => first.values,
            (None, None) => [-civil_time::tt_minus_utc_s(time_us), 0.0, 0.0, 0.0, 0.0],
        };
        [-ut1_less_tt, x, y, dx, dy]
    }

    /// TT - UT1, s.
    pub fn tt_minus_ut1_s(&self, time_us: i64) -> f64 {
        self.values(time_us)[0]
    }

    /// GCRF to the terrestrial intermediate frame: ITRF but for the motion of the pole in the crust.
    pub fn gcrf_to_intermediate(&self, time_us: i64) -> [Vector; 3] {
        let [tt_minus_ut1_s, _, _, dx, dy] = self.values(time_us);
        let ([x, y, z], locator) = pole_and_locator(time_us);
        let (x, y) = (x + dx, y + dy);
        let a = 1.0 / (1.0 + z);
        let to_pole = [[1.0 - a * x * x, -a * x * y, -x], [-a * x * y, 1.0 - a * y * y, -y], [x, y, z]];
        let angle = earth_rotation_angle(time_us, tt_minus_ut1_s) - locator;
        product(&rotation(2, angle), &to_pole)
    }

    /// GCRF to the true equator and mean equinox of SGP4 (TEME), from which the Earth turns by the sidereal
    /// time of 1982 (Vallado et al. 2006). Both frames turn with the Earth alike, so that it serves
    /// velocities as well.
    pub fn gcrf_to_teme(&self, time_us: i64) -> [Vector; 3] {
        let ut1_us = time_us - libm::rint(1e6 * self.tt_minus_ut1_s(time_us)) as i64;
        let t = ut1_us as f64 / (36_525.0 * DAY_US as f64);
        let day = ut1_us.rem_euclid(DAY_US) as f64 / DAY_US as f64;
        // Counted from noon; whole days are taken out of 876,600 h a century.
        let seconds = 67_310.548_41 + t * (8_640_184.812_866 + t * (0.093_104 - 6.2e-6 * t));
        let angle = std::f64::consts::TAU * (day + libm::fmod(seconds / 86_400.0, 1.0));
        product(&rotation(2, -angle), &self.gcrf_to_intermediate(time_us))
    }

    /// GCRF to ITRF.
    pub fn gcrf_to_itrf(&self, time_us: i64) -> [Vector; 3] {
        let [_, x, y, _, _] = self.values(time_us);
        // s', 47 µas a century.
        let locator = -47e-6 * ARCSEC * time_us as f64 / (36_525.0 * DAY_US as f64);
        let tilt = product(&rotation(0, -y), &product(&rotation(1, -x), &rotation(2, locator)));
        product(&tilt, &self.gcrf_to_intermediate(time_us))
    }
}

/// GCRF to the mean equator and equinox of J2000.0 (EME2000): the frame bias (IERS Conventions 2010, 5.4.4).
pub fn gcrf_to_eme2000() -> [Vector; 3] {
    let [right_ascension, xi, eta] = [-14.6e-3, -16.617e-3, -6.8192e-3].map(|arcsec| arcsec * ARCSEC);
    product(&rotation(0, -eta), &product(&rotation(1, xi), &rotation(2, right_ascension)))
}

/// Reads a row.
fn row(line: &str) -> Option<Row> {
    let fields: Vec<f64> = line.split_whitespace().map_while(|field| field.parse().ok()).collect();
    let [year, month, day, _, mjd, x, y, ut1_utc, dx, dy, ..] = fields[..] else { return None };
    let utc_us = civil_time::shown_us([year as i64, month as i64, day as i64, 0, 0], 0).ok()?;
    let right = mjd == (utc_us + DAY_US / 2).div_euclid(DAY_US) as f64 + MJD_2000 as f64;
    let sound = [x, y, dx, dy].iter().all(|angle| angle.abs() < 2.0) && ut1_utc.abs() < 1.0;
    let midnight_us = Clock::Utc.tt_us(utc_us);
    let ut1_less_tt = ut1_utc - civil_time::tt_minus_utc_s(midnight_us);
    let values = [ut1_less_tt, x * ARCSEC, y * ARCSEC, dx * ARCSEC, dy * ARCSEC];
    (right && sound).then_some(Row { midnight_us, values })
}

#[cfg(test)]
mod tests;
