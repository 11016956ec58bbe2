//! The Earth's orientation against SOFA's routines.

use super::*;
use crate::world::attitude::apply;
use crate::world::vector::{length, minus, transposed};
use proptest::prelude::*;

/// Two days about each date of [`REFERENCE`], IERS 20 C04.
const SERIES: &str = "\
# YR  MM  DD  HH       MJD        x(\")        y(\")  UT1-UTC(s)       dX(\")       dY(\")
2008   8  31   0  54709.00    0.298644    0.322367  -0.4642399    0.000124   -0.000288 0 0 0
2008   9   1   0  54710.00    0.298737    0.318512  -0.4653251    0.000123   -0.000317 0 0 0
2018   7  29   0  58328.00    0.197660    0.408719   0.0699466   -0.000107    0.000100 0 0 0
2018   7  30   0  58329.00    0.198295    0.407650   0.0699913   -0.000082    0.000126 0 0 0
2019   1   1   0  58484.00    0.086392    0.271153  -0.0361567    0.000258   -0.000027 0 0 0
2019   1   2   0  58485.00    0.084374    0.271932  -0.0370275    0.000307   -0.000003 0 0 0
";

/// TT (µs since J2000) and GCRF to ITRF by ERFA 2.0.1: xys06a with dX and dY, era00, pom00, sp00; midnights
/// UTC.
const REFERENCE: [(i64, [Vector; 3]); 3] = [
    (
        273412865184000,
        [
            [0.936235711076252, -0.351371680754372, -0.000797037886893],
            [0.351371520139084, 0.936236049639695, -0.000337920415742],
            [0.000864951267079, 0.000036316746793, 0.999999625270130],
        ],
    ),
    (
        586094469184000,
        [
            [0.592882084889320, -0.805288562981320, -0.001078771881903],
            [0.805287316803655, 0.592883065631845, -0.001416997584591],
            [0.001780677529103, -0.000028608831985, 0.999998414183279],
        ],
    ),
    (
        599572869184000,
        [
            [-0.175657474813332, 0.984451284698089, 0.000345830141077],
            [-0.984449671365102, -0.175657813115360, 0.001782481605162],
            [0.001815514072444, -0.000027346151067, 0.999998351579062],
        ],
    ),
];

#[test]
fn the_crust_stands_as_sofa_has_it() {
    let orientation = EarthOrientation::read(SERIES).unwrap();
    for (time_us, expected) in REFERENCE {
        let found = orientation.gcrf_to_itrf(time_us);
        let apart = |k: usize| length(minus(found[k], expected[k])) / ARCSEC * 1e3;
        println!("{:.3} {:.3} {:.3} mas", apart(0), apart(1), apart(2));
        assert!((0..3).all(|k| apart(k) < 1.0));
        // Without the series: 0.5 s of UT1 and 0.5 arcsec of the pole.
        let rough = EarthOrientation::default().gcrf_to_itrf(time_us);
        assert!((0..3).all(|k| length(minus(rough[k], expected[k])) < 8.0 * ARCSEC));
    }
}

#[test]
fn without_a_series_it_is_equator_and_sidereal_angle() {
    for time_us in [REFERENCE[0].0, 843_393_969_184_000] {
        let equator = crate::world::time::ephemeris::icrs_to_equator(time_us);
        let turned = product(&rotation(2, crate::world::time::ephemeris::sidereal_angle(time_us)), &equator);
        let found = EarthOrientation::default().gcrf_to_intermediate(time_us);
        // A microsecond of rounding is 15 µas.
        assert!((0..3).all(|k| length(minus(found[k], turned[k])) < 2e-5 * ARCSEC));
    }
}

#[test]
fn vallados_example_is_met() {
    // Vallado, Fundamentals of Astrodynamics, examples 3-14 and 3-15 (IAU 2006/2000 with dX, dY): 2004-04-06
    // 07:51:28.386009 UTC, UT1 - UTC -0.4399619 s, pole -0.140682, 0.333309 arcsec. A day's rows with the
    // same values.
    let rows = "2004 4 6 0 53101.00 -0.140682 0.333309 -0.4399619 -0.000205 -0.000136\n\
                2004 4 7 0 53102.00 -0.140682 0.333309 -0.4399619 -0.000205 -0.000136\n";
    let orientation = EarthOrientation::read(rows).unwrap();
    let time_us = civil_time::tt_us("2004-04-06T07:51:28.386009").unwrap();
    let gcrf = [5_102.508_952_9, 6_123.011_399_1, 6_378.136_933_8];
    let itrf = [-1_033.479_383, 7_901.295_275_4, 6_380.356_595_8];
    let teme = [5_094.180_162_1, 6_127.644_659_5, 6_380.344_532_7];
    for (name, turn, expected) in
        [("ITRF", orientation.gcrf_to_itrf(time_us), itrf), ("TEME", orientation.gcrf_to_teme(time_us), teme)]
    {
        let apart_m = 1e3 * length(minus(apply(&turn, gcrf), expected));
        println!("{name}: {apart_m:.3} m");
        assert!(apart_m < 0.1, "{name}");
    }
}

#[test]
fn the_frame_bias_is_that_of_sofa() {
    // bp00 of ERFA 2.0.1.
    let expected = [
        [1.0, -7.078_279_744e-8, 8.056_217_147e-8],
        [7.078_279_478e-8, 1.0, 3.306_041_454e-8],
        [-8.056_217_381e-8, -3.306_040_884e-8, 1.0],
    ];
    let found = gcrf_to_eme2000();
    assert!((0..3).all(|k| length(minus(found[k], expected[k])) < 1e-12));
}

proptest! {
    #[test]
    fn there_and_back_is_where_one_was(time_us in -8e14 as i64..18e14 as i64, place in prop::array::uniform3(-5e4..5e4f64)) {
        let turn = EarthOrientation::default().gcrf_to_itrf(time_us);
        let back = apply(&transposed(&turn), apply(&turn, place));
        // A tenth of a millimetre at 50,000 km: what a pole shifted by dX and dY is longer than a unit vector
        // is less.
        prop_assert!(length(minus(back, place)) < 1e-7);
    }
}

#[test]
fn days_that_are_missing_are_named() {
    let orientation = EarthOrientation::read(SERIES).unwrap();
    let (first, hour) = (REFERENCE[0].0, 3_600_000_000);
    assert_eq!(orientation.missing(first, first + 24 * hour), None);
    assert_eq!(orientation.missing(first - hour, first), Some(first - hour));
    assert_eq!(orientation.missing(first, first + 25 * hour), Some(first + 24 * hour));
    assert!(orientation.missing(first + 48 * hour, first + 49 * hour).is_some());
    assert_eq!(EarthOrientation::default().missing(0, 1), None);
}

#[test]
fn faulty_series_name_the_line() {
    let (line, what) = EarthOrientation::read(&SERIES.replace("58328.00", "58327.00")).unwrap_err();
    assert!(line == 4 && what.contains("no row"), "{line} {what}");
    let backwards = SERIES.replace("2018   7  30   0  58329.00", "2018   7  28   0  58327.00");
    assert_eq!(EarthOrientation::read(&backwards).unwrap_err().0, 5);
    assert_eq!(EarthOrientation::read("# nothing\n").unwrap_err().0, 1);
    assert_eq!(EarthOrientation::read("<html>").unwrap_err().0, 1);
}
