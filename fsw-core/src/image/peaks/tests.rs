//! The quick search against the plain one: every sum compared with its 24 neighbours.

use super::*;
use crate::image::allowance::{CANDIDATE_CYCLES, WINDOW_CYCLES};
use crate::image::condition::condition;
use crate::image::test_sky::{Chance, Sky};
use fsw_pixels::window::BANDS;
use proptest::prelude::*;
use std::vec::Vec;

/// Sum of the 3 x 3 residuals about (x, y), against the levels of the rows and of the cell of a place.
fn sum9(window: &Residuals, (cell_x, cell_y): (usize, usize), x: usize, y: usize) -> i32 {
    let window = window.about(cell_x, cell_y);
    (y - 1..=y + 1).map(|y| window.run::<3>(x - 1, y).unwrap().sum::<i32>()).sum()
}

/// The same threshold in every cell.
fn everywhere(threshold: i32) -> Cells<i32> {
    [[threshold; BLOCKS]; BANDS]
}

/// Whether (x, y) is a peak of more than a pixel, by definition; sums outside the core count less the
/// tolerance.
fn is_peak(window: &Residuals, core: Window, (x, y): (usize, usize), threshold: i32) -> bool {
    let inside = |x: usize, y: usize| {
        (usize::from(core.x)..usize::from(core.x + core.width)).contains(&x)
            && (usize::from(core.y)..usize::from(core.y + core.height)).contains(&y)
    };
    let own = sum9(window, (x, y), x, y);
    let greater = |(nx, ny): (usize, usize)| {
        let other = sum9(window, (x, y), nx, ny) - if inside(nx, ny) { 0 } else { window.sum_sigma };
        other > own || (other == own && (ny, nx) < (y, x))
    };
    let around = (y - 2..=y + 2).flat_map(|ny| (x - 2..=x + 2).map(move |nx| (nx, ny)));
    own > threshold
        && !window.about(x, y).five_by_five(x, y).is_some_and(|pixels| is_single_pixel(&pixels))
        && !around.filter(|place| *place != (x, y)).any(greater)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn no_peak_is_lost_or_invented(
        seed: u64, width in 22usize..=128, height in 22usize..=64, bits in 6u8..=16, sigmas in 3i32..7, slope in -2.0..2.0f64,
    ) {
        let mut chance = Chance(seed);
        let scale = f64::from(1u32 << bits) / 64.0;
        let mut sky = Sky::new(width, height, 10.0 * scale).add(|x, _| slope * 0.05 * scale * x).noise(scale, seed);
        for _ in 0..6 {
            let at = [chance.even() * width as f64, chance.even() * height as f64];
            sky = sky.star(at, 0.9, 20.0 * scale * chance.even());
        }
        let mut pixels = sky.expose(bits).pixels;
        let window = condition(&mut pixels, width, bits).unwrap();
        let core = Window { x: 7, y: 7, width: width as u16 - 14, height: height as u16 - 14 };
        let threshold = sigmas * window.sum_sigma;
        let mut found = Vec::new();
        let whole = for_each_peak(&window, core, &everywhere(threshold), &mut Allowance::plenty(), |x, y, _| {found.push((y, x)); true});
        prop_assert!(whole);
        found.sort_unstable();
        let all = (7..height - 7).flat_map(|y| (7..width - 7).map(move |x| (x, y)));
        let expected: Vec<_> = all.filter(|place| is_peak(&window, core, *place, threshold)).map(|(x, y)| (y, x)).collect();
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn the_search_ends_with_the_allowance() {
    let mut pixels = Sky::new(128, 64, 500.0).noise(60.0, 3).expose(10).pixels;
    let window = condition(&mut pixels, 128, 10).unwrap();
    let core = Window { x: 7, y: 7, width: 114, height: 50 };
    // One of noise: there are peaks everywhere.
    let mut all = 0;
    assert!(for_each_peak(&window, core, &everywhere(0), &mut Allowance::plenty(), |_, _, _| {
        all += 1;
        true
    }));
    let mut calls = 0;
    let mut allowance = Allowance::of_a_window();
    assert!(!for_each_peak(&window, core, &everywhere(0), &mut allowance, |_, _, allowance| {
        calls += 1;
        allowance.spend(CANDIDATE_CYCLES)
    }));
    let most = (WINDOW_CYCLES / (LOOK_CYCLES.min(CANDIDATE_CYCLES) + CANDIDATE_CYCLES)) as usize;
    std::println!("{calls} of {all} peaks within a window's allowance");
    assert!(all > 100 && (1..=most + 1).contains(&calls));
    // A core that leaves no room for the sums is not searched, and that is told.
    let mut plenty = Allowance::plenty();
    assert!(!for_each_peak(&window, Window { x: 2, ..core }, &everywhere(0), &mut plenty, |_, _, _| {
        true
    }));
    assert!(for_each_peak(&window, Window { width: 0, ..core }, &everywhere(0), &mut plenty, |_, _, _| {
        true
    }));
}

#[test]
fn the_brightest_is_found_before_the_allowance_ends_wherever_it_stands() {
    for (x, y) in [(20.3, 15.0), (64.0, 32.4), (105.2, 50.1)] {
        let mut sky = Sky::new(128, 64, 100.0);
        for column in 0..9 {
            for row in 0..4 {
                sky = sky.star([13.0 + 12.0 * f64::from(column), 11.0 + 13.0 * f64::from(row)], 0.9, 150.0);
            }
        }
        let mut pixels = sky.star([x, y], 0.9, 2500.0).noise(2.0, 5).expose(12).pixels;
        let window = condition(&mut pixels, 128, 12).unwrap();
        let core = Window { x: 7, y: 7, width: 114, height: 50 };
        let mut found = Vec::new();
        let threshold = 5 * window.sum_sigma;
        assert!(!for_each_peak(
            &window,
            core,
            &everywhere(threshold),
            &mut Allowance::of_a_window(),
            |x, y, allowance| {
                found.push((x, y));
                allowance.spend(CANDIDATE_CYCLES)
            }
        ));
        // One that shares its row of a block may come before it.
        let near =
            |place: &(usize, usize)| (place.0 as f64 - x).abs() <= 1.0 && (place.1 as f64 - y).abs() <= 1.0;
        assert!(found.iter().take(2).any(near), "{found:?}");
    }
}
