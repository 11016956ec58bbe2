//! The Earth's centre taken into the orbit filter, and the orbit as it is reported.

use super::Sensor;
use super::record::{Events, FixRecord};
use super::timekeeping::SECOND_US;
use crate::earth::EarthFix;
use crate::frames::{Icrs, Rotation, StarPath};
use crate::orbit::OrbitState;
use crate::orbit::filter::Update;
use crate::orbit::point::{PositionFix, earth_to_icrs};
use crate::telemetry::{Event, FixFault, OrbitReport};
use nalgebra::{Matrix3, Vector3};

impl Sensor<'_> {
    /// Takes an orbit from another source (the ground), with one sigma for all axes of position and of
    /// velocity. `false`, and no change, when the state or a sigma is out of bounds.
    pub fn initialise_orbit(
        &mut self,
        state: OrbitState,
        position_sigma_km: f64,
        velocity_sigma_km_s: f64,
    ) -> bool {
        let taken =
            self.orbit.initialise(state, position_sigma_km, velocity_sigma_km_s, &self.parameters.orbit);
        if taken {
            self.fixed_us = state.time_us;
        }
        taken
    }

    /// Takes the Earth's centre, seen with an attitude of `sigma_rad` at `terrestrial_us`, into the orbit
    /// (eq. 5.4).
    #[inline(never)]
    pub(super) fn update_orbit(
        &mut self,
        fix: &EarthFix,
        sigma_rad: [f32; 3],
        attitude: &Rotation<Icrs, StarPath>,
        terrestrial_us: i64,
        events: &mut Events,
    ) -> FixRecord {
        let [x, y, z] = sigma_rad.map(|sigma| sigma * sigma);
        let attitude_covariance = Matrix3::from_diagonal(&Vector3::new(x, y, z));
        let mounting = self.star_to_earth.inverse();
        // The filter has its own account of errors that last.
        let EarthFix { centre_km, noise_km2, linearisation_km, .. } = fix;
        let to_icrs = earth_to_icrs(attitude, &mounting);
        let fix = PositionFix::new(
            centre_km,
            noise_km2,
            linearisation_km,
            &to_icrs,
            &attitude_covariance,
            &mounting,
        );
        let Some(mut position) = fix else {
            return FixRecord { nis: None, fault: Some(FixFault::Impossible) };
        };
        if let Some(state) = self.orbit.state() {
            position = position.without_aberration(&state.velocity_km_s);
        }
        let update = self.orbit.update(terrestrial_us, &position, &to_icrs, &self.parameters.orbit);
        let (event, taken, nis, fault) = match update {
            Update::Begun => (None, true, None, None),
            Update::Started => (Some(Event::OrbitStarted), true, None, None),
            Update::Restarted => (Some(Event::OrbitRestarted), true, None, None),
            Update::Accepted { nis } => (None, true, Some(nis), None),
            Update::Rejected { nis } => (Some(Event::FixRejected), false, Some(nis), None),
            Update::Refused(error) => (None, false, None, Some(error.into())),
        };
        if let Some(event) = event {
            events.note(event);
        }
        if taken {
            self.fixed_us = terrestrial_us;
        }
        FixRecord { nis, fault }
    }

    /// The orbit as it stands after this second, whose fix had the normalised innovation squared `nis`.
    #[inline(never)]
    pub(super) fn orbit_report(&mut self, nis: Option<f32>, events: &mut Events) -> Option<OrbitReport> {
        let state = self.orbit.state()?;
        let (position, velocity) = (self.orbit.position_sigma_km()?, self.orbit.velocity_sigma_km_s()?);
        let single = |value: Option<f64>| value.unwrap_or(0.0) as f32;
        let since_fix_us = state.time_us.saturating_sub(self.fixed_us).max(0);
        let settled = self.orbit.settled();
        if settled && !self.converged {
            events.note(Event::OrbitConverged);
        }
        self.converged = settled;
        Some(OrbitReport {
            position_km: state.position_km.into(),
            velocity_km_s: state.velocity_km_s.into(),
            sigma_position_km: position.map(|sigma| sigma as f32),
            sigma_velocity_km_s: velocity.map(|sigma| sigma as f32),
            correlations: self.orbit.covariance()?.motion_correlations(),
            limb_height_km: single(self.orbit.limb_height_km()),
            limb_height_sigma_km: single(self.orbit.limb_height_sigma_km()),
            nis,
            since_fix_s: (since_fix_us / SECOND_US).min(u32::MAX.into()) as u32,
            settled,
        })
    }
}
