//! The physical limit: what no estimator can do better than.
//!
//! In: a scene's electrons and optics, the stars that were used. Out: Cramer-Rao bounds. A star's centroid:
//! with the mean electrons `m(x, y)` of the pixels about it, as the scene draws them (PSF at its place in the
//! field, sensitive part of the pixels, colour, vignetting), and the variance `m + dark + read² + rows² +
//! quantisation²`, its information about the place is `F = Σ grad m gradᵀ m / variance`, its bound `F⁻¹`. The
//! attitude: `P = [Σ (I - b bᵀ) / sigma²]⁻¹` (thesis eq. 3.27), rad², of a single image. In f64, apart from
//! the flight code.
//!
//! The star stands still and its flux is known; the noise of rows is taken for independent from pixel to
//! pixel; fixed patterns are taken for known. The gradient is a difference over `STEP_PX` to either side,
//! right to 1e-3.
//!
//! [`position`] is that of the orbit by the limb of an uneven Earth.

pub mod orbit;
pub mod position;

use crate::world::attitude::Vector;
use crate::world::lens::optics::Optics;
use crate::world::scene::{Scene, VisibleStar};
use crate::world::sky::stars::DetectorModel;
use crate::world::vector::{cross, plus};
use fsw_hal::Window;

/// Half the distance over which an image's change is measured, px.
const STEP_PX: f64 = 0.02;

