//! Rate by streaks, and the resolution of its sense.
//!
//! In: the arcs of an image's streaks, the seconds since the last image, and its [`RateHistory`].
//! Out: a [`StreakRate`] or `None`. The ends of streaks and the exposure give the rate except for its sense
//! ([`arcs::solve`]). Each of the two senses predicts where the streaks of the last image are now; the odds
//! of the two follow from what each finds and from what it would find by chance. A star found in both images
//! also gives the mean rate between them, more accurate than the ends of its streak. Two successive means are
//! extrapolated to the present; a single one is used with its covariance enlarged by the possible change of
//! the rate since: that of a free body, or of a slew as the last images show it.
//!
//! `None` where too few streaks agree and no other image has confirmed the rate, or where it contradicts
//! that of the last image: tracks of protons and structure of the Sun's glare are lines too, and of many
//! lines some agree by chance.

use super::arcs::{
    self, Arc, MAX_ARCS, RateFit, are_consistent, corrected, enlarged, fused, inflated, is_set,
};
use super::marks::{DetectorScale, FASTEST_RAD_S, MAX_MARKS, Mark, match_at_rate, match_by_separation};
use super::streaks::mark_of;
use crate::attitude::filter::free_body_change;
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Equations, two of a whole streak and one of a cut one, required of a rate of a single image if at most one
/// streak disagrees: five more than fix a rate. A random line agrees with the rate of two others in half a
/// percent of the cases, four of eight in two percent: with more that disagree one streak more is required.
const FEWEST_EQUATIONS: usize = 8;
const MORE_OF_MANY: usize = 2;
/// The same where the rate of the last image agrees: part of a third streak, and if that rate was not known
/// one more of many. Two shreds of cloud agreed with those of the image before in two of 80 flights, three of
/// five in one of 60; a star and a satellite fix a rate too, and go on alike: 13 sigma in one of 60.
const FEWEST_REPEATED: usize = 5;
/// Variance of the difference of two rates, a share of their square, up to which their agreement within 4
/// sigma is evidence: of two random rates five in a hundred agree so.
const REPEATED_SHARE: f32 = 0.025;
/// Expected number of chance matches up to which a mean rate, of several matches, confirms the rate.
const MAX_CHANCE_MATCHES: f32 = 0.03;
/// The same for fewer, which correct it: one by chance may lie anywhere within the reach of the prediction,
/// and turns the rate about the line of sight by up to three sigma.
const MAX_CHANCE_OF_FEW: f32 = 0.01;
/// Fewest matches that make a mean rate: of two, one by chance turns it about the other.
const FEWEST_OF_MEAN: u32 = 3;
/// Share of an image's streaks that the next one shows again: others leave the field, or are hits.
const SHOWN_AGAIN: f32 = 0.5;
/// Natural logarithm of the odds of a sense over the opposite one from which it is known, 10,000 to 1, and
/// of the largest odds that are kept.
const SENSE_KNOWN: f32 = 9.2;
const MAX_SENSE: f32 = 2.0 * SENSE_KNOWN;
/// A mean rate is extrapolated by the one before it where the images are at most so far apart, s.
const LONGEST_EXTRAPOLATION_S: f32 = 1.5;

/// Change of the rate in a second, one sigma, where nothing is known of it: a share of the rate, as in a slew
/// of 10 s, and at least that of a slew of 40 deg in half a minute, rad/s.
const SLEW_CHANGE_SHARE: f32 = 0.25;
const SLEW_CHANGE: f32 = 8e-4;
/// Share of the change observed before that is still possible a second later: in the middle of a slew the
/// rate stays for a moment, and jitter by chance.
const CHANGE_KEPT: f32 = 0.9;
/// By how much of itself the change changes in a second, as a slew begins or ends.
const CHANGE_OF_CHANGE: f32 = 0.25;

/// A rate, rad/s, and its covariance, (rad/s)².
pub type Estimate = (Vector3<f32>, Matrix3<f32>);

/// History kept from image to image.
#[derive(Debug, Default)]
pub struct RateHistory {
    /// Whole streaks, or stars, of the last image.
    pub marks: Vec<Mark, MAX_MARKS>,
    /// Rate by the streaks of that image, of the more likely sense.
    streaks: Option<RateFit>,
    /// Whether more streaks of that image agree with it than do not: with two of many some rate always does.
    agreed: bool,
    /// Natural logarithm of the odds of this sense over the opposite one.
    sense: f32,
    /// Mean rate up to that image from the one before, if there was one.
    mean: Option<Estimate>,
    /// By how much the rate changes in a second, one sigma about every axis, rad/s; `None` until two mean
    /// rates were compared.
    change: Option<Vector3<f32>>,
    /// By how much it may change in the next second, one sigma about every axis, rad/s. At the crest of a
    /// slew two images differ by little: what was possible before them is forgotten slowly.
    possible: Option<Vector3<f32>>,
    /// The rate that was found, where its sense was known.
    known: Option<Estimate>,
}

