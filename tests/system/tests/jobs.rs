//! Campaigns in tasks of Slurm and Kubernetes (`sil-host/jobs`): the shell that their files run, two tasks
//! each at small size, merged, and read by DuckDB. The Python of `tests/run` is needed; without it they are
//! skipped.

use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use system_tests::{json_lines, python, scratch, sil_host, workspace};

/// Flights of a task.
const RUNS: &str = "3";

fn jobs() -> PathBuf {
    workspace().join("sil-host/jobs")
}

/// A folder as a user has it: the job files, a minute of the default scenario, and `sextant` on the PATH.
fn desk(name: &str) -> (PathBuf, String) {
    let folder = scratch(name);
    for file in fs::read_dir(jobs()).expect("the job files") {
        let file = file.expect("an entry");
        fs::copy(file.path(), folder.join(file.file_name())).expect("copied");
    }
    let (_, scenario) = sil_host::scenario::EMBEDDED[0];
    let short = scenario.replace("duration_s = 21600", "duration_s = 60").replace("geo-eclipse", "short");
    fs::write(folder.join("short.toml"), short).expect("written");
    fs::write(folder.join("vary.toml"), "[optics]\naperture_mm = { uniform = [10.0, 12.0] }\n")
        .expect("written");
    let programs = sil_host().parent().expect("a folder").to_path_buf();
    let path = std::env::var("PATH").expect("a PATH");
    (folder, format!("{}:{path}", programs.display()))
}

/// Runs a command there and insists on success.
fn call(folder: &Path, path: &str, words: &[&str], variables: &[(&str, &str)]) -> String {
    let output = Command::new(words[0])
        .args(&words[1..])
        .current_dir(folder)
        .env("PATH", path)
        .envs(variables.iter().copied())
        .output()
        .expect("the command starts");
    let [out, err] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.success(), "{words:?}: {out}{err}");
    out
}

/// The lines of the tasks' files, one file behind the other, as `at-scale.md` has it.
fn merged(folder: &Path) -> String {
    ["00000", "00001"]
        .map(|task| {
            fs::read_to_string(folder.join(format!("out/flights-{task}.jsonl"))).expect("a task's file")
        })
        .concat()
}

#[test]
fn a_slurm_array_flies_a_campaign_and_duckdb_reads_it() {
    let (folder, path) = desk("slurm");
    let common = [("SCENARIO", "short.toml"), ("SEED", "7"), ("RUNS", RUNS), ("OUT", "out")];
    for task in ["0", "1"] {
        let variables = [&common[..], &[("SLURM_ARRAY_TASK_ID", task)]].concat();
        call(&folder, &path, &["sh", "slurm.sh"], &variables);
    }
    // A task that is started again flies nothing twice.
    let before = merged(&folder);
    assert_eq!(before.lines().count(), 6);
    call(&folder, &path, &["sh", "slurm.sh"], &[&common[..], &[("SLURM_ARRAY_TASK_ID", "1")]].concat());
    assert_eq!(merged(&folder), before);
    // Merged they are the campaign on one machine.
    fs::write(folder.join("flights.jsonl"), before).expect("written");
    let campaign = ["campaign", "run", "short.toml", "--seed", "7", "--runs", "6", "--json", "--out"];
    let rows = |more: &[&str]| {
        let output = Command::new(sil_host()).args(campaign).args(more).current_dir(&folder).output();
        let output = output.expect("the program starts");
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
        json_lines(&output)
    };
    let of_tasks = rows(&["flights.jsonl", "--held"]);
    assert_eq!(of_tasks, rows(&["at-once.jsonl"]));
    assert!(of_tasks.len() > 20, "{}", of_tasks.len());
    let Some(python) = python() else { return };
    let read = call(&folder, &path, &[&python, "quantiles.py", "out/flights-*.parquet"], &[]);
    let mut lines = read.lines();
    assert_eq!(lines.next(), Some("figure,flights,median,percent_5,percent_95"));
    let by_name: BTreeMap<&str, Vec<f64>> = lines
        .map(|line| line.split_once(',').expect("a row"))
        .map(|(name, numbers)| {
            (name, numbers.split(',').map(|number| number.parse().expect(number)).collect())
        })
        .collect();
    assert_eq!(by_name.len(), of_tasks.len());
    for row in &of_tasks {
        let name = row["figure"].as_str().expect("a name");
        let numbers = &by_name[name];
        assert_eq!(row["runs"].as_f64(), Some(numbers[0]), "{name}");
        assert_eq!(row["median"].as_f64(), Some(numbers[1]), "{name}");
        let kept = row["kept_by_95_percent"].as_f64().expect("a number");
        assert!(numbers[2..].contains(&kept), "{name}: {kept} of {numbers:?}");
        assert!(numbers[2] <= numbers[1] && numbers[1] <= numbers[3], "{name}");
    }
    println!("{} figures of 6 flights: DuckDB's are the campaign's", of_tasks.len());
}

