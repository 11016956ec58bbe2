//! How bright a place of the Earth's surface is, by its albedo and by how it is lit and seen.
//!
//! In: albedo `A`, cosines `μ0` of the Sun's and `μ` of the view's zenith angle, cosine of the angle between
//! Sun and observer seen from the place. Out: radiance over that of a white surface with the Sun in the
//! zenith.
//!
//! [`Photometry::Mixed`], this project's: `A μ0 (2 k / (μ0 + μ) + 1 - k)`, Lommel-Seeliger and Lambert. The
//! flight code's limb model has the same form.
//!
//! [`Photometry::Minnaert`]: `A μ0^k μ^(k-1)` (Minnaert, Astrophys. J. 93, 403, 1941) with `k` from 0.5 for
//! what is black to 1, Lambert's law, for thick cloud, snow and ice from an albedo of 0.6 on: the range that
//! planets' surfaces show, the line between is this project's choice. Where the albedo is that of open sea,
//! its glint comes on top: `π F P / (4 μ cos⁴β)` with Fresnel's reflection `F` of water and the slopes of
//! waves `P = exp(-tan²β / σ²) / (π σ²)`, `σ² = 0.003 + 0.00512 W` in a wind of `W` = 7 m/s (Cox and Munk, J.
//! Opt. Soc. Am. 44, 838, 1954); `β` is the tilt of the wave that mirrors the Sun. Where the albedo is that
//! of high cloud or ice, plates of ice that lie nearly level mirror it too: the same with the Fresnel
//! reflection of ice, times the share of the area that they are, 0.001 to 0.01, and `σ` the tangent of their
//! tilt, below 1 deg (Bréon and Dubrulle, J. Atmos. Sci. 61, 2888, 2004; seen from far as flashes over land,
//! Marshak et al., Geophys. Res. Lett. 44, 5197, 2017); here the upper end of both.

use std::f32::consts::PI;

/// Albedo from which on `k` is 1.
const LAMBERT_FROM: f32 = 0.6;
/// Albedo of open sea, and that from which on none of it is seen.
const SEA: (f32, f32) = (0.05, 0.12);
/// Albedo from which on some of the ice mirrors, and that from which on all of it does.
const ICE: (f32, f32) = (LAMBERT_FROM, 0.7);
/// Waves in a wind of 7 m/s; the refractive index of water is 1.34.
const WAVES: Facets = Facets { slopes: 0.003 + 0.005_12 * 7.0, straight: 0.021, share: 1.0 };
/// Level plates of ice, of the refractive index 1.31, tilted by 1 deg.
const PLATES: Facets = Facets { slopes: 3.047e-4, straight: 0.018, share: 0.01 };
/// Brightest that the mirrored Sun is drawn: smooth slopes hide lower waves where the view is flat.
const GLINT_MAX: f32 = 2.0;

/// What mirrors the Sun.
struct Facets {
    /// Mean square slope, both directions together.
    slopes: f32,
    /// Reflection straight down.
    straight: f32,
    /// Share of the area.
    share: f32,
}

/// A law of brightness.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Photometry {
    /// A mix of Lommel-Seeliger and Lambert.
    #[default]
    Mixed,
    /// Minnaert's, by cover, with the glints of sea and ice.
    Minnaert,
}

impl Photometry {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Mixed, Self::Minnaert];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mixed => "mixed",
            Self::Minnaert => "minnaert",
        }
    }

    /// That of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }
}

/// Minnaert's law with the glints of sea and ice. `lit` and `view` are the cosines, `view` above 0; `phase` that
/// of the angle between Sun and observer.
pub fn minnaert(albedo: f32, lit: f32, view: f32, phase: f32) -> f32 {
    if lit <= 0.0 {
        return 0.0;
    }
    let k = 0.5 + 0.5 * (albedo * (1.0 / LAMBERT_FROM)).min(1.0);
    let even = albedo * libm::powf(lit * view, k) / view;
    let (sea, none) = SEA;
    let open = ((none - albedo) / (none - sea)).clamp(0.0, 1.0);
    let (some, all) = ICE;
    let icy = ((albedo - some) / (all - some)).clamp(0.0, 1.0);
    match (open, icy) {
        (0.0, 0.0) => even,
        (0.0, _) => even + icy * glint(&PLATES, lit, view, phase),
        (..) => even + open * glint(&WAVES, lit, view, phase),
    }
}

