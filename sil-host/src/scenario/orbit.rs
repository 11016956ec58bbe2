//! The `[orbit]` of a scenario: where the satellite starts, or a file that says where it is. One of these:
//!
//! | keys | |
//! |---|---|
//! | `a_km`, `e`, `i_deg`, `raan_deg`, `argp_deg`, `true_anomaly_deg` | Keplerian elements; all but `a_km` are 0 by default |
//! | `position_km`, `velocity_km_s` | a state |
//! | `tle` | the two lines; their SGP4 state at the start is flown on |
//! | `oem_file` | an Orbit Ephemeris Message as text, which is followed |
//! | `sp3_file`, and `sp3_satellite` where it holds several | a precise orbit, which is followed |
//!
//! Files and a TLE are of the Earth alone. Paths begin at the scenario's folder.

use super::body::of_the_earth_alone;
use super::text::Text;
use crate::error::HostError;
use crate::world::attitude::Vector;
use crate::world::orbit::track::Samples;
use crate::world::orbit::{Forces, OrbitError, TruthOrbit, check_state, oem, sp3, state_of_elements, tle};
use fsw_core::orbit::body::CentralBody;
use serde::Deserialize;
use toml::Spanned;

const ECCENTRICITY: (f64, f64) = (0.0, 0.95);
const INCLINATION_DEG: (f64, f64) = (0.0, 180.0);
const ANGLE_DEG: (f64, f64) = (-360.0, 360.0);
const POSITION_KM: (f64, f64) = (-500_000.0, 500_000.0);
const VELOCITY_KM_S: (f64, f64) = (-12.0, 12.0);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOrbit {
    a_km: Option<Spanned<f64>>,
    e: Option<Spanned<f64>>,
    i_deg: Option<Spanned<f64>>,
    raan_deg: Option<Spanned<f64>>,
    argp_deg: Option<Spanned<f64>>,
    true_anomaly_deg: Option<Spanned<f64>>,
    position_km: Option<Spanned<[f64; 3]>>,
    velocity_km_s: Option<Spanned<[f64; 3]>>,
    tle: Option<Spanned<[Spanned<String>; 2]>>,
    oem_file: Option<Spanned<String>>,
    sp3_file: Option<Spanned<String>>,
    sp3_satellite: Option<Spanned<String>>,
}

/// Where the run starts, and the orbit where a file gives it.
pub(super) struct Start {
    /// Position, ICRS, km.
    pub(super) position_km: Vector,
    /// Velocity, ICRS, km/s.
    pub(super) velocity_km_s: Vector,
    /// The orbit of a file.
    pub(super) track: Option<TruthOrbit>,
}

impl Start {
    fn flown((position_km, velocity_km_s): (Vector, Vector)) -> Self {
        Self { position_km, velocity_km_s, track: None }
    }

    fn followed(track: TruthOrbit) -> Self {
        let (position_km, velocity_km_s) = track.at(0.0);
        Self { position_km, velocity_km_s, track: Some(track) }
    }
}

impl RawOrbit {
    /// The keys that are given: the kind of orbit each belongs to, its name, its place in the text.
    fn given(&self) -> Vec<(&'static str, &'static str, usize)> {
        fn at<T>(value: &Option<Spanned<T>>) -> Option<usize> {
            value.as_ref().map(|value| value.span().start)
        }
        let keys = [
            ("elements", "orbit.a_km", at(&self.a_km)),
            ("elements", "orbit.e", at(&self.e)),
            ("elements", "orbit.i_deg", at(&self.i_deg)),
            ("elements", "orbit.raan_deg", at(&self.raan_deg)),
            ("elements", "orbit.argp_deg", at(&self.argp_deg)),
            ("elements", "orbit.true_anomaly_deg", at(&self.true_anomaly_deg)),
            ("a state", "orbit.position_km", at(&self.position_km)),
            ("a state", "orbit.velocity_km_s", at(&self.velocity_km_s)),
            ("a TLE", "orbit.tle", at(&self.tle)),
            ("an OEM file", "orbit.oem_file", at(&self.oem_file)),
            ("an SP3 file", "orbit.sp3_file", at(&self.sp3_file)),
            ("an SP3 file", "orbit.sp3_satellite", at(&self.sp3_satellite)),
        ];
        keys.into_iter().filter_map(|(kind, key, at)| at.map(|at| (kind, key, at))).collect()
    }
}

