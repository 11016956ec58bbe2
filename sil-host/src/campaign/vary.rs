//! The file of `--vary`: keys of a scenario that every run of a campaign draws anew.
//!
//! In: TOML in the shape of a scenario file, with a distribution in the place of a value:
//!
//! | distribution | draws |
//! |---|---|
//! | `{ uniform = [low, high] }` | a number evenly from low to high |
//! | `{ log_uniform = [low, high] }` | a number whose logarithm is even |
//! | `{ normal = [mean, sigma] }` | a Gaussian number |
//! | `{ whole = [low, high] }` | a whole number, both ends among them |
//! | `{ choice = [a, b, ...] }` | one of these, each as often |
//!
//! A plain value replaces the scenario's. In an array the element of the same place is replaced, so
//! `star_path_deg = [0.0, { normal = [90.0, 0.1] }, 0.0]` and `[[faults]]` can be drawn as well. Out:
//! [`Variation`]. What a run draws for a key depends on the campaign's seed, the run and the key alone.

use crate::error::HostError;
use crate::formats::toml_keys::{keys, line_at};
use crate::world::noise::{Noise, Stream};
use std::path::{Path, PathBuf};
use toml::Value;

pub(super) const TO_DO: &str = "give a value or one of { uniform = [low, high] }, { log_uniform = [low, high] }, { normal = [mean, sigma] }, \
     { whole = [low, high] }, { choice = [a, b] }";

/// What stands in the place of a value.
#[derive(Clone, Debug, PartialEq)]
enum Source {
    Uniform([f64; 2]),
    LogUniform([f64; 2]),
    Normal([f64; 2]),
    Whole([i64; 2]),
    Choice(Vec<Value>),
    Fixed(Value),
}

