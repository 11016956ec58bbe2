//! `report.html`: a run on one page that needs nothing else.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`trace`] | values, second by second | curves of constant length that keep every spike |
//! | [`scale`] | a curve's values | heights and ticks |
//! | [`plot`] | curves | inline SVG |
//! | [`moments`] | seconds | the few worth a picture |
//! | [`frames`] | such a second | the frame with what was found on it |
//! | [`figures_table`] | the judge's figures | lines for page and terminal |
//! | [`page`] | all of these | the page |
//!
//! No scripts, no fonts, no links to elsewhere; colours follow the reader's light or dark. Nothing in it
//! depends on the time of day, so that equal runs give equal files.

pub mod figures_table;
pub mod frames;
pub mod moments;
pub mod page;
pub mod plot;
pub mod scale;
pub mod trace;

use crate::judge::arcsec;
use crate::judge::expected::mode_of;
use crate::judge::second::Judged;
use crate::run::events;
use crate::run::harness::Second;
use crate::world::scene::SensorState;
use fsw_core::modes::Mode;
use moments::Moments;
use trace::{Banded, Marks, Stretches, Trace};

/// Most events listed; the others are counted.
const EVENTS_MAX: usize = 120;

/// Rows of the plot of modes, a mode each, in the order in which they are drawn.
pub const MODE_ROWS: [&str; 6] = ["tracking", "eclipse", "Sun outage", "acquisition", "self-test", "safe"];

/// The row of a mode.
fn row_of(mode: Mode) -> u8 {
    match mode {
        Mode::Tracking => 0,
        Mode::Eclipse => 1,
        Mode::SunOutage => 2,
        Mode::Acquisition => 3,
        Mode::SelfTest => 4,
        Mode::Safe => 5,
    }
}

/// What the page needs of the seconds gone by; its size does not depend on their number.
#[derive(Clone, Debug)]
pub struct Recorder {
    stretches: Stretches,
    geometry: Marks,
    expected: Marks,
    flown: Marks,
    wrong: Marks,
    attitude: [Banded; 3],
    rate: [Trace; 3],
    position: [Banded; 3],
    velocity: [Banded; 3],
    earth: [Banded; 3],
    limb_height: Banded,
    stars: Trace,
    limb_points: Trace,
    lit_limb: Trace,
    nis: Trace,
    events: Vec<(u32, String)>,
    events_left_out: u32,
    moments: Moments,
}

impl Recorder {
    /// For a run of `seconds`.
    pub fn new(seconds: u32) -> Self {
        let stretches = Stretches::of(seconds);
        let (marks, trace, banded) = (Marks::new(stretches), Trace::new(stretches), Banded::new(stretches));
        let three = || [banded.clone(), banded.clone(), banded.clone()];
        Self {
            stretches,
            geometry: marks.clone(),
            expected: marks.clone(),
            flown: marks.clone(),
            wrong: marks,
            attitude: three(),
            rate: [trace.clone(), trace.clone(), trace.clone()],
            position: three(),
            velocity: three(),
            earth: three(),
            limb_height: banded,
            stars: trace.clone(),
            limb_points: trace.clone(),
            lit_limb: trace.clone(),
            nis: trace,
            events: Vec::new(),
            events_left_out: 0,
            moments: Moments::default(),
        }
    }

    /// Adds a second; `mode_right` is the judge's word on its mode.
    pub fn add(&mut self, second: &Second<'_>, mode_right: bool) {
        let Second { cycle, report, truth, judged, .. } = *second;
        let at = self.stretches.index(cycle);
        match truth.state {
            SensorState::Full => {}
            SensorState::Eclipse => self.geometry.add(at, plot::DARK),
            _ => self.geometry.add(at, plot::SUN),
        }
        self.expected.add(at, row_of(mode_of(truth.state)));
        self.flown.add(at, row_of(report.mode));
        if !mode_right {
            self.wrong.add(at, row_of(report.mode));
        }
        self.add_errors(at, judged);
        self.stars.add(at, judged.stars.into());
        self.limb_points.add(at, judged.limb_points.into());
        self.lit_limb.add(at, truth.lit_limb_deg);
        for fault in second.faults {
            if fault.from_s == cycle {
                self.note(
                    cycle,
                    format!("fault injected for {} s: {}", fault.until_s - cycle, fault.kind.word()),
                );
            }
        }
        for event in &report.events {
            self.note(cycle, events::words(event));
        }
        self.moments.look(second, cycle + 1 == self.stretches.seconds);
    }

    fn note(&mut self, cycle: u32, words: String) {
        if self.events.len() < EVENTS_MAX {
            self.events.push((cycle, words));
        } else {
            self.events_left_out += 1;
        }
    }

    fn add_errors(&mut self, at: usize, judged: &Judged) {
        if let Some(attitude) = &judged.attitude_rad {
            for axis in 0..3 {
                self.attitude[axis].add(at, arcsec(attitude.error[axis]), arcsec(attitude.sigma[axis]));
            }
        }
        if let Some(rate) = judged.rate_rad_s {
            for (trace, error) in self.rate.iter_mut().zip(rate) {
                trace.add(at, arcsec(error));
            }
        }
        if let Some(earth) = &judged.earth {
            let sigma_deg = earth.sigma_rad.to_degrees();
            self.earth[0].add(at, earth.across_rad[0].to_degrees(), sigma_deg);
            self.earth[1].add(at, earth.across_rad[1].to_degrees(), sigma_deg);
            self.earth[2].add(at, earth.distance_km, earth.sigma_km);
        }
        if let Some(orbit) = &judged.orbit {
            for axis in 0..3 {
                let (position, velocity) = (&orbit.position_rac_km, &orbit.velocity_rac_km_s);
                self.position[axis].add(at, position.error[axis], position.sigma[axis]);
                self.velocity[axis].add(at, 1e3 * velocity.error[axis], 1e3 * velocity.sigma[axis]);
            }
            let [height, sigma] = orbit.limb_height_km;
            self.limb_height.add(at, height, sigma);
            if let Some([square, freedom]) = orbit.nis {
                self.nis.add(at, square / freedom.max(1.0));
            }
        }
    }
}

#[cfg(test)]
#[path = "report_tests.rs"]
mod tests;
