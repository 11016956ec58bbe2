//! Where a satellite is by one real picture of the Earth: three geostationary ones, of known longitude.
//!
//! `sil-host earth` gives the Earth's direction and distance in the camera's axes. On these grids the axis
//! points at the Earth's centre and a side is east: an attitude as good as their projection. Truth: the
//! equator at the satellite's longitude, 42,164 km from the centre. The longitudes are held against a place
//! of a coast in each picture, read from it by eye to a pixel or two. GOES-16 stood at 89.5 deg W until
//! 30 November 2017, and its picture is one of that time.

use crate::earth_real::{Camera, GOES15, GOES16, METEOSAT, NORTH, earth, number};
use sil_host::world::attitude::{Vector, apply, dot, rotation};
use sil_host::world::time::ephemeris::{icrs_to_equator, sidereal_angle, sun_km};
use sil_host::world::vector::{length, minus, plus, times, unit};

const RADIUS_KM: f64 = 42_164.0;
const EARTH_KM: f64 = 6378.137;
/// Flattening.
const FLATTENING: f64 = 1.0 / 298.257;

/// A satellite and a picture of it.
struct Seen {
    name: &'static str,
    picture: &'static str,
    camera: Camera,
    longitude_deg: f64,
    /// Whether north is up; else south is.
    north_up: bool,
    /// Seconds of 2017-08-21 (UTC), where the time is known.
    utc_s: Option<f64>,
    /// The side of the Sun on the picture, by its terminator, where the time is not known.
    sun_side: [f64; 2],
    /// A place: latitude and longitude, deg, and where it is on the picture, px.
    place: ([f64; 2], [f64; 2]),
}

/// Cape San Lucas, Arica, the end of the gulf of Suez.
const CAPE: ([f64; 2], [f64; 2]) = ([22.88, -109.91], [338.3, 142.0]);
const ARICA: ([f64; 2], [f64; 2]) = ([-18.48, -70.33], [350.0, 351.0]);
const SUEZ: ([f64; 2], [f64; 2]) = ([29.95, 32.55], [181.3, 569.3]);

const GOES_15: Seen = Seen {
    name: "GOES-15, half",
    picture: "goestools/GOES15_FD_VS_20170821T1506Z.png",
    camera: GOES15,
    longitude_deg: -135.0,
    north_up: true,
    utc_s: Some(15.1 * 3600.0),
    sun_side: [0.0; 2],
    place: CAPE,
};

const SEEN: [Seen; 5] = [
    GOES_15,
    Seen {
        name: "GOES-15, gibbous",
        picture: "goestools/GOES15_FD_VS_20170821T1806Z.png",
        utc_s: Some(18.1 * 3600.0),
        ..GOES_15
    },
    Seen {
        name: "GOES-15, full",
        picture: "goestools/GOES15_FD_VS_20170821T2106Z.png",
        utc_s: Some(21.1 * 3600.0),
        ..GOES_15
    },
    Seen {
        name: "GOES-16, half",
        picture: "pytroll/GOES16_ABI_C02_520.png",
        camera: GOES16,
        longitude_deg: -89.5,
        north_up: true,
        utc_s: None,
        sun_side: [0.99, 0.14],
        place: ARICA,
    },
    Seen {
        name: "Meteosat-10, gibbous",
        picture: "pytroll/natural_hrit.png",
        camera: METEOSAT,
        longitude_deg: 0.0,
        north_up: false,
        utc_s: None,
        sun_side: [-0.83, -0.55],
        place: SUEZ,
    },
];

impl Seen {
    /// Up, east and north at the satellite, axes that turn with the Earth.
    fn up_east_north(&self) -> [Vector; 3] {
        let (s, c) = self.longitude_deg.to_radians().sin_cos();
        [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]
    }

    /// Axes of the camera: x and y on the picture, z along the line of sight.
    fn axes(&self) -> [Vector; 3] {
        let [up, east, north] = self.up_east_north();
        let side = if self.north_up { 1.0 } else { -1.0 };
        [times(side, east), times(-side, north), times(-1.0, up)]
    }

