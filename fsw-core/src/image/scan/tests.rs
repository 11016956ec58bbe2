//! Stars in, centroids out: over whole frames, whatever is behind the stars.

use super::*;
use crate::image::test_sky::{Chance, Frame, Sky};
use crate::image::{Detection, DetectionParameters};
use proptest::prelude::*;
use std::vec::Vec;

/// All that a scan finds.
pub(super) fn scanned(frame: &mut Frame) -> Detections {
    let mut detections = Detections::new();
    let parameters = DetectionParameters::default();
    scan(frame, &mut [0; TILE_PIXELS], &parameters, &mut detections).unwrap();
    detections
}

/// What a window shows.
fn windowed(frame: &mut Frame, window: Window) -> Detections {
    let mut detections = Detections::new();
    let parameters = DetectionParameters::default();
    read_stars(frame, window, &mut [0; TILE_PIXELS], &parameters, &mut detections).unwrap();
    detections
}

/// Distance of the spot's centre from a place, per axis, px.
pub(super) fn miss(spot: &Detection, [x, y]: [f64; 2]) -> [f64; 2] {
    let [found_x, found_y] = spot.centre_px();
    [f64::from(found_x) - x, f64::from(found_y) - y]
}

/// The spot within two pixels of a place.
pub(super) fn at(detections: &Detections, place: [f64; 2]) -> Option<Detection> {
    detections.spots().iter().find(|spot| miss(spot, place).iter().all(|axis| axis.abs() < 2.0)).copied()
}

/// Places `spacing` px apart, each at its own phase within the pixel.
pub(super) fn places(width: usize, height: usize, spacing: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut chance = Chance(seed);
    let mut places = Vec::new();
    for y in (20..height - 20).step_by(spacing) {
        for x in (20..width - 20).step_by(spacing) {
            places.push([x as f64 + chance.even() - 0.5, y as f64 + chance.even() - 0.5]);
        }
    }
    places
}

pub(super) fn with_stars(sky: Sky, places: &[[f64; 2]], sigma_px: f64, flux: f64) -> Sky {
    places.iter().fold(sky, |sky, place| sky.star(*place, sigma_px, flux))
}

#[test]
fn bright_stars_are_centred_within_a_twentieth_to_a_tenth_of_a_pixel() {
    for (sigma_px, bound_px) in [(0.7, 0.05), (0.9, 0.05), (1.2, 0.1), (1.5, 0.12)] {
        let stars = places(460, 460, 60, 1);
        let sky = with_stars(Sky::new(460, 460, 60.0), &stars, sigma_px, 3000.0).noise(2.0, 3);
        let found = scanned(&mut sky.expose(12));
        let mut largest: f64 = 0.0;
        for star in &stars {
            let spot = at(&found, *star).expect("a bright star is found");
            largest = miss(&spot, *star).iter().fold(largest, |most, axis| most.max(axis.abs()));
        }
        std::println!("PSF of {sigma_px} px: worst centre of {} stars {largest:.3} px", stars.len());
        assert!(largest < bound_px);
        assert_eq!(found.spots().len(), stars.len(), "and nothing else");
    }
}

#[test]
fn the_reported_sigma_of_faint_stars_is_honest() {
    let parameters = DetectionParameters::default();
    for (flux, seed) in [(70.0, 3), (100.0, 4), (200.0, 5)] {
        let (mut chi_square, mut axes, mut beyond, mut stars_drawn) = (0.0, 0, 0, 0);
        for seed in seed * 100..seed * 100 + 8 {
            let stars = places(460, 460, 50, seed);
            stars_drawn += stars.len();
            let sky = with_stars(Sky::new(460, 460, 60.0), &stars, 0.9, flux).noise(3.0, seed);
            let found = scanned(&mut sky.expose(12));
            for (spot, star) in stars.iter().filter_map(|star| Some((at(&found, *star)?, *star))) {
                for axis in miss(&spot, star) {
                    let sigmas = axis / f64::from(spot.sigma_px());
                    chi_square += sigmas * sigmas;
                    beyond += usize::from(sigmas.abs() > 3.0);
                    axes += 1;
                }
            }
        }
        let mean = chi_square / axes as f64;
        std::println!(
            "flux {flux} = {:.0} sigma of a pixel: {} of {stars_drawn} found, chi-square {mean:.2} an axis, {beyond} of {axes} beyond 3 sigma",
            flux / 3.0,
            axes / 2
        );
        // 70 of 1000: the floor for bright stars is wider than their error, hence the low bound.
        assert!(parameters.centroid_floor_millipx == 70 && (0.2..1.4).contains(&mean));
        assert!(beyond * 50 <= axes, "at most 2 % beyond 3 sigma");
    }
}

