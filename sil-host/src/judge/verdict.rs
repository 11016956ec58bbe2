//! A run's figures held against the limits that its scenario sets.

use super::figures::Figures;
use super::table::{self, Figure, Side};
use serde::Serialize;

/// A limit of a scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The figure.
    pub of: &'static Figure,
    /// Its value, in the figure's unit.
    pub value: f64,
}

/// A limit, held against the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The figure's key.
    pub limit: &'static str,
    /// The side on which it is kept.
    pub side: Side,
    /// What was demanded.
    pub demanded: f64,
    /// What was reached; none where the run did not yield the figure.
    pub reached: Option<f64>,
    /// Whether the limit is kept.
    pub kept: bool,
}

impl Verdict {
    /// Holds a limit against the figures.
    pub fn new(limit: &Limit, figures: &Figures) -> Self {
        let reached = (limit.of.of)(figures);
        let kept = reached.is_some_and(|reached| match limit.of.side {
            Side::AtLeast => reached >= limit.value,
            Side::AtMost => reached <= limit.value,
        });
        Self { limit: limit.of.key, side: limit.of.side, demanded: limit.value, reached, kept }
    }

    /// Holds a scenario's limits against the figures; that every number be finite is demanded of every run.
    pub fn all(limits: &[Limit], figures: &Figures) -> Vec<Self> {
        let demanded = Limit { of: &table::NOT_FINITE, value: 0.0 };
        let limited = !limits.is_empty() || figures.not_finite > 0;
        let own = limited.then_some(demanded);
        limits.iter().chain(&own).map(|limit| Self::new(limit, figures)).collect()
    }
}
