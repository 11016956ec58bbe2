//! One JSON object a line, in and out.

use crate::error::HostError;
use serde::{Deserialize, Serialize};
use std::path::Path;

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
        HostError::input(path, Some(number), words, to_do)
    })
}

/// Prints `value` on a line of its own.
pub fn print_line<T: Serialize>(value: &T) {
    say!("{}", serde_json::to_string(value).expect("answers have string keys only"));
}
