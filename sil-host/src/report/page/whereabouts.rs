//! Where the satellite was in the last second whose orbit was known: reported beside true, for the page.

use super::{TABLE, TABLE_END, clock};
use crate::report::recorder::LastOrbit;
use crate::world::vector::{angle, times};
use fsw_core::orbit::keplerian::Keplerian;
use nalgebra::Vector3;
use std::fmt::Write as _;

/// Writes it; nothing where no orbit was known.
pub(super) fn write(page: &mut String, last: Option<&LastOrbit>) {
    let Some(LastOrbit { cycle, report, local, truth }) = last else { return };
    let _ = write!(
        page,
        "<h2>Orbit at {}</h2><p class=\"soft\">ICRS axes; elements osculating.</p>{TABLE}<tr><th></th><th>Reported</th>\
         <th>True</th></tr>",
        clock(*cycle)
    );
    let mut row = |what: &str, decimals: usize, reported: &[f64], sure: &[f64]| {
        let list = |values: &[f64]| {
            let texts: Vec<String> = values.iter().map(|value| format!("{value:.decimals$}")).collect();
            texts.join(", ")
        };
        let _ = write!(page, "<tr><td>{what}</td><td>{}</td><td>{}</td></tr>", list(reported), list(sure));
    };
    row("Position, km", 3, &report.position_km, &truth.position_km);
    row("Velocity, km/s", 6, &report.velocity_km_s, &truth.velocity_km_s);
    let mu = truth.ellipsoid.body().facts().mu_km3_s2;
    let sure = Keplerian::of(mu, &Vector3::from(truth.position_km), &Vector3::from(truth.velocity_km_s));
    if let Some((of, sure)) = report.elements.zip(sure) {
        let degrees = |angle_rad: f32| f64::from(angle_rad).to_degrees();
        let rows = [
            ("Semi-major axis, km", 3, of.semi_major_axis_km, sure.semi_major_axis_km),
            ("Eccentricity", 6, f64::from(of.eccentricity), sure.eccentricity),
            ("Inclination, deg", 4, degrees(of.inclination_rad), sure.inclination_rad.to_degrees()),
            (
                "Right ascension of the ascending node, deg",
                4,
                degrees(of.node_rad),
                sure.node_rad.to_degrees(),
            ),
            ("Argument of perigee, deg", 4, degrees(of.perigee_rad), sure.perigee_rad.to_degrees()),
            ("True anomaly, deg", 4, degrees(of.anomaly_rad), sure.anomaly_rad.to_degrees()),
        ];
        for (what, decimals, reported, sure) in rows {
            row(what, decimals, &[reported], &[sure]);
        }
    }
    if let Some(local) = local {
        let down = angle(truth.earth_path[2], times(-1.0, truth.position_km));
        let nadir_deg = f64::from(local.nadir_rad).to_degrees();
        row("Earth path off nadir, deg", 4, &[nadir_deg], &[down.to_degrees()]);
    }
    page.push_str(TABLE_END);
}
