use super::*;
use crate::earth::test_world::{GEO_KM, World, camera, geostationary, low, narrow, parameters};
use crate::oracle::{self, Generator, wide, wide_matrix};
use nalgebra::Vector3;

/// What a fix in tracking demands.
const CRITERIA: FitCriteria = FitCriteria { tolerance_px: 2.0, min_inliers: 6, standalone: true };

/// Half of the range in which the mean of `runs` normalised squares of three unknowns lies, 3.3 sigmas (99.9
/// %).
fn band(runs: usize) -> f64 {
    3.3 * (6.0 / runs as f64).sqrt()
}

/// Points of the true limb between two azimuths, moved across it by Gaussian noise.
fn points(
    world: &World,
    arc: [f64; 2],
    count: usize,
    noise_px: f64,
    generator: &mut Generator,
) -> Vec<LimbPoint, 128> {
    let height = f64::from(parameters().limb.height_km);
    let camera = oracle::reference_camera();
    (0..count)
        .map(|index| {
            let azimuth = arc[0] + (arc[1] - arc[0]) * (index as f64 + 0.5) / count as f64;
            let at = |azimuth| oracle::project(&camera, &world.limb(azimuth, height));
            let ([x, y], [x0, y0], [x1, y1]) = (at(azimuth), at(azimuth - 1e-3), at(azimuth + 1e-3));
            let length = (x1 - x0).hypot(y1 - y0);
            let mut normal = [(y1 - y0) / length, (x0 - x1) / length];
            let [ox, oy] = oracle::project(&camera, &world.limb(azimuth, height + 50.0));
            if (ox - x) * normal[0] + (oy - y) * normal[1] < 0.0 {
                normal = normal.map(|part| -part);
            }
            let noise = noise_px * generator.gaussian();
            LimbPoint::new(
                [(x + noise * normal[0]) as f32, (y + noise * normal[1]) as f32],
                noise_px.max(1e-3) as f32,
                normal.map(|part| part as f32),
            )
        })
        .collect()
}

fn solve(world: &World, points: &[LimbPoint], tolerance_px: f32) -> Result<EarthFix, FitError> {
    let mut parameters = parameters();
    (parameters.fit.least_arc_deg, parameters.plausible.range_share) = (5.0, 1.0);
    centre(
        points,
        &camera(),
        &world.body(&parameters),
        &FitCriteria { tolerance_px, min_inliers: 6, standalone: true },
        None,
        &parameters,
        &mut RayBuffer::new(),
    )
}

/// Mean normalised square, direction rms, mean and rms of the distance's error, share of refusals.
fn monte_carlo(
    world: &World,
    arc_deg: [f64; 2],
    count: usize,
    noise_px: f64,
    runs: usize,
) -> (f64, f64, f64, f64, f64) {
    let mut generator = Generator::new(42);
    let arc = arc_deg.map(f64::to_radians);
    let clean = points(world, arc, count, 0.0, &mut generator);
    let (mut nees, mut angle, mut mean, mut square, mut refused) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for _ in 0..runs {
        let mut noisy = clean.clone();
        for point in &mut noisy {
            let noise = (noise_px * generator.gaussian()) as f32;
            point.sigma_px = noise_px as f32;
            point.centre_px[0] += noise * point.outward_px[0];
            point.centre_px[1] += noise * point.outward_px[1];
        }
        let Ok(fix) = solve(world, &noisy, 5.0 * noise_px.max(0.2) as f32) else {
            refused += 1.0;
            continue;
        };
        let error = wide(&fix.centre_km) - world.centre;
        nees += error.dot(&(wide_matrix(&fix.covariance_km2).try_inverse().unwrap() * error));
        let range = wide(&fix.centre_km).norm() - world.centre.norm();
        angle += wide(&fix.centre_km).normalize().cross(&world.centre.normalize()).norm_squared();
        mean += range;
        square += range * range;
    }
    let solved = runs as f64 - refused;
    (nees / solved, (angle / solved).sqrt(), mean / solved, (square / solved).sqrt(), refused / runs as f64)
}

