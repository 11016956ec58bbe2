//! The judge judged: a flight as honest as it says passes, and whatever is made wrong in it is found.
//!
//! The honest flight is drawn, not flown: the truth of the default scenario with errors of the sigmas that
//! are reported, those of the orbit going together for [`TAU_S`]. So the test says nothing of the flight code
//! and does not depend on it.

use super::expected::mode_of;
use super::{Judge, Judged, Verdict};
use crate::harness::truth_of;
use crate::scenario::Scenario;
use crate::world::attitude::{apply, compose};
use crate::world::noise::{Noise, Stream};
use crate::world::scene::Truth;
use crate::world::vector::length;
use fsw_core::modes::Mode;
use fsw_core::telemetry::{
    AttitudeReport, EarthReport, FilteredAttitude, MOTION_CORRELATIONS, OrbitReport, Report,
};
use std::path::Path;

/// For so long errors of position and velocity go together, s.
const TAU_S: f64 = 120.0;
const ATTITUDE_SIGMA_RAD: [f64; 3] = [5e-6, 5e-6, 35e-6];
const FILTERED_SIGMA_RAD: [f64; 3] = [2e-6, 2e-6, 14e-6];
const POSITION_SIGMA_KM: f64 = 0.4;
const VELOCITY_SIGMA_KM_S: f64 = 4e-5;
/// Correlation of the position's x and y.
const CORRELATION: f64 = 0.8;
const DIRECTION_SIGMA_RAD: f64 = 2e-4;
const DISTANCE_SIGMA_KM: f64 = 6.0;

/// What is demanded of it: two per mille of right sigmas are refused on each side, by each.
const LIMITS: &str = "attitude_valid_share = 0.999
within_3_sigma_share = 0.98
mode_share = 0.999
mode_latest_s = 4
first_attitude_s = 5
recovery_s = 5
attitude_consistency = 0.004
attitude_jump_sigma = 8.0
attitude_worst_sigma = 6.0
mode_changes_10_s = 4
attitude_bias_sigma = 0.5
attitude_sigma_arcsec = 9.0
filtered_consistency = 0.004
filtered_bias_sigma = 0.5
filtered_bias_arcsec = 0.1
filtered_noise_arcsec = 0.5
earth_direction_consistency = 0.004
earth_distance_consistency = 0.004
earth_distance_bias_sigma = 0.5
position_consistency = 0.004
position_95_km = 1.5
position_jump_sigma = 2.0
velocity_consistency = 0.004
velocity_95_m_s = 0.15
settled_s = 100
nis_consistency = 0.004
";

/// The turned attitude: `error` rotates the true axes into the estimated ones, rad.
fn turned(truth: [f64; 4], error: [f64; 3]) -> [f32; 4] {
    let [x, y, z] = error.map(|angle| 0.5 * angle);
    compose([x, y, z, libm::sqrt(1.0 - x * x - y * y - z * z)], truth).map(|part| part as f32)
}

/// Covariance of a centre known as well along all axes, km².
fn even(sigma_km: f64) -> [f32; 6] {
    let variance = (sigma_km * sigma_km) as f32;
    [variance, 0.0, variance, 0.0, 0.0, variance]
}

/// Position's x and y correlated, nothing else.
fn correlations(of_x_and_y: f64) -> [f32; MOTION_CORRELATIONS] {
    let mut correlations = [0.0; MOTION_CORRELATIONS];
    correlations[0] = of_x_and_y as f32;
    correlations
}

