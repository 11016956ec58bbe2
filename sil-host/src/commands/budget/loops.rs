//! The loops of each stage: the constant at which each ends, how its passes are seen, and the flights that
//! drive the stage there.
//!
//! Every loop of the flight code ends at a constant. A pass is seen as a call of a function of the image,
//! which the meter counts and times, or in the second's report. The caps are those of the reference detector
//! and the default parameters.

use super::{CROWDED_FIELD, EVERY_MODE, KNOWN_PIXELS, PROTON_STORM, STARLESS, WIDEST_LIMB};
use fsw_core::camera::Camera;
use fsw_core::earth::view::{COARSE, FINE};
use fsw_core::earth::{EarthParameters, MAX_SEARCH_POINTS, centre, consensus, limb, reach};
use fsw_core::frames::{Direction, EarthPath};
use fsw_core::image::scan::{self, MAX_DETECTIONS};
use fsw_core::image::streaks::follow;
use fsw_core::image::streaks::search::BLOCK_PX;
use fsw_core::orbit::{beginning, dynamics, filter};
use fsw_core::plan::{MAX_STAR_WINDOWS, PROBES};
use fsw_core::rate::arcs::MAX_ARCS;
use fsw_core::stars::MAX_MEASURED;
use fsw_core::stars::confirm::ROUNDS;
use fsw_core::stars::predict::MAX_FIELD_STARS;
use fsw_core::telemetry::{Outcome, Report};
use fsw_hal::{DetectorGeometry, Stage};
use std::collections::BTreeSet;

/// The reference detector, px.
const WIDTH_PX: usize = 1280;
const HEIGHT_PX: usize = 1024;
/// From a line of a search for the Earth to the next, px, and from a line of the sky's level.
const SEARCH_PX: usize = 16;
const SKY_PX: usize = 4 * SEARCH_PX;
/// Catalogue pairs of a second: `identification.pairs_per_cycle`.
const PAIRS: usize = 1_200_000;
/// An acceleration at each of the four places of a step.
const PLACES: usize = 4;

/// Lines of the detector from half of this distance on, and rows alone.
const fn lines(apart_px: usize) -> usize {
    rows(apart_px) + (WIDTH_PX - apart_px / 2).div_ceil(apart_px)
}
const fn rows(apart_px: usize) -> usize {
    (HEIGHT_PX - apart_px / 2).div_ceil(apart_px)
}
/// Of a search for the Earth, and for the terminator, whose rows are read twice.
const SEARCHED: usize = lines(SEARCH_PX) + lines(SKY_PX);
const TERMINATOR: usize = lines(SKY_PX) + 2 * rows(SEARCH_PX);
/// Of a search for lines of stars.
const BLOCKS: usize = WIDTH_PX.div_ceil(BLOCK_PX as usize) * HEIGHT_PX.div_ceil(BLOCK_PX as usize);
/// Blocks of the detector that may show the ground to the terminator: every second one of every row read.
const GROUND_BLOCKS: usize = rows(SEARCH_PX) * WIDTH_PX / SEARCH_PX;
/// Called for the slope along each axis of the detector at each limb point of a fit.
const LIMB_POINT: &str = "Ray::new::{{closure}}";
const SLOPES: usize = 2;
/// Called for each window read.
const READ: &str = "read";

/// A loop of a stage.
pub(super) struct Loop {
    pub(super) name: &'static str,
    pub(super) cap: usize,
    pub(super) passes: Passes,
}

/// How the passes of a loop are seen, and what becomes of those that no flight has.
pub(super) enum Passes {
    /// The second's report says how many; a flight has as many as there may be, or another loop is priced by
    /// them.
    Reported(fn(&Report, &Camera) -> usize),
    /// Calls of a function; a flight has as many as there may be.
    Called(&'static str),
    /// The same, reckoned up: as many as there may be, each as dear as the dearest.
    Priced(&'static str),
    /// The same of passes that go over all of what another loop counts: dearer by as many as the flights had
    /// too few of these.
    PricedBy(&'static str, &'static Loop),
    /// Catalogue stars of the field. What the stage costs is reckoned up: a star costs the same, be there few
    /// or many, and what does not depend on them is reckoned up with it.
    FieldStars,
}

impl Passes {
    /// The function whose calls are the passes.
    pub(super) fn function(&self) -> Option<&'static str> {
        match self {
            Self::Reported(_) | Self::FieldStars => None,
            Self::Called(function) | Self::Priced(function) | Self::PricedBy(function, _) => Some(function),
        }
    }
}

/// A stage's loops, and the flights that drive it to its caps.
pub(super) struct StageLoops {
    pub(super) stage: Stage,
    pub(super) flights: &'static [&'static str],
    pub(super) loops: &'static [Loop],
    /// What it may cost by the flight code's own account, where what depends on the sky is paid from an
    /// allowance.
    pub(super) account: Option<fn(&DetectorGeometry) -> u64>,
}

