//! What the emulated computer flies: clips of scenarios, one after the other.
//!
//! In: clips. Out: a frame a second and the parameter table for them. Between two clips the clock jumps; what the
//! flight code makes of that (a gap that it crosses, one too long, a step backwards) is part of the mission.
//!
//! [`MISSION`] goes through every mode; [`WIDE_LIMB`] has what that camera's mount does not see, the lowest orbit's limb, across which
//! strips are longest.
//!
//! | clip of the mission | what is new in it |
//! |---|---|
//! | low orbit, 4 min before dusk | self-test, acquisition, tracking, the orbit started |
//! | a few seconds later, twice | the orbit crosses gaps and its speed becomes known |
//! | night, 5.5 min later | the stars are lost and acquired anew; eclipse |
//! | sunrise, 48 min later | Sun outage until its time-out, safe mode, self-test, acquisition of a blinded detector |
//! | 3 min later | the Sun leaves: acquisition, tracking; the orbit has drifted and the whole detector is searched |
//! | GEO, an hour earlier | the clock goes backwards; the Earth whole |
//! | GEO, 4 h later | a thin crescent, for which the whole detector is searched second after second |
//! | tumbling at 4 deg/s | streaks found by the scan, then sought as lines |
//!
//! Time-outs are short and the fixes' slow errors small, so that 132 seconds suffice to know an orbit and to lose it; all else is
//! the scenarios' own.

use crate::error::HostError;
use crate::frames_file::FramesWriter;
use crate::run::harness::ThisSecond;
use crate::scenario::Scenario;
use fsw_core::modes::ModeParameters;
use fsw_core::orbit::parameters::OrbitParameters;
use fsw_core::parameters::Parameters;
use fsw_hal::DetectorGeometry;
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

const LEO: &str = "sso-noon-midnight";
const GEO: &str = "geo-eclipse";

/// Every mode.
pub const MISSION: [Clip; 9] = [
    Clip { scenario: LEO, from_s: 440, seconds: 12 },
    Clip { scenario: LEO, from_s: 456, seconds: 10 },
    Clip { scenario: LEO, from_s: 480, seconds: 18 },
    Clip { scenario: LEO, from_s: 830, seconds: 27 },
    Clip { scenario: LEO, from_s: 3723, seconds: 21 },
    Clip { scenario: LEO, from_s: 3903, seconds: 10 },
    Clip { scenario: GEO, from_s: 0, seconds: 10 },
    Clip { scenario: GEO, from_s: 13_678, seconds: 12 },
    Clip { scenario: "tumbling", from_s: 60, seconds: 12 },
];

/// The limb from 450 km: found, then tracked while the orbit becomes known.
pub const WIDE_LIMB: [Clip; 1] = [Clip { scenario: "leo-oblique", from_s: 0, seconds: 30 }];

/// The mission's time-outs.
const MODES: ModeParameters = ModeParameters {
    patience_s: 3,
    fault_patience_s: 5,
    settle_s: 3,
    acquisition_timeout_s: 5,
    outage_timeout_s: 10,
    pause_s: 3,
};

fn scenario(clip: &Clip) -> Result<Scenario, HostError> {
    Scenario::load(Path::new(clip.scenario))
}

/// Slow errors of a fix over its white noise: with as few fixes as the mission has, the default would leave the orbit unknown.
const BIAS_OVER_NOISE: f32 = 2.0;
const BIAS_TIME_SHARE: f32 = 0.03;
const LIMB_HEIGHT_SIGMA_KM: f32 = 0.3;

/// Parameters in a hurry.
fn hurried(parameters: Parameters) -> Parameters {
    let orbit = OrbitParameters {
        bias_over_noise: BIAS_OVER_NOISE,
        bias_time_share: BIAS_TIME_SHARE,
        limb_height_sigma_km: LIMB_HEIGHT_SIGMA_KM,
        ..parameters.orbit
    };
    Parameters { modes: MODES, orbit, ..parameters }
}

fn flight_parameters(scenario: &Scenario) -> Result<Parameters, HostError> {
    Ok(scenario.flight_parameters(scenario.calibration()?.as_ref()))
}

/// The detector and its flight parameters: those of the first clip's scenario, with the mission's time-outs.
///
/// # Errors
/// When there is no clip, or they need different ones: camera and mount must be the same in all. (The exposure may differ: frames in
/// a file have been exposed.)
pub fn instrument(clips: &[Clip]) -> Result<(DetectorGeometry, Parameters), HostError> {
    let [first, others @ ..] = clips else {
        return Err(HostError::usage("no clip to fly", "report this"));
    };
    let scene = scenario(first)?;
    let geometry = scene.camera.geometry();
    let parameters = hurried(flight_parameters(&scene)?);
    for clip in others {
        let other = scenario(clip)?;
        let exposure_us = parameters.exposure_us;
        let needed = Parameters { exposure_us, ..hurried(flight_parameters(&other)?) };
        if needed != parameters || other.camera.geometry() != geometry {
            let what = format!("{} needs another instrument than {}", clip.scenario, first.scenario);
            return Err(HostError::usage(what, "report this"));
        }
    }
    Ok((geometry, parameters))
}

/// Writes the frames.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(clips: &[Clip], writer: &mut FramesWriter) -> Result<(), HostError> {
    for clip in clips {
        let scenario = scenario(clip)?;
        let mut scene = scenario.scene()?;
        for cycle in (clip.from_s..).take(clip.seconds as usize) {
            let instant_us = scenario.instant_us(cycle);
            let mut detector = ThisSecond { scene: &mut scene, cycle: cycle.into() };
            writer.record(&mut detector, instant_us, scenario.exposure_us)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_clip_lies_in_its_scenario_and_one_instrument_serves_all() {
        for clip in MISSION.iter().chain(&WIDE_LIMB) {
            assert!(clip.from_s + clip.seconds <= scenario(clip).unwrap().duration_s, "{clip:?}");
        }
        assert_eq!(MISSION.iter().map(|clip| clip.seconds).sum::<u32>(), 132);
        for clips in [&MISSION[..], &WIDE_LIMB] {
            assert!(instrument(clips).unwrap().1.check().is_ok());
        }
        assert!(instrument(&[MISSION[0], WIDE_LIMB[0]]).is_err());
    }
}
