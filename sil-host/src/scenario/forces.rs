//! The `[forces]` of a scenario: what pulls and pushes the satellite, and how the Earth stands.
//!
//! | key | default | |
//! |---|---|---|
//! | `gravity_degree`, `gravity_order` | 20, degree | of the field EGM2008, 0 to 36; about Moon and Mars 12, 0 to 12 |
//! | `sun`, `moon`, `drag`, `radiation_pressure` | true | whether they act; `moon` is the Earth about the Moon, there is none about Mars, and drag about the Earth alone |
//! | `mass_kg`, `drag_area_m2`, `cd` | 100, 1, 2.2 | for the air |
//! | `radiation_area_m2`, `cr` | 1, 1.3 | for sunlight |
//! | `earth_orientation_file` | none: UT1 = UTC, pole at rest | IERS C04, from the scenario's folder |

use super::body::{of_the_earth_alone, switched_on};
use super::text::Text;
use crate::error::HostError;
use crate::world::orbit::OrbitError;
use crate::world::orbit::forces::{Forces, Satellite};
use crate::world::orbit::gravity;
use crate::world::time::earth_orientation::EarthOrientation;
use fsw_core::orbit::body::CentralBody;
use serde::Deserialize;
use toml::Spanned;

const MASS_KG: (f64, f64) = (0.1, 1e6);
const AREA_M2: (f64, f64) = (0.0, 1e4);
const COEFFICIENT: (f64, f64) = (0.0, 10.0);

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawForces {
    gravity_degree: Option<Spanned<i64>>,
    gravity_order: Option<Spanned<i64>>,
    sun: Option<bool>,
    moon: Option<Spanned<bool>>,
    drag: Option<Spanned<bool>>,
    radiation_pressure: Option<bool>,
    mass_kg: Option<Spanned<f64>>,
    drag_area_m2: Option<Spanned<f64>>,
    cd: Option<Spanned<f64>>,
    radiation_area_m2: Option<Spanned<f64>>,
    cr: Option<Spanned<f64>>,
    earth_orientation_file: Option<Spanned<String>>,
}

/// The forces about `body` of a run from `start_us` over `duration_s`.
pub(super) fn read(
    text: &Text<'_>,
    raw: &RawForces,
    body: CentralBody,
    start_us: i64,
    duration_s: u32,
) -> Result<Forces, HostError> {
    let default = Forces::about(body);
    let moon = switched_on(&raw.moon).filter(|_| !default.moon);
    let file = raw.earth_orientation_file.as_ref().map(|file| file.span().start);
    let asked = [
        ("forces.drag", switched_on(&raw.drag)),
        ("forces.moon", moon),
        ("forces.earth_orientation_file", file),
    ];
    of_the_earth_alone(text, body, &asked)?;
    let (key, most) = ("forces.gravity_degree", gravity::largest(body) as i64);
    let degree = text.whole(key, raw.gravity_degree.as_ref(), default.gravity_degree as i64, (0, most))?;
    let order = text.whole("forces.gravity_order", raw.gravity_order.as_ref(), degree, (0, degree))?;
    let number = |key: &str, value: &Option<Spanned<f64>>, default, range| {
        text.number(&format!("forces.{key}"), value.as_ref(), default, range)
    };
    let Satellite { mass_kg, drag_area_m2, cd, radiation_area_m2, cr } = default.satellite;
    let satellite = Satellite {
        mass_kg: number("mass_kg", &raw.mass_kg, mass_kg, MASS_KG)?,
        drag_area_m2: number("drag_area_m2", &raw.drag_area_m2, drag_area_m2, AREA_M2)?,
        cd: number("cd", &raw.cd, cd, COEFFICIENT)?,
        radiation_area_m2: number("radiation_area_m2", &raw.radiation_area_m2, radiation_area_m2, AREA_M2)?,
        cr: number("cr", &raw.cr, cr, COEFFICIENT)?,
    };
    let orientation = match &raw.earth_orientation_file {
        None => EarthOrientation::default(),
        Some(file) => orientation(text, file, start_us, duration_s)?,
    };
    Ok(Forces {
        body,
        gravity_degree: degree as usize,
        gravity_order: order as usize,
        sun: raw.sun.unwrap_or(default.sun),
        moon: raw.moon.as_ref().map_or(default.moon, |moon| *moon.get_ref()),
        drag: raw.drag.as_ref().map_or(default.drag, |drag| *drag.get_ref()),
        radiation_pressure: raw.radiation_pressure.unwrap_or(default.radiation_pressure),
        satellite,
        orientation,
    })
}

/// Reads a C04 series that covers the run.
fn orientation(
    text: &Text<'_>,
    file: &Spanned<String>,
    start_us: i64,
    duration_s: u32,
) -> Result<EarthOrientation, HostError> {
    let key = "forces.earth_orientation_file";
    let (path, content) = text.file(key, file, "give the path of an IERS C04 series")?;
    let orientation = EarthOrientation::read(&content).map_err(|(line, what)| {
        HostError::input(&path, Some(line), what, "give an IERS C04 series as published")
    })?;
    let end_us = start_us + i64::from(duration_s) * 1_000_000;
    match orientation.missing(start_us, end_us) {
        None => Ok(orientation),
        Some(day_us) => {
            let what = OrbitError::Orientation(day_us).to_string();
            Err(text.fault(file.span().start, key, &what, "give a series that covers the run"))
        }
    }
}