#[test]
fn a_fix_is_as_good_as_its_covariance_for_every_arc_from_the_geostationary_orbit() {
    // Direction for 200 points of 100 urad in arcsec where the algorithms' page gives it.
    let runs = 400;
    for (arc, goal) in [(360.0, 3.0), (180.0, 5.0), (90.0, 17.0), (40.0, 80.0), (20.0, f64::INFINITY)] {
        let world = geostationary(0.0, 1);
        let (nees, angle, mean, rms, refused) = monte_carlo(&world, [25.0, 25.0 + arc], 100, 0.3, runs);
        let arcsec = angle * oracle::ARCSEC / 2f64.sqrt();
        std::println!(
            "arc {arc} deg: NEES {nees:.2}, direction {arcsec:.1} arcsec (as of 200 points), \
             distance mean {mean:.1}, rms {rms:.1} km, refused {refused:.3}"
        );
        assert!((nees - 3.0).abs() < band(runs) + 0.2, "arc {arc}: {nees}");
        assert!(arcsec < 1.5 * goal, "arc {arc}: {arcsec}");
        assert!(
            mean.abs() < 4.0 * rms / (runs as f64).sqrt() + 1e-3 * GEO_KM,
            "arc {arc}: {mean} of {rms} km"
        );
        assert!(refused < 0.02, "arc {arc}: {refused}");
    }
}

#[test]
fn a_fix_is_as_good_as_its_covariance_from_low_orbits() {
    let runs = 400;
    for (altitude, arc) in [(450.0, 20.0), (450.0, 30.0), (800.0, 25.0)] {
        let world = low(altitude, 70.0, [40.0, 30.0], 1);
        // Azimuth of the line of sight about the centre.
        let axis = world.centre.normalize();
        let first = (Vector3::x() - axis * axis.x).normalize();
        let second = axis.cross(&first);
        let middle = second.z.atan2(first.z).to_degrees();
        for noise in [0.1, 0.5] {
            let (nees, angle, mean, rms, refused) =
                monte_carlo(&world, [middle - arc / 2.0, middle + arc / 2.0], 24, noise, runs);
            std::println!(
                "{altitude} km, arc {arc} deg, {noise} px: NEES {nees:.2}, direction {:.4} deg, \
                 distance mean {mean:.2}, rms {rms:.2} km, refused {refused:.3}",
                angle.to_degrees()
            );
            assert!((nees - 3.0).abs() < band(runs) + 0.3, "{altitude} km: {nees}");
            assert!(mean.abs() < 4.0 * rms / (runs as f64).sqrt() + 0.5, "{altitude} km: {mean} of {rms}");
            assert!(refused < 0.02);
        }
    }
}

#[test]
fn without_noise_the_centre_is_exact_to_rounding() {
    let mut generator = Generator::new(9);
    for (world, arc, limit) in [
        (geostationary(0.0, 1), [0.0, 360.0], 1.0),
        (geostationary(0.0, 1), [10.0, 100.0], 4.0),
        (low(500.0, 90.0, [40.0, 30.0], 1), [-12.0, 12.0], 0.05),
    ] {
        let axis = world.centre.normalize();
        let first = (Vector3::x() - axis * axis.x).normalize();
        let middle = if arc[0] < 0.0 { axis.cross(&first).z.atan2(first.z).to_degrees() } else { 0.0 };
        let arc = arc.map(|end| (end + middle).to_radians());
        let found = solve(&world, &points(&world, arc, 60, 0.0, &mut generator), 1.0).unwrap();
        let error = (wide(&found.centre_km) - world.centre).norm();
        std::println!("error without noise {error:.3} km, rms {:.5} px", found.rms_px);
        assert!(error < limit, "{error} km");
        assert!((f64::from(found.arc_rad) / (arc[1] - arc[0]) - 1.0).abs() < 0.06);
    }
}

#[test]
fn a_third_of_wrong_points_is_left_out() {
    let mut generator = Generator::new(5);
    let world = geostationary(0.0, 1);
    let mut list = points(&world, [0.0, 4.0], 60, 0.1, &mut generator);
    for (index, point) in list.iter_mut().enumerate() {
        if index % 3 == 0 {
            point.centre_px[0] += generator.between(-200.0, 200.0) as f32;
            point.centre_px[1] += generator.between(30.0, 90.0) as f32;
        }
    }
    let fix = solve(&world, &list, 2.0).unwrap();
    for index in 0..60 {
        let is_inlier = fix.inliers >> index & 1 == 1;
        assert!(!is_inlier || index % 3 != 0, "wrong point {index} taken in");
    }
    assert!(fix.inliers.count_ones() >= 38);
    assert!((wide(&fix.centre_km) - world.centre).norm() < 60.0);
}

