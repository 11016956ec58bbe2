//! The Earth taken into the orbit filter, and the orbit as it is reported.

use super::Sensor;
use super::record::{Events, FixRecord, Solution};
use super::timekeeping::SECOND_US;
use crate::earth::heights::PredictedLimb;
use crate::earth::{Body, EarthFix, MAX_LIMB_POINTS};
use crate::frames::{EarthPath, Icrs, LimbHeight, Rotation, StarPath};
use crate::matrix::{symmetric_product, transposed_product};
use crate::orbit::OrbitState;
use crate::orbit::body::CentralBody;
use crate::orbit::filter::{Nis, Update};
use crate::orbit::keplerian::Keplerian;
use crate::orbit::lvlh;
use crate::orbit::motion::MotionCovariance;
use crate::orbit::parameters::Observation;
use crate::orbit::point::{PositionFix, earth_to_icrs};
use crate::order::fill;
use crate::outages::local_axes;
use crate::telemetry::{ElementsReport, Event, FixFault, LocalAttitude, OrbitReport};
use heapless::Vec;
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
            self.seal(None);
        }
        taken
    }

    /// Takes the Earth, seen with an attitude of `sigma_rad` at `terrestrial_us`, into the orbit: the
    /// heights of its limb points where the orbit is known and takes these, else its centre (eq. 5.4).
    #[inline(never)]
    pub(super) fn update_orbit(
        &mut self,
        (fix, body): (&EarthFix, &Body),
        sigma_rad: [f32; 3],
        attitude: &Rotation<Icrs, StarPath>,
        terrestrial_us: i64,
        events: &mut Events,
    ) -> FixRecord {
        let attitude_covariance = covariance_rad2(sigma_rad);
        let mounting = self.mounting().inverse();
        let to_icrs = earth_to_icrs(attitude, &mounting);
        let heights = self.parameters.orbit.observation == Observation::LimbHeights;
        if let Some(state) = self.orbit.state().filter(|_| heights) {
            let centre_km = transposed_product(&to_icrs, &state.position_km).map(|axis| -axis as f32);
            let in_path = self.in_earth_path(&attitude_covariance);
            let Some(limb) = PredictedLimb::new(&centre_km, body) else {
                return FixRecord { nis: None, fault: Some(FixFault::Impossible) };
            };
            let heights = limb.heights(&self.workspace.shared.readout().rays);
            let mut seen = Vec::<LimbHeight, MAX_LIMB_POINTS>::new();
            // There are no more points than room.
            fill(&mut seen, heights);
            self.orbit.observe_limb(&seen, body.radius_km(), &to_icrs, &in_path, &self.parameters.orbit);
            return FixRecord::default();
        }
        let EarthFix { centre_km, covariance_km2, noise_km2, linearisation_km, .. } = fix;
        let shared_km2 = covariance_km2 - noise_km2;
        let fix = PositionFix::new(
            centre_km,
            [noise_km2, &shared_km2],
            linearisation_km,
            &to_icrs,
            &attitude_covariance,
            &mounting,
        );
        let Some(position) = fix else {
            return FixRecord { nis: None, fault: Some(FixFault::Impossible) };
        };
        let parameters = &self.parameters.orbit;
        let update = match self.orbit.state() {
            Some(state) => {
                let position = position.without_aberration(&state.velocity_km_s);
                self.orbit.update_by_fix(&position, &to_icrs, parameters)
            }
            None => self.orbit.begin(terrestrial_us, &position, &to_icrs, parameters),
        };
        self.note_update(update, terrestrial_us, events)
    }

    /// From the star path to the Earth path: as the parameters have it, turned by what the orbit has learned.
    pub(super) fn mounting(&self) -> Rotation<StarPath, EarthPath> {
        self.star_to_earth.turned(&self.orbit.misalignment_rad())
    }

    /// A covariance in star path axes as the Earth path has it.
    pub(super) fn in_earth_path(&self, covariance: &Matrix3<f32>) -> Matrix3<f32> {
        symmetric_product(self.mounting().matrix(), covariance)
    }

    /// Records what an observation came to.
    pub(super) fn note_update(
        &mut self,
        update: Update,
        terrestrial_us: i64,
        events: &mut Events,
    ) -> FixRecord {
        let (event, taken, nis, fault) = match update {
            Update::Collected | Update::Gathered => (None, false, None, None),
            Update::Started => (Some(Event::OrbitStarted), true, None, None),
            Update::Accepted(nis) => (None, true, Some(nis), None),
            Update::Downweighted(nis) => (Some(Event::FixDownweighted), false, Some(nis), None),
            Update::Diverged(nis) => (Some(Event::OrbitRestarted), false, Some(nis), None),
            Update::Refused(error) => (None, false, None, Some(error.into())),
        };
        if let Some(event) = event {
            events.note(event);
        }
        if taken {
            self.fixed_us = terrestrial_us;
        }
        if matches!(update, Update::Diverged(_)) {
            self.forget_orbit();
        }
        FixRecord { nis, fault }
    }

    /// The orbit as it stands after this second, whose observation had the normalised innovation squared
    /// `nis`.
    #[inline(never)]
    pub(super) fn orbit_report(&mut self, nis: Option<Nis>, events: &mut Events) -> Option<OrbitReport> {
        let state = self.orbit.state()?;
        let covariance = self.orbit.motion_covariance()?;
        let [limb_height_km, limb_height_sigma_km] = self.orbit.limb_height_km()?;
        let since_fix_us = state.time_us.saturating_sub(self.fixed_us).max(0);
        let settled = self.orbit.settled();
        if settled && !self.converged {
            events.note(Event::OrbitConverged);
        }
        self.converged = settled;
        Some(OrbitReport {
            position_km: state.position_km.into(),
            velocity_km_s: state.velocity_km_s.into(),
            sigma_position_km: covariance.position_sigma_km(),
            sigma_velocity_km_s: covariance.velocity_sigma_km_s(),
            correlations: covariance.correlations(),
            sigma_hill_km: sigma_hill_km(state, &covariance).unwrap_or_default(),
            elements: elements_report(self.parameters.orbit.body, state),
            limb_height_km,
            limb_height_sigma_km,
            misalignment_rad: self.orbit.misalignment_rad().into(),
            misalignment_sigma_rad: self.orbit.misalignment_sigma_rad()?,
            nis: nis.map(|nis| nis.square),
            nis_freedom: nis.map_or(0, |nis| nis.freedom),
            since_fix_s: (since_fix_us / SECOND_US).min(u32::MAX.into()) as u32,
            settled,
        })
    }

    /// The attitude against the local vertical.
    #[inline(never)]
    pub(super) fn local_attitude(&self, solution: Option<&Solution>) -> Option<LocalAttitude> {
        let attitude = Rotation::<Icrs, StarPath>::from_quaternion(solution?.attitude.quaternion)?;
        let to_star_path = local_axes(self.orbit.state()?)?.inverse().then(&attitude);
        let path = to_star_path.then(&self.mounting());
        // Rows: the Earth path's axes in LVLH.
        let axes = path.matrix();
        Some(LocalAttitude {
            quaternion: to_star_path.quaternion(),
            nadir_rad: libm::atan2f(libm::sqrtf(axes.m31 * axes.m31 + axes.m32 * axes.m32), axes.m33),
            yaw_rad: libm::atan2f(axes.m12, axes.m11),
        })
    }
}

