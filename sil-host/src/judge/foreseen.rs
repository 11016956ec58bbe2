//! The sensor's next change of state as it foresees it, held against what then comes.
//!
//! In: every second's true state and what was foreseen in it. Out: how often something is, and the errors of
//! the time and of the length. A change that is foreseen is held against the nearest true one to the same
//! state; one that falls beyond the run, or within five of its sigmas before the end, against none.

use super::second::{Axes, Judged};
use super::series::Series;
use super::sums::{Share, Sizes};
use crate::world::scene::SensorState;
use fsw_core::telemetry::NextState;

/// The length of a state whose begin is known no better says more of the orbit than of the length, s.
const WELL_KNOWN_S: f64 = 5.0;

/// What was foreseen in a run, and what came.
#[derive(Clone, Debug, Default)]
pub struct Foreseen {
    /// The true state of the second before.
    state: Option<SensorState>,
    /// Seconds in which it was another than before, and which.
    changes: Vec<(u32, SensorState)>,
    /// Second and what was foreseen in it.
    told: Vec<(u32, NextState)>,
    /// Of the seconds with attitude and orbit those in which something was.
    share: Share,
    seconds: u32,
}

/// What it comes to.
#[derive(Clone, Debug)]
pub struct Agreement {
    /// Share of the seconds with attitude and orbit in which something was foreseen.
    pub share: Option<f64>,
    /// Errors of the time until the change, s.
    pub time_s: Series,
    /// Errors of the length that the new state has, where its begin is known to 5 s, s.
    pub length_s: Sizes,
}

impl Foreseen {
    /// Adds a second.
    pub fn add(&mut self, second: &Judged) {
        self.seconds = second.cycle + 1;
        if self.state.replace(second.state).is_some_and(|before| before != second.state) {
            self.changes.push((second.cycle, second.state));
        }
        if second.locally_known {
            self.share.add(second.next_state.is_some());
        }
        self.told.extend(second.next_state.map(|next| (second.cycle, next)));
    }

    /// The true change to a state nearest to a second: its second, and how long the state lasts.
    fn nearest(&self, state: u8, second: f64) -> Option<(f64, Option<f64>)> {
        let of_state = self.changes.iter().enumerate().filter(|(_, (_, new))| *new as u8 == state);
        let distance = |at: u32| (f64::from(at) - second).abs();
        let (index, (at, _)) = of_state.min_by(|(_, a), (_, b)| distance(a.0).total_cmp(&distance(b.0)))?;
        let ends = self.changes.get(index + 1).map(|(end, _)| f64::from(end - at));
        Some((f64::from(*at), ends))
    }

    /// What it all comes to. Where no change to the state came at all the error is as long as the run.
    pub fn finish(&self) -> Agreement {
        let (mut time_s, mut length_s) = (Series::new(1), Sizes::default());
        let end = f64::from(self.seconds);
        for (cycle, next) in &self.told {
            let sigma = f64::from(next.sigma_s);
            let at = f64::from(*cycle) + f64::from(next.in_s);
            if at + 5.0 * sigma >= end {
                continue;
            }
            let came = self.nearest(next.state as u8, at);
            let error = came.map_or(end, |(truly, _)| at - truly);
            time_s.add(*cycle, Axes { error: [error, 0.0, 0.0], sigma: [sigma; 3] });
            let lasted = came.and_then(|(_, lasted)| lasted);
            if let Some((told, lasted)) = next.lasts_s.zip(lasted)
                && sigma < WELL_KNOWN_S
            {
                length_s.add(f64::from(told) - lasted);
            }
        }
        Agreement { share: self.share.value(), time_s, length_s }
    }
}

#[cfg(test)]
mod tests;
