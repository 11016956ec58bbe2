//! From centroids to identified stars.
//!
//! [`identify`] proposes polygons of measured and catalogue stars (separations, triangles, sense of
//! rotation, merging along a side: thesis §3.1.3), [`confirm`] verifies a proposal by projecting the
//! catalogue into the image, [`chance`] says how likely that is of a wrong one, [`predict`] gives the star
//! positions of an attitude. [`reidentify`] needs no polygon: it begins with an attitude that was known some
//! seconds ago.

#[cfg(test)]
mod artificial;
pub mod chance;
pub mod confirm;
pub mod focal_ratio;
pub mod identify;
mod parameters;
pub mod polygon;
pub mod predict;
pub mod reidentify;
pub mod search_order;
mod triangles;
mod weighing;

use crate::attitude::VectorPair;
use crate::camera::Camera;
use crate::catalog::{Catalogue, Star};
use crate::frames::{Direction, Icrs, StarPath};
use crate::image::Detection;
use crate::image::calibration::Calibration;
use nalgebra::Vector3;

/// Largest number of measured stars used in identification; of more, the brightest.
pub const MAX_MEASURED: usize = 64;

/// A measured star.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredStar {
    /// Position on the detector, px.
    pub centre_px: [f32; 2],
    /// Standard deviation of the centre per axis, px.
    pub sigma_px: f32,
    /// Direction of this position.
    pub direction: Direction<StarPath>,
}

impl MeasuredStar {
    /// A star at a pixel position; `None` when position or sigma are not finite, or the sigma is not
    /// positive.
    pub fn new(camera: &Camera, centre_px: [f32; 2], sigma_px: f32) -> Option<Self> {
        let direction = camera.direction(centre_px)?;
        let usable = sigma_px > 1e-4 && sigma_px < 1e3;
        if usable { Some(Self { centre_px, sigma_px, direction }) } else { None }
    }

    /// A star from its spot.
    pub fn from_detection(camera: &Camera, spot: &Detection) -> Option<Self> {
        Self::new(camera, spot.centre_px(), spot.sigma_px())
    }

    /// Rolling-shutter correction: the star at the time of the middle row (thesis §9.1.1.1). Rows are
    /// exposed `row_time_s` one after the other.
    pub fn at_mid_frame(self, camera: &Camera, rate_rad_s: &Vector3<f32>, row_time_s: f32) -> Option<Self> {
        let later_s = row_delay_s(camera, self.centre_px, row_time_s);
        let direction = direction_after(&self.direction, rate_rad_s, -later_s)?;
        Some(Self { centre_px: camera.project(&direction)?, direction, ..self })
    }

    /// The vector pair of this star and the apparent direction `seen` of its catalogue star.
    pub fn paired_with(&self, seen: Direction<Icrs>, camera: &Camera) -> VectorPair {
        VectorPair {
            measured: self.direction,
            reference: seen,
            sigma_rad: self.sigma_px * camera.rad_per_px(),
        }
    }
}

/// Direction of a star `later_s` later at a constant rate, to first order: `db/dt = -ω × b`.
pub fn direction_after(
    direction: &Direction<StarPath>,
    rate_rad_s: &Vector3<f32>,
    later_s: f32,
) -> Option<Direction<StarPath>> {
    let unit = direction.vector();
    Direction::new(unit - rate_rad_s.cross(unit) * later_s)
}

/// Exposure time of a position's row after that of the middle row, s.
pub fn row_delay_s(camera: &Camera, [_, y]: [f32; 2], row_time_s: f32) -> f32 {
    let [_, middle] = camera.middle_px();
    (y - middle) * row_time_s
}

/// A measured star matched with a catalogue star.
#[derive(Clone, Copy, Debug)]
pub struct Match {
    /// Index of the measured star.
    pub measured: u8,
    /// Index of the catalogue star.
    pub star: u16,
    /// Rank of the catalogue star among those predicted, by brightness.
    pub rank: u8,
    /// Measured less projected position, px.
    pub residual_px: [f32; 2],
}

/// Measured stars of one image with catalogue and camera.
#[derive(Clone, Copy, Debug)]
pub struct StarField<'a> {
    measured: &'a [MeasuredStar],
    /// The catalogue.
    pub catalogue: &'a Catalogue<'a>,
    /// The camera.
    pub camera: &'a Camera,
    /// Searched detector area, px: the whole detector, or the windows read without their margins.
    pub searched_px: f32,
    /// Calibration of the lens, if there is one.
    calibration: Option<&'a Calibration<'a>>,
}

impl<'a> StarField<'a> {
    /// Stars found on the whole detector, brightest first where brightness is known; of more than
    /// [`MAX_MEASURED`] the first.
    pub fn whole(measured: &'a [MeasuredStar], catalogue: &'a Catalogue<'a>, camera: &'a Camera) -> Self {
        Self { measured, catalogue, camera, searched_px: camera.area_px(), calibration: None }
    }

    /// Stars found in windows of `searched_px` in all.
    pub fn windows(
        measured: &'a [MeasuredStar],
        catalogue: &'a Catalogue<'a>,
        camera: &'a Camera,
        searched_px: f32,
    ) -> Self {
        Self { measured, catalogue, camera, searched_px, calibration: None }
    }

    /// The same without so many pixels that the detector did not deliver.
    pub fn without(self, unread_px: u32) -> Self {
        Self { searched_px: (self.searched_px - unread_px as f32).max(1.0), ..self }
    }

