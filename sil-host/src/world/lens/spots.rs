//! Images of point sources: mean electrons of the pixels of a window.
//!
//! In: places and electrons of stars, the PSF, what of a pixel is sensitive. Out: light added to the pixels
//! of a window. Each star is a sum of Gaussians ([`Psf`]), each of them integrated over the pixels
//! ([`PixelResponse`]). The spots are sorted by row, so a window costs its pixels and the spots that touch
//! its rows; every pixel adds up its spots in the same order whatever the window, hence to the same bits.

use super::psf::{BLOBS_MAX, Blob, Psf};
use crate::world::detector::pixel::{LINE_MAX, Line, PixelResponse};
use crate::world::sky::colour::BANDS;
use fsw_hal::Window;
use std::sync::Arc;

/// An image of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Column of the centre, px.
    pub x_px: f64,
    /// Row of the centre, px.
    pub y_px: f64,
    /// Mean electrons of the whole image in each part of the band.
    pub electrons: [f64; BANDS],
}

/// Spots sorted by row, with what they are drawn by.
#[derive(Debug, Clone, PartialEq)]
pub struct Spots {
    psf: Arc<Psf>,
    response: PixelResponse,
    reach_px: f64,
    spots: Vec<Spot>,
}

impl Spots {
    /// Sorts `spots`.
    pub fn new(psf: Arc<Psf>, response: PixelResponse, mut spots: Vec<Spot>) -> Self {
        spots.sort_unstable_by(|a, b| a.y_px.total_cmp(&b.y_px).then(a.x_px.total_cmp(&b.x_px)));
        let reach_px = Self::reach_px(&psf);
        Self { psf, response, reach_px, spots }
    }

    /// How far from its place a spot can touch a pixel's centre, px.
    pub fn reach_px(psf: &Psf) -> f64 {
        psf.reach_px() + 2.0
    }

    /// Number of spots.
    pub fn len(&self) -> usize {
        self.spots.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.spots.is_empty()
    }

    /// Adds the mean electrons of all spots to `electrons`, the pixels of `window` row by row.
    pub fn add_to(&self, window: Window, electrons: &mut [f64]) {
        let (left, top) = (f64::from(window.x) - self.reach_px, f64::from(window.y) - self.reach_px);
        let right = f64::from(window.x) + f64::from(window.width) + self.reach_px;
        let bottom = f64::from(window.y) + f64::from(window.height) + self.reach_px;
        let first = self.spots.partition_point(|s| s.y_px < top);
        let touching = self.spots[first..].iter().take_while(|s| s.y_px <= bottom);
        let mut brush = Brush::default();
        for spot in touching.filter(|s| s.x_px >= left && s.x_px <= right) {
            brush.draw(&self.psf, self.response, spot, window, electrons);
        }
    }
}

/// What drawing needs and need not be made anew for every spot.
#[derive(Debug, Clone)]
pub struct Brush {
    blobs: [Blob; BLOBS_MAX],
    columns: Line,
    rows: Line,
}

impl Default for Brush {
    fn default() -> Self {
        let blob = Blob { x_px: 0.0, y_px: 0.0, sigma_px: 1.0, electrons: 0.0 };
        Self { blobs: [blob; BLOBS_MAX], columns: Line::EMPTY, rows: Line::EMPTY }
    }
}

impl Brush {
    /// Adds one spot to the pixels of `window`.
    pub fn draw(
        &mut self,
        psf: &Psf,
        response: PixelResponse,
        spot: &Spot,
        window: Window,
        electrons: &mut [f64],
    ) {
        let count = psf.image(spot.x_px, spot.y_px, &spot.electrons, &mut self.blobs);
        let (across, down) = ((window.x, window.width), (window.y, window.height));
        for blob in &self.blobs[..count] {
            let reach = Psf::blob_reach_px(blob.sigma_px).min(LINE_MAX as i64 / 2);
            let columns = |line: &mut Line| response.fill(line, blob.x_px, blob.sigma_px, reach, across);
            let rows = |line: &mut Line| response.fill(line, blob.y_px, blob.sigma_px, reach, down);
            // The shorter side first: it is the one that lies beside the blob more often.
            if window.width < window.height {
                columns(&mut self.columns);
                if self.columns.count > 0 {
                    rows(&mut self.rows);
                }
            } else {
                rows(&mut self.rows);
                if self.rows.count > 0 {
                    columns(&mut self.columns);
                }
            }
            if self.rows.count > 0 && self.columns.count > 0 {
                response.add(&self.columns, &self.rows, blob.electrons, usize::from(window.width), electrons);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaussian(sigma_px: f64, spots: Vec<Spot>) -> Spots {
        Spots::new(Arc::new(Psf::gaussian(sigma_px)), PixelResponse::Full, spots)
    }

    #[test]
    fn all_light_arrives_at_the_right_place() {
        let spot = Spot { x_px: 20.3, y_px: 17.8, electrons: [2000.0, 2000.0, 1000.0] };
        let window = Window { x: 2, y: 3, width: 40, height: 30 };
        let mut electrons = vec![0.0; window.area()];
        gaussian(0.9, vec![spot]).add_to(window, &mut electrons);
        let sum: f64 = electrons.iter().sum();
        assert!((sum / 5000.0 - 1.0).abs() < 1e-5, "{sum}");
        let moment = |place: fn(usize) -> f64| {
            electrons.iter().enumerate().map(|(i, e)| place(i) * e).sum::<f64>() / sum
        };
        assert!((moment(|i| 2.0 + (i % 40) as f64) - 20.3).abs() < 1e-5);
        assert!((moment(|i| 3.0 + (i / 40) as f64) - 17.8).abs() < 1e-5);
    }

    #[test]
    fn spots_off_the_window_do_not_touch_it() {
        let far = |x_px, y_px| Spot { x_px, y_px, electrons: [1e6; BANDS] };
        let spots = gaussian(1.0, vec![far(-50.0, 5.0), far(5.0, 60.0), far(500.0, 5.0), far(5.0, -1e9)]);
        let mut electrons = [0.0; 100];
        spots.add_to(Window { x: 0, y: 0, width: 10, height: 10 }, &mut electrons);
        assert!(electrons.iter().all(|e| *e == 0.0));
    }
}
