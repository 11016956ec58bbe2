//! The mission that the emulated computer flies: clips of scenarios, one after the other, through every mode.
//!
//! In: [`CLIPS`]. Out: a frame a second and the parameter table for them. Between two clips the clock jumps; what the
//! flight code makes of that (a gap that it crosses, one too long, a step backwards) is part of the mission.
//!
//! | clip | what is new in it |
//! |---|---|
//! | dusk in a low orbit | self-test, acquisition, tracking with the orbit started, eclipse |
//! | sunrise, 50 min later | the gap is crossed; stars lost, acquisition; Sun outage until its time-out, safe mode, self-test |
//! | the Sun leaves, 3 min later | Sun outage ends, acquisition, tracking along a bright limb |
//! | GEO, the whole Earth, earlier | the orbit is forgotten; tracking with the limb all around |
//! | GEO, the Sun leaves, 4 h later | a thin crescent: the whole detector is searched for the limb, second after second |
//!
//! Time-outs are as short as the table allows, so that 120 seconds suffice; all else is the scenarios' own.

use crate::error::HostError;
use crate::frames_file::FramesWriter;
use crate::run::harness::ThisSecond;
use crate::scenario::Scenario;
use fsw_core::modes::ModeParameters;
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

/// The clips, in order.
pub const CLIPS: [Clip; 5] = [
    Clip { scenario: "sso-noon-midnight", from_s: 640, seconds: 50 },
    Clip { scenario: "sso-noon-midnight", from_s: 3721, seconds: 23 },
    Clip { scenario: "sso-noon-midnight", from_s: 3900, seconds: 14 },
    Clip { scenario: "geo-eclipse", from_s: 0, seconds: 15 },
    Clip { scenario: "geo-eclipse", from_s: 13_672, seconds: 18 },
];

/// Seconds of the mission.
pub const SECONDS: u32 = {
    let [a, b, c, d, e] = CLIPS;
    a.seconds + b.seconds + c.seconds + d.seconds + e.seconds
};

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

/// The detector and its flight parameters: those of the first clip's scenario, with the mission's time-outs.
///
/// # Errors
/// When the clips need different ones: camera and mount must be the same in all. (The exposure may differ: frames in a
/// file have been exposed.)
pub fn instrument() -> Result<(DetectorGeometry, Parameters), HostError> {
    let first = scenario(&CLIPS[0])?;
    let geometry = first.camera.geometry();
    let parameters = Parameters { modes: MODES, ..first.flight_parameters() };
    for clip in &CLIPS {
        let other = scenario(clip)?;
        let exposure_us = parameters.exposure_us;
        let needed = Parameters { modes: MODES, exposure_us, ..other.flight_parameters() };
        if needed != parameters || other.camera.geometry() != geometry {
            let what = format!("{} needs another instrument than {}", clip.scenario, CLIPS[0].scenario);
            return Err(HostError::usage(what, "report this"));
        }
    }
    Ok((geometry, parameters))
}

/// Writes the frames.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(writer: &mut FramesWriter) -> Result<(), HostError> {
    for clip in &CLIPS {
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
        for clip in &CLIPS {
            assert!(clip.from_s + clip.seconds <= scenario(clip).unwrap().duration_s, "{clip:?}");
        }
        assert_eq!(SECONDS, 120);
        assert!(instrument().unwrap().1.check().is_ok());
    }
}
