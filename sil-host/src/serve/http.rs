//! Requests and answers: who may ask, what is asked, what is answered.
//!
//! | request | answer |
//! |---|---|
//! | `GET /` and the page's files | the page |
//! | `GET /api/page` | what does not change: columns, scenarios, fault buttons, recorded runs, stars |
//! | `GET /api/state?run=R&since=N` | the run, the controls, and the rows from second N on; all of another run |
//! | `GET /api/second?run=R&cycle=N` | a second looked at ([`super::look`]) |
//! | `GET /api/frame?run=R&cycle=N` | its frame, PNG |
//! | `POST /api/order` | an [`Order`] in JSON, carried out |
//!
//! A page of another site must neither read nor steer. The `Host` must be this machine's loopback, so that a
//! name which another site points here is refused; an order's `Origin` must be the page's own; and no header
//! lets other sites read.

use super::desk::Desk;
use super::log::Run;
use super::orders::{self, Order};
use super::{Library, faults, look, row};
use crate::report::page::PALETTE;
use serde_json::json;
use std::sync::Arc;

/// Most rows in an answer.
const ROWS_MAX: usize = 4000;

/// The page's files: path, type, text.
pub const FILES: [(&str, &str, &str); 13] = [
    ("/", "text/html; charset=utf-8", include_str!("page/page.html")),
    ("/palette.css", CSS, PALETTE),
    ("/page.css", CSS, include_str!("page/page.css")),
    ("/page.js", JS, include_str!("page/page.js")),
    ("/controls.js", JS, include_str!("page/controls.js")),
    ("/run.js", JS, include_str!("page/run.js")),
    ("/words.js", JS, include_str!("page/words.js")),
    ("/plots.js", JS, include_str!("page/plots.js")),
    ("/frame.js", JS, include_str!("page/frame.js")),
    ("/sky.js", JS, include_str!("page/sky.js")),
    ("/globe.js", JS, include_str!("page/globe.js")),
    ("/svg.js", JS, include_str!("page/svg.js")),
    ("/coast.json", JSON, include_str!("page/coast.json")),
];
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";
const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Whether it is an order (POST); else it only asks (GET).
    pub is_order: bool,
    /// Path and query.
    pub url: &'a str,
    /// The header `Host`.
    pub host: Option<&'a str>,
    /// The header `Origin`.
    pub origin: Option<&'a str>,
    /// The body.
    pub body: &'a [u8],
}

/// What is answered.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// HTTP status.
    pub status: u16,
    /// Type of the body.
    pub kind: &'static str,
    /// The body.
    pub body: Vec<u8>,
}

impl Answer {
    /// A line of text.
    pub fn text(status: u16, line: &str) -> Self {
        Self { status, kind: TEXT, body: format!("{line}\n").into_bytes() }
    }

    fn json(text: String) -> Self {
        Self { status: 200, kind: JSON, body: text.into_bytes() }
    }
}

/// Answers a request.
pub fn answer(request: &Request<'_>, desk: &Desk, library: &Library) -> Answer {
    let Some(host) = request.host.filter(|host| is_loopback(host)) else {
        return Answer::text(403, "this page is for this machine only: ask for 127.0.0.1 or localhost");
    };
    let (path, query) = request.url.split_once('?').unwrap_or((request.url, ""));
    if request.is_order {
        return match path {
            "/api/order" if request.origin != Some(&format!("http://{host}")) => {
                Answer::text(403, "orders are taken from this page only: their Origin must be its own")
            }
            "/api/order" => order(request.body, desk, library),
            _ => Answer::text(404, "no such page"),
        };
    }
    if let Some((_, kind, text)) = FILES.into_iter().find(|(file, ..)| *file == path) {
        return Answer { status: 200, kind, body: text.into() };
    }
    match path {
        "/api/page" => page(library),
        "/api/state" => state(query, desk),
        "/api/second" => of_second(query, desk, |run, cycle| {
            let log = run.log();
            let second = log.seconds.get(cycle as usize).cloned();
            drop(log);
            let second = second.ok_or_else(not_flown)?;
            Ok(Answer::json(json!(look::look(run, cycle, &second)).to_string()))
        }),
        "/api/frame" => of_second(query, desk, |run, cycle| {
            let log = run.log();
            let (second, faults) = (log.seconds.get(cycle as usize).cloned(), log.faults.clone());
            drop(log);
            let report = second.ok_or_else(not_flown)?.report();
            let world = run.world.as_ref().map_err(Clone::clone);
            let drawn = world.and_then(|world| world.frame(&faults, cycle, report.as_ref()));
            let body = drawn.map_err(|why| Answer::text(404, &why))?;
            Ok(Answer { status: 200, kind: "image/png", body })
        }),
        _ => Answer::text(404, "no such page"),
    }
}

