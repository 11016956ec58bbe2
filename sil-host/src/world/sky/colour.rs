//! Star colours: how B-V changes what a detector between 500 and 900 nm sees at equal V.
//!
//! In: B-V. Out: electrons of the three thirds of the band ([`BAND_NM`]), in shares of those that a star of
//! B-V = 0 and the same V gives in all of it; quantum efficiency is even. The star is a black body of the
//! temperature `T = 4600 K [1 / (0.92 (B-V) + 1.7) + 1 / (0.92 (B-V) + 0.62)]` (Ballesteros 2012, EPL 97,
//! 34008), its V the photons at 551 nm. Against real spectra this is good to some per cent for B to K stars;
//! M stars (B-V above 1.5), with their bands of TiO, give more than it says. Interpolated in a table, error
//! below 0.001.

use std::sync::LazyLock;

/// Parts of the band.
pub const BANDS: usize = 3;
/// Middle wavelengths of the parts, nm.
pub const BAND_NM: [f64; BANDS] = [567.0, 700.0, 833.0];
/// The band, nm.
const EDGES_NM: (f64, f64) = (500.0, 900.0);
/// Effective wavelength of V, nm.
const V_NM: f64 = 551.0;
/// `h c / k`, nm K.
const SECOND_RADIATION_NM_K: f64 = 1.438_776_877e7;
/// Colours of the table.
const COLOURS: (f64, f64) = (-0.4, 2.4);
const STEPS: usize = 112;
/// Trapezes a part of the band.
const SLICES: u32 = 24;

static TABLE: LazyLock<Vec<[f64; BANDS]>> = LazyLock::new(|| {
    let white: f64 = thirds(0.0).iter().sum();
    let step = (COLOURS.1 - COLOURS.0) / STEPS as f64;
    (0..=STEPS).map(|k| thirds(COLOURS.0 + step * k as f64).map(|third| third / white)).collect()
});

/// Effective temperature of a star, K.
fn temperature_k(b_v: f64) -> f64 {
    4600.0 * ((0.92 * b_v + 1.7).recip() + (0.92 * b_v + 0.62).recip())
}

/// Photons of a black body relative to those at [`V_NM`], integrated over the thirds of the band.
fn thirds(b_v: f64) -> [f64; BANDS] {
    let x = SECOND_RADIATION_NM_K / temperature_k(b_v);
    let photons = |nm: f64| libm::pow(nm, -4.0) / libm::expm1(x / nm);
    let width = (EDGES_NM.1 - EDGES_NM.0) / BANDS as f64;
    std::array::from_fn(|band| {
        let at = |k: u32| photons(EDGES_NM.0 + width * (band as f64 + f64::from(k) / f64::from(SLICES)));
        let inner: f64 = (1..SLICES).map(at).sum();
        (inner + 0.5 * (at(0) + at(SLICES))) * width / f64::from(SLICES) / photons(V_NM)
    })
}

/// Electrons of a star in the parts of the band, relative to all those of a star of B-V = 0 and the same V.
pub fn shares(b_v: f64) -> [f64; BANDS] {
    let place = (b_v.clamp(COLOURS.0, COLOURS.1) - COLOURS.0) / (COLOURS.1 - COLOURS.0) * STEPS as f64;
    let index = (place as usize).min(STEPS - 1);
    let part = place - index as f64;
    std::array::from_fn(|band| {
        let (low, high) = (TABLE[index][band], TABLE[index + 1][band]);
        low + part * (high - low)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_star_gives_all_and_red_ones_more_and_redder() {
        let sum = |b_v| shares(b_v).iter().sum::<f64>();
        assert!((sum(0.0) - 1.0).abs() < 1e-3);
        let (hot, sun, cool) = (sum(-0.3), sum(0.65), sum(1.5));
        assert!(hot < 1.0 && 1.0 < sun && sun < cool, "{hot} {sun} {cool}");
        assert!(shares(1.5)[2] / cool > 1.3 * shares(0.0)[2]);
        // V - I (Cousins) of the Sun is 0.70 (B-V 0.65), that of a K0 giant 1.00 (B-V 1.00): magnitudes at
        // 790 nm at equal V.
        let v_i = |b_v: f64| {
            let x = SECOND_RADIATION_NM_K / temperature_k(b_v);
            let photons = |nm: f64| libm::pow(nm, -4.0) / libm::expm1(x / nm);
            2.5 * libm::log10(photons(790.0) / photons(V_NM))
        };
        for (b_v, published) in [(0.65, 0.70), (1.00, 1.00)] {
            let found = v_i(b_v) - v_i(0.0);
            println!("B-V {b_v}: V-I {found:.2} for {published}");
            assert!((found - published).abs() < 0.2, "{b_v}: {found}");
        }
    }

    #[test]
    fn the_sun_has_its_temperature() {
        assert!((temperature_k(0.65) - 5778.0).abs() < 60.0, "{}", temperature_k(0.65));
    }

    #[test]
    fn the_table_interpolates() {
        let white: f64 = thirds(0.0).iter().sum();
        for k in 0..200 {
            let b_v = -0.39 + 0.0137 * f64::from(k);
            for (found, exact) in shares(b_v).iter().zip(thirds(b_v)) {
                assert!((found - exact / white).abs() < 1e-3, "{b_v}");
            }
        }
    }
}
