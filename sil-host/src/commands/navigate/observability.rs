//! What measurements of the Earth can tell of an orbit at all (thesis §5.2.2).
//!
//! In: a state, the forces, the times of the measurements. Out, for each form of measurement, without and with
//! a constant misalignment of the star path against the Earth path: the singular values and the rank of the
//! observability matrix of the arc (eq. 5.36), and the combinations of states that it leaves unknown.
//!
//! States: position and velocity at the first state along Hill's axes then, over the distance and the speed
//! then; with the misalignment, its three angles about Hill's axes of date, rad, constant for a satellite that
//! keeps turned to the Earth. Of each measurement the rows are the change of the direction along and across
//! the track, rad, and of the distance over itself; all over the root of the number of measurements. The
//! derivative by the state is a central difference of the propagation: a transition in closed form, right to
//! 1e-4, would blur what is not observable. Errors of the rows: 1e-8. The noise of a measurement is left out.
//!
//! Under a point mass the orbit is known from directions alone. An angle along the track (about the orbit's
//! normal) is the same as a place farther on, a turn about the vertical moves nothing: of the three angles
//! that about the track alone is observable, as in the thesis (there β is, λ is not). The Earth's bulge tells
//! a place farther on from an angle in principle, with a singular value of 1e-6 of the largest.

use crate::commands::propagate::carried;
use crate::formats::json;
use fsw_core::orbit::OrbitState;
use fsw_core::orbit::forces::Forces;
use fsw_core::orbit::lvlh::hill;
use nalgebra::{DMatrix, SMatrix, Vector3};
use serde::Serialize;

/// States of the orbit, and the angles of the misalignment.
const ORBIT: usize = 6;
const ANGLES: usize = 3;
/// Names of all, in order.
const NAMES: [&str; ORBIT + ANGLES] = [
    "radial",
    "along",
    "cross",
    "radial velocity",
    "along velocity",
    "cross velocity",
    "turn about radial",
    "turn about along",
    "turn about cross",
];
/// Step of the central differences, share of distance or speed: errors of 1e-10 by the bend and by rounding.
const STEP: f64 = 1e-5;
/// Singular values of a smaller share of the largest count as none: those of what is not observable are below
/// 1e-10.
const LEAST_SHARE: f64 = 1e-8;
/// What is smaller in a combination is none.
const LEAST_PART: f64 = 1e-3;

/// Change of the position at a measurement, over the distance, radial, along and across, by the first state.
type Sensitivity = SMatrix<f64, 3, ORBIT>;

/// What is measured of the Earth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Form {
    /// Its direction.
    Unit,
    /// Direction and distance.
    Position,
    /// Both in the first measurement, the direction in those that follow.
    Combined,
}

impl Form {
    const ALL: [Self; 3] = [Self::Unit, Self::Position, Self::Combined];

    /// Whether measurement number `index` has a distance.
    fn has_distance(self, index: usize) -> bool {
        self == Self::Position || (self == Self::Combined && index == 0)
    }

    fn words(self) -> &'static str {
        match self {
            Self::Unit => "direction",
            Self::Position => "direction and distance",
            Self::Combined => "distance once, then direction",
        }
    }
}

/// What one form tells.
#[derive(Clone, Debug, Serialize)]
pub struct Observability {
    form: Form,
    /// Whether the angles are among the states.
    misalignment: bool,
    states: usize,
    rank: usize,
    /// From the largest on.
    singular_values: Vec<f64>,
    /// Combinations of states that change no measurement, in the order of the states, each with a 1 at the
    /// last state that is in no other.
    unobservable: Vec<Vec<f64>>,
    /// Whether each angle is observable, about radial, along, cross.
    angles_observable: Option<[bool; ANGLES]>,
}

/// The derivatives at times in order, not before `first`; `None` where the orbit leaves the bounds of the
/// dynamics or has no plane.
fn sensitivities(first: &OrbitState, forces: &Forces, times_us: &[i64]) -> Option<Vec<Sensitivity>> {
    let axes = hill(&first.position_km, &first.velocity_km_s)?.transpose();
    let [far_km, fast_km_s] = [first.position_km.norm(), first.velocity_km_s.norm()];
    let moved = |column: usize, step: f64| {
        let along: Vector3<f64> = axes.column(column % 3) * step;
        let mut state = *first;
        if column < 3 {
            state.position_km += along * far_km;
        } else {
            state.velocity_km_s += along * fast_km_s;
        }
        state
    };
    let mut pairs: [[OrbitState; 2]; ORBIT] =
        std::array::from_fn(|column| [moved(column, STEP), moved(column, -STEP)]);
    let mut middle = *first;
    let mut all = Vec::with_capacity(times_us.len());
    for time_us in times_us {
        middle = carried(&middle, *time_us, forces).ok()?;
        for state in pairs.as_flattened_mut() {
            *state = carried(state, *time_us, forces).ok()?;
        }
        let axes = hill(&middle.position_km, &middle.velocity_km_s)? / middle.position_km.norm();
        let columns =
            pairs.map(|[ahead, behind]| axes * (ahead.position_km - behind.position_km) / (2.0 * STEP));
        all.push(Sensitivity::from_columns(&columns));
    }
    Some(all)
}

