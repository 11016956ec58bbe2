use super::*;
use crate::earth::Strips;
use crate::earth::limb_sensor::{self, Buffers, LimbSensor};
use crate::earth::search::Points;
use crate::earth::test_world::{World, camera, geostationary, low, parameters};
use crate::oracle::Generator;
use std::boxed::Box;

/// Truth: the world's lens has 3000 px. What a camera says whose focal length is wrong by a share, from a
/// picture of the world.
fn found(world: &World, wrong: f32) -> Scale {
    let mut parameters = parameters();
    parameters.limb.height_sigma_km = 1.6;
    let mut described = *camera().parameters();
    described.focal_length_px *= 1.0 + wrong;
    let (camera, body) = (Camera::new(described).unwrap(), world.body(&parameters));
    let limb_sensor = LimbSensor { camera: &camera, body: &body, parameters: &parameters, turn: None };
    let (mut points, mut rays) = (Points::new(), Box::new(RayBuffer::new()));
    let mut buffers = Buffers { buffer: &mut [0; 2048], points: &mut points, rays: &mut rays };
    let fix =
        limb_sensor::acquire(&limb_sensor, &mut world.picture(1.0, 3), &mut buffers).unwrap().fix.unwrap();
    let strips = Strips { read: fix.inliers.count_ones() as usize, skipped: 0, km_per_px: f32::INFINITY };
    let (criteria, prior) = (parameters.strip_criteria(&strips, true), CentrePrior::from_fix(&fix));
    let measured = LimbPoints {
        points: &points,
        camera: &camera,
        body: &body,
        criteria: &criteria,
        prior: prior.as_ref(),
        parameters: &parameters,
    };
    Scale::by_the_earth(&measured, [world.centre.norm() as f32, 1.0], &mut rays).unwrap()
}

#[test]
fn the_earth_of_a_known_distance_shows_a_wrong_focal_length() {
    for (name, world) in [
        ("geostationary, full", geostationary(20.0, 3)),
        ("geostationary, half", geostationary(90.0, 4)),
        ("5000 km, slant", low(5_000.0, 40.0, [40.0, 30.0], 5)),
    ] {
        for wrong in [0.0, 0.005, -0.003] {
            let scale = found(&world, wrong);
            // The lens is shorter than the camera says.
            let truth = 1.0 / (1.0 + wrong) - 1.0;
            std::println!("{name}: {:+.5} for {truth:+.5}, sigma {:.5}", scale.share, scale.sigma);
            assert!((scale.share - truth).abs() < 3.0 * scale.sigma, "{name}");
        }
    }
}

#[test]
fn stars_show_a_stretch_whatever_shift_and_turn_the_attitude_left() {
    let mut generator = Generator::new(35);
    let (sigma, share) = (0.05, 4e-4);
    let (mut squares, runs) = (0.0, 400);
    for _ in 0..runs {
        let stars: [_; 10] = core::array::from_fn(|_| {
            let [x, y] = [generator.between(0.0, 1279.0), generator.between(0.0, 1023.0)];
            let (turn, noise) = (2e-4, generator.gaussian_vector() * sigma);
            let seen = [
                x + share * (x - 640.0) - turn * y + 3.0 + noise.x,
                y + share * (y - 500.0) + turn * x - 2.0 + noise.y,
            ];
            ([x as f32, y as f32], seen.map(|at| at as f32))
        });
        let scale = Scale::by_stars(&stars, sigma as f32).unwrap();
        squares += f64::from((scale.share - share as f32) / scale.sigma).powi(2);
        assert!(scale.sigma < 8e-5, "{scale:?}");
    }
    // Mean of 400 squares: 1 +- 0.071, three sigma.
    let mean = squares / f64::from(runs);
    assert!((mean - 1.0).abs() < 0.22, "{mean}");
    assert!(Scale::by_stars(&[([0.0; 2], [0.0; 2]); 2], 0.05).is_none());
}

#[test]
fn two_scales_are_apart_by_sigmas_of_their_difference() {
    let [earth, stars] = [Scale { share: 2e-3, sigma: 3e-4 }, Scale { share: 5e-4, sigma: 4e-4 }];
    assert!((earth.apart(&stars) - 3.0).abs() < 1e-4 && (stars.apart(&earth) + 3.0).abs() < 1e-4);
}