/// The start of a run at `start_us` (TT, µs since J2000) over `duration_s`, about the body of the forces.
pub(super) fn read(
    text: &Text<'_>,
    raw: &Spanned<RawOrbit>,
    start_us: i64,
    duration_s: u32,
    forces: &Forces,
) -> Result<Start, HostError> {
    let (orbit, Forces { body, orientation, .. }) = (raw.get_ref(), forces);
    let given = orbit.given();
    let of_the_earth = |(kind, key, at): &(&str, &'static str, usize)| {
        (*key, (!matches!(*kind, "elements" | "a state")).then_some(*at))
    };
    of_the_earth_alone(text, *body, &given.iter().map(of_the_earth).collect::<Vec<_>>())?;
    if let Some((first, _, _)) = given.first()
        && let Some((other, key, at)) = given.iter().find(|(kind, _, _)| kind != first)
    {
        let what = format!("{first} and {other} exclude each other");
        return Err(text.fault(*at, key, &what, "remove one of them"));
    }
    let follow = |key: &str, file: &Spanned<String>, samples: &Samples| {
        TruthOrbit::along(samples, start_us, duration_s, orientation).map_err(|error| {
            let to_do = match error {
                OrbitError::Span(..) => "move scenario.start or give another file",
                OrbitError::Orientation(_) => "give a series that covers 12 samples before and after the run",
                _ => "give another file",
            };
            text.fault(file.span().start, key, &error.to_string(), to_do)
        })
    };
    if let Some(a_km) = &orbit.a_km {
        elements(text, *body, orbit, a_km).map(Start::flown)
    } else if let (Some(position), Some(velocity)) = (&orbit.position_km, &orbit.velocity_km_s) {
        let r = text.array("orbit.position_km", position, POSITION_KM)?;
        let v = text.array("orbit.velocity_km_s", velocity, VELOCITY_KM_S)?;
        check_state(*body, r, v).map_err(|error| {
            let key = "orbit.velocity_km_s";
            text.fault(velocity.span().start, key, &error.to_string(), "give another orbit")
        })?;
        Ok(Start::flown((r, v)))
    } else if let Some(lines) = &orbit.tle {
        let [first, second] = lines.get_ref();
        let state = tle::state([first.get_ref(), second.get_ref()], start_us, orientation).map_err(
            |(line, what)| {
                let at = [first, second][line.min(1)].span().start;
                text.fault(at, "orbit.tle", &what, "copy both lines whole")
            },
        )?;
        check_state(*body, state.0, state.1).map_err(|error| {
            text.fault(lines.span().start, "orbit.tle", &error.to_string(), "give another orbit")
        })?;
        Ok(Start::flown(state))
    } else if let Some(file) = &orbit.oem_file {
        let key = "orbit.oem_file";
        let (path, content) = text.file(key, file, "give the path of an OEM as text")?;
        let segments = oem::read(&content)
            .map_err(|(line, what)| HostError::input(&path, Some(line), what, "give a CCSDS OEM as text"))?;
        // The segment that carries the run; where none does, the fault of the first.
        let tried: Vec<_> = segments.iter().map(|samples| follow(key, file, samples)).collect();
        let good = tried.iter().position(Result::is_ok).unwrap_or(0);
        tried.into_iter().nth(good).map_or_else(
            || Err(text.fault(file.span().start, key, "holds no segment", "give another file")),
            |track| track.map(Start::followed),
        )
    } else if let Some(file) = &orbit.sp3_file {
        let key = "orbit.sp3_file";
        let (path, content) = text.file(key, file, "give the path of an SP3 file")?;
        let satellite = orbit.sp3_satellite.as_ref().map(|name| name.get_ref().as_str());
        let samples = sp3::read(&content, satellite)
            .map_err(|(line, what)| HostError::input(&path, Some(line), what, "give an SP3 file"))?;
        follow(key, file, &samples).map(Start::followed)
    } else {
        let what = "neither elements nor a state, a TLE or an orbit file";
        let to_do =
            "give a_km and the other elements, or position_km and velocity_km_s, tle, oem_file or sp3_file";
        Err(text.fault(raw.span().start, "orbit", what, to_do))
    }
}

/// The state of Keplerian elements.
fn elements(
    text: &Text<'_>,
    body: CentralBody,
    orbit: &RawOrbit,
    a_km: &Spanned<f64>,
) -> Result<(Vector, Vector), HostError> {
    let a = text.number("orbit.a_km", Some(a_km), 0.0, body.facts().orbit_km.into())?;
    let number =
        |key: &str, value: &Option<Spanned<f64>>, range| text.number(key, value.as_ref(), 0.0, range);
    let e = number("orbit.e", &orbit.e, ECCENTRICITY)?;
    let i = number("orbit.i_deg", &orbit.i_deg, INCLINATION_DEG)?;
    let raan = number("orbit.raan_deg", &orbit.raan_deg, ANGLE_DEG)?;
    let argp = number("orbit.argp_deg", &orbit.argp_deg, ANGLE_DEG)?;
    let anomaly = number("orbit.true_anomaly_deg", &orbit.true_anomaly_deg, ANGLE_DEG)?;
    // What the ranges let through is a fault of eccentricity and axis together.
    let (key, at) = match &orbit.e {
        Some(e) => ("orbit.e", e.span().start),
        None => ("orbit.a_km", a_km.span().start),
    };
    state_of_elements(body, [a, e, i, raan, argp, anomaly])
        .map_err(|error| text.fault(at, key, &error.to_string(), "give another orbit"))
}

#[cfg(test)]
mod tests;
