//! From windows of raw pixels to star centroids, in integers.
//!
//! [`condition`] knows the local background and noise of a window, `peaks` finds local maxima that rise from
//! it, [`centroid`] judges each maximum by the thesis's criteria and gives its centre, with a
//! [`calibration`] a better one ([`matched`]), by its motion in the exposure too where that is known
//! ([`turn`]), `search` does all this in a window, [`scan`] walks the whole detector in tiles, `detections`
//! keeps the brightest spots and [`repeated`] puts first those that the last image had too. Loops over
//! pixels are in `fsw-pixels`. `allowance` bounds what crowded pictures cost, [`blinding`] knows a detector
//! at full scale, [`fingerprint`] an image that was there before. Before all of them [`bad_pixels`] may
//! correct the known [`defects`].
//!
//! Scaled counts: every pixel is brought to one scale, full scale = 2^14 = [`FULL_SCALE`], whatever the
//! converter's resolution, so thresholds mean the same for 8, 10 and 16 bits and a residual fits an `i16`.

mod allowance;
pub mod bad_pixels;
pub mod blinding;
pub mod calibration;
pub mod centroid;
pub mod defects;
mod detections;
pub mod fingerprint;
pub mod matched;
mod peaks;
pub mod repeated;
pub mod scan;
mod search;
mod shape;
mod smear;
pub mod streaks;
#[cfg(test)]
mod test_sky;
pub mod turn;

#[cfg(test)]
pub(crate) use detections::tests::SPOT;

use crate::trigonometry::hypotenuse;
use calibration::Calibration;
use fsw_ground::table::parameter_group;
pub use fsw_pixels::window::FULL_SCALE;
pub use fsw_pixels::{condition, patch};
use turn::Turn;

parameter_group! {
    /// Thresholds of star detection (thesis 3.1.1). Sigmas are those of the local background. The ranges of
    /// what a star's shape must be end where the reference lens's stars still pass: with 400 percent of the
    /// inner ring a third of the attitudes is lost, with 500 all are.
    pub struct DetectionParameters in "detection" {
        /// A 3 x 3 sum must rise this many tenths of a sigma above the background.
        threshold_sigma_tenths: u16 = 50, 30..=200, "0.1 sigma",
            "five sigma: one in 3.5 million places by chance; the thesis has 6 % of full scale instead";
        /// The maximum must exceed the mean of its region by this factor.
        peak_to_region_percent: u16 = 160, 100..=400, "%", "thesis 3.1.1: 1.6";
        /// The maximum must exceed the mean of the inner ring by this factor.
        peak_to_inner_percent: u16 = 115, 100..=300, "%",
            "thesis 1.5, for spots of 3 px, which sharper and blunter lenses fail";
        /// The inner ring's mean must exceed the outer ring's by this factor.
        inner_to_outer_percent: u16 = 115, 100..=300, "%", "thesis 3.1.1: 1.15";
        /// The inner ring must hold at least this share of the maximum: a hot pixel or a proton hit does not.
        inner_share_percent: u16 = 6, 0..=30, "%", "chosen: a single bright pixel leaves less";
        /// The region grows until the ring around it is below this share of the maximum.
        skirt_share_percent: u16 = 10, 1..=50, "%", "chosen: a Gaussian spot within 2.1 sigma";
        /// Error of a centre of intensity without background noise. A calibrated lens has its own.
        centroid_floor_millipx: u16 = 70, 1..=1000, "0.001 px", "thesis 0.1 px; residuals of real pictures";
    }
}

/// How stars are found and centred: by thresholds, and by the calibration of the lens where there is one.
#[derive(Clone, Copy, Debug)]
pub struct DetectionMethod<'a> {
    /// The thresholds.
    pub parameters: &'a DetectionParameters,
    /// The lens's profiles and corrections.
    pub calibration: Option<&'a Calibration<'a>>,
    /// How the sensor turns, where it is known to draw stars out.
    pub turn: Option<Turn>,
}

impl<'a> From<&'a DetectionParameters> for DetectionMethod<'a> {
    fn from(parameters: &'a DetectionParameters) -> Self {
        Self { parameters, calibration: None, turn: None }
    }
}

/// A star-like spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detection {
    /// Column of the centre of intensity, Q16.16 px.
    pub x_q16: i32,
    /// Row of the centre of intensity, Q16.16 px.
    pub y_q16: i32,
    /// Sum over the region above the noise floor, scaled counts.
    pub flux: i32,
    /// Sum over the 3 x 3 pixels about the maximum above the noise floor, scaled counts; the largest number
    /// there is for a saturated spot. It orders faint spots better than `flux`, to which the noise of a
    /// larger area adds.
    pub core_flux: i32,
    /// Standard deviation of the centre per axis, Q16.16 px.
    pub sigma_q16: i32,
    /// A pixel stood at full scale: the centre is good, the flux a lower bound.
    pub saturated: bool,
    /// It stands on or beside an extended bright object (clouds, a limb), far above whose texture it rises.
    pub extended: bool,
    /// Length to which the sensor's turning has drawn it out, px, its centre being that of all its light, or
    /// that of the lens's profile along the way that it is told to move; 0 of what is round.
    pub drawn_px: u8,
    /// A second maximum stands so close that its light draws the centre along; the sigma holds by how much.
    pub blended: bool,
    /// It stood in the last scanned image too, moved like the others that did.
    pub repeated: bool,
    /// Its number, which it keeps as long as one scanned image after the other shows it; 0 of a spot that no
    /// scan has numbered.
    pub number: u8,
    /// Brightness behind it, scaled counts, where its image holds more than a star and noise; else 0.
    pub backdrop: u16,
}

impl Detection {
    /// Sorts by brightness, brightest first, those that stood in the last image too before all others, those
    /// on extended objects behind; equal spots by position, so that the order is the same everywhere.
    pub fn rank(&self) -> impl Ord + use<> {
        let brightness = core::cmp::Reverse((self.core_flux, self.flux));
        (self.extended, !self.repeated, brightness, self.y_q16, self.x_q16)
    }

    /// Whether it is the round image of one star in the open sky, nothing of it cut off.
    pub(crate) fn is_single(&self) -> bool {
        !(self.saturated || self.extended || self.blended || self.drawn_px > 0)
    }

    /// The centre, px.
    pub fn centre_px(&self) -> [f32; 2] {
        const SCALE: f32 = 1.0 / 65_536.0;
        [self.x_q16 as f32 * SCALE, self.y_q16 as f32 * SCALE]
    }

    /// Standard deviation per axis, px.
    pub fn sigma_px(&self) -> f32 {
        self.sigma_q16 as f32 * (1.0 / 65_536.0)
    }

    /// The same with an error of so many px that its centre may have besides.
    #[inline(never)]
    pub(crate) fn doubted(&self, by_px: f32) -> Self {
        let sigma_q16 = (hypotenuse(self.sigma_px(), by_px) * 65_536.0) as i32;
        Self { sigma_q16, ..*self }
    }
}
