//! The setting of a run, for the page.

use super::{TABLE, TABLE_END};
use crate::scenario::Scenario;
use crate::world::motion::pointing::Law;
use std::fmt::Write as _;

/// Where the Earth path looks.
fn pointing_words(scenario: &Scenario) -> String {
    let mut words = match &scenario.pointing.law {
        Law::Nadir { off_nadir_deg, roll_deg } => {
            format!("{off_nadir_deg} deg off nadir towards flight, rolled by {roll_deg} deg")
        }
        Law::Horizon { below_deg, roll_deg } => {
            format!("{below_deg} deg below the horizon ahead, rolled by {roll_deg} deg")
        }
        Law::Inertial(aim) => {
            format!(
                "right ascension {} deg, declination {} deg, rolled by {} deg",
                aim.ra_deg, aim.dec_deg, aim.roll_deg
            )
        }
        Law::Spin(tumble) => {
            let [x, y, z] = tumble.at(0.0).rate_rad_s.map(f64::to_degrees);
            format!("turning freely, at the start {x:.3}, {y:.3}, {z:.3} deg/s about x, y, z")
        }
    };
    if !scenario.pointing.slews.is_empty() {
        let _ = write!(words, "; slews: {}", scenario.pointing.slews.len());
    }
    if scenario.jitter.is_some() {
        words += "; with jitter";
    }
    words
}

/// Writes it.
pub(super) fn write(page: &mut String, scenario: &Scenario) {
    let camera = &scenario.camera;
    let [rx, ry, rz] = scenario.position_km.map(|value| format!("{value:.3}"));
    let [vx, vy, vz] = scenario.velocity_km_s.map(|value| format!("{value:.6}"));
    let [a, b, c] = scenario.mount.star_path_deg;
    let rows = [
        ("Position at the start, ICRS", format!("{rx}, {ry}, {rz} km")),
        ("Velocity at the start, ICRS", format!("{vx}, {vy}, {vz} km/s")),
        ("Period", format!("{:.0} s", scenario.period_s())),
        ("Earth path", pointing_words(scenario)),
        (
            "Star path",
            format!(
                "turned by {a}, {b}, {c} deg about x, y, z of the Earth path{}",
                if camera.mirrored { ", mirrored" } else { "" }
            ),
        ),
        (
            "Camera",
            format!(
                "{} x {} px, f = {} px, {} bits, {} ms",
                camera.width_px,
                camera.height_px,
                camera.focal_length_px,
                camera.bits,
                f64::from(scenario.exposure_us) * 1e-3
            ),
        ),
        (
            "A frame holds",
            format!(
                "{} false stars, {} hot pixels, {} dead ones ({:.0} % of both are known on board), {}",
                scenario.disturbances.false_stars,
                scenario.disturbances.hot_pixels,
                scenario.disturbances.dead_low + scenario.disturbances.dead_high,
                100.0 * scenario.disturbances.surveyed,
                scenario.disturbances.protons
            ),
        ),
    ];
    let _ = write!(page, "<h2>Setting</h2>{TABLE}");
    for (what, value) in rows {
        let _ = write!(page, "<tr><td>{what}</td><td>{value}</td></tr>");
    }
    page.push_str(TABLE_END);
}
