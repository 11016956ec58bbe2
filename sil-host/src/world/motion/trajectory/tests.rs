//! Trajectories through the scene: sensor states about an eclipse, blinding, aberration, the mirror, windows
//! of the Earth.

use super::*;
use crate::formats::camera_file::CameraFile;
use crate::world::attitude::{dot, matrix};
use crate::world::motion::Motion;
use crate::world::motion::jitter::{Jitter, JitterModel, Line};
use crate::world::motion::pointing::{Aim, Law};
use crate::world::motion::slew::Slew;
use crate::world::motion::tumble::Tumble;
use crate::world::orbit::state_of_elements;
use crate::world::scene::{Scene, SceneSettings, WorldStar};
use crate::world::time::ephemeris::sun_km;
use crate::world::vector::{angle, cross, product};
use fsw_core::orbit::body::CentralBody;
use fsw_hal::{Detector, Window};
use proptest::prelude::*;

/// The equinox of 2026-09-23 0:05 UTC.
const EQUINOX_US: i64 = 843_393_969_184_000;
/// Along the orbit normal: the Sun never comes there in these tests.
const ASIDE: Mount = Mount { star_path_deg: [90.0, 0.0, 0.0] };
const ALONG: Mount = Mount { star_path_deg: [0.0, 90.0, 0.0] };

/// Geostationary, starting `hours` before the satellite is behind the Earth (about: by the Sun's right
/// ascension).
fn geo(hours: f64, mount: Mount) -> Trajectory {
    let sun = sun_km(EQUINOX_US);
    let midnight_deg = libm::atan2(-sun[1], -sun[0]).to_degrees();
    let (r, v) = state_of_elements(
        CentralBody::Earth,
        [42_164.17, 0.0, 0.0, 0.0, 0.0, midnight_deg - 15.0411 * hours],
    )
    .unwrap();
    let orbit = TruthOrbit::new(EQUINOX_US, r, v, 86_400).unwrap();
    Trajectory { orbit, pointing: Pointing::default(), mount, earth: EarthModel::default() }
}

fn leo() -> Trajectory {
    let (r, v) = state_of_elements(CentralBody::Earth, [6828.0, 0.001, 51.6, 60.0, 0.0, 100.0]).unwrap();
    let orbit = TruthOrbit::new(EQUINOX_US, r, v, 6000).unwrap();
    let pointing = Pointing::nadir(69.1, 20.0);
    Trajectory { orbit, pointing, mount: ASIDE, earth: EarthModel::default() }
}

fn camera() -> CameraFile {
    CameraFile { mirrored: true, ..CameraFile::reference() }
}

/// The reference field on an eighth of the pixels a side, for tests of whole frames.
fn small_camera() -> CameraFile {
    CameraFile {
        width_px: 160,
        height_px: 128,
        focal_length_px: 375.0,
        optical_centre_px: [79.5, 63.5],
        ..camera()
    }
}

fn scene(camera: CameraFile, trajectory: Trajectory, stars: &[WorldStar]) -> Scene {
    Scene::new(SceneSettings::new(camera, Motion::orbiting(trajectory), 4), stars).unwrap()
}

/// Runs of equal states, each with its number of seconds, looked at every `step` s.
fn states(trajectory: &Trajectory, seconds: u32, step: usize) -> Vec<(SensorState, u32)> {
    let optics = Optics::new(&camera()).unwrap();
    let mut runs: Vec<(SensorState, u32)> = Vec::new();
    for second in (0..seconds).step_by(step) {
        let state = trajectory.truth(f64::from(second), &optics).state;
        match runs.last_mut() {
            Some((last, length)) if *last == state => *length += step as u32,
            _ => runs.push((state, step as u32)),
        }
    }
    runs
}

