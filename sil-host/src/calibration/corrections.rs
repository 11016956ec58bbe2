//! Correction tables fitted to what the flight code's centroids miss.
//!
//! In: errors of many centroids, each at a place on the detector, with its standard deviation. Out: for each
//! node of a grid the correction at every tenth of a pixel.
//!
//! The correction is periodic in the place within the pixel: at each node a constant and the waves of
//! [`WAVES`] along both axes; between nodes it goes linearly, as the flight code reads it. The coefficients
//! of all nodes are found by weighted least squares at once; each is taken to be no larger than about
//! [`ORDINARY_PX`], so that a node with few stars has small corrections and not wild ones.

use fsw_core::image::calibration::PHASES;
use nalgebra::{DMatrix, DVector};

/// Waves along x and y, periods a pixel, beside the constant.
const WAVES: [[f64; 2]; 6] = [[1.0, 0.0], [0.0, 1.0], [2.0, 0.0], [0.0, 2.0], [1.0, 1.0], [1.0, -1.0]];
/// Coefficients of a node.
const TERMS: usize = 1 + 2 * WAVES.len();
/// An ordinary correction, px.
const ORDINARY_PX: f64 = 0.02;

/// The error of a centroid.
#[derive(Debug, Clone, Copy)]
pub struct Miss {
    /// Measured place, px.
    pub at_px: [f64; 2],
    /// What is to be added to it, px.
    pub correction_px: [f64; 2],
    /// Standard deviation an axis, px.
    pub sigma_px: f64,
}

/// Nodes of the tables: place of the first, px, distance, columns and rows.
#[derive(Debug, Clone, Copy)]
pub struct Nodes {
    /// Of the first, px.
    pub first_px: [f64; 2],
    /// From one to the next, px.
    pub step_px: f64,
    /// Columns and rows.
    pub count: [usize; 2],
}

impl Nodes {
    /// The four nodes about a place with their shares; beyond the outermost it goes straight on.
    fn about(&self, at_px: [f64; 2]) -> [(usize, f64); 4] {
        let along = |axis: usize| {
            let at = (at_px[axis] - self.first_px[axis]) / self.step_px;
            let index = (at.max(0.0) as usize).min(self.count[axis].saturating_sub(2));
            (index, at - index as f64)
        };
        let ((column, right), (row, below)) = (along(0), along(1));
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| {
            let part = |step: usize, beyond: f64| if step == 1 { beyond } else { 1.0 - beyond };
            ((row + dy) * self.count[0] + column + dx, part(dx, right) * part(dy, below))
        })
    }
}

/// Constant and waves at a place.
fn terms([x, y]: [f64; 2]) -> [f64; TERMS] {
    let mut all = [1.0; TERMS];
    for (pair, [along, across]) in all[1..].chunks_exact_mut(2).zip(WAVES) {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * (along * x + across * y));
        (pair[0], pair[1]) = (sin, cos);
    }
    all
}

/// Tables, node by node and row by row of phases; `None` where the errors say nothing.
pub fn tables(misses: &[Miss], nodes: &Nodes) -> Option<Vec<Vec<[f64; 2]>>> {
    let size = nodes.count[0] * nodes.count[1] * TERMS;
    let mut matrix = DMatrix::from_diagonal_element(size, size, ORDINARY_PX.powi(-2));
    let mut right = [DVector::zeros(size), DVector::zeros(size)];
    for miss in misses {
        let (weight, terms) = (miss.sigma_px.powi(-2), terms(miss.at_px));
        let entries: Vec<(usize, f64)> = nodes
            .about(miss.at_px)
            .into_iter()
            .flat_map(|(node, share)| {
                terms.iter().enumerate().map(move |(k, term)| (node * TERMS + k, share * term))
            })
            .collect();
        for (i, a) in &entries {
            for (axis, right) in right.iter_mut().enumerate() {
                right[*i] += weight * a * miss.correction_px[axis];
            }
            for (j, b) in &entries {
                matrix[(*i, *j)] += weight * a * b;
            }
        }
    }
    let factors = matrix.cholesky()?;
    let found = right.map(|right| factors.solve(&right));
    let step = 1.0 / PHASES as f64;
    let phases =
        || (0..PHASES).flat_map(|y| (0..PHASES).map(move |x| terms([x as f64 * step, y as f64 * step])));
    let table = |node: usize| {
        let value = |terms: &[f64; TERMS], axis: usize| {
            terms.iter().enumerate().map(|(k, term)| term * found[axis][node * TERMS + k]).sum::<f64>()
        };
        phases().map(|terms| [value(&terms, 0), value(&terms, 1)]).collect()
    };
    Some((0..nodes.count[0] * nodes.count[1]).map(table).collect())
}