/// Whether a `Host` names this machine's loopback, at whatever port a tunnel gives it.
fn is_loopback(host: &str) -> bool {
    let (name, port) = host.rsplit_once(':').unwrap_or((host, "80"));
    matches!(name, "127.0.0.1" | "localhost") && port.parse::<u16>().is_ok()
}

fn not_flown() -> Answer {
    Answer::text(404, "this second has not been flown")
}

/// A whole number of a query.
fn number(query: &str, key: &str) -> Option<u32> {
    let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
    pairs.filter(|(name, _)| *name == key).find_map(|(_, value)| value.parse().ok())
}

/// What does not change while the program runs.
fn page(library: &Library) -> Answer {
    let scenarios: Vec<_> = library
        .scenarios
        .iter()
        .map(|scenario| json!({"name": scenario.name, "description": scenario.description, "seed": scenario.seed}))
        .collect();
    let page = json!({
        "columns": row::names().collect::<Vec<_>>(),
        "scenarios": scenarios,
        "faults": faults::buttons(),
        "recorded": library.recorded(),
        "stars": look::background(),
    });
    Answer::json(page.to_string())
}

/// The run, the controls, and rows.
fn state(query: &str, desk: &Desk) -> Answer {
    let controls = desk.controls();
    let (run, (running, speed)) = (controls.run().cloned(), (controls.running, controls.speed));
    let (message, preparing, steps) = (controls.message.clone(), controls.preparing, controls.steps);
    drop(controls);
    let Some(run) = run else {
        return Answer::json(json!({"run": null, "preparing": preparing, "message": message}).to_string());
    };
    let log = run.log();
    let flown = log.seconds.len();
    let known = number(query, "run") == Some(run.title.run);
    let since = number(query, "since").filter(|_| known).map_or(0, |since| (since as usize).min(flown));
    let rows: Vec<&str> =
        log.seconds[since..].iter().take(ROWS_MAX).map(|second| second.row.as_str()).collect();
    let faults: Vec<_> = log
        .faults
        .iter()
        .map(|fault| json!({"kind": fault.kind.word(), "from_s": fault.from_s, "until_s": fault.until_s}))
        .collect();
    let head = json!({
        "run": run.title, "running": running, "speed": speed, "steps": steps, "flown": flown,
        "since": since, "faults": faults, "end": log.end, "message": message, "preparing": preparing,
    });
    let head = head.to_string();
    // The rows are JSON already.
    let head = head.strip_suffix('}').unwrap_or(&head);
    Answer::json(format!("{head},\"rows\":[{}]}}", rows.join(",")))
}

/// The answer about a second of the run that is asked about.
fn of_second(query: &str, desk: &Desk, answer: impl FnOnce(&Run, u32) -> Result<Answer, Answer>) -> Answer {
    let run: Option<Arc<Run>> = desk.controls().run().cloned();
    let (Some(asked), Some(cycle)) = (number(query, "run"), number(query, "cycle")) else {
        return Answer::text(400, "say which run and which second: ?run=R&cycle=N");
    };
    match run.filter(|run| run.title.run == asked) {
        Some(run) => answer(&run, cycle).unwrap_or_else(|answer| answer),
        None => Answer::text(404, "this run is no longer shown"),
    }
}

/// Carries an order out.
fn order(body: &[u8], desk: &Desk, library: &Library) -> Answer {
    let order: Order = match serde_json::from_slice(body) {
        Ok(order) => order,
        Err(error) => return Answer::text(400, &format!("no order: {error}")),
    };
    match orders::carry_out(order, desk, library) {
        Ok(()) => Answer::json(json!({"done": true}).to_string()),
        Err(error) => Answer::text(400, &error.to_string()),
    }
}
