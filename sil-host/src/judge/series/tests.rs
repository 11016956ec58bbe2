use super::*;
use crate::world::noise::{Noise, Stream};

/// A series of three axes whose errors go together for `tau` seconds (first-order Gauss-Markov), of sigma 1,
/// told with `told` times that.
fn series(seed: u64, seconds: u32, tau: f64, told: f64) -> Series {
    let noise = Noise::new(seed, 0, Stream::Attitude);
    let kept = if tau > 0.0 { libm::exp(-1.0 / tau) } else { 0.0 };
    let mut error = [0, 1, 2].map(|axis| noise.gaussian(0, axis));
    let mut series = Series::new(3);
    for second in 0..seconds {
        series.add(second, Axes { error, sigma: [told; 3] });
        error = [0, 1, 2].map(|axis: usize| {
            kept * error[axis] + libm::sqrt(1.0 - kept * kept) * noise.gaussian(second + 1, axis as u32)
        });
    }
    series
}

#[test]
fn right_sigmas_are_called_consistent_and_others_are_not_however_errors_go_together() {
    // Seconds, correlation time; the last: six hours of errors that go together for ten minutes.
    for (seconds, tau) in [(600, 0.0), (3_600, 20.0), (21_600, 300.0)] {
        let (mut refused, mut wide, mut narrow, runs) = (0, 0, 0, 40);
        for seed in 1..=runs {
            let consistency =
                |told: f64| series(seed, seconds, tau, told).statistics(0, 1.0).unwrap().consistency;
            refused += u32::from(consistency(1.0) < 0.01);
            wide += u32::from(consistency(3.0) < 0.01);
            narrow += u32::from(consistency(1.0 / 3.0) < 0.01);
        }
        println!(
            "{seconds} s, tau {tau} s: {refused} of {runs} right ones refused; {wide} of sigma x 3, {narrow} of / 3"
        );
        // 1 % would be refused if the band were exact; it is wider.
        assert!(refused <= 2 && wide == 40 && narrow == 40);
    }
}

#[test]
fn the_time_for_which_errors_go_together_is_found() {
    // A Gauss-Markov process: 2 tau.
    let mean = (1..=20)
        .map(|seed| series(seed, 20_000, 50.0, 1.0).statistics(0, 1.0).unwrap().correlation_s)
        .sum::<f64>()
        / 20.0;
    assert!((80.0..200.0).contains(&mean), "{mean}");
}

#[test]
fn statistics_are_those_counted_by_hand() {
    let mut series = Series::new(2);
    let errors = [3.0, 3.0, 3.0, 8.0];
    for (second, error) in errors.into_iter().enumerate() {
        series.add(second as u32 + 10, Axes { error: [error, 4.0, f64::NAN], sigma: [2.0, 4.0, 0.0] });
    }
    series.add(14, Axes { error: [f64::NAN, 0.0, 0.0], sigma: [1.0; 3] });
    series.add(15, Axes { error: [0.0; 3], sigma: [0.0, 1.0, 1.0] });
    assert_eq!(series.not_finite(), 2);
    let found = series.statistics(0, 10.0).unwrap();
    assert_eq!((found.seconds, found.largest_sigma, found.jump_sigma), (4, 4.0, Some((2.5, 13))));
    assert_eq!((found.within_share, found.all_within_3_share), ([0.5, 0.875, 0.875], 0.75));
    assert!((found.error_95 - 10.0 * libm::sqrt(80.0)).abs() < 1e-9);
    assert!((found.normalised_square - (3.0 * 2.25 + 16.0 + 4.0) / 8.0).abs() < 1e-12);
    assert!((found.rms_axes[0] - 10.0 * libm::sqrt((27.0 + 64.0) / 4.0)).abs() < 1e-9);
    // Of 3, 3, 3, 8 the mean is 4.25, the mean square about it (3 * 1.25² + 3.75²) / 4.
    let near = |value: f64, by_hand: f64| (value - by_hand).abs() < 1e-9;
    assert!(near(found.bias_axes[0], 42.5) && near(found.noise_axes[0], 10.0 * libm::sqrt(4.6875)));
    assert!(near(found.bias_axes[1], 40.0) && near(found.noise_axes[1], 0.0));
    // The last second alone.
    let last = series.statistics(13, 1.0).unwrap();
    assert_eq!((last.seconds, last.rms_axes[0], last.sigma_axes[1], last.jump_sigma), (1, 8.0, 4.0, None));
    assert!(series.statistics(16, 1.0).is_none());
    // Four sigma are not beyond four.
    assert_eq!(found.beyond_4_share, 0.0);
    series.add(17, Axes { error: [0.0, 17.0, 0.0], sigma: [2.0, 4.0, 0.0] });
    assert_eq!(series.statistics(0, 1.0).unwrap().beyond_4_share, 0.2);
}