/// Covariance of an attitude of these standard deviations about the star path's axes, rad².
pub(super) fn covariance_rad2(sigma_rad: [f32; 3]) -> Matrix3<f32> {
    let [x, y, z] = sigma_rad.map(|sigma| sigma * sigma);
    Matrix3::from_diagonal(&Vector3::new(x, y, z))
}

/// Sigmas of the position along Hill's axes, km.
fn sigma_hill_km(state: &OrbitState, covariance: &MotionCovariance) -> Option<[f32; 3]> {
    let axes = lvlh::hill(&state.position_km, &state.velocity_km_s)?.map(|element| element as f32);
    let turned = symmetric_product(&axes, &covariance.position_km2().map(|element| element as f32));
    Some(turned.diagonal().map(|variance| libm::sqrtf(variance.max(0.0))).into())
}

/// The orbit in Kepler's elements.
fn elements_report(body: CentralBody, state: &OrbitState) -> Option<ElementsReport> {
    let elements = Keplerian::of(body.facts().mu_km3_s2, &state.position_km, &state.velocity_km_s)?;
    Some(ElementsReport {
        semi_major_axis_km: elements.semi_major_axis_km,
        eccentricity: elements.eccentricity as f32,
        inclination_rad: elements.inclination_rad as f32,
        node_rad: elements.node_rad as f32,
        perigee_rad: elements.perigee_rad as f32,
        anomaly_rad: elements.anomaly_rad as f32,
    })
}
