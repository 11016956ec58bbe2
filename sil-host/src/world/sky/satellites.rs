//! Other satellites: points that cross the field and draw streaks.
//!
//! In: a seed, a rate of crossings, the attitude over time. Out: the satellites whose light may be seen about
//! a time, each on a great circle. In every stretch of two minutes their number is a Poisson number; each
//! stands at one moment in the field, at a random place, and goes in a random direction at 0.02 to 1.5 deg/s
//! (the logarithm even), as satellites between 500 km and the geostationary ring do. It glints: its light is
//! that of a star of V = 1 to 6.5 at that moment and falls off as a Gaussian of 40 s, so that none appears or
//! goes out at once. Shadow and real orbits are left out.

use crate::world::attitude::{Vector, apply, matrix};
use crate::world::lens::optics::Optics;
use crate::world::motion::Motion;
use crate::world::noise::{Noise, Stream};
use crate::world::vector::{cross, plus, times, transposed, unit};
use std::f64::consts::TAU;

/// Length of a stretch, s.
const STRETCH_S: f64 = 120.0;
/// Width of a glint, s.
const GLINT_S: f64 = 40.0;
/// Glints are followed for so long before and after their moment: five widths, 14 magnitudes.
const REACH_S: f64 = 200.0;
/// Angular rates, deg/s.
const RATE_DEG_S: (f64, f64) = (0.02, 1.5);
/// Magnitudes at the moment.
const V: (f64, f64) = (1.0, 6.5);
/// Most crossings an hour.
pub const CROSSINGS_AN_HOUR_MAX: f64 = 3_600.0;

/// A satellite on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Satellite {
    moment_s: f64,
    /// Direction at the moment, and the way it goes; unit vectors, ICRS.
    there: Vector,
    ahead: Vector,
    rate_rad_s: f64,
    v: f64,
}

impl Satellite {
    /// Unit vector to it, ICRS.
    pub fn direction(&self, t_s: f64) -> Vector {
        let (s, c) = libm::sincos(self.rate_rad_s * (t_s - self.moment_s));
        plus(times(c, self.there), s, self.ahead)
    }

    /// Visual magnitude.
    pub fn v(&self, t_s: f64) -> f64 {
        let widths = (t_s - self.moment_s) / GLINT_S;
        // exp(-x²/2) is a magnitude of 2.5 log10(e) x²/2.
        self.v + 0.542_868_102_379_064_9 * widths * widths
    }

    /// Angular rate, rad/s.
    pub fn rate_rad_s(&self) -> f64 {
        self.rate_rad_s
    }
}

/// The satellites whose light may be seen at `t_s`, in the order of their moments' stretches.
pub fn about(seed: u64, t_s: f64, an_hour: f64, motion: &Motion, optics: &Optics) -> Vec<Satellite> {
    let mut seen = Vec::new();
    if an_hour <= 0.0 {
        return seen;
    }
    let stretch_of = |t: f64| (t / STRETCH_S).floor() as i64;
    for stretch in stretch_of(t_s - REACH_S)..=stretch_of(t_s + REACH_S) {
        let noise = Noise::new(seed, stretch as u64, Stream::Satellite);
        let count = noise.poisson(0, 0, an_hour * STRETCH_S / 3600.0) as u32;
        for index in 1..=count {
            let satellite = satellite(&noise, index, stretch, motion, optics);
            seen.extend(satellite.filter(|satellite| (t_s - satellite.moment_s).abs() < REACH_S));
        }
    }
    seen
}

/// `None` where the place on the detector has no direction.
fn satellite(noise: &Noise, index: u32, stretch: i64, motion: &Motion, optics: &Optics) -> Option<Satellite> {
    let random = |what, low: f64, high: f64| low + (high - low) * noise.uniform(index, what);
    let moment_s = STRETCH_S * (stretch as f64 + random(0, 0.0, 1.0));
    let [width, height] = optics.size_px();
    let in_field = optics.unproject([random(1, -0.5, width - 0.5), random(2, -0.5, height - 0.5)])?;
    let there = apply(&transposed(&matrix(motion.at(moment_s))), in_field);
    let aside = unit(cross(there, if there[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] }));
    let (s, c) = libm::sincos(random(3, 0.0, TAU));
    let ahead = plus(times(c, aside), s, cross(there, aside));
    let (slow, fast) = RATE_DEG_S;
    let rate_rad_s = (slow * libm::pow(fast / slow, random(4, 0.0, 1.0))).to_radians();
    Some(Satellite { moment_s, there, ahead, rate_rad_s, v: random(5, V.0, V.1) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::camera_file::CameraFile;
    use crate::world::attitude::dot;
    use crate::world::vector::minus;

    fn optics() -> Optics {
        Optics::new(&CameraFile::reference()).unwrap()
    }

    const STILL: Motion = Motion::fixed([0.0, 0.0, 0.0, 1.0]);

    #[test]
    fn as_many_cross_as_set_and_each_passes_through_the_field() {
        let optics = optics();
        let mut moments = Vec::new();
        for t in (0..100_000).step_by(60) {
            for satellite in about(7, f64::from(t), 30.0, &STILL, &optics) {
                if !moments.contains(&satellite.moment_s) {
                    moments.push(satellite.moment_s);
                    let pixel = optics.project(satellite.direction(satellite.moment_s)).unwrap();
                    assert!(optics.on_detector(pixel));
                }
            }
        }
        let inside = moments.iter().filter(|t| (0.0..100_000.0).contains(*t)).count() as f64;
        // 833 expected: a standard deviation of 29; four of them fail a right generator once in 16,000.
        assert!((inside - 833.3).abs() < 4.0 * 28.9, "{inside}");
        assert!(about(7, 50.0, 0.0, &STILL, &optics).is_empty());
    }

    #[test]
    fn a_satellite_goes_on_a_great_circle_at_its_rate_and_glints() {
        let satellites = about(3, 1_000.0, 300.0, &STILL, &optics());
        assert!(satellites.len() > 10);
        for satellite in satellites {
            let (a, b) = (satellite.direction(1_000.0), satellite.direction(1_000.1));
            assert!((dot(a, a) - 1.0).abs() < 1e-12);
            let moved = dot(minus(b, a), minus(b, a)).sqrt();
            assert!((moved / satellite.rate_rad_s - 0.1).abs() < 1e-6);
            assert!((0.02..1.51).contains(&satellite.rate_rad_s.to_degrees()));
            let moment = satellite.moment_s;
            assert!((1.0..6.5).contains(&satellite.v(moment)));
            let lost = satellite.v(moment + GLINT_S) - satellite.v(moment);
            assert!((libm::pow(10.0, -0.4 * lost) - libm::exp(-0.5)).abs() < 1e-12);
            assert!(satellite.v(moment + REACH_S) > satellite.v(moment) + 13.0);
        }
    }

    #[test]
    fn the_same_satellites_are_there_whenever_they_are_asked_for() {
        let optics = optics();
        let early = about(3, 1_000.0, 60.0, &STILL, &optics);
        let late = about(3, 1_100.0, 60.0, &STILL, &optics);
        let both = early.iter().filter(|s| (s.moment_s - 1_100.0).abs() < REACH_S).collect::<Vec<_>>();
        assert!(!both.is_empty() && both.iter().all(|satellite| late.contains(satellite)));
        assert_ne!(early, about(4, 1_000.0, 60.0, &STILL, &optics));
    }
}
