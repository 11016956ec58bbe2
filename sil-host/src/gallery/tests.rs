//! Tests: each figure's content against the thesis where it should agree, and against what must hold.

use super::*;
use std::collections::HashSet;

/// What a figure came to.
fn made(name: &str) -> Made {
    let figure = figures().find(|figure| figure.name == name).expect("a figure of that name");
    (figure.make)(figure).expect("it is made")
}

/// The numbers in ours of a row.
fn numbers(made: &Made, row: &str) -> Vec<f64> {
    let row = made.rows.iter().find(|of| of.what.contains(row)).unwrap_or_else(|| panic!("{row}"));
    let parts = row.ours.split(|c: char| c.is_whitespace() || "(;:,".contains(c));
    parts.filter_map(|part| part.parse().ok()).collect()
}

#[test]
fn every_figure_has_a_name_of_its_own_and_numbers_with_a_place() {
    let names: HashSet<&str> = figures().map(|figure| figure.name).collect();
    assert_eq!(names.len(), figures().count());
    assert!(names.len() >= 25);
    for figure in figures() {
        assert!(!figure.title.is_empty() && figure.place.contains('\u{a7}'), "{}", figure.name);
        for told in figure.thesis {
            assert!(
                told.value.is_finite() && !told.place.is_empty() && !told.what.is_empty(),
                "{}",
                figure.name
            );
        }
    }
}

#[test]
fn the_sun_stands_over_the_earth_as_long_as_in_the_thesis() {
    let made = made("fig-8.5");
    // 4215 s.
    let over = numbers(&made, "over the Earth (4)");
    assert!((over[0] / 4215.0 - 1.0).abs() < 0.015, "{over:?}");
    let beside = numbers(&made, "in the star path (3), each");
    // With the thesis's field: half of what 17.7 deg are more than the Earth, 33 s, and the Sun's radius, 64 s.
    assert!((beside[1] - 97.0).abs() < 10.0 && beside[0] > 600.0, "{beside:?}");
}

#[test]
fn the_methods_lie_where_the_thesis_has_them_with_one_to_two_sixteenths_of_a_pixel() {
    let made = made("tab-3.9");
    let pitch = numbers(&made, "optimal methods, pitch/yaw");
    // Over all noise, 1/16 px, 2/16 px; "1/16" itself is no number.
    assert!(pitch[1] < 3.2243 && pitch[2] > 3.2243, "{pitch:?}");
}

#[test]
fn the_covariance_is_that_of_the_errors_along_any_axes() {
    let made = made("eq-3.28");
    // Of 411 directions the scatter is known to 2.5 %.
    for stars in ["3 stars", "5 stars", "10 stars"] {
        let both = numbers(&made, stars);
        assert!((both[0] / both[1] - 1.0).abs() < 0.08, "{stars}: {both:?}");
    }
    // A mean of 3 x 4110 squares that go together by fields: within a tenth of one.
    assert!((numbers(&made, "squared")[0] - 1.0).abs() < 0.1);
}

#[test]
fn a_point_solution_hardly_depends_on_the_attitude() {
    let made = made("fig-6.2");
    let change = numbers(&made, "all axes together");
    assert!(change.iter().all(|change| *change < 1e-6), "{change:?}");
    // 0.1 deg of the distance.
    assert!((numbers(&made, "point solution")[0] - 73.6).abs() < 0.6);
}

#[test]
fn flight_code_and_world_are_perturbed_alike() {
    let made = made("fig-A.7");
    for (force, tolerance) in [("J2", 0.02), ("field beyond J2", 0.03), ("Sun and Moon", 0.07), ("drag", 0.3)]
    {
        let row = numbers(&made, force);
        // Flown low, GEO; world low, GEO: printed with two digits.
        for (flown, world) in row[..2].iter().zip(&row[2..]) {
            assert!((flown - world).abs() <= tolerance * world, "{force}: {row:?}");
        }
    }
}

#[test]
fn the_horizon_is_curved_as_the_thesis_says() {
    let view = horizon::horizon(300.0).unwrap();
    let [height_px, _] = horizon::sagitta_px(&view.in_field());
    // 25 px over 24 deg are 16 over the shorter side of 19.4 deg.
    assert!((height_px / 16.0 - 1.0).abs() < 0.25, "{height_px}");
}

#[test]
fn a_low_horizon_is_as_wrong_as_it_says_and_with_its_height_known_far_less() {
    let made = made("fig-7.13");
    let first = |row: &str| numbers(&made, row)[0];
    let (error, sigma) = (first("Earth's centre of a single picture"), first("stated sigma"));
    // Medians of 20 seeds of eight pictures: known to a fifth.
    assert!((0.7..1.4).contains(&(error / sigma)), "{error} deg, sigma {sigma}");
    assert!(first("best of any unbiased method") < error && first("height known") < 0.2 * error);
    let flown = numbers(&made, "flown: direction");
    assert!(matches!(flown[..], [.., 140.0..=160.0, 160.0]), "{flown:?}");
}

#[test]
fn a_curve_that_runs_back_has_more_than_one_true_place() {
    let straight: Vec<[f64; 2]> = (0..=20).map(|step| [f64::from(step), 0.0]).collect();
    assert_eq!(centroids::most_places(&straight), 1);
    let back: Vec<[f64; 2]> = straight.iter().map(|[at, _]| [*at, 6.0 * (0.6 * at).sin()]).collect();
    assert!(centroids::most_places(&back) >= 3);
}

#[test]
fn numbers_are_written_with_the_digits_that_count() {
    let words = [0.051_63, 12.345, 1234.5, 0.0].map(|value| digits(value, 3));
    assert_eq!(words, ["0.0516", "12.3", "1234", "0"]);
}

#[test]
fn a_section_has_the_picture_the_table_and_the_command() {
    let figure = figures().find(|figure| figure.name == "fig-8.9").unwrap();
    let mut text = String::new();
    page::section(&mut text, figure, &(figure.make)(figure).unwrap());
    for words in [
        "## fig-8.9: ",
        "![outages in GTO",
        "(fig-8.9.svg)",
        "| ours | thesis |",
        "| 211 s |",
        "gallery fig-8.9`",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}
