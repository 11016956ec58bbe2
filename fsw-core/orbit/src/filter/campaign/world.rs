//! The world of the campaigns: a true satellite, fixes of it, and a filter that takes them.

use crate::OrbitState;
use crate::body::EARTH;
use crate::factor::{Factor, POSITION};
use crate::filter::{OrbitFilter, Update};
use crate::lvlh::lvlh;
use crate::noise::acceleration;
use crate::oracle::Generator;
use crate::parameters::OrbitParameters;
use crate::point::PositionFix;
use crate::reference;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// How the Earth is seen: independent errors at each fix.
#[derive(Clone, Copy)]
pub(super) struct Eye {
    /// Of the direction, rad, along and across the orbit.
    pub(super) along_rad: f64,
    pub(super) across_rad: f64,
    /// Of the distance, as a share of it.
    pub(super) range: f64,
    /// Correlation of the distance with the direction along the orbit (a limb seen on one side only).
    pub(super) correlation: f64,
}

impl Eye {
    /// Covariance at this place, turned by the orbit's axes there.
    pub(super) fn covariance(&self, position_km: &Vector3<f64>, normal: &Vector3<f64>) -> Matrix3<f64> {
        let distance = position_km.norm();
        let up = position_km / distance;
        let across = (normal - up * normal.dot(&up)).normalize();
        let axes = Matrix3::from_columns(&[across.cross(&up), across, up]);
        let (a, c) = (self.along_rad * distance, self.across_rad * distance);
        let r = self.range * distance;
        let ar = self.correlation * a * r;
        axes * Matrix3::new(a * a, 0.0, ar, 0.0, c * c, 0.0, ar, 0.0, r * r) * axes.transpose()
    }

    /// A fix of the satellite at `true_km`, which is seen at `seen_km`. The sensor knows its errors only at
    /// the measured place.
    pub(super) fn fix(
        &self,
        (true_km, seen_km): (&Vector3<f64>, &Vector3<f64>),
        normal: &Vector3<f64>,
        generator: &mut Generator,
    ) -> PositionFix {
        let noise = self.covariance(true_km, normal).cholesky().unwrap().l() * generator.gaussian_vector();
        let position_km = seen_km + noise;
        PositionFix {
            position_km,
            covariance_km2: self.covariance(&position_km, normal),
            shared_km2: Matrix3::zeros(),
            linearisation_km: position_km,
        }
    }

    /// The eye whose one fix tells as much as `fixes` of this.
    pub(super) fn averaging(&self, fixes: i64) -> Self {
        let share = 1.0 / (fixes as f64).sqrt();
        let Self { along_rad, across_rad, range, correlation } = *self;
        Self {
            along_rad: along_rad * share,
            across_rad: across_rad * share,
            range: range * share,
            correlation,
        }
    }
}

/// What moves the true satellite.
#[derive(Clone, Copy)]
pub(super) enum World {
    /// The filter's own forces and white acceleration as strong as its process noise says: strict
    /// consistency.
    White,
    /// The Earth's field to degree and order 20, by the reference propagator: realism.
    Lumpy,
}

pub(super) struct Scenario {
    pub(super) start: OrbitState,
    pub(super) duration_s: i64,
    pub(super) cadence_s: i64,
    /// Period and length of the eclipses, s; the first comes after half a period.
    pub(super) eclipse: Option<(i64, i64)>,
    pub(super) eye: Eye,
    pub(super) world: World,
    pub(super) parameters: OrbitParameters,
}

/// A run's end.
pub(super) struct Outcome {
    /// Radial, along, across, m.
    pub(super) error_m: Vector3<f64>,
    pub(super) sigma_m: Vector3<f64>,
    pub(super) nees: f64,
    /// Error and sigma of the limb height, km.
    pub(super) limb_km: (f64, f64),
    pub(super) downweighted: u32,
    pub(super) settled_after_s: Option<i64>,
}

pub(super) fn state_error(filter: &OrbitFilter, truth: &OrbitState) -> Vector6<f64> {
    let state = filter.state().unwrap();
    let (r, v) = (state.position_km - truth.position_km, state.velocity_km_s - truth.velocity_km_s);
    Vector6::new(r.x, r.y, r.z, v.x, v.y, v.z)
}

pub(super) fn state_covariance(p: &Factor) -> Matrix6<f64> {
    Matrix6::from_fn(|row, column| f64::from(p.covariance(row, column)))
}

pub(super) fn nees(filter: &OrbitFilter, truth: &OrbitState) -> f64 {
    let error = state_error(filter, truth);
    let covariance = state_covariance(filter.factor().unwrap());
    error.dot(&(covariance.try_inverse().unwrap() * error))
}

