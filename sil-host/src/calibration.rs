//! Makes what the flight code wants to know of a lens and its pixels from pictures of the sky: a
//! [calibration](fsw_core::image::calibration).
//!
//! In: the stars of pictures whose attitudes are known ([`sights`]), a camera. Out: the bytes of the file.
//! Nothing is asked of the world but pictures: those of a user's own camera serve as well.
//!
//! 1. Profiles are fitted to the pixels, at distances from the optical centre `PROFILE_STEP_PX` apart.
//! 2. With them the flight code measures each star; the attitudes are fitted anew to what it finds, and both
//!    are done once more (`ROUNDS`).
//! 3. What is missing to where the stars should be becomes the displacement by colour of each profile and the
//!    correction tables.
//! 4. What is then left beyond the noise in every `JUDGING_OF`th picture, which the fits have not seen, is the
//!    part of a centroid's error that is no noise; it is written into the file.

pub mod centroid;
mod corrections;
pub mod fit;
mod format;
pub mod pictures;
mod profiles;
pub mod sights;

use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use crate::world::attitude::{Vector, apply};
use crate::world::lens::optics::Optics;
use corrections::Miss;
use fit::{Sighting, View};
pub use format::with_gain;
use format::{Content, Layout, StarProfile};
use fsw_core::image::calibration::{Calibration, PHASES};
use profiles::PixelNoise;
use sights::Sight;

/// From a profile to the next, px.
const PROFILE_STEP_PX: u16 = 64;
/// From a correction table to the next, px.
const TABLE_STEP_PX: u16 = 200;
/// Half the side of a star's window, px.
const HALF_WINDOW_PX: u16 = 16;
/// Rounds of profiles, centroids and attitudes.
const ROUNDS: u32 = 2;
/// Fewest stars, all pictures together.
const FEWEST_STARS: usize = 1500;
/// Error of a centroid beside its noise before any is known, px.
const FIRST_RESIDUAL_PX: f64 = 0.01;
/// A centroid that misses by more, in its own sigmas, is disturbed.
const OUTLIER: f64 = 5.0;
/// Half the width of the ring over which a displacement by colour is taken, px: it is as smooth as the lens.
const COLOUR_RING_PX: f64 = 96.0;
/// Of so many pictures one is not fitted but judges the fit.
const JUDGING_OF: usize = 5;
/// Rounds of the fit of what is left and the weights that depend on it.
const RESIDUAL_ROUNDS: u32 = 10;

/// A calibration, and what it was made from.
#[derive(Debug, Clone)]
pub struct Built {
    /// Bytes of the file.
    pub bytes: Vec<u8>,
    /// Stars, all pictures together.
    pub stars: usize,
    /// What the corrections leave of a centroid's error without noise, px an axis.
    pub residual_px: f64,
    /// The pictures with their attitudes, and where the centres of gravity of their stars' images are.
    pub views: Vec<View>,
}

/// A sight whose star the flight code found.
struct Found<'s> {
    sight: &'s Sight,
    /// Measured place, px.
    at_px: [f64; 2],
    /// Standard deviation an axis by noise alone, px.
    noise_px: f64,
}

impl Found<'_> {
    /// What is to be added to the measured place, px, and its length in sigmas.
    fn miss_px(&self) -> ([f64; 2], f64) {
        let miss = [0, 1].map(|axis| self.sight.at_px[axis] - self.at_px[axis]);
        (miss, libm::hypot(miss[0], miss[1]) / self.noise_px.hypot(3.0 * FIRST_RESIDUAL_PX))
    }
}

/// What the flight code finds of the stars with a calibration, those that are disturbed left out.
fn found<'s>(sights: &'s [Sight], bits: u8, calibration: &Calibration) -> Vec<Found<'s>> {
    let residual_px = f64::from(calibration.residual_px());
    let measured = in_parallel(sights, |sight| {
        let seen: Option<([f64; 2], f64)> =
            centroid::find(sight.window, bits, sight.pixels.clone(), Some(calibration), sight.at_px);
        Some(seen.map(|(at_px, sigma_px)| {
            let variance = sigma_px * sigma_px - residual_px * residual_px;
            Found { sight, at_px, noise_px: variance.max(1e-8).sqrt() }
        }))
    });
    let near = |found: &Found| found.miss_px().1 < OUTLIER;
    measured.into_iter().flatten().flatten().filter(near).collect()
}