#[test]
fn a_star_on_any_seam_is_found_once() {
    let size = 400u16;
    let geometry = fsw_hal::DetectorGeometry { width_px: size, height_px: size, bits: 12 };
    let seams: Vec<f64> = columns(&geometry).map(|span| f64::from(span.core)).collect();
    let rows: Vec<f64> = rows(&geometry).map(|span| f64::from(span.core)).collect();
    assert!(seams.len() >= 3 && rows.len() >= 6);
    for step in -6..=6 {
        let shift = f64::from(step) * 0.34;
        let inner = |starts: &[f64]| starts[1..].to_vec();
        let mut stars = Vec::new();
        for y in inner(&rows) {
            for x in inner(&seams) {
                stars.push([x - 0.5 + shift, y - 0.5 - shift]);
                stars.push([x - 0.5 + shift, y + 24.3]);
            }
            stars.push([30.2, y - 0.5 + shift]);
        }
        let sky = with_stars(Sky::new(400, 400, 60.0), &stars, 0.9, 1500.0).noise(2.0, 7);
        let found = scanned(&mut sky.expose(12));
        let missing: Vec<_> = stars.iter().filter(|star| at(&found, **star).is_none()).collect();
        assert!(missing.is_empty(), "{missing:?}");
        assert_eq!(found.found() as usize, stars.len());
    }
}

#[test]
fn a_window_centres_a_star_as_the_scan_does() {
    let stars = places(460, 460, 60, 11);
    let sky = with_stars(Sky::new(460, 460, 60.0), &stars, 0.9, 2500.0).noise(2.0, 12);
    let mut frame = sky.expose(12);
    let whole = scanned(&mut frame);
    for side in [21u16, 25, 27, 35, 61] {
        let mut largest: f64 = 0.0;
        for star in &stars {
            let corner = star.map(|at| at.round() as i32 - i32::from(side / 2));
            let [Ok(x), Ok(y)] = corner.map(u16::try_from) else { continue };
            let window = Window { x, y, width: side, height: side };
            if !window.fits(&frame.geometry) {
                continue;
            }
            let found = windowed(&mut frame, window);
            let [alone, scanned] = [&found, &whole].map(|list| at(list, *star).expect("found by both"));
            let difference = miss(&alone, scanned.centre_px().map(f64::from));
            largest = difference.iter().fold(largest, |most, axis| most.max(axis.abs()));
        }
        std::println!("windows of {side} px: {largest:.4} px from the scan");
        assert!(largest < 0.02);
    }
}

