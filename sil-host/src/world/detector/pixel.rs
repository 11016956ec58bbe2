//! What of a pixel is sensitive to light.
//!
//! In: a Gaussian of light. Out: its share in every pixel of a line, by the normal distribution. The thesis
//! takes 70 % of a pixel for sensitive, an L about the corner where its electronics lie, and the sensitivity
//! within even (§3.1.2, fig. 3.7). The L is the whole square less a square in its corner of high x and y, so
//! the light of a Gaussian in it is the difference of two products, over the L's area: the fill factor is in
//! the star's flux already and must not count twice.
//!
//! A pixel's number stands for the centre of gravity of its sensitive area, which is 0.097 px away from that
//! of the square: what is seen of even light has no shift, as after the calibration of a real camera.

use crate::world::normal::QuickNormal;

/// Share of a pixel that is sensitive.
pub const FILL_FACTOR: f64 = 0.7;
/// Side of the dead corner, px: the root of 1 - [`FILL_FACTOR`].
const CORNER_PX: f64 = 0.547_722_557_505_166_1;
/// From the L's centre of gravity to the square's, px, along either axis.
const SHIFT_PX: f64 = (1.0 - FILL_FACTOR) / FILL_FACTOR * (0.5 - 0.5 * CORNER_PX);

/// Sensitive part of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelResponse {
    /// All of it.
    Full,
    /// An L.
    LShape,
}

/// Widest line of pixels.
pub const LINE_MAX: usize = 65;

/// Shares of a Gaussian in a line of pixels along one axis.
#[derive(Debug, Clone)]
pub struct Line {
    /// Index of the first in the window.
    pub first: usize,
    /// Number of pixels.
    pub count: usize,
    /// In the whole width of the pixels.
    pub whole: [f64; LINE_MAX],
    /// In the width of their dead corners.
    pub corner: [f64; LINE_MAX],
}

impl Line {
    /// An empty line, to be filled.
    pub const EMPTY: Self = Self { first: 0, count: 0, whole: [0.0; LINE_MAX], corner: [0.0; LINE_MAX] };
}

impl PixelResponse {
    /// Fills `line` with a Gaussian of `sigma_px` about `centre`, in the pixels no farther than `reach_px`
    /// from its own that lie among the `length` from number `from` on.
    #[inline]
    pub fn fill(
        self,
        line: &mut Line,
        centre: f64,
        sigma_px: f64,
        reach_px: i64,
        (from, length): (u16, u16),
    ) {
        let (from, length) = (i64::from(from), i64::from(length));
        let nearest = libm::rint(centre) as i64;
        let first = (nearest - reach_px).max(from);
        let last = (nearest + reach_px).min(from + length - 1);
        if last < first {
            line.count = 0;
            return;
        }
        (line.first, line.count) = ((first - from) as usize, (last - first + 1) as usize);
        let scale = sigma_px.recip();
        let shift = if self == Self::LShape { SHIFT_PX } else { 0.0 };
        let normal = QuickNormal::table();
        let below = |edge: f64| normal.below((edge + shift - centre) * scale);
        let mut left = below(first as f64 - 0.5);
        for (k, pixel) in (first..=last).enumerate() {
            let right = below(pixel as f64 + 0.5);
            line.whole[k] = right - left;
            if self == Self::LShape {
                line.corner[k] = right - below(pixel as f64 + (0.5 - CORNER_PX));
            }
            left = right;
        }
    }

    /// Share of the sensitive part whose place, from the centre of gravity in the direction `normal`, is less
    /// than `w` px: a square projects to the sum of two uniform distributions.
    pub fn below(self, normal: [f64; 2], w: f64) -> f64 {
        match self {
            Self::Full => square_below(normal, 1.0, w),
            Self::LShape => {
                let aside = normal[0] + normal[1];
                let whole = square_below(normal, 1.0, w - SHIFT_PX * aside);
                let corner = square_below(normal, CORNER_PX, w - (SHIFT_PX + 0.5 - 0.5 * CORNER_PX) * aside);
                (whole - (1.0 - FILL_FACTOR) * corner) / FILL_FACTOR
            }
        }
    }

