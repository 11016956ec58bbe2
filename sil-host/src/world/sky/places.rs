//! Where a star stands: proper motion and parallax, apart from `catalog-gen`.
//!
//! In: place at J1991.25 and proper motion of the source (Hipparcos, ICRS), a Julian year, the Earth's place
//! about the Sun. Out: unit vector from the Earth, without aberration.
//!
//! The star moves along the great circle of its proper motion: `u(t) = u cos μt + m sin μt`, `m` the unit
//! vector of its motion. (`catalog-gen` moves it on a straight line in space: the two differ by `(μt)³ / 3`,
//! 1e-4 arcsec after 35 years for the fastest star.) A parallax `π` moves it by `-π e`, `e` the Earth's place
//! in astronomical units, before it is made a unit vector again. The source has no parallaxes: those of the
//! stars to V = 8 that are nearest stand here, as the new reduction of Hipparcos has them (van Leeuwen 2007),
//! rounded; those below 0.15 arcsec and faint ones of the neighbourhood are left out, as are radial
//! velocities.

use crate::world::attitude::{Vector, dot};
use crate::world::vector::{plus, times, unit};
use catalog_gen::SourceStar;

/// Year of the source's places.
const SOURCE_YEAR: f64 = 1991.25;
/// Milliarcseconds in a radian.
const MAS_PER_RAD: f64 = 180.0 * 3600.0e3 / std::f64::consts::PI;
/// Hipparcos number and parallax, mas.
const PARALLAXES_MAS: [(u32, f64); 24] = [
    (3821, 168.0),
    (8102, 274.0),
    (15_510, 165.5),
    (16_537, 310.9),
    (19_849, 200.6),
    (32_349, 379.2),
    (37_279, 284.6),
    (54_035, 392.6),
    (71_681, 754.8),
    (71_683, 754.8),
    (88_601, 196.7),
    (96_100, 173.8),
    (97_649, 195.0),
    (99_240, 163.7),
    (104_214, 286.8),
    (104_217, 285.9),
    (108_870, 276.1),
    (114_046, 305.3),
    (73_184, 171.2),
    (49_908, 205.2),
    (84_405, 168.5),
    (99_461, 166.2),
    (105_090, 253.4),
    (114_622, 152.8),
];

/// The direction of a star in `year`, from the Earth at `earth_au` about the Sun.
pub fn direction(star: &SourceStar, year: f64, earth_au: Vector) -> Vector {
    let (sin_ra, cos_ra) = libm::sincos(star.ra_deg.to_radians());
    let (sin_dec, cos_dec) = libm::sincos(star.dec_deg.to_radians());
    let place = [cos_dec * cos_ra, cos_dec * sin_ra, sin_dec];
    let east = [-sin_ra, cos_ra, 0.0];
    let north = [-sin_dec * cos_ra, -sin_dec * sin_ra, cos_dec];
    let motion = plus(times(star.pm_ra_mas_yr, east), star.pm_dec_mas_yr, north);
    let motion_mas_yr = dot(motion, motion).sqrt();
    let moved = if motion_mas_yr > 0.0 {
        let (s, c) = libm::sincos(motion_mas_yr * (year - SOURCE_YEAR) / MAS_PER_RAD);
        plus(times(c, place), s / motion_mas_yr, motion)
    } else {
        place
    };
    let parallax_mas = PARALLAXES_MAS.iter().find(|(hip, _)| *hip == star.hip).map_or(0.0, |(_, mas)| *mas);
    unit(plus(moved, -parallax_mas / MAS_PER_RAD, earth_au))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::vector::angle;

    const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

    #[test]
    fn without_parallax_it_is_the_catalogues_place_to_a_milliarcsecond() {
        let mut most = 0.0f64;
        for star in catalog_gen::source::stars() {
            let ours = direction(&star, 2026.7, [0.0; 3]);
            let theirs = star.direction_at(2026.7);
            let apart: Vector = [0, 1, 2].map(|k| ours[k] - theirs[k]);
            most = most.max(dot(apart, apart).sqrt() / ARCSEC);
        }
        println!("{most:.1e} arcsec");
        assert!(most < 2e-3, "{most}");
    }

    #[test]
    fn near_stars_swing_by_twice_their_parallax_in_half_a_year() {
        let stars = catalog_gen::source::stars();
        let star = stars.iter().find(|star| star.hip == 71_683).unwrap();
        let still = direction(star, 2026.0, [0.0; 3]);
        // Across the line of sight, on either side of the Sun.
        let across = unit([-still[1], still[0], 0.0]);
        let [one, other] = [1.0, -1.0].map(|side| direction(star, 2026.0, times(side, across)));
        assert!((angle(one, other) / (2.0 * 0.7548 * ARCSEC) - 1.0).abs() < 1e-3);
        // The star seems to go the other way than the Earth.
        assert!(dot(one, across) < dot(still, across));
        // All of the list are in the source.
        let known = |hip: u32| stars.iter().any(|star| star.hip == hip);
        assert!(PARALLAXES_MAS.iter().all(|(hip, _)| known(*hip)));
    }
}
