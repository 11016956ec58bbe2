//! Two fields of stars: an Earth path without its filter around the dark Earth, flown from pixels. In
//! geo-two-fields the Sun is hidden from second 2,399 to 6,445, and deeper below the limb than twilight
//! reaches from 3,843 to 5,001.

use crate::flights::{self, scenario};
use fsw_hal::OpenPaths;
use sil_host::judge::arcsec;
use sil_host::judge::second::Axes;
use sil_host::scenario::{Believed, Scenario};
use sil_host::world::motion::pointing::{Aim, Law};
use sil_host::world::motion::trajectory::SensorState;

/// A flight of geo-two-fields; unless it is changed, its mounting alone is told wrong.
struct TwoFields {
    /// The mounting as it was told last; `None` where none was.
    told: Option<Axes>,
    /// Seconds in which the Earth path's filter was out, and of these with the Earth lit.
    clear_s: u32,
    lit_s: u32,
    /// Looks at its stars, those that saw some that agree, and how many these were on average.
    looks: u32,
    seen: u32,
    stars: f64,
}

impl TwoFields {
    fn mounting(&self) -> Axes {
        self.told.expect("it tells a mounting")
    }

    /// Of the mounting, arcsec.
    fn sigma(&self) -> [f64; 3] {
        self.mounting().sigma.map(arcsec)
    }

    fn is_right(&self) -> bool {
        let Axes { error, sigma } = self.mounting();
        error.iter().zip(sigma).all(|(error, sigma)| error.abs() < 3.5 * sigma)
    }
}

fn fly_two_fields(seconds: u32, change: impl FnOnce(&mut Scenario)) -> TwoFields {
    let mut scenario = scenario("geo-two-fields", seconds);
    scenario.believed = Believed { mount_deg: scenario.believed.mount_deg, ..Believed::TRUTH };
    change(&mut scenario);
    let mut flown = TwoFields { told: None, clear_s: 0, lit_s: 0, looks: 0, seen: 0, stars: 0.0 };
    let mut worst = 0.0f64;
    flights::fly(&scenario, |second| {
        let report = second.report;
        worst = worst.max(second.judged.attitude_rad.map_or(0.0, |attitude| attitude.worst_sigma()));
        flown.clear_s += u32::from(report.earth_path_clear);
        flown.lit_s += u32::from(report.earth_path_clear && second.truth.state != SensorState::Eclipse);
        flown.looks += u32::from(report.earth_path_stars.is_some());
        if let Some(stars) = report.earth_path_stars.filter(|stars| *stars > 0) {
            flown.stars += (f64::from(stars) - flown.stars) / f64::from(flown.seen + 1);
            flown.seen += 1;
        }
        flown.told = second.judged.mounting_rad.or(flown.told);
    });
    let TwoFields { clear_s, lit_s, looks, seen, stars, .. } = &flown;
    let error = flown.mounting().error.map(arcsec);
    println!(
        "filter out for {clear_s} s, {lit_s} with a lit Earth; {seen} of {looks} looks with {stars:.1} stars; \
         mounting {error:.2?} arcsec off of {:.2?}; attitude {worst:.1} sigma",
        flown.sigma()
    );
    assert!(worst < 6.0);
    flown
}

#[test]
fn stars_around_the_dark_earth_tell_how_the_paths_are_mounted() {
    let flown = fly_two_fields(5100, |_| {});
    // The Sun is deeper than 5 deg below the limb for 20 minutes.
    assert!((1100..1250).contains(&flown.clear_s) && flown.lit_s == 0);
    assert!(flown.looks >= flown.clear_s / 16 && 10 * flown.seen >= 9 * flown.looks);
    assert!(flown.is_right() && flown.sigma().iter().all(|sigma| *sigma < 3.0));
    // Ten times as far off as the orbit is told: stars are believed more than a theodolite.
    let far = fly_two_fields(5100, |scenario| scenario.believed.mount_deg = [0.02, -0.025, 0.03]);
    assert!(far.is_right());
}

/// It turns what is seen through either path, and so the limb.
#[test]
fn an_optical_centre_told_wrong_is_a_part_of_it() {
    let flown = fly_two_fields(5100, |scenario| {
        scenario.believed = Believed { optical_centre_px: [0.1, -0.06], ..Believed::TRUTH };
    });
    assert!(flown.is_right() && flown.sigma().iter().all(|sigma| *sigma < 3.0));
}

#[test]
fn one_or_two_stars_tell_it_too() {
    // The reference instrument's mirror.
    let flown = fly_two_fields(5100, |scenario| scenario.earth = scenario.earth.behind(0.09));
    assert!(flown.stars < 2.0 && 3 * flown.seen >= 2 * flown.looks);
    assert!(flown.is_right() && flown.sigma()[..2].iter().all(|sigma| *sigma < 3.0));
}

/// Every star keeps its pixels, and what is wrong with its place there.
#[test]
fn a_field_at_rest_is_one_look_however_long_it_is_looked_at() {
    let flown = fly_two_fields(5100, |scenario| {
        // The Earth's direction in second 4,400.
        let aim = Aim { ra_deg: 180.35, dec_deg: 0.0, roll_deg: 0.0 };
        scenario.pointing = Law::Inertial(aim).into();
    });
    assert!(flown.clear_s > 1000 && flown.seen == 1 && flown.stars > 2.0);
    assert!(flown.is_right() && flown.sigma().iter().all(|sigma| *sigma > 2.0));
}

#[test]
fn without_its_filter_a_lit_earth_floods_its_disc_and_nothing_wrong_is_told() {
    let flown = fly_two_fields(600, |scenario| scenario.held_open = Some(OpenPaths::BothClear));
    assert!(flown.clear_s == 600 && flown.lit_s == 600);
    assert!(flown.is_right());
}