/// The Sun in waves or plates.
fn glint(facets: &Facets, lit: f32, view: f32, phase: f32) -> f32 {
    // Sum of the directions to Sun and observer: its half is the cosine of the angle of incidence.
    let sum = (2.0 + 2.0 * phase).max(1e-6).sqrt();
    let tilt = ((lit + view) / sum).clamp(1e-3, 1.0);
    let tangent2 = 1.0 / (tilt * tilt) - 1.0;
    let slopes = libm::expf(-tangent2 / facets.slopes) / (PI * facets.slopes);
    let flat = 1.0 - 0.5 * sum.min(2.0);
    let fresnel = facets.straight + (1.0 - facets.straight) * flat * flat * flat * flat * flat;
    (PI * facets.share * fresnel * slopes / (4.0 * view * tilt * tilt * tilt * tilt)).min(GLINT_MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_down_every_cover_has_its_albedo_and_snow_is_lamberts() {
        for albedo in [0.15, 0.3, 0.58] {
            assert!((minnaert(albedo, 1.0, 1.0, 0.5) - albedo).abs() < 1e-6);
        }
        for (lit, view) in [(0.3, 0.9), (0.9, 0.2), (0.5, 0.5)] {
            assert!((minnaert(0.68, lit, view, 0.4) - 0.68 * lit).abs() < 1e-6);
            // Reciprocal, as every law must be: brightness over the cosine of the Sun.
            let there = minnaert(0.2, lit, view, 0.4) / lit;
            assert!((there / (minnaert(0.2, view, lit, 0.4) / view) - 1.0).abs() < 1e-5);
        }
        assert_eq!(minnaert(0.3, 0.0, 0.5, 0.1), 0.0);
    }

    #[test]
    fn the_sea_mirrors_the_sun_where_it_must() {
        // Cox and Munk with the Sun and the observer in the zenith: F / 4 σ² = 0.14 for 7 m/s.
        let above = minnaert(0.05, 1.0, 1.0, 1.0) - 0.05;
        assert!((above / (0.021 / (4.0 * WAVES.slopes)) - 1.0).abs() < 1e-3, "{above}");
        // 60 degrees off the mirrored direction nothing is left, and land mirrors nothing.
        let off = f32::cos(1.047);
        let plain = 0.05 * libm::powf(off, 0.5 + 0.5 * 0.05 / 0.6 - 1.0);
        assert!(minnaert(0.05, 1.0, off, off) - plain < 2e-4);
        assert!((minnaert(0.15, 1.0, 1.0, 1.0) - 0.15).abs() < 1e-6);
    }

    #[test]
    fn ice_mirrors_the_sun_within_its_plates_tilt_and_no_other_cover_does() {
        // Sun and observer 30 deg from the zenith on either side of it, and 3 deg beside that: 1.5 deg of tilt.
        let at = |albedo: f32, view_deg: f32| {
            let (sun, view) = (30.0_f32.to_radians(), view_deg.to_radians());
            let plain = albedo * libm::powf(sun.cos() * view.cos(), 1.0) / view.cos();
            minnaert(albedo, sun.cos(), view.cos(), (sun + view).cos()) - plain
        };
        let (mirrored, beside) = (at(0.7, 30.0), at(0.7, 33.0));
        // 0.01 F / (4 σ² μ), F = 0.018 + 0.982 (1 - cos 30 deg)^5, σ = tan 1 deg.
        let by_hand = 0.01 * (0.018 + 0.982 * 4.32e-5) / (4.0 * 3.047e-4 * 0.866);
        assert!((mirrored / by_hand - 1.0).abs() < 2e-3, "{mirrored} {by_hand}");
        assert!((beside / mirrored / libm::expf(-2.25) - 1.0).abs() < 0.06, "{beside}");
        // Half way to all of it; none where it begins, and 6 deg off.
        assert!((at(0.65, 30.0) / by_hand - 0.5).abs() < 2e-3);
        assert!(at(0.6, 30.0).abs() < 1e-6 && at(0.7, 42.0).abs() < 1e-6);
        // It adds a quarter of the cover's own light, and only there.
        assert!((0.2..0.35).contains(&(mirrored / (0.7 * 0.866))));
    }
}
