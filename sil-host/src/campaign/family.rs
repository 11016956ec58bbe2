//! The scenario of each run of a campaign: another seed, and the keys that `--vary` draws.
//!
//! In: a scenario, a file of what varies, the campaign's seed, the number of a run. Out: a checked
//! [`Scenario`] that depends on these alone, and the values drawn.

use super::vary::{self, Variation};
use crate::error::{HostError, InputError};
use crate::formats::toml_keys::key_at;
use crate::scenario::{Believed, Scenario};
use crate::words::IN_THE_PLACE_OF;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Values drawn for a run, by key.
pub type Values = BTreeMap<String, serde_json::Value>;

/// The scenarios of a campaign.
#[derive(Clone, Debug)]
pub struct Family {
    /// The scenario as its file has it.
    pub base: Scenario,
    varied: Option<Varied>,
}

#[derive(Clone, Debug)]
struct Varied {
    path: PathBuf,
    table: toml::Table,
    variation: Variation,
}

/// Seed of a run's flight. Odd multiples keep the runs of neighbouring seeds apart.
fn flight_seed(seed: u64, run: u64) -> u64 {
    seed.wrapping_mul(1_000_003).wrapping_add(run)
}

impl Family {
    /// Of a scenario file or name, none: the default one; `vary` names what is drawn.
    ///
    /// # Errors
    /// When a file cannot be read or is wrong.
    pub fn new(scenario: Option<&Path>, vary: Option<&Path>) -> Result<Self, HostError> {
        let (path, text) = Scenario::text(scenario)?;
        Self::of_text(&path, &text, vary.map(Variation::load).transpose()?)
    }

    /// Of a scenario of which nothing is drawn but the seed.
    pub fn of_scenario(base: Scenario) -> Self {
        Self { base, varied: None }
    }

    /// Of the text of a scenario; `path` is for messages and for the folder of its files.
    ///
    /// # Errors
    /// When the text is no scenario.
    pub fn of_text(path: &Path, text: &str, variation: Option<Variation>) -> Result<Self, HostError> {
        let base = Scenario::parse(path, text)?;
        // A scenario is TOML.
        let table = toml::from_str(text).unwrap_or_default();
        let varied = variation.map(|variation| Varied { path: path.to_path_buf(), table, variation });
        Ok(Self { base, varied })
    }

    /// The same scenarios, in which the flight code is told the truth: what is drawn for `[believed]` is not.
    pub fn told_the_truth(mut self) -> Self {
        self.base.believed = Believed::TRUTH;
        self.varied = self.varied.and_then(|Varied { path, mut table, variation }| {
            let none = toml::Table::from_iter([("differences".to_owned(), false.into())]);
            table.insert("believed".to_owned(), none.into());
            Some(Varied { path, table, variation: variation.without("believed")? })
        });
        self
    }

    /// The scenario of a run, and what was drawn for it.
    ///
    /// # Errors
    /// When what was drawn makes no scenario: with line and key of the file that says what varies.
    pub fn member(&self, seed: u64, run: u64) -> Result<(Scenario, Values), HostError> {
        let seed_of_flight = Some(flight_seed(seed, run));
        let Some(Varied { path, table, variation }) = &self.varied else {
            return Ok((self.base.clone().with_seed(seed_of_flight), Values::new()));
        };
        let (tree, drawn) = variation.draw(table, seed, run);
        let text = toml::to_string(&tree).map_err(|error| {
            HostError::usage(format!("run {run} makes no scenario: {error}"), "change what it draws")
        })?;
        let scenario = Scenario::parse(path, &text).map_err(|error| refused(variation, &text, run, error))?;
        let value = |value| serde_json::to_value(value).unwrap_or_default();
        let values = drawn.into_iter().map(|(key, of)| (key, value(of))).collect();
        Ok((scenario.with_seed(seed_of_flight), values))
    }

    /// What each of some runs draws; every run's scenario is checked.
    ///
    /// # Errors
    /// Those of [`Self::member`], of the first run that has one.
    pub fn drawn(&self, seed: u64, runs: Range<u64>) -> Result<BTreeMap<u64, Values>, HostError> {
        runs.map(|run| Ok((run, self.member(seed, run)?.1))).collect()
    }
}

/// The fault of a scenario that a run drew, told of what it draws from.
fn refused(variation: &Variation, text: &str, run: u64, error: HostError) -> HostError {
    let HostError::Input(InputError { line, what, to_do, .. }) = &error else { return error };
    let key = line.and_then(|line| key_at(text, line)).filter(|key| variation.has(key));
    // The scenario's own message begins with the key.
    let what = key.as_ref().and_then(|key| what.strip_prefix(&format!("{key}: "))).unwrap_or(what);
    let word = key.as_deref().filter(|_| what.contains(IN_THE_PLACE_OF));
    if let Some((key, word)) = word.and_then(|key| Some((key, variation.no_distribution(key)?))) {
        return variation.fault(key, format!("{word} is no distribution"), vary::TO_DO);
    }
    variation.fault(key.as_deref().unwrap_or("scenario"), format!("{what} (run {run})"), to_do)
}

#[cfg(test)]
mod tests;
