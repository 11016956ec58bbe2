//! The physical limit: what no estimator can do better than.
//!
//! In: a scene's electrons and optics, the stars that were used. Out: Cramer-Rao bounds. A star's centroid: with mean
//! electrons `m(x, y)` of a Gaussian PSF integrated over pixels and variance `m + dark + read² + quantisation²`, the
//! information about its column is `Σ (dm/dx)² / variance`. The attitude: `P = [Σ (I - b bᵀ) / sigma²]⁻¹` (thesis eq. 3.27),
//! rad², of a single image. In f64, apart from the flight code.

use crate::world::scene::{Scene, VisibleStar};
use crate::world::stars::DetectorModel;

/// Half the side of the region over which a star's information is summed, in PSF widths.
const REACH_SIGMAS: f64 = 5.0;

/// Sum over pixel numbers near 0 of a star centred at `phase`, per pixel: integrated PSF and its derivative.
fn profile(phase: f64, psf_sigma_px: f64) -> Vec<(f64, f64)> {
    let reach = (REACH_SIGMAS * psf_sigma_px).ceil() as i32;
    let edge = |at: f64| libm::erf((at - phase) / (psf_sigma_px * std::f64::consts::SQRT_2));
    let density = |at: f64| {
        let t = (at - phase) / psf_sigma_px;
        (-0.5 * t * t).exp() / (psf_sigma_px * (2.0 * std::f64::consts::PI).sqrt())
    };
    (-reach..=reach)
        .map(|pixel| {
            let (left, right) = (f64::from(pixel) - 0.5, f64::from(pixel) + 0.5);
            (0.5 * (edge(right) - edge(left)), density(left) - density(right))
        })
        .collect()
}

/// Bound of a centroid's standard deviation per axis, px, of a star of `electrons` at a sub-pixel `phase`, over a
/// background whose variance is `variance_e2` a pixel.
pub fn centroid_px(electrons: f64, phase: [f64; 2], psf_sigma_px: f64, variance_e2: f64) -> [f64; 2] {
    let [columns, rows] = phase.map(|phase| profile(phase, psf_sigma_px));
    let mut information = [0.0; 2];
    for (share_y, slope_y) in &rows {
        for (share_x, slope_x) in &columns {
            let variance = electrons * share_x * share_y + variance_e2;
            information[0] += (electrons * slope_x * share_y).powi(2) / variance;
            information[1] += (electrons * share_x * slope_y).powi(2) / variance;
        }
    }
    information.map(|information| information.sqrt().recip())
}

/// Variance of a pixel without a star, e-².
fn background_e2(detector: &DetectorModel, bits: u8, exposure_s: f64) -> f64 {
    let gain = detector.gain_e_per_dn(bits);
    detector.dark_now_e_s() * exposure_s + detector.read_noise_e * detector.read_noise_e + gain * gain / 12.0
}

/// Diagonal of the inverse of a symmetric positive 3 x 3 matrix `[xx, xy, xz, yy, yz, zz]`.
fn inverse_diagonal([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> [f64; 3] {
    let minors = [yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy];
    let determinant = xx * minors[0] - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    minors.map(|minor| minor / determinant)
}

/// Bound of the attitude's standard deviations about x, y, z, rad, from `stars` of the scene's present image; `None` when
/// fewer than two of them are on it.
pub fn attitude_rad(scene: &Scene, stars: &[VisibleStar], exposure_us: u32) -> Option<[f64; 3]> {
    let settings = scene.settings();
    let exposure_s = f64::from(exposure_us) * 1e-6;
    let variance_e2 = background_e2(&settings.detector, settings.camera.bits, exposure_s);
    let per_focal_length = scene.optics().focal_length_px().recip();
    let mut sums = [0.0; 6];
    for star in stars {
        let [bx, by, bz] = scene.optics().unproject([star.x_px, star.y_px])?;
        let electrons = settings.detector.star_e_s(star.v) * exposure_s;
        let phase = [star.x_px, star.y_px].map(|at| at - at.round());
        let [sx, sy] = centroid_px(electrons, phase, settings.psf_sigma_px, variance_e2);
        // The mean of both axes; a pixel is taken for the same angle everywhere, as the flight code does.
        let weight = (0.5 * (sx * sx + sy * sy) * per_focal_length * per_focal_length).recip();
        let terms = [by * by + bz * bz, -bx * by, -bx * bz, bx * bx + bz * bz, -by * bz, bx * bx + by * by];
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += weight * term;
        }
    }
    (stars.len() >= 2).then(|| inverse_diagonal(sums).map(f64::sqrt))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photon_noise_alone_gives_the_psf_width_over_the_root_of_the_photons() {
        // The textbook limit sigma / sqrt(N); pixels of finite size cost some percent of it.
        for electrons in [100.0, 10_000.0] {
            let [x, y] = centroid_px(electrons, [0.1, -0.3], 1.5, 1e-9);
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
        let [x, _] = centroid_px(10.0, [0.0, 0.0], 2.0, 1e4);
        let ideal = 100.0 * (8.0 * std::f64::consts::PI).sqrt() * 4.0 / 10.0;
        assert!((x / ideal - 1.0).abs() < 0.06, "{x} {ideal}");
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
