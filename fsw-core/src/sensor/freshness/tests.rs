use super::*;

const QUIET: Noise = Noise { steps: 170, light: 10_000 };

#[test]
fn noise_that_light_explains_is_no_disturbance_and_other_noise_is() {
    let mut freshness = Freshness::default();
    for _ in 0..100 {
        assert!(!freshness.is_disturbed(QUIET));
    }
    // The lit Earth: a hundred counts a pixel, steps of three.
    assert!(!freshness.is_disturbed(Noise { steps: 800, light: 35_000 }));
    // A burst of four counts, on the dark sky; and one that fills the pixels up.
    assert!(freshness.is_disturbed(Noise { steps: 1200, light: 10_100 }));
    assert!(freshness.is_disturbed(Noise { steps: 12_000, light: 13_000 }));
    for left in (0..SUSPECTED).rev() {
        assert!(!freshness.is_disturbed(QUIET));
        assert_eq!(freshness.suspected, left);
    }
}

#[test]
fn noise_that_lasts_becomes_usual_in_minutes_and_falls_at_once() {
    let mut freshness = Freshness::default();
    assert!(!freshness.is_disturbed(QUIET));
    let warm = Noise { steps: 300, light: 10_050 };
    let images = (0..1000).take_while(|_| freshness.is_disturbed(warm)).count();
    std::println!("noise of 1.8 times the usual is usual after {images} images");
    assert!((15..300).contains(&images));
    assert!(!freshness.is_disturbed(QUIET));
    assert!(freshness.is_disturbed(warm));
}

fn solved(angle_rad: f32, second: i64) -> Solved {
    let at_rest = Rotation::from_quaternion([0.0, 0.0, 0.0, 1.0]).unwrap();
    Solved {
        attitude: at_rest.turned(&Vector3::new(angle_rad, 0.0, 0.0)),
        sigma_rad: [1e-5, 1e-5, 5e-5],
        image: LocalTime::from_us(second * SECOND_US),
    }
}

#[test]
fn an_image_whose_stars_have_not_moved_is_old_and_after_a_gap_one_that_is_not_where_it_should_be() {
    let rate = Vector3::new(1e-3, 0.0, 0.0);
    let before = solved(0.0, 100);
    let age = |angle_rad, second| solved(angle_rad, second).age_since(&before, Some(&rate));
    assert!(matches!(age(1e-3, 101), Age::New) && matches!(age(0.0, 101), Age::Old));
    // It slows down.
    assert!(matches!(age(4e-4, 101), Age::New));
    // Half of a gap of ten seconds, and all of it.
    assert!(matches!(age(5e-3, 110), Age::Old) && matches!(age(10.1e-3, 110), Age::New));
    assert!(matches!(age(0.0, 161), Age::New), "believed after a minute");
    let slow = solved(0.0, 101).age_since(&before, Some(&Vector3::new(5e-5, 0.0, 0.0)));
    assert!(matches!(slow, Age::Unknown(way) if way.x == 5e-5));
}

/// The second attitude of all, in a burst of noise: of the first one's image, or of one that has not moved.
#[test]
fn without_a_rate_an_image_whose_stars_have_not_moved_is_old_for_a_minute() {
    let before = solved(0.0, 100);
    for (angle_rad, second, is_old) in
        [(0.0, 101, true), (1e-3, 101, false), (0.0, 130, true), (0.0, 161, false)]
    {
        let age = solved(angle_rad, second).age_since(&before, None);
        assert_eq!(matches!(age, Age::Old), is_old, "{angle_rad} {second}");
        assert_eq!(matches!(age, Age::New), !is_old, "{angle_rad} {second}");
    }
}
