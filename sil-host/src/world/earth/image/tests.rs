//! The drawn Earth: radiometry, limb, motion, and that nothing depends on the window.

use super::*;
use crate::formats::camera_file::CameraFile;
use crate::world::attitude::dot;
use crate::world::earth::Ellipsoid;
use crate::world::earth::{Figure, POLE_KM};
use crate::world::vector::{cross, plus, product};
use fsw_core::orbit::body::CentralBody;
use proptest::prelude::*;
use std::sync::OnceLock;

const EQUATOR: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const WHOLE: Window = Window { x: 0, y: 0, width: 1280, height: 1024 };
/// Name, distance from the centre in km, angle off nadir in deg: the limb near the middle in the low orbits,
/// all round in the high one.
const ORBITS: [(&str, f64, f64); 3] =
    [("GEO", 42_164.0, 0.0), ("SSO 800 km", 7178.0, 62.7), ("LEO 450 km", 6828.0, 69.1)];

/// What an image is seen from and how.
#[derive(Debug, Clone, Copy)]
struct Seen {
    radius_km: f64,
    off_nadir_deg: f64,
    sun: Vector,
    rate_rad_s: Vector,
    exposure_s: f64,
    row_time_s: f64,
    /// Instant at which the middle of the exposure lies, s.
    at_s: f64,
    seed: u64,
    model: EarthModel,
}

impl Seen {
    /// At rest from `radius_km` above (0, 0) of the equator, looking `off_nadir_deg` towards +y of the
    /// equatorial axes.
    fn still(radius_km: f64, off_nadir_deg: f64, sun: Vector) -> Self {
        Self {
            radius_km,
            off_nadir_deg,
            sun,
            rate_rad_s: [0.0; 3],
            exposure_s: 0.4,
            row_time_s: 0.0,
            at_s: 0.0,
            seed: 1,
            model: EarthModel::default(),
        }
    }

    fn image(&self) -> EarthImage {
        let velocity_km_s = [0.0, 3.0, 1.0];
        let position_km = plus([self.radius_km, 0.0, 0.0], self.at_s, velocity_km_s);
        let (s, c) = libm::sincos(self.off_nadir_deg.to_radians());
        let start = [[s, c, 0.0], [0.0, 0.0, 1.0], [-c, s, 0.0]];
        // A camera turned by an angle about an axis of its own sees directions turned back.
        let angle = length(self.rate_rad_s) * self.at_s;
        let earth_path = if angle == 0.0 {
            start
        } else {
            let axis = unit(self.rate_rad_s);
            let (s, c) = libm::sincos(angle);
            let back =
                EQUATOR.map(|e| plus(plus(times(c, e), -s, cross(axis, e)), (1.0 - c) * dot(axis, e), axis));
            // The rows of `back` are the images of the axes: the matrix is their transpose.
            product(&crate::world::vector::transposed(&back), &start)
        };
        let view = View {
            ellipsoid: &Ellipsoid::new(CentralBody::Earth, &EQUATOR, position_km),
            earth_path: &earth_path,
            rate_rad_s: self.rate_rad_s,
            position_km,
            velocity_c: times(LIGHT_KM_S.recip(), velocity_km_s),
            sun: unit(self.sun),
            sidereal_rad: 1.0,
            exposure_s: self.exposure_s,
            row_time_s: self.row_time_s,
            transmission: 1.0,
        };
        let optics = Optics::new(&CameraFile::reference()).unwrap();
        EarthImage::new(&self.model, self.seed, &optics, 0.9, &view)
    }
}

fn even() -> EarthModel {
    EarthModel { cloud_contrast: 0.0, ..EarthModel::default() }
}

fn drawn(image: &EarthImage, window: Window) -> Vec<f64> {
    let mut electrons = vec![0.0; window.area()];
    let mut cell_buffer = CellBuffer::EMPTY;
    image.add_to(window, &mut electrons, &mut cell_buffer);
    electrons
}

