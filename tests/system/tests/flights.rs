//! Flights of the program's own scenarios, second by second.

use sil_host::campaign::family::Family;
use sil_host::harness::{self, Second};
use sil_host::scenario::Scenario;
use std::path::Path;

/// A scenario of so many seconds.
pub fn scenario(name: &str, seconds: u32) -> Scenario {
    let mut scenario = Scenario::load(Path::new(name)).unwrap();
    scenario.duration_s = seconds;
    scenario
}

/// A flight of a family of tests/families: its base, what is drawn, seed and run.
pub fn member(base: &str, vary: &str, seed: u64, run: u64) -> Scenario {
    let [base, vary] = [base, vary].map(|name| Path::new("../families").join(name));
    Family::new(Some(&base), Some(&vary)).unwrap().member(seed, run).unwrap().0
}

/// Flies a scenario and shows each second to `look`.
pub fn fly(scenario: &Scenario, mut look: impl FnMut(Second<'_>)) {
    harness::fly(scenario, &mut scenario.scene().unwrap(), |second| {
        look(second);
        Ok(())
    })
    .unwrap();
}
