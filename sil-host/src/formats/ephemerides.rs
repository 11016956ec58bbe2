//! The ephemerides of a run: truth and estimate, orbit and attitude, as CCSDS messages.
//!
//! | file | a line a second |
//! |---|---|
//! | `truth.oem` | position and velocity of the world |
//! | `estimate.oem` | the orbit that the sensor reports, with its covariance once a minute |
//! | `truth.aem` | the world's quaternion from ICRF to the star path |
//! | `estimate.aem` | the filtered attitude; where there is none, that of one image |
//!
//! An estimate stands at the instant that the sensor gives it, which is that of its image.

use super::ccsds::{Message, MessageFile, RunName};
use crate::error::HostError;
use crate::harness::Second;
use crate::judge::second::{image_cycle, motion_covariance};
use crate::output::Folder;
use crate::scenario::Scenario;

/// The files.
pub const FILES: [&str; 4] = ["truth.oem", "estimate.oem", "truth.aem", "estimate.aem"];

/// The four messages under way.
#[derive(Debug)]
pub struct Ephemerides {
    truth: [MessageFile; 2],
    estimate: [MessageFile; 2],
}

impl Ephemerides {
    /// Begins them.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(folder: &Folder, scenario: &Scenario) -> Result<Self, HostError> {
        let name = |comment| RunName {
            object: scenario.name.clone(),
            centre: scenario.forces.body,
            comment,
            start_us: scenario.start_us,
            end_us: scenario.instant_us(scenario.duration_s),
        };
        let file =
            |file: &str, message, comment| MessageFile::create(&folder.file(file), message, name(comment));
        let truth = "the truth of a simulated run";
        let estimate = "what the flight code reports in a simulated run";
        let [truth_orbit, estimate_orbit, truth_attitude, estimate_attitude] = FILES;
        Ok(Self {
            truth: [
                file(truth_orbit, Message::Orbit, truth)?,
                file(truth_attitude, Message::Attitude, truth)?,
            ],
            estimate: [
                file(estimate_orbit, Message::Orbit, estimate)?,
                file(estimate_attitude, Message::Attitude, estimate)?,
            ],
        })
    }

    /// Adds a second.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn add(&mut self, second: &Second<'_>) -> Result<(), HostError> {
        let Second { truth, report, .. } = second;
        let state = |position: [f64; 3], velocity: [f64; 3]| {
            let ([x, y, z], [vx, vy, vz]) = (position, velocity);
            [x, y, z, vx, vy, vz]
        };
        let [orbit, attitude] = &mut self.truth;
        orbit.add(truth.instant_us, &state(truth.position_km, truth.velocity_km_s), None)?;
        attitude.add(truth.instant_us, &truth.quaternion, None)?;
        let Some(instant_us) = report.instant_us else { return Ok(()) };
        let [orbit, attitude] = &mut self.estimate;
        if let Some(reported) = &report.orbit {
            let covariance = motion_covariance(reported);
            orbit.add(instant_us, &state(reported.position_km, reported.velocity_km_s), Some(&covariance))?;
        }
        let single = report.attitude.map(|single| single.quaternion);
        if let Some(quaternion) = report.filtered.map(|filtered| filtered.quaternion).or(single) {
            // A search may last for seconds; what it finds is the attitude of its image.
            let late_us = 1_000_000 * i64::from(report.cycle.saturating_sub(image_cycle(report)));
            attitude.add(instant_us - late_us, &quaternion.map(f64::from), None)?;
        }
        Ok(())
    }

    fn each(&mut self) -> impl Iterator<Item = &mut MessageFile> {
        self.truth.iter_mut().chain(&mut self.estimate)
    }

    /// Hands whole lines over to the system.
    ///
    /// # Errors
    /// When it refuses.
    pub fn flush(&mut self) -> Result<(), HostError> {
        self.each().try_for_each(MessageFile::flush)
    }

    /// Ends the messages and gives the files their names.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(self) -> Result<(), HostError> {
        self.truth.into_iter().chain(self.estimate).try_for_each(MessageFile::finish)
    }
}
