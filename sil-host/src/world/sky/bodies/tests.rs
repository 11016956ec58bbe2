//! The bodies in a scene: each is where it should be, hidden by what stands before it, and the same in any
//! window.

use super::*;
use crate::formats::camera_file::CameraFile;
use crate::formats::picture::copy_window;
use crate::world::detector::imaging::ImagingModel;
use crate::world::detector::shutter::Shutter;
use crate::world::earth::EarthModel;
use crate::world::motion::pointing::{Aim, Law, Mount, Pointing};
use crate::world::motion::tumble::Tumble;
use crate::world::noise::{Noise, Stream};
use crate::world::orbit::{TruthOrbit, state_of_elements};
use crate::world::scene::{Scene, SceneSettings};
use crate::world::vector::{angle, minus, plus, times, unit};
use fsw_core::orbit::body::CentralBody;
use fsw_hal::Detector;

/// The equinox of 2026-09-23 0:05 UTC, three days before full Moon.
const START_US: i64 = 843_393_969_184_000;
const EXPOSURE_US: u32 = 100_000;

/// Geostationary, both paths looking into `direction` (ICRS).
pub(in crate::world) fn looking(direction: Vector) -> Trajectory {
    let (r, v) = state_of_elements(CentralBody::Earth, [42_164.17, 0.0, 0.05, 0.0, 0.0, 130.0]).unwrap();
    let aim = Aim {
        ra_deg: libm::atan2(direction[1], direction[0]).to_degrees(),
        dec_deg: libm::asin(direction[2]).to_degrees(),
        roll_deg: 20.0,
    };
    Trajectory {
        orbit: TruthOrbit::new(START_US, r, v, 600).unwrap(),
        pointing: Pointing { law: Law::Inertial(aim), ..Pointing::default() },
        mount: Mount::default(),
        earth: EarthModel::default(),
    }
}

fn exposed(trajectory: Trajectory, bodies: BodiesModel) -> Scene {
    let camera = CameraFile { mirrored: true, ..CameraFile::reference() };
    let mut settings = SceneSettings::new(camera, Motion::orbiting(trajectory), 7);
    (settings.bodies, settings.imaging) = (bodies, ImagingModel::REFERENCE);
    let mut scene = Scene::new(settings, &[]).unwrap();
    scene.expose_cycle(100, EXPOSURE_US).unwrap();
    scene
}

fn whole(scene: &mut Scene) -> Vec<u16> {
    let mut pixels = vec![0; scene.geometry().whole().area()];
    scene.read(scene.geometry().whole(), &mut pixels).unwrap();
    pixels
}

/// Mean place and number of the pixels above `level`.
fn bright(pixels: &[u16], level: u16) -> ([f64; 2], usize) {
    let above = pixels.iter().enumerate().filter(|(_, value)| **value > level);
    let (mut sum, mut count) = ([0.0; 2], 0);
    for (index, _) in above {
        sum = [sum[0] + (index % 1280) as f64, sum[1] + (index / 1280) as f64];
        count += 1;
    }
    (sum.map(|s| s / count as f64), count)
}

/// Where a direction is imaged through the star path.
fn place(scene: &Scene, direction: Vector) -> [f64; 2] {
    let truth = scene.truth().unwrap();
    let aberration = scene.settings().motion.aberration(100.0);
    let seen = plus(direction, 1.0, aberration);
    scene.optics().project(apply(&matrix(truth.quaternion), seen)).unwrap()
}

#[test]
fn a_planet_stands_where_it_should_and_only_where_planets_are_asked_for() {
    let jupiter = planets::at(START_US)[3];
    let beside = unit(plus(jupiter.direction, 0.1, [0.0, 0.0, 1.0]));
    let only = BodiesModel { planets: true, ..BodiesModel::NONE };
    let mut scene = exposed(looking(beside), only);
    let [x, y] = place(&scene, planets::at(START_US + 100_000_000)[3].direction);
    let ([bx, by], count) = bright(&whole(&mut scene), 500);
    assert!(count > 3 && libm::hypot(x - bx, y - by) < 1.0, "{bx} {by} for {x} {y}, {count} px");
    let mut without = exposed(looking(beside), BodiesModel::NONE);
    assert_eq!(bright(&whole(&mut without), 500).1, 0);
}

