use super::*;

/// Trials are at most the stars of a field less the two that made the hypothesis.
const MOST_TRIALS: u32 = MAX_FIELD_STARS as u32 - 2;

/// Binomial tail from exact coefficients (they fit u64 up to 62 trials), in f64 with `p^hits` taken out.
fn exact(hits: u32, trials: u32, p: f32) -> f64 {
    let p = f64::from(p);
    let mut coefficient = 1u64;
    let mut sum = 0.0;
    for k in 0..=trials {
        if k >= hits {
            sum += coefficient as f64 * p.powi((k - hits) as i32) * (1.0 - p).powi((trials - k) as i32);
        }
        coefficient = (u128::from(coefficient) * u128::from(trials - k) / u128::from(k + 1)) as u64;
    }
    f64::from(hits) * p.log10() + sum.log10()
}

#[test]
fn the_chance_of_a_match_is_the_exact_binomial_tail() {
    let logs = WholeLogs::default();
    let (mut worst, mut worst_relative) = (0.0f64, 0.0f64);
    for trials in 0..=MOST_TRIALS {
        for hits in 0..=trials {
            for p in [1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.03, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999] {
                let expected = if hits == 0 { 0.0 } else { exact(hits, trials, p) };
                let error = (f64::from(log10_binomial_tail(hits, trials, p, &logs)) - expected).abs();
                worst = worst.max(error);
                if expected < -1.0 {
                    worst_relative = worst_relative.max(error / -expected);
                }
            }
        }
    }
    std::println!("log10 of the tail: {worst:.1e} absolute, {worst_relative:.1e} relative");
    assert!(worst < 1e-3 && worst_relative < 1e-5, "{worst:e}, {worst_relative:e}");
}

#[test]
fn near_the_limit_of_1e_9_the_chance_is_right_to_a_thousandth() {
    let logs = WholeLogs::default();
    let mut tested = 0;
    for trials in 1..=MOST_TRIALS {
        for hits in 1..=trials {
            for step in 1..100 {
                let p = step as f32 * 0.005;
                let expected = exact(hits, trials, p);
                if (-12.0..-6.0).contains(&expected) {
                    let error =
                        10f64.powf(f64::from(log10_binomial_tail(hits, trials, p, &logs)) - expected) - 1.0;
                    assert!(error.abs() < 1e-3, "{hits} of {trials} at {p}: {error:e}");
                    tested += 1;
                }
            }
        }
    }
    assert!(tested > 1000, "{tested}");
}

#[test]
fn what_is_no_evidence_has_the_chance_one() {
    let logs = WholeLogs::default();
    for trials in [0, 1, MOST_TRIALS] {
        assert_eq!(log10_binomial_tail(0, trials, 0.1, &logs), 0.0);
        for p in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1.0, 2.0] {
            assert_eq!(log10_binomial_tail(trials, trials, p, &logs), 0.0, "{p}");
        }
    }
}

#[test]
fn more_hits_than_trials_are_impossible() {
    let logs = WholeLogs::default();
    assert_eq!(log10_binomial_tail(5, 4, 0.1, &logs), f32::NEG_INFINITY);
}

#[test]
fn the_chance_falls_with_every_hit_and_never_exceeds_one() {
    let logs = WholeLogs::default();
    for trials in 1..=MOST_TRIALS {
        for p in [1e-6, 0.01, 0.2, 0.5, 0.8, 0.999] {
            let tails = (0..=trials).map(|hits| log10_binomial_tail(hits, trials, p, &logs));
            let mut last = 0.0;
            for tail in tails {
                assert!(tail <= last + 1e-4 && tail <= 0.0, "{tail} after {last}: {trials} trials at {p}");
                last = tail;
            }
        }
    }
}
