//! Images of point sources: mean electrons of the pixels of a window.
//!
//! A spot is a Gaussian of width `σ` integrated over each pixel: `N/4 [erf((x + ½ - x₀)/√2σ) - erf((x - ½ - x₀)/√2σ)]`
//! times the same in y. It is cut at 5 σ, beyond which lies less than 1e-6 of the light. The spots are sorted by row,
//! so a window costs its pixels and the spots that touch its rows; every pixel adds up its spots in the same order
//! whatever the window, hence to the same bits.

use fsw_hal::Window;

/// Largest half width of the box a spot is drawn in, px.
const REACH_MAX_PX: usize = 32;

/// An image of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Column of the centre, px.
    pub x_px: f64,
    /// Row of the centre, px.
    pub y_px: f64,
    /// Mean electrons of the whole image.
    pub electrons: f64,
}

/// Spots sorted by row, with their common width.
#[derive(Debug, Clone, PartialEq)]
pub struct Spots {
    sigma_px: f64,
    reach_px: usize,
    spots: Vec<Spot>,
}

impl Spots {
    /// Range of widths that can be drawn, px.
    pub const SIGMA_PX: (f64, f64) = (0.1, 6.0);

    /// Sorts `spots`; `sigma_px` is taken into [`Self::SIGMA_PX`].
    pub fn new(sigma_px: f64, mut spots: Vec<Spot>) -> Self {
        let sigma_px = sigma_px.clamp(Self::SIGMA_PX.0, Self::SIGMA_PX.1);
        spots.sort_by(|a, b| a.y_px.total_cmp(&b.y_px).then(a.x_px.total_cmp(&b.x_px)));
        Self { sigma_px, reach_px: Self::reach_px(sigma_px), spots }
    }

    /// Half width of the box a spot of `sigma_px` is drawn in, px.
    pub fn reach_px(sigma_px: f64) -> usize {
        ((5.0 * sigma_px).ceil() as usize + 1).min(REACH_MAX_PX)
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
        let reach = self.reach_px as f64 + 1.0;
        let (top, bottom) =
            (f64::from(window.y) - reach, f64::from(window.y) + f64::from(window.height) + reach);
        let first = self.spots.partition_point(|s| s.y_px < top);
        let touching = self.spots[first..].iter().take_while(|s| s.y_px <= bottom);
        let (left, right) =
            (f64::from(window.x) - reach, f64::from(window.x) + f64::from(window.width) + reach);
        for spot in touching.filter(|s| s.x_px >= left && s.x_px <= right) {
            self.draw(spot, window, electrons);
        }
    }

    fn draw(&self, spot: &Spot, window: Window, electrons: &mut [f64]) {
        let (columns, x0, nx) = self.profile(spot.x_px, window.x, window.width);
        let (rows, y0, ny) = self.profile(spot.y_px, window.y, window.height);
        for (j, row_share) in rows.iter().enumerate().take(ny) {
            let start = (y0 + j) * usize::from(window.width) + x0;
            let scale = spot.electrons * row_share;
            for (pixel, share) in electrons[start..start + nx].iter_mut().zip(&columns) {
                *pixel += scale * share;
            }
        }
    }

    /// Shares of a line of pixels along one axis that lie in the window, the first one's index in the window, and
    /// their number.
    fn profile(&self, centre: f64, from: u16, length: u16) -> ([f64; 2 * REACH_MAX_PX + 1], usize, usize) {
        let mut shares = [0.0; 2 * REACH_MAX_PX + 1];
        let (from, length) = (i64::from(from), i64::from(length));
        let (nearest, reach) = (libm::rint(centre) as i64, self.reach_px as i64);
        let first = (nearest - reach).max(from);
        let last = (nearest + reach).min(from + length - 1);
        if last < first {
            return (shares, 0, 0);
        }
        let scale = std::f64::consts::FRAC_1_SQRT_2 / self.sigma_px;
        let edge = |pixel: i64| libm::erf((pixel as f64 - 0.5 - centre) * scale);
        let mut left = edge(first);
        for (share, pixel) in shares.iter_mut().zip(first..=last) {
            let right = edge(pixel + 1);
            *share = 0.5 * (right - left);
            left = right;
        }
        (shares, (first - from) as usize, (last - first + 1) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_light_arrives_at_the_right_place() {
        let spot = Spot { x_px: 20.3, y_px: 17.8, electrons: 5000.0 };
        let window = Window { x: 2, y: 3, width: 40, height: 30 };
        let mut electrons = vec![0.0; window.area()];
        Spots::new(0.9, vec![spot]).add_to(window, &mut electrons);
        let sum: f64 = electrons.iter().sum();
        assert!((sum / 5000.0 - 1.0).abs() < 1e-6, "{sum}");
        let moment = |place: fn(usize) -> f64| {
            electrons.iter().enumerate().map(|(i, e)| place(i) * e).sum::<f64>() / sum
        };
        assert!((moment(|i| 2.0 + (i % 40) as f64) - 20.3).abs() < 1e-5);
        assert!((moment(|i| 3.0 + (i / 40) as f64) - 17.8).abs() < 1e-5);
    }

    #[test]
    fn spots_off_the_window_do_not_touch_it() {
        let far = |x_px, y_px| Spot { x_px, y_px, electrons: 1e6 };
        let spots = Spots::new(1.0, vec![far(-50.0, 5.0), far(5.0, 60.0), far(500.0, 5.0), far(5.0, -1e9)]);
        let mut electrons = [0.0; 100];
        spots.add_to(Window { x: 0, y: 0, width: 10, height: 10 }, &mut electrons);
        assert!(electrons.iter().all(|e| *e == 0.0));
    }
}
