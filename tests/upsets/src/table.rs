//! What all flights came to: how many of each outcome, how long attitude and orbit were lost, how the
//! quantities were told with turned bits and without, and which flights were the worst.

use crate::FlyArguments;
use crate::flight::{Flown, Told, WRONG_SIGMA};
use crate::memory::{Flip, Part, STATE_BYTES, WORKSPACE_BYTES};
use serde::Serialize;
use sil_host::campaign::spread::{Spread, share_interval_percent};
use std::collections::BTreeMap;

/// Most flights that are listed.
const LISTED: usize = 12;

/// A quantity over all flights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Pooled {
    /// With turned bits and without.
    pub told: [Told; 2],
    /// Flights in which the turned bits made it wrong.
    pub wrong: usize,
}

/// All flights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// Flights.
    pub flights: usize,
    /// Bits turned over.
    pub flips: usize,
    /// Flights whose telemetry is that of the flight without, to the last byte.
    pub no_effect: usize,
    /// Flights whose telemetry is another, nothing lost and nothing wrong.
    pub changed: usize,
    /// Flights in which attitude or orbit were lost for a while, with no restart and nothing wrong.
    pub lost: usize,
    /// Flights in which the computer ended and began anew, nothing wrong.
    pub restarted: usize,
    /// Flights in which something was told wrong.
    pub told_wrong: usize,
    /// How computers ended.
    pub ended: BTreeMap<String, usize>,
    /// Seconds without readable telemetry, the computer flying.
    pub unreadable: u32,
    /// Longest loss of the attitude, over the flights that lost it, s.
    pub attitude_lost_s: Option<Spread>,
    /// The same of the orbit.
    pub orbit_lost_s: Option<Spread>,
    /// The quantities.
    pub quantities: BTreeMap<String, Pooled>,
}

/// Which of the outcomes a flight had; the gravest counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    NoEffect,
    Changed,
    Lost,
    Restarted,
    Wrong,
}

fn outcome(flown: &Flown) -> Outcome {
    if !flown.wrong.is_empty() {
        Outcome::Wrong
    } else if !flown.ended.is_empty() {
        Outcome::Restarted
    } else if flown.attitude_lost_s[1] > 0 || flown.orbit_lost_s[1] > 0 {
        Outcome::Lost
    } else if flown.changed_s.is_some() {
        Outcome::Changed
    } else {
        Outcome::NoEffect
    }
}

/// The spread of the losses over the flights that had one.
fn losses(flown: &[Flown], of: impl Fn(&Flown) -> u32) -> Option<Spread> {
    let mut losses: Vec<f64> = flown.iter().map(of).filter(|lost| *lost > 0).map(f64::from).collect();
    losses.sort_by(f64::total_cmp);
    Spread::of(&losses)
}

impl Told {
    fn add(&mut self, other: &Self) {
        self.seconds += other.seconds;
        self.beyond_4 += other.beyond_4;
        self.worst_sigma = self.worst_sigma.max(other.worst_sigma);
    }

    fn beyond_4_percent(&self) -> f64 {
        100.0 * f64::from(self.beyond_4) / f64::from(self.seconds.max(1))
    }
}

impl Table {
    /// Of these flights.
    pub fn of(flown: &[Flown]) -> Self {
        let of = |wanted| flown.iter().filter(|flown| outcome(flown) == wanted).count();
        let mut quantities: BTreeMap<String, Pooled> = BTreeMap::new();
        let mut ended = BTreeMap::new();
        for flown in flown {
            for (index, told) in [&flown.with, &flown.without].into_iter().enumerate() {
                for (key, told) in told {
                    quantities.entry(key.clone()).or_default().told[index].add(told);
                }
            }
            for wrong in &flown.wrong {
                quantities.entry(wrong.quantity.clone()).or_default().wrong += 1;
            }
            for one in &flown.ended {
                *ended.entry(one.how.clone()).or_insert(0) += 1;
            }
        }
        Self {
            flights: flown.len(),
            flips: flown.iter().map(|flown| flown.flips.len()).sum(),
            no_effect: of(Outcome::NoEffect),
            changed: of(Outcome::Changed),
            lost: of(Outcome::Lost),
            restarted: of(Outcome::Restarted),
            told_wrong: of(Outcome::Wrong),
            ended,
            unreadable: flown.iter().map(|flown| flown.unreadable).sum(),
            attitude_lost_s: losses(flown, |flown| flown.attitude_lost_s[0]),
            orbit_lost_s: losses(flown, |flown| flown.orbit_lost_s[0]),
            quantities,
        }
    }

