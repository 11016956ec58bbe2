//! A fix as an observation (thesis tab. 5.1): position, or its direction alone (eq. 5.25-5.27).
//!
//! In: a [`PositionFix`], the predicted state, the rotation from the Earth path to ICRS; out: rows of unit
//! variance.
//!
//! Differences are taken along three axes, up and two across it: of distance along the first, of direction
//! times the predicted distance along the others, so that a fix far off is not below the tangent; beyond a
//! right angle what lies across grows no more, and is the distance itself. The
//! covariance of a fix is elongated along the line to the Earth and grows with the distance. It is
//! therefore taken along its own three axes, and brought to the predicted distance: by the ratio across the
//! line, by its square along it.
//!
//! A limb higher by `h` makes the distance shorter by the share `h / a` (`a`: the equatorial radius). The
//! misalignment of the paths, a rotation vector in the Earth path, turns the fix about the Earth. Errors that
//! fixes share for `2 L / w` ([`super::horizon`]) have their covariance multiplied by the number of fixes in
//! that time: white noise of the same spectral density.
//!
//! Direction and distance are no straight functions of the position. What their bend may come to, the
//! variance of the position over twice its length, is noise of its own (Gaussian filter of the second order,
//! Jazwinski 1970, §9.7): without it a guess wrong by Earth radii would be believed to be known before it is.

use super::OrbitState;
use super::body::CentralBody;
use super::dynamics::plausible;
use super::factor::{HEIGHT, MISALIGNMENT, POSITION, Row, STATES};
use super::point::PositionFix;
use fsw_ground::matrix::{
    Cholesky, add_scaled, add_to_diagonal, cross_matrix, dot, plus_scaled, product, scaled, symmetric_product,
};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// An element of a rotation is at most 1; 10 % for rounding.
const GREATEST_ELEMENT: f64 = 1.1;

/// Why a fix is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FixError {
    /// A value is not finite, or the position is none of a satellite of the body.
    Impossible,
    /// Its covariance is not positive definite.
    Covariance,
}

/// Whether a fix is finite, possible and has a covariance.
pub(super) fn check(
    body: CentralBody,
    fix: &PositionFix,
    earth_to_icrs: &Matrix3<f64>,
) -> Result<(), FixError> {
    let at_rest = Vector3::zeros();
    if !plausible(body, &fix.position_km, &at_rest)
        || !plausible(body, &fix.linearisation_km, &at_rest)
        // NaN is refused too.
        || !earth_to_icrs.iter().all(|x| libm::fabs(*x) < GREATEST_ELEMENT)
    {
        return Err(FixError::Impossible);
    }
    if is_covariance(&fix.covariance_km2) && fix.shared_km2.iter().all(|x| libm::fabs(*x) < GREATEST_VARIANCE)
    {
        Ok(())
    } else {
        Err(FixError::Covariance)
    }
}

/// Largest valid variance: products of it stay finite.
const GREATEST_VARIANCE: f64 = 1e30;

/// Whether a covariance is positive definite. Its factor reads one half of it only; in the other no element
/// may be greater than the trace, as none of a covariance is.
pub fn is_covariance(m: &Matrix3<f64>) -> bool {
    let trace = m.trace();
    trace < GREATEST_VARIANCE && m.iter().all(|x| libm::fabs(*x) <= trace) && Cholesky::of(m).is_some()
}

/// Up at a position and two axes across it, as rows; `across` fixes how these stand about it.
fn axes_at(position_km: &Vector3<f64>, across: &Vector3<f64>) -> Option<Matrix3<f64>> {
    let up = scaled(position_km, 1.0 / libm::sqrt(dot(position_km, position_km)));
    let first = plus_scaled(across, -dot(across, &up), &up);
    let square = dot(&first, &first);
    if square.is_nan() || square <= 1e-12 {
        return None;
    }
    let first = scaled(&first, 1.0 / libm::sqrt(square));
    let second = product(&cross_matrix(&up), &first);
    Some(Matrix3::from([up.into(), first.into(), second.into()]).transpose())
}

