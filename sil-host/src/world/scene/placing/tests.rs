//! Ways whose speed changes, against images of even times.

use super::*;
use crate::formats::camera_file::CameraFile;
use crate::world::detector::pixel::PixelResponse;
use crate::world::motion::pointing::Mount;
use crate::world::scene::WorldStar;
use crate::world::sky::bodies::tests::looking;
use crate::world::vector::{times, unit};
use fsw_hal::{Detector, OpenPaths, Window};
use std::sync::Arc;

const WINDOW: Window = Window { x: 0, y: 0, width: 96, height: 24 };
const ELECTRONS: f64 = 8000.0;

/// The pixels of lines and images.
fn pixels(light: PointLight, psf: &Arc<Psf>) -> Vec<f64> {
    let mut pixels = vec![0.0; WINDOW.area()];
    light.streaks.add_to(WINDOW, &mut pixels);
    Spots::new(psf.clone(), PixelResponse::Full, light.spots).add_to(WINDOW, &mut pixels);
    pixels
}

/// A way, its place at a part of the exposure given, in so many chords.
fn chords(place: impl Fn(f64) -> f64, count: usize) -> Vec<[f64; 2]> {
    (0..=count).map(|chord| [place(chord as f64 / count as f64), 11.3]).collect()
}

#[test]
fn a_star_that_begins_to_move_or_comes_to_rest_keeps_its_light_where_it_is() {
    let psf = Arc::new(Psf::gaussian(0.9));
    let none = || PointLight { spots: Vec::new(), streaks: Streaks::new(psf.clone(), PixelResponse::Full) };
    let mut colour = [0.0; BANDS];
    colour[0] = ELECTRONS;
    // From rest all along; at rest for two thirds; to rest; at an even speed; slower and faster.
    let ways: [fn(f64) -> f64; 5] = [
        |t| 12.2 + 15.0 * t * t,
        |t| 12.2 + 500.0 * (t - 0.66).max(0.0).powi(2),
        |t| 12.2 + 60.0 * (1.0 - (1.0 - t).powi(3)),
        |t| 12.2 + 60.0 * t,
        |t| 12.2 + 60.0 * (t + 0.1 * (std::f64::consts::TAU * t).sin()),
    ];
    for (number, way) in ways.into_iter().enumerate() {
        let mut drawn = none();
        drawn.lay_way(&chords(way, 32), colour.map(|e| e / 32.0), &psf);
        let mut oracle = none();
        let places = chords(way, 4096);
        oracle.spots.extend(images(&places, colour.map(|e| e / 4096.0), 0.02));
        let (drawn, oracle) = (pixels(drawn, &psf), pixels(oracle, &psf));
        let (all, brightest) = (drawn.iter().sum::<f64>(), oracle.iter().copied().fold(0.0, f64::max));
        let worst = drawn.iter().zip(&oracle).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        println!("way {number}: light {:.4}, worst pixel {:.4}", all / ELECTRONS, worst / brightest);
        // A pixel by less than its noise, two of a hundred.
        assert!((all / ELECTRONS - 1.0).abs() < 0.003 && worst < 0.02 * brightest, "way {number}");
    }
}

/// A geostationary scene with a star of V = -1 in the middle of the Earth path, whose direction is `off` from
/// that to the Earth, rad; the star path looks 90 deg away.
fn scene_with_star_near_the_earth(off: f64) -> Scene {
    let trajectory = looking([1.0, 0.0, 0.0]);
    let down = unit(times(-1.0, trajectory.orbit.at(100.0).0));
    let direction = unit(plus(down, libm::tan(off), [0.0, 0.0, 1.0]));
    let mount = Mount { star_path_deg: [0.0, 90.0, 0.0] };
    let trajectory = Trajectory { mount, ..looking(direction) };
    let camera = CameraFile { mirrored: true, ..CameraFile::reference() };
    let settings = SceneSettings::new(camera, Motion::orbiting(trajectory), 7);
    Scene::new(settings, &[WorldStar { hip: 1, direction, v: -1.0, b_v: 0.0 }]).unwrap()
}

#[test]
fn without_its_filter_the_earth_path_shows_stars_beside_the_earth_and_none_behind_it() {
    // The Earth's radius is 8.7 deg there.
    for (off_deg, seen) in [(10.0f64, 1), (8.0, 0)] {
        let mut scene = scene_with_star_near_the_earth(off_deg.to_radians());
        for (open, stars) in [(OpenPaths::Both, 0), (OpenPaths::Star, 0), (OpenPaths::BothClear, seen)] {
            scene.open(open);
            scene.expose_cycle(100, 100_000).unwrap();
            let mut pixels = [0; 21 * 21];
            scene.read(Window { x: 629, y: 501, width: 21, height: 21 }, &mut pixels).unwrap();
            let brightest = |pixels: &[u16]| pixels.iter().copied().max().unwrap_or(0);
            let middle = brightest(&pixels[7 * 21..14 * 21]);
            let edge = brightest(&pixels[..5 * 21]);
            assert_eq!(middle > edge + 40, stars == 1, "{open:?} at {off_deg} deg: {middle} {edge}");
        }
        let (path, truth) = (scene.clear_earth_path().unwrap(), scene.truth().unwrap());
        let streaks = Streaks::new(scene.psf.clone(), PixelResponse::Full);
        let mut light = PointLight { spots: Vec::new(), streaks };
        let visible = scene.place_stars(&path, 100, 0.1, Some(&truth), &mut light);
        assert_eq!(visible.len(), seen);
        for star in visible {
            // Aberration moves it by up to 25 arcsec, a pixel is 69.
            assert!(libm::hypot(star.x_px - 639.5, star.y_px - 511.5) < 0.5, "{star:?}");
            let light_e: f64 = light.spots.iter().flat_map(|spot| spot.electrons).sum();
            let expected_e = scene.settings.detector.star_e_s(-1.0) * 0.1 * 0.09 / 0.91;
            assert!((light_e / expected_e - 1.0).abs() < 1e-9, "{light_e} {expected_e}");
        }
    }
}