    /// Where a direction is on the picture, px.
    fn pixel(&self, direction: Vector) -> [f64; 2] {
        let [x, y, z] = apply(&self.axes(), direction);
        let across = x.hypot(y);
        let scale = self.camera.focal_length_px * across.atan2(z) / across;
        let [cx, cy] = self.camera.centre_px;
        [cx + scale * x, cy + scale * y]
    }

    /// The side of the Sun on the picture, unit.
    fn sun_side(&self) -> [f64; 2] {
        let Some(utc_s) = self.utc_s else { return self.sun_side };
        // 6442 days after J2000.0 it was noon; TT - UTC = 69.184 s.
        let time_us = ((6442.0 * 86_400.0 + utc_s - 43_200.0 + 69.184) * 1e6) as i64;
        let turn = rotation(2, sidereal_angle(time_us));
        let sun = unit(apply(&turn, apply(&icrs_to_equator(time_us), sun_km(time_us))));
        let [x, y, _] = apply(&self.axes(), sun);
        [x, y].map(|part| part / x.hypot(y))
    }
}

#[test]
fn the_longitudes_are_those_of_the_pictures() {
    for seen in &SEEN {
        let ([latitude_deg, longitude_deg], at_px) = seen.place;
        let (s, c) = latitude_deg.to_radians().sin_cos();
        let (east, towards) = longitude_deg.to_radians().sin_cos();
        let squeezed = (1.0 - FLATTENING).powi(2);
        let normal_km = EARTH_KM / (c * c + squeezed * s * s).sqrt();
        let place = times(normal_km, [c * towards, c * east, squeezed * s]);
        let [up, ..] = seen.up_east_north();
        let [x, y] = seen.pixel(minus(place, times(RADIUS_KM, up)));
        let off_px = (x - at_px[0]).hypot(y - at_px[1]);
        println!("{}: the place is {off_px:.1} px from where it is seen", seen.name);
        // Half a degree of longitude is two pixels.
        assert!(off_px < 2.0, "{}: {x:.1} {y:.1}", seen.name);
    }
}

#[test]
fn one_picture_gives_a_position_within_20_km_across() {
    println!(
        "position by one picture less the truth, km: east, north, up; sigma across, along; towards the Sun"
    );
    let mut square = 0.0;
    for seen in &SEEN {
        let Some(answer) = earth("positions", seen.picture, &seen.camera, &NORTH) else { return };
        let direction = [0, 1, 2].map(|k| number(&answer["direction"][k]));
        let distance_km = number(&answer["distance_km"]);
        let axes = seen.axes();
        let to_earth = (0..3).fold([0.0; 3], |sum, k| plus(sum, direction[k], axes[k]));
        let [up, east, north] = seen.up_east_north();
        let error = minus(times(-distance_km, to_earth), times(RADIUS_KM, up));
        let [along, east, north] = [up, east, north].map(|axis| dot(error, axis));
        let sigma_km = number(&answer["sigma_deg"]).to_radians() * distance_km;
        let sigma_along_km = number(&answer["sigma_distance_km"]);
        let side = seen.sun_side();
        let towards_deg = (direction[0] * side[0] + direction[1] * side[1]).to_degrees();
        println!(
            "{:21} {east:+6.1} {north:+6.1} {along:+7.1}; {sigma_km:5.1} {sigma_along_km:6.1}; \
             {towards_deg:+.4} deg, {:+.1} km",
            seen.name,
            towards_deg.to_radians() * distance_km
        );
        assert!(length([east, north, 0.0]) <= 20.0, "{}", seen.name);
        assert!(east.abs().max(north.abs()) <= 3.0 * sigma_km && along.abs() <= 3.0 * sigma_along_km);
        // The thesis has 60 to 70 km.
        assert!(sigma_km < 60.0);
        square += (east.powi(2) + north.powi(2)) / (10.0 * sigma_km.powi(2));
    }
    println!("mean of (error / sigma)² across: {square:.2}");
}
