use super::*;
use crate::body::{CentralBody, EARTH};
use crate::look::Look;
use crate::reference::circular;

const RADIUS_KM: f32 = 6_378.137;

fn geometry(radius_km: f64) -> LimbGeometry {
    LimbGeometry::of(CentralBody::Earth, &circular(radius_km, 51.6), &Vector3::z(), RADIUS_KM).unwrap()
}

fn at_azimuth(waves_of: &[f32; WAVES], azimuth: f32) -> f32 {
    dot_slices(waves_of, &waves(azimuth.cos(), azimuth.sin()))
}

/// Height of the limb from a moved place about the limb from here: the angle beyond it, by bisection in f64.
fn height_km(radius_km: f64, moved_km: &Vector3<f64>, azimuth: f64) -> f64 {
    let place = moved_km - Vector3::new(0.0, 0.0, radius_km);
    let cone = (EARTH.radius_km / radius_km).asin();
    let passes = |angle: f64| {
        let ray = Vector3::new(angle.sin() * azimuth.cos(), angle.sin() * azimuth.sin(), angle.cos());
        place.cross(&ray).norm() > EARTH.radius_km
    };
    let (mut inside, mut outside) = (cone - 0.4, cone + 0.4);
    for _ in 0..60 {
        let middle = 0.5 * (inside + outside);
        if passes(middle) { outside = middle } else { inside = middle }
    }
    (inside - cone).sin() * radius_km * cone.cos()
}

#[test]
fn the_moved_limb_is_where_its_rays_touch_the_sphere() {
    for (radius_km, size, tolerance_km) in
        [(6_828.0, 60.0, 0.05), (7_176.0, 60.0, 0.05), (42_164.0, 600.0, 0.2)]
    {
        let here = geometry(radius_km);
        for direction in [Vector3::x(), -Vector3::y(), Vector3::z(), Vector3::new(0.6, 0.48, -0.64)] {
            let moved_km = direction * size;
            let limb = here.moved(&moved_km.map(|axis| axis as f32));
            for step in 0..12 {
                let azimuth = f64::from(step) * 0.5;
                let (seen, expected) = (
                    f64::from(at_azimuth(&limb.height_km, azimuth as f32)),
                    height_km(radius_km, &moved_km, azimuth),
                );
                assert!(
                    (seen - expected).abs() < tolerance_km,
                    "{radius_km} {moved_km} {azimuth}: {seen} {expected}"
                );
            }
        }
    }
}

/// After a gap a low orbit is off by hundreds of kilometres, and a limb 1 km from where it is expected reads
/// as 40 km along the track.
#[test]
fn the_moved_limb_is_that_of_the_ellipsoid() {
    let (a, b) = (EARTH.radius_km + 5.0, EARTH.polar_km + 5.0);
    let inverse = Vector3::new(1.0 / (a * a), 1.0 / (a * a), 1.0 / (b * b));
    let at = |latitude_deg: f64| {
        let (sine, cosine) = latitude_deg.to_radians().sin_cos();
        (Vector3::new(cosine, 0.0, sine) * 7_176.0, Vector3::new(-sine, 0.0, cosine) * 7.5)
    };
    for latitude_deg in [0.0, 30.0, 60.0, 85.0] {
        let (position_km, velocity_km_s) = at(latitude_deg);
        let state = OrbitState { time_us: 0, position_km, velocity_km_s };
        let here = LimbGeometry::of(CentralBody::Earth, &state, &Vector3::z(), a as f32).unwrap();
        let axes = here.axes.map(f64::from);
        let truth_km = at(latitude_deg + 7.2).0;
        let moved_km = (truth_km - position_km).map(|axis| axis as f32);
        let limb = here.moved(&(here.moves * moved_km));
        let (sine, cosine) = (f64::from(here.sine), f64::from(here.cosine));
        for azimuth in [-0.25, -0.1, 0.0, 0.1, 0.25f64] {
            // Positive where the line of sight at an angle from nadir hits the ellipsoid.
            let hits = |angle: f64| {
                let ray = Vector3::new(angle.sin() * azimuth.cos(), angle.sin() * azimuth.sin(), angle.cos());
                let ray = axes.transpose() * ray;
                let ray = Vector3::new(ray.x, ray.y, ray.z * b / a);
                let product = |one: &Vector3<f64>, other| one.component_mul(&inverse).dot(other);
                product(&truth_km, &ray).powi(2) - product(&ray, &ray) * (product(&truth_km, &truth_km) - 1.0)
            };
            let cone = sine.asin();
            let (mut inside, mut outside) = (cone - 0.3, cone + 0.3);
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                if hits(middle) > 0.0 { inside = middle } else { outside = middle }
            }
            let expected_km = (inside - cone).sin() * a * cosine / sine;
            let seen_km = f64::from(at_azimuth(&limb.height_km, azimuth as f32));
            assert!((seen_km - expected_km).abs() < 0.3, "{latitude_deg} {azimuth}: {seen_km} {expected_km}");
        }
    }
}

#[test]
fn its_gradient_is_the_derivative_of_its_height() {
    let here = geometry(6_828.0);
    let moved_km = Vector3::new(20.0, -10.0, 5.0);
    let limb = here.moved(&moved_km);
    for axis in 0..3 {
        let mut by = Vector3::zeros();
        by[axis] = 2.0;
        let (more, less) = (here.moved(&(moved_km + by)), here.moved(&(moved_km - by)));
        for azimuth in [0.0, 1.0, 2.5, 4.0] {
            let slope = (at_azimuth(&more.height_km, azimuth) - at_azimuth(&less.height_km, azimuth)) / 4.0;
            assert!((slope - at_azimuth(&limb.gradient[axis], azimuth)).abs() < 3e-3, "{axis} {azimuth}");
        }
    }
}

