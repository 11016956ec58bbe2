//! What the emulated computer flies: clips of scenarios, one after the other.
//!
//! In: a [`Flight`]. Out: a frame a second and the parameter table for them. Between two clips the sensor is
//! not asked for as long as the clips are apart; where the next one is earlier, for `PAUSE_US`, and the clock
//! is set back. What the flight code makes of that (a gap that it crosses, one too long, a step backwards) is
//! part of the flight.
//!
//! [`MISSION`] goes through every mode. [`GYRO`] has a rate sensor, which carries the attitude through a
//! sunrise. In [`EARTH_ALONE`] the star path is shut: the Earth holds the attitude, then gives it alone. The
//! others drive a part of the second to its caps: [`WIDE_LIMB`] the strips across the limb, which from the
//! lowest orbit and after a gap are longest and from there need another mount, [`STORM`] the scan and the
//! identification, [`CROWD`] what tracking reads and matches.
//!
//! | clip of the mission | what is new in it |
//! |---|---|
//! | low orbit, 10 min before dusk | self-test, acquisition, tracking in strips about the last fix |
//! | six times a minute later | an arc long enough for a first orbit |
//! | 3 min before dusk, twice | trials of a first orbit until one passes; looks at the limb |
//! | night, 5.5 min later | the stars are lost and acquired anew; eclipse |
//! | sunrise, 48 min later | Sun outage until its time-out, safe mode, acquisition of a blinded detector |
//! | 3 min later | the Sun leaves: acquisition, tracking; the orbit has drifted and the whole detector is searched |
//! | GEO, an hour earlier | the clock goes backwards; the Earth whole |
//! | GEO, 4 h later | a thin crescent, for which the whole detector is searched second after second |
//! | tumbling at 4 deg/s | streaks found by the scan, then sought as lines |
//!
//! Time-outs are short and the limb's slow errors pass soon, so that 208 seconds suffice to know an orbit and to
//! lose it; all else is the scenarios' own.

use super::Instrument;
use super::ground::Ground;
use crate::error::HostError;
use crate::flight::StarCalibration;
use crate::formats::frames_file::{FramesWriter, Readings};
use crate::harness::ThisSecond;
use crate::scenario::Scenario;
use crate::world::detector::disturbances::Disturbances;
use crate::world::detector::protons::Protons;
use crate::world::instruments::gyro::{Gyro, GyroModel};
use crate::world::instruments::magnetometer::{BodyMagnetometer, MagnetometerModel};
use crate::world::scene::Scene;
use fsw_core::command::{GroundOrbit, Telecommand};
use fsw_core::modes::ModeParameters;
use fsw_core::orbit::OrbitState;
use fsw_core::orbit::parameters::OrbitParameters;
use fsw_core::parameters::Parameters;
use fsw_core::shutting::ShutterParameters;
use fsw_hal::{Instant, LocalTime, Magnetometer, OpenPaths, RateSensor};
use std::path::Path;

/// A piece of an embedded scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clip {
    /// Name of the scenario.
    pub scenario: &'static str,
    /// Its first second that is shown.
    pub from_s: u32,
    /// Seconds shown.
    pub seconds: u32,
}

/// What the ground sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The true orbit of the second before, as known to 10 km and 10 m/s.
    Orbit,
    /// The only path to be open; the sensor's choice again.
    Shutter(Option<OpenPaths>),
    /// The attitude is to be forgotten.
    Reacquire,
}

const LEO: &str = "sso-noon-midnight";
const GEO: &str = "geo-eclipse";

/// What is shown to the emulated computer in one go.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// The pieces, in order.
    pub clips: &'static [Clip],
    /// From which clip on what else is on the detector that is neither star nor Earth; none: what the scenarios
    /// say.
    pub disturbances: Option<(usize, fn() -> Disturbances)>,
    /// The gyro on board; none: what the scenarios say.
    pub gyro: Option<GyroModel>,
    /// The magnetometer on board, whatever the scenarios say.
    pub magnetometer: Option<MagnetometerModel>,
    /// Which paths are open.
    pub open: OpenPaths,
    /// What the ground sends, and in which second of the flight. Where it moves shutters, there are some.
    pub orders: &'static [(u32, Order)],
}