impl Source {
    /// The distribution that a table is; `None`: it is a table of keys.
    fn of(table: &toml::Table) -> Option<Result<Self, &'static str>> {
        let (word, value) = table.iter().next().filter(|_| table.len() == 1)?;
        let pair = || {
            let numbers: Vec<f64> = value.as_array()?.iter().filter_map(number).collect();
            <[f64; 2]>::try_from(numbers).ok().filter(|pair| pair.iter().all(|number| number.is_finite()))
        };
        let ordered = |pair: Option<[f64; 2]>, what| pair.filter(|[low, high]| low < high).ok_or(what);
        Some(match word.as_str() {
            "uniform" => ordered(pair(), "uniform takes two numbers, the lower one first").map(Self::Uniform),
            "log_uniform" => ordered(
                pair().filter(|[low, _]| *low > 0.0),
                "log_uniform takes two numbers above 0, the lower one first",
            )
            .map(Self::LogUniform),
            "normal" => pair()
                .filter(|[_, sigma]| *sigma >= 0.0)
                .map(Self::Normal)
                .ok_or("normal takes mean and sigma, which is not negative"),
            "whole" => value
                .as_array()
                .map(|ends| ends.iter().filter_map(Value::as_integer).collect::<Vec<i64>>())
                .and_then(|ends| <[i64; 2]>::try_from(ends).ok())
                .filter(|[low, high]| low <= high)
                .map(Self::Whole)
                .ok_or("whole takes two whole numbers, the lower one first"),
            "choice" => value
                .as_array()
                .filter(|values| !values.is_empty())
                .map(|values| Self::Choice(values.clone()))
                .ok_or("choice takes a list of values"),
            _ => return None,
        })
    }

    fn draw(&self, noise: &Noise) -> Value {
        let uniform = noise.uniform(0, 0);
        let between = |[low, high]: [f64; 2]| low + (high - low) * uniform;
        match self {
            Self::Uniform(ends) => Value::Float(between(*ends)),
            Self::LogUniform(ends) => {
                Value::Float(libm::exp(between(ends.map(libm::log))).clamp(ends[0], ends[1]))
            }
            Self::Normal([mean, sigma]) => Value::Float(mean + sigma * noise.gaussian(0, 0)),
            Self::Whole([low, high]) => {
                let count = high.abs_diff(*low) as f64 + 1.0;
                Value::Integer(low.saturating_add((count * uniform) as i64).min(*high))
            }
            Self::Choice(values) => {
                values[((values.len() as f64 * uniform) as usize).min(values.len() - 1)].clone()
            }
            Self::Fixed(value) => value.clone(),
        }
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// What is drawn, read and checked.
#[derive(Clone, Debug)]
pub struct Variation {
    file: PathBuf,
    text: String,
    sources: Vec<(Vec<String>, Source)>,
}

/// A key with dots and the value drawn for it.
pub type Drawn = Vec<(String, Value)>;

impl Variation {
    /// Reads a file.
    ///
    /// # Errors
    /// With file and line, when it cannot be read or a distribution cannot be drawn from.
    pub fn load(file: &Path) -> Result<Self, HostError> {
        let text = std::fs::read_to_string(file).map_err(|error| {
            HostError::system(file, "read", &error, "give a TOML file of scenario keys and distributions")
        })?;
        Self::parse(file, text)
    }

    /// Reads a text; `file` is for messages.
    ///
    /// # Errors
    /// As [`Variation::load`].
    pub fn parse(file: &Path, text: String) -> Result<Self, HostError> {
        let tree: toml::Table = toml::from_str(&text).map_err(|error| {
            let line = error.span().map(|span| line_at(&text, span.start));
            HostError::input(file, line, error.message(), "correct the line")
        })?;
        let mut sources = Vec::new();
        gather(&Value::Table(tree), &mut Vec::new(), &mut sources).map_err(|(path, what)| {
            HostError::input(file, line_of(&text, &path), format!("{path}: {what}"), TO_DO)
        })?;
        let variation = Self { file: file.to_path_buf(), text, sources };
        if variation.sources.is_empty() {
            return Err(HostError::input(file, None, "varies nothing", TO_DO));
        }
        if variation.has("scenario.seed") {
            let to_do = "remove it: the seed follows from --seed and the run";
            return Err(variation.fault("scenario.seed", "every run has its own".into(), to_do));
        }
        Ok(variation)
    }

    /// The scenario `base` with what `run` draws, and the values.
    pub fn draw(&self, base: &toml::Table, seed: u64, run: u64) -> (Value, Drawn) {
        let mut tree = Value::Table(base.clone());
        let noise = Noise::new(seed, run, Stream::Variation);
        let mut drawn = Vec::new();
        for (path, source) in &self.sources {
            let name = path.join(".");
            let value = source.draw(&noise.part(hash(&name)));
            set(&mut tree, path, value.clone());
            drawn.push((name, value));
        }
        (tree, drawn)
    }

    /// A fault of what stands here for a scenario's key.
    pub fn fault(&self, key: &str, what: String, to_do: &str) -> HostError {
        HostError::input(&self.file, line_of(&self.text, key), format!("{key}: {what}"), to_do)
    }

    /// The same without a key and its parts; `None` where nothing is left.
    pub fn without(mut self, key: &str) -> Option<Self> {
        self.sources.retain(|(path, _)| !belongs(&path.join("."), key));
        (!self.sources.is_empty()).then_some(self)
    }

    /// The word that stands, with a list, in a table in the place of a key's value, if there is one: a
    /// distribution that is none.
    pub fn no_distribution(&self, key: &str) -> Option<&str> {
        self.sources.iter().find_map(|(path, source)| {
            let (word, above) = path.split_last()?;
            (above.join(".") == key && matches!(source, Source::Fixed(Value::Array(_))))
                .then_some(word.as_str())
        })
    }

    /// Whether something is drawn for a key or for a part of it.
    pub fn has(&self, key: &str) -> bool {
        self.sources.iter().map(|(path, _)| path.join(".")).any(|path| belongs(&path, key))
    }
}

/// Whether a key is another one or a part of it.
fn belongs(key: &str, of: &str) -> bool {
    key.strip_prefix(of).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Distributions and plain values of a tree, with their paths.
fn gather(
    value: &Value,
    path: &mut Vec<String>,
    into: &mut Vec<(Vec<String>, Source)>,
) -> Result<(), (String, &'static str)> {
    let source = match value {
        Value::Table(table) => match Source::of(table) {
            Some(source) => source.map_err(|what| (path.join("."), what))?,
            None => {
                for (key, value) in table {
                    path.push(key.clone());
                    gather(value, path, into)?;
                    path.pop();
                }
                return Ok(());
            }
        },
        Value::Array(values) if values.iter().any(Value::is_table) => {
            for (index, value) in values.iter().enumerate() {
                path.push(index.to_string());
                gather(value, path, into)?;
                path.pop();
            }
            return Ok(());
        }
        plain => Source::Fixed(plain.clone()),
    };
    into.push((path.clone(), source));
    Ok(())
}

/// Puts a value into a tree; what is missing on the way is made.
fn set(tree: &mut Value, path: &[String], value: Value) {
    let Some((step, rest)) = path.split_first() else {
        *tree = value;
        return;
    };
    if let Value::Array(values) = tree
        && let Ok(index) = step.parse::<usize>()
    {
        while values.len() <= index {
            values.push(Value::Table(toml::Table::new()));
        }
        return set(&mut values[index], rest, value);
    }
    if !tree.is_table() {
        *tree = Value::Table(toml::Table::new());
    }
    if let Value::Table(table) = tree {
        let is_list = rest.first().is_some_and(|next| next.parse::<usize>().is_ok());
        let missing = || if is_list { Value::Array(Vec::new()) } else { Value::Table(toml::Table::new()) };
        set(table.entry(step.clone()).or_insert_with(missing), rest, value);
    }
}

/// FNV-1a: a number for a name.
fn hash(name: &str) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    name.bytes().fold(0xcbf2_9ce4_8422_2325, step)
}

/// Line of a key, or of the first part of it.
fn line_of(text: &str, key: &str) -> Option<usize> {
    let keys = keys(text);
    let own = keys.iter().find(|(name, _)| name == key);
    own.or_else(|| keys.iter().filter(|(name, _)| belongs(name, key)).max_by_key(|(name, _)| name.len()))
        .map(|(_, line)| *line)
}

#[cfg(test)]
mod tests;
