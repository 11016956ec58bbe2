use super::*;
use crate::earth::centre::{RayBuffer, centre};
use crate::earth::limb::{crossing, strip};
use crate::earth::search::{Points, search};
use crate::earth::test_world::{GEOMETRY, World, camera, even, geostationary, low, parameters};
use crate::earth::view::View;
use crate::oracle::{wide, wide_matrix};
use std::vec::Vec;

/// One tracking second about a predicted centre.
fn track(world: &World, predicted_km: &Vector3<f32>, reach_px: u16, seed: u64) -> Result<EarthFix, FitError> {
    let (parameters, camera) = (parameters(), camera());
    let body = world.body(&parameters);
    let view = View::new(predicted_km, &body).unwrap();
    let expected = view.limb(&camera, f32::from(reach_px) + 1.0, (24, 4), &parameters).points;
    let points: Vec<LimbPoint> = expected
        .iter()
        .enumerate()
        .filter_map(|(index, expected)| {
            let strip = strip(expected, even(reach_px), &GEOMETRY)?;
            let pixels = world.expose(strip.window, 1.0, seed * 100 + index as u64);
            crossing(&pixels, &strip, &GEOMETRY, &parameters).map(|found| found.point)
        })
        .collect();
    let strips = Strips { read: points.len(), skipped: 0, km_per_px: f32::INFINITY };
    let criteria = &parameters.strip_criteria(&strips, true);
    centre(&points, &camera, &body, criteria, None, &parameters, &mut RayBuffer::new())
}

#[test]
fn strips_tolerate_what_a_limb_scatters() {
    let parameters = parameters();
    let tolerance = |km_per_px: f32| {
        parameters.strip_criteria(&Strips { read: 24, skipped: 0, km_per_px }, true).tolerance_px
    };
    assert_eq!(tolerance(f32::INFINITY), parameters.strips.tolerance_px);
    // Four scatters of 0.6 km are 3 px of 0.8 km, and 2 px are allowed besides.
    assert!((tolerance(0.8) - 13f32.sqrt()).abs() < 1e-4);
    assert!(tolerance(0.0).is_finite());
}

/// Direction error, deg, distance error, km, normalised square.
fn errors(world: &World, fix: &EarthFix) -> (f64, f64, f64) {
    let found = wide(&fix.centre_km);
    let error = found - world.centre;
    let angle = found.normalize().cross(&world.centre.normalize()).norm().to_degrees();
    let nees = error.dot(&(wide_matrix(&fix.covariance_km2).try_inverse().unwrap() * error));
    (angle, found.norm() - world.centre.norm(), nees)
}

#[test]
fn strips_after_a_search_find_the_centre_within_the_goal() {
    let mut failed = Vec::new();
    for (name, make, reach, limit_deg) in [
        ("geostationary, full", (|seed| geostationary(5.0, seed)) as fn(u64) -> World, 24, 0.03),
        ("geostationary, 60 deg", |seed| geostationary(60.0, seed), 24, 0.02),
        ("geostationary, half", |seed| geostationary(90.0, seed), 24, 0.02),
        ("geostationary, crescent", |seed| geostationary(130.0, seed), 24, 0.02),
        ("450 km", |seed| low(450.0, 90.0, [40.0, 30.0], seed), 50, 1.0),
        ("800 km, slant", |seed| low(800.0, 35.0, [40.0, 30.0], seed), 50, 1.5),
    ] {
        let (parameters, runs) = (parameters(), 4);
        let (mut squares, mut ranges, mut nees, mut sigma, mut solved) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for seed in 0..runs {
            let world = make(seed + 50);
            let mut points = Points::new();
            search(&mut world.picture(1.0, seed), &mut [0; 1280], &parameters, &mut points).unwrap();
            let body = world.body(&parameters);
            let criteria = &parameters.search_criteria(points.len());
            let first = centre(&points, &camera(), &body, criteria, None, &parameters, &mut RayBuffer::new());
            let fix = first.and_then(|first| track(&world, &first.centre_km, reach, seed));
            match fix {
                Ok(fix) => {
                    let (angle, range, square) = errors(&world, &fix);
                    squares += angle * angle;
                    ranges += range * range;
                    nees += square;
                    sigma += f64::from(fix.sigmas().0).to_degrees();
                    solved += 1.0;
                }
                Err(refusal) => std::println!("{name} {seed}: {refusal:?}, search {:?}", first.err()),
            }
        }
        let rms = (squares / solved).sqrt();
        std::println!(
            "{name}: direction rms {rms:.4} deg (mean sigma {:.4}), distance rms {:.1} km, mean NEES {:.1}, solved {solved}",
            sigma / solved,
            (ranges / solved).sqrt(),
            nees / solved
        );
        if rms.is_nan() || rms > limit_deg || solved < 3.0 {
            failed.push(name);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn sigmas_are_those_across_and_along_the_direction() {
    let fix = EarthFix {
        centre_km: Vector3::new(0.0, 3000.0, 4000.0),
        linearisation_km: Vector3::new(0.0, 3000.0, 4000.0),
        // 3 km along, 10 km across in x, 5 km across in the plane of y and z.
        covariance_km2: {
            let (along, across) = (Vector3::new(0.0, 0.6, 0.8), Vector3::new(0.0, 0.8, -0.6));
            let x = Vector3::new(1.0, 0.0, 0.0);
            along * along.transpose() * 9.0 + across * across.transpose() * 25.0 + x * x.transpose() * 100.0
        },
        noise_km2: nalgebra::Matrix3::identity(),
        arc_rad: 1.0,
        rms_px: 0.1,
        inliers: 7,
    };
    let (direction_rad, range_km) = fix.sigmas();
    assert!((direction_rad - 10.0 / 5000.0).abs() < 1e-6 && (range_km - 3.0).abs() < 1e-3);
    // A centre 3,000 km across of 5,000 km is 5,831 km away: 831 km in three sigma, by the series 900.
    let across = nalgebra::Matrix3::from_diagonal(&Vector3::new(1e6, 0.0, 0.0));
    let (_, range_km) = EarthFix { covariance_km2: across, ..fix }.sigmas();
    assert!((range_km - 300.0).abs() < 0.1, "{range_km}");
}
