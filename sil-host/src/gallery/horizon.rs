//! The Earth's limb on the detector, and fits to it (thesis figs. 3.26 to 3.28, §3.2.2).
//!
//! Limbs are the world's (`view`); points with noise go to the flight code's centre and to the methods that do
//! not fly (`methods`).

mod methods;
mod view;

use super::seeds::{OverSeeds, over_seeds};
use super::{Figure, Made, Row, Told, digits};
use crate::error::HostError;
use crate::formats::camera_file::CameraFile;
use crate::report::chart::{Axis, Chart, Series};
use crate::world::earth::EQUATOR_KM;
use crate::world::noise::{Noise, Stream};
use crate::world::vector::{cross, minus, plus, times, unit};
use fsw_core::camera::Camera;
use methods::fits;
use view::{LimbView, camera, flown, noisy};

/// The figures.
pub const FIGURES: &[Figure] = &[
    Figure {
        name: "eq-3.33",
        title: "fits of circles and ellipses beside the circularised one",
        place: "\u{a7}3.2.2, eq. 3.33 to 3.38",
        thesis: &[
            Told {
                what: "step at noon of the plain circle",
                value: 0.2,
                unit: "deg",
                place: "\u{a7}7.2.2.3",
            },
            Told {
                what: "factor by which the known eccentricity reduces it",
                value: 2.0,
                unit: "",
                place: "\u{a7}7.2.2.3",
            },
        ],
        make: fits,
    },
    Figure {
        name: "fig-3.26",
        title: "elliptical image of a sphere off the axis",
        place: "\u{a7}3.2.2.2",
        thesis: &[],
        make: off_axis,
    },
    Figure {
        name: "fig-3.27",
        title: "circle and true image of the horizon in a low orbit",
        place: "\u{a7}3.2.2.2",
        thesis: &[],
        make: low_horizon,
    },
    Figure {
        name: "fig-3.28",
        title: "curvature of the horizon in a low orbit, and what it is good for",
        place: "\u{a7}3.2.3",
        thesis: &[
            Told {
                what: "height of the horizon over its chord, 300 km, 24 deg",
                value: 25.0,
                unit: "px",
                place: "\u{a7}3.2.3",
            },
            Told {
                what: "Earth vector with 1 px of the horizon, 300 km",
                value: 0.3,
                unit: "deg",
                place: "\u{a7}3.2.3; the scan has \u{201c}30\u{201d}",
            },
        ],
        make: curvature,
    },
];

/// Trials a seed.
const TRIALS: u64 = 10;

/// The farthest of points from the circle through the first, the middle and the last.
fn off_circle_px(points: &[[f64; 2]]) -> f64 {
    let [a, b, c] = [0, points.len() / 2, points.len() - 1].map(|index| points[index]);
    let Some((centre, radius)) = circle_through(a, b, c) else { return f64::NAN };
    points.iter().map(|[x, y]| (libm::hypot(x - centre[0], y - centre[1]) - radius).abs()).fold(0.0, f64::max)
}

fn circle_through([ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]) -> Option<([f64; 2], f64)> {
    let (bx, by, cx, cy) = (bx - ax, by - ay, cx - ax, cy - ay);
    let twice = 2.0 * (bx * cy - by * cx);
    let (bb, cc) = (bx * bx + by * by, cx * cx + cy * cy);
    let (x, y) = ((cy * bb - by * cc) / twice, (bx * cc - cx * bb) / twice);
    twice.is_normal().then(|| ([ax + x, ay + y], libm::hypot(x, y)))
}

