use super::follow::{follow, piece_at};
use super::search::{Pieces, search};
use super::*;
use crate::image::scan::TILE_PIXELS;
use crate::image::test_sky::{Chance, Frame, Sky};
use proptest::prelude::*;
use std::vec::Vec;

const LEVEL: f64 = 60.0;
/// Noise of a pixel, counts of 12 bits.
const NOISE: f64 = 8.0;
const BITS: u8 = 12;
/// Sigma of a star's image, px.
const SPOT_PX: f64 = 0.9;

fn taken(ends: [[f64; 2]; 2], light: f64, seed: u64) -> Frame {
    Sky::new(384, 320, LEVEL).streak(ends, SPOT_PX, light).noise(NOISE, seed).expose(BITS)
}

/// Ends about the picture's middle.
fn ends(length: f64, angle: f64, [dx, dy]: [f64; 2]) -> [[f64; 2]; 2] {
    let half = [0.5 * length * angle.cos(), 0.5 * length * angle.sin()];
    [-1.0, 1.0].map(|sign| [192.0 + dx + sign * half[0], 160.0 + dy + sign * half[1]])
}

fn found(frame: &mut Frame) -> Vec<Streak> {
    let mut buffer = [0; TILE_PIXELS];
    let mut pieces = Pieces::new();
    search(frame, &mut buffer, &mut pieces).unwrap();
    let mut streaks: Vec<Streak> = Vec::new();
    for piece in &pieces {
        if !streaks.iter().any(|streak| streak.holds(piece.at_px, 6.0)) {
            streaks.extend(follow(frame, &mut buffer, piece, &mut 20_000).unwrap());
        }
    }
    streaks
}

/// Errors of the ends along and across, over their sigmas.
fn normalised(streak: &Streak, truth: [[f64; 2]; 2]) -> [f64; 4] {
    let [a, b] = streak.ends_px.map(|end| end.map(f64::from));
    let far = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
    let [from, to] = if far(a, truth[0]) < far(a, truth[1]) { truth } else { [truth[1], truth[0]] };
    let length = far(from, to);
    let (ux, uy) = ((to[0] - from[0]) / length, (to[1] - from[1]) / length);
    let off = |p: [f64; 2], q: [f64; 2]| {
        let (dx, dy) = (p[0] - q[0], p[1] - q[1]);
        [
            (dx * ux + dy * uy) / f64::from(streak.sigma_along_px),
            (dy * ux - dx * uy) / f64::from(streak.sigma_across_px),
        ]
    };
    let ([e, f], [g, h]) = (off(a, from), off(b, to));
    [e, f, g, h]
}

/// Of 40 streaks of such lengths and light a pixel's length, noises of a pixel: how many are missed, and the
/// mean squares of their ends' errors over their sigmas, along and across.
fn measured(lengths: [f64; 2], lights: [f64; 2]) -> (u32, f64, f64) {
    let mut chance = Chance(5);
    let (mut along, mut across, mut count, mut missed) = (0.0, 0.0, 0.0, 0);
    for case in 0..40 {
        let mut between = |[least, most]: [f64; 2]| least + (most - least) * chance.even();
        let length = between(lengths);
        let truth = ends(length, between([0.0, core::f64::consts::PI]), [0, 1].map(|_| between([0.0, 20.0])));
        let mut frame = taken(truth, NOISE * between(lights), case);
        let streaks = found(&mut frame);
        let near = streaks.iter().find(|streak| streak.length_px() as f64 > 0.6 * length);
        let Some(streak) = near else {
            missed += 1;
            continue;
        };
        assert!(!streak.cut);
        let [a, b, c, d] = normalised(streak, truth).map(|sigmas| sigmas * sigmas);
        along += a + c;
        across += b + d;
        count += 2.0;
    }
    let (along, across) = (along / count, across / count);
    std::println!("{missed} of 40 missed; mean squares along {along}, across {across}");
    (missed, along, across)
}

#[test]
fn a_streak_of_any_length_and_direction_is_found_and_its_ends_are_as_sure_as_they_say() {
    let (missed, along, across) = measured([40.0, 200.0], [4.0, 16.0]);
    assert!(missed <= 2 && along < 2.0 && across < 2.0);
}

/// A search's line of bins holds them whole in many directions.
#[test]
fn the_ends_of_a_short_streak_are_as_sure_as_they_say() {
    let (missed, along, across) = measured([11.0, 24.0], [8.0, 20.0]);
    assert!(missed <= 10 && along < 2.0 && across < 1.0);
}

/// Bright ones are seen along lines that cross them too; of what is at full scale half lies outside of half
/// of the light, by up to 1.5 px.
#[test]
fn the_ends_of_a_bright_streak_are_as_sure_as_they_say() {
    for lights in [[400.0, 1200.0], [1200.0, 2400.0], [2400.0, 8000.0], [8000.0, 90_000.0]] {
        let (missed, along, across) = measured([20.0, 60.0], lights);
        assert!(missed <= 1 && along < 2.0 && across < 2.0);
    }
}

