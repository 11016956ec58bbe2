//! What is to be said of a run first: whether it is right, in a badge and a sentence.

use super::figures_table;
use super::scale::label;
use crate::judge::quantities::{QUANTITIES, Quantity};
use crate::judge::series::SigmaFit;
use crate::judge::{Figures, Verdict};

/// A mean NIS less probable than this contradicts the filter's sigmas.
const NIS_IMPROBABLE: f64 = 0.01;
/// Mean NIS of a degree of freedom.
const NIS_EXPECTED: f64 = 1.0;
/// Most of what misses that a sentence names.
const NAMED: usize = 5;

/// A run in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// Every limit is kept, and every figure is as it should be.
    Right,
    /// No limit is missed, but a figure contradicts itself, or nothing was demanded.
    Doubtful,
    /// A limit is missed.
    Missed,
}

impl Grade {
    /// Its class in the pages' style: `good`, `doubt` or `bad`.
    pub fn class(self) -> &'static str {
        match self {
            Self::Right => "good",
            Self::Doubtful => "doubt",
            Self::Missed => "bad",
        }
    }
}

/// What is to be said first.
#[derive(Clone, Debug, PartialEq)]
pub struct Opinion {
    /// In a word.
    pub grade: Grade,
    /// In a few words.
    pub badge: String,
    /// In a clause: whether it is right.
    pub verdict: String,
    /// The first of what is not right; empty where all is.
    pub wrong: String,
    /// What was reached.
    pub reached: String,
}

fn number(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}

/// The first few of `names`, and how many more there are.
fn named(names: &[String]) -> String {
    let first = names[..names.len().min(NAMED)].join("; ");
    match names.len().saturating_sub(NAMED) {
        0 => first,
        more => format!("{first}; and {more} more"),
    }
}

/// How the sigmas of a quantity are wrong; `None` where they are not.
fn contradiction(quantity: &Quantity, figures: &Figures) -> Option<String> {
    match figures.run(quantity.key)?.sigma_fit() {
        SigmaFit::Right => None,
        SigmaFit::TooLarge => Some(format!("{}: sigmas too large", quantity.words)),
        SigmaFit::TooSmall => Some(format!("{}: sigmas too small", quantity.words)),
    }
}

/// How the innovations of the orbit filter stand to its sigmas.
fn nis(figures: &Figures) -> String {
    let larger = figures.orbit.nis_mean.is_some_and(|mean| mean > NIS_EXPECTED);
    format!("innovations {} than their sigmas", if larger { "larger" } else { "smaller" })
}

/// Figures that contradict themselves, whether or not a limit is set on them.
pub fn contradictions(figures: &Figures) -> Vec<String> {
    let quantities = QUANTITIES.iter().filter_map(|quantity| contradiction(quantity, figures));
    let improbable = figures.orbit.nis_consistency.filter(|probability| *probability < NIS_IMPROBABLE);
    let not_finite = (figures.not_finite > 0).then(|| format!("{} s with no number", figures.not_finite));
    quantities.chain(improbable.map(|_| nis(figures))).chain(not_finite).collect()
}

/// What a missed limit says, in a clause.
fn missed(verdict: &Verdict, figures: &Figures) -> String {
    let of = verdict.limit.strip_suffix("_consistency");
    let quantity = QUANTITIES.iter().find(|quantity| Some(quantity.key) == of);
    let contradiction = quantity.and_then(|quantity| contradiction(quantity, figures));
    match verdict.limit {
        "nis_consistency" if figures.orbit.nis_mean.is_some() => nis(figures),
        _ => contradiction.unwrap_or_else(|| figures_table::verdict(verdict)[0].clone()),
    }
}

impl Opinion {
    /// Of a run's figures and limits.
    pub fn of(figures: &Figures, verdicts: &[Verdict]) -> Self {
        let missed: Vec<String> =
            verdicts.iter().filter(|verdict| !verdict.kept).map(|verdict| missed(verdict, figures)).collect();
        let contradictions = contradictions(figures);
        let doubts = number(contradictions.len(), "figure is not right", "figures are not right");
        let limits = number(verdicts.len(), "limit", "limits");
        let (grade, badge, verdict, wrong) = match (verdicts.is_empty(), missed.len(), contradictions.len()) {
            (_, 1.., _) => (
                Grade::Missed,
                number(missed.len(), "limit missed", "limits missed"),
                format!("NOT right: {} of {limits} MISSED", missed.len()),
                missed,
            ),
            (true, ..) => (
                Grade::Doubtful,
                "no limits set".to_owned(),
                match contradictions.len() {
                    0 => "No limits were set; the reported sigmas are as the errors".to_owned(),
                    _ => format!("No limits were set; {doubts}"),
                },
                contradictions,
            ),
            (false, _, 0) => (
                Grade::Right,
                "all right".to_owned(),
                "Right: all limits are kept, and the reported sigmas are as the errors".to_owned(),
                contradictions,
            ),
            (false, ..) => (
                Grade::Doubtful,
                format!("limits kept, {doubts}"),
                format!("All limits are kept, but {doubts}"),
                contradictions,
            ),
        };
        Self { grade, badge, verdict, wrong: named(&wrong), reached: reached(figures) }
    }

