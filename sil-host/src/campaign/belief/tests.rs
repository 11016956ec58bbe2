use super::*;
use crate::campaign::Experiment;
use crate::cli::CommonArguments;
use std::path::Path;

#[test]
fn there_is_a_row_for_all_none_and_each_difference_alone_and_left_out() {
    let rows = variants(&Believed::default());
    assert_eq!(rows.len(), 2 + 2 * PARTS.len());
    assert_eq!((rows[0].1, rows[1].1), (Believed::default(), Believed::TRUTH));
    // Every field has a key: all parts taken over one by one are the whole.
    let mut whole = Believed::TRUTH;
    PARTS.iter().for_each(|(_, take)| take(&mut whole, &Believed::default()));
    assert_eq!(whole, Believed::default());
    for pair in rows[2..].chunks_exact(2) {
        let [(only, one), (without, others)] = pair else { unreachable!() };
        assert_eq!(only.replace("only", "without"), *without);
        let (_, take) = PARTS.iter().find(|(key, _)| only.ends_with(key)).unwrap();
        let mut joined = *others;
        take(&mut joined, one);
        assert_eq!(joined, Believed::default(), "{only}");
    }
    let one = Believed { clock_offset_s: 3.0, ..Believed::TRUTH };
    assert_eq!(variants(&one).len(), 4);
}

#[test]
fn every_column_is_a_figure_and_a_difference_shows_in_its_own() {
    assert!(FIGURES.iter().all(|(key, _)| table::figure(key).is_some()));
    let text = crate::scenario::EMBEDDED[0].1.replace("duration_s = 21600", "duration_s = 30");
    let base = Scenario::parse(Path::new("short.toml"), &text).unwrap();
    let believed = Believed { optical_centre_px: [0.3, 0.0], ..Believed::TRUTH };
    let base = Scenario { believed, ..base };
    let arguments = CampaignBeliefArguments {
        scenario: None,
        runs: 1,
        common: CommonArguments { seed: 1, json: true, ..CommonArguments::default() },
    };
    let variants = variants_of(&base, &arguments).unwrap();
    let flown = crate::campaign::runs(&variants, &arguments.common).unwrap();
    assert!(flown.iter().zip(variants.keys()).all(|(flight, key)| variants.key_of(flight) == Some(key)));
    let rows = table_of(&variants, flown);
    let names: Vec<&str> = rows.iter().map(|row| row.differences.as_str()).collect();
    assert_eq!(names, ["all", "none", "only optical_centre_px", "without optical_centre_px"]);
    assert!(rows[0].medians == rows[2].medians && rows[1].medians == rows[3].medians);
    let (shifted, truth) = (&rows[0], &rows[1]);
    // 0.3 px of 68.75 arcsec.
    let attitude = |row: &Row| row.medians["attitude_rms_arcsec"];
    assert!(attitude(truth) < 2.0 && (attitude(shifted) - 20.6).abs() < 2.0, "{truth:?} {shifted:?}");
    let text = super::text(&rows);
    assert!(text.lines().count() == 5 && text.contains("attitude") && !text.contains("rate"), "{text}");
}
