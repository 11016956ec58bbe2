//! Parameters of star identification, and the measured side that they give a tolerance.

use super::MeasuredStar;
use crate::camera::Camera;
use crate::catalog::Catalogue;
use crate::catalog::lookup::{COARSE_CHORD_ERROR, MAX_ABERRATION, q30};
use fsw_ground::table::parameter_group;

/// Tolerances tried one after the other.
pub const TOLERANCES: usize = 3;

parameter_group! {
    /// Star identification.
    pub struct IdentificationParameters in "identification" {
        /// Centroid errors to assume per axis, 1 sigma, tried in this order. The tolerance of a separation is
        /// three sigmas of the difference of two stars, `3 sqrt(2)` times as much (thesis 4.1.1).
        centroid_sigma_px: [f32; TOLERANCES] = [0.35, 1.0, 2.0], 0.05..=2.5, "px",
            "lenses without a calibration; with one 0.2, 0.6, 2";
        /// Relative uncertainty of the focal length, added to the tolerance as this share of the separation.
        scale_uncertainty: f32 = 2e-4, 0.0..=0.01, "",
            "an aluminium barrel, 23e-6 per K, 9 K from where it was calibrated: 0.2 px over 1000 px";
        /// Largest accepted common logarithm of the false-identification probability.
        log10_false_limit: f32 = -9.0, -30.0..=-2.0, "", "one wrong sky in thirty years of an image a second";
        /// Catalogue pairs that may be looked at in one second, triangles and confirmations counted in
        /// proportion.
        pairs_per_cycle: u32 = 1_200_000, 10_000..=4_000_000, "",
            "46 cycles a pair on the target: 56 M cycles";
    }
}

impl IdentificationParameters {
    /// The defaults for a lens whose [`Calibration`](crate::image::calibration::Calibration) is known: its
    /// centroids are better, and a narrower match is stronger evidence.
    pub fn of_calibrated_lens() -> Self {
        Self { centroid_sigma_px: [0.2, 0.6, 2.0], ..Self::default() }
    }

    /// The measured side between two stars with the tolerance number `step`.
    pub(super) fn side(&self, step: usize, a: &MeasuredStar, b: &MeasuredStar, camera: &Camera) -> Side {
        let chord = a.direction.chord(&b.direction);
        let tolerance = self.tolerance_px(step) * camera.rad_per_px();
        Side::new(chord, tolerance + self.scale_uncertainty * chord)
    }

    /// Tolerance of a separation of two stars near each other, px.
    pub fn tolerance_px(&self, step: usize) -> f32 {
        const THREE_SIGMA_OF_DIFFERENCE: f32 = 4.242_640_7;
        self.centroid_sigma_px.get(step).copied().unwrap_or(0.0) * THREE_SIGMA_OF_DIFFERENCE
    }
}

/// A measured side: its chord and the half width of the band in which catalogue chords fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub chord: f32,
    pub tolerance: f32,
    /// Coarse squared chords ([`Catalogue::coarse_square`]) outside which none fits.
    coarse: [u32; 2],
}

impl Side {
    /// No side. All bits zero, so that a static of it lies in `.bss`.
    pub const NONE: Self = Self { chord: 0.0, tolerance: 0.0, coarse: [0; 2] };

    pub fn new(chord: f32, tolerance: f32) -> Self {
        let reach = tolerance + COARSE_CHORD_ERROR + MAX_ABERRATION * chord;
        let (low, high) = (chord - reach, chord + reach);
        Self { chord, tolerance, coarse: [if low > 0.0 { q30(low * low) } else { 0 }, q30(high * high)] }
    }

    pub fn low(&self) -> f32 {
        self.chord - self.tolerance
    }

    pub fn high(&self) -> f32 {
        self.chord + self.tolerance
    }

    /// Whether the chord of two catalogue stars may fit: 30 cycles instead of 250.
    pub fn may_fit(&self, catalogue: &Catalogue, a: u16, b: u16) -> bool {
        let [low, high] = self.coarse;
        (low..=high).contains(&catalogue.coarse_square(a, b))
    }

    /// [`Side::fit`] of the chord of two catalogue stars.
    #[inline(never)]
    pub fn fit_between(&self, catalogue: &Catalogue, a: u16, b: u16) -> Option<f32> {
        self.fit((catalogue.unit(a)? - catalogue.unit(b)?).norm())
    }

    /// Squared difference of a catalogue chord in squared tolerances, if it fits.
    pub fn fit(&self, chord: f32) -> Option<f32> {
        let error = (chord - self.chord) / self.tolerance;
        let square = error * error;
        if square <= 1.0 { Some(square) } else { None }
    }
}
