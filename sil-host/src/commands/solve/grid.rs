//! Lines of right ascension and declination over a picture.
//!
//! In: where the picture looks. Out: lines as places in the picture, px, with what they are labelled; four to
//! ten of each kind.

use super::pointing::{Pointing, unit_vector};
use crate::world::attitude::{apply, dot};
use fsw_core::frames::Direction;

/// Distances of lines, degrees.
const STEPS_DEG: [f64; 9] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0];
/// Lines along the shorter side of the picture, at least.
const LINES: f64 = 5.0;
/// Points of a line.
const POINTS: u32 = 240;
/// Lines of right ascension end before a pole, degrees.
const POLE_DEG: f64 = 89.9;

/// A line of the grid.
pub struct GridLine {
    /// What it is, degrees.
    pub label: String,
    /// Places along it, px; none where the camera does not see it.
    pub places: Vec<Option<[f32; 2]>>,
}

/// The lines that cross a picture.
pub fn lines(pointing: &Pointing) -> Vec<GridLine> {
    let camera = &pointing.camera;
    let corners: Option<Vec<_>> =
        camera.corners_px().into_iter().map(|corner| pointing.sky(corner)).collect();
    let (Some([ra_deg, dec_deg]), Some(corners)) = (pointing.middle_deg(), corners) else {
        return Vec::new();
    };
    let middle = unit_vector([ra_deg, dec_deg]);
    let cosine = corners.into_iter().map(|corner| dot(middle, corner)).fold(1.0, f64::min);
    let reach_deg = libm::acos(cosine).to_degrees();
    let parameters = camera.parameters();
    let shorter = parameters.width_px.min(parameters.height_px);
    let side_deg = (f64::from(shorter) / f64::from(parameters.focal_length_px)).to_degrees();
    let (low, high) = ((dec_deg - reach_deg).max(-POLE_DEG), (dec_deg + reach_deg).min(POLE_DEG));
    // Half the right ascensions in view: the circle of the corners seen from the pole.
    let ratio = libm::sin(reach_deg.to_radians()) / libm::cos(dec_deg.to_radians());
    let half_deg = if ratio < 1.0 { libm::asin(ratio).to_degrees() } else { 180.0 };
    let dec_step = step(side_deg / LINES);
    let ra_step = step(side_deg / LINES / libm::cos(dec_deg.to_radians()).max(0.05));
    let line = |label: String, at: &dyn Fn(f64) -> [f64; 2]| {
        let shares = (0..=POINTS).map(|point| f64::from(point) / f64::from(POINTS));
        GridLine { label, places: shares.map(|share| place(pointing, cosine, at(share))).collect() }
    };
    let of_dec = multiples(low, high, dec_step).map(|dec| {
        let label = format!("Dec {}", number(dec, dec_step));
        line(label, &|share| [ra_deg + half_deg * (2.0 * share - 1.0), dec])
    });
    let of_ra = multiples(ra_deg - half_deg, ra_deg + half_deg - 1e-6, ra_step).map(|ra| {
        let label = format!("RA {}", number(ra.rem_euclid(360.0), ra_step));
        line(label, &|share| [ra, low + (high - low) * share])
    });
    of_dec.chain(of_ra).collect()
}

/// Where the camera shows a direction, px; none outside the cone of the corners, into which a distortion may
/// fold it back.
fn place(pointing: &Pointing, cosine: f64, at_deg: [f64; 2]) -> Option<[f32; 2]> {
    let [x, y, z] = apply(&pointing.attitude, unit_vector(at_deg)).map(|part| part as f32);
    let direction =
        Direction::new(nalgebra::Vector3::new(x, y, z)).filter(|_| f64::from(z) > cosine - 0.02)?;
    pointing.camera.project(&direction)
}

/// The least step that is no shorter than this.
fn step(least_deg: f64) -> f64 {
    STEPS_DEG.into_iter().find(|step| *step >= least_deg).unwrap_or(30.0)
}

/// Multiples of a step between two numbers.
fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    ((low / step).ceil() as i32..=(high / step).floor() as i32).map(move |number| f64::from(number) * step)
}

/// A multiple of a step with the decimals it needs.
fn number(value: f64, step: f64) -> String {
    let decimals = usize::from(step < 1.0);
    format!("{value:.decimals$}")
}
