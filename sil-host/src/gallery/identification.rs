//! Identification by tolerance: how often it is right, and how long it takes (thesis figs. 4.3 and 4.4).
//!
//! Fields and judge are those of [`crate::campaign::identify`]; the flight code's identification gets one
//! tolerance for all its tries.

use super::{Figure, Made, Row, SEED, Told, digits};
use crate::campaign::identify::blocks::{self, Key, Outcome};
use crate::campaign::identify::cases::{self, Case, Change, LIMIT_V, Maker, Peers};
use crate::campaign::spread::share_interval_percent;
use crate::error::HostError;
use crate::flight::lost_in_space::Solver;
use crate::flight::{self, Density};
use crate::harness::star_scene;
use crate::report::chart::{Axis, Chart, Series};
use fsw_core::stars::identify::IdentificationParameters;
use rayon::prelude::*;
use std::path::Path;
use std::time::Instant;

/// The figures.
pub const FIGURES: &[Figure] = &[
    Figure {
        name: "fig-4.3",
        title: "probability of a right identification by tolerance",
        place: "\u{a7}4.1.1",
        thesis: &[
            Told {
                what: "tolerance that is the best trade-off, over the noise of a separation",
                value: 3.0,
                unit: "",
                place: "\u{a7}4.1.1",
            },
            Told { what: "right with five stars", value: 98.0, unit: "%", place: "\u{a7}3.1.1" },
        ],
        make: probability,
    },
    Figure {
        name: "fig-4.4",
        title: "time of an identification by tolerance",
        place: "\u{a7}4.1.1",
        thesis: &[
            Told {
                what: "power of the tolerance with which the time grows",
                value: 2.0,
                unit: "",
                place: "\u{a7}4.1.1: \u{201c}approximately quadratic\u{201d}",
            },
            Told {
                what: "time at 30 arcsec over that at none",
                value: 37.0,
                unit: "",
                place: "fig. 4.4; the scan has \u{201c}3Q\u{201d} for the tolerance",
            },
        ],
        make: time,
    },
];

/// Stars of a field, the brightest: as many as the thesis reckons with.
const STARS: usize = 5;
/// Fields of a point.
const FIELDS: u64 = 400;
/// Angle of a pixel of the campaign's camera, arcsec.
const PIXEL_ARCSEC: f64 = 52.9;
/// Noise of a star, arcsec (thesis: sixths of a pixel of about 60 arcsec).
const NOISE_ARCSEC: [f64; 6] = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
/// Tolerances over the noise of a separation.
const MULTIPLES: [f64; 8] = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0];
/// Tolerances of the time, arcsec, and the noise of its fields.
const TOLERANCES_ARCSEC: [f64; 7] = [10.0, 20.0, 30.0, 60.0, 90.0, 120.0, 240.0];
const QUIET_ARCSEC: f64 = 2.0;

/// Fields with this noise, tried with a tolerance of a separation, both in arcsec: what came of them, and the
/// mean time of one, ms.
fn tried(
    noise_arcsec: f64,
    tolerance_arcsec: f64,
    change: Change,
    fields: u64,
) -> Result<(Outcome, f64), HostError> {
    // The flight code's tolerance is three sigmas of the difference of two centroids.
    let sigma_px = (tolerance_arcsec / PIXEL_ARCSEC / (3.0 * std::f64::consts::SQRT_2)) as f32;
    let criterion = IdentificationParameters {
        centroid_sigma_px: [sigma_px; 3],
        scale_uncertainty: 0.0,
        ..IdentificationParameters::default()
    };
    let case = Case {
        name: String::new(),
        noise_px: noise_arcsec / PIXEL_ARCSEC,
        false_stars: 0,
        change,
        peers: Peers::Unknown,
        criterion,
    };
    let sky: Vec<_> = star_scene::sky().into_iter().filter(|star| star.v <= LIMIT_V).collect();
    let maker = Maker::new(&case, SEED, &sky)?;
    let camera = flight::camera(&cases::camera()?, Path::new("the camera of the campaign"))?;
    let bytes = flight::catalogue_bytes(&camera, Density::Full)?;
    let catalogue = flight::open(&bytes)?;
    let mut solver = Solver::default();
    let begun = Instant::now();
    let key = Key { seed: SEED, case: case.name.clone(), first: 0, fields };
    let block = blocks::fly(key, &maker, &camera, &catalogue, &mut solver);
    Ok((block.outcome, 1e3 * begun.elapsed().as_secs_f64() / fields as f64))
}

/// Share that was identified rightly, %, with its interval.
fn right(outcome: &Outcome) -> (f64, [f64; 2]) {
    let right = outcome.identified - outcome.wrong;
    (100.0 * right as f64 / outcome.tried.max(1) as f64, share_interval_percent(right, outcome.tried))
}

