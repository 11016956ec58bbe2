//! Protons: how many hit the detector where, and what a hit leaves.
//!
//! In: the satellite's position, the detector's size, an exposure, a seed and cycle. Out: a mean number of
//! hits, and the charge each leaves in pixels.
//!
//! Flux. Everywhere [`BACKGROUND_CM2_S`] of cosmic rays. In the South Atlantic anomaly a Gaussian about
//! `SAA_CENTRE_DEG` with the widths `SAA_WIDTH_DEG` in latitude and longitude, its peak by altitude from
//! `SAA_PEAK_CM2_S` with the logarithm interpolated: orders of magnitude of AP8-MIN for protons above some 10
//! MeV, which a few millimetres of aluminium let through; a factor of 2 or 3 either way, as between solar
//! minimum and maximum. None below 300 km; above 2000 km the anomaly is no longer one, and orbits within the
//! belts are not modelled.
//!
//! A hit. Directions are even over the half sphere, so those through a plane have an even cos². The track
//! crosses `DEPTH_UM` of silicon in which charge is collected, hence `depth · tan` of detector, and leaves
//! `CHARGE_E_UM` electrons a µm (the logarithm even: from a minimum ionising proton to one of 20 MeV) along
//! the way, shared among the pixels below. The charge does not spread sideways, and its own fluctuation is
//! left out.

use super::deposits::{Deposit, Deposits};
use crate::world::motion::trajectory::Truth;
use crate::world::noise::{Noise, Stream};
use crate::world::time::ephemeris;
use crate::world::vector::length;
use fsw_core::orbit::body::CentralBody;
use fsw_hal::DetectorGeometry;
use std::f64::consts::TAU;
use std::fmt;

/// Cosmic rays, 1/cm²/s.
pub const BACKGROUND_CM2_S: f64 = 4.0;
/// Middle of the anomaly: geocentric latitude, east longitude, degrees.
const SAA_CENTRE_DEG: [f64; 2] = [-27.0, -48.0];
/// Its widths (standard deviations), degrees.
const SAA_WIDTH_DEG: [f64; 2] = [10.0, 21.0];
/// Altitude (km) and flux in its middle, 1/cm²/s.
const SAA_PEAK_CM2_S: [(f64, f64); 5] =
    [(300.0, 60.0), (500.0, 1.0e3), (800.0, 5.0e3), (1400.0, 2.5e4), (2000.0, 6.0e4)];
/// Mean radius of the Earth, km.
const EARTH_KM: f64 = 6371.0;
/// Depth of silicon from which charge is collected, µm.
const DEPTH_UM: f64 = 10.0;
/// Charge along a track, e-/µm.
const CHARGE_E_UM: (f64, f64) = (80.0, 2000.0);
/// Longest track drawn, px.
const TRACK_PX_MAX: f64 = 64.0;
/// Parts of a pixel's side by which a track is followed.
const STEPS_PER_PX: f64 = 4.0;
/// Most hits drawn in an exposure.
const HITS_MAX: f64 = 1e6;

/// How many protons hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protons {
    /// So many in every exposure.
    Fixed(u32),
    /// As many as the place in the orbit makes likely.
    Orbit,
}

impl fmt::Display for Protons {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(hits) => write!(formatter, "{hits} protons"),
            Self::Orbit => formatter.write_str("protons by the place in the orbit"),
        }
    }
}

/// Protons and cosmic rays at an instant, 1/cm²/s; about Moon and Mars cosmic rays alone.
pub fn flux_cm2_s(truth: &Truth) -> f64 {
    if truth.ellipsoid.body() != CentralBody::Earth {
        return BACKGROUND_CM2_S;
    }
    let p = crate::world::attitude::apply(truth.ellipsoid.equator(), truth.position_km);
    let latitude = libm::atan2(p[2], libm::hypot(p[0], p[1])).to_degrees();
    let longitude = (libm::atan2(p[1], p[0]) - ephemeris::sidereal_angle(truth.instant_us)).to_degrees();
    BACKGROUND_CM2_S + anomaly_cm2_s([latitude, longitude], length(p) - EARTH_KM)
}

/// Protons of the anomaly at a place (latitude, longitude, degrees) and altitude.
fn anomaly_cm2_s(place_deg: [f64; 2], altitude_km: f64) -> f64 {
    let Some(pair) = SAA_PEAK_CM2_S.windows(2).find(|p| (p[0].0..=p[1].0).contains(&altitude_km)) else {
        return 0.0;
    };
    let part = (altitude_km - pair[0].0) / (pair[1].0 - pair[0].0);
    let peak = pair[0].1 * libm::pow(pair[1].1 / pair[0].1, part);
    let mut offset = [place_deg[0] - SAA_CENTRE_DEG[0], place_deg[1] - SAA_CENTRE_DEG[1]];
    offset[1] -= 360.0 * libm::rint(offset[1] / 360.0);
    let square: f64 = [0, 1].iter().map(|k: &usize| (offset[*k] / SAA_WIDTH_DEG[*k]).powi(2)).sum();
    peak * libm::exp(-0.5 * square)
}

