//! The command `attitude`: sets of vector pairs in, attitudes out, and the table of the methods.

use serde_json::{Value, json};
use sil_host::world::attitude::{apply, matrix};
use system_tests::{json_lines, run, scratch};

const METHODS: [&str; 8] = ["svd", "q", "quest", "foam", "esoq", "esoq2", "lsq", "anisotropic"];
/// `[x, y, z, w]`, 125 deg.
const TRUTH: [f64; 4] = [0.6, -0.48, 0.44, 0.464_758_001_544_890_15];

/// A set of exact pairs, five stars in a field of 20 deg.
fn exact() -> Value {
    let rows = matrix(TRUTH);
    // The inverse of the rotation: its transpose.
    let back = [0, 1, 2].map(|k| [rows[0][k], rows[1][k], rows[2][k]]);
    let stars = [[0.0, 0.0], [0.15, 0.05], [-0.1, 0.12], [-0.05, -0.14], [0.12, -0.1]];
    let b = stars.map(|[x, y]: [f64; 2]| [x, y, (1.0 - x * x - y * y).sqrt()]);
    json!({ "id": "exact", "b": b, "r": b.map(|b| apply(&back, b)), "sigma_rad": vec![1e-5; 5] })
}

fn write(name: &str, lines: &[String]) -> String {
    let file = scratch(name).join("sets.jsonl");
    std::fs::write(&file, lines.join("\n")).unwrap();
    file.to_str().unwrap().to_owned()
}

