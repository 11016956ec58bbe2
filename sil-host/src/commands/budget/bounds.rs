//! What the stages of a second cost at their caps.
//!
//! Every loop of the flight code ends at a constant ([`loops`](super::loops)). In: the metered flights. Out,
//! of each stage: its bound, and whether it cost more in any flight; its caps, and how many passes of each
//! loop the flights had that drive it there.
//!
//! A bound is the most, over the seconds of these flights, of what the stage costs with all the passes that
//! its loops may have, each as dear as the dearest that was flown. Scan and windows have an account of the
//! flight code's own: what a tile or window may spend is paid from an allowance. Where the Earth path shows
//! stars these take the place of the limb, at the bounds of the stars' stages.
//!
//! An identification in the second of a scan has a tenth of the allowance of later ones, and one of lines
//! looks near to a known attitude alone: a stage has a bound of its own in the seconds of either.
//!
//! Not at its cap is what the table of loops does not have: a loop within a pass costs what it cost in the
//! dearest pass.

use super::flown::{Flown, MeteredCycle, MeteredStage};
use super::loops::{Loop, Passes, STAGES, StageLoops};
use super::table::stage_name;
use crate::error::HostError;
use crate::flight;
use fsw_core::camera::Camera;
use fsw_core::catalog::Catalogue;
use fsw_core::frames::Rotation;
use fsw_core::image::scan;
use fsw_core::stars::confirm::MAX_FEW_STARS;
use fsw_core::stars::predict::field_stars;
use fsw_core::telemetry::Report;
use fsw_hal::Stage;
use serde::Serialize;
use std::collections::BTreeMap;

/// A stage, and by which stage the whole detector is searched for stars or their lines in its second.
type Key = (u8, Option<u8>);

/// The stages that search it.
const SEARCHING: [u8; 2] = [Stage::Scan as u8, Stage::Streaks as u8];

/// A stage's cost at its caps.
#[derive(Clone, Debug, Serialize)]
pub(super) struct StageBound {
    /// At its caps.
    pub(super) bound_cycles: u64,
    /// In any flight.
    pub(super) worst_cycles: u64,
    caps: BTreeMap<&'static str, usize>,
    /// Most passes of each loop in a second of the flights that drive it to its caps.
    reached: BTreeMap<&'static str, usize>,
    /// The loops of which the bound has as many passes as there may be, whatever the flights had.
    reckoned: Vec<&'static str>,
    saturated_by: &'static [&'static str],
    /// Whether it cost no more than its bound, in each kind of second.
    #[serde(skip)]
    within: bool,
}

impl StageBound {
    /// Whether no flight cost more than the bound, and the bound is one at the caps.
    pub(super) fn kept(&self) -> bool {
        self.within && self.short_of_caps().next().is_none()
    }

    /// The loops of which no flight had as many passes as there may be, nor the bound has: name, passes, cap.
    pub(super) fn short_of_caps(&self) -> impl Iterator<Item = (&'static str, usize, usize)> {
        let loops = self.caps.iter().zip(self.reached.values());
        loops
            .map(|((name, cap), reached)| (*name, *reached, *cap))
            .filter(|(name, reached, cap)| reached < cap && !self.reckoned.contains(name))
    }
}

/// A stage in a second of a flight that drives it to its caps.
struct Saturated<'a> {
    metered: &'a MeteredStage,
    report: &'a Report,
    flown: &'a Flown,
    camera: Camera,
}

impl Saturated<'_> {
    /// Passes of a loop.
    fn passes(&self, one: &Loop, catalogue: &Catalogue) -> usize {
        match one.passes {
            Passes::Reported(count) => count(self.report, &self.camera),
            Passes::Called(function) | Passes::Priced(function) | Passes::PricedBy(function, _) => {
                self.metered.calls_of(function).calls as usize
            }
            Passes::FieldStars => self.field_stars(catalogue).unwrap_or(0),
        }
    }

    /// Catalogue stars in the field of the second's attitude; `None` without one.
    fn field_stars(&self, catalogue: &Catalogue) -> Option<usize> {
        let attitude = Rotation::from_quaternion(self.report.attitude?.quaternion)?;
        Some(field_stars(catalogue, &self.camera, &attitude)?.len())
    }
}

/// The seconds of a stage in the flights that drive it to its caps.
struct Saturation<'a> {
    stage: &'a StageLoops,
    catalogue: &'a Catalogue<'a>,
    seconds: Vec<(Key, Saturated<'a>)>,
}

impl<'a> Saturation<'a> {
    fn new(stage: &'a StageLoops, flights: &'a [Flown], catalogue: &'a Catalogue) -> Self {
        let mut seconds = Vec::new();
        for flown in flights.iter().filter(|flown| stage.flights.contains(&flown.name)) {
            let Ok(camera) = Camera::new(flown.camera) else { continue };
            for (cycle, report) in &flown.seconds {
                let of_stage = keyed(cycle).find(|((number, _), _)| *number == stage.stage as u8);
                seconds.extend(
                    of_stage.map(|(key, metered)| (key, Saturated { metered, report, flown, camera })),
                );
            }
        }
        Self { stage, catalogue, seconds }
    }

    /// Most passes of a loop in a second.
    fn reached(&self, one: &Loop) -> usize {
        self.seconds.iter().map(|(_, second)| second.passes(one, self.catalogue)).max().unwrap_or(0)
    }

    /// The dearest call of a function, cycles.
    fn dearest(&self, function: &str) -> u64 {
        let calls = self.seconds.iter().map(|(_, second)| second.metered.calls_of(function).most.cycles);
        calls.max().unwrap_or(0)
    }