/// Brightness of a pixel computed alone, in f64: no cells, no lanes. Whole exposures at rest only.
fn alone(image: &EarthImage, pixel: [f64; 2]) -> f64 {
    let pose = image.sights.pose(image.sights.row_s(pixel[1]));
    let sight = image.sights.sight(&pose, pixel).unwrap();
    let moved_km = sight.km_s * image.step_s;
    let sigma = (image.variance_px2 * sight.km_per_px.powi(2) + moved_km * moved_km / 12.0).sqrt();
    let lifted = sight.depth + image.lift_km(&sight, sigma, 0.0) / sight.km_per_depth;
    let height = -lifted * sight.km_per_depth;
    let limb = image.looks.limb.at(height as f32, sigma as f32);
    let cube = sight.cosine.powi(3);
    let near = height > -REACH_SIGMAS * sigma;
    let depth = if near { f64::from(limb.depth_km) / sight.km_per_depth } else { lifted };
    let root = depth.max(0.0).sqrt();
    let point = plus(sight.nearest, root, sight.back);
    let normal = Figure::of(CentralBody::Earth).to_sphere(point);
    let per_length = length(normal).recip();
    let [sx, sy, sz] = image.sun.map(f64::from);
    let sunlight = per_length * dot(normal, [sx, sy, sz * POLE_KM / EQUATOR_KM]);
    let w = f64::from(image.shade.twilight);
    let lit = if sunlight < w { (sunlight + w).max(0.0).powi(2) / (4.0 * w) } else { sunlight };
    let view = libm::hypot(root * sight.slope * per_length / EQUATOR_KM, f64::from(HAZE));
    let ground_rad = 0.577 * sight.ground_rad_s * image.step_s;
    let spread = libm::hypot(image.per_focal_length, ground_rad);
    let size = (sight.way_km - root * EQUATOR_KM).max(0.0) * spread / view;
    let albedo = image.looks.map.at(point.map(|c| c as f32), AlbedoMap::level_of(size as f32));
    let (mean, haze) = (f64::from(image.shade.mean_albedo), f64::from(image.shade.haze));
    let albedo = f64::from(albedo) + haze / view * (mean - f64::from(albedo));
    let k = f64::from(image.shade.lommel_seeliger);
    let surface = albedo * lit * (2.0 * k / (lit + view) + 1.0 - k);
    let share = if near { f64::from(limb.share) } else { 1.0 };
    let glow = if near && height < image.top_km + REACH_SIGMAS * sigma { f64::from(limb.glow) } else { 0.0 };
    cube * (share * surface + glow)
}

#[test]
fn a_full_earth_gives_the_electrons_of_its_albedo() {
    // By hand: 0.3 * 500 / pi W/m²/sr, 7.854e-5 m², (1/3000)² sr, 0.09 / 4000, 0.5 * 0.7, 2.84e-19 J, 0.4 s.
    let expected = 0.4 * 47.746 * 7.854e-5 / 9e6 * 2.25e-5 * 0.35 / 2.84e-19;
    let full = Seen { model: even(), ..Seen::still(42_164.0, 0.0, [1.0, 0.0, 0.0]) };
    let middle = drawn(&full.image(), Window { x: 639, y: 511, width: 1, height: 1 })[0];
    assert!((middle / expected - 1.0).abs() < 0.005, "{middle} {expected}");
    assert!((1.1e4..1.25e4).contains(&(middle / 0.4)));
}

#[test]
fn the_night_side_is_dark() {
    for (name, radius, off) in ORBITS {
        let night = Seen::still(radius, off, [-1.0, 0.0, 0.0]).image();
        let electrons = drawn(&night, WHOLE);
        let most = electrons.iter().copied().fold(0.0, f64::max);
        println!("{name}: {most:.4} e at the limb");
        // The night sky: some 9e-7 of the 15,700 electrons of white in 0.4 s.
        assert!(most > 1e-3 && most < 0.02, "{most}");
        let model = EarthModel { airglow: false, ..EarthModel::default() };
        let dark = Seen { model, ..Seen::still(radius, off, [-1.0, 0.0, 0.0]) }.image();
        assert!(drawn(&dark, WHOLE).iter().all(|e| *e == 0.0));
    }
}

