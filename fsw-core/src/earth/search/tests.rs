use super::*;
use crate::earth::MAX_LIMB_POINTS;
use crate::earth::centre::{RayBuffer, centre};
use crate::earth::test_world::{GEOMETRY, Picture, World, camera, geostationary, low, narrow, parameters};
use crate::earth::view::{ExpectedLimb, View};
use crate::oracle::{Generator, wide, wide_matrix};
use nalgebra::Vector3;
use std::vec::Vec as List;

fn find(picture: &mut Picture) -> Points {
    let mut points = Points::new();
    search(picture, &mut [0; 1280], &parameters(), &mut points).unwrap();
    points
}

#[test]
fn the_earth_is_found_without_prediction_from_high_and_low_orbits() {
    let mut failed = List::new();
    for (name, world, limit_deg) in [
        ("geostationary, full", geostationary(5.0, 3), 0.2),
        ("geostationary, 60 deg", geostationary(60.0, 4), 0.1),
        ("geostationary, half", geostationary(90.0, 5), 0.1),
        ("geostationary, crescent", geostationary(130.0, 6), 0.1),
        ("450 km, below", low(450.0, 90.0, [40.0, 30.0], 7), 1.5),
        ("800 km, slant", low(800.0, 35.0, [40.0, 30.0], 8), 1.5),
        ("600 km, left, low Sun", low(600.0, 180.0, [8.0, 80.0], 9), 3.0),
    ] {
        let mut picture = world.picture(1.0, 11);
        let points = find(&mut picture);
        let parameters = parameters();
        let body = world.body(&parameters);
        let fix = centre(
            &points,
            &camera(),
            &body,
            &parameters.search_criteria(points.len()),
            None,
            &parameters,
            &mut RayBuffer::new(),
        );
        let fix = fix.unwrap_or_else(|refusal| panic!("{name}: {refusal:?} of {} points", points.len()));
        let found = wide(&fix.centre_km);
        let error = found - world.centre;
        let angle = found.normalize().cross(&world.centre.normalize()).norm().to_degrees();
        let nees = error.dot(&(wide_matrix(&fix.covariance_km2).try_inverse().unwrap() * error));
        let (sigma_rad, sigma_km) = fix.sigmas();
        std::println!(
            "{name}: {} of {} points, arc {:.0} deg, rms {:.2} px, error {angle:.4} deg (sigma {:.4}), distance {:+.1} km \
             (sigma {sigma_km:.1}), NEES {nees:.1}",
            fix.inliers.count_ones(),
            points.len(),
            fix.arc_rad.to_degrees(),
            fix.rms_px,
            sigma_rad.to_degrees(),
            found.norm() - world.centre.norm(),
        );
        if angle >= limit_deg {
            failed.push(name);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn a_sky_of_stars_and_hot_pixels_has_no_limb() {
    let mut generator = Generator::new(21);
    let mut pixels: List<u16> =
        (0..GEOMETRY.whole().area()).map(|_| (40.0 + generator.gaussian()).round() as u16).collect();
    for _ in 0..400 {
        let (x, y) = (generator.between(3.0, 1276.0) as usize, generator.between(3.0, 1020.0) as usize);
        let peak = generator.between(20.0, 900.0);
        let sigma = generator.between(0.3, 1.5);
        for row in y - 3..=y + 3 {
            for column in x - 3..=x + 3 {
                let off = (row as f64 - y as f64).hypot(column as f64 - x as f64);
                pixels[row * 1280 + column] += (peak * (-0.5 * (off / sigma).powi(2)).exp()) as u16;
            }
        }
    }
    assert_eq!(find(&mut Picture { pixels }).len(), 0);
}

#[test]
fn a_terminator_alone_gives_few_points_and_no_centre() {
    // The night side towards space, the terminator across the field.
    let world = World { albedo: [0.6, 0.6], ..low(700.0, 90.0, [20.0, 0.0], 2) };
    let mut dark = world.clone();
    dark.sun = Vector3::new(0.0, 1.0, 0.35).normalize();
    let points = find(&mut dark.picture(1.0, 3));
    let parameters = parameters();
    let body = dark.body(&parameters);
    let fix = centre(
        &points,
        &camera(),
        &body,
        &parameters.search_criteria(points.len()),
        None,
        &parameters,
        &mut RayBuffer::new(),
    );
    std::println!("terminator: {} points, {:?}", points.len(), fix.err());
    assert!(fix.is_err());
}

/// How many points there are, and how many of them lie on the limb that is lit.
fn on_limb(world: &World, noise: f64) -> [usize; 2] {
    let parameters = parameters();
    let view = View::new(&narrow(&world.centre), &world.body(&parameters)).unwrap();
    let limb = view.limb(&camera(), 0.0, (MAX_LIMB_POINTS, 4), &parameters).points;
    let points = find(&mut world.picture(noise, 11));
    let is_on_limb = |point: &&LimbPoint| {
        let off = |expected: &ExpectedLimb| [0, 1].map(|axis| point.centre_px[axis] - expected.at_px[axis]);
        let apart = |expected: &ExpectedLimb| {
            let [dx, dy] = off(expected);
            dx.hypot(dy)
        };
        let nearest = limb.iter().min_by(|one, other| apart(one).total_cmp(&apart(other))).unwrap();
        let ([dx, dy], [nx, ny]) = (off(nearest), nearest.outward_px);
        (dx * nx + dy * ny).abs() < 6.0
    };
    [points.len(), points.iter().filter(is_on_limb).count()]
}

#[test]
fn noise_hides_few_points_and_makes_none() {
    for (name, world) in [
        ("geostationary, 60 deg", geostationary(60.0, 4)),
        ("geostationary, crescent", geostationary(130.0, 6)),
        ("800 km, slant", low(800.0, 35.0, [40.0, 30.0], 8)),
    ] {
        let [found, quiet] = on_limb(&world, 1.0);
        let share = |true_ones: usize, found: usize| true_ones as f64 / found.max(1) as f64;
        let quiet_share = share(quiet, found);
        for noise in [2.0, 4.0, 8.0] {
            let [found, true_ones] = on_limb(&world, noise);
            std::println!("{name}, noise {noise}: {true_ones} of {found} on the limb, quiet {quiet}");
            assert!(2 * true_ones >= quiet && share(true_ones, found) >= 0.95 * quiet_share, "{name}");
        }
    }
}

#[test]
fn a_dark_sea_is_no_sky() {
    // From left to right: sky, a bright limb, dark sea, clouds. From the right a line first meets the clouds,
    // then the sea, then the limb.
    let mut generator = Generator::new(5);
    let level = |x: usize| match x {
        0..500 => 33.0,
        500..560 => 120.0,
        560..800 => 45.0,
        _ => 130.0,
    };
    let pixels = (0..GEOMETRY.whole().area())
        .map(|place| (level(place % usize::from(GEOMETRY.width_px)) + generator.gaussian()).round() as u16)
        .collect();
    let points = find(&mut Picture { pixels });
    assert!(points.len() > 60);
    for LimbPoint { centre_px: [x, _], outward_px, .. } in points {
        assert!((x - 499.5).abs() < 1.0 && outward_px == [-1.0, 0.0], "{x}");
    }
}

#[test]
fn a_short_buffer_is_refused() {
    let mut picture = Picture { pixels: std::vec![40; GEOMETRY.whole().area()] };
    let result = search(&mut picture, &mut [0; 1279], &parameters(), &mut Points::new());
    assert_eq!(result, Err(DetectorError::BufferLength));
}

#[test]
fn more_points_than_the_list_holds_are_thinned_out_evenly() {
    let mut points = Points::new();
    let mut thinned = Decimator { points: &mut points, seen: 0, stride: 1 };
    for number in 0..1000 {
        thinned.add(LimbPoint::new([number as f32, 0.0], 1.0, [1.0, 0.0]));
    }
    let numbers: List<f32> = points.iter().map(|point| point.centre_px[0]).collect();
    assert!(numbers.len() > MAX_SEARCH_POINTS / 2);
    assert!(numbers.windows(2).all(|pair| pair[1] - pair[0] == 8.0), "{numbers:?}");
    assert!(numbers[0] == 0.0 && *numbers.last().unwrap() > 980.0);
}

proptest::proptest! {
    #[test]
    fn any_line_gives_points_on_it(raw in proptest::collection::vec(0u16..1024, 0..300), smooth in 1usize..20) {
        let pixels: List<u16> = raw
            .iter()
            .enumerate()
            .map(|(index, _)| raw[index / smooth * smooth])
            .collect();
        let thresholds = Thresholds {
            contrast: 60 << 6,
            begin: 15 << 6,
            dark: 120 << 6,
            sky: 0,
            max_above_sky: 15 << 6,
            run: 12,
            rise: 64,
            floor_px: 0.3,
        };
        for backwards in [false, true] {
            if let Some(found) = first_crossing(&Line { pixels: &pixels, backwards }, &thresholds) {
                assert!(found.place >= 0.0 && found.place < pixels.len() as f32);
                assert!(found.sigma_px.is_finite());
            }
        }
    }
}
