//! `cycles.csv`: a row a second, its columns declared in [`columns`].
//!
//! Whole lines only are handed to the system, every few hundred or after a second of waiting, so that a run
//! that is killed leaves a file that can be read up to its last full line. An empty field is a value that was
//! not there.

pub mod columns;

use crate::error::HostError;
use crate::output::PartialFile;
use columns::{RowInputs, cells, names};
use std::path::Path;
use std::time::{Duration, Instant};

/// Most lines kept back.
const LINES: u32 = 256;
/// Longest time for which lines are kept back.
const PATIENCE: Duration = Duration::from_secs(1);

/// The file under way.
#[derive(Debug)]
pub struct CyclesFile {
    file: PartialFile,
    kept_back: csv::Writer<Vec<u8>>,
    lines: u32,
    written: Instant,
}

/// A line that cannot be made, which is a fault of ours.
fn unwritten(error: impl std::fmt::Display) -> HostError {
    HostError::usage(format!("a line of cycles.csv cannot be made: {error}"), "report this")
}

impl CyclesFile {
    /// Makes the file and writes its header.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: &Path) -> Result<Self, HostError> {
        let mut kept_back = csv::Writer::from_writer(Vec::new());
        kept_back.write_record(names()).map_err(unwritten)?;
        let mut cycles =
            Self { file: PartialFile::create(path)?, kept_back, lines: 0, written: Instant::now() };
        cycles.flush()?;
        Ok(cycles)
    }

    /// Adds the row of a second; gives whether lines were handed to the system.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn add(&mut self, row: &RowInputs<'_>) -> Result<bool, HostError> {
        self.kept_back.serialize(cells(row)).map_err(unwritten)?;
        self.lines += 1;
        let due = self.lines >= LINES || self.written.elapsed() >= PATIENCE;
        if due {
            self.flush()?;
        }
        Ok(due)
    }

    fn flush(&mut self) -> Result<(), HostError> {
        let empty = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        let lines = std::mem::replace(&mut self.kept_back, empty).into_inner().map_err(unwritten)?;
        self.file.write(&lines)?;
        self.lines = 0;
        self.written = Instant::now();
        Ok(())
    }

    /// Hands over what is left and gives the file its name.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(mut self) -> Result<(), HostError> {
        self.flush()?;
        self.file.finish()
    }
}

#[cfg(test)]
mod tests;