#[test]
fn points_that_fix_no_centre_are_refused() {
    let mut generator = Generator::new(6);
    let world = geostationary(0.0, 1);
    let list = points(&world, [0.0, 6.0], 60, 0.1, &mut generator);
    assert_eq!(solve(&world, &list[..5], 2.0), Err(FitError::TooFewPoints));
    // The bright side outward: a hole in a bright field.
    let mut hole = list.clone();
    hole.iter_mut().for_each(|point| point.outward_px = point.outward_px.map(|part| -part));
    assert!(matches!(solve(&world, &hole, 2.0), Err(FitError::NoConsensus | FitError::Degenerate)));
    let mut one_place = list.clone();
    one_place.iter_mut().for_each(|point| *point = list[0]);
    assert!(solve(&world, &one_place, 2.0).is_err());
    let mut nowhere = list.clone();
    nowhere.iter_mut().for_each(|point| point.centre_px[0] = f32::NAN);
    assert_eq!(solve(&world, &nowhere, 2.0), Err(FitError::TooFewPoints));
    let short = points(&world, [1.0, 1.05], 60, 0.02, &mut generator);
    assert!(matches!(
        solve(&world, &short, 2.0),
        Err(FitError::ShortArc | FitError::Degenerate | FitError::Uncertain)
    ));
    let scattered: std::vec::Vec<LimbPoint> = (0..60)
        .map(|_| {
            LimbPoint::new(
                [generator.between(0.0, 1279.0) as f32, generator.between(0.0, 1023.0) as f32],
                0.3,
                [1.0, 0.0],
            )
        })
        .collect();
    assert!(solve(&world, &scattered, 2.0).is_err());
    // Beyond any orbit of the Earth a round cloud in the night side would do as well.
    let mut at_times = |farther: f64| {
        let far = World { centre: world.centre * farther, ..world.clone() };
        solve(&far, &points(&far, [0.0, 6.0], 60, 0.1, &mut generator), 2.0)
    };
    assert!(at_times(2.0).is_ok());
    assert_eq!(at_times(3.0), Err(FitError::Degenerate));
    assert!(narrow(&world.centre).z > 0.0);
}

proptest::proptest! {
    #[test]
    fn whatever_the_points_a_fix_is_finite(
        raw in proptest::collection::vec((-2000f32..3000.0, -2000f32..3000.0, 0.01f32..5.0, 0f32..6.3), 0..140)
    ) {
        let list: std::vec::Vec<LimbPoint> = raw
            .iter()
            .map(|(x, y, sigma_px, angle)| LimbPoint::new([*x, *y], *sigma_px, [angle.cos(), angle.sin()]))
            .collect();
        let world = geostationary(30.0, 1);
        let mut parameters = parameters();
        (parameters.fit.fewest_points, parameters.fit.least_arc_deg) = (3, 0.0);
        (parameters.plausible.sigma_deg, parameters.plausible.range_share) = (1e9, 1e9);
        let body = world.body(&parameters);
        if let Ok(fix) = centre(&list, &camera(), &body, &FitCriteria { tolerance_px: 200.0, min_inliers: 3, standalone: true }, None, &parameters, &mut RayBuffer::new()) {
            proptest::prop_assert!(fix.centre_km.iter().chain(fix.covariance_km2.iter()).all(|value| value.is_finite()));
            proptest::prop_assert!(fix.rms_px.is_finite() && fix.arc_rad.is_finite());
        }
    }
}

/// The limb from 450 km, 22 deg of arc seen in 24 points, without noise but as if of 0.3 px.
struct ShortArc {
    world: World,
    clean: Vec<LimbPoint, 128>,
    parameters: EarthParameters,
    /// Variances of the centre, km², and their directions, where it truly is.
    variances: Vector3<f64>,
    directions: nalgebra::Matrix3<f64>,
}

impl ShortArc {
    const NOISE_PX: f32 = 0.3;

