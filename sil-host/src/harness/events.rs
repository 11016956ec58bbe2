//! What happened in a second, in words.

use crate::judge::expected::word;
use fsw_core::modes::Guard;
use fsw_core::telemetry::Event;

/// Why a mode was left.
pub(crate) fn reason(guard: Guard) -> &'static str {
    match guard {
        Guard::SelfTestPassed => "self-test passed",
        Guard::AttitudeKnown => "attitude and rate known",
        Guard::AttitudeLost => "attitude lost",
        Guard::EarthDark => "no lit limb in the field",
        Guard::EarthLit => "lit limb in the field",
        Guard::Blinded => "detector blinded",
        Guard::SunGone => "no longer blinded",
        Guard::TimedOut => "mode lasted too long",
        Guard::Faults => "faults in a row",
        Guard::Healthy => "self-test passed again",
        Guard::Commanded => "commanded",
        Guard::MemoryDamaged => "memory damaged",
    }
}

/// An event in words, without comma or semicolon.
pub fn words(event: &Event) -> String {
    match event {
        Event::Mode(mode, guard) => format!("to {}: {}", word(*mode), reason(*guard)),
        Event::OrbitStarted => "first orbit found and tested".into(),
        Event::OrbitConverged => "orbit converged".into(),
        Event::FixDownweighted => "observation of the Earth contradicts the orbit".into(),
        Event::OrbitRestarted => "orbit diverged, begins anew".into(),
        Event::OrbitForgotten => "orbit forgotten".into(),
        Event::ClockJump => "clock jump".into(),
        Event::SunInPath => "Sun in a path by prediction".into(),
        Event::ParametersRestored => "parameters restored from their copy".into(),
        Event::ParametersLost => "parameters and their copy damaged".into(),
        Event::CatalogueDamaged => "catalogue damaged".into(),
        Event::CalibrationDamaged => "calibration damaged".into(),
        Event::RateSensorShutOut => "rate sensor contradicted and shut out".into(),
        Event::MagnetometerShutOut => "magnetometer contradicted and shut out".into(),
        Event::TimeForgotten => "time damaged and forgotten".into(),
        Event::GroundForgotten => "usual ground damaged and forgotten".into(),
        Event::ShuttersReleased => "command of the shutters damaged: both opened".into(),
        Event::Overran => "the second before took too long".into(),
    }
}

/// Whether the orbit began or ended with an event.
pub fn is_restart(event: &Event) -> bool {
    matches!(event, Event::OrbitStarted | Event::OrbitRestarted | Event::OrbitForgotten)
}
