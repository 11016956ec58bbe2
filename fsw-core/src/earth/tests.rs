use super::*;

#[test]
fn default_parameters_lie_in_their_ranges() {
    for (name, value, low, high) in EarthParameters::default().ranges() {
        assert!((low..=high).contains(&value), "{name} = {value}");
    }
}

#[test]
fn sigmas_are_those_across_and_along_the_direction() {
    let fix = EarthFix {
        centre_km: Vector3::new(0.0, 3000.0, 4000.0),
        // 3 km along, 10 km across in x, 5 km across in the plane of y and z.
        covariance_km2: {
            let (along, across) = (Vector3::new(0.0, 0.6, 0.8), Vector3::new(0.0, 0.8, -0.6));
            let x = Vector3::new(1.0, 0.0, 0.0);
            along * along.transpose() * 9.0 + across * across.transpose() * 25.0 + x * x.transpose() * 100.0
        },
        arc_rad: 1.0,
        rms_px: 0.1,
        inliers: 7,
    };
    let (direction_rad, range_km) = fix.sigmas();
    assert!((direction_rad - 10.0 / 5000.0).abs() < 1e-6 && (range_km - 3.0).abs() < 1e-4);
}
