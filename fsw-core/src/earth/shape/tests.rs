use super::*;
use crate::earth::test_world::{A_KM, B_KM, direction};
use crate::oracle::Generator;

#[test]
fn sphere_space_makes_the_ellipsoid_a_sphere_and_back() {
    let mut generator = Generator::new(3);
    let mut parameters = EarthParameters::default();
    parameters.limb.height_km = 0.0;
    for _ in 0..200 {
        let pole = generator.unit();
        let body = Body::new(&direction(&pole), Some(&direction(&generator.unit())), &parameters);
        // A point of the ellipsoid in axes along and across the pole.
        let aside = pole.cross(&generator.unit()).normalize();
        let angle: f64 = generator.between(-1.5, 1.5);
        let point = (aside * A_KM * angle.cos() + pole * B_KM * angle.sin()) / A_KM;
        let narrow = point.map(|part| part as f32);
        let in_sphere_space = body.in_sphere_space(&narrow);
        assert!((in_sphere_space.norm() - 1.0).abs() < 5e-7);
        assert!((body.in_space(&in_sphere_space) - narrow).norm() < 5e-7);
        // The normal is the gradient.
        let normal = (aside * angle.cos() / A_KM + pole * angle.sin() / B_KM).normalize();
        let sun = Vector3::new(0.6f32, 0.0, 0.8);
        let lit = Body::new(&direction(&pole), Direction::new(sun).as_ref(), &parameters);
        let expected = normal.dot(&sun.map(f64::from));
        assert!((f64::from(lit.sun_sine(&in_sphere_space).unwrap()) - expected).abs() < 1e-6);
    }
}

#[test]
fn the_axes_across_a_direction_are_right_handed() {
    let mut generator = Generator::new(4);
    for _ in 0..100 {
        let axis = generator.unit().map(|part| part as f32);
        let (first, second) = normal_basis(&axis);
        let volume = first.cross(&second).dot(&axis);
        assert!((volume - 1.0).abs() < 1e-5, "{volume}");
    }
}