#[test]
fn stars_are_found_through_banding_slopes_glow_and_vignetting() {
    let stars = places(460, 460, 70, 13);
    let banding = |y: f64| if (y as u32 * 7) % 5 < 2 { 2.0 } else { -2.0 };
    type Background = (&'static str, fn(f64, f64) -> f64);
    let backgrounds: [Background; 3] = [
        ("slope", |x, y| 0.15 * x + 0.1 * y),
        ("glow", |x, y| 120.0 * (-(x.hypot(y)) / 120.0).exp()),
        ("vignetting", |x, y| 120.0 / (1.0 + ((x - 230.0).powi(2) + (y - 230.0).powi(2)) / 60_000.0).powi(2)),
    ];
    for (name, background) in backgrounds {
        let sky = Sky::new(460, 460, 30.0).add(background).add(|_, y| banding(y));
        let sky = with_stars(sky, &stars, 0.9, 300.0).noise(2.0, 14);
        let found = scanned(&mut sky.expose(10));
        let seen = stars.iter().filter(|star| at(&found, **star).is_some()).count();
        std::println!("{name}: {seen} of {} stars, {} spots", stars.len(), found.spots().len());
        assert!(seen + 1 >= stars.len(), "{name}");
        assert!(found.spots().len() <= stars.len() + 2, "{name}: false stars");
    }
}

#[test]
fn featureless_frames_show_no_star() {
    let frame = |values: &dyn Fn(usize, usize) -> u16| {
        let geometry = fsw_hal::DetectorGeometry { width_px: 300, height_px: 200, bits: 10 };
        let pixels = (0..200).flat_map(|y| (0..300).map(move |x| values(x, y))).collect();
        Frame { geometry, pixels }
    };
    for mut frame in [
        frame(&|_, _| 0),
        frame(&|_, _| 77),
        frame(&|_, _| 1023),
        frame(&|x, y| if (x + y) % 2 == 0 { 0 } else { 1023 }),
        frame(&|_, y| if y % 2 == 0 { 40 } else { 44 }),
        frame(&|x, _| (x * 3) as u16),
    ] {
        assert_eq!(scanned(&mut frame).found(), 0);
    }
}

#[test]
fn gaussian_noise_shows_few_false_stars() {
    let mut found = 0;
    let (side, frames) = (1000, 10);
    for seed in 0..frames {
        found += scanned(&mut Sky::new(side, side, 60.0).noise(3.0, 1000 + seed).expose(10)).found();
    }
    let rate = f64::from(found) / frames as f64;
    std::println!("{rate:.2} false stars a megapixel of Gaussian noise at the default threshold");
    assert!(rate <= 3.0);
}

#[test]
fn hot_pixels_and_extended_objects_are_refused() {
    let hot = places(460, 460, 40, 15);
    let spikes = |x: f64, y: f64| {
        if hot.iter().any(|at| (at[0].round(), at[1].round()) == (x, y)) { 400.0 } else { 0.0 }
    };
    let disc = |x: f64, y: f64| if (x - 231.0).hypot(y - 229.0) < 30.0 { 500.0 } else { 0.0 };
    let plane = |x: f64, y: f64| if x + 0.3 * y > 260.0 { 600.0 } else { 0.0 };
    for (name, sky) in [
        ("hot pixels", Sky::new(460, 460, 60.0).add(spikes)),
        ("disc", Sky::new(460, 460, 60.0).add(disc)),
        ("edge", Sky::new(460, 460, 60.0).add(plane)),
    ] {
        let found = scanned(&mut sky.noise(2.0, 16).expose(10)).found();
        std::println!("{name}: {found} spots");
        assert!(found <= 2, "{name}");
    }
}

#[test]
fn a_saturated_star_is_centred() {
    for (phase, seed) in [(0.0, 17), (0.3, 18), (-0.45, 19)] {
        // Full scale over 9 px, a skirt around it.
        let star = [150.0 + phase, 120.0 - phase];
        let sky = Sky::new(300, 240, 60.0).star(star, 1.6, 400_000.0).noise(2.0, seed);
        let mut frame = sky.expose(10);
        let row = &frame.pixels[120 * 300..121 * 300];
        assert!((8..=10).contains(&row.iter().filter(|raw| **raw == 1023).count()));
        let found = scanned(&mut frame);
        assert_eq!(found.found(), 1);
        let spot = found.spots()[0];
        std::println!("saturated: {:.3?} px off", miss(&spot, star));
        assert!(spot.saturated && miss(&spot, star).iter().all(|axis| axis.abs() < 0.2));
    }
}

#[test]
fn the_same_sky_gives_the_same_spots_at_any_resolution() {
    let stars = places(300, 240, 50, 20);
    let base = with_stars(Sky::new(300, 240, 20.0), &stars, 0.9, 600.0).noise(2.0, 21).expose(8);
    let reference = scanned(&mut base.clone());
    assert_eq!(reference.spots().len(), stars.len());
    for bits in [10u8, 12, 14, 16] {
        let mut frame = base.clone();
        frame.geometry.bits = bits;
        frame.pixels.iter_mut().for_each(|raw| *raw <<= bits - 8);
        let found = scanned(&mut frame);
        for star in &stars {
            let [one, other] = [&reference, &found].map(|list| at(list, *star).expect("found at both"));
            assert!(miss(&one, other.centre_px().map(f64::from)).iter().all(|axis| axis.abs() < 0.02));
            assert!((one.flux - other.flux).abs() * 50 <= one.flux);
        }
    }
}

#[test]
fn the_brightest_are_kept_and_come_first() {
    let stars = places(1280, 1024, 60, 22);
    assert!(stars.len() > 3 * MAX_DETECTIONS);
    let mut sky = Sky::new(1280, 1024, 60.0);
    for (index, star) in stars.iter().enumerate() {
        sky = sky.star(*star, 0.9, 500.0 + 7.0 * ((index * 101) % stars.len()) as f64);
    }
    let found = scanned(&mut sky.noise(2.0, 24).expose(12));
    assert_eq!(found.spots().len(), MAX_DETECTIONS);
    // Noise adds one here and there.
    assert!((stars.len()..stars.len() + 3).contains(&(found.found() as usize)));
    assert!(found.spots().is_sorted_by_key(|spot| spot.rank()));
    // Neighbours in brightness may change places: the sums over 3 x 3 px depend on the phase.
    let brightest = stars.len() - MAX_DETECTIONS * 3 / 2;
    let faint = |index: usize| (index * 101) % stars.len() < brightest;
    let kept_faint = stars.iter().enumerate().filter(|(i, star)| faint(*i) && at(&found, **star).is_some());
    assert_eq!(kept_faint.count(), 0);
}

#[test]
fn a_crowd_is_told_and_bounded() {
    // Star-like spots every 13 px, far more than are examined; nearer ones are noise.
    let stars = places(500, 400, 13, 24);
    let mut frame = with_stars(Sky::new(500, 400, 60.0), &stars, 0.8, 900.0).expose(10);
    let found = scanned(&mut frame);
    assert!(found.crowded_tiles() > 0 && found.spots().len() <= MAX_DETECTIONS);
}

#[test]
fn a_scan_of_the_reference_detector_stays_below_77_million_cycles() {
    let geometry = fsw_hal::DetectorGeometry { width_px: 1280, height_px: 1024, bits: 10 };
    assert!(bound_cycles(&geometry) < 77_000_000, "{}", bound_cycles(&geometry));
}

#[test]
fn a_crowd_above_does_not_hide_the_stars_below() {
    // Three of four tiles are full of star-like spots; each of the others holds a bright star.
    let (width, height) = (800, 700);
    let mut sky = Sky::new(width, height, 60.0);
    for y in (10..500).step_by(13) {
        for x in (10..width - 10).step_by(13) {
            sky = sky.star([x as f64 + 0.2, y as f64 - 0.1], 0.8, 400.0);
        }
    }
    let mut stars = Vec::new();
    for y in [555, 610, 665] {
        for x in (40..width - 40).step_by(70) {
            stars.push([x as f64, y as f64 + 0.4]);
        }
    }
    // And one in the very middle of the crowd.
    stars.push([402.0, 246.0]);
    let found = scanned(&mut with_stars(sky, &stars, 0.9, 2500.0).noise(2.0, 31).expose(12));
    let seen = stars.iter().filter(|star| at(&found, **star).is_some()).count();
    std::println!("{seen} of {} stars, {} tiles crowded", stars.len(), found.crowded_tiles());
    assert!(found.crowded_tiles() > 30 && seen == stars.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn whatever_the_pixels_every_spot_lies_in_the_window(
        seed: u64, bits in 1u8..=16, width in 0u16..=140, height in 0u16..=70, kind in 0u8..4,
    ) {
        let mut chance = Chance(seed);
        let geometry = fsw_hal::DetectorGeometry { width_px: 150, height_px: 80, bits };
        // The last kinds break the promise that values have `bits` bits, and imitate stars and their absence.
        let mask = if kind < 2 { geometry.full_scale() } else { u16::MAX };
        let draw = |chance: &mut Chance| match kind {
            1 => if chance.bits().is_multiple_of(50) { u16::MAX } else { 0 },
            3 => (chance.bits() % 3) as u16 * 32_767,
            _ => chance.bits() as u16,
        };
        let pixels = (0..150 * 80).map(|_| draw(&mut chance) & mask).collect();
        let mut frame = Frame { geometry, pixels };
        let window = Window { x: 3, y: 5, width, height };
        let mut detections = Detections::new();
        let parameters = DetectionParameters { threshold_sigma_tenths: 30, ..DetectionParameters::default() };
        let _ = read_stars(&mut frame, window, &mut [0; TILE_PIXELS], &parameters, &mut detections);
        for spot in detections.spots() {
            let [x, y] = spot.centre_px();
            // The maximum lies in the core, and the centre within half the largest region of it.
            let margin = MARGIN as f32 - 3.5;
            prop_assert!(x > 3.0 + margin && x < 3.0 + f32::from(width) - margin);
            prop_assert!(y > 5.0 + margin && y < 5.0 + f32::from(height) - margin);
            prop_assert!(spot.sigma_px() > 0.0 && spot.flux > 0);
        }
    }
}
