//! The drawn Earth: radiometry, limb, terminator, and what the flight code needs to know of the limb's height.

use super::*;
use crate::camera_file::CameraFile;
use crate::world::optics::Optics;

const EQUATOR: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// An Earth image from `radius_km` above (0, 0) of the equator, `off_nadir_deg` towards +y of the equatorial axes, with the
/// Sun's direction in these axes.
fn image(radius_km: f64, off_nadir_deg: f64, sun: Vector, model: EarthModel) -> EarthImage {
    let position_km = [radius_km, 0.0, 0.0];
    let (s, c) = off_nadir_deg.to_radians().sin_cos();
    let earth_path = [[s, c, 0.0], [0.0, 0.0, 1.0], [-c, s, 0.0]];
    let view = View {
        ellipsoid: &Ellipsoid::new(&EQUATOR, position_km),
        earth_path: &earth_path,
        position_km,
        velocity_c: [0.0; 3],
        sun: unit(sun),
        sidereal_rad: 1.0,
    };
    EarthImage::new(&model, &Optics::new(&CameraFile::reference()).unwrap(), 0.9, &view)
}

fn even() -> EarthModel {
    EarthModel { cloud_contrast: 0.0, ..EarthModel::default() }
}

#[test]
fn a_full_earth_gives_the_electrons_of_its_albedo() {
    // By hand: 0.3 * 500 / pi W/m²/sr, 7.854e-5 m², (1/3000)² sr, 0.09 / 4000, 0.5 * 0.7, 2.84e-19 J.
    let expected = 47.746 * 7.854e-5 / 9e6 * 2.25e-5 * 0.35 / 2.84e-19;
    let seen = image(42_164.0, 0.0, [1.0, 0.0, 0.0], even());
    let middle = seen.white_e_s * seen.brightness([639.5, 511.5]);
    assert!((middle / expected - 1.0).abs() < 0.005, "{middle} {expected}");
    assert!((1.1e4..1.25e4).contains(&middle));
    assert_eq!(seen.brightness([639.5, 0.0]), 0.0);
    let night = image(42_164.0, 0.0, [-1.0, 0.0, 0.0], even());
    assert_eq!(night.brightness([639.5, 511.5]), 0.0);
}

/// Heights (km) and brightness along a line of the detector from `from` px, every `step` px, across the limb.
fn radial(seen: &EarthImage, axis: usize, from: f64, to: f64, step: f64) -> Vec<(f64, f64)> {
    let mut line = Vec::new();
    let mut at = from;
    while at < to {
        let mut pixel = [639.5, 511.5];
        pixel[axis] = at;
        let d = seen.optics.normalised(pixel).unwrap();
        let ray = apply(&seen.to_sphere, [d[0], d[1], 1.0]);
        let way = -dot(seen.place, ray) / dot(ray, ray);
        let lowest = plus(seen.place, way, ray);
        let rho = length(lowest);
        line.push(((rho - 1.0) * rho / length(to_sphere(lowest)), seen.brightness(pixel)));
        at += step;
    }
    line
}

/// Height at which the brightness first falls below half of `full`, interpolated.
fn half_height(line: &[(f64, f64)], full: f64) -> f64 {
    let pair = line.windows(2).find(|w| w[0].1 >= 0.5 * full && w[1].1 < 0.5 * full).unwrap();
    let share = (pair[0].1 - 0.5 * full) / (pair[0].1 - pair[1].1);
    pair[0].0 + share * (pair[1].0 - pair[0].0)
}

