//! The page of `campaign scenarios`, in Markdown.

use super::{Part, Row};
use crate::campaign::flights::{self, Flown};
use crate::judge::table::{self, Side};
use crate::report::figures_table;
use crate::version;
use crate::world::time::civil_time;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::time::{SystemTime, UNIX_EPOCH};

/// 2000-01-01T12:00:00 UTC, s since 1970.
const NOON_2000_S: i64 = 946_728_000;

const HEAD: &str = "\
| figure | limit | median (95 % interval) | 95 % of flights keep (95 % interval) | limit kept | told the truth: median | 95 % keep | limit kept |
|---|---|---|---|---|---|---|---|
";

/// Today, UTC.
fn today() -> String {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
    let shown_us = (since_1970 as i64 - NOON_2000_S).saturating_mul(1_000_000);
    civil_time::shown_text(shown_us).chars().take("YYYY-MM-DD".len()).collect()
}

/// The numbers of runs of a row, those that follow each other as from-to.
fn numbers(flown: &[Flown]) -> String {
    let mut spans: Vec<(u64, u64)> = Vec::new();
    for run in flown.iter().map(|flown| flown.run) {
        match spans.last_mut() {
            Some((_, last)) if last.checked_add(1) == Some(run) => *last = run,
            _ => spans.push((run, run)),
        }
    }
    let span = |(first, last): &(u64, u64)| match first == last {
        true => first.to_string(),
        false => format!("{first}\u{2013}{last}"),
    };
    if spans.is_empty() { "none".to_owned() } else { spans.iter().map(span).collect::<Vec<_>>().join(", ") }
}

/// Median and quantile of a figure, each with its interval if `intervals`.
fn values(row: Option<&flights::Row>, intervals: bool) -> [String; 2] {
    let Some(row) = row else { return ["\u{2013}".to_owned(), "\u{2013}".to_owned()] };
    let show = |value: f64| figures_table::value(Some(value), row.unit);
    let spread = &row.spread;
    let [median, quantile] = [spread.median, spread.kept_by_95_percent].map(show);
    if !intervals {
        return [median, quantile];
    }
    let ends = |interval: [Option<f64>; 2]| interval.map(|end| end.map_or("?".to_owned(), show));
    let [low, high] = ends(spread.median_interval);
    let [better, worse] = ends(spread.kept_interval);
    [format!("{median} ({low} to {high})"), format!("{quantile} ({better} to {worse})")]
}

/// How many of the flights kept the limit.
fn kept(limited: bool, missed: usize, flights: usize) -> String {
    match missed {
        _ if !limited || flights == 0 => String::new(),
        0 => format!("all {flights}"),
        _ => format!("{} of {flights}, **MISSED**", flights - missed),
    }
}

fn line(row: &Row, flights: [usize; 2]) -> String {
    let Some(figure) = table::figure(row.figure) else { return String::new() };
    let side = match figure.side {
        Side::AtLeast => "\u{2265}",
        Side::AtMost => "\u{2264}",
    };
    let shown = |limit| format!("{side} {}", figures_table::value(Some(limit), figure.unit));
    let limit = row.limit.map(shown).unwrap_or_default();
    let kept = [0, 1].map(|of| kept(row.limit.is_some(), row.missed[of], flights[of]));
    let [median, quantile] = values(row.drawn.as_ref(), true);
    let [median_told, quantile_told] = values(row.none.as_ref(), false);
    let [kept, kept_told] = kept;
    let words = figure.words;
    format!(
        "| {words} | {limit} | {median} | {quantile} | {kept} | {median_told} | {quantile_told} | {kept_told} |\n"
    )
}

/// The page.
pub(super) fn text(parts: &[Part<'_>], command: &str, seed: u64) -> String {
    let all = || parts.iter().flat_map(|part| part.flown.iter().flatten());
    let programs: BTreeSet<&str> = all().map(|flown| flown.program.as_str()).collect();
    let programs: Vec<&str> = programs.into_iter().map(|of| if of.is_empty() { "?" } else { of }).collect();
    let mixed = match all().filter(|flown| flown.program != version::words()).count() {
        0 => String::new(),
        others => format!(" **{others} of them were not flown by the program that made this page.**"),
    };
    let mut page = format!(
        "# Figures of the scenarios\n\n\
         Made on {} by `{command}` from {} flights of Sextant {}.{mixed}\n\n\
         Flown twice with the same seeds: with differences of belief, those drawn for each flight and the scenario's own, \
         and told the truth; its sigmas allow for the differences either way, so that told the truth they are larger than its errors. \
         A limit is MISSED where a flight missed it; figures are over the run where nothing else is said. \
         The 95 % quantile's interval has no worse end (?) below 72 flights. A probability: NEES or NIS of a flight with right \
         sigmas is as far from its mean, or farther, with this probability; one flight in a hundred with right sigmas \
         falls below 0.01.\n",
        today(),
        all().count(),
        programs.join(", "),
    );
    for part in parts {
        let rows = part.rows();
        let missed = rows.iter().filter(|row| row.missed[0] > 0).count();
        let limits = rows.iter().filter(|row| row.limit.is_some()).count();
        let verdict = match (limits, missed) {
            (0, _) => "No limits.".to_owned(),
            (_, 0) => format!("All {limits} limits kept in every flight."),
            _ => format!("**MISSED: {missed} of {limits} limits.**"),
        };
        let [drawn, none] = part.flown.each_ref().map(|flown| numbers(flown));
        let _ = write!(
            page,
            "\n## {}\n\n{}. Seed {seed}, runs {drawn}; told the truth: {none}. {verdict}\n\n{HEAD}",
            part.scenario.name, part.scenario.description
        );
        let flights = part.flown.each_ref().map(Vec::len);
        page.extend(rows.iter().map(|row| line(row, flights)));
    }
    page
}
