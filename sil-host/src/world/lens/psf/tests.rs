use super::*;
use crate::formats::camera_file::CameraFile;
use crate::world::detector::pixel::PixelResponse;
use crate::world::lens::optics::Optics;
use crate::world::lens::spots::{Spot, Spots};
use fsw_hal::Window;
use std::sync::Arc;

const REFERENCE: LensModel = LensModel { aperture_mm: 10.0, defocus_mm: -0.06 };
const MOUNTS: VignettingModel = VignettingModel { cosine: true, corner_loss: 0.15 };

fn reference() -> Psf {
    let optics = Optics::new(&CameraFile::reference()).unwrap();
    Psf::of_lens(&REFERENCE, &MOUNTS, 7.5, &optics).unwrap()
}

/// Share of the light, centre, central second moments (xx, yy) and third (xxx) of a star on a fine count of
/// blobs.
fn moments(psf: &Psf, x: f64, y: f64, b_v: f64) -> ([f64; 2], [f64; 2], f64) {
    let blob = Blob { x_px: 0.0, y_px: 0.0, sigma_px: 1.0, electrons: 0.0 };
    let mut blobs = [blob; BLOBS_MAX];
    let count = psf.image(x, y, &colour::shares(b_v), &mut blobs);
    let sum = |f: &dyn Fn(&Blob) -> f64| blobs[..count].iter().map(|b| b.electrons * f(b)).sum::<f64>();
    let total = sum(&|_| 1.0);
    let centre = [sum(&|b| b.x_px) / total, sum(&|b| b.y_px) / total];
    let second = [
        sum(&|b| (b.x_px - centre[0]).powi(2) + b.sigma_px * b.sigma_px) / total,
        sum(&|b| (b.y_px - centre[1]).powi(2) + b.sigma_px * b.sigma_px) / total,
    ];
    let third = sum(&|b| {
        let d = b.x_px - centre[0];
        d.powi(3) + 3.0 * d * b.sigma_px * b.sigma_px
    }) / total;
    (centre, second, third)
}

#[test]
fn a_white_star_is_where_the_distortion_model_puts_it_and_others_near_it() {
    let psf = reference();
    let mut worst = 0.0f64;
    for (x, y) in [(639.5, 511.5), (900.2, 300.7), (10.0, 20.0), (1279.0, 511.0), (333.3, 1000.0)] {
        let ([cx, cy], ..) = moments(&psf, x, y, 0.0);
        assert!((cx - x).abs() < 1e-9 && (cy - y).abs() < 1e-9);
        for b_v in [-0.3, 0.65, 1.8] {
            let ([cx, cy], ..) = moments(&psf, x, y, b_v);
            worst = worst.max(libm::hypot(cx - x, cy - y));
        }
    }
    println!("lateral colour: {worst:.4} px");
    assert!((1e-4..0.1).contains(&worst), "{worst}");
}

#[test]
fn stars_are_about_three_by_five_pixels_and_lopsided_off_the_axis() {
    let psf = Arc::new(reference());
    for x in [640u16, 940, 1150, 1240] {
        let (_, [xx, yy], third) = moments(&psf, f64::from(x), 512.0, 0.0);
        let spot = Spot { x_px: x.into(), y_px: 512.0, electrons: colour::shares(0.0) };
        let window = Window { x: x - 20, y: 492, width: 41, height: 41 };
        let mut light = vec![0.0; window.area()];
        Spots::new(psf.clone(), PixelResponse::Full, vec![spot]).add_to(window, &mut light);
        let sum: f64 = light.iter().sum();
        // Light within so many columns and rows of the middle.
        let within = |columns: i32, rows: i32| {
            let inside =
                |k: usize| ((k % 41) as i32 - 20).abs() <= columns && ((k / 41) as i32 - 20).abs() <= rows;
            (0..light.len()).filter(|k| inside(*k)).map(|k| light[k]).sum::<f64>() / sum
        };
        let skewness = third / xx.powf(1.5);
        println!(
            "{x}: widths {:.2} x {:.2} px, skewness {skewness:.2}; 3 x 3 {:.2}, 3 x 5 {:.2}, 5 x 5 {:.2}; sum {sum:.7}",
            xx.sqrt(),
            yy.sqrt(),
            within(1, 1),
            within(1, 2).max(within(2, 1)),
            within(2, 2)
        );
        assert!((sum - 1.0).abs() < 2e-5, "{sum}");
        assert!((0.75..0.95).contains(&within(1, 2).max(within(2, 1))) && within(2, 2) > 0.9);
        assert_eq!(skewness > 0.2, x > 1000, "{x}: {skewness}");
    }
}

#[test]
fn moments_are_those_of_the_rays() {
    // Against a fan of rays of its own, finer, at a field radius that is a node (8 of 16) and one that is
    // none.
    let optics = Optics::new(&CameraFile::reference()).unwrap();
    let psf = reference();
    let lens = Lens::new(22.5, 10.0, 0.06).unwrap();
    for part in [0.5, 0.73] {
        let radius_px = part * optics.radius_px();
        let field = libm::atan(radius_px / 3000.0);
        let mut sums = [0.0; 4];
        for (wavelength_nm, weight) in BAND_NM.into_iter().zip(colour::shares(0.0)) {
            for i in 0..60 {
                for j in 0..60 {
                    let (u, v) = ((f64::from(i) + 0.5) / 30.0 - 1.0, (f64::from(j) + 0.5) / 30.0 - 1.0);
                    if u * u + v * v > 1.0 {
                        continue;
                    }
                    let [x, y] = lens.landing(field, wavelength_nm, [u * MOUNTS.mounts(part), v]).unwrap();
                    let [x, y] = [x / 0.0075, y / 0.0075];
                    for (sum, term) in sums.iter_mut().zip([1.0, x, x * x, y * y]) {
                        *sum += weight * term;
                    }
                }
            }
        }
        let [n, x, xx, yy] = sums;
        let expected = [xx / n - (x / n).powi(2), yy / n];
        let base = DIFFUSION_PX * DIFFUSION_PX;
        let (_, second, _) = moments(&psf, 639.5 + radius_px, 511.5, 0.0);
        for (found, expected) in second.iter().zip(expected) {
            // Zones are round, so a part of a zone's variance goes to the other axis; together they are
            // right.
            assert!((found - base - expected).abs() < 0.25 * expected, "{part}: {second:?} {expected:?}");
        }
        let (total, rays) = (second[0] + second[1] - 2.0 * base, expected[0] + expected[1]);
        assert!((total / rays - 1.0).abs() < 0.03, "{part}: {total} {rays}");
    }
}

#[test]
fn a_lens_too_fast_or_out_of_focus_is_refused() {
    let of = |focal_length_px, defocus_mm| {
        let optics = Optics::new(&CameraFile { focal_length_px, ..CameraFile::reference() }).unwrap();
        Psf::of_lens(&LensModel { defocus_mm, ..REFERENCE }, &MOUNTS, 7.5, &optics)
    };
    assert!(of(300.0, -0.1).is_none());
    assert!(of(3000.0, -2.0).is_none());
    assert!(of(3000.0, 0.0).is_some());
}
