//! What a scan says of stars that the sensor's turning has drawn out, with hits among them.

use super::tests::{places, scanned};
use super::*;
use crate::image::calibration::{Calibration, sample};
use crate::image::test_sky::{Chance, Frame, Sky};
use crate::image::turn::Turn;
use crate::image::{Detection, DetectionParameters};
use std::vec::Vec;

/// Fewest spots drawn out that say anything, as in the sensor.
const FEWEST: u32 = 6;
const SPOT_PX: f64 = 1.0;
/// Of a sharper lens.
const SHARP_PX: f64 = 0.6;

/// [`turning_through`] a blunt lens.
fn turning(length: f64, seed: u64) -> (Frame, Vec<[f64; 2]>) {
    turning_through(SPOT_PX, length, seed)
}

/// 49 stars of 600 to 60,000 counts, drawn out over `length` px across the rows, among 8 hits that are sharp;
/// their middles.
fn turning_through(spot_px: f64, length: f64, seed: u64) -> (Frame, Vec<[f64; 2]>) {
    let mut chance = Chance(seed);
    let stars = places(460, 460, 60, seed);
    let mut sky = Sky::new(460, 460, 60.0);
    for [x, y] in &stars {
        let flux = 600.0 * 100f64.powf(chance.even());
        let (dx, dy) = (0.4 * length, 0.3 * length);
        sky = if length > 0.5 {
            sky.streak([[x - dx, y - dy], [x + dx, y + dy]], spot_px, flux / length)
        } else {
            sky.star([*x, *y], spot_px, flux)
        };
    }
    for _ in 0..8 {
        sky = sky.star([30.0 + 400.0 * chance.even(), 30.0 + 400.0 * chance.even()], 0.7, 4000.0);
    }
    (sky.noise(8.0, seed).expose(12), stars)
}

