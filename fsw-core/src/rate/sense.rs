//! The rate by streaks, and its sense.
//!
//! In: the arcs and marks of an image's streaks, the seconds since the image before, and the [`Memory`] of
//! it. Out: [`Found`], or nothing. The ends of streaks and the exposure give the rate but for its sense
//! ([`arcs::solve`]). Two hypotheses, this sense and the opposite one, say where the streaks of the last
//! image must be now; the one that finds them gains. A star found again also gives the mean rate between the
//! images, better than the ends of its streak do; two such means in a row give the rate now, one alone holds
//! as far as a free body may have changed since ([`CHANGE`]).
//!
//! No rate is given where too few streaks agree and no other image has confirmed it, nor one that contradicts
//! the last image's.

use super::arcs::{self, Arc, MAX_ARCS, RateFit, corrected, is_like, joined, widened};
use super::marks::{CHANGE, FASTEST_RAD_S, Field, MAX_MARKS, Mark, encounters, matched};
use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

/// Equations beyond the three unknowns that make a rate of one image believed: three whole streaks, or two
/// and two cut ones.
const FEWEST_SPARE: usize = 3;
/// Expected number of chance encounters up to which one encounter decides the sense.
const BY_CHANCE: f32 = 0.03;
/// The sense is known from so many encounters on, and so many are counted at most.
const SURE: i8 = 2;
const MOST_SURE: i8 = 4;
/// A mean rate is extrapolated by the one before it where the images are at most so far apart, s.
const LONGEST_EXTRAPOLATION_S: f32 = 1.5;

/// A rate, rad/s, and its covariance, (rad/s)².
pub type Estimate = (Vector3<f32>, Matrix3<f32>);

/// What is remembered from image to image.
#[derive(Debug, Default)]
pub struct Memory {
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
pub struct Found {
    /// The rate and its covariance.
    pub estimate: Estimate,
    /// Whether streaks found again in the next image took part.
    pub from_both: bool,
    /// Whether the opposite rate is as likely.
    pub either_sense: bool,
    /// Whole streaks that agree.
    pub whole: u32,
}

impl Memory {
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
    pub fn take_stars(
        &mut self,
        marks: Vec<Mark, MAX_MARKS>,
        elapsed_s: Option<f32>,
    ) -> Option<(Estimate, u32)> {
        let rate = elapsed_s.and_then(|elapsed_s| matched(&self.marks, &marks, elapsed_s));
        *self = Self::of_marks(marks);
        let rate = rate?;
        let off = 0.5 * CHANGE * rate.rad_s.norm_squared() * elapsed_s?;
        Some(((rate.rad_s, widened(rate.covariance, off)), rate.count()))
    }