#[test]
fn an_equinox_night_in_geo_is_an_eclipse_between_two_blindings() {
    let runs = states(&geo(3.0, ASIDE), 6 * 3600, 10);
    println!("{runs:?}");
    let kinds: Vec<SensorState> = runs.iter().map(|run| run.0).collect();
    use SensorState::{Eclipse, Full, SunInEarthPath};
    assert_eq!(kinds, [Full, SunInEarthPath, Eclipse, SunInEarthPath, Full]);
    // The Sun's disc stays whole behind the Earth while its centre is within asin(R / a) - 0.267 deg: on a
    // chord through the middle 2 * (8.700 - 0.267) / 15.041 h = 67.3 min.
    assert!((runs[2].1 as f64 / 60.0 - 67.3).abs() < 0.7, "{} s", runs[2].1);
    assert!((f64::from(runs[1].1) - f64::from(runs[3].1)).abs() <= 90.0);
    // x is along flight, in the equator: half the field is atan(640 / 3000) = 12.04 deg, and 0.267 deg of the
    // disc.
    let both = f64::from(runs[1].1 + runs[2].1 + runs[3].1) / 3600.0;
    assert!((both - 2.0 * (12.042 + 0.267) / 15.041).abs() < 0.01, "{both} h");
}

#[test]
fn a_star_path_in_the_orbit_plane_is_blinded_too_and_half_way_over_the_earth() {
    let runs = states(&geo(12.0, ALONG), 86_160, 60);
    println!("{runs:?}");
    let kinds: Vec<SensorState> = runs.iter().map(|run| run.0).filter(|s| *s != SensorState::Full).collect();
    use SensorState::{Eclipse, SunInEarthPath, SunInStarPath, SunInStarPathOverEarth};
    let earth = [SunInEarthPath, Eclipse, SunInEarthPath];
    let star = [SunInStarPath, SunInStarPathOverEarth, SunInStarPath];
    assert!(kinds == [earth, star].concat() || kinds == [star, earth].concat(), "{kinds:?}");
}

#[test]
fn the_sun_in_a_path_drives_the_detector_to_full_scale() {
    for (mount, second, state) in [
        (ASIDE, 3 * 3600 + 2700, SensorState::SunInEarthPath),
        (ALONG, 9 * 3600, SensorState::SunInStarPathOverEarth),
    ] {
        let mut scene = scene(small_camera(), geo(3.0, mount), &[]);
        scene.expose_cycle(second, 100_000).unwrap();
        assert_eq!(scene.truth().unwrap().state, state);
        let mut pixels = vec![0; scene.geometry().whole().area()];
        scene.read(scene.geometry().whole(), &mut pixels).unwrap();
        let full = pixels.iter().filter(|v| **v == 1023).count();
        assert!(full * 100 >= pixels.len() * 95, "{full} of {}", pixels.len());
    }
}

#[test]
fn the_veil_fills_the_reference_detector_within_a_tenth_of_a_second() {
    // By hand: 500 W/m² * 7.854e-5 m² / 2.84e-19 J * 0.35 * 1e-4 / 1310720 px.
    let veil = sun::veil_e_s(&EarthModel::default(), &CameraFile::reference().geometry());
    assert!((veil / 3.69e6 - 1.0).abs() < 0.01, "{veil}");
}

#[test]
fn the_truth_agrees_with_itself() {
    let trajectory = leo();
    let optics = Optics::new(&camera()).unwrap();
    for t in [0.0, 777.0, 5999.0] {
        let truth = trajectory.truth(t, &optics);
        let star_path = matrix(truth.quaternion);
        // The star path looks along the normal of the Earth path's y, which here is turned by the roll.
        let expected = product(&trajectory.mount.earth_to_star(), &truth.earth_path);
        for (a, b) in star_path.iter().zip(expected) {
            assert!(angle(*a, b) < 1e-12);
        }
        // The Earth path stands off nadir as asked, and turns once an orbit about the orbit's normal.
        let nadir = times(-1.0, unit(truth.position_km));
        assert!((angle(truth.earth_path[2], nadir).to_degrees() - 69.1).abs() < 1e-9);
        let momentum = cross(truth.position_km, truth.velocity_km_s);
        let turning = times(dot(truth.position_km, truth.position_km).recip(), momentum);
        let expected = apply(&star_path, turning);
        // J2 turns the orbit's plane as well, at up to 1e-3 of that.
        assert!(angle(expected, truth.rate_rad_s) < 3e-3, "{expected:?} {:?}", truth.rate_rad_s);
        assert!((dot(expected, expected) / dot(truth.rate_rad_s, truth.rate_rad_s) - 1.0).abs() < 1e-5);
        assert_eq!(truth.instant_us, EQUINOX_US + (t * 1e6) as i64);
    }
}

