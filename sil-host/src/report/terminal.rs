//! The summary of a run on a terminal: what misses first, in lines that end between words.

use super::figures_table::{self, Line, QuantityRow};
use super::opinion::{Grade, Opinion, duration};
use crate::judge::series::SigmaFit;
use crate::judge::{Figures, Verdict};
use crate::scenario::Scenario;
use console::style;
use std::path::Path;
use textwrap::{Options, WordSeparator, WordSplitter, fill};

/// Widths between which lines are made; one that is not known counts as [`WIDTH`].
const WIDTHS: (usize, usize) = (60, 132);
/// Where standard output is no terminal.
const WIDTH: usize = 100;
/// From this width on there is room for one more column.
const ROOMY: usize = 92;
/// Width of what a line is about.
const WHAT: usize = 34;

/// Width of the terminal, characters.
pub fn width() -> usize {
    let columns = console::Term::stdout().size_checked().map_or(WIDTH, |(_, columns)| usize::from(columns));
    columns.clamp(WIDTHS.0, WIDTHS.1)
}

/// `text` in lines of `width` that end between words, the first led by `first`, the others by `rest`.
fn wrapped(text: &str, width: usize, first: &str, rest: &str) -> String {
    let options = Options::new(width)
        .break_words(false)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation)
        .initial_indent(first)
        .subsequent_indent(rest);
    fill(text, options) + "\n"
}

/// What was reached, for people, in lines of `width` characters.
pub fn summary(
    scenario: &Scenario,
    figures: &Figures,
    verdicts: &[Verdict],
    (folder, took_s): (&Path, f64),
    width: usize,
) -> String {
    let opinion = Opinion::of(figures, verdicts);
    let mut text = wrapped(&format!("{}: {}", scenario.name, scenario.description), width, "", "  ");
    let flown = format!(
        "{} from {} UTC, seed {}, flown in {took_s:.1} s ({:.0} times real time)",
        duration(scenario.duration_s),
        scenario.start_utc,
        scenario.seed,
        f64::from(scenario.duration_s) / took_s
    );
    text += &wrapped(&flown, width, "", "  ");
    text.push('\n');
    // What misses follows, a line each.
    let sentence = match opinion.grade {
        Grade::Missed => format!("{}.", opinion.verdict),
        Grade::Right | Grade::Doubtful => opinion.sentence(),
    };
    let sentence = wrapped(&sentence, width, "", "  ");
    let sentence = sentence.trim_end();
    text += &match opinion.grade {
        Grade::Right => format!("{}\n", style(sentence).green()),
        Grade::Doubtful => format!("{}\n", style(sentence).yellow()),
        Grade::Missed => format!("{}\n", style(sentence).red().bold()),
    };
    text += &wrapped(&opinion.reached, width, "", "  ");
    text += &limits(verdicts, width);
    text += &quantities(&figures_table::quantities(figures), width);
    text.push('\n');
    for line in figures_table::lines(figures) {
        text += &reached(&line, width);
    }
    let page = folder.join("report.html").display().to_string();
    // A path is one word, whatever is in it.
    text + &format!("\nReport: {page}")
}

/// The limits, those that miss first.
fn limits(verdicts: &[Verdict], width: usize) -> String {
    let mut text = if verdicts.is_empty() { String::new() } else { "\n".to_owned() };
    for verdict in figures_table::missed_first(verdicts) {
        let [what, demanded, reached] = figures_table::verdict(verdict);
        let line =
            wrapped(&format!("{what}: {reached} (limit {demanded})"), width, "  MISSED  ", "          ");
        text += &match verdict.kept {
            true => line.replacen("MISSED", &style("kept  ").green().to_string(), 1),
            false => line.replacen("MISSED", &style("MISSED").red().bold().to_string(), 1),
        };
    }
    text
}

/// A row a quantity under a row of titles.
fn quantities(rows: &[QuantityRow], width: usize) -> String {
    let roomy = width >= ROOMY;
    let line = |cells: [&str; 7], word: &str| {
        let [what, rms, error_95, sigma, unit, within, square] = cells;
        let within = if roomy { format!(" {within:>9}") } else { String::new() };
        format!("  {what:28} {rms:>7} {error_95:>7} {sigma:>7} {unit:6}{within} {square:>7} {word}\n")
    };
    let titles = ["Error of the last orbit", "rms", "95 %", "sigma", "", "in 3 sig.", "(e/s)\u{b2}"];
    let mut text = format!("\n{}", line(titles, "sigmas"));
    for row in rows {
        let cells = [row.what, &row.rms, &row.error_95, &row.sigma, row.unit, &row.within, &row.square];
        let word = match row.fit {
            SigmaFit::Right => style(row.word()).green(),
            _ => style(row.word()).red(),
        };
        text += &line(cells, &word.to_string());
    }
    text
}

/// A figure and what is beside it.
fn reached(line: &Line, width: usize) -> String {
    let rest = " ".repeat(WHAT + 3);
    let first = format!("  {:WHAT$} ", line.what);
    let text = wrapped(&line.reached, width, &first, &rest);
    if line.beside.is_empty() { text } else { text + &wrapped(&line.beside, width, &rest, &rest) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::figures::QuantityFigures;
    use crate::judge::quantities::QUANTITIES;
    use crate::judge::series::Statistics;

    fn summary_of(width: usize) -> String {
        let scenario = Scenario::default_embedded();
        let mut figures = Figures::default();
        for quantity in &QUANTITIES {
            let run = Statistics {
                rms: 0.003_714,
                error_95: 123_456.7,
                sigma: 1776.4,
                band_99: [0.298, 2.21],
                normalised_square: 0.000_07,
                ..Statistics::default()
            };
            let of = QuantityFigures { unit: quantity.unit, run: Some(run), last_orbit: None };
            figures.quantities.insert(quantity.key, of);
        }
        figures.attitude.rms_arcsec = Some([0.545, 0.527, 3.96]);
        let verdicts = Verdict::all(&scenario.limits, &figures);
        console::strip_ansi_codes(&summary(&scenario, &figures, &verdicts, (Path::new("out"), 44.1), width))
            .into_owned()
    }

    #[test]
    fn lines_fit_the_terminal_and_end_between_words() {
        let whole = summary_of(10_000);
        let whole: Vec<&str> = whole.split_whitespace().collect();
        for width in [60, 80, 92, 100, 132] {
            let text = summary_of(width);
            // The table of quantities is as wide as its columns.
            let widest = text.lines().map(textwrap::core::display_width).max().unwrap_or(0);
            assert!(widest <= width.max(80), "{widest} at {width}:\n{text}");
            let cut: Vec<&str> = text.split_whitespace().filter(|word| !whole.contains(word)).collect();
            assert!(cut.is_empty(), "{cut:?} at {width}");
        }
    }

    #[test]
    fn what_misses_is_said_first() {
        let text = summary_of(100);
        let missed = text.find("  MISSED  ").unwrap();
        let kept = text.find("  kept    ").unwrap();
        assert!(text.find("NOT right").unwrap() < missed && missed < kept, "{text}");
        assert!(kept > text.rfind("  MISSED  ").unwrap());
        assert!(kept < text.find("Error of the last orbit").unwrap());
        assert_eq!(text.lines().last(), Some("Report: out/report.html"));
    }
}
