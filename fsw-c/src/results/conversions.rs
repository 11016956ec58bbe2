//! From the flight code's report.

use super::*;
use fsw_core::command::CommandOutcome;
use fsw_core::modes::Mode as FlightMode;
use fsw_core::outages;
use fsw_core::telemetry::{
    self, AttitudeReport, ElementsReport, FilteredAttitude, LocalAttitude, OrbitReport, Report,
};

impl From<FlightMode> for Mode {
    fn from(mode: FlightMode) -> Self {
        match mode {
            FlightMode::SelfTest => Self::SelfTest,
            FlightMode::Acquisition => Self::Acquisition,
            FlightMode::Tracking => Self::Tracking,
            FlightMode::Eclipse => Self::Eclipse,
            FlightMode::SunOutage => Self::SunOutage,
            FlightMode::Safe => Self::Safe,
            FlightMode::CommandedSafe => Self::CommandedSafe,
        }
    }
}

impl From<Option<telemetry::Outcome>> for Outcome {
    fn from(outcome: Option<telemetry::Outcome>) -> Self {
        use telemetry::Outcome as Flight;
        match outcome {
            None => Self::None,
            Some(Flight::SelfTestPassed) => Self::SelfTestPassed,
            Some(Flight::Identified) => Self::Identified,
            Some(Flight::Searching) => Self::Searching,
            Some(Flight::NotIdentified(_)) => Self::NotIdentified,
            Some(Flight::TooFast) => Self::TooFast,
            Some(Flight::Tracked) => Self::Tracked,
            Some(Flight::Lost) => Self::Lost,
            Some(Flight::Blinded) => Self::Blinded,
            Some(Flight::StarPathShut) => Self::StarPathShut,
        }
    }
}

impl From<telemetry::EarthStatus> for EarthStatus {
    fn from(status: telemetry::EarthStatus) -> Self {
        match status {
            telemetry::EarthStatus::NotLooked => Self::NotLooked,
            telemetry::EarthStatus::Dark => Self::Dark,
            telemetry::EarthStatus::Faint => Self::Faint,
            telemetry::EarthStatus::Found => Self::Found,
            telemetry::EarthStatus::Refused(_) => Self::Refused,
        }
    }
}

impl From<telemetry::ClockState> for ClockState {
    fn from(state: telemetry::ClockState) -> Self {
        match state {
            telemetry::ClockState::Unknown => Self::Unknown,
            telemetry::ClockState::Synchronised => Self::Synchronised,
            telemetry::ClockState::Holdover => Self::Holdover,
        }
    }
}

impl From<&AttitudeReport> for Attitude {
    fn from(report: &AttitudeReport) -> Self {
        let AttitudeReport { quaternion, sigma_rad, log10_false: _, age_s } = *report;
        Self { known: true, quaternion, sigma_rad, age_s: age_s.into() }
    }
}

impl From<&FilteredAttitude> for Attitude {
    fn from(report: &FilteredAttitude) -> Self {
        let FilteredAttitude { quaternion, sigma_rad } = *report;
        Self { known: true, quaternion, sigma_rad, age_s: 0 }
    }
}

impl From<&OrbitReport> for Orbit {
    fn from(report: &OrbitReport) -> Self {
        Self {
            known: true,
            settled: report.settled,
            since_fix_s: report.since_fix_s,
            position_km: report.position_km,
            velocity_km_s: report.velocity_km_s,
            sigma_position_km: report.sigma_position_km,
            sigma_velocity_km_s: report.sigma_velocity_km_s,
            sigma_hill_km: report.sigma_hill_km,
            misalignment_rad: report.misalignment_rad,
            misalignment_sigma_rad: report.misalignment_sigma_rad,
            elements: report.elements.as_ref().map(Elements::from).unwrap_or_default(),
        }
    }
}

impl From<&ElementsReport> for Elements {
    fn from(report: &ElementsReport) -> Self {
        let ElementsReport { semi_major_axis_km, eccentricity, .. } = *report;
        let ElementsReport { inclination_rad, node_rad, perigee_rad, anomaly_rad, .. } = *report;
        Self {
            known: true,
            semi_major_axis_km,
            eccentricity,
            inclination_rad,
            node_rad,
            perigee_rad,
            anomaly_rad,
        }
    }
}

impl From<&LocalAttitude> for Local {
    fn from(report: &LocalAttitude) -> Self {
        let LocalAttitude { quaternion, nadir_rad, yaw_rad } = *report;
        Self { known: true, quaternion, nadir_rad, yaw_rad }
    }
}

