//! The file that remembers what a campaign has done: one JSON object a line.
//!
//! A campaign that was stopped goes on behind what the file holds; a last line that was cut off is left out.

use crate::error::HostError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The file, open at its end.
#[derive(Debug)]
pub struct LinesFile {
    path: PathBuf,
    file: File,
}

impl LinesFile {
    /// Opens or makes the file, and gives what it holds.
    ///
    /// # Errors
    /// When it cannot be read or written, or a line is of no campaign of this kind.
    pub fn open<T: DeserializeOwned>(path: &Path) -> Result<(Self, Vec<T>), HostError> {
        let system =
            |error: std::io::Error| HostError::system(path, "used", &error, "give another file by --out");
        let text = if path.exists() { std::fs::read_to_string(path).map_err(system)? } else { String::new() };
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let line = |(number, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|_| {
                let what = "no line of such a campaign";
                HostError::input(path, Some(number + 1), what, "give another file by --out")
            })
        };
        let held = text[..whole].lines().enumerate().map(line).collect::<Result<_, _>>()?;
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(system)?;
        // What was cut off when the campaign was stopped.
        file.set_len(whole as u64).map_err(system)?;
        Ok((Self { path: path.to_path_buf(), file }, held))
    }

    /// Adds a line.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(&mut self, done: &impl Serialize) -> Result<(), HostError> {
        let line = serde_json::to_string(done).expect("a line has string keys only") + "\n";
        self.file
            .write_all(line.as_bytes())
            .map_err(|error| HostError::system(&self.path, "written", &error, "free some space"))
    }
}

#[cfg(test)]
#[path = "lines_tests.rs"]
mod tests;