/// Every mode.
pub const MISSION: Flight = Flight {
    clips: &[
        Clip { scenario: LEO, from_s: 20, seconds: 6 },
        Clip { scenario: LEO, from_s: 80, seconds: 4 },
        Clip { scenario: LEO, from_s: 140, seconds: 4 },
        Clip { scenario: LEO, from_s: 200, seconds: 4 },
        Clip { scenario: LEO, from_s: 260, seconds: 4 },
        Clip { scenario: LEO, from_s: 320, seconds: 4 },
        Clip { scenario: LEO, from_s: 380, seconds: 4 },
        Clip { scenario: LEO, from_s: 440, seconds: 60 },
        Clip { scenario: LEO, from_s: 505, seconds: 26 },
        Clip { scenario: LEO, from_s: 830, seconds: 27 },
        Clip { scenario: LEO, from_s: 3723, seconds: 21 },
        Clip { scenario: LEO, from_s: 3903, seconds: 10 },
        Clip { scenario: GEO, from_s: 0, seconds: 10 },
        Clip { scenario: GEO, from_s: 13_678, seconds: 12 },
        Clip { scenario: "tumbling", from_s: 60, seconds: 12 },
    ],
    disturbances: None,
    gyro: None,
    magnetometer: None,
    open: OpenPaths::Both,
    orders: &[],
};

/// The night before sunrise, and the Sun in the star path: what the stars gave the gyro carries.
pub const GYRO: Flight = Flight {
    clips: &[Clip { scenario: LEO, from_s: 3690, seconds: 54 }],
    disturbances: None,
    gyro: Some(FIBRE_OPTIC),
    magnetometer: None,
    open: OpenPaths::Both,
    orders: &[],
};

/// A fibre-optic gyro, as the defaults of the flight parameters have it.
const FIBRE_OPTIC: GyroModel = GyroModel {
    noise_deg_s: 5.7e-4,
    bias_deg_s: 5.7e-3,
    drift_deg_s_h: 3.4e-4,
    scale_error: 1e-4,
    misalignment_deg: 0.01,
    resolution_deg_s: 0.0,
    range_deg_s: 100.0,
};

/// The limb from 450 km: found while the orbit becomes known, tracked, and expected after a gap over which
/// that has become unsure.
pub const WIDE_LIMB: Flight = Flight {
    clips: &[
        Clip { scenario: "leo-oblique", from_s: 0, seconds: 6 },
        Clip { scenario: "leo-oblique", from_s: 60, seconds: 4 },
        Clip { scenario: "leo-oblique", from_s: 120, seconds: 4 },
        Clip { scenario: "leo-oblique", from_s: 180, seconds: 4 },
        Clip { scenario: "leo-oblique", from_s: 240, seconds: 4 },
        Clip { scenario: "leo-oblique", from_s: 300, seconds: 4 },
        Clip { scenario: "leo-oblique", from_s: 360, seconds: 4 },
        Clip { scenario: "leo-oblique", from_s: 420, seconds: 126 },
        Clip { scenario: "leo-oblique", from_s: 550, seconds: 10 },
    ],
    disturbances: None,
    gyro: None,
    magnetometer: None,
    open: OpenPaths::Both,
    orders: &[],
};

/// More spots than the flight code may look at, in which no stars are found.
pub const STORM: Flight = Flight {
    clips: &[Clip { scenario: LEO, from_s: 440, seconds: 12 }],
    disturbances: Some((0, storm)),
    gyro: None,
    magnetometer: None,
    open: OpenPaths::Both,
    orders: &[],
};

/// The same on a detector most of whose hot pixels are known on board: stars are found, and the Earth.
pub const SURVEYED: Flight = Flight { disturbances: Some((0, surveyed)), ..STORM };

/// The richest field of the scenarios, tracked, in which a storm begins: every window has more spots than it
/// can measure.
pub const CROWD: Flight = Flight {
    clips: &[
        Clip { scenario: GEO, from_s: 15_116, seconds: 10 },
        Clip { scenario: GEO, from_s: 15_126, seconds: 4 },
    ],
    disturbances: Some((1, crowd)),
    gyro: None,
    magnetometer: None,
    open: OpenPaths::Both,
    orders: &[],
};

