//! Rate by streaks, and the resolution of its sense.
//!
//! In: the arcs and marks of an image's streaks, the seconds since the last image, and its [`RateHistory`].
//! Out: a [`StreakRate`] or `None`. The ends of streaks and the exposure give the rate except for its sense
//! ([`arcs::solve`]). Each of the two senses predicts where the streaks of the last image are now; the one
//! with more matches gains. A star found in both images also gives the mean rate between them, more
//! accurate than the ends of its streak. Two successive means are extrapolated to the present; a single one
//! is used with its covariance enlarged by the possible change of a free body's rate
//! ([`FREE_BODY_CHANGE`]).
//!
//! `None` where too few streaks agree and no other image has confirmed the rate, or where it contradicts
//! that of the last image.

use super::arcs::{self, Arc, MAX_ARCS, RateFit, are_consistent, corrected, fused, inflated};
use super::marks::{
    DetectorScale, FASTEST_RAD_S, FREE_BODY_CHANGE, MAX_MARKS, Mark, match_at_rate, match_by_separation,
};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Redundant equations required of a rate of a single image: four whole streaks, or three and two cut ones.
/// Of three lines two fix a rate; that the third agrees by chance has a probability of some percent.
const FEWEST_SPARE: usize = 5;
/// Expected number of chance matches up to which one match decides the sense.
const MAX_CHANCE_MATCHES: f32 = 0.03;
/// Net matches from which the sense is known, and largest count.
const SENSE_KNOWN: i8 = 2;
const MAX_SENSE: i8 = 4;
/// A mean rate is extrapolated by the one before it where the images are at most so far apart, s.
const LONGEST_EXTRAPOLATION_S: f32 = 1.5;

/// Change of the rate in a second, rad/s, where nothing is known of it: a slew of 40 deg in half a minute.
const SLEW_CHANGE: f32 = 8e-4;

/// A rate, rad/s, and its covariance, (rad/s)².
pub type Estimate = (Vector3<f32>, Matrix3<f32>);

/// History kept from image to image.
#[derive(Debug, Default)]
pub struct RateHistory {
    /// Whole streaks, or stars, of the last image.
    pub marks: Vec<Mark, MAX_MARKS>,
    /// Rate by the streaks of that image, of the more likely sense.
    streaks: Option<RateFit>,
    /// Matches for this sense less those for the opposite one.
    sense: i8,
    /// Mean rate up to that image from the one before, if there was one.
    mean: Option<Estimate>,
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

    /// Update by the stars of an image, `elapsed_s` after the last one (`None` if not comparable). Returns
    /// the mean rate between the two by matched stars, its covariance enlarged by the possible change
    /// since, and the number of matches.
    #[inline(never)]
    pub fn update_from_stars(
        &mut self,
        marks: Vec<Mark, MAX_MARKS>,
        elapsed_s: Option<f32>,
    ) -> Option<(Estimate, u32)> {
        let rate = elapsed_s.and_then(|elapsed_s| match_by_separation(&self.marks, &marks, elapsed_s));
        *self = Self::of_marks(marks);
        let rate = rate?;
        let off = 0.5 * FREE_BODY_CHANGE * rate.rad_s.norm_squared() * elapsed_s?;
        Some(((rate.rad_s, inflated(rate.covariance, off)), rate.count()))
    }

    /// Update by the streaks of an image, `elapsed_s` after the last one (`None` if not comparable).
    #[inline(never)]
    pub fn update_from_streaks(
        &mut self,
        arcs: &[Arc],
        marks: Vec<Mark, MAX_MARKS>,
        elapsed_s: Option<f32>,
        field: DetectorScale,
    ) -> Option<StreakRate> {
        let rate = arcs::solve(arcs).filter(|rate| rate.rad_s.norm() < FASTEST_RAD_S);
        let before = core::mem::replace(self, Self::of_marks(marks));
        let rate = rate?;
        let (whole, cut) = count(arcs, &rate);
        let compared = RateComparison::new(&before, arcs, &rate, elapsed_s)?;
        let hypotheses = Hypotheses::new(&compared, arcs, (&before.marks, &self.marks), field);
        let decision = hypotheses.decide(&compared, &before)?;
        let estimate = fused_rate(&compared, &hypotheses, &decision, &before);
        let sure = decision.sense >= SENSE_KNOWN;
        self.sense = decision.sense;
        self.known = sure.then_some(estimate.0);
        self.mean = decision.mean.map(|mean| (mean.rad_s, mean.covariance));
        self.streaks = Some(decision.rate);
        // The last image's rate counts only if its sense was known.
        let contradicts = compared.consistent == Some(false) && before.sense >= SENSE_KNOWN;
        let alone = 2 * whole + cut >= FEWEST_SPARE + 3 && !contradicts;
        // At least half of the arcs must agree: of many lines some agree by chance, those of an Earth that
        // hardly moves from image to image with the same rate.
        let agreed = 2 * (whole + cut) >= arcs.len() && (alone || compared.is_consistent());
        let confirmed = decision.mean.is_some();
        (confirmed || agreed).then_some(StreakRate {
            estimate: estimate.0,
            from_both: estimate.1,
            either_sense: !sure,
            whole: whole as u32,
        })
    }
}

/// Whole and cut arcs that agree with a rate.
fn count(arcs: &[Arc], rate: &RateFit) -> (usize, usize) {
    let agreeing = arcs.iter().enumerate().filter(|(index, _)| (rate.arcs >> *index) & 1 == 1);
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
}