    /// In a sentence: whether it is right, and what is not.
    pub fn sentence(&self) -> String {
        let Self { verdict, wrong, .. } = self;
        if wrong.is_empty() { format!("{verdict}.") } else { format!("{verdict} \u{2013} {wrong}.") }
    }
}

/// Attitude and position in a sentence.
fn reached(figures: &Figures) -> String {
    let rms = |key: &str| Some(figures.last_orbit(key).or(figures.run(key))?.rms);
    let attitude = match (figures.attitude.rms_arcsec, rms("rate")) {
        (Some(rms), _) => format!("attitude {} arcsec about x, y, z", rms.map(label).join(", ")),
        (None, Some(rate)) => format!("no attitude, rate {} deg/s", label(rate)),
        (None, None) => "no attitude".to_owned(),
    };
    let position = rms("position")
        .map_or_else(|| "no orbit".to_owned(), |rms| format!("position {} km (last orbit)", label(rms)));
    format!("Reached, rms: {attitude}; {position}.")
}

/// A time in words.
pub fn duration(seconds: u32) -> String {
    let parts = [(seconds / 3600, "h"), (seconds / 60 % 60, "min"), (seconds % 60, "s")];
    let parts: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, unit)| format!("{count} {unit}")).collect();
    parts.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::Limit;
    use crate::judge::figures::QuantityFigures;
    use crate::judge::series::Statistics;
    use crate::judge::table;

    fn figures(normalised_square: f64) -> Figures {
        let run = Statistics { normalised_square, band_99: [0.5, 2.0], ..Statistics::default() };
        let of = QuantityFigures { unit: "km", run: Some(run), last_orbit: None };
        let quantities = std::iter::once(("position", of)).collect();
        Figures { mode_share: Some(0.97), quantities, ..Figures::default() }
    }

    fn opinion(normalised_square: f64, demanded: Option<f64>) -> Opinion {
        let figures = figures(normalised_square);
        let of = table::figure("mode_share").unwrap();
        let limits: Vec<Limit> = demanded.map(|value| Limit { of, value }).into_iter().collect();
        Opinion::of(&figures, &Verdict::all(&limits, &figures))
    }

    #[test]
    fn only_a_run_whose_limits_and_figures_are_right_is_called_right() {
        assert_eq!(opinion(1.0, Some(0.9)).grade, Grade::Right);
        let doubtful = opinion(0.002, Some(0.9));
        assert_eq!(doubtful.grade, Grade::Doubtful);
        assert_eq!(doubtful.wrong, "Position: sigmas too large");
        assert_eq!(doubtful.badge, "limits kept, 1 figure is not right");
        assert_eq!(opinion(1.0, None).grade, Grade::Doubtful);
    }

    #[test]
    fn what_misses_is_named() {
        let missed = opinion(1.0, Some(0.99));
        assert_eq!((missed.grade, missed.badge.as_str()), (Grade::Missed, "1 limit missed"));
        assert!(missed.sentence().contains("1 of 2 limits MISSED \u{2013} mode as the geometry says"));
        let many: Vec<String> = (0..9).map(|n| n.to_string()).collect();
        assert_eq!(named(&many), "0; 1; 2; 3; 4; and 4 more");
    }

    #[test]
    fn a_missed_consistency_says_how_the_sigmas_are_wrong() {
        let mut figures = figures(0.002);
        (figures.orbit.nis_mean, figures.orbit.nis_consistency) = (Some(0.1), Some(1e-9));
        let limit = |key| Limit { of: table::figure(key).unwrap(), value: 0.01 };
        let limits = [limit("position_consistency"), limit("nis_consistency"), limit("velocity_consistency")];
        let opinion = Opinion::of(&figures, &Verdict::all(&limits, &figures));
        assert_eq!(
            opinion.wrong,
            "Position: sigmas too large; innovations smaller than their sigmas; velocity: sigmas by NEES, probability"
        );
    }

    #[test]
    fn times_are_words() {
        assert_eq!((duration(21_600), duration(3_725)), ("6 h".into(), "1 h 2 min 5 s".into()));
    }
}
