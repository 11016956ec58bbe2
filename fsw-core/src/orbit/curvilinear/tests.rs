use super::*;

fn moved(
    position_km: &Vector3<f64>,
    velocity_km_s: &Vector3<f64>,
    by_km: &Vector3<f64>,
    by_km_s: &Vector3<f64>,
) -> (Vector3<f64>, Vector3<f64>, Option<Matrix3<f64>>) {
    let (mut position_km, mut velocity_km_s) = (*position_km, *velocity_km_s);
    let turn = correct_state(&mut position_km, &mut velocity_km_s, by_km, by_km_s);
    (position_km, velocity_km_s, turn)
}

fn close(one: &Vector3<f64>, other: &Vector3<f64>, tolerance: f64) -> bool {
    (one - other).iter().all(|axis| axis.abs() < tolerance)
}

#[test]
fn a_correction_along_a_circle_stays_on_it() {
    // Farther by 400 km on a circular orbit: the state after so long a flight.
    let (radius, speed) = (6828.0, 7.64);
    let (position, velocity) = (Vector3::new(radius, 0.0, 0.0), Vector3::new(0.0, speed, 0.0));
    let angle: f64 = 400.0 / radius;
    let by_km = Vector3::new(0.0, 400.0, 0.0);
    let by_km_s = Vector3::new(-speed * angle, 0.0, 0.0);
    let (moved_to, moving, turn) = moved(&position, &velocity, &by_km, &by_km_s);
    let expected = Vector3::new(angle.cos(), angle.sin(), 0.0) * radius;
    assert!(close(&moved_to, &expected, 1e-6));
    assert!(close(&moving, &(Vector3::new(-angle.sin(), angle.cos(), 0.0) * speed), 1e-9));
    let turn = turn.unwrap();
    assert!((turn * turn.transpose() - Matrix3::identity()).iter().all(|x| x.abs() < 1e-12));
}

#[test]
fn small_corrections_are_straight() {
    let position = Vector3::new(0.0, 42_164.0, 0.0);
    let by = Vector3::new(0.5, -0.3, 0.2);
    let (moved_to, moving, turn) = moved(&position, &Vector3::zeros(), &by, &by);
    assert_eq!((moved_to, moving, turn), (position + by, by, None));
}
