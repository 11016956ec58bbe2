use super::*;
use crate::cli::CommonArguments;

fn arguments(runs: u64, out: Option<&Path>) -> CampaignAcquireArguments {
    CampaignAcquireArguments {
        runs,
        common: CommonArguments {
            seed: 5,
            out: out.map(Path::to_path_buf),
            json: true,
            ..CommonArguments::default()
        },
    }
}

fn with_threads(threads: usize, arguments: &CampaignAcquireArguments) -> Vec<Run> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| runs(arguments)).unwrap()
}

#[test]
fn random_directions_are_found_whatever_the_threads_and_stops() {
    let path = std::env::temp_dir().join(format!("sextant-acquire-{}.jsonl", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let whole = with_threads(2, &arguments(12, None));
    assert_eq!(with_threads(1, &arguments(5, Some(&path))), whole[..5]);
    assert_eq!(with_threads(2, &arguments(12, Some(&path))), whole);
    assert_eq!(std::fs::read_to_string(&path).unwrap().lines().count(), 12);
    std::fs::remove_file(&path).unwrap();
    let figures = Figures::of(&whole);
    // About 2 of 100 need more than three cycles.
    assert!(figures.wrong == 0 && figures.without.len() <= 2, "{figures:?}");
    let sights: std::collections::BTreeSet<_> =
        whole.iter().map(|run| run.sight_deg[0] as i64 / 30).collect();
    assert!(sights.len() >= 5, "spread over the sky: {sights:?}");
}

#[test]
fn figures_are_those_counted_by_hand() {
    let run = |number, cycles: Option<u32>, error: f64| Run {
        seed: 1,
        run: number,
        sight_deg: [10.0, 20.0],
        cycles,
        error_arcsec: cycles.map(|_| [error, 0.0, 0.0]),
        sigma_arcsec: cycles.map(|_| [1.0; 3]),
        stars: 8,
    };
    let figures =
        Figures::of(&[run(0, Some(1), 1.0), run(1, Some(3), 4.0), run(2, None, 0.0), run(3, Some(1), 301.0)]);
    assert_eq!((figures.by_cycle, figures.wrong, figures.kept), ([2, 0, 1], 1, false));
    assert_eq!((figures.found_percent, figures.without), (75.0, vec![(2, [10.0, 20.0])]));
    assert!((figures.within_3_sigma_percent - 100.0 / 3.0).abs() < 1e-9);
}

#[test]
fn a_file_of_something_else_is_refused_with_its_line() {
    let path = std::env::temp_dir().join(format!("sextant-acquire-other-{}.jsonl", std::process::id()));
    std::fs::write(&path, "{\"id\":3}\n").unwrap();
    let message = runs(&arguments(1, Some(&path))).unwrap_err().to_string();
    assert!(message.contains(".jsonl:1: no line of such a campaign") && !message.contains('\n'), "{message}");
    std::fs::remove_file(&path).unwrap();
}
