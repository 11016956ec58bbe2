//! Stars as light: from visual magnitude to electrons, and what the detector adds.
//!
//! Flux of a star of V = 0. The scan of thesis table 3.5 reads "8 10? photons" for 79 mm² of aperture,
//! 500-900 nm, quantum efficiency 0.5 and fill factor 0.7; its exponent is lost. From physics: the flux of an
//! A0 star at V = 0 (Vega, [`VEGA_PHOTONS`]) integrated over the band is 2.7e6 photons/s/cm², times 0.785
//! cm², 0.5 and 0.7 gives 7.3e5 electrons/s, a tenth below 8e5. So the table means 8e5 *detected* photons *a
//! second* (per exposure, or before the detector's losses, it would be off by 3 and more), and
//! [`ZERO_MAGNITUDE_E_S`] takes it. It holds for a star of B-V = 0; at the same V cool stars give more in
//! this red band than hot ones, see [`super::colour`].
//!
//! Detector (thesis table A.10 and ALGORITHMS part 0): dark current 800 e-/s at 20 °C, doubling every 7 K;
//! read noise 20 e-; full well 40,000 e- at full scale; a pedestal of 30/1024 of full scale keeps the noise
//! from being cut off.

use crate::world::detector::fixed_pattern::PatternModel;
use crate::world::detector::pixel::PixelResponse;
use crate::world::normal::ROUNDER;

/// Electrons a second of a star of V = 0 in the thesis's optics, without the mirror.
pub const ZERO_MAGNITUDE_E_S: f64 = 8.0e5;

/// Flux of an A0 star at V = 0: wavelength (nm), photons/s/cm²/nm. Monochromatic values of Vega at the edges
/// of the band and at the effective wavelengths of V, R and I, approximate (a few per cent).
pub const VEGA_PHOTONS: [(f64, f64); 5] =
    [(500.0, 11_800.0), (550.0, 10_000.0), (640.0, 7_100.0), (790.0, 4_600.0), (900.0, 3_900.0)];

/// Aperture area of the thesis's optics (diameter 10 mm), cm².
pub const APERTURE_CM2: f64 = std::f64::consts::FRAC_PI_4;
/// Quantum efficiency.
pub const QUANTUM_EFFICIENCY: f64 = 0.5;

/// The electrons of a detector and its optics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectorModel {
    /// Electrons a second of a star of V = 0 before [`Self::throughput`].
    pub zero_magnitude_e_s: f64,
    /// Share of the light that reaches the detector: 0.91 by the mirror of the star path.
    pub throughput: f64,
    /// Dark current at 20 °C, e-/s a pixel.
    pub dark_e_s: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Standard deviation of the readout, e-.
    pub read_noise_e: f64,
    /// Charge at which a pixel is full, e-; equals full scale.
    pub full_well_e: f64,
    /// Value of an empty pixel as a share of `2^bits`.
    pub pedestal: f64,
    /// What of a pixel is sensitive.
    pub response: PixelResponse,
    /// How pixels, columns and rows differ.
    pub pattern: PatternModel,
    /// Shortest and longest exposure, µs.
    pub exposure_us: (u32, u32),
}

impl Default for DetectorModel {
    fn default() -> Self {
        Self {
            zero_magnitude_e_s: ZERO_MAGNITUDE_E_S,
            throughput: 0.91,
            dark_e_s: 800.0,
            temperature_c: 20.0,
            read_noise_e: 20.0,
            full_well_e: 40_000.0,
            pedestal: 30.0 / 1024.0,
            response: PixelResponse::Full,
            pattern: PatternModel::NONE,
            exposure_us: (1_000, 2_000_000),
        }
    }
}

impl DetectorModel {
    /// The reference detector with what makes real pixels differ: the default has pixels that are all alike.
    pub fn reference() -> Self {
        Self { response: PixelResponse::LShape, pattern: PatternModel::REFERENCE, ..Self::default() }
    }