impl From<outages::SensorState> for SensorState {
    fn from(state: outages::SensorState) -> Self {
        use outages::SensorState as Flight;
        match state {
            Flight::Full => Self::Full,
            Flight::SunInEarthPath => Self::SunInEarthPath,
            Flight::Eclipse => Self::Eclipse,
            Flight::SunInStarPath => Self::SunInStarPath,
            Flight::SunInStarPathOverEarth => Self::SunInStarPathOverEarth,
        }
    }
}

impl From<&telemetry::NextState> for NextState {
    fn from(report: &telemetry::NextState) -> Self {
        let telemetry::NextState { state, in_s, sigma_s, lasts_s } = *report;
        Self { known: true, state: state.into(), in_s, sigma_s, lasts_s: lasts_s.unwrap_or(0) }
    }
}

impl From<&telemetry::MagnetometerReport> for MagneticField {
    fn from(report: &telemetry::MagnetometerReport) -> Self {
        let telemetry::MagnetometerReport { field_ut, zero_ut, zero_sigma_ut, used } = *report;
        Self { known: true, used, field_ut, zero_ut, zero_sigma_ut }
    }
}

/// The rate by the attitudes so far, else by streaks and nameless stars.
fn rate(report: &Report) -> Rate {
    match (report.rate_rad_s, &report.rate) {
        (Some(rad_s), _) => Rate { known: true, rad_s, ..Rate::default() },
        (None, Some(rate)) => Rate {
            known: true,
            either_sense: rate.either_sense,
            rad_s: rate.rad_s,
            sigma_rad_s: rate.sigma_rad_s,
        },
        (None, None) => Rate::default(),
    }
}

/// What did not serve, as a sum.
fn faults(faults: &telemetry::Faults) -> u32 {
    let bit = |fault: bool, bit: u32| if fault { bit } else { 0 };
    bit(faults.detector.is_some(), FAULT_DETECTOR)
        | bit(faults.image.is_some(), FAULT_IMAGE)
        | bit(faults.clock.is_some(), FAULT_CLOCK)
        | bit(faults.rate_sensor.is_some(), FAULT_RATE_SENSOR)
        | bit(faults.fix.is_some(), FAULT_FIX)
        | bit(faults.shutter.is_some(), FAULT_SHUTTER)
        | bit(faults.magnetometer.is_some(), FAULT_MAGNETOMETER)
}

impl From<&Report> for CycleResult {
    fn from(report: &Report) -> Self {
        let earth = report.earth.as_ref().map(|earth| Earth {
            direction: earth.direction,
            sigma_rad: earth.sigma_rad,
            distance_km: earth.distance_km,
            sigma_km: earth.sigma_km,
            covariance_km2: earth.covariance_km2,
        });
        Self {
            cycle: report.cycle,
            mode: report.mode.into(),
            outcome: report.outcome.into(),
            earth_status: report.earth_status.into(),
            clock: report.clock.into(),
            faults: faults(&report.faults),
            local_us: report.local_us,
            terrestrial_us: report.instant_us.unwrap_or(0),
            detections: report.detections.into(),
            stars: report.stars.len() as u32,
            attitude: report.attitude.as_ref().map(Attitude::from).unwrap_or_default(),
            filtered: report.filtered.as_ref().map(Attitude::from).unwrap_or_default(),
            rate: rate(report),
            earth: earth.unwrap_or_default(),
            orbit: report.orbit.as_ref().map(Orbit::from).unwrap_or_default(),
            local: report.local.as_ref().map(Local::from).unwrap_or_default(),
            next_state: report.next_state.as_ref().map(NextState::from).unwrap_or_default(),
            magnetic_field: report.magnetometer.as_ref().map(MagneticField::from).unwrap_or_default(),
            command: match report.command {
                None => CommandResult::None,
                Some(CommandOutcome::Done) => CommandResult::Done,
                Some(CommandOutcome::Refused(_)) => CommandResult::Refused,
            },
            refusal: match report.command {
                Some(CommandOutcome::Refused(reason)) => reason.code().into(),
                _ => 0,
            },
            exposure_us: report.exposure_us.unwrap_or(0),
            star_path_shut: report.star_path_shut,
            earth_path_shut: report.earth_path_shut,
            earth_path_clear: report.earth_path_clear,
            earth_path_stars: report.earth_path_stars.unwrap_or(0),
            sensor_state_known: report.state.is_some(),
            sensor_state: report.state.map(SensorState::from).unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests;
