//! What a user reads when something is wrong: one line, where it is and what to do about it.
//!
//! Every message has the form `sil-host: FILE:LINE: what; what to do`, without `:LINE` where a file has no
//! lines and without `FILE` where none is concerned; of the installed program `sextant: ...`. The program
//! then ends with [`EXIT_BAD_INPUT`].

use crate::words::{io_words, name, one_line};
use fsw_hal::DetectorError;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit status after bad input or wrong usage.
pub const EXIT_BAD_INPUT: u8 = 2;

/// Exit status of a run that was judged and failed its own limits.
pub const EXIT_JUDGED_FAILED: u8 = 1;

/// Why the program cannot go on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HostError {
    /// A picture file cannot be used.
    #[error("{name}: {0}", name = name())]
    Picture(#[from] crate::formats::picture::PictureError),
    /// Something else in a file is wrong.
    #[error("{name}: {0}", name = name())]
    Input(InputError),
    /// The request itself is wrong.
    #[error("{name}: {what}; {to_do}", name = name())]
    Usage {
        /// What is wrong.
        what: String,
        /// What to do about it.
        to_do: String,
    },
}

/// A fault at a place in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file.
    pub file: PathBuf,
    /// Its line, counted from 1, where the file has lines.
    pub line: Option<usize>,
    /// What is wrong.
    pub what: String,
    /// What to do about it.
    pub to_do: String,
}

impl fmt::Display for InputError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:", one_line(&self.file.display().to_string()))?;
        if let Some(line) = self.line {
            write!(formatter, "{line}:")?;
        }
        write!(formatter, " {}; {}", one_line(&self.what), one_line(&self.to_do))
    }
}

impl HostError {
    /// A fault in `file`, at `line` (from 1) where the file has lines.
    pub fn input(
        file: &Path,
        line: Option<usize>,
        what: impl Into<String>,
        to_do: impl Into<String>,
    ) -> Self {
        Self::Input(InputError { file: file.to_path_buf(), line, what: what.into(), to_do: to_do.into() })
    }

    /// The system refuses what is to be done (`read`, `written`) with `file`.
    pub fn system(file: &Path, done: &str, error: &std::io::Error, to_do: &str) -> Self {
        Self::input(file, None, format!("cannot be {done}: {}", io_words(error)), to_do)
    }

    /// A picture did not serve the flight code as a detector, which is a fault of ours.
    pub fn detector(picture: &Path, error: DetectorError) -> Self {
        Self::input(picture, None, format!("the detector failed ({error:?})"), "report this")
    }

    /// A fault of the request that shows in one of several files.
    pub fn at(self, file: &Path) -> Self {
        match self {
            Self::Usage { what, to_do } => Self::input(file, None, what, to_do),
            other => other,
        }
    }

    /// The message without the program's name, within another line.
    pub fn message(&self) -> String {
        match self {
            Self::Picture(error) => error.to_string(),
            Self::Input(error) => error.to_string(),
            Self::Usage { what, to_do } => format!("{what}; {to_do}"),
        }
    }

    /// A fault of the request itself.
    pub fn usage(what: impl Into<String>, to_do: impl Into<String>) -> Self {
        Self::Usage { what: one_line(&what.into()), to_do: one_line(&to_do.into()) }
    }
}

/// Of many inputs those that cannot be used: each costs a line on stderr and status 2 at the end, and the
/// others are answered.
#[derive(Debug, Default)]
pub struct Faults {
    any: bool,
}

impl Faults {
    /// What came of an input, where anything did; else the fault is printed and counted.
    pub fn noted<T>(&mut self, result: Result<T, HostError>) -> Option<T> {
        result
            .inspect_err(|error| {
                eprintln!("{error}");
                self.any = true;
            })
            .ok()
    }

    /// With what the program ends.
    pub fn status(&self) -> ExitCode {
        if self.any { ExitCode::from(EXIT_BAD_INPUT) } else { ExitCode::SUCCESS }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_with_file_line_and_advice() {
        let error = HostError::input(Path::new("a.jsonl"), Some(7), "no\n`id`", "add one");
        assert_eq!(error.to_string(), "sil-host: a.jsonl:7: no `id`; add one");
        let error = HostError::input(Path::new("a.bin"), None, "empty", "write it again");
        assert_eq!(error.to_string(), "sil-host: a.bin: empty; write it again");
    }

    #[test]
    fn a_usage_message_is_one_line() {
        let error = HostError::usage("two\r\nlines", "see --help");
        assert_eq!(error.to_string(), "sil-host: two lines; see --help");
    }
}
