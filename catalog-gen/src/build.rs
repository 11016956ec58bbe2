//! From the star source to a catalogue: motion, blending, even thinning, proximity, bytes.
//!
//! 1. Every source star is carried to the epoch and close components become blobs ([`crate::blend`]).
//! 2. A blob to the magnitude limit is kept when at most `brighter_neighbours` brighter blobs lie within
//!    `thinning_radius_deg`. All brighter blobs count, kept or not, so the result does not depend on any
//!    order, and poor regions lose nothing while the Milky Way is cut down to the same density.
//! 3. A kept star is flagged when another blob within `proximity_deg` is brighter than its own V + 2.5 mag (a
//!    tenth of its light, which at that distance moves a centroid by a tenth of a pixel or more). The source
//!    ends at V 8, so the rule is complete for stars to V 5.5 and knows the neighbours to V 8 of fainter
//!    ones.
//! 4. [`mod@crate::assemble`] writes the bytes.

use crate::assemble::{CatalogueStar, TableParameters, assemble};
use crate::blend::{Blob, blend, centi, chord_square};
use crate::grid::CellGrid;
use crate::parameters::{BuildError, BuildParameters, FLIGHT_BYTES, chord};
use crate::source::{SourceStar, checksum};

/// Two stars closer than this share of the proximity radius are one blob.
const BLEND_SHARE: f64 = 0.25;
/// A neighbour with less light than this, in magnitudes below the star, does not disturb its centroid.
const DISTURBING_MAGNITUDES: f64 = 2.5;

/// Builds a catalogue.
///
/// # Errors
/// When a parameter is out of its range or the result would not fit the format.
pub fn build(stars: &[SourceStar], parameters: &BuildParameters) -> Result<Vec<u8>, BuildError> {
    parameters.check()?;
    let blobs = blend(stars, parameters.epoch_year, chord(parameters.proximity_deg * BLEND_SHARE));
    let disturbed = disturbed(&blobs, chord(parameters.proximity_deg));
    let chosen = even(&blobs, parameters);
    let chosen: Vec<CatalogueStar> = chosen
        .into_iter()
        .map(|index| {
            let Blob { direction, hip, v, b_v } = blobs[index];
            CatalogueStar { direction, hip, v, b_v, proximity: disturbed[index] }
        })
        .collect();
    let tables = TableParameters {
        max_separation_deg: parameters.max_separation_deg,
        epoch_year: parameters.epoch_year,
        field_deg: parameters.field_deg,
        source_crc: checksum(stars),
    };
    assemble(&chosen, &tables)
}

/// Builds the catalogue that flies behind a field of this size, degrees: as dense as the reference's, 37
/// stars a field, where that fits into [`FLIGHT_BYTES`], else with fewer brighter neighbours (27, 18 or 9
/// stars a field).
///
/// # Errors
/// When the longer side of the field is not 8 to 40 deg.
pub fn build_for_flight(
    stars: &[SourceStar],
    field_deg: [f64; 2],
    epoch_year: f64,
) -> Result<Vec<u8>, BuildError> {
    let mut neighbours = BuildParameters::reference().brighter_neighbours;
    loop {
        let bytes = build(stars, &BuildParameters::for_flight(field_deg, epoch_year, neighbours)?)?;
        if bytes.len() <= FLIGHT_BYTES || neighbours == 0 {
            return Ok(bytes);
        }
        neighbours -= 1;
    }
}

/// Whether a bright enough neighbour stands within the chord, for each blob.
fn disturbed(blobs: &[Blob], proximity_chord: f64) -> Vec<bool> {
    let points: Vec<[f64; 3]> = blobs.iter().map(|blob| blob.direction).collect();
    let grid = CellGrid::new(&points, proximity_chord);
    let mut disturbed = vec![false; blobs.len()];
    grid.candidate_pairs(|first, second| {
        let (first, second) = (grid.order()[first] as usize, grid.order()[second] as usize);
        if chord_square(points[first], points[second]) < proximity_chord * proximity_chord {
            disturbed[first] |= blobs[second].v < blobs[first].v + DISTURBING_MAGNITUDES;
            disturbed[second] |= blobs[first].v < blobs[second].v + DISTURBING_MAGNITUDES;
        }
    });
    disturbed
}

/// Indices of the blobs to keep; `blobs` are sorted by brightness, so a brighter blob is one with a smaller
/// index.
fn even(blobs: &[Blob], parameters: &BuildParameters) -> Vec<usize> {
    let limit = centi(parameters.magnitude);
    let bright = blobs.partition_point(|blob| blob.v_centi() <= limit);
    let points: Vec<[f64; 3]> = blobs[..bright].iter().map(|blob| blob.direction).collect();
    let radius = chord(parameters.thinning_radius_deg);
    let grid = CellGrid::new(&points, radius);
    let most = parameters.brighter_neighbours as usize;
    let is_kept = |&index: &usize| {
        let brighter = grid
            .candidates(points[index])
            .filter(|&other| other < index && chord_square(points[index], points[other]) <= radius * radius);
        brighter.take(most + 1).count() <= most
    };
    (0..bright).filter(is_kept).collect()
}