#[test]
fn the_moon_floods_its_disc_in_the_star_path_and_is_dimmed_in_the_earth_path() {
    let only = BodiesModel { moon: true, ..BodiesModel::NONE };
    let moon_km = ephemeris::moon_km(START_US + 100_000_000);
    let seen_from = |position: Vector| unit(minus(moon_km, position));
    let trajectory = looking(unit(moon_km));
    let direction = seen_from(trajectory.orbit.at(100.0).0);
    let mut scene = exposed(trajectory.clone(), only);
    let pixels = whole(&mut scene);
    let ([x, y], count) = bright(&pixels, 1000);
    let expected = place(&scene, direction);
    // The disc has a radius of 13.6 px; its dark rim on one side displaces the middle by 1.7 px, the blur of
    // the bright rim on the other by as much again.
    assert!(libm::hypot(x - expected[0], y - expected[1]) < 4.0, "{x} {y} for {expected:?}");
    assert!((400..1000).contains(&count), "{count}");
    // The Earth path alone: brighter than the dark by up to the albedo's 0.12 of 1.16e4 / 0.3 e-/s.
    let camera = CameraFile { mirrored: true, ..CameraFile::reference() };
    let mut settings = SceneSettings::new(camera, Motion::orbiting(trajectory), 7);
    settings.bodies = only;
    settings.imaging = ImagingModel { star_path_transmission: 0.0, ..ImagingModel::REFERENCE };
    let mut scene = Scene::new(settings, &[]).unwrap();
    scene.expose_cycle(100, 900_000).unwrap();
    let pixels = whole(&mut scene);
    let truth = scene.truth().unwrap();
    let [x, y] = scene.optics().earth_path().project(apply(&truth.earth_path, direction)).unwrap();
    let at = |x: f64, y: f64| {
        let near =
            |k: i64| f64::from(pixels[((y as i64 + k / 5 - 2) * 1280 + x as i64 + k % 5 - 2) as usize]);
        (0..25).map(near).sum::<f64>() / 25.0
    };
    let electrons = (at(x, y) - at(x + 60.0, y)) * 40_000.0 / 1023.0 / 0.9;
    assert!((1_000.0..5_000.0).contains(&electrons), "{electrons} e-/s");
}

#[test]
fn the_earth_in_the_star_path_hides_stars_and_its_lit_side_saturates() {
    let trajectory = looking([1.0, 0.0, 0.0]);
    let down = times(-1.0, unit(trajectory.orbit.at(100.0).0));
    let trajectory = Trajectory { pointing: looking(down).pointing, ..trajectory };
    let camera = CameraFile { mirrored: true, ..CameraFile::reference() };
    let settings = SceneSettings::new(camera, Motion::orbiting(trajectory), 7);
    let mut scene = Scene::new(settings, &crate::world::sky::in_year(2026.7)).unwrap();
    scene.expose_cycle(100, EXPOSURE_US).unwrap();
    let truth = scene.truth().unwrap();
    let limb_deg = libm::asin(6378.137 / length(truth.position_km)).to_degrees();
    let sight = transposed(&matrix(truth.quaternion));
    let nadir = times(-1.0, truth.position_km);
    let seen = scene.visible_stars();
    assert!(seen.len() > 50);
    for star in seen {
        let direction = apply(&sight, scene.optics().unproject([star.x_px, star.y_px]).unwrap());
        assert!(angle(direction, nadir).to_degrees() > limb_deg - 0.05, "{star:?}");
    }
    let pixels = whole(&mut scene);
    let lit = pixels.iter().filter(|value| **value >= 1023).count();
    assert!((100_000..700_000).contains(&lit), "{lit}");
}

#[test]
fn any_window_shows_the_bodies_of_the_whole_frame() {
    let moon = unit(ephemeris::moon_km(START_US));
    let mut trajectory = looking(moon);
    let quaternion = trajectory.quaternion(0.0);
    trajectory.pointing.law = Law::Spin(Tumble::new(quaternion, [0.02, 0.01, -0.02], [1.0; 3], 600));
    let camera = CameraFile { mirrored: true, ..CameraFile::reference() };
    let mut settings = SceneSettings::new(camera, Motion::orbiting(trajectory), 7);
    settings.bodies = BodiesModel { satellites_an_hour: 3600.0, ..BodiesModel::ALL };
    settings.imaging =
        ImagingModel { shutter: Shutter::Rolling { row_time_s: 5e-5 }, ..ImagingModel::REFERENCE };
    let mut scene = Scene::new(settings, &[]).unwrap();
    scene.expose_cycle(2, EXPOSURE_US).unwrap();
    let frame = whole(&mut scene);
    let noise = Noise::new(3, 0, Stream::Shuffle);
    for k in 0..40 {
        let pick = |n, side: f64| (noise.uniform(k, n) * side) as u16;
        let window = Window {
            x: pick(0, 1200.0),
            y: pick(1, 950.0),
            width: 1 + pick(2, 79.0),
            height: 1 + pick(3, 73.0),
        };
        let (mut part, mut cut) = (vec![0; window.area()], vec![0; window.area()]);
        scene.read(window, &mut part).unwrap();
        copy_window(&frame, &scene.geometry(), window, &mut cut);
        assert_eq!(part, cut, "{window:?}");
    }
}
