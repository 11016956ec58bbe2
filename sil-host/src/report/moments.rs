//! Seconds worth a picture, chosen while the run goes by: the first rate, the first identification, the
//! longest and the shortest lit limb tracked, eclipse, the Sun in a path, the end.

use crate::harness::Second;
use crate::world::scene::SensorState;
use fsw_core::modes::Mode;
use fsw_core::telemetry::{Outcome, Report};

/// A lit limb must be this much longer or shorter to replace the one kept, deg.
const BETTER_BY_DEG: f64 = 5.0;
/// Seconds into an eclipse or a Sun outage at which it is shown.
const INTO_S: u32 = 60;
/// A crescent is at least this long, deg.
const CRESCENT_DEG: f64 = 12.0;

/// A second to be shown.
#[derive(Clone, Debug)]
pub struct Moment {
    /// What it shows.
    pub title: &'static str,
    /// Its report.
    pub report: Report,
    /// Lit limb in the field, deg.
    pub lit_limb_deg: f64,
}

/// The moments so far.
#[derive(Clone, Debug, Default)]
pub struct Moments {
    rate: Option<Moment>,
    first: Option<Moment>,
    fullest: Option<Moment>,
    crescent: Option<Moment>,
    eclipse: Option<Moment>,
    sun: Option<Moment>,
    last: Option<Moment>,
    seconds_in_state: u32,
    state: Option<SensorState>,
}

impl Moments {
    /// Looks at a second; `is_last` is the run's last.
    pub fn look(&mut self, second: &Second<'_>, is_last: bool) {
        let Second { report, truth, .. } = *second;
        let state = truth.state;
        self.seconds_in_state = if self.state == Some(state) { self.seconds_in_state + 1 } else { 0 };
        self.state = Some(state);
        let taken = |title| Some(Moment { title, report: report.clone(), lit_limb_deg: truth.lit_limb_deg });
        if self.rate.is_none() && report.rate.is_some() {
            self.rate = taken("First rate, without an attitude");
        }
        if self.first.is_none() && report.outcome == Some(Outcome::Identified) {
            self.first = taken("First identification, without prior knowledge");
        }
        let lit = truth.lit_limb_deg;
        if report.mode == Mode::Tracking
            && report.outcome == Some(Outcome::Tracked)
            && state == SensorState::Full
        {
            let longer = |kept: &Moment| lit > kept.lit_limb_deg + BETTER_BY_DEG;
            if self.fullest.as_ref().is_none_or(longer) {
                self.fullest = taken("Tracking, the longest lit limb");
            }
            let shorter = |kept: &Moment| lit < kept.lit_limb_deg - BETTER_BY_DEG;
            let first = self.fullest.as_ref().is_some_and(shorter);
            if lit >= CRESCENT_DEG && self.crescent.as_ref().map_or(first, shorter) {
                self.crescent = taken("Tracking, the shortest lit limb");
            }
        }
        if self.seconds_in_state == INTO_S {
            match state {
                SensorState::Full => {}
                SensorState::Eclipse if self.eclipse.is_none() => {
                    self.eclipse = taken("Eclipse: stars alone")
                }
                SensorState::Eclipse => {}
                _ if self.sun.is_none() => self.sun = taken("The Sun in a path"),
                _ => {}
            }
        }
        if is_last {
            self.last = taken("The last second");
        }
    }

    /// In the order of time.
    pub fn into_vec(self) -> Vec<Moment> {
        let Self { rate, first, fullest, crescent, eclipse, sun, last, .. } = self;
        let mut moments: Vec<Moment> =
            [rate, first, fullest, crescent, eclipse, sun, last].into_iter().flatten().collect();
        moments.sort_by_key(|moment| moment.report.cycle);
        moments.dedup_by_key(|moment| moment.report.cycle);
        moments
    }
}
