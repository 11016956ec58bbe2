use super::*;
use crate::cli::CommonArguments;

fn arguments(fields: u64, skies: u64, out: Option<&Path>) -> CampaignIdentifyArguments {
    CampaignIdentifyArguments {
        fields,
        skies,
        no_stars: 0,
        common: CommonArguments {
            seed: 11,
            out: out.map(Path::to_path_buf),
            json: true,
            ..CommonArguments::default()
        },
    }
}

fn outcomes(rows: &[Row]) -> Vec<(String, Outcome)> {
    rows.iter().map(|row| (row.case.clone(), row.outcome)).collect()
}

fn with_threads(threads: usize, arguments: &CampaignIdentifyArguments) -> Vec<(String, Outcome)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    outcomes(&pool.install(|| rows(arguments)).unwrap())
}

#[test]
fn the_table_does_not_depend_on_the_number_of_threads_nor_on_a_stop_between() {
    let whole = with_threads(1, &arguments(0, 700, None));
    assert_eq!(with_threads(3, &arguments(0, 700, None)), whole);
    let path = std::env::temp_dir().join(format!("sextant-campaign-{}.jsonl", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let lines = || std::fs::read_to_string(&path).unwrap().lines().count();
    with_threads(2, &arguments(0, 500, Some(&path)));
    assert_eq!(lines(), 2);
    assert_eq!(with_threads(2, &arguments(0, 700, Some(&path))), whole);
    assert_eq!(lines(), 3);
    assert_eq!(with_threads(2, &arguments(0, 700, Some(&path))), whole);
    assert_eq!(lines(), 3, "nothing was tried again");
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn hard_fields_are_identified_and_never_wrongly() {
    let rows = rows(&arguments(20, 0, None)).unwrap();
    let of = |name: &str| rows.iter().find(|row| row.case == name).unwrap();
    for row in rows.iter().filter(|row| row.peers_percent.is_some() || row.outcome.stated_ppb < 1000) {
        assert_eq!(row.outcome.wrong, 0, "{}", row.case);
    }
    for name in ["240 arcsec", "untold lens, 240 arcsec", "close pairs", "5 planets"] {
        assert_eq!(of(name).identified_percent, 100.0, "{name}");
    }
    for (name, least) in [
        ("3 stars, up to 10 % false", 60.0),
        ("4 stars, up to 10 % false", 70.0),
        ("5 brightest stars", 70.0),
        ("7 stars before 45 of clouds", 80.0),
        ("edge stars", 60.0),
        ("half of the stars missing", 85.0),
    ] {
        assert!(of(name).identified_percent >= least, "{name}: {}", of(name).identified_percent);
    }
}

#[test]
fn a_row_is_kept_without_wrong_skies_and_not_behind_the_peers() {
    let case = |name: &str| cases::grid().into_iter().find(|case| case.name == name).unwrap();
    let outcome = |identified, wrong| Outcome { tried: 1000, identified, wrong, ..Outcome::default() };
    let noisy = case("2 px, 0 false");
    assert!(Row::new(&noisy, outcome(945, 0), 0).kept);
    assert!(!Row::new(&noisy, outcome(944, 0), 0).kept);
    assert!(!Row::new(&noisy, outcome(1000, 1), 0).kept);
    let few = cases::hard().into_iter().find(|case| !case.as_in_flight()).unwrap();
    let stated = |wrong| Outcome { stated_ppb: 4_000_000_000, ..outcome(900, wrong) };
    assert!(Row::new(&few, stated(10), 0).kept, "4 stated, 3 standard deviations of 2");
    assert!(!Row::new(&few, stated(11), 0).kept);
}
