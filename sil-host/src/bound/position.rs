//! What no filter can know better of a satellite's position by the limb of an uneven body.
//!
//! In: the truth of a flight, second by second, the world's Earth, and how well the orbit is known at the
//! start. Out: the sigma of the position, radial, along, across, km, by all of the limb seen until then.
//!
//! Once in a block of time (until the limb has moved on by `PATCH_KM`, at most `LONGEST_S`) the heights of
//! places on the lit limb in the field are measured, `PATCH_KM` apart. A height changes by `-n · δr` with
//! the satellite's position, `n` the ellipsoid's normal there; it is off by the world's own field, Gaussian,
//! fixed to the turning Earth, of the covariance [`Heights`], and by `EDGE_KM` for `EDGE_S`, white. With
//! the rows `A` of all heights by the state at the start and their covariance `C = L Lᵀ` the information is
//! `Aᵀ C⁻¹ A`. It is summed height by height, by the rows of `L⁻¹ A`. Each is compared with the latest
//! `WINDOW` or half of them (Vecchia, J. R. Stat. Soc. B 50, 297, 1988): two revolutions in a low orbit. A
//! state that the ground gives at the start adds its own, `1 / sigma²` of every axis.
//!
//! Lengths on another body's ground are that share of the Earth's that its radius is, as the fields' cells
//! are.
//!
//! All else is known: latitude and season, the mean height, alignment, attitude and forces; without a state
//! from the ground nothing of the orbit before the first block. Any of them unknown would make the bound
//! worse. Heights closer together than these would make it 6 % better (Sun-synchronous orbit). A bound is an
//! rms over worlds: in one of them an error may be smaller.
//!
//! Geometry and heights are the world's. The transition of errors, with the pull of the bulge, is that of
//! the flight code's orbit room between true states 30 s apart (error 1e-6).

use super::orbit::{covariance, radial_along_cross};
use crate::world::attitude::{Vector, apply, rotation};
use crate::world::body::meridian_rad;
use crate::world::earth::heights::Heights;
use crate::world::earth::{EQUATOR_KM, EarthModel, Figure};
use crate::world::lens::optics::Optics;
use crate::world::motion::trajectory::{SensorState, Truth};
use crate::world::vector::{cross, length, plus, times};
use fsw_core::orbit::OrbitState;
use fsw_core::orbit::body::CentralBody;
use fsw_core::orbit::forces::Forces;
use nalgebra::{Matrix6, Vector3, Vector6};

/// Way over the ground of the Earth from one height to the next, km: half of the length over which the
/// field's large part agrees.
const PATCH_KM: f64 = 300.0;
/// Time from one true state to the next, s; blocks are as many of them as need be.
const STEP_S: i64 = 30;
const LONGEST_S: f64 = 1200.0;
/// Most places of a block, and heights with which others are compared.
const PLACES: usize = 36;
const WINDOW: usize = 600;
/// By what an edge is off beside the field, km, and for how long, s: clouds and light, in rendered low
/// orbits.
const EDGE_KM: f64 = 0.6;
const EDGE_S: f64 = 12.0;
/// Distances at which the covariance is tabled, km apart: straight between them to 3e-5 km².
const TABLED_KM: f64 = 5.0;

/// A height that was measured.
#[derive(Clone, Copy, Debug)]
struct Height {
    /// Where, axes that turn with the Earth, km.
    place_km: Vector,
    /// Its change by the state at the start.
    row: Vector6<f64>,
    /// Variance of its own, km².
    own_km2: f64,
}

/// The bound of a flight.
#[derive(Clone, Debug)]
pub struct PositionBound {
    body: CentralBody,
    /// Its radius over the Earth's: lengths on its ground are that share of those above.
    share: f64,
    /// Covariance of two heights, km², from 0 in steps of [`TABLED_KM`] on the Earth.
    covariances_km2: Vec<f64>,
    /// The last true state, and the transition to it from the first.
    last: Option<OrbitState>,
    transition: Matrix6<f64>,
    information: Matrix6<f64>,
    /// The latest heights, of each its row of `L` and of `L⁻¹ A`.
    latest: Vec<Height>,
    roots: Vec<Vec<f64>>,
    white: Vec<Vector6<f64>>,
    /// Not before then a block is measured.
    next_us: i64,
    sigma_km: Option<[f64; 3]>,
}

impl PositionBound {
    /// Before the first second, over this Earth.
    pub fn new(model: &EarthModel) -> Self {
        let heights = Heights::of(model);
        let share = Figure::of(model.body).equator_km / EQUATOR_KM;
        let steps = (2.0 * EQUATOR_KM / TABLED_KM) as u32 + 2;
        let covariance_km2 = |k: u32| heights.covariance_km2(share * TABLED_KM * f64::from(k));
        Self {
            body: model.body,
            share,
            covariances_km2: (0..steps).map(covariance_km2).collect(),
            last: None,
            transition: Matrix6::identity(),
            information: Matrix6::zeros(),
            latest: Vec::new(),
            roots: Vec::new(),
            white: Vec::new(),
            next_us: i64::MIN,
            sigma_km: None,
        }
    }

    /// The same where the ground gives a state at the start, known so well along every axis.
    pub fn knowing(mut self, position_sigma_km: f64, velocity_sigma_m_s: f64) -> Self {
        let sigmas = [position_sigma_km, 1e-3 * velocity_sigma_m_s];
        self.information = Matrix6::from_diagonal(&Vector6::from_fn(|axis, _| sigmas[axis / 3].powi(-2)));
        self
    }

