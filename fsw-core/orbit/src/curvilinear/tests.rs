use super::*;
use crate::body::EARTH;
use std::vec::Vec;

fn moved(before: &Motion, by: &Motion) -> (Motion, Option<Turn>) {
    let (mut position_km, mut velocity_km_s) = *before;
    let turn = correct_state(EARTH.mu_km3_s2, &mut position_km, &mut velocity_km_s, by);
    ((position_km, velocity_km_s), turn)
}

fn circle() -> Motion {
    let radius: f64 = 6828.0;
    let speed = (EARTH.mu_km3_s2 / radius).sqrt();
    (Vector3::new(radius, 0.0, 0.0), Vector3::new(0.0, 0.6 * speed, 0.8 * speed))
}

#[test]
fn a_correction_along_a_circle_stays_on_it() {
    // Farther by 400 km on a circular orbit: the state after so long a flight.
    let before = circle();
    let (radius, along) = (before.0.norm(), before.1.normalize());
    let angle: f64 = 400.0 / radius;
    let by = (along * 400.0, -before.0.normalize() * (before.1.norm() * angle));
    let (after, turn) = moved(&before, &by);
    let expected = (before.0.normalize() * angle.cos() + along * angle.sin()) * radius;
    let moving = (along * angle.cos() - before.0.normalize() * angle.sin()) * before.1.norm();
    assert!((after.0 - expected).norm() < 1e-4, "{}", (after.0 - expected).norm());
    assert!((after.1 - moving).norm() < 1e-7);
    // The matrix turns the position, and whatever is constant along the orbit stays so: the energy.
    let turn = nalgebra::Matrix6::from_fn(|row, column| turn.unwrap()[row][column]);
    let energy = |at: &Motion| {
        let gradient = at.0 * (EARTH.mu_km3_s2 / at.0.norm().powi(3));
        nalgebra::RowVector6::from_iterator(gradient.iter().chain(at.1.iter()).copied())
    };
    let kept = energy(&after) * turn - energy(&before);
    assert!(kept.iter().all(|element| element.abs() < 1e-6), "{kept}");
}

/// After a revolution a corrected orbit is where the elements' linear law says, however long the
/// correction; a correction along the tangent is not.
#[test]
fn a_correction_means_the_same_orbit_wherever_it_is_made() {
    let before = circle();
    let along = before.1.normalize();
    // 300 km ahead, and the velocity of the same orbit there.
    let by = (along * 300.0, -before.0.normalize() * (before.1.norm() * 300.0 / before.0.norm()));
    let axis_km = |at: &Motion| 1.0 / (2.0 / at.0.norm() - at.1.norm_squared() / EARTH.mu_km3_s2);
    let straight = plus(&before, 1.0, &by);
    assert!((axis_km(&straight) - axis_km(&before)).abs() > 10.0);
    assert!((axis_km(&moved(&before, &by).0) - axis_km(&before)).abs() < 0.01);
}

#[test]
fn the_matrix_is_the_derivative_of_the_move() {
    // Two states 1 m apart are after the same change as far apart as the matrix says.
    let before = circle();
    let by = (before.1.normalize() * 150.0, Vector3::new(-0.17, 0.01, -0.01));
    let (after, turn) = moved(&before, &by);
    let turn = turn.unwrap();
    let shift = (Vector3::new(0.0006, -0.0003, 0.0007), Vector3::new(1e-6, 2e-6, -1e-6));
    let change = change(EARTH.mu_km3_s2, &before, &by, STEP / 0.022).unwrap();
    let other = elements(EARTH.mu_km3_s2, &plus(&before, 1.0, &shift))
        .unwrap()
        .plus(&change)
        .state(EARTH.mu_km3_s2)
        .unwrap();
    let numbers: Vec<f64> = shift.0.iter().chain(shift.1.iter()).copied().collect();
    let by_matrix = turn.map(|row| row.iter().zip(&numbers).map(|(t, x)| t * x).sum::<f64>());
    let apart = (other.0 - after.0, other.1 - after.1);
    for (one, two) in apart.0.iter().chain(apart.1.iter()).zip(&by_matrix) {
        assert!((one - two).abs() < 1e-3 * one.abs().max(1e-7), "{one} {two}");
    }
}

/// 70 km higher at the same speed is another orbit, not another place on this one.
#[test]
fn a_correction_of_the_orbits_shape_is_straight() {
    let before = circle();
    let by = (before.0.normalize() * 70.0, Vector3::zeros());
    assert_eq!(moved(&before, &by), (plus(&before, 1.0, &by), None));
}

#[test]
fn small_corrections_and_those_of_no_orbit_are_straight() {
    let by = (Vector3::new(0.5, -0.3, 0.2), Vector3::new(1e-5, 0.0, 0.0));
    let before = circle();
    assert_eq!(moved(&before, &by), (plus(&before, 1.0, &by), None));
    // At rest there are no elements.
    let (rest, far) = ((before.0, Vector3::zeros()), (Vector3::new(50.0, 0.0, 0.0), Vector3::zeros()));
    assert_eq!(moved(&rest, &far), (plus(&rest, 1.0, &far), None));
    let not_a_number = (Vector3::new(f64::NAN, 0.0, 0.0), Vector3::zeros());
    assert_eq!(moved(&before, &not_a_number).1, None);
}