#[test]
fn cells_give_what_every_pixel_alone_would() {
    for (name, radius, off) in ORBITS {
        for (kind, rate, row_time_s) in [("still", [0.0; 3], 0.0), ("turning", [0.0008, -0.001, 0.002], 2e-5)]
        {
            let sun = [0.8, 0.5, 0.4];
            let seen =
                Seen { rate_rad_s: rate, row_time_s, exposure_s: 0.1, ..Seen::still(radius, off, sun) };
            let image = seen.image();
            assert_eq!(image.steps, 1);
            let electrons = drawn(&image, WHOLE);
            let scale = image.white_e_s * seen.exposure_s;
            let full = electrons.iter().copied().fold(0.0, f64::max) / scale;
            let (mut worst, mut squares, mut count) = (0.0f64, 0.0, 0u32);
            // Every pixel of a thinned grid, one that hits all places in a cell.
            for k in (0..WHOLE.area()).step_by(37) {
                let (x, y) = (k % 1280, k / 1280);
                let exact = alone(&image, [x as f64, y as f64]);
                let error = (electrons[k] / scale - exact).abs() / full;
                if exact > 0.0 {
                    (squares, count) = (squares + error * error, count + 1);
                }
                worst = worst.max(error);
            }
            let rms = (squares / f64::from(count.max(1))).sqrt();
            println!("{name} {kind}: brightness worst {worst:.1e}, rms {rms:.1e} of full");
            assert!(worst < 2e-3, "{worst}");
        }
    }
}

#[test]
fn cells_keep_the_limb_in_its_place() {
    for (name, radius, off) in ORBITS {
        let image = Seen {
            row_time_s: 2e-5,
            rate_rad_s: [0.001, 0.0, 0.0],
            ..Seen::still(radius, off, [1.0, 0.2, 0.1])
        }
        .image();
        let pose = |y: f64| image.sights.pose(image.sights.row_s(y));
        let node = |x: usize, y: usize| image.node::<true>(&pose(y as f64), [x as f64, y as f64]);
        let mut worst = 0.0f64;
        for top in (0..1024).step_by(HEIGHT) {
            for left in (0..1280).step_by(WIDTH) {
                let nodes = [0, 4, 8].map(|y| [0, 8, 16].map(|x| node(left + x, top + y)));
                let cell = [0, 1, 2].map(|j: usize| [&nodes[j][0], &nodes[j][1], &nodes[j][2]]);
                if image.content(&cell) != Content::Limb {
                    continue;
                }
                for (x, y) in [(3, 1), (12, 6), (5, 3), (13, 2)] {
                    let (mut places, mut depth, mut km) = (Places::EMPTY, [0.0; AREA], [0.0; AREA]);
                    places.fill(x..x + 1, y..y + 1);
                    places.depth(&cell, &mut depth);
                    places.values(&cell, KM_PER_DEPTH, &mut km);
                    let height = -depth[0] * km[0];
                    let (x, y) = ((left + x) as f64, (top + y) as f64);
                    let exact = image.node::<true>(&pose(y), [x, y]);
                    let exact_km = -exact.depth * exact.values[KM_PER_DEPTH];
                    // Where the brightness changes.
                    if exact_km > -40.0 && exact_km < 60.0 {
                        let px = f64::from((height - exact_km).abs())
                            / (f64::from(exact.values[SIGMA_KM]) / 0.945);
                        worst = worst.max(px);
                    }
                }
            }
        }
        println!("{name}: {worst:.5} px");
        assert!(worst < 0.01, "{worst}");
    }
}

