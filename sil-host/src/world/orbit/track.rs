//! From the samples of an orbit file to a smooth way.
//!
//! In: positions at times, in a file's frame, km. Out: nodes every `NODE_S` seconds in GCRF. Each sample is
//! turned to GCRF; the polynomial through the [`POINTS`] samples nearest to a node (Newton's divided
//! differences, any spacing) gives its position, velocity and acceleration. Velocities in a file are not
//! used: their units vary from maker to maker.
//!
//! Error, by leaving out every other sample of Jason-2's orbit (then 120 s apart, 1336 km high): 3 mm, near
//! the ends of the file 17 mm; with samples every 60 s, of a flown orbit of 450 km, 0.05 mm and 0.003 mm/s.
//! Jason-2's velocities come out within 1.2 mm/s of those in the file.

use super::integrator::Node;
use super::{LONGEST_S, MARGIN_S, MU_EARTH, OrbitError};
use crate::world::attitude::{Vector, apply};
use crate::world::time::earth_orientation::{EarthOrientation, gcrf_to_eme2000};
use crate::world::vector::{length, transposed};
use fsw_core::orbit::body::EARTH;

/// Samples that a polynomial goes through.
pub const POINTS: usize = 12;
/// Seconds between nodes: their curve is right to 0.01 mm in the lowest orbit.
const NODE_S: f64 = 30.0;
/// Samples may lie this part of a revolution apart.
const SPARSEST: f64 = 1.0 / 12.0;

/// The axes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// GCRF or ICRF.
    Gcrf,
    /// Mean equator and equinox of J2000.0.
    Eme2000,
    /// True equator, mean equinox, as SGP4 has it.
    Teme,
    /// Any realisation of ITRF; they agree to centimetres.
    Itrf,
}

impl Frame {
    /// From this frame to GCRF.
    fn to_gcrf(self, time_us: i64, orientation: &EarthOrientation) -> [Vector; 3] {
        transposed(&match self {
            Self::Gcrf => return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            Self::Eme2000 => gcrf_to_eme2000(),
            Self::Teme => orientation.gcrf_to_teme(time_us),
            Self::Itrf => orientation.gcrf_to_itrf(time_us),
        })
    }
}

/// Where a file says the satellite is.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// Axes of the positions.
    pub frame: Frame,
    /// TT (µs since J2000.0), rising, and position (km).
    pub places: Vec<(i64, Vector)>,
}

/// Nodes from just before `start_us` to just after `seconds` later.
///
/// # Errors
/// When the run is not within the samples, these are too few or too far apart, or the Earth's orientation is
/// not known.
pub(super) fn nodes(
    samples: &Samples,
    start_us: i64,
    seconds: u32,
    orientation: &EarthOrientation,
) -> Result<Vec<Node>, OrbitError> {
    let all = &samples.places;
    if all.len() < POINTS {
        return Err(OrbitError::Few(all.len()));
    }
    let end_us = start_us + i64::from(seconds) * 1_000_000;
    let span = (all[0].0, all[all.len() - 1].0);
    if start_us < span.0 || end_us > span.1 {
        return Err(OrbitError::Span(span.0, span.1));
    }
    if seconds > LONGEST_S {
        return Err(OrbitError::Duration(seconds));
    }
    // A whole polynomial's samples on either side, where the file has them.
    let from = all.partition_point(|place| place.0 <= start_us).saturating_sub(POINTS);
    let to = (all.partition_point(|place| place.0 < end_us) + POINTS).min(all.len());
    let places = &all[from..to];
    if matches!(samples.frame, Frame::Itrf | Frame::Teme)
        && let Some(day_us) = orientation.missing(places[0].0, places[places.len() - 1].0)
    {
        return Err(OrbitError::Orientation(day_us));
    }
    let seconds_of = |time_us: i64| (time_us - start_us) as f64 * 1e-6;
    let [least_km, _] = EARTH.orbit_km;
    for pair in places.windows(2) {
        let ((here_us, place), (next_us, _)) = (pair[0], pair[1]);
        let radius = length(place);
        if radius < least_km {
            return Err(OrbitError::Ground(seconds_of(here_us), least_km));
        }
        let gap_s = (next_us - here_us) as f64 * 1e-6;
        if gap_s > SPARSEST * std::f64::consts::TAU * radius * (radius / MU_EARTH).sqrt() {
            return Err(OrbitError::Sparse(here_us, gap_s));
        }
    }
    let turned = |(time_us, place): &(i64, Vector)| {
        (seconds_of(*time_us), apply(&samples.frame.to_gcrf(*time_us, orientation), *place))
    };
    let places: Vec<(f64, Vector)> = places.iter().map(turned).collect();
    let count = ((f64::from(seconds) + 2.0 * MARGIN_S) / NODE_S).ceil() as u32;
    Ok((0..=count).map(|k| node(&places, f64::from(k) * NODE_S - MARGIN_S)).collect())
}

/// The node at `t_s` by the polynomial through the samples about it.
fn node(places: &[(f64, Vector)], t_s: f64) -> Node {
    let after = places.partition_point(|place| place.0 <= t_s);
    let first = after.saturating_sub(POINTS / 2).min(places.len() - POINTS);
    let nearest = &places[first..first + POINTS];
    let mut node = Node { t_s, position: [0.0; 3], velocity: [0.0; 3], acceleration: [0.0; 3] };
    for axis in 0..3 {
        let mut differences: Vec<f64> = nearest.iter().map(|place| place.1[axis]).collect();
        for order in 1..POINTS {
            for k in (order..POINTS).rev() {
                let over = nearest[k].0 - nearest[k - order].0;
                differences[k] = (differences[k] - differences[k - 1]) / over;
            }
        }
        // Horner's scheme with the first derivative and half the second.
        let (mut value, mut slope, mut bend) = (0.0, 0.0, 0.0);
        for k in (0..POINTS).rev() {
            let t = t_s - nearest[k].0;
            bend = bend * t + slope;
            slope = slope * t + value;
            value = value * t + differences[k];
        }
        node.position[axis] = value;
        node.velocity[axis] = slope;
        node.acceleration[axis] = 2.0 * bend;
    }
    node
}

#[cfg(test)]
mod tests;
