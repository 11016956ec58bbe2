use super::*;
use crate::commands::run::fly_into;
use crate::serve::world::World;
use fsw_core::orbit::body::CentralBody;
use fsw_core::telemetry::Report;
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Longest wait for a flight in tests.
const PATIENCE: Duration = Duration::from_secs(120);

/// The default scenario, cut to 12 s, in a file of its own.
fn short_scenario(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sextant-serve-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("short.toml");
    let text = EMBEDDED[0].1.replace("duration_s = 21600", "duration_s = 12");
    std::fs::write(&file, text.replace("name = \"geo-eclipse\"", "name = \"short\"")).unwrap();
    file
}

/// A server of its own with the short scenario ready; gives where it is.
fn started(name: &str) -> String {
    let file = short_scenario(name);
    let library = Library::new(Some(&file), Path::new("no-such-folder"), None).unwrap();
    let scenario = library.scenarios[0].clone();
    let server = Server::bind(0, library).unwrap();
    server.fly(scenario);
    let address = server.address.to_string();
    std::thread::spawn(move || server.run());
    address
}

/// Sends a request with these headers; gives status, head and body.
fn send(address: &str, line: &str, headers: &[(&str, &str)], body: &[u8]) -> (u16, String, Vec<u8>) {
    let mut stream = TcpStream::connect(address).unwrap();
    let mut text = format!("{line} HTTP/1.1\r\nConnection: close\r\nContent-Length: {}\r\n", body.len());
    headers.iter().for_each(|(name, value)| text += &format!("{name}: {value}\r\n"));
    stream.write_all(format!("{text}\r\n").as_bytes()).unwrap();
    stream.write_all(body).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(answer[..end].to_vec()).unwrap();
    (head[9..12].parse().unwrap(), head, answer[end + 4..].to_vec())
}

fn get(address: &str, url: &str) -> (u16, Vec<u8>) {
    let (status, _, body) = send(address, &format!("GET {url}"), &[("Host", address)], b"");
    (status, body)
}

fn json_of(address: &str, url: &str) -> Value {
    let (status, body) = get(address, url);
    assert_eq!(status, 200, "{url}: {}", String::from_utf8_lossy(&body));
    serde_json::from_slice(&body).unwrap()
}

fn order(address: &str, order: &Value) -> (u16, String) {
    let origin = format!("http://{address}");
    let headers = [("Host", address), ("Origin", origin.as_str())];
    let (status, _, body) = send(address, "POST /api/order", &headers, order.to_string().as_bytes());
    (status, String::from_utf8(body).unwrap())
}