/// A rate by streaks.
#[derive(Clone, Copy, Debug)]
pub struct StreakRate {
    /// The rate and its covariance.
    pub estimate: Estimate,
    /// Whether streaks found again in the next image took part.
    pub from_both: bool,
    /// Whether the opposite rate is as likely.
    pub either_sense: bool,
    /// Whole streaks that agree.
    pub whole: u32,
}

impl RateHistory {
    /// Marks alone.
    fn of_marks(marks: Vec<Mark, MAX_MARKS>) -> Self {
        Self { marks, ..Self::default() }
    }

    /// The rate by the last image, where its sense was known.
    pub fn known_rate(&self) -> Option<&Vector3<f32>> {
        self.known.as_ref().map(|(rate, _)| rate)
    }

    /// By how much the rate of the last image's streaks may change in the next second, one sigma about every
    /// axis, rad/s; `None` of stars.
    pub fn possible_change(&self) -> Option<&Vector3<f32>> {
        self.possible.as_ref()
    }

    /// Update by the stars of an image, `elapsed_s` after the last one (`None` if not comparable). Returns
    /// the mean rate between the two by matched stars, its covariance enlarged by the change since, and the
    /// number of matches. One sigma of that change is by how much the mean rate before differs: as a turn
    /// begins the rate is up to three times its mean. Where there is none before it may have begun to turn. It
    /// is no less than in half that time of a slew, or of a free body's turning.
    #[inline(never)]
    pub fn update_from_stars(
        &mut self,
        marks: Vec<Mark, MAX_MARKS>,
        elapsed_s: Option<f32>,
    ) -> Option<(Estimate, u32)> {
        let rate = elapsed_s.and_then(|elapsed_s| match_by_separation(&self.marks, &marks, elapsed_s));
        let before = core::mem::replace(self, Self::of_marks(marks));
        let (rate, elapsed_s) = rate.zip(elapsed_s)?;
        self.mean = Some((rate.rad_s, rate.covariance));
        let size = rate.rad_s.norm();
        let least = free_body_change(&rate.rad_s).max(SLEW_CHANGE_SHARE * size);
        let observed = last_mean(&before, elapsed_s).map(|last| change_between(&rate, last, elapsed_s).max());
        let off = observed.unwrap_or(size).max(0.5 * least) * elapsed_s;
        Some(((rate.rad_s, inflated(rate.covariance, off)), rate.count()))
    }

    /// Update by the arcs of an image's streaks, the middle of each exposed `late_s` after that of the frame,
    /// `elapsed_s` after the last image (`None` if not comparable).
    #[inline(never)]
    pub fn update_from_streaks(
        &mut self,
        (arcs, late_s): (&[Arc], &[f32]),
        elapsed_s: Option<f32>,
        field: DetectorScale,
    ) -> Option<StreakRate> {
        let rate = arcs::solve(arcs).filter(|rate| rate.rad_s.norm() < FASTEST_RAD_S);
        let (whole, cut) = rate.as_ref().map_or((0, 0), |rate| count(arcs, rate));
        // More arcs must agree than do not: of many lines some agree by chance, those of an Earth that hardly
        // moves from image to image with the same rate.
        let most_agree = 2 * (whole + cut) > arcs.len();
        let marked = rate.as_ref().filter(|_| most_agree).map_or(u32::MAX, |rate| rate.arcs);
        let before = core::mem::replace(self, Self::of_marks(marks_of((arcs, late_s), marked)));
        self.agreed = most_agree;
        let rate = rate?;
        let compared = RateComparison::new(&before, arcs, &rate, elapsed_s)?;
        let hypotheses = Hypotheses::new(&compared, arcs, (&before.marks, &self.marks), field);
        let decision = hypotheses.decide(&compared, &before)?;
        let observed = observed_change(&compared, &decision, &before);
        let change = possible_change(observed, &compared, &before);
        let estimate = fused_rate((&compared, &change), &hypotheses, &decision, &before);
        let sure = decision.sense >= SENSE_KNOWN;
        self.sense = decision.sense;
        self.known = sure.then_some(estimate.0);
        self.mean = decision.mean.map(|mean| (mean.rad_s, mean.covariance));
        self.change = observed.map_or(before.change, |_| Some(change));
        let kept = before.possible.map_or_else(|| slew_change(&compared.rate), |before| before * CHANGE_KEPT);
        self.possible = Some(change.sup(&kept));
        self.streaks = Some(decision.rate);
        // The last image's rate counts only if its sense was known, or if its agreement is evidence by
        // itself.
        let known = before.sense >= SENSE_KNOWN;
        let (agreeing, equations) = (whole + cut, 2 * whole + cut);
        let more = if agreeing + 1 >= arcs.len() { 0 } else { MORE_OF_MANY };
        let enough = equations >= FEWEST_EQUATIONS + more && is_of_best(arcs, &rate);
        let alone = enough && !(known && compared.consistent == Some(false));
        let known = known && compared.is_consistent();
        let fewest = FEWEST_REPEATED + if known { 0 } else { more };
        let repeated = (known || compared.repeats) && equations >= fewest;
        let agreed = most_agree && (alone || repeated);
        let confirmed = decision.mean.is_some() && (known || hypotheses.chance < MAX_CHANCE_MATCHES);
        (confirmed || agreed).then_some(StreakRate {
            estimate: estimate.0,
            from_both: estimate.1,
            either_sense: !sure,
            whole: whole as u32,
        })
    }
}