impl StageLoops {
    /// Whether the bound has as many passes of a loop as there may be, whatever the flights had.
    pub(super) fn reckons(&self, one: &Loop) -> bool {
        self.account.is_some()
            || matches!(one.passes, Passes::Priced(_) | Passes::PricedBy(..) | Passes::FieldStars)
            || self
                .loops
                .iter()
                .any(|other| matches!(other.passes, Passes::PricedBy(_, by) if by.name == one.name))
    }
}

const fn reported(name: &'static str, cap: usize, count: fn(&Report, &Camera) -> usize) -> Loop {
    Loop { name, cap, passes: Passes::Reported(count) }
}

const fn called(name: &'static str, cap: usize, function: &'static str) -> Loop {
    Loop { name, cap, passes: Passes::Called(function) }
}

const fn priced(name: &'static str, cap: usize, function: &'static str) -> Loop {
    Loop { name, cap, passes: Passes::Priced(function) }
}

const fn priced_by(name: &'static str, cap: usize, function: &'static str, by: &'static Loop) -> Loop {
    Loop { name, cap, passes: Passes::PricedBy(function, by) }
}

const FIELD_STARS: Loop = Loop { name: "catalogue stars", cap: MAX_FIELD_STARS, passes: Passes::FieldStars };
/// Of more spots the brightest are measured.
const MEASURED: Loop =
    reported("measured stars", MAX_MEASURED, |report, _| usize::from(report.detections).min(MAX_MEASURED));
const SEARCH_POINTS: Loop = priced("slopes of points", SLOPES * MAX_SEARCH_POINTS, LIMB_POINT);
const GROUND: Loop = reported("blocks of the ground", GROUND_BLOCKS, blocks_of_ground);
const TRIPLETS: usize = consensus::MAX_TRIPLETS as usize + consensus::ROUNDS;
/// The fix itself stands about one more cone than the steps have.
const CONES: usize = centre::STEPS + 1;

const fn stage(stage: Stage, flights: &'static [&'static str], loops: &'static [Loop]) -> StageLoops {
    StageLoops { stage, flights, loops, account: None }
}