    /// The functions whose calls are reckoned up, and what all that there may be cost, each as dear as the
    /// dearest.
    fn reckoned(&self) -> Vec<(&'static str, u64)> {
        let price = |one: &Loop| match one.passes {
            Passes::Priced(function) => Some((function, one.cap as u64 * self.dearest(function))),
            Passes::PricedBy(function, by) => {
                let (cap, reached) = (by.cap as u64, self.reached(by).clamp(1, by.cap) as u64);
                Some((function, (one.cap as u64 * self.dearest(function) * cap).div_ceil(reached)))
            }
            Passes::Reported(_) | Passes::Called(_) | Passes::FieldStars => None,
        };
        self.stage.loops.iter().filter_map(price).collect()
    }

    /// What a second's stage would have cost at its caps; `None` where that cannot be told.
    fn at_caps(&self, second: &Saturated, reckoned: &[(&'static str, u64)]) -> Option<u64> {
        if let Some(account) = self.stage.account {
            return Some(account(&second.flown.geometry));
        }
        let mut cycles = second.metered.work.cycles;
        for (function, all) in reckoned {
            cycles += all.saturating_sub(second.metered.calls_of(function).work.cycles);
        }
        if let Some(one) = self.stage.loops.iter().find(|one| matches!(one.passes, Passes::FieldStars)) {
            let stars = second.field_stars(self.catalogue).filter(|stars| *stars > 0)?;
            cycles = (cycles * one.cap as u64).div_ceil(stars as u64);
        }
        Some(cycles)
    }

    /// The bound of each kind of second.
    fn bounds(&self) -> BTreeMap<Key, u64> {
        let reckoned = self.reckoned();
        let mut bounds = BTreeMap::new();
        for (key, second) in &self.seconds {
            if let Some(at_caps) = self.at_caps(second, &reckoned) {
                let bound = bounds.entry(*key).or_insert(0);
                *bound = at_caps.max(*bound);
            }
        }
        bounds
    }
}

/// Most of a stage's costs, of whichever kind of second.
fn most_of(costs: &BTreeMap<Key, u64>, stage: u8) -> u64 {
    let of_stage = costs.iter().filter(|((number, _), _)| *number == stage);
    of_stage.map(|(_, cycles)| *cycles).max().unwrap_or(0)
}

/// A stage's bound in a kind of second; of one that the flights do not have, the greatest of all.
fn bound_of(bounds: &BTreeMap<Key, u64>, key: Key) -> u64 {
    bounds.get(&key).copied().unwrap_or_else(|| most_of(bounds, key.0))
}

/// The bounds of all stages.
pub(super) struct Bounds {
    bounds: BTreeMap<Key, u64>,
    stages: BTreeMap<&'static str, StageBound>,
}

/// A second's stages with their keys.
fn keyed(cycle: &MeteredCycle) -> impl Iterator<Item = (Key, &MeteredStage)> {
    let searched = SEARCHING.into_iter().find(|stage| cycle.stages.contains_key(stage));
    cycle.stages.iter().map(move |(stage, metered)| ((*stage, searched), metered))
}

impl Bounds {
    /// Of metered flights.
    ///
    /// # Errors
    /// When the catalogue of the flight image is damaged.
    pub(super) fn new(flights: &[Flown]) -> Result<Self, HostError> {
        let catalogue = flight::open(catalog_gen::REFERENCE)?;
        let saturations: Vec<_> =
            STAGES.iter().map(|stage| Saturation::new(stage, flights, &catalogue)).collect();
        let mut bounds: BTreeMap<Key, u64> = saturations.iter().flat_map(Saturation::bounds).collect();
        // In place of the limb there may be stars: as many as in windows of their own, predicted and matched.
        let [predict, confirm, limb] =
            [Stage::Predict, Stage::Confirm, Stage::Limb].map(|stage| (stage as u8, None));
        let of = |key| bounds.get(&key).copied().unwrap_or(0);
        let second_field = scan::windows_bound_cycles(MAX_FEW_STARS as u32) + 2 * of(predict) + of(confirm);
        let most = of(limb).max(second_field);
        bounds.insert(limb, most);
        let mut worst = BTreeMap::new();
        for (key, metered) in
            flights.iter().flat_map(|flown| &flown.seconds).flat_map(|(cycle, _)| keyed(cycle))
        {
            let most = worst.entry(key).or_insert(0);
            *most = metered.work.cycles.max(*most);
        }
        let of_stage = |saturation: &Saturation| {
            let StageLoops { stage, flights, loops, .. } = saturation.stage;
            let number = *stage as u8;
            let mut costs = worst.iter().filter(|((of, _), _)| *of == number);
            let reckoned = loops.iter().filter(|one| saturation.stage.reckons(one));
            let bound = StageBound {
                bound_cycles: most_of(&bounds, number),
                worst_cycles: most_of(&worst, number),
                caps: loops.iter().map(|one| (one.name, one.cap)).collect(),
                reached: loops.iter().map(|one| (one.name, saturation.reached(one))).collect(),
                reckoned: reckoned.map(|one| one.name).collect(),
                saturated_by: flights,
                within: costs.all(|(key, cycles)| *cycles <= bound_of(&bounds, *key)),
            };
            (stage_name(number), bound)
        };
        let stages = saturations.iter().map(of_stage).collect();
        Ok(Self { bounds, stages })
    }

    /// What a second would have cost, had each of its stages cost what it costs at its caps.
    pub(super) fn of_second(&self, cycle: &MeteredCycle) -> u64 {
        keyed(cycle).fold(cycle.work.cycles, |sum, (key, metered)| {
            sum + bound_of(&self.bounds, key).saturating_sub(metered.work.cycles)
        })
    }

    /// Of each stage, in whichever second it costs most.
    pub(super) fn stages(&self) -> &BTreeMap<&'static str, StageBound> {
        &self.stages
    }
}

#[cfg(test)]
mod tests;