/// Marks of the whole arcs whose bits are set. One that contradicts its image's rate is no star's, or its
/// middle is not the star's: found again by chance it turned the rate about the line of sight by 19 sigma.
#[inline(never)]
fn marks_of((arcs, late_s): (&[Arc], &[f32]), marked: u32) -> Vec<Mark, MAX_MARKS> {
    let mut marks = Vec::new();
    for (index, (arc, late_s)) in arcs.iter().zip(late_s).enumerate() {
        if arc.whole
            && is_set(marked, index)
            && let Some(mark) = mark_of(arc, *late_s)
        {
            let _ = marks.push(mark);
        }
    }
    marks
}

/// Whether the whole arc whose length is known best is among those that agree with a rate. Faint ones are
/// measured too long together where the noise goes on at their ends: five outvoted two bright ones.
fn is_of_best(arcs: &[Arc], rate: &RateFit) -> bool {
    let whole = arcs.iter().enumerate().filter(|(_, arc)| arc.whole);
    let best = whole.min_by(|(_, one), (_, other)| one.sigma_rad[0].total_cmp(&other.sigma_rad[0]));
    best.is_none_or(|(index, _)| is_set(rate.arcs, index))
}

/// Whole and cut arcs that agree with a rate.
fn count(arcs: &[Arc], rate: &RateFit) -> (usize, usize) {
    let agreeing = arcs.iter().enumerate().filter(|(index, _)| is_set(rate.arcs, *index));
    agreeing
        .fold((0, 0), |(whole, cut), (_, arc)| if arc.whole { (whole + 1, cut) } else { (whole, cut + 1) })
}

/// The rate of an image and that of the last one, in the same sense: it cannot have reversed within a few
/// seconds.
struct RateComparison {
    rate: RateFit,
    last: Option<RateFit>,
    /// Seconds since the last image; 1 where there is none.
    elapsed_s: f32,
    /// Possible change of a free body's rate in a second, rad/s.
    change: f32,
    /// Whether the two are consistent; `None` where their covariance is too large to decide.
    consistent: Option<bool>,
    /// Whether they are, and so near to each other as two wrong ones hardly are.
    repeats: bool,
}

impl RateComparison {
    fn new(before: &RateHistory, arcs: &[Arc], rate: &RateFit, elapsed_s: Option<f32>) -> Option<Self> {
        let last = before.streaks.filter(|_| elapsed_s.is_some());
        let against = last.is_some_and(|last| last.rad_s.dot(&rate.rad_s) < 0.0);
        let rate = if against { arcs::opposite(arcs, rate)? } else { *rate };
        let elapsed_s = elapsed_s.unwrap_or(1.0);
        let change = free_body_change(&rate.rad_s);
        let consistent = last.as_ref().and_then(|last| are_consistent(&rate, last, change * elapsed_s));
        let near = |last: RateFit| {
            let variance = inflated(rate.covariance + last.covariance, change * elapsed_s).trace();
            variance < REPEATED_SHARE * rate.rad_s.norm_squared().max(last.rad_s.norm_squared())
        };
        let repeats = consistent == Some(true) && before.agreed && last.is_some_and(near);
        Some(Self { rate, last, elapsed_s, change, consistent, repeats })
    }

