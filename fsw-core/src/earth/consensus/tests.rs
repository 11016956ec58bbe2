use super::*;
use crate::earth::LimbPoint;
use crate::earth::rays;
use crate::earth::test_world::{camera, geostationary, parameters};
use crate::oracle::{self, Generator};
use std::vec::Vec;

/// Points of a circle like the disc's, the first `wrong` of them anywhere, well mixed.
fn points(count: usize, wrong: usize, seed: u64) -> (Vec<LimbPoint>, Vec<bool>) {
    let world = geostationary(0.0, 1);
    let [mx, my] = oracle::project(&oracle::reference_camera(), &world.centre.normalize());
    let mut generator = Generator::new(seed);
    (0..count)
        .map(|index| {
            let is_wrong = index * 7919 % count < wrong;
            let azimuth = generator.between(0.0, std::f64::consts::TAU);
            let ray = world.limb(azimuth, f64::from(parameters().limb.height_km));
            let mut at = oracle::project(&oracle::reference_camera(), &ray);
            if is_wrong {
                at = [generator.between(0.0, 1279.0), generator.between(0.0, 1023.0)];
            }
            let length = (at[0] - mx).hypot(at[1] - my);
            let outward = [(at[0] - mx) / length, (at[1] - my) / length];
            let noise = 0.3 * generator.gaussian();
            let point = LimbPoint::new(
                [(at[0] + noise * outward[0]) as f32, (at[1] + noise * outward[1]) as f32],
                0.3,
                outward.map(|part| part as f32),
            );
            (point, is_wrong)
        })
        .unzip()
}

/// A third of 40 points.
const CRITERIA: FitCriteria = FitCriteria { tolerance_px: 2.0, min_inliers: 13, standalone: true };

#[test]
fn a_body_is_found_with_forty_percent_of_the_points_wrong() {
    let world = geostationary(0.0, 1);
    let body = world.body(&parameters());
    let mut missed = 0;
    for seed in 0..200 {
        let (points, wrong) = points(60, 24, seed);
        let mut rays = Rays::new();
        rays::fill(&mut rays, &points, &camera(), &body);
        let Ok(_) = find_consensus(&mut rays, &body, &CRITERIA, &parameters()) else {
            missed += 1;
            continue;
        };
        let taken_in = rays.iter().filter(|ray| wrong[usize::from(ray.index)]).count();
        assert!(rays.len() >= 33 && taken_in <= 3, "seed {seed}: {} rays, {taken_in} wrong", rays.len());
    }
    std::println!("missed {missed} of 200");
    assert!(missed <= 2);
}

#[test]
fn points_without_a_body_are_refused() {
    let world = geostationary(0.0, 1);
    let body = world.body(&parameters());
    for seed in 0..200 {
        let (points, _) = points(40, 40, seed);
        let mut rays = Rays::new();
        rays::fill(&mut rays, &points, &camera(), &body);
        assert!(find_consensus(&mut rays, &body, &CRITERIA, &parameters()).is_err(), "seed {seed}");
    }
}

#[test]
fn a_limb_on_the_night_side_is_no_limb() {
    let mut world = geostationary(0.0, 1);
    let (points, _) = points(40, 0, 1);
    let mut rays = Rays::new();
    let body = world.body(&parameters());
    rays::fill(&mut rays, &points, &camera(), &body);
    assert!(find_consensus(&mut rays, &body, &CRITERIA, &parameters()).is_ok());
    world.sun = world.centre.normalize();
    let night = world.body(&parameters());
    rays::fill(&mut rays, &points, &camera(), &night);
    assert_eq!(
        find_consensus(&mut rays, &night, &CRITERIA, &parameters()).err(),
        Some(FitError::NoConsensus)
    );
}
