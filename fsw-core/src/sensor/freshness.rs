//! Whether an image that its noise does not give away is an old one, sold as new.
//!
//! An old image that is disturbed on its way has another noise than when it was first read, and no
//! fingerprint knows it again, nor when it comes again undisturbed; but its noise is larger than usual. From
//! such an image on the stars must have moved since the last image that is known to be new, if the rate of
//! then moves them, or where no rate is known; where they have not, the image is refused. Where they are
//! expected to move by too little to tell, the attitude may be wrong by that much, and its sigma holds it.
//! So it is with an image whose readout broke off in every probe that the image before has, and with the
//! first one after an image of which nothing was read.
//! Ten images without disturbance end the suspicion, and a minute without an image that is known to be new:
//! the spacecraft may have turned otherwise.
//!
//! The first attitude after blinded seconds that is far from what the rate of before leads to is not told: it
//! has turned meanwhile, or is wrong. The next image decides, by a search.
//!
//! In: the noise of each image, its attitude, the filter's rate. Out: [`Age`].

use super::Sensor;
use super::timekeeping::SECOND_US;
use crate::attitude::filter::{Filter, RESTART_NIS, seconds};
use crate::frames::{Icrs, Rotation, StarPath};
use crate::image::fingerprint::Noise;
use fsw_hal::LocalTime;
use nalgebra::Vector3;

/// Noise over the usual, halves of it, from which an image is disturbed.
const DISTURBED: u32 = 3;
/// The usual noise grows by a count and this share from image to image, 2^-8: a detector that warms up is
/// believed again after minutes.
const GROWTH_SHIFT: u16 = 8;
/// Undisturbed images that end the suspicion.
const SUSPECTED: u8 = 10;
/// Way, in standard deviations of both attitudes, that tells an old image from a new one.
const LEAST_WAY_SIGMAS: f32 = 5.0;
/// Within so many two attitudes are the same, and after a gap a new image is where it is expected ...
const OFF_SIGMAS: f32 = 4.0;
/// ... or within this share of the way: the rate is not quite constant.
const OFF_SHARE: f32 = 1.0 / 16.0;
/// Images less apart are of one second and the next, us.
const NEXT_US: i64 = 1_600_000;
/// An image within this time of one that was not expected decides, us.
const DECIDES_US: i64 = 3 * SECOND_US;
/// After so long an image is believed whatever it shows, us: the spacecraft may have turned.
const LONGEST_US: i64 = 60 * SECOND_US;
/// Longest way, rad: a rotation vector is unique below half a turn.
const LONGEST_WAY_RAD: f32 = 2.0;

/// What an image that its noise does not give away is.
pub(super) enum Age {
    /// New.
    New,
    /// Perhaps an old one: its attitude is off by so much then, rad.
    Unknown(Vector3<f32>),
    /// An old one.
    Old,
}

/// An image that was solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved {
    pub(super) attitude: Rotation<Icrs, StarPath>,
    pub(super) sigma_rad: [f32; 3],
    pub(super) image: LocalTime,
}

/// What is usual of the images' noise, and by what a new image is known.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Freshness {
    usual: Noise,
    /// Undisturbed images to come that are suspected.
    suspected: u8,
    /// The last image that is known to be new, and the last one that was refused since.
    verified: Option<Solved>,
    refused: Option<Solved>,
    /// The last rate that was known of a new image, rad/s.
    rate_rad_s: Option<Vector3<f32>>,
    /// Instant of the last image that was not expected.
    unexpected: Option<LocalTime>,
}

impl Freshness {
    /// Takes the noise of an image; whether it is larger than usual, and by more than more light makes it:
    /// that of the sunlit Earth is smaller than its light.
    pub(super) fn is_disturbed(&mut self, noise: Noise) -> bool {
        let grown = self.usual.steps + 1 + (self.usual.steps >> GROWTH_SHIFT);
        if self.usual.steps == 0 || noise.steps <= grown {
            self.usual = noise;
        } else {
            self.usual.steps = grown;
        }
        let more_light = noise.light.saturating_sub(self.usual.light);
        let disturbed = 2 * noise.steps > DISTURBED * self.usual.steps
            && noise.steps.saturating_sub(self.usual.steps) > more_light;
        self.suspected = if disturbed { SUSPECTED } else { self.suspected.saturating_sub(1) };
        disturbed
    }

