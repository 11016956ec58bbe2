//! Windows to read: for predicted stars, and probes of the detector.
//!
//! Stars. In: predicted stars, the gate about each, the sky hidden by the lit Earth. Out: windows,
//! brightest star first. A window is the gate and the margin that a centroid needs; windows that leave the
//! detector are dropped, because centroiding needs the whole region.
//!
//! Probes: small windows to test the detector and to detect blinding by the Sun.

pub use crate::image::fingerprint::PROBES;
use crate::image::patch::MARGIN;
use crate::stars::predict::Predicted;
use fsw_hal::{DetectorGeometry, Window};
use heapless::Vec;

/// Most star windows in a second: 20 windows of 25 x 25 px are 1 % of the reference detector. The median
/// field has 36 stars; 20 windows instead of 24 do not change the accuracy of `sil-host run geo-day`.
pub const MAX_STAR_WINDOWS: usize = 20;
/// Widest gate for which a window still fits the readout buffer's height of 64 rows.
pub const MAX_GATE_PX: u16 = 24;

/// Windows about the brightest predicted stars that are not `hidden` (a place on the detector, px).
pub fn star_windows(
    predicted: &[Predicted],
    geometry: &DetectorGeometry,
    gate_px: u16,
    hidden: impl Fn([f32; 2]) -> bool,
) -> Vec<Window, MAX_STAR_WINDOWS> {
    let reach = i32::from(gate_px.min(MAX_GATE_PX)) + MARGIN as i32;
    let side = (2 * reach + 1) as u16;
    let mut windows = Vec::new();
    for star in predicted {
        // The conversion saturates: a position far outside, or NaN, gives no window.
        let [x, y] = star.centre_px.map(|at| (libm::floorf(at + 0.5) as i32).saturating_sub(reach));
        let (Ok(x), Ok(y)) = (u16::try_from(x), u16::try_from(y)) else { continue };
        let window = Window { x, y, width: side, height: side };
        if hidden(star.centre_px) {
            continue;
        }
        if window.fits(geometry) && windows.push(window).is_err() {
            break;
        }
    }
    windows
}

/// Side of a probe, px.
pub const PROBE_PX: u16 = 16;

/// Probes near the four corners and in the middle of the detector, of sides no longer than the detector's.
pub fn probes(geometry: &DetectorGeometry) -> [Window; PROBES] {
    let side = |length: u16| PROBE_PX.min(length);
    let (width, height) = (side(geometry.width_px), side(geometry.height_px));
    let (right, bottom) = (geometry.width_px - width, geometry.height_px - height);
    [(0, 0), (right, 0), (right / 2, bottom / 2), (0, bottom), (right, bottom)].map(|(x, y)| Window {
        x,
        y,
        width,
        height,
    })
}

/// Pixels of the windows in which a star's maximum may stand.
pub fn searched_px(windows: &[Window]) -> f32 {
    let margins = 2 * MARGIN as u16;
    windows.iter().fold(0.0, |sum, window| {
        sum + f32::from(window.width.saturating_sub(margins))
            * f32::from(window.height.saturating_sub(margins))
    })
}

#[cfg(test)]
mod tests;