    /// The table for people.
    pub fn text(&self, arguments: &FlyArguments, flown: &[Flown]) -> String {
        let in_state = |flip: &&Flip| flip.part == Part::State;
        let of_state = flown.iter().flat_map(|flown| &flown.flips).filter(in_state).count();
        let seconds: u32 = flown.iter().map(|flown| flown.seconds).sum();
        let mut text = format!(
            "{} flights, {} bits turned over, one in {:.0} s: {of_state} in the {STATE_BYTES} bytes of the \
             state, {} in the {WORKSPACE_BYTES} of the workspace\n\n",
            self.flights,
            self.flips,
            f64::from(seconds) / (self.flips.max(1) as f64),
            self.flips - of_state,
        );
        let [low, high] = share_interval_percent(self.told_wrong as u64, self.flights as u64);
        for (what, count, more) in [
            ("telemetry as without, to the last byte", self.no_effect, String::new()),
            ("other telemetry, nothing lost, nothing wrong", self.changed, String::new()),
            ("attitude or orbit lost for a while, and told so", self.lost, String::new()),
            ("computer ended and began anew", self.restarted, format!("  {:?}", self.ended)),
            (
                "told wrong, beyond 6 sigma",
                self.told_wrong,
                format!("  {low:.2} to {high:.2} % with 95 % confidence"),
            ),
        ] {
            text += &format!("{what:50} {count:>6}{more}\n");
        }
        text += &format!("{:50} {:>6}\n\n", "seconds whose telemetry could not be read", self.unreadable);
        for (what, lost) in [("attitude lost", &self.attitude_lost_s), ("orbit lost", &self.orbit_lost_s)] {
            let Some(lost) = lost else { continue };
            text += &format!(
                "{what}: in {} flights; longest for {} s in the median, {} s in 95 % of these\n",
                lost.runs, lost.median, lost.kept_by_95_percent
            );
        }
        text += &format!(
            "\n{:18} {:>10} {:>10} {:>12} {:>12} {:>10} {:>10}  {}\n",
            "", "told, s", "without", "beyond 4", "without", "worst", "without", "flights made wrong"
        );
        for (key, Pooled { told: [with, without], wrong }) in &self.quantities {
            text += &format!(
                "{key:18} {:>10} {:>10} {:>10.3} % {:>10.3} % {:>10.2} {:>10.2}  {wrong}\n",
                with.seconds,
                without.seconds,
                with.beyond_4_percent(),
                without.beyond_4_percent(),
                with.worst_sigma,
                without.worst_sigma
            );
        }
        text + &worst(arguments, flown)
    }
}

/// The worst flights, each with the command that flies it again.
fn worst(arguments: &FlyArguments, flown: &[Flown]) -> String {
    let rank = |flown: &&Flown| {
        let sigma = flown.wrong.iter().map(|wrong| wrong.worst_sigma).fold(0.0, f64::max);
        (outcome(flown), sigma, flown.attitude_lost_s[0].max(flown.orbit_lost_s[0]))
    };
    let mut listed: Vec<&Flown> = flown.iter().filter(|flown| outcome(flown) >= Outcome::Lost).collect();
    listed.sort_by(|one, other| rank(other).partial_cmp(&rank(one)).unwrap_or(std::cmp::Ordering::Equal));
    let FlyArguments { of, flips, common, .. } = arguments;
    let vary = of.vary.iter().map(|vary| format!(" --vary {}", vary.display())).collect::<String>();
    let mut text = String::new();
    for flown in listed.into_iter().take(LISTED) {
        text += &format!(
            "\ncargo run --release -p upsets -- fly {}{vary} --flips {flips} --seed {} --first {} \
             --runs 1\n   ",
            of.scenario.display(),
            common.seed,
            flown.run
        );
        for wrong in &flown.wrong {
            text += &format!(
                " {} beyond {WRONG_SIGMA} sigma from {} s on, at worst {:.1};",
                wrong.quantity, wrong.from_s, wrong.worst_sigma
            );
        }
        for ended in &flown.ended {
            text += &format!(" {} at {} s;", ended.how, ended.second);
        }
        let [[attitude, _], [orbit, _]] = [flown.attitude_lost_s, flown.orbit_lost_s];
        text += &format!(" attitude lost for {attitude} s, orbit for {orbit} s; turned over:");
        for Flip { second, part, byte, bit } in &flown.flips {
            let part = if *part == Part::State { "state" } else { "workspace" };
            text += &format!(" {second} s {part} {byte}.{bit}");
        }
        text.push('\n');
    }
    text
}
