use super::*;
use crate::rate::arcs::tests::{Chance, turned};

const FIELD: DetectorScale = DetectorScale { rad_per_px: 1.0 / 3000.0, area_px: 1280.0 * 1024.0 };
const EXPOSURE_S: f64 = 0.4;
/// Standard deviations of a streak from end to end, along and across, rad.
const SIGMA_RAD: [f32; 2] = [7e-4, 2e-4];

/// A streak's arc, its ends off by their sigmas.
fn streak(ends: [[f64; 3]; 2], chance: &mut Chance) -> Arc {
    let [a, c] = ends.map(|end| Vector3::from(end.map(|part| part as f32)));
    let along = (c - a).normalize();
    let across = (a + c).cross(&along).normalize();
    let [along_rad, across_rad] = SIGMA_RAD.map(|sigma| sigma * core::f32::consts::FRAC_1_SQRT_2);
    let mut off = |end: Vector3<f32>| {
        let [x, y] = [along_rad, across_rad].map(|sigma| sigma * chance.gaussian() as f32);
        (end + along * x + across * y).normalize()
    };
    let ends = [off(a), off(c)];
    Arc { ends, sigma_rad: SIGMA_RAD, duration_s: [EXPOSURE_S as f32; 2], directed: false, whole: true }
}

/// The arc of a star that is at its place in the middle of the exposure.
fn drawn(star: [f64; 3], rate: [f64; 3], chance: &mut Chance) -> Arc {
    streak([-0.5, 0.5].map(|share| turned(star, rate, share * EXPOSURE_S)), chance)
}

/// What the history tells of an image of streaks, a second after the one before.
fn told(history: &mut RateHistory, streaks: impl Iterator<Item = Arc>, is_first: bool) -> Option<StreakRate> {
    let arcs: std::vec::Vec<_> = streaks.collect();
    history.update_from_streaks((&arcs, &[0.0; MAX_ARCS]), (!is_first).then_some(1.0), FIELD)
}

/// The largest error of a rate over its sigma, of any axis; of either sense the nearer.
fn sigmas(rate: &StreakRate, truth: [f64; 3]) -> f32 {
    let (found, covariance) = rate.estimate;
    let truth = Vector3::from(truth.map(|part| part as f32));
    let sense = if rate.either_sense && found.dot(&truth) < 0.0 { -1.0 } else { 1.0 };
    let sigma = covariance.diagonal().map(libm::sqrtf);
    (found * sense - truth).component_div(&sigma).amax()
}

/// Where stars are a second after `second`, while they turn about an axis by `deg_s` of time: the exposures'
/// middles are a second apart, the mean of a hundred steps.
fn a_second_later<const COUNT: usize>(
    stars: [[f64; 3]; COUNT],
    axis: [f64; 3],
    deg_s: impl Fn(f64) -> f64,
    second: u32,
) -> [[f64; 3]; COUNT] {
    (0..100).fold(stars, |stars, step| {
        let at = deg_s(f64::from(second) + (f64::from(step) + 0.5) / 100.0).to_radians();
        stars.map(|star| turned(star, axis.map(|part| part * at), 0.01))
    })
}

/// Eight stars seen for ten seconds while the size of the rate goes as `deg_s` of time. Returns the largest
/// errors of the rates that were told, sigmas, of the last one, a share of it, and by which share of it each
/// may change in a second.
fn fly(deg_s: impl Fn(f64) -> f64, chance: &mut Chance) -> (std::vec::Vec<f32>, f32, std::vec::Vec<f32>) {
    let axis = chance.rate(1.0).map(f64::to_degrees);
    let mut stars: [[f64; 3]; 8] = core::array::from_fn(|_| chance.star());
    let (mut history, mut errors, mut last) = (RateHistory::default(), std::vec::Vec::new(), 0.0);
    let mut changes = std::vec::Vec::new();
    for second in 0..10 {
        let rate = axis.map(|part| part * deg_s(f64::from(second)).to_radians());
        let streaks = stars.map(|star| drawn(star, rate, chance));
        if let Some(rate_told) = told(&mut history, streaks.into_iter(), second == 0) {
            errors.push(sigmas(&rate_told, rate));
            last = (rate_told.estimate.0.norm() / Vector3::from(rate).norm() as f32 - 1.0).abs();
            changes.push(history.possible_change().unwrap().amax() / rate_told.estimate.0.norm());
        }
        stars = a_second_later(stars, axis, &deg_s, second);
    }
    (errors, last, changes)
}