/// What an honest sensor would report, second by second.
fn honest(truths: &[Truth], seed: u64) -> Vec<Report> {
    let noise = Noise::new(seed, 0, Stream::Attitude);
    let kept = libm::exp(-1.0 / TAU_S);
    let mut slow: [f64; 6] = std::array::from_fn(|stream| noise.gaussian(u32::MAX, stream as u32));
    let mut reports = Vec::with_capacity(truths.len());
    for (cycle, truth) in (0..).zip(truths) {
        let draw = |stream: u32| noise.gaussian(cycle, stream);
        for (slow, stream) in slow.iter_mut().zip(0..) {
            *slow = kept * *slow + libm::sqrt(1.0 - kept * kept) * draw(stream);
        }
        let drawn = |sigma: [f64; 3], from: u32| [0, 1, 2].map(|axis| sigma[axis] * draw(from + axis as u32));
        let mode = mode_of(truth.state);
        let nadir = apply(&truth.earth_path, truth.position_km.map(|part| -part));
        let distance = length(nadir);
        let seen = [
            nadir[0] + distance * DIRECTION_SIGMA_RAD * draw(20),
            nadir[1] + distance * DIRECTION_SIGMA_RAD * draw(21),
            nadir[2],
        ];
        let [x, y, z, ..] = slow;
        let together = [x, CORRELATION * x + libm::sqrt(1.0 - CORRELATION * CORRELATION) * y, z];
        let sun = mode == Mode::SunOutage;
        let fix = mode == Mode::Tracking;
        // The sum of three squares, where three degrees of freedom are expected.
        let nis = [0, 1, 2].map(|axis| draw(30 + axis)).map(|deviate| deviate * deviate).iter().sum::<f64>();
        reports.push(Report {
            cycle,
            instant_us: Some(truth.instant_us),
            mode,
            attitude: (!sun && cycle >= 2).then(|| AttitudeReport {
                quaternion: turned(truth.quaternion, drawn(ATTITUDE_SIGMA_RAD, 10)),
                sigma_rad: ATTITUDE_SIGMA_RAD.map(|sigma| sigma as f32),
                log10_false: -20.0,
                age_s: 0,
            }),
            filtered: (!sun && cycle >= 5).then(|| FilteredAttitude {
                quaternion: turned(truth.quaternion, drawn(FILTERED_SIGMA_RAD, 13)),
                sigma_rad: FILTERED_SIGMA_RAD.map(|sigma| sigma as f32),
            }),
            earth: fix.then(|| EarthReport {
                direction: seen.map(|part| (part / length(seen)) as f32),
                sigma_rad: DIRECTION_SIGMA_RAD as f32,
                distance_km: (distance + DISTANCE_SIGMA_KM * draw(22)) as f32,
                sigma_km: DISTANCE_SIGMA_KM as f32,
                covariance_km2: even(distance * DIRECTION_SIGMA_RAD),
                inliers: 40,
                arc_deg: 180.0,
                rms_px: 0.3,
            }),
            orbit: (cycle >= 20).then(|| OrbitReport {
                position_km: [0, 1, 2]
                    .map(|axis| truth.position_km[axis] + POSITION_SIGMA_KM * together[axis]),
                velocity_km_s: [0, 1, 2]
                    .map(|axis| truth.velocity_km_s[axis] + VELOCITY_SIGMA_KM_S * slow[3 + axis]),
                sigma_position_km: [POSITION_SIGMA_KM as f32; 3],
                sigma_velocity_km_s: [VELOCITY_SIGMA_KM_S as f32; 3],
                correlations: correlations(CORRELATION),
                sigma_hill_km: [0.0; 3],
                elements: None,
                limb_height_km: 0.3,
                limb_height_sigma_km: 0.5,
                misalignment_rad: [0.0; 3],
                misalignment_sigma_rad: [0.0; 3],
                nis: fix.then_some(nis as f32),
                nis_freedom: 3,
                since_fix_s: 0,
                settled: cycle >= 60,
            }),
            ..Report::default()
        });
    }
    reports
}

fn each_attitude(reports: &mut [Report], change: impl Fn(&mut AttitudeReport)) {
    reports.iter_mut().filter_map(|report| report.attitude.as_mut()).for_each(change);
}

fn each_filtered(reports: &mut [Report], change: impl Fn(&mut FilteredAttitude)) {
    reports.iter_mut().filter_map(|report| report.filtered.as_mut()).for_each(change);
}

fn each_earth(reports: &mut [Report], change: impl Fn(&mut EarthReport)) {
    reports.iter_mut().filter_map(|report| report.earth.as_mut()).for_each(change);
}

fn each_orbit(reports: &mut [Report], change: impl Fn(&mut OrbitReport)) {
    reports.iter_mut().filter_map(|report| report.orbit.as_mut()).for_each(change);
}

/// Moves what `of` gives by `seconds` to later.
fn late<T: Clone>(reports: &mut [Report], seconds: usize, of: impl Fn(&mut Report) -> &mut T) {
    for second in (seconds..reports.len()).rev() {
        let before = of(&mut reports[second - seconds]).clone();
        *of(&mut reports[second]) = before;
    }
}

