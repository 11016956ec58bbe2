//! What the page's buttons ask for, in JSON: `{"do":"step","seconds":10}`.

use super::desk::Desk;
use super::{Library, faults, recorded};
use crate::error::HostError;
use serde::Deserialize;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Speeds that can be set, times real time.
const SPEEDS: RangeInclusive<f64> = 0.1..=10_000.0;

/// An order.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(tag = "do", rename_all = "kebab-case")]
pub enum Order {
    /// The flight goes on by itself.
    Start,
    /// It waits.
    Pause,
    /// A paused flight goes on by so many seconds.
    Step {
        /// How many.
        seconds: u32,
    },
    /// How fast it goes on by itself.
    Speed {
        /// Times real time; none: as fast as it goes.
        times: Option<f64>,
    },
    /// Another flight, paused before its first second.
    Fly {
        /// Its name, one of the library's.
        scenario: String,
        /// Its seed; none: the scenario's own.
        seed: Option<u64>,
    },
    /// A fault of a button, from the next second on.
    Fault {
        /// Its word ([`crate::harness::faults::FaultKind::word`]).
        kind: String,
    },
    /// A recorded run is shown.
    Open {
        /// The folder that `run --out` wrote.
        folder: PathBuf,
    },
}

/// Carries an order out.
///
/// # Errors
/// When it cannot be: in one line what is wrong.
pub fn carry_out(order: Order, desk: &Desk, library: &Library) -> Result<(), HostError> {
    let run = desk.controls().run().cloned();
    let in_flight = run.filter(|run| run.title.folder.is_none());
    let needs_flight = matches!(order, Order::Start | Order::Step { .. } | Order::Fault { .. });
    let gyro = in_flight.as_ref().is_some_and(|run| run.title.gyro);
    if needs_flight && in_flight.is_none_or(|run| run.log().end.is_some()) {
        return Err(HostError::usage("no flight is under way", "begin one by New flight"));
    }
    match order {
        Order::Start => desk.set(|controls| controls.running = true),
        Order::Pause => desk.pause(),
        Order::Step { seconds } => desk.set(|controls| {
            controls.running = false;
            controls.steps = controls.steps.saturating_add(seconds);
        }),
        Order::Speed { times } => {
            if times.is_some_and(|times| !SPEEDS.contains(&times)) {
                return Err(HostError::usage(
                    "no such speed",
                    format!("use {} to {}, or none", SPEEDS.start(), SPEEDS.end()),
                ));
            }
            desk.set(|controls| controls.speed = times);
        }
        Order::Fly { scenario, seed } => desk.fly(library.scenario(&scenario)?.with_seed(seed)),
        Order::Fault { kind } => {
            if faults::from_second(&kind, 0).is_none() {
                return Err(HostError::usage(format!("`{kind}` is no fault of a button"), "use one of them"));
            }
            if kind == "gyro-silent" && !gyro {
                return Err(HostError::usage("there is no gyro on board", "fly tumbling"));
            }
            desk.set(|controls| controls.inject(kind));
        }
        Order::Open { folder } => desk.open(|run| recorded::open(run, &folder, &library.scenarios))?,
    }
    Ok(())
}