/// Waits until the state is as `wanted`.
fn wait_for(address: &str, wanted: impl Fn(&Value) -> bool) -> Value {
    let began = Instant::now();
    loop {
        let state = json_of(address, "/api/state");
        if wanted(&state) {
            return state;
        }
        assert!(began.elapsed() < PATIENCE, "{state}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn the_page_is_whole_and_loads_nothing_from_elsewhere() {
    let address = started("page");
    let (status, head, body) = send(&address, "GET /", &[("Host", &address)], b"");
    let html = String::from_utf8(body).unwrap();
    assert_eq!(status, 200);
    assert!(head.contains("default-src 'none'") && head.contains("nosniff"), "{head}");
    assert!(!head.to_lowercase().contains("access-control"), "{head}");
    for (file, ..) in http::FILES {
        let (status, body) = get(&address, file);
        let text = String::from_utf8(body).unwrap();
        assert!(status == 200 && !text.is_empty(), "{file}");
        assert!(!text.contains("://"), "{file} names another place");
    }
    // Whatever the page's files ask for is one of them.
    let all = http::FILES.map(|(_, _, text)| text).concat();
    for asked in all.split(['"', '\'']).filter(|word| word.ends_with(".js") || word.ends_with(".css")) {
        assert!(http::FILES.iter().any(|(file, ..)| *file == asked), "{asked} is not served");
    }
    assert!(html.contains("/page.js") && html.contains("/page.css") && html.contains("/palette.css"));
    let page = json_of(&address, "/api/page");
    assert_eq!(page["scenarios"][0]["name"], "short");
    assert_eq!(page["scenarios"].as_array().unwrap().len(), EMBEDDED.len() + 1);
    assert!(page["stars"].as_array().unwrap().len() > 400);
}

#[test]
fn other_hosts_and_orders_of_other_pages_are_refused() {
    let address = started("hosts");
    for host in
        ["evil.example", "127.0.0.1.evil.example", "127.0.0.1:80:80", "localhost:x", "192.168.0.1", ""]
    {
        let (status, ..) = send(&address, "GET /api/state", &[("Host", host)], b"");
        assert_eq!(status, 403, "{host}");
    }
    for host in ["localhost", "localhost:9000", "127.0.0.1"] {
        assert_eq!(send(&address, "GET /api/state", &[("Host", host)], b"").0, 200, "{host}");
    }
    let body = json!({"do": "pause"}).to_string();
    for origin in [None, Some("null"), Some("http://evil.example"), Some("http://localhost")] {
        let mut headers = vec![("Host", address.as_str())];
        headers.extend(origin.map(|origin| ("Origin", origin)));
        let (status, ..) = send(&address, "POST /api/order", &headers, body.as_bytes());
        assert_eq!(status, 403, "{origin:?}");
    }
    assert_eq!(order(&address, &json!({"do": "pause"})).0, 200);
}

#[test]
fn what_is_no_request_is_answered_in_a_line() {
    let address = started("bad");
    wait_for(&address, |state| state["run"]["run"] == 1);
    for (wrong, word) in [
        (json!({"do": "fly", "scenario": "../secret"}), "no scenario"),
        (json!({"do": "fault", "kind": "none such"}), "no fault"),
        (json!({"do": "fault", "kind": "gyro-silent"}), "no gyro"),
        (json!({"do": "speed", "times": -1.0}), "no such speed"),
        (json!({"do": "step", "seconds": -1}), "no order"),
        (json!({"do": "open", "folder": "/no/such"}), "summary.json"),
        (json!({"do": "dance"}), "no order"),
        (json!(17), "no order"),
    ] {
        let (status, line) = order(&address, &wrong);
        assert!(
            status == 400 && line.contains(word) && line.lines().count() == 1,
            "{wrong}: {status} {line}"
        );
    }
    for (url, expected) in [
        ("/etc/passwd", 404),
        ("/../page.css", 404),
        ("/api/second", 400),
        ("/api/second?run=1&cycle=9", 404),
        ("/api/second?run=7&cycle=0", 404),
        ("/api/frame?run=1&cycle=4294967296", 400),
        ("/api/frame?run=1&cycle=4294967295", 404),
    ] {
        assert_eq!(get(&address, url).0, expected, "{url}");
    }
    let headers = [("Host", address.as_str()), ("Origin", "http://x")];
    assert_eq!(send(&address, "PUT /api/order", &headers, b"").0, 405);
    assert_eq!(send(&address, "POST /api/order", &headers, &[b' '; 5000]).0, 413);
    assert_eq!(json_of(&address, "/api/state")["flown"], 0, "nothing of this has flown");
}

#[test]
fn a_taken_port_is_said_in_a_line() {
    let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = taken.local_addr().unwrap().port();
    let library = Library::new(None, Path::new("no-such-folder"), None).unwrap();
    let Err(error) = Server::bind(port, library) else { panic!("the port is taken") };
    let line = error.to_string();
    assert!(line.contains("--port") && line.contains(&port.to_string()) && !line.contains('\n'), "{line}");
}

#[test]
fn a_flight_is_stepped_broken_and_looked_at_and_its_record_shows_the_same() {
    let file = short_scenario("record");
    let folder = file.with_file_name("out");
    fly_into(&Scenario::load(&file).unwrap(), &folder, "sil-host run", true).unwrap();
    let address = started("flight");
    wait_for(&address, |state| state["run"]["run"] == 1);
    order(&address, &json!({"do": "step", "seconds": 8}));
    let state = wait_for(&address, |state| state["flown"] == 8);
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(json_of(&address, "/api/state")["flown"], 8, "a paused flight waits");
    let second = json_of(&address, "/api/second?run=1&cycle=7");
    assert!(second["stars"].as_array().unwrap().len() > 5 && second["reported"] == true, "{second}");
    assert!(second["windows"].as_array().unwrap().len() > 20);
    let (status, frame) = get(&address, "/api/frame?run=1&cycle=7");
    assert!(status == 200 && frame.starts_with(b"\x89PNG"));
    // Its record: the same values but for the host's time, the same stars, the same frame.
    let (status, line) = order(&address, &json!({"do": "open", "folder": folder}));
    assert_eq!(status, 200, "{line}");
    let record = json_of(&address, "/api/state");
    assert_eq!(record["run"]["folder"], folder.display().to_string());
    let values = |state: &Value| state["rows"].as_array().unwrap()[..8].to_vec();
    for (flown, recorded) in values(&state).iter().zip(values(&record)) {
        let (flown, recorded) = (flown.as_array().unwrap(), recorded.as_array().unwrap());
        assert_eq!(flown[..flown.len() - 1], recorded[..recorded.len() - 1]);
    }
    let number = &record["run"]["run"];
    let of_record = json_of(&address, &format!("/api/second?run={number}&cycle=7"));
    assert_eq!(second["stars"], of_record["stars"]);
    assert_eq!(get(&address, &format!("/api/frame?run={number}&cycle=7")).1, frame);
    assert_eq!(order(&address, &json!({"do": "start"})).0, 400, "a record does not fly");
    // Another flight, with a fault.
    order(&address, &json!({"do": "fly", "scenario": "short", "seed": 2}));
    wait_for(&address, |state| state["run"]["seed"] == 2);
    order(&address, &json!({"do": "step", "seconds": 8}));
    let before = wait_for(&address, |state| state["flown"] == 8);
    order(&address, &json!({"do": "fault", "kind": "blinded"}));
    order(&address, &json!({"do": "speed", "times": null}));
    order(&address, &json!({"do": "start"}));
    let after = wait_for(&address, |state| state["end"].is_object());
    let of = |state: &Value, second: usize, name: &str| {
        state["rows"][second][row::names().position(|column| column == name).unwrap()].clone()
    };
    assert_eq!(of(&before, 7, "faults"), Value::Null);
    assert_eq!((of(&after, 8, "faults"), of(&after, 8, "status")), (json!("blinded"), json!("blinded")));
    assert!(after["end"]["words"].as_str().unwrap().contains("by hand"), "{}", after["end"]);
    assert_eq!(after["running"], false);
    std::fs::remove_dir_all(file.parent().unwrap()).unwrap();
}

#[test]
fn a_folder_that_is_no_run_is_refused_where_it_is_wrong() {
    let file = short_scenario("damaged");
    let folder = file.with_file_name("out");
    let scenario = Scenario::load(&file).unwrap();
    fly_into(&scenario, &folder, "sil-host run", true).unwrap();
    let open =
        || recorded::open(1, &folder, std::slice::from_ref(&scenario)).map_err(|error| error.to_string());
    let with = |name: &str, change: &dyn Fn(String) -> String| {
        let path = folder.join(name);
        let whole = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, change(whole.clone())).unwrap();
        let opened = open();
        std::fs::write(&path, whole).unwrap();
        opened.err().unwrap_or_else(|| panic!("{name} is damaged"))
    };
    let cut = with("cycles.csv", &|text| text[..text.len() - 40].to_owned());
    assert!(cut.contains("cycles.csv"), "{cut}");
    let unnumbered = with("cycles.csv", &|text| text.replacen("\n3,", "\n5,", 1));
    assert!(unnumbered.contains("cycles.csv:5:") && unnumbered.contains("numbered"), "{unnumbered}");
    let renamed = with("cycles.csv", &|text| text.replacen("true_qx", "qx_true", 1));
    assert!(renamed.contains("cycles.csv:1:") && renamed.contains("true_qx"), "{renamed}");
    let no_summary = with("summary.json", &|_| "{}".to_owned());
    assert!(no_summary.contains("summary.json:1:"), "{no_summary}");
    let start = (scenario.start_us as f64 * 1e-6).to_string();
    let never = with("summary.json", &|text| text.replace(&start, "9e99"));
    assert!(never.contains("summary.json") && never.contains("start_t_s"), "{never}");
    let nowhere = with("summary.json", &|text| text.replace(r#""body": "earth""#, r#""body": "pluto""#));
    assert!(nowhere.contains("summary.json") && nowhere.contains("pluto"), "{nowhere}");
    // What is flown about; a run that does not say it flew about the Earth.
    let summary = folder.join("summary.json");
    let whole = std::fs::read_to_string(&summary).unwrap();
    for (said, body) in [(r#""body": "moon","#, CentralBody::Moon), ("", CentralBody::Earth)] {
        std::fs::write(&summary, whole.replace(r#""body": "earth","#, said)).unwrap();
        assert_eq!(open().unwrap().ground.body(), body);
    }
    std::fs::write(&summary, whole).unwrap();
    assert!(open().unwrap().world.is_ok());
    // Of another orbit the frames would be another run's.
    let other = Scenario { position_km: scenario.position_km.map(|km| 1.001 * km), ..scenario.clone() };
    let run = recorded::open(1, &folder, &[other]).unwrap();
    assert!(run.world.err().unwrap().contains("another world"));
    assert!(recorded::open(1, &folder, &[]).unwrap().world.err().unwrap().contains("not kept"));
    // Without telemetry the rest is shown.
    std::fs::remove_file(folder.join("telemetry.bin")).unwrap();
    assert!(open().unwrap().log().seconds[3].report().is_none());
    std::fs::remove_dir_all(file.parent().unwrap()).unwrap();
}

/// The share of a frame's pixels that are lit.
fn lit(world: &World, report: Option<&Report>) -> f64 {
    let frame = world.frame(&[], 100, report).unwrap();
    let picture = image::load_from_memory(&frame).unwrap().into_luma8();
    let lit = picture.pixels().filter(|pixel| pixel.0[0] > 128).count();
    lit as f64 / picture.pixels().len() as f64
}

#[test]
fn a_frame_is_exposed_through_the_paths_and_as_long_as_the_second_was() {
    let scenario = Scenario::load(&short_scenario("paths")).unwrap();
    let scene = scenario.scene().unwrap();
    let world = World::new(scenario, scene);
    let of = |exposure_us, earth_path_shut| Report {
        exposure_us: Some(exposure_us),
        earth_path_shut,
        ..Report::default()
    };
    let whole = lit(&world, None);
    assert!(whole > 0.005, "the lit Earth: {whole}");
    assert_eq!(lit(&world, Some(&of(400_000, false))), whole);
    let [shut, short] = [of(400_000, true), of(1_000, false)].map(|report| lit(&world, Some(&report)));
    assert!(shut < 0.1 * whole && short < 0.1 * whole, "{shut}, {short} of {whole}");
}
