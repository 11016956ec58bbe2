//! Flights of the program's own scenarios, second by second.

use sil_host::harness::{self, Second};
use sil_host::scenario::Scenario;
use std::path::Path;

/// A scenario of so many seconds.
pub fn scenario(name: &str, seconds: u32) -> Scenario {
    let mut scenario = Scenario::load(Path::new(name)).unwrap();
    scenario.duration_s = seconds;
    scenario
}

/// Flies a scenario and shows each second to `look`.
pub fn fly(scenario: &Scenario, mut look: impl FnMut(Second<'_>)) {
    harness::fly(scenario, &mut scenario.scene().unwrap(), |second| {
        look(second);
        Ok(())
    })
    .unwrap();
}
