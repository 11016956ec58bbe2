use super::*;

const BASE: &str = "\
[scenario]
name = \"a\"
[orbit]
a_km = 7000.0
[mount]
star_path_deg = [0.0, 90.0, 0.0]
[[faults]]
kind = \"time-out\"
share = 1.0
";

const FILE: &str = "\
[orbit]
a_km = { uniform = [7000, 7100] }
e = { log_uniform = [1e-4, 1e-2] }
[mount]
star_path_deg = [0.5, { normal = [90.0, 2.0] }, 0.0]
[gyro]
range_deg_s = { choice = [10.0, 20.0] }
[[faults]]
from_s = { whole = [10, 12] }
";

fn variation(text: &str) -> Result<Variation, HostError> {
    Variation::parse(Path::new("vary.toml"), text.to_owned())
}

fn drawn(text: &str, run: u64) -> (Value, Drawn) {
    variation(text).unwrap().draw(&toml::from_str(BASE).unwrap(), 3, run)
}

fn number_of(tree: &Value, path: &[&str]) -> f64 {
    let step = |tree: Value, step: &&str| match &tree {
        Value::Array(values) => values[step.parse::<usize>().unwrap()].clone(),
        table => table[*step].clone(),
    };
    number(&path.iter().fold(tree.clone(), step)).unwrap()
}

#[test]
fn every_distribution_has_its_moments() {
    let of =
        |path: &[&str]| -> Vec<f64> { (0..2000).map(|run| number_of(&drawn(FILE, run).0, path)).collect() };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let deviation = |values: &[f64]| {
        let middle = mean(values);
        mean(&values.iter().map(|value| (value - middle).powi(2)).collect::<Vec<_>>()).sqrt()
    };
    let a = of(&["orbit", "a_km"]);
    assert!((mean(&a) - 7050.0).abs() < 3.0 && (deviation(&a) - 28.87).abs() < 1.5);
    let e = of(&["orbit", "e"]);
    assert!(e.iter().all(|e| (1e-4..=1e-2).contains(e)));
    let logarithms: Vec<f64> = e.iter().map(|e| e.log10()).collect();
    assert!((mean(&logarithms) + 3.0).abs() < 0.05 && (deviation(&logarithms) - 0.577).abs() < 0.03);
    let mount = of(&["mount", "star_path_deg", "1"]);
    assert!((mean(&mount) - 90.0).abs() < 0.2 && (deviation(&mount) - 2.0).abs() < 0.15);
    for (path, values) in [
        (["gyro", "range_deg_s"].as_slice(), [10.0, 20.0].as_slice()),
        (&["faults", "0", "from_s"], &[10.0, 11.0, 12.0]),
    ] {
        let drawn = of(path);
        for value in values {
            let share = drawn.iter().filter(|drawn| *drawn == value).count() as f64 / drawn.len() as f64;
            assert!((share * values.len() as f64 - 1.0).abs() < 0.1, "{value}: {share}");
        }
    }
}

#[test]
fn what_is_not_named_stays_and_plain_values_replace() {
    let (tree, values) = drawn(FILE, 0);
    assert_eq!(tree["scenario"]["name"].as_str(), Some("a"));
    assert_eq!(number_of(&tree, &["faults", "0", "share"]), 1.0);
    assert_eq!(number_of(&tree, &["mount", "star_path_deg", "0"]), 0.5);
    let names: Vec<&str> = values.iter().map(|(name, _)| name.as_str()).collect();
    assert!(names.contains(&"mount.star_path_deg.1") && names.contains(&"faults.0.from_s"), "{names:?}");
}

#[test]
fn a_draw_depends_on_seed_run_and_key_alone() {
    let alone = "orbit.a_km = { uniform = [7000, 7100] }";
    assert_eq!(
        number_of(&drawn(FILE, 7).0, &["orbit", "a_km"]),
        number_of(&drawn(alone, 7).0, &["orbit", "a_km"])
    );
    assert_ne!(
        number_of(&drawn(alone, 7).0, &["orbit", "a_km"]),
        number_of(&drawn(alone, 8).0, &["orbit", "a_km"])
    );
}

#[test]
fn faults_of_the_file_name_line_and_key() {
    let message = |text: &str| variation(text).unwrap_err().to_string();
    for (text, beginning) in [
        ("[orbit]\ne = { uniform = [2, 1] }", "sil-host: vary.toml:2: orbit.e: uniform takes two numbers"),
        (
            "[orbit]\n\ne = { log_uniform = [0, 1] }",
            "sil-host: vary.toml:3: orbit.e: log_uniform takes two numbers above 0",
        ),
        ("orbit.e = { normal = [0.0, -1.0] }", "sil-host: vary.toml:1: orbit.e: normal takes"),
        ("orbit.e = { normal = [0.0, nan] }", "sil-host: vary.toml:1: orbit.e: normal takes"),
        ("[[faults]]\nfrom_s = { whole = [1.5, 3] }", "sil-host: vary.toml:2: faults.0.from_s: whole takes"),
        ("orbit.e = { choice = [] }", "sil-host: vary.toml:1: orbit.e: choice takes"),
        ("scenario.seed = 3", "sil-host: vary.toml:1: scenario.seed: every run has its own"),
        ("orbit.e = = 3", "sil-host: vary.toml:1: "),
        ("", "sil-host: vary.toml: varies nothing"),
    ] {
        let message = message(text);
        assert!(message.starts_with(beginning) && !message.contains('\n'), "{text}: {message}");
    }
}