#[test]
fn every_method_answers_every_set_in_the_order_asked() {
    let file = write("attitude-good", &[exact().to_string(), exact().to_string()]);
    let output = run(&["attitude", &file, "--method", &METHODS.join(","), "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answers = json_lines(&output);
    assert_eq!(answers.len(), 16);
    for (answer, method) in answers.iter().zip(METHODS.iter().cycle()) {
        assert_eq!((&answer["id"], &answer["method"]), (&json!("exact"), &json!(method)));
        assert_eq!(answer["status"], "solved");
        for (found, truth) in answer["q"].as_array().unwrap().iter().zip(TRUTH) {
            assert!((found.as_f64().unwrap() - truth).abs() < 1e-6, "{answer}");
        }
        let sigma: Vec<f64> = serde_json::from_value(answer["sigma_arcsec"].clone()).unwrap();
        // Five stars of 2 arcsec.
        assert!(sigma[..2].iter().all(|sigma| (0.8..1.5).contains(sigma)) && sigma[2] < 10.0, "{answer}");
        assert!(answer["us"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn a_set_that_fixes_no_attitude_is_refused_with_the_reason() {
    let star = [0.0, 0.0, 1.0];
    let set = |b: Vec<[f64; 3]>, sigma_rad: f64| {
        json!({ "id": 1, "b": b, "r": b, "sigma_rad": vec![sigma_rad; b.len()] }).to_string()
    };
    let arc = vec![[0.6, 0.0, 0.8], star, [-0.6, 0.0, 0.8]];
    let lines = [set(vec![star], 1e-4), set(vec![star; 3], 1e-4), set(arc.clone(), 0.0), set(arc, 1e-4)];
    let output = run(&["attitude", &write("attitude-degenerate", &lines), "--method", "svd,lsq", "--json"]);
    assert!(output.status.success());
    let answers = json_lines(&output);
    let reasons: Vec<_> = answers.iter().map(|answer| answer["reason"].as_str().unwrap_or("")).collect();
    let expected = [
        "fewer than two",
        "fewer than two",
        "parallel",
        "parallel",
        "not positive",
        "not positive",
        "",
        "great circle",
    ];
    for (reason, expected) in reasons.iter().zip(expected) {
        assert!(reason.contains(expected), "{reasons:?}");
    }
    assert!(answers[..6].iter().all(|answer| answer["status"] == "refused" && answer["q"].is_null()));
}

#[test]
fn ellipses_reach_the_anisotropic_method() {
    let mut set = exact();
    set["sigma_rad"] = json!(vec![1e-4; 5]);
    set["covariance_rad2"] = json!(vec![[1.99e-8, 0.0, 1e-10]; 5]);
    let output = run(&[
        "attitude",
        &write("attitude-ellipses", &[set.to_string()]),
        "--method",
        "svd,anisotropic",
        "--json",
    ]);
    let sigma =
        |answer: &Value| -> Vec<f64> { serde_json::from_value(answer["sigma_arcsec"].clone()).unwrap() };
    let answers = json_lines(&output);
    let (svd, extended) = (sigma(&answers[0]), sigma(&answers[1]));
    // Turning about x moves stars along y, which is known ten times as well; roll profits too.
    assert!(
        extended[0] < 0.2 * svd[0] && extended[2] < 0.3 * svd[2] && extended[1] > svd[1],
        "{svd:?} {extended:?}"
    );
}

#[test]
fn a_line_that_is_no_set_costs_one_line_and_status_2_and_the_others_are_answered() {
    let good = exact();
    let with = |key: &str, value: Value| {
        let mut set = good.clone();
        set[key] = value;
        set.to_string()
    };
    let bad = [
        ("{\"id\":1,".to_string(), "EOF"),
        (json!({ "id": 1, "b": [], "r": [] }).to_string(), "sigma_rad"),
        (with("sigma_rad", json!([1e-4])), "b has 5 entries and sigma_rad has 1"),
        (with("covariance_rad2", json!([])), "covariance_rad2 has 0"),
        (with("covariance_rad2", json!([[1], [1], [1], [1], [1]])), "covariance_rad2[0] has 1 numbers"),
        (with("b", json!([[0, 0, 1], [0, 1, 0], [1, 0], [0, 0, 1], [0, 0, 1]])), "b[2] has 2 numbers"),
        (with("r", json!([[0, 0, 1], [0, 2, 0], [1, 0, 0], [0, 0, 1], [0, 0, 1]])), "r[1] is no unit vector"),
        (
            with("r", json!([[0, 0, 1e300], [0, 1, 0], [1, 0, 0], [0, 0, 1], [0, 0, 1]])),
            "r[0] is no unit vector",
        ),
        ("{\"id\":1,\"b\":[[NaN,0,1]],\"r\":[[0,0,1]],\"sigma_rad\":[1]}".to_string(), "expected value"),
    ];
    for (line, words) in bad {
        let file = write("attitude-bad", &[good.to_string(), line, good.to_string()]);
        let output = run(&["attitude", &file, "--json"]);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{text}");
        assert!(
            text.starts_with("sil-host: ") && text.contains("sets.jsonl:2:") && text.contains(words),
            "{text}"
        );
        assert_eq!(json_lines(&output).len(), 2);
    }
    for (arguments, words) in [
        (&["attitude"][..], "SETS.jsonl"),
        (&["attitude", "no-such.jsonl"], "no-such.jsonl"),
        (&["attitude", "x.jsonl", "--method", "triad"], "anisotropic"),
        (&["attitude", "x.jsonl", "--table"], "--table"),
    ] {
        let output = run(arguments);
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), text.trim_end().lines().count()), (Some(2), 1), "{text}");
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn the_table_is_the_same_every_time_and_the_optimal_methods_reach_the_bound() {
    let (one, other) = (run(&["attitude", "--table", "--json"]), run(&["attitude", "--table", "--json"]));
    assert!(one.status.success() && one.stdout == other.stdout);
    let rows = json_lines(&one);
    for (row, method) in rows.iter().zip(METHODS) {
        assert_eq!((&row["method"], &row["sets"]), (&json!(method), &json!(32_880)));
        if method != "lsq" {
            assert_eq!(row["refused"], 0);
            for ratio in row["rms_over_bound"].as_array().unwrap() {
                assert!((ratio.as_f64().unwrap() - 1.0).abs() < 0.01, "{row}");
            }
            assert!((row["within_3_sigma"].as_f64().unwrap() - 0.9973).abs() < 0.001, "{row}");
        }
    }
    let text = run(&["attitude", "--table"]);
    assert_eq!(String::from_utf8_lossy(&text.stdout).lines().count(), 3 + rows.len());
}

#[test]
fn directions_that_contradict_each_other_are_refused_by_every_method() {
    let mut mirrored = exact();
    for b in mirrored["b"].as_array_mut().unwrap() {
        b[0] = json!(-b[0].as_f64().unwrap());
    }
    let axes = json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
    let turned = json!([[-1, 0, 0], [0, -1, 0], [0, 0, -1]]);
    let inverted = json!({ "id": 2, "b": axes, "r": turned, "sigma_rad": [1e-5, 1e-5, 1e-5] });
    // A star twenty sigmas off; and exact ones whose sigma is below what single precision holds.
    let (mut off, mut fine) = (exact(), exact());
    off["sigma_rad"] = json!(vec![1e-4; 5]);
    off["b"][1] = json!([0.152, 0.05, (1.0f64 - 0.152 * 0.152 - 0.05 * 0.05).sqrt()]);
    fine["sigma_rad"] = json!(vec![2e-9; 5]);
    let lines = [mirrored, inverted, off, fine].map(|set| set.to_string());
    let file = write("attitude-contradictory", &lines);
    let output = run(&["attitude", &file, "--method", &METHODS.join(","), "--json"]);
    assert!(output.status.success());
    let answers = json_lines(&output);
    let (refused, solved) = answers.split_at(3 * METHODS.len());
    for answer in refused {
        assert_eq!(answer["status"], "refused", "{answer}");
        assert_eq!(answer["reason"], "directions contradict each other", "{answer}");
        assert!(answer["q"].is_null() && answer["sigma_arcsec"].is_null());
    }
    assert!(solved.iter().all(|answer| answer["status"] == "solved"), "{solved:?}");
}