/// The star path is shut: the attitude is carried on and held to the Earth, then by the Earth and its
/// terminator alone.
pub const EARTH_ALONE: Flight = Flight {
    clips: &[Clip { scenario: LEO, from_s: 20, seconds: 24 }, Clip { scenario: GEO, from_s: 0, seconds: 24 }],
    disturbances: None,
    gyro: None,
    magnetometer: None,
    open: OpenPaths::Both,
    orders: &[
        (6, Order::Orbit),
        (12, Order::Shutter(Some(OpenPaths::Earth))),
        (18, Order::Reacquire),
        (25, Order::Shutter(None)),
        (30, Order::Orbit),
        (36, Order::Shutter(Some(OpenPaths::Earth))),
        (42, Order::Reacquire),
    ],
};

fn crowd() -> Disturbances {
    Disturbances { false_stars: 3_000, protons: Protons::Fixed(3_000), ..Disturbances::default() }
}

fn surveyed() -> Disturbances {
    Disturbances { surveyed: 0.95, ..storm() }
}

fn storm() -> Disturbances {
    Disturbances {
        false_stars: 200,
        hot_pixels: 1_000,
        protons: Protons::Fixed(300),
        ..Disturbances::default()
    }
}

/// Local time between a clip and one of an earlier date: longer than any orbit is propagated over.
const PAUSE_US: i64 = 3 * 3_600_000_000;

/// The mission's time-outs.
const MODES: ModeParameters = ModeParameters {
    patience_s: 3,
    dwell_s: 1,
    fault_patience_s: 5,
    settle_s: 3,
    acquisition_timeout_s: 5,
    outage_timeout_s: 10,
    healthy_s: 3,
};

/// Length over which the limb's height changes: with as few fixes as the mission has, the default would leave
/// the orbit unknown.
const FIELD_LENGTH_KM: f32 = 100.0;

/// Parameters in a hurry.
fn hurried(parameters: Parameters) -> Parameters {
    let orbit = OrbitParameters { field_length_km: FIELD_LENGTH_KM, ..parameters.orbit };
    Parameters { modes: MODES, orbit, ..parameters }
}

fn flight_parameters(scenario: &Scenario) -> Result<Parameters, HostError> {
    let calibration = scenario.calibration()?;
    Ok(scenario.flight_parameters(calibration.as_ref().and_then(StarCalibration::open).as_ref()))
}

/// What gyro and magnetometer read in a second.
fn readings(scenario: &Scenario, scene: &Scene, (cycle, instant): (u32, LocalTime)) -> Readings {
    let Some(truth) = &scene.truth_at(cycle.into()) else { return Readings::default() };
    let (seed, cycle) = (scenario.seed, cycle.into());
    let rate = scenario
        .gyro
        .as_ref()
        .and_then(|model| Gyro { model, seed, cycle, instant, truth }.angular_rate().ok()?);
    let field = scenario
        .magnetometer
        .as_ref()
        .and_then(|model| BodyMagnetometer { model, seed, cycle, instant, truth }.magnetic_field().ok()?);
    Readings { rate, field }
}

impl Flight {
    /// The detector, its flight parameters and defects: those of the first clip's scenario, with the mission's
    /// time-outs.
    ///
    /// # Errors
    /// When there is no clip, or they need different ones: camera and mount must be the same in all. (The
    /// exposure may differ: frames in a file have been exposed.)
    pub fn instrument(&self) -> Result<Instrument, HostError> {
        let [first, others @ ..] = self.clips else {
            return Err(HostError::usage("no clip to fly", "report this"));
        };
        let scenario = self.scenario(0, first)?;
        let geometry = scenario.camera.geometry();
        let mut parameters = hurried(flight_parameters(&scenario)?);
        for (index, clip) in (1..).zip(others) {
            let other = self.scenario(index, clip)?;
            let mut needed = hurried(flight_parameters(&other)?);
            needed.imaging.exposure_us = parameters.imaging.exposure_us;
            if needed != parameters || other.camera.geometry() != geometry {
                let what = format!("{} needs another instrument than {}", clip.scenario, first.scenario);
                return Err(HostError::usage(what, "report this"));
            }
        }
        if self.orders.iter().any(|(_, order)| matches!(order, Order::Shutter(_))) {
            parameters.shutter = Some(ShutterParameters::default());
        }
        Ok(Instrument { geometry, parameters, defects: scenario.known_defects() })
    }