    fn is_consistent(&self) -> bool {
        self.consistent == Some(true)
    }

    /// The marks of the last image found in this one at a rate, the last one's taken with `sign`; the number
    /// expected by chance.
    fn match_last_image(
        &self,
        matches: &mut Vec<Arc, MAX_ARCS>,
        images: (&[Mark], &[Mark]),
        (rate, sign): (&RateFit, f32),
        field: DetectorScale,
    ) -> f32 {
        // Between two images the mean of both rates applies, plus the possible change.
        let (mean, covariance, off) = match self.last.filter(|_| self.is_consistent()) {
            Some(last) => {
                ((rate.rad_s + last.rad_s * sign) * 0.5, (rate.covariance + last.covariance) * 0.25, 0.1)
            }
            None => (rate.rad_s, rate.covariance, 0.5),
        };
        let off = off * self.change * self.elapsed_s;
        match_at_rate(matches, images, (&mean, &inflated(covariance, off)), self.elapsed_s, field)
    }
}

/// Both senses, and their matches with the last image.
struct Hypotheses {
    opposite: Option<RateFit>,
    /// Arcs of the marks matched by this sense.
    matches: Vec<Arc, MAX_ARCS>,
    /// By what the odds of this sense over the opposite one grow, natural logarithm.
    gain: f32,
    /// Expected number of chance matches.
    chance: f32,
}

/// The more likely sense, its rate, and the mean rate since the last image.
struct Decision {
    rate: RateFit,
    sense: f32,
    mean: Option<RateFit>,
}

/// Natural logarithm of the odds of a rate over none at all, where so many of the last image's marks were
/// matched and so many are expected by chance: a match is as many times as probable as marks that are shown
/// again, and chance matches, are more than chance matches.
fn log_odds(matched: usize, marks: usize, chance: f32) -> f32 {
    matched as f32 * libm::logf(1.0 + SHOWN_AGAIN * marks as f32 / chance.max(1e-6))
}

impl Hypotheses {
    fn new(
        compared: &RateComparison,
        arcs: &[Arc],
        images: (&[Mark], &[Mark]),
        field: DetectorScale,
    ) -> Self {
        let mut matches = Vec::new();
        let mut odds = |rate: &RateFit, sign: f32| {
            let chance = compared.match_last_image(&mut matches, images, (rate, sign), field);
            (log_odds(matches.len(), images.0.len(), chance), chance)
        };
        let opposite = arcs::opposite(arcs, &compared.rate);
        let back = opposite.as_ref().map_or(0.0, |opposite| odds(opposite, -1.0).0);
        let (forth, chance) = odds(&compared.rate, 1.0);
        Self { opposite, matches, gain: forth - back, chance }
    }

    /// Adds the gain to the odds so far; `None` where the opposite sense is more likely and has no rate.
    fn decide(&self, compared: &RateComparison, before: &RateHistory) -> Option<Decision> {
        // The odds are kept only if the two rates are consistent.
        let sense = if compared.last.is_some() && compared.is_consistent() { before.sense } else { 0.0 };
        let sense = (sense + self.gain).clamp(-MAX_SENSE, MAX_SENSE);
        if sense < 0.0 {
            return Some(Decision { rate: self.opposite?, sense: -sense, mean: None });
        }
        let change = compared.change * compared.elapsed_s;
        let mean = (self.gain > 0.0).then(|| arcs::solve(&self.matches)).flatten();
        let mean = mean.filter(|mean| {
            mean.count() >= FEWEST_OF_MEAN && are_consistent(mean, &compared.rate, change) == Some(true)
        });
        Some(Decision { rate: compared.rate, sense, mean })
    }
}

