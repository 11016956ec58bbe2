//! The Earth's half of a second: limb, centre, position, orbit.

use super::{Instruments, Sensor, Sky};
use crate::frames::{Icrs, Rotation, StarPath};
use crate::orbit::filter::Update;
use crate::orbit::point::{PositionFix, earth_to_icrs};
use crate::telemetry::{EarthReport, EarthStatus, Event, Fault, OrbitReport, Report, Status};
use fsw_hal::{Clock, Detector, DetectorError, Stage, StageMeter};
use nalgebra::{Matrix3, Vector3};

pub(super) struct View;
impl View {
    pub fn lit_at(&self, _: &crate::frames::Direction<crate::frames::EarthPath>) -> bool {
        false
    }
}

impl Sensor<'_> {
    pub(super) fn view(&self, _sky: &Sky, _attitude: &Rotation<Icrs, StarPath>) -> Option<View> {
        None
    }
    /// Looks for the Earth in the image of this second, whose attitude is known, and takes its centre into the orbit.
    #[inline(never)]
    pub(super) fn look_at_earth(
        &mut self,
        _instruments: &mut Instruments<impl Detector, impl Clock, impl StageMeter>,
        _sky: &Sky,
        _attitude: &Rotation<Icrs, StarPath>,
        _report: &mut Report,
    ) {
    }
    /// Reports the orbit as it stands after this second.
    #[inline(never)]
    pub(super) fn report_orbit(&mut self, report: &mut Report) {
        let (Some(state), Some(position), Some(velocity)) =
            (self.orbit.state(), self.orbit.position_sigma_km(), self.orbit.velocity_sigma_km_s())
        else {
            return;
        };
        let single = |value: Option<f64>| value.unwrap_or(0.0) as f32;
        let since_fix_us = state.time_us.saturating_sub(self.fixed_us).max(0);
        report.orbit = Some(OrbitReport {
            position_km: state.position_km.into(),
            velocity_km_s: state.velocity_km_s.into(),
            sigma_position_km: position.map(|sigma| sigma as f32),
            sigma_velocity_km_s: velocity.map(|sigma| sigma as f32),
            limb_height_km: single(self.orbit.limb_height_km()),
            limb_height_sigma_km: single(self.orbit.limb_height_sigma_km()),
            nis: self.nis.take(),
            since_fix_s: (since_fix_us / 1_000_000).min(u32::MAX.into()) as u32,
            settled: self.orbit.settled(),
        });
        if self.orbit.settled() && !self.converged {
            self.converged = true;
            report.note(Event::OrbitConverged);
        }
    }
}
