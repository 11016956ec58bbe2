use super::*;
use crate::cli::CommonArguments;
use rows::Row;
use seen::Fix;
use std::path::Path;

fn arguments(runs: u64, out: Option<&Path>) -> CampaignEarthArguments {
    CampaignEarthArguments {
        runs,
        horizon: Default::default(),
        surface: Default::default(),
        common: CommonArguments {
            seed: 5,
            out: out.map(Path::to_path_buf),
            json: true,
            ..CommonArguments::default()
        },
    }
}

fn with_threads(threads: usize, arguments: &CampaignEarthArguments) -> Vec<Run> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| runs(arguments)).unwrap()
}

#[test]
fn frames_are_the_same_whatever_the_threads_and_stops() {
    let path = std::env::temp_dir().join(format!("sextant-earth-{}.jsonl", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let whole = with_threads(2, &arguments(2, None));
    let first: Vec<Run> = whole.iter().filter(|run| run.run == 0).cloned().collect();
    assert_eq!(with_threads(1, &arguments(1, Some(&path))), first);
    assert_eq!(with_threads(2, &arguments(2, Some(&path))), whole);
    assert_eq!(std::fs::read_to_string(&path).unwrap().lines().count(), 2 * CASES.len());
    std::fs::remove_file(&path).unwrap();
    for run in &whole {
        let case = CASES.iter().find(|case| case.name == run.case).unwrap();
        let [from, to] = case.phase_deg;
        assert!((from..to).contains(&run.phase_deg) && run.lit_limb_deg >= case.least_lit_deg, "{run:?}");
        assert!(
            run.seen.len() == seen::WAYS.len()
                && run.seen.iter().all(|seen| seen.fix.is_some() != seen.refused.is_some())
        );
    }
    // The disc in the middle is found by the flight code, and the table says so.
    let table = Table::of(&whole);
    for row in table.rows.iter().filter(|row| row.case.starts_with("GEO") && row.way == Way::Tracked) {
        assert!(row.found_percent == 100.0 && row.rms_deg.iter().all(|rms| *rms < 0.03), "{row:?}");
    }
    assert!(table.text().contains("Step at noon"));
}

fn run_of(case: &str, way: Way, fix: Option<Fix>) -> Run {
    let refused = fix.is_none().then(|| "ShortArc".to_string());
    Run {
        seed: 1,
        run: 0,
        case: case.into(),
        horizon: "noise".into(),
        surface: "mixed".into(),
        phase_deg: 30.0,
        lit_limb_deg: 180.0,
        limit_deg: Some([0.003, 0.004]),
        seen: vec![Seen { way, refused, fix }],
    }
}

#[test]
fn figures_are_those_counted_by_hand() {
    let fix = |x: f64, nees: f64| Fix {
        error_deg: [x, 0.0],
        sigma_deg: Some([0.004, 0.004]),
        distance_sigma_km: Some(10.0),
        nees: Some(nees),
        ..Fix::default()
    };
    let case = CASES[1].name;
    let runs = [Some(fix(0.003, 3.0)), Some(fix(-0.004, 3.0)), Some(fix(0.013, 6.0)), None]
        .map(|fix| run_of(case, Way::Sun, fix));
    let table = Table::of(&runs);
    let row: &Row = table.rows.iter().find(|row| row.case == case && row.way == Way::Sun).unwrap();
    assert_eq!((row.frames, row.found_percent, row.refused["ShortArc"]), (4, 75.0, 1));
    assert!((row.rms_deg[0] - (194e-6f64 / 3.0).sqrt()).abs() < 1e-12 && row.median_deg[0] == 0.004);
    assert!((row.nees.unwrap() - 4.0 / 3.0).abs() < 1e-12);
    assert!((row.within_3_sigma_percent.unwrap() - 200.0 / 3.0).abs() < 1e-9);
    let half = 1.96 * (2.0f64 / 9.0).sqrt();
    assert!((row.nees_band.unwrap()[1] - 1.0 - half).abs() < 1e-12 && row.kept == Some(true));
    let noon = table.noons.iter().find(|noon| noon.way == Way::Sun).unwrap();
    assert!((noon.step_deg - 0.008).abs() < 1e-12 && noon.step_sigma_deg > 0.0);
    // A covariance that is too small, or a direction worse than is asked, misses.
    let kept = |case: &str, limit: f64, fix: Fix| {
        let run = Run { limit_deg: Some([limit, limit]), ..run_of(case, Way::Sun, Some(fix)) };
        let table = Table::of(&[run]);
        let row = table.rows.iter().find(|row| row.case == case && row.way == Way::Sun).unwrap();
        // A case without a frame misses too.
        assert!(!table.kept());
        row.kept.unwrap()
    };
    assert!(kept(case, 0.003, fix(0.019, 3.0)));
    assert!(!kept(case, 0.003, fix(0.019, 60.0)) && !kept(case, 0.003, fix(0.021, 3.0)));
    // What is impossible is not asked.
    let wide = "LEO, 800 km, wide lens";
    assert!(kept(wide, 0.045, fix(0.06, 3.0)) && !kept(wide, 0.035, fix(0.06, 3.0)));
}

#[test]
fn a_file_of_something_else_is_refused_with_its_line() {
    let path = std::env::temp_dir().join(format!("sextant-earth-other-{}.jsonl", std::process::id()));
    std::fs::write(&path, "{\"id\":3}\n").unwrap();
    let message = runs(&arguments(1, Some(&path))).unwrap_err().to_string();
    assert!(message.contains(".jsonl:1: no line of such a campaign") && !message.contains('\n'), "{message}");
    std::fs::remove_file(&path).unwrap();
}

/// Without clouds, seasons and uneven heights what is left of the limb's height is the method's own: it grows
/// with the distance, as an angle would.
#[test]
fn a_limb_narrower_than_a_pixel_is_found_higher_by_less_than_two_sigmas_of_the_orbit_filter() {
    let mut base = cases::base().unwrap();
    (base.earth.cloud_contrast, base.earth.height_variation_km, base.earth.season) = (0.0, 0.0, false);
    let heights = Heights::of(&base.earth);
    let above = |name: &str, distance_km: f64| {
        let number = CASES.iter().position(|case| case.name == name).unwrap();
        let radii = (0..6).filter_map(|run| {
            let seen = fly(&base, &heights, 3, run, number).unwrap().seen;
            let sun = seen.into_iter().find(|seen| seen.way == Way::Sun)?;
            Some(sun.fix?.radius_error_deg)
        });
        let radii: Vec<f64> = radii.collect();
        let rad = (radii.iter().sum::<f64>() / radii.len() as f64).to_radians();
        println!("{name}: {} frames, {:.2e} rad, {:.2} km higher", radii.len(), rad, distance_km * rad);
        assert!(radii.len() > 3);
        rad
    };
    let expected = fsw_core::orbit::parameters::OrbitParameters::default();
    for name in ["GEO, noon, phase 0-20", "GEO, phase 60-100"] {
        assert!((0.0..2.0 * f64::from(expected.height_sigma_rad)).contains(&above(name, 41_680.0)));
    }
    // From low orbits the angle is nothing beside the sigma of the height.
    assert!((3_290.0 * above("LEO, 800 km, wide lens", 3_290.0)).abs() < f64::from(expected.height_sigma_km));
}
