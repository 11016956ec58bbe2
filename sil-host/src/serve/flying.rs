//! The flight's thread: the flight that `run` flies ([`crate::harness::Flight`]), second after second as the
//! desk allows.

use super::desk::{Desk, Turn};
use super::log::{End, Log, Run, Title};
use super::world::World;
use crate::commands::run::bounded::BoundedJudge;
use crate::error::HostError;
use crate::harness::{self, Flight};
use crate::judge::Verdict;
use crate::report::opinion::Opinion;
use crate::scenario::Scenario;
use std::sync::Arc;
use std::time::Instant;

/// Flies what the desk asks for, one flight after the other.
pub fn work(desk: &Desk) {
    loop {
        if let Err(error) = fly(desk, &desk.next_flight()) {
            desk.complain(&error);
        }
    }
}

/// One flight, until it is over or something else is to be shown.
fn fly(desk: &Desk, scenario: &Scenario) -> Result<(), HostError> {
    let mut scene = scenario.scene()?;
    let world = World::new(scenario.clone(), scene.clone());
    harness::with_flight(scenario, &mut scene, |flight| {
        let log = Log { faults: scenario.faults.clone(), ..Log::default() };
        let run = Arc::new(Run::new(Title::of(desk.number(), scenario), Ok(world), log));
        desk.show(&run);
        seconds(desk, scenario, flight, &run)
    })
}

/// The seconds of a flight.
fn seconds(desk: &Desk, scenario: &Scenario, flight: &mut Flight<'_>, run: &Run) -> Result<(), HostError> {
    let mut judge = BoundedJudge::new(scenario);
    let mut injected = 0;
    for cycle in 0..scenario.duration_s {
        let Turn::Fly(faults) = desk.turn(cycle) else { return Ok(()) };
        for fault in faults {
            injected += 1;
            flight.inject(fault);
            run.log().faults.push(fault);
        }
        let began = Instant::now();
        flight.second(|second| {
            let host_ms = 1e3 * began.elapsed().as_secs_f64();
            let mode_right = judge.add(&second);
            run.add(second, mode_right, host_ms);
            Ok(())
        })?;
    }
    let figures = judge.finish();
    let opinion = Opinion::of(&figures, &Verdict::all(&scenario.limits, &figures));
    let by_hand = match injected {
        0 => String::new(),
        _ => format!(" {injected} faults were injected by hand: the limits are not meant for them."),
    };
    let words = format!("{} {}{by_hand}", opinion.sentence(), opinion.reached);
    run.log().end = Some(End::new(opinion.grade, words));
    desk.pause();
    Ok(())
}
