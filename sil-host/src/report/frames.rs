//! A frame as people see it: the picture, and on it what the flight code found.
//!
//! In: a moment of the run. Out: an inline SVG that holds the frame (half its size, stretched, as a PNG) and
//! above it, in the detector's pixels, recognised stars with their Hipparcos numbers, limb points, and the
//! Earth's limb as it follows from the centre and distance that the flight code found.

use super::moments::Moment;
use crate::error::HostError;
use crate::harness::truth_of;
use crate::world::attitude::{Vector, apply, dot};
use crate::world::earth::Figure;
use crate::world::scene::{Scene, Truth};
use crate::world::vector::{cross, plus, product, times, transposed, unit};
use base64::Engine as _;
use fsw_core::telemetry::Report;
use fsw_hal::Detector;
use image::codecs::png::CompressionType;
use image::{ExtendedColorType, ImageEncoder};
use std::fmt::Write as _;

/// A pixel of the picture is this many of the frame's on a side.
const REDUCTION: usize = 2;
/// Levels of grey: few, so that noise costs little.
const LEVELS: f64 = 28.0;
/// Greatest number of labelled stars.
const LABELS: usize = 14;
/// Points along the limb.
const LIMB_STEPS: u32 = 720;

/// Draws a moment.
///
/// # Errors
/// When the frame cannot be drawn again.
pub fn draw(scene: &mut Scene, moment: &Moment, exposure_us: u32) -> Result<String, HostError> {
    let cycle = moment.report.cycle;
    let geometry = scene.geometry();
    let (width, height) = (geometry.width_px, geometry.height_px);
    let mut pixels = vec![0; geometry.whole().area()];
    scene
        .expose_cycle(cycle.into(), exposure_us)
        .and_then(|()| scene.read(geometry.whole(), &mut pixels))
        .map_err(|error| {
            HostError::usage(format!("frame {cycle} cannot be drawn ({error:?})"), "report this")
        })?;
    let png = png(&pixels, usize::from(width), geometry.full_scale(), CompressionType::Best)?;
    let truth = truth_of(scene, cycle)?;
    let mut svg = format!(
        "<svg class=\"frame\" viewBox=\"-0.5 -0.5 {width} {height}\" role=\"img\" aria-label=\"{}\">\
         <image x=\"-0.5\" y=\"-0.5\" width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{}\"/>",
        moment.title,
        base64::engine::general_purpose::STANDARD.encode(png)
    );
    overlay(&mut svg, &moment.report, &truth, scene);
    svg.push_str("</svg>");
    Ok(svg)
}

/// Reduces by the brightest of every block, so that stars stay, stretches, and encodes.
pub(crate) fn png(
    pixels: &[u16],
    width: usize,
    full_scale: u16,
    compression: CompressionType,
) -> Result<Vec<u8>, HostError> {
    let (columns, rows) = (width / REDUCTION, pixels.len() / width / REDUCTION);
    let mut reduced = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        let lines = &pixels[row * REDUCTION * width..(row * REDUCTION + REDUCTION) * width];
        for column in 0..columns {
            let block = lines.chunks_exact(width).flat_map(|line| &line[column * REDUCTION..][..REDUCTION]);
            reduced.push(block.copied().max().unwrap_or(0));
        }
    }
    let mut sorted = reduced.clone();
    sorted.sort_unstable();
    let quantile = |share: f64| f64::from(sorted[(share * (sorted.len() - 1) as f64) as usize]);
    let full = f64::from(full_scale);
    // The sky's level is black, unless the whole frame is bright.
    let black = quantile(0.1).min(0.2 * full);
    let knee = full / 100.0;
    let most = libm::asinh((full - black) / knee);
    let grey = |value: &u16| {
        let height = libm::asinh((f64::from(*value) - black).max(0.0) / knee) / most;
        (libm::round(height * LEVELS) * 255.0 / LEVELS) as u8
    };
    let bytes: Vec<u8> = reduced.iter().map(grey).collect();
    let mut png = Vec::new();
    image::codecs::png::PngEncoder::new_with_quality(
        &mut png,
        compression,
        image::codecs::png::FilterType::NoFilter,
    )
    .write_image(&bytes, columns as u32, rows as u32, ExtendedColorType::L8)
    .map_err(|error| HostError::usage(format!("a frame cannot be encoded: {error}"), "report this"))?;
    Ok(png)
}

fn overlay(svg: &mut String, report: &Report, truth: &Truth, scene: &Scene) {
    if let Some(limb) = limb_path(report, truth, scene) {
        let _ = write!(svg, "<path class=\"limb\" d=\"{limb}\"/>");
    }
    for [x, y] in &report.limb_px {
        let _ = write!(svg, "<circle class=\"limb-point\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\"/>");
    }
    for (number, star) in report.stars.iter().enumerate() {
        let [x, y] = star.centre_px;
        let _ = write!(svg, "<circle class=\"star\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"13\"/>");
        if number < LABELS {
            let (at, anchor) = if x > 1150.0 { (x - 18.0, "end") } else { (x + 18.0, "start") };
            let _ = write!(
                svg,
                "<text class=\"hip\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                y + 5.0,
                star.hip
            );
        }
    }
}

/// The limb of the ellipsoid about the centre found, on the detector.
///
/// With `B` from the Earth path to axes in which the ellipsoid is a unit sphere, the sphere's centre stands
/// at `c = B r`; the rays `s` that touch it have `|s| = 1`, `s · c / |c| = sqrt(1 - 1 / |c|²)`; the limb is
/// where `B⁻¹ s` points.
pub(crate) fn limb_path(report: &Report, truth: &Truth, scene: &Scene) -> Option<String> {
    let earth = report.earth?;
    let optics = scene.optics().earth_path();
    let equator = product(truth.ellipsoid.equator(), &transposed(&truth.earth_path));
    let Figure { equator_km, pole_km } = *truth.ellipsoid.figure();
    let radii = [equator_km, equator_km, pole_km];
    let centre = earth.direction.map(|component| f64::from(component) * f64::from(earth.distance_km));
    let scaled = apply(&equator, centre);
    let c: Vector = [0, 1, 2].map(|k| scaled[k] / radii[k]);
    let far_square = dot(c, c);
    if !(far_square > 1.0 && far_square.is_finite()) {
        return None;
    }
    let (axis, sine) = (unit(c), libm::sqrt(far_square).recip());
    let cosine = libm::sqrt(1.0 - sine * sine);
    let aside = if axis[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let e1 = unit(cross(aside, axis));
    let e2 = cross(axis, e1);
    let mut path = String::new();
    let mut drawing = false;
    for step in 0..=LIMB_STEPS {
        let (s, co) = libm::sincos(std::f64::consts::TAU * f64::from(step) / f64::from(LIMB_STEPS));
        let ray = plus(plus(times(cosine, axis), sine * co, e1), sine * s, e2);
        let of_date: Vector = [0, 1, 2].map(|k| ray[k] * radii[k]);
        let pixel = optics.project(apply(&transposed(&equator), of_date));
        match pixel.filter(|[x, y]| (-200.0..1e4).contains(x) && (-200.0..1e4).contains(y)) {
            Some([x, y]) => {
                let _ = write!(path, "{}{x:.1} {y:.1}", if drawing { 'L' } else { 'M' });
                drawing = true;
            }
            None => drawing = false,
        }
    }
    Some(path)
}
