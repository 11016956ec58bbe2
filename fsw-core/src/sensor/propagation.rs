//! Orbit, ephemeris, aberration and attitude brought to the instant of the second.

use super::Sensor;
use super::record::{Events, FixRecord};
use super::timekeeping::Time;
use crate::frames::{Direction, Icrs};
use crate::orbit::constants::LIGHT_KM_S;
use crate::orbit::ephemeris;
use crate::orbit::filter::ResetReason;
use crate::telemetry::{ClockFault, ClockState, Event, ReadingFault};
use fsw_hal::{LocalTime, ReadingError};
use nalgebra::Vector3;

/// A reading is of the second before, its middle at most so long ago, us.
const READING_AGE_US: i64 = 1_500_000;

/// Attitudes in a row that contradict the rate sensor (NIS of 40 and more) before it is shut out. One comes of
/// a manoeuvre within a reading, or of a spacecraft that shakes.
const MOST_DOUBTS: u8 = 3;

/// What a rate sensor or a magnetometer was asked for and gave: the middle of a reading, and its axes.
pub(super) type Reading = Result<Option<(LocalTime, [f32; 3])>, ReadingError>;

/// What depends on Terrestrial Time alone.
#[derive(Clone, Copy)]
pub(super) struct Ephemeris {
    /// Terrestrial Time, us since J2000.0.
    pub(super) terrestrial_us: i64,
    pub(super) sun: Direction<Icrs>,
    pub(super) pole: Direction<Icrs>,
}

/// A reading that can serve at `now`, or why there is none.
pub(super) fn usable(reading: Reading, now: LocalTime) -> Result<Vector3<f32>, ReadingFault> {
    let (instant, axes) = reading?.ok_or(ReadingFault::Silent)?;
    if !(0..=READING_AGE_US).contains(&now.us_since(instant)) {
        return Err(ReadingFault::Stale);
    }
    let finite = axes.iter().all(|axis| axis.is_finite());
    if finite { Ok(axes.into()) } else { Err(ReadingFault::NotFinite) }
}

impl Sensor<'_> {
    /// Brings orbit, Sun, pole and aberration to the instant of the second. `None`, and stars without
    /// aberration, where Terrestrial Time is not known; the orbit is propagated by local time all the same.
    #[inline(never)]
    pub(super) fn update_ephemeris(
        &mut self,
        time: &Time,
        fix: &mut FixRecord,
        events: &mut Events,
    ) -> Option<Ephemeris> {
        if time.fault == Some(ClockFault::CounterReset) {
            self.forget_attitude();
        }
        if let Some(step_us) = time.step_us {
            events.note(Event::ClockJump);
            self.orbit.shift_epoch(step_us);
            self.fixed_us = self.fixed_us.saturating_add(step_us);
        }
        if let Some(terrestrial_us) = time.terrestrial_us {
            let propagated = self.orbit.approach(terrestrial_us, &self.parameters.orbit);
            let stale = self.orbit.is_stale(terrestrial_us.saturating_sub(self.fixed_us));
            if stale || propagated.is_err() {
                match propagated {
                    Err(ResetReason::Diverged) => self.forget_orbit(),
                    _ => self.lose_orbit(),
                }
                events.note(Event::OrbitForgotten);
            }
            let update = self.orbit.proceed(&self.parameters.orbit);
            *fix = self.note_update(update, terrestrial_us, events);
        }
        let known_us = time.terrestrial_us.filter(|_| time.state != ClockState::Unknown);
        self.aberration_corrected = known_us.is_some();
        let body = self.parameters.orbit.body;
        // About the Sun, and about the central body where that is known: up to 5 arcsec of 25.
        let velocity_km_s = known_us.map_or(Vector3::zeros(), |instant_us| {
            let orbital_km_s = self.orbit.state().map_or(Vector3::zeros(), |state| state.velocity_km_s);
            ephemeris::velocity_km_s(body, instant_us) + orbital_km_s
        });
        self.catalogue.set_observer_velocity((velocity_km_s / LIGHT_KM_S).map(|axis| axis as f32));
        known_us.map(|terrestrial_us| Ephemeris {
            terrestrial_us,
            sun: ephemeris::sun_direction(body, terrestrial_us),
            pole: ephemeris::pole(body, terrestrial_us),
        })
    }

    /// Whether the rate sensor is asked: the parameters have one that is not shut out, and there is an
    /// attitude to propagate.
    pub(super) fn needs_rate(&self) -> bool {
        self.parameters.rate_sensor.is_some()
            && self.motion.as_ref().is_some()
            && !self.rate_sensor_is_shut_out()
    }

    /// Whether so many attitudes in a row contradicted the rate sensor that it is not asked anymore.
    pub(super) fn rate_sensor_is_shut_out(&self) -> bool {
        self.rate_sensor_doubts >= MOST_DOUBTS
    }

    /// Counts the attitudes in a row that contradict the rate sensor; whether this one shuts it out, so that
    /// nothing that rests on its readings is to be believed.
    pub(super) fn shuts_rate_sensor_out(&mut self, contradicts: bool) -> bool {
        if self.rate_sensor_is_shut_out() {
            return false;
        }
        self.rate_sensor_doubts = if contradicts { self.rate_sensor_doubts + 1 } else { 0 };
        self.rate_sensor_is_shut_out()
    }

    /// Propagates the attitude to this second by the rate sensor's reading of the one before; without one
    /// that can serve, by the last rate. Returns why there is none.
    #[inline(never)]
    pub(super) fn propagate_gyro(&mut self, reading: Reading) -> Option<ReadingFault> {
        let (Some(noise), Some(motion)) = (self.parameters.rate_sensor, self.motion.as_mut()) else {
            return None;
        };
        let reading = usable(reading, self.now);
        let to_star_path = self.star_to_earth.inverse();
        let rate_rad_s = reading.map(|rad_s| to_star_path.matrix() * rad_s);
        motion.propagate_gyro(self.now, noise, rate_rad_s.ok());
        reading.err()
    }
}
