//! Both times of a second: local time, by which all elapsed times are measured, and Terrestrial Time, for Sun
//! and Earth.
//!
//! In: the clock, and the instant of the image where there is one. Out: [`Time`]. Terrestrial Time is the
//! clock's; while that gives none, or an instant outside the years in which it is believed, the last one, or
//! that of a command, is propagated by local time. A step of the clock is the difference between its
//! Terrestrial Time and the last one propagated.

use crate::command::{Refusal, TimeCorrelation};
use crate::telemetry::{ClockFault, ClockState, ImageFault};
use crate::word_sum;
use fsw_hal::Error;
use fsw_hal::{Clock, LocalTime};

/// Instants between which the clock is believed: the years 2000 and 2100, microseconds since J2000.0.
pub const INSTANTS_US: (i64, i64) = (0, 3_155_760_000_000_000);
/// A second, us.
pub(super) const SECOND_US: i64 = 1_000_000;
/// Larger differences between clock and local time are steps, us. A smaller one is the counter's drift (20
/// ppm are 20 us a second) and its correction.
const STEP_US: i64 = 100_000;
/// Without a clock Terrestrial Time goes on by local time for so long, us: a day, in which a counter that is
/// off by 50 ppm loses 4 s. The Sun's direction changes by 0.2 arcsec in that time, and so does the
/// aberration.
const HOLDOVER_US: i64 = 86_400 * SECOND_US;
/// An image may be later than the second in which it is read by so much, us, and earlier by so much.
const IMAGE_AHEAD_US: i64 = 100_000;
const IMAGE_AGE_US: i64 = 10 * SECOND_US;
/// Two images are at least so far apart, us; nearer it is the same one, whose instant was reckoned again by a
/// counter that drifts.
const LEAST_APART_US: i64 = 50_000;

/// Both times of a second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Time {
    /// Of the image, or of the call in a second without one.
    pub local: LocalTime,
    /// Terrestrial Time at that instant, us since J2000.0, however old the correlation; `None` where the
    /// clock has never given it.
    pub terrestrial_us: Option<i64>,
    /// What that rests on.
    pub state: ClockState,
    /// By how much the clock, or the correlation by command, has stepped since the last second, us.
    pub step_us: Option<i64>,
    /// Why the clock did not serve.
    pub fault: Option<ClockFault>,
}

/// What is remembered from second to second.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Timekeeper {
    /// Local time of the last second.
    last: Option<LocalTime>,
    /// ... and of the last image used.
    image: Option<LocalTime>,
    /// Local and Terrestrial Time when the clock last gave both.
    correlation: Option<(LocalTime, i64)>,
    /// Whether the clock gave Terrestrial Time in the last second.
    served: bool,
    /// By how much a command moved the correlation since, us.
    commanded_us: i64,
}

/// When a second is by the counter.
pub(super) struct Now {
    local: LocalTime,
    fault: Option<ClockFault>,
}

impl Timekeeper {
    /// Sum of the words of all that is remembered.
    pub(super) fn word_sum(&self) -> u32 {
        let Self { last, image, correlation, served, commanded_us } = *self;
        let at = |instant: Option<LocalTime>| instant.map_or(-1, LocalTime::as_us);
        let (then, us) = correlation.map_or((-1, -1), |(then, us)| (then.as_us(), us));
        let longs = [at(last), at(image), then, us, commanded_us].map(|us| word_sum::of_long(us as u64));
        longs.into_iter().fold(served.into(), u32::wrapping_add)
    }

    /// Reads the counter. Where it fails a second has passed; where it has gone backwards all that was
    /// remembered is void.
    pub(super) fn read_counter(&mut self, clock: &mut impl Clock) -> Now {
        let presumed = self.last.map_or(LocalTime::default(), |last| last.plus_us(SECOND_US));
        match clock.local_time() {
            Ok(local) if self.last.is_some_and(|last| local < last) => {
                *self = Self::default();
                Now { local, fault: Some(ClockFault::CounterReset) }
            }
            Ok(local) => Now { local, fault: None },
            Err(error) => Now { local: presumed, fault: Some(error.kind().into()) },
        }
    }

