use super::*;
use crate::earth::test_world::{
    GEO_KM, Picture, World, camera, direction, geostationary, low, narrow, parameters,
};
use crate::oracle::Generator;
use nalgebra::Vector3;
use std::vec::Vec as List;

/// The Sun by the terminator of a picture of this world, and how far it is off, about the Earth's centre,
/// rad.
fn seen(world: &World, picture: &mut Picture) -> Option<(SunSeen, f64)> {
    let (camera, parameters) = (camera(), parameters());
    let view = View::new(&narrow(&world.centre), &world.body(&parameters)).unwrap();
    let away = -world.centre.normalize();
    let phase = away.dot(&world.sun) as f32;
    let seen = sun_seen(picture, &mut [0; 1280], (&camera, &view), phase, &parameters).unwrap()?;
    let across = |vector: Vector3<f64>| (vector - away * away.dot(&vector)).normalize();
    let (found, true_sun) = (across(crate::oracle::wide(seen.direction.vector())), across(world.sun));
    Some((seen, found.cross(&true_sun).norm().atan2(found.dot(&true_sun))))
}

#[test]
fn the_sun_is_where_the_terminator_says_from_crescent_to_gibbous_whole_or_in_part() {
    let mut generator = Generator::new(41);
    let (mut ratios, mut told) = (List::new(), 0);
    for seed in 0..40 {
        let phase = generator.between(40.0, 140.0).to_radians();
        let sun = Vector3::new(0.0, 0.0, -phase.cos()) + {
            let azimuth = generator.between(0.0, std::f64::consts::TAU);
            Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * phase.sin()
        };
        // The centre in the field, or beyond its edge.
        let [x, y] = [0.0, 1.0].map(|_| GEO_KM * generator.between(-0.22, 0.22));
        let world = World::new(Vector3::new(x, y, GEO_KM), generator.unit(), sun, seed);
        let Some((seen, off_rad)) = seen(&world, &mut world.picture(1.0, seed)) else { continue };
        assert!((f64::from(seen.direction.vector().norm()) - 1.0).abs() < 1e-5);
        told += usize::from(seen.sigma_rad < 0.175);
        ratios.push(off_rad / f64::from(seen.sigma_rad));
    }
    ratios.sort_by(f64::total_cmp);
    let rms = (ratios.iter().map(|ratio| ratio * ratio).sum::<f64>() / ratios.len() as f64).sqrt();
    std::println!(
        "seen in {} of 40, within 10 deg in {told}; off by {rms:.2} sigma rms, {:.1} at most",
        ratios.len(),
        ratios[ratios.len() - 1]
    );
    assert!(told >= 20 && rms < 1.5 && ratios[ratios.len() - 1] < 4.0);
}

#[test]
fn without_a_terminator_in_the_field_the_sun_is_not_seen() {
    // All lit, all dark, and a horizon by day.
    for world in [geostationary(0.0, 3), geostationary(179.0, 4), low(800.0, 90.0, [60.0, 30.0], 5)] {
        assert!(seen(&world, &mut world.picture(1.0, 7)).is_none());
    }
}

#[test]
fn hot_pixels_and_stars_move_it_by_less_than_a_tenth_of_its_sigma() {
    let world = geostationary(90.0, 5);
    let mut picture = world.picture(1.0, 7);
    let (_, clean_rad) = seen(&world, &mut picture).unwrap();
    let mut generator = Generator::new(9);
    for _ in 0..20_000 {
        let place = generator.between(0.0, picture.pixels.len() as f64) as usize;
        picture.pixels[place] = 1000;
    }
    let (seen, off_rad) = seen(&world, &mut picture).unwrap();
    std::println!("off by {clean_rad:.4} rad, with hot pixels by {off_rad:.4}, sigma {:.4}", seen.sigma_rad);
    assert!((off_rad - clean_rad).abs() < 0.1 * f64::from(seen.sigma_rad));
}

#[test]
fn what_is_no_sphere_under_the_sun_is_refused() {
    let world = geostationary(90.0, 5);
    let mut picture = world.picture(1.0, 7);
    // Its lit half in the wrong place: no azimuth is right.
    for (place, pixel) in picture.pixels.iter_mut().enumerate() {
        *pixel = if (place / 40) % 2 == 0 { 400 } else { 40 };
    }
    assert!(seen(&world, &mut picture).is_none());
    let camera = camera();
    let body = world.body(&parameters());
    let view = View::new(&narrow(&world.centre), &body).unwrap();
    let short = sun_seen(&mut picture, &mut [0; 100], (&camera, &view), 0.0, &parameters());
    assert_eq!(short.err(), Some(DetectorError::BufferLength));
    // Toward the centre the ground is straight below.
    let up = view.upward_where_met(&direction(&world.centre)).unwrap();
    assert!(up[0] < -0.999 && view.upward_where_met(&direction(&Vector3::new(1.0, 0.0, 0.1))).is_none());
}