/// The pictures with what was found of their stars, so many pixels farther from the optical centre than
/// measured as `outwards_px` says of a distance from it.
fn views(
    found: &[Found],
    attitudes: &[[Vector; 3]],
    centre_px: [f64; 2],
    outwards_px: impl Fn(f64) -> f64,
) -> Vec<View> {
    let mut views: Vec<View> =
        attitudes.iter().map(|attitude| View { attitude: *attitude, stars: Vec::new() }).collect();
    for Found { sight, at_px, noise_px } in found {
        let Sight { hip, direction, .. } = **sight;
        let sigma_px = noise_px.hypot(FIRST_RESIDUAL_PX);
        let from = [0, 1].map(|axis| at_px[axis] - centre_px[axis]);
        let distance = libm::hypot(from[0], from[1]).max(1.0);
        let at_px = [0, 1].map(|axis| at_px[axis] + outwards_px(distance) * from[axis] / distance);
        views[sight.picture].stars.push(Sighting { hip, direction, at_px, sigma_px });
    }
    views
}

/// Noise of an empty pixel, digital numbers: the median absolute deviation along the windows' first lines.
fn empty_dn(sights: &[Sight]) -> f64 {
    let middle = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(1.0)
    };
    let of_sight = |sight: &Sight| {
        let line: Vec<f64> =
            sight.pixels.iter().take(sight.window.width.into()).map(|v| f64::from(*v)).collect();
        let floor = middle(&mut line.clone());
        middle(&mut line.iter().map(|value| (value - floor).abs()).collect())
    };
    // Of normal noise it is 0.6745 standard deviations.
    middle(&mut sights.iter().map(of_sight).collect()) / 0.6745
}

/// How far stars at this distance from the optical centre are displaced outwards for each magnitude of B-V,
/// px: a line through their misses.
fn colour_px(found: &[Found], centre_px: [f64; 2], radius_px: f64, colour: f64) -> f64 {
    let (mut seen, mut all) = (0.0, 1e-9);
    for star in found {
        let from = [0, 1].map(|axis| star.at_px[axis] - centre_px[axis]);
        let distance = libm::hypot(from[0], from[1]).max(1.0);
        if (distance - radius_px).abs() > COLOUR_RING_PX {
            continue;
        }
        let outwards = -(0..2).map(|axis| star.miss_px().0[axis] * from[axis] / distance).sum::<f64>();
        let weight = star.noise_px.hypot(FIRST_RESIDUAL_PX).powi(-2);
        let b_v = star.sight.b_v - colour;
        seen += weight * b_v * outwards;
        all += weight * b_v * b_v;
    }
    seen / all
}

/// What is to be corrected at the found stars, their displacement by colour taken off.
fn misses(found: &[Found], calibration: &Calibration) -> Vec<Miss> {
    let miss = |star: &Found| {
        let shift = calibration.colour_shift_px(star.at_px.map(|px| px as f32), star.sight.b_v as f32);
        let (miss, _) = star.miss_px();
        Miss {
            at_px: star.at_px,
            correction_px: [0, 1].map(|axis| miss[axis] + f64::from(shift[axis])),
            sigma_px: star.noise_px.hypot(FIRST_RESIDUAL_PX),
        }
    };
    found.iter().map(miss).collect()
}

/// What a calibration leaves of the errors of centroids without noise, px an axis.
fn residual_px(found: &[Found], calibration: &Calibration) -> f64 {
    let both = |(star, miss): (&Found, Miss)| miss.correction_px.map(|px| (star.noise_px.powi(2), px * px));
    beyond_noise_px(&found.iter().zip(misses(found, calibration)).flat_map(both).collect::<Vec<_>>())
}

