//! What the stages of a second cost at their caps.
//!
//! Every loop of the flight code ends at a constant. A stage whose loops all reach theirs costs the most,
//! whatever the sky. In: the metered flights. Out, of each stage: its caps, the flight that drives it there,
//! what it cost there, and whether it cost more in any other. The bounds of scan and windows are the flight
//! code's own ([`scan::bound_cycles`], [`scan::windows_bound_cycles`]): what a tile or window may spend is
//! paid from an allowance. Of stages whose cost goes with the catalogue stars of the field the bound is that
//! of [`MAX_FIELD_STARS`], by as many as the flight had. Where the Earth path shows stars these take the
//! place of the limb, at the bounds of the stars' stages.
//!
//! An identification in the second of a scan has a tenth of the allowance of later ones, and one of lines looks near
//! to a known attitude alone: a stage has a bound of its own in the seconds of either.

use super::flown::{Flown, MeteredCycle, Work};
use super::table::stage_name;
use super::{CROWDED_FIELD, EVERY_MODE, PROTON_STORM, WIDEST_LIMB};
use crate::error::HostError;
use crate::flight;
use fsw_core::camera::Camera;
use fsw_core::catalog::Catalogue;
use fsw_core::earth::view::{COARSE, FINE};
use fsw_core::earth::{MAX_LIMB_POINTS, MAX_SEARCH_POINTS, centre, consensus, limb, reach};
use fsw_core::frames::Rotation;
use fsw_core::image::scan::{self, MAX_DETECTIONS};
use fsw_core::image::streaks::search::MAX_PIECES;
use fsw_core::orbit::{beginning, dynamics, factor, filter};
use fsw_core::plan::{MAX_STAR_WINDOWS, PROBES};
use fsw_core::rate::arcs::MAX_ARCS;
use fsw_core::stars::MAX_MEASURED;
use fsw_core::stars::confirm::{MAX_FEW_STARS, ROUNDS};
use fsw_core::stars::predict::{MAX_FIELD_STARS, field_stars};
use fsw_hal::Stage;
use serde::Serialize;
use std::collections::BTreeMap;

/// A stage's caps and the flights that drive it there.
struct Saturated {
    stage: Stage,
    flights: &'static [&'static str],
    caps: &'static [(&'static str, usize)],
    /// Whether its cost goes with the catalogue stars of the field.
    by_field_stars: bool,
}

const fn at_caps(
    stage: Stage,
    flights: &'static [&'static str],
    caps: &'static [(&'static str, usize)],
) -> Saturated {
    Saturated { stage, flights, caps, by_field_stars: false }
}

const SATURATED: [Saturated; 11] = [
    at_caps(Stage::Scan, &[PROTON_STORM, CROWDED_FIELD], &[("spots", MAX_DETECTIONS)]),
    at_caps(Stage::Identify, &[PROTON_STORM, CROWDED_FIELD], &[("measured stars", MAX_MEASURED)]),
    Saturated {
        by_field_stars: true,
        ..at_caps(
            Stage::Predict,
            &[CROWDED_FIELD, EVERY_MODE, WIDEST_LIMB],
            &[("catalogue stars", MAX_FIELD_STARS)],
        )
    },
    at_caps(Stage::Windows, &[CROWDED_FIELD], &[("windows", MAX_STAR_WINDOWS), ("spots", MAX_DETECTIONS)]),
    Saturated {
        by_field_stars: true,
        ..at_caps(
            Stage::Confirm,
            &[CROWDED_FIELD],
            &[("catalogue stars", MAX_FIELD_STARS), ("measured stars", MAX_MEASURED), ("rounds", ROUNDS)],
        )
    },
    at_caps(
        Stage::Limb,
        &[WIDEST_LIMB, EVERY_MODE],
        &[("strips", reach::MAX_LIMB_STRIPS), ("pixels along", limb::MAX_LENGTH), ("across", limb::BREADTH)],
    ),
    at_caps(
        Stage::Centre,
        &[WIDEST_LIMB, EVERY_MODE],
        &[
            ("points", MAX_LIMB_POINTS),
            ("points of a search", MAX_SEARCH_POINTS),
            ("triplets", consensus::MAX_TRIPLETS as usize),
            ("steps", centre::STEPS),
        ],
    ),
    at_caps(
        Stage::Orbit,
        &[EVERY_MODE, WIDEST_LIMB],
        &[
            ("spans", filter::MAX_SPANS as usize),
            ("steps of a span", dynamics::MAX_STEPS as usize),
            ("states", factor::STATES),
            ("fixes of a beginning", beginning::FIXES),
        ],
    ),
    at_caps(Stage::Search, &[EVERY_MODE], &[("coarse strips", COARSE), ("fine strips", FINE)]),
    at_caps(Stage::Streaks, &[EVERY_MODE], &[("pieces", MAX_PIECES), ("streaks", MAX_ARCS)]),
    at_caps(Stage::Image, &[EVERY_MODE, WIDEST_LIMB, PROTON_STORM, CROWDED_FIELD], &[("probes", PROBES)]),
];

