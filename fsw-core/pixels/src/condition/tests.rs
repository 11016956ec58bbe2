//! Levels and noise against the truth they were drawn from.

use super::*;
use crate::test_sky::{Chance, Sky};
use proptest::prelude::*;

/// Largest absolute residual of noiseless pixels.
fn leftover(residuals: &Residuals) -> i32 {
    let residual = |x, y| residuals.about(x, y).run::<1>(x, y).and_then(|mut run| run.next());
    let row = |y: usize| (0..residuals.width()).filter_map(move |x| residual(x, y));
    (0..residuals.height()).flat_map(row).map(i32::abs).max().unwrap_or(0)
}

#[test]
fn the_noise_is_measured_within_6_percent() {
    for (bits, sigma) in [(10u8, 1.5), (10, 4.0), (12, 5.0), (14, 30.0), (16, 100.0)] {
        let (mut pixel, mut sum, windows) = (0.0, 0.0, 40);
        for seed in 0..windows {
            let mut pixels = Sky::new(120, 62, 20.0 * sigma).noise(sigma, seed).expose(bits).pixels;
            let residuals = condition(&mut pixels, 120, bits).unwrap();
            // Rounding to counts adds a twelfth of a squared count.
            let truth = (sigma * sigma + 1.0 / 12.0).sqrt() * f64::from(FULL_SCALE) / f64::from(1u32 << bits);
            let ratio = f64::from(residuals.sigma) / truth;
            assert!((0.8..1.2).contains(&ratio), "a single window: {ratio}");
            pixel += ratio / windows as f64;
            sum += f64::from(residuals.sum_sigma) / (3.0 * truth) / windows as f64;
        }
        std::println!("{bits} bits, sigma {sigma}: pixels {pixel:.3}, sums {sum:.3} of the truth");
        assert!((0.94..1.06).contains(&pixel) && (0.94..1.1).contains(&sum));
    }
}

#[test]
fn rows_and_blocks_of_any_level_are_levelled() {
    // 12 bits: a scaled count is a quarter of a raw one.
    for width in [16, 27, 63, 64, 100, 128] {
        let sky = Sky::new(width, 50, 600.0)
            .add(|_, y| ((y as i32 * 37) % 11 * 13) as f64)
            .add(|x, _| ((x as i32 / 16 * 29) % 7 * 40) as f64);
        let mut pixels = sky.expose(12).pixels;
        let residuals = condition(&mut pixels, width, 12).unwrap();
        assert!(leftover(&residuals) <= 2, "width {width}: {}", leftover(&residuals));
    }
}

#[test]
fn rows_levels_err_by_less_where_the_readout_bands_less() {
    // A window that a star is tracked in, its background sloping down.
    let (side, sigma, windows) = (27, 8.0, 200);
    let error = |banding: f64| {
        let mut square = 0.0;
        for seed in 0..windows {
            let mut chance = Chance(900 + seed);
            let bands: std::vec::Vec<f64> = (0..side).map(|_| banding * chance.gaussian()).collect();
            let truth = |y: usize| 600.0 + 1.5 * y as f64 + bands[y];
            let sky = Sky::new(side, side, 0.0).add(|_, y| truth(y as usize)).noise(sigma, seed);
            let mut pixels = sky.expose(12).pixels;
            let residuals = condition(&mut pixels, side, 12).unwrap();
            let apart: std::vec::Vec<f64> =
                (0..side).map(|y| 0.25 * f64::from(residuals.level(side / 2, y)) - truth(y)).collect();
            // All rows alike move no centre.
            let mean = apart.iter().sum::<f64>() / side as f64;
            square += apart.iter().map(|apart| (apart - mean).powi(2)).sum::<f64>() / side as f64;
        }
        (square / windows as f64).sqrt() / sigma
    };
    let [none, some, strong] = [0.0, 0.15, 2.0].map(|share| error(share * sigma));
    std::println!("error of a row's level, sigmas of a pixel: {none:.3}, {some:.3}, {strong:.3}");
    // A mean of the row's pixels alone errs by 0.2.
    assert!(none < 0.13 && some < 0.18 && strong < 0.24);
}

