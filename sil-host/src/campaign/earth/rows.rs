//! The table of `campaign earth`.
//!
//! In: runs. Out: a [`Row`] for every case and way, and a [`Noon`] for every way.
//!
//! NEES is that of the centre in three dimensions, divided by its three degrees of freedom: one where the
//! covariance is right, less where it is cautious. Its band holds the mean of so many independent frames with
//! 95 %. The step at noon is what the centre moves by when the lit side changes: twice the mean error towards
//! the Sun in the geostationary cases up to 100 deg of phase (thesis fig. 7.16).

use super::Run;
use super::cases::{CASES, Case};
use super::seen::{Fix, Seen, WAYS, Way};
use serde::Serialize;
use std::collections::BTreeMap;

/// The step that is asked for, deg.
const STEP_GOAL_DEG: f64 = 0.01;
/// Where the goal lies below what any method could reach, so many times that is asked.
const OVER_LIMIT: f64 = 1.5;
/// A row's NEES is too great beyond so many of its sigmas: by chance one of two thousand rows, and some
/// thirty are judged at once.
const NEES_SIGMAS: f64 = 3.3;
/// Phases up to which the geostationary cases count for it, deg.
const STEP_PHASE_DEG: f64 = 100.0;

/// What a way came to in a case.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The case.
    pub case: &'static str,
    /// The way.
    pub way: Way,
    /// Frames.
    pub frames: usize,
    /// Those with a centre, %.
    pub found_percent: f64,
    /// Why the others have none.
    pub refused: BTreeMap<String, usize>,
    /// Root mean square error of the direction towards the Sun and across, deg.
    pub rms_deg: [f64; 2],
    /// Median of its size, deg.
    pub median_deg: [f64; 2],
    /// Its mean, deg.
    pub mean_deg: [f64; 2],
    /// Root mean square of its sigma, deg.
    pub sigma_deg: Option<[f64; 2]>,
    /// Root mean square error with the distance known, deg.
    pub known_distance_rms_deg: Option<[f64; 2]>,
    /// Root mean square error of the limb's half angle, deg.
    pub radius_rms_deg: f64,
    /// Root mean square error of the distance, km.
    pub distance_rms_km: f64,
    /// Median arc, deg.
    pub arc_deg: Option<f64>,
    /// Normalised error squared, mean, over its degrees of freedom.
    pub nees: Option<f64>,
    /// Its band.
    pub nees_band: Option<[f64; 2]>,
    /// Frames with direction and distance within three sigma, %.
    pub within_3_sigma_percent: Option<f64>,
    /// Root mean square error of the position made with the stars' attitude, of an axis across the line to
    /// the centre and along it, km.
    pub position_rms_km: Option<[f64; 2]>,
    /// Root mean square of its sigma, km.
    pub position_sigma_km: Option<[f64; 2]>,
    /// Root mean square of the share by which the focal length seems wrong, the orbit's distance known, and
    /// of its sigma.
    pub focal_length: Option<[f64; 2]>,
    /// Root mean square of the least sigma of the direction that any way could have in these frames, deg
    /// ([`limit`](super::limit)).
    pub limit_deg: Option<[f64; 2]>,
    /// What is asked of the direction, deg.
    pub goal_deg: Option<f64>,
    /// Whether that, or one and a half times what is possible at best, is kept, and the covariance not too
    /// small; none where nothing is asked.
    pub kept: Option<bool>,
}

/// What a way's centre does at noon.
#[derive(Clone, Debug, Serialize)]
pub struct Noon {
    /// The way.
    pub way: Way,
    /// Step, deg.
    pub step_deg: f64,
    /// Its standard error, deg.
    pub step_sigma_deg: f64,
    /// What is asked, deg.
    pub goal_deg: f64,
}

/// All of it.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// By case and way.
    pub rows: Vec<Row>,
    /// By way.
    pub noons: Vec<Noon>,
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / f64::max(count, 1.0)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// All of them, where every one is known and there are any.
fn all<T>(fixes: &[&Fix], part: impl Fn(&Fix) -> Option<T>) -> Option<Vec<T>> {
    let parts: Option<Vec<T>> = fixes.iter().map(|fix| part(fix)).collect();
    parts.filter(|parts| !parts.is_empty())
}