#[test]
fn rates_are_within_their_sigmas_at_rest_in_a_slew_and_as_one_begins_and_ends() {
    let mut chance = Chance(11);
    let slew = |t: f64| 1.0 + 0.2 * t;
    let hump = |t: f64| 1.0 + 1.2 * (1.0 - (core::f64::consts::TAU * t / 9.0).cos());
    let shakes = |t: f64| 1.0 + 0.05 * (2.9 * t).sin();
    let mut shares = std::vec::Vec::new();
    for (case, deg_s) in [&|_: f64| 1.0, &slew as &dyn Fn(f64) -> f64, &hump, &shakes].iter().enumerate() {
        let (mut count, mut beyond) = (0, 0);
        for _ in 0..40 {
            let (errors, share, changes) = fly(deg_s, &mut chance);
            if case == 0 {
                // A rate that stays may be the crest of a slew: that is forgotten slowly, by half in seven images.
                let (second, last) = (changes[1], changes.last().unwrap());
                assert!(second > 0.15 && (0.3..0.6).contains(&(last / second)), "{changes:?}");
            }
            count += errors.len();
            beyond += errors.iter().filter(|error| **error > 4.0).count();
            assert!(errors.iter().all(|error| *error < 6.0), "{case}: {errors:?}");
            if case == 0 {
                shares.push(share);
            }
        }
        std::println!("case {case}: {count} rates, {beyond} beyond 4 sigma");
        assert!(count >= 320 && beyond <= 4, "{case}: {beyond} of {count}");
    }
    // The goal for a rate that stays.
    shares.sort_by(f32::total_cmp);
    assert!(shares[20] < 0.01, "{}", shares[20]);
}

#[test]
fn lines_of_any_direction_and_length_give_hardly_ever_a_rate() {
    // As the tracks of protons: 10 to 100 px.
    let mut chance = Chance(12);
    let mut rates = 0;
    let mut history = RateHistory::default();
    for image in 0..1000 {
        let lines: std::vec::Vec<_> = (0..8)
            .map(|_| {
                let (from, angle) = (chance.star(), core::f64::consts::PI * chance.next());
                let length = (55.0 + 45.0 * chance.next()) / 3000.0;
                let to = [from[0] + length * angle.cos(), from[1] + length * angle.sin(), from[2]];
                let norm = to.iter().map(|part| part * part).sum::<f64>().sqrt();
                streak([from, to.map(|part| part / norm)], &mut chance)
            })
            .collect();
        rates += u32::from(told(&mut history, lines.into_iter(), image == 0).is_some());
    }
    std::println!("rates of random lines: {rates} in 1,000 images");
    assert!(rates <= 5, "{rates}");
}

/// Whether an image in which three of four streaks have a rate tells it, after one in which two of `before`
/// have it and the others any.
fn repeats(before: usize, chance: &mut Chance) -> bool {
    let rate = chance.rate(12.0);
    let mut image = |having: usize, all: usize| -> std::vec::Vec<Arc> {
        let of = |number: usize, chance: &mut Chance| {
            let star = chance.star();
            let rate = if number < having { rate } else { chance.rate(12.0) };
            drawn(star, rate, chance)
        };
        (0..all).map(|number| of(number, chance)).collect()
    };
    let (first, second) = (image(2, before), image(3, 4));
    let mut history = RateHistory::default();
    told(&mut history, first.into_iter(), true);
    told(&mut history, second.into_iter(), false).is_some()
}

#[test]
fn two_of_many_streaks_of_the_last_image_are_no_evidence() {
    let mut chance = Chance(13);
    let [two, nine] = [2, 9].map(|before| (0..100).filter(|_| repeats(before, &mut chance)).count());
    std::println!("told after two of two streaks: {two} of 100, after two of nine: {nine}");
    assert!(two >= 50 && nine <= 5, "{two} and {nine}");
}