    /// Adds a second; gives the sigma after the last step, radial, along, across, km, `None` while the limb
    /// seen does not fix an orbit. `optics` are those of the star path.
    pub fn add(&mut self, truth: &Truth, optics: &Optics) -> Option<[f64; 3]> {
        let now_us = truth.instant_us;
        if self.last.is_some_and(|last| now_us < last.time_us + 1_000_000 * STEP_S) {
            return self.sigma_km;
        }
        let state = OrbitState {
            time_us: now_us,
            position_km: truth.position_km.into(),
            velocity_km_s: truth.velocity_km_s.into(),
        };
        if let Some(last) = self.last.replace(state) {
            let rows = Forces::J2.about(self.body).transition(&last, &state);
            self.transition = Matrix6::from_fn(|row, column| rows[row][column]) * self.transition;
        }
        if truth.state == SensorState::Full && now_us >= self.next_us {
            let lasts_s = block_s(truth, self.share * PATCH_KM);
            self.next_us = now_us + (1e6 * lasts_s) as i64;
            self.measure(&self.heights(truth, optics, EDGE_KM * EDGE_KM * EDGE_S / lasts_s));
        }
        let known = covariance(&self.information);
        let position = known.map(|known| self.transition * known * self.transition.transpose());
        self.sigma_km =
            position.and_then(|all| radial_along_cross(&state, &all.fixed_view::<3, 3>(0, 0).into_owned()));
        self.sigma_km
    }

    /// Heights of places evenly along the lit limb in the field.
    fn heights(&self, truth: &Truth, optics: &Optics, own_km2: f64) -> Vec<Height> {
        let lit: Vec<(Vector, Vector)> = truth.lit_limb(optics).collect();
        let equator_km = truth.ellipsoid.figure().equator_km;
        let sine = equator_km / length(truth.position_km);
        let circle_km = equator_km * (1.0 - sine * sine).max(0.0).sqrt();
        let arc_km = truth.lit_limb_deg.to_radians() * circle_km;
        let count = ((arc_km / (self.share * PATCH_KM)) as usize + 1).min(PLACES).min(lit.len());
        let turn = rotation(2, meridian_rad(self.body, truth.instant_us));
        let height = |index: usize| {
            let (normal, place) = lit[(2 * index + 1) * lit.len() / (2 * count)];
            let row = Vector3::from(normal).transpose() * self.transition.fixed_rows::<3>(0);
            let place_km = apply(&turn, apply(truth.ellipsoid.equator(), place));
            Height { place_km, row: -row.transpose(), own_km2 }
        };
        (0..count).map(height).collect()
    }

    /// Covariance of two heights of the field, km².
    fn covariance_km2(&self, one: &Height, other: &Height) -> f64 {
        let at = length(plus(one.place_km, -1.0, other.place_km)) / (self.share * TABLED_KM);
        let (step, part) = (at as usize, at.fract());
        match self.covariances_km2.get(step..step + 2) {
            Some([low, high]) => low + part * (high - low),
            _ => 0.0,
        }
    }

    /// Compares a height with the latest, and joins it to them; its row of `L⁻¹ A`.
    fn compared(&mut self, height: Height) -> Option<Vector6<f64>> {
        let mut root = Vec::with_capacity(self.latest.len() + 1);
        let mut left = height.row;
        for ((other, of), white) in self.latest.iter().zip(&self.roots).zip(&self.white) {
            let (pivot, before) = of.split_last()?;
            let shared = (self.covariance_km2(&height, other) - dot(before, &root)) / pivot;
            left -= white * shared;
            root.push(shared);
        }
        let own_km2 = self.covariance_km2(&height, &height) + height.own_km2 - dot(&root, &root);
        let pivot = (own_km2 > 0.0).then(|| own_km2.sqrt())?;
        root.push(pivot);
        self.latest.push(height);
        self.roots.push(root);
        self.white.push(left / pivot);
        self.white.last().copied()
    }

    /// Adds the information of a block.
    fn measure(&mut self, heights: &[Height]) {
        for height in heights {
            if let Some(white) = self.compared(*height) {
                self.information += white * white.transpose();
            }
        }
        if self.latest.len() > WINDOW {
            let kept = self.latest.split_off(self.latest.len() - WINDOW / 2);
            self.latest.clear();
            self.roots.clear();
            self.white.clear();
            for height in kept {
                self.compared(height);
            }
        }
    }
}

/// Sum of products, in eight sums so that the machine can take several at a time.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (eights, others) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = eights.remainder().iter().zip(others.remainder()).map(|(a, b)| a * b).sum();
    for (eight, other) in eights.zip(others) {
        for (sum, (a, b)) in sums.iter_mut().zip(eight.iter().zip(other)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// How long a block lasts, s: until the limb has moved on by a patch.
fn block_s(truth: &Truth, patch_km: f64) -> f64 {
    let Truth { position_km, velocity_km_s, ellipsoid, .. } = truth;
    let square_km2 = length(*position_km).powi(2);
    let turn = times(square_km2.recip(), cross(*position_km, *velocity_km_s));
    let pole = ellipsoid.equator()[2];
    let facts = ellipsoid.body().facts();
    let ground_km_s = ellipsoid.figure().equator_km * length(plus(turn, -facts.rate_rad_s, pole));
    let steps = (patch_km / ground_km_s).min(LONGEST_S) / STEP_S as f64;
    STEP_S as f64 * steps.max(1.0).ceil()
}

#[cfg(test)]
mod tests;
