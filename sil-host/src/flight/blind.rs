//! Identification with nothing known of the optics.
//!
//! In: centroids of a picture, brightest first, and its size. Out: [`Solution`] and the catalogue that its
//! stars are numbered in, or the flight code's reason.
//!
//! Focal lengths of horizontal fields from [`NARROWEST_DEG`] to [`WIDEST_DEG`] are tried in steps of 0.2 %,
//! each as an undistorted camera with the optical centre in the middle, then the same as seen in a mirror;
//! all of them first with little effort, then with more. Neighbouring fields share a catalogue. Every
//! hypothesis counts in the false-identification probability, so that more fields ask for more agreement:
//! of the million or more that are tried a picture needs about seven stars.

use super::lost_in_space::{FOCAL_STEP, Round, Solution, Solver};
use super::{Density, catalogue_bytes, open};
use crate::formats::camera_file::CameraFile;
use fsw_core::camera::Camera;
use fsw_core::stars::identify::NotIdentified;
use fsw_hal::DetectorGeometry;
use std::borrow::Cow;
use std::path::Path;

/// Horizontal fields that are tried, degrees.
pub const NARROWEST_DEG: f64 = 5.0;
/// The widest of them.
pub const WIDEST_DEG: f64 = 40.0;
/// Field with which the search begins, degrees.
const FIRST_DEG: f64 = 14.0;
/// Fields that share a catalogue differ by no more than this factor.
const SHARED: f64 = 1.3;
/// Rounds over all focal lengths: centroid sigma to assume (px) and catalogue pairs to look at.
const ROUNDS: [Round; 2] = [(0.35, 20_000), (0.35, 100_000)];

/// Focal lengths that share a catalogue.
struct Group {
    /// Their mean, px, and steps of the ladder to either side.
    focal_length_px: f64,
    steps: i32,
    /// Built when it is first needed; none where no catalogue serves such a field.
    catalogue: Option<Option<Cow<'static, [u8]>>>,
}

/// A search over all optics, for pictures of one size.
pub struct BlindSearch {
    geometry: DetectorGeometry,
    groups: Vec<Group>,
}

/// A solution, and bytes of the catalogue of its stars.
pub struct BlindSolution<'s> {
    /// The solution.
    pub solution: Solution,
    /// The catalogue.
    pub catalogue: &'s [u8],
}

/// Focal length of a horizontal field, px.
fn focal_length_px(geometry: &DetectorGeometry, field_deg: f64) -> f64 {
    0.5 * f64::from(geometry.width_px) / (0.5 * field_deg.to_radians()).tan()
}

impl BlindSearch {
    /// For pictures of this size.
    pub fn new(geometry: DetectorGeometry) -> Self {
        let [shortest, longest, first] =
            [WIDEST_DEG, NARROWEST_DEG, FIRST_DEG].map(|field_deg| focal_length_px(&geometry, field_deg));
        let count = ((longest / shortest).ln() / SHARED.ln()).ceil();
        let width = (longest / shortest).ln() / count;
        let steps = (0.5 * width / FOCAL_STEP).ceil() as i32;
        let middle = |index: u32| shortest * ((f64::from(index) + 0.5) * width).exp();
        let mut groups: Vec<Group> = (0..count as u32)
            .map(|index| Group { focal_length_px: middle(index), steps, catalogue: None })
            .collect();
        let far = |group: &Group| (group.focal_length_px / first).ln().abs();
        groups.sort_by(|a, b| far(a).total_cmp(&far(b)));
        Self { geometry, groups }
    }

    /// Tries that one call of [`Self::search`] makes at most.
    pub fn tries(&self) -> u64 {
        let of_group = |group: &Group| 2 * (2 * group.steps as u64 + 1);
        ROUNDS.len() as u64 * self.groups.iter().map(of_group).sum::<u64>()
    }

    /// Identifies stars given with their sigmas, px, brightest first; `tried` is called after every try.
    /// The fields of the last solution are tried first.
    ///
    /// # Errors
    /// Why they were not identified.
    pub fn search(
        &mut self,
        solver: &mut Solver,
        centroids: &[([f32; 2], f32)],
        mut tried: impl FnMut(),
    ) -> Result<BlindSolution<'_>, NotIdentified> {
        let mut hypotheses = 0.0;
        for round in ROUNDS {
            for mirrored in [false, true] {
                for index in 0..self.groups.len() {
                    let found = self.groups[index].search(
                        (self.geometry, mirrored),
                        solver,
                        (centroids, round),
                        &mut hypotheses,
                        &mut tried,
                    )?;
                    if let Some(solution) = found {
                        self.groups[..=index].rotate_right(1);
                        let catalogue = self.groups[0].catalogue.as_ref().and_then(Option::as_deref);
                        return Ok(BlindSolution { solution, catalogue: catalogue.unwrap_or(&[]) });
                    }
                }
            }
        }
        Err(NotIdentified::NoMatch)
    }
}

impl Group {
    /// Tries the focal lengths of the group from the middle outwards; `Ok(None)` where none fits.
    fn search(
        &mut self,
        (geometry, mirrored): (DetectorGeometry, bool),
        solver: &mut Solver,
        (centroids, round): (&[([f32; 2], f32)], Round),
        hypotheses: &mut f32,
        tried: &mut impl FnMut(),
    ) -> Result<Option<Solution>, NotIdentified> {
        let Some(camera) = camera(geometry, mirrored, self.focal_length_px) else { return Ok(None) };
        let build = || catalogue_bytes(&camera, Density::Brightest).ok();
        let Some(bytes) = self.catalogue.get_or_insert_with(build) else { return Ok(None) };
        let Ok(catalogue) = open(bytes) else { return Ok(None) };
        for camera in super::lost_in_space::ladder(&camera, self.steps) {
            let found = solver.attempt(centroids, camera, &catalogue, round, hypotheses);
            tried();
            match found {
                Ok(solution) => return Ok(Some(solution)),
                Err(NotIdentified::TooFewStars) => return Err(NotIdentified::TooFewStars),
                Err(_) => {}
            }
        }
        Ok(None)
    }
}

/// An undistorted camera; `None` where the flight code refuses it.
fn camera(geometry: DetectorGeometry, mirrored: bool, focal_length_px: f64) -> Option<Camera> {
    let file = CameraFile { mirrored, ..CameraFile::undistorted(geometry, focal_length_px) };
    super::camera(&file, Path::new("")).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_is_within_a_step_of_a_focal_length_that_is_tried() {
        for [width_px, height_px] in [[1280, 1024], [600, 917]] {
            let search = BlindSearch::new(DetectorGeometry { width_px, height_px, bits: 8 });
            let tried: Vec<f64> = search
                .groups
                .iter()
                .filter_map(|group| {
                    Some((camera(search.geometry, false, group.focal_length_px)?, group.steps))
                })
                .flat_map(|(camera, steps)| super::super::lost_in_space::ladder(&camera, steps))
                .map(|camera| camera.parameters().focal_length_px.into())
                .collect();
            assert_eq!(2 * ROUNDS.len() * tried.len(), search.tries() as usize);
            for hundredths in 505..=3995 {
                let wanted = focal_length_px(&search.geometry, f64::from(hundredths) / 100.0);
                let off = tried.iter().map(|tried| (tried / wanted - 1.0).abs()).fold(1.0, f64::min);
                assert!(off < 0.0012, "{hundredths} hundredths of a degree: off by {off}");
            }
            let first = focal_length_px(&search.geometry, FIRST_DEG);
            assert!((search.groups[0].focal_length_px / first).ln().abs() < SHARED.ln() / 2.0 + 0.01);
        }
    }
}
