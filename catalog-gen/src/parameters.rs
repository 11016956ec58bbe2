//! What kind of catalogue to build: limits with unit, range and reason, and the choice of them for a camera.
//!
//! | parameter | unit | range | reference | why |
//! |---|---|---|---|---|
//! | `magnitude` | V | 0 to 8 | 6.5 | faintest star kept; the source ends at 8 |
//! | `field_deg` | deg | 1 to 90 | 24.1 | longer side of the camera's field, noted in the file |
//! | `max_separation_deg` | deg | 0.1 to 60 | 10 | longest separation in the pair table |
//! | `brighter_neighbours` | stars | 0 to 1000 | 3 | a star with more brighter ones around it is left out |
//! | `thinning_radius_deg` | deg | 0 to 60 | 4.05 | what "around" means; 0 keeps every star |
//! | `proximity_deg` | deg | 0 to 1 | 0.067 | neighbours closer than this disturb a centroid (3.5 px) |
//! | `epoch_year` | Julian year | 1950 to 2100 | 2026.5 | mission's middle; proper motion is applied |

use crate::source::{FAINTEST_V, SourceStar};
use thiserror::Error;

/// Epoch of the embedded catalogue and default of the command line.
pub const DEFAULT_EPOCH_YEAR: f64 = 2026.5;
/// Field of the reference camera, degrees: 1280 x 1024 px at a focal length of 3000 px.
pub const REFERENCE_FIELD_DEG: [f64; 2] = [24.1, 19.4];
/// More pairs than this are refused: 80 MB of table, far beyond any use.
pub const MAX_PAIRS: f64 = 20e6;

/// The proximity radius as a share of the longer side of the field: 3.5 px of 1280.
const PROXIMITY_PER_FIELD: f64 = 1.0 / 360.0;
/// Longest separation worth a place in the pair table: beyond it, distortion costs more than the pair brings.
const LONGEST_SEPARATION_DEG: f64 = 12.0;
/// The pair table reaches over this share of the field's diagonal.
const SEPARATION_PER_DIAGONAL: f64 = 0.75;
/// Stars in the mean field to which [`for_field`] sets the magnitude limit.
const STARS_IN_MEAN_FIELD: f64 = 30.0;
/// Thinning of [`for_field`]: at most this many brighter stars within this share of the longer side. The
/// circle is about half the field, so only fields twice as rich as the mean are thinned.
const BRIGHTER_NEIGHBOURS: u32 = 25;
const THINNING_PER_FIELD: f64 = 0.4;
/// Longer sides that a catalogue to V 8 can serve, and the shortest shorter side, degrees.
const FIELD_RANGE_DEG: std::ops::RangeInclusive<f64> = 4.0..=60.0;
const SHORTEST_SIDE_DEG: f64 = 2.0;
/// Longer sides of the fields that fly: catalogues for narrower ones outgrow [`FLIGHT_BYTES`], wider ones
/// were not flown.
pub const FLIGHT_FIELD_DEG: std::ops::RangeInclusive<f64> = 8.0..=40.0;
/// Most bytes of a catalogue for flight.
pub const FLIGHT_BYTES: usize = 256 * 1024;
/// Height over width of the reference field.
const REFERENCE_ASPECT: f64 = 0.8;
/// Stars a magnitude fainter are three times as many, so that 4 magnitudes make up for a field ten times
/// narrower.
const MAGNITUDES_PER_DECADE: f64 = 4.0;
/// The whole sky in square degrees.
const SKY_DEG2: f64 = 41_252.961;

