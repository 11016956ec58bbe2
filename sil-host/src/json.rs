//! One JSON object a line on stdout.

use serde::Serialize;
use std::io::Write;

/// Prints `value` on a line of its own.
///
/// A reader that has closed the pipe has what it wanted; that is no fault.
pub fn print_line<T: Serialize>(value: &T) {
    let mut text = serde_json::to_string(value).expect("answers have string keys only");
    text.push('\n');
    let _ = std::io::stdout().write_all(text.as_bytes());
}