fn probability(figure: &Figure) -> Result<Made, HostError> {
    let whole_at = NOISE_ARCSEC[NOISE_ARCSEC.len() - 1];
    let kinds: Vec<(f64, Change)> = NOISE_ARCSEC
        .iter()
        .map(|noise| (*noise, Change::Brightest(STARS)))
        .chain([(whole_at, Change::None)])
        .collect();
    let points: Vec<((f64, Change), f64)> =
        kinds.iter().flat_map(|kind| MULTIPLES.map(|multiple| (*kind, multiple))).collect();
    let tried_at = |((noise, change), multiple): &((f64, Change), f64)| {
        tried(*noise, multiple * std::f64::consts::SQRT_2 * noise, *change, FIELDS)
            .map(|(outcome, _)| outcome)
    };
    let outcomes = points.par_iter().map(tried_at).collect::<Result<Vec<_>, _>>()?;
    let mut series = Vec::new();
    let mut rows = Vec::new();
    for ((noise, change), of_kind) in kinds.iter().zip(outcomes.chunks(MULTIPLES.len())) {
        let curve = MULTIPLES.iter().zip(of_kind).map(|(multiple, of)| [*multiple, right(of).0]).collect();
        let edges = MULTIPLES.iter().zip(of_kind).map(|(multiple, of)| {
            let [low, high] = right(of).1;
            [*multiple, low, high]
        });
        let stars = if *change == Change::None { "all stars".to_owned() } else { format!("{STARS} stars") };
        series.push(
            Series::ours(format!("ours, {noise:.0} arcsec, {stars}"), curve).marked().within(edges.collect()),
        );
        // 1, 3 and 5 times the noise.
        let [one, three, five] = [1, 5, 7].map(|index| right(&of_kind[index]).0);
        let words = format!("{one:.1}, {three:.1}, {five:.1} %");
        rows.push(match (*change, *noise == NOISE_ARCSEC[0]) {
            (Change::Brightest(_), true) => Row {
                what: format!("right at 1, 3, 5 times the noise: {noise:.0} arcsec, {stars}"),
                ..figure.row(1, words)
            },
            _ => Row::alone(format!("right at 1, 3, 5 times the noise: {noise:.0} arcsec, {stars}"), words),
        });
    }
    let first = &outcomes[..MULTIPLES.len()];
    let least = MULTIPLES.iter().zip(first).max_by(|a, b| right(a.1).0.total_cmp(&right(b.1).0));
    rows.insert(
        0,
        figure.row(
            0,
            least.map_or("none".into(), |(multiple, _)| format!("most right at {multiple}, 10 arcsec")),
        ),
    );
    let wrong: u64 = outcomes.iter().map(|outcome| outcome.wrong).sum();
    rows.push(Row::alone(
        "wrong identifications, all fields of the figure",
        format!("{wrong} of {}", FIELDS * outcomes.len() as u64),
    ));
    let best = figure.thesis[0].value;
    series.push(Series::thesis("thesis, best trade-off", vec![[best, 0.0], [best, 100.0]]));
    let chart = Chart {
        title: format!("Right identifications of {FIELDS} random fields of 15 deg"),
        x: Axis::new("tolerance of a separation over its noise, sqrt(2) times a star's"),
        y: Axis::new("identified rightly, %").between([0.0, 102.0]),
        series,
    };
    let verdict = "As in the thesis the curves rise to three sigmas, and beyond, with much noise, a wider tolerance costs right answers. Where the thesis then takes a false \
        sky now and then, the flight code says \u{201c}not identified\u{201d}: an answer is told only with a chance of one in a thousand million of being wrong, which five stars of 30 arcsec \
        and more cannot give. With all stars of the field, as it flies, 60 arcsec are no hindrance.";
    Ok(Made::new(&[chart], rows, verdict))
}

fn time(figure: &Figure) -> Result<Made, HostError> {
    // One after the other: a time is asked for.
    let times =
        TOLERANCES_ARCSEC.iter().map(|tolerance| tried(QUIET_ARCSEC, *tolerance, Change::None, FIELDS));
    let times = times.collect::<Result<Vec<_>, _>>()?;
    let first = times[0].1;
    let ours: Vec<[f64; 2]> =
        TOLERANCES_ARCSEC.iter().zip(&times).map(|(at, (_, ms))| [*at, ms / first]).collect();
    // A parabola through 1 at none and the thesis's factor at 30 arcsec.
    let factor = (figure.thesis[1].value - 1.0) / (30.0 * 30.0);
    let law = TOLERANCES_ARCSEC.map(|at| [at, 1.0 + factor * at * at]).to_vec();
    // Slope of the logarithms from 60 arcsec on.
    let (from, to) = (ours[3], ours[6]);
    let power = (to[1] / from[1]).ln() / (to[0] / from[0]).ln();
    let chart = Chart {
        title: "Time of an identification, over that with the least tolerance".into(),
        x: Axis::logarithmic("tolerance of a separation, arcsec"),
        y: Axis::logarithmic("time over the first"),
        series: vec![
            Series::ours("ours, over 10 arcsec", ours.clone()).marked(),
            Series::thesis("thesis, quadratic through 37 at 30 arcsec, over none", law),
        ],
    };
    let rows = vec![
        figure.row(0, format!("{power:.1} between 60 and 240 arcsec")),
        figure.row(1, format!("{:.2}, over 10 arcsec", ours[2][1])),
        Row::alone(
            "time of an identification at 10 and at 240 arcsec, this machine",
            format!("{} and {} ms", digits(first, 2), digits(times[6].1, 2)),
        ),
        Row::alone("identified rightly at 240 arcsec", format!("{:.1} %", right(&times[6].0).0)),
    ];
    let verdict = "The thesis makes all triangles of all pairs, so its time grows with the square of the tolerance; the flight code goes from one base \
        side to the next and stops at the first polygon that is confirmed, so that a wider tolerance costs it only the pairs of few sides. Times \
        are of this machine; their ratios hardly depend on it.";
    Ok(Made::new(&[chart], rows, verdict))
}
