//! `sil-host budget`: what a second costs on the reference on-board computer, against its limits.
//!
//! Builds the flight image and the cycle meter, records the
//! [mission](crate::commands::record::mission) through every mode, the widest limb, a storm of protons, one
//! in a crowded field, a sunrise with a gyro, a shut star path and known bad pixels, flies them in the emulator and prints, per mode and stage,
//! the worst cycles observed, the cycles at the caps (`bounds`), flash, static RAM and stack. The stack is
//! the deeper of two: the deepest path through the calls of the machine code (`tests/stack-depth`, which also
//! proves that nothing calls itself and no call's target is unknown), and what was touched. Status 1 when a
//! limit is overrun or the target's telemetry is not the host's to the byte. Cycles are those of the meter's
//! model (Cortex-M4F, zero wait states, no interrupts); the cost of reading pixels from a real detector is
//! not in them. With `--wait-states W` every line of 16 bytes of code and every word loaded costs W more, as
//! from a flash without cache and prefetch: a bound, held against the same limits.
//!
//! What stars and Earth cost of a second, several stages each, is held against limits of its own, in
//! acquisition too where the limb is predicted: the first strips after a search are as long as strips can be.
//! A row is a mode. Three kinds of seconds have rows of their own, whatever their mode, and the limit of
//! acquisition: those in which the whole detector is searched for the Earth, those of a Sun outage in which it
//! is searched for stars, and those in which the orbit crosses a jump of the clock.

mod bounds;
mod flown;
mod limits;
mod loops;
mod table;

use crate::cli::BudgetArguments;
use crate::commands::record::mission::{CROWD, EARTH_ALONE, GYRO, MISSION, STORM, SURVEYED, WIDE_LIMB};
use crate::error::{EXIT_JUDGED_FAILED, HostError};
use crate::formats::json;
use bounds::Bounds;
use flown::{Flown, fly};
use std::process::ExitCode;
use table::table;

/// Names of the flights that drive stages to their caps.
const EVERY_MODE: &str = "every mode";
const WIDEST_LIMB: &str = "widest limb";
const PROTON_STORM: &str = "storm";
const CROWDED_FIELD: &str = "crowd";
const KNOWN_PIXELS: &str = "known pixels";
const STARLESS: &str = "Earth alone";

/// Runs the command.
///
/// # Errors
/// Outside the repository, or when building or emulating fails.
pub fn run(arguments: &BudgetArguments) -> Result<ExitCode, HostError> {
    let root = limits::workspace()?;
    let limits = limits::read(&root)?;
    // The emulator takes no blanks in a file name, which a folder of the system's for such files does not
    // have.
    let folder = std::env::temp_dir().join(format!("sextant-budget-{}", std::process::id()));
    let flights = [
        (EVERY_MODE, MISSION),
        (WIDEST_LIMB, WIDE_LIMB),
        (PROTON_STORM, STORM),
        (CROWDED_FIELD, CROWD),
        ("gyro", GYRO),
        (STARLESS, EARTH_ALONE),
        (KNOWN_PIXELS, SURVEYED),
    ];
    let counted = loops::counted_functions();
    let flights = flights.iter().map(|(name, flight)| fly(&root, (name, flight), &folder, &counted));
    let flights: Result<Vec<Flown>, HostError> = flights.collect();
    let _ = std::fs::remove_dir_all(&folder);
    let mut flights = flights?;
    for flown in &mut flights {
        flown.wait(arguments.wait_states.into());
    }
    let bounds = Bounds::new(&flights)?;
    let budget = table(&limits, arguments.wait_states, &flights, &bounds);
    if arguments.json {
        json::print_line(&budget);
    } else {
        budget.print();
    }
    Ok(if budget.kept() { ExitCode::SUCCESS } else { ExitCode::from(EXIT_JUDGED_FAILED) })
}