    /// Suspects an image of which no probe was read that was read of the image before.
    pub(super) fn suspect(&mut self) {
        self.suspected = self.suspected.max(1);
    }
}

impl Sensor<'_> {
    /// What an image is by its attitude: new, where the stars have moved since the last one that is known to
    /// be new, or since the one that was refused before it.
    pub(super) fn age(&mut self, solved: &Solved) -> Age {
        let Freshness { suspected, verified, refused, rate_rad_s, .. } = self.freshness;
        let (Some(verified), 1..) = (verified, suspected) else { return Age::New };
        match solved.age_since(&verified, rate_rad_s.as_ref()) {
            Age::Old => {}
            age => return age,
        }
        self.freshness.refused = Some(*solved);
        let since_refused = refused.map(|refused| solved.age_since(&refused, rate_rad_s.as_ref()));
        since_refused.filter(|age| matches!(age, Age::New)).unwrap_or(Age::Old)
    }

    /// Whether an image after a gap is so far from what the filter expects that the next one decides; none
    /// where it is that next one.
    #[inline(never)]
    pub(super) fn is_unexpected(&mut self, solved: &Solved) -> bool {
        let Solved { attitude, sigma_rad, image } = solved;
        let is_next = |before| (1..=DECIDES_US).contains(&image.us_since(before));
        let after_gap = |motion: &&Filter| motion.age_us(*image) >= NEXT_US;
        let off = (self.motion.as_ref().filter(after_gap))
            .and_then(|motion| motion.sigmas_off(attitude, sigma_rad, *image));
        let unexpected = off.is_some_and(|off| off.norm_squared() >= RESTART_NIS)
            && !self.turning.is_of_lines()
            && !self.freshness.unexpected.is_some_and(is_next);
        if unexpected {
            self.freshness.unexpected = Some(*image);
        }
        unexpected
    }

    /// Remembers an image that is known to be new, once the filter has its attitude.
    pub(super) fn verify(&mut self, solved: Solved) {
        let rate = self.motion.as_ref().and_then(Filter::rate).map(|rate| rate.rad_s);
        let rate_rad_s = rate.or(self.freshness.rate_rad_s);
        self.freshness = Freshness { verified: Some(solved), refused: None, rate_rad_s, ..self.freshness };
    }
}

impl Solved {
    /// What this image is by how far the stars have moved since another one: where that is of the second
    /// before, or no rate is known, at all; where images in between were not solved, and this may be one of
    /// them, as the rate has it.
    #[inline(never)]
    fn age_since(&self, other: &Self, rate_rad_s: Option<&Vector3<f32>>) -> Age {
        let elapsed_us = self.image.us_since(other.image);
        let way = rate_rad_s.map_or_else(Vector3::zeros, |rate| rate * seconds(elapsed_us));
        if elapsed_us > LONGEST_US || way.dot(&way) > LONGEST_WAY_RAD * LONGEST_WAY_RAD {
            return Age::New;
        }
        let sigmas = |turn: &Vector3<f32>| {
            let both =
                self.sigma_rad.iter().zip(other.sigma_rad).map(|(one, other)| one * one + other * other);
            let squares = turn.iter().zip(both).map(|(angle, variance)| angle * angle / variance.max(1e-14));
            libm::sqrtf(squares.sum())
        };
        let away = sigmas(&way);
        if rate_rad_s.is_some() && away < LEAST_WAY_SIGMAS {
            return Age::Unknown(way);
        }
        let gone = self.attitude.angle_from(&other.attitude);
        let is_new = if elapsed_us < NEXT_US || rate_rad_s.is_none() {
            sigmas(&gone) > OFF_SIGMAS
        } else {
            sigmas(&(gone - way)) < OFF_SIGMAS.max(OFF_SHARE * away)
        };
        if is_new { Age::New } else { Age::Old }
    }
}

#[cfg(test)]
mod tests;
