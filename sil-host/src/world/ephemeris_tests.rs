//! Ephemeris against SOFA's routines (epv00, moon98, pnm06a, gst06a with TT - UT1 = 69.184 s) and the almanac.

use super::super::vector::{angle, length};
use super::*;

type Row = (i64, Vector, Vector, Vector, Vector, f64);

/// TT (µs since J2000), Sun (km), Moon (km), the Earth's heliocentric velocity (km/s), pole, sidereal angle (rad).
const REFERENCE: [Row; 16] = [
    (
        1177200000000,
        [60472450., -123075359., -53360027.],
        [318878., 192018., 45591.],
        [-27.6351, -11.3431, -4.9178],
        [-0.000022671, -0.000026641, 0.999999999],
        2.7680494,
    ),
    (
        106357968000000,
        [86374353., 113917473., 49388149.],
        [-178785., -284570., -123777.],
        [23.9570, -15.7042, -6.8071],
        [0.000296492, 0.000021302, 0.999999956],
        0.9022385,
    ),
    (
        211538736000000,
        [-148927141., 19687097., 8535715.],
        [22926., 338180., 185472.],
        [3.7744, 26.9476, 11.6827],
        [0.000654437, 0.000045557, 0.999999785],
        5.3197023,
    ),
    (
        316719504000000,
        [59377818., -123527749., -53552757.],
        [85417., -359847., -162220.],
        [-27.7516, -11.1336, -4.8278],
        [0.001008095, 0.000012745, 0.999999492],
        3.4539712,
    ),
    (
        421900272000000,
        [87325436., 113295551., 49114935.],
        [-174831., 346186., 112187.],
        [23.8474, -15.8782, -6.8831],
        [0.001321319, -0.000033852, 0.999999126],
        1.5881470,
    ),
    (
        527081040000000,
        [-148766796., 20745999., 8994580.],
        [263127., -254757., -92409.],
        [3.9830, 26.9100, 11.6669],
        [0.001612768, -0.000043199, 0.999998699],
        6.0054578,
    ),
    (
        632261808000000,
        [58285185., -123946647., -53730457.],
        [-344435., 98613., 75280.],
        [-27.8334, -10.9195, -4.7341],
        [0.001915835, -0.000011257, 0.999998165],
        4.1396096,
    ),
    (
        737442576000000,
        [88241670., 112673191., 48842055.],
        [372748., 36474., -2161.],
        [23.7082, -16.0637, -6.9647],
        [0.002250735, 0.000031020, 0.999997467],
        2.2738347,
    ),
    (
        842623344000000,
        [-148619441., 21782551., 9442912.],
        [-346109., -150603., -98149.],
        [4.2115, 26.8966, 11.6598],
        [0.002611541, 0.000032871, 0.999996589],
        0.4081200,
    ),
    (
        947804112000000,
        [57203965., -124378182., -53914491.],
        [294834., 243462., 132414.],
        [-27.9221, -10.7357, -4.6526],
        [0.002952583, -0.000016236, 0.999995641],
        4.8255458,
    ),
    (
        1052984880000000,
        [89166498., 112040306., 48564855.],
        [-207701., -316195., -113141.],
        [23.5626, -16.2147, -7.0296],
        [0.003250335, -0.000055652, 0.999994716],
        2.9596865,
    ),
    (
        1158165648000000,
        [-148446752., 22845989., 9903279.],
        [82126., 348589., 119131.],
        [4.4550, 26.8505, 11.6377],
        [0.003541722, -0.000043903, 0.999993727],
        1.0938116,
    ),
    (
        1263346416000000,
        [56100632., -124803761., -54096477.],
        [87723., -310974., -153657.],
        [-28.0357, -10.5276, -4.5617],
        [0.003860533, -0.000004617, 0.999992548],
        5.5111848,
    ),
    (
        1368527184000000,
        [90082142., 111413005., 48289766.],
        [-254604., 248487., 138391.],
        [23.4488, -16.3814, -7.0998],
        [0.004208586, 0.000022538, 0.999991144],
        3.6454402,
    ),
    (
        1473707952000000,
        [-148269617., 23889860., 10356377.],
        [343354., -199604., -69615.],
        [4.6621, 26.8074, 11.6180],
        [0.004566029, 0.000002508, 0.999989576],
        1.7797184,
    ),
    (
        1578888720000000,
        [54984635., -125213570., -54270918.],
        [-384001., 127541., 17303.],
        [-28.1104, -10.3082, -4.4678],
        [0.004890673, -0.000053132, 0.999988039],
        6.1971072,
    ),
];

fn worst(error: impl Fn(&Row) -> f64) -> f64 {
    REFERENCE.iter().map(error).fold(0.0, f64::max)
}

#[test]
fn the_sun_stands_within_a_hundredth_of_a_degree() {
    let direction = worst(|row| angle(sun_km(row.0), row.1).to_degrees());
    let distance = worst(|row| (length(sun_km(row.0)) - length(row.1)).abs());
    println!("Sun: {:.2} arcsec, {distance:.0} km", direction * 3600.0);
    assert!(direction < 0.004 && distance < 12_000.0);
}

#[test]
fn the_moon_stands_within_a_twentieth_of_a_degree() {
    let direction = worst(|row| angle(moon_km(row.0), row.2).to_degrees());
    let distance = worst(|row| (length(moon_km(row.0)) - length(row.2)).abs());
    println!("Moon: {direction:.4} deg, {distance:.0} km");
    assert!(direction < 0.05 && distance < 150.0);
}

#[test]
fn the_earth_moves_as_it_does() {
    let error = worst(|row| length(minus(earth_velocity_km_s(row.0), row.3)));
    println!("velocity: {error:.4} km/s");
    assert!(error < 0.01);
}

#[test]
fn pole_and_rotation_are_those_of_date() {
    let pole = worst(|row| angle(icrs_to_equator(row.0)[2], row.4) / ARCSEC);
    let turn = worst(|row| {
        let difference = sidereal_angle(row.0) - row.5;
        libm::atan2(libm::sin(difference), libm::cos(difference)).abs() / ARCSEC
    });
    println!("pole {pole:.3} arcsec, sidereal angle {turn:.3} arcsec");
    assert!(pole < 0.5 && turn < 1.0);
}

#[test]
fn equinoxes_and_solstices_of_the_almanac_are_met() {
    // UTC to the minute, 2026: March 20 14:46, June 21 8:25, September 23 0:05, December 21 20:50; apparent longitudes.
    let instants = [827_290_029_184_000, 835_302_369_184_000, 843_393_969_184_000, 851_158_269_184_000];
    for (quarter, time_us) in instants.into_iter().enumerate() {
        let t = centuries(time_us);
        let of_date = apply(&rotation(0, obliquity(t)), apply(&precession(t), sun_km(time_us)));
        // Light takes 499 s, in which the Earth goes 20.5 arcsec; nutation moves the equinox.
        let longitude =
            libm::atan2(of_date[1], of_date[0]).to_degrees() - 20.5 / 3600.0 + nutation(t).0.to_degrees();
        let error = (longitude - 90.0 * quarter as f64 + 540.0).rem_euclid(360.0) - 180.0;
        assert!(error.abs() < 0.003, "{quarter}: {error} deg");
    }
}

#[test]
fn the_julian_year_counts_from_2000() {
    assert!((julian_year(827_290_029_184_000) - 2026.2155).abs() < 1e-3);
}
