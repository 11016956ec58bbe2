//! Streaks: stars whose light the sensor's turning has drawn out over many pixels.
//!
//! [`search`] finds pieces of lines in the whole image, [`follow`] measures the streak to which a piece
//! belongs. Both read windows of the image and hold none of it.
//!
//! Why lines are summed (thesis §3.1.5 sums 5 x 11 px on a grid of lines): the light of a pixel falls with
//! the rate, that of the whole streak does not. With 0.4 s, 3000 px and 29 electrons of noise a star of V = 3
//! gives a pixel's length 870 electrons at 1 deg/s and 58 at 15 deg/s, twice the noise of such a length,
//! where nothing that looks at 3 x 3 px sees it.

pub mod follow;
mod profile;
pub mod search;

use super::FULL_SCALE;

/// A piece of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// A point of it, px.
    pub at_px: [f32; 2],
    /// Unit vector along it.
    pub along: [f32; 2],
    /// How far it rises from the noise, sixteenths of a sigma.
    pub strength: i32,
    /// Brightness of the sky about it, scaled counts; 0 of one that was not searched for.
    pub background: i32,
}

/// A measured streak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Streak {
    /// Its ends, px.
    pub ends_px: [[f32; 2]; 2],
    /// Standard deviation of an end along the streak, px.
    pub sigma_along_px: f32,
    /// Standard deviation of an end across it, px.
    pub sigma_across_px: f32,
    /// Whether either end is that of the detector, not of the streak.
    pub cut: bool,
    /// Light of a pixel's length, scaled counts.
    pub light: f32,
}

impl Streak {
    /// From end to end, px.
    pub fn length_px(&self) -> f32 {
        let [[a, b], [c, d]] = self.ends_px;
        libm::sqrtf((c - a) * (c - a) + (d - b) * (d - b))
    }

    /// The point between the ends, px.
    pub fn middle_px(&self) -> [f32; 2] {
        let [[a, b], [c, d]] = self.ends_px;
        [0.5 * (a + c), 0.5 * (b + d)]
    }

    /// Whether a place lies on it, `margin_px` beside or beyond it included.
    pub fn holds(&self, [x, y]: [f32; 2], margin_px: f32) -> bool {
        let ([a, b], [mx, my]) = (self.ends_px[0], self.middle_px());
        let half = 0.5 * self.length_px();
        if half < 0.5 {
            return false;
        }
        let (ux, uy) = ((mx - a) / half, (my - b) / half);
        let (dx, dy) = (x - mx, y - my);
        (dx * ux + dy * uy).abs() < half + margin_px && (dy * ux - dx * uy).abs() < margin_px
    }
}

/// Scaled counts of a raw one, of 14 bits or fewer without loss.
fn scale(bits: u8) -> f32 {
    FULL_SCALE as f32 / (1u32 << bits.clamp(1, 16)) as f32
}

/// A raw value in scaled counts, rounded down.
fn scaled(raw: u16, bits: u8) -> i32 {
    (i32::from(raw) * FULL_SCALE) >> bits.clamp(1, 16)
}

#[cfg(test)]
mod tests;
