//! The estimated quantities that are judged, each declared once.

use super::second::{Axes, Judged};
use crate::world::attitude::Vector;
use crate::world::scene::SensorState;

/// A quantity of which every second gives an error and a reported sigma.
#[derive(Debug)]
pub struct Quantity {
    /// Key in `summary.json`.
    pub key: &'static str,
    /// What it is, for people.
    pub words: &'static str,
    /// Unit of its figures.
    pub unit: &'static str,
    /// What one of the judge's own units (rad, rad/s, km, km/s) is in it.
    pub scale: f64,
    /// Axes that count.
    pub axes: usize,
    /// Its error in a second.
    pub of: fn(&Judged) -> Option<Axes>,
    /// Its independent deviates, where the axes are correlated.
    pub deviates: Option<fn(&Judged) -> Option<Vector>>,
}

const ARCSEC: f64 = 3600.0 * 180.0 / std::f64::consts::PI;
const DEG: f64 = 180.0 / std::f64::consts::PI;

const fn quantity(
    key: &'static str,
    words: &'static str,
    (unit, scale): (&'static str, f64),
    axes: usize,
    of: fn(&Judged) -> Option<Axes>,
) -> Quantity {
    Quantity { key, words, unit, scale, axes, of, deviates: None }
}

/// Attitude is judged while the Sun does not blind the detector, and by itself while it does; position and
/// velocity from the first orbit on, for their sigmas must hold even while the filter converges, along the
/// true radial, along-track and cross-track axes with the reported correlations.
pub const QUANTITIES: [Quantity; 10] = [
    quantity("attitude", "Attitude", ("arcsec", ARCSEC), 3, |of| of.attitude_rad.filter(|_| !of.sun())),
    quantity("filtered", "Filtered attitude", ("arcsec", ARCSEC), 3, |of| {
        of.filtered_rad.filter(|_| !of.sun())
    }),
    quantity("sun_attitude", "Attitude in Sun outages", ("arcsec", ARCSEC), 3, |of| {
        of.attitude_rad.filter(|_| of.sun())
    }),
    quantity("rate", "Rate without an attitude", ("deg/s", DEG), 3, |of| Some(of.turning?.rad_s)),
    Quantity {
        deviates: Some(|of| Some(of.earth?.direction_rad.deviates)),
        ..quantity("earth_direction", "Earth's direction", ("deg", DEG), 2, |of| {
            Some(of.earth?.direction_rad.axes)
        })
    },
    quantity("earth_distance", "Earth's distance", ("km", 1.0), 1, |of| {
        let earth = of.earth?;
        Some(Axes { error: [earth.distance_km, 0.0, 0.0], sigma: [earth.sigma_km; 3] })
    }),
    Quantity {
        deviates: Some(|of| Some(of.orbit?.position_km.deviates)),
        ..quantity("position", "Position", ("km", 1.0), 3, |of| Some(of.orbit?.position_km.axes))
    },
    Quantity {
        deviates: Some(|of| Some(of.orbit?.velocity_km_s.deviates)),
        ..quantity("velocity", "Velocity", ("m/s", 1e3), 3, |of| Some(of.orbit?.velocity_km_s.axes))
    },
    Quantity {
        deviates: Some(|of| Some(of.orbit?.position_km.deviates)),
        ..quantity("dark_position", "Position in eclipse and Sun", ("km", 1.0), 3, |of| {
            of.orbit.filter(|_| of.state != SensorState::Full).map(|orbit| orbit.position_km.axes)
        })
    },
    quantity("mounting", "Mounting of the paths", ("arcsec", ARCSEC), 3, |of| of.mounting_rad),
];

/// Seconds until the sensor's next change of state: no second by itself gives its error, which
/// [`foreseen`](super::foreseen) knows when the run is over.
pub const NEXT_STATE: Quantity = quantity("next_state", "Next change of state", ("s", 1.0), 1, |_| None);
