//! The sensor's next two changes of state, found a step a second.
//!
//! An outlook goes along the orbit in steps of a share of a revolution. Where the state at the end of a step
//! is another one than at its begin, the step is halved until the change is known to the second. It ends
//! after two changes, the begin and the end of an outage, or after a revolution: what does not come within one
//! comes with the season.
//!
//! Between full and eclipse it is then asked how fast the lit limb goes or comes: above the terminator ten
//! times slower than the satellite goes round, and its time is as much worse known.
//!
//! A state that lasts no longer than a step may be passed over.

use super::{Forecast, SensorState};
use crate::orbit::OrbitState;
use crate::orbit::constants::MICROSECONDS;
use crate::orbit::dynamics::{MAX_SPAN_US, PropagationError};
use crate::orbit::elements::radius_and_axis_km;

/// Steps of a revolution: 5 s in a low orbit, 72 s in GEO.
const STEPS: f64 = 1200.0;
/// Longest step, s: that of a propagation.
const LONGEST_S: f64 = MAX_SPAN_US as f64 / MICROSECONDS;

/// Seconds after a change in which the pace of the lit limb is measured.
const PACE_S: u8 = 16;

/// A change of the sensor's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The first whole second after the outlook's begin in which the state is another one: Terrestrial Time,
    /// microseconds since J2000.0.
    pub time_us: i64,
    /// What it is then.
    pub state: SensorState,
    /// How fast the lit limb goes or comes, rad/s, where it is that which changes: an angle by which the Sun,
    /// the body or the field is elsewhere shifts the time by no more than itself over this.
    pub pace_rad_s: Option<f32>,
}

/// The orbit so many seconds later.
fn after(forecast: &Forecast<'_>, orbit: &OrbitState, seconds: u16) -> Result<OrbitState, PropagationError> {
    forecast.forces.propagate(orbit, i64::from(seconds) * MICROSECONDS as i64)
}

/// A look ahead under way.
#[derive(Clone, Copy, Debug)]
pub struct Outlook {
    /// How far it has come, and the sensor's state there.
    reached: (OrbitState, SensorState),
    /// Where it is another one; of no meaning while `bracket_s` is 0.
    beyond: (OrbitState, SensorState),
    /// Seconds between both, 0 where no change is known.
    bracket_s: u16,
    step_s: u16,
    end_us: i64,
    found: [Option<Change>; 2],
}

impl Outlook {
    /// Begins at a state of the orbit; `None` where that is none of a satellite.
    pub fn new(forecast: &Forecast<'_>, orbit: &OrbitState) -> Option<Self> {
        let here = (*orbit, forecast.state(orbit)?);
        let mu = forecast.forces.body.facts().mu_km3_s2;
        let (_, axis_km) = radius_and_axis_km(mu, &orbit.position_km, &orbit.velocity_km_s);
        // Of an open orbit, not a number or less than 0: the longest step.
        let period_s = core::f64::consts::TAU * axis_km * libm::sqrt(axis_km / mu);
        let step_s = period_s / STEPS;
        let step_s = if step_s < LONGEST_S { step_s.max(1.0) } else { LONGEST_S };
        let end_us = orbit.time_us.saturating_add((step_s * STEPS * MICROSECONDS) as i64);
        Some(Self {
            reached: here,
            beyond: here,
            bracket_s: 0,
            step_s: step_s as u16,
            end_us,
            found: [None; 2],
        })
    }

    /// Goes on by one propagation and one state of the sensor, or by the pace of a change.
    ///
    /// # Errors
    /// When the orbit leaves the bounds of the dynamics, or has no state there.
    pub fn step(&mut self, forecast: &Forecast<'_>) -> Result<(), PropagationError> {
        if self.bracket_s == 1 {
            return self.change(forecast);
        }
        let (from, state) = &self.reached;
        let span_s = if self.bracket_s > 0 { self.bracket_s / 2 } else { self.step_s };
        let orbit = after(forecast, from, span_s)?;
        let there = (orbit, forecast.state(&orbit).ok_or(PropagationError::Impossible)?);
        if there.1 == *state {
            self.reached = there;
            self.bracket_s = self.bracket_s.saturating_sub(span_s);
        } else {
            self.beyond = there;
            self.bracket_s = span_s;
        }
        Ok(())
    }

    /// Notes the change that is known to the second, and goes on from it.
    fn change(&mut self, forecast: &Forecast<'_>) -> Result<(), PropagationError> {
        let ((_, before), (orbit, state)) = (self.reached, self.beyond);
        let pace_rad_s = if before.rests_on_limb() && state.rests_on_limb() {
            let later = after(forecast, &orbit, PACE_S.into())?;
            let margin_rad = forecast.lit_margin_rad(&later).ok_or(PropagationError::Impossible)?;
            // A limb that is out of sight by then goes faster than can be told.
            Some(libm::fabsf(margin_rad) / f32::from(PACE_S)).filter(|pace| pace.is_finite())
        } else {
            None
        };
        if let Some(place) = self.found.iter_mut().find(|place| place.is_none()) {
            *place = Some(Change { time_us: orbit.time_us, state, pace_rad_s });
        }
        (self.reached, self.bracket_s) = (self.beyond, 0);
        Ok(())
    }

    /// The changes found, in their order.
    pub fn found(&self) -> [Option<Change>; 2] {
        self.found
    }

    /// Whether it is at its end.
    pub fn is_over(&self) -> bool {
        self.reached.0.time_us >= self.end_us || self.found.iter().all(Option::is_some)
    }
}
