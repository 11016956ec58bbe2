//! Limb points of some seconds, joined to a look, and the look taken into the state.

use super::{Estimate, Nis, Rows};
use crate::OrbitState;
use crate::constants::{LIGHT_KM_S, MICROSECONDS};
use crate::dynamics::MAX_SPAN_US;
use crate::ephemeris::pole_axis;
use crate::factor::{MISALIGNMENT, POSITION};
use crate::horizon::LimbGeometry;
use crate::look::Look;
use crate::parameters::OrbitParameters;
use fsw_ground::frames::LimbHeight;
use fsw_ground::matrix::{dot_slices, plus_scaled};
use fsw_ground::trigonometry::hypotenuse;
use nalgebra::{Matrix3, Vector3};

/// Where the second order of a height by the position's sigma is greater than this, km, a look is taken in
/// gradually: in shares of its information, about the state that the one before left (recursive update,
/// Zanetti 2012).
const GREATEST_BEND_KM: f32 = 0.2;
const GRADUAL: [f32; 3] = [0.01, 0.09, 0.9];
/// In one share.
const AT_ONCE: [f32; 1] = [1.0];
/// Most spans from the end of a look back to the mean of its points: the longest look is 300 s, and the mean
/// is at its begin where the limb was lost at once.
const LOOK_SPANS: u32 = 2;

/// A look that is taken in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taking {
    pub(super) look: Look,
    /// The state at the mean time of its points, before any of it was taken.
    pub(super) seen: OrbitState,
    /// The misalignment then.
    misalignment: Vector3<f32>,
    /// Shares that are left.
    shares: &'static [f32],
}

impl Estimate {
    /// Takes the limb points of a second into the look under way, or into a new one where it is time.
    #[inline(never)]
    pub(in crate::filter) fn add_to_look(
        &mut self,
        heights: &[LimbHeight],
        radius_km: f32,
        to_icrs: &Matrix3<f64>,
        attitude_rad2: &Matrix3<f32>,
        parameters: &OrbitParameters,
    ) {
        let now_us = self.state.time_us;
        let due = now_us >= self.next_look_us && self.taking.is_none();
        let Some(geometry) = self.geometry().filter(|_| due) else { return };
        let lasts_s = geometry.between_looks_s(parameters).min(parameters.look_s);
        let look = self.look.get_or_insert(Look::new(now_us, lasts_s, radius_km));
        self.to_icrs = to_icrs.map(|element| element as f32);
        let since_s = look.age_s(now_us);
        // x, y, z of LVLH in the Earth path.
        let axes = (geometry.axes * self.to_icrs).transpose();
        let velocity = self.state.velocity_km_s.map(|axis| axis as f32);
        let velocity = geometry.axes * velocity * (geometry.distance_km / LIGHT_KM_S as f32);
        let count = heights.len() as f32;
        let arc_km = arc_rad(heights.iter().map(|point| axes.tr_mul(&point.radial))) * geometry.circle_km();
        let patches = 1.0 + arc_km / geometry.patch_km(parameters);
        let crowding = (count * look.lasts_s / patches).max(1.0);
        let common_km2 = geometry.edge_km2(parameters) * crowding;
        for point in heights {
            let radial = axes.tr_mul(&point.radial);
            let length = hypotenuse(radial.x, radial.y).max(1e-3);
            let azimuth = [radial.x / length, radial.y / length];
            let [cosine, sine] = azimuth;
            // Aberration lifts the limb by D (n · v) / c.
            let lifted =
                geometry.cosine * (velocity.x * cosine + velocity.y * sine) - geometry.sine * velocity.z;
            // The attitude's error is common to the second's points: each has the variance of all.
            let turn = (axes * Vector3::new(-sine, cosine, 0.0)) * geometry.distance_km;
            let turned_km2 = turn.dot(&(attitude_rad2 * turn)) * count;
            let variance = common_km2 + point.sigma_km * point.sigma_km + turned_km2;
            look.add(azimuth, point.height_km - lifted, libm::sqrtf(variance), since_s);
        }
    }

    /// Takes in the look under way when its time is over, in steps of a second each: first noise is added,
    /// then the look's shares follow, until one is beyond the gate. Gives what came of a share. After a gap it
    /// waits, as the gap took the second.
    #[inline(never)]
    pub(in crate::filter) fn finish_look(&mut self, parameters: &OrbitParameters) -> Option<(Nis, bool)> {
        self.busy = false;
        if self.spans > 1 {
            return None;
        }
        let Some(taking) = self.taking else {
            self.end_look(parameters);
            self.busy = self.taking.is_some();
            return None;
        };
        self.busy = true;
        let Some(rows) = self.rows_of_look(&taking, parameters) else {
            self.taking = None;
            return None;
        };
        let (nis, within) = self.update(rows, parameters);
        let next = Taking { shares: taking.shares.get(1..).unwrap_or(&[]), ..taking };
        self.taking = Some(next).filter(|next| within && !next.shares.is_empty());
        Some((nis, within))
    }