#[test]
fn the_limb_stands_and_falls_as_the_model_says() {
    // Brightness over that of an even surface under the same Sun, seen as flat as the limb is: heights at
    // which it is 0.9, 0.5 and 0.1, along lines across the limb at many azimuths, less what the horizon lifts
    // them. A low orbit's blur adds little to the profile.
    for (name, radius, off) in ORBITS {
        let image = Seen { model: even(), ..Seen::still(radius, off, [1.0, 0.3, 0.1]) }.image();
        let pose = image.sights.pose(0.0);
        let at = |pixel: [f64; 2]| {
            let sight = image.sights.sight(&pose, pixel).unwrap();
            let sigma = image.variance_px2.sqrt() * sight.km_per_px;
            (-sight.depth * sight.km_per_depth, image.lift_km(&sight, sigma, 0.0))
        };
        let (mut heights, mut lifts, mut widths) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..36 {
            // GEO: from the middle outwards; low: columns across the horizon.
            let (start, step) = if name == "GEO" {
                let (s, c) = (f64::from(k) * 0.1745).sin_cos();
                ([639.5 + 420.0 * c, 511.5 + 420.0 * s], [0.01 * c, 0.01 * s])
            } else {
                ([500.0, 20.0 + 28.0 * f64::from(k)], [0.01, 0.0])
            };
            let mut crossings = [f64::NAN; 3];
            let mut lift = 0.0;
            let mut before = (f64::NAN, f64::NAN);
            for n in 0..60_000 {
                let pixel = [start[0] + step[0] * f64::from(n), start[1] + step[1] * f64::from(n)];
                if !(0.0..1279.0).contains(&pixel[0]) || !(0.0..1023.0).contains(&pixel[1]) {
                    break;
                }
                let (height, lifted) = at(pixel);
                if !(-60.0..90.0).contains(&height) {
                    continue;
                }
                let normal = unit(
                    Figure::of(CentralBody::Earth)
                        .to_sphere(image.sights.sight(&pose, pixel).unwrap().nearest),
                );
                let [sx, sy, sz] = image.sun.map(f64::from);
                let sunlight = dot(normal, [sx, sy, sz * POLE_KM / EQUATOR_KM]);
                let off_axis = image.sights.sight(&pose, pixel).unwrap().cosine.powi(3);
                let flat = 0.3 * sunlight * (0.8 / (sunlight + 0.1) + 0.6) * off_axis;
                let drawn = alone(&image, pixel) / flat;
                for (crossing, level) in crossings.iter_mut().zip([0.9, 0.5, 0.1]) {
                    if before.1 >= level && drawn < level {
                        *crossing = height;
                        lift = lifted;
                    }
                }
                before = (height, drawn);
            }
            if crossings.iter().all(|c| c.is_finite()) {
                heights.push(crossings[1] - lift);
                lifts.push(lift);
                widths.push(crossings[2] - crossings[0]);
            }
        }
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let spread =
            |v: &[f64]| (v.iter().map(|x| (x - mean(v)).powi(2)).sum::<f64>() / v.len() as f64).sqrt();
        println!(
            "{name}: half at {:.2} km + {:.2} ± {:.2} km, 10-90 % {:.1} ± {:.2} km ({} lines)",
            mean(&heights),
            mean(&lifts),
            spread(&lifts),
            mean(&widths),
            spread(&widths),
            heights.len()
        );
        assert!(heights.len() > 20);
        if name != "GEO" {
            assert!((3.0..6.0).contains(&mean(&heights)) && (18.0..22.0).contains(&mean(&widths)));
            assert!(spread(&heights) < 0.3);
        }
    }
}

#[test]
fn light_falls_with_the_cube_of_the_cosine() {
    // The same place of the Earth in the middle of the picture and near its edge, on a sphere without
    // features.
    let straight = Seen { model: even(), ..Seen::still(42_164.0, 0.0, [1.0, 0.0, 0.0]) }.image();
    for off_deg in [4.0f64, 8.0] {
        let turned = Seen { model: even(), ..Seen::still(42_164.0, off_deg, [1.0, 0.0, 0.0]) }.image();
        let pixel = [639.5 - 3000.0 * off_deg.to_radians().tan(), 511.5];
        let ratio = alone(&turned, pixel) / alone(&straight, [639.5, 511.5]);
        let cosine = off_deg.to_radians().cos();
        assert!((ratio / cosine.powi(3) - 1.0).abs() < 1e-4, "{off_deg}: {ratio}");
    }
}

#[test]
fn a_long_exposure_is_the_mean_of_short_ones() {
    // Tumbling in geostationary and low orbit, by some 18 px and, low, by 84 px and more.
    let slow = [0.009, 0.012, 0.02];
    for ((name, radius, off), rate_rad_s) in [
        (ORBITS[0], slow),
        (ORBITS[2], slow),
        (ORBITS[2], [0.06, 0.01, 0.02]),
        (ORBITS[2], [0.02, -0.07, 0.03]),
    ] {
        let long = Seen { rate_rad_s, ..Seen::still(radius, off, [1.0, 0.4, 0.2]) };
        let window = if name == "GEO" {
            Window { x: 1020, y: 440, width: 120, height: 80 }
        } else {
            Window { x: 560, y: 440, width: 160, height: 80 }
        };
        let image = long.image();
        assert!(image.steps > 1, "{}", image.steps);
        let found = drawn(&image, window);
        let parts = 240;
        let (mut mean, mut cell_buffer) = (vec![0.0; window.area()], CellBuffer::EMPTY);
        for k in 0..parts {
            let at_s = 0.4 * ((f64::from(k) + 0.5) / f64::from(parts) - 0.5);
            let short = Seen { at_s, exposure_s: 0.4 / f64::from(parts), ..long };
            short.image().add_to(window, &mut mean, &mut cell_buffer);
        }
        let full = mean.iter().copied().fold(0.0, f64::max);
        let error = |(a, b): (&f64, &f64)| (a - b).abs() / full;
        let worst = found.iter().zip(&mean).map(error).fold(0.0, f64::max);
        let rms = (found.iter().zip(&mean).map(|p| error(p).powi(2)).sum::<f64>() / mean.len() as f64).sqrt();
        let bias = found.iter().zip(&mean).map(|(a, b)| (a - b) / full).sum::<f64>() / mean.len() as f64;
        println!("{name}, {} parts: worst {worst:.4}, rms {rms:.4}, mean {bias:.5} of full", image.steps);
        assert!(rms < 0.01 && worst < 0.06 && bias.abs() < 2e-3);
    }
}

