//! Tests: the flight code's prediction against the world, which is written apart from it.

use super::*;
use crate::scenario::Believed;
use crate::scenario::EMBEDDED;
use crate::world::scene::Scene;

/// The six orbits of the thesis, in the order of its figures.
const ORBITS: [&str; 6] = [
    include_str!("../../../orbits/geo-in-plane.toml"),
    include_str!("../../../orbits/geo-out-of-plane.toml"),
    include_str!("../../../orbits/sso-in-plane.toml"),
    include_str!("../../../orbits/sso-out-of-plane.toml"),
    include_str!("../../../orbits/gto-in-plane.toml"),
    include_str!("../../../orbits/gto-out-of-plane.toml"),
];

fn parsed(text: &str) -> Scenario {
    Scenario::parse(Path::new("orbit.toml"), text).unwrap()
}

/// The thesis's orbits, and the embedded ones that follow a law without slews; the flight code told the
/// truth.
fn scenarios() -> Vec<Scenario> {
    let lawful = |scenario: &Scenario| {
        scenario.pointing.turns_evenly() && law(scenario).is_ok() && scenario.track.is_none()
    };
    let embedded = EMBEDDED.iter().map(|(_, text)| parsed(text)).filter(lawful);
    let told = |scenario| Scenario { believed: Believed::TRUTH, ..scenario };
    ORBITS.into_iter().map(parsed).chain(embedded).map(told).collect()
}

/// How far a change of the Sun may be from where it is predicted, s: in GEO the Sun moves 15 arcsec a second
/// and the ephemeris on board errs by 25.
const SUN_S: i64 = 2;
/// Lit limb, deg of azimuth, up to which it may be told lit or dark: world and flight code look at it each
/// half degree, and a high orbit takes half a minute for that.
const FAINT_DEG: f64 = 1.0;

/// State of the world's sensor in a second, and whether next to nothing of the limb is lit.
fn state_at(scene: &Scene, second: u32) -> (u8, bool) {
    let truth = scene.truth_at(second.into()).unwrap();
    (truth.state as u8, truth.lit_limb_deg <= FAINT_DEG)
}

/// Whether `state` may be told where the world has that one: the same, or light of a faint limb.
fn agrees(state: u8, (truth, faint): (u8, bool)) -> bool {
    state == truth || faint && [state, truth].iter().all(|state| [0, 2].contains(state))
}

#[test]
fn predicted_states_are_those_of_the_flown_world() {
    let mut suns = 0;
    for scenario in scenarios() {
        let outlook = outlook(&scenario, Some(scenario.duration_s.into()), Dynamics::Full).unwrap();
        let scene = scenario.scene().unwrap();
        for interval in &outlook.states {
            let [begin, end] = [interval.begin_s, interval.end_s].map(i64::from);
            // About every change of the Sun, else each minute and a half.
            let inner = (begin + SUN_S..end - SUN_S).step_by(97).chain([begin + SUN_S, end - 1 - SUN_S]);
            for second in inner.filter(|second| (begin + SUN_S..end - SUN_S).contains(second)) {
                let truth = state_at(&scene, second as u32);
                assert!(agrees(interval.state, truth), "{} second {second}: {truth:?}", scenario.name);
            }
        }
        suns += outlook.states.iter().filter(|interval| ![0, 2].contains(&interval.state)).count();
        println!("{}: {} changes as the world has them", scenario.name, outlook.states.len() - 1);
    }
    // Enough of what is to be predicted to the second.
    assert!(suns >= 20, "{suns}");
}

#[test]
fn intervals_and_totals_fill_the_span() {
    for text in ORBITS {
        let outlook = outlook(&parsed(text), None, Dynamics::Full).unwrap();
        assert!((f64::from(outlook.duration_s) - outlook.period_s.unwrap()).abs() < 1.0);
        assert_eq!(outlook.states[0].begin_s, 0);
        assert!(outlook.states.windows(2).all(|pair| pair[0].end_s == pair[1].begin_s));
        assert!(outlook.states.windows(2).all(|pair| pair[0].state != pair[1].state));
        assert_eq!(outlook.states.last().unwrap().end_s, outlook.duration_s);
        assert_eq!(outlook.totals.iter().map(|total| total.seconds).sum::<u32>(), outlook.duration_s);
        assert!((outlook.totals.iter().map(|total| total.share).sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn orbits_without_a_law_without_an_end_or_into_the_ground_are_refused_in_words() {
    let geo = ORBITS[0];
    let refusal =
        |text: &str, duration_s| outlook(&parsed(text), duration_s, Dynamics::Full).unwrap_err().to_string();
    let spin =
        geo.replace("law = \"nadir\"", "law = \"spin\"\nra_deg = 0\ndec_deg = 0\nrate_deg_s = [0, 0, 1]");
    assert!(refusal(&spin, None).contains("turns freely"));
    assert!(refusal(geo, Some(1e9)).contains("400 days"));
    let fast = "[orbit]\nposition_km = [8000, 0, 0]\nvelocity_km_s = [0, 12, 0]\n[pointing]";
    let open =
        geo[..geo.find("[orbit]").unwrap()].to_owned() + fast + &geo[geo.find("[pointing]").unwrap() + 10..];
    match Scenario::parse(Path::new("orbit.toml"), &open) {
        // Where scenarios refuse what does not close, there is nothing to predict.
        Err(refused) => assert!(refused.to_string().contains("orbit"), "{refused}"),
        Ok(scenario) => {
            let refused = outlook(&scenario, None, Dynamics::Full).unwrap_err().to_string();
            assert!(refused.contains("--duration-s"), "{refused}");
        }
    }
}

#[test]
fn the_page_shows_every_orbit_and_its_states() {
    let outlooks = ORBITS.map(|text| outlook(&parsed(text), None, Dynamics::Full).unwrap());
    let page = page::html(&outlooks);
    for outlook in &outlooks {
        assert!(page.contains(&format!("<h2>{}</h2>", outlook.orbit)));
    }
    assert_eq!(page.matches("<svg").count(), 6);
    assert!(page.contains("3 Sun in the star path") && !page.contains("http"));
}

#[test]
fn a_dawn_dusk_orbit_has_no_outage_where_the_sun_stands_on_its_normal() {
    let share = |text: &str, state: usize| {
        outlook(&parsed(text), Some(6050.0), Dynamics::Full).unwrap().totals[state].share
    };
    let aligned = include_str!("../../../orbits/sso-dawn-dusk.toml");
    assert_eq!(share(aligned, 0), 1.0);
    // As far beside it as orbits of the same node are in another month: the limb ahead is dark for a while.
    let beside = aligned.replace("2026-10-15", "2026-09-23").replace("291.0", "270.7");
    assert!((0.3..0.5).contains(&share(&beside, 2)), "{}", share(&beside, 2));
}