    /// Adds `electrons` in the product of two lines to the pixels of a window `width` wide.
    #[inline]
    pub fn add(self, columns: &Line, rows: &Line, electrons: f64, width: usize, pixels: &mut [f64]) {
        for j in 0..rows.count {
            let start = (rows.first + j) * width + columns.first;
            let line = &mut pixels[start..start + columns.count];
            match self {
                Self::Full => {
                    let whole = electrons * rows.whole[j];
                    for (pixel, share) in line.iter_mut().zip(&columns.whole) {
                        *pixel += whole * share;
                    }
                }
                Self::LShape => {
                    let whole = electrons / FILL_FACTOR * rows.whole[j];
                    let corner = electrons / FILL_FACTOR * rows.corner[j];
                    for ((pixel, share), hidden) in line.iter_mut().zip(&columns.whole).zip(&columns.corner) {
                        *pixel += whole * share - corner * hidden;
                    }
                }
            }
        }
    }
}

/// Share of a square about 0 that lies less than `w` in the direction `normal`.
fn square_below(normal: [f64; 2], side: f64, w: f64) -> f64 {
    // Along an axis one of the two has no width: a thousandth of a pixel instead.
    let [a, b] = normal.map(|part| (part.abs() * side).max(1e-3));
    let ramp = |at: f64| 0.5 * at.max(0.0) * at.max(0.0);
    let (sum, difference) = (0.5 * (a + b), 0.5 * (a - b));
    (ramp(w + sum) - ramp(w + difference) - ramp(w - difference) + ramp(w - sum)) / (a * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light of a Gaussian of 5000 e- in 20 x 20 pixels: sum and centre.
    fn image(response: PixelResponse, sigma_px: f64, x: f64, y: f64) -> (f64, [f64; 2]) {
        let (mut columns, mut rows, mut pixels) = (Line::EMPTY, Line::EMPTY, [0.0; 400]);
        response.fill(&mut columns, x, sigma_px, 8, (0, 20));
        response.fill(&mut rows, y, sigma_px, 8, (0, 20));
        response.add(&columns, &rows, 5000.0, 20, &mut pixels);
        let sum: f64 = pixels.iter().sum();
        let moment = |place: fn(usize) -> usize| {
            pixels.iter().enumerate().map(|(i, e)| place(i) as f64 * e).sum::<f64>() / sum
        };
        (sum, [moment(|i| i % 20), moment(|i| i / 20)])
    }

    #[test]
    fn all_light_arrives_at_the_right_place_in_full_pixels() {
        let (sum, [x, y]) = image(PixelResponse::Full, 0.9, 9.3, 10.8);
        assert!((sum / 5000.0 - 1.0).abs() < 1e-6 && (x - 9.3).abs() < 1e-5 && (y - 10.8).abs() < 1e-5);
    }

    #[test]
    fn the_l_sees_as_much_and_at_the_same_place_on_the_mean_over_phases() {
        let (mut flux, mut offset, mut worst) = (0.0, [0.0; 2], 0.0f64);
        for k in 0..100 {
            let (x, y) = (9.0 + 0.1 * f64::from(k % 10), 9.0 + 0.1 * f64::from(k / 10));
            let (sum, centre) = image(PixelResponse::LShape, 0.4, x, y);
            flux += sum / 5e5;
            worst = worst.max((sum / 5000.0 - 1.0).abs());
            // The mean of the centre is weighted with the light, as the mean over many stars would be.
            offset = [offset[0] + (centre[0] - x) * sum / 5e5, offset[1] + (centre[1] - y) * sum / 5e5];
        }
        assert!((flux - 1.0).abs() < 1e-5, "{flux}");
        assert!(offset[0].abs() < 1e-4 && offset[1].abs() < 1e-4, "{offset:?}");
        // A sharp image does feel the dead corner.
        assert!((0.03..0.2).contains(&worst), "{worst}");
    }
}