#[test]
fn aberration_moves_a_star_towards_the_way_of_flight() {
    let trajectory = geo(6.0, ASIDE);
    let beta = trajectory.aberration(0.0);
    // 29.8 km/s about the Sun (September) and 3.07 about the Earth; the two add up at most to 22.8 arcsec.
    let arcsec = dot(beta, beta).sqrt().to_degrees() * 3600.0;
    assert!((18.0..23.0).contains(&arcsec), "{arcsec}");
    let annual = times(ephemeris::LIGHT_KM_S.recip(), ephemeris::earth_velocity_km_s(EQUINOX_US));
    assert!((dot(annual, annual).sqrt().to_degrees() * 3600.0 - 20.5).abs() < 0.4);
    // On the detector: the star is drawn where its shifted direction projects.
    let towards = matrix(trajectory.quaternion(0.0))[2];
    let star = WorldStar { hip: 1, direction: towards, v: 3.0, b_v: 0.0 };
    let mut scene = scene(camera(), trajectory, &[star]);
    scene.expose(100_000).unwrap();
    let seen = scene.visible_stars()[0];
    let shift_px = libm::hypot(seen.x_px - 639.5, seen.y_px - 511.5);
    let across = dot(beta, beta) - dot(beta, towards).powi(2);
    assert!((shift_px - 3000.0 * across.sqrt()).abs() < 2e-3, "{shift_px}");
}

