//! Density of the upper air after Harris and Priester (Montenbruck and Gill, *Satellite Orbits*, §3.5.2).
//!
//! In: height, km, and how far the place lies in the bulge that follows the Sun. Out: density, kg/m³. The
//! table is the published one (their table 3.8, mean solar activity) at every second to fifth height, so that
//! heights between, exponentially, are within 5 % of it. Below 100 km the density is that at 100 km, above
//! 1,000 km there is none.
//!
//! The real density differs by solar and magnetic activity: half or twice this at 450 km is usual, five times
//! at 800 km possible. The ground scales it by [`super::parameters::OrbitParameters::drag_m2_kg`].

/// Height, km; natural logarithms of the least and the greatest density of a day, g/km³.
const TABLE: [[f32; 3]; 15] = [
    [100.0, 13.1171, 13.1171],
    [120.0, 10.1226, 10.1226],
    [130.0, 9.0332, 9.0722],
    [140.0, 8.2685, 8.3087],
    [150.0, 7.6601, 7.7030],
    [170.0, 6.6856, 6.7751],
    [200.0, 5.5440, 5.7564],
    [250.0, 4.0446, 4.5335],
    [320.0, 2.3970, 3.2233],
    [420.0, 0.4434, 1.7377],
    [560.0, -1.9052, 0.0050],
    [680.0, -3.6374, -1.3127],
    [780.0, -4.7682, -2.3252],
    [920.0, -6.1148, -3.4641],
    [1000.0, -6.7680, -4.0118],
];
/// kg/m³ of a g/km³.
const KG_M3: f32 = 1e-12;

/// How far a place lies in the bulge, 0 to 1: `cos⁶ (psi / 2)`, psi being the angle from the bulge's apex.
/// The published exponent is 2 for orbits of low inclination and 6 for polar ones.
pub(super) fn bulge(cosine: f32) -> f32 {
    // cos² of half the angle.
    let half = 0.5 + 0.5 * cosine;
    half * half * half
}

/// Density at a height above the ellipsoid, kg/m³.
pub(super) fn density_kg_m3(height_km: f32, bulge: f32) -> f32 {
    let [mut from_km, mut least, mut most] = TABLE[0];
    let height_km = height_km.max(from_km);
    for [to_km, least_up, most_up] in TABLE {
        if height_km <= to_km {
            let share = (height_km - from_km) / (to_km - from_km).max(1.0);
            let between = |below: f32, above: f32| libm::expf(below + share * (above - below));
            let least = between(least, least_up);
            return KG_M3 * (least + bulge * (between(most, most_up) - least));
        }
        (from_km, least, most) = (to_km, least_up, most_up);
    }
    0.0
}
