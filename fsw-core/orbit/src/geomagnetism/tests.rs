//! Tests of the magnetic field against sums of the published coefficients by another program (numerical
//! gradient of the potential, degree 8 and degree 13).

use super::*;
use crate::ephemeris::pole_axis;

/// Earth-fixed place, km; flux density of degree 8 of 2027.5, and of degree 13, uT.
const SUMS: [([f64; 3], [f32; 3], [f32; 3]); 6] = [
    ([6820.0, 0.0, 0.0], [11.35551, -1.60746, 22.04763], [11.28308, -1.59606, 22.09401]),
    ([0.0, 0.0, 6820.0], [-1.08145, 0.12294, -47.04368], [-1.07773, 0.19799, -47.02193]),
    ([0.0, 1.0, -6900.0], [9.87417, -6.94203, -40.45924], [9.83999, -6.86433, -40.41194]),
    ([-3000.0, 4500.0, 4400.0], [23.85973, -30.97042, -4.12368], [23.86064, -30.97396, -4.18761]),
    ([2500.0, -5200.0, 3900.0], [-18.55255, 28.93277, -1.48741], [-18.57193, 28.89726, -1.46462]),
    ([30_000.0, -25_000.0, 14_000.0], [-0.09756, 0.06738, 0.0576], [-0.09756, 0.06738, 0.0576]),
];

/// From ICRS to axes that turn with the Earth.
fn to_fixed(time_us: i64) -> nalgebra::Matrix3<f32> {
    let (sine, cosine) = sine_cosine(rotation_rad(CentralBody::Earth, time_us));
    let turn = nalgebra::Matrix3::new(cosine, sine, 0.0, -sine, cosine, 0.0, 0.0, 0.0, 1.0);
    turn * equator_axes(&pole_axis(CentralBody::Earth, time_us))
}

#[test]
fn the_field_is_the_published_one() {
    for time_us in [0, 868_000_000_000_000] {
        let to_fixed = to_fixed(time_us);
        for (place_km, to_degree_8, to_degree_13) in SUMS {
            let place_km = to_fixed.map(f64::from).transpose() * Vector3::from(place_km);
            let fixed_ut =
                to_fixed * flux_density_ut(&place_km, &pole_axis(CentralBody::Earth, time_us), time_us);
            assert!((fixed_ut - Vector3::from(to_degree_8)).norm() < 1e-3, "{fixed_ut}");
            assert!((fixed_ut - Vector3::from(to_degree_13)).norm() < 0.12, "{fixed_ut}");
        }
    }
}

#[test]
fn it_has_no_divergence_and_falls_with_the_cube_of_the_distance_far_out() {
    let time_us = 868_000_000_000_000;
    let at =
        |place_km: Vector3<f64>| flux_density_ut(&place_km, &pole_axis(CentralBody::Earth, time_us), time_us);
    for place_km in [[5_000.0, 3_000.0, 4_000.0], [-1_000.0, 200.0, -7_000.0]].map(Vector3::from) {
        let step_km = 20.0;
        let divergence: f32 = (0..3)
            .map(|axis| {
                let mut step = Vector3::zeros();
                step[axis] = step_km;
                (at(place_km + step) - at(place_km - step))[axis] / (2.0 * step_km as f32)
            })
            .sum();
        assert!(divergence.abs() < 3e-6, "{divergence}");
        let [near, far] = [20.0, 40.0].map(|scale| at(place_km * scale).norm());
        assert!((near / far - 8.0).abs() < 0.2, "{near} {far}");
    }
}
