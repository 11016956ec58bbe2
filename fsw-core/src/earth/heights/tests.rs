use super::*;
use crate::earth::test_world::World;
use crate::earth::{EarthParameters, LimbPoint};
use crate::oracle::{project, reference_camera};
use nalgebra::Vector3;

#[test]
fn heights_are_those_of_the_true_limb_about_the_predicted_one() {
    let parameters = EarthParameters::default();
    let camera = crate::earth::test_world::camera();
    let level_km = f64::from(parameters.limb.height_km);
    for (centre, off_km) in [
        (Vector3::new(0.0, 0.0, 42_164.0), Vector3::new(4.0, -7.0, 20.0)),
        (Vector3::new(6_456.0, 0.0, 2_223.0), Vector3::new(2.0, 1.0, -3.0)),
    ] {
        let world = World::new(centre, Vector3::new(0.2, 1.0, 0.1), Vector3::new(0.0, 0.0, -1.0), 1);
        let body = world.body(&parameters);
        let predicted = (centre + off_km).map(|axis| axis as f32);
        let limb = PredictedLimb::new(&predicted, &body).unwrap();
        let mut seen = 0;
        for step in 0..400 {
            let azimuth = f64::from(step) * std::f64::consts::TAU / 400.0;
            let at = |height_km: f64| project(&reference_camera(), &world.limb(azimuth, height_km));
            let ([x, y], [x1, y1]) = (at(level_km + 2.0), at(level_km + 12.0));
            let length = (x1 - x).hypot(y1 - y);
            let inside = (0.0..1280.0).contains(&x) && (0.0..1024.0).contains(&y);
            if !inside || !length.is_finite() {
                continue;
            }
            let point = LimbPoint::new(
                [x as f32, y as f32],
                0.3,
                [((x1 - x) / length) as f32, ((y1 - y) / length) as f32],
            );
            let height = limb.height(&Ray::new(&point, 0, &camera, &body).unwrap()).unwrap();
            // Two kilometres above, less what the wrong centre hides: its component along the normal, which is
            // the radial direction tilted by the cone's angle.
            let distance = predicted.norm();
            let (sine, cosine) = (limb.cone.sine, limb.cone.cosine);
            let normal = height.radial * cosine - predicted / distance * sine;
            let expected = 2.0 - normal.dot(&off_km.map(|axis| axis as f32));
            assert!((height.height_km - expected).abs() < 0.15, "{centre} {azimuth}: {height:?} {expected}");
            seen += 1;
        }
        assert!(seen > 20, "{seen}");
    }
}
