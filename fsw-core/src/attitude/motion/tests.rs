use super::*;
use crate::oracle::Generator;

const ARCSEC: f32 = 1.0 / 206_264.8;
const SIGMA: [f32; 3] = [1.0 * ARCSEC, 1.0 * ARCSEC, 6.0 * ARCSEC];

fn start() -> Rotation<Icrs, StarPath> {
    Rotation::from_quaternion([0.5, -0.4, 0.3, 0.6]).unwrap()
}

/// Seconds of a sensor turning at `rate`, observed with white errors.
fn observed(
    rate: &Vector3<f32>,
    seconds: u32,
    generator: &mut Generator,
) -> (Motion, Rotation<Icrs, StarPath>) {
    let mut truth = start();
    let noisy = |truth: &Rotation<Icrs, StarPath>, generator: &mut Generator| {
        let error = Vector3::from(SIGMA.map(|sigma| sigma * generator.gaussian() as f32));
        truth.turned(&error)
    };
    let mut motion = Motion::begin(noisy(&truth, generator), SIGMA, 0);
    for cycle in 1..=seconds {
        truth = truth.turned(rate);
        motion.observe(noisy(&truth, generator), SIGMA, cycle);
    }
    (motion, truth)
}

#[test]
fn one_attitude_gives_no_rate_and_no_prediction() {
    let motion = Motion::begin(start(), SIGMA, 7);
    assert!(motion.rate().is_none() && motion.at(8).is_none());
}

#[test]
fn the_attitude_is_carried_for_twenty_minutes_within_its_sigma() {
    // 200 flights, orbital rate, blind for 1200 s: mean normalised square of the error. The sigma is an upper bound (white
    // differences), so it must lie below 1.3 and the error must not be absurdly small either.
    let mut generator = Generator::new(31);
    let mut sum = 0.0;
    for _ in 0..200 {
        let rate = Vector3::new(0.0, 1.1e-3, 2e-4);
        let (mut motion, mut truth) = observed(&rate, 60, &mut generator);
        for cycle in 61..=1260 {
            truth = truth.turned(&rate);
            motion.carry(cycle);
        }
        let (carried, sigma) = motion.at(1260).unwrap();
        let error = carried.angle_from(&truth);
        sum += (0..3).map(|axis| (error[axis] / sigma[axis]).powi(2)).sum::<f32>() / 600.0;
    }
    std::println!("mean normalised square error after 1200 s blind: {sum:.3}");
    assert!((0.005..1.3).contains(&sum), "{sum}");
}

#[test]
fn a_gap_does_not_spoil_the_rate() {
    let rate = Vector3::new(1e-4, -5e-4, 3e-4);
    let (mut motion, truth) = observed(&rate, 40, &mut Generator::new(5));
    let before = motion.rate().unwrap().rad_s;
    motion.observe(truth.turned(&(rate * 500.0)), SIGMA, 540);
    assert_eq!(motion.rate().unwrap().rad_s, before);
    assert!((before - rate).norm() < 3.0 * ARCSEC);
}

#[test]
fn a_turn_too_far_is_not_predicted() {
    let (motion, _) = observed(&Vector3::new(0.0, 0.01, 0.0), 5, &mut Generator::new(9));
    assert!(motion.at(100).is_some() && motion.at(5 + 200).is_none());
}
