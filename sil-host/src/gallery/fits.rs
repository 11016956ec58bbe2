//! Fits of circles and ellipses that do not fly, for comparison with the circularised circle (thesis §3.2.2,
//! eq. 3.33 to 3.38).
//!
//! In: points, px. Out: the centre, px; `None` where there is none.
//!
//! - Geometric circle (eq. 3.36): least squares of the distances from the circle, by Gauss-Newton steps.
//! - Direct ellipse: the conic of least algebraic error among ellipses, by Halir and Flusser (*Numerically
//!   stable direct least squares fitting of ellipses*, WSCG 1998).
//! - Geometric ellipse: least squares of the distances from the ellipse to their first order (Sampson), all five
//!   parameters free, by Gauss-Newton steps from a circle.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Steps of the geometric fits, and the change of the parameters at which they end, px.
const STEPS: usize = 60;
const SETTLED_PX: f64 = 1e-6;
/// Step of the difference that gives a derivative, px.
const DIFFERENCE_PX: f64 = 1e-4;

/// Least squares of residuals by Gauss-Newton steps with numerical derivatives; `None` where it does not
/// settle.
fn settled(
    mut parameters: DVector<f64>,
    residuals: impl Fn(&DVector<f64>) -> DVector<f64>,
) -> Option<DVector<f64>> {
    for _ in 0..STEPS {
        let here = residuals(&parameters);
        let columns: Vec<DVector<f64>> = (0..parameters.len())
            .map(|index| {
                let mut there = parameters.clone();
                there[index] += DIFFERENCE_PX;
                (residuals(&there) - &here) / DIFFERENCE_PX
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let normal = jacobian.tr_mul(&jacobian);
        let step = normal.cholesky()?.solve(&jacobian.tr_mul(&here));
        parameters -= &step;
        if !parameters.iter().all(|value| value.abs() < 1e6) {
            return None;
        }
        if step.amax() < SETTLED_PX {
            return Some(parameters);
        }
    }
    None
}

/// Centre of the geometric circle, from a first guess of centre and radius.
pub fn geometric_circle(points: &[[f64; 2]], centre: [f64; 2], radius: f64) -> Option<[f64; 2]> {
    let start = DVector::from_vec(vec![centre[0], centre[1], radius]);
    let found = settled(start, |p| {
        DVector::from_iterator(
            points.len(),
            points.iter().map(|[x, y]| libm::hypot(x - p[0], y - p[1]) - p[2]),
        )
    })?;
    Some([found[0], found[1]])
}

/// Centre of the geometric ellipse, from a first guess: a circle.
pub fn geometric_ellipse(points: &[[f64; 2]], centre: [f64; 2], radius: f64) -> Option<[f64; 2]> {
    // Half axes `r ± s` along a direction that `s`, a vector, has.
    let start = DVector::from_vec(vec![centre[0], centre[1], radius, 0.01, 0.01]);
    let found = settled(start, |p| {
        let squeezed = libm::hypot(p[3], p[4]);
        let half = [p[2] + squeezed, p[2] - squeezed];
        let turn = 0.5 * libm::atan2(p[4], p[3]);
        let (sine, cosine) = libm::sincos(turn);
        let distance = |[x, y]: &[f64; 2]| {
            let (dx, dy) = (x - p[0], y - p[1]);
            let (u, v) = ((cosine * dx + sine * dy) / half[0], (cosine * dy - sine * dx) / half[1]);
            let slope = 2.0 * libm::hypot(u / half[0], v / half[1]);
            (u * u + v * v - 1.0) / slope
        };
        DVector::from_iterator(points.len(), points.iter().map(distance))
    })?;
    let squeezed = libm::hypot(found[3], found[4]);
    (found[2] > squeezed).then_some([found[0], found[1]])
}

/// Centre of the direct ellipse.
pub fn direct_ellipse(points: &[[f64; 2]], centre: [f64; 2], radius: f64) -> Option<[f64; 2]> {
    let (mut quadratic, mut mixed, mut linear) = (Matrix3::zeros(), Matrix3::zeros(), Matrix3::zeros());
    for [x, y] in points {
        // In radii about the guess, so that all columns are of one size.
        let (x, y) = ((x - centre[0]) / radius, (y - centre[1]) / radius);
        let (two, one) = (Vector3::new(x * x, x * y, y * y), Vector3::new(x, y, 1.0));
        quadratic += two * two.transpose();
        mixed += two * one.transpose();
        linear += one * one.transpose();
    }
    let reduce = -linear.try_inverse()? * mixed.transpose();
    let reduced: Matrix3<f64> = quadratic + mixed * reduce;
    // The inverse of the constraint 4 a c - b² = 1 times it.
    let system = Matrix3::from_rows(&[reduced.row(2) * 0.5, -reduced.row(1), reduced.row(0) * 0.5]);
    let values = system.complex_eigenvalues();
    let real =
        values.iter().filter(|value| value.im.abs() < 1e-9 * value.re.abs().max(1e-9)).map(|value| value.re);
    let ellipse = |value: f64| -> Option<Vector3<f64>> {
        // The vector of a value: the last right singular vector of what it makes singular.
        let singular = (system - Matrix3::identity() * value).svd(false, true);
        let least = singular.singular_values.imin();
        let vector = singular.v_t?.row(least).transpose();
        (4.0 * vector[0] * vector[2] - vector[1] * vector[1] > 0.0).then_some(vector)
    };
    let two = real.into_iter().find_map(ellipse)?;
    let one = reduce * two;
    let determinant = 4.0 * two[0] * two[2] - two[1] * two[1];
    let x = (two[1] * one[1] - 2.0 * two[2] * one[0]) / determinant;
    let y = (two[1] * one[0] - 2.0 * two[0] * one[1]) / determinant;
    Some([centre[0] + radius * x, centre[1] + radius * y])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ellipse(count: usize, arc_rad: f64) -> Vec<[f64; 2]> {
        let (sine, cosine) = libm::sincos(0.4);
        let point = |index: usize| {
            let (s, c) = libm::sincos(arc_rad * (index as f64 / count as f64 - 0.5));
            let (u, v) = (460.0 * c, 452.0 * s);
            [640.0 + cosine * u - sine * v, 512.0 + sine * u + cosine * v]
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn ellipses_without_noise_are_found_from_a_third_of_them() {
        for arc_rad in [2.0, 4.0, std::f64::consts::TAU] {
            for fit in [direct_ellipse, geometric_ellipse] {
                let [x, y] = fit(&ellipse(90, arc_rad), [630.0, 520.0], 440.0).unwrap();
                assert!((x - 640.0).abs() < 1e-3 && (y - 512.0).abs() < 1e-3, "{arc_rad}: {x} {y}");
            }
        }
    }

    #[test]
    fn a_circle_is_pulled_towards_the_points_of_half_an_ellipse() {
        // A radius of b + (a - b) cos² over half a turn: to the first order its part along the cosine beside a
        // constant is 1.12 (a - b), here 8.96 px along the long axis.
        let [x, _] = geometric_circle(&ellipse(90, std::f64::consts::PI), [630.0, 520.0], 440.0).unwrap();
        assert!((x - 640.0 - 8.96 * libm::cos(0.4)).abs() < 0.2, "{x}");
    }
}
