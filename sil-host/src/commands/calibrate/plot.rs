//! The residuals of a calibration, drawn over the detector.
//!
//! Every star has a line from where the lens puts it towards where it was measured, made longer so that nine
//! in ten stay below [`LONGEST_PX`]; grey with the focal length alone fitted, coloured with the lens found.

use super::Calibration;
use crate::calibration::fit;
use crate::formats::camera_file::CameraFile;
use std::fmt::Write;

/// Length of the lines that nine in ten stay below, drawing units.
const LONGEST_PX: f64 = 40.0;
/// Width of the drawing.
const WIDTH: f64 = 900.0;

/// The drawing as SVG.
pub fn svg(calibration: &Calibration) -> String {
    let Calibration { fit, plain: (plain, before), .. } = calibration;
    let lines = |camera: &CameraFile, views: &[fit::View]| -> Vec<([f64; 2], [f64; 2])> {
        let of = |view: &fit::View| {
            let pairs = view.stars.iter().zip(fit::residuals(camera, view));
            pairs.filter_map(|(star, residual)| Some((star.at_px, residual?))).collect::<Vec<_>>()
        };
        views.iter().flat_map(of).collect()
    };
    let (old, new) = (lines(plain, before), lines(&fit.camera, &fit.views));
    let mut lengths: Vec<f64> = old.iter().chain(&new).map(|(_, [x, y])| x.hypot(*y)).collect();
    lengths.sort_by(f64::total_cmp);
    let long = lengths.get(lengths.len() * 9 / 10).copied().unwrap_or(1.0).max(1e-3);
    let per_px = WIDTH / f64::from(plain.width_px);
    let height = per_px * f64::from(plain.height_px);
    let stretch = LONGEST_PX / long;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {:.0}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{WIDTH}\" height=\"{height:.1}\" fill=\"#fbfbf9\" stroke=\"#999\"/>\n",
        height + 46.0
    );
    for (drawn, colour, width) in [(old, "#b0aca4", 1.0), (new, "#0b6e99", 1.8)] {
        let _ = writeln!(text, "<g stroke=\"{colour}\" fill=\"{colour}\" stroke-width=\"{width}\">");
        for ([x, y], [dx, dy]) in drawn {
            let (x, y) = ((x + 0.5) * per_px, (y + 0.5) * per_px);
            let (end_x, end_y) = (x + stretch * dx, y + stretch * dy);
            let _ = writeln!(
                text,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.6\"/><path d=\"M{x:.1} {y:.1}L{end_x:.1} {end_y:.1}\"/>"
            );
        }
        text += "</g>\n";
    }
    // A line of a round length, and what the colours are.
    let scale_px = 10f64.powf(long.log10().round());
    let [below, middle] = [height + 28.0, height + 23.0];
    let _ = write!(
        text,
        "<path d=\"M14 {middle:.1}h{:.1}\" stroke=\"#333\" stroke-width=\"2\"/>\n\
         <text x=\"{:.1}\" y=\"{below:.1}\">{scale_px} px</text>\n\
         <text x=\"330\" y=\"{below:.1}\" fill=\"#77736b\">focal length alone: rms {:.3} px an axis</text>\n\
         <text x=\"640\" y=\"{below:.1}\" fill=\"#0b6e99\">lens found: rms {:.3} px an axis</text>\n</svg>\n",
        stretch * scale_px,
        22.0 + stretch * scale_px,
        fit::rms_px(plain, before),
        fit.rms_px()
    );
    text
}
