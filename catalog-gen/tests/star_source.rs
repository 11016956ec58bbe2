//! The embedded star source: intact, repeatable from `hip2.dat`, and right where the sky is known
//! independently.

use catalog_gen::source::{self, EMBEDDED_CRC, SourceError, SourceStar};
use catalog_gen::{hip2, source::EPOCH_YEAR};

fn star(hip: u32) -> SourceStar {
    source::stars().into_iter().find(|star| star.hip == hip).expect("in the source")
}

/// Degrees between a direction and a right ascension and declination.
fn arcsec_from(direction: [f64; 3], ra_deg: f64, dec_deg: f64) -> f64 {
    let (ra, dec) = (ra_deg.to_radians(), dec_deg.to_radians());
    let other = [dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin()];
    let square: f64 = direction.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
    square.sqrt().to_degrees() * 3600.0
}

#[test]
fn the_embedded_source_is_the_one_that_was_reviewed() {
    let stars = source::stars();
    assert_eq!(source::checksum(&stars), EMBEDDED_CRC);
    assert_eq!(source::encode(&stars), source::embedded());
    assert_eq!(stars.len(), 41_314);
    assert!(stars.windows(2).all(|pair| pair[0].hip < pair[1].hip));
    assert!(stars.iter().all(|star| star.v <= 8.0 && (0.0..360.0).contains(&star.ra_deg)));
}

#[test]
fn the_source_follows_from_hip2_dat() {
    let Some(path) = std::env::var_os("SEXTANT_HIP2_DAT") else {
        println!("skipped: no data (set SEXTANT_HIP2_DAT to hip2.dat)");
        return;
    };
    let text = std::fs::read_to_string(path).expect("hip2.dat can be read");
    let stars = hip2::convert(&text).expect("hip2.dat can be converted");
    assert!(source::encode(&stars) == source::embedded());
}

#[test]
fn a_damaged_source_is_refused() {
    let whole = source::embedded();
    assert_eq!(source::decode(&whole[..15]), Err(SourceError::NotASource));
    assert_eq!(source::decode(&whole[..whole.len() - 1]), Err(SourceError::Length));
    assert_eq!(source::decode(&whole[..whole.len() - 20]), Err(SourceError::Length));
    for offset in [0, 5, 6, 9, 13, 16, 1000, whole.len() - 1] {
        let mut bytes = whole.to_vec();
        bytes[offset] ^= 0x10;
        assert!(source::decode(&bytes).is_err(), "byte {offset}");
    }
}

#[test]
fn sixty_one_cygni_moves_as_computed_by_spherical_trigonometry() {
    // From hip2.dat by position angle and arc (four-parts formula, apart from this crate), to 0.1 mas.
    let star = star(104_214);
    assert!(arcsec_from(star.direction_at(2026.5), 316.764_162_883_2, 38.773_494_368_3) < 0.010);
    // The position usually printed for epoch J2000, from other motions (the star circles its companion):
    // 21 06 53.9396, +38 44 57.902.
    let (ra_deg, dec_deg) =
        (15.0 * (21.0 + 6.0 / 60.0 + 53.9396 / 3600.0), 38.0 + 44.0 / 60.0 + 57.902 / 3600.0);
    assert!(arcsec_from(star.direction_at(2000.0), ra_deg, dec_deg) < 0.25);
    let moved = arcsec_from(star.direction_at(2026.5), star.ra_deg, star.dec_deg);
    assert!((moved - 35.25 * 5.2975).abs() < 0.01, "35.25 years at 5.2975 arcsec a year: {moved}");
}

#[test]
fn a_star_stands_where_the_source_has_it_at_the_source_epoch() {
    for star in source::stars().into_iter().step_by(97) {
        let direction = star.direction_at(EPOCH_YEAR);
        assert!(arcsec_from(direction, star.ra_deg, star.dec_deg) < 1e-6);
        assert!((direction.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn the_stars_that_the_new_reduction_lacks_are_there() {
    // J2000 positions and V of the Bright Star Catalogue (94 Aqr B: of 2MASS).
    let known = [
        (55_203, 169.5458, 31.5292, 3.79),
        (78_727, 241.0921, -11.3731, 4.16),
        (31_067, 97.7921, 16.9386, 6.20),
        (115_125, 349.7777, -13.4553, 6.97),
    ];
    for (hip, ra_deg, dec_deg, v) in known {
        let star = star(hip);
        assert!(arcsec_from(star.direction_at(2000.0), ra_deg, dec_deg) < 3.0, "HIP {hip}");
        assert!((star.v - v).abs() < 0.005);
    }
    // The two components of 94 Aqr are 12 arcsec apart.
    let primary = star(115_126);
    let apart = arcsec_from(star(115_125).direction_at(1991.25), primary.ra_deg, primary.dec_deg);
    assert!((10.0..15.0).contains(&apart), "{apart}");
}

#[test]
fn known_magnitudes_are_met_to_a_tenth() {
    // Vega, Capella (multiple), Betelgeuse (red, variable: 0.3), Regulus, UU Aur (carbon star, variable:
    // 0.3).
    for (hip, v, tolerance) in [
        (91_262, 0.03, 0.1),
        (24_608, 0.08, 0.1),
        (27_989, 0.45, 0.3),
        (49_669, 1.36, 0.1),
        (31_579, 5.29, 0.3),
    ] {
        assert!((star(hip).v - v).abs() < tolerance, "HIP {hip}: {}", star(hip).v);
    }
}

#[test]
fn text_that_is_not_hip2_dat_is_refused_with_line_and_column() {
    let line = "1 5 0 1 0.5 0.1 4.5 -4.5 -1.2 1 1 1 1 1 90 0.9 0 0.0 0 7.2 0.002 0.017 0 0.482 0.025";
    assert_eq!(hip2::convert(line).unwrap().len(), 5, "the star and the four missing ones");
    let message = |text: &str| hip2::convert(text).unwrap_err().to_string();
    assert!(message("").contains("holds no star"));
    assert!(message(&format!("{line}\nHIP 7")).contains("line 2 has 2 columns"));
    assert!(message(&line.replace("7.2 ", "bright ")).contains("line 1, column 20: \"bright\""));
    assert!(message(&line.replace(" 0.5 ", " 9.5 ")).contains("line 1, column 5"));
}