#[test]
fn the_limbs_half_brightness_stands_where_the_model_says() {
    // Half of the brightness at the ellipsoid's edge before the PSF (then it is H ln 2 without one), and of that ten and
    // twenty pixels inside; Sun across the line of sight, or as far behind the satellite as its elevation allows.
    println!("  view      Sun elevation, from   half of: edge  10 px in  20 px in (km)");
    let views = [("GEO", 42_164.0, 0.0), ("SSO 798 km", 7176.0, 62.7), ("LEO 450 km", 6828.0, 69.1)];
    for (name, radius, off) in views {
        for elevation in [90.0f64, 60.0, 30.0, 10.0, 5.0] {
            for behind in [false, true] {
                let dip = (EQUATOR_KM / radius).acos();
                // The limb point towards +y: its normal, and the horizontals across the view and to the satellite.
                let normal = [dip.cos(), dip.sin(), 0.0];
                let horizontal = if behind { [dip.sin(), -dip.cos(), 0.0] } else { [0.0, 0.0, 1.0] };
                let (s, c) = elevation.to_radians().sin_cos();
                let sun = plus(normal.map(|n| n * s), c, horizontal);
                let seen = image(radius, off, sun, even());
                // x px runs towards +y; the limb is near the middle in the oblique views, 455 px out in GEO.
                let line = radial(&seen, 0, 340.0, 1279.0, 0.02);
                let limb = line.iter().position(|(h, _)| *h >= 0.0).unwrap();
                let levels = [seen.surface(normal, 0.0, 1.0), line[limb - 500].1, line[limb - 1000].1];
                let [edge, ten, twenty] = levels.map(|full| half_height(&line, full));
                let from = if behind { "behind" } else { "across" };
                println!("{name:>11} {elevation:8.0} deg {from} {edge:15.2} {ten:9.2} {twenty:9.2}");
                if name != "GEO" {
                    // There the PSF is a tenth of the scale height: it lifts the half by sigma²/2H and little more.
                    assert!((edge - 8.0 * 2f64.ln()).abs() < 0.2, "{edge}");
                }
                assert!((-10.0..16.0).contains(&ten), "{ten}");
            }
        }
    }
}

#[test]
fn the_blurred_limb_is_the_convolution() {
    for (sigma, scale) in [(11.0, 8.0), (0.6, 8.0), (3.0, 5.0), (40.0, 8.0)] {
        for height in [-30.0, -5.0, 0.0, 3.0, 10.0, 40.0] {
            // The rule of midpoints over ±8 widths, the edge and the exponential as they stand.
            let steps = 40_000;
            let mut sum = 0.0;
            for k in 0..steps {
                let t = (f64::from(k) + 0.5) / f64::from(steps) * 16.0 - 8.0;
                let h = height + sigma * t;
                let value: f64 = if h < 0.0 { 1.0 } else { (-h / scale).exp() };
                sum += value * (-0.5 * t * t).exp() * 16.0 / f64::from(steps);
            }
            let expected = sum / (2.0 * std::f64::consts::PI).sqrt();
            let found = blurred_limb(height, sigma, scale);
            assert!((found - expected).abs() < 2e-4, "{sigma} {scale} {height}: {found} {expected}");
        }
    }
    // Where the PSF is much wider than the air, both forms agree.
    let (below, above) = (blurred_limb(20.0, 47.9, 8.0), blurred_limb(20.0, 48.1, 8.0));
    assert!((below - above).abs() < 2e-3);
}

#[test]
fn there_are_no_steps_in_the_image() {
    // From the disc across limb and terminator, in fine steps: no change larger than the steepest slope allows.
    for (radius, off, sun) in
        [(42_164.0, 0.0, [0.3, -1.0, 0.2]), (42_164.0, 0.0, [0.1, 1.0, 0.0]), (6828.0, 69.1, [0.5, 0.6, 0.6])]
    {
        let seen = image(radius, off, sun, EarthModel::default());
        for axis in [0, 1] {
            let line = radial(&seen, axis, 0.0, 1023.0, 0.01);
            let most = line.windows(2).map(|w| (w[0].1 - w[1].1).abs()).fold(0.0, f64::max);
            assert!(most < 0.012, "{radius} {axis}: {most}");
        }
    }
}

#[test]
fn windows_far_from_the_earth_are_left_alone() {
    let seen = image(42_164.0, 0.0, [1.0, 0.2, 0.1], EarthModel::default());
    let mut skipped = 0;
    for x in (0..1280).step_by(64) {
        for y in (0..1024).step_by(64) {
            let window = Window { x, y, width: 64, height: 64 };
            if !seen.may_touch(window) {
                skipped += 1;
                let dark = |k: u16| seen.brightness([f64::from(x + k % 64), f64::from(y + k / 64)]) == 0.0;
                assert!((0..4096).all(dark));
            }
        }
    }
    assert!(skipped > 80, "{skipped}");
}
