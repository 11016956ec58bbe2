use super::*;
use crate::harness::truth_of;
use crate::scenario::Scenario;
use crate::world::earth::albedo::Albedo;
use crate::world::earth::horizon::Horizon;
use crate::world::noise::{Noise, Stream};
use crate::world::scene::Scene;
use nalgebra::{DMatrix, DVector};

/// Three Sun-synchronous orbits.
fn flight() -> (Scenario, Scene) {
    let scenario = Scenario::named(Some("sso-noon-midnight".as_ref())).unwrap();
    let scene = scenario.scene().unwrap();
    (scenario, scene)
}

/// The bound after steps, and all heights of the blocks until then.
fn flown(steps: u32) -> (PositionBound, Vec<Height>, Heights) {
    let (scenario, scene) = flight();
    let mut bound = PositionBound::new(&scenario.earth);
    let mut all = Vec::new();
    for step in 0..steps {
        let truth = truth_of(&scene, step * STEP_S as u32).unwrap();
        let next_us = bound.next_us;
        bound.add(&truth, scene.optics());
        if bound.next_us > next_us {
            let lasts_s = block_s(&truth, PATCH_KM);
            all.extend(bound.heights(&truth, scene.optics(), EDGE_KM * EDGE_KM * EDGE_S / lasts_s));
        }
    }
    (bound, all, Heights::of(&scenario.earth))
}

/// Covariance of heights, all with all, km², and their rows.
fn whole(all: &[Height], heights: &Heights) -> (DMatrix<f64>, DMatrix<f64>) {
    let apart = |i: usize, j: usize| length(plus(all[i].place_km, -1.0, all[j].place_km));
    let covariance = DMatrix::from_fn(all.len(), all.len(), |i, j| {
        heights.covariance_km2(apart(i, j)) + if i == j { all[i].own_km2 } else { 0.0 }
    });
    (covariance, DMatrix::from_fn(all.len(), 6, |i, column| all[i].row[column]))
}

fn information(covariance: DMatrix<f64>, rows: &DMatrix<f64>) -> Matrix6<f64> {
    let all = rows.tr_mul(&covariance.cholesky().unwrap().solve(rows));
    Matrix6::from_fn(|row, column| all[(row, column)])
}

/// Sigmas of the state at the start.
fn sigmas(information: &Matrix6<f64>) -> [f64; 6] {
    let known = covariance(information).unwrap();
    std::array::from_fn(|state| known[(state, state)].sqrt())
}

#[test]
fn height_by_height_is_all_at_once() {
    let close = |steps: u32, tolerance: f64| {
        let (bound, all, heights) = flown(steps);
        let (whole, rows) = whole(&all, &heights);
        let [ours, theirs] = [bound.information, information(whole, &rows)].map(|of| sigmas(&of));
        println!("{} heights: {ours:.3?}, all at once {theirs:.3?}", all.len());
        for (ours, theirs) in ours.iter().zip(theirs) {
            assert!((ours / theirs - 1.0).abs() < tolerance, "{ours} {theirs}");
        }
        all.len()
    };
    // An orbit: every height is compared with all before it. Three: the last with two orbits.
    assert!(close(202, 0.01) < WINDOW);
    assert!(close(605, 0.05) > WINDOW);
}

#[test]
fn the_best_estimate_in_the_worlds_own_fields_is_as_good_as_the_bound() {
    let (scenario, _) = flight();
    let (_, all, heights) = flown(202);
    let (whole, rows) = whole(&all, &heights);
    let known = information(whole.clone(), &rows);
    let factor = whole.cholesky().unwrap();
    let weights = factor.solve(&rows);
    let model = scenario.earth;
    let mut square = 0.0;
    let seeds = 60;
    for seed in 0..seeds {
        let clouds = Albedo::new(seed, model.mean_albedo, model.cloud_contrast);
        let field = Horizon::new(model.horizon, seed, model.height_variation_km, false, &clouds);
        let noise = Noise::new(seed, 0, Stream::Jitter);
        let seen = DVector::from_fn(all.len(), |index, _| {
            let Height { place_km, own_km2, .. } = all[index];
            let place = times(length(place_km).recip(), place_km);
            field.height_km(place, 0.0) + own_km2.sqrt() * noise.gaussian(index as u32, 0)
        });
        // J⁻¹ Aᵀ C⁻¹ h is off by what was measured of no displacement; its normalised square is that times J.
        let right = weights.tr_mul(&seen);
        let error = covariance(&known).unwrap() * nalgebra::Vector6::from_fn(|row, _| right[row]);
        square += error.dot(&(known * error)) / 6.0;
    }
    square /= seeds as f64;
    println!("normalised error squared {square:.2} of 1, {} heights", all.len());
    // 99 % of a chi-square of 360 degrees of freedom over its mean.
    assert!((0.82..1.20).contains(&square), "{square}");
}

#[test]
fn a_state_from_the_ground_is_the_bound_before_any_limb_and_makes_it_better_afterwards() {
    let (scenario, scene) = flight();
    let bounds =
        [PositionBound::new(&scenario.earth), PositionBound::new(&scenario.earth).knowing(50.0, 20.0)];
    let flown = bounds.map(|mut bound| {
        let mut sigma = |step: u32| {
            let truth = truth_of(&scene, step * STEP_S as u32).unwrap();
            bound.add(&truth, scene.optics()).map_or(f64::INFINITY, |[r, a, c]| r.hypot(a).hypot(c))
        };
        (0..40).map(&mut sigma).collect::<Vec<f64>>()
    });
    let [without, with] = &flown;
    assert!(with[0] <= 50.0 * 3.0_f64.sqrt() + 1e-9);
    assert!(without.iter().zip(with).all(|(without, with)| with < without));
    // Without any limb it is that of the start alone.
    let blind = covariance(&PositionBound::new(&scenario.earth).knowing(50.0, 20.0).information).unwrap();
    for (axis, sigma) in [50.0, 50.0, 50.0, 0.02, 0.02, 0.02].into_iter().enumerate() {
        assert!((blind[(axis, axis)].sqrt() / sigma - 1.0).abs() < 1e-9, "{axis}");
    }
}