/// Thesis §5.2.2 has an angle between the paths that a height does not show: a turn about the line to the
/// Earth.
#[test]
fn a_row_is_the_sum_of_its_terms() {
    let here = geometry(7_176.0);
    let pole = Vector3::new(0.3, -0.2, 0.933).normalize();
    let limb = here.moved(&Vector3::zeros());
    let path = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
    for azimuth in [0.1f32, 1.2, 3.0, 5.1] {
        let (sine, cosine) = azimuth.sin_cos();
        let row = here.sensitivity(&waves(cosine, sine), &limb, (&pole, &path), 10.0);
        let radial = here.axes.transpose() * Vector3::new(cosine, sine, 0.0);
        let down = here.axes.transpose() * Vector3::z();
        let normal = radial * here.cosine - down * here.sine;
        let s = normal.dot(&pole);
        let expected = [1.0, here.distance_km, s, 1.0 / 3.0 - s * s];
        for (value, expected) in row[HEIGHT..FIELD].iter().zip(expected) {
            assert!((value - expected).abs() < 1e-4 * expected.abs().max(1.0), "{value} {expected}");
        }
        let ray = radial * here.sine + down * here.cosine;
        let turn = path * ray.cross(&normal) * here.distance_km;
        // The pole's part of a move is longer in sphere space.
        let stretched = normal + Vector3::z() * (normal.z * (6_378.137 / 6_356.752 - 1.0));
        for axis in 0..3 {
            assert!((row[axis] + stretched[axis]).abs() < 1e-4);
            assert!((row[axis + 3] - 10.0 * stretched[axis]).abs() < 1e-3);
            assert!(
                (row[MISALIGNMENT + axis] - turn[axis]).abs() < 0.5,
                "{} {}",
                row[MISALIGNMENT + axis],
                turn[axis]
            );
        }
        assert!((path * down).dot(&turn).abs() < 1e-2);
    }
}

#[test]
fn the_fields_variances_are_those_of_its_sigma() {
    let parameters = OrbitParameters { edge_sigma_km: 0.0, edge_sigma_rad: 0.0, ..Default::default() };
    for radius_km in [6_828.0, 42_164.0] {
        let variations = geometry(radius_km).variations(&parameters);
        let [mean, rest @ ..] = variations.map(|variation| variation.variance_km2);
        // At any azimuth: cos² + sin² of each wave.
        let all = mean + rest.iter().sum::<f32>();
        assert!((all.sqrt() / parameters.field_sigma_km - 1.0).abs() < 1e-5);
        assert!(rest.windows(2).all(|pair| pair[0] >= pair[1]));
    }
    // Static in GEO, minutes in low orbits.
    assert!(geometry(42_164.0).field_lasts_s(&parameters) > 2_000.0);
    assert!((280.0..360.0).contains(&geometry(6_828.0).field_lasts_s(&parameters)));
}

/// Where the limb stays, waves and what is left of the looks' noise hold the edges' errors together, as rows
/// of patches that err independently do: all of it around the limb, and over an arc of it.
#[test]
fn errors_of_edges_that_last_are_in_the_waves_and_not_in_the_noise() {
    let parameters = OrbitParameters { field_sigma_km: 0.0, ..Default::default() };
    let here = LimbGeometry { ground_km_s: 1e-3, ..geometry(42_164.0) };
    let patches = core::f32::consts::TAU * here.circle_km() / here.patch_km(&parameters);
    let sigma_km = here.edge_km2(&parameters).sqrt();
    let variances = of_waves(here.variations(&parameters).map(|variation| variation.variance_km2));
    for (share, least) in [(1.0, 0.96), (0.5, 0.45)] {
        let mut look = Look::new(0, 1.0, RADIUS_KM);
        // Four points a patch, each with the noise of all four.
        let points = (4.0 * share * patches).round();
        for point in 0..points as u32 {
            let azimuth = core::f32::consts::TAU * share * point as f32 / points;
            look.add([azimuth.cos(), azimuth.sin()], 0.0, 2.0 * sigma_km, 0.0);
        }
        let mut in_waves = 0.0;
        for (row, _) in look.rows() {
            let of_row =
                row.iter().zip(variances).map(|(wave, variance)| wave * wave * variance).sum::<f32>();
            let left = here.left_of_edges(row, &parameters);
            // The limb's patches are not quite a whole number of points.
            assert!((of_row + left - 1.0).abs() < 0.03, "{share}: {of_row} and {left}");
            in_waves += of_row / WAVES as f32;
        }
        assert!((least..=1.0).contains(&in_waves), "{share}: {in_waves}");
    }
    // Low orbits leave them behind between two looks.
    let low = geometry(6_828.0);
    assert_eq!(low.left_of_edges(&[1.0; WAVES], &parameters), 1.0);
    assert!(low.variations(&parameters).iter().all(|variation| variation.variance_km2 == 0.0));
}

#[test]
fn there_is_no_limb_inside_the_earth_and_none_without_a_plane() {
    let state = circular(6_378.2, 10.0);
    assert!(LimbGeometry::of(CentralBody::Earth, &state, &Vector3::z(), RADIUS_KM).is_none());
    let falling = OrbitState { velocity_km_s: -circular(7_000.0, 0.0).position_km, ..circular(7_000.0, 0.0) };
    assert!(LimbGeometry::of(CentralBody::Earth, &falling, &Vector3::z(), RADIUS_KM).is_none());
}