/// A stage, and by which stage the whole detector is searched for stars or their lines in its second.
type Key = (u8, Option<u8>);

/// The stages that search it.
const SEARCHING: [u8; 2] = [Stage::Scan as u8, Stage::Streaks as u8];

/// A stage's cost at its caps.
#[derive(Clone, Debug, Serialize)]
pub(super) struct StageBound {
    /// By the flights that drive it to its caps.
    pub(super) bound_cycles: u64,
    /// In any flight.
    pub(super) worst_cycles: u64,
    caps: BTreeMap<&'static str, usize>,
    saturated_by: &'static [&'static str],
}

impl StageBound {
    /// Whether no flight cost more than the bound.
    pub(super) fn kept(&self) -> bool {
        self.worst_cycles <= self.bound_cycles
    }
}

/// The bounds of all stages.
pub(super) struct Bounds {
    bounds: BTreeMap<Key, u64>,
    worst: BTreeMap<Key, u64>,
}

/// A second's stages with their keys.
fn keyed(cycle: &MeteredCycle) -> impl Iterator<Item = (Key, &Work)> {
    let searched = SEARCHING.into_iter().find(|stage| cycle.stages.contains_key(stage));
    cycle.stages.iter().map(move |(stage, work)| ((*stage, searched), work))
}

/// Most catalogue stars in the field of a flight's attitudes, 1 where there is none.
fn most_field_stars(catalogue: &Catalogue, flown: &Flown) -> u64 {
    let Ok(camera) = Camera::new(flown.camera) else { return 1 };
    let attitudes = flown.seconds.iter().filter_map(|(_, report)| report.attitude);
    let counts = attitudes.filter_map(|attitude| {
        let attitude = Rotation::from_quaternion(attitude.quaternion)?;
        Some(field_stars(catalogue, &camera, &attitude)?.len())
    });
    counts.max().unwrap_or(1).max(1) as u64
}

impl Bounds {
    /// Of metered flights.
    ///
    /// # Errors
    /// When the catalogue of the flight image is damaged.
    pub(super) fn new(flights: &[Flown]) -> Result<Self, HostError> {
        let catalogue = flight::open(catalog_gen::REFERENCE)?;
        let (mut bounds, mut worst) = (BTreeMap::new(), BTreeMap::new());
        for flown in flights {
            let field_stars = most_field_stars(&catalogue, flown);
            for (key, work) in flown.seconds.iter().flat_map(|(cycle, _)| keyed(cycle)) {
                let most = worst.entry(key).or_insert(0);
                *most = work.cycles.max(*most);
                let saturated = SATURATED.iter().find(|saturated| saturated.stage as u8 == key.0);
                let Some(saturated) = saturated.filter(|stage| stage.flights.contains(&flown.name)) else {
                    continue;
                };
                let at_caps = match saturated.stage {
                    Stage::Scan => scan::bound_cycles(&flown.geometry),
                    Stage::Windows => scan::windows_bound_cycles(MAX_STAR_WINDOWS as u32),
                    _ if saturated.by_field_stars => work.cycles * MAX_FIELD_STARS as u64 / field_stars,
                    _ => work.cycles,
                };
                let bound = bounds.entry(key).or_insert(0);
                *bound = at_caps.max(*bound);
            }
        }
        // In place of the limb there may be stars: as many as in windows of their own, predicted and matched.
        let [predict, confirm, limb] =
            [Stage::Predict, Stage::Confirm, Stage::Limb].map(|stage| (stage as u8, None));
        let of = |key| bounds.get(&key).copied().unwrap_or(0);
        let second_field = scan::windows_bound_cycles(MAX_FEW_STARS as u32) + 2 * of(predict) + of(confirm);
        let most = of(limb).max(second_field);
        bounds.insert(limb, most);
        Ok(Self { bounds, worst })
    }

    /// What a second would have cost, had each of its stages cost what it costs at its caps.
    pub(super) fn of_second(&self, cycle: &MeteredCycle) -> u64 {
        keyed(cycle).fold(cycle.work.cycles, |sum, (key, work)| {
            sum + self.bounds.get(&key).map_or(0, |bound| bound.saturating_sub(work.cycles))
        })
    }

    /// Of each stage, in whichever second it costs most.
    pub(super) fn stages(&self) -> BTreeMap<&'static str, StageBound> {
        let of_stage = |saturated: &Saturated| {
            let most = |costs: &BTreeMap<Key, u64>| {
                let of_stage = costs.iter().filter(|((stage, _), _)| *stage == saturated.stage as u8);
                of_stage.map(|(_, cycles)| *cycles).max().unwrap_or(0)
            };
            StageBound {
                bound_cycles: most(&self.bounds),
                worst_cycles: most(&self.worst),
                caps: saturated.caps.iter().copied().collect(),
                saturated_by: saturated.flights,
            }
        };
        SATURATED.iter().map(|stage| (stage_name(stage.stage as u8), of_stage(stage))).collect()
    }
}