fn off_axis(_: &Figure) -> Result<Made, HostError> {
    // A sphere's limb: a cone of the Earth's half angle, tilted.
    let f = CameraFile::reference().focal_length_px;
    let stretch = |half_rad: f64, off_deg: f64| {
        let off = off_deg.to_radians();
        let ray = |azimuth: f64| {
            let (s, c) = libm::sincos(azimuth);
            let (sr, cr) = libm::sincos(half_rad);
            let (so, co) = libm::sincos(off);
            // About z, then tilted towards x.
            let (x, y, z) = (sr * c, sr * s, cr);
            [co * x + so * z, y, co * z - so * x]
        };
        let place = |azimuth: f64| {
            let [x, y, z] = ray(azimuth);
            (z > 0.0).then_some([f * x / z, f * y / z])
        };
        let points: Option<Vec<[f64; 2]>> = (0..360).map(|k| place(f64::from(k).to_radians())).collect();
        let points = points?;
        let extent = |k: usize| {
            let values = || points.iter().map(move |point| point[k]);
            values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
        };
        Some(100.0 * (extent(0) / extent(1) - 1.0))
    };
    let geo = libm::asin(EQUATOR_KM / 42_164.0);
    let mut series = Vec::new();
    for (name, half) in [
        ("GEO, half angle 8.7 deg", geo),
        ("GTO, 20 deg", 20f64.to_radians()),
        ("45 deg", 45f64.to_radians()),
    ] {
        let points = (0..=40).filter_map(|step| {
            let off = 0.5 * f64::from(step);
            Some([off, stretch(half, off)?])
        });
        series.push(Series::ours(format!("ours, {name}"), points.collect()));
    }
    series.push(Series::thesis("a circle, as the thesis takes it in GEO", vec![[0.0, 0.0], [20.0, 0.0]]));
    let chart = Chart {
        title: "Stretch of a sphere's image away from the axis".into(),
        x: Axis::new("angle of its centre off the axis, deg"),
        y: Axis::new("longer over shorter diameter less 1, %"),
        series,
    };
    let at = |off: f64| stretch(geo, off).map_or("open".into(), |percent| format!("{percent:.2} %"));
    let px = |off: f64| {
        stretch(geo, off)
            .map_or("open".into(), |percent| format!("{:.1} px", 0.01 * percent * 2.0 * f * libm::tan(geo)))
    };
    let rows = vec![
        Row::alone("GEO, 1 deg off the axis", format!("{}, {}", at(1.0), px(1.0))),
        Row::alone("GEO, 5 deg off the axis", format!("{}, {}", at(5.0), px(5.0))),
        Row::alone(
            "limb's half angle from 450 km",
            format!(
                "{:.1} deg: about its horizon the conic is a hyperbola",
                libm::asin(EQUATOR_KM / 6_828.0).to_degrees()
            ),
        ),
    ];
    let verdict = "The thesis gives a sketch and no number. It neglects the effect in GEO, where the Earth stands in the middle: a degree off, 0.1 px, \
        that is right; five degrees off it is 4 px, many times a limb point's noise. The flight code fits the cone itself, at any angle and distance";
    Ok(Made::new(&[chart], rows, verdict))
}

/// The view of a horizon from a height over the equator's radius.
pub(super) fn horizon(height_km: f64) -> Result<LimbView, HostError> {
    let radius_km = EQUATOR_KM + height_km;
    LimbView::new(radius_km, libm::asin(EQUATOR_KM / radius_km).to_degrees())
}

/// Height of the limb over its chord, and how far it is from the circle through ends and middle, px.
pub(super) fn sagitta_px(points: &[[f64; 2]]) -> [f64; 2] {
    let (first, last) = (points[0], points[points.len() - 1]);
    let (dx, dy) = (last[0] - first[0], last[1] - first[1]);
    let chord = libm::hypot(dx, dy);
    let off = |[x, y]: &[f64; 2]| (((x - first[0]) * dy - (y - first[1]) * dx) / chord).abs();
    [points.iter().map(off).fold(0.0, f64::max), off_circle_px(points)]
}

fn low_horizon(_: &Figure) -> Result<Made, HostError> {
    let mut series = Vec::new();
    let mut rows = Vec::new();
    for height_km in [300.0, 450.0, 800.0] {
        let points = horizon(height_km)?.in_field();
        let [first, middle, last] = [0, points.len() / 2, points.len() - 1].map(|index| points[index]);
        let Some((centre, radius)) = circle_through(first, middle, last) else { continue };
        let off = points.iter().map(|[x, y]| [y - 511.5, libm::hypot(x - centre[0], y - centre[1]) - radius]);
        series.push(Series::ours(format!("ours, {height_km:.0} km: limb less circle"), off.collect()));
        rows.push(Row::alone(
            format!("farthest from the circle through ends and middle, {height_km:.0} km"),
            format!(
                "{} px; radius of that circle {radius:.0} px, f tan(half angle) {:.0} px",
                digits(off_circle_px(&points), 2),
                CameraFile::reference().focal_length_px
                    * libm::tan(libm::asin(EQUATOR_KM / (EQUATOR_KM + height_km)))
            ),
        ));
    }
    series.push(Series::thesis(
        "the circle of the global criterion; inliers within 4 px",
        vec![[-511.0, 0.0], [511.0, 0.0]],
    ));
    let chart = Chart {
        title: "True limb less the circle through its ends and middle".into(),
        x: Axis::new("place along the shorter side from the middle, px"),
        y: Axis::new("limb outside the circle, px"),
        series,
    };
    let verdict = "The thesis's picture shows circle and limb apart, without scale, and concludes that no circle serves there. With the horizon across the middle of this lens a circle follows \
        the limb to a thirtieth of a pixel, and its radius is that of the way to the image of the Earth's centre, f tan(half angle): the hyperbola's curvature at its vertex. It is the short arc that makes a single \
        frame weak in LEO (fig-3.28), not the conic. Away from the middle the circle fails (fig-3.26); the flight code asks for the cone from the start, in LEO and in GEO";
    Ok(Made::new(&[chart], rows, verdict))
}

