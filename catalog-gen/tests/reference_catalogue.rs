//! The embedded catalogue: reproducible, small enough, and dense enough everywhere.

use catalog_gen::blend::blend;
use catalog_gen::source::{self, EMBEDDED_CRC};
use catalog_gen::{BuildParameters, REFERENCE, build, for_field, inspect};
use fsw_core::catalog::{Catalogue, Star};
use std::collections::BTreeMap;

/// V of every blob at the catalogue's epoch for a field of this size, hundredths; stars within 1 / 1440 of it
/// are one blob.
fn blob_magnitudes(field_deg: f64) -> BTreeMap<u32, i32> {
    let blend_chord = 2.0 * (0.5 * field_deg / 1440.0).to_radians().sin();
    blend(&source::stars(), 2026.5, blend_chord).iter().map(|blob| (blob.hip, blob.v_centi())).collect()
}

#[test]
fn the_embedded_catalogue_is_what_build_gives_with_its_defaults() {
    let built = build(&source::stars(), &BuildParameters::reference()).unwrap();
    assert!(built == REFERENCE, "data/reference.cat is out of date: write it with `catalog-gen build`");
}

#[test]
fn it_fits_into_160_kib() {
    assert!(REFERENCE.len() <= 160 * 1024, "{} bytes", REFERENCE.len());
}

#[test]
fn at_least_5_usable_stars_stand_in_99_9_percent_of_the_fields_with_and_without_an_earth_disc() {
    let contents = inspect::inspect(REFERENCE, 20_000).unwrap();
    let coverage = contents.coverage;
    for share in [coverage.share, coverage.share_with_earth] {
        assert!(share[2] >= 0.999, "{coverage:?}");
        assert!(share[0] >= share[1] && share[1] >= share[2]);
    }
    assert!((3_000..3_328).contains(&contents.stars) && (34_000..40_000).contains(&contents.pairs));
}

#[test]
fn its_stars_are_source_stars_carried_to_the_epoch_and_sorted_by_brightness() {
    let catalogue = Catalogue::open(REFERENCE).unwrap();
    assert_eq!(catalogue.source_crc(), EMBEDDED_CRC);
    assert!((catalogue.epoch_year() - 2026.5).abs() < 0.001);
    assert_eq!((catalogue.field_millideg(), catalogue.magnitudes_centi()[1] <= 650), (24_100, true));
    let source = source::stars();
    let stars: Vec<_> = catalogue.stars().collect();
    let v_centi = blob_magnitudes(24.1);
    let sorted = |pair: &[Star]| (v_centi[&pair[0].hip], pair[0].hip) < (v_centi[&pair[1].hip], pair[1].hip);
    assert!(stars.windows(2).all(sorted));
    let ends = [stars.first(), stars.last()].map(|star| v_centi[&star.unwrap().hip]);
    assert_eq!(catalogue.magnitudes_centi().map(i32::from), ends);
    let mut single = 0;
    for star in &stars {
        let original = source[source.binary_search_by_key(&star.hip, |original| original.hip).unwrap()];
        let expected = original.direction_at(2026.5);
        let unit = star.unit_q30.map(|x| f64::from(x) / f64::from(1 << 30));
        let apart: f64 = unit.iter().zip(expected).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let arcsec = apart.to_degrees() * 3600.0;
        // A photocentre may stand aside by up to half the blend radius (60 arcsec).
        assert!(arcsec < 30.1, "HIP {}: {arcsec}", star.hip);
        single += usize::from(arcsec < 0.022);
    }
    assert!(single > stars.len() * 95 / 100, "only blends stand aside: {single} of {}", stars.len());
}

#[test]
fn alpha_centauri_is_one_star() {
    let catalogue = Catalogue::open(REFERENCE).unwrap();
    let members: Vec<_> = catalogue.stars().filter(|star| [71_683, 71_681].contains(&star.hip)).collect();
    assert_eq!(members.len(), 1);
    assert_eq!(members[0].hip, 71_683);
    // V = -0.3 together: only Sirius and Canopus are brighter. A alone has -0.01, behind Arcturus.
    assert_eq!(catalogue.stars().position(|star| star.hip == 71_683), Some(2));
}

#[test]
fn a_neighbour_that_disturbs_a_centroid_is_flagged_and_a_distant_one_is_not() {
    let catalogue = Catalogue::open(REFERENCE).unwrap();
    // Mizar's companion (14 arcsec) belongs to its blob; Alcor is 708 arcsec away and leaves it alone.
    let mizar = catalogue.stars().find(|star| star.hip == 65_378).unwrap();
    assert!(!mizar.proximity);
    // The equal components of nu Draconis are 62 arcsec apart: two pixels' worth of one disturbed blob.
    let nu_draconis: Vec<_> = catalogue.stars().filter(|star| [85_819, 85_829].contains(&star.hip)).collect();
    assert!(!nu_draconis.is_empty() && nu_draconis.iter().all(|star| star.proximity));
}

#[test]
fn a_15_degree_field_keeps_nearly_every_star_to_v_6() {
    let source = source::stars();
    let bytes = build(&source, &for_field(15.0, 15.0, 2026.5).unwrap()).unwrap();
    let catalogue = Catalogue::open(&bytes).unwrap();
    let v_centi = blob_magnitudes(15.0);
    let kept = catalogue.stars().filter(|star| v_centi[&star.hip] <= 600).count();
    let bright = source.iter().filter(|star| star.v <= 6.005).count();
    assert!(kept * 100 >= bright * 97, "{kept} of {bright}");
}

#[test]
fn every_camera_from_4_to_60_degrees_gets_a_catalogue_that_opens() {
    let source = source::stars();
    for (width, height) in [(4.0, 3.0), (6.0, 4.5), (9.0, 16.0), (24.1, 19.4), (60.0, 45.0)] {
        let parameters = for_field(width, height, 2030.25).unwrap();
        let bytes = build(&source, &parameters).unwrap();
        let catalogue = Catalogue::open(&bytes).unwrap();
        assert!(f64::from(catalogue.magnitudes_centi()[1]) <= parameters.magnitude * 100.0 + 1e-9);
        let per_field = catalogue.star_count() as f64 * width * height / 41_253.0;
        assert!((10.0..32.0).contains(&per_field), "{width} x {height}: {per_field} stars a field");
        assert!(catalogue.pair_count() > 500);
    }
}
