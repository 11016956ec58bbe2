//! Flights of several families with the same seeds, so that their rows differ by what the families do.
//!
//! A row is a scenario with a name for what the flight code believes in it. All rows of a scenario fly run
//! `i` before any flies `i + 1`: a campaign that is stopped has done the same runs of each.

use super::Experiment;
use super::family::{Family, Values};
use super::flights::{self, Flown};
use crate::cli::CommonArguments;
use crate::error::HostError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A flight of a row.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Flight {
    /// The row's name: what the flight code is told.
    pub differences: String,
    /// The flight.
    #[serde(flatten)]
    pub flown: Flown,
}

/// The rows, and what is flown for them.
#[derive(Debug)]
pub struct Variants {
    name: String,
    seed: u64,
    /// Name and scenarios of each.
    pub rows: Vec<(String, Family)>,
    /// Rows and runs in the order in which they are flown.
    order: Vec<(usize, u64)>,
    /// What they draw.
    drawn: BTreeMap<(usize, u64), Values>,
}

impl Variants {
    /// So many runs of each row; every scenario is checked before any is flown.
    ///
    /// # Errors
    /// When what a run draws makes no scenario.
    pub fn new(
        name: &str,
        rows: Vec<(String, Family)>,
        (common, runs): (&CommonArguments, u64),
    ) -> Result<Self, HostError> {
        let mut order = Vec::new();
        let numbered: Vec<usize> = (0..rows.len()).collect();
        for scenario in numbered.chunk_by(|one, other| rows[*one].1.base.name == rows[*other].1.base.name) {
            order.extend(common.numbers(runs).flat_map(|run| scenario.iter().map(move |row| (*row, run))));
        }
        let draw = |(row, run): &(usize, u64)| Ok(((*row, *run), rows[*row].1.member(common.seed, *run)?.1));
        let drawn = order.iter().map(draw).collect::<Result<_, HostError>>()?;
        Ok(Self { name: name.to_owned(), seed: common.seed, rows, order, drawn })
    }

    /// The row of a flight, if it is one of these.
    fn row_of(&self, flight: &Flight) -> Option<usize> {
        let named = |(differences, family): &(String, Family)| {
            *differences == flight.differences && family.base.name == flight.flown.scenario
        };
        self.rows.iter().position(named)
    }

    /// The flights by row.
    pub fn by_row(&self, flights: Vec<Flight>) -> Vec<Vec<Flown>> {
        let mut rows = vec![Vec::new(); self.rows.len()];
        for flight in flights {
            if let Some(row) = self.row_of(&flight) {
                rows[row].push(flight.flown);
            }
        }
        rows
    }
}

impl Experiment for Variants {
    /// Row and run.
    type Key = (usize, u64);
    type Run = Flight;
    type Workspace = ();

    fn name(&self) -> &str {
        &self.name
    }

    fn keys(&self) -> Vec<(usize, u64)> {
        self.order.clone()
    }

    fn key_of(&self, flight: &Flight) -> Option<(usize, u64)> {
        let key = (self.row_of(flight)?, flight.flown.run);
        let ours = flight.flown.seed == self.seed && self.drawn.get(&key) == Some(&flight.flown.drawn);
        ours.then_some(key)
    }

    fn workspace(&self) {}

    fn fly(&self, (): &mut (), (row, run): &(usize, u64)) -> Result<Flight, HostError> {
        let (differences, family) = &self.rows[*row];
        let flown = flights::fly(family, self.seed, *run)?;
        Ok(Flight { differences: differences.clone(), flown })
    }
}