/// Three rows of a fix, of unit variance, and its innovations in them. `unit`: of its direction alone; the
/// first row is then empty. `sharing`: number of fixes that share their slow errors; `bend_km`: sigma of what
/// is not straight, the state's position being uncertain. `None` where the
/// covariance is none, or position and velocity of the state are in line.
#[inline(never)]
pub(super) fn rows_of(
    body: CentralBody,
    fix: &PositionFix,
    state: &OrbitState,
    earth_to_icrs: &Matrix3<f64>,
    (unit, sharing, bend_km): (bool, f64, f64),
) -> Option<[(Row, f32); 3]> {
    let predicted = &state.position_km;
    let distance = libm::sqrt(dot(predicted, predicted));
    let fixed = libm::sqrt(dot(&fix.position_km, &fix.position_km));
    let axes = axes_at(predicted, &state.velocity_km_s)?;
    let own_axes = axes_at(&fix.linearisation_km, &state.velocity_km_s)?;
    let ratio = distance / libm::sqrt(dot(&fix.linearisation_km, &fix.linearisation_km));
    let stretch = Matrix3::from_diagonal(&Vector3::new(ratio * ratio, ratio, ratio));
    let mut covariance = fix.covariance_km2;
    add_scaled(&mut covariance, sharing, &fix.shared_km2);
    let mut covariance = symmetric_product(&product(&stretch, &own_axes), &covariance);
    add_to_diagonal(&mut covariance, bend_km * bend_km);
    let mut innovation = product(&axes, &scaled(&fix.position_km, distance / fixed));
    let [[up, first, second]] = &mut innovation.data.0;
    if *up <= 0.0 {
        // The other way about it is as far off as can be, not as near: no direction differs by more.
        let across = libm::sqrt(*first * *first + *second * *second);
        (*first, *second) = match across > 1e-9 * distance {
            true => (*first * distance / across, *second * distance / across),
            false => (distance, 0.0),
        };
    }
    *up = fixed - distance;
    // Columns: position, the height of the limb, the misalignment.
    let mut columns = SMatrix::<f64, 3, 7>::zeros();
    let turned = product(&axes, &product(&cross_matrix(predicted), earth_to_icrs));
    let height = [-distance / body.facts().radius_km, 0.0, 0.0];
    let parts = axes.data.0.into_iter().chain([height]).chain(turned.data.0);
    for (column, part) in columns.data.0.iter_mut().zip(parts) {
        *column = part;
    }
    if unit {
        // The distance has no part in it.
        if let Some(first) = innovation.get_mut(0) {
            *first = 0.0;
        }
        for column in &mut columns.data.0 {
            let [first, ..] = column;
            *first = 0.0;
        }
        for (i, column) in covariance.data.0.iter_mut().enumerate() {
            for (j, element) in column.iter_mut().enumerate() {
                *element = match (i, j) {
                    (0, 0) => 1.0,
                    (0, _) | (_, 0) => 0.0,
                    _ => *element,
                };
            }
        }
    }
    let factor = Cholesky::of(&covariance)?;
    let (columns, innovation) = (factor.whitened(&columns), factor.whitened(&innovation));
    let mut rows = [([0.0; STATES], 0.0); 3];
    let places = (POSITION..POSITION + 3).chain([HEIGHT]).chain(MISALIGNMENT..STATES);
    for (column, place) in columns.data.0.iter().zip(places) {
        for ((row, _), element) in rows.iter_mut().zip(column) {
            if let Some(sensitivity) = row.get_mut(place) {
                *sensitivity = *element as f32;
            }
        }
    }
    for ((_, value), innovation) in rows.iter_mut().zip(innovation.iter()) {
        *value = *innovation as f32;
    }
    Some(rows)
}
