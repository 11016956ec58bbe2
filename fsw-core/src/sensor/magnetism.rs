//! What a magnetometer adds: a check of the attitude that is carried on without stars, and two of its axes.
//!
//! With stars and an orbit it is the magnetometer that is measured: its zero, and whether it lies. Without
//! stars its reading is a direction of which the orbit says where it should be. One that contradicts the
//! carried attitude tells of a turn that nobody measured, one that does not corrects it. A field too weak to
//! be a direction, as in high orbits, says nothing.
//!
//! In: a reading, orbit, time; the attitude by stars or the carried one. Out: the zero, the attitude
//! corrected; the direction for an attitude by the Earth alone ([`super::earth`]).

use super::Sensor;
use super::attitude::sigma_across;
use super::propagation::{Ephemeris, Reading, usable};
use super::record::{Field, Record};
use crate::attitude::VectorPair;
use crate::frames::{Direction, EarthPath, Icrs, Rotation, StarPath};
use crate::magnetism::CONTRADICTION;
use crate::orbit::geomagnetism;
use crate::telemetry::{AttitudeReport, Event};
use crate::trigonometry::hypotenuse;
use fsw_ground::matrix::dot;
use nalgebra::Vector3;

/// Largest standard deviation of a field that is taken for a direction, rad: 10 deg.
const DIRECTION_RAD: f32 = 0.175;
/// The field falls with the cube of the distance: its error by a place off by a share of it.
const BY_DISTANCE: f32 = 3.0;

impl Sensor<'_> {
    /// Takes a reading for this second's field.
    #[inline(never)]
    pub(super) fn take_field(
        &mut self,
        reading: Reading,
        ephemeris: Option<&Ephemeris>,
        record: &mut Record,
    ) {
        let reading = usable(reading, self.now);
        record.magnetometer_fault = reading.err();
        if let (Ok(reading_ut), Some(ephemeris)) = (reading, ephemeris) {
            record.field = self.field(reading_ut, ephemeris);
        }
    }

    /// The field by the orbit beside a reading.
    fn field(&self, reading_ut: Vector3<f32>, ephemeris: &Ephemeris) -> Option<Field> {
        let errors = self.parameters.magnetometer?;
        let (state, trace_km2) = self.orbit.state().zip(self.orbit.position_trace_km2())?;
        let (place_km, pole) = (&state.position_km, ephemeris.pole.vector().map(f64::from));
        let expected_ut = geomagnetism::flux_density_ut(place_km, &pole, ephemeris.terrestrial_us);
        let share = libm::sqrtf((trace_km2 / dot(place_km, place_km) as f32).max(0.0));
        let by_place_ut = BY_DISTANCE * share * expected_ut.norm();
        Some(Field { reading_ut, expected_ut, sigma_ut: hypotenuse(errors.field_ut, by_place_ut) })
    }

    /// The field as a direction: as it is seen, and as it should be; with the standard deviation of one
    /// reading, rad. `None` where it is too weak, or not as strong as it should be.
    pub(super) fn magnetic_direction(
        &self,
        field: &Field,
    ) -> Option<(Direction<EarthPath>, Direction<Icrs>, f32)> {
        let errors = self.parameters.magnetometer?;
        let seen_ut = field.reading_ut - self.magnetism.zero_ut();
        let sigma_ut = self.magnetism.sigma_ut(&errors, field.sigma_ut);
        let strength_ut = field.expected_ut.norm();
        let off_ut = libm::fabsf(seen_ut.norm() - strength_ut);
        let sigma_rad = sigma_ut / strength_ut;
        // False for NaN.
        if !(sigma_rad < DIRECTION_RAD && off_ut < CONTRADICTION * sigma_ut) {
            return None;
        }
        Some((Direction::new(seen_ut)?, Direction::new(field.expected_ut)?, sigma_rad))
    }

    /// Holds the attitude that is carried on to the field of a second without stars.
    #[inline(never)]
    pub(super) fn hold_by_field(&mut self, record: &mut Record) {
        let (Some(field), Some(errors)) = (&record.field, &self.parameters.magnetometer) else { return };
        let Some((seen, reference, sigma_rad)) = self.magnetic_direction(field) else { return };
        let measured = self.mounting().inverse().apply(&seen);
        let averaged_ut = self.magnetism.averaged_sigma_ut(errors, field.sigma_ut);
        let (now, Some(motion)) = (self.now, self.motion.as_mut()) else { return };
        let Some((attitude, carried_rad)) = motion.at(now) else { return };
        let across_rad = sigma_across(carried_rad, measured.vector());
        let off = measured.vector().cross(attitude.apply(&reference).vector());
        if off.norm() > CONTRADICTION * hypotenuse(sigma_rad, across_rad) {
            motion.contradict(now);
            return;
        }
        let averaged = VectorPair { measured, reference, sigma_rad: averaged_ut / field.expected_ut.norm() };
        record.field_used = motion.measurement_update_direction(&averaged, now);
    }

    /// Learns the magnetometer's zero in a second whose own stars gave the attitude.
    #[inline(never)]
    pub(super) fn learn_zero(&mut self, attitude: &AttitudeReport, record: &mut Record) {
        let (Some(field), Some(errors)) = (&record.field, &self.parameters.magnetometer) else { return };
        let Some(attitude) = Rotation::<Icrs, StarPath>::from_quaternion(attitude.quaternion) else {
            return;
        };
        let in_path = self.mounting().matrix() * (attitude.matrix() * field.expected_ut);
        self.magnetism.learn(&(field.reading_ut - in_path), errors, field.sigma_ut);
        if self.magnetism.is_shut_out() {
            record.events.note(Event::MagnetometerShutOut);
        }
    }
}