#[test]
fn neighbours_that_go_together_widen_the_noise_of_sums() {
    let white = Sky::new(122, 64, 400.0).noise(8.0, 9);
    let mut smooth = white.clone();
    for (index, value) in smooth.values.iter_mut().enumerate().skip(1) {
        *value = 0.5 * (white.values[index] + white.values[index - 1]);
    }
    let measure = |sky: &Sky| {
        let mut pixels = sky.expose(12).pixels;
        let residuals = condition(&mut pixels, 122, 12).unwrap();
        f64::from(residuals.sum_sigma) / f64::from(residuals.sigma)
    };
    assert!((2.9..3.5).contains(&measure(&white)) && measure(&smooth) > 3.5);
}

#[test]
fn clouds_do_not_make_the_sky_beside_them_noisy() {
    let sigma = 2.0;
    for (clouded, seed) in [(40usize, 1), (72, 2), (88, 3)] {
        // Waves of many lengths, as high as a hundred sigmas, up to a rim.
        let cloud = |x: f64, y: f64| {
            let wave = |length: f64, angle: f64| {
                ((x * angle.cos() + y * angle.sin()) * std::f64::consts::TAU / length).sin()
            };
            let height = 300.0 + 60.0 * wave(70.0, 1.2) + 50.0 * wave(31.0, 2.6) + 40.0 * wave(13.0, 0.4);
            if x < clouded as f64 { height } else { 0.0 }
        };
        let sky = Sky::new(120, 62, 200.0);
        let noise_of = |sky: &Sky| {
            let mut pixels = sky.clone().noise(sigma, seed).expose(12).pixels;
            *condition(&mut pixels, 120, 12).unwrap().noise()
        };
        let (clear, beside) = (noise_of(&sky), noise_of(&sky.clone().add(cloud)));
        // The rim's neighbours may feel it; a cell's own noise is known to a quarter, and a chance hill
        // doubles it.
        let first = clouded.div_ceil(BLOCK) + 1;
        for (clear, beside) in clear.iter().zip(&beside) {
            for block in first..BLOCKS {
                let ratio = f64::from(beside[block]) / f64::from(clear[block]);
                assert!((0.6..2.0).contains(&ratio), "{clouded} columns of clouds, block {block}: {ratio}");
            }
        }
        assert!(beside.iter().all(|band| band[0] > 5 * clear[0][0]), "and clouds are told");
    }
}

#[test]
fn windows_that_cannot_be_served_are_refused() {
    let mut pixels = [100; 129 * 65];
    for (length, width) in [(0, 0), (15 * 20, 15), (129 * 20, 129), (128 * 65, 128), (20 * 20 + 1, 20)] {
        assert!(condition(&mut pixels[..length], width, 10).is_none(), "{length} px, width {width}");
    }
    assert!(condition(&mut pixels[..16], 16, 10).is_some());
}

proptest! {
    #[test]
    fn the_levels_hardly_feel_a_star(x in 6.0..114.0f64, star_y in 6.0..56.0f64, flux in 0.0..50_000.0f64) {
        let sky = Sky::new(120, 62, 200.0);
        let mut pixels = sky.star([x, star_y], 1.2, flux).expose(12).pixels;
        let residuals = condition(&mut pixels, 120, 12).unwrap();
        for y in 0..62 {
            for column in 0..120 {
                // The wings of a star count in its own cell, and little: a two-thousandth of its light a pixel.
                let near = (column as f64 - x).abs() < 20.0 && (y as f64 - star_y).abs() < 20.0;
                let most = 12 + if near { (4.0 * flux / 2_000.0) as i32 } else { 0 };
                prop_assert!((residuals.level(column, y) - 800).abs() <= most, "{} {y}: {}", column, residuals.level(column, y));
            }
        }
    }
}