/// Noise of a limb point of the accuracy, px, and heights, km.
const HORIZON_PX: f64 = 1.0;
const HEIGHTS_KM: [f64; 5] = [300.0, 450.0, 600.0, 800.0, 1_200.0];
/// Numbers of limb points: as few as a chord's height needs, and as the flight code reads.
const NUMBERS: [usize; 3] = [6, 12, 48];

/// Root mean square error of the direction along the vertical and across it, deg, of points on a horizon.
fn horizon_errors(view: &LimbView, camera: &Camera, number: usize, seed: u64) -> [f64; 2] {
    let limb = view.in_field();
    let chosen: Vec<[f64; 2]> =
        (0..number).map(|index| limb[index * (limb.len() - 1) / (number - 1)]).collect();
    let down = view.centre();
    // Towards the limb in the field, and across.
    let up = unit(minus([0.0, 0.0, 1.0], times(down[2], down)));
    let across = cross(down, up);
    let inside = view.optics.project(unit(plus([0.0, 0.0, 1.0], 0.2, down))).unwrap_or([0.0; 2]);
    let (mut squares, mut found) = ([0.0; 2], 0.0);
    for trial in 0..TRIALS {
        let noise = Noise::new(seed, trial, Stream::Centroid).part(number as u64);
        let points = noisy(&chosen, inside, HORIZON_PX, &noise);
        let Some(seen) = flown(view, camera, &points, HORIZON_PX) else { continue };
        for (square, axis) in squares.iter_mut().zip([up, across]) {
            let error: f64 = (0..3).map(|k| seen[k] * axis[k]).sum();
            *square += error.to_degrees().powi(2);
        }
        found += 1.0;
    }
    squares.map(|square| (square / found).sqrt())
}

fn curvature(figure: &Figure) -> Result<Made, HostError> {
    let camera = camera()?;
    let heights: Vec<[f64; 2]> = HEIGHTS_KM
        .iter()
        .map(|height| Ok([*height, sagitta_px(&horizon(*height)?.in_field())[0]]))
        .collect::<Result<_, HostError>>()?;
    let told = figure.thesis[0].value;
    let bow = Chart {
        title: "Height of the horizon over its chord".into(),
        x: Axis::new("height of the orbit, km"),
        y: Axis::new("height over the chord, px"),
        series: vec![
            Series::ours("ours, along the shorter side of 19.4 deg", heights.clone()).marked(),
            Series::ours(
                "ours, the same over 24 deg",
                heights.iter().map(|[h, px]| [*h, px * (640.0f64 / 512.0).powi(2)]).collect(),
            ),
            Series::thesis("thesis, 300 km, 24 deg", vec![[300.0, told]]).as_points(),
        ],
    };
    let mut series = Vec::new();
    let mut rows = vec![figure.row(
        0,
        format!(
            "{:.1} px over the shorter side; {:.1} px over 24 deg",
            heights[0][1],
            heights[0][1] * (640.0f64 / 512.0).powi(2)
        ),
    )];
    for number in NUMBERS {
        let mut of_height = Vec::new();
        for height_km in HEIGHTS_KM {
            let view = horizon(height_km)?;
            let seeds = over_seeds(|seed| horizon_errors(&view, &camera, number, seed));
            of_height.push([0, 1].map(|axis| OverSeeds::of(seeds.iter().map(|seed| seed[axis]))));
        }
        for (axis, name) in [(0, "along the vertical"), (1, "across it")] {
            let points = HEIGHTS_KM.iter().zip(&of_height).map(|(h, of)| [*h, of[axis].median]).collect();
            series.push(Series::ours(format!("ours, {number} points, {name}"), points).marked());
        }
        let words = format!(
            "{} along the vertical, {} across",
            of_height[0][0].words("deg"),
            of_height[0][1].words("deg")
        );
        rows.push(match number {
            6 => Row { what: "Earth vector, 6 points of 1 px, 300 km".into(), ..figure.row(1, words) },
            _ => Row::alone(format!("Earth vector, {number} points of 1 px, 300 km"), words),
        });
    }
    series.push(
        Series::thesis("thesis, estimate for 1 px at 300 km", vec![[300.0, figure.thesis[1].value]])
            .as_points(),
    );
    let accuracy = Chart {
        title: "Earth vector from a horizon with 1 px of noise a point, distance unknown".into(),
        x: Axis::new("height of the orbit, km"),
        y: Axis::logarithmic("error of the direction, rms, deg"),
        series,
    };
    let verdict = "The horizon is somewhat flatter than the thesis's round figure. Its estimate of the Earth vector takes one pixel of the whole curve; with the distance unknown direction and distance trade off along \
        the vertical, so that a single frame of a few points is worse than it says. (Reached in flight, it says: 2 deg.) Across the vertical the error is a small part of that, and an orbit knows the distance: \
        the flight code takes the points' heights into the orbit instead of a centre";
    Ok(Made::new(&[bow, accuracy], rows, verdict))
}
