use super::*;
use crate::earth::limb::{Crossing, Reach, StripPoint, crossing, strip};
use crate::earth::test_world::{GEOMETRY, World, camera, geostationary, low, narrow, parameters};
use crate::earth::view::View;
use std::vec::Vec;

/// Bias and scatter of the points of a filter against where the limb stands, px, and the share found.
fn measure(world: &World, reach_px: u16, filter: impl Crossing) -> (f64, f64, f64) {
    let parameters = parameters();
    let view = View::new(&narrow(&world.centre), &world.body(&parameters)).unwrap();
    let limb = view.limb(&camera(), 90.0, (24, 4), &parameters);
    let (mut errors, mut asked) = (Vec::new(), 0.0);
    for (index, expected) in limb.points.iter().enumerate() {
        let reach = Reach { outward_px: reach_px, inward_px: reach_px };
        let Some(strip) = strip(expected, reach, &GEOMETRY) else { continue };
        asked += 1.0;
        let pixels = world.expose(strip.window, 1.0, index as u64);
        if let Some(StripPoint { point: found, .. }) = filter(&pixels, &strip, &GEOMETRY, &parameters) {
            assert!(found.sigma_px > 0.0 && found.outward_px == expected.outward_px);
            let [nx, ny] = expected.outward_px;
            let [dx, dy] = [0, 1].map(|k| found.centre_px[k] - expected.at_px[k]);
            errors.push(f64::from(dx * nx + dy * ny));
        }
    }
    let count = errors.len().max(1) as f64;
    let bias = errors.iter().sum::<f64>() / count;
    let scatter = (errors.iter().map(|error| (error - bias).powi(2)).sum::<f64>() / count).sqrt();
    (bias, scatter, count / asked)
}

#[test]
fn both_filters_find_the_limb_of_an_even_earth_and_are_worse_than_the_flights_crossing() {
    let even = |world: World| World { albedo: [0.6, 0.6], ..world };
    // The steep limb of a high orbit is a pixel wide, the lens more: neither shape is that of the lens.
    for (name, world, reach_px, limit_px) in [
        ("geostationary, half", even(geostationary(90.0, 5)), 20, 0.7),
        ("450 km", even(low(450.0, 90.0, [40.0, 30.0], 7)), 64, 2.0),
    ] {
        let flight = measure(&world, reach_px, crossing);
        let filters = [measure(&world, reach_px, exponential), measure(&world, reach_px, polynomial)];
        for ((bias, scatter, share), what) in filters.into_iter().zip(["exponential", "polynomial"]) {
            std::println!("{name}, {what}: bias {bias:+.3} px, scatter {scatter:.3}, found {share:.2}");
            assert!(bias.abs() < limit_px && scatter < limit_px && share > 0.8, "{name}, {what}");
            assert!(bias.hypot(scatter) > flight.0.hypot(flight.1), "{name}, {what}");
        }
    }
}

#[test]
fn noise_and_a_bright_outside_give_no_limb() {
    let world = geostationary(60.0, 3);
    let parameters = parameters();
    let view = View::new(&narrow(&world.centre), &world.body(&parameters)).unwrap();
    let expected = view.limb(&camera(), 90.0, (24, 4), &parameters).points[3];
    let strip = strip(&expected, Reach { outward_px: 20, inward_px: 20 }, &GEOMETRY).unwrap();
    let area = strip.window.area();
    let noise: Vec<u16> = (0..area).map(|index| 40 + (index * 7919 % 5) as u16).collect();
    let bright = std::vec![600; area];
    for pixels in [&noise, &bright, &Vec::new()] {
        assert!(exponential(pixels, &strip, &GEOMETRY, &parameters).is_none());
        assert!(polynomial(pixels, &strip, &GEOMETRY, &parameters).is_none());
    }
}