/// Bounds of a centroid's standard deviations along columns and rows, px, of a star `at` a place, over a
/// background whose variance is `variance_e2` a pixel; `image` gives the mean electrons of the pixels about
/// it for a place near that.
pub fn centroid_px(image: impl Fn([f64; 2]) -> Vec<f64>, at: [f64; 2], variance_e2: f64) -> [f64; 2] {
    let moved = |dx: f64, dy: f64| image([at[0] + dx * STEP_PX, at[1] + dy * STEP_PX]);
    let [middle, right, left, below, above] =
        [(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].map(|(dx, dy)| moved(dx, dy));
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for (k, electrons) in middle.iter().enumerate() {
        let weight = (electrons.max(0.0) + variance_e2).recip();
        let slope = [right[k] - left[k], below[k] - above[k]].map(|difference| difference / (2.0 * STEP_PX));
        xx += slope[0] * slope[0] * weight;
        xy += slope[0] * slope[1] * weight;
        yy += slope[1] * slope[1] * weight;
    }
    let determinant = xx * yy - xy * xy;
    [yy, xx].map(|minor| (minor / determinant).sqrt())
}

/// The same of a star of `scene`.
fn star_centroid_px(scene: &Scene, star: &VisibleStar, exposure_s: f64, variance_e2: f64) -> [f64; 2] {
    let geometry = scene.settings().camera.geometry();
    let reach = scene.star_reach_px();
    let span = |at: f64, side: u16| {
        let (low, high) = ((at - reach).max(0.0) as u16, (at + reach).min(f64::from(side) - 1.0) as u16);
        (low, high - low + 1)
    };
    let ((x, width), (y, height)) = (span(star.x_px, geometry.width_px), span(star.y_px, geometry.height_px));
    let window = Window { x, y, width, height };
    let image = |at| scene.star_image(star, at, exposure_s, window);
    centroid_px(image, [star.x_px, star.y_px], variance_e2)
}

/// Variance of a pixel without a star, e-².
fn background_e2(detector: &DetectorModel, bits: u8, exposure_s: f64) -> f64 {
    let gain = detector.gain_e_per_dn(bits);
    let rows = detector.pattern.row_noise_e;
    detector.dark_now_e_s() * exposure_s
        + detector.read_noise_e * detector.read_noise_e
        + rows * rows
        + gain * gain / 12.0
}

/// Diagonal of the inverse of a symmetric positive 3 x 3 matrix `[xx, xy, xz, yy, yz, zz]`.
fn inverse_diagonal([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> [f64; 3] {
    let minors = [yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy];
    let determinant = xx * minors[0] - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    minors.map(|minor| minor / determinant)
}

/// Bound of the attitude's standard deviations about x, y, z, rad, from `stars` of the scene's present image;
/// `None` when fewer than two of them are on it.
pub fn attitude_rad(scene: &Scene, stars: &[VisibleStar], exposure_us: u32) -> Option<[f64; 3]> {
    let settings = scene.settings();
    let exposure_s = f64::from(exposure_us) * 1e-6;
    let variance_e2 = background_e2(&settings.detector, settings.camera.bits, exposure_s);
    let per_focal_length = scene.optics().focal_length_px().recip();
    let mut sums = [0.0; 6];
    for star in stars {
        let [bx, by, bz] = scene.optics().unproject([star.x_px, star.y_px])?;
        let [sx, sy] = star_centroid_px(scene, star, exposure_s, variance_e2);
        // The mean of both axes; a pixel is taken for the same angle everywhere, as the flight code does.
        let weight = (0.5 * (sx * sx + sy * sy) * per_focal_length * per_focal_length).recip();
        let terms = [by * by + bz * bz, -bx * by, -bx * bz, bx * bx + bz * bz, -by * bz, bx * bx + by * by];
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += weight * term;
        }
    }
    (stars.len() >= 2).then(|| inverse_diagonal(sums).map(f64::sqrt))
}

/// Angle over which the change of a star's place with the attitude is measured, rad.
const STEP_RAD: f64 = 1e-6;

/// Bound of the attitude's standard deviations about x, y, z, rad, from stars at these places on the detector
/// with these covariances `[xx, xy, yy]`, px²: `P = [Σ Jᵀ C⁻¹ J]⁻¹`, J the change of a star's place with the
/// rotation vector, which is eq. 3.27 without its assumption that an error is the same angle in every
/// direction. `None` for fewer than two stars, or one that the camera does not see.
pub fn attitude_of_places_rad(optics: &Optics, stars: &[([f64; 2], [f64; 3])]) -> Option<[f64; 3]> {
    let mut sums = [0.0; 6];
    for (place, [xx, xy, yy]) in stars {
        let b = optics.unproject(*place)?;
        // A rotation by the vector `θ` moves the components of a star by `-θ × b`.
        let moved = |axis: Vector, angle: f64| optics.project(plus(b, -angle, cross(axis, b)));
        let slope = |axis: Vector| -> Option<[f64; 2]> {
            let (ahead, behind) = (moved(axis, STEP_RAD)?, moved(axis, -STEP_RAD)?);
            Some([0, 1].map(|k| (ahead[k] - behind[k]) / (2.0 * STEP_RAD)))
        };
        let slopes = [slope([1.0, 0.0, 0.0])?, slope([0.0, 1.0, 0.0])?, slope([0.0, 0.0, 1.0])?];
        let determinant = xx * yy - xy * xy;
        let term = |i: usize, j: usize| {
            let ([ax, ay], [bx, by]) = (slopes[i], slopes[j]);
            (ax * bx * yy - (ax * by + ay * bx) * xy + ay * by * xx) / determinant
        };
        let terms = [term(0, 0), term(0, 1), term(0, 2), term(1, 1), term(1, 2), term(2, 2)];
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    (stars.len() >= 2).then(|| inverse_diagonal(sums).map(f64::sqrt))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::detector::pixel::PixelResponse;
    use crate::world::lens::psf::Psf;
    use crate::world::lens::spots::{Brush, Spot};

    /// Bound of a Gaussian star of `sigma_px` on full pixels.
    fn gaussian(electrons: f64, phase: [f64; 2], sigma_px: f64, variance_e2: f64) -> [f64; 2] {
        let psf = Psf::gaussian(sigma_px);
        let window = Window { x: 0, y: 0, width: 41, height: 41 };
        let image = |[x_px, y_px]: [f64; 2]| {
            let mut light = vec![0.0; window.area()];
            let spot = Spot { x_px, y_px, electrons: [electrons, 0.0, 0.0] };
            Brush::default().draw(&psf, PixelResponse::Full, &spot, window, &mut light);
            light
        };
        centroid_px(image, phase.map(|phase| 20.0 + phase), variance_e2)
    }

    #[test]
    fn photon_noise_alone_gives_the_psf_width_over_the_root_of_the_photons() {
        // The textbook limit sigma / sqrt(N); pixels of finite size cost some percent of it.
        for electrons in [100.0, 10_000.0] {
            let [x, y] = gaussian(electrons, [0.1, -0.3], 1.5, 1e-9);
            let ideal = 1.5 / electrons.sqrt();
            assert!(
                (1.0..1.05).contains(&(x / ideal)) && (1.0..1.05).contains(&(y / ideal)),
                "{x} {y} {ideal}"
            );
        }
    }

    #[test]
    fn background_noise_alone_gives_the_textbook_limit() {
        // sigma_n sqrt(8 pi) s² / N for a Gaussian PSF of width s on fine pixels.
        let [x, _] = gaussian(10.0, [0.0, 0.0], 2.0, 1e4);
        let ideal = 100.0 * (8.0 * std::f64::consts::PI).sqrt() * 4.0 / 10.0;
        assert!((x / ideal - 1.0).abs() < 0.06, "{x} {ideal}");
    }

    #[test]
    fn a_cross_of_four_stars_has_the_bound_that_follows_by_hand() {
        // f = 3000 px, stars 300 px from the centre on both axes, 0.3 px: an angle of s = 1e-4 rad. About z
        // only the two coordinates across the radius count: s² / (4 0.1²). About x the y coordinates count,
        // by 1 on the x axis and by 1 + 0.1² on the y axis: s² / (2 + 2 1.01²).
        let camera = crate::formats::camera_file::CameraFile::reference();
        let optics = Optics::new(&camera).unwrap();
        let [cx, cy] = optics.centre_px();
        let star = |x: f64, y: f64| ([cx + x, cy + y], [0.09, 0.0, 0.09]);
        let stars = [star(300.0, 0.0), star(-300.0, 0.0), star(0.0, 300.0), star(0.0, -300.0)];
        let found = attitude_of_places_rad(&optics, &stars).unwrap();
        let across = 1e-4 / (2.0 + 2.0 * 1.01f64 * 1.01).sqrt();
        for (found, expected) in found.iter().zip([across, across, 1e-4 / 0.2]) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
        assert!(attitude_of_places_rad(&optics, &stars[..1]).is_none());
    }

    #[test]
    fn the_inverse_is_that_of_a_matrix_known_by_hand() {
        // [[2,1,0],[1,2,0],[0,0,4]]: the inverse's diagonal is 2/3, 2/3, 1/4.
        let diagonal = inverse_diagonal([2.0, 1.0, 0.0, 2.0, 0.0, 4.0]);
        for (found, expected) in diagonal.iter().zip([2.0 / 3.0, 2.0 / 3.0, 0.25]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }
}
