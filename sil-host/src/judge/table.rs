//! Every figure of a run that can be limited, declared once: its key, unit, side, words, and where it is
//! found.

use super::figures::Figures;
use super::series::Statistics;
use serde::Serialize;

/// On which side of its value a limit is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The figure must not be less.
    AtLeast,
    /// The figure must not be more.
    AtMost,
}

/// A figure on which a limit can be set.
#[derive(Debug)]
pub struct Figure {
    /// Key in the scenario's `[limits]`.
    pub key: &'static str,
    /// What it is, for people.
    pub words: &'static str,
    /// Its unit; empty for shares, which are shown in percent.
    pub unit: &'static str,
    /// The side on which it is kept.
    pub side: Side,
    /// Values a limit may take.
    pub range: (f64, f64),
    /// The figure; `None` where the run did not yield it.
    pub of: fn(&Figures) -> Option<f64>,
}

impl PartialEq for Figure {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}

/// Unit of a probability.
pub const PROBABILITY: &str = "probable";

const fn share(key: &'static str, words: &'static str, of: fn(&Figures) -> Option<f64>) -> Figure {
    Figure { key, words, unit: "", side: Side::AtLeast, range: (0.0, 1.0), of }
}

const fn at_most(
    key: &'static str,
    words: &'static str,
    (unit, most): (&'static str, f64),
    of: fn(&Figures) -> Option<f64>,
) -> Figure {
    Figure { key, words, unit, side: Side::AtMost, range: (0.0, most), of }
}

const fn consistency(key: &'static str, words: &'static str, of: fn(&Figures) -> Option<f64>) -> Figure {
    Figure { key, words, unit: PROBABILITY, side: Side::AtLeast, range: (0.0, 1.0), of }
}

fn across(axes: Option<[f64; 3]>) -> Option<f64> {
    axes.map(|[x, y, _]| x.abs().max(y.abs()))
}

fn jump(of: Option<&Statistics>) -> Option<f64> {
    Some(of?.jump_sigma?.0)
}

/// What every quantity can be limited in: error and sigma of the last orbit; jump, bias and NEES of the run.
macro_rules! of_quantity {
    ($key:literal, $words:literal, $unit:literal, $suffix:literal) => {
        [
            at_most(
                concat!($key, "_95_", $suffix),
                concat!($words, ": error of the last orbit, 95 %"),
                ($unit, 1e6),
                |of| Some(of.last_orbit($key)?.error_95),
            ),
            at_most(
                concat!($key, "_sigma_", $suffix),
                concat!($words, ": reported sigma of the last orbit, rms"),
                ($unit, 1e6),
                |of| Some(of.last_orbit($key)?.sigma),
            ),
            at_most(
                concat!($key, "_jump_sigma"),
                concat!($words, ": largest jump in a second"),
                ("sigma", 1e3),
                |of| jump(of.run($key)),
            ),
            at_most(
                concat!($key, "_worst_sigma"),
                concat!($words, ": largest error, of any axis; 0 where none was told"),
                ("sigma", 1e6),
                |of| Some(of.run($key).map_or(0.0, |run| run.largest_sigma)),
            ),
            Figure {
                side: Side::AtMost,
                ..share(
                    concat!($key, "_beyond_4_sigma_share"),
                    concat!($words, ": seconds beyond 4 sigma; 0 where none was told"),
                    |of| Some(of.run($key).map_or(0.0, |run| run.beyond_4_share)),
                )
            },
            at_most(concat!($key, "_bias_sigma"), concat!($words, ": mean error"), ("sigma", 1e3), |of| {
                Some(of.run($key)?.bias_sigma)
            }),
            at_most(
                concat!($key, "_nees"),
                concat!($words, ": NEES over its degrees of freedom (1 for right sigmas)"),
                ("sigma\u{b2}", 1e6),
                |of| Some(of.run($key)?.normalised_square),
            ),
            consistency(
                concat!($key, "_consistency"),
                concat!($words, ": sigmas by NEES, probability"),
                |of| Some(of.run($key)?.consistency),
            ),
        ]
    };
}

static OF_RUN: [Figure; 29] = [
    share("attitude_valid_share", "attitude valid outside Sun states", |of| of.attitude_valid_share),
    share("within_3_sigma_share", "attitude error within 3 reported sigma", |of| of.within_3_sigma_share),
    share("position_within_3_sigma_share", "position error within 3 reported sigma", |of| {
        of.orbit.position_within_3_sigma_share
    }),
    share("mode_share", "mode as the geometry says", |of| of.mode_share),
    share("state_share", "state of the sensor as the geometry says, where it is told", |of| of.state_share),
    share("rate_share", "rate known while no attitude is, outside Sun states", |of| of.rate.share),
    share("rate_within_3_sigma_share", "rate without an attitude within 3 reported sigma", |of| {
        of.rate.within_3_sigma_share
    }),
    at_most("rate_error_percent", "size of a rate without an attitude, median error", ("%", 100.0), |of| {
        of.rate.error_percent
    }),
    at_most("rate_axis_deg", "axis of a rate without an attitude, median error", ("deg", 180.0), |of| {
        of.rate.axis_deg
    }),
    at_most("first_attitude_s", "first attitude", ("s", 1e6), |of| of.first_attitude_s.map(f64::from)),
    at_most("recovery_s", "longest without an attitude outside Sun states", ("s", 1e6), |of| {
        of.recovery_s.map(f64::from)
    }),
    at_most("mode_latest_s", "latest mode after a change of the geometry", ("s", 1e6), |of| {
        of.mode_latest_s.map(f64::from)
    }),
    at_most("mode_changes_10_s", "most changes of the mode within ten seconds", ("changes", 10.0), |of| {
        of.mode_changes_10_s.map(f64::from)
    }),
    share("next_state_share", "next change of state foreseen, while attitude and orbit are known", |of| {
        of.next_state_share
    }),
    at_most("next_state_length_95_s", "length of the state foreseen to 5 s, error, 95 %", ("s", 1e6), |of| {
        of.next_state_length_95_s
    }),
    at_most("settled_s", "orbit filter settled", ("s", 1e6), |of| of.orbit.settled_s.map(f64::from)),
    at_most(
        "filtered_rms_arcsec",
        "filtered attitude error, worst axis across, rms",
        ("arcsec", 1e6),
        |of| across(of.filtered.rms_arcsec),
    ),
    at_most(
        "filtered_bias_arcsec",
        "filtered attitude, bias (mean error), worst axis across",
        ("arcsec", 1e6),
        |of| across(of.filtered.bias_arcsec),
    ),
    at_most(
        "filtered_noise_arcsec",
        "filtered attitude, noise (about the mean error), worst axis across, rms",
        ("arcsec", 1e6),
        |of| across(of.filtered.noise_arcsec),
    ),
    at_most("attitude_rms_arcsec", "attitude error, worst axis across, rms", ("arcsec", 1e6), |of| {
        across(of.attitude.rms_arcsec)
    }),
    at_most(
        "attitude_bias_arcsec",
        "attitude, bias (mean error), worst axis across",
        ("arcsec", 1e6),
        |of| across(of.attitude.bias_arcsec),
    ),
    at_most(
        "attitude_noise_arcsec",
        "attitude, noise (about the mean error), worst axis across, rms",
        ("arcsec", 1e6),
        |of| across(of.attitude.noise_arcsec),
    ),
    at_most("earth_direction_rms_deg", "Earth's direction, rms per axis", ("deg", 180.0), |of| {
        of.earth.direction_rms_deg
    }),
    at_most("earth_distance_rms_km", "Earth's distance, rms", ("km", 1e6), |of| of.earth.distance_rms_km),
    at_most("final_position_km", "3-D position error at the end", ("km", 1e6), |of| {
        of.orbit.final_position_km
    }),
    at_most("last_orbit_position_km", "3-D position error of the last orbit, rms", ("km", 1e6), |of| {
        of.orbit.last_orbit_position_km
    }),
    at_most(
        "last_orbit_position_bounds",
        "3-D position error of the last orbit over the horizon's bound, rms",
        ("bounds", 1e6),
        |of| Some(of.orbit.last_orbit_position_km? / of.orbit.last_orbit_bound_km?),
    ),
    at_most("last_orbit_velocity_m_s", "3-D velocity error of the last orbit, rms", ("m/s", 1e6), |of| {
        of.orbit.last_orbit_velocity_m_s
    }),
    consistency("nis_consistency", "innovations: sigmas by NIS, probability", |of| of.orbit.nis_consistency),
];

/// Numbers that are none: no run may have any.
pub static NOT_FINITE: Figure =
    at_most("not_finite", "seconds with a number that is none", ("s", 0.0), |of| {
        Some(f64::from(of.not_finite))
    });

static OF_QUANTITIES: [[Figure; 8]; 11] = [
    of_quantity!("attitude", "attitude", "arcsec", "arcsec"),
    of_quantity!("filtered", "filtered attitude", "arcsec", "arcsec"),
    of_quantity!("sun_attitude", "attitude carried through the Sun", "arcsec", "arcsec"),
    of_quantity!("rate", "rate without an attitude", "deg/s", "deg_s"),
    of_quantity!("earth_direction", "Earth's direction", "deg", "deg"),
    of_quantity!("earth_distance", "Earth's distance", "km", "km"),
    of_quantity!("position", "position", "km", "km"),
    of_quantity!("velocity", "velocity", "m/s", "m_s"),
    of_quantity!("dark_position", "position in eclipse and Sun", "km", "km"),
    of_quantity!("mounting", "mounting of the paths", "arcsec", "arcsec"),
    of_quantity!("next_state", "next change of state", "s", "s"),
];

/// Every figure that can be limited.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    OF_RUN.iter().chain([&NOT_FINITE]).chain(OF_QUANTITIES.iter().flatten())
}

/// The figure with a key.
pub fn figure(key: &str) -> Option<&'static Figure> {
    figures().find(|figure| figure.key == key)
}
