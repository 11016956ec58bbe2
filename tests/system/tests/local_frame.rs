//! Kepler's elements, Hill's sigmas and the attitude against the local vertical, as flown: beside what the
//! truth's position, velocity and attitude say, computed apart.

use crate::flights::{self, scenario};
use sil_host::judge::attitude_error;
use sil_host::world::attitude::{Vector, apply, dot, matrix, quaternion};
use sil_host::world::vector::{angle, cross, length, product, times, transposed, unit};

/// The orbit of this scenario is known after a quarter of an hour.
const SCENARIO: &str = "sso-noon-midnight";
const SECONDS: u32 = 1500;

/// ICRS to LVLH: along the flight, against the normal, down.
fn lvlh(position: Vector, velocity: Vector) -> [Vector; 3] {
    let down = unit(times(-1.0, position));
    let right = unit(cross(velocity, position));
    [cross(right, down), right, down]
}

#[test]
fn elements_and_the_attitude_against_the_vertical_are_those_of_the_truth_within_their_sigmas() {
    let scenario = scenario(SCENARIO, SECONDS);
    let mut seconds = 0;
    flights::fly(&scenario, |second| {
        let (Some(orbit), Some(local)) = (&second.report.orbit, &second.report.local) else { return };
        seconds += 1;
        let truth = second.truth;
        let axes = lvlh(truth.position_km, truth.velocity_km_s);
        // How far a wrong orbit turns the axes.
        let turned = |sigma: [f32; 3], of: f64| 5.0 * sigma.map(f64::from).iter().sum::<f64>() / of;
        let tolerance_rad = turned(orbit.sigma_position_km, length(truth.position_km))
            + turned(orbit.sigma_velocity_km_s, 7.45)
            + 1e-3;
        let to_path = product(&matrix(truth.quaternion), &transposed(&axes));
        let off_rad = length(attitude_error(local.quaternion, quaternion(&to_path)));
        assert!(off_rad < tolerance_rad, "second {}", second.cycle);
        // The mount as the flight is told it is a tenth of a degree off.
        let mount_rad = 5e-3;
        let nadir_rad = angle(truth.earth_path[2], axes[2]);
        assert!((f64::from(local.nadir_rad) - nadir_rad).abs() < tolerance_rad + mount_rad);
        let across = apply(&axes, truth.earth_path[0]);
        let yaw_rad = f64::from(local.yaw_rad) - across[1].atan2(across[0]);
        let level = across[0].hypot(across[1]);
        assert!(yaw_rad.sin().abs() * level < tolerance_rad + mount_rad && yaw_rad.cos() > 0.0);
        // Hill's sigmas: the reported covariance along the axes of the reported state.
        let sigma_km = orbit.sigma_position_km.map(f64::from);
        let [xy, xz, yz] = [0, 1, 2].map(|k| f64::from(orbit.correlations[k]));
        let correlation = [[1.0, xy, xz], [xy, 1.0, yz], [xz, yz, 1.0]];
        let outwards = unit(orbit.position_km);
        let normal = unit(cross(orbit.position_km, orbit.velocity_km_s));
        for (axis, reported) in
            [outwards, cross(normal, outwards), normal].into_iter().zip(orbit.sigma_hill_km)
        {
            let weighted = [0, 1, 2].map(|k| axis[k] * sigma_km[k]);
            let sigma_km = dot(weighted, apply(&correlation, weighted)).sqrt();
            assert!((f64::from(reported) / sigma_km - 1.0).abs() < 1e-2, "{reported} {sigma_km}");
        }
        // Elements: by conservation, from the reported state.
        let of = orbit.elements.unwrap();
        let (r, v) = (orbit.position_km, orbit.velocity_km_s);
        let mu = 398_600.441_8;
        let momentum = cross(r, v);
        let energy = 0.5 * dot(v, v) - mu / length(r);
        assert!((of.semi_major_axis_km / (-0.5 * mu / energy) - 1.0).abs() < 1e-9);
        assert!((f64::from(of.inclination_rad) - (momentum[2] / length(momentum)).acos()).abs() < 1e-6);
        let parameter_km = dot(momentum, momentum) / mu;
        let e = f64::from(of.eccentricity);
        assert!((of.semi_major_axis_km * (1.0 - e * e) / parameter_km - 1.0).abs() < 1e-6);
        let radius_km = parameter_km / (1.0 + e * f64::from(of.anomaly_rad).cos());
        assert!((radius_km / length(r) - 1.0).abs() < 1e-6);
        let latitude = f64::from(of.inclination_rad).sin() * f64::from(of.perigee_rad + of.anomaly_rad).sin();
        assert!((latitude - r[2] / length(r)).abs() < 1e-5);
    });
    println!("{seconds} of {SECONDS} s with an orbit");
    assert!(seconds > 200);
}
