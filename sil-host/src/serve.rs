//! `sil-host serve`: a page on this machine that flies a scenario live and shows recorded runs.
//!
//! In: scenarios, a port. Out: a page at the loopback address. Nothing is written: the run's seconds are kept
//! in memory, 2 to 4 KB a second of flight, as long as it is shown.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`connection`] | a connection | its request, and the answer to it |
//! | [`http`] | a request | the answer, or why it is refused |
//! | [`orders`] | what a button asks for | controls that are set |
//! | [`desk`] | controls | what the flight does next |
//! | [`flying`] | the desk, a scenario | the flight, second after second |
//! | [`recorded`] | the folder of a run | its seconds |
//! | [`log`], [`row`] | seconds | what is kept of them; a line of values each |
//! | [`look`], [`ground`] | a second | what is drawn of it: frame, sky, globe |
//! | [`world`] | a scenario | frames, drawn when they are asked for |
//! | [`faults`] | a button | a fault of the harness |
//! | `page/` | all of these | HTML, CSS and JavaScript; nothing from elsewhere |
//!
//! `page/coast.json` are the coasts of Natural Earth (public domain), its land at 1:110 million simplified to
//! 0.35 deg: lines of longitude and latitude in turn, tenths of a degree.
//!
//! A flight here is the flight of `run`: the same scenario and seed give the same seconds.

pub mod connection;
pub mod desk;
pub mod faults;
pub mod flying;
pub mod ground;
pub mod http;
pub mod log;
pub mod look;
pub mod orders;
pub mod recorded;
pub mod row;
pub mod world;

use crate::error::HostError;
use crate::scenario::{EMBEDDED, Scenario};
use crate::words::io_words;
use desk::Desk;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};

/// What can be flown and opened.
#[derive(Debug)]
pub struct Library {
    /// The scenarios, the first one flown when nothing else is asked for.
    pub scenarios: Vec<Scenario>,
    /// The folder in which runs are looked for.
    runs: PathBuf,
    /// A recorded run that was named.
    named: Option<PathBuf>,
}

impl Library {
    /// The scenarios that come with the program, behind one that is named; runs below the folder `runs`, and
    /// one that is `named`.
    ///
    /// # Errors
    /// When the named scenario cannot be read.
    pub fn new(scenario: Option<&Path>, runs: &Path, named: Option<PathBuf>) -> Result<Self, HostError> {
        let first = Scenario::named(scenario)?;
        let mut scenarios = vec![first];
        for (name, text) in EMBEDDED {
            let embedded = Scenario::parse(Path::new(name), text)?;
            if embedded.name != scenarios[0].name {
                scenarios.push(embedded);
            }
        }
        Ok(Self { scenarios, runs: runs.to_path_buf(), named })
    }

    /// The scenario of a name.
    ///
    /// # Errors
    /// When there is none.
    pub fn scenario(&self, name: &str) -> Result<Scenario, HostError> {
        self.scenarios.iter().find(|scenario| scenario.name == name).cloned().ok_or_else(|| {
            let names: Vec<&str> = self.scenarios.iter().map(|scenario| scenario.name.as_str()).collect();
            HostError::usage(
                format!("`{name}` is no scenario of this page"),
                format!("use {}", names.join(", ")),
            )
        })
    }

    /// The recorded runs that are at hand.
    pub fn recorded(&self) -> Vec<String> {
        let named = self.named.iter().map(|path| path.display().to_string());
        named.chain(recorded::found_in(&self.runs)).collect()
    }
}

/// The page, bound to its port.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    desk: Desk,
    library: Library,
}

impl Server {
    /// Takes a port of the loopback address, 0: any that is free.
    ///
    /// # Errors
    /// When the port cannot be had.
    pub fn bind(port: u16, library: Library) -> Result<Self, HostError> {
        let refused = |why: String| {
            HostError::usage(format!("--port: {port} cannot be had: {why}"), "use another one, or 0 for any")
        };
        let listener =
            TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|error| refused(io_words(&error)))?;
        let address = listener.local_addr().map_err(|error| refused(io_words(&error)))?;
        Ok(Self { listener, address, desk: Desk::default(), library })
    }

    /// Where the page is.
    pub fn address(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Shows a recorded run.
    ///
    /// # Errors
    /// When the folder is none of a run.
    pub fn open(&self, folder: &Path) -> Result<(), HostError> {
        self.desk.open(|run| recorded::open(run, folder, &self.library.scenarios))
    }

    /// Makes a flight ready.
    pub fn fly(&self, scenario: Scenario) {
        self.desk.fly(scenario);
    }

    /// Answers and flies until the program ends.
    pub fn run(&self) {
        std::thread::scope(|scope| {
            scope.spawn(|| flying::work(&self.desk));
            for stream in self.listener.incoming().flatten() {
                scope.spawn(|| {
                    // Of a connection that broke off nobody waits for an answer.
                    let _ =
                        connection::serve(stream, |request| http::answer(request, &self.desk, &self.library));
                });
            }
        });
    }
}

#[cfg(test)]
mod tests;
