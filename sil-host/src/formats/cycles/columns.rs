//! The columns of `cycles.csv`, each declared once: name, unit, frame, meaning, and where it is found.
//!
//! The file's header, its rows and the page `sil-host/CYCLES.md` are made from [`COLUMNS`]. Names are a
//! contract: a name stays, and a new column goes to the end and raises [`VERSION`].
//!
//! No column says processor cycles: the host cannot count those of the on-board computer, and what the flight
//! code charges itself (`fsw_core::image::allowance`) are greatest prices of the search for spots alone.
//! `cargo budget` counts the cycles of each stage in the emulator.

use crate::harness::faults;
use crate::harness::status::{activity_word, fault_words, shut_word, status_word};
use crate::harness::{Second, events};
use crate::judge::arcsec;
use crate::judge::expected::{expected_mode, word};
use crate::world::attitude::Vector;
use fsw_core::telemetry::{EarthStatus, RateSource};
use serde::{Serialize, Serializer};

/// Version of the table: raised when a column is added or means something else.
pub const VERSION: u32 = 11;

/// What a row is made from.
#[derive(Clone, Copy, Debug)]
pub struct RowInputs<'a> {
    /// The second.
    pub second: Second<'a>,
    /// Whether its mode is as the geometry says.
    pub mode_right: bool,
}

/// Columns side by side that are one quantity: one of a scalar, one for each axis of a vector.
#[derive(Debug)]
pub struct Columns {
    /// Their names.
    pub names: &'static [&'static str],
    /// Unit; empty for words, counts and ratios.
    pub unit: &'static str,
    /// Axes in which the numbers are; empty for scalars.
    pub frame: &'static str,
    /// What they are, and when they are empty.
    pub meaning: &'static str,
    of: Of,
}

/// How a value is found and written.
#[derive(Debug)]
enum Of {
    /// Words.
    Words(fn(&RowInputs<'_>) -> String),
    /// Numbers with so many decimals, one for each name; empty cells where there are none.
    Numbers(usize, fn(&RowInputs<'_>) -> Option<Vec<f64>>),
}

/// A value in a row.
#[derive(Debug, PartialEq)]
pub enum Cell {
    /// There is none.
    Empty,
    /// Words.
    Words(String),
    /// A number and its decimals.
    Number(f64, usize),
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Empty => serializer.serialize_none(),
            Self::Words(words) => serializer.serialize_str(words),
            Self::Number(value, digits) => serializer.collect_str(&format_args!("{value:.digits$}")),
        }
    }
}

impl Columns {
    fn cells(&self, row: &RowInputs<'_>) -> Vec<Cell> {
        let (digits, numbers) = match self.of {
            Of::Words(of) => {
                let words = of(row);
                return vec![if words.is_empty() { Cell::Empty } else { Cell::Words(words) }];
            }
            Of::Numbers(digits, of) => (digits, of(row)),
        };
        let cell = |index| match &numbers {
            Some(numbers) => numbers.get(index).map_or(Cell::Empty, |value| Cell::Number(*value, digits)),
            None => Cell::Empty,
        };
        (0..self.names.len()).map(cell).collect()
    }
}

/// The names, in the order of the file.
pub fn names() -> impl Iterator<Item = &'static str> {
    COLUMNS.iter().flat_map(|columns| columns.names).copied()
}

/// The values of a second, in the order of [`names`].
pub fn cells(row: &RowInputs<'_>) -> Vec<Cell> {
    COLUMNS.iter().flat_map(|columns| columns.cells(row)).collect()
}

const fn words(
    names: &'static [&'static str],
    meaning: &'static str,
    of: fn(&RowInputs<'_>) -> String,
) -> Columns {
    Columns { names, unit: "", frame: "", meaning, of: Of::Words(of) }
}

const fn numbers(
    names: &'static [&'static str],
    (unit, frame): (&'static str, &'static str),
    meaning: &'static str,
    digits: usize,
    of: fn(&RowInputs<'_>) -> Option<Vec<f64>>,
) -> Columns {
    Columns { names, unit, frame, meaning, of: Of::Numbers(digits, of) }
}

fn flag(is_so: bool) -> Option<Vec<f64>> {
    Some(vec![f64::from(u8::from(is_so))])
}

fn one(value: impl Into<f64>) -> Option<Vec<f64>> {
    Some(vec![value.into()])
}

fn scaled<const N: usize>(values: [f64; N], of: impl Fn(f64) -> f64) -> Option<Vec<f64>> {
    Some(values.map(of).to_vec())
}

/// The two axes across a direction.
fn across([x, y, _]: &Vector) -> [f64; 2] {
    [*x, *y]
}

fn wide<const N: usize>(values: [f32; N]) -> [f64; N] {
    values.map(f64::from)
}

/// What came of looking for the Earth, in a word.
fn earth_word(status: EarthStatus) -> &'static str {
    use fsw_core::earth::FitError;
    match status {
        EarthStatus::NotLooked => "not-looked",
        EarthStatus::Dark => "dark",
        EarthStatus::Faint => "faint",
        EarthStatus::Found => "found",
        EarthStatus::Refused(FitError::TooFewPoints) => "too-few-points",
        EarthStatus::Refused(FitError::NoConsensus) => "no-consensus",
        EarthStatus::Refused(FitError::ShortArc) => "short-arc",
        EarthStatus::Refused(FitError::Degenerate) => "degenerate",
        EarthStatus::Refused(FitError::Uncertain) => "uncertain",
    }
}