#[test]
fn a_row_of_a_rolling_shutter_is_that_of_its_time() {
    let rolling = Seen {
        rate_rad_s: [0.004, 0.006, 0.03],
        row_time_s: 4e-5,
        exposure_s: 0.01,
        ..Seen::still(42_164.0, 0.0, [1.0, 0.4, 0.2])
    };
    let rows = rolling.image();
    for y in [100u16, 300, 511, 700, 900] {
        let row = Window { x: 0, y, width: 1280, height: 1 };
        let at_s = (f64::from(y) - 511.5) * 4e-5;
        let (a, b) = (drawn(&rows, row), drawn(&Seen { row_time_s: 0.0, at_s, ..rolling }.image(), row));
        let full = b.iter().copied().fold(0.0, f64::max);
        let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / full).fold(0.0, f64::max);
        println!("row {y}: {worst:.1e} of full");
        assert!(worst < 3e-3, "{worst}");
    }
}

#[test]
fn seeds_make_other_clouds_and_the_same_seed_the_same() {
    let image = |seed| drawn(&Seen { seed, ..Seen::still(42_164.0, 0.0, [1.0, 0.4, 0.2]) }.image(), WHOLE);
    let (one, again, other) = (image(1), image(1), image(2));
    assert!(one == again);
    assert!(one.iter().zip(&other).filter(|(a, b)| a != b).count() > 300_000);
}

/// All effects at once: a tumbling camera with a rolling shutter over the terminator.
fn all_effects(radius_km: f64, off_nadir_deg: f64) -> EarthImage {
    Seen {
        rate_rad_s: [0.004, 0.005, 0.03],
        row_time_s: 3e-5,
        seed: 9,
        ..Seen::still(radius_km, off_nadir_deg, [0.5, 0.8, -0.3])
    }
    .image()
}

fn whole(index: usize) -> &'static (EarthImage, Vec<f64>) {
    static FRAMES: [OnceLock<(EarthImage, Vec<f64>)>; 2] = [OnceLock::new(), OnceLock::new()];
    FRAMES[index].get_or_init(|| {
        let image = if index == 0 { all_effects(42_164.0, 0.0) } else { all_effects(6828.0, 69.1) };
        let electrons = drawn(&image, WHOLE);
        (image, electrons)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_window_is_that_of_the_whole_frame_to_the_bit(
        index in 0usize..2, x in 0u16..1270, y in 0u16..1014, width in 1u16..130, height in 1u16..60,
    ) {
        let (image, frame) = whole(index);
        prop_assert!(image.steps > 1);
        let window = Window { x, y, width: width.min(1280 - x), height: height.min(1024 - y) };
        let electrons = drawn(image, window);
        for (k, value) in electrons.iter().enumerate() {
            let column = usize::from(x) + k % usize::from(window.width);
            let row = usize::from(y) + k / usize::from(window.width);
            prop_assert_eq!(value.to_bits(), frame[row * 1280 + column].to_bits());
        }
    }
}

#[test]
fn windows_far_from_the_earth_are_left_alone() {
    let seen = Seen::still(42_164.0, 0.0, [1.0, 0.2, 0.1]).image();
    let frame = drawn(&seen, WHOLE);
    let mut skipped = 0;
    for x in (0..1280).step_by(64) {
        for y in (0..1024).step_by(64) {
            let window = Window { x, y, width: 64, height: 64 };
            if !seen.may_touch(window) {
                skipped += 1;
                let dark =
                    |k: usize| frame[(usize::from(y) + k / 64) * 1280 + usize::from(x) + k % 64] == 0.0;
                assert!((0..4096).all(dark));
            }
        }
    }
    assert!(skipped > 80, "{skipped}");
}
