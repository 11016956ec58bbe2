use super::*;
use crate::reference::circular;

#[test]
fn axes_point_along_the_flight_against_the_normal_and_down() {
    let orbit = circular(7_000.0, 98.0);
    let matrix = lvlh(&orbit.position_km, &orbit.velocity_km_s).unwrap();
    assert!((matrix * orbit.position_km - Vector3::new(0.0, 0.0, -7_000.0)).norm() < 1e-9);
    let speed = orbit.velocity_km_s.norm();
    assert!((matrix * orbit.velocity_km_s - Vector3::new(speed, 0.0, 0.0)).norm() < 1e-12);
    assert!((matrix.determinant() - 1.0).abs() < 1e-12);
}

#[test]
fn hills_axes_point_outwards_along_and_across() {
    let orbit = circular(7_000.0, 98.0);
    let (r, v) = (orbit.position_km, orbit.velocity_km_s);
    let matrix = hill(&r, &v).unwrap();
    let apart =
        |axis: usize, direction: Vector3<f64>| (matrix.row(axis).transpose() - direction.normalize()).norm();
    assert!(apart(0, r) < 1e-12 && apart(1, v) < 1e-12 && apart(2, r.cross(&v)) < 1e-12);
    assert!(hill(&r, &r).is_none());
}

#[test]
fn without_a_plane_there_are_no_axes() {
    let r = Vector3::new(7_000.0, 0.0, 0.0);
    for v in [Vector3::zeros(), Vector3::new(3.0, 0.0, 0.0), Vector3::new(f64::NAN, 1.0, 0.0)] {
        assert!(lvlh(&r, &v).is_none());
    }
    assert!(lvlh(&Vector3::zeros(), &r).is_none());
}