    /// The same with a calibration of the lens.
    pub fn calibrated(self, calibration: Option<&'a Calibration<'a>>) -> Self {
        Self { calibration, ..self }
    }

    /// Displacement of a catalogue star at `at_px` by its colour (lateral chromatic aberration), px.
    pub fn colour_shift_px(&self, at_px: [f32; 2], star: &Star) -> [f32; 2] {
        let b_v = f32::from(star.colour_centi) * 0.01;
        self.calibration.map_or([0.0; 2], |calibration| calibration.colour_shift_px(at_px, b_v))
    }

    /// Whether the lens is calibrated: then the centroids' sigmas are known, not assumed.
    pub fn is_calibrated(&self) -> bool {
        self.calibration.is_some()
    }

    /// The measured star `seen`, identified as `star`, corrected for its colour.
    pub fn colour_corrected(&self, seen: &MeasuredStar, star: &Star) -> MeasuredStar {
        let [x, y] = seen.centre_px;
        let [dx, dy] = self.colour_shift_px(seen.centre_px, star);
        let moved =
            self.calibration.and_then(|_| MeasuredStar::new(self.camera, [x - dx, y - dy], seen.sigma_px));
        moved.unwrap_or(*seen)
    }

    /// The measured stars, at most [`MAX_MEASURED`].
    pub fn measured(&self) -> &'a [MeasuredStar] {
        self.measured.get(..MAX_MEASURED).unwrap_or(self.measured)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::sample;
    use crate::oracle::reference_camera;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_measured_star_has_a_finite_place_error_and_direction(
            x in any::<f32>(), y in any::<f32>(), sigma_px in any::<f32>()
        ) {
            for (x, y) in [(x, y), (x % 2000.0, y % 2000.0)] {
                for sigma_px in [sigma_px, 0.1] {
                    let Some(star) = MeasuredStar::new(&camera(), [x, y], sigma_px) else { continue };
                    prop_assert!(star.centre_px == [x, y] && x.is_finite() && y.is_finite());
                    prop_assert!(star.sigma_px > 0.0 && star.sigma_px.is_finite());
                    prop_assert!((star.direction.vector().norm() - 1.0).abs() < 1e-6);
                }
            }
        }
    }

    fn camera() -> Camera {
        Camera::new(reference_camera()).unwrap()
    }

    #[test]
    fn what_is_not_finite_never_becomes_a_measured_star() {
        let camera = camera();
        assert!(MeasuredStar::new(&camera, [3.0, 4.0], 0.1).is_some());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for (centre_px, sigma_px) in [([bad, 4.0], 0.1), ([3.0, bad], 0.1), ([3.0, 4.0], bad)] {
                assert!(
                    MeasuredStar::new(&camera, centre_px, sigma_px).is_none(),
                    "{centre_px:?}, {sigma_px}"
                );
            }
        }
    }

    #[test]
    fn a_star_without_an_error_is_refused_and_so_is_one_far_off_the_detector() {
        let camera = camera();
        for sigma_px in [0.0, -0.0, -0.1, f32::MIN_POSITIVE, 1e3, f32::MAX] {
            assert!(MeasuredStar::new(&camera, [3.0, 4.0], sigma_px).is_none(), "{sigma_px}");
        }
        assert!(MeasuredStar::new(&camera, [1e9, 4.0], 0.1).is_none());
        assert!(MeasuredStar::new(&camera, [f32::MAX, f32::MIN], 0.1).is_none());
    }

    #[test]
    fn the_centroid_error_becomes_an_angle_by_the_focal_length() {
        let camera = camera();
        let pair = |sigma_px| {
            let seen = MeasuredStar::new(&camera, [100.0, 900.0], sigma_px).unwrap();
            let bytes = sample::bytes(&[sample::star(&-Vector3::x(), 1)], 26, 0);
            let catalogue = Catalogue::open(&bytes).unwrap();
            seen.paired_with(catalogue.apparent_direction(&catalogue.star(0).unwrap()), &camera)
        };
        // The reference camera has 3000 px: 0.3 px are 100 microradians.
        assert!((pair(0.3).sigma_rad - 1e-4).abs() < 1e-10);
        assert!((pair(0.3).reference.vector() + Vector3::x()).norm() < 1e-7);
        assert!(pair(0.3).measured.dot(&camera.direction([100.0, 900.0]).unwrap()) > 0.999_999);
    }

    #[test]
    fn of_too_many_stars_the_first_take_part() {
        let camera = camera();
        let bytes = sample::bytes(&[], 26, 0);
        let catalogue = Catalogue::open(&bytes).unwrap();
        let stars: [MeasuredStar; 100] =
            core::array::from_fn(|index| MeasuredStar::new(&camera, [index as f32, 0.0], 0.1).unwrap());
        for count in [0, 1, MAX_MEASURED - 1, MAX_MEASURED, MAX_MEASURED + 1, 100] {
            let field = StarField::whole(&stars[..count], &catalogue, &camera);
            assert_eq!(field.measured().len(), count.min(64));
            assert!((0u8..).zip(field.measured()).all(|(index, star)| star.centre_px[0] == f32::from(index)));
        }
        assert_eq!(StarField::whole(&stars, &catalogue, &camera).searched_px, 1280.0 * 1024.0);
        assert_eq!(StarField::windows(&stars, &catalogue, &camera, 500.0).searched_px, 500.0);
    }
}
