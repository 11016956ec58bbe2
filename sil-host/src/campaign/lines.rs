//! The file that remembers what a campaign has done: one JSON object a line.
//!
//! A campaign that was stopped goes on behind what the file holds; a last line that was cut off is left out.
//! Two campaigns at a time on one file are refused.

use crate::error::HostError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The file, open at its end, for many threads; or none, which remembers nothing.
#[derive(Debug)]
pub struct LinesFile {
    open: Option<(PathBuf, Mutex<File>)>,
}

impl LinesFile {
    /// Opens or makes the file, if there is to be one, and gives what it holds.
    ///
    /// # Errors
    /// When it cannot be read or written, or a line is of no campaign of this kind.
    pub fn open<T: DeserializeOwned>(path: Option<&Path>) -> Result<(Self, Vec<T>), HostError> {
        let Some(path) = path else { return Ok((Self { open: None }, Vec::new())) };
        let system =
            |error: std::io::Error| HostError::system(path, "used", &error, "give another file by --out");
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(system)?;
        crate::output::held(path, &file, "file")?;
        let bytes = std::fs::read(path).map_err(system)?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let line = |(number, line): (usize, &[u8])| {
            serde_json::from_slice(line).map_err(|_| {
                let what = "no line of such a campaign";
                HostError::input(path, Some(number + 1), what, "give another file by --out")
            })
        };
        let lines = bytes[..whole].split_inclusive(|byte| *byte == b'\n');
        let held = lines.enumerate().map(line).collect::<Result<_, _>>()?;
        // What was cut off when the campaign was stopped.
        file.set_len(whole as u64).map_err(system)?;
        Ok((Self { open: Some((path.to_path_buf(), Mutex::new(file))) }, held))
    }

    /// Adds a line.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(&self, done: &impl Serialize) -> Result<(), HostError> {
        let Some((path, file)) = &self.open else { return Ok(()) };
        let line = serde_json::to_string(done).expect("a line has string keys only") + "\n";
        // A thread that failed has said why.
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(line.as_bytes())
            .map_err(|error| HostError::system(path, "written", &error, "free some space"))
    }
}

#[cfg(test)]
mod tests;