impl Row {
    fn of(case: &Case, way: Way, seen: &[&Seen], limit_deg: Option<[f64; 2]>) -> Self {
        let fixes: Vec<&Fix> = seen.iter().filter_map(|seen| seen.fix.as_ref()).collect();
        let mut refused = BTreeMap::new();
        for reason in seen.iter().filter_map(|seen| seen.refused.clone()) {
            *refused.entry(reason).or_insert(0) += 1;
        }
        let axes = |of: fn(&mut dyn Iterator<Item = f64>) -> f64| {
            [0, 1].map(|axis| of(&mut fixes.iter().map(|fix| fix.error_deg[axis])))
        };
        let both = |pairs: Vec<[f64; 2]>| [0, 1].map(|axis| rms(pairs.iter().map(|pair| pair[axis])));
        let count = fixes.len() as f64;
        let nees = all(&fixes, |fix| fix.nees).map(|values| mean(values.into_iter()) / 3.0);
        let nees_sigma = (2.0 / (3.0 * count.max(1.0))).sqrt();
        let half_band = 1.96 * nees_sigma;
        let within = all(&fixes, |fix| {
            let (sigma, distance_sigma) = (fix.sigma_deg?, fix.distance_sigma_km?);
            let across = fix.error_deg.iter().zip(sigma).all(|(error, sigma)| error.abs() <= 3.0 * sigma);
            Some(across && fix.distance_error_km.abs() <= 3.0 * distance_sigma)
        });
        let rms_deg = axes(|values| rms(values));
        let goal_deg = case.goal_deg.filter(|_| way.has_goal());
        Self {
            case: case.name,
            way,
            frames: seen.len(),
            found_percent: 100.0 * count / (seen.len() as f64).max(1.0),
            refused,
            rms_deg,
            median_deg: axes(|values| median(values.map(f64::abs))),
            mean_deg: axes(|values| mean(values)),
            sigma_deg: all(&fixes, |fix| fix.sigma_deg).map(both),
            known_distance_rms_deg: all(&fixes, |fix| fix.known_distance_error_deg).map(both),
            radius_rms_deg: rms(fixes.iter().map(|fix| fix.radius_error_deg)),
            distance_rms_km: rms(fixes.iter().map(|fix| fix.distance_error_km)),
            arc_deg: all(&fixes, |fix| fix.arc_deg).map(|values| median(values.into_iter())),
            nees,
            nees_band: nees.map(|_| [1.0 - half_band, 1.0 + half_band]),
            within_3_sigma_percent: within
                .map(|within| 100.0 * within.iter().filter(|within| **within).count() as f64 / count),
            position_rms_km: all(&fixes, |fix| fix.position_km).map(both),
            position_sigma_km: all(&fixes, |fix| fix.position_sigma_km).map(both),
            focal_length: all(&fixes, |fix| fix.focal_length).map(both),
            limit_deg,
            goal_deg,
            kept: goal_deg.map(|goal| {
                count > 0.0
                    && rms_deg
                        .iter()
                        .zip(limit_deg.unwrap_or_default())
                        .all(|(rms, limit)| *rms <= goal.max(OVER_LIMIT * limit))
                    && nees.is_some_and(|nees| nees <= 1.0 + NEES_SIGMAS * nees_sigma)
            }),
        }
    }

    fn line(&self) -> String {
        let pair = |pair: [f64; 2]| format!("{:.4} {:.4}", pair[0], pair[1]);
        let optional = |value: Option<String>| value.unwrap_or_else(|| "-".into());
        let refused: Vec<String> =
            self.refused.iter().map(|(reason, count)| format!("{count} {reason}")).collect();
        format!(
            "  {:<12}{:>6.1}{:>16}{:>16}{:>16}{:>16}{:>16}{:>9.4}{:>10.1}{:>6}{:>7}{:>13}{:>7}{:>8}  {}",
            format!("{:?}", self.way).to_lowercase(),
            self.found_percent,
            pair(self.rms_deg),
            pair(self.median_deg),
            pair(self.mean_deg),
            optional(self.sigma_deg.map(pair)),
            optional(self.known_distance_rms_deg.map(pair)),
            self.radius_rms_deg,
            self.distance_rms_km,
            optional(self.arc_deg.map(|arc| format!("{arc:.0}"))),
            optional(self.nees.map(|nees| format!("{nees:.2}"))),
            optional(self.nees_band.map(|[low, high]| format!("{:.2} to {high:.2}", low.max(0.0)))),
            optional(self.within_3_sigma_percent.map(|share| format!("{share:.1}"))),
            optional(self.kept.map(|kept| if kept { "kept" } else { "MISSED" }.into())),
            refused.join(", ")
        )
    }
}

