//! The thesis's figures and tables, each by the project's own code beside the thesis's numbers.
//!
//! In: a [`Figure`] of the table [`figures`]. Out: [`Made`]: pictures, rows of ours beside the thesis's, and
//! where and why they differ. [`page`] makes a page of them; the command is
//! [`crate::commands::gallery`].
//!
//! | module | figures |
//! |---|---|
//! | [`centroids`] | noise and pixel errors of a star's centre (figs. 3.5, 3.8 to 3.10) |
//! | [`attitude`] | methods, numbers of stars, geometry, rate (tab. 3.9, fig. 4.5, eq. 3.28, 3.32) |
//! | [`horizon`], [`fits`] | the limb on the detector, circles and ellipses through it (figs. 3.26 to 3.28, eq. 3.33) |
//! | [`identification`] | its probability and time by tolerance (figs. 4.3, 4.4) |
//! | [`tracking`] | turning without an attitude (figs. 3.16, 7.10, 7.11) |
//! | [`point`], [`orbit`] | point solution, four days in GEO (figs. 6.2 to 6.5) |
//! | [`perturbations`] | forces by radius (fig. A.7) |
//! | [`low_orbit`] | the horizon by MITA's camera (fig. 7.13) |
//! | [`earth`] | the Earth in geostationary pictures (figs. 7.14 to 7.17) |
//! | [`accuracies`] | all accuracies together (tab. 7.4, 9.2) |
//! | [`seeds`] | none: medians and what 95 % of the seeds keep |
//! | [`turning_sky`] | none: the camera turning under the stars |
//! | [`outages`] | states of the sensor along six orbits (figs. 8.5 to 8.10) |
//!
//! What the thesis says stands as data ([`Told`]). Its text is a scan: curves are not in it, so that a figure
//! is held against the numbers that the text gives; what cannot be read is left out and named.

pub mod accuracies;
pub mod attitude;
pub mod centroids;
pub mod earth;
pub mod fits;
pub mod horizon;
pub mod identification;
pub mod low_orbit;
pub mod orbit;
pub mod outages;
pub mod page;
pub mod perturbations;
pub mod point;
pub mod seeds;
pub mod tracking;
pub mod turning_sky;

use crate::error::HostError;
use crate::report::chart::Chart;

/// Seed of all that is random here.
pub const SEED: u64 = 24;

/// A number of the thesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// What it is of.
    pub what: &'static str,
    /// It.
    pub value: f64,
    /// Its unit; empty of a number.
    pub unit: &'static str,
    /// Where it stands.
    pub place: &'static str,
}

impl Told {
    /// With its unit.
    pub fn words(&self) -> String {
        format!("{} {}", self.value, self.unit).trim_end().to_owned()
    }
}

/// A figure or table of the thesis.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Where the thesis speaks of it.
    pub place: &'static str,
    /// What the thesis says.
    pub thesis: &'static [Told],
    /// Makes ours.
    pub make: fn(&Figure) -> Result<Made, HostError>,
}

impl Figure {
    /// A row of the thesis's number `number`, ours beside it.
    pub fn row(&self, number: usize, ours: impl Into<String>) -> Row {
        let told = self.thesis[number];
        Row { what: told.what.into(), ours: ours.into(), thesis: Some(told) }
    }
}

/// A row of a figure's table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Of what.
    pub what: String,
    /// Ours, with its unit.
    pub ours: String,
    /// The thesis's; none where it gives no number that can be read.
    pub thesis: Option<Told>,
}

impl Row {
    /// Without a number of the thesis.
    pub fn alone(what: impl Into<String>, ours: impl Into<String>) -> Self {
        Self { what: what.into(), ours: ours.into(), thesis: None }
    }
}

/// What became of a figure.
#[derive(Clone, Debug, Default)]
pub struct Made {
    /// SVG files; the first has the figure's name, others its name and their number.
    pub pictures: Vec<String>,
    /// Ours beside the thesis's.
    pub rows: Vec<Row>,
    /// Where ours differs, and why.
    pub verdict: String,
}

impl Made {
    /// Of charts.
    pub fn new(charts: &[Chart], rows: Vec<Row>, verdict: impl Into<String>) -> Self {
        Self { pictures: charts.iter().map(Chart::svg).collect(), rows, verdict: verdict.into() }
    }
}

/// All figures, by subject.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    let rooms = [
        centroids::FIGURES,
        attitude::FIGURES,
        identification::FIGURES,
        tracking::FIGURES,
        horizon::FIGURES,
        low_orbit::FIGURES,
        earth::FIGURES,
        point::FIGURES,
        orbit::FIGURES,
        perturbations::FIGURES,
        outages::FIGURES,
        accuracies::FIGURES,
    ];
    rooms.into_iter().flatten()
}

/// The number of a value with so many digits that count.
pub(crate) fn digits(value: f64, count: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let decimals = (count - 1 - value.abs().log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests;
