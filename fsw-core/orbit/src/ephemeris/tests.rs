use super::*;
use crate::oracle::wide;
use crate::reference::time_us;

/// Time (TT, us); Sun (km), Moon (km), barycentric velocity of the Earth (km/s) by ERFA's `epv00` and
/// `moon98`; pole of date with nutation (X, Y) by `xys06a`.
type Row = (i64, [f64; 3], [f64; 3], [f64; 3], [f64; 2]);
const ERFA: [Row; 5] = [
    (
        31460261000000,
        [23584505.0, -133221325.0, -57758481.0],
        [356924.0, -161721.0, -99816.0],
        [-29.8804, -4.4987, -1.9500],
        [0.0000657, -0.0000143],
    ),
    (
        345677760000000,
        [-17570178.0, -134130552.0, -58147877.0],
        [389827.0, 67966.0, 69085.0],
        [-30.0560, 3.1385, 1.3609],
        [0.0010963, -0.0000009],
    ),
    (
        737625597000000,
        [83846258.0, 115540039.0, 50085053.0],
        [315711.0, 194575.0, 84489.0],
        [24.3224, -15.2742, -6.6226],
        [0.0022510, 0.0000306],
    ),
    (
        1125080928000000,
        [-135119616.0, 62203441.0, 26962997.0],
        [94694.0, 339515.0, 110634.0],
        [12.8964, 24.3149, 10.5388],
        [0.0034508, -0.0000533],
    ),
    (
        1569892320000000,
        [-148661560.0, -17064098.0, -7394322.0],
        [-254085.0, -259802.0, -120553.0],
        [-4.1798, 27.0273, 11.7128],
        [0.0048612, -0.0000449],
    ),
];

#[test]
fn sun_moon_pole_and_velocity_keep_to_their_stated_errors() {
    for (time, sun, moon, velocity, [x, y]) in ERFA {
        let bodies = Bodies::at(CentralBody::Earth, time);
        let (sun, moon) = (Vector3::from(sun), Vector3::from(moon));
        assert!(sun.angle(&bodies.sun_km).to_degrees() < 0.007);
        assert!((sun.norm() / bodies.sun_km.norm() - 1.0).abs() < 6e-5);
        assert!(sun.angle(&wide(sun_direction(CentralBody::Earth, time).vector())).to_degrees() < 0.01);
        assert!(moon.angle(&bodies.neighbour_km).to_degrees() < 0.1);
        assert!((moon.norm() - bodies.neighbour_km.norm()).abs() < 600.0);
        assert!((Vector3::from(velocity) - velocity_km_s(CentralBody::Earth, time)).norm() < 0.03);
        assert!((bodies.pole.x - x).hypot(bodies.pole.y - y) < 0.6 * RAD_PER_ARCSEC);
        assert!((wide(pole(CentralBody::Earth, time).vector()) - bodies.pole).norm() < 2e-7);
    }
}

/// The seasons, to the minute (UTC), and the Sun's apparent longitude of date.
#[test]
fn the_seasons_begin_on_time() {
    for (days, hours, longitude) in [
        (79.0, 7.0 + 35.0 / 60.0, 0.0),       // 2000-03-20 07:35
        (7_476.0, 21.0 + 44.0 / 60.0, 90.0),  // 2020-06-20 21:44
        (8_025.0, 15.0 + 59.0 / 60.0, 270.0), // 2021-12-21 15:59
        (8_845.0, 3.0 + 6.0 / 60.0, 0.0),     // 2024-03-20 03:06
    ] {
        let time = time_us(days + hours / 24.0 - 0.5, 67.0);
        let sun = Bodies::at(CentralBody::Earth, time).sun_km;
        let (sine, cosine) = (84_381.406 * RAD_PER_ARCSEC).sin_cos();
        let of_j2000 = (cosine * sun.y + sine * sun.z).atan2(sun.x).to_degrees();
        // General precession 50.29 arcsec a year, aberration 20.5 arcsec.
        let apparent = of_j2000 + (5_029.0 * centuries(time) - 20.5) / 3600.0;
        let late = (apparent - longitude + 540.0).rem_euclid(360.0) - 180.0;
        assert!(late.abs() < 0.012, "{longitude}: {late}");
    }
}

/// Greatest eclipse (TT): the axis of the shadow misses the Earth's centre by `gamma` radii, so the
/// directions to Sun and Moon are apart by about `gamma` horizontal parallaxes of the Moon.
#[test]
fn eclipses_happen() {
    for (days, hours, gamma, opposite) in [
        (6_442.0, 18.0 + 26.7 / 60.0, 0.4367, false), // 2017-08-21 solar
        (8_864.0, 18.0 + 18.5 / 60.0, 0.3431, false), // 2024-04-08 solar
        (6_782.0, 20.0 + 22.9 / 60.0, 0.1168, true),  // 2018-07-27 lunar
    ] {
        let Bodies { sun_km, neighbour_km: moon_km, .. } =
            Bodies::at(CentralBody::Earth, time_us(days + hours / 24.0 - 0.5, 0.0));
        let apart = moon_km.angle(&if opposite { -sun_km } else { sun_km });
        let expected = gamma * 6_378.137 / moon_km.norm();
        assert!(
            (apart - expected).abs().to_degrees() < 0.1,
            "{} {}",
            apart.to_degrees(),
            expected.to_degrees()
        );
    }
}

#[test]
fn any_time_gives_finite_bodies() {
    for time in [i64::MIN, -1, 0, 1, i64::MAX] {
        let Bodies { sun_km, neighbour_km: moon_km, pole, .. } = Bodies::at(CentralBody::Earth, time);
        assert!((sun_km + moon_km + pole).iter().all(|x| x.is_finite()));
    }
}
