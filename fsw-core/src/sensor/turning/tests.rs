//! What is done with the next image.

use super::*;

/// Whether each of so many images is searched for lines; a scan shows so many stars and asks for lines, a
/// search finds none and gives a rate where `rate_at` is its number.
fn images(count: usize, stars: usize, rate_at: Option<usize>) -> std::vec::Vec<bool> {
    let mut next = Next::default();
    (0..count)
        .map(|number| {
            let seeks = next.seeks;
            next = if seeks {
                next.after_lines(&[], rate_at == Some(number))
            } else {
                next.after_scan(true, stars)
            };
            seeks
        })
        .collect()
}

#[test]
fn lines_that_give_no_rate_leave_every_other_image_to_the_stars() {
    let searched = images(41, FEWEST_STARS, None);
    assert_eq!(searched[..5], [false, true, true, true, false]);
    assert!(searched[5..].chunks(2).all(|pair| pair == [true, false]), "{searched:?}");
}

#[test]
fn a_scan_that_shows_no_stars_begins_the_searches_anew() {
    let searched = images(9, FEWEST_STARS - 1, None);
    assert_eq!(searched, [false, true, true, true, false, true, true, true, false]);
}

#[test]
fn a_rate_gives_the_searches_for_lines_their_patience_back() {
    let searched = images(14, FEWEST_STARS, Some(7));
    assert_eq!(searched[4..8], [false, true, false, true]);
    assert_eq!(searched[8..12], [true, true, true, false]);
}

#[test]
fn without_streaks_the_exposure_changes_from_search_to_search() {
    let mut next = Next::default();
    let mut divisors = std::vec::Vec::new();
    for _ in 0..6 {
        next = next.after_lines(&[], false).after_scan(true, FEWEST_STARS);
        divisors.push(next.divisor);
    }
    assert_eq!(divisors, [UNSEEN_DIVISOR, 1, UNSEEN_DIVISOR, 1, UNSEEN_DIVISOR, 1]);
}

#[test]
fn the_exposure_is_shortened_to_streaks_of_three_px_and_no_further_than_to_an_eighth() {
    let divisors = [0.0, 2.9, 3.1, 10.6, 21.4, 60.0].map(short_divisor);
    assert_eq!(divisors, [1, 1, 2, 4, 8, 8]);
}

#[test]
fn an_image_that_gave_an_attitude_is_followed_by_one_of_its_exposure_and_one_that_did_not_by_the_whole() {
    let short = Next { scan_divisor: 4, ..Next::default() };
    let mut turning = Turning { next: short, ..Turning::default() };
    turning.keep_exposure();
    assert_eq!((turning.divisor(), turning.seeks_streaks()), (4, false));
    for stars in [0, FEWEST_STARS] {
        assert!(short.after_scan(false, stars).scan_divisor <= 1);
    }
    turning.forget();
    assert!(turning.divisor() <= 1);
}

/// After an image that told 0.03 rad/s about y.
fn told(at: LocalTime) -> Turning {
    let report = RateReport {
        rad_s: [0.0, 0.03, 0.0],
        sigma_rad_s: [1e-4; 3],
        source: RateSource::Both,
        either_sense: false,
        stars: 5,
    };
    Turning { told: Some((report, at)), taken: at, ..Turning::default() }
}

#[test]
fn a_rate_that_was_told_serves_an_attitude_for_four_seconds_its_sigma_growing() {
    let at = |seconds: i64| LocalTime::from_us(seconds * 1_000_000);
    assert!(Turning::default().rate_at(at(10)).is_none());
    let mut turning = told(at(10));
    for (second, sigma) in [(10, 1e-4), (11, 2.06e-4), (13, 5.49e-4)] {
        let rate = turning.rate_at(at(second)).unwrap();
        assert_eq!(rate.rad_s.y, 0.03);
        assert!((rate.sigma_rad_s.x - sigma).abs() < 0.01 * sigma, "{second} s: {}", rate.sigma_rad_s.x);
    }
    assert!(turning.rate_at(at(15)).is_none());
    turning.keep_exposure();
    assert!(turning.rate_at(at(11)).is_none());
}

#[test]
fn while_its_search_goes_on_an_image_tells_its_rate_as_far_as_a_slew_leaves_it_known() {
    let at = |seconds: i64| LocalTime::from_us(seconds * 1_000_000);
    let report = told(at(10)).told_at(at(12), &Vector3::new(1e-3, 2e-3, 0.0)).unwrap();
    assert_eq!((report.rad_s, report.source, report.stars), ([0.0, 0.03, 0.0], RateSource::Both, 5));
    for (sigma, expected) in report.sigma_rad_s.into_iter().zip([2.0025e-3, 4.0012e-3, 1e-4]) {
        assert!((sigma - expected).abs() < 1e-6, "{sigma}");
    }
    // One that may have changed by two fifths of itself says too little.
    assert!(says_enough(&report));
    assert!(!says_enough(&told(at(10)).told_at(at(12), &Vector3::repeat(4e-3)).unwrap()));
    // An image whose streaks gave none has none.
    assert!(Turning { taken: at(11), ..told(at(10)) }.rate_under_search(at(12)).is_none());
}
