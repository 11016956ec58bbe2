//! Fields that are the gradient of spherical harmonics: gravity, magnetism.
//!
//! In: coefficients, position in axes that turn with the body, km; degree and order. Out: the gradient along
//! the same axes. Pines' formulation (*AIAA Journal* 11, 1973, 1508-1511), which has no singular point: with
//! `s, t, u` the direction's components, `A(n, m)` the derivatives of the Legendre polynomials of `u`, and
//! `c(m) + i s(m) = (s + i t)^m`, the potential is `k/r Σ (R/r)^n A(n, m) (C c(m) + S s(m))`. One column
//! of `A` (one order) is made from the next lower degrees and used with the column of the next order, so
//! that two columns are all that is held. In f32, rounding 1e-6 of the sum.

use nalgebra::Vector3;

/// Highest degree and order.
pub const MAX_DEGREE: u8 = 8;
/// The same as an index.
const MOST: usize = MAX_DEGREE as usize;
/// Of each order, degrees up to one more than the field's.
type Column = [f32; MOST + 2];

/// A potential.
pub(super) struct Harmonics {
    /// Radius of the model, km.
    pub(super) radius_km: f32,
    /// Lowest degree in the table.
    pub(super) first: usize,
    /// C and S order by order, of each the degrees from the lowest or the order to [`MAX_DEGREE`], not
    /// normalised.
    pub(super) coefficients: &'static [[f32; 2]],
}

/// Derivatives of order `order` of the Legendre polynomials at `sine`; the first, `sectorial`, is
/// `(2 m - 1)!!`.
fn column(order: usize, sectorial: f32, sine: f32) -> Column {
    let mut column = [0.0; MOST + 2];
    let (mut last, mut before) = (sectorial, 0.0);
    for (degree, place) in column.iter_mut().enumerate().skip(order) {
        if degree > order {
            let (n, m) = (degree as f32, order as f32);
            (last, before) = (((2.0 * n - 1.0) * sine * last - (n + m - 1.0) * before) / (n - m), last);
        }
        *place = last;
    }
    column
}

fn at(column: &Column, degree: usize) -> f32 {
    column.get(degree).copied().unwrap_or(0.0)
}

impl Harmonics {
    /// Gradient at `r`, km, by the terms up to `degree` and `order`, times `scale`, the potential's `k`.
    #[inline(never)]
    fn gradient(&self, scale: f32, r: &Vector3<f32>, degree: u8, order: u8) -> Vector3<f32> {
        let inverse = 1.0 / libm::sqrtf(r.dot(r));
        let [s, t, u] = [r.x * inverse, r.y * inverse, r.z * inverse];
        let mut powers = [0.0; MOST + 2];
        let mut power = scale * inverse * inverse;
        for place in &mut powers {
            *place = power;
            power *= self.radius_km * inverse;
        }
        let mut coefficients = self.coefficients.iter();
        let (mut this, mut sectorial) = (column(0, 1.0, u), 1.0);
        // Cosine and sine of the order's multiple of the longitude, times a power of the latitude's cosine;
        // and those of the order before.
        let ([mut cosine, mut sine], [mut cosine_before, mut sine_before]) = ([1.0, 0.0], [0.0, 0.0]);
        let (mut sum, mut radial) = (Vector3::zeros(), 0.0);
        for m in 0..=MOST {
            sectorial *= (2 * m + 1) as f32;
            let next = column(m + 1, sectorial, u);
            for (n, [c, s]) in (m.max(self.first)..=MOST).zip(&mut coefficients) {
                if n > usize::from(degree) || m > usize::from(order) {
                    continue;
                }
                let power = at(&powers, n);
                let here = c * cosine + s * sine;
                let across = power * m as f32 * at(&this, n);
                sum.x += across * (c * cosine_before + s * sine_before);
                sum.y += across * (s * cosine_before - c * sine_before);
                sum.z += power * at(&next, n) * here;
                radial -= power * at(&next, n + 1) * here;
            }
            [cosine_before, sine_before] = [cosine, sine];
            [cosine, sine] = [s * cosine - t * sine, s * sine + t * cosine];
            this = next;
        }
        sum + Vector3::new(s, t, u) * radial
    }

    /// The same along axes of the equator against which the body has turned by an angle, given by its sine
    /// and cosine.
    pub(super) fn turned_gradient(
        &self,
        scale: f32,
        (r, [sine, cosine]): (&Vector3<f32>, [f32; 2]),
        degree: u8,
        order: u8,
    ) -> Vector3<f32> {
        let fixed = Vector3::new(cosine * r.x + sine * r.y, cosine * r.y - sine * r.x, r.z);
        let along = self.gradient(scale, &fixed, degree, order);
        Vector3::new(cosine * along.x - sine * along.y, sine * along.x + cosine * along.y, along.z)
    }
}
