//! One JSON object a line on stdout.

use serde::Serialize;

/// Prints `value` on a line of its own.
pub fn print_line<T: Serialize>(value: &T) {
    say!("{}", serde_json::to_string(value).expect("answers have string keys only"));
}
