use super::*;
use crate::scenario::EMBEDDED;

fn family(vary: &str) -> Family {
    let variation = Variation::parse(Path::new("vary.toml"), vary.to_owned()).unwrap();
    Family::of_text(Path::new("geo.toml"), EMBEDDED[0].1, Some(variation)).unwrap()
}

fn refusal(vary: &str) -> String {
    let message = family(vary).member(1, 4).unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

#[test]
fn a_run_has_what_it_draws_and_the_values_stand_beside() {
    let vary =
        "[scenario]\nduration_s = { whole = [20, 30] }\n[gyro]\nnoise_deg_s = { log_uniform = [0.01, 1.0] }";
    let (scenario, values) = family(vary).member(1, 4).unwrap();
    assert_eq!(values["scenario.duration_s"], scenario.duration_s);
    assert_eq!(values["gyro.noise_deg_s"], scenario.gyro.unwrap().noise_deg_s);
    assert!((20..=30).contains(&scenario.duration_s));
    let (again, _) = family(vary).member(1, 4).unwrap();
    assert_eq!((again.seed, again.duration_s), (scenario.seed, scenario.duration_s));
    assert_ne!(family(vary).member(1, 5).unwrap().1, values);
}

#[test]
fn without_variation_a_run_is_the_scenario_with_its_seed() {
    let family = Family::new(None, None).unwrap();
    let (scenario, values) = family.member(1, 4).unwrap();
    assert_eq!(scenario, family.base.clone().with_seed(Some(1_000_007)));
    assert!(values.is_empty());
}

#[test]
fn a_key_or_value_that_no_scenario_takes_is_told_with_the_line_that_draws_it() {
    let unknown = refusal("[orbit]\n# no such key\nhight_km = { uniform = [1, 2] }");
    assert!(unknown.starts_with("sil-host: vary.toml:3: orbit.hight_km: unknown field"), "{unknown}");
    let table = refusal("[orbits]\na_km = { uniform = [1, 2] }");
    assert!(table.starts_with("sil-host: vary.toml:1: orbits: unknown field"), "{table}");
    let range = refusal("\norbit.e = { uniform = [2.0, 3.0] }");
    assert!(range.starts_with("sil-host: vary.toml:2: orbit.e: 2.") && range.contains("(run 4)"), "{range}");
    let kind = refusal("scenario.duration_s = { uniform = [20, 30] }");
    assert!(kind.starts_with("sil-host: vary.toml:1: scenario.duration_s: floating point"), "{kind}");
    assert!(kind.contains("in the place of a whole number (run 4)"), "{kind}");
    let word = refusal("scenario.exposure_ms = { gauss = [400.0, 1.0] }");
    assert!(
        word.starts_with("sil-host: vary.toml:1: scenario.exposure_ms: gauss is no distribution"),
        "{word}"
    );
    let element = refusal("mount.star_path_deg = [0.0, { normal = [9000.0, 1.0] }, 0.0]");
    assert!(element.starts_with("sil-host: vary.toml:1: mount.star_path_deg: "), "{element}");
}

#[test]
fn told_the_truth_a_family_draws_the_rest_alike() {
    let text = "[scenario]\nexposure_ms = { uniform = [380, 420] }\n[believed]\nclock_offset_s = { normal = [0.0, 1.0] }\n";
    let path = Path::new("vary.toml");
    let variation = || Variation::parse(path, text.into()).unwrap();
    let family = Family::of_text(Path::new("geo.toml"), EMBEDDED[0].1, Some(variation())).unwrap();
    let (scenario, drawn) = family.member(1, 3).unwrap();
    let (truth, drawn_of_it) = family.clone().told_the_truth().member(1, 3).unwrap();
    assert_eq!((truth.believed, truth.exposure_us), (Believed::TRUTH, scenario.exposure_us));
    assert_eq!((drawn.len(), drawn_of_it.len(), truth.seed), (2, 1, scenario.seed));
    assert_ne!(scenario.believed.clock_offset_s, Believed::default().clock_offset_s);
    // Nothing else is drawn: the scenario as it is.
    let only = Variation::parse(path, "believed.clock_drift_ppm = { uniform = [1, 2] }".into()).unwrap();
    let family = Family::of_text(Path::new("geo.toml"), EMBEDDED[0].1, Some(only)).unwrap().told_the_truth();
    assert_eq!(family.member(1, 3).unwrap().0, Scenario { seed: 1_000_006, ..family.base.clone() });
}
