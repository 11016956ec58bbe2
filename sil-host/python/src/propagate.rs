//! `propagate`: a state carried on by the dynamics that fly.

use crate::arrays::{Numbers, Rows, refused, rows, three};
use fsw_core::orbit::OrbitState;
use pyo3::prelude::*;
use sil_host::cli::dynamics as named;
use sil_host::commands::propagate::{Input, carried};
use sil_host::formats::orbit_state::{StateInput, body as body_named, time_us};

/// What stands where the orbit has left the bounds.
const NOTHING: [f64; 3] = [f64::NAN; 3];

/// A state carried on by the dynamics that fly: what `sextant propagate` answers.
///
/// t_s: time of the state, TT, seconds since J2000.0. r_km, v_km_s: (3,) float64, position and velocity along
/// the ICRS axes. times_s: (m,) float64, the times that are asked for, as t_s, in any order of time.
/// dynamics: kepler (a point mass), j2 (the Earth's field of the second degree, Sun and Moon) or full (the
/// field of the eighth, Sun, Moon, drag and the Sun's light). Drag acts where drag_area_m2 is given, with cd,
/// the Sun's light where srp_area_m2 is, with cr, both with mass_kg; only dynamics="full" has them. body: what
/// the satellite flies about, earth, moon or mars; drag about the Earth alone.
///
/// Returns position and velocity, (m, 3) float64 each, km and km/s. From where the orbit leaves the bounds of
/// the dynamics (about the Earth 5,000 to 600,000 km) rows are NaN. Raises ValueError for what is no state of
/// a satellite.
#[pyfunction]
#[pyo3(signature = (
    t_s, r_km, v_km_s, times_s, *,
    body="earth", dynamics="full", mass_kg=0.0, drag_area_m2=0.0, cd=0.0, srp_area_m2=0.0, cr=0.0
))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn propagate(
    py: Python<'_>,
    t_s: f64,
    r_km: Numbers<'_>,
    v_km_s: Numbers<'_>,
    times_s: Numbers<'_>,
    body: &str,
    dynamics: &str,
    mass_kg: f64,
    drag_area_m2: f64,
    cd: f64,
    srp_area_m2: f64,
    cr: f64,
) -> PyResult<(Rows, Rows)> {
    let body = body_named(body).map_err(refused)?;
    let state = StateInput { t_s, r_km: three("r_km", &r_km)?, v_km_s: three("v_km_s", &v_km_s)?, body };
    let input = Input { state, mass_kg, drag_area_m2, srp_area_m2, cd, cr };
    let forces = input.forces(named(dynamics).map_err(refused)?).map_err(refused)?;
    let times = times_s.as_array().iter().map(|t_s| time_us(*t_s)).collect::<Result<Vec<_>, _>>();
    let times = times.map_err(|what| refused(format!("times_s: {what}")))?;
    let first = state.state().map_err(refused)?;
    let states: Vec<Option<OrbitState>> = py.detach(|| {
        let mut last = Some(first);
        let next = times.into_iter().map(|to_us| {
            last = last.and_then(|state| carried(&state, to_us, &forces).ok());
            last
        });
        next.collect()
    });
    let of = |pick: fn(&OrbitState) -> [f64; 3]| {
        rows(py, states.iter().map(|state| state.as_ref().map_or(NOTHING, pick)))
    };
    Ok((of(|state| state.position_km.into())?, of(|state| state.velocity_km_s.into())?))
}
