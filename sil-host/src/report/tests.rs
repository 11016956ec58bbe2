use super::*;
use crate::harness::faults::{Fault, FaultKind};
use crate::harness::{Second, truth_of};
use crate::judge::expected::mode_of;
use crate::judge::{Judge, Judged, Verdict};
use crate::scenario::Scenario;
use crate::world::attitude::apply;
use crate::world::noise::{Noise, Stream};
use fsw_core::modes::Mode;
use fsw_core::telemetry::{
    AttitudeReport, ClockState, EarthReport, EarthStatus, Event, FilteredAttitude, MOTION_CORRELATIONS,
    OrbitReport, Outcome, Report,
};

/// A report of a sensor whose errors are Gaussian with the sigmas it reports; `decay` shrinks those of the
/// orbit.
fn made_up(noise: &Noise, cycle: u32, truth: &crate::world::scene::Truth, decay: f64) -> Report {
    let mode = mode_of(truth.state);
    let draw = |stream: u32| noise.gaussian(cycle, stream);
    let sun = mode == Mode::SunOutage;
    let quaternion = truth.quaternion.map(|c| c as f32);
    let sigma_km = 0.4 + 800.0 * decay;
    let error = [draw(0) * sigma_km, draw(1) * sigma_km, draw(2) * sigma_km];
    let nadir = apply(&truth.earth_path, truth.position_km.map(|c| -c));
    let distance = crate::world::vector::length(nadir);
    let sees = mode == Mode::Tracking;
    let direction =
        [nadir[0] + draw(3) * 8.0, nadir[1] + draw(4) * 8.0, nadir[2]].map(|c| (c / distance) as f32);
    let attitude =
        AttitudeReport { quaternion, sigma_rad: [5e-6, 5e-6, 35e-6], log10_false: -20.0, age_s: 0 };
    Report {
        cycle,
        local_us: i64::from(cycle) * 1_000_000,
        instant_us: Some(truth.instant_us),
        clock: ClockState::Synchronised,
        mode,
        outcome: Some(if cycle == 0 { Outcome::Identified } else { Outcome::Tracked }),
        attitude: (!sun).then_some(attitude),
        filtered: (!sun).then_some(FilteredAttitude { quaternion, sigma_rad: attitude.sigma_rad }),
        detections: 30,
        earth_status: if sees { EarthStatus::Found } else { EarthStatus::Dark },
        earth: sees.then_some(EarthReport {
            direction,
            sigma_rad: 2e-4,
            distance_km: (distance + 6.0 * draw(5)) as f32,
            sigma_km: 6.0,
            covariance_km2: [1.0, 0.0, 1.0, 0.0, 0.0, 36.0],
            inliers: 40,
            arc_deg: 180.0,
            rms_px: 0.3,
        }),
        orbit: (cycle > 20).then_some(OrbitReport {
            position_km: [0, 1, 2].map(|k| truth.position_km[k] + error[k]),
            velocity_km_s: [0, 1, 2].map(|k| truth.velocity_km_s[k] + error[k] * 1e-4),
            sigma_position_km: [sigma_km as f32; 3],
            sigma_velocity_km_s: [sigma_km as f32 * 1e-4; 3],
            correlations: [0.0; MOTION_CORRELATIONS],
            sigma_hill_km: [0.0; 3],
            elements: None,
            limb_height_km: 0.3,
            limb_height_sigma_km: 0.5,
            misalignment_rad: [0.0; 3],
            misalignment_sigma_rad: [0.0; 3],
            nis: sees.then_some(3.0),
            nis_freedom: 3,
            since_fix_s: 0,
            settled: decay < 1e-3,
        }),
        events: if cycle == 21 { [Event::OrbitStarted].into_iter().collect() } else { Default::default() },
        ..Report::default()
    }
}

/// What is said to be broken.
const FAULTS: [Fault; 1] = [Fault { kind: FaultKind::TimeOut(1.0), from_s: 700, until_s: 760 }];

