//! A second as the page plots it: a JSON array of values, one for each name of [`names`].
//!
//! In: the cells of a second in flight, or a line of a recorded `cycles.csv`. Out: the same text for both.
//! The columns keep the names, units and frames of `cycles.csv` ([`crate::formats::cycles::columns`]); three
//! more are made here.

use crate::formats::cycles::columns::{self, Cell};
use std::fmt::Write as _;
use std::sync::LazyLock;

/// Columns of `cycles.csv` that the page shows.
const COLUMNS: [&str; 32] = [
    "cycle",
    "mode",
    "expected_mode",
    "mode_right",
    "sensor_state",
    "lit_limb_deg",
    "status",
    "earth_status",
    "stars",
    "detections",
    "limb_points",
    "attitude_error_x_arcsec",
    "attitude_error_y_arcsec",
    "attitude_error_z_arcsec",
    "attitude_sigma_x_arcsec",
    "attitude_sigma_y_arcsec",
    "attitude_sigma_z_arcsec",
    "position_error_radial_km",
    "position_error_along_km",
    "position_error_cross_km",
    "position_sigma_radial_km",
    "position_sigma_along_km",
    "position_sigma_cross_km",
    "velocity_error_radial_m_s",
    "velocity_error_along_m_s",
    "velocity_error_cross_m_s",
    "rate_x_deg_s",
    "rate_y_deg_s",
    "rate_z_deg_s",
    "events",
    "faults",
    "reported_faults",
];

/// What is made here: the point below the satellite (geocentric latitude, east longitude), and the host's time
/// for the second, world and flight code together; none of a recorded run.
const MADE: [&str; 3] = ["latitude_deg", "longitude_deg", "host_ms"];

/// Where each of the columns stands in a row, where it does.
pub type Places = [Option<usize>; COLUMNS.len()];

/// Places of the columns in a second in flight.
static IN_FLIGHT: LazyLock<Places> = LazyLock::new(|| places(columns::names()));

/// The values' names, in their order.
pub fn names() -> impl Iterator<Item = &'static str> {
    COLUMNS.into_iter().chain(MADE)
}

/// Places of the columns in rows with this header.
pub fn places<'a>(header: impl Iterator<Item = &'a str>) -> Places {
    let header: Vec<&str> = header.collect();
    COLUMNS.map(|name| header.iter().position(|column| *column == name))
}

/// The values of a second in flight from all its `cells`.
pub fn of_cells(cells: &[Cell], place_deg: [f64; 2], host_ms: f64) -> String {
    let text = |place: Option<usize>| match place.and_then(|place| cells.get(place)) {
        Some(Cell::Words(words)) => json_words(words),
        Some(Cell::Number(value, digits)) if value.is_finite() => format!("{value:.digits$}"),
        _ => "null".to_owned(),
    };
    array(IN_FLIGHT.iter().map(|place| text(*place)), place_deg, Some(host_ms))
}

/// The values of a line of a recorded run.
pub fn of_fields(fields: &csv::StringRecord, places: &Places, place_deg: [f64; 2]) -> String {
    let text = |place: Option<usize>| match place.and_then(|place| fields.get(place)) {
        None | Some("") => "null".to_owned(),
        // What JSON reads as a number is one.
        Some(field) if serde_json::from_str::<f64>(field).is_ok() => field.to_owned(),
        Some(field) => json_words(field),
    };
    array(places.iter().map(|place| text(*place)), place_deg, None)
}

fn array(
    values: impl Iterator<Item = String>,
    [latitude, longitude]: [f64; 2],
    host_ms: Option<f64>,
) -> String {
    let mut row = values.fold("[".to_owned(), |row, value| row + &value + ",");
    let _ = write!(row, "{latitude:.3},{longitude:.3},");
    match host_ms {
        Some(host_ms) => {
            let _ = write!(row, "{host_ms:.2}]");
        }
        None => row.push_str("null]"),
    }
    row
}

fn json_words(words: &str) -> String {
    serde_json::Value::from(words).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn a_second_in_flight_and_its_line_give_the_same_values() {
        let names: Vec<&str> = columns::names().collect();
        let cells: Vec<Cell> = names
            .iter()
            .map(|name| match *name {
                "mode" => Cell::Words("tracking".into()),
                "events" => Cell::Words("to safe: \"faults\"".into()),
                "attitude_error_x_arcsec" => Cell::Number(-1.2345, 3),
                "attitude_sigma_x_arcsec" => Cell::Number(f64::NAN, 3),
                _ => Cell::Empty,
            })
            .collect();
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        writer.serialize(&cells).unwrap();
        let line = writer.into_inner().unwrap();
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&line[..]);
        let fields = reader.records().next().unwrap().unwrap();
        let flown: Vec<Value> = serde_json::from_str(&of_cells(&cells, [1.0, -2.0], 3.5)).unwrap();
        let recorded = of_fields(&fields, &places(names.iter().copied()), [1.0, -2.0]);
        let recorded: Vec<Value> = serde_json::from_str(&recorded).unwrap();
        let of =
            |values: &[Value], name: &str| values[super::names().position(|n| n == name).unwrap()].clone();
        for name in ["mode", "events", "attitude_error_x_arcsec", "stars", "latitude_deg"] {
            assert_eq!(of(&flown, name), of(&recorded, name), "{name}");
        }
        assert_eq!(of(&flown, "attitude_error_x_arcsec"), json!(-1.234));
        assert_eq!(of(&flown, "attitude_sigma_x_arcsec"), Value::Null);
        assert_eq!((of(&flown, "host_ms"), of(&recorded, "host_ms")), (json!(3.5), Value::Null));
        assert_eq!((flown.len(), recorded.len()), (super::names().count(), super::names().count()));
    }

    #[test]
    fn every_column_is_one_of_cycles_csv() {
        assert!(IN_FLIGHT.iter().all(Option::is_some));
    }
}