#[test]
fn a_faint_streak_is_seen_as_a_line_where_no_pixel_stands_out() {
    // 1.2 sigma of a pixel a pixel's length: 0.5 sigma in the brightest pixel.
    let seen = (0..10).filter(|seed| {
        let truth = ends(220.0, 0.3 + 0.2 * *seed as f64, [0.0; 2]);
        let streaks = found(&mut taken(truth, 2.2 * NOISE, *seed));
        streaks.iter().any(|streak| streak.holds([192.0, 160.0], 3.0))
    });
    assert!(seen.count() >= 8);
}

#[test]
fn stars_hits_an_edge_and_noise_are_no_streaks() {
    for seed in 0..4 {
        let mut chance = Chance(seed);
        let mut sky = Sky::new(384, 320, LEVEL);
        for _ in 0..20 {
            sky = sky.star([384.0 * chance.even(), 320.0 * chance.even()], 0.9, 2000.0);
            sky = sky.star([384.0 * chance.even(), 320.0 * chance.even()], 0.3, 3000.0);
        }
        let sky = sky.add(|x, y| if x + 0.3 * y > 300.0 { 400.0 } else { 0.0 });
        let streaks = found(&mut sky.noise(NOISE, seed).expose(BITS));
        assert!(streaks.len() <= 1, "{seed}: {streaks:?}");
    }
}

#[test]
fn lines_before_a_sky_brighter_than_the_darkest_are_no_streaks() {
    let dark = [[60.0, 70.0], [180.0, 95.0]];
    let bright = [[150.0, 240.0], [290.0, 270.0]];
    // The lower half by less than a sixty-fourth of full scale brighter, and by more.
    for (by, expected) in [(30.0, [true, true]), (100.0, [true, false])] {
        let sky = [dark, bright]
            .into_iter()
            .fold(Sky::new(384, 320, LEVEL), |sky, ends| sky.streak(ends, SPOT_PX, 20.0 * NOISE));
        let sky = sky.add(|_, y| if y > 150.0 { by * ((y - 150.0) / 40.0).min(1.0) } else { 0.0 });
        let streaks = found(&mut sky.noise(NOISE, 3).expose(BITS));
        let seen = [dark, bright].map(|[from, to]: [[f64; 2]; 2]| {
            let middle = [0, 1].map(|axis| (0.5 * (from[axis] + to[axis])) as f32);
            streaks.iter().any(|streak| streak.holds(middle, 3.0))
        });
        assert_eq!(seen, expected, "{by}: {streaks:?}");
    }
}

#[test]
fn a_streak_that_leaves_the_picture_is_said_to_be_cut() {
    let truth = [[200.0, 150.0], [420.0, 190.0]];
    let streaks = found(&mut taken(truth, 20.0 * NOISE, 1));
    assert!(!streaks.is_empty() && streaks.iter().all(|streak| streak.cut));
}

#[test]
fn the_direction_of_a_short_streak_is_told_by_its_moments() {
    for tenths in 0..31 {
        let angle = 0.1 * f64::from(tenths);
        let mut frame = taken(ends(12.0, angle, [0.3, 0.4]), 40.0 * NOISE, 2);
        let piece = piece_at(&mut frame, &mut [0; TILE_PIXELS], [192, 160]).unwrap().unwrap();
        let cosine = f64::from(piece.along[0]) * angle.cos() + f64::from(piece.along[1]) * angle.sin();
        assert!(cosine.abs() > 0.97, "{angle}: {piece:?}");
        let streak = follow(&mut frame, &mut [0; TILE_PIXELS], &piece, &mut 3000).unwrap().unwrap();
        assert!((streak.length_px() - 12.0).abs() < 0.4, "{angle}: {}", streak.length_px());
    }
}

#[test]
fn without_columns_left_nothing_is_sampled() {
    let mut frame = taken(ends(80.0, 0.2, [0.0; 2]), 20.0 * NOISE, 1);
    let piece = Piece { at_px: [192.0, 160.0], along: [1.0, 0.2], strength: 80, background: 0 };
    let mut columns = 63;
    assert_eq!(follow(&mut frame, &mut [0; TILE_PIXELS], &piece, &mut columns), Ok(None));
    assert_eq!(columns, 63);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn any_piece_on_any_pixels_is_followed_without_a_panic_within_the_columns(
        x in -500f32..900.0, y in any::<f32>(), angle in 0f32..7.0, seed in any::<u64>(), bits in 8u8..=16,
    ) {
        let mut chance = Chance(seed);
        let geometry = fsw_hal::DetectorGeometry { width_px: 200, height_px: 130, bits };
        let pixels = (0..200 * 130).map(|_| (chance.bits() & chance.bits()) as u16 >> (16 - bits)).collect();
        let mut frame = Frame { geometry, pixels };
        let mut buffer = [0; TILE_PIXELS];
        for y in [y, y % 200.0] {
            let piece = Piece { at_px: [x, y], along: [angle.cos(), angle.sin()], strength: 0, background: 0 };
            let mut columns = 3000;
            follow(&mut frame, &mut buffer, &piece, &mut columns).unwrap();
        }
        search(&mut frame, &mut buffer, &mut Pieces::new()).unwrap();
        prop_assert!(piece_at(&mut frame, &mut buffer, [x.max(0.0) as u16, 5]).is_ok());
    }
}
