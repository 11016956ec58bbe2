//! A flight with turned bits beside the same flight without, both held against the truth by the host's judge.
//!
//! Whatever the flight without turned bits tells wrong or does not tell is no matter of these: a quantity is
//! told wrong by the turned bits where its worst error is beyond [`WRONG_SIGMA`] in the one flight and not in
//! the other, and lost in a second in which the other tells it.

use crate::FlyArguments;
use crate::aboard::{Aboard, Ended};
use crate::memory::{Flip, flips};
use fsw_core::telemetry::{self, MAX_FRAME_BYTES};
use serde::{Deserialize, Serialize};
use sil_host::campaign::Experiment;
use sil_host::campaign::family::{Family, Values};
use sil_host::error::HostError;
use sil_host::harness::{self, Flight, FlightCode};
use sil_host::judge::Judge;
use sil_host::judge::quantities::{QUANTITIES, Quantity};
use sil_host::scenario::Scenario;
use sil_host::version;
use std::collections::BTreeMap;

/// An error beyond so many of its reported sigmas is wrong.
pub const WRONG_SIGMA: f64 = 6.0;

/// The quantities that are judged; the position in the dark is one of the positions.
fn quantities() -> impl Iterator<Item = &'static Quantity> {
    QUANTITIES.iter().filter(|quantity| quantity.key != "dark_position")
}

/// How a quantity was told in a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Told {
    /// Seconds with it.
    pub seconds: u32,
    /// Of these with an axis beyond 4 sigma.
    pub beyond_4: u32,
    /// Largest error over its sigma.
    pub worst_sigma: f64,
}

/// A quantity that was told wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wrong {
    /// Its key.
    pub quantity: String,
    /// First second in which an axis was beyond [`WRONG_SIGMA`], or no number.
    pub from_s: u32,
    /// Largest error over its sigma.
    pub worst_sigma: f64,
}

/// What a flight came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Flown {
    /// The scenario's name.
    pub scenario: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the flight.
    pub run: u64,
    /// What was drawn for it, by key of the scenario.
    pub drawn: Values,
    /// Seconds flown.
    pub seconds: u32,
    /// The bits that were turned over.
    pub flips: Vec<Flip>,
    /// First second whose telemetry is not that of the flight without, byte for byte.
    pub changed_s: Option<u32>,
    /// The computers that ended.
    pub ended: Vec<Ended>,
    /// Seconds whose telemetry could not be read, where the computer did not end.
    pub unreadable: u32,
    /// Most seconds in a row without an attitude that the flight without turned bits tells; and in all.
    pub attitude_lost_s: [u32; 2],
    /// The same of the orbit.
    pub orbit_lost_s: [u32; 2],
    /// How each quantity was told with turned bits.
    pub with: BTreeMap<String, Told>,
    /// And without.
    pub without: BTreeMap<String, Told>,
    /// What the turned bits made wrong.
    pub wrong: Vec<Wrong>,
    /// The program that flew it, see [`version`].
    pub program: String,
}

/// The seconds of one of the two flights.
#[derive(Default)]
struct Seconds {
    /// Telemetry frames.
    frames: Vec<Vec<u8>>,
    /// Whether attitude and orbit were told.
    known: Vec<[bool; 2]>,
    told: BTreeMap<String, Told>,
    /// First second in which a quantity was wrong, by its key.
    wrong: BTreeMap<&'static str, u32>,
}

impl Seconds {
    /// Flies a scenario to its end.
    fn fly<F: FlightCode>(scenario: &Scenario, flight: &mut Flight<'_, F>) -> Result<Self, HostError> {
        let mut seconds = Self::default();
        let mut judge = Judge::new(scenario.duration_s, scenario.period_s());
        for _ in 0..scenario.duration_s {
            flight.second(|second| {
                judge.add(second.judged);
                for quantity in quantities() {
                    let Some(axes) = (quantity.of)(second.judged) else { continue };
                    let axes_count = 0..quantity.axes;
                    let sound = axes_count
                        .map(|axis| (axes.error[axis] / axes.sigma[axis]).abs())
                        .all(|sigmas| sigmas <= WRONG_SIGMA);
                    if !sound {
                        seconds.wrong.entry(quantity.key).or_insert(second.cycle);
                    }
                }
                let mut frame = [0; MAX_FRAME_BYTES];
                let frame = telemetry::encode(second.report, &mut frame).unwrap_or_default();
                seconds.frames.push(frame.to_vec());
                seconds.known.push([second.report.attitude.is_some(), second.report.orbit.is_some()]);
                Ok(())
            })?;
        }
        let figures = judge.finish();
        for quantity in quantities() {
            let Some(run) = figures.run(quantity.key) else { continue };
            let told = Told {
                seconds: run.seconds,
                beyond_4: (run.beyond_4_share * f64::from(run.seconds)).round() as u32,
                worst_sigma: run.largest_sigma,
            };
            seconds.told.insert(quantity.key.to_owned(), told);
        }
        Ok(seconds)
    }