/// The rate fused from all estimates, and whether matched streaks took part. `change`: by how much the rate
/// changes in a second, one sigma about every axis, rad/s.
#[inline(never)]
fn fused_rate(
    (compared, change): (&RateComparison, &Vector3<f32>),
    hypotheses: &Hypotheses,
    decision: &Decision,
    before: &RateHistory,
) -> (Estimate, bool) {
    let elapsed_s = compared.elapsed_s;
    let Hypotheses { opposite, matches, gain, chance } = hypotheses;
    let streaks = (decision.rate.rad_s, decision.rate.covariance);
    if decision.sense < SENSE_KNOWN {
        // With rows that begin one after the other the opposite rate has another size.
        let off = opposite.as_ref().map_or(Vector3::zeros(), |opposite| opposite.rad_s + compared.rate.rad_s);
        return ((streaks.0, enlarged(streaks.1, &off)), false);
    }
    let both = match &decision.mean {
        Some(mean) => fused(streaks, rate_at_image((elapsed_s, change), mean, before)),
        // Too few matches for a mean rate of their own: they correct the rate.
        None if *gain > 0.0 && *chance < MAX_CHANCE_OF_FEW => {
            corrected(streaks, matches, 0.5 * change.max() * elapsed_s)
        }
        None => None,
    };
    let estimate = both.unwrap_or(streaks);
    // The last image's rate, its covariance enlarged by the possible change since.
    let last = before.known.filter(|_| compared.is_consistent());
    let last = last.map(|(known, covariance)| (known, enlarged(covariance, &(change * elapsed_s))));
    (last.and_then(|last| fused(estimate, last)).unwrap_or(estimate), both.is_some())
}

/// The mean rate up to the last image, where that is not too old to be compared with the one since.
fn last_mean(before: &RateHistory, elapsed_s: f32) -> Option<&Estimate> {
    before.mean.as_ref().filter(|_| elapsed_s < LONGEST_EXTRAPOLATION_S)
}

/// By how much the rate changes in a second by two estimates of it, one sigma about every axis, rad/s. About
/// the line of sight, where it is known least, the difference counts beyond two sigma; elsewhere all of it.
#[inline(never)]
fn change_between(now: &RateFit, (last, covariance): &Estimate, elapsed_s: f32) -> Vector3<f32> {
    let difference = now.rad_s - last;
    let square = difference.component_mul(&difference);
    let across = square.x.max(square.y);
    let about = across.max(square.z - 4.0 * (now.covariance + covariance).m33);
    Vector3::new(across, across, about).map(libm::sqrtf) / elapsed_s.max(0.1)
}

/// The change of the rate in a second by the last two mean rates.
fn observed_change(
    compared: &RateComparison,
    decision: &Decision,
    before: &RateHistory,
) -> Option<Vector3<f32>> {
    let last = last_mean(before, compared.elapsed_s)?;
    Some(change_between(decision.mean.as_ref()?, last, compared.elapsed_s))
}

/// By how much a rate of which nothing else is known may change in a second, one sigma about every axis,
/// rad/s.
fn slew_change(rate: &RateFit) -> Vector3<f32> {
    Vector3::repeat((SLEW_CHANGE_SHARE * rate.rad_s.norm()).max(SLEW_CHANGE))
}

/// By how much the rate may change in a second, one sigma about every axis, rad/s: as that of a free body, or
/// where that is more, as in a slew, as `observed` now or before. Until two mean rates were compared, as the
/// rates by the streaks of two images differ; by one image a slew cannot be told from a free body.
fn possible_change(
    observed: Option<Vector3<f32>>,
    compared: &RateComparison,
    before: &RateHistory,
) -> Vector3<f32> {
    let by_streaks =
        |last: &RateFit| change_between(&compared.rate, &(last.rad_s, last.covariance), compared.elapsed_s);
    let change = match (observed, before.change, &compared.last) {
        (Some(observed), Some(before), _) => observed.sup(&(before * CHANGE_KEPT)),
        (Some(change), None, _) | (None, Some(change), _) => change,
        (None, None, Some(last)) => by_streaks(last),
        (None, None, None) => slew_change(&compared.rate),
    };
    change.sup(&Vector3::repeat(compared.change))
}

/// The rate at the image from the mean rate since the last image, which refers to the middle of that
/// interval: unchanged with a larger covariance, or extrapolated by the mean before it, whichever has the
/// smaller covariance.
fn rate_at_image(
    (elapsed_s, change): (f32, &Vector3<f32>),
    mean: &RateFit,
    before: &RateHistory,
) -> Estimate {
    let as_it_is = (mean.rad_s, enlarged(mean.covariance, &(change * (0.5 * elapsed_s))));
    let Some((last, covariance)) = last_mean(before, elapsed_s) else {
        return as_it_is;
    };
    let covariance = mean.covariance * 2.25 + covariance * 0.25;
    let extrapolated = (mean.rad_s * 1.5 - last * 0.5, enlarged(covariance, &(change * CHANGE_OF_CHANGE)));
    if extrapolated.1.trace() < as_it_is.1.trace() { extrapolated } else { as_it_is }
}

#[cfg(test)]
mod tests;
