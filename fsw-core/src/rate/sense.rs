//! The rate by streaks, and its sense.
//!
//! In: the arcs and marks of an image's streaks, the seconds since the image before, and the [`RateHistory`] of
//! it. Out: [`StreakRate`], or nothing. The ends of streaks and the exposure give the rate but for its sense
//! ([`arcs::solve`]). Two hypotheses, this sense and the opposite one, say where the streaks of the last
//! image must be now; the one that finds them gains. A star found again also gives the mean rate between the
//! images, better than the ends of its streak do; two such means in a row give the rate now, one alone holds
//! as far as a free body may have changed since ([`FREE_BODY_CHANGE`]).
//!
//! No rate is given where too few streaks agree and no other image has confirmed it, nor one that contradicts
//! the last image's.

use super::arcs::{self, Arc, MAX_ARCS, RateFit, are_consistent, corrected, fused, inflated};
use super::marks::{
    DetectorScale, FASTEST_RAD_S, FREE_BODY_CHANGE, MAX_MARKS, Mark, match_at_rate, match_by_separation,
};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Equations beyond the three unknowns that make a rate of one image believed: three whole streaks, or two
/// and two cut ones.
const FEWEST_SPARE: usize = 3;
/// Expected number of chance encounters up to which one encounter decides the sense.
const MAX_CHANCE_MATCHES: f32 = 0.03;
/// The sense is known from so many encounters on, and so many are counted at most.
const SENSE_KNOWN: i8 = 2;
const MAX_SENSE: i8 = 4;
/// A mean rate is extrapolated by the one before it where the images are at most so far apart, s.
const LONGEST_EXTRAPOLATION_S: f32 = 1.5;

/// A rate, rad/s, and its covariance, (rad/s)².
pub type Estimate = (Vector3<f32>, Matrix3<f32>);

/// What is remembered from image to image.
#[derive(Debug, Default)]
pub struct RateHistory {
    /// Whole streaks, or stars, of the last image.
    pub marks: Vec<Mark, MAX_MARKS>,
    /// Rate by the streaks of that image, of the sense that is believed more.
    streaks: Option<RateFit>,
    /// Encounters for this sense less those against it.
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

    /// Takes in the stars of an image, `elapsed_s` after the last one where that can be compared with it: the
    /// mean rate between the two by the stars found again, with what it may have changed by since, and their
    /// number.
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

    /// Takes in the streaks of an image, `elapsed_s` after the last one where that can be compared with it.
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
        let (sure, confirmed) =
            (decision.sense >= SENSE_KNOWN, decision.mean.is_some() || compared.is_consistent());
        self.sense = decision.sense;
        self.known = sure.then_some(estimate.0);
        self.mean = decision.mean.map(|mean| (mean.rad_s, mean.covariance));
        self.streaks = Some(decision.rate);
        // A contradiction is none of the last image's if that one had less to say.
        let contradicts = compared.consistent == Some(false) && before.sense >= SENSE_KNOWN;
        // Among many lines of which most disagree, some agree by chance.
        let alone = 2 * whole + cut >= FEWEST_SPARE + 3 && 2 * (whole + cut) >= arcs.len();
        (confirmed || alone && !contradicts).then_some(StreakRate {
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

/// The rate of an image beside that of the last one, in the same sense: it cannot have turned over in a few
/// seconds.
struct RateComparison {
    rate: RateFit,
    last: Option<RateFit>,
    /// Seconds since the last image; 1 where there is none.
    elapsed_s: f32,
    /// By how much a free body's rate may change in a second, rad/s.
    change: f32,
    /// Whether the two are like each other; `None` where one of them says too little.
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
        // Between two images the mean of both rates counts, and what a body may do beside it.
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

/// Both senses, and what the last image says of them.
struct Hypotheses {
    opposite: Option<RateFit>,
    /// Ways of the marks that this sense finds again.
    matches: Vec<Arc, MAX_ARCS>,
    /// How many more it finds than the opposite one.
    gain: i8,
    /// How many it would find by chance.
    chance: f32,
}

/// The sense that is believed, with its rate and the mean rate since the last image.
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

    /// Adds the gain to what was believed before; `None` where the opposite sense is believed and has no
    /// rate.
    fn decide(&self, compared: &RateComparison, before: &RateHistory) -> Option<Decision> {
        // Of two rates that differ one is wrong; whatever was concluded from them is not kept.
        let sense = if compared.last.is_some() && compared.is_consistent() { before.sense } else { 0 };
        // One encounter decides it where chance would hardly bring one about.
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

/// The rate now by all that is known of it, and whether streaks found again took part.
#[inline(never)]
fn fused_rate(
    compared: &RateComparison,
    hypotheses: &Hypotheses,
    decision: &Decision,
    before: &RateHistory,
) -> (Estimate, bool) {
    let RateComparison { elapsed_s, change, .. } = *compared;
    let Hypotheses { matches, gain, chance, .. } = hypotheses;
    let off = 0.5 * change * elapsed_s;
    let streaks = (decision.rate.rad_s, decision.rate.covariance);
    if decision.sense < SENSE_KNOWN {
        return (streaks, false);
    }
    let both = match &decision.mean {
        Some(mean) => fused(streaks, rate_at_image(compared, decision, mean, before)),
        // Too few for a mean of their own.
        None if *gain > 0 && *chance < MAX_CHANCE_MATCHES => corrected(streaks, matches, off),
        None => None,
    };
    let estimate = both.unwrap_or(streaks);
    // What was found by the last image, with what may have changed since.
    let last = before.known.filter(|_| compared.is_consistent());
    let last = last.map(|(known, covariance)| (known, inflated(covariance, change * elapsed_s)));
    (last.and_then(|last| fused(estimate, last)).unwrap_or(estimate), both.is_some())
}

/// The rate now from the mean since the last image, which is that of half the time before: as it is, with
/// what may have changed since, or extrapolated by the mean before it, whichever is surer.
fn rate_at_image(
    compared: &RateComparison,
    decision: &Decision,
    mean: &RateFit,
    before: &RateHistory,
) -> Estimate {
    let RateComparison { elapsed_s, change, .. } = *compared;
    let as_it_is = (mean.rad_s, inflated(mean.covariance, 0.5 * change * elapsed_s));
    let Some((last, covariance)) = before.mean.filter(|_| elapsed_s < LONGEST_EXTRAPOLATION_S) else {
        return as_it_is;
    };
    let wander = change * decision.rate.rad_s.norm();
    let extrapolated =
        (mean.rad_s * 1.5 - last * 0.5, inflated(mean.covariance * 2.25 + covariance * 0.25, wander));
    if extrapolated.1.trace() < as_it_is.1.trace() { extrapolated } else { as_it_is }
}