/// `r` of `E[miss²] = r² + a noise²`, px, from pairs of `noise²` and `miss²`, by least squares weighted with
/// the squares' own scatter. `a` takes up that the flight code's noise is an upper bound. Never less than a
/// standard deviation of `r²`: fewer stars prove less.
fn beyond_noise_px(squares: &[(f64, f64)]) -> f64 {
    let (mut residual2, mut share) = (FIRST_RESIDUAL_PX.powi(2), 1.0);
    for _ in 0..RESIDUAL_ROUNDS {
        let [mut w, mut v, mut vv, mut m, mut vm] = [0.0; 5];
        for (noise2, miss2) in squares {
            // A square of a normal error scatters by sqrt(2) of its mean.
            let weight = 0.5 / (residual2 + share * noise2).powi(2);
            (w, v, vv) = (w + weight, v + weight * noise2, vv + weight * noise2 * noise2);
            (m, vm) = (m + weight * miss2, vm + weight * noise2 * miss2);
        }
        let determinant = w * vv - v * v;
        if determinant.is_nan() || determinant <= 0.0 {
            break;
        }
        residual2 = ((vv * m - v * vm) / determinant).max((vv / determinant).sqrt());
        share = ((w * vm - v * m) / determinant).max(0.1);
    }
    residual2.sqrt()
}

/// A calibration just made.
fn opened(bytes: &[u8]) -> Result<Calibration<'_>, HostError> {
    Calibration::open(bytes)
        .map_err(|_| HostError::usage("the star profiles are no calibration", "report this"))
}

/// Pictures of too few stars, or of none that the flight code finds.
fn few(what: impl Into<String>) -> HostError {
    HostError::usage(what.into(), "give more pictures of the sky, or longer exposures")
}

fn unseen() -> HostError {
    few("the flight code does not find the stars of these pictures")
}

/// What a calibration is made with, beside the stars.
struct Bench<'c> {
    camera: &'c CameraFile,
    optics: Optics,
    layout: Layout,
    bits: u8,
    noise: PixelNoise,
    /// Mean colour of the stars, B-V.
    colour: f64,
}

impl<'c> Bench<'c> {
    fn new(
        sights: &[Sight],
        camera: &'c CameraFile,
        (bits, full_well_e): (u8, f64),
    ) -> Result<Self, HostError> {
        let refused = || HostError::usage("only rectilinear cameras are calibrated", "give another camera");
        Ok(Self {
            camera,
            optics: Optics::new(camera).ok_or_else(refused)?,
            layout: Layout::new(camera, full_well_e)?,
            bits,
            noise: PixelNoise {
                empty_dn: empty_dn(sights),
                dn_per_e: f64::from((1u32 << bits) - 1) / full_well_e,
            },
            colour: sights.iter().map(|sight| sight.b_v).sum::<f64>() / sights.len() as f64,
        })
    }

    /// Profiles of these stars, of a displacement by colour not known yet.
    fn profiles(&self, sights: &[Sight]) -> Result<Vec<StarProfile>, HostError> {
        let points = profiles::fit(sights, self.layout.centre_px, &self.layout.radii_px(), self.noise);
        let profile = |points| StarProfile { points, colour_px: 0.0 };
        Ok(points.ok_or_else(unseen)?.into_iter().map(profile).collect())
    }

    /// Bytes of a calibration; without tables nothing is corrected.
    fn bytes(&self, profiles: &[StarProfile], tables: Option<&[Vec<[f64; 2]>]>, residual_px: f64) -> Vec<u8> {
        let [columns, rows] = self.layout.nodes().count;
        let plain = vec![vec![[0.0; 2]; PHASES * PHASES]; columns * rows];
        let content =
            Content { profiles, tables: tables.unwrap_or(&plain), residual_px, colour: self.colour };
        self.layout.bytes(&content)
    }

