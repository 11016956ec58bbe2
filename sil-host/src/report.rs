//! `report.html`: a run on one page that needs nothing else; and its summary on a terminal.
//!
//! | module | takes | gives |
//! |---|---|---|
//! | [`recorder`] | seconds | what the page needs of them, in constant memory |
//! | [`trace`] | values, second by second | curves of constant length that keep every spike |
//! | [`scale`] | how large a curve's values are | heights and ticks |
//! | [`panel`] | a curve | its scale, and what it cannot show |
//! | [`plot`], [`strip`] | panels; modes | inline SVG over the time of the run |
//! | [`chart`] | curves of one quantity over another | SVG files that stand alone |
//! | [`standing_alone`] | a drawing for a page | an SVG file |
//! | [`histogram`] | errors and sigmas | inline SVG: how far the sigmas are right |
//! | [`orbit_view`] | the truth | inline SVG: orbit, Earth, shadow, Sun |
//! | [`moments`] | seconds | the few worth a picture |
//! | [`frames`] | such a second | the frame with what was found on it |
//! | [`opinion`] | figures and limits | what is to be said first |
//! | [`figures_table`] | the judge's figures | lines for page and terminal |
//! | [`page`] | all of these | the page |
//! | [`terminal`] | figures and limits | the summary in lines of a given width |
//!
//! No scripts, no fonts, no links to elsewhere; colours follow the reader's light or dark. Nothing in it
//! depends on the time of day, so that equal runs give equal files.

pub mod chart;
pub mod figures_table;
pub mod frames;
pub mod glossary;
pub mod histogram;
pub mod moments;
pub mod opinion;
pub mod orbit_view;
pub mod page;
pub mod panel;
pub mod plot;
pub mod recorder;
pub mod scale;
pub mod standing_alone;
pub mod strip;
pub mod terminal;
pub mod trace;

pub use recorder::Recorder;

#[cfg(test)]
mod tests;
