use super::*;
use crate::harness;
use crate::scenario::{Believed, EMBEDDED, Scenario};
use std::path::Path;

fn parsed(lines: &str) -> Result<Scenario, HostError> {
    let text = EMBEDDED[0].1.replace("duration_s = 21600", "duration_s = 10");
    Scenario::parse(Path::new("some.toml"), &text.replacen("[mount]", &format!("{lines}\n[mount]"), 1))
}

#[test]
fn every_observation_can_be_flown_and_others_are_refused() {
    for (word, observation) in [
        ("Position", Observation::Position),
        ("UnitVector", Observation::UnitVector),
        ("Combined", Observation::Combined),
    ] {
        let scenario = parsed(&format!("[orbit_filter]\nobservation = \"{word}\"")).unwrap();
        assert_eq!(scenario.flight_parameters(None).orbit.observation, observation);
    }
    let message = parsed("[orbit_filter]\nobservation = \"limb\"").unwrap_err().to_string();
    assert!(message.contains("some.toml:") && message.contains("UnitVector"), "{message}");
    let message = parsed("[orbit_filter.start]\nposition_sigma_km = 0.0\nvelocity_sigma_m_s = 1.0")
        .unwrap_err()
        .to_string();
    assert!(message.contains("orbit_filter.start.position_sigma_km: 0 is out of range"), "{message}");
    let message = parsed("[orbit_filter]\nstart = { position_sigma_km = 1.0 }").unwrap_err().to_string();
    assert!(message.contains("`velocity_sigma_m_s`"), "{message}");
}

#[test]
fn a_state_from_the_ground_is_the_orbit_before_any_fix_with_its_error_and_sigma() {
    // The sensor's clock tells the world's time: an offset would be an error along the track.
    let mut scenario = parsed(
        "[orbit_filter.start]\nposition_sigma_km = 2.0\nvelocity_sigma_m_s = 0.5\n\
         position_error_km = [0.5, -1.5, 0.25]\nvelocity_error_m_s = [0.0, 0.1, 0.0]",
    )
    .unwrap();
    scenario.believed = Believed::TRUTH;
    let mut scene = scenario.scene().unwrap();
    let mut first = None;
    harness::fly(&scenario, &mut scene, |second| {
        first = first.or(second.judged.orbit.filter(|orbit| orbit.nis.is_none()));
        Ok(())
    })
    .unwrap();
    let orbit = first.expect("an orbit before the first fix");
    for (axis, (error, velocity)) in [(0.5, 0.0), (-1.5, 0.1), (0.25, 0.0)].into_iter().enumerate() {
        assert!((orbit.position_km.axes.error[axis] - error).abs() < 0.01, "{orbit:?}");
        assert!((orbit.position_km.axes.sigma[axis] - 2.0).abs() < 0.01, "{orbit:?}");
        assert!((1e3 * orbit.velocity_km_s.axes.error[axis] - velocity).abs() < 0.01, "{orbit:?}");
    }
}

#[test]
fn errors_that_are_drawn_have_the_sigmas_that_are_told_and_are_others_in_each_flight() {
    let told = "[orbit_filter.start]\nposition_sigma_km = 50.0\nvelocity_sigma_m_s = 20.0\ndrawn = true";
    let scenario = parsed(told).unwrap();
    let truth = parsed(&told.replace("drawn = true", "")).unwrap().ground_state().unwrap();
    let error = |seed: u64| {
        let told = scenario.clone().with_seed(Some(seed)).ground_state().unwrap();
        let position_km = (told.position_km - truth.position_km) / 50.0;
        let velocity = (told.velocity_km_s - truth.velocity_km_s) / 0.02;
        [position_km.x, position_km.y, position_km.z, velocity.x, velocity.y, velocity.z]
    };
    assert_eq!(error(3), error(3));
    // Over 400 flights the mean of six squares is 1 to 0.03, and no two components go together beyond 4 /
    // sqrt(400).
    let errors: Vec<[f64; 6]> = (0..400).map(error).collect();
    let mean = |one: usize, other: usize| errors.iter().map(|of| of[one] * of[other]).sum::<f64>() / 400.0;
    for one in 0..6 {
        assert!((mean(one, one) - 1.0).abs() < 0.3, "{one}: {}", mean(one, one));
        (0..one).for_each(|other| assert!(mean(one, other).abs() < 0.2, "{one} {other}"));
    }
    let both = told.replace("drawn = true", "drawn = true\nposition_error_km = [1.0, 0.0, 0.0]");
    let message = parsed(&both).unwrap_err().to_string();
    assert!(message.contains("orbit_filter.start.drawn: the errors are given as well"), "{message}");
}