    /// Ends the look under way when its time is over.
    fn end_look(&mut self, parameters: &OrbitParameters) {
        let now_us = self.state.time_us;
        let Some(look) = self.look.filter(|look| look.age_s(now_us) >= look.lasts_s) else { return };
        let Some(geometry) = self.geometry() else { return };
        self.look = None;
        let every_us = (geometry.between_looks_s(parameters).max(look.lasts_s) * 1e6) as i64;
        let blind_us = look.begun_us.saturating_sub(self.next_look_us);
        self.next_look_us = look.begun_us.saturating_add(every_us).max(self.state.time_us);
        self.add_noise(parameters);
        self.add_bend(blind_us as f64 / MICROSECONDS);
        let bent_km = self.factor.trace(POSITION) / (2.0 * geometry.distance_km);
        let shares = if bent_km > GREATEST_BEND_KM { &GRADUAL[..] } else { &AT_ONCE };
        let misalignment = self.misalignment;
        self.taking = self.seen(&look, parameters).map(|seen| Taking { look, seen, misalignment, shares });
    }

    /// The state at the mean time of a look's points: the axes turn, those of that time count. `None` where
    /// that is more than [`LOOK_SPANS`] back.
    fn seen(&self, look: &Look, parameters: &OrbitParameters) -> Option<OrbitState> {
        let mut seen = self.state;
        let mut left_us = (f64::from(self.lag_s(look)) * MICROSECONDS) as i64;
        for _ in 0..LOOK_SPANS {
            let span_us = left_us.clamp(0, MAX_SPAN_US);
            if span_us > 0 {
                seen = parameters.forces().propagate(&seen, -span_us).ok()?;
            }
            left_us = left_us.saturating_sub(span_us);
        }
        (left_us <= 0).then_some(seen)
    }

    /// Time since the mean of a look's points, s.
    fn lag_s(&self, look: &Look) -> f32 {
        look.age_s(self.state.time_us) - look.mean_s()
    }

    /// Rows of the next share of a look, about the state that the shares before it left.
    #[inline(never)]
    fn rows_of_look(
        &self,
        Taking { look, seen, misalignment, shares }: &Taking,
        parameters: &OrbitParameters,
    ) -> Option<Rows> {
        let geometry =
            LimbGeometry::of(self.body, seen, &pole_axis(self.body, seen.time_us), look.radius_km)?;
        let pole = pole_axis(self.body, self.state.time_us).map(|axis| axis as f32);
        let path = self.to_icrs.transpose();
        let lag_s = self.lag_s(look);
        let now_seen = self.seen(look, parameters)?;
        let moved_km = plus_scaled(&now_seen.position_km, -1.0, &seen.position_km).map(|axis| axis as f32);
        let limb = geometry.moved(&(geometry.moves * moved_km));
        let turned = self.misalignment - misalignment;
        let share = *shares.first()?;
        let mut rows = Rows::of_look();
        let places = rows.sensitivities.iter_mut().zip(&mut rows.innovations);
        for ((sensitivity, innovation), (waves, height)) in places.zip(look.rows()) {
            let row = geometry.sensitivity(waves, &limb, (&pole, &path), lag_s);
            let by_turn = row.get(MISALIGNMENT..).map_or(0.0, |row| dot_slices(row, turned.as_slice()));
            let expected = dot_slices(waves, &limb.height_km) + dot_slices(&row, &self.horizon) + by_turn;
            let left = height - expected;
            let weight = libm::sqrtf(share / geometry.left_of_edges(waves, parameters));
            (*sensitivity, *innovation) = (row.map(|element| weight * element), weight * left);
        }
        Some(rows)
    }
}

/// Azimuth that directions span about the third axis, rad: the sum of the widest two sides about their mean.
fn arc_rad(directions: impl Iterator<Item = Vector3<f32>> + Clone) -> f32 {
    let mean = directions.clone().fold(Vector3::zeros(), |sum: Vector3<f32>, direction| sum + direction);
    let (mut low, mut high) = (0.0, 0.0);
    for direction in directions {
        let across = mean.x * direction.y - mean.y * direction.x;
        let along = mean.x * direction.x + mean.y * direction.y;
        let angle = libm::atan2f(across, along);
        (low, high) = (if angle < low { angle } else { low }, if angle > high { angle } else { high });
    }
    high - low
}