    /// Terrestrial Time of the last second, us since J2000.0.
    pub(super) fn last_terrestrial_us(&self) -> Option<i64> {
        let (then, us) = self.correlation?;
        self.last.map(|last| us.saturating_add(last.us_since(then)))
    }

    /// Takes the correlation from a command.
    ///
    /// # Errors
    /// [`Refusal::ClockServes`], [`Refusal::Correlation`].
    pub(super) fn correlate(&mut self, given: TimeCorrelation) -> Result<(), Refusal> {
        if self.served {
            return Err(Refusal::ClockServes);
        }
        let TimeCorrelation { local, terrestrial_us } = given;
        let recent = self.last.is_some_and(|last| (0..=HOLDOVER_US).contains(&last.us_since(local)));
        if !recent || !(INSTANTS_US.0..=INSTANTS_US.1).contains(&terrestrial_us) {
            return Err(Refusal::Correlation);
        }
        if let Some((then, us)) = self.correlation {
            let moved_us = terrestrial_us.saturating_sub(us.saturating_add(local.us_since(then)));
            self.commanded_us = self.commanded_us.saturating_add(moved_us);
        }
        self.correlation = Some((local, terrestrial_us));
        Ok(())
    }

    /// Whether an image of `instant`, read in the second `now`, may be used; if so it is that of this second.
    pub(super) fn accept(&mut self, instant: LocalTime, now: &Now) -> Result<(), ImageFault> {
        let same = |image: LocalTime| instant.us_since(image).saturating_abs() < LEAST_APART_US;
        if self.image.is_some_and(same) {
            return Err(ImageFault::Repeated);
        }
        if self.last.is_some_and(|last| instant <= last) {
            return Err(ImageFault::OutOfOrder);
        }
        // The age of an image is unknown where the counter failed.
        let age_us = now.local.us_since(instant);
        if !matches!(now.fault, Some(ClockFault::Hardware))
            && !(-IMAGE_AHEAD_US..=IMAGE_AGE_US).contains(&age_us)
        {
            return Err(ImageFault::Implausible);
        }
        self.image = Some(instant);
        Ok(())
    }

    /// Both times of the second `now`, whose image, where it has one, is of the instant `image`.
    pub(super) fn times(&mut self, clock: &mut impl Clock, now: &Now, image: Option<LocalTime>) -> Time {
        let local = image.unwrap_or(now.local);
        self.last = Some(local);
        let given = clock.terrestrial_us(local).map_err(|error| ClockFault::from(error.kind()));
        let given = given.and_then(|us| {
            if (INSTANTS_US.0..=INSTANTS_US.1).contains(&us) { Ok(us) } else { Err(ClockFault::Implausible) }
        });
        let kept = self.correlation.map(|(then, us)| us.saturating_add(local.us_since(then)));
        let fresh = self.correlation.is_some_and(|(then, _)| local.us_since(then) <= HOLDOVER_US);
        self.served = given.is_ok();
        let commanded_us = core::mem::take(&mut self.commanded_us);
        let step = |us: i64| Some(us.saturating_add(commanded_us)).filter(|us| us.saturating_abs() > STEP_US);
        match given {
            Ok(us) => {
                self.correlation = Some((local, us));
                let step_us = kept.and_then(|kept| step(us.saturating_sub(kept)));
                let state = ClockState::Synchronised;
                Time { local, terrestrial_us: Some(us), state, step_us, fault: now.fault }
            }
            Err(fault) => {
                let state = if fresh { ClockState::Holdover } else { ClockState::Unknown };
                let fault = now.fault.or(Some(fault));
                Time { local, terrestrial_us: kept, state, step_us: step(0), fault }
            }
        }
    }
}
