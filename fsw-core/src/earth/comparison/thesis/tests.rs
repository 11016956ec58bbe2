use super::*;
use crate::earth::test_world::{GEO_KM, Picture, camera, direction, geostationary};
use crate::oracle::Generator;
use std::vec::Vec as List;

fn point(centre_px: [f32; 2]) -> LimbPoint {
    LimbPoint::new(centre_px, 1.0, [1.0, 0.0])
}

/// Points of an ellipse with the pole along y, over an arc.
fn ellipse(arc_deg: f64, noise_px: f64, generator: &mut Generator) -> List<LimbPoint> {
    (0..100)
        .map(|k| {
            let angle = (arc_deg * (f64::from(k) / 99.0 - 0.5)).to_radians();
            let radius = 1.0 + noise_px * generator.gaussian() / 300.0;
            let squeezed = (1.0 - f64::from(ECCENTRICITY).powi(2)).sqrt();
            point([
                (400.0 + 300.0 * radius * angle.cos()) as f32,
                (350.0 + 300.0 * radius * angle.sin() * squeezed) as f32,
            ])
        })
        .collect()
}

#[test]
fn an_ellipse_is_fitted_whole_and_by_half() {
    let mut generator = Generator::new(4);
    // Whole: three sigma of sqrt(2 / n) times the noise, per axis. By half the centre along the arc's middle
    // is three times worse.
    for (arc_deg, noise_px, limit_px) in
        [(360.0, 0.0, 0.01), (180.0, 0.0, 0.02), (360.0, 0.3, 0.13), (180.0, 0.3, 0.4)]
    {
        let points = ellipse(arc_deg, noise_px, &mut generator);
        let found = circle(&points, [0.0, -1.0], ECCENTRICITY).unwrap();
        let error = (found.centre_px[0] - 400.0).hypot(found.centre_px[1] - 350.0);
        std::println!(
            "{arc_deg} deg, noise {noise_px} px: centre off by {error:.4} px, radius {:.3}",
            found.radius_px
        );
        assert!(error < limit_px && (found.radius_px - 300.0).abs() < 2.0 * limit_px.max(0.02));
    }
}

#[test]
fn outliers_up_to_a_half_are_left_out_and_more_are_refused() {
    let mut generator = Generator::new(5);
    let mut points = ellipse(300.0, 0.3, &mut generator);
    for (index, outlier) in points.iter_mut().enumerate() {
        if index % 5 < 2 {
            *outlier = point([generator.between(0.0, 800.0) as f32, generator.between(0.0, 700.0) as f32]);
        }
    }
    let found = circle(&points, [0.0, 1.0], ECCENTRICITY).unwrap();
    assert!((found.centre_px[0] - 400.0).hypot(found.centre_px[1] - 350.0) < 0.5, "{found:?}");
    let chance: List<LimbPoint> = (0..100)
        .map(|_| point([generator.between(0.0, 800.0) as f32, generator.between(0.0, 700.0) as f32]))
        .collect();
    assert_eq!(circle(&chance, [0.0, 1.0], ECCENTRICITY), Err(FitError::NoConsensus));
    assert_eq!(circle(&chance[..3], [0.0, 1.0], ECCENTRICITY), Err(FitError::TooFewPoints));
}

#[test]
fn a_rendered_full_disc_is_found_within_a_pixel() {
    let world = geostationary(5.0, 3);
    let mut points = Points::new();
    limb_points(&mut Picture { pixels: world.picture(1.0, 11).pixels }, &mut [0; 2048], &mut points).unwrap();
    let pole = [world.pole.x as f32, world.pole.y as f32];
    let found = circle(&points, pole, ECCENTRICITY).unwrap();
    let truth = camera().project_earth(&direction(&world.centre)).unwrap();
    let error = (found.centre_px[0] - truth[0]).hypot(found.centre_px[1] - truth[1]);
    // Half angle of the disc from this distance.
    let radius = 3000.0 * (6378.137f64 / GEO_KM).asin().tan();
    std::println!("{} points, {found:?}: centre off by {error:.3} px, radius {radius:.2}", points.len());
    assert!(error < 1.0 && (f64::from(found.radius_px) - radius).abs() < 1.5);
}

proptest::proptest! {
    #[test]
    fn whatever_the_points_a_circle_is_finite(
        raw in proptest::collection::vec((proptest::num::f32::ANY, -1e4f32..1e4), 0..60),
        pole in [proptest::num::f32::NORMAL, proptest::num::f32::NORMAL],
    ) {
        let points: List<LimbPoint> = raw.iter().map(|(x, y)| point([*x, *y])).collect();
        if let Ok(circle) = circle(&points, pole, ECCENTRICITY) {
            assert!(circle.radius_px.is_finite() && circle.inliers >= 2);
        }
    }
}