/// Why no catalogue was built.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BuildError {
    /// A parameter is out of its range, or not a number.
    #[error("{name} of {value} is impossible; give {low} to {high}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value allowed.
        low: f64,
        /// Largest value allowed.
        high: f64,
    },
    /// No catalogue can serve such a camera.
    #[error(
        "no catalogue serves a field of {width_deg:.1} x {height_deg:.1} deg; the longer side must be 4 to 60 deg, the shorter at least 2"
    )]
    NoField {
        /// Width of the field, degrees.
        width_deg: f64,
        /// Height of the field, degrees.
        height_deg: f64,
    },
    /// No catalogue for flight can serve such a camera.
    #[error(
        "no flight catalogue serves a field of {0:.1} deg; its longer side must be 8 to 40 deg: give another focal length"
    )]
    NoFlightField(f64),
    /// More stars than a catalogue can hold.
    #[error(
        "{0} stars are more than the 65535 that a catalogue holds; lower the magnitude or the stars per field"
    )]
    TooManyStars(usize),
    /// The pair table would be absurdly large.
    #[error("about {0:.0} million pairs are too many; lower the largest separation or the magnitude")]
    TooManyPairs(f64),
    /// A star cannot be written.
    #[error("star {hip} cannot be written; its direction must be a unit vector and its number below 1048576")]
    Star {
        /// Hipparcos number.
        hip: u32,
    },
}

/// What kind of catalogue to build; the table above says what each value means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildParameters {
    /// Faintest V kept.
    pub magnitude: f64,
    /// Longer side of the field, degrees.
    pub field_deg: f64,
    /// Longest separation in the pair table, degrees.
    pub max_separation_deg: f64,
    /// Largest number of brighter stars within the thinning radius of a kept star.
    pub brighter_neighbours: u32,
    /// Radius of the thinning circle, degrees.
    pub thinning_radius_deg: f64,
    /// Distance within which a neighbour disturbs a centroid, degrees; within a quarter of it two stars are
    /// one blob.
    pub proximity_deg: f64,
    /// Epoch of the directions, Julian year.
    pub epoch_year: f64,
}

impl BuildParameters {
    /// Those of the embedded catalogue: V 6.5, at most 3 brighter stars within 4.05 degrees, pairs to 10
    /// degrees.
    ///
    /// The smaller the circle, the more evenly the same number of stars lies, for a cluster robs fewer others
    /// of their place; and fewer pairs a star leave room for more stars. Of 20,000 fields the one with the
    /// fewest stars has 24, and 6 beside an Earth's disc (`inspect`); with 6 stars to V 6 within 5.7 degrees
    /// and pairs to 12 degrees, in nearly as many bytes, 18 and 2.
    pub fn reference() -> Self {
        let [field_deg, _] = REFERENCE_FIELD_DEG;
        Self {
            magnitude: 6.5,
            field_deg,
            max_separation_deg: 10.0,
            brighter_neighbours: 3,
            thinning_radius_deg: 4.05,
            proximity_deg: field_deg * PROXIMITY_PER_FIELD,
            epoch_year: DEFAULT_EPOCH_YEAR,
        }
    }

    /// Sets the density: of a field `field_deg` wide and 0.8 of that high the thinning circle covers a share
    /// s, so `stars` a field are `s * stars` in the circle, and the faintest of them has one brighter
    /// neighbour less.
    pub fn with_stars_per_field(self, stars: f64) -> Self {
        let circle = core::f64::consts::PI * self.thinning_radius_deg * self.thinning_radius_deg;
        let share = circle / (0.8 * self.field_deg * self.field_deg);
        Self { brighter_neighbours: ((share * stars).round() - 1.0).max(0.0) as u32, ..self }
    }

