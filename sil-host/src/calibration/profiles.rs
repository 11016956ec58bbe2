//! Star profiles fitted to the pixels of many stars: effective point spread functions (Anderson and King
//! 2000, PASP 112, 1360).
//!
//! In: [`Sight`]s whose places are known. Out: for each distance from the optical centre the coefficients of
//! the quadratic B-spline that [`fsw_pixels::profile`] reads: the share of a star's light that a pixel gets,
//! by its place from the star along and across the field's radius.
//!
//! All stars within a ring share a profile. In turn the spline is fitted by weighted least squares to the
//! pixels over their stars' fluxes, and flux and floor of each star to the spline ([`ROUNDS`] times). What
//! few pixels say is held by the third differences along either axis, which a smooth image has small.

use super::sights::Sight;
use fsw_core::image::calibration::{POINTS_PER_PX, PROFILE_REACH_PX, RADIAL_POINTS, TANGENTIAL_POINTS};
use nalgebra::{DMatrix, DVector};

/// Rounds of spline and fluxes.
const ROUNDS: u32 = 4;
/// Coefficients of a profile.
const COEFFICIENTS: usize = RADIAL_POINTS * TANGENTIAL_POINTS;
/// Stars that a profile needs: a ring is widened until it has them.
const STARS: usize = 600;
/// Half the width of a ring, px.
const RING_PX: f64 = 32.0;
/// Third difference of coefficients that is ordinary, share of the light in a pixel: a Gaussian of 1 px in
/// steps of a quarter has 0.004.
const ROUGHNESS: f64 = 0.004;
/// A pixel is left out farther from its fit, sigmas.
const OUTLIER: f64 = 6.0;
/// Least variance of a pixel, share of the star's light squared: gains that differ by 1 % in a pixel with a
/// quarter of the light.
const GAIN_ERROR: f64 = 0.0025 * 0.0025;

/// What is known of a star's light: flux, floor, noise of a pixel, digital numbers.
#[derive(Clone, Copy)]
struct Light {
    flux: f64,
    floor: f64,
}

/// Coefficients of a spline about a place, with their weights.
type Near = [(usize, f64); 9];
/// What a pixel has of a star's profile, where it has anything, and its value, digital numbers.
type ProfilePixel = (Option<Near>, f64);

/// The three points of a spline about a place, counted from `first`, with their weights.
fn basis(at: f64) -> (i64, [f64; 3]) {
    let index = (at + 0.5).floor();
    let past = at - index;
    let (before, after) = (0.5 * (0.5 - past).powi(2), 0.5 * (0.5 + past).powi(2));
    (index as i64 - 1, [before, 1.0 - before - after, after])
}

/// The coefficients about a place along and across the radius, px, and their weights; `None` beyond the
/// reach.
fn shares([along, across]: [f64; 2]) -> Option<Near> {
    let points = POINTS_PER_PX as f64;
    let (column, in_row) = basis((along + PROFILE_REACH_PX as f64) * points);
    let (row, in_column) = basis(across.abs() * points);
    if column < 0 || column + 2 >= RADIAL_POINTS as i64 || row + 2 >= TANGENTIAL_POINTS as i64 {
        return None;
    }
    let mut all = [(0, 0.0); 9];
    for (slot, (k, j)) in all.iter_mut().zip((0..3).flat_map(|j| (0..3).map(move |k| (k, j)))) {
        // The row before the first is its mirror image.
        let line = (row + j as i64).unsigned_abs() as usize;
        *slot = (line * RADIAL_POINTS + (column as usize + k), in_row[k] * in_column[j]);
    }
    Some(all)
}

/// A star's pixels along and across its radius, with their values.
fn turned(sight: &Sight, centre_px: [f64; 2]) -> Vec<ProfilePixel> {
    let from = [sight.at_px[0] - centre_px[0], sight.at_px[1] - centre_px[1]];
    let radius = libm::hypot(from[0], from[1]);
    let [cos, sin] = if radius > 0.5 { from.map(|part| part / radius) } else { [1.0, 0.0] };
    let place = |([x, y], value): ([f64; 2], f64)| (shares([x * cos + y * sin, y * cos - x * sin]), value);
    sight.near().map(place).collect()
}

/// The star's flux and floor by its pixels beyond the profile's reach and the sum of the others.
fn first_light(pixels: &[ProfilePixel]) -> Light {
    let mut outside: Vec<f64> =
        pixels.iter().filter(|(near, _)| near.is_none()).map(|pixel| pixel.1).collect();
    outside.sort_by(f64::total_cmp);
    let floor = outside.get(outside.len() / 2).copied().unwrap_or(0.0);
    let flux = pixels.iter().filter(|(near, _)| near.is_some()).map(|(_, value)| value - floor).sum();
    Light { flux, floor }
}

fn share(near: &Option<Near>, spline: &[f64]) -> f64 {
    near.as_ref().map_or(0.0, |all| all.iter().map(|(index, weight)| weight * spline[*index]).sum())
}