#[test]
fn streaks_that_agree_do_not_outvote_the_best_known_one() {
    let mut chance = Chance(14);
    let [mut alone, mut outvoted] = [0, 0];
    for _ in 0..100 {
        let rate = chance.rate(3.0);
        let mut of = |rate| drawn(chance.star(), rate, &mut chance);
        let long: std::vec::Vec<_> = (0..5).map(|_| of(rate.map(|part| 1.4 * part))).collect();
        let sharp = [of(rate), of(rate)].map(|arc| Arc { sigma_rad: arc.sigma_rad.map(|s| 0.7 * s), ..arc });
        let is_told = |arcs: &[Arc]| told(&mut RateHistory::default(), arcs.iter().copied(), true).is_some();
        alone += u32::from(is_told(&long));
        let all: std::vec::Vec<_> = long.iter().chain(&sharp).copied().collect();
        outvoted += u32::from(is_told(&all));
    }
    std::println!(
        "five streaks of one rate are told: {alone} of 100, beside two better ones of another: {outvoted}"
    );
    assert!(alone >= 80 && outvoted <= 5, "{alone} and {outvoted}");
}

#[test]
fn two_streaks_alone_are_no_evidence_after_a_known_rate() {
    let mut chance = Chance(15);
    let [mut two, mut three] = [0, 0];
    for _ in 0..100 {
        let rate = chance.rate(3.0);
        let mut stars: [[f64; 3]; 8] = core::array::from_fn(|_| chance.star());
        for (last, tally) in [(2, &mut two), (3, &mut three)] {
            let mut history = RateHistory::default();
            let seen = [8, 8, 8, last];
            let rates: std::vec::Vec<_> = (0..)
                .zip(seen)
                .map(|(second, count)| {
                    stars = stars.map(|star| turned(star, rate, 1.0));
                    let streaks = stars.map(|star| drawn(star, rate, &mut chance));
                    told(&mut history, streaks.into_iter().take(count), second == 0)
                })
                .collect();
            // Of eight it is told, of both senses the right one.
            assert!(rates[2].is_some_and(|rate| !rate.either_sense));
            *tally += u32::from(rates[3].is_some());
        }
    }
    std::println!("told after a known rate by two streaks: {two} of 100, by three: {three}");
    assert!(two == 0 && three >= 80, "{two} and {three}");
}

/// Errors over sigmas, and sigmas as a share of the rate, of the rates between images of six stars without
/// streaks, second by second, while the size of the rate goes as `deg_s` of time.
fn fly_by_stars(deg_s: impl Fn(f64) -> f64, chance: &mut Chance) -> std::vec::Vec<[f32; 2]> {
    let axis = chance.rate(1.0).map(f64::to_degrees);
    let mut stars: [[f64; 3]; 6] = core::array::from_fn(|_| chance.star());
    let (mut history, mut told) = (RateHistory::default(), std::vec::Vec::new());
    for second in 0..10 {
        let marks = stars.map(|star| Mark {
            direction: Vector3::from(star.map(|part| part as f32 + 1e-4 * chance.gaussian() as f32))
                .normalize(),
            sigma_rad: [1e-4; 2],
            late_s: 0.0,
        });
        let found = history.update_from_stars(marks.into_iter().collect(), (second > 0).then_some(1.0));
        if let Some(((rate, covariance), _)) = found {
            let truth = axis.map(|part| (part * deg_s(f64::from(second)).to_radians()) as f32);
            let sigma = covariance.diagonal().map(libm::sqrtf);
            told.push([
                (rate - Vector3::from(truth)).component_div(&sigma).amax(),
                sigma.amax() / rate.norm(),
            ]);
        }
        stars = a_second_later(stars, axis, &deg_s, second);
    }
    told
}

#[test]
fn rates_between_images_of_stars_are_within_their_sigmas_as_a_slew_begins_and_ends() {
    let mut chance = Chance(17);
    let turned = |at: f64| (at - 2.0).clamp(0.0, 6.0) / 6.0;
    let slew = |at: f64| 0.002 + 0.3 * (1.0 - libm::cos(core::f64::consts::TAU * turned(at)));
    let (mut slewing, mut spinning) = (0.0f32, std::vec::Vec::new());
    for _ in 0..200 {
        slewing = fly_by_stars(slew, &mut chance).into_iter().map(|[error, _]| error).fold(slewing, f32::max);
        spinning.extend(fly_by_stars(|_| 0.3, &mut chance).into_iter().skip(1).map(|[_, share]| share));
    }
    spinning.sort_by(f32::total_cmp);
    let usual = spinning[spinning.len() / 2];
    std::println!("slews within {slewing:.1} sigma; of a spin known to {usual:.3}, {} times", spinning.len());
    // With an eighth of the rate as its sigma 13.4 in a slew.
    assert!(slewing < 4.0 && usual < 0.25 && spinning.len() > 1000);
}
