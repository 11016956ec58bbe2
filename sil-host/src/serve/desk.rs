//! What the page and the flight share: the run that is shown, and the controls.
//!
//! Requests set the controls; the flight, in a thread of its own, asks before every second what to do
//! ([`Desk::turn`]) and waits here while it is paused or faster than it should be.

use super::faults;
use super::log::{End, Run};
use crate::error::HostError;
use crate::harness::faults::Fault;
use crate::report::opinion::Grade;
use crate::scenario::Scenario;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How fast a flight goes when nothing is said, times real time.
const SPEED: f64 = 10.0;

/// What the flight's thread does next.
#[derive(Debug)]
enum Next {
    /// Another flight.
    Fly(Box<Scenario>),
    /// Nothing more: a recorded run is shown.
    Leave,
}

/// The controls.
#[derive(Debug)]
pub struct Controls {
    /// Whether the flight goes on by itself.
    pub running: bool,
    /// Seconds that it shall go on though it is paused.
    pub steps: u32,
    /// Times real time; none: as fast as it goes.
    pub speed: Option<f64>,
    /// What went wrong last.
    pub message: Option<String>,
    /// Whether a flight is being made ready.
    pub preparing: bool,
    /// Number of the last run.
    last_run: u32,
    run: Option<Arc<Run>>,
    next: Option<Next>,
    /// Faults of buttons that are to act from the next second on.
    faults: Vec<String>,
    /// When the next second is due.
    due: Instant,
}

impl Controls {
    /// The run that is shown.
    pub fn run(&self) -> Option<&Arc<Run>> {
        self.run.as_ref()
    }

    /// A fault of this kind from the next second on.
    pub fn inject(&mut self, kind: String) {
        self.faults.push(kind);
    }
}

/// What is to be done before a second.
#[derive(Debug, PartialEq)]
pub enum Turn {
    /// Fly it, with these faults from now on.
    Fly(Vec<Fault>),
    /// The flight is over: something else is to be shown.
    Leave,
}

/// Shared by requests and flight.
#[derive(Debug)]
pub struct Desk {
    controls: Mutex<Controls>,
    changed: Condvar,
}

impl Default for Desk {
    fn default() -> Self {
        let controls = Controls {
            running: false,
            steps: 0,
            speed: Some(SPEED),
            message: None,
            preparing: false,
            last_run: 0,
            run: None,
            next: None,
            faults: Vec::new(),
            due: Instant::now(),
        };
        Self { controls: Mutex::new(controls), changed: Condvar::new() }
    }
}

impl Desk {
    /// The controls as they are.
    pub fn controls(&self) -> MutexGuard<'_, Controls> {
        self.controls.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the controls, and tells the flight.
    pub fn set(&self, change: impl FnOnce(&mut Controls)) {
        let mut controls = self.controls();
        controls.message = None;
        let before = (controls.running, controls.speed);
        change(&mut controls);
        if before != (controls.running, controls.speed) {
            controls.due = Instant::now();
        }
        self.changed.notify_all();
    }

    /// Has another flight made ready, paused before its first second.
    pub fn fly(&self, scenario: Scenario) {
        self.set(|controls| {
            (controls.running, controls.steps) = (false, 0);
            controls.faults.clear();
            controls.preparing = true;
            controls.next = Some(Next::Fly(Box::new(scenario)));
        });
    }

    /// Shows a recorded run, which `open` makes of its number; the flight ends.
    ///
    /// # Errors
    /// What `open` says.
    pub fn open(&self, open: impl FnOnce(u32) -> Result<Run, HostError>) -> Result<(), HostError> {
        let run = open(self.number())?;
        self.set(|controls| {
            (controls.running, controls.steps) = (false, 0);
            controls.faults.clear();
            controls.preparing = false;
            controls.run = Some(Arc::new(run));
            controls.next = Some(Next::Leave);
        });
        Ok(())
    }

    /// The number of a new run.
    pub fn number(&self) -> u32 {
        let mut controls = self.controls();
        controls.last_run += 1;
        controls.last_run
    }

    /// Shows a flight, unless something else is to be shown by now.
    pub fn show(&self, run: &Arc<Run>) {
        let mut controls = self.controls();
        if controls.next.is_none() {
            controls.preparing = false;
            controls.run = Some(run.clone());
        }
    }

    /// Says what went wrong: the flight is over.
    pub fn complain(&self, error: &HostError) {
        let mut controls = self.controls();
        if let Some(run) = &controls.run {
            let end = || End::new(Grade::Missed, "The flight broke off.".into());
            run.log().end.get_or_insert_with(end);
        }
        (controls.running, controls.steps) = (false, 0);
        controls.preparing = matches!(controls.next, Some(Next::Fly(_)));
        controls.message = Some(error.to_string());
    }

    /// Pauses.
    pub fn pause(&self) {
        let mut controls = self.controls();
        (controls.running, controls.steps) = (false, 0);
    }

    /// Waits for the next flight.
    pub fn next_flight(&self) -> Scenario {
        let mut controls = self.controls();
        loop {
            if let Some(Next::Fly(scenario)) = controls.next.take() {
                return *scenario;
            }
            controls = self.changed.wait(controls).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Waits until the second `cycle` is due.
    pub fn turn(&self, cycle: u32) -> Turn {
        let mut controls = self.controls();
        loop {
            if controls.next.is_some() {
                return Turn::Leave;
            }
            let now = Instant::now();
            let due = match controls.speed {
                Some(_) => controls.due.max(now),
                None => now,
            };
            let stepping = controls.steps > 0;
            if stepping || (controls.running && due <= now) {
                controls.steps = controls.steps.saturating_sub(1);
                let second =
                    controls.speed.map_or(Duration::ZERO, |times| Duration::from_secs_f64(1.0 / times));
                // Of a second that took longer than it should the time is not made up.
                controls.due = (controls.due + second).max(now);
                let words = std::mem::take(&mut controls.faults);
                return Turn::Fly(words.iter().filter_map(|word| faults::from_second(word, cycle)).collect());
            }
            controls = if controls.running {
                let (controls, _) = self
                    .changed
                    .wait_timeout(controls, due.saturating_duration_since(now))
                    .unwrap_or_else(PoisonError::into_inner);
                controls
            } else {
                self.changed.wait(controls).unwrap_or_else(PoisonError::into_inner)
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_paused_flight_goes_on_by_steps_only_and_takes_its_faults_along() {
        let desk = Desk::default();
        desk.set(|controls| {
            controls.steps = 2;
            controls.inject("blinded".into());
        });
        let Turn::Fly(injected) = desk.turn(5) else { panic!("it leaves") };
        assert_eq!((injected.len(), injected[0].from_s), (1, 5));
        assert_eq!(desk.turn(6), Turn::Fly(vec![]));
        assert_eq!(desk.controls().steps, 0);
        desk.fly(Scenario::default_embedded());
        assert_eq!(desk.turn(7), Turn::Leave);
        assert_eq!(desk.next_flight().name, "geo-eclipse");
    }

    #[test]
    fn a_running_flight_keeps_its_speed() {
        let desk = Desk::default();
        desk.set(|controls| (controls.running, controls.speed) = (true, Some(50.0)));
        let began = Instant::now();
        (0..6).for_each(|cycle| assert_eq!(desk.turn(cycle), Turn::Fly(vec![])));
        assert!(began.elapsed() >= Duration::from_millis(99), "{:?}", began.elapsed());
        desk.set(|controls| controls.speed = None);
        (6..2000).for_each(|cycle| assert_eq!(desk.turn(cycle), Turn::Fly(vec![])));
    }
}
