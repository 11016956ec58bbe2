use super::*;
use crate::camera::CameraParameters;
use crate::earth::limb::{crossing, strip};
use crate::earth::test_world::{
    A_KM, GEOMETRY, World, camera, error_px, even, geostationary, low, parameters, through_a_dark_lens,
};
use crate::oracle::Generator;
use nalgebra::Vector3;
use std::vec::Vec;

fn point(brightness: f32) -> LimbPoint {
    LimbPoint {
        centre_px: [639.5, 511.5],
        sigma_px: 0.1,
        outward_px: [0.6, -0.8],
        ground: Ground { brightness, lever_px: if brightness > 0.0 { 8.0 } else { 0.0 } },
    }
}

/// How far outward a point stands, px.
fn outward_px(point: &LimbPoint) -> f32 {
    0.6 * (point.centre_px[0] - 639.5) - 0.8 * (point.centre_px[1] - 511.5)
}

/// Points of these brightnesses after a second.
fn corrected(usual: &mut UsualGround, brightnesses: &[f32]) -> Vec<f32> {
    let mut points: Vec<LimbPoint> = brightnesses.iter().copied().map(point).collect();
    usual.correct(&mut points, &camera(), &parameters().limb);
    points.iter().map(outward_px).collect()
}

#[test]
fn points_over_bright_ground_move_outward_and_those_over_dark_ground_inward() {
    let share = parameters().limb.ground_share;
    let mut usual = UsualGround::default();
    let moved = corrected(&mut usual, &[100.0, 300.0, 200.0, 0.0]);
    // Usual is 200: half and one and a half of it, and a point that was not measured.
    for (moved, of_usual) in moved.into_iter().zip([-0.5, 0.5, 0.0, 0.0]) {
        assert!((moved - share * of_usual * 8.0).abs() < 1e-4, "{moved}, {of_usual}");
    }
}

#[test]
fn usual_is_the_mean_of_what_was_seen_and_follows_it_within_hours() {
    let mut usual = UsualGround::default();
    for second in 0..4 {
        corrected(&mut usual, &[100.0 + 20.0 * second as f32]);
    }
    assert!((usual.brightness - 130.0).abs() < 1e-3);
    // The lens loses half of its light: after six hours 63 % of that are taken in.
    let mut usual = UsualGround { brightness: 200.0, seconds: LONGEST_S };
    for _ in 0..LONGEST_S as u32 {
        corrected(&mut usual, &[100.0]);
    }
    assert!((usual.brightness - (100.0 + 100.0 * libm::expf(-1.0))).abs() < 0.5, "{}", usual.brightness);
    let before = usual;
    assert_eq!(corrected(&mut usual, &[0.0]), [0.0]);
    assert_eq!(usual, before, "a second without a measured point");
}

#[test]
fn the_brightest_cloud_moves_a_point_by_its_share_at_most() {
    let mut usual = UsualGround { brightness: 100.0, seconds: 1000.0 };
    let moved = corrected(&mut usual, &[1e6]);
    assert!(moved[0] < parameters().limb.ground_share * MOST * 8.0 + 1e-3);
}

/// A camera whose lens is that of [`through_a_dark_lens`].
fn dark_camera() -> Camera {
    Camera::new(CameraParameters { corner_loss: 0.5, ..*camera().parameters() }).unwrap()
}

/// Errors across the limb of the points of a world that stands where it is expected, seen through a dark
/// lens, px: as found, and corrected for a lens such as `told`.
fn errors_px(world: &World, usual: &mut UsualGround, told: &Camera) -> Vec<[f64; 2]> {
    let parameters = parameters();
    let (mut found, mut expected) = (Vec::new(), Vec::new());
    for (index, truth) in world.expected().into_iter().enumerate() {
        let Some(strip) = strip(&truth, even(64), &GEOMETRY) else { continue };
        let mut pixels = world.expose(strip.window, 1.0, index as u64);
        through_a_dark_lens(&mut pixels, &strip.window);
        let Some(seen) = crossing(&pixels, &strip, &GEOMETRY, &parameters) else { continue };
        found.push(seen.point);
        expected.push(truth);
    }
    let mut moved = found.clone();
    usual.correct(&mut moved, told, &parameters.limb);
    let both = found.iter().zip(&moved).zip(&expected);
    both.map(|((one, other), truth)| [one, other].map(|point| error_px(point, truth))).collect()
}

/// Clouds of all sizes from 60 to 3000 km: other ones over the ground before the limb than at the limb.
fn clouds(seed: u64) -> Vec<(Vector3<f64>, f64)> {
    let mut generator = Generator::new(1000 + seed);
    let mut wave = || {
        let length_km = 60.0 * libm::pow(50.0, generator.between(0.0, 1.0));
        let wave = generator.unit() * (std::f64::consts::TAU * A_KM / length_km);
        (wave, generator.between(0.0, std::f64::consts::TAU))
    };
    (0..8).map(|_| wave()).collect()
}

#[test]
fn clouds_move_a_limb_less_when_their_brightness_is_taken_off() {
    for (name, world) in [
        ("450 km", (|seed| low(450.0, 90.0, [40.0, 30.0], seed)) as fn(u64) -> World),
        ("geostationary", |seed| geostationary(60.0, seed)),
    ] {
        let mut usual = UsualGround::default();
        let clouds = |seed| World { albedo: [0.4, 0.8], waves: clouds(seed), ..world(seed) };
        // What is usual is known before.
        for seed in 100..140 {
            errors_px(&clouds(seed), &mut usual, &dark_camera());
        }
        let errors: Vec<[f64; 2]> =
            (0..40).flat_map(|seed| errors_px(&clouds(seed), &mut usual, &dark_camera())).collect();
        // A few edges are those of clouds: medians.
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        let [before, after] = [0, 1].map(|k| {
            let middle = median(errors.iter().map(|error| error[k]).collect());
            median(errors.iter().map(|error| (error[k] - middle).abs()).collect())
        });
        std::println!(
            "{name}: {} points, {before:.3} px off in the median, {after:.3} corrected",
            errors.len()
        );
        assert!(errors.len() > 1000 && after < 0.97 * before);
    }
}

#[test]
fn a_lens_that_dims_the_corner_bends_no_limb() {
    // Ground as bright everywhere, which nothing but the lens darkens: the middle of the limb against its ends.
    let world = World { albedo: [0.6, 0.6], ..low(450.0, 60.0, [40.0, 30.0], 1) };
    let bend_px = |told: &Camera| {
        let errors = errors_px(&world, &mut UsualGround::default(), told);
        let moves: Vec<f64> = errors.iter().map(|[found, corrected]| corrected - found).collect();
        let (least, most) =
            moves.iter().fold((f64::MAX, f64::MIN), |(low, high), &m| (low.min(m), high.max(m)));
        assert!(moves.len() > 10, "{} points", moves.len());
        most - least
    };
    let open = Camera::new(CameraParameters { corner_loss: 0.0, ..*camera().parameters() }).unwrap();
    let [told, untold] = [dark_camera(), open].map(|told| bend_px(&told));
    std::println!("bent by {told:.3} px, {untold:.3} with the lens untold");
    assert!(told < 0.2 * untold);
}