    fn new(generator: &mut Generator) -> Self {
        let world = low(450.0, 90.0, [40.0, 30.0], 1);
        let axis = world.centre.normalize();
        let first = (Vector3::x() - axis * axis.x).normalize();
        let middle = axis.cross(&first).z.atan2(first.z);
        let arc = [-11f64, 11.0].map(|end| end.to_radians() + middle);
        let mut clean = points(&world, arc, 24, 0.0, generator);
        clean.iter_mut().for_each(|point| point.sigma_px = Self::NOISE_PX);
        let mut parameters = parameters();
        parameters.fit.least_arc_deg = 5.0;
        (parameters.plausible.sigma_deg, parameters.plausible.range_share) = (1e3, 1e3);
        let (variances, directions) = (Vector3::zeros(), nalgebra::Matrix3::zeros());
        let mut arc = Self { world, clean, parameters, variances, directions };
        let eigen = wide_matrix(&arc.fit(&arc.clean, None).covariance_km2).symmetric_eigen();
        (arc.variances, arc.directions) = (eigen.eigenvalues, eigen.eigenvectors);
        arc
    }

    fn noisy(&self, generator: &mut Generator) -> Vec<LimbPoint, 128> {
        let mut noisy = self.clean.clone();
        for point in &mut noisy {
            let noise = Self::NOISE_PX * generator.gaussian() as f32;
            point.centre_px[0] += noise * point.outward_px[0];
            point.centre_px[1] += noise * point.outward_px[1];
        }
        noisy
    }

    fn fit(&self, list: &[LimbPoint], expected: Option<&CentrePrior>) -> EarthFix {
        let body = self.world.body(&self.parameters);
        centre(list, &camera(), &body, &CRITERIA, expected, &self.parameters, &mut RayBuffer::new()).unwrap()
    }

    /// An expectation this far from the true centre, known to `sigma_km` along every axis.
    fn expected(&self, off_km: &Vector3<f64>, sigma_km: f64) -> CentrePrior {
        CentrePrior {
            centre_km: narrow(&(self.world.centre + off_km)),
            information: nalgebra::Matrix3::identity() * (sigma_km * sigma_km).recip() as f32,
        }
    }
}

#[test]
fn about_an_expected_centre_a_short_arc_scatters_in_every_direction_as_its_covariance_says() {
    let mut generator = Generator::new(22);
    let arc = ShortArc::new(&mut generator);
    // Known to 50 m in the best direction, to 27 km in the worst.
    assert!(arc.variances.max().sqrt() > 20.0 && arc.variances.min().sqrt() < 0.1);
    let runs = 400;
    for prior_km in [1.0, 3.0, 10.0] {
        let mut squares = Vector3::zeros();
        for _ in 0..runs {
            let noisy = arc.noisy(&mut generator);
            let fix =
                arc.fit(&noisy, Some(&arc.expected(&(generator.gaussian_vector() * prior_km), prior_km)));
            let error = arc.directions.transpose() * (wide(&fix.centre_km) - arc.world.centre);
            squares += error.component_mul(&error).component_div(&arc.variances) / f64::from(runs);
        }
        std::println!("expected to {prior_km} km: normalised squares {squares:.2?}");
        // 99.9 % of the mean of so many chi-squares of one degree of freedom.
        let band = 3.3 * (2.0 / f64::from(runs)).sqrt();
        assert!(squares.iter().all(|square| (square - 1.0).abs() < band), "{prior_km} km: {squares}");
    }
}

#[test]
fn a_fix_does_not_lean_towards_the_expected_centre() {
    // The same points about centres that are expected on either side along the arc's worst direction, and
    // known to a kilometre there: the filter would otherwise take its own prediction for news.
    let mut generator = Generator::new(24);
    let arc = ShortArc::new(&mut generator);
    let worst: Vector3<f64> = arc.directions.column(arc.variances.imax()).into();
    let (runs, off_km) = (50, 10.0);
    let mut lean = 0.0;
    for _ in 0..runs {
        let noisy = arc.noisy(&mut generator);
        let along = |side: f64| {
            let fix = arc.fit(&noisy, Some(&arc.expected(&(worst * side), 1.0)));
            let [centre, place] = [fix.centre_km, fix.linearisation_km].map(|at| worst.dot(&wide(&at)));
            (centre, place)
        };
        let ((ahead, place_ahead), (behind, place_behind)) = (along(off_km), along(-off_km));
        assert!(place_ahead - place_behind > 1.9 * off_km, "the place is the expected one");
        lean += (ahead - behind) / (2.0 * off_km * f64::from(runs));
    }
    std::println!("of an expectation {:.3} is in the fix", lean);
    assert!(lean.abs() < 0.03, "{lean}");
}