#[test]
fn an_indexed_job_of_kubernetes_flies_its_share() {
    let Some(python) = python() else { return };
    let (folder, path) = desk("kubernetes");
    let read = "import json, sys, yaml; print(json.dumps(yaml.safe_load(open(sys.argv[1]))))";
    let job = call(&folder, &path, &[&python, "-c", read, "kubernetes.yaml"], &[]);
    let job: Value = serde_json::from_str(&job).expect("JSON");
    assert_eq!(job["kind"], "Job");
    assert_eq!((&job["apiVersion"], &job["spec"]["completionMode"]), (&"batch/v1".into(), &"Indexed".into()));
    let pod = &job["spec"]["template"]["spec"];
    assert_eq!(pod["restartPolicy"], "Never", "backoffLimitPerIndex asks for it");
    let container = &pod["containers"][0];
    let mounted: Vec<&Value> =
        container["volumeMounts"].as_array().expect("a list").iter().map(|of| &of["name"]).collect();
    let volumes: Vec<&Value> =
        pod["volumes"].as_array().expect("a list").iter().map(|of| &of["name"]).collect();
    assert_eq!(mounted, volumes);
    // The pod's command with its variables, here at small size.
    let mut variables: BTreeMap<&str, &str> = container["env"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|of| (of["name"].as_str().expect("a name"), of["value"].as_str().expect("words")))
        .collect();
    assert_eq!(variables.keys().copied().collect::<Vec<_>>(), ["OUT", "RUNS", "SCENARIO", "SEED"]);
    let small = [("OUT", "out"), ("RUNS", RUNS), ("SCENARIO", "short.toml"), ("VARY", "vary.toml")];
    variables.extend(small);
    let command: Vec<&str> = container["command"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|word| word.as_str().expect("words"))
        .collect();
    assert_eq!(command, ["sh", "/jobs/task.sh"]);
    for task in ["0", "1"] {
        let of_task: Vec<_> = variables.clone().into_iter().chain([("JOB_COMPLETION_INDEX", task)]).collect();
        call(&folder, &path, &["sh", "task.sh"], &of_task);
    }
    let runs: Vec<Value> =
        merged(&folder).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let mut numbers: Vec<u64> = runs.iter().map(|run| run["run"].as_u64().expect("a number")).collect();
    numbers.sort_unstable();
    assert_eq!(numbers, [0, 1, 2, 3, 4, 5]);
    assert!(runs.iter().all(|run| run["drawn"]["optics.aperture_mm"].is_f64()), "{}", runs[0]);
}

#[test]
fn a_task_without_an_index_or_with_bad_input_fails_and_says_so() {
    let (folder, path) = desk("no-index");
    let task = |variables: &[(&str, &str)]| {
        let mut command = Command::new("sh");
        command.arg("task.sh").current_dir(&folder).env("PATH", &path).env_remove("SLURM_ARRAY_TASK_ID");
        let output = command.envs(variables.iter().copied()).output().expect("sh");
        assert!(!output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(task(&[]).contains("there is no index"));
    let common = [("JOB_COMPLETION_INDEX", "0"), ("SEED", "1"), ("RUNS", "1"), ("OUT", "out")];
    assert!(task(&common).contains("SCENARIO"));
    assert!(task(&[&common[..], &[("SCENARIO", "no-such.toml")]].concat()).contains("no-such.toml"));
}

#[test]
fn the_shell_of_the_job_files_is_clean() {
    let files: Vec<PathBuf> = ["task.sh", "slurm.sh"].map(|file| jobs().join(file)).into();
    for shell in ["sh", "bash"] {
        for file in &files {
            assert!(Command::new(shell).arg("-n").arg(file).status().expect("a shell").success());
        }
    }
    match Command::new("shellcheck").args(&files).status() {
        Ok(status) => assert!(status.success(), "shellcheck"),
        Err(_) => println!("skipped: shellcheck is not installed"),
    }
}
