//! Bands of a frame that have been drawn, so that a pixel of a searched image is drawn once.
//!
//! In: the rows of a window. Out: their numbers, copied. A search reads the detector in large windows, then
//! many small ones about what it found; a tracking sensor reads small windows only, for which a whole band
//! would be a waste. So a large window has its bands drawn whole, side by side on all cores, and every window
//! within drawn bands is a copy. A number is a pure function of its place: a copy is what drawing would give.

use fsw_hal::{DetectorGeometry, Window};
use rayon::prelude::*;

/// Rows of a band.
const BAND_ROWS: usize = 64;
/// Rows that are drawn at once: those of a cell of the Earth's image.
const PART_ROWS: usize = 8;
/// Pixels from which a window is large.
const LARGE_PX: usize = 4096;

/// The drawn bands of an exposure.
#[derive(Debug, Clone, Default)]
pub struct Kept {
    width: usize,
    numbers: Vec<u16>,
    drawn: Vec<bool>,
}

impl Kept {
    /// Forgets everything: another exposure.
    pub fn clear(&mut self) {
        self.drawn.fill(false);
    }

    /// Whether a window's bands are worth drawing whole.
    pub fn is_large(window: Window) -> bool {
        window.area() >= LARGE_PX
    }

    /// Has `draw` fill those bands of `window` that are not drawn yet, in windows as wide as the detector.
    pub fn draw<S>(
        &mut self,
        geometry: DetectorGeometry,
        window: Window,
        scratch: impl Fn() -> S + Sync + Send,
        draw: impl Fn(&mut S, Window, &mut [u16]) + Sync + Send,
    ) {
        let (width, height) = (usize::from(geometry.width_px), usize::from(geometry.height_px));
        if self.numbers.is_empty() {
            (self.width, self.numbers) = (width, vec![0; width * height]);
            self.drawn = vec![false; height.div_ceil(BAND_ROWS)];
        }
        let bands = Self::bands(window);
        let first = bands.start;
        let numbers = self.numbers.chunks_mut(BAND_ROWS * width).zip(&mut self.drawn);
        for (band, (numbers, drawn)) in (first..).zip(numbers.skip(first).take(bands.len())) {
            if std::mem::replace(drawn, true) {
                continue;
            }
            let parts = numbers.par_chunks_mut(PART_ROWS * width).enumerate();
            parts.for_each_init(&scratch, |scratch, (part, numbers)| {
                let y = (band * BAND_ROWS + part * PART_ROWS) as u16;
                let height = (numbers.len() / width) as u16;
                draw(scratch, Window { x: 0, y, width: geometry.width_px, height }, numbers);
            });
        }
    }

    /// Fills the `pixels` of `window` if all of them are drawn, and says so.
    pub fn copy(&self, window: Window, pixels: &mut [u16]) -> bool {
        let Some(drawn) = self.drawn.get(Self::bands(window)) else { return false };
        if !drawn.iter().all(|drawn| *drawn) {
            return false;
        }
        let [left, top, width] = [window.x, window.y, window.width].map(usize::from);
        let rows = self.numbers.chunks_exact(self.width).skip(top);
        for (pixels, row) in pixels.chunks_exact_mut(width).zip(rows) {
            pixels.copy_from_slice(&row[left..left + width]);
        }
        true
    }

    /// Numbers of the bands that a window, which is not empty, touches.
    fn bands(window: Window) -> std::ops::Range<usize> {
        let top = usize::from(window.y);
        top / BAND_ROWS..(top + usize::from(window.height)).div_ceil(BAND_ROWS)
    }
}
