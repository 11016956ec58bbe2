//! `sil-host propagate`: a state carried on by the flight code's dynamics.
//!
//! In: `{"t_s","r_km","v_km_s"}` and what it flies about ([`crate::formats::orbit_state`]). Drag acts where
//! `"drag_area_m2"` is given, with `"cd"`, the Sun's light where `"srp_area_m2"` is, with `"cr"`, both with
//! `"mass_kg"`; `--dynamics` other than `full` have neither.
//!
//! Out: a line a step, `{"t_s","status","r_km","v_km_s"}`. `status` is `propagated`, or in a last line
//! `out_of_bounds` where the orbit leaves the bounds of the dynamics (about the Earth 5,000 to 600,000 km);
//! position and velocity are then null.

use crate::cli::PropagateArguments;
use crate::error::HostError;
use crate::formats::json;
use crate::formats::orbit_state::StateInput;
use fsw_core::orbit::OrbitState;
use fsw_core::orbit::constants::MICROSECONDS;
use fsw_core::orbit::dynamics::{MAX_SPAN_US, PropagationError};
use fsw_core::orbit::forces::{Dynamics, Forces};
use serde::{Deserialize, Serialize};
use std::fs;
use std::process::ExitCode;

const TO_DO: &str = "give {\"t_s\":..,\"r_km\":[x,y,z],\"v_km_s\":[x,y,z]} and, where they count, body, mass_kg, \
                     drag_area_m2, srp_area_m2, cd, cr";
/// Greatest coefficient times area over mass, m²/kg, that the flight parameters may have.
const MOST_M2_KG: f64 = 10.0;
/// Most states that one call prints.
const MAX_STATES: f64 = 1e7;

/// A state and the satellite, as the file gives them.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// The state.
    #[serde(flatten)]
    pub state: StateInput,
    /// Mass, kg.
    #[serde(default)]
    pub mass_kg: f64,
    /// Area against the air, m²; 0: no drag.
    #[serde(default)]
    pub drag_area_m2: f64,
    /// Area against the Sun's light, m²; 0: no pressure of it.
    #[serde(default)]
    pub srp_area_m2: f64,
    /// Drag coefficient.
    #[serde(default)]
    pub cd: f64,
    /// Coefficient of the light's pressure.
    #[serde(default)]
    pub cr: f64,
}

impl Input {
    /// The forces on the satellite.
    ///
    /// # Errors
    /// In words, where there is an area and no mass or coefficient, or more than flies, or drag where no air
    /// is known.
    pub fn forces(&self, dynamics: Dynamics) -> Result<Forces, String> {
        let drag_m2_kg = self.per_mass("cd", self.cd, self.drag_area_m2)?;
        let body = self.state.body;
        if drag_m2_kg > 0.0 && !body.facts().air {
            return Err(format!("drag_area_m2: no air is known about the body {}", body.name()));
        }
        let radiation_m2_kg = self.per_mass("cr", self.cr, self.srp_area_m2)?;
        Ok(dynamics.forces(drag_m2_kg, radiation_m2_kg).about(body))
    }

    /// Coefficient times area over mass, m²/kg; 0 without an area.
    ///
    /// # Errors
    /// In words, where there is an area and no mass or coefficient, or more than flies.
    fn per_mass(&self, name: &str, coefficient: f64, area_m2: f64) -> Result<f32, String> {
        if area_m2 == 0.0 {
            return Ok(0.0);
        }
        let share = coefficient * area_m2 / self.mass_kg;
        // Also refuses what is no number.
        if area_m2 > 0.0 && self.mass_kg > 0.0 && coefficient > 0.0 && share <= MOST_M2_KG {
            Ok(share as f32)
        } else {
            Err(format!(
                "with an area {name} and mass_kg must be positive, and {name} area / mass 0 to 10 m2/kg"
            ))
        }
    }
}

/// A state as it is printed.
#[derive(Clone, Copy, Debug, Serialize)]
struct StateOutput {
    /// TT, seconds since J2000.0.
    t_s: f64,
    status: &'static str,
    r_km: Option<[f64; 3]>,
    v_km_s: Option<[f64; 3]>,
}

impl StateOutput {
    fn print(&self, as_json: bool) {
        if as_json {
            return json::print_line(self);
        }
        match (self.r_km, self.v_km_s) {
            (Some([x, y, z]), Some([vx, vy, vz])) => {
                print_line!(
                    "{:.3} s: r {x:.6}, {y:.6}, {z:.6} km, v {vx:.9}, {vy:.9}, {vz:.9} km/s",
                    self.t_s
                );
            }
            _ => print_line!("{:.3} s: out of the bounds of the dynamics", self.t_s),
        }
    }
}

/// The state at a time, in spans that the dynamics take.
///
/// # Errors
/// Where the orbit leaves their bounds on the way.
pub fn carried(state: &OrbitState, to_us: i64, forces: &Forces) -> Result<OrbitState, PropagationError> {
    let mut state = *state;
    while state.time_us != to_us {
        let span_us = (to_us - state.time_us).clamp(-MAX_SPAN_US, MAX_SPAN_US);
        state = forces.propagate(&state, span_us)?;
    }
    Ok(state)
}

/// Runs the command.
///
/// # Errors
/// Of the file, and more states than can be wanted.
pub fn run(arguments: &PropagateArguments) -> Result<ExitCode, HostError> {
    let PropagateArguments { state: path, duration_s, step_s, dynamics, json } = arguments;
    let text = fs::read_to_string(path)
        .map_err(|error| HostError::system(path, "read", &error, "check the path"))?;
    let refuse = |what: String| HostError::input(path, None, what, TO_DO);
    if text.trim().is_empty() {
        return Err(refuse("the file is empty".into()));
    }
    let input: Input = serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
    let first = input.state.state().map_err(refuse)?;
    if duration_s / step_s > MAX_STATES {
        return Err(HostError::usage("more than 1e7 states", "give a longer --step-s"));
    }
    let forces = input.forces(*dynamics).map_err(refuse)?;
    let last_us = first.time_us + (duration_s * MICROSECONDS).round() as i64;
    let times = (0..).map(|step| first.time_us + (f64::from(step) * step_s * MICROSECONDS).round() as i64);
    let mut state = first;
    for time_us in times.take_while(|time_us| *time_us < last_us).chain([last_us]) {
        let carried = carried(&state, time_us, &forces);
        let t_s = time_us as f64 / MICROSECONDS;
        let output = match carried {
            Ok(OrbitState { position_km, velocity_km_s, .. }) => StateOutput {
                t_s,
                status: "propagated",
                r_km: Some(position_km.into()),
                v_km_s: Some(velocity_km_s.into()),
            },
            Err(_) => StateOutput { t_s, status: "out_of_bounds", r_km: None, v_km_s: None },
        };
        output.print(*json);
        let Ok(next) = carried else { break };
        state = next;
    }
    Ok(ExitCode::SUCCESS)
}
