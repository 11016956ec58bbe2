use super::*;
use std::path::Path;

#[test]
fn there_is_a_row_for_all_none_and_each_difference_alone_and_left_out() {
    let rows = variants(&Believed::default());
    assert_eq!(rows.len(), 2 + 2 * PARTS.len());
    assert_eq!((rows[0].believed, rows[1].believed), (Believed::default(), Believed::TRUTH));
    // Every field has a key: all parts taken over one by one are the whole.
    let mut whole = Believed::TRUTH;
    PARTS.iter().for_each(|(_, take)| take(&mut whole, &Believed::default()));
    assert_eq!(whole, Believed::default());
    for pair in rows[2..].chunks_exact(2) {
        let [only, without] = pair else { unreachable!() };
        assert_eq!(only.name.replace("only", "without"), without.name);
        let (_, take) = PARTS.iter().find(|(key, _)| only.name.ends_with(key)).unwrap();
        let mut joined = without.believed;
        take(&mut joined, &only.believed);
        assert_eq!(joined, Believed::default(), "{}", only.name);
    }
    let one = Believed { clock_offset_s: 3.0, ..Believed::TRUTH };
    assert_eq!(variants(&one).len(), 4);
}

#[test]
fn every_column_is_a_figure_and_a_difference_shows_in_its_own() {
    assert!(FIGURES.iter().all(|(key, _)| table::figure(key).is_some()));
    let text = crate::scenario::EMBEDDED[0].1.replace("duration_s = 21600", "duration_s = 30");
    let family = Family::of_text(Path::new("short.toml"), &text, None).unwrap();
    let common = crate::cli::CommonArguments { seed: 1, json: true, ..Default::default() };
    let arguments = CampaignRunArguments { scenario: None, runs: 1, vary: None, common };
    let shifted = Believed { optical_centre_px: [0.3, 0.0], ..Believed::TRUTH };
    let variant = |name: &str, believed| Variant { name: name.into(), believed };
    let variants = [variant("truth", Believed::TRUTH), variant("shifted", shifted)];
    let rows = rows(&family, &variants, &arguments).unwrap();
    let [truth, shifted] = rows.try_into().unwrap();
    // 0.3 px of 68.75 arcsec.
    let attitude = |row: &Row| row.medians["attitude_rms_arcsec"];
    assert!(attitude(&truth) < 2.0 && (attitude(&shifted) - 20.6).abs() < 2.0, "{truth:?} {shifted:?}");
    let text = super::text(&[truth, shifted]);
    assert!(text.lines().count() == 3 && text.contains("attitude") && !text.contains("rate"), "{text}");
}
