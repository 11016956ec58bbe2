use super::*;
use crate::cli::CommonArguments;

/// Flights of a scenario that yield what a scenario of the program limits, the last one missing it.
fn flights(scenario: &str, differences: &str, count: u64) -> Vec<Flight> {
    let flown = |run: u64| Flown {
        scenario: scenario.to_owned(),
        seed: 1,
        run,
        flight_seed: run,
        drawn: Default::default(),
        figures: [("mode_share".to_owned(), 0.99), ("filtered_bias_arcsec".to_owned(), 0.1 * run as f64)]
            .into(),
        missed: if run + 1 == count { vec!["rate_share".to_owned()] } else { Vec::new() },
        program: "0 build 1".to_owned(),
    };
    (0..count).map(|run| Flight { differences: differences.to_owned(), flown: flown(run) }).collect()
}

fn arguments(scenarios: &[&str], runs: u64) -> CampaignScenariosArguments {
    let common = CommonArguments { seed: 1, json: true, ..CommonArguments::default() };
    let scenarios = scenarios.iter().map(PathBuf::from).collect();
    CampaignScenariosArguments { scenarios, runs, common, ..CampaignScenariosArguments::default() }
}

#[test]
fn a_page_says_of_every_limited_figure_what_was_reached_and_missed() {
    let arguments = arguments(&["tumbling", "gto"], 20);
    let variants = variants_of(&arguments).unwrap();
    let mut all = flights("tumbling", DRAWN, 20);
    all.extend(flights("tumbling", NONE, 3));
    let parts = parts(&variants, all);
    // Of gto nothing was flown.
    assert_eq!(parts.len(), 1);
    let rows = parts[0].rows();
    let share = rows.iter().find(|row| row.figure == "rate_share").unwrap();
    assert_eq!((share.limit, share.missed, share.drawn.is_none()), (Some(0.3), [1, 1], true));
    let text = page::text(&parts, &command(&arguments), 1);
    let line = |words: &str| text.lines().find(|line| line.contains(words)).unwrap();
    assert!(line("rate known while").contains("19 of 20, **MISSED**"), "{text}");
    let mode = line("mode as the geometry says");
    assert!(mode.contains("\u{2265} 95.00 %") && mode.contains("all 20") && mode.contains("all 3"), "{mode}");
    // Ranks 6 and 15 about the median, 17 and none about the quantile; told the truth 0, 0.1, 0.2.
    let bias = line("filtered attitude, bias");
    assert!(bias.contains("0.95 arcsec (0.5 arcsec to 1.4 arcsec)"), "{bias}");
    assert!(bias.contains("1.8 arcsec (1.6 arcsec to ?)") && bias.contains("| 0.1 arcsec |"), "{bias}");
    assert!(text.contains("**MISSED: 1 of 7 limits.**") && text.contains("runs 0\u{2013}19"), "{text}");
    assert!(text.contains("from 23 flights") && text.contains("**23 of them were not flown by"), "{text}");
    assert!(text.contains(&format!("{} campaign scenarios tumbling gto --runs 20 --seed 1", program())));
    // Every line of a table has as many cells as its head.
    let table = text.lines().filter(|line| line.starts_with('|'));
    assert!(table.map(|line| line.matches('|').count()).all(|bars| bars == 9), "{text}");
}

#[test]
fn all_scenarios_draw_an_instrument_for_each_seed_and_are_told_the_truth_beside_it() {
    let variants = variants_of(&arguments(&[], 200)).unwrap();
    assert_eq!(variants.rows.len(), 2 * EMBEDDED.len());
    let mut squares = 0.0;
    for run in 0..200 {
        let (scenario, drawn) = variants.rows[0].1.member(1, run).unwrap();
        let [x, y] = scenario.believed.optical_centre_px;
        squares += x * x + y * y;
        assert_eq!((drawn.len(), variants.rows[1].1.member(1, run).unwrap().1.len()), (2, 0));
    }
    // The flight code's own sigma, to the 5 % of 400 numbers.
    let told = fsw_core::parameters::MountParameters::default().boresight_sigma_px;
    let sigma = libm::sqrt(squares / 400.0);
    assert!((sigma / f64::from(told) - 1.0).abs() < 0.12, "{sigma}");
    assert!(BESIDE.iter().all(|key| table::figure(key).is_some()));
}

#[test]
fn a_page_is_made_of_what_a_file_holds() {
    let folder = std::env::temp_dir().join(format!("sextant-scenarios-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let short = |name: &str| {
        let text = EMBEDDED[0].1.replace("duration_s = 21600", "duration_s = 12");
        let path = folder.join(format!("{name}.toml"));
        std::fs::write(&path, text.replace("name = \"geo-eclipse\"", &format!("name = \"{name}\""))).unwrap();
        path
    };
    let with = |scenarios: &[&PathBuf], held| CampaignScenariosArguments {
        scenarios: scenarios.iter().map(|path| path.to_path_buf()).collect(),
        page: Some(folder.join("page.md")),
        common: CommonArguments { held, out: Some(folder.join("flights.jsonl")), ..arguments(&[], 1).common },
        ..arguments(&[], 1)
    };
    let [one, other] = ["one", "other"].map(short);
    run(&with(&[&one], false)).unwrap();
    run(&with(&[&one, &other], true)).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert!(read("page.md").contains("## one") && !read("page.md").contains("## other"));
    run(&with(&[&one, &other], false)).unwrap();
    assert!(read("page.md").contains("## other"));
    assert!(!read("page.md").contains("not flown by"));
    // A run is flown once, both ways with one seed.
    let lines = read("flights.jsonl");
    assert_eq!(lines.lines().count(), 4);
    let flights: Vec<Flight> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(flights.iter().all(|flight| flight.flown.flight_seed == flights[0].flown.flight_seed));
    assert!(flights.iter().all(|flight| flight.flown.program == flights[0].flown.program));
    assert!(run(&with(&[&one, &one], true)).unwrap_err().to_string().contains("two scenarios"));
    std::fs::remove_dir_all(&folder).unwrap();
}