    /// Fits the attitudes anew to what the flight code finds with profiles of these stars, and says where
    /// they then should be.
    fn align(&self, sights: &mut [Sight], attitudes: &mut Vec<[Vector; 3]>) -> Result<(), HostError> {
        let bytes = self.bytes(&self.profiles(sights)?, None, FIRST_RESIDUAL_PX);
        let views =
            views(&found(sights, self.bits, &opened(&bytes)?), attitudes, self.layout.centre_px, |_| 0.0);
        *attitudes = views.iter().map(|view| fit::attitude(self.camera, view)).collect();
        for sight in sights {
            let seen = self.optics.project(apply(&attitudes[sight.picture], sight.direction));
            sight.at_px = seen.unwrap_or(sight.at_px);
        }
        Ok(())
    }
}

/// Builds the calibration of `camera` from the stars of pictures of so many bits, taken in these attitudes,
/// ICRS to sensor. `full_well_e` is the charge at full scale, electrons.
///
/// # Errors
/// Where the stars are too few, or the flight code does not find them.
pub fn build(
    mut sights: Vec<Sight>,
    mut attitudes: Vec<[Vector; 3]>,
    camera: &CameraFile,
    (bits, full_well_e): (u8, f64),
) -> Result<Built, HostError> {
    if sights.len() < FEWEST_STARS {
        return Err(few(format!("{} stars do not give star profiles, {FEWEST_STARS} do", sights.len())));
    }
    let bench = Bench::new(&sights, camera, (bits, full_well_e))?;
    for _ in 1..ROUNDS {
        bench.align(&mut sights, &mut attitudes)?;
    }
    let (judging, fitted): (Vec<Sight>, Vec<Sight>) =
        sights.into_iter().partition(|sight| sight.picture % JUDGING_OF == JUDGING_OF - 1);
    let mut profiles = bench.profiles(&fitted)?;
    let bytes = bench.bytes(&profiles, None, FIRST_RESIDUAL_PX);
    let uncorrected = opened(&bytes)?;
    let mut seen = found(&fitted, bits, &uncorrected);
    let centre_px = bench.layout.centre_px;
    for (profile, radius_px) in profiles.iter_mut().zip(bench.layout.radii_px()) {
        profile.colour_px = colour_px(&seen, centre_px, radius_px, bench.colour);
    }
    let bytes = bench.bytes(&profiles, None, FIRST_RESIDUAL_PX);
    let misses = misses(&seen, &opened(&bytes)?);
    let tables = corrections::tables(&misses, &bench.layout.nodes()).ok_or_else(unseen)?;
    let bytes = bench.bytes(&profiles, Some(&tables), FIRST_RESIDUAL_PX);
    let corrected = opened(&bytes)?;
    let residual_px = residual_px(&found(&judging, bits, &corrected), &corrected);
    seen.extend(found(&judging, bits, &uncorrected));
    let outwards_px = |distance_px: f64| {
        let nearest = (distance_px / f64::from(PROFILE_STEP_PX)).round() as usize;
        profiles
            .get(nearest.min(profiles.len() - 1))
            .map_or(0.0, |profile| profiles::outwards_px(&profile.points))
    };
    Ok(Built {
        stars: seen.len(),
        views: views(&seen, &attitudes, centre_px, outwards_px),
        bytes: bench.bytes(&profiles, Some(&tables), residual_px),
        residual_px,
    })
}

/// Maps on all processors, in order. Not by rayon: callers hold a lock, and a worker of a pool that waits
/// takes up other work, which may want the same lock.
fn in_parallel<'t, T: Sync, R: Send>(
    items: &'t [T],
    map: impl Fn(&'t T) -> Option<R> + Sync,
) -> Option<Vec<R>> {
    let workers = std::thread::available_parallelism().map_or(1, |count| count.get());
    let share = items.len().div_ceil(workers).max(1);
    std::thread::scope(|scope| {
        let parts: Vec<_> = items
            .chunks(share)
            .map(|part| scope.spawn(|| part.iter().map(&map).collect::<Option<Vec<_>>>()))
            .collect();
        let mut all = Vec::with_capacity(items.len());
        for part in parts {
            // A thread that panicked has said why.
            all.extend(part.join().ok().flatten()?);
        }
        Some(all)
    })
}

#[cfg(test)]
mod tests;
