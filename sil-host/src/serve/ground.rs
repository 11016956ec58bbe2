//! Directions as places on the turning body, for drawings.
//!
//! In: a direction from the body's centre, ICRS axes, any length; an instant, TT, us since J2000. Out:
//! geocentric latitude and east longitude (-180 to 180), degrees. The equator is that of the run's start and
//! the body turns evenly since: in ten days that is wrong by less than 2 arcsec, of the Moon by 0.7 deg.

use crate::world::attitude::{Vector, apply};
use crate::world::body::{icrs_to_equator, meridian_rad};
use fsw_core::orbit::body::CentralBody;

/// The turning body of a run.
#[derive(Clone, Debug)]
pub struct Ground {
    body: CentralBody,
    start_us: i64,
    /// ICRS to the equator of the start.
    equator: [Vector; 3],
    /// Angle to the prime meridian at the start, rad.
    angle_rad: f64,
}

impl Ground {
    /// That of a run which starts at this instant.
    pub fn new(body: CentralBody, start_us: i64) -> Self {
        let equator = icrs_to_equator(body, start_us);
        Self { body, start_us, equator, angle_rad: meridian_rad(body, start_us) }
    }

    /// The body.
    pub fn body(&self) -> CentralBody {
        self.body
    }

    /// Latitude and longitude below a direction, degrees.
    pub fn place_deg(&self, direction: Vector, instant_us: i64) -> [f64; 2] {
        let [x, y, z] = apply(&self.equator, direction);
        let turned =
            self.angle_rad + self.body.facts().rate_rad_s * 1e-6 * (instant_us - self.start_us) as f64;
        let longitude = (libm::atan2(y, x) - turned).to_degrees();
        [libm::atan2(z, libm::hypot(x, y)).to_degrees(), longitude - 360.0 * libm::rint(longitude / 360.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::time::civil_time::tt_us;
    use crate::world::time::ephemeris;

    #[test]
    fn the_sun_stands_over_greenwich_at_noon_and_over_the_tropic_in_june() {
        // The equation of time is -1.8 min on 21 June, which is 0.45 deg.
        let noon = tt_us("2026-06-21T12:00:00").unwrap();
        let ground = Ground::new(CentralBody::Earth, noon - 5 * 86_400_000_000);
        let [latitude, longitude] = ground.place_deg(ephemeris::sun_km(noon), noon);
        assert!((latitude - 23.44).abs() < 0.05 && (longitude - 0.45).abs() < 0.1, "{latitude} {longitude}");
        let [_, evening] = ground.place_deg(ephemeris::sun_km(noon), noon + 6 * 3_600_000_000);
        assert!((longitude - evening - 90.2).abs() < 0.2, "{evening}");
    }
}