    /// Takes in the streaks of an image, `elapsed_s` after the last one where that can be compared with it.
    #[inline(never)]
    pub fn take_streaks(
        &mut self,
        arcs: &[Arc],
        marks: Vec<Mark, MAX_MARKS>,
        elapsed_s: Option<f32>,
        field: Field,
    ) -> Option<Found> {
        let rate = arcs::solve(arcs).filter(|rate| rate.rad_s.norm() < FASTEST_RAD_S);
        let before = core::mem::replace(self, Self::of_marks(marks));
        let rate = rate?;
        let (whole, cut) = count(arcs, &rate);
        let compared = Compared::new(&before, arcs, &rate, elapsed_s)?;
        let hypotheses = Hypotheses::new(&compared, arcs, (&before.marks, &self.marks), field);
        let decision = hypotheses.decide(&compared, &before)?;
        let estimate = best(&compared, &hypotheses, &decision, &before);
        let (sure, confirmed) = (decision.sense >= SURE, decision.mean.is_some() || compared.repeats());
        self.sense = decision.sense;
        self.known = sure.then_some(estimate.0);
        self.mean = decision.mean.map(|mean| (mean.rad_s, mean.covariance));
        self.streaks = Some(decision.rate);
        // A contradiction is none of the last image's if that one had less to say.
        let contradicts = compared.like == Some(false) && before.sense >= SURE;
        // Among many lines of which most disagree, some agree by chance.
        let alone = 2 * whole + cut >= FEWEST_SPARE + 3 && 2 * (whole + cut) >= arcs.len();
        (confirmed || alone && !contradicts).then_some(Found {
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
struct Compared {
    rate: RateFit,
    last: Option<RateFit>,
    /// Seconds since the last image; 1 where there is none.
    elapsed_s: f32,
    /// By how much a free body's rate may change in a second, rad/s.
    change: f32,
    /// Whether the two are like each other; `None` where one of them says too little.
    like: Option<bool>,
}

impl Compared {
    fn new(before: &Memory, arcs: &[Arc], rate: &RateFit, elapsed_s: Option<f32>) -> Option<Self> {
        let last = before.streaks.filter(|_| elapsed_s.is_some());
        let against = last.is_some_and(|last| last.rad_s.dot(&rate.rad_s) < 0.0);
        let rate = if against { arcs::opposite(arcs, rate)? } else { *rate };
        let elapsed_s = elapsed_s.unwrap_or(1.0);
        let change = CHANGE * rate.rad_s.norm_squared();
        let like = last.as_ref().and_then(|last| is_like(&rate, last, change * elapsed_s));
        Some(Self { rate, last, elapsed_s, change, like })
    }

    fn repeats(&self) -> bool {
        self.like == Some(true)
    }

    /// The marks of the last image found in this one at a rate, the last one's taken with `sign`; the number
    /// expected by chance.
    fn meet(
        &self,
        there: &mut Vec<Arc, MAX_ARCS>,
        images: (&[Mark], &[Mark]),
        (rate, sign): (&RateFit, f32),
        field: Field,
    ) -> f32 {
        // Between two images the mean of both rates counts, and what a body may do beside it.
        let (mean, covariance, off) = match self.last.filter(|_| self.repeats()) {
            Some(last) => {
                ((rate.rad_s + last.rad_s * sign) * 0.5, (rate.covariance + last.covariance) * 0.25, 0.1)
            }
            None => (rate.rad_s, rate.covariance, 0.5),
        };
        let off = off * self.change * self.elapsed_s;
        encounters(there, images, (&mean, &widened(covariance, off)), self.elapsed_s, field)
    }
}

/// Both senses, and what the last image says of them.
struct Hypotheses {
    opposite: Option<RateFit>,
    /// Ways of the marks that this sense finds again.
    there: Vec<Arc, MAX_ARCS>,
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
    fn new(compared: &Compared, arcs: &[Arc], images: (&[Mark], &[Mark]), field: Field) -> Self {
        let mut there = Vec::new();
        let opposite = arcs::opposite(arcs, &compared.rate);
        if let Some(opposite) = &opposite {
            compared.meet(&mut there, images, (opposite, -1.0), field);
        }
        let back = there.len() as i8;
        let chance = compared.meet(&mut there, images, (&compared.rate, 1.0), field);
        let gain = there.len() as i8 - back;
        Self { opposite, there, gain, chance }
    }

    /// Adds the gain to what was believed before; `None` where the opposite sense is believed and has no
    /// rate.
    fn decide(&self, compared: &Compared, before: &Memory) -> Option<Decision> {
        // Of two rates that differ one is wrong; whatever was concluded from them is not kept.
        let sense = if compared.last.is_some() && compared.repeats() { before.sense } else { 0 };
        // One encounter decides it where chance would hardly bring one about.
        let weight = if self.chance < BY_CHANCE { SURE } else { 1 };
        let sense = (sense + weight * self.gain.clamp(-2, 2)).clamp(-MOST_SURE, MOST_SURE);
        if sense < 0 {
            return Some(Decision { rate: self.opposite?, sense: -sense, mean: None });
        }
        let change = compared.change * compared.elapsed_s;
        let mean = (self.gain > 0).then(|| arcs::solve(&self.there)).flatten();
        let mean = mean.filter(|mean| is_like(mean, &compared.rate, change) == Some(true));
        Some(Decision { rate: compared.rate, sense, mean })
    }
}

/// The rate now by all that is known of it, and whether streaks found again took part.
#[inline(never)]
fn best(
    compared: &Compared,
    hypotheses: &Hypotheses,
    decision: &Decision,
    before: &Memory,
) -> (Estimate, bool) {
    let Compared { elapsed_s, change, .. } = *compared;
    let Hypotheses { there, gain, chance, .. } = hypotheses;
    let off = 0.5 * change * elapsed_s;
    let streaks = (decision.rate.rad_s, decision.rate.covariance);
    if decision.sense < SURE {
        return (streaks, false);
    }
    let both = match &decision.mean {
        Some(mean) => joined(streaks, now(compared, decision, mean, before)),
        // Too few for a mean of their own.
        None if *gain > 0 && *chance < BY_CHANCE => corrected(streaks, there, off),
        None => None,
    };
    let estimate = both.unwrap_or(streaks);
    // What was found by the last image, with what may have changed since.
    let last = before.known.filter(|_| compared.repeats());
    let last = last.map(|(known, covariance)| (known, widened(covariance, change * elapsed_s)));
    (last.and_then(|last| joined(estimate, last)).unwrap_or(estimate), both.is_some())
}

/// The rate now from the mean since the last image, which is that of half the time before: as it is, with
/// what may have changed since, or extrapolated by the mean before it, whichever is surer.
fn now(compared: &Compared, decision: &Decision, mean: &RateFit, before: &Memory) -> Estimate {
    let Compared { elapsed_s, change, .. } = *compared;
    let as_it_is = (mean.rad_s, widened(mean.covariance, 0.5 * change * elapsed_s));
    let Some((last, covariance)) = before.mean.filter(|_| elapsed_s < LONGEST_EXTRAPOLATION_S) else {
        return as_it_is;
    };
    let wander = change * decision.rate.rad_s.norm();
    let extrapolated =
        (mean.rad_s * 1.5 - last * 0.5, widened(mean.covariance * 2.25 + covariance * 0.25, wander));
    if extrapolated.1.trace() < as_it_is.1.trace() { extrapolated } else { as_it_is }
}