    /// Those of a catalogue for flight behind a field of this size, degrees: the reference's, scaled with the
    /// field, where no more than `brighter_neighbours` (the reference has 3) brighter stars lie in the
    /// thinning circle. The magnitude limit follows the density of stars, to V 8.
    ///
    /// # Errors
    /// When the longer side is not 8 to 40 deg, a twentieth of a degree granted.
    pub fn for_flight(
        [width_deg, height_deg]: [f64; 2],
        epoch_year: f64,
        brighter_neighbours: u32,
    ) -> Result<Self, BuildError> {
        let field_deg = width_deg.max(height_deg);
        let rounded_deg = (field_deg * 10.0).round() / 10.0;
        // Of a number and NaN `max` and `min` give the number: each side is held against its bound.
        let wide_enough = width_deg >= SHORTEST_SIDE_DEG && height_deg >= SHORTEST_SIDE_DEG;
        if !(FLIGHT_FIELD_DEG.contains(&rounded_deg) && wide_enough) {
            return Err(BuildError::NoFlightField(field_deg));
        }
        let reference = Self::reference();
        // The longer side of a field of the reference's shape that sees as much sky.
        let side_deg = libm::sqrt(width_deg * height_deg / REFERENCE_ASPECT);
        let scale = side_deg / reference.field_deg;
        let magnitude = reference.magnitude - MAGNITUDES_PER_DECADE * libm::log10(scale).min(0.0);
        Ok(Self {
            magnitude: ((magnitude * 100.0).round() / 100.0).min(FAINTEST_V),
            field_deg,
            max_separation_deg: thousandth(reference.max_separation_deg * scale).min(LONGEST_SEPARATION_DEG),
            brighter_neighbours,
            thinning_radius_deg: thousandth(reference.thinning_radius_deg * scale),
            proximity_deg: field_deg * PROXIMITY_PER_FIELD,
            epoch_year,
        })
    }

    /// Checks every range.
    ///
    /// # Errors
    /// With the first parameter out of its range.
    pub fn check(&self) -> Result<(), BuildError> {
        let ranges = [
            ("magnitude limit", self.magnitude, 0.0, FAINTEST_V),
            ("field", self.field_deg, 1.0, 90.0),
            ("largest separation", self.max_separation_deg, 0.1, 60.0),
            ("number of brighter neighbours", f64::from(self.brighter_neighbours), 0.0, 1000.0),
            ("thinning radius", self.thinning_radius_deg, 0.0, 60.0),
            ("proximity radius", self.proximity_deg, 0.0, 1.0),
            ("epoch", self.epoch_year, 1950.0, 2100.0),
        ];
        for (name, value, low, high) in ranges {
            if !(low..=high).contains(&value) {
                return Err(BuildError::Parameter { name, value, low, high });
            }
        }
        Ok(())
    }
}

/// Parameters for a camera whose field is `width_deg` x `height_deg`, from the embedded star source.
///
/// The magnitude limit puts 30 stars into the mean field (not beyond the source's V 8), crowded fields are
/// thinned to about 50, the pair table reaches over 3/4 of the diagonal (not beyond 12 degrees).
///
/// # Errors
/// When the field is smaller than a catalogue to V 8 can serve (4 degrees), or larger than 60 degrees.
pub fn for_field(width_deg: f64, height_deg: f64, epoch_year: f64) -> Result<BuildParameters, BuildError> {
    for_field_from(&crate::source::stars(), width_deg, height_deg, epoch_year)
}

/// As [`for_field`], from other stars.
///
/// # Errors
/// As [`for_field`].
pub fn for_field_from(
    stars: &[SourceStar],
    width_deg: f64,
    height_deg: f64,
    epoch_year: f64,
) -> Result<BuildParameters, BuildError> {
    let (field_deg, shorter_deg) = (width_deg.max(height_deg), width_deg.min(height_deg));
    // `max` and `min` pass over a value that is not a number.
    let numbers = !(width_deg.is_nan() || height_deg.is_nan());
    if !(numbers && FIELD_RANGE_DEG.contains(&field_deg) && shorter_deg >= SHORTEST_SIDE_DEG) {
        return Err(BuildError::NoField { width_deg, height_deg });
    }
    let wanted = (STARS_IN_MEAN_FIELD * SKY_DEG2 / (width_deg * height_deg)) as usize;
    let mut magnitudes: Vec<f64> = stars.iter().map(|star| star.v).collect();
    magnitudes.sort_unstable_by(f64::total_cmp);
    let magnitude = magnitudes.get(wanted).copied().unwrap_or(FAINTEST_V).clamp(0.0, FAINTEST_V);
    let diagonal_deg = (width_deg * width_deg + height_deg * height_deg).sqrt();
    let parameters = BuildParameters {
        magnitude: (magnitude * 100.0).ceil() / 100.0,
        field_deg,
        max_separation_deg: LONGEST_SEPARATION_DEG.min(SEPARATION_PER_DIAGONAL * diagonal_deg),
        brighter_neighbours: BRIGHTER_NEIGHBOURS,
        thinning_radius_deg: THINNING_PER_FIELD * field_deg,
        proximity_deg: field_deg * PROXIMITY_PER_FIELD,
        epoch_year,
    };
    parameters.check()?;
    Ok(parameters)
}

