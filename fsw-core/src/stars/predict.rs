//! Predicted detector positions of the catalogue stars for an attitude.
//!
//! In: attitude, camera, catalogue. Out: stars with their pixel positions, brightest first. One pass over the
//! catalogue with one dot product a star; only those inside the detector's circumscribed cone are projected.

use crate::camera::Camera;
use crate::catalog::Catalogue;
use crate::catalog::lookup::MAX_ABERRATION;
use crate::frames::{Direction, Icrs, Rotation, StarPath};
use heapless::Vec;

/// Largest number of predicted stars; of more, the brightest.
pub const MAX_FIELD_STARS: usize = 48;
/// Margin of the cone's cosine: in a field narrower than 0.3 deg rounding alone would lose stars in the
/// corners.
const COSINE_ROUNDING: f32 = 1e-6;

/// A catalogue star predicted on the detector.
#[derive(Clone, Copy, Debug)]
pub struct Predicted {
    /// Index in the catalogue.
    pub star: u16,
    /// Predicted position, px.
    pub centre_px: [f32; 2],
}

/// Cosine of the angle from the detector's middle to its farthest corner, and a little more; the middle's
/// direction.
fn circumscribed_cone(camera: &Camera) -> Option<(f32, Direction<StarPath>)> {
    let middle = camera.direction(camera.middle_px())?;
    let cosine = camera.corners_px().into_iter().try_fold(1.0f32, |least, corner| {
        camera.direction(corner).map(|direction| least.min(direction.dot(&middle)))
    })?;
    Some((cosine - COSINE_ROUNDING, middle))
}

/// The brightest catalogue stars on the detector.
pub fn field_stars(
    catalogue: &Catalogue,
    camera: &Camera,
    attitude: &Rotation<Icrs, StarPath>,
) -> Option<Vec<Predicted, MAX_FIELD_STARS>> {
    let (cosine, middle) = circumscribed_cone(camera)?;
    let boresight = attitude.inverse().apply(&middle);
    let mut field = Vec::new();
    for (index, direction) in catalogue.stars_in_cone(&boresight, cosine - MAX_ABERRATION) {
        let direction = catalogue.aberrated(&direction);
        if direction.dot(&boresight) < cosine {
            continue;
        }
        let Some(centre_px) = camera.project(&attitude.apply(&direction)) else { continue };
        if !camera.contains(centre_px, 0.0) {
            continue;
        }
        if field.push(Predicted { star: index, centre_px }).is_err() {
            break;
        }
    }
    Some(field)
}

#[cfg(test)]
mod tests;