pub(super) fn radial_along_across(truth: &OrbitState) -> Matrix3<f64> {
    let axes = lvlh(&truth.position_km, &truth.velocity_km_s).unwrap();
    Matrix3::from_rows(&[-axes.row(2), axes.row(0).into(), -axes.row(1)])
}

/// What the true satellite and the sky do, apart from the white noise of a fix.
pub(super) struct Truth {
    state: OrbitState,
    /// Height of the limb above that assumed, km.
    limb_height_km: f64,
    misalignment: Vector3<f64>,
}

impl Truth {
    fn at_start(scenario: &Scenario, generator: &mut Generator) -> Self {
        let Scenario { start, parameters, .. } = scenario;
        Self {
            state: *start,
            misalignment: generator.gaussian_vector() * f64::from(parameters.misalignment_sigma_rad),
            limb_height_km: generator.gaussian() * f64::from(parameters.height_sigma_km),
        }
    }

    /// One fix later.
    fn live(&mut self, scenario: &Scenario, generator: &mut Generator) {
        let step_s = scenario.cadence_s as f64;
        self.state = match scenario.world {
            World::Lumpy => reference::propagate(&self.state, step_s, 10.0, 20),
            World::White => shaken(scenario, &self.state, generator),
        };
    }

    /// Position as it is seen, without white noise.
    fn seen_km(&self, to_icrs: &Matrix3<f64>) -> Vector3<f64> {
        let nearer = self.state.position_km * (1.0 - self.limb_height_km / EARTH.radius_km);
        nearer + nearer.cross(&(to_icrs * self.misalignment))
    }
}

/// The state one fix later under the filter's own forces and white acceleration over the step, exactly: a
/// velocity, and a position half bound to it and half free.
pub(super) fn shaken(scenario: &Scenario, state: &OrbitState, generator: &mut Generator) -> OrbitState {
    let step_s = scenario.cadence_s as f64;
    let mut next = scenario.parameters.forces().propagate(state, scenario.cadence_s * 1_000_000).unwrap();
    let strength = (acceleration(state, &scenario.parameters) * step_s).sqrt();
    let (bound, free) = (generator.gaussian_vector() * strength, generator.gaussian_vector() * strength);
    next.velocity_km_s += bound;
    next.position_km += (bound * 0.5 + free / 12.0f64.sqrt()) * step_s;
    next
}

pub(super) fn fly(scenario: &Scenario, seed: u64) -> Outcome {
    let Scenario { eye, cadence_s, parameters, .. } = scenario;
    let mut generator = Generator::new(seed);
    let start = &scenario.start;
    let normal = start.position_km.cross(&start.velocity_km_s).normalize();
    let mut truth = Truth::at_start(scenario, &mut generator);
    let mut filter = OrbitFilter::new();
    let (mut downweighted, mut settled_after_s) = (0, None);
    for second in (0..scenario.duration_s).step_by(*cadence_s as usize) {
        if second > 0 {
            truth.live(scenario, &mut generator);
        }
        let dark = scenario.eclipse.is_some_and(|(period, length)| {
            second >= period / 2 && (second - period / 2).rem_euclid(period) < length
        });
        let state = &truth.state;
        if dark {
            filter.advance(state.time_us, parameters).unwrap();
            continue;
        }
        // The Earth path looks at the Earth, rolled by the orbit.
        let to_icrs = lvlh(&state.position_km, &state.velocity_km_s).unwrap().transpose();
        let seen_km = truth.seen_km(&to_icrs);
        let fix = eye.fix((&state.position_km, &seen_km), &normal, &mut generator);
        match filter.update(state.time_us, &fix, &to_icrs, parameters) {
            Update::Downweighted(_) => downweighted += 1,
            Update::Diverged(_) | Update::Refused(_) => panic!("lost at {second} s"),
            Update::Collected | Update::Started | Update::Accepted(_) | Update::Gathered => (),
        }
        if filter.settled() && settled_after_s.is_none() {
            settled_after_s = Some(second);
        }
    }
    let factor = filter.factor().unwrap();
    let state = &truth.state;
    let axes = radial_along_across(state);
    let [height_km, height_sigma_km] = filter.limb_height_km().unwrap().map(f64::from);
    Outcome {
        error_m: axes * state_error(&filter, state).fixed_rows::<3>(0) * 1e3,
        sigma_m: (axes * factor.block(POSITION, POSITION) * axes.transpose()).diagonal().map(f64::sqrt) * 1e3,
        nees: nees(&filter, state),
        limb_km: (height_km - truth.limb_height_km, height_sigma_km),
        downweighted,
        settled_after_s,
    }
}