#[test]
fn an_expectation_far_wrong_does_not_move_the_fix_of_a_long_arc() {
    let mut generator = Generator::new(23);
    let world = geostationary(0.0, 1);
    let parameters = parameters();
    let body = world.body(&parameters);
    for arc_deg in [360.0, 180.0] {
        let list = points(&world, [0.0, f64::to_radians(arc_deg)], 48, 0.3, &mut generator);
        let fit = |expected: Option<&CentrePrior>| {
            centre(&list, &camera(), &body, &CRITERIA, expected, &parameters, &mut RayBuffer::new()).unwrap()
        };
        let alone = fit(None);
        let inverse = wide_matrix(&alone.covariance_km2).try_inverse().unwrap();
        // An orbit that is off by three sigmas of its own.
        for off_km in [100.0, 300.0, 1000.0] {
            let expected = CentrePrior {
                centre_km: narrow(&(world.centre + generator.unit() * off_km)),
                information: nalgebra::Matrix3::identity() * (off_km as f32 / 3.0).powi(-2),
            };
            let fix = fit(Some(&expected));
            let apart = wide(&fix.centre_km) - wide(&alone.centre_km);
            let sigmas = apart.dot(&(inverse * apart)).sqrt();
            std::println!("arc {arc_deg} deg, expected {off_km} km off: moved by {sigmas:.4} sigma");
            assert!(sigmas < 0.1, "arc {arc_deg} deg, {off_km} km: {sigmas} sigma");
        }
    }
}

/// Numbers as they come from a broken computer: mostly of the given size, else anything.
fn number(low: f32, high: f32) -> impl proptest::strategy::Strategy<Value = f32> {
    use proptest::prelude::*;
    prop_oneof![
        6 => low..high,
        1 => any::<f32>(),
        1 => prop::sample::select(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE, 0.0]),
    ]
}

proptest::proptest! {
    #[test]
    fn whatever_the_points_and_the_expectation_a_fix_is_finite(
        start in 0f64..6.0,
        wrong in proptest::collection::vec(
            (0usize..40, number(0.0, 1280.0), number(0.0, 1024.0), number(0.01, 5.0), number(-1.0, 1.0), number(-1.0, 1.0)), 0..12
        ),
        expected_km in proptest::array::uniform3(number(-5e4, 5e4)),
        information in proptest::array::uniform9(number(-1.0, 1.0)),
        diagonal in number(0.0, 10.0),
        tolerance_px in number(0.2, 20.0),
    ) {
        // A true limb, some points of it replaced by anything, so that a fit is reached.
        let world = geostationary(30.0, 1);
        let mut list = points(&world, [start, start + 2.0], 40, 0.3, &mut Generator::new(1));
        for (at, x, y, sigma_px, out_x, out_y) in wrong {
            list[at] = LimbPoint::new([x, y], sigma_px, [out_x, out_y]);
        }
        let information = nalgebra::Matrix3::from_row_slice(&information);
        for information in [information, nalgebra::Matrix3::identity() * diagonal, information * information.transpose()] {
            let expected = CentrePrior { centre_km: Vector3::from(expected_km), information };
            let mut parameters = parameters();
            (parameters.plausible.sigma_deg, parameters.plausible.range_share) = (1e9, 1e9);
            let body = world.body(&parameters);
            if let Ok(fix) =
                centre(&list, &camera(), &body, &FitCriteria { tolerance_px, min_inliers: 6, standalone: true }, Some(&expected), &parameters, &mut RayBuffer::new())
            {
                let vectors = fix.centre_km.iter().chain(&fix.linearisation_km);
                proptest::prop_assert!(vectors.chain(&fix.covariance_km2).all(|value| value.is_finite()), "{fix:?}");
                proptest::prop_assert!(fix.rms_px.is_finite() && fix.arc_rad.is_finite());
                let (direction_rad, range_km) = fix.sigmas();
                proptest::prop_assert!(direction_rad.is_finite() && range_km.is_finite());
            }
        }
    }
}