#[test]
fn a_mirrored_star_path_sees_an_inertial_and_a_tumbling_sky_where_it_must() {
    let aim = Aim { ra_deg: 200.0, dec_deg: 35.0, roll_deg: -50.0 };
    let rate_rad_s = [0.01, -0.02, 0.015];
    let spin = Tumble::new(quaternion(&aim.matrix()), rate_rad_s, [1.0; 3], 100);
    let mount = Mount { star_path_deg: [20.0, 75.0, -40.0] };
    for (law, t) in [(Law::Inertial(aim), 60.0), (Law::Spin(spin), 0.0)] {
        let spins = matches!(law, Law::Spin(_));
        let trajectory = Trajectory { pointing: law.into(), mount, ..geo(3.0, ASIDE) };
        let star_path = product(&mount.earth_to_star(), &aim.matrix());
        // Right and down in the star path's frame: the mirror turns right to left.
        let (beta, towards) =
            (trajectory.aberration(t), unit(apply(&transposed(&star_path), [0.1, 0.05, 1.0])));
        let star = WorldStar { hip: 1, direction: minus(towards, beta), v: 3.0, b_v: 0.0 };
        let mut scene = scene(camera(), trajectory, &[star]);
        scene.expose_cycle(t as u64, 1_000).unwrap();
        let seen = scene.visible_stars()[0];
        let centre = camera().optical_centre_px;
        assert!(
            (seen.x_px - (centre[0] - 300.0)).abs() < 1e-6 && (seen.y_px - (centre[1] + 150.0)).abs() < 1e-6
        );
        let expected = if spins { rate_rad_s } else { [0.0; 3] };
        let body = scene.truth().unwrap().body_rate_rad_s();
        assert!(body.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{body:?}");
    }
}

#[test]
fn a_mirror_turns_the_star_path_over_and_leaves_the_earth_path() {
    let direct = CameraFile::reference();
    let (plain, mirrored) = (Optics::new(&direct).unwrap(), Optics::new(&camera()).unwrap());
    let direction = [0.1, 0.05, 1.0];
    assert_eq!(plain.project(direction), Some([939.5, 661.5]));
    assert_eq!(mirrored.project(direction), Some([339.5, 661.5]));
    assert_eq!(mirrored.earth_path().project(direction), Some([939.5, 661.5]));
    let back = mirrored.unproject([339.5, 661.5]).unwrap();
    assert!(angle(back, direction) < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn any_window_of_earth_and_stars_equals_the_crop_of_the_whole_frame(
        x in 0u16..160, y in 0u16..128, w in 1u16..160, h in 1u16..128, low: bool, cycle in 0u64..5000,
        exposure_us in 2_000u32..500_000,
    ) {
        let window = Window { x, y, width: w.min(160 - x), height: h.min(128 - y) };
        let trajectory = if low { leo() } else { geo(12.0, ASIDE) };
        let cycle = if low { cycle } else { cycle * 17 };
        let star = WorldStar { hip: 1, direction: matrix(trajectory.quaternion(cycle as f64))[2], v: 1.0, b_v: 0.0 };
        let mut scene = scene(small_camera(), trajectory, &[star]);
        scene.expose_cycle(cycle, exposure_us).unwrap();
        let geometry = scene.geometry();
        let mut part = vec![0; window.area()];
        scene.read(window, &mut part).unwrap();
        let mut whole = vec![0; geometry.whole().area()];
        scene.read(geometry.whole(), &mut whole).unwrap();
        let mut crop = vec![0; window.area()];
        crate::formats::picture::copy_window(&whole, &geometry, window, &mut crop);
        prop_assert_eq!(part, crop);
    }
}

#[test]
fn the_earth_models_values_are_checked() {
    let mut trajectory = geo(1.0, ASIDE);
    trajectory.earth.scale_height_km = 0.0;
    let settings = SceneSettings::new(camera(), Motion::orbiting(trajectory), 4);
    assert_eq!(Scene::new(settings, &[]).err(), Some(crate::world::scene::SceneError::Earth));
}

#[test]
fn an_exposure_sees_the_means_over_it() {
    let aim = Aim { ra_deg: 40.0, dec_deg: -10.0, roll_deg: 5.0 };
    // Even turning: attitude and rate are those of the middle.
    assert!(leo().mean_over(100.0, 0.4).is_none());
    let rate_rad_s = [0.05, 0.02, -0.07];
    let mut trajectory = leo();
    trajectory.pointing.law = Law::Spin(Tumble::new(quaternion(&aim.matrix()), rate_rad_s, [1.0; 3], 100));
    let (attitude, rate) = trajectory.mean_over(60.0, 0.4).unwrap();
    let apart =
        |a: [f64; 4], b: [f64; 4]| 2.0 * (1.0 - a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().abs());
    assert!(apart(attitude, trajectory.quaternion(60.0)) < 1e-15);
    assert!(length(minus(rate, trajectory.rate_rad_s(60.0))) < 1e-9);
    // Whole periods of a shaking leave what it shakes, in attitude and in rate.
    let mut still = leo();
    still.pointing.law = Law::Inertial(aim);
    let line = Line { frequency_hz: 10.0, amplitude_arcsec: [20.0, 30.0, 10.0] };
    let model = JitterModel { random_arcsec: [0.0; 3], correlation_s: 1.0, lines: vec![line] };
    let mut shaken = still.clone();
    shaken.pointing.jitter = Jitter::new(&model, 7);
    let (attitude, rate) = shaken.mean_over(60.0, 0.4).unwrap();
    let arcsec = |square: f64| 2.0 * libm::sqrt(square) * 206_265.0;
    let away = |t: f64| arcsec(apart(shaken.quaternion(t), still.quaternion(60.0)));
    assert!((0..10).any(|step| away(60.0 + 0.01 * f64::from(step)) > 10.0));
    assert!(arcsec(apart(attitude, still.quaternion(60.0))) < 0.5 && length(rate) < 1e-6);
}

/// A star whose light is measured frame by frame beside where the attitude of the exposure has it, px.
fn departures(trajectory: Trajectory, towards: Vector) -> Vec<[f64; 2]> {
    let star = WorldStar { hip: 1, direction: towards, v: 2.0, b_v: 0.0 };
    let mut settings = SceneSettings::new(small_camera(), Motion::orbiting(trajectory), 4);
    settings.detector.dark_e_s = 0.0;
    settings.detector.read_noise_e = 0.0;
    settings.detector.pedestal = 0.0;
    let optics = Optics::new(&small_camera()).unwrap();
    let mut scene = Scene::new(settings.clone(), &[star]).unwrap();
    let mut departures = Vec::new();
    for cycle in 0..12 {
        scene.expose(400_000).unwrap();
        let mut pixels = vec![0; scene.geometry().whole().area()];
        scene.read(scene.geometry().whole(), &mut pixels).unwrap();
        let seen = plus(towards, 1.0, settings.motion.aberration(cycle as f64));
        let attitude = scene.seen_at(cycle).unwrap().quaternion;
        let place = optics.project(apply(&matrix(attitude), seen));
        let inside = |[x, y]: [f64; 2]| (50.0..110.0).contains(&x) && (40.0..90.0).contains(&y);
        let Some([x, y]) = place.filter(|place| inside(*place)) else { continue };
        let (left, top) = (x as usize - 20, y as usize - 20);
        let near =
            |at: usize| (left..left + 41).contains(&(at % 160)) && (top..top + 41).contains(&(at / 160));
        let counts = |inside: bool| {
            (0..pixels.len()).filter(move |at| near(*at) == inside).map(|at| (at, f64::from(pixels[at])))
        };
        let sky = counts(false).map(|(_, value)| value).sum::<f64>() / counts(false).count() as f64;
        let light: f64 = counts(true).map(|(_, value)| value - sky).sum();
        let moment = |place: fn(usize) -> usize| {
            counts(true).map(|(at, value)| place(at) as f64 * (value - sky)).sum::<f64>() / light
        };
        departures.push([moment(|at| at % 160) - x, moment(|at| at / 160) - y]);
    }
    departures
}

#[test]
fn a_star_is_drawn_about_where_the_attitude_of_the_exposure_has_it() {
    let aim = Aim { ra_deg: 40.0, dec_deg: 60.0, roll_deg: 5.0 };
    let mut still = geo(6.0, ASIDE);
    still.pointing.law = Law::Inertial(aim);
    // Three periods an exposure: begin, middle and end are alike.
    let line = Line { frequency_hz: 7.5, amplitude_arcsec: [1500.0, 900.0, 0.0] };
    let model = JitterModel { random_arcsec: [600.0; 3], correlation_s: 0.3, lines: vec![line] };
    let mut shaken = still.clone();
    shaken.pointing.jitter = Jitter::new(&model, 7);
    // 2 deg, 13 px, in the last 0.4 s.
    let mut slewed = still.clone();
    let axis = [0.6, 0.8, 0.0];
    slewed.pointing.slews.push(Slew { start_s: 3.2, duration_s: 2.0, axis, angle_rad: -0.6 });
    for (trajectory, at_least) in [(shaken, 12), (slewed, 6)] {
        let towards = matrix(trajectory.quaternion(11.0))[2];
        let departures = departures(trajectory, towards);
        assert!(departures.len() >= at_least, "{}", departures.len());
        let worst = departures.iter().flatten().fold(0.0f64, |worst, px| worst.max(px.abs()));
        assert!(worst < 0.05, "{departures:?}");
    }
}
