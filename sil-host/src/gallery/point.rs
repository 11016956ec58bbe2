//! A point solution by attitude: one Earth vector and one attitude make a position (thesis fig. 6.2).
//!
//! The covariance is that of the flight code's [`PositionFix`].

use super::orbit::{GEO_KM, NOISE_RAD};
use super::{Figure, Made, Row, Told};
use crate::error::HostError;
use crate::report::chart::{Axis, Chart, Series};
use crate::world::attitude::Vector;
use fsw_core::frames::{EarthPath, Icrs, Rotation, StarPath};
use fsw_core::orbit::point::{PositionFix, earth_to_icrs};
use nalgebra::{Matrix3, Vector3};

/// The figure.
pub const FIGURES: &[Figure] = &[Figure {
    name: "fig-6.2",
    title: "accuracy of a point solution by the attitude",
    place: "\u{a7}6.1",
    thesis: &[
        Told {
            what: "all axes together change with the attitude by, share of the distance",
            value: 1e-6,
            unit: "rad",
            place: "\u{a7}6.1",
        },
        Told { what: "point solution in GEO, 1 sigma", value: 60.0, unit: "km", place: "tab. 7.4, 9.2" },
    ],
    make: point_solution,
}];

/// Sigmas of the attitude, arcsec, about x, y, z (thesis tab. 9.2).
const ATTITUDE_ARCSEC: [f64; 3] = [6.0, 6.0, 25.0];
/// Attitudes over the sphere.
const ATTITUDES: u32 = 411;

/// A line of sight of the spiral.
fn sight(number: u32) -> Vector {
    let golden_rad = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let z = 1.0 - f64::from(2 * number + 1) / f64::from(ATTITUDES);
    let (sine, cosine) = libm::sincos(golden_rad * f64::from(number));
    let across = (1.0 - z * z).sqrt();
    [across * cosine, across * sine, z]
}

/// Standard deviations of a position along x and of all axes together, km, with the star path along a line of
/// sight, the Earth behind it (`mounting` none) or across it.
fn point_sigmas_km(sight: Vector, mounting: &Rotation<EarthPath, StarPath>) -> Option<[f64; 2]> {
    let z = Vector3::from(sight);
    let aside = if z.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let x = aside.cross(&z).normalize();
    let rows = Matrix3::from_rows(&[x.transpose(), z.cross(&x).transpose(), z.transpose()]);
    let attitude = Rotation::<Icrs, StarPath>::from_orthogonal(rows.map(|part| part as f32));
    let earth_km = Vector3::new(0.0, 0.0, GEO_KM as f32);
    let noise = Matrix3::identity() * ((NOISE_RAD * GEO_KM).powi(2) as f32);
    let arcsec = std::f64::consts::PI / (180.0 * 3600.0);
    let attitude_rad2 =
        Matrix3::from_diagonal(&Vector3::from(ATTITUDE_ARCSEC.map(|sigma| (sigma * arcsec).powi(2) as f32)));
    let to_icrs = earth_to_icrs(&attitude, mounting);
    let fix = PositionFix::new(
        &earth_km,
        [&noise, &Matrix3::zeros()],
        &earth_km,
        &to_icrs,
        &attitude_rad2,
        mounting,
    )?;
    Some([fix.covariance_km2.m11.sqrt(), (fix.covariance_km2.trace() / 3.0).sqrt()])
}

fn point_solution(figure: &Figure) -> Result<Made, HostError> {
    let turned = |axis_deg: f32| {
        let half = 0.5 * axis_deg.to_radians();
        Rotation::<EarthPath, StarPath>::from_quaternion([libm::sinf(half), 0.0, 0.0, libm::cosf(half)])
    };
    let mut series = Vec::new();
    let mut rows = Vec::new();
    let (mut changes, mut all_axes) = (Vec::new(), 0.0);
    for (name, angle_deg) in
        [("the Earth along the star path's axis", 180.0), ("the Earth across it, as in our mount", 90.0)]
    {
        let mounting =
            turned(angle_deg).ok_or_else(|| HostError::usage("a mounting is none", "report this"))?;
        let points: Vec<[f64; 3]> = (0..ATTITUDES)
            .filter_map(|number| {
                let [x, all] = point_sigmas_km(sight(number), &mounting)?;
                Some([sight(number)[0], x, all])
            })
            .collect();
        let range = |part: usize| {
            let values = || points.iter().map(move |point| point[part]);
            [values().fold(f64::MAX, f64::min), values().fold(0.0, f64::max)]
        };
        let ([low, high], [least, most]) = (range(1), range(2));
        rows.push(Row::alone(
            format!("sigma along x, {name}, least and largest"),
            format!("{low:.3} and {high:.3} km"),
        ));
        changes.push((most - least) / GEO_KM);
        all_axes = most;
        series.push(
            Series::ours(format!("ours, {name}"), points.iter().map(|point| [point[0], point[1]]).collect())
                .as_points(),
        );
    }
    rows.insert(0, figure.row(0, format!("{:.1e} and {:.1e} rad", changes[0], changes[1])));
    rows.insert(
        1,
        figure.row(1, format!("{:.0} km an axis with 0.1 deg of the Earth's direction", all_axes)),
    );
    series.push(Series::thesis(
        "0.1 deg of the Earth's direction alone",
        vec![[-1.0, NOISE_RAD * GEO_KM], [1.0, NOISE_RAD * GEO_KM]],
    ));
    let chart = Chart {
        title: "Position along x of ICRS, 411 attitudes, GEO".into(),
        x: Axis::new("x component of the star path's line of sight"),
        y: Axis::new("sigma of the position along x, km"),
        series,
    };
    let verdict = "As the thesis says, one axis varies only with the star sensor's variances, a thousandth of the Earth's, and all axes together do not vary, so \
        that the mount may be chosen freely. Its colours on a sphere are drawn here over the component that they depend on. 0.1 deg is 74 km; the thesis's 60 km is 0.08 deg.";
    Ok(Made::new(&[chart], rows, verdict))
}
