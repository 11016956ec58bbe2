//! Where a satellite is by one real picture of the Earth: three geostationary ones, of known longitude.
//!
//! `sil-host earth` gives the Earth's direction and distance in the camera's axes. On these grids the axis
//! points at the Earth's centre and a side is east: an attitude as good as their projection. Truth: the
//! equator at the satellite's longitude, 42,164 km from the centre. The longitudes are held against a place
//! of a coast in each picture, read from it by eye to a pixel or two. GOES-16 stood at 89.5 deg W until
//! 30 November 2017, and its picture is one of that time.
//!
//! The three hours of GOES-15 are one series: half, gibbous, full, as the terminator goes over the disc.

use crate::earth_pictures::folder;
use crate::earth_real::{Camera, GOES15, GOES16, METEOSAT, NORTH, earth, number};
use sil_host::formats::picture::Picture;
use sil_host::report::chart::{Axis, Chart, Series};
use sil_host::world::attitude::{Vector, apply, dot, rotation};
use sil_host::world::time::ephemeris::{icrs_to_equator, sidereal_angle, sun_km};
use sil_host::world::vector::{angle, length, minus, plus, times, unit};
use system_tests::data;

const RADIUS_KM: f64 = 42_164.0;
const EARTH_KM: f64 = 6378.137;
/// Flattening.
const FLATTENING: f64 = 1.0 / 298.257;
/// A pixel of the disc is lit above this grey of 255.
const LIT: u16 = 5;

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

    /// The Sun in axes that turn with the Earth, unit; of a picture whose time is known.
    fn sun(&self) -> Option<Vector> {
        // 6442 days after J2000.0 it was noon; TT - UTC = 69.184 s.
        let time_us = ((6442.0 * 86_400.0 + self.utc_s? - 43_200.0 + 69.184) * 1e6) as i64;
        let turn = rotation(2, sidereal_angle(time_us));
        Some(unit(apply(&turn, apply(&icrs_to_equator(time_us), sun_km(time_us)))))
    }

    /// The side of the Sun on the picture, unit.
    fn sun_side(&self) -> [f64; 2] {
        let Some(sun) = self.sun() else { return self.sun_side };
        let [x, y, _] = apply(&self.axes(), sun);
        [x, y].map(|part| part / x.hypot(y))
    }

    /// Angle between Sun and satellite at the Earth, deg; of a picture whose time is known.
    fn phase_deg(&self) -> Option<f64> {
        Some(angle(self.sun()?, self.up_east_north()[0]).to_degrees())
    }

    /// The position by the Earth's direction, camera axes, and distance less the truth, km: up, east, north.
    fn error_km(&self, direction: Vector, distance_km: f64) -> [f64; 3] {
        let axes = self.axes();
        let to_earth = (0..3).fold([0.0; 3], |sum, k| plus(sum, direction[k], axes[k]));
        let local = self.up_east_north();
        let error = minus(times(-distance_km, to_earth), times(RADIUS_KM, local[0]));
        local.map(|axis| dot(error, axis))
    }

    /// What one picture says of the position; none without the data.
    fn placed(&self, test: &str) -> Option<Placed> {
        let answer = earth(test, self.picture, &self.camera, &NORTH)?;
        let direction = [0, 1, 2].map(|k| number(&answer["direction"][k]));
        let distance_km = number(&answer["distance_km"]);
        Some(Placed {
            direction,
            distance_km,
            error_km: self.error_km(direction, distance_km),
            sigma_km: number(&answer["sigma_deg"]).to_radians() * distance_km,
            sigma_along_km: number(&answer["sigma_distance_km"]),
        })
    }

    /// Share of the disc's pixels that are lit.
    fn lit_share(&self) -> Option<f64> {
        let picture = Picture::load(&data(&format!("earth/{}", self.picture))?).unwrap();
        let width = usize::from(fsw_hal::Detector::geometry(&picture).width_px);
        let [cx, cy] = self.camera.centre_px;
        let radius = 0.97 * self.camera.focal_length_px * (EARTH_KM / RADIUS_KM).asin();
        let at = |k: usize| ((k % width) as f64 - cx, (k / width) as f64 - cy);
        let disc = picture.pixels().iter().enumerate().filter(|(k, _)| at(*k).0.hypot(at(*k).1) < radius);
        let (lit, all) = disc.fold((0, 0), |(lit, all), (_, v)| (lit + u32::from(*v > LIT), all + 1));
        Some(f64::from(lit) / f64::from(all))
    }
}

