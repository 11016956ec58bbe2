//! What a detector sees: components closer than about a pixel are one blob.
//!
//! In: stars at the mission's epoch. Out: blobs, brightest first. The brightest star takes in every fainter
//! one within the blend radius (a quarter of the proximity radius: 60 arcsec, 0.9 px, for the reference
//! camera); the blob stands at the centre of light of its members, `sum f u / |sum f u|` with f = 10^(-0.4
//! V), carries the light of all (`V = -2.5 log10 sum f`, the colour likewise from the sums in B and V) and
//! the number of the brightest. Dropping the companions instead would put the blob up to half its size aside:
//! 30 arcsec for an equal pair, five times the sensor's error. Companions beyond that, yet within the
//! proximity radius, disturb a centroid without becoming one with it: see [`mod@crate::build`].

use crate::grid::CellGrid;
use crate::source::{SourceStar, normalised};

/// One point of light, at the epoch it was made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blob {
    /// Unit vector, ICRS.
    pub direction: [f64; 3],
    /// Hipparcos number of the brightest member.
    pub hip: u32,
    /// V of all members together.
    pub v: f64,
    /// B-V of all members together.
    pub b_v: f64,
}

impl Blob {
    /// V in hundredths, as the catalogue stores and sorts it.
    pub fn v_centi(&self) -> i32 {
        centi(self.v)
    }
}

/// Hundredths of a magnitude, rounded.
pub(crate) fn centi(magnitude: f64) -> i32 {
    (magnitude * 100.0).round() as i32
}

/// Square of the chord between two unit vectors.
pub(crate) fn chord_square([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> f64 {
    (a - x) * (a - x) + (b - y) * (b - y) + (c - z) * (c - z)
}

/// The stars as blobs at `epoch_year`, brightest first (by V in hundredths, then by Hipparcos number).
///
/// `blend_chord` is the chord within which stars are one blob.
pub fn blend(stars: &[SourceStar], epoch_year: f64, blend_chord: f64) -> Vec<Blob> {
    let mut singles: Vec<Blob> = stars
        .iter()
        .map(|star| Blob {
            direction: star.direction_at(epoch_year),
            hip: star.hip,
            v: star.v,
            b_v: star.b_v,
        })
        .collect();
    sort(&mut singles);
    let points: Vec<[f64; 3]> = singles.iter().map(|single| single.direction).collect();
    let grid = CellGrid::new(&points, blend_chord);
    let mut taken = vec![false; singles.len()];
    let mut blobs = Vec::with_capacity(singles.len());
    for index in 0..singles.len() {
        if taken[index] {
            continue;
        }
        let mut members: Vec<usize> = grid
            .candidates(points[index])
            .filter(|&other| {
                other > index
                    && !taken[other]
                    && chord_square(points[index], points[other]) < blend_chord * blend_chord
            })
            .collect();
        // A fixed order of summing, whatever the grid's: the bytes must not depend on it.
        members.sort_unstable();
        members.iter().for_each(|&member| taken[member] = true);
        blobs.push(combine(&singles[index], members.iter().map(|&member| &singles[member])));
    }
    sort(&mut blobs);
    blobs
}

/// Brightest first. The order is that of the catalogue's hundredths, so that it can be checked in the file.
fn sort(blobs: &mut [Blob]) {
    blobs.sort_by_key(|blob| (blob.v_centi(), blob.hip));
}

fn combine<'a>(first: &Blob, others: impl Iterator<Item = &'a Blob>) -> Blob {
    let light = |magnitude: f64| libm::pow(10.0, -0.4 * magnitude);
    let mut blob = *first;
    for other in others {
        let (visual, more_visual) = (light(blob.v), light(other.v));
        let blue = light(blob.v + blob.b_v) + light(other.v + other.b_v);
        let [mut x, mut y, mut z] = blob.direction;
        let [other_x, other_y, other_z] = other.direction;
        x = x * visual + other_x * more_visual;
        y = y * visual + other_y * more_visual;
        z = z * visual + other_z * more_visual;
        blob.direction = normalised([x, y, z]);
        blob.v = -2.5 * libm::log10(visual + more_visual);
        blob.b_v = -2.5 * libm::log10(blue) - blob.v;
    }
    blob
}

#[cfg(test)]
mod tests {
    use super::*;

    fn star(hip: u32, dec_arcsec: f64, v: f64, b_v: f64) -> SourceStar {
        let dec_deg = dec_arcsec / 3600.0;
        SourceStar { hip, ra_deg: 10.0, dec_deg, pm_ra_mas_yr: 0.0, pm_dec_mas_yr: 0.0, v, b_v }
    }

    fn arcsec(value: f64) -> f64 {
        crate::parameters::chord(value / 3600.0)
    }

    #[test]
    fn an_equal_pair_becomes_one_blob_halfway_and_three_quarters_of_a_magnitude_brighter() {
        let stars = [star(7, 20.0, 5.0, 0.5), star(3, 0.0, 5.0, 0.5), star(9, 600.0, 4.0, 0.0)];
        let blobs = blend(&stars, 1991.25, arcsec(60.0));
        assert_eq!(blobs.iter().map(|blob| blob.hip).collect::<Vec<_>>(), [9, 3]);
        let pair = blobs[1];
        assert!((pair.v - 4.247_425).abs() < 1e-6 && (pair.b_v - 0.5).abs() < 1e-9);
        let dec_arcsec = libm::asin(pair.direction[2]).to_degrees() * 3600.0;
        assert!((dec_arcsec - 10.0).abs() < 1e-6);
    }

    #[test]
    fn a_faint_companion_hardly_moves_its_star_and_a_distant_one_does_not() {
        let stars = [star(1, 0.0, 2.0, 0.0), star(2, 40.0, 7.0, 1.0), star(3, 61.0, 2.0, 0.0)];
        let blobs = blend(&stars, 1991.25, arcsec(60.0));
        assert_eq!(blobs.len(), 2);
        let moved = libm::asin(blobs[0].direction[2]).to_degrees() * 3600.0;
        assert!((moved - 40.0 * 0.01 / 1.01).abs() < 1e-6, "1 % of the light, 1 % of the way");
    }
}