/// Flux and floor by least squares to a spline.
fn light(pixels: &[ProfilePixel], spline: &[f64]) -> Light {
    let (mut n, mut f, mut ff, mut s, mut fs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (near, value) in pixels {
        let share = share(near, spline);
        (n, f, ff, s, fs) = (n + 1.0, f + share, ff + share * share, s + value, fs + share * value);
    }
    let spread = n * ff - f * f;
    Light { flux: (n * fs - f * s) / spread, floor: (ff * s - f * fs) / spread }
}

/// Noise of an empty pixel, digital numbers, and those of an electron.
#[derive(Clone, Copy, Debug)]
pub struct PixelNoise {
    /// Standard deviation without light.
    pub empty_dn: f64,
    /// Digital numbers an electron.
    pub dn_per_e: f64,
}

/// Variance of a pixel over the star's flux squared.
fn variance(noise: PixelNoise, light: Light, share: f64) -> f64 {
    let photons = share.max(0.0) * noise.dn_per_e / light.flux;
    (noise.empty_dn / light.flux).powi(2) + photons + GAIN_ERROR
}

/// The spline of a ring of stars; `None` where they do not determine one.
fn ring(stars: &[&Sight], centre_px: [f64; 2], noise: PixelNoise) -> Option<Vec<f64>> {
    let pixels: Vec<_> = stars.iter().map(|sight| turned(sight, centre_px)).collect();
    let mut lights: Vec<_> = pixels.iter().map(|pixels| first_light(pixels)).collect();
    let mut spline: Option<Vec<f64>> = None;
    for _ in 0..ROUNDS {
        let (mut matrix, mut right) =
            (DMatrix::zeros(COEFFICIENTS, COEFFICIENTS), DVector::zeros(COEFFICIENTS));
        for (pixels, light) in
            pixels.iter().zip(&lights).filter(|(_, light)| light.flux > 20.0 * noise.empty_dn)
        {
            for (near, value) in pixels {
                let Some(near_points) = near else { continue };
                let seen = (value - light.floor) / light.flux;
                let model = spline.as_ref().map_or(seen, |spline| share(near, spline));
                let variance = variance(noise, *light, model);
                if (seen - model).powi(2) > OUTLIER * OUTLIER * variance {
                    continue;
                }
                for (i, a) in near_points {
                    right[*i] += a * seen / variance;
                    for (j, b) in near_points {
                        matrix[(*i, *j)] += a * b / variance;
                    }
                }
            }
        }
        smooth(&mut matrix);
        let solution = matrix.cholesky()?.solve(&right);
        // A star's light is in all pixels together once.
        let row_sum =
            |row: usize| (0..RADIAL_POINTS).map(|column| solution[row * RADIAL_POINTS + column]).sum::<f64>();
        let all = row_sum(0) + 2.0 * (1..TANGENTIAL_POINTS).map(row_sum).sum::<f64>();
        let whole = all / (POINTS_PER_PX * POINTS_PER_PX) as f64;
        let found: Vec<f64> = solution.iter().map(|point| point / whole).collect();
        lights = pixels.iter().map(|pixels| light(pixels, &found)).collect();
        spline = Some(found);
    }
    spline
}

/// Adds what is known of an image before any is seen: its third differences are small, and it is dark at the
/// edge.
fn smooth(matrix: &mut DMatrix<f64>) {
    let at = |row: i64, column: i64| row.unsigned_abs() as usize * RADIAL_POINTS + column as usize;
    let mut add = |places: [usize; 4]| {
        for (i, a) in places.iter().zip([-1.0, 3.0, -3.0, 1.0]) {
            for (j, b) in places.iter().zip([-1.0, 3.0, -3.0, 1.0]) {
                matrix[(*i, *j)] += a * b / (ROUGHNESS * ROUGHNESS);
            }
        }
    };
    let (rows, columns) = (TANGENTIAL_POINTS as i64, RADIAL_POINTS as i64);
    for row in 0..rows {
        (0..columns - 3).for_each(|column| add([0, 1, 2, 3].map(|k| at(row, column + k))));
    }
    for column in 0..columns {
        (-1..rows - 3).for_each(|row| add([0, 1, 2, 3].map(|k| at(row + k, column))));
    }
    for row in 0..rows {
        for column in 0..columns {
            if row + 1 >= rows || column == 0 || column + 1 == columns {
                let edge = at(row, column);
                matrix[(edge, edge)] += 1.0 / (ROUGHNESS * ROUGHNESS);
            }
        }
    }
}

/// Coefficients of the profiles at these distances from the optical centre; `None` where the stars do not
/// determine them.
pub fn fit(
    sights: &[Sight],
    centre_px: [f64; 2],
    radii_px: &[f64],
    noise: PixelNoise,
) -> Option<Vec<Vec<f64>>> {
    let distance = |sight: &Sight| libm::hypot(sight.at_px[0] - centre_px[0], sight.at_px[1] - centre_px[1]);
    super::in_parallel(radii_px, |radius_px| {
        let mut by_ring: Vec<(f64, &Sight)> =
            sights.iter().map(|sight| ((distance(sight) - radius_px).abs(), sight)).collect();
        by_ring.sort_by(|a, b| a.0.total_cmp(&b.0));
        let within = by_ring.iter().take_while(|(beside, _)| *beside <= RING_PX).count();
        let stars: Vec<&Sight> = by_ring.iter().take(within.max(STARS)).map(|(_, sight)| *sight).collect();
        ring(&stars, centre_px, noise)
    })
}

/// How much farther from the optical centre than the star's place its centre of gravity is, px.
pub fn outwards_px(points: &[f64]) -> f64 {
    let (mut light, mut moment) = (0.0, 0.0);
    for (row, line) in points.chunks_exact(RADIAL_POINTS).enumerate() {
        // All rows but the first have a mirror image.
        let weight = if row == 0 { 1.0 } else { 2.0 };
        for (column, point) in line.iter().enumerate() {
            light += weight * point;
            moment += weight * point * (column as f64 / POINTS_PER_PX as f64 - PROFILE_REACH_PX as f64);
        }
    }
    moment / light
}