    /// The same behind an entrance pupil so many times as large.
    pub fn gathering(self, light: f64) -> Self {
        Self { zero_magnitude_e_s: self.zero_magnitude_e_s * light, ..self }
    }

    /// Electrons a second of a star of magnitude `v` and B-V = 0.
    pub fn star_e_s(&self, v: f64) -> f64 {
        self.zero_magnitude_e_s * self.throughput * libm::pow(10.0, -0.4 * v)
    }

    /// Dark current at the temperature set, e-/s a pixel.
    pub fn dark_now_e_s(&self) -> f64 {
        self.dark_e_s * libm::exp2((self.temperature_c - 20.0) / 7.0)
    }

    /// Electrons a digital number.
    pub fn gain_e_per_dn(&self, bits: u8) -> f64 {
        self.full_well_e / f64::from((1u32 << bits.min(16)) - 1)
    }

    /// Value of an empty pixel, DN.
    pub fn pedestal_dn(&self, bits: u8) -> f64 {
        self.pedestal * f64::from(1u32 << bits.min(16))
    }

    /// What turns electrons into numbers of `bits`.
    pub fn converter(&self, bits: u8) -> Converter {
        Converter {
            full_well_e: self.full_well_e,
            dn_per_e: self.gain_e_per_dn(bits).recip(),
            pedestal_dn: self.pedestal_dn(bits),
            full_scale_dn: f64::from((1u32 << bits.min(16)) - 1),
        }
    }

    /// Whether all values make physical sense.
    pub fn is_sound(&self) -> bool {
        let not_negative =
            [self.zero_magnitude_e_s, self.throughput, self.dark_e_s, self.read_noise_e, self.pedestal];
        not_negative.iter().all(|v| v.is_finite() && *v >= 0.0)
            && self.pedestal < 1.0
            && self.full_well_e.is_finite()
            && self.full_well_e > 0.0
            && (-100.0..=100.0).contains(&self.temperature_c)
            && self.pattern.is_sound()
    }
}

/// From electrons to digital numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converter {
    full_well_e: f64,
    dn_per_e: f64,
    pedestal_dn: f64,
    full_scale_dn: f64,
}

impl Converter {
    /// The digital number of `electrons`, rounded, with pedestal, cut at 0, full well and full scale.
    #[inline]
    pub fn digital_number(&self, electrons: f64) -> u16 {
        let least = |a: f64, b: f64| if a < b { a } else { b };
        let value = least(electrons, self.full_well_e) * self.dn_per_e + self.pedestal_dn;
        let cut = least(if value > 0.0 { value } else { 0.0 }, self.full_scale_dn);
        (cut + ROUNDER).to_bits() as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::detector::pixel::FILL_FACTOR;

    #[test]
    fn the_flux_of_the_table_follows_from_vega() {
        let band: f64 = VEGA_PHOTONS.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
        let electrons = band * APERTURE_CM2 * QUANTUM_EFFICIENCY * FILL_FACTOR;
        assert!((electrons / ZERO_MAGNITUDE_E_S - 1.0).abs() < 0.1, "{electrons}");
    }

    #[test]
    fn five_magnitudes_are_a_factor_of_hundred_and_seven_kelvin_one_of_two() {
        let model = DetectorModel::default();
        assert!((model.star_e_s(1.0) / model.star_e_s(6.0) - 100.0).abs() < 1e-9);
        let warm = DetectorModel { temperature_c: 27.0, ..model };
        assert!((warm.dark_now_e_s() - 1600.0).abs() < 1e-9);
    }

    #[test]
    fn values_are_cut_at_both_ends() {
        let converter = DetectorModel::default().converter(10);
        assert_eq!(converter.digital_number(0.0), 30);
        assert_eq!(converter.digital_number(-1e9), 0);
        assert_eq!(converter.digital_number(1e9), 1023);
        assert_eq!(DetectorModel::default().converter(16).digital_number(1e9), 65_535);
        assert_eq!(converter.digital_number(391.1), 40);
    }
}