/// The observability matrix of an arc.
fn matrix(sensitivities: &[Sensitivity], form: Form, misalignment: bool) -> DMatrix<f64> {
    let states = if misalignment { ORBIT + ANGLES } else { ORBIT };
    let count = sensitivities.len();
    let mut rows = DMatrix::zeros(3 * count, states);
    for (index, sensitivity) in sensitivities.iter().enumerate() {
        let mut block = rows.rows_mut(3 * index, 3);
        block.columns_mut(0, ORBIT).copy_from(sensitivity);
        if misalignment {
            // A turn by θ moves the vertical by θ x e: along by that about cross, across by less that about
            // along.
            block[(1, ORBIT + 2)] = 1.0;
            block[(2, ORBIT + 1)] = -1.0;
        }
        if !form.has_distance(index) {
            block.row_mut(0).fill(0.0);
        }
    }
    rows / (count as f64).sqrt()
}

/// Makes each row the only one with a part in some column, 1 there; columns from the last to the first.
fn reduced(mut rows: DMatrix<f64>) -> DMatrix<f64> {
    let mut done = 0;
    for column in (0..rows.ncols()).rev() {
        let Some(pivot) = (done..rows.nrows())
            .max_by(|a, b| rows[(*a, column)].abs().total_cmp(&rows[(*b, column)].abs()))
            .filter(|pivot| rows[(*pivot, column)].abs() > LEAST_PART)
        else {
            continue;
        };
        rows.swap_rows(done, pivot);
        let unit = rows.row(done) / rows[(done, column)];
        for row in 0..rows.nrows() {
            let part = rows[(row, column)];
            let cleared = if row == done { unit.clone() } else { rows.row(row) - &unit * part };
            rows.set_row(row, &cleared);
        }
        done += 1;
    }
    rows
}

/// What one form tells by these derivatives.
fn observability(sensitivities: &[Sensitivity], form: Form, misalignment: bool) -> Option<Observability> {
    let rows = matrix(sensitivities, form, misalignment);
    let states = rows.ncols();
    // Its triangle has the same singular values.
    let triangle = if rows.nrows() > states { rows.qr().r() } else { rows };
    let svd = triangle.svd(false, true);
    let (values, directions) = (svd.singular_values, svd.v_t?);
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let largest = values.max();
    let rank = order.iter().filter(|index| values[**index] > LEAST_SHARE * largest).count();
    let unknown = reduced(directions.select_rows(order.iter().skip(rank)));
    let angles_observable =
        misalignment.then(|| std::array::from_fn(|angle| unknown.column(ORBIT + angle).amax() < LEAST_PART));
    Some(Observability {
        form,
        misalignment,
        states,
        rank,
        singular_values: order.iter().map(|index| values[*index]).collect(),
        unobservable: unknown.row_iter().map(|row| row.iter().copied().collect()).collect(),
        angles_observable,
    })
}

/// What each form tells, without and with a misalignment; `None` where the orbit cannot be followed, or there
/// are fewer than three measurements.
pub fn table(first: &OrbitState, forces: &Forces, times_us: &[i64]) -> Option<Vec<Observability>> {
    let sensitivities = sensitivities(first, forces, times_us).filter(|all| all.len() >= 3)?;
    let cases = [false, true].into_iter().flat_map(|misaligned| Form::ALL.map(|form| (form, misaligned)));
    cases.map(|(form, misaligned)| observability(&sensitivities, form, misaligned)).collect()
}

impl Observability {
    /// A combination in words.
    fn combination(parts: &[f64]) -> String {
        let named = parts.iter().zip(NAMES).rev().filter(|(part, _)| part.abs() >= LEAST_PART);
        named.map(|(part, name)| format!("{part:+.3} {name}")).collect::<Vec<_>>().join(", ")
    }

    /// Prints it as a JSON line or for people.
    pub fn print(&self, as_json: bool) {
        if as_json {
            return json::print_line(self);
        }
        let values: Vec<String> = self.singular_values.iter().map(|value| format!("{value:.1e}")).collect();
        print_line!(
            "{}, {}: rank {} of {}; singular values {}",
            self.form.words(),
            if self.misalignment { "misaligned" } else { "aligned" },
            self.rank,
            self.states,
            values.join(" ")
        );
        for parts in &self.unobservable {
            print_line!("    not observable: {}", Self::combination(parts));
        }
    }
}

#[cfg(test)]
mod tests;