/// Every stage.
pub(super) const STAGES: [StageLoops; 11] = [
    StageLoops {
        account: Some(scan::bound_cycles),
        ..stage(
            Stage::Scan,
            &[PROTON_STORM, CROWDED_FIELD],
            &[reported("spots", MAX_DETECTIONS, |report, _| report.detections.into())],
        )
    },
    stage(
        Stage::Identify,
        &[PROTON_STORM, CROWDED_FIELD, EVERY_MODE],
        &[
            MEASURED,
            // A search that goes on has used up what a second may.
            reported("catalogue pairs", PAIRS, |report, _| match report.outcome {
                Some(Outcome::Searching) => PAIRS,
                _ => 0,
            }),
        ],
    ),
    stage(Stage::Predict, &[CROWDED_FIELD, EVERY_MODE, WIDEST_LIMB], &[FIELD_STARS]),
    StageLoops {
        account: Some(|_| scan::windows_bound_cycles(MAX_STAR_WINDOWS as u32)),
        ..stage(Stage::Windows, &[CROWDED_FIELD], &[called("windows", MAX_STAR_WINDOWS, READ)])
    },
    stage(
        Stage::Confirm,
        &[CROWDED_FIELD],
        &[
            FIELD_STARS,
            MEASURED,
            priced_by("rounds and the last match", ROUNDS + 1, "confirm::match_stars", &MEASURED),
        ],
    ),
    stage(
        Stage::Limb,
        &[WIDEST_LIMB, EVERY_MODE],
        &[
            called("strips", reach::MAX_LIMB_STRIPS, READ),
            priced("runs of a strip", reach::MAX_LIMB_STRIPS * limb::MAX_RUNS, "lines::trimmed_means"),
            priced("azimuths", 2 * COARSE + FINE + reach::MAX_LIMB_STRIPS, "View::project_limb"),
        ],
    ),
    stage(
        Stage::Centre,
        &[WIDEST_LIMB, EVERY_MODE],
        &[
            called("slopes of points", SLOPES * reach::MAX_LIMB_STRIPS, LIMB_POINT),
            priced("triplets and refits", TRIPLETS, "consensus::inliers_of"),
            called("steps and the fix", CONES, "Departing::new"),
        ],
    ),
    stage(
        Stage::Orbit,
        &[EVERY_MODE, WIDEST_LIMB],
        &[
            priced("spans", filter::SPANS_A_SECOND as usize, "propagate_span"),
            called(
                "accelerations",
                filter::SPANS_A_SECOND as usize * dynamics::MAX_STEPS as usize * PLACES,
                "Field::acceleration",
            ),
            priced("limbs taken", 1, "add_to_look"),
            priced("steps ahead", 1, "Outlook::step"),
            called("shares of a look", 1, "Estimate::update"),
            called("fixes of a trial", beginning::FIXES_A_CALL, "Trial::add"),
        ],
    ),
    stage(
        Stage::Search,
        &[EVERY_MODE, WIDEST_LIMB, STARLESS],
        &[
            called("lines", SEARCHED + TERMINATOR, READ),
            SEARCH_POINTS,
            priced_by("triplets and refits", TRIPLETS, "consensus::inliers_of", &SEARCH_POINTS),
            priced_by("steps and the fix", CONES, "Departing::new", &SEARCH_POINTS),
            GROUND,
            priced_by("terminators", 1, "terminator::sun_seen", &GROUND),
            priced("runs of a strip", reach::MAX_LIMB_STRIPS * limb::MAX_RUNS, "lines::trimmed_means"),
        ],
    ),
    stage(
        Stage::Streaks,
        &[EVERY_MODE],
        &[
            called("blocks", BLOCKS, "search::bins_of"),
            priced("blocks that may hold a line", BLOCKS, "radon::best_line"),
            priced("windows along lines", follow::MAX_COLUMNS / follow::CHUNK, "Columns::of"),
            priced("streaks", MAX_ARCS, "follow::fit"),
        ],
    ),
    stage(
        Stage::Image,
        &[EVERY_MODE, WIDEST_LIMB, PROTON_STORM, CROWDED_FIELD, KNOWN_PIXELS],
        &[called("probes", PROBES, READ)],
    ),
];

/// Blocks that show the ground, in a second in which the terminator is sought and the Earth was found.
fn blocks_of_ground(report: &Report, camera: &Camera) -> usize {
    let found = report.earth.filter(|_| report.outcome == Some(Outcome::StarPathShut));
    let direction = found.and_then(|earth| Direction::<EarthPath>::new(earth.direction.into()));
    let Some((earth, direction)) = found.zip(direction) else { return 0 };
    let sine = EarthParameters::default().ellipsoid.equatorial_km / earth.distance_km;
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    let shows_ground =
        |at_px: &[f32; 2]| camera.earth_direction(*at_px).is_some_and(|seen| seen.dot(&direction) > cosine);
    let rows = (0..rows(SEARCH_PX)).map(|row| (row * SEARCH_PX + SEARCH_PX / 2) as f32);
    // A block is eight pixels.
    let places = || (0..WIDTH_PX / SEARCH_PX).map(|column| (column * SEARCH_PX) as f32 + 3.5);
    rows.flat_map(|y| places().map(move |x| [x, y])).filter(shows_ground).count()
}

/// The functions whose calls are counted, as the meter wants their names.
pub(super) fn counted_functions() -> String {
    let loops = STAGES.iter().flat_map(|stage| stage.loops);
    let functions: BTreeSet<_> = loops.filter_map(|one| one.passes.function()).collect();
    functions.into_iter().collect::<Vec<_>>().join("+")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::record::Instrument;
    use crate::commands::record::mission::{CROWD, EARTH_ALONE, MISSION, STORM, WIDE_LIMB};

    #[test]
    fn the_caps_are_those_of_the_flights_detector_and_parameters() {
        for flight in [MISSION, WIDE_LIMB, STORM, CROWD, EARTH_ALONE] {
            let Instrument { geometry, parameters, .. } = flight.instrument().unwrap();
            assert_eq!([geometry.width_px, geometry.height_px].map(usize::from), [WIDTH_PX, HEIGHT_PX]);
            assert_eq!(usize::from(parameters.earth.search.step_px), SEARCH_PX);
            assert_eq!(parameters.identification.pairs_per_cycle as usize, PAIRS);
        }
        assert_eq!((SEARCHED, TERMINATOR, BLOCKS), (180, 164, 320));
    }
}
