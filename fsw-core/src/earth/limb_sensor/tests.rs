use super::*;
use crate::earth::test_world::{
    DARK, GEOMETRY, Picture, World, camera, even, geostationary, low, narrow, parameters,
};
use crate::oracle::{Generator, wide};
use std::boxed::Box;
use std::vec::Vec as List;

const WIDTH: usize = 1280;
const HEIGHT: usize = 1024;

/// Looks at a picture with the pole known, and the Sun if it is given.
fn find(picture: &mut Picture, world: &World, sun_known: bool) -> Found {
    let parameters = parameters();
    let known = world.body(&parameters);
    let body = if sun_known { known } else { known.without_sun() };
    let camera = camera();
    let limb_sensor = LimbSensor { camera: &camera, body: &body, parameters: &parameters, turn: None };
    let mut rays = Box::new(centre::RayBuffer::new());
    let mut buffers = Buffers { buffer: &mut [0; 2048], points: &mut search::Points::new(), rays: &mut rays };
    acquire(&limb_sensor, picture, &mut buffers).unwrap()
}

#[test]
fn the_earth_is_found_in_a_picture_of_which_nothing_is_known() {
    let mut failed = List::new();
    for (name, world, limit_deg) in [
        ("geostationary, full", geostationary(5.0, 3), 0.03),
        ("geostationary, 60 deg", geostationary(60.0, 4), 0.03),
        ("geostationary, half", geostationary(90.0, 5), 0.05),
        ("geostationary, crescent", geostationary(130.0, 6), 0.05),
        ("450 km, below", low(450.0, 90.0, [40.0, 30.0], 7), 1.0),
        ("800 km, slant", low(800.0, 35.0, [40.0, 30.0], 8), 1.0),
    ] {
        for sun_known in [true, false] {
            let found = find(&mut world.picture(1.0, 11), &world, sun_known);
            let fix = found.fix.unwrap_or_else(|refusal| panic!("{name}: {refusal:?}, {found:?}"));
            let seen = wide(&fix.centre_km);
            let angle = seen.normalize().cross(&world.centre.normalize()).norm().to_degrees();
            let sigma = fix.sigmas().0.to_degrees();
            std::println!(
                "{name}, Sun known {sun_known}: {} of {} strips, arc {:.0} deg, rms {:.2} px, error {angle:.4} deg (sigma {sigma:.4})",
                fix.inliers.count_ones(),
                found.strips,
                fix.arc_rad.to_degrees(),
                fix.rms_px
            );
            if angle > limit_deg {
                failed.push(name);
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

/// A picture drawn by a function of the pixel, with noise of one count.
fn drawn(at: impl Fn(f64, f64) -> f64) -> Picture {
    let mut generator = Generator::new(8);
    let pixels = (0..WIDTH * HEIGHT)
        .map(|index| {
            let value = at((index % WIDTH) as f64, (index / WIDTH) as f64);
            (DARK + value + generator.gaussian()).round().clamp(0.0, 1023.0) as u16
        })
        .collect();
    Picture { pixels }
}

/// A rendered picture with something drawn over it.
fn covered(world: &World, at: impl Fn(f64, f64) -> Option<f64>) -> Picture {
    let mut picture = world.picture(1.0, 5);
    for (index, pixel) in picture.pixels.iter_mut().enumerate() {
        if let Some(value) = at((index % WIDTH) as f64, (index / WIDTH) as f64) {
            *pixel = (DARK + value).round().clamp(0.0, 1023.0) as u16;
        }
    }
    picture
}

/// Clouds as seen from above, 100 to 600 counts.
fn ground(x: f64, y: f64) -> f64 {
    350.0 + 125.0 * ((x / 37.0).sin() + (y / 29.0 + x / 91.0).cos())
}

#[test]
fn what_is_no_measurable_earth_is_refused_with_its_reason() {
    use FitError::{Degenerate, NoConsensus, ShortArc, TooFewPoints};
    let geo = geostationary(40.0, 3);
    let leo = low(800.0, 90.0, [40.0, 30.0], 7);
    let night = World { sun: geo.centre.normalize(), ..geo.clone() };
    // The horizon of a low orbit cuts off a corner of the field: 11 deg beyond its middle.
    let whole = low(800.0, 38.7, [40.0, 30.0], 7);
    let aside = Vector3::new(-(38.7f64.to_radians().sin()), 38.7f64.to_radians().cos(), 0.0);
    let turned = |vector: &Vector3<f64>| {
        let (sine, cosine) = 11f64.to_radians().sin_cos();
        vector * cosine + aside.cross(vector) * sine + aside * (aside.dot(vector) * (1.0 - cosine))
    };
    let corner = World::new(turned(&whole.centre), turned(&whole.pole), turned(&whole.sun), 7);
    // Night all over the limb in sight.
    let leo_night = World { sun: -leo.sun, ..leo.clone() };
    let airglow = |x: f64, y: f64| {
        // A layer 12 km thick about the limb of a low orbit, a px a km: a sharp outer edge, and below it the
        // two passages through a thin shell, 80 counts where they join.
        let depth = 4800.0 - (x - 639.5).hypot(y - 5300.0);
        let path = |depth: f64| depth.max(0.0).sqrt();
        80.0 * (path(depth) - path(depth - 12.0)) / path(12.0)
    };
    let from = |x: f64, y: f64| move |cx: f64, cy: f64| (x - cx).hypot(y - cy);
    let sun = |x: f64, y: f64| {
        let off = from(x, y)(700.0, 400.0);
        if off < 90.0 { 2000.0 } else { 40_000.0 / (off - 50.0) - 40.0 }.max(0.0)
    };
    let moon = |x: f64, y: f64| if from(x, y)(500.0, 600.0) < 13.6 { 400.0 } else { 0.0 };
    let panel =
        |x: f64, y: f64| x + 0.3 * y > 330.0 && x - 0.2 * y < 900.0 && y > 0.1 * x - 60.0 && y < 1000.0;
    let bordered = |x: f64, y: f64| {
        let inside = x > 40.0 && x < 1240.0 && y > 40.0 && y < 984.0;
        if inside { ground(x, y) } else { 0.0 }
    };
    let corners = |x: f64, y: f64| {
        let filled = (x - 639.5).abs() + (y - 511.5).abs() > 900.0;
        if filled { 0.0 } else { ground(x, y) }
    };
    let flat = |_: f64, y: f64| 300.0 / (1.0 + (-(y - 500.0) / 6.0).exp());
    let cases: [(&str, Picture, &World, &[FitError]); 12] = [
        ("night", night.picture(1.0, 2), &night, &[TooFewPoints]),
        ("airglow", drawn(airglow), &leo_night, &[TooFewPoints, NoConsensus]),
        ("Sun in the field", drawn(sun), &geo, &[TooFewPoints, NoConsensus]),
        ("detector full of the Sun", drawn(|_, _| 2000.0), &geo, &[TooFewPoints]),
        (
            "occluder over most of the disc",
            covered(&geo, |x, y| panel(x, y).then_some(600.0)),
            &geo,
            &[NoConsensus],
        ),
        (
            "occluder over all of it",
            drawn(|x, y| if panel(x, y) { 600.0 } else { 0.0 }),
            &geo,
            &[NoConsensus],
        ),
        ("Moon alone", drawn(moon), &geo, &[TooFewPoints]),
        ("frame border", drawn(bordered), &leo, &[NoConsensus]),
        ("fill corners", drawn(corners), &leo, &[NoConsensus, TooFewPoints]),
        ("corner of a horizon", corner.picture(1.0, 3), &corner, &[ShortArc]),
        ("ground everywhere", drawn(ground), &leo, &[TooFewPoints]),
        ("edge without curvature", drawn(flat), &leo, &[Degenerate]),
    ];
    let mut failed = List::new();
    for (name, mut picture, world, reasons) in cases {
        for sun_known in [true, false] {
            let found = find(&mut picture, world, sun_known);
            std::println!(
                "{name}, Sun known {sun_known}: {} points, {} strips, {:?}",
                found.searched,
                found.strips,
                found.fix.map(|fix| (
                    fix.centre_km,
                    fix.inliers.count_ones(),
                    fix.rms_px,
                    fix.arc_rad.to_degrees(),
                    fix.sigmas()
                ))
            );
            if !found.fix.is_err_and(|reason| reasons.contains(&reason)) {
                failed.push(name);
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn the_moon_or_a_dark_boom_before_the_disc_moves_the_centre_by_less_than_its_sigma_allows() {
    let world = geostationary(40.0, 3);
    let boom = |x: f64, y: f64| ((x - 0.4 * y - 200.0).abs() < 40.0).then_some(0.0);
    let moon = |x: f64, y: f64| ((x - 250.0).hypot(y - 300.0) < 13.6).then_some(400.0);
    for (name, mut picture) in [("boom", covered(&world, boom)), ("Moon", covered(&world, moon))] {
        let found = find(&mut picture, &world, true);
        let fix = found.fix.unwrap();
        let angle = wide(&fix.centre_km).normalize().cross(&world.centre.normalize()).norm().to_degrees();
        std::println!("{name}: error {angle:.4} deg, sigma {:.4}", fix.sigmas().0.to_degrees());
        assert!(angle < 0.05, "{name}");
    }
}

#[test]
fn a_short_buffer_is_the_detectors_error() {
    let world = geostationary(5.0, 3);
    let parameters = parameters();
    let (body, camera) = (world.body(&parameters), camera());
    let limb_sensor = LimbSensor { camera: &camera, body: &body, parameters: &parameters, turn: None };
    let mut rays = Box::new(centre::RayBuffer::new());
    let mut buffers = Buffers { buffer: &mut [0; 100], points: &mut search::Points::new(), rays: &mut rays };
    let mut picture = Picture { pixels: std::vec![40; GEOMETRY.whole().area()] };
    assert_eq!(acquire(&limb_sensor, &mut picture, &mut buffers), Err(DetectorError::BufferLength));
}

#[test]
fn a_dark_sea_before_clouds_is_no_limb() {
    let world = geostationary(5.0, 3);
    let (parameters, camera) = (parameters(), camera());
    let body = world.body(&parameters);
    let view = View::new(&narrow(&world.centre), &body).unwrap();
    // An eighth of the limb: clouds up to 14 px inside of it, and beyond them sea without an end.
    let middle = world.centre / world.centre.z * f64::from(camera.parameters().focal_length_px);
    let off = |x: f64, y: f64| (x - 639.5 - middle.x, y - 511.5 - middle.y);
    let hidden = |x: f64, y: f64| {
        let (x, y) = off(x, y);
        y.atan2(x).abs() < core::f64::consts::FRAC_PI_8
    };
    let limb_px = |[x, y]: [f32; 2]| {
        let (x, y) = off(x.into(), y.into());
        x.hypot(y)
    };
    let limb = view.limb(&camera, 90.0, (MAX_LIMB_STRIPS, 4), &parameters).points;
    let radius_px = limb_px(limb[0].at_px);
    let mut picture = covered(&world, |x, y| {
        let (dx, dy) = off(x, y);
        let inside_px = radius_px - 14.0 - dx.hypot(dy);
        hidden(x, y).then(|| 60.0 + 160.0 / (1.0 + (-inside_px).exp()))
    });
    let at_sea = |at: [f32; 2]| hidden(at[0].into(), at[1].into());
    // Its coast is a good edge by itself.
    let coasts = limb.iter().filter(|expected| at_sea(expected.at_px)).filter(|expected| {
        let strip = limb::strip(expected, even(40), &GEOMETRY).unwrap();
        let mut pixels = std::vec![0; strip.window.area()];
        picture.read(strip.window, &mut pixels).unwrap();
        limb::crossing(&pixels, &strip, &GEOMETRY, &parameters).is_some()
    });
    assert!(coasts.count() >= 2);

    let limb_sensor = LimbSensor { camera: &camera, body: &body, parameters: &parameters, turn: None };
    let (mut points, mut rays) = (search::Points::new(), Box::new(centre::RayBuffer::new()));
    let mut buffers = Buffers { buffer: &mut [0; 2048], points: &mut points, rays: &mut rays };
    let variance = limb_sensor.height_variance(&view, 10.0);
    let strips = limb_sensor.read_strips(&mut picture, &view, &variance, &EVEN_STRIPS, &mut buffers).unwrap();
    std::println!("{} points of {} strips", points.len(), strips.read);
    assert!(points.iter().all(|point| !at_sea(point.centre_px)));
    assert!(points.len() >= 16);
}