    /// What the ground sends, as packets.
    ///
    /// # Errors
    /// When a scenario cannot be loaded.
    pub fn ground(&self) -> Result<Ground, HostError> {
        let mut ground = Ground::default();
        for (second, order) in self.orders {
            let telecommand = match order {
                Order::Orbit => Telecommand::Orbit(self.orbit(second.saturating_sub(1))?),
                Order::Shutter(open) => Telecommand::Shutter(*open),
                Order::Reacquire => Telecommand::Reacquire,
            };
            ground.send(*second, &telecommand)?;
        }
        Ok(ground)
    }

    /// The true orbit in a second of the flight, as known to 10 km and 10 m/s.
    ///
    /// # Errors
    /// When there is no such second, or its scenario cannot be loaded.
    pub fn orbit(&self, second: u32) -> Result<GroundOrbit, HostError> {
        let nothing = || HostError::usage("no orbit in such a second", "report this");
        let mut cycles = (0..).zip(self.clips).flat_map(|(index, clip)| {
            (clip.from_s..).take(clip.seconds as usize).map(move |cycle| (index, clip, cycle))
        });
        let (index, clip, cycle) = cycles.nth(second as usize).ok_or_else(nothing)?;
        let scenario = self.scenario(index, clip)?;
        let truth = scenario.scene()?.truth_at(cycle.into()).ok_or_else(nothing)?;
        let state = OrbitState {
            time_us: scenario.instant_us(cycle),
            position_km: truth.position_km.into(),
            velocity_km_s: truth.velocity_km_s.into(),
        };
        Ok(GroundOrbit { state, position_sigma_km: 10.0, velocity_sigma_km_s: 0.01 })
    }

    /// The scenario of a clip, the `index`th.
    fn scenario(&self, index: usize, clip: &Clip) -> Result<Scenario, HostError> {
        let scenario = Scenario::load(Path::new(clip.scenario))?;
        let more = self.disturbances.filter(|(first, _)| index >= *first);
        let disturbances = more.map_or(scenario.disturbances, |(_, disturbances)| disturbances());
        let gyro = self.gyro.or(scenario.gyro);
        Ok(Scenario { disturbances, gyro, magnetometer: self.magnetometer, ..scenario })
    }

    /// Writes the frames.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn draw(&self, writer: &mut FramesWriter) -> Result<(), HostError> {
        let mut last: Option<(i64, i64)> = None;
        for (index, clip) in self.clips.iter().enumerate() {
            let scenario = self.scenario(index, clip)?;
            let mut scene = scenario.scene()?;
            scene.open(self.open);
            for cycle in (clip.from_s..).take(clip.seconds as usize) {
                let instant_us = scenario.instant_us(cycle);
                let local_us = last.map_or(0, |(local_us, before_us)| match instant_us - before_us {
                    elapsed_us @ 1.. => local_us + elapsed_us,
                    _ => local_us + PAUSE_US,
                });
                last = Some((local_us, instant_us));
                let instant = Instant::new(LocalTime::from_us(local_us), instant_us);
                let readings = readings(&scenario, &scene, (cycle, instant.local));
                let mut detector =
                    ThisSecond { scene: &mut scene, cycle: cycle.into(), instant: instant.local };
                writer.record(&mut detector, (instant, readings), scenario.exposure_us)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_clip_lies_in_its_scenario_and_one_instrument_serves_all() {
        for flight in [MISSION, WIDE_LIMB, STORM, SURVEYED, CROWD, GYRO, EARTH_ALONE] {
            for clip in flight.clips {
                assert!(
                    clip.from_s + clip.seconds <= flight.scenario(0, clip).unwrap().duration_s,
                    "{clip:?}"
                );
            }
            assert!(flight.instrument().unwrap().parameters.check().is_ok());
        }
        assert_eq!(MISSION.clips.iter().map(|clip| clip.seconds).sum::<u32>(), 208);
        const BOTH: &[Clip] = &[MISSION.clips[0], WIDE_LIMB.clips[0]];
        assert!(Flight { clips: BOTH, ..MISSION }.instrument().is_err());
    }
}
