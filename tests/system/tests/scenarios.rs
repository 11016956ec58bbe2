//! `sil-host run` and `render` as people meet them: files, statuses, equal runs.

use serde_json::Value;
use sil_host::harness;
use sil_host::scenario::{EMBEDDED, Scenario};
use sil_host::world::orbit::oem;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use system_tests::{amount, cargo, json_lines, run, scratch, sil_host};

const FILES: [&str; 8] = [
    "cycles.csv",
    "estimate.aem",
    "estimate.oem",
    "report.html",
    "summary.json",
    "telemetry.bin",
    "truth.aem",
    "truth.oem",
];

/// The default scenario with another duration and other limits, written into `folder`.
fn scenario(folder: &Path, seconds: u32, limits: &str) -> String {
    let (_, text) = EMBEDDED[0];
    let text = text.replace("duration_s = 21600", &format!("duration_s = {seconds}"));
    let head = text.split("[limits]").next().expect("a text");
    let path = folder.join("short.toml");
    std::fs::write(&path, format!("{head}[limits]\n{limits}\n")).expect("the target folder can be written");
    path.to_str().expect("a path in UTF-8").to_owned()
}

fn read(folder: &Path, file: &str) -> Vec<u8> {
    std::fs::read(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

#[test]
fn two_runs_with_the_same_seed_write_identical_files_and_another_seed_does_not() {
    let folder = scratch("equal-runs");
    let file = scenario(&folder, 40, "mode_share = 0.0");
    let fly = |name: &str, seed: &str| {
        let out = folder.join(name);
        let output = run(&["run", &file, "--out", out.to_str().unwrap(), "--seed", seed, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        (out, json_lines(&output))
    };
    let ((first, summary), (second, _), (other, _)) = (fly("a", "3"), fly("b", "3"), fly("c", "4"));
    for name in FILES {
        assert!(read(&first, name) == read(&second, name), "{name} differs");
    }
    assert!(read(&first, "telemetry.bin") != read(&other, "telemetry.bin"));
    assert_eq!(summary.len(), 1);
    let written: Value = serde_json::from_slice(&read(&first, "summary.json")).unwrap();
    assert_eq!(summary[0], written);
    assert_eq!(
        (&written["seed"], &written["seconds"], &written["kept"]),
        (&3.into(), &40.into(), &true.into())
    );
}

/// Flights tried of every scenario; the gate tries the first of them.
const SEEDS: u64 = 4;
const GATE_SEEDS: u64 = 2;

#[test]
fn the_first_attitude_comes_within_seconds_whatever_the_seed() {
    let (mut flights, mut late) = (0, 0);
    for (name, text) in EMBEDDED {
        let duration = text.lines().find(|line| line.starts_with("duration_s")).expect("every file has one");
        // Faults and slews come later; they would lie beyond the end.
        let text = text.split("[[").next().expect("a text").replace(duration, "duration_s = 12");
        let scenario = Scenario::parse(Path::new(name), &text).unwrap();
        // A tumbling sensor promises none.
        if name == "tumbling" {
            continue;
        }
        for seed in 1..=amount(GATE_SEEDS, SEEDS) {
            let scenario = scenario.clone().with_seed(Some(seed));
            let mut scene = scenario.scene().unwrap();
            let mut first = None;
            harness::fly(&scenario, &mut scene, |second| {
                if let Some(attitude) = &second.judged.attitude_rad {
                    first.get_or_insert(second.cycle + 1);
                    assert!(attitude.worst_sigma() < 5.0, "{name}, seed {seed}: {attitude:?}");
                }
                Ok(())
            })
            .unwrap();
            flights += 1;
            if first.is_none_or(|first| first > 5) {
                println!("{name}, seed {seed}: {first:?}");
                late += 1;
            }
        }
    }
    println!("{late} of {flights} flights had to wait for more than 5 s");
    // Where bright clouds fill the field few stars are left; it is rare.
    assert!(10 * late <= flights, "{late} of {flights}");
}

#[test]
fn a_row_a_second_with_every_column_and_a_frame_a_second() {
    let folder = scratch("rows");
    let file = scenario(&folder, 30, "");
    let out = folder.join("out");
    let output = run(&["run", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("report.html") && text.contains("No limits were set"), "{text}");
    let cycles = String::from_utf8(read(&out, "cycles.csv")).unwrap();
    let mut lines = cycles.lines();
    let columns = lines.next().unwrap().split(',').count();
    let rows: Vec<&str> = lines.collect();
    assert_eq!(rows.len(), 30);
    for (cycle, row) in rows.iter().enumerate() {
        assert_eq!(row.split(',').count(), columns, "{row}");
        assert!(row.starts_with(&format!("{cycle},")));
    }
    let stream = read(&out, "telemetry.bin");
    let (mut rest, mut frames) = (&stream[..], 0);
    while let Some((frame, after)) = fsw_core::telemetry::split_first(rest) {
        assert_eq!(fsw_core::telemetry::decode(frame).unwrap().cycle, frames);
        (rest, frames) = (after, frames + 1);
    }
    assert_eq!((frames, rest.len()), (30, 0));
    let orbit = oem::read(&String::from_utf8(read(&out, "truth.oem")).unwrap()).unwrap();
    assert_eq!((orbit.len(), orbit[0].places.len()), (1, 30));
    let attitude = String::from_utf8(read(&out, "estimate.aem")).unwrap();
    let (_, data) = attitude.split_once("DATA_START\n").unwrap();
    assert!(data.lines().filter(|line| line.split(' ').count() == 5).count() > 20, "{attitude}");
}

#[test]
fn a_limit_that_is_missed_gives_status_1_and_says_so() {
    let folder = scratch("missed");
    let file = scenario(&folder, 12, "attitude_rms_arcsec = 0.0");
    let out = folder.join("out");
    let output = run(&["run", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("MISSED"));
    let page = String::from_utf8(read(&out, "report.html")).unwrap();
    assert!(page.contains("1 limit missed"));
}

/// Starts a run that would last for days and waits for its first rows.
fn started(file: &str, out: &Path) -> Child {
    let child = Command::new(sil_host())
        .args(["run", file, "--out", out.to_str().unwrap()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let began = Instant::now();
    let rows =
        || std::fs::read_to_string(out.join("cycles.csv.partial")).map_or(0, |text| text.lines().count());
    while rows() < 20 && began.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(50));
    }
    child
}

fn ended(mut child: Child) {
    child.kill().expect("it runs still");
    child.wait().expect("it ends");
}

#[test]
fn a_killed_run_leaves_partial_files_of_whole_rows_and_nothing_of_an_older_one() {
    let folder = scratch("killed");
    let out = folder.join("out");
    std::fs::create_dir_all(&out).unwrap();
    FILES.iter().for_each(|name| std::fs::write(out.join(name), "of an older run").unwrap());
    let file = scenario(&folder, 800_000, "");
    ended(started(&file, &out));
    assert!(FILES.iter().all(|name| !out.join(name).exists()));
    let text = std::fs::read_to_string(out.join("cycles.csv.partial")).unwrap();
    let whole = &text[..text.rfind('\n').expect("a full line")];
    let columns = whole.lines().next().unwrap().split(',').count();
    assert!(whole.lines().count() >= 20);
    assert!(whole.lines().all(|row| row.split(',').count() == columns));
    let stream = read(&out, "telemetry.bin.partial");
    let (mut rest, mut frames) = (&stream[..], 0);
    while let Some((frame, after)) = fsw_core::telemetry::split_first(rest) {
        assert_eq!(fsw_core::telemetry::decode(frame).unwrap().cycle, frames);
        (rest, frames) = (after, frames + 1);
    }
    assert!(frames >= 19);
    // The folder is free again, and the next run leaves nothing partial in it.
    let file = scenario(&folder, 12, "");
    assert_eq!(run(&["run", &file, "--out", out.to_str().unwrap()]).status.code(), Some(0));
    let mut names: Vec<_> = std::fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, FILES);
}

#[test]
fn two_runs_at_a_time_do_not_share_a_folder() {
    let folder = scratch("shared");
    let out = folder.join("out");
    let file = scenario(&folder, 800_000, "");
    let first = started(&file, &out);
    let second = run(&["run", &file, "--out", out.to_str().unwrap()]);
    ended(first);
    let message = String::from_utf8_lossy(&second.stderr);
    assert_eq!(second.status.code(), Some(2));
    assert!(
        message.contains("another run is writing into this folder") && message.lines().count() == 1,
        "{message}"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_standard_output_that_is_lost_is_status_2() {
    let folder = scratch("lost-output");
    let (file, out) = (scenario(&folder, 12, ""), folder.join("out"));
    let folder_of = ["run", &file, "--out", out.to_str().unwrap()];
    for arguments in [&folder_of[..], &[&folder_of[..], &["--json"]].concat(), &["parameters"], &["columns"]]
    {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output =
            Command::new(sil_host()).args(arguments).stdout(full).output().expect("the program starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2));
        assert!(message.contains("standard output cannot be written"), "{message}");
    }
}

#[test]
fn a_rendered_frame_is_the_same_in_both_kinds_of_file() {
    use fsw_hal::Detector;
    use sil_host::formats::picture::Picture;
    let folder = scratch("render");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (png, fits) = (file("frame.png"), file("frame.fits"));
    for out in [&png, &fits] {
        let output = run(&["render", "geo-eclipse", "--cycle", "100", "--out", out]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let [png, fits] = [png, fits].map(|name| Picture::load(Path::new(&name)).unwrap());
    assert_eq!(png.pixels(), fits.pixels());
    assert_eq!((png.geometry().width_px, png.geometry().height_px), (1280, 1024));
    assert!(png.pixels().iter().max() > Some(&100) && png.pixels().iter().all(|value| *value <= 1023));
}

#[test]
fn flights_in_two_threads_at_once_are_those_flown_alone() {
    let telemetry = |seed: u64| {
        let text = EMBEDDED[0].1.replace("duration_s = 21600", "duration_s = 30");
        let scenario = Scenario::parse(Path::new("short.toml"), &text).unwrap().with_seed(Some(seed));
        let mut scene = scenario.scene().unwrap();
        let (mut bytes, mut buffer) = (Vec::new(), vec![0; fsw_core::telemetry::MAX_FRAME_BYTES + 2]);
        harness::fly(&scenario, &mut scene, |second| {
            bytes.extend_from_slice(fsw_core::telemetry::encode_next(second.report, &mut buffer).unwrap());
            Ok(())
        })
        .unwrap();
        bytes
    };
    let alone = [telemetry(3), telemetry(4)];
    let together = std::thread::scope(|scope| {
        let threads = [3, 4].map(|seed| scope.spawn(move || telemetry(seed)));
        threads.map(|thread| thread.join().expect("the flight ends"))
    });
    assert!(alone == together && alone[0] != alone[1]);
}

/// Peak of a run's memory, MiB; `None` where the system does not give it.
fn peak_mib(folder: &Path, seconds: u32) -> Option<f64> {
    let file = scenario(folder, seconds, "");
    let out = folder.join(format!("out-{seconds}"));
    let mut child = Command::new(sil_host())
        .args(["run", &file, "--out", out.to_str().unwrap(), "--json"])
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts");
    let status = format!("/proc/{}/status", child.id());
    let mut peak_kib = None;
    while child.try_wait().expect("its end can be asked for").is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let high = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = high.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
        peak_kib = kib.or(peak_kib);
        std::thread::sleep(Duration::from_millis(5));
    }
    peak_kib.map(|kib| kib / 1024.0)
}

#[test]
fn memory_does_not_grow_with_the_run() {
    let folder = scratch("memory");
    let (Some(short), Some(long)) = (peak_mib(&folder, 300), peak_mib(&folder, 2_700)) else {
        println!("skipped: this system does not give a program's peak memory");
        return;
    };
    println!("peak memory: {short:.1} MiB for 5 min, {long:.1} MiB for 45 min");
    // An orbit's nodes are all that may grow: less than 200 bytes a simulated minute.
    assert!(long < 300.0 && long < short + 8.0, "{short} {long}");
}

#[test]
fn an_effect_a_figure_and_a_command_of_ones_own_are_a_few_lines() {
    cargo(&["run", "--release", "--locked", "-p", "extended", "--", "ghost"]);
}

#[test]
fn a_campaign_of_a_scenario_keeps_its_files_in_a_folder_and_goes_on() {
    let folder = scratch("campaign-folder");
    let file = scenario(&folder, 12, "mode_share = 0.0");
    let fly = |name: &str, more: &[&str]| {
        let out = folder.join(name);
        let arguments = ["campaign", &file, "--jobs", "2", "--seed", "5", "--out", out.to_str().unwrap()];
        let output = run(&[&arguments[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        (out, String::from_utf8(output.stdout).unwrap())
    };
    let (out, said) = fly("whole", &["--runs", "3"]);
    let flights = read(&out, "flights.jsonl");
    assert_eq!(read(&out, "figures.txt"), said.as_bytes());
    assert_eq!(String::from_utf8(read(&out, "flights.csv")).unwrap().lines().count(), 4);
    assert_eq!(flights.iter().filter(|byte| **byte == b'\n').count(), 3);
    // What it holds is not flown again.
    assert_eq!(fly("whole", &["--runs", "3"]).1, said);
    assert_eq!(read(&out, "flights.jsonl"), flights);
    // Two machines, one behind the other.
    let (one, _) = fly("one", &["--runs", "1"]);
    let (other, _) = fly("other", &["--first", "1", "--runs", "2"]);
    let merged = [read(&one, "flights.jsonl"), read(&other, "flights.jsonl")].concat();
    std::fs::write(one.join("flights.jsonl"), &merged).unwrap();
    let (merged_folder, merged_said) = fly("one", &["--runs", "3"]);
    assert_eq!((merged_said, read(&merged_folder, "flights.jsonl")), (said, merged));
    assert_eq!(read(&merged_folder, "flights.csv"), read(&out, "flights.csv"));
}