impl Table {
    /// Of runs.
    pub fn of(runs: &[Run]) -> Self {
        let of = |case: &Case, way: Way| -> Vec<&Seen> {
            let runs = runs.iter().filter(|run| run.case == case.name);
            runs.flat_map(|run| run.seen.iter().filter(move |seen| seen.way == way)).collect()
        };
        let noon = |way: Way| {
            let cases = CASES.iter().filter(|case| !case.at_horizon && case.phase_deg[1] <= STEP_PHASE_DEG);
            let errors: Vec<f64> = cases
                .flat_map(|case| of(case, way))
                .filter_map(|seen| Some(seen.fix.as_ref()?.error_deg[0]))
                .collect();
            let middle = mean(errors.iter().copied());
            let scatter = rms(errors.iter().map(|error| error - middle));
            Noon {
                way,
                step_deg: 2.0 * middle.abs(),
                step_sigma_deg: 2.0 * scatter / (errors.len() as f64).max(1.0).sqrt(),
                goal_deg: STEP_GOAL_DEG,
            }
        };
        let limit = |case: &Case| {
            let limits = runs.iter().filter(|run| run.case == case.name).filter_map(|run| run.limit_deg);
            let limits: Vec<[f64; 2]> = limits.collect();
            (!limits.is_empty()).then(|| [0, 1].map(|axis| rms(limits.iter().map(|limit| limit[axis]))))
        };
        let rows = CASES.iter().flat_map(|case| {
            let limit_deg = limit(case);
            WAYS.map(|way| Row::of(case, way, &of(case, way), limit_deg))
        });
        Self { rows: rows.collect(), noons: WAYS.map(noon).to_vec() }
    }

    /// Whether every goal is kept.
    pub fn kept(&self) -> bool {
        self.rows.iter().all(|row| row.kept != Some(false))
            && self.noons.iter().all(|noon| !noon.way.has_goal() || noon.step_deg <= noon.goal_deg)
    }

    /// The table for people.
    pub fn text(&self) -> String {
        let mut lines = vec![
            "The Earth in single frames; pairs are towards the Sun and across, deg".to_string(),
            format!(
                "  {:<12}{:>6}{:>16}{:>16}{:>16}{:>16}{:>16}{:>9}{:>10}{:>6}{:>7}{:>13}{:>7}{:>8}  {}",
                "",
                "found,",
                "error,",
                "median",
                "mean",
                "stated",
                "rms with",
                "radius,",
                "distance,",
                "arc,",
                "",
                "",
                "in 3",
                "",
                "",
            ),
            format!(
                "  {:<12}{:>6}{:>16}{:>16}{:>16}{:>16}{:>16}{:>9}{:>10}{:>6}{:>7}{:>13}{:>7}{:>8}  {}",
                "way",
                "%",
                "rms",
                "size",
                "error",
                "sigma",
                "dist. known",
                "rms deg",
                "rms km",
                "deg",
                "NEES",
                "its band",
                "sigma",
                "",
                "refused"
            ),
        ];
        let mut case = "";
        for row in &self.rows {
            if row.case != case {
                case = row.case;
                let goal =
                    row.goal_of_case().map_or(String::new(), |goal| format!(", goal {goal} deg an axis"));
                let limit = row
                    .limit_deg
                    .map_or(String::new(), |[towards, across]| format!(", at best {towards:.4} {across:.4}"));
                lines.push(format!("{case} ({} frames{goal}{limit})", row.frames));
            }
            lines.push(row.line());
        }
        lines.push(format!("Step at noon, deg (goal {STEP_GOAL_DEG})"));
        lines.extend(self.noons.iter().map(|noon| {
            let way = format!("{:?}", noon.way).to_lowercase();
            format!("  {way:<12}{:.4} +- {:.4}", noon.step_deg, noon.step_sigma_deg)
        }));
        lines.push("Position by one frame and a star attitude, km an axis across and along (thesis: 70 in GEO, 36 in LEO)".into());
        lines.extend(self.rows.iter().filter(|row| row.way == Way::Sun).filter_map(|row| {
            let ([across, along], [across_sigma, along_sigma]) =
                row.position_rms_km.zip(row.position_sigma_km)?;
            Some(format!(
                "  {:<24}error {across:.1} {along:.1}, stated {across_sigma:.1} {along_sigma:.1}",
                row.case
            ))
        }));
        lines.push("Focal length by the Earth, the distance known from the orbit, share of it".into());
        lines.extend(self.rows.iter().filter_map(|row| {
            let [rms, sigma] = row.focal_length?;
            Some(format!("  {:<24}error {rms:.5}, stated {sigma:.5}", row.case))
        }));
        lines.push(if self.kept() { "kept" } else { "MISSED" }.to_string());
        lines.join("\n")
    }
}

impl Row {
    fn goal_of_case(&self) -> Option<f64> {
        CASES.iter().find(|case| case.name == self.case).and_then(|case| case.goal_deg)
    }
}