impl RateComparison {
    fn new(before: &RateHistory, arcs: &[Arc], rate: &RateFit, elapsed_s: Option<f32>) -> Option<Self> {
        let last = before.streaks.filter(|_| elapsed_s.is_some());
        let against = last.is_some_and(|last| last.rad_s.dot(&rate.rad_s) < 0.0);
        let rate = if against { arcs::opposite(arcs, rate)? } else { *rate };
        let elapsed_s = elapsed_s.unwrap_or(1.0);
        let change = FREE_BODY_CHANGE * rate.rad_s.norm_squared();
        let consistent = last.as_ref().and_then(|last| are_consistent(&rate, last, change * elapsed_s));
        Some(Self { rate, last, elapsed_s, change, consistent })
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
    /// Number of matches above that of the opposite sense.
    gain: i8,
    /// Expected number of chance matches.
    chance: f32,
}

/// The more likely sense, its rate, and the mean rate since the last image.
struct Decision {
    rate: RateFit,
    sense: i8,
    mean: Option<RateFit>,
}

impl Hypotheses {
    fn new(
        compared: &RateComparison,
        arcs: &[Arc],
        images: (&[Mark], &[Mark]),
        field: DetectorScale,
    ) -> Self {
        let mut matches = Vec::new();
        let opposite = arcs::opposite(arcs, &compared.rate);
        if let Some(opposite) = &opposite {
            compared.match_last_image(&mut matches, images, (opposite, -1.0), field);
        }
        let back = matches.len() as i8;
        let chance = compared.match_last_image(&mut matches, images, (&compared.rate, 1.0), field);
        let gain = matches.len() as i8 - back;
        Self { opposite, matches, gain, chance }
    }

    /// Adds the gain to the previous count; `None` where the opposite sense is more likely and has no rate.
    fn decide(&self, compared: &RateComparison, before: &RateHistory) -> Option<Decision> {
        // The count is kept only if the two rates are consistent.
        let sense = if compared.last.is_some() && compared.is_consistent() { before.sense } else { 0 };
        // One match decides where chance matches are unlikely.
        let weight = if self.chance < MAX_CHANCE_MATCHES { SENSE_KNOWN } else { 1 };
        let sense = (sense + weight * self.gain.clamp(-2, 2)).clamp(-MAX_SENSE, MAX_SENSE);
        if sense < 0 {
            return Some(Decision { rate: self.opposite?, sense: -sense, mean: None });
        }
        let change = compared.change * compared.elapsed_s;
        let mean = (self.gain > 0).then(|| arcs::solve(&self.matches)).flatten();
        let mean = mean.filter(|mean| are_consistent(mean, &compared.rate, change) == Some(true));
        Some(Decision { rate: compared.rate, sense, mean })
    }
}

/// The rate fused from all estimates, and whether matched streaks took part.
#[inline(never)]
fn fused_rate(
    compared: &RateComparison,
    hypotheses: &Hypotheses,
    decision: &Decision,
    before: &RateHistory,
) -> (Estimate, bool) {
    let elapsed_s = compared.elapsed_s;
    let change = observed_change(compared, decision, before);
    let Hypotheses { matches, gain, chance, .. } = hypotheses;
    let off = 0.5 * change * elapsed_s;
    let streaks = (decision.rate.rad_s, decision.rate.covariance);
    if decision.sense < SENSE_KNOWN {
        return (streaks, false);
    }
    let both = match &decision.mean {
        Some(mean) => fused(streaks, rate_at_image((elapsed_s, change), decision, mean, before)),
        // Too few matches for a mean rate of their own: they correct the rate.
        None if *gain > 0 && *chance < MAX_CHANCE_MATCHES => corrected(streaks, matches, off),
        None => None,
    };
    let estimate = both.unwrap_or(streaks);
    // The last image's rate, its covariance enlarged by the possible change since.
    let last = before.known.filter(|_| compared.is_consistent());
    let last = last.map(|(known, covariance)| (known, inflated(covariance, change * elapsed_s)));
    (last.and_then(|last| fused(estimate, last)).unwrap_or(estimate), both.is_some())
}

/// By how much the rate changes in a second, rad/s: as that of a free body, or where that is more, as in a
/// slew, as the last two mean rates differ beyond their sigmas. By one mean rate a slew cannot be told from
/// a free body.
fn observed_change(compared: &RateComparison, decision: &Decision, before: &RateHistory) -> f32 {
    let Some(mean) = &decision.mean else { return compared.change };
    let close = compared.elapsed_s < LONGEST_EXTRAPOLATION_S;
    let observed = before.mean.filter(|_| close).map_or(SLEW_CHANGE, |(last, covariance)| {
        let difference = mean.rad_s - last;
        let square = difference.dot(&difference) - (mean.covariance + covariance).trace();
        libm::sqrtf(square.max(0.0)) / compared.elapsed_s.max(0.1)
    });
    compared.change.max(observed)
}

/// The rate at the image from the mean rate since the last image, which refers to the middle of that
/// interval: unchanged with a larger covariance, or extrapolated by the mean before it, whichever has the
/// smaller covariance.
fn rate_at_image(
    (elapsed_s, change): (f32, f32),
    decision: &Decision,
    mean: &RateFit,
    before: &RateHistory,
) -> Estimate {
    let as_it_is = (mean.rad_s, inflated(mean.covariance, 0.5 * change * elapsed_s));
    let Some((last, covariance)) = before.mean.filter(|_| elapsed_s < LONGEST_EXTRAPOLATION_S) else {
        return as_it_is;
    };
    // The change itself changes: as a free body turns on, and by a quarter in a second as a slew begins or
    // ends.
    let wander = change * decision.rate.rad_s.norm().max(0.25);
    let extrapolated =
        (mean.rad_s * 1.5 - last * 0.5, inflated(mean.covariance * 2.25 + covariance * 0.25, wander));
    if extrapolated.1.trace() < as_it_is.1.trace() { extrapolated } else { as_it_is }
}