/// A position by one picture.
struct Placed {
    direction: Vector,
    distance_km: f64,
    /// Less the truth: up, east, north.
    error_km: [f64; 3],
    /// Stated, an axis across and along.
    sigma_km: f64,
    sigma_along_km: f64,
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
        let Some(placed) = seen.placed("positions") else { return };
        let Placed { direction, distance_km, error_km: [along, east, north], sigma_km, sigma_along_km } =
            placed;
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

#[test]
fn the_hours_of_goes_15_place_it_alike_whatever_the_terminator_does() {
    println!(
        "hour, phase, lit share of the disc (by the phase); east, north, up, km; sigma across, along, km"
    );
    let mut hours = Vec::new();
    for seen in &SEEN[..3] {
        let Some(placed) = seen.placed("hours") else { return };
        let (utc_h, phase_deg) = (seen.utc_s.unwrap() / 3600.0, seen.phase_deg().unwrap());
        let (lit, by_phase) = (seen.lit_share().unwrap(), 0.5 * (1.0 + phase_deg.to_radians().cos()));
        let [up, east, north] = placed.error_km;
        let (sigma, sigma_up) = (placed.sigma_km, placed.sigma_along_km);
        println!(
            "{utc_h:.1} h, {phase_deg:.1} deg, {lit:.3} ({by_phase:.3}); {east:+.1}, {north:+.1}, {up:+.1}; \
             {sigma:.1}, {sigma_up:.1}"
        );
        // Beside the terminator sea is lit and darker than the grey that counts: 0.07 of the half disc.
        assert!((lit - by_phase).abs() < 0.1, "the terminator is not where the hour says");
        assert!(east.abs().max(north.abs()) <= 3.0 * sigma && up.abs() <= 3.0 * sigma_up && sigma < 60.0);
        hours.push((utc_h, placed));
    }
    // One pixel of the picture is 27 km of position: the joint fit of the grid is known to a third of one.
    for axis in [1, 2] {
        let values = || hours.iter().map(|(_, placed)| placed.error_km[axis]);
        let spread = values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min);
        println!("spread over the hours, {}: {spread:.1} km", ["east", "north"][axis - 1]);
        assert!(spread < 20.0);
    }
    let path = folder().join("goes-15-hours.svg");
    std::fs::write(&path, chart(&hours).svg()).unwrap();
    println!("plot in {}", path.display());
}

/// Errors over the hours, UTC, with their sigmas.
fn chart(hours: &[(f64, Placed)]) -> Chart {
    let series = [("east", 1), ("north", 2), ("up", 0)].map(|(name, axis)| {
        let at = |(hour, placed): &(f64, Placed)| [*hour, placed.error_km[axis]];
        let band = |(hour, placed): &(f64, Placed)| {
            let sigma = if axis == 0 { placed.sigma_along_km } else { placed.sigma_km };
            [*hour, placed.error_km[axis] - sigma, placed.error_km[axis] + sigma]
        };
        let name = format!("ours, {name}, with its sigma");
        Series::ours(name, hours.iter().map(at).collect()).marked().within(hours.iter().map(band).collect())
    });
    let level = |name, km: f64| Series::thesis(name, vec![[hours[0].0, km], [hours[2].0, km]]);
    let told = [level("thesis, point solution in GEO, 1 sigma", 60.0), level("", -60.0)];
    Chart {
        title: "GOES-15 by one picture of the Earth: half, gibbous, full".into(),
        x: Axis::new("21 August 2017, UTC, h"),
        y: Axis::new("position less the truth, km"),
        series: series.into_iter().chain(told).collect(),
    }
}
