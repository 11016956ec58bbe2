//! The text of a scenario file: from places in it to messages with a line.

use crate::error::HostError;
use crate::formats::toml_keys::{key_at, line_at};
use crate::words::{io_words, kinds};
use std::path::{Path, PathBuf};
use toml::Spanned;

/// A text being read and the name it goes by in messages.
#[derive(Clone, Copy)]
pub(super) struct Text<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Text<'_> {
    /// Line of the byte `at`, from 1.
    pub(super) fn line(&self, at: usize) -> usize {
        line_at(self.text, at)
    }

    /// A fault of the value of `key`, at byte `at`.
    pub(super) fn fault(&self, at: usize, key: &str, what: &str, to_do: &str) -> HostError {
        HostError::input(self.path, Some(self.line(at)), format!("{key}: {what}"), to_do)
    }

    /// What the TOML reader found: broken syntax, a key that is missing or unknown, a value of another kind.
    pub(super) fn syntax(&self, error: &toml::de::Error) -> HostError {
        let message = error.message();
        let to_do = if message.contains("missing field") {
            "add it"
        } else if message.contains("unknown field") {
            "correct or remove it"
        } else {
            "correct the line"
        };
        let line = error.span().map(|span| self.line(span.start));
        let words = kinds(message);
        let key = line.filter(|_| words != message).and_then(|line| key_at(self.text, line));
        let what = key.map_or(words.clone(), |key| format!("{key}: {words}"));
        HostError::input(self.path, line, what, to_do)
    }

    /// Path and text of the file that `key` names, from the folder of this text.
    pub(super) fn file(
        &self,
        key: &str,
        name: &Spanned<String>,
        to_do: &str,
    ) -> Result<(PathBuf, String), HostError> {
        let path = self.path.parent().unwrap_or(Path::new("")).join(name.get_ref());
        let content = std::fs::read_to_string(&path).map_err(|error| {
            let what = format!("{} cannot be read: {}", path.display(), io_words(&error));
            self.fault(name.span().start, key, &what, to_do)
        })?;
        Ok((path, content))
    }

    /// A number within its range; `None` takes the default.
    pub(super) fn number(
        &self,
        key: &str,
        value: Option<&Spanned<f64>>,
        default: f64,
        (low, high): (f64, f64),
    ) -> Result<f64, HostError> {
        let Some(value) = value else { return Ok(default) };
        let number = *value.get_ref();
        // Written so that NaN is refused as well.
        if !(number >= low && number <= high) {
            let to_do = format!("use {low} to {high}");
            return Err(self.fault(value.span().start, key, &format!("{number} is out of range"), &to_do));
        }
        Ok(number)
    }

    /// A whole number within its range; `None` takes the default.
    pub(super) fn whole(
        &self,
        key: &str,
        value: Option<&Spanned<i64>>,
        default: i64,
        (low, high): (i64, i64),
    ) -> Result<i64, HostError> {
        let Some(value) = value else { return Ok(default) };
        let number = *value.get_ref();
        if !(low..=high).contains(&number) {
            let to_do = format!("use {low} to {high}");
            return Err(self.fault(value.span().start, key, &format!("{number} is out of range"), &to_do));
        }
        Ok(number)
    }

    /// Some numbers, each within the range.
    pub(super) fn array<const N: usize>(
        &self,
        key: &str,
        value: &Spanned<[f64; N]>,
        (low, high): (f64, f64),
    ) -> Result<[f64; N], HostError> {
        let numbers = *value.get_ref();
        match numbers.iter().find(|number| !(**number >= low && **number <= high)) {
            Some(number) => Err(self.fault(
                value.span().start,
                key,
                &format!("{number} is out of range"),
                &format!("use {low} to {high}"),
            )),
            None => Ok(numbers),
        }
    }
}
