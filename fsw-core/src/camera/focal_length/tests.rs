use super::*;
use crate::oracle::Generator;

/// What a scale uncertainty of the parameters allows.
const PRIOR: f32 = 2e-4;
/// Of an image with fifteen stars of 0.15 px.
const SIGMA: f32 = 1.3e-4;

/// An estimate after so many images, a second apart, of a lens of `true_ratio` at the second.
fn after(seconds: i64, generator: &mut Generator, true_ratio: impl Fn(i64) -> f64) -> FocalLength {
    let mut focal = FocalLength::new(PRIOR);
    for second in 0..seconds {
        let seen = true_ratio(second) + f64::from(SIGMA) * generator.gaussian();
        focal.update(seen as f32, SIGMA, LocalTime::from_us(second * 1_000_000));
    }
    focal
}

#[test]
fn a_lens_beyond_its_tolerance_is_followed_within_half_a_minute() {
    let mut generator = Generator::new(3);
    for ratio in [0.995, 0.9999, 1.0, 1.005] {
        let off = |seconds, generator: &mut Generator| {
            f64::from(after(seconds, generator, |_| ratio).ratio()) - ratio
        };
        assert!(off(30, &mut generator).abs() < 2.5e-4 && off(600, &mut generator).abs() < 5e-5);
    }
}

#[test]
fn a_barrel_that_warms_is_followed_to_a_twentieth_of_a_pixel_in_the_corner() {
    let mut generator = Generator::new(4);
    // 1 K a minute for half an hour.
    let ratio = |second: i64| 1.0 + 4e-7 * second as f64;
    let mut square = 0.0;
    for _ in 0..20 {
        let off = f64::from(after(1800, &mut generator, ratio).ratio()) - ratio(1799);
        square += off * off / 20.0;
    }
    std::println!("rms {:.1e}", f64::sqrt(square));
    assert!(square < 7e-5 * 7e-5);
}

#[test]
fn its_spread_in_steady_state_is_that_of_the_filter() {
    let mut generator = Generator::new(5);
    let (mut square, mut variance) = (0.0, 0.0);
    for _ in 0..200 {
        let focal = after(400, &mut generator, |_| 1.0);
        square += f64::from(focal.ratio() - 1.0).powi(2) / 200.0;
        variance = f64::from(focal.variance);
    }
    // 200 samples: 3 sigma of a variance are 30 %. The lens does not walk here: the filter allows for more.
    std::println!("{:.1e} of {:.1e}", square.sqrt(), variance.sqrt());
    assert!(square < 1.3 * variance && square > 0.3 * variance);
}

#[test]
fn nonsense_changes_nothing() {
    let mut focal = FocalLength::new(PRIOR);
    let now = LocalTime::from_us(5);
    for (ratio, sigma) in [
        (f32::NAN, SIGMA),
        (1.0, f32::NAN),
        (f32::INFINITY, SIGMA),
        (1.03, SIGMA),
        (0.97, SIGMA),
        (1.001, 0.0),
        (1.001, -1.0),
        (1.001, f32::INFINITY),
    ] {
        focal.update(ratio, sigma, now);
    }
    assert!(focal.ratio() == 1.0 && focal.instant.is_none());
    // A clock that runs backwards does no harm.
    focal.update(1.001, SIGMA, now);
    focal.update(1.001, SIGMA, LocalTime::from_us(-7_000_000));
    assert!(focal.ratio() > 1.0 && focal.ratio() <= 1.001 && focal.variance > 0.0);
}
