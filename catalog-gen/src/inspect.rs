//! What a catalogue file contains, for people and as JSON.

use crate::coverage::{Coverage, coverage, half_field};
use fsw_core::catalog::{Catalogue, CatalogueError};
use serde_json::{Value, json};
use std::fmt;

/// The contents of a catalogue.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Length in bytes.
    pub bytes: usize,
    /// Number of stars.
    pub stars: usize,
    /// Stars with a neighbour too close for an undisturbed centroid; they do not count in `coverage`.
    pub proximity_stars: usize,
    /// Number of pairs.
    pub pairs: usize,
    /// Number of bins of the pair table.
    pub bins: u32,
    /// Longest separation in the pair table, degrees.
    pub max_separation_deg: f64,
    /// Epoch of the directions, Julian year.
    pub epoch_year: f64,
    /// V of the brightest and the faintest star; `None` without stars.
    pub magnitudes: Option<[f64; 2]>,
    /// Longer side of the field it was thinned for, degrees.
    pub field_deg: f64,
    /// CRC-32 of the star source it was built from.
    pub source_crc: u32,
    /// How many usable stars random fields of that size hold.
    pub coverage: Coverage,
}

/// Opens a catalogue and looks through it.
///
/// # Errors
/// When the bytes are not an intact catalogue.
pub fn inspect(bytes: &[u8], fields: u32) -> Result<Inspection, CatalogueError> {
    const ONE_Q30: f64 = (1u32 << 30) as f64;
    let catalogue = Catalogue::open(bytes)?;
    let usable: Vec<[f64; 3]> = catalogue
        .stars()
        .filter(|star| !star.proximity)
        .map(|star| star.unit_q30.map(|x| f64::from(x) / ONE_Q30))
        .collect();
    let bins =
        bytes.get(24..).and_then(|rest| rest.first_chunk()).map_or(0, |word| u32::from_le_bytes(*word));
    let field_deg = f64::from(catalogue.field_millideg()) / 1000.0;
    let centi = |magnitude: i16| f64::from(magnitude) / 100.0;
    Ok(Inspection {
        bytes: bytes.len(),
        stars: catalogue.star_count(),
        proximity_stars: catalogue.star_count() - usable.len(),
        pairs: catalogue.pair_count(),
        bins,
        max_separation_deg: 2.0 * libm::asin(f64::from(catalogue.max_chord()) / 2.0).to_degrees(),
        epoch_year: f64::from(catalogue.epoch_year()),
        magnitudes: catalogue.star(0).map(|_| catalogue.magnitudes_centi().map(centi)),
        field_deg,
        source_crc: catalogue.source_crc(),
        coverage: coverage(&usable, fields, half_field(field_deg)),
    })
}

impl Inspection {
    /// Sides of the fields of `coverage`, tenths of a degree.
    fn sides_deg(&self) -> [f64; 2] {
        half_field(self.field_deg).map(|half| (20.0 * libm::atan(half).to_degrees()).round() / 10.0)
    }

    /// One JSON object.
    pub fn to_json(&self) -> Value {
        let rounded = |value: f64, digits: i32| {
            let scale = 10f64.powi(digits);
            (value * scale).round() / scale
        };
        let shares = |[three, four, five]: [f64; 3], fewest: u32| json!({ "3": three, "4": four, "5": five, "fewest_stars": fewest });
        let covered = &self.coverage;
        json!({
            "bytes": self.bytes,
            "stars": self.stars,
            "proximity_stars": self.proximity_stars,
            "pairs": self.pairs,
            "bins": self.bins,
            "max_separation_deg": rounded(self.max_separation_deg, 4),
            "epoch_year": rounded(self.epoch_year, 3),
            "brightest_v": self.magnitudes.map(|[brightest, _]| brightest),
            "faintest_v": self.magnitudes.map(|[_, faintest]| faintest),
            "field_deg": self.field_deg,
            "source_crc": format!("{:08x}", self.source_crc),
            "coverage": {
                "field_deg": self.sides_deg(),
                "fields": covered.fields,
                "mean_stars": rounded(covered.mean_stars, 3),
                "free": shares(covered.share, covered.fewest_stars),
                "earth_disc": shares(covered.share_with_earth, covered.fewest_stars_with_earth),
            },
        })
    }
}

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |shares: [f64; 3]| shares.map(|share| format!("{:8.3} %", share * 100.0)).join(" ");
        let [width_deg, height_deg] = self.sides_deg();
        let covered = &self.coverage;
        writeln!(
            f,
            "{} stars ({} with a close neighbour), epoch {:.3}",
            self.stars, self.proximity_stars, self.epoch_year
        )?;
        if let Some([brightest, faintest]) = self.magnitudes {
            writeln!(
                f,
                "V {brightest:.2} to {faintest:.2}, thinned for a field of {:.1} deg",
                self.field_deg
            )?;
        }
        writeln!(f, "{} pairs to {:.2} deg in {} bins", self.pairs, self.max_separation_deg, self.bins)?;
        writeln!(f, "{} bytes, star source {:08x}", self.bytes, self.source_crc)?;
        writeln!(
            f,
            "coverage, {} random fields of {width_deg} x {height_deg} deg, {:.1} stars in the mean:",
            covered.fields, covered.mean_stars
        )?;
        writeln!(f, "  stars in the field      >= 3       >= 4       >= 5   fewest")?;
        writeln!(f, "  whole field       {} {:8}", percent(covered.share), covered.fewest_stars)?;
        write!(
            f,
            "  with Earth disc   {} {:8}",
            percent(covered.share_with_earth),
            covered.fewest_stars_with_earth
        )
    }
}
