//! Behaviour at the doors here; accuracy and consistency in `campaign`.

use super::*;
use crate::orbit::reference::circular;

fn good_fix(state: &OrbitState) -> PositionFix {
    let position_km = state.position_km;
    PositionFix { position_km, covariance_km2: Matrix3::identity() * 25.0, place_km: position_km }
}

/// A filter that has followed a low orbit for ten minutes without noise, and the true state.
fn running(parameters: &OrbitParameters) -> (OrbitFilter, OrbitState) {
    let mut filter = OrbitFilter::new();
    let mut truth = circular(7_000.0, 51.0);
    assert_eq!(
        filter.update(truth.time_us, &good_fix(&truth), &Matrix3::identity(), parameters),
        Update::Started
    );
    for _ in 0..600 {
        truth = parameters.dynamics.propagate(&truth, 1_000_000).unwrap();
        let update = filter.update(truth.time_us, &good_fix(&truth), &Matrix3::identity(), parameters);
        assert!(matches!(update, Update::Accepted { .. }), "{update:?}");
    }
    (filter, truth)
}

#[test]
fn a_fix_far_off_is_rejected_and_many_start_the_filter_anew() {
    let parameters = OrbitParameters { patience: 4, ..OrbitParameters::default() };
    let (mut filter, truth) = running(&parameters);
    let mut wrong = good_fix(&truth);
    wrong.position_km.y += 500.0;
    for second in 1..=4 {
        let time = truth.time_us + second * 1_000_000;
        let update = filter.update(time, &wrong, &Matrix3::identity(), &parameters);
        if second < 4 {
            assert!(matches!(update, Update::Rejected { nis } if nis > 30.0), "{update:?}");
            assert_eq!(i64::from(filter.rejections()), second);
        } else {
            assert_eq!(update, Update::Restarted);
            assert_eq!(filter.state().unwrap().position_km, wrong.position_km);
        }
    }
}

#[test]
fn what_is_no_fix_is_refused_and_changes_nothing() {
    let parameters = OrbitParameters::default();
    let (mut filter, truth) = running(&parameters);
    let before = *filter.state().unwrap();
    let good = good_fix(&truth);
    let mut refuse = |fix: PositionFix, rotation: Matrix3<f64>, why| {
        assert_eq!(filter.update(truth.time_us, &fix, &rotation, &parameters), Update::Refused(why));
        assert_eq!(*filter.state().unwrap(), before);
    };
    let identity = Matrix3::identity();
    for x in [f64::NAN, f64::INFINITY, 1e7] {
        refuse(PositionFix { position_km: Vector3::new(x, 0.0, 0.0), ..good }, identity, Refusal::Impossible);
    }
    refuse(PositionFix { position_km: Vector3::zeros(), ..good }, identity, Refusal::Impossible);
    refuse(good, identity * f64::NAN, Refusal::Impossible);
    for covariance in [identity * f64::NAN, Matrix3::zeros(), -identity, Matrix3::from_element(1.0)] {
        refuse(PositionFix { covariance_km2: covariance, ..good }, identity, Refusal::Covariance);
    }
}

#[test]
fn an_outage_of_two_hours_is_crossed_and_more_is_not() {
    let parameters = OrbitParameters::default();
    let (mut filter, truth) = running(&parameters);
    let before = filter.position_sigma_km().unwrap();
    let mut jumped = filter;
    jumped.advance(truth.time_us + MAX_GAP_US, &parameters).unwrap();
    for second in (0..7_200).map(|second| second + 1) {
        filter.advance(truth.time_us + second * 1_000_000, &parameters).unwrap();
    }
    // In one jump or second by second: the same orbit and nearly the same doubt.
    let apart = (filter.state().unwrap().position_km - jumped.state().unwrap().position_km).norm();
    assert!(apart < 0.05, "{apart}");
    for ((slow, fast), before) in
        filter.position_sigma_km().unwrap().iter().zip(jumped.position_sigma_km().unwrap()).zip(before)
    {
        assert!((slow / fast - 1.0).abs() < 0.1, "{slow} {fast}");
        assert!(*slow > before);
    }
    assert_eq!(jumped.advance(truth.time_us + 2 * MAX_GAP_US + 1, &parameters), Err(Lost::TooLong));
    assert!(jumped.state().is_none() && !jumped.settled());
    assert_eq!(filter.advance(truth.time_us, &parameters), Err(Lost::Backwards));
    assert!(filter.state().is_none());
    let (mut filter, _) = running(&parameters);
    assert_eq!(filter.advance(i64::MIN, &parameters), Err(Lost::TooLong));
}

#[test]
fn an_orbit_into_the_earth_is_forgotten() {
    let parameters = OrbitParameters::default();
    let mut filter = OrbitFilter::new();
    assert_eq!(filter.advance(5, &parameters), Ok(()));
    let falling = OrbitState { velocity_km_s: Vector3::zeros(), ..circular(7_000.0, 0.0) };
    assert!(filter.start(falling, 1.0, 1.0, &parameters));
    assert_eq!(filter.advance(falling.time_us + MAX_GAP_US, &parameters), Err(Lost::Diverged));
    assert!(!filter.start(falling, f64::NAN, 1.0, &parameters));
    assert!(!filter.start(OrbitState { position_km: Vector3::zeros(), ..falling }, 1.0, 1.0, &parameters));
}

/// Thesis §5.2: a geostationary radius wrong by 1 to some tens of Earth radii at the start.
#[test]
fn a_start_many_earth_radii_off_converges() {
    for observation in [Observation::Position, Observation::Combined, Observation::UnitVector] {
        // Neither noise nor bias: convergence alone is at stake.
        let parameters = OrbitParameters {
            observation,
            misalignment_sigma_rad: 0.0,
            bias_over_noise: 0.0,
            ..OrbitParameters::default()
        };
        // Without any distance the linearised filter converges from three radii; ten leave 50 km after 18 hours.
        let directions = observation == Observation::UnitVector;
        let radii: &[f64] = if directions { &[1.0, 3.0] } else { &[1.0, 3.0, 10.0, 50.0] };
        for radii in radii {
            let mut truth = circular(42_164.0, 0.1);
            let mut filter = OrbitFilter::new();
            let off = radii * EARTH_RADIUS_KM;
            let wrong = OrbitState { position_km: truth.position_km * (1.0 + off / 42_164.0), ..truth };
            assert!(filter.start(wrong, off, 3.0, &parameters));
            // 0.02 deg across, 100 km along, a fix in 20 s, for 18 hours.
            let mut restarted = 0;
            for _ in 0..3_240 {
                truth = parameters.dynamics.propagate(&truth, 20_000_000).unwrap();
                let along =
                    truth.position_km * truth.position_km.transpose() / truth.position_km.norm_squared();
                let covariance_km2 = Matrix3::identity() * 216.0 + along * 1e4;
                let position_km = truth.position_km;
                let fix = PositionFix { position_km, covariance_km2, place_km: position_km };
                let update = filter.update(truth.time_us, &fix, &Matrix3::identity(), &parameters);
                restarted += u32::from(matches!(update, Update::Restarted | Update::Started));
            }
            let apart = (filter.state().unwrap().position_km - truth.position_km).norm();
            std::println!(
                "{observation:?} from {radii} radii off: {apart:.2} km after 18 h, {restarted} restarts"
            );
            assert!(apart < 5.0, "{observation:?} {radii}: {apart}");
        }
    }
}

#[test]
fn the_defaults_are_within_their_ranges() {
    for (name, value, low, high) in OrbitParameters::default().ranges() {
        assert!((low..=high).contains(&value), "{name}");
    }
}
