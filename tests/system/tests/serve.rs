//! The page of `serve`: by its requests, and as people use it in a browser.

mod browser;

use browser::Browser;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use system_tests::{refused, run, scratch, sil_host, workspace};

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(120);

/// The program with its page, until it is dropped.
struct Served {
    program: Child,
    address: String,
}

impl Served {
    fn start(arguments: &[&str]) -> Self {
        let mut command = Command::new(sil_host());
        let program =
            command.arg("serve").args(arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut program = program.expect("the program starts");
        let mut line = String::new();
        let output = program.stdout.as_mut().expect("its output is piped");
        BufReader::new(output).read_line(&mut line).expect("it says where it is");
        let address = line.trim().strip_prefix("http://").expect("an address").trim_end_matches('/');
        assert!(address.starts_with("127.0.0.1:"), "{address}");
        Self { program, address: address.to_owned() }
    }

    fn send(&self, line: &str, body: &str) -> (u16, Vec<u8>) {
        let Self { address, .. } = self;
        let mut stream = TcpStream::connect(address).expect("it listens");
        write!(
            stream,
            "{line} HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\nConnection: close\r\n\
             Content-Length: {}\r\n\r\n{body}",
            body.len()
        )
        .expect("it reads");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("it answers");
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let status = String::from_utf8_lossy(&answer[9..12]).parse().expect("a status");
        (status, answer[end + 4..].to_vec())
    }

    fn get(&self, url: &str) -> Value {
        let (status, body) = self.send(&format!("GET {url}"), "");
        assert_eq!(status, 200, "{url}: {}", String::from_utf8_lossy(&body));
        serde_json::from_slice(&body).expect("JSON")
    }

    fn order(&self, order: &Value) {
        let (status, body) = self.send("POST /api/order", &order.to_string());
        assert_eq!(status, 200, "{order}: {}", String::from_utf8_lossy(&body));
    }

    /// The state, once it is as `wanted`.
    fn state(&self, wanted: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            let state = self.get("/api/state");
            if wanted(&state) {
                return state;
            }
            assert!(began.elapsed() < PATIENCE, "{}", state["run"]);
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// The columns' places in a row.
    fn columns(&self) -> HashMap<String, usize> {
        let page = self.get("/api/page");
        let names = page["columns"].as_array().expect("columns").iter();
        names.enumerate().map(|(place, name)| (name.as_str().expect("a name").to_owned(), place)).collect()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// A flight of three minutes in which the orbit is known from the start, in a file; and its record.
fn short_flight(name: &str) -> (PathBuf, PathBuf) {
    let folder = scratch(name);
    let text =
        fs::read_to_string(workspace().join("sil-host/src/scenarios/geo-eclipse.toml")).expect("a scenario");
    let text = text.replace("duration_s = 21600", "duration_s = 180").replace("\"geo-eclipse\"", "\"short\"");
    let file = folder.join("short.toml");
    let start = "\n[orbit_filter.start]\nposition_sigma_km = 20.0\nvelocity_sigma_m_s = 1.0\n\
                 position_error_km = [3.0, -5.0, 4.0]\nvelocity_error_m_s = [0.2, 0.1, -0.3]\n";
    fs::write(&file, format!("{text}{start}")).expect("written");
    let record = folder.join("out");
    let done = run(&["run", text_of(&file), "--seed", "5", "--out", text_of(&record)]);
    assert!(matches!(done.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&done.stderr));
    (file, record)
}

fn text_of(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// The record's values by column, row by row.
fn csv(record: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let text = fs::read_to_string(record.join("cycles.csv")).expect("cycles.csv");
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    (lines.next().expect("a header"), lines.collect())
}

#[test]
fn a_flight_on_the_page_is_that_of_run_and_its_record_is_scrubbed() {
    let (file, record) = short_flight("serve");
    let served = Served::start(&[text_of(&file), "--seed", "5"]);
    served.state(|state| state["run"]["seed"] == 5);
    served.order(&json!({"do": "step", "seconds": 120}));
    let state = served.state(|state| state["flown"] == 120);
    let columns = served.columns();
    let (names, lines) = csv(&record);
    let mut compared = 0;
    for (row, line) in state["rows"].as_array().expect("rows").iter().zip(&lines) {
        for (name, field) in names.iter().zip(line) {
            let Some(place) = columns.get(name) else { continue };
            let value = match &row[*place] {
                Value::Null => String::new(),
                Value::String(words) => words.clone(),
                number => number.to_string(),
            };
            let same = value == *field
                || value.parse::<f64>().ok().zip(field.parse().ok()).is_some_and(|(a, b): (f64, f64)| a == b);
            assert!(same, "second {}: {name} is {value}, {field} in the record", line[0]);
            compared += usize::from(!field.is_empty() && name.contains("error"));
        }
    }
    assert!(compared > 120 * 6, "{compared} errors of attitude and position");

    // Paused it holds, started it goes on, ended it says what it came to.
    std::thread::sleep(Duration::from_millis(400));
    assert_eq!(served.get("/api/state")["flown"], 120);
    served.order(&json!({"do": "speed", "times": 20.0}));
    let began = Instant::now();
    served.order(&json!({"do": "start"}));
    served.state(|state| state["flown"].as_u64() >= Some(130));
    assert!(began.elapsed() > Duration::from_millis(420), "20 times real time: {:?}", began.elapsed());

    // A fault of a button acts, is told, and is seen in the frame.
    served.order(&json!({"do": "pause"}));
    let flown = served.state(|state| state["running"] == false)["flown"].as_u64().expect("a number");
    served.order(&json!({"do": "fault", "kind": "blinded"}));
    served.order(&json!({"do": "step", "seconds": 2}));
    let state = served.state(|state| state["flown"] == flown + 2);
    let row = &state["rows"][flown as usize];
    assert_eq!((&row[columns["faults"]], &row[columns["status"]]), (&json!("blinded"), &json!("blinded")));
    assert_eq!(state["faults"][0]["kind"], "blinded");
    let frame = |run: u64, cycle: u64| served.send(&format!("GET /api/frame?run={run}&cycle={cycle}"), "");
    let white = |frame: &(u16, Vec<u8>)| {
        let picture = image::load_from_memory(&frame.1).expect("a picture").into_luma8();
        picture.pixels().filter(|pixel| pixel.0[0] == u8::MAX).count() as f64 / f64::from(640 * 512)
    };
    let (good, blinded) = (frame(1, flown - 1), frame(1, flown));
    assert!(white(&good) < 0.1 && white(&blinded) == 1.0, "{} {}", white(&good), white(&blinded));

    // The record: every second at hand, stars from its telemetry, the frame drawn again.
    served.order(&json!({"do": "open", "folder": record}));
    let state = served.get("/api/state");
    assert_eq!((&state["flown"], &state["run"]["scenario"]), (&json!(180), &json!("short")));
    let run = state["run"]["run"].as_u64().expect("a number");
    for cycle in [179, 3, 90] {
        let second = served.get(&format!("/api/second?run={run}&cycle={cycle}"));
        assert!(second["stars"].as_array().expect("stars").len() > 5, "{cycle}");
        assert_eq!(second["no_frame"], Value::Null);
    }
    assert_eq!(frame(run, flown - 1), good, "the frame of a second is the same, flown or recorded");
}

#[test]
fn what_cannot_be_served_is_one_line_and_a_signal_ends_it() {
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("its address").port().to_string();
    refused(&["serve", "--port", &port], &["--port", &port, "cannot be had"]);
    refused(&["serve", "--port", "70000"], &["--port"]);
    refused(&["serve", "no-such.toml"], &["no-such.toml"]);
    refused(&["serve", "--open", "no-such-folder"], &["no-such-folder", "summary.json"]);
    let mut served = Served::start(&[]);
    // As Ctrl-C does, which programs in the background are often told to ignore.
    let signal = Command::new("kill").arg(served.program.id().to_string()).status();
    assert!(signal.expect("kill").success());
    let began = Instant::now();
    while served.program.try_wait().expect("a status").is_none() {
        assert!(began.elapsed() < Duration::from_secs(5), "it does not end");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn the_page_is_used_by_mouse_and_keyboard_in_a_browser() {
    let (file, record) = short_flight("serve-browser");
    let served = Served::start(&[text_of(&file), "--seed", "5"]);
    let Some(mut browser) = Browser::start([1280, 800], &scratch("serve-profile")) else { return };
    served.state(|state| state["run"]["seed"] == 5);
    browser.open(&format!("http://{}/", served.address));
    browser.wait("document.querySelector('#scenario').textContent === 'short'");
    browser.screenshot(&record.with_file_name("ready.png"));

    // Nothing is wider than the window, and every control has a name.
    assert_eq!(browser.value("document.documentElement.scrollWidth <= 1280"), json!(true));
    assert_eq!(browser.value("document.documentElement.scrollHeight <= 800"), json!(true));
    let unnamed = "[...document.querySelectorAll('button, input, select, svg[role=img], #events')].filter((of) => \
                   !(of.textContent.trim() || of.ariaLabel || of.labels?.length)).map((of) => of.outerHTML)";
    assert_eq!(browser.value(unnamed), json!([]));

    // A click starts it, the space bar pauses it, the right arrow steps.
    browser.click("#start");
    browser.wait("Number(document.querySelector('#cursor').value) > 20");
    browser.wait("document.querySelector('#start').textContent === 'Pause'");
    browser.key(" ", 32);
    browser.wait("document.querySelector('#start').textContent === 'Start'");
    let flown = served.state(|state| state["running"] == false)["flown"].as_u64().expect("a number");
    browser.key("ArrowRight", 39);
    served.state(|state| state["flown"] == flown + 1);
    browser.wait(&format!("Number(document.querySelector('#cursor').value) === {flown}"));
    browser.wait("document.querySelectorAll('#overlay .star').length > 5");
    browser.wait(
        "!document.querySelector('#frame').hidden && document.querySelector('#frame').naturalWidth === 640",
    );
    for drawn in
        ["#attitude .band", "#position .band", "#globe .lit", "#sky .used", "#overlay .window", "#figures td"]
    {
        browser.wait(&format!("document.querySelector({drawn:?}) !== null"));
    }
    assert!(browser.text("#sentence").starts_with("Attitude off by"), "{}", browser.text("#sentence"));
    browser.screenshot(&record.with_file_name("flying.png"));

    // A fault by button is told and listed.
    browser.click("#faults button[data-kind=blinded]");
    browser.click("#step");
    browser.wait("document.querySelector('#events .fault')?.textContent === 'broken: blinded'");
    browser.wait("document.querySelector('#faults .acts')?.dataset.kind === 'blinded'");
    let text = |of: &str| format!("document.querySelector('{of}').textContent");
    browser.wait(&format!("{}.startsWith({})", text("#frame-words"), text("#since")));
    browser.screenshot(&record.with_file_name("blinded.png"));

    // The record is opened by its folder and scrubbed by keys.
    browser.value(&format!("document.querySelector('#folder').value = {:?}", text_of(&record)));
    browser.click("#open button");
    browser.wait("document.querySelector('#source').textContent.startsWith('recorded')");
    browser.wait("document.querySelector('#cursor').max === '179'");
    browser.key("End", 35);
    browser.wait("document.querySelector('#since').textContent === 'T+0:02:59'");
    browser.wait("document.querySelector('#frame-words').textContent.startsWith('T+0:02:59')");
    browser.key("ArrowLeft", 37);
    browser.wait("document.querySelector('#since').textContent === 'T+0:02:58'");
    browser.screenshot(&record.with_file_name("recorded.png"));
    let asked = browser.asked();
    let here = format!("http://{}/", served.address);
    let elsewhere: Vec<&String> = asked
        .iter()
        .filter(|url| !url.starts_with(&here) && !url.contains(&here) && *url != "data:,")
        .collect();
    assert!(asked.len() > 10 && elsewhere.is_empty(), "asked elsewhere: {elsewhere:?}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
