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
fn a_correction_by_the_bent_difference_arrives() {
    let first = Vector3::new(7000.0, -120.0, 800.0);
    let velocity = Vector3::new(0.1, 7.4, 0.3);
    for other in [
        Vector3::new(6900.0, 900.0, 700.0),
        Vector3::new(7000.001, -120.002, 800.003),
        Vector3::new(4000.0, 6000.0, -900.0),
    ] {
        let bent = CurvilinearDifference::between(&first, &other).unwrap();
        let (position, _, _) = moved(&first, &velocity, &bent.difference_km, &Vector3::zeros());
        assert!(close(&position, &other, 1e-6), "{position} {other}");
        let direction = bent.rotation * first * bent.scale;
        assert!(close(&direction, &other, 1e-7));
    }
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

#[test]
fn what_cannot_be_compared_is_refused() {
    let position = Vector3::new(7000.0, 0.0, 0.0);
    for other in [Vector3::zeros(), Vector3::new(f64::NAN, 1.0, 0.0), Vector3::new(-7000.0, 0.0, 0.0)] {
        assert!(CurvilinearDifference::between(&position, &other).is_none());
        assert!(CurvilinearDifference::between(&other, &position).is_none());
    }
}