/// Holds what `of` gives through a stretch of seconds.
fn frozen<T: Clone>(
    reports: &mut [Report],
    stretch: std::ops::Range<usize>,
    of: impl Fn(&mut Report) -> &mut T,
) {
    let held = of(&mut reports[stretch.start]).clone();
    reports[stretch].iter_mut().for_each(|report| *of(report) = held.clone());
}

fn turn(quaternion: &mut [f32; 4], error: [f64; 3]) {
    *quaternion = turned(quaternion.map(f64::from), error);
}

/// An attitude in the middle of the flight.
fn middle(reports: &mut [Report]) -> &mut Report {
    let from = reports.len() / 2;
    let known = |report: &&mut Report| report.attitude.is_some() && report.earth.is_some();
    reports[from..].iter_mut().find(known).expect("the Earth is in light after the middle")
}

type Mutation = (&'static str, fn(&mut [Report]));

const MUTATIONS: [Mutation; 43] = [
    ("attitude sigma x 3", |all| {
        each_attitude(all, |of| of.sigma_rad = of.sigma_rad.map(|sigma| 3.0 * sigma))
    }),
    ("attitude sigma / 3", |all| {
        each_attitude(all, |of| of.sigma_rad = of.sigma_rad.map(|sigma| sigma / 3.0))
    }),
    ("attitude sigma about z x 0.5", |all| each_attitude(all, |of| of.sigma_rad[2] *= 0.5)),
    ("attitude NaN in one second", |all| middle(all).attitude.as_mut().unwrap().quaternion[1] = f32::NAN),
    ("attitude sigma infinite in one second", |all| {
        middle(all).attitude.as_mut().unwrap().sigma_rad[0] = f32::INFINITY;
    }),
    ("attitude sigma zero in one second", |all| middle(all).attitude.as_mut().unwrap().sigma_rad[0] = 0.0),
    ("attitude frozen for a minute", |all| frozen(all, 3000..3060, |report| &mut report.attitude)),
    ("attitude the other way round", |all| each_attitude(all, |of| of.quaternion[3] *= -1.0)),
    ("attitude a second late", |all| late(all, 1, |report| &mut report.attitude)),
    ("attitude, x and y swapped", |all| each_attitude(all, |of| of.quaternion.swap(0, 1))),
    ("attitude, bias of 2 sigma", |all| each_attitude(all, |of| turn(&mut of.quaternion, [1e-5, 0.0, 0.0]))),
    ("attitude wrong by 5 deg in one second", |all| {
        turn(&mut middle(all).attitude.as_mut().unwrap().quaternion, [0.09, 0.0, 0.0]);
    }),
    ("attitude missing in every 20th second", |all| {
        all.iter_mut().step_by(20).for_each(|report| report.attitude = None);
    }),
    ("attitude missing for ten seconds", |all| {
        all[3000..3010].iter_mut().for_each(|report| report.attitude = None);
    }),
    ("attitude half a minute after the start", |all| {
        all[..30].iter_mut().for_each(|report| report.attitude = None);
    }),
    ("mode 5 s late", |all| late(all, 5, |report| &mut report.mode)),
    ("mode stays in tracking", |all| all.iter_mut().for_each(|report| report.mode = Mode::Tracking)),
    ("mode safe for a minute", |all| all[3000..3060].iter_mut().for_each(|report| report.mode = Mode::Safe)),
    ("filtered attitude's sigma x 3", |all| {
        each_filtered(all, |of| of.sigma_rad = of.sigma_rad.map(|sigma| 3.0 * sigma))
    }),
    ("filtered attitude's sigma / 3", |all| {
        each_filtered(all, |of| of.sigma_rad = of.sigma_rad.map(|sigma| sigma / 3.0))
    }),
    ("filtered attitude a second late", |all| late(all, 1, |report| &mut report.filtered)),
    ("filtered attitude, bias of 2 sigma", |all| {
        each_filtered(all, |of| turn(&mut of.quaternion, [0.0, 4e-6, 0.0]))
    }),
    ("position sigma x 3", |all| {
        each_orbit(all, |of| of.sigma_position_km = of.sigma_position_km.map(|sigma| 3.0 * sigma))
    }),
    ("position sigma / 3", |all| {
        each_orbit(all, |of| of.sigma_position_km = of.sigma_position_km.map(|sigma| sigma / 3.0))
    }),
    ("position NaN in one second", |all| middle(all).orbit.as_mut().unwrap().position_km[2] = f64::NAN),
    ("position sigma NaN in one second", |all| {
        middle(all).orbit.as_mut().unwrap().sigma_position_km[2] = f32::NAN
    }),
    ("orbit frozen for ten minutes", |all| frozen(all, 3000..3600, |report| &mut report.orbit)),
    ("position with its sign changed", |all| {
        each_orbit(all, |of| of.position_km = of.position_km.map(|part| -part))
    }),
    ("orbit a second late", |all| late(all, 1, |report| &mut report.orbit)),
    ("position, y and z swapped", |all| each_orbit(all, |of| of.position_km.swap(1, 2))),
    ("position, bias of 2 sigma", |all| each_orbit(all, |of| of.position_km[0] += 0.8)),
    ("position in metres", |all| {
        each_orbit(all, |of| of.position_km = of.position_km.map(|part| 1e3 * part))
    }),
    ("position 4 sigma off in one second", |all| middle(all).orbit.as_mut().unwrap().position_km[1] += 1.6),
    ("velocity sigma / 3", |all| {
        each_orbit(all, |of| of.sigma_velocity_km_s = of.sigma_velocity_km_s.map(|sigma| sigma / 3.0));
    }),
    ("velocity in m/s", |all| {
        each_orbit(all, |of| of.velocity_km_s = of.velocity_km_s.map(|part| 1e3 * part))
    }),
    ("position's correlation with the other sign", |all| {
        each_orbit(all, |of| of.correlations = correlations(-CORRELATION))
    }),
    ("orbit never settled", |all| each_orbit(all, |of| of.settled = false)),
    ("no orbit", |all| all.iter_mut().for_each(|report| report.orbit = None)),
    ("innovations x 3", |all| each_orbit(all, |of| of.nis = of.nis.map(|nis| 9.0 * nis))),
    ("innovations / 3", |all| each_orbit(all, |of| of.nis = of.nis.map(|nis| nis / 9.0))),
    ("Earth's direction sigma / 3", |all| {
        each_earth(all, |of| of.covariance_km2 = of.covariance_km2.map(|element| element / 9.0))
    }),
    ("Earth's distance, bias of 2 sigma", |all| each_earth(all, |of| of.distance_km += 12.0)),
    ("Earth's distance NaN in one second", |all| middle(all).earth.as_mut().unwrap().distance_km = f32::NAN),
];

#[test]
fn an_honest_flight_passes_and_every_mutation_of_it_is_found() {
    let (_, text) = crate::scenario::EMBEDDED[0];
    let head = text.split("[limits]").next().unwrap();
    let scenario = Scenario::parse(Path::new("mutated.toml"), &format!("{head}[limits]\n{LIMITS}")).unwrap();
    let scene = scenario.scene().unwrap();
    let truths: Vec<Truth> = (0..scenario.duration_s).map(|cycle| truth_of(&scene, cycle).unwrap()).collect();
    let missed = |reports: &[Report]| -> Vec<&'static str> {
        let mut judge = Judge::new(scenario.duration_s, scenario.period_s());
        for (report, truth) in reports.iter().zip(&truths) {
            judge.add(&Judged::new(report, truth, truth));
        }
        let verdicts = Verdict::all(&scenario.limits, &judge.finish());
        verdicts.iter().filter(|verdict| !verdict.kept).map(|verdict| verdict.limit).collect()
    };
    for seed in 1..=5 {
        assert_eq!(missed(&honest(&truths, seed)), [""; 0], "seed {seed}");
    }
    let honest = honest(&truths, 1);
    // The other sign of a quaternion is the same attitude.
    let mut same = honest.clone();
    each_attitude(&mut same, |of| of.quaternion = of.quaternion.map(|part| -part));
    assert_eq!(missed(&same), [""; 0]);
    let mut unseen = Vec::new();
    for (name, mutate) in MUTATIONS {
        let mut mutated = honest.clone();
        mutate(&mut mutated);
        let missed = missed(&mutated);
        println!("{name:40} {}", missed.join(", "));
        if missed.is_empty() {
            unseen.push(name);
        }
    }
    assert!(unseen.is_empty(), "not found: {unseen:?}");
    // What lasts is told from what does not: 0.82 arcsec of bias, and noise as before.
    let mut biased = honest;
    each_filtered(&mut biased, |of| turn(&mut of.quaternion, [0.0, 4e-6, 0.0]));
    let missed = missed(&biased);
    assert!(missed.contains(&"filtered_bias_arcsec") && !missed.contains(&"filtered_noise_arcsec"));
}