/// Distance of a spot from the nearest star's middle, px.
fn nearest_px(spot: &Detection, stars: &[[f64; 2]]) -> f64 {
    let [x, y] = spot.centre_px().map(f64::from);
    stars.iter().map(|[star_x, star_y]| (x - star_x).hypot(y - star_y)).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_slow_sensor_has_points_a_faster_one_drawn_stars_and_a_fast_one_streaks() {
    for seed in 1..=20 {
        let smear = |length| scanned(&mut turning(length, seed).0).smear(FEWEST);
        for length in [0.0, 1.0, 2.0] {
            assert_eq!(smear(length), Smear::Points, "{length} px, seed {seed}");
        }
        assert_eq!(smear(6.0), Smear::Drawn, "seed {seed}");
        for length in [12.0, 16.0, 24.0] {
            assert_eq!(smear(length), Smear::Streaks, "{length} px, seed {seed}");
        }
    }
}

#[test]
fn of_drawn_stars_those_that_are_kept_stand_in_the_middle_of_their_streaks() {
    let (mut kept, mut astray) = (0, 0);
    for seed in 1..=20 {
        for length in [5.0, 6.0, 7.0] {
            let (mut frame, stars) = turning(length, seed);
            let mut found = scanned(&mut frame);
            if found.smear(FEWEST) != Smear::Drawn {
                continue;
            }
            found.keep_drawn();
            for spot in found.spots() {
                kept += 1;
                astray += usize::from(nearest_px(spot, &stars) > 4.0 * f64::from(spot.sigma_px()));
            }
        }
    }
    std::println!("{kept} kept, {astray} beyond 4 sigma");
    // A hit beside a star, or on its streak: 8 of 460 x 460 px.
    assert!(kept > 1000 && 50 * astray <= kept);
}

/// The spots of a scan through a sharp lens, stars drawn out over `length` px and told to move by `told` px;
/// and the stars' middles.
fn scanned_as_told(length: f64, told: Option<f32>, seed: u64) -> (Detections, Vec<[f64; 2]>) {
    // Over 460 px a turn about the axes across a long lens moves every star alike.
    const FOCAL_LENGTH_PX: f32 = 1e6;
    let turn = |length: f32| {
        let about = [0.6, -0.8, 0.0].map(|share| share * length / FOCAL_LENGTH_PX);
        Turn::new([230.0; 2], FOCAL_LENGTH_PX, false, about)
    };
    let (mut frame, stars) = turning_through(SHARP_PX, length, seed);
    (scanned_sharply(&mut frame, told.map(turn)), stars)
}

/// The spots of a scan through the sharp lens, told how it turns.
fn scanned_sharply(frame: &mut Frame, turn: Option<Turn>) -> Detections {
    let bytes = sample::gaussian(SHARP_PX);
    let calibration = Calibration::open(&bytes).unwrap();
    let parameters = DetectionParameters::default();
    let method = DetectionMethod { parameters: &parameters, calibration: Some(&calibration), turn };
    let mut found = Detections::new();
    scan(frame, &mut [0; TILE_PIXELS], method, &mut found).unwrap();
    found
}

#[test]
fn stars_that_move_otherwise_than_is_told_are_blurred() {
    for seed in 1..=20 {
        let smear = |length, told| scanned_as_told(length, Some(told), seed).0.smear(FEWEST);
        assert_eq!(smear(0.0, 0.0), Smear::Points, "seed {seed}");
        assert_eq!(smear(3.0, 3.0), Smear::Points, "seed {seed}");
        for (length, told) in [(3.0, 0.0), (0.0, 3.0)] {
            let smear = smear(length, told);
            assert!(
                matches!(smear, Smear::Blurred | Smear::MostlyBlurred),
                "{length} px, {told} told: {smear:?}"
            );
        }
    }
}

#[test]
fn where_a_turn_begins_within_the_exposure_most_stars_look_otherwise_than_at_rest() {
    const REST: f64 = 0.2;
    let turn = Some(Turn::new([230.0; 2], 1e6, false, [0.0; 3]));
    for way_px in [5.0, 8.0] {
        // Of twelve parts of the exposure.
        let ways: [f64; 12] = core::array::from_fn(|part| {
            let since = ((part as f64 + 0.5) / 12.0 - REST).max(0.0) / (1.0 - REST);
            way_px * since * since
        });
        let mean = ways.iter().sum::<f64>() / 12.0;
        let (mut most, mut off_px, mut spots) = (0, 0.0, 0);
        for seed in 1..=20 {
            let mut chance = Chance(seed);
            let mut sky = Sky::new(460, 460, 60.0);
            let mut stars = places(460, 460, 60, seed);
            for [x, y] in &mut stars {
                let flux = 600.0 * 100f64.powf(chance.even());
                for way in ways {
                    sky = sky.star([*x + 0.8 * way, *y + 0.6 * way], SHARP_PX, flux / 12.0);
                }
                (*x, *y) = (*x + 0.8 * mean, *y + 0.6 * mean);
            }
            let found = scanned_sharply(&mut sky.noise(8.0, seed).expose(12), turn);
            most += usize::from(found.smear(FEWEST) == Smear::MostlyBlurred);
            off_px += found.spots().iter().map(|spot| nearest_px(spot, &stars)).sum::<f64>();
            spots += found.spots().len();
        }
        let off_px = off_px / spots as f64;
        std::println!("{way_px} px: mostly blurred in {most} of 20 images, centres {off_px:.2} px off");
        assert!(most == 20 && (0.2..2.0).contains(&off_px), "{way_px}: {most}, {off_px}");
    }
}

#[test]
fn of_stars_drawn_out_as_is_told_the_centres_are_nearer_to_the_middles_of_their_streaks() {
    // Of four places of 7 px through so sharp a lens the profile is no better than all the light.
    for (length, gain) in [(5.0f32, 3.0), (6.0, 3.0), (7.0, 0.8)] {
        let [(_, without_px, _), (kept, with_px, astray)] = [None, Some(length)].map(|told| {
            let mut misses_px = Vec::new();
            let mut astray = 0;
            for seed in 1..=20 {
                let (mut found, stars) = scanned_as_told(length.into(), told, seed);
                assert_eq!(found.smear(FEWEST), Smear::Drawn, "{length} px, {told:?}, seed {seed}");
                found.keep_drawn();
                for spot in found.spots() {
                    let nearest = nearest_px(spot, &stars);
                    misses_px.push(nearest);
                    astray += usize::from(nearest > 4.0 * f64::from(spot.sigma_px()));
                }
            }
            misses_px.sort_by(f64::total_cmp);
            (misses_px.len(), misses_px[misses_px.len() / 2], astray)
        });
        std::println!(
            "{length} px: {without_px:.3}, told {with_px:.3} px; {astray} of {kept} beyond 4 sigma"
        );
        assert!(gain * with_px < without_px && 50 * astray <= kept, "{length} px");
    }
}