impl Protons {
    /// Number of hits in an exposure of `time_s`; `truth` is missing where there is no orbit.
    pub fn hits(
        self,
        (seed, cycle): (u64, u64),
        truth: Option<&Truth>,
        geometry: DetectorGeometry,
        pixel_pitch_um: f64,
        time_s: f64,
    ) -> u32 {
        match self {
            Self::Fixed(hits) => hits,
            Self::Orbit => {
                let area_cm2 = geometry.whole().area() as f64 * (1e-4 * pixel_pitch_um).powi(2);
                let mean = truth.map_or(BACKGROUND_CM2_S, flux_cm2_s) * area_cm2 * time_s;
                Noise::new(seed, cycle, Stream::ProtonCount).poisson(0, 0, mean.min(HITS_MAX)) as u32
            }
        }
    }
}

/// The charge that `hits` protons of a cycle leave.
pub fn tracks(
    (seed, cycle): (u64, u64),
    hits: u32,
    geometry: DetectorGeometry,
    pixel_pitch_um: f64,
) -> Deposits {
    let noise = Noise::new(seed, cycle, Stream::Proton);
    let mut deposits: Vec<Deposit> = Vec::new();
    for index in 0..hits {
        let uniform = |k| noise.uniform(index, k);
        let (width, height) = (f64::from(geometry.width_px), f64::from(geometry.height_px));
        let (x, y) = (width * uniform(0), height * uniform(1));
        let (sin, cos) = libm::sincos(TAU * uniform(2));
        // The squared cosine of the angle to the detector's normal is even.
        let square = uniform(3);
        let length_px = (DEPTH_UM / pixel_pitch_um * ((1.0 - square) / square).sqrt()).min(TRACK_PX_MAX);
        let way_um = libm::hypot(DEPTH_UM, length_px * pixel_pitch_um);
        let charge = way_um * CHARGE_E_UM.0 * libm::pow(CHARGE_E_UM.1 / CHARGE_E_UM.0, uniform(4));
        let steps = (STEPS_PER_PX * length_px).ceil().max(1.0);
        for step in 0..steps as u32 {
            let way = length_px * (f64::from(step) + 0.5) / steps;
            let (px, py) = (x + way * cos, y + way * sin);
            if (0.0..width).contains(&px) && (0.0..height).contains(&py) {
                deposits.push(Deposit { x: px as u16, y: py as u16, electrons: charge / steps });
            }
        }
    }
    Deposits::new(deposits)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEOMETRY: DetectorGeometry = DetectorGeometry { width_px: 1280, height_px: 1024, bits: 10 };

    #[test]
    fn the_anomaly_is_over_brazil_and_grows_with_altitude() {
        let at = |place, altitude| anomaly_cm2_s(place, altitude);
        assert!((at(SAA_CENTRE_DEG, 500.0) - 1.0e3).abs() < 1e-6);
        assert!((at([-27.0, 312.0], 800.0) - 5.0e3).abs() < 1e-6);
        // Two widths away, an eighth of the peak or less.
        assert!((50.0..130.0).contains(&at([-27.0, 0.0], 500.0)));
        assert!(at([45.0, 130.0], 800.0) < 1e-6 && at(SAA_CENTRE_DEG, 200.0) == 0.0);
        assert_eq!(at(SAA_CENTRE_DEG, 36_000.0), 0.0);
        // The Hubble telescope (28.5 degrees, 550 km) spends about 15 % of its time in it.
        let inside = |k: &u32| {
            let (u, node) = (0.1 * f64::from(*k), 0.618_034 * f64::from(*k));
            let latitude = libm::asin(libm::sin(28.5f64.to_radians()) * libm::sin(u)).to_degrees();
            at([latitude, node.to_degrees()], 550.0) > 10.0
        };
        let share = (0..20_000).filter(inside).count() as f64 / 20_000.0;
        println!("share of the time in the anomaly: {share:.3}");
        assert!((0.1..0.2).contains(&share), "{share}");
    }

    #[test]
    fn hits_come_in_number_and_tracks_in_length_and_charge() {
        let tracks = tracks((1, 2), 4000, GEOMETRY, 7.5);
        let sum: f64 = tracks.as_slice().iter().map(|d| d.electrons).sum();
        // Mean of 1/cos with an even cos² is 2; of the charge a µm (2000 - 80) / ln 25.
        let expected = 4000.0 * 2.0 * DEPTH_UM * 1920.0 / 25f64.ln();
        assert!((sum / expected - 1.0).abs() < 0.1, "{sum} {expected}");
        assert!(tracks.as_slice().windows(2).all(|w| w[0].y <= w[1].y));
        assert!(tracks.as_slice().iter().all(|d| d.x < 1280 && d.y < 1024 && d.electrons > 0.0));
        let mean = |time_s: f64| {
            let count = |cycle| Protons::Orbit.hits((3, cycle), None, GEOMETRY, 7.5, time_s);
            (0..4000).map(|cycle| f64::from(count(cycle))).sum::<f64>() / 4000.0
        };
        // 4 /cm²/s on 0.737 cm².
        let expected = 4.0 * 0.7373 * 0.4;
        assert!((mean(0.4) - expected).abs() < 4.0 * (expected / 4000.0f64).sqrt());
        assert_eq!(Protons::Fixed(7).hits((3, 1), None, GEOMETRY, 7.5, 0.4), 7);
    }
}