/// Rounded, so that the last digit of a field does not matter.
fn thousandth(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// Chord of a separation, `2 sin(separation / 2)`.
pub(crate) fn chord(separation_deg: f64) -> f64 {
    2.0 * libm::sin(separation_deg.to_radians() / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_that_no_catalogue_serves_is_refused_in_one_line() {
        for (width, height) in [(3.9, 3.0), (61.0, 20.0), (10.0, 1.0), (f64::NAN, 10.0), (-5.0, 10.0)] {
            let error = for_field_from(&[], width, height, 2026.5).unwrap_err().to_string();
            assert!(error.starts_with("no catalogue serves a field of") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn impossible_parameters_are_refused() {
        let good = BuildParameters::reference();
        assert_eq!(good.check(), Ok(()));
        let bad = [
            BuildParameters { magnitude: 8.1, ..good },
            BuildParameters { magnitude: f64::NAN, ..good },
            BuildParameters { field_deg: 0.5, ..good },
            BuildParameters { max_separation_deg: 0.0, ..good },
            BuildParameters { max_separation_deg: f64::INFINITY, ..good },
            BuildParameters { thinning_radius_deg: -1.0, ..good },
            BuildParameters { proximity_deg: 2.0, ..good },
            BuildParameters { epoch_year: 1900.0, ..good },
        ];
        for parameters in bad {
            assert!(matches!(parameters.check(), Err(BuildError::Parameter { .. })), "{parameters:?}");
        }
    }

    #[test]
    fn stars_per_field_and_brighter_neighbours_agree_for_the_reference() {
        assert_eq!(BuildParameters::reference().with_stars_per_field(37.0), BuildParameters::reference());
        assert_eq!(BuildParameters::reference().with_stars_per_field(0.0).brighter_neighbours, 0);
    }

    #[test]
    fn the_reference_is_the_flight_catalogue_of_its_field_and_fields_out_of_range_are_refused() {
        let for_flight = |width, height| BuildParameters::for_flight([width, height], DEFAULT_EPOCH_YEAR, 3);
        assert_eq!(for_flight(24.1, 0.8 * 24.1), Ok(BuildParameters::reference()));
        assert_eq!(for_flight(8.0, 6.4).unwrap().magnitude, 8.0);
        for (width, height) in [(7.9, 6.0), (41.0, 33.0), (30.0, 1.0), (f64::NAN, 10.0), (f64::INFINITY, 9.0)]
        {
            let error = for_flight(width, height).unwrap_err().to_string();
            assert!(error.contains("8 to 40 deg") && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn the_limits_for_a_field_follow_the_sky() {
        let limits = |width, height| for_field(width, height, 2026.5).unwrap();
        let [narrow, square, wide] = [limits(6.0, 4.5), limits(15.0, 15.0), limits(60.0, 45.0)];
        assert_eq!(narrow.magnitude, 8.0);
        assert!((narrow.max_separation_deg - 5.625).abs() < 1e-12);
        assert!(square.magnitude >= 6.0 && square.magnitude < 6.3, "{}", square.magnitude);
        assert!(wide.magnitude > 3.0 && wide.magnitude < 4.5, "{}", wide.magnitude);
        assert_eq!(wide.max_separation_deg, 12.0);
    }
}
