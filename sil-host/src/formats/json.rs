//! One JSON object a line, in and out.

use crate::error::HostError;
use crate::words::kinds;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// The lines of a file that are not blank, as they come.
///
/// Each has its number, from 1, or is a fault of its own: a line that is no UTF-8 text does not end the file.
/// A file without lines is one fault.
pub struct Lines<'p> {
    path: &'p Path,
    /// What to do about a file without lines.
    to_do: &'static str,
    /// None behind the end.
    reader: Option<BufReader<File>>,
    number: usize,
    any: bool,
}

impl<'p> Lines<'p> {
    /// Opens the file; `to_do` is the advice where it holds no line.
    ///
    /// # Errors
    /// When the system does not hand it out.
    pub fn open(path: &'p Path, to_do: &'static str) -> Result<Self, HostError> {
        let file = File::open(path).map_err(|error| unreadable(path, &error))?;
        Ok(Self { path, to_do, reader: Some(BufReader::new(file)), number: 0, any: false })
    }

    /// The end: nothing is read behind it.
    fn end(&mut self, fault: Option<HostError>) -> Option<Result<(usize, String), HostError>> {
        self.reader = None;
        fault.map(Err)
    }
}

impl Iterator for Lines<'_> {
    type Item = Result<(usize, String), HostError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let mut bytes = Vec::new();
            match self.reader.as_mut()?.read_until(b'\n', &mut bytes) {
                Ok(0) if self.any => return self.end(None),
                Ok(0) => {
                    return self.end(Some(HostError::input(
                        self.path,
                        None,
                        "the file is empty: it holds no line",
                        self.to_do,
                    )));
                }
                Ok(_) => self.number += 1,
                Err(error) => return self.end(Some(unreadable(self.path, &error))),
            }
            if bytes.iter().all(u8::is_ascii_whitespace) {
                continue;
            }
            self.any = true;
            let number = Some(self.number);
            let no_text = |_| HostError::input(self.path, number, "no UTF-8 text", "write the line as UTF-8");
            return Some(String::from_utf8(bytes).map(|text| (self.number, text)).map_err(no_text));
        }
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> HostError {
    HostError::system(path, "read", error, "check the path")
}

/// What line `number` (from 1) of a file holds.
///
/// # Errors
/// Where it holds something else; `to_do` says what to give.
pub fn read_line<'t, T: Deserialize<'t>>(
    path: &Path,
    number: usize,
    text: &'t str,
    to_do: &str,
) -> Result<T, HostError> {
    serde_json::from_str(text).map_err(|error| {
        let words = error.to_string();
        // The parser counts lines within this one.
        let words = words.split(" at line").next().unwrap_or(&words);
        HostError::input(path, Some(number), kinds(words), to_do)
    })
}

/// Prints `value` on a line of its own.
pub fn print_line<T: Serialize>(value: &T) {
    print_line!("{}", serde_json::to_string(value).expect("answers have string keys only"));
}

#[cfg(test)]
mod tests;
