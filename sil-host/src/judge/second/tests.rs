use super::*;

/// A report whose ICRS covariance is this; its position is off by `error`.
fn report(error: Vector, covariance: [Vector; 3]) -> OrbitReport {
    let sigma = [0, 1, 2].map(|axis| libm::sqrt(covariance[axis][axis]));
    let correlation =
        |row: usize, column: usize| (covariance[row][column] / (sigma[row] * sigma[column])) as f32;
    let mut correlations = [0.0; fsw_core::telemetry::MOTION_CORRELATIONS];
    correlations[..3].copy_from_slice(&[correlation(1, 0), correlation(2, 0), correlation(2, 1)]);
    OrbitReport {
        position_km: [7000.0 + error[0], error[1], error[2]],
        velocity_km_s: [0.0, 7.5, 0.0],
        sigma_position_km: sigma.map(|sigma| sigma as f32),
        sigma_velocity_km_s: [1e-3; 3],
        correlations,
        sigma_hill_km: [0.0; 3],
        elements: None,
        limb_height_km: 0.0,
        limb_height_sigma_km: 1.0,
        misalignment_rad: [0.0; 3],
        misalignment_sigma_rad: [0.0; 3],
        nis: None,
        nis_freedom: 0,
        since_fix_s: 0,
        settled: true,
    }
}

fn position_error(report: &OrbitReport, position_km: Vector, velocity_km_s: Vector) -> Correlated {
    let axes = orbit_axes(position_km, velocity_km_s).unwrap();
    let covariance = motion_covariance(report);
    let block = [0, 1, 2].map(|row| [0, 1, 2].map(|column| covariance[row][column]));
    turned(&axes, minus(report.position_km, position_km), block)
}

#[test]
fn a_covariance_known_by_hand_gives_its_sigmas_correlations_and_nees() {
    // On the x axis and flying along y: radial, along, cross are x, y, z.
    // [[4, 3], [3, 9]]⁻¹ = [[9, -3], [-3, 4]] / 27.
    let covariance = [[4.0, 3.0, 0.0], [3.0, 9.0, 0.0], [0.0, 0.0, 1.0]];
    let found = position_error(&report([2.0, -3.0, 0.5], covariance), [7000.0, 0.0, 0.0], [0.0, 7.5, 0.0]);
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    (0..3).for_each(|axis| close(found.axes.sigma[axis], [2.0, 3.0, 1.0][axis]));
    close(found.correlation[0], 0.5);
    close(found.nees(), (9.0 * 4.0 + 2.0 * 3.0 * 6.0 + 4.0 * 9.0) / 27.0 + 0.25);
    close(found.deviates[0], 1.0);
}

#[test]
fn in_turned_axes_the_sigma_is_that_of_the_axis_and_the_nees_stays() {
    // Flying along z from the y axis: radial is y, along z, cross x.
    let covariance = [[4.0, 3.0, 1.0], [3.0, 9.0, -2.0], [1.0, -2.0, 16.0]];
    let report = report([2.0, -3.0, 0.5], covariance);
    let other = position_error(&report, [7000.0, 0.0, 0.0], [0.0, 7.5, 0.0]);
    let moved = OrbitReport { position_km: [2.0, 7000.0 - 3.0, 0.5], ..report };
    let found = position_error(&moved, [0.0, 7000.0, 0.0], [0.0, 0.0, 7.5]);
    let sigma = [3.0, 4.0, 2.0];
    assert!((0..3).all(|axis| (found.axes.sigma[axis] - sigma[axis]).abs() < 1e-5), "{found:?}");
    assert!((found.nees() - other.nees()).abs() < 1e-4, "{} {}", found.nees(), other.nees());
    assert!((found.correlation[0] + 2.0 / 12.0).abs() < 1e-5);
}

#[test]
fn a_sigma_that_is_none_gives_deviates_that_are_none() {
    let mut report = report([1.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    report.sigma_position_km[1] = f32::NAN;
    let found = position_error(&report, [7000.0, 0.0, 0.0], [0.0, 7.5, 0.0]);
    assert!(!found.nees().is_finite());
}