/// The page of a made-up run of the default scenario, and its figures.
fn made_up_page() -> (String, crate::judge::Figures) {
    let scenario = Scenario::default_embedded();
    let mut scene = scenario.scene().unwrap();
    let noise = Noise::new(7, 0, Stream::Attitude);
    let mut judge = Judge::new(scenario.duration_s, scenario.period_s());
    let mut recorder = Recorder::new(scenario.duration_s);
    for cycle in 0..scenario.duration_s {
        let truth = truth_of(&scene, cycle).unwrap();
        let decay = libm::exp(-f64::from(cycle) / 700.0);
        let report = made_up(&noise, cycle, &truth, decay);
        let judged = Judged::new(&report, &truth, &truth);
        let right = judge.add(&judged);
        recorder.add_bound(cycle, (cycle > 100).then_some([0.3; 3]));
        let (rate, field) = (None, None);
        let second = Second {
            cycle,
            report: &report,
            truth: &truth,
            judged: &judged,
            rate,
            field,
            scene: &scene,
            faults: &FAULTS,
            windows: &[],
        };
        recorder.add(&second, right);
    }
    let figures = judge.finish();
    let verdicts = Verdict::all(&scenario.limits, &figures);
    let page =
        page::html(&scenario, &recorder, (&figures, &verdicts), &mut scene, "sil-host run it").unwrap();
    (page, figures)
}

#[test]
fn the_page_needs_nothing_else_and_shows_every_part() {
    let (page, figures) = made_up_page();
    for part in [
        "<h2>Modes</h2>",
        "Attitude error</h2>",
        "Position error</h2>",
        "Velocity error</h2>",
        "Earth vector error</h2>",
        "<h2>Frames</h2>",
        "<h2>Events</h2>",
        "first orbit found and tested",
        "data:image/png;base64,",
        "\u{2713} kept",
        "class=\"fault\"",
        "class=\"bound\"",
        "bound of the horizon",
        "<title>1 time-out</title>",
        "second 21: first orbit found and tested",
        "<h2>Injected faults</h2>",
        "<h2>Orbit and Sun</h2>",
        "<h2>Are the sigmas right?</h2>",
        "<b>Earth's direction</b>: sigmas",
        "normalised innovation squared",
        "<code>sil-host run it</code>",
        concat!("Sextant ", env!("CARGO_PKG_VERSION")),
    ] {
        assert!(page.contains(part), "{part} is missing");
    }
    // Pictures are text that may spell anything.
    let text: String =
        page.split("base64,").map(|part| part.split_once('"').map_or(part, |(_, rest)| rest)).collect();
    for foreign in ["http:", "https:", "<script", "src=", "url(", "NaN", "inf "] {
        assert!(!text.contains(foreign), "{foreign} is in the page");
    }
    assert!(page.len() < 4_000_000, "{} bytes", page.len());
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
    // What was drawn with the sigmas it reports is judged to have them: three axes within three sigma, 99.19
    // %.
    let within = figures.orbit.position_within_3_sigma_share.unwrap();
    let expected = 0.9973f64.powi(3);
    let seconds = f64::from(figures.seconds - figures.orbit.first_s.unwrap());
    let tolerance = 4.0 * (expected * (1.0 - expected) / seconds).sqrt();
    assert!((within - expected).abs() < tolerance, "{within}");
    assert!((figures.orbit.position_normalised_square.unwrap() - 1.0).abs() < 0.03);
    let direction_deg = figures.earth.direction_rms_deg.unwrap();
    assert!((direction_deg / (8.0 / 42_165.0f64).to_degrees() - 1.0).abs() < 0.03, "{direction_deg}");
    assert!((figures.earth.distance_rms_km.unwrap() / 6.0 - 1.0).abs() < 0.03);
    assert_eq!(figures.mode_share, Some(1.0));
}

#[test]
fn the_verdict_comes_first_then_frames_then_figures_then_plots() {
    let (page, figures) = made_up_page();
    let mut at = 0;
    for part in [
        "class=\"badge",
        "class=\"sentence",
        "<h2>Frames",
        "<h2>Limits",
        "<h2>Figures",
        "<h2>Plots",
        "<h2>Terms",
    ] {
        let next = page.find(part).unwrap_or_else(|| panic!("{part} is missing"));
        assert!(next > at, "{part} comes too early");
        at = next;
    }
    // A made-up filter knows no innovations: every one is 3, which chance does not do.
    let limits = page.matches("\u{2717} MISSED").count();
    assert_eq!(
        page.matches("<tr class=\"missed\"").count() - limits,
        opinion::contradictions(&figures).len()
    );
    assert!(limits == 0 || page.find("\u{2717} MISSED") < page.find("\u{2713} kept"));
    assert_eq!(page.contains("badge good"), limits == 0 && opinion::contradictions(&figures).is_empty());
}

#[test]
fn equal_runs_give_equal_pages() {
    assert!(made_up_page().0 == made_up_page().0);
}