fn source_word(source: RateSource) -> &'static str {
    match source {
        RateSource::Streaks => "streaks",
        RateSource::Images => "images",
        RateSource::Both => "streaks+images",
    }
}

const STAR_PATH: &str = "star path";
const EARTH_PATH: &str = "Earth path";
const ICRS: &str = "ICRS, geocentric";
const RAC: &str = "true radial, along, cross";

/// Every column.
pub const COLUMNS: &[Columns] = &[
    numbers(&["cycle"], ("", ""), "number of the second, from 0", 0, |of| one(of.second.cycle)),
    numbers(
        &["t_s"],
        ("s", ""),
        "instant of the image by the sensor: TT since J2000.0; empty while its clock has not given it",
        3,
        |of| one(of.second.report.instant_us? as f64 * 1e-6),
    ),
    words(
        &["mode"],
        "mode in which the second was spent: self-test, acquisition, tracking, eclipse, sun-outage, safe, commanded-safe",
        |of| word(of.second.report.mode).into(),
    ),
    words(&["expected_mode"], "mode that the true geometry asks for", |of| {
        word(expected_mode(of.second.judged)).into()
    }),
    numbers(
        &["sensor_state"],
        ("", ""),
        "true geometry, thesis table 8.1: 0 Earth and stars seen, 1 Sun in the Earth path, 2 no lit limb on the detector, \
         3 Sun in the star path, 4 the same with its image on the Earth's",
        0,
        |of| one(of.second.truth.state as u8),
    ),
    numbers(
        &["lit_limb_deg"],
        ("deg", ""),
        "true lit limb on the detector, azimuth about the centre",
        1,
        |of| one(of.second.truth.lit_limb_deg),
    ),
    words(
        &["status"],
        "what came of the stars: self-test-passed, identified, searching, not-identified, too-fast, tracked, lost, \
         blinded, waiting; detector-fault and image-refused come before them",
        |of| status_word(of.second.report).into(),
    ),
    words(
        &["earth_status"],
        "what came of looking for the Earth: not-looked, dark, faint, found, or why it was refused: too-few-points, \
         no-consensus, short-arc, degenerate, uncertain",
        |of| earth_word(of.second.report.earth_status).into(),
    ),
    numbers(&["stars"], ("", ""), "stars recognised", 0, |of| one(of.second.judged.stars)),
    numbers(&["detections"], ("", ""), "star-like spots, or streaks, in the image or its windows", 0, |of| {
        one(of.second.judged.detections)
    }),
    numbers(&["limb_points"], ("", ""), "limb points used", 0, |of| one(of.second.judged.limb_points)),
    numbers(
        &["true_qx", "true_qy", "true_qz", "true_qw"],
        ("", "ICRS to star path"),
        "true attitude, quaternion, scalar last",
        9,
        |of| Some(of.second.truth.quaternion.to_vec()),
    ),
    numbers(
        &["qx", "qy", "qz", "qw"],
        ("", "ICRS to star path"),
        "attitude, quaternion, scalar last; empty without one. Of a search that took several seconds it is that of \
         its image",
        9,
        |of| Some(wide(of.second.report.attitude?.quaternion).to_vec()),
    ),
    numbers(
        &["attitude_error_x_arcsec", "attitude_error_y_arcsec", "attitude_error_z_arcsec"],
        ("arcsec", STAR_PATH),
        "error of the attitude, rotation vector, at the instant of its image",
        3,
        |of| scaled(of.second.judged.attitude_rad?.error, arcsec),
    ),
    numbers(
        &["attitude_sigma_x_arcsec", "attitude_sigma_y_arcsec", "attitude_sigma_z_arcsec"],
        ("arcsec", STAR_PATH),
        "reported standard deviation of the attitude",
        3,
        |of| scaled(of.second.judged.attitude_rad?.sigma, arcsec),
    ),
    numbers(&["true_x_km", "true_y_km", "true_z_km"], ("km", ICRS), "true position", 6, |of| {
        Some(of.second.truth.position_km.to_vec())
    }),
    numbers(&["true_vx_km_s", "true_vy_km_s", "true_vz_km_s"], ("km/s", ICRS), "true velocity", 9, |of| {
        Some(of.second.truth.velocity_km_s.to_vec())
    }),
    numbers(&["x_km", "y_km", "z_km"], ("km", ICRS), "position; empty without an orbit", 6, |of| {
        Some(of.second.report.orbit?.position_km.to_vec())
    }),
    numbers(
        &["vx_km_s", "vy_km_s", "vz_km_s"],
        ("km/s", ICRS),
        "velocity; empty without an orbit",
        9,
        |of| Some(of.second.report.orbit?.velocity_km_s.to_vec()),
    ),
    numbers(
        &["sigma_x_km", "sigma_y_km", "sigma_z_km"],
        ("km", ICRS),
        "reported standard deviation of the position",
        6,
        |of| Some(wide(of.second.report.orbit?.sigma_position_km).to_vec()),
    ),
    numbers(
        &["sigma_vx_km_s", "sigma_vy_km_s", "sigma_vz_km_s"],
        ("km/s", ICRS),
        "reported standard deviation of the velocity",
        9,
        |of| Some(wide(of.second.report.orbit?.sigma_velocity_km_s).to_vec()),
    ),
    numbers(
        &["position_error_radial_km", "position_error_along_km", "position_error_cross_km"],
        ("km", RAC),
        "error of the position",
        6,
        |of| Some(of.second.judged.orbit?.position_km.axes.error.to_vec()),
    ),
    numbers(
        &["velocity_error_radial_m_s", "velocity_error_along_m_s", "velocity_error_cross_m_s"],
        ("m/s", RAC),
        "error of the velocity",
        5,
        |of| scaled(of.second.judged.orbit?.velocity_km_s.axes.error, |error| 1e3 * error),
    ),
    numbers(
        &["earth_error_x_deg", "earth_error_y_deg"],
        ("deg", EARTH_PATH),
        "error of the direction to the Earth's centre across it, along x and y as nearly as they are across it; empty \
         where the Earth was not found",
        6,
        |of| scaled(across(&of.second.judged.earth?.direction_rad.axes.error), f64::to_degrees),
    ),
    numbers(
        &["earth_sigma_deg"],
        ("deg", ""),
        "reported standard deviation of that direction, the greater of the two",
        6,
        |of| one(of.second.judged.earth?.sigma_rad.to_degrees()),
    ),
    numbers(&["distance_error_km"], ("km", ""), "error of the distance of the Earth's centre", 4, |of| {
        one(of.second.judged.earth?.distance_km)
    }),
    numbers(&["distance_sigma_km"], ("km", ""), "its reported standard deviation", 4, |of| {
        one(of.second.judged.earth?.sigma_km)
    }),
    numbers(&["limb_inliers"], ("", ""), "limb points on which the centre rests", 0, |of| {
        one(of.second.report.earth?.inliers)
    }),
    numbers(&["limb_arc_deg"], ("deg", ""), "arc that these span about the centre", 3, |of| {
        one(of.second.report.earth?.arc_deg)
    }),
    numbers(&["limb_rms_px"], ("px", ""), "rms of their distances from the fitted limb", 3, |of| {
        one(of.second.report.earth?.rms_px)
    }),
    numbers(
        &["limb_height_km", "limb_height_sigma_km"],
        ("km", ""),
        "estimated departure of the limb's height from the parameter, and its standard deviation",
        4,
        |of| Some(of.second.judged.orbit?.limb_height_km.to_vec()),
    ),
    numbers(
        &["nis"],
        ("", ""),
        "normalised innovation squared of the observation that was taken in the second",
        4,
        |of| one(of.second.judged.orbit?.nis?[0]),
    ),
    numbers(&["since_fix_s"], ("s", ""), "time since the last fix that was accepted", 0, |of| {
        one(of.second.judged.orbit?.since_fix_s)
    }),
    numbers(&["settled"], ("", ""), "1: the orbit filter has converged, else 0", 0, |of| {
        flag(of.second.judged.orbit?.settled)
    }),
    words(&["events"], "what happened, separated by semicolons", |of| {
        of.second.report.events.iter().map(events::words).collect::<Vec<_>>().join("; ")
    }),
    words(&["faults"], "what the scenario breaks in this second", |of| {
        faults::words(of.second.faults, of.second.cycle)
    }),
    numbers(
        &["rate_error_x_arcsec_s", "rate_error_y_arcsec_s", "rate_error_z_arcsec_s"],
        ("arcsec/s", STAR_PATH),
        "error of the attitude filter's rate; empty without one",
        3,
        |of| scaled(of.second.judged.rate_rad_s?, arcsec),
    ),
    numbers(
        &["gyro_x_deg_s", "gyro_y_deg_s", "gyro_z_deg_s"],
        ("deg/s", EARTH_PATH),
        "reading of the gyro; empty where there is none or its range is exceeded",
        4,
        |of| scaled(wide(of.second.rate?.rad_s), f64::to_degrees),
    ),
    numbers(
        &["magnetometer_x_ut", "magnetometer_y_ut", "magnetometer_z_ut"],
        ("uT", EARTH_PATH),
        "reading of the magnetometer; empty where there is none or its range is exceeded",
        4,
        |of| Some(wide(of.second.field?.ut).to_vec()),
    ),
    numbers(
        &["true_rate_x_deg_s", "true_rate_y_deg_s", "true_rate_z_deg_s"],
        ("deg/s", STAR_PATH),
        "true rate against the stars",
        6,
        |of| scaled(of.second.truth.rate_rad_s, f64::to_degrees),
    ),
    numbers(
        &["rate_x_deg_s", "rate_y_deg_s", "rate_z_deg_s"],
        ("deg/s", STAR_PATH),
        "rate found without an attitude; empty without one",
        6,
        |of| scaled(wide(of.second.report.rate?.rad_s), f64::to_degrees),
    ),
    numbers(
        &["rate_sigma_x_deg_s", "rate_sigma_y_deg_s", "rate_sigma_z_deg_s"],
        ("deg/s", STAR_PATH),
        "its reported standard deviation",
        6,
        |of| scaled(wide(of.second.report.rate?.sigma_rad_s), f64::to_degrees),
    ),
    words(&["rate_source"], "on what it rests: streaks, images, streaks+images", |of| {
        of.second.report.rate.map_or(String::new(), |rate| source_word(rate.source).into())
    }),
    numbers(&["rate_either_sense"], ("", ""), "1: it may as well be the opposite one, else 0", 0, |of| {
        flag(of.second.report.rate?.either_sense)
    }),
    numbers(&["rate_error_percent"], ("%", ""), "error of its size", 4, |of| {
        one(100.0 * of.second.judged.turning?.size)
    }),
    numbers(&["rate_axis_error_deg"], ("deg", ""), "error of its axis", 4, |of| {
        one(of.second.judged.turning?.axis_deg)
    }),
    numbers(
        &["filtered_error_x_arcsec", "filtered_error_y_arcsec", "filtered_error_z_arcsec"],
        ("arcsec", STAR_PATH),
        "error of the filtered attitude; empty in a second whose image was not taken into the filter",
        3,
        |of| scaled(of.second.judged.filtered_rad?.error, arcsec),
    ),
    numbers(
        &["filtered_sigma_x_arcsec", "filtered_sigma_y_arcsec", "filtered_sigma_z_arcsec"],
        ("arcsec", STAR_PATH),
        "its reported standard deviation",
        3,
        |of| scaled(of.second.judged.filtered_rad?.sigma, arcsec),
    ),
    words(
        &["activity"],
        "what was done with the second: waiting, self-test, star-search, streak-search, star-tracking, propagation",
        |of| activity_word(of.second.report.activity).into(),
    ),
    words(&["reported_faults"], "faults that the sensor reports, separated by semicolons", |of| {
        fault_words(of.second.report)
    }),
    numbers(&["format_version"], ("", ""), "version of this table", 0, |_| one(VERSION)),
    numbers(&["mode_right"], ("", ""), "1: the mode is as the geometry says, else 0", 0, |of| {
        flag(of.mode_right)
    }),
    numbers(
        &["filtered_qx", "filtered_qy", "filtered_qz", "filtered_qw"],
        ("", "ICRS to star path"),
        "filtered attitude, quaternion, scalar last",
        9,
        |of| Some(wide(of.second.report.filtered?.quaternion).to_vec()),
    ),
    numbers(
        &["position_sigma_radial_km", "position_sigma_along_km", "position_sigma_cross_km"],
        ("km", RAC),
        "standard deviation of the position, of the reported covariance",
        6,
        |of| Some(of.second.judged.orbit?.position_km.axes.sigma.to_vec()),
    ),
    numbers(
        &["velocity_sigma_radial_m_s", "velocity_sigma_along_m_s", "velocity_sigma_cross_m_s"],
        ("m/s", RAC),
        "standard deviation of the velocity, of the reported covariance",
        5,
        |of| scaled(of.second.judged.orbit?.velocity_km_s.axes.sigma, |sigma| 1e3 * sigma),
    ),
    numbers(
        &[
            "position_correlation_radial_along",
            "position_correlation_radial_cross",
            "position_correlation_along_cross",
        ],
        ("", RAC),
        "reported correlations of the position's errors",
        6,
        |of| Some(of.second.judged.orbit?.position_km.correlation.to_vec()),
    ),
    numbers(
        &["position_nees", "velocity_nees"],
        ("", ""),
        "normalised error squared of position and velocity by the reported covariance, three degrees of freedom each",
        4,
        |of| of.second.judged.orbit.map(|orbit| vec![orbit.position_km.nees(), orbit.velocity_km_s.nees()]),
    ),
    numbers(&["nis_freedom"], ("", ""), "degrees of freedom of `nis`", 0, |of| {
        one(of.second.judged.orbit?.nis?[1])
    }),
    numbers(
        &["semi_major_axis_km"],
        ("km", ICRS),
        "semi-major axis of the orbit, osculating; empty without an orbit, and for an open one",
        4,
        |of| one(of.second.report.orbit?.elements?.semi_major_axis_km),
    ),
    numbers(&["eccentricity"], ("", ICRS), "its eccentricity", 8, |of| {
        one(of.second.report.orbit?.elements?.eccentricity)
    }),
    numbers(
        &["inclination_deg", "node_deg", "perigee_deg", "true_anomaly_deg"],
        ("deg", ICRS),
        "inclination, right ascension of the ascending node, argument of perigee and true anomaly; where there is no \
         node or no perigee its angle is 0",
        6,
        |of| {
            let of = of.second.report.orbit?.elements?;
            let angles_rad = [of.inclination_rad, of.node_rad, of.perigee_rad, of.anomaly_rad];
            scaled(wide(angles_rad), f64::to_degrees)
        },
    ),
    numbers(
        &["lvlh_qx", "lvlh_qy", "lvlh_qz", "lvlh_qw"],
        ("", "LVLH to star path"),
        "attitude against local vertical and horizontal, quaternion, scalar last; empty without attitude and orbit",
        9,
        |of| Some(wide(of.second.report.local?.quaternion).to_vec()),
    ),
    numbers(
        &["nadir_deg", "yaw_deg"],
        ("deg", ""),
        "from the Earth path's line of sight to the Earth's centre; about the vertical, from the flight's direction, to \
         the Earth path's x axis",
        5,
        |of| {
            let local = of.second.report.local?;
            scaled(wide([local.nadir_rad, local.yaw_rad]), f64::to_degrees)
        },
    ),
    numbers(
        &["misalignment_x_arcsec", "misalignment_y_arcsec", "misalignment_z_arcsec"],
        ("arcsec", "Earth path"),
        "by what the Earth path is turned against the mounting of the parameters; 0 where it is not estimated",
        4,
        |of| scaled(wide(of.second.report.orbit?.misalignment_rad), arcsec),
    ),
    numbers(
        &["misalignment_sigma_x_arcsec", "misalignment_sigma_y_arcsec", "misalignment_sigma_z_arcsec"],
        ("arcsec", "Earth path"),
        "its standard deviation",
        4,
        |of| scaled(wide(of.second.report.orbit?.misalignment_sigma_rad), arcsec),
    ),
    words(
        &["path_shut"],
        "path that was to be shut against the Sun: star, earth; empty where both were open",
        |of| shut_word(of.second.report).into(),
    ),
    numbers(
        &["next_state"],
        ("", ""),
        "next sensor_state as the sensor foresees it; empty where no change is foreseen within a revolution, or \
         attitude or orbit are not known",
        0,
        |of| one(of.second.report.next_state?.state as u8),
    ),
    numbers(&["next_state_in_s"], ("s", ""), "time until then", 0, |of| {
        one(of.second.report.next_state?.in_s)
    }),
    numbers(&["next_state_sigma_s"], ("s", ""), "its standard deviation", 2, |of| {
        one(of.second.report.next_state?.sigma_s)
    }),
    numbers(
        &["next_state_lasts_s"],
        ("s", ""),
        "how long it lasts; empty where its end is not foreseen",
        0,
        |of| one(of.second.report.next_state?.lasts_s?),
    ),
    numbers(
        &["exposure_s"],
        ("s", ""),
        "exposure that the image was asked for with; empty where the second needed no image",
        4,
        |of| one(f64::from(of.second.report.exposure_us?) * 1e-6),
    ),
    numbers(
        &["magnetometer_zero_x_ut", "magnetometer_zero_y_ut", "magnetometer_zero_z_ut"],
        ("uT", EARTH_PATH),
        "zero of the magnetometer as stars and orbit have shown it; empty where it was not asked or gave no reading",
        3,
        |of| Some(wide(of.second.report.magnetometer?.zero_ut).to_vec()),
    ),
    numbers(&["magnetometer_zero_sigma_ut"], ("uT", ""), "standard deviation of its axes", 3, |of| {
        one(of.second.report.magnetometer?.zero_sigma_ut)
    }),
    words(
        &["magnetometer_used"],
        "true where the attitude of the second rests on the magnetometer; empty where it was not asked",
        |of| of.second.report.magnetometer.map_or(String::new(), |report| report.used.to_string()),
    ),
    numbers(
        &["earth_sigma_x_deg", "earth_sigma_y_deg"],
        ("deg", EARTH_PATH),
        "standard deviation of the direction to the Earth's centre along the axes of its error, of the reported \
         covariance",
        6,
        |of| scaled(across(&of.second.judged.earth?.direction_rad.axes.sigma), f64::to_degrees),
    ),
    numbers(&["earth_correlation"], ("", EARTH_PATH), "correlation of these two", 4, |of| {
        one(of.second.judged.earth?.direction_rad.correlation[0])
    }),
    words(
        &["earth_path_clear"],
        "true where the Earth path's filter was to be out of the way, else false",
        |of| of.second.report.earth_path_clear.to_string(),
    ),
    numbers(
        &["earth_path_stars"],
        ("", ""),
        "stars seen through the Earth path, its filter out of the way, that do not contradict each other; empty \
         where none were looked for",
        0,
        |of| one(of.second.report.earth_path_stars?),
    ),
    numbers(
        &["told_state"],
        ("", ""),
        "sensor_state as the sensor tells it, by attitude, time, orbit and what is seen of the limb; empty where these do \
         not tell",
        0,
        |of| one(of.second.report.state? as u8),
    ),
];