    /// Most seconds in a row, and all, in which `other` tells the thing of this index and this one does not.
    fn lost(&self, other: &Self, index: usize) -> [u32; 2] {
        let lost = self.known.iter().zip(&other.known).map(|(one, other)| other[index] && !one[index]);
        let [mut row, mut most, mut all] = [0; 3];
        for lost in lost {
            row = if lost { row + 1 } else { 0 };
            most = most.max(row);
            all += u32::from(lost);
        }
        [most, all]
    }
}

/// The flights that are asked for.
pub struct Flights<'a> {
    arguments: &'a FlyArguments,
    family: Family,
    /// What the flights draw.
    drawn: BTreeMap<u64, Values>,
}

impl<'a> Flights<'a> {
    /// Every flight's scenario is checked before any is flown.
    ///
    /// # Errors
    /// When a file cannot be read or is wrong.
    pub fn new(arguments: &'a FlyArguments) -> Result<Self, HostError> {
        let family = arguments.of.family()?;
        let numbers = arguments.common.numbers(arguments.runs);
        let drawn = family.drawn(arguments.common.seed, numbers)?;
        Ok(Self { arguments, family, drawn })
    }
}

impl Experiment for Flights<'_> {
    type Key = u64;
    type Run = Flown;
    type Workspace = ();

    fn name(&self) -> &str {
        &self.family.base.name
    }

    fn keys(&self) -> Vec<u64> {
        self.drawn.keys().copied().collect()
    }

    fn key_of(&self, flown: &Flown) -> Option<u64> {
        let ours = flown.scenario == self.family.base.name
            && flown.seed == self.arguments.common.seed
            && flown.flips.len() == self.arguments.flips as usize;
        (ours && self.drawn.get(&flown.run) == Some(&flown.drawn)).then_some(flown.run)
    }

    fn workspace(&self) {}

    fn fly(&self, (): &mut (), run: &u64) -> Result<Flown, HostError> {
        let (seed, run) = (self.arguments.common.seed, *run);
        let (scenario, drawn) = self.family.member(seed, run)?;
        let flips = flips(scenario.seed, scenario.duration_s, self.arguments.flips);
        let without = harness::with_flight(&scenario, &mut scenario.scene()?, |flight| {
            Seconds::fly(&scenario, flight)
        })?;
        let mut aboard = Aboard::new(&self.arguments.of, (seed, run), &flips);
        let mut scene = scenario.scene()?;
        let with = Seconds::fly(&scenario, &mut Flight::of(&scenario, &mut scene, &mut aboard))?;
        let changed = aboard.frames.iter().zip(&without.frames).position(|(one, other)| one != other);
        let unread = |(second, frame): (u32, &Vec<u8>)| {
            telemetry::decode(frame).is_err() && aboard.ended.iter().all(|ended| ended.second != second)
        };
        let wrong = with.wrong.iter().filter(|(key, _)| !without.wrong.contains_key(*key));
        Ok(Flown {
            scenario: self.family.base.name.clone(),
            seed,
            run,
            drawn,
            seconds: scenario.duration_s,
            changed_s: changed.map(|second| second as u32),
            unreadable: (0..).zip(&aboard.frames).filter(|of| unread(*of)).count() as u32,
            attitude_lost_s: with.lost(&without, 0),
            orbit_lost_s: with.lost(&without, 1),
            wrong: wrong
                .map(|(key, from_s)| Wrong {
                    quantity: (*key).to_owned(),
                    from_s: *from_s,
                    worst_sigma: with.told.get(*key).map_or(0.0, |told| told.worst_sigma),
                })
                .collect(),
            with: with.told,
            without: without.told,
            ended: std::mem::take(&mut aboard.ended),
            program: version::words().to_owned(),
            flips: aboard.flips.to_vec(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lost_is_what_the_other_flight_tells() {
        let of = |known: &[bool]| Seconds {
            known: known.iter().map(|known| [*known, true]).collect(),
            ..Seconds::default()
        };
        let without = of(&[false, true, true, true, false, true, true]);
        let with = of(&[false, true, false, false, false, true, false]);
        assert_eq!(with.lost(&without, 0), [2, 3]);
        assert_eq!(with.lost(&without, 1), [0, 0]);
    }
}
